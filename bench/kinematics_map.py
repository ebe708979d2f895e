#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What small displacements cost: linear against nonlinear kinematics over w, wall and torque (scene of data/cd14.nml, coarse mesh).

Usage: bench/kinematics_map.py; writes bench/results/kinematics_map.json and docs/figures/kinematics_map.png.
"""

import sys

import numpy as np

import hdengine
from common import ROOT, read_record, write_record

W, WALL, TORQUES = (0.05e-3, 0.1e-3, 0.2e-3, 0.3e-3), (0.25e-3, 0.36e-3, 0.6e-3), (2.5, 5.0, 10.0)
NAMES = ("K_TS by Eq. 45", "normal force", "mid-band pressure")


def solve(w, wall, kinematics):
    """K_TS, normal force, mid-band pressure at every torque."""
    with hdengine.Run(ROOT / "data/cd14.nml", mesh={"divisions": 40, "band_facets": 7}, geometry={"wall_thickness": wall, "rim_thickness": 1.186 * wall},
                      wave_generator={"w": w}, load={"torque": TORQUES[-1], "assembly_steps": 2, "torque_steps": 4},
                      solver={"kinematics": kinematics}) as run:
        steps = {round(s.sums["torque_nm"], 6): s for s in run}
    return np.array([[steps[t].k_ts_nm_per_rad, steps[t].sums["normal_force_n"], steps[t].sums["pressure_mid_mean_pa"]] for t in TORQUES])


def draw(rows, path):
    """Largest change of the three quantities over w, one line per wall and torque."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(1, 3, figsize=(11, 4.6), constrained_layout=True)
    for ax, i in zip(axes, range(3)):
        for wall, color in zip(WALL, ("C0", "C1", "C2")):
            for torque, style in zip(TORQUES, (":", "--", "-")):
                mine = [r for r in rows if r["wall_m"] == wall and r["torque_nm"] == torque]
                ax.plot([1e3 * r["w_m"] for r in mine], [100 * r["error"][i] for r in mine], "o" + style, color=color, ms=4,
                        label=f"wall {1e3 * wall:.2f} mm, {torque:g} N m")
        ax.set(xlabel="w / mm", title=NAMES[i])
        ax.grid(alpha=0.3)
    axes[0].set_ylabel("small displacements against large / %")
    fig.legend(*axes[2].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    fig.savefig(path, dpi=110)


def main():
    """Command line; --redraw makes the figure from the record."""
    if sys.argv[1:] == ["--redraw"]:
        draw(read_record("kinematics_map"), ROOT / "docs/figures/kinematics_map.png")
        return
    rows = []
    for wall in WALL:
        for w in W:
            try:
                small, large = solve(w, wall, "linear"), solve(w, wall, "nonlinear")
            except hdengine.HdengineError as e:
                print(w, wall, str(e)[:80], flush=True)
                continue
            for torque, a, b in zip(TORQUES, small, large):
                rows.append({"w_m": w, "wall_m": wall, "torque_nm": torque, "error": list(a / b - 1)})
            print(f"w {1e3 * w:.2f} mm, wall {1e3 * wall:.2f} mm: " + ", ".join(
                f"{t:g} N m " + "/".join(f"{100 * x:+.1f}" for x in r["error"]) for t, r in zip(TORQUES, rows[-3:])), flush=True)
    write_record("kinematics_map", rows)
    draw(rows, ROOT / "docs/figures/kinematics_map.png")


if __name__ == "__main__":
    main()
