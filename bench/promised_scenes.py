#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes that state a tolerance: how often a planned run promises it, and how often the true error keeps the promise.

Promised are limits on fine meshes of tangent K_TS, rotation, normal force and mid-band pressure (hd_promises). The reference of a scene
knows only meshes beyond the finest that a plan of it solved: the next three of the series, with twice the layers, edge cells half as
long and twice the load steps; the line through them over the length of the facets to the power of 3/2 gives what is true. The line
through the last two of them is the reference's doubt. A promise is judged where that doubt is below SETTLED of its tolerance.
A promise is made where the summary says "met": "yes". Meshes above LIMIT_MB are refused, which ends a plan without a promise, as does
a run beyond LIMIT_S seconds of wall clock. The smallest tolerance, if it needs four layers, is asked of scenes whose plan of the one
before took less than QUICK seconds. A reference whose next mesh would take longer than LONGEST seconds ends there.

Usage: bench/promised_scenes.py --seed 2712 [--count 60] [--seconds 540] [--tolerances 0.05 0.02 0.01]; what the record holds is not
run again.
"""
import argparse
import shutil
import tempfile
import time
from pathlib import Path

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

import hdengine
from common import FIGURES, ROOT, add_row, mesh_of_level, new_axes, read_rows, styled

SEED = 2611   # of the scenes that other scripts draw
BAND = tuple(mesh_of_level(level)["mesh.band_facets"] for level in range(1, 14))
NAMES = {"k_ts_tangent_nm_per_rad": "tangent K_TS", "rotation_rad": "rotation", "normal_force_n": "normal force",
         "pressure_mid_mean_pa": "mid-band pressure"}
POWER = 1.5
LIMIT_MB = 300
LIMIT_S = 900
LONGEST = 100
QUICK = 10
SETTLED = 0.25


def draw(i, seed=SEED):
    """Input file and keys of scene i, from its own generator."""
    r = np.random.default_rng([seed, i])
    wall, support = r.uniform(0.25e-3, 0.8e-3), "hub" if r.random() < 0.65 else "bearing"
    keys = {
        "geometry.wall_thickness": wall,
        "geometry.rim_thickness": wall * r.uniform(1, 2),
        "geometry.ring_thickness": r.uniform(0.5e-3, 1.5e-3),
        "geometry.band_length": r.uniform(9e-3, 14e-3),
        "wave_generator.w": r.uniform(0.05e-3, 0.35e-3),
        "wave_generator.interference": r.uniform(-5e-6, 40e-6),
        "wave_generator.eccentricity": float(r.random() < 0.3) * r.uniform(0, 20e-6),
        "contact.friction": r.uniform(0.03, 0.4),
        "load.torque": r.uniform(0.3, 15 if support == "hub" else 3),
    }
    words = {"load.support": support, "contact.law": r.choice(["hard", "joint", "joint_elastic"], p=[0.4, 0.4, 0.2]),
             "solver.kinematics": "nonlinear" if r.random() < 0.2 else "linear"}
    data = "cd14.nml" if r.random() < 0.5 else "cd14_ground.nml"
    return data, {k: float(f"{v:.6g}") for k, v in keys.items()} | {k: str(v) for k, v in words.items()}


def solve(data, keys, folder):
    """Result and CPU seconds of a run; all meshes forgotten before."""
    hdengine.forget()
    start = time.process_time()
    found = hdengine.run(ROOT / "data" / data, folder, True, **{"output.vtu": "none"}, **keys)
    return found, time.process_time() - start


def planned(data, keys, tolerance, folder):
    """What a planned run promises, and what a reference needs of it."""
    try:
        found, seconds = solve(data, keys | {"run.tolerance": tolerance, "mesh.memory_limit_mb": LIMIT_MB, "solver.time_limit_s": LIMIT_S}, folder)
    except hdengine.HdengineError as e:
        return {"tolerance": tolerance, "met": "no", "message": str(e)[:120]}
    plan, scene = found.summary["plan"], found.summary["scene"]
    limits = found.limits
    trials = [line.split(",")[:-1] for line in (folder / "plan.csv").read_text().splitlines()[1:]]
    return {"tolerance": tolerance, "met": plan["met"], "level": plan["level"], "seconds": seconds,
            "limit": {n: v[0] for n, v in limits.items()}, "estimate": {n: v[1] for n, v in limits.items()},
            "mesh_gives": {n: found.summary["results"][n] for n in limits},
            "trials": {words[0]: [float(v) for v in words[1:5]] for words in trials},
            "layers": scene["mesh.through_wall"], "load_steps": [scene["load.assembly_steps"], scene["load.torque_steps"]]}


def reference(data, keys, made, folder):
    """Results of meshes beyond the finest of the plans, by level, and the CPU seconds of each."""
    level = max(run["level"] for run in made)
    layers = 2 * max(run["layers"] for run in made)
    steps = [2 * max(run["load_steps"][k] for run in made) for k in range(2)]
    found = {}
    for k in range(level + 1, level + 4):
        if len(found) > 0 and 2.5 * found[k - 1]["seconds"] > LONGEST:
            break
        mesh = mesh_of_level(k, geometry={"band_length": keys["geometry.band_length"]})
        result, seconds = solve(data, keys | mesh | {
            "mesh.edge_length": keys["geometry.band_length"] / (16 * BAND[k - 1]), "mesh.through_wall": layers, "mesh.through_ring": layers,
            "solver.tolerance": 1e-6, "solver.time_limit_s": 2 * LIMIT_S, "load.assembly_steps": steps[0], "load.torque_steps": steps[1]}, folder)
        found[k] = {n: result.summary["results"][n] for n in NAMES} | {"seconds": seconds}
    return found


def true_limits(found):
    """Limits of a reference: the line through its meshes at facets of length 0."""
    x = np.array([BAND[int(k) - 1] for k in found], float)**-POWER
    return {n: float(np.polyfit(x, [row[n] for row in found.values()], 1)[1]) for n in NAMES if None not in (row[n] for row in found.values())}


def judge(row, folder):
    """Enter the true errors of the promises of a scene, where its reference is settled."""
    made = [run for run in row["runs"] if run["met"] == "yes"]
    if not made:
        return
    try:
        row["reference"] = reference(row["data"], row["keys"], made, folder)
    except hdengine.HdengineError as e:
        row["reference_message"] = str(e)[:120]
        return
    if len(row["reference"]) < 3:
        return
    true, last = true_limits(row["reference"]), true_limits(dict(list(row["reference"].items())[1:]))
    row["reference_doubt"] = {n: abs(last[n] / v - 1) for n, v in true.items()}
    for run in made:
        if max(row["reference_doubt"].values()) > SETTLED * run["tolerance"]:
            continue
        run["true_error"] = {n: abs(v / true[n] - 1) for n, v in run["limit"].items() if n in true}
        run["true_error_of_mesh"] = {n: abs(v / true[n] - 1) for n, v in run["mesh_gives"].items() if n in true}


def judged_runs(rows, tolerance=None):
    """Promises with their true errors."""
    return [run for row in rows for run in row["runs"] if "true_error" in run and tolerance in (None, run["tolerance"])]


@styled
def figure(rows):
    """True error over its estimate of everything that is promised: docs/figures/promised_scenes.png."""
    tolerances = sorted({run["tolerance"] for run in judged_runs(rows)}, reverse=True)
    fig, axes = new_axes(1, len(tolerances), figsize=(4.6 * len(tolerances), 4.4))
    for axis, tolerance in zip(np.atleast_1d(axes), tolerances):
        for name, words in NAMES.items():
            pairs = [(100 * run["estimate"][name], 100 * max(run["true_error"][name], 1e-5)) for run in judged_runs(rows, tolerance)
                     if name in run["limit"]]
            axis.loglog(*zip(*pairs), "o", ms=4, label=words)
        ends = np.array([0.15, 100 * tolerance])
        axis.plot(ends, ends, "k:", label="true = estimated")
        axis.axhline(100 * tolerance, color="0.4", lw=0.8, ls="--", label="tolerance")
        axis.set_title(f"tolerance {100 * tolerance:g} %", fontsize=12)
        axis.set_xlabel("estimated error / %")
        axis.set_ylabel("true error / %")
        for side in (axis.xaxis, axis.yaxis):
            side.set_major_locator(LogLocator(subs=(1, 3)))
            side.set_major_formatter("{x:g}")
            side.set_minor_formatter(NullFormatter())
    np.atleast_1d(axes)[0].legend(fontsize=8, loc="upper left", bbox_to_anchor=(0, 0.95))
    fig.savefig(FIGURES / "promised_scenes.png", dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, required=True, help="of the scenes; a record holds the scenes of several seeds")
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seconds", type=float, default=540, help="no new scene is begun after so long")
    parser.add_argument("--tolerances", type=float, nargs="+", default=(0.05, 0.02, 0.01))
    args = parser.parse_args()
    known = read_rows("promised_scenes", "scene")
    start, folder = time.time(), Path(tempfile.mkdtemp())
    for i in range(args.count):
        if time.time() - start > args.seconds:
            break
        if (name := f"{args.seed}-{i}") in known:
            continue
        data, keys = draw(i, args.seed)
        row = {"scene": name, "data": data, "keys": keys, "runs": []}
        for tolerance in args.tolerances:
            if tolerance >= 0.02 or row["runs"][-1].get("seconds", QUICK) < QUICK:
                row["runs"].append(planned(data, keys, tolerance, folder))
        judge(row, folder)
        add_row("promised_scenes", row, seed=args.seed)
        print(name, data, keys["load.support"], keys["contact.law"], keys["solver.kinematics"],
              [(run["met"], run.get("level"), max(run.get("estimate", {"": 0}).values()), max(run.get("true_error", {"": 0}).values()), run.get("message"))
               for run in row["runs"]], [f"{found['seconds']:.0f}" for found in row.get("reference", {}).values()], row.get("reference_message"), flush=True)
    shutil.rmtree(folder)
    rows = list(read_rows("promised_scenes", "scene").values())
    if judged_runs(rows):
        figure(rows)


if __name__ == "__main__":
    main()
