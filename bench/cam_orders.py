#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What ellipse and cosine give in small and large displacements over w (scene of data/cd14.nml, 64 x 10 facets, ring held on the cam).

Usage: bench/cam_orders.py; writes bench/results/cam_orders.json, prints Markdown.
"""
import hdengine
from common import ROOT, write_record

KEYS = ("normal_force_n", "contact_area_m2", "pressure_max_pa", "pressure_mid_mean_pa", "rotation_rad")


def main():
    rows = []
    for w in (1e-4, 2e-4, 3e-4):
        for cam in ("ellipse", "cosine"):
            for kinematics in ("linear", "nonlinear"):
                with hdengine.Run(ROOT / "data/cd14.nml", mesh={"divisions": 64, "band_facets": 10}, wave_generator={"w": w, "cam": cam},
                                  solver={"kinematics": kinematics}, load={"torque_steps": 1}) as run:
                    sums = list(run)[-1].sums
                rows.append({"w_m": w, "cam": cam, "kinematics": kinematics} | {k: sums[k] for k in KEYS})
                r = rows[-1]
                print(f"| {1e3 * w:.1f} | {cam} | {kinematics} | {r['normal_force_n']:.0f} | {1e6 * r['contact_area_m2']:.0f} | "
                      f"{1e-6 * r['pressure_max_pa']:.1f} | {1e-6 * r['pressure_mid_mean_pa']:.3f} | {1e6 * r['rotation_rad']:.2f} |", flush=True)
    write_record("cam_orders", rows)


if __name__ == "__main__":
    main()
