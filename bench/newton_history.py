#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Newton's method: residual per iteration over all load steps of several scenes, changes of the contact states marked, and the order of convergence
where the states are settled.

Usage: bench/newton_history.py; writes bench/results/newton_history.json and docs/figures/newton_history.png, prints Markdown.
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

from common import ROOT, program, write_record

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


def main():
    record = {}
    fig, axes = plt.subplots(2, 5, figsize=(17, 7), layout="constrained", width_ratios=[1, 1, 1, 1, 1.1])
    panels, pairs = [*axes[:, :4].flat], []
    print("| scene | Newton iterations | load steps | most in a step | order, median (of) | largest r₁/r₀² | condensed: iterations |\n|" + "---|" * 7)
    for ax, (name, keys) in zip(panels, SCENES.items()):
        rows = solve(keys, "newton")
        draw(ax, rows, name)
        count = sum(max(r[1] for r in rows if r[0] == step) for step in {r[0] for r in rows})
        most = max(r[1] for r in rows)
        large = "rotations" in name
        found, rate = (f(rows, FLOOR_OF_ROTATIONS if large else FLOOR) for f in (orders, constants))
        condensed = "" if large else solve(keys, "condensed")
        record[name] = {"history": rows, "orders": found, "largest_factor": max(rate, default=None), "most_in_a_step": most,
                        "iterations": count,
                        "iterations_condensed": len(condensed) - len({r[0] for r in condensed}) if condensed else None}
        pairs += [(a[2], b[2]) for a, b in zip(rows, rows[1:]) if follows(a, b) and a[3] == b[3] == 0 and a[2] < 1e-2]
        print(f"| {name} | {count} | {max(r[0] for r in rows)} | {most} | {np.median(found) if found else np.nan:.2f} ({len(found)}) | "
              f"{max(rate, default=np.nan):.2g} | {record[name]['iterations_condensed'] or '-'} |", flush=True)
    for ax in axes[:, 0]:
        ax.set_ylabel("relative residual")
    for ax in axes[1, :4]:
        ax.set_xlabel("iteration, steps one after the other")
    axes[0, 0].plot([], [], "o", color="C0", label="assembly, states changed")
    axes[0, 0].plot([], [], "o", color="C0", mfc="white", label="assembly, settled")
    axes[0, 0].plot([], [], "o", color="C1", label="torque, states changed")
    axes[0, 0].plot([], [], "o", color="C1", mfc="white", label="torque, settled")
    fig.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower left", ncols=4)
    ax = axes[0, 4]
    x, y = np.array(pairs).T
    ax.loglog(x, y, "o", ms=4, alpha=0.6)
    line = np.array([2e-8, 1e-2])
    ax.loglog(line, 1e4 * line**2, "k-", lw=1, label="10⁴ r²")
    ax.loglog(line, line, "k--", lw=1, label="r (no gain)")
    ax.axhline(FLOOR, color="0.6", ls=":", label="rounding")
    ax.set(xlabel="residual r of an iterate with settled states", ylabel="residual of the next", title="all scenes")
    ax.legend(fontsize=8)
    ax.grid(alpha=0.3)
    ax = axes[1, 4]
    ax.hist(np.concatenate([r["orders"] for r in record.values()]), bins=np.arange(0, 3.6, 0.2))
    ax.set(xlabel="order log(r₂/r₁) / log(r₁/r₀)", ylabel="iterates", title="order of settled iterates")
    fig.savefig(ROOT / "docs/figures/newton_history.png", dpi=90)
    write_record("newton_history", record)


if __name__ == "__main__":
    main()
