#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes and whole drives on small meshes: how many converge, in how many iterations, and what the engine says of the rest. Of drives
moments must balance, no ball, flank or point of contact may pull, none rub with more than mu times its force, a point that presses has no gap,
friction may give nothing back, and a loop's work must be what is stored and what friction took.

Usage: bench/random_runs.py [scenes] [drives] [large] [rub] [loose] [--count N] [--only N]; large: drives with large displacements, rub: with
friction of the flanks, loose: as built, with the bearing free in the cup. Writes bench/results/random_runs.json; --count writes nothing, --only prints the keys and the result of one.
"""
import argparse
import csv
import json
import subprocess
import tempfile
from collections import Counter
from os import environ
from pathlib import Path
from statistics import median

import numpy as np

from common import DATA, ONE_THREAD, program, write_part

SCENES, DRIVES, LOOSE = 2023, 36, 57   # seeds
OPTIONS = ((0.15, "contact.law", "joint"), (0.1, "wave_generator.shape", "as_formed"), (0.15, "wave_generator.ring_contact", "unilateral"),
           (0.15, "load.torque_load", "teeth"), (0.1, "solver.kinematics", "nonlinear"), (0.2, "contact.slave", "cup"))


def scene(i):
    """Keys of scene i: drawn from its own generator, so a scene stays the same whatever the count."""
    r = np.random.default_rng([SCENES, i])
    divisions, facets = int(r.choice([24, 32, 40])), int(r.integers(3, 7))
    keys = {
        "geometry.wall_thickness": 10 ** r.uniform(-4, np.log10(2e-3)),
        "geometry.ring_thickness": 10 ** r.uniform(-4, np.log10(2e-3)),
        "mesh.divisions": divisions,
        "mesh.band_facets": facets,
        "mesh.wall_elements": 4,
        "mesh.bottom_elements": 3,
        "wave_generator.w": r.uniform(0, 0.4e-3),
        "wave_generator.cam": str(r.choice(["ellipse", "cosine"])),
        "wave_generator.ring_tangent": str(r.choice(["follow", "free"], p=[0.8, 0.2])),  # drawn, then left to the engine
        "wave_generator.eccentricity": float(r.choice([0, 1])) * r.uniform(0, 50e-6),
        "wave_generator.eccentricity_angle_deg": r.uniform(0, 360),
        "wave_generator.interference": float(r.choice([0, 1], p=[0.25, 0.75])) * r.uniform(0, 50e-6),
        "contact.friction": float(r.choice([0, 1], p=[0.1, 0.9])) * r.uniform(0, 1),
        "load.support": str(r.choice(["hub", "bearing"])),
        "load.torque": 10 ** r.uniform(-1, 2) * r.choice([-1, 1]),
        "load.assembly_steps": 2,
        "load.torque_steps": 3,
    }
    keys["geometry.rim_thickness"] = keys["geometry.wall_thickness"] * r.uniform(1, 2)
    if r.random() < 0.3:
        keys["mesh.ring_divisions"] = int(divisions * r.uniform(0.6, 1.5))
        keys["mesh.ring_facets"] = int(r.integers(2, 8))
    for chance, key, value in OPTIONS:
        if (key != "wave_generator.ring_contact" or "wave_generator.shape" not in keys) and r.random() < chance:
            keys[key] = value
    keys = {k: float(f"{v:.6g}") if isinstance(v, float) else v for k, v in keys.items()}
    return keys | {"wave_generator.ring_tangent": "auto"}


def cup(r):
    """Keys of a cup by sections: short or long, fillet, tapered wall, bottom inside or flange outside of the bore."""
    bore = 17.5e-3
    rim, wall, bottom = 10 ** r.uniform(-3.7, -3.1), 10 ** r.uniform(-3.8, -3.2), 10 ** r.uniform(-3.7, -2.9)
    end, hat = r.uniform(16e-3, 32e-3), r.random() < 0.5
    hub = r.uniform(23e-3, 30e-3) if hat else r.uniform(5e-3, 12e-3)
    fillet = r.uniform(1.05, 3) * max(wall, bottom) if hat or r.random() < 0.6 else 0
    return {"cup.sections_r": [bore, bore, bore, bore, bore, hub], "cup.sections_z": [0, 9e-3, 10e-3, end, end, end],
            "cup.sections_thickness": [rim, rim, wall, wall, bottom, bottom], "cup.sections_fillet": [0, 0, 0, fillet, 0, 0]}


def drive(i):
    """Keys of drive i."""
    r = np.random.default_rng([DRIVES, i])

    def sometimes(chance, value, other=0.0):
        return value if r.random() < chance else other
    teeth = int(r.choice([100, 160, 200, 320]))
    keys = {
        "mesh.divisions": int(r.choice([24, 32, 40])), "mesh.band_facets": int(r.integers(3, 7)), "mesh.bottom_elements": 4,
        "geometry.band_length": r.uniform(6e-3, 12e-3), "geometry.ring_thickness": 10 ** r.uniform(-3.4, -2.7),
        "wave_generator.w": r.uniform(0.05e-3, 0.45e-3), "wave_generator.cam": str(r.choice(["ellipse", "cosine", "arcs"])),
        "wave_generator.interference": r.choice([0, 1, -1], p=[0.25, 0.6, 0.15]) * r.uniform(0, 40e-6),
        "wave_generator.eccentricity": sometimes(0.4, r.uniform(0, 50e-6)), "wave_generator.eccentricity_angle_deg": r.uniform(0, 360),
        "bearing.balls": int(r.choice([0, *range(7, 26)])), "bearing.ball_diameter": r.uniform(2e-3, 3.6e-3),
        "bearing.outer_conformity": r.uniform(0.505, 0.6), "bearing.clearance": sometimes(0.5, r.uniform(-10e-6, 60e-6)),
        "bearing.cage_angle_deg": r.uniform(0, 30),
        "contact.friction": sometimes(0.9, r.uniform(0, 0.6)), "load.teeth": teeth,
        "load.tooth_pairs": 2 * int(r.integers(2, teeth // 8)), "load.tooth_stiffness": 10 ** r.uniform(7, 9),
        "load.tooth_clearance": sometimes(0.8, 10 ** r.uniform(-6, -3.7)), "load.pressure_angle_deg": sometimes(0.9, r.uniform(0, 40)),
        "load.torque": 10 ** r.uniform(-1, 2) * r.choice([-1, 1]), "load.torque_steps": int(r.integers(1, 5)), "load.assembly_steps": 2,
        "loop.torques": [float(f"{v:.4g}") for v in 10 ** r.uniform(-0.5, 1.6) * r.uniform(-1, 1, int(r.integers(2, 5)))],
    }
    if r.random() < 0.5:
        keys |= cup(r)
    else:
        keys |= {"geometry.wall_thickness": 10 ** r.uniform(-3.8, -3.1), "geometry.hub_radius": r.uniform(5e-3, 12e-3),
                 "geometry.cup_length": r.uniform(14e-3, 32e-3)}
        keys["geometry.rim_thickness"] = keys["geometry.wall_thickness"] * r.uniform(1, 1.6)
    for chance, key, value in ((0.15, "contact.mode", "frictionless"), (0.1, "contact.law", "joint"), (0.2, "contact.slave", "cup"),
                               (0.1, "mesh.element", "hex20r"), (0.15, "solver.method", "newton"), (0.2, "mesh.through_wall", 2)):
        if r.random() < chance:
            keys[key] = value
    return {k: ",".join(f"{x:.6g}" for x in v) if isinstance(v, list) else float(f"{v:.6g}") if isinstance(v, float) else v
            for k, v in keys.items()}


def loose(i):
    """Keys of drive i as it is built: lengths in proportion to its bore, the bearing free in the cup by up to 100 um."""
    r = np.random.default_rng([LOOSE, i])

    def sometimes(chance, value, other=0.0):
        return value if r.random() < chance else other
    size, ratio = r.uniform(11, 40), int(r.choice([50, 100, 160]))
    s = size / 14
    wall, rated = r.uniform(0.25e-3, 0.5e-3) * s, 7.8 * s**3
    band = r.uniform(4e-3, 8e-3) * s
    torque = rated * r.uniform(0.1, 2)
    keys = {
        "mesh.divisions": int(r.choice([24, 32, 40, 48])), "mesh.band_facets": int(r.integers(4, 9)),
        "geometry.bore_radius": 17.5e-3 * s, "geometry.rim_length": 9e-3 * s, "geometry.band_start": r.uniform(0, 9e-3 * s - band),
        "geometry.band_length": band, "geometry.ring_thickness": r.uniform(0.5e-3, 1.5e-3) * s, "geometry.wall_thickness": wall,
        "geometry.rim_thickness": wall * r.uniform(1, 1.5), "geometry.rim_taper": 1e-3 * s, "geometry.cup_length": r.uniform(18e-3, 26e-3) * s,
        "geometry.bottom_thickness": r.uniform(0.3e-3, 0.8e-3) * s, "geometry.hub_radius": r.uniform(8e-3, 11.25e-3) * s,
        "wave_generator.w": 0.2e-3 * s * 100 / ratio * r.uniform(0.8, 1.2), "wave_generator.cam": str(r.choice(["ellipse", "cosine", "arcs"])),
        "wave_generator.clearance": r.uniform(0, 100e-6), "wave_generator.eccentricity": sometimes(0.5, r.uniform(0, 20e-6)),
        "wave_generator.eccentricity_angle_deg": r.uniform(0, 360), "bearing.balls": int(r.choice([0, *range(15, 28)])),
        "bearing.ball_diameter": 3.2e-3 * s, "bearing.clearance": sometimes(0.5, r.uniform(-5e-6, 20e-6)),
        "bearing.cage_angle_deg": sometimes(0.5, r.uniform(0, 12)), "contact.friction": r.uniform(0.02, 0.3),
        "load.torque": torque, "load.teeth": 2 * ratio, "load.tooth_pairs": 2 * round(0.2 * ratio), "load.tooth_stiffness": 1.25e8 * s,
        "load.pressure_angle_deg": {50: 30, 100: 20, 160: 20}[ratio], "load.tooth_friction": sometimes(0.3, r.uniform(0.02, 0.15)),
        "load.spline": str(r.choice(["free", "rigid"])), "load.spline_diameter": 50e-3 * s, "load.torque_steps": int(r.integers(4, 7)),
        "loop.history": str(r.choice(["loop", "assembled"])), "loop.torque_1": 0.25 * torque, "loop.torque_2": 0.8 * torque,
        "loop.rated_torque": torque, "load.tooth_gaps": 0, "load.tooth_gaps_back": 0}
    if r.random() < 0.6:
        pairs = keys["load.tooth_pairs"]
        way = np.tile(abs(np.arange(pairs // 2) + 0.5 - r.uniform(0.3, 0.7) * pairs / 2) / (pairs / 4), 2)
        keys["load.tooth_gaps"] = list(r.uniform(0.3e-6, 3e-6) * s + r.uniform(5e-6, 30e-6) * s * way**2)
        keys["load.tooth_gaps_back"] = sometimes(0.5, list(keys["load.tooth_gaps"][::-1]))
    else:
        keys["load.tooth_clearance"] = r.uniform(0, 40e-6) * s
    keys["solver.kinematics"] = "linear" if r.random() < 0.9 else "nonlinear"
    if keys["solver.kinematics"] == "nonlinear":
        keys |= {"load.torque_steps": 2, "loop.torques": [torque, 0]}
    return {k: ",".join(f"{x:.6g}" for x in v) if isinstance(v, list) else float(f"{v:.6g}") if isinstance(v, float) else v
            for k, v in keys.items()}


def columns(path):
    """A table by its columns; none of one that is not there."""
    if not path.exists():
        return {}
    with path.open() as f:
        rows = list(csv.DictReader(f))
    return {k: np.array([r[k] for r in rows]) for k in (rows[0] if rows else {})}


def contact_faults(facets, mu):
    """What must hold at the facets of a hard contact and does not: their pressures and shears are those of corners, their gap the mean of these."""
    p, shear = (np.array([facets[f"{name}_{k}_pa"] for k in (1, 2, 3, 4)]).astype(float) for name in ("pressure", "shear"))
    gap = facets["gap_m"].astype(float)
    most, reach = p.max(), max(abs(gap).max(), 1e-6)
    found = []
    if p.min() < -1e-6 * most:
        found.append(f"a point pulls with {-p.min():.1e} Pa")
    if gap.min() < -1e-4 * reach:
        found.append(f"a facet lies {-gap.min():.1e} m deep")
    if gap[(p > 1e-6 * most).all(axis=0)].max(initial=0) > 1e-4 * reach:
        found.append("all of a facet presses over a gap")
    if (abs(shear) - mu * p).max() > 1e-6 * most:
        found.append("a point rubs with more than mu times its pressure")
    return found


def faults(keys, steps, loop, teeth, balls, facets):
    """What must hold in every converged drive and does not."""
    torque = loop["torque_nm"].astype(float)
    top = max(abs(torque).max(), 1e-3)
    found = []
    left = 1e-3 if keys.get("solver.kinematics") == "nonlinear" else 1e-4  # pairs that still move may leave so much (moment_left, hd_newton)
    if abs(steps["torque_balance_nm"].astype(float)).max() > left * top:
        found.append(f"torque balance {abs(steps['torque_balance_nm'].astype(float)).max():.1e} N m")
    if teeth and min(teeth["force_n"].astype(float)) < 0 or balls and min(balls["force_n"].astype(float)) < 0:
        found.append("a ball or flank pulls")
    mu = keys.get("load.tooth_friction", 0)
    if teeth and np.any(abs(teeth["friction_n"].astype(float)) > mu * teeth["force_n"].astype(float) * (1 + 1e-9)):
        found.append("a flank rubs with more than mu times its force")
    heat = np.diff(loop["dissipated_j"].astype(float))
    if keys.get("contact.law") == "joint" or keys["load.torque_steps"] == 1:
        heat = heat[:0]  # a rough joint gives back what it stored in shear; one step over a reversal is no integral
    if heat.min(initial=0) < -1e-2 * max(abs(loop["work_j"].astype(float)).max(), 1e-12):
        found.append(f"friction gives {-heat.min():.1e} J")
    if not np.isfinite(loop["angle_rad"].astype(float)).all():
        found.append("the angle is no number")
    if heat.size:  # over steps to or from T = 0 a loose drive is so soft that the mean of two torques says little of its work
        energy = loop["work_j"].astype(float) - loop["stored_j"].astype(float) - loop["dissipated_j"].astype(float)
        lost = abs(np.diff(energy)[torque[1:] * torque[:-1] > 0].sum()) / max(abs(loop["work_j"].astype(float)).max(), 1e-12)
        if lost > 0.04:
            found.append(f"{lost:.2g} of the work is neither stored nor dissipated")
    if keys.get("contact.law") != "joint":
        found += contact_faults(facets, 0 if keys.get("contact.mode") == "frictionless" else keys["contact.friction"])
    return found


def solve(data, keys, limit):
    """Outcome of a run: exit code, message, iterations of each step, and the faults of a drive's results."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        done = subprocess.run([program("hdengine.x"), DATA / data, *(f"{k}={v}" for k, v in keys.items()), "output.vtu=none",
                               f"solver.time_limit_s={limit}", "--out", out, "-q"], capture_output=True, text=True, env=environ | ONE_THREAD)
        row = {"code": done.returncode, "message": done.stderr.strip(), "iterations": [], "cut_backs": 0, "faults": []}
        if (out / "summary.json").exists():
            steps = columns(out / "steps.csv")
            row["iterations"] = [int(n) for n in steps.get("iterations", [])]
            row["cut_backs"] = json.loads((out / "summary.json").read_text())["results"]["cut_backs"]
            if done.returncode == 0 and data.startswith("drive"):
                row["faults"] = faults(keys, steps, *(columns(out / f"{name}.csv") for name in ("loop", "teeth", "balls", "contact")))
    return row


