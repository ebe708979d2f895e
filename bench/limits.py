#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the methods of the contact solver end: one panel each, with a mark where the engine's answer sets in.

Takes some two minutes; reads bench/results of earlier scripts where they hold the figures. Writes bench/results/limits.json and
docs/figures/limits_contact.png.
"""
import csv
import subprocess
import tempfile
from pathlib import Path

import matplotlib
import matplotlib.ticker
import numpy as np

matplotlib.use("Agg")
import elements  # noqa: E402
from matplotlib import pyplot as plt  # noqa: E402

from common import ROOT, program, read_record, write_record
from hdengine import mesh as hm  # noqa: E402

EXE = program("hdengine.x")

RECORD = {}


def stored(name):
    """Results of an earlier script."""
    return read_record(name)


def run(*keys):
    """Rows of steps.csv and history.csv, exit code and message of the peer scene."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        done = subprocess.run([EXE, ROOT / "data/peer_hub.nml", *keys, "output.vtu=none", "--out", out, "-q"], capture_output=True, text=True)
        steps, history = ([{k: float(v) for k, v in row.items() if k != "phase"} for row in csv.DictReader((out / f).open())]
                          for f in ("steps.csv", "history.csv"))
    return steps, history, done.returncode, done.stderr


def error(case, element):
    """Relative error of a linear case [%]."""
    return float(100 * ((case.probe * elements.engine(case, element)[0]).sum() / case.exact - 1))


def lines(ax, name, x, curves, xlabel, ylabel, title, log="y", answer=None):
    """Curves over x, kept in the record."""
    RECORD[name] = {"x": list(map(float, x)), **{k: list(map(float, v)) for k, v in curves.items()}, "answer": answer}
    for label, y in curves.items():
        ax.plot(x, np.abs(y), "o-", ms=4, label=label)
    ax.set(xlabel=xlabel, ylabel=ylabel, title=title)
    if "x" in log:
        ax.set_xscale("log")
        ax.set_xticks(x, [f"{v:.3g}" for v in x])
        ax.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    if "y" in log:
        ax.set_yscale("log")
    ax.grid(alpha=0.3)


def mark(ax, text, x=None, y=None):
    """Line where the answer sets in."""
    if x is not None:
        ax.axvline(x, color="C3", ls="--")
    if y is not None:
        ax.axhline(y, color="C3", ls="--")
    ax.plot([], [], color="C3", ls="--", label=text)


def locking(ax):
    x = (0.2, 0.3, 0.5, 0.7, 1, 2)
    lines(ax, "locking", x, {e: [error(elements.ring_harmonic(e == "hex20r", t, 80), e) for t in x] for e in ("hex8", "hex8i", "hex20r")},
          "wall / mm", "|error| / %", "ring, 80 divisions: hex8 locks", "xy")
    mark(ax, "1 %; answer: hex8i is the default", y=1)
    ax.set_ylim(bottom=1e-4)


