#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wall clock of a scene over the number of threads, beside an earlier engine, and what 10^7 dof take.

Usage: bench/threads.py [HDENGINE_X [EARLIER_HDENGINE_X]]; writes bench/results/threads.json. With programs named it needs Python alone, for a
machine of many idle cores may have nothing else. The earlier engine runs on one thread and on all.
"""
import importlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COUNTS = [n for n in (1, 2, 4, 8, 16, 32, 64) if n <= (os.cpu_count() or 1)]
PRESS = "data/cd14.nml mesh.through_wall=4 mesh.through_ring=4"
SCENES = {"drive14": "data/drive14.nml", "drive14, fine": "data/drive14.nml mesh.divisions=188 mesh.band_facets=26",
          "CD-14-100": f"{PRESS} mesh.divisions=344 mesh.band_facets=60",
          "CD-14-100, finest": f"{PRESS} mesh.divisions=1088 mesh.band_facets=190 output.contact=last"}  # on all threads only


def run(engine, which, scene, threads):
    """One run: its seconds by the wall clock and of the processor, and its memory."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.time()
        command, count = [engine, *SCENES[scene].split(), "output.vtu=none", "run.band=.false.", "--out", f"{folder}/r", "-q"], str(threads)
        process = subprocess.Popen(command, cwd=ROOT, env=os.environ | {"OMP_NUM_THREADS": count, "OPENBLAS_NUM_THREADS": count})
        (_, status, usage), wall = os.wait4(process.pid, 0), time.time() - start
        if status:
            raise SystemExit(f"{engine} {scene}: {os.waitstatus_to_exitcode(status)}")
        summary = json.loads(Path(folder, "r/summary.json").read_text())
    print(which, scene, threads, f"{wall:.2f} s", summary["timers_s"], file=sys.stderr, flush=True)
    return {"scene": scene, "engine": which, "threads": threads, "dof": summary["model"]["dof"], "wall_s": float(f"{wall:.3g}"),
            "cpu_s": float(f"{usage.ru_utime + usage.ru_stime:.3g}"), "memory_mb": round(usage.ru_maxrss / 1024)}


def main(now=None, earlier=None):
    """Measure."""
    now = now or importlib.import_module("hdengine_x").PROGRAM
    cases = [("now", scene, n) for scene in SCENES for n in (COUNTS if "finest" not in scene else COUNTS[-1:])]
    cases += [("before", scene, n) for scene in SCENES if "finest" not in scene and earlier for n in (1, COUNTS[-1])]
    rows = [run({"now": now, "before": earlier}[which], which, scene, n) for which, scene, n in cases]
    processor, *_ = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    version = subprocess.run([now, "--version"], capture_output=True, text=True).stdout.split()[1]
    origin = {"script": "threads.py", "commit": version.rpartition("+g")[2], "machine": f"{processor}, {os.cpu_count()} cores",
              "versions": {"hdengine": version}, "threads": COUNTS[-1], "seconds": round(sum(r["wall_s"] for r in rows), 1)}
    (ROOT / "bench/results/threads.json").write_text(re.sub(r"\n\s{3}\s*|\n  (?=})", " ", json.dumps({"provenance": origin, "rows": rows}, indent=1)) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
