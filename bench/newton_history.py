#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Newton's method: residual per iteration over all load steps of several scenes, changes of the contact states marked, and the order of convergence
where the states are settled.

Usage: bench/newton_history.py [--draw]; writes bench/results/newton_history.json and docs/figures/newton_{history,order}.png; with --draw the figures
alone, from the record.
"""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

from common import ROOT, program, read_record, write_record

EXE = program("hdengine.x")


KEYS = ["mesh.divisions=80", "load.assembly_steps=4", "load.torque_steps=4", "solver.tolerance=1e-10", "output.vtu=none"]
FREE = ["load.support=bearing"]
SCENES = {"HUB": [], "FREE": FREE, "INT": [*FREE, "wave_generator.interference=10e-6"], "HUB, 64 on 80 divisions": ["mesh.ring_divisions=64"],
          "HUB, e = 20 µm": ["wave_generator.eccentricity=20e-6"], "HUB, rough joint": ["contact.law=joint"],
          "HUB, large rotations": ["solver.kinematics=nonlinear", "solver.tolerance=1e-9"],
          "FREE to 9 N m (slips at 9.3)": [*FREE, "load.torque=9"]}
FLOOR, FLOOR_OF_ROTATIONS = 1e-11, 5e-11  # rounding of the residual


def solve(keys, method):
    """Rows (step, iteration, residual, changes, torque) of a run."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        done = subprocess.run([EXE, ROOT / "data/peer_hub.nml", *KEYS, f"solver.method={method}", *keys, "--out", out, "-q"], capture_output=True, text=True)
        if done.returncode:
            print(done.stderr, file=sys.stderr)
        with (out / "history.csv").open() as f:
            return [[int(r["step"]), int(r["iteration"]), float(r["residual"]), int(r["change"]), float(r["torque_nm"])] for r in csv.DictReader(f)]


def follows(a, b):
    """B is the next iterate of the same equations; where pairs are made anew the count stands still."""
    return a[0] == b[0] and b[1] == a[1] + 1


def orders(rows, floor):
    """log(r2/r1) / log(r1/r0) of successive iterates with settled states, where r1 shows the asymptote and r2 is not rounding."""
    found = []
    for a, b, c in zip(rows, rows[1:], rows[2:]):
        if follows(a, b) and follows(b, c) and b[3] == c[3] == 0 and b[1] > 0 and b[2] < 1e-2 and b[2] < 0.3 * a[2] and c[2] > floor:
            found.append(float(np.log(c[2] / b[2]) / np.log(b[2] / a[2])))
    return found


def constants(rows, floor):
    """r1 / r0^2 of the same pairs."""
    return [b[2] / a[2] ** 2 for a, b in zip(rows, rows[1:]) if follows(a, b) and a[3] == b[3] == 0 and a[2] < 1e-3 and b[2] > floor]


def draw(ax, rows, name):
    """Residual over iterations; a line per load step, filled where states changed."""
    last = 0
    for step in sorted({r[0] for r in rows}):
        mine = [r for r in rows if r[0] == step]
        x, y = last + np.arange(len(mine)), np.array([r[2] for r in mine])
        change = np.array([r[3] > 0 for r in mine])
        color = "C0" if mine[-1][4] == 0 else "C1"
        ax.semilogy(x, y, "-", color=color, lw=1)
        ax.semilogy(x[change], y[change], "o", color=color, ms=4)
        ax.semilogy(x[~change], y[~change], "o", color=color, mfc="white", ms=4)
        last += len(mine)
    ax.set(title=name, ylim=(1e-13, 3))
    ax.grid(alpha=0.3)


def measure():
    """History, orders and iterations of every scene."""
    record = {}
    for name, keys in SCENES.items():
        rows = solve(keys, "newton")
        large = "rotations" in name
        found, rate = (f(rows, FLOOR_OF_ROTATIONS if large else FLOOR) for f in (orders, constants))
        condensed = "" if large else solve(keys, "condensed")
        record[name] = {"history": rows, "orders": found, "largest_factor": max(rate, default=None), "most_in_a_step": max(r[1] for r in rows),
                        "iterations": sum(max(r[1] for r in rows if r[0] == step) for step in {r[0] for r in rows}),
                        "iterations_condensed": len(condensed) - len({r[0] for r in condensed}) if condensed else None}
        print(f"{name}: {record[name]['iterations']} iterations, median order {np.median(found) if found else np.nan:.2f}", flush=True)
    write_record("newton_history", record)


def draw_histories(record):
    """A panel for each scene."""
    fig, axes = plt.subplots(4, 2, figsize=(9, 13), layout="constrained")
    for ax, (name, scene) in zip(axes.flat, record.items()):
        draw(ax, scene["history"], name)
    for ax in axes[:, 0]:
        ax.set_ylabel("relative residual")
    for ax in axes[-1]:
        ax.set_xlabel("iteration, steps one after the other")
    for color, part in (("C0", "assembly"), ("C1", "torque")):
        axes[0, 0].plot([], [], "o", color=color, label=f"{part}, states changed")
        axes[0, 0].plot([], [], "o", color=color, mfc="white", label=f"{part}, settled")
    fig.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    fig.savefig(ROOT / "docs/figures/newton_history.png", dpi=90)


def draw_orders(record):
    """Each residual over the one in front of it, and the orders that follow."""
    fig, (left, right) = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    pairs = [(a[2], b[2]) for scene in record.values() for rows in [scene["history"]] for a, b in zip(rows, rows[1:])
             if follows(a, b) and a[3] == b[3] == 0 and a[2] < 1e-2]
    left.loglog(*np.array(pairs).T, "o", ms=4, alpha=0.6)
    line = np.array([2e-8, 1e-2])
    left.loglog(line, 1e4 * line**2, "k-", lw=1, label="10⁴ r²")
    left.loglog(line, line, "k--", lw=1, label="r (no gain)")
    left.axhline(FLOOR, color="0.6", ls=":", label="rounding")
    left.set(xlabel="residual r of an iterate with settled states", ylabel="residual of the next")
    left.legend()
    left.grid(alpha=0.3)
    right.hist(np.concatenate([r["orders"] for r in record.values()]), bins=np.arange(0, 3.6, 0.2))
    right.set(xlabel="order log(r₂/r₁) / log(r₁/r₀)", ylabel="iterates")
    fig.savefig(ROOT / "docs/figures/newton_order.png", dpi=90)


def main():
    """Command line; --draw only draws the record."""
    if sys.argv[1:] != ["--draw"]:
        measure()
    record = read_record("newton_history")
    draw_histories(record)
    draw_orders(record)


if __name__ == "__main__":
    main()
