#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small against large displacements of whole drives: K1, K2, K3, hysteresis and the moment on the cam over w and wave generators.

Usage: bench/drive_kinematics.py; writes bench/results/drive_kinematics.json.
"""
from common import solve, write_record

COARSE = {"mesh.divisions": 48, "mesh.band_facets": 8}
EVEN = {"bearing.balls": 0, "wave_generator.ball_stiffness": 2.9e8}
CASES = (
    ("size 14, w 0.1 mm", "drive14.nml", COARSE | {"wave_generator.w": 1e-4}),
    ("size 14, w 0.2 mm", "drive14.nml", COARSE),
    ("size 14, w 0.3 mm", "drive14.nml", COARSE | {"wave_generator.w": 3e-4}),
    ("even spring", "drive14.nml", COARSE | EVEN),
    ("rigid", "drive14.nml", COARSE | {"bearing.balls": 0}),
    ("wall 0.25 mm", "drive14.nml", COARSE | {"geometry.wall_thickness": 0.25e-3}),
    ("size 20", "drive20.nml", COARSE),
    ("size 40", "drive40.nml", COARSE),
    ("size 14, its own mesh", "drive14.nml", {}))
NAMES = ("k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad", "hysteresis_rad", "wave_generator_torque_nm", "von_mises_max_pa",
         "loop_work_j", "loop_stored_j", "loop_dissipated_j", "torque_balance_nm")


def main():
    """Solve both kinematics of all cases."""
    rows = []
    for name, scene, keys in CASES:
        row = {"case": name, "keys": keys}
        for kinematics in ("linear", "nonlinear"):
            summary, done = solve(scene, *(f"{k}={v}" for k, v in keys.items()), f"solver.kinematics={kinematics}")
            if done.code != 0:
                raise SystemExit(done.text)
            row[kinematics] = {n: summary["results"][n] for n in NAMES}
            row[kinematics]["cpu_s"] = done.cpu_s
        rows.append(row)
        print(name, ", ".join(f"{100 * (row['nonlinear'][n] / row['linear'][n] - 1):+.1f} %" for n in NAMES[:4]), flush=True)
    write_record("drive_kinematics", rows, threads=1)


if __name__ == "__main__":
    main()
