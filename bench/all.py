#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every benchmark by name: what it measures, with which arguments. Called by `./hd bench`, which then writes the tables of the pages.

Usage: bench/all.py [--quick] [--list] [NAME ...]
Without names all of them run, one after the other. `--quick` takes those that show every method in ten minutes; their records go to build/bench, and no page changes. `--list` only tells.
"""
import argparse
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from common import ROOT, table

HERE = Path(__file__).parent


@dataclass
class Bench:
    """One script: arguments of the full and of the quick call, roughly how many minutes it takes."""

    script: str
    what: str
    minutes: float
    full: tuple = ()
    quick: tuple = None    # None: not in the quick set

    @property
    def name(self):
        """Its name on the command line."""
        return "court" if self.script == "../court/run.py" else Path(self.script).stem


BENCHES = (
    Bench("pareto.py", "error over time of every family of methods", 10, quick=("--quick",)),
    Bench("stability.py", "right, refused, slow, wrong over hard parameters", 18, quick=("--quick",)),
    Bench("../court/run.py", "problems with published answers", 1, quick=()),
    Bench("elements.py", "elements beside CalculiX", 1, quick=("--quick",)),
    Bench("height_peers.py", "heights beside FINUFFT and BLAS", 5),
    Bench("peer_hub.py", "the press-fit scene beside CalculiX", 6),
    Bench("peer_drive.py", "a small whole drive beside CalculiX", 5),
    Bench("solver_choice.py", "matrix solvers: time and memory beside their predictions", 3, quick=("--quick",)),
    Bench("threads.py", "wall clock over the number of threads, beside an engine named", 6, quick=()),
    Bench("gradient.py", "parts of a loop's time, and what a gradient costs", 1, quick=()),
    Bench("readings.py", "K_TS in every reading, over mesh, friction, joint, steps", 6),
    Bench("random_runs.py", "random scenes and drives: converged or refused", 40, quick=("scenes", "--count", "60")),
    Bench("promised.py", "planned tolerances kept or not", 90, full=("scenes", "--seed", "2717", "--count", "200", "--seconds", "5400")),
    Bench("paper_comparison.py", "the paper's trends, premise by premise", 4),
    Bench("drive_catalogue.py", "the whole drives beside the catalogue", 4),
    Bench("sensitivity.py", "Sobol indices of the tangent", 15),
    Bench("joint_law.py", "the joint law beside boundary elements", 25),
    Bench("joint_shear.py", "shear with friction beside the law", 10),
    Bench("joint_measured.py", "measured joints beside the law", 0.1, quick=()),
    Bench("blind_fit.py", "the fit told nothing, on maps not ours", 30),
)


def known():
    """Benchmarks by their name on the command line."""
    return {b.name: b for b in BENCHES}


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    for option in ("quick", "list"):
        parser.add_argument(f"--{option}", action="store_true")
    options = parser.parse_args()
    for name in options.names:
        if name not in known():
            parser.error(f"no benchmark '{name}'; valid: {', '.join(known())}")
    if options.list:
        print(table(("benchmark", "what it measures", "minutes"), [(b.name, b.what, f"{b.minutes:g}") for b in BENCHES]))
        return
    kept = ROOT / "build/bench"
    kept.mkdir(parents=True, exist_ok=True)
    environment = os.environ | ({"HDENGINE_BENCH": str(kept)} if options.quick else {})
    failed = []
    for name, bench in known().items():
        if (options.names and name not in options.names) or (options.quick and not options.names and bench.quick is None):
            continue
        words = bench.quick if options.quick and bench.quick is not None else bench.full
        print(f"{name}: {bench.what}", flush=True)
        start = time.time()
        done = subprocess.run([sys.executable, HERE / bench.script, *words], cwd=ROOT, env=environment, stdout=subprocess.DEVNULL)
        print(f"{name}: {'done' if done.returncode == 0 else 'FAILED'} in {time.time() - start:.0f} s", flush=True)
        failed += [name] if done.returncode else []
    if not options.quick:
        subprocess.run([sys.executable, HERE / "tables.py"], cwd=ROOT)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
