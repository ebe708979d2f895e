#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random whole drives that state a tolerance: how often a planned run promises K1 to K3 and hysteresis, and how often the true error
keeps the promise. Judged as promised_scenes.py judges; every eighth drive runs its whole loop, the others its first rise. Record
promised_drives.jsonl, table of docs/evidence/planned_drives.md.

Usage: bench/promised_drives.py --seed 3601 [--count 8] [--seconds 540] [--tolerances 0.1 0.05]
"""
import argparse
import shutil
import tempfile
import time
from pathlib import Path

import f90nml
import numpy as np
from promised_scenes import is_referred, judge, judged, planned

from common import DATA, add_row, read_rows

SCENES = ("drive11", "drive14", "drive17", "drive20", "drive25", "drive14_50", "drive14_160", "drive14_short", "drive14_hat")


def draw(i, seed):
    """Input file and keys of drive i, from its own generator: what no catalogue states, over the ranges of docs/evidence/drive_inputs.md."""
    r = np.random.default_rng([seed, i])
    data = f"{r.choice(SCENES)}.nml"
    keys = {
        "wave_generator.interference": r.uniform(0, 20e-6), "wave_generator.eccentricity": float(r.random() < 0.3) * r.uniform(0, 10e-6),
        "contact.friction": r.uniform(0.05, 0.3), "bearing.balls": int(r.integers(17, 26)), "bearing.cage_angle_deg": r.uniform(0, 20),
        "bearing.clearance": float(r.random() < 0.3) * r.uniform(0, 5e-6), "load.tooth_clearance": r.uniform(3e-6, 20e-6),
        "load.pressure_angle_deg": r.uniform(20, 30), "load.tooth_stiffness": 10 ** r.uniform(7.8, 8.4),
    }
    keys = {k: v if isinstance(v, int) else float(f"{v:.6g}") for k, v in keys.items()} | {"joint.model": "hu2023", "bearing.model": "auto"}
    return data, keys if i % 8 == 7 else keys | {"loop.torques": [rise(data)]}


def rise(data):
    """The largest torque of a scene's loop [N m]."""
    return f90nml.read(DATA / data)["load"]["torque"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, required=True, help="of the drives; a record holds those of several seeds")
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=540, help="no new drive is begun after so long")
    parser.add_argument("--tolerances", type=float, nargs="+", default=(0.1, 0.05))
    args = parser.parse_args()
    known = read_rows("promised_drives", "scene")
    start, folder = time.time(), Path(tempfile.mkdtemp())
    for i in range(args.count):
        if time.time() - start > args.seconds:
            break
        name = f"{args.seed}-{i}"
        data, keys = draw(i, args.seed)
        row = known.get(name, {"scene": name, "data": data, "keys": keys, "runs": []})
        if row["runs"] and is_referred(row):
            continue
        for tolerance in () if row["runs"] else args.tolerances:
            row["runs"].append(planned(data, keys, tolerance, folder))
        judge(row, folder)
        add_row("promised_drives", row, seed=args.seed)
        print(name, data, [(run["tolerance"], run["met"], run.get("level"), run.get("message", "")) for run in row["runs"]],
              [(run["tolerance"], run["estimate"], run["true_error"]) for run in judged(row)], row.get("reference_message", ""), flush=True)
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