def divisions(ax):
    x = (40, 60, 80, 120, 160)
    lines(ax, "divisions", x, {e: [error(elements.cup(e == "hex20r", d, d // 5), e) for d in x] for e in ("hex8i", "hex20r")},
          "divisions", "|error| / %", "cup, 0.3 mm: divisions", "xy")
    mark(ax, "1 %; none: hex20r, or more divisions", y=1)
    ax.set_ylim(bottom=1e-2)


def trapezoids(ax):
    angle, curves = (0, 5, 10, 20, 30, 45), {"hex8i": [], "hex20r": []}
    for element, values in curves.items():
        for a in angle:
            m = hm.block(np.linspace(0, 6, 7), [-0.1, 0.1], [-0.05, 0.05], element == "hex20r")
            x = m.points.copy()
            x[:, 0] += np.tan(np.radians(a)) * np.interp(x[:, 0], np.arange(7), [0, 1, -1, 1, -1, 1, 0]) * m.points[:, 1]
            m = hm.Mesh(x, m.cells)
            values.append(error(elements.beam("", "", m, 1e7, 0.3, x[:, 0] < 1e-9, x[:, 0] > 6 - 1e-9, (0, 1, 0), 0.1081), element))
    lines(ax, "trapezoids", angle, curves, "slant of trapezoidal cells / degrees", "|error| / %", "straight beam: trapezoids")
    mark(ax, "revolved meshes stay at 0°; own: hex20r", x=0)


def load_steps(ax):
    rows, curves = stored("step_study"), {}
    for s in ("hub", "bearing"):
        mine = [r for r in rows if r["support"] == s]
        curves[s] = [100 * (r["results"]["rotation_rad"] / mine[-1]["results"]["rotation_rad"] - 1) for r in mine[:-1]]
    lines(ax, "load steps", [r["torque_steps"] for r in mine[:-1]], curves, "torque steps", "|rotation against 80 steps| / %", "torque steps", "xy")
    mark(ax, "default 5", x=5)


def half_width(ax):
    rows = [r for r in stored("contact_standards")["hertz_line"]["rows"] if r["element"] == "hex8i"]
    lines(ax, "half-width", [r["elements"] for r in rows], {k.replace("_", "-"): [100 * r[k] for r in rows] for k in ("half_width", "peak", "field")},
          "cells in the half-width", "|error| / %", "Hertz, line: cells", "xy")
    mark(ax, "10 cells: 1 %", x=10)


def gross_slip(ax):
    steps, _, code, text = run("mesh.divisions=40", "load.support=bearing", "load.torque=12", "load.torque_steps=24")
    mine = [s for s in steps if s["load_factor"] >= 1 or s["torque_nm"] > 0]
    lines(ax, "gross slip", [s["torque_nm"] for s in mine], {"rotation": [1e6 * s["rotation_rad"] for s in mine]}, "torque / N m", "rotation / µrad",
          "FREE: no equilibrium", "", text.split(":")[1].strip() if code else None)
    mark(ax, f'"{RECORD["gross slip"]["answer"]}", code 4', x=float(text.split("T = ")[1].split()[0]))


def kinematics(ax):
    rows = stored("kinematics_map")
    x = sorted({r["w_m"] for r in rows})
    names = ("K_TS", "normal force", "mid-band pressure")
    lines(ax, "kinematics", [1e3 * w for w in x], {n: [100 * max(abs(r["error"][i]) for r in rows if r["w_m"] == w) for w in x] for i, n in enumerate(names)},
          "w / mm", "largest |change| / %", "linear kinematics", "xy")
    mark(ax, "'auto' at tolerance 0.1: nonlinear above", y=5)


def small_slip(ax):
    small = ["mesh.divisions=24", "mesh.band_facets=4", "solver.kinematics=nonlinear", "load.torque=12", "load.torque_steps=6", "load.support=bearing"]
    for shape, name in (("pressed", "pressed: pairs follow"), ("as_formed", "formed on a cone: pairs at rest")):
        steps, *_ = run(*small, f"wave_generator.shape={shape}", f"wave_generator.cone_angle_deg={0.1 * (shape == 'as_formed')}")
        mine = [s for s in steps if s["torque_nm"] > 0]
        x, y = [s["torque_nm"] for s in mine], [s["torque_balance_nm"] / s["torque_nm"] for s in mine]
        if shape == "pressed":
            lines(ax, "small slip", x, {name: y}, "torque / N m", "|out of balance| / torque", "nonlinear, FREE")
        else:
            RECORD["small slip"] |= {"x_formed": x, name: y}
            ax.plot(x, np.abs(y), "o-", ms=4, label=name)
    ax.set(yscale="log")
    mark(ax, '1 %: "the slip is too large", code 4', y=1e-2)


def floor(ax):
    x, y = (1, 2, 4, 8), []
    for n in x:
        history = run("mesh.divisions=24", "mesh.band_facets=4", f"mesh.through_ring={n}", f"mesh.through_wall={n}", "load.torque_steps=1",
                      "solver.tolerance=1e-14", "solver.max_iterations=25", "solver.max_cuts=0", "solver.method=newton")[1]
        y.append(min(h["residual"] for h in history))
    lines(ax, "floor", x, {"least residual": y}, "cells through wall and ring", "residual", "rounding of the residual", "xy")
    mark(ax, "default tolerance", y=1e-8)


def lifting(ax):
    rows = [r for r in stored("random_scenes")["scenes"] if "wave_generator.ring_contact" in r["keys"] and r["iterations"]]
    x, y = ([f(r) for r in rows] for f in (lambda r: 1e3 * r["keys"]["geometry.ring_thickness"], lambda r: r["iterations"][0]))
    RECORD["lifting"] = {"x": x, "first step": y}
    ax.plot(x, y, "o", ms=4, label="first step")
    ax.set(xscale="log", xlabel="ring / mm", ylabel="Newton iterations", title=f"ring that lifts off: {len(rows)} random scenes", ylim=(0, 65))
    ax.grid(alpha=0.3)
    mark(ax, "60: the load step is halved", y=60)


def schur(ax):
    rows = stored("cost_over_size")["rows"]
    for method, label in (("condensed", "harmonics"), ("single", "sparse matrix, single precision"), ("exact", "sparse matrix"), ("schur", "Schur complement")):
        mine = [r for r in rows if r["method"] == method and r.get("memory_mb") and r.get("iterations")]
        RECORD[f"memory {label}"] = {"x": [r["dof"] for r in mine], "mb": [r["memory_mb"] for r in mine]}
        ax.loglog([r["dof"] for r in mine], [r["memory_mb"] for r in mine], "o-", ms=4, label=label)
    ax.set(xlabel="dof", ylabel="memory / MB", title="memory", ylim=(0.3, 5e4))
    ax.grid(alpha=0.3)
    mark(ax, "refused beyond 80 % of the machine\n(16 GiB shown): code 6", y=0.8 * 16 * 1024)


def edge(ax):
    rows = stored("mesh_study")
    lines(ax, "edge", [r["band_facets"] for r in rows], {"peak": [1e-6 * r["results"]["pressure_max_pa"] for r in rows]}, "rows of facets",
          "peak pressure / MPa", "peak at the ring's edge: 1/h", "xy")
    ax.plot([], [], " ", label="none; quote no peak")


PANELS = (locking, divisions, trapezoids, load_steps, half_width, gross_slip, kinematics, small_slip, floor, lifting, schur, edge)


def main():
    fig, axes = plt.subplots(6, 2, figsize=(10, 21), layout="constrained")
    for ax, panel in zip(axes.flat, PANELS):
        panel(ax)
        ax.legend(fontsize=10)
        print(panel.__name__, flush=True)
    fig.savefig(ROOT / "docs/figures/limits_contact.png", dpi=85)
    write_record("limits", RECORD)


if __name__ == "__main__":
    main()
