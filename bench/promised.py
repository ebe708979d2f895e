#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes and whole drives that state a tolerance: how often a planned run promises it, and how often the true error keeps the promise.

Promised are limits on fine meshes (hd_promises): tangent K_TS of the last load step and of all, rotation, normal force, mid-band pressure
and its peak, the pressure field, and K_FTS, which every eighth scene is for. Fields are compared by their means over 16 x 4 equal patches,
in the norm; K_TS of all steps by the step that errs most. The reference of a scene
takes three meshes of the series with its own kinematics, twice the layers, edge cells half as long and twice the load steps: the finest
that a plan of it solved, or that of 16 rows, and the next two; where the third would take more than LONGEST seconds, the one below takes its place. The second
may take twice as long. The line through them over the length of the facets to the power of 3/2 gives what is true. What the line through
the last two gives beside that is the reference's doubt. A result is judged where its doubt is below SETTLED of the tolerance, a promise
where all its results are or one is beyond the tolerance.
A promise is made where the summary says "met": "yes". Meshes above LIMIT_MB (TEETH_MB) are refused, which ends a plan without a promise, as does
a run beyond LIMIT_S seconds of wall clock. The smallest tolerance, if it needs four layers, is asked of scenes whose plan of the one
before took less than QUICK seconds.

Of drives K1 to K3 are promised, on meshes without edge cells, over the whole loop, with small displacements.

