#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random whole drives that state a tolerance: how often a planned run promises K1 to K3 and hysteresis, and how often the true error
keeps the promise. Judged as promised_scenes.py judges; every eighth drive runs its whole loop, the others its first rise. Displacements
are small in plan and reference: references with large ones would take hours. Record promised_drives.jsonl, table of
docs/evidence/planned_drives.md.

Usage: bench/promised_drives.py --seed 3601 [--count 8] [--seconds 540] [--tolerances 0.1 0.05]
"""
import f90nml
import numpy as np
from promised_scenes import go_on, judged

from common import DATA

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
    keys = {k: v if isinstance(v, int) else float(f"{v:.6g}") for k, v in keys.items()}
    keys |= {"joint.model": "hu2023", "bearing.model": "auto", "solver.kinematics": "linear"}
    return data, keys if i % 8 == 7 else keys | {"loop.torques": [rise(data)]}


def rise(data):
    """The largest torque of a scene's loop [N m]."""
    return f90nml.read(DATA / data)["load"]["torque"]


def told(row):
    """Random whole drives that state a tolerance: promises made and kept."""
    return ([(run["tolerance"], run["met"], run.get("level"), run.get("message", "")) for run in row["runs"]],
            [(run["tolerance"], run["estimate"], run["true_error"]) for run in judged(row)])


if __name__ == "__main__":
    go_on("promised_drives", draw, (0.1, 0.05), lambda runs, tolerance: True, told)
