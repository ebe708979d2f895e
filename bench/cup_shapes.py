# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of the cup beside each other in the whole drive of size 14: table of docs/evidence/drive_inputs.md, figure of their meridians.

Usage: python bench/cup_shapes.py
"""
import tempfile
from pathlib import Path

import meshio
import numpy as np
from matplotlib.collections import PolyCollection

from common import new_axes, put, save_figure, solve, styled, table, write_record

RISE = {"mesh.divisions": 48, "mesh.band_facets": 8, "loop.torques": 14, "load.torque_steps": 7, "output.vtu": "last"}
BORE, HUB = 17.5e-3, 8e-3


def sections(*rows):
    """Keys of a cup from (r, z, thickness, fillet) [m]."""
    names = ("r", "z", "thickness", "fillet")
    return {f"cup.sections_{name}": ",".join(f"{v:.6g}" for v in column) for name, column in zip(names, zip(*rows))}


def cup(end, *, hub=HUB, taper=0.36e-3, fillet=0.0, bottom=0.5e-3):
    """Rim as in drive14.nml, wall from `taper` behind the rim to 0.36 mm, bottom or flange."""
    return sections((BORE, 0, 0.427e-3, 0), (BORE, 9e-3, 0.427e-3, 0), (BORE, 10e-3, taper, 0), (BORE, end, 0.36e-3, fillet),
                    (BORE, end, bottom, fillet), (hub, end, bottom, 0))


SHAPES = (
    ("simple cup", cup(19.5e-3)), ("fillet of 1.5 mm", cup(19.5e-3, fillet=1.5e-3)),
    ("fillet, wall tapered from 0.427 mm", cup(19.5e-3, fillet=1.5e-3, taper=0.427e-3)),
    ("silk hat, flange to 27 mm", cup(20e-3, hub=27e-3, fillet=1.5e-3)),
    ("silk hat, flange to 23 mm", cup(20e-3, hub=23e-3, fillet=1.5e-3)))
DRAWN = ("simple cup", "fillet, wall tapered from 0.427 mm", "silk hat, flange to 27 mm")


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
def draw(meridians):
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
    """Solve, write, draw."""
    rows, meridians = [], {}
    for name, keys in SHAPES:
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder) / "scene.nml"
            text = (Path(__file__).parents[1] / "data/drive14_hat.nml").read_text()
            scene.write_text(text[:text.index("&cup")] + text[text.index("&mesh"):])
            summary, done = solve(scene, *(f"{k}={v}" for k, v in {**RISE, **keys}.items()), out=Path(folder) / "run.out")
            if done.code != 0:
                raise SystemExit(done.text)
            r = summary["results"]
            rows.append({"shape": name, "k": [r[f"k{i}_nm_per_rad"] for i in (1, 2, 3)], "von_mises_cup_pa": r["von_mises_max_pa"]})
            if name in DRAWN:
                meridians[name] = meridian(Path(folder) / "run.out")
    write_record("cup_shapes", rows, threads=1)
    base = rows[0]["k"]
    put("drive shapes", table(("shape, size 14", "K1 / K2 / K3 in kN m/rad", "change in %"), [
        (r["shape"], " / ".join(f"{k / 1e3:.3g}" for k in r["k"]), " / ".join(f"{100 * (k / b - 1):+.0f}" for k, b in zip(r["k"], base)))
        for r in rows]), page="evidence/drive_inputs")
    draw(meridians)


if __name__ == "__main__":
    main()