Usage: bench/promised.py scenes|drives --seed 2712 [--first 0] [--count 60] [--seconds 540]; what the record holds is not run again.
"""
import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

import hdengine
from common import ROOT, add_row, mesh_of_level, read_rows

STEPS, FIELD = "k_ts_tangent_steps_nm_per_rad", "pressure_field_pa"   # several numbers each
ALL_FROM = 2717   # seed from which every eighth scene is one against the teeth
BAND = tuple(mesh_of_level(level)["mesh.band_facets"] for level in range(1, 14))
PROMISES = dict(zip(hdengine._engine.names("promise_columns"), hdengine._engine.names("promise_words")))
DRIVE_NAMES = tuple(n for n in PROMISES if n in hdengine._engine.names("loop"))
NAMES = {n: words for n, words in PROMISES.items() if n not in DRIVE_NAMES}
DRIVES = ("drive11", "drive14", "drive17", "drive20", "drive25", "drive32", "drive40", "drive20_50", "drive20_160", "drive14_hat")
POWER = 1.5
JUDGING = 5   # level of a reference at least: 16 rows
LIMIT_MB = 300
TEETH_MB = 2000   # bonded faces are solved with all their unknowns
LIMIT_S = 900
LONGEST = 150
GROWTH = 2.5   # of the time from mesh to mesh
QUICK = 10
SETTLED = 0.25


def draw(i, seed):
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
    words = {"load.support": support, "wave_generator.ring_tangent": "auto", "contact.law": r.choice(["hard", "joint", "joint_elastic"], p=[0.4, 0.4, 0.2]),
             "solver.kinematics": "nonlinear" if r.random() < 0.2 else "linear"}
    data = "paper.nml" if r.random() < 0.5 else "cd14.nml"
    if seed >= ALL_FROM and i % 8 == 7:
        keys = {k: v for k, v in keys.items() if k.startswith("geometry")} | {"load.torque": keys["load.torque"],
                "load.tooth_stiffness": 10 ** r.uniform(7.8, 8.4)}
        data, words = "teeth.nml", {}
    if keys.get("wave_generator.interference", 0) < 0:
        keys["wave_generator.clearance"] = -keys.pop("wave_generator.interference")
    return data, {k: float(f"{v:.6g}") for k, v in keys.items()} | {k: str(v) for k, v in words.items()}


def draw_drive(i, seed):
    """Input file and keys of drive i as it is built, from its own generator: what no catalogue states."""
    r = np.random.default_rng([seed, i])
    data = f"{r.choice(DRIVES)}.nml"
    keys = {
        "wave_generator.clearance": r.uniform(0, 20e-6), "wave_generator.eccentricity": float(r.random() < 0.3) * r.uniform(0, 10e-6),
        "contact.friction": r.uniform(0.05, 0.3), "bearing.balls": int(r.integers(17, 26)), "bearing.cage_angle_deg": r.uniform(0, 20),
        "bearing.clearance": float(r.random() < 0.3) * r.uniform(0, 5e-6), "load.pressure_angle_deg": r.uniform(20, 30),
        "load.tooth_stiffness": 10 ** r.uniform(7.8, 8.4),
    }
    keys = {k: v if isinstance(v, int) else float(f"{v:.6g}") for k, v in keys.items()}
    return data, keys | {"bearing.model": "auto", "solver.kinematics": "linear"}


def solve(data, keys, folder):
    """Result and CPU seconds of a run; all meshes forgotten before."""
    hdengine.forget()
    start = time.process_time()
    found = hdengine.run(ROOT / "data" / data, folder, True, **{"output.vtu": "none"}, **keys)
    return found, time.process_time() - start


def planned(data, keys, tolerance, folder, memory_mb=None):
    """What a planned run promises, and what a reference needs of it."""
    limit = memory_mb or (TEETH_MB if data == "teeth.nml" else LIMIT_MB)
    if keys.get("solver.kinematics") == "nonlinear":   # true are large displacements; the plan may correct small ones
        keys = keys | {"solver.kinematics": "auto"}
    try:
        found, seconds = solve(data, keys | {"run.tolerance": tolerance, "mesh.memory_limit_mb": limit, "solver.time_limit_s": LIMIT_S}, folder)
    except hdengine.HdengineError as e:
        return {"tolerance": tolerance, "met": "no", "message": str(e)[:120]}
    plan, scene = found.summary["plan"], found.summary["scene"]
    limits = found.limits
    return {"tolerance": tolerance, "met": plan["met"], "level": plan["level"], "seconds": seconds,
            "limit": {n: v[0] for n, v in limits.items()}, "estimate": {n: v[1] for n, v in limits.items()},
            "layers": scene["mesh.through_wall"], "band_length": scene["geometry.band_length"], "load_steps": [scene["load.assembly_steps"], scene["load.torque_steps"]]}


def reference(data, keys, made, folder):
    """Results of three meshes from the finest of the plans on, or from the one below, by level, and the CPU seconds of each."""
    level = max(JUDGING, *(run["level"] for run in made))
    layers = 2 * max(run["layers"] for run in made)
    steps = [2 * max(run["load_steps"][k] for run in made) for k in range(2)]
    band = keys.get("geometry.band_length") or made[0]["band_length"]
    names = DRIVE_NAMES if data.startswith("drive") else NAMES

    def solved(k):   # where the first mesh takes LONGEST, no second one is solved
        mesh = mesh_of_level(k, ROOT / "data" / data, geometry={"band_length": band})
        result, seconds = solve(data, keys | mesh | {
            "mesh.edge_length": 0 if names is DRIVE_NAMES else band / (16 * BAND[k - 1]), "mesh.through_wall": layers, "mesh.through_ring": layers,
            "solver.tolerance": 1e-6, "solver.time_limit_s": LONGEST if k == level else 2 * LIMIT_S, "load.assembly_steps": steps[0], "load.torque_steps": steps[1]}, folder)
        several = {} if names is DRIVE_NAMES or result.against_teeth else {
            STEPS: result.steps["k_ts_bonded_nm_per_rad"][-1 - steps[1]:].tolist(), FIELD: patch_pressures(result)}
        return {n: result.summary["results"].get(n) or None for n in names} | several | {"seconds": seconds}
    found = {level: solved(level)}
    for k in (level + 1, level + 2):
        if GROWTH * found[max(found)]["seconds"] > (2 * LONGEST if k == level + 1 else LONGEST):
            break
        found[k] = solved(k)
    if len(found) == 2:
        found[level - 1] = solved(level - 1)
    return dict(sorted(found.items()))


def patch_pressures(result, around=16, along=4):
    """Mean pressures of equal patches of the band in the last step, along the band first [Pa]."""
    area, pressure, theta = (result.contact[n][-1].reshape(result.shape) for n in ("area_m2", "pressure_pa", "theta_rad"))
    z = np.append(0, np.cumsum(area[0])) / area[0].sum()
    turn = np.arange(len(theta) + 1) / len(theta) + theta[0, 0] / (2 * np.pi) - 0.5 / len(theta)

    def overlap(ends, parts):
        low, high = np.arange(parts)[:, None] / parts, np.arange(1, parts + 1)[:, None] / parts
        return parts * np.maximum(0, np.minimum(high, ends[1:]) - np.maximum(low, ends[:-1]))
    return (sum(overlap(turn + k, around) for k in (-1, 0, 1)) @ pressure @ overlap(z, along).T).ravel().tolist()


def true_limits(found):
    """Limits of a reference: the line through its meshes at facets of length 0."""
    x = np.array([BAND[int(k) - 1] for k in found], float)**-POWER
    names = [n for n in next(iter(found.values())) if n != "seconds" and None not in (row[n] for row in found.values())]
    return {n: np.polyfit(x, [row[n] for row in found.values()], 1)[1] for n in names}


def promised_steps(run, name, true):
    """What is true of the load steps that a run promises K_TS of, NaN of the others; a reference has more steps."""
    if name != STEPS or STEPS not in run["limit"]:
        return true
    limit = np.array(run["limit"][STEPS])
    return np.where(np.isnan(limit), np.nan, np.array(true)[::(len(true) - 1) // (len(limit) - 1)])


def relative(name, value, true):
    """Relative error of a result: of a field in the norm, of several numbers the largest."""
    value, true = np.atleast_1d(value), np.atleast_1d(true)
    if name == FIELD:
        return float(np.linalg.norm(value - true) / np.linalg.norm(true))
    return float(np.nanmax(abs(value / true - 1)))


def judge(row, folder):
    """Enter the reference of a scene."""
    made = [run for run in row["runs"] if run["met"] == "yes"]
    if not made:
        return
    row.pop("reference_message", None)
    try:
        row["reference"] = reference(row["data"], row["keys"], made, folder)
    except hdengine.HdengineError as e:
        row["reference_message"] = str(e)[:120]


def judged(row):
    """Promises of a row, with the true errors of what is judged of them."""
    made = [run for run in row["runs"] if run["met"] == "yes"]
    if len(row.get("reference", {})) < 3:
        return [run | {"true_error": {}} for run in made]
    true, last = true_limits(row["reference"]), true_limits(dict(list(row["reference"].items())[1:]))
    found = []
    for run in made:
        there = {n: promised_steps(run, n, v) for n, v in true.items()}
        known = [n for n in run["limit"] if n in true and relative(n, promised_steps(run, n, last[n]), there[n]) < SETTLED * run["tolerance"]]
        found.append(run | {"true_error": {n: relative(n, run["limit"][n], there[n]) for n in known}})
    return found


def kept(row):
    """What the record holds of a row: of each promise its time, and of each result the estimated and the true error, None where it is not judged."""
    def three(x):
        return None if x is None else float(f"{x:.3g}")
    return {"scene": row["scene"], "asked": [run["tolerance"] for run in row["runs"]], "runs": [
        {"tolerance": run["tolerance"], "seconds": three(run["seconds"]),
         "results": {n: [three(e), three(run["true_error"].get(n))] for n, e in run["estimate"].items()}} for run in judged(row)]}


def more(runs, tolerance):
    """Whether a scene is asked for one more tolerance."""
    return tolerance >= 0.02 or runs[-1].get("seconds", QUICK) < QUICK


KINDS = {"scenes": (draw, (0.05, 0.02, 0.01)), "drives": (draw_drive, (0.1, 0.05))}


def main():
    """Draw, plan and judge scenes until the time of the command line is over."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--seed", type=int, required=True, help="of the scenes; a record holds the scenes of several seeds")
    parser.add_argument("--first", type=int, default=0, help="scene to begin with: two runs share a set")
    parser.add_argument("--count", type=int, default=60, help="of the set")
    parser.add_argument("--seconds", type=float, default=540, help="no new scene is begun after so long")
    args = parser.parse_args()
    record, (drawn, tolerances) = f"promised_{args.kind}", KINDS[args.kind]
    known, start = read_rows(record, "scene"), time.time()
    with tempfile.TemporaryDirectory() as folder:
        for i in range(args.first, args.count):
            name = f"{args.seed}-{i}"
            if name in known or time.time() - start > args.seconds:
                continue
            data, keys = drawn(i, args.seed)
            row = {"scene": name, "data": data, "keys": keys, "runs": []}
            for tolerance in tolerances:
                if more(row["runs"], tolerance):
                    row["runs"].append(planned(data, keys, tolerance, Path(folder)))
            judge(row, Path(folder))
            add_row(record, kept(row), seed=args.seed)
            print(kept(row), row.get("reference_message", ""), flush=True)


if __name__ == "__main__":
    main()
