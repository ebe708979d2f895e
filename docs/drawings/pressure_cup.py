#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws docs/figures/pressure_cup.png: size 14 at 5 N m, cup cut open, contact facets coloured by pressure (needs PyVista).

Cup, ring and pressure are those of data/cd14.nml; cam and balls are drawn to scale and not computed by that scene.
Run: .venv/bin/python docs/drawings/pressure_cup.py
"""
import tempfile
from pathlib import Path

import numpy as np
import pyvista

import hdengine

ROOT = Path(__file__).parents[2]
TIMES = 7               # displacements are drawn this many times
BALLS, DIAMETER = 21, 3.2   # of data/drive14.nml [mm]
TICKS = (0.3, 1, 3, 10, 30, 100)


def cam(radius, w, z):
    """Disc with the profile of the wave generator between two heights [mm]."""
    angle = np.linspace(0, 2 * np.pi, 241)[:-1]
    rho = radius + w * np.cos(2 * angle)
    points = np.c_[rho * np.cos(angle), rho * np.sin(angle), np.full(angle.size, z[0])]
    face = pyvista.PolyData(points, faces=np.r_[angle.size, np.arange(angle.size)])
    return face.extrude((0, 0, z[1] - z[0]), capping=True)


def draw(folder, path):
    """Picture of a finished run with grids."""
    bodies, face = (pyvista.read(next(Path(folder).glob(f"{name}_*.vtu"))) for name in ("bodies", "contact"))
    for part in (bodies, face):
        part.points = 1e3 * (part.points + TIMES * part["displacement_m"])
    cup, ring = (bodies.extract_cells(np.flatnonzero(bodies["body"] == i)).extract_surface(algorithm="dataset_surface") for i in (2, 1))
    face["p"] = np.where(face["pressure_pa"] > 0, face["pressure_pa"] / 1e6, np.nan)
    w, inner = TIMES * 0.2, 16.5
    plotter = pyvista.Plotter(off_screen=True, window_size=(1500, 1050))
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    plotter.add_mesh(cup.clip("-y", origin=(0, 0.01, 0)), color="#9db4c8", smooth_shading=False, ambient=0.25)
    plotter.add_mesh(ring, color="#e8d9b9", ambient=0.25)
    face.points[:, :2] *= 1 + 0.06 / np.hypot(*face.points[:, :2].T)[:, None]       # above the ring's own skin
    plotter.add_mesh(face, scalars="p", cmap="turbo", clim=(TICKS[0], TICKS[-1]), log_scale=True, nan_color="#f4f1ea", ambient=0.45,
                     diffuse=0.6, show_scalar_bar=False)
    plotter.add_mesh(cam(inner - DIAMETER - 0.2, w, (1.5, 11.5)), color="#c9c9c9", ambient=0.2)
    for angle in 2 * np.pi * np.arange(BALLS) / BALLS:
        rho = inner - DIAMETER / 2 + w * np.cos(2 * angle)
        plotter.add_mesh(pyvista.Sphere(radius=DIAMETER / 2, center=(rho * np.cos(angle), rho * np.sin(angle), 3.5)), color="#7a7a7a",
                         specular=0.6, smooth_shading=True)
    plotter.camera_position = [(22, -62, -46), (0.5, 0, 6.2), (0, 0, -1)]
    plotter.camera.zoom(1.17)
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    label(picture, path)


def label(picture, path):
    """Colour bar and names beside the picture."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure
    figure = Figure(figsize=(9, 5.6))
    FigureCanvasAgg(figure)
    axis = figure.add_axes((0, 0, 0.86, 1))
    axis.imshow(picture)
    axis.axis("off")
    bar = figure.colorbar(ScalarMappable(LogNorm(TICKS[0], TICKS[-1]), "turbo"), cax=figure.add_axes((0.875, 0.14, 0.022, 0.7)),
                          extend="both", ticks=TICKS)
    bar.ax.minorticks_off()
    bar.ax.set_yticklabels([f"{t:g}" for t in TICKS])
    bar.set_label("contact pressure / MPa", fontsize=11)
    for text, at, to in NAMES:
        axis.annotate(text, xy=to, xytext=at, fontsize=11, ha="center", va="center", arrowprops={"arrowstyle": "-", "lw": 0.9})
    figure.savefig(path, dpi=110)


NAMES = (("flexspline (cup, cut open)", (230, 60), (300, 268)), ("balls", (860, 60), (727, 240)), ("cam", (1180, 60), (900, 330)),
         ("ring of the\nflexible bearing", (1395, 250), (1292, 400)),
         ("coloured: contact with the cup\ngrey: open", (250, 1000), (420, 760)))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as work:
        out = Path(work) / "cd14.out"
        hdengine.run(ROOT / "data/cd14.nml", out)
        draw(out, ROOT / "docs/figures/pressure_cup.png")
