#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Do the workers of a study share the cores? Wall and CPU seconds of one study with two workers under different settings of the threads.

Usage: bench/worker_threads.py [turns]
Eight scenes of 160 x 24 facets; the settings take turns. Record: worker_threads.json, table in docs/evidence/robustness.md.
"""
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from common import program, put, table, write_record

STUDY = """[study]
scene = "{root}/data/cd14.nml"
[fixed]
mesh.divisions = 160
mesh.band_facets = 24
load.torque_steps = 1
output.vtu = "none"
[grid]
load.torque = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
"""
SETTINGS = {
    "as installed (nothing set)": {},
    "OMP_NUM_THREADS=1": {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    "two threads a worker, waiting actively": {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2", "OMP_WAIT_POLICY": "active"},
}


def timed(study, folder, variables):
    """Wall and CPU seconds of the study."""
    shutil.rmtree(folder, ignore_errors=True)
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("OMP_", "OPENBLAS_"))}
    before, start = os.times(), time.perf_counter()
    subprocess.run([program("hdengine"), "study", study, "--jobs", "2", "--out", folder], env=clean | variables, check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = os.times()
    return time.perf_counter() - start, after.children_user + after.children_system - before.children_user - before.children_system


def main():
    """Command line."""
    turns = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    found = {name: [] for name in SETTINGS}
    with tempfile.TemporaryDirectory() as work:
        study = Path(work) / "s.toml"
        study.write_text(STUDY.format(root=Path(__file__).resolve().parents[1]))
        for _ in range(turns):
            for name, variables in SETTINGS.items():
                found[name].append(timed(study, Path(work) / "out", variables))
    rows = [{"setting": name, "wall_s": [round(w, 2) for w, _ in seconds], "cpu_s": [round(c, 2) for _, c in seconds]}
            for name, seconds in found.items()]
    for row in rows:
        print(f"{row['setting']:42} wall {median(row['wall_s']):6.1f} s   CPU {median(row['cpu_s']):6.1f} s")
    write_record("worker_threads", rows, threads="as stated")
    put("workers", table(("threads", "wall s", "CPU s"), [(f"{r['setting']}", f"{median(r['wall_s']):.1f}", f"{median(r['cpu_s']):.1f}")
                                                          for r in rows]), "evidence/robustness")


if __name__ == "__main__":
    main()
