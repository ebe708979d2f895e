#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""K_TS of CD-14-100 by each model of the joint over torque, w and eccentricity, rings of the paper and ground ones.

Writes bench/results/joint_models.json. The contact law is hard: both models judge the same pressures. Usage: bench/joint_models.py
"""
import json
import tempfile
from pathlib import Path

from hdengine import Run

ROOT = Path(__file__).resolve().parents[1]
POINTS = [{"wave_generator.w": w} for w in (0.195e-3, 0.2e-3, 0.205e-3, 0.21e-3, 0.215e-3)] + [{"wave_generator.eccentricity": 1e-5}]


def main():
    rows = []
    for scene in ("cd14", "cd14_ground"):
        for torque in (1.0, 3.0, 5.0):
            for keys in POINTS:
                with tempfile.TemporaryDirectory() as folder:
                    every = {"load.torque": torque, "load.torque_steps": 2, "output.vtu": "none", **keys}
                    with Run(ROOT / f"data/{scene}.nml", Path(folder) / "out", **every) as run:
                        for _ in run:
                            pass
                    summary = json.loads((Path(folder) / "out/summary.json").read_text())
                models, results = summary["k_ts_by_model"], summary["results"]
                rows.append({"scene": scene, "torque_nm": torque, **keys, "eq45_hu2023": models["hu2023_nm_per_rad"],
                             "eq45_spectrum": models["spectrum_nm_per_rad"], "tangent_chosen": results["k_ts_tangent_nm_per_rad"],
                             "secant_chosen": results["k_ts_secant_nm_per_rad"], "slip_share_force": results["slip_share_force"]})
                print({k: v if isinstance(v, str) else float(f"{v:.4g}") for k, v in rows[-1].items()}, flush=True)
    (ROOT / "bench/results/joint_models.json").write_text(json.dumps({"script": "bench/joint_models.py", "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
