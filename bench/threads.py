#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wall clock of one scene over the number of threads, beside an earlier engine, and what 10^7 dof take.

Usage: bench/threads.py HDENGINE_X EARLIER_HDENGINE_X [SECONDS]; writes bench/results/threads.json. It needs nothing but Python, for a machine of many
cores, none of which is busy, may have nothing else. The earlier engine runs on one thread and on all. Runs that would begin later than SECONDS
from the start are left out.
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def press_fit(divisions, facets):
    """CD-14-100 with four layers of elements through wall and ring."""
    return "data/cd14.nml", f"mesh.divisions={divisions}", f"mesh.band_facets={facets}", "mesh.through_wall=4", "mesh.through_ring=4"


SCENES = {"drive14": ("data/drive14.nml",), "drive14, fine": ("data/drive14.nml", "mesh.divisions=188", "mesh.band_facets=26"),
          "CD-14-100": press_fit(344, 60), "CD-14-100, finest": press_fit(1088, 190)}
ALONE = "CD-14-100, finest"  # on all threads only
COUNTS = [n for n in (1, 2, 4, 8, 16, 32, 64) if n <= (os.cpu_count() or 1)]


def run(engine, which, scene, threads):
    """One run: its seconds by the wall clock and of the processor, and its memory."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.time()
        process = subprocess.Popen([engine, *SCENES[scene], "output.vtu=none", "--out", f"{folder}/r", "-q"], cwd=ROOT,
                                   env=os.environ | {"OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads)})
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.time() - start
        if status:
            raise SystemExit(f"{engine} {scene}: {os.waitstatus_to_exitcode(status)}")
        summary = json.loads(Path(folder, "r/summary.json").read_text())
    row = {"scene": scene, "engine": which, "threads": threads, "dof": summary["mesh"]["dof"], "wall_s": float(f"{wall:.3g}"),
           "cpu_s": float(f"{usage.ru_utime + usage.ru_stime:.3g}"), "memory_mb": round(usage.ru_maxrss / 1024)}
    print(row, summary["timers_s"], file=sys.stderr, flush=True)
    return row


def main(now, earlier, seconds="3600"):
    """Measure."""
    start = time.time()
    cases = [("now", scene, n) for scene in SCENES for n in (COUNTS if scene != ALONE else COUNTS[-1:])]
    cases += [("before", scene, n) for scene in SCENES if scene != ALONE for n in sorted({COUNTS[0], COUNTS[-1]})]
    rows = [run({"now": now, "before": earlier}[which], which, scene, n) for which, scene, n in cases if time.time() - start < float(seconds)]
    processor = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())[0]
    version = subprocess.run([now, "--version"], capture_output=True, text=True).stdout.split()[1]
    origin = {"script": "threads.py", "commit": version.rpartition("+")[2], "machine": f"{processor}, {os.cpu_count()} cores",
              "versions": {"hdengine": version}, "threads": COUNTS[-1], "seconds": round(time.time() - start, 1)}
    text = json.dumps({"provenance": origin, "rows": rows}, indent=1)
    (ROOT / "bench/results/threads.json").write_text(re.sub(r"\n\s+(?=[\"}])", " ", text) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
