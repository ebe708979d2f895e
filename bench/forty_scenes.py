#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Forty scenes of torque x eccentricity x w (Fig. 11-13) of data/cd14.nml in one process, on kept factors.

Every scene is an assembly and a torque ramp; the assembly is solved once for the torques that share it. Usage: bench/forty_scenes.py; writes bench/results/forty_scenes.json.
"""
import itertools
import resource
import sys
import time

import hdengine  # noqa: E402
from common import ROOT, write_record

TORQUES, ECCENTRICITIES = (1.0, 2.0, 3.0, 4.0, 5.0), (0.0, 5e-6, 10e-6)
DEFORMATIONS = (0.195e-3, 0.200e-3, 0.205e-3, 0.210e-3, 0.215e-3)


def main():
    points = [(t, e, 0.2e-3) for e, t in itertools.product(ECCENTRICITIES, TORQUES)]
    points += [(t, 0.0, w) for w, t in itertools.product(DEFORMATIONS, TORQUES)]
    rows = []
    hdengine.forget()
    start, cpu = time.time(), time.process_time()
    for torque, eccentricity, w in points:
        before = time.time()
        with hdengine.Run(ROOT / "data/cd14.nml", load__torque=torque, wave_generator__eccentricity=eccentricity,
                          wave_generator__w=w, solver__symmetry=sys.argv[1] if len(sys.argv) > 1 else "auto") as run:
            for step in run:
                pass
            dof, facets = run.dof, run.facets
        rows.append({"torque_nm": torque, "eccentricity_m": eccentricity, "w_m": w, "k_ts_nm_per_rad": step.k_ts_nm_per_rad,
                     "rotation_rad": step.sums["rotation_rad"], "seconds": time.time() - before})
    record = {"scenes": len(rows), "dof": dof, "facets": facets, "wall_s": time.time() - start,
              "cpu_s": time.process_time() - cpu, "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
              "rows": rows}
    write_record("forty_scenes", record)
    print(f"{len(rows)} scenes of {dof} dof, {facets} facets: {record['wall_s']:.1f} s wall, {record['cpu_s']:.1f} s CPU, "
          f"{record['peak_memory_mb']:.0f} MB; slowest {max(r['seconds'] for r in rows):.2f} s")


if __name__ == "__main__":
    main()
