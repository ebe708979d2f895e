#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes on small meshes: how many converge, in how many iterations, and what the engine says of the rest.

Usage: bench/random_scenes.py [--count 500] [--seed 2023] [--ring auto] [--only N]; writes bench/results/random_scenes.json, prints Markdown.
"""
import argparse
import csv
import json
import statistics
import subprocess
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from common import ROOT, program, write_record

EXE = program("hdengine.x")

OPTIONS = ((0.15, "contact.law", "joint"), (0.1, "wave_generator.shape", "as_formed"), (0.15, "wave_generator.ring_contact", "unilateral"),
           (0.15, "load.torque_load", "teeth"), (0.1, "solver.kinematics", "nonlinear"), (0.2, "contact.slave", "cup"))


def draw(seed, i):
    """Keys of scene i: drawn from its own generator, so a scene stays the same whatever the count."""
    r = np.random.default_rng([seed, i])
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
        "wave_generator.ring_tangent": str(r.choice(["follow", "free"], p=[0.8, 0.2])),
        "wave_generator.eccentricity": float(r.choice([0, 1])) * r.uniform(0, 50e-6),
        "wave_generator.eccentricity_angle_deg": r.uniform(0, 360),
        "wave_generator.interference": float(r.choice([0, 1], p=[0.25, 0.75])) * r.uniform(0, 50e-6),
        "contact.friction": float(r.choice([0, 1], p=[0.1, 0.9])) * r.uniform(0, 1),
        "load.support": str(r.choice(["hub", "bearing"])),
        "load.torque": 10 ** r.uniform(-1, 2) * r.choice([-1, 1]),
        "load.assembly_steps": 2,
        "load.torque_steps": 3,
    }
    if keys["load.support"] == "bearing":  # a ring that slides on the cam takes no torque: refused as input
        keys["wave_generator.ring_tangent"] = "follow"
    keys["geometry.rim_thickness"] = keys["geometry.wall_thickness"] * r.uniform(1, 2)
    if r.random() < 0.3:
        keys["mesh.ring_divisions"] = int(divisions * r.uniform(0.6, 1.5))
        keys["mesh.ring_facets"] = int(r.integers(2, 8))
    for chance, key, value in OPTIONS:
        if (key != "wave_generator.ring_contact" or "wave_generator.shape" not in keys) and r.random() < chance:
            keys[key] = value
    return {k: float(f"{v:.6g}") if isinstance(v, float) else v for k, v in keys.items()}


def on_balls(keys):
    """The same scene with a ring that slides on the cam wherever the hub is held."""
    return keys | {"wave_generator.ring_tangent": "auto"}


def solve(keys, limit=400):
    """Outcome of a scene."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        done = subprocess.run([EXE, ROOT / "data/cd14.nml", *(f"{k}={v}" for k, v in keys.items()), "output.vtu=none", f"solver.time_limit_s={limit}",
                               "--out", out, "-q"], capture_output=True, text=True)
        row = {"code": done.returncode, "message": done.stderr.strip()}
        path = out / "summary.json"
        if path.exists():
            s = json.loads(path.read_text())
            with (out / "steps.csv").open() as f:
                row["iterations"] = [int(step["iterations"]) for step in csv.DictReader(f)]
            row |= {k: s["results"][k] for k in ("cut_backs", "rotation_rad", "normal_force_n", "friction_capacity_nm", "torque_balance_nm")}
            row |= {"total_s": s["timers_s"]["total"], "solver": s["model"]["solver"]}
    return row


def outcome(row):
    """Class of a result."""
    if row["code"] == 0:
        return "converged"
    for word in ("gross slip", "not held", "slip is too large"):
        if word in row["message"]:
            return word
    return f"code {row['code']}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--seed", type=int, default=2023)
    parser.add_argument("--ring", choices=("drawn", "auto"), default="auto", help="auto: the default, every ring with a held hub slides; drawn: four in five held on the cam, record random_scenes_drawn")
    parser.add_argument("--only", type=int, help="one scene: print its keys and result")
    args = parser.parse_args()
    if args.only is not None:
        keys = draw(args.seed, args.only)
        keys = on_balls(keys) if args.ring == "auto" else keys
        print(" ".join(f"{k}={v}" for k, v in keys.items()))
        print(json.dumps(solve(keys), indent=1))
        return
    rows = []
    for i in range(args.start, args.start + args.count):
        keys = draw(args.seed, i)
        keys = on_balls(keys) if args.ring == "auto" else keys
        rows.append({"scene": i, "keys": keys} | solve(keys))
        if outcome(rows[-1]) not in ("converged", "gross slip"):
            print(i, outcome(rows[-1]), rows[-1]["message"][:100], flush=True)
    classes = Counter(map(outcome, rows))
    steps = [n for row in rows for n in row.get("iterations", [])]
    by_option = {o: dict(Counter(outcome(r) for r in rows if o in r["keys"])) for _, o, _ in OPTIONS}
    record = {"seed": args.seed, "count": args.count, "outcomes": dict(classes), "outcomes_by_option": by_option, "iterations_per_step_median": statistics.median(steps),
              "iterations_per_step_90": float(np.quantile(steps, 0.9)), "iterations_per_step_95": float(np.quantile(steps, 0.95)),
              "iterations_per_step_max": max(steps), "first_step_median": statistics.median(row["iterations"][0] for row in rows if row.get("iterations")),
              "worst_torque_balance": max(abs(row["torque_balance_nm"] / row["keys"]["load.torque"]) for row in rows if row["code"] == 0),
              "cut_backs": sum(row.get("cut_backs", 0) for row in rows if row["code"] == 0), "scenes": rows}
    if args.start == 0:
        write_record("random_scenes" + ("_drawn" if args.ring == "drawn" else ""), record, seed=args.seed)
    for k, v in record.items():
        if k != "scenes":
            print(f"| {k} | {v} |")


if __name__ == "__main__":
    main()