def outcome(row):
    """Class of a result."""
    if row["code"] == 0:
        return "converged" if not row["faults"] else "converged, with a fault"
    words = ("not held", "gross slip", "slip is too large", "does not settle", "time limit", "stopped at a limit", "run in a cycle", "no convergence")
    return next((word for word in words if word in row["message"]), f"code {row['code']}")


def rub(i):
    """Keys of drive i with friction of its flanks."""
    return drive(i) | {"load.tooth_friction": float(f"{np.random.default_rng([DRIVES, i, 1]).uniform(0.02, 0.3):.3g}")}


KINDS = {"scenes": (scene, 500, 400), "drives": (lambda i: drive(i) | {"solver.kinematics": "linear"}, 300, 600),
         "large": (lambda i: drive(i) | {"solver.kinematics": "nonlinear"}, 30, 120),
         "loose": (loose, 200, 120),
        "rub": (lambda i: rub(i) | {"solver.kinematics": "linear"}, 30, 600)}  # keys, number, limit [s]
NAMES = {"large": "drives, large displacements", "rub": "drives, friction of the flanks", "loose": "drives, bearing free in the cup"}


def run(kind, numbers):
    """Solve runs; print what does not converge."""
    keys_of, _, limit = KINDS[kind]
    rows = []
    for i in numbers:
        keys = keys_of(i)
        rows.append(solve("cd14.nml" if kind == "scenes" else "drive14_hat.nml" if "cup.sections_r" in keys else "drive14.nml", keys, limit))
        if outcome(rows[-1]) != "converged":
            print(kind, i, outcome(rows[-1]), rows[-1]["message"][:160].replace("\n", " "), rows[-1]["faults"], flush=True)
    steps = [n for row in rows for n in row["iterations"]]
    return {"count": len(rows), "outcomes": dict(Counter(map(outcome, rows)).most_common()), "iterations_per_step_median": median(steps),
            "iterations_per_step_95": float(np.quantile(steps, 0.95)), "iterations_per_step_max": max(steps),
            "cut_backs": sum(row["cut_backs"] for row in rows if row["code"] == 0)}


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kinds", nargs="*", choices=[*KINDS, []])
    parser.add_argument("--count", type=int)
    parser.add_argument("--only", type=int)
    args = parser.parse_args()
    for kind in args.kinds or KINDS:
        if args.only is not None:
            print(" ".join(f"'{k}={v}'" for k, v in KINDS[kind][0](args.only).items()))
        found = run(kind, [args.only] if args.only is not None else range(args.count or KINDS[kind][1]))
        print(kind, found, flush=True)
        if args.only is None and args.count is None:
            write_part("random_runs", NAMES.get(kind, kind), found, seed=SCENES, threads=1)


if __name__ == "__main__":
    main()
