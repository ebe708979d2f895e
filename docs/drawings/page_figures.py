#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the pages that the package draws by itself: joint of the paper, two specimens, a record, tooth gaps, shapes of the cup.

Usage: docs/drawings/page_figures.py
"""
import sys
import tempfile
from pathlib import Path

import meshio
import numpy as np
from matplotlib.collections import PolyCollection

import hdengine
from hdengine import Joint, roughness, specimen
from hdengine.figures.joint import plot_joint
from hdengine.record import Record

sys.path.append(str(Path(__file__).resolve().parents[2] / "bench"))
from common import DATA, new_axes, save_figure, styled  # noqa: E402

BORE, HUB = 17.5e-3, 8e-3


def sections(*rows):
    """Keys of a cup from (r, z, thickness, fillet) [m]."""
    names = ("r", "z", "thickness", "fillet")
    return {f"cup.sections_{name}": ",".join(f"{v:.6g}" for v in column) for name, column in zip(names, zip(*rows))}


def cup(end, *, taper=0.36e-3, fillet=0.0, bottom=0.5e-3):
    """Rim as in drive14.nml, wall from `taper` behind the rim to 0.36 mm, bottom."""
    return sections((BORE, 0, 0.427e-3, 0), (BORE, 9e-3, 0.427e-3, 0), (BORE, 10e-3, taper, 0), (BORE, end, 0.36e-3, fillet),
                    (BORE, end, bottom, fillet), (HUB, end, bottom, 0))


SHAPES = {"simple cup": cup(19.5e-3), "fillet, wall tapered from 0.427 mm": cup(19.5e-3, fillet=1.5e-3, taper=0.427e-3),
          "silk hat of drive14_hat.nml": {}}


def meridian(folder):
    """Quadrilaterals of the first sector's side at theta = 0 (z, r) [mm], and their bodies."""
    mesh = meshio.read(sorted(folder.glob("bodies_*.vtu"))[-1])
    x = 1e3 * mesh.points
    at_side = (abs(x[:, 1]) < 1e-6) & (x[:, 0] > 0)
    found, body = [], []
    for cell, b in zip(mesh.cells[0].data, np.ravel(mesh.cell_data["body"][0])):
        side = [n for n in cell[[0, 1, 5, 4]] if at_side[n]]
        if len(side) == 4:
            found.append([(x[n, 2], x[n, 0]) for n in side])
            body.append(int(b))
    return found, body


@styled
def shapes(meridians):
    """The meshes of the meridians."""
    figure, axes = new_axes(1, len(meridians), figsize=(11, 3.9))
    for axis, (name, (cells, body)) in zip(axes, meridians.items()):
        axis.add_collection(PolyCollection(cells, facecolors=[{1: "#e8b96a"}.get(b, "#9db4c8") for b in body], edgecolors="#222222",
                                           linewidths=0.5))
        axis.set(xlim=(-1, 22), ylim=(6, 29), aspect="equal", xlabel="from the opening / mm")
        axis.set_title(name, fontsize=11)
    axes[0].set_ylabel("from the axis / mm")
    save_figure(figure, "cup_shapes")


def main():
    """Draw all."""
    save_figure(plot_joint(Joint(asperity_radius=250e-6, s_min=1e-15), np.logspace(-3, 3.2, 200) * 1e6).figure, "joint_stiffness")
    parts = [specimen.read(DATA / f"specimen_{name}.sdf") for name in ("flexspline", "bearing")]
    waves = roughness.Ridges(length=0.5e-3, shortest_wavelength=1e-6, ridges=10, gamma=1.5)
    save_figure(specimen.equivalent(*parts, surface=waves).plot(), "joint_surface", dpi=80)
    save_figure(Record.read(DATA / "torque_record.csv").plot(), "record")
    save_figure(hdengine.tooth_gaps(hdengine.Involute(0.1778e-3), DATA / "drive14.nml").plot(), "tooth_gaps")
    with tempfile.TemporaryDirectory() as folder:
        meridians = {}
        for name, keys in SHAPES.items():
            hdengine.run(DATA / "drive14_hat.nml", f"{folder}/shape", True, **keys, **{
                "loop.torques": 1, "load.torque_steps": 1, "mesh.divisions": 48, "mesh.band_facets": 8, "output.vtu": "last"})
            meridians[name] = meridian(Path(folder) / "shape")
        shapes(meridians)


if __name__ == "__main__":
    main()
