#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random whole drives on small meshes: how many converge, whether their moments, their energy and their laws hold, and what the engine
says of the rest. Record random_drives.json, table of docs/evidence/drive.md.

A tenth of them with large displacements too: record random_drives_large.json, table of docs/evidence/kinematics_drive.md. As many with
friction of their tooth flanks: record random_drives_rub.json, table of docs/evidence/drive_friction.md.

Usage: bench/random_drives.py [--count 300] [--start 0] [--only N] [--kind large|rub]
"""
import argparse
import csv
import json
import statistics
import subprocess
import tempfile
from collections import Counter
from os import environ
from pathlib import Path

import numpy as np

from common import DATA, ONE_THREAD, program, put, table, write_record

EXE = program("hdengine.x")
SEED = 36


def cup(r):
    """Keys of a cup by sections: short or long, fillet, tapered wall, bottom inside or flange outside of the bore."""
    bore = 17.5e-3
    rim, wall, bottom = 10 ** r.uniform(-3.7, -3.1), 10 ** r.uniform(-3.8, -3.2), 10 ** r.uniform(-3.7, -2.9)
    end, hat = r.uniform(16e-3, 32e-3), r.random() < 0.5
    hub = r.uniform(23e-3, 30e-3) if hat else r.uniform(5e-3, 12e-3)
    fillet = r.uniform(1.05, 3) * max(wall, bottom) if hat or r.random() < 0.6 else 0
    return {"cup.sections_r": [bore, bore, bore, bore, bore, hub], "cup.sections_z": [0, 9e-3, 10e-3, end, end, end],
            "cup.sections_thickness": [rim, rim, wall, wall, bottom, bottom], "cup.sections_fillet": [0, 0, 0, fillet, 0, 0]}


def draw(i):
    """Keys of scene i, from its own generator: a scene stays the same whatever the count."""
    r = np.random.default_rng([SEED, i])

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


def columns(path):
    """A table by its columns; none of one that is not there."""
    if not path.exists():
        return {}
    with path.open() as f:
        rows = list(csv.DictReader(f))
    return {k: np.array([r[k] for r in rows]) for k in (rows[0] if rows else {})}


def solve(keys, limit=600):
    """Outcome of a scene, with the faults of its results: [] where all holds."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        done = subprocess.run([EXE, DATA / ("drive14_hat.nml" if "cup.sections_r" in keys else "drive14.nml"), *(f"{k}={v}" for k, v in keys.items()), "output.vtu=none",
                               f"solver.time_limit_s={limit}", "--out", out, "-q"], capture_output=True, text=True, env=environ | ONE_THREAD)
        row = {"code": done.returncode, "message": done.stderr.strip()}
        if (out / "summary.json").exists():
            s = json.loads((out / "summary.json").read_text())
            steps, loop = columns(out / "steps.csv"), columns(out / "loop.csv")
            row |= {"iterations": [int(n) for n in steps.get("iterations", [])], "cut_backs": s["results"]["cut_backs"], "warnings": s.get("warnings", []),
                    "total_s": s["timers_s"]["total"], "k": [s["results"].get(f"k{i}_nm_per_rad") for i in (1, 2, 3)]}
            if done.returncode == 0:
                row["faults"] = faults(keys, steps, loop, columns(out / "teeth.csv"), columns(out / "balls.csv"))
    return row


def faults(keys, steps, loop, teeth, balls):
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
    return found


def outcome(row):
    """Class of a result."""
    if row["code"] == 0:
        return "converged" if not row.get("faults") else "converged, with a fault"
    for word in ("not held", "gross slip", "does not settle", "time limit", "stopped at a limit", "run in a cycle", "no convergence"):
        if word in row["message"]:
            return word
    return f"code {row['code']}"


KINDS = {"": ("random_drives", "drive random", "evidence/drive", 600), "large": ("random_drives_large", "drive random", "evidence/kinematics_drive", 120),
         "rub": ("random_drives_rub", "drive random rub", "evidence/drive_friction", 600)}  # record, table, page, limit [s]


def run(kind, start, count):
    """Solve scenes, print what does not converge, write record and table if there are enough."""
    name, mark, page, limit = KINDS[kind]
    rows = []
    for i in range(start, start + count):
        keys = draw(i) | {"solver.kinematics": "nonlinear" if kind == "large" else "linear"}
        if kind == "rub":
            keys["load.tooth_friction"] = float(f"{np.random.default_rng([SEED, i, 1]).uniform(0.02, 0.3):.3g}")
        rows.append({"scene": i, "keys": keys} | solve(keys, limit))
        if outcome(rows[-1]) != "converged":
            print(i, outcome(rows[-1]), rows[-1]["message"][:160].replace("\n", " "), rows[-1].get("faults", ""), flush=True)
    classes = Counter(map(outcome, rows))
    steps = [n for row in rows for n in row.get("iterations", [])]
    record = {"count": count, "outcomes": dict(classes), "iterations_per_step_median": statistics.median(steps),
              "iterations_per_step_95": float(np.quantile(steps, 0.95)), "iterations_per_step_max": max(steps),
              "cut_backs": sum(r.get("cut_backs", 0) for r in rows if r["code"] == 0),
              "scenes": [{k: v for k, v in row.items() if k not in ("keys", "warnings")} for row in rows]}
    print(kind, {k: v for k, v in record.items() if k != "scenes"})
    if start == 0 and count >= (30 if kind else 100):
        write_record(name, record, seed=SEED, threads=1)
        put(mark, table(("outcome", "drives"), [(k, v) for k, v in classes.most_common()]), page=page)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--only", type=int, help="one scene: print its keys and result")
    parser.add_argument("--kind", choices=("large", "rub"), help="default: plain scenes, and a tenth as many of each kind")
    args = parser.parse_args()
    if args.only is not None:
        print(" ".join(f"'{k}={v}'" for k, v in draw(args.only).items()))
        print(json.dumps(solve(draw(args.only)), indent=1))
        return
    run(args.kind or "", args.start, args.count)
    if not args.kind:
        run("large", args.start, args.count // 10)
        run("rub", args.start, args.count // 10)


if __name__ == "__main__":
    main()
