#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Instructions of a dozen small runs against the last record: a loss of 1.3 in any of them fails.

Usage: bench/regressions.py [--record] [NAME ...]

valgrind's cachegrind counts the instructions of the engine. The count is the same on a busy and on an idle machine; it says nothing
of memory traffic, of waiting and of threads. valgrind shows the engine a processor without AVX-512, and OPENBLAS_CORETYPE pins
BLAS to AVX2, so that processors with AVX2 agree. `--record` appends a line to results/regressions.jsonl; without it the counts are
held against the last line, and the command ends with code 1 where one of them is above 1.3 times its record.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from datetime import date
from pathlib import Path

import numpy as np

from common import DATA, ONE_THREAD, add_row, program, put, read_rows, table

SMALL = ("mesh.divisions=24", "mesh.band_facets=4", "load.assembly_steps=1", "load.torque_steps=1", "output.vtu=none")
LESS = ("mesh.divisions=16", "mesh.band_facets=3")
CASES = {  # name: what it holds, scene, keys
    "condensed": ("contact condensed by harmonics", "cd14.nml", (*SMALL, "mesh.divisions=48", "mesh.band_facets=8")),
    "schur": ("contact condensed by Schur complement", "cd14.nml", (*SMALL, "solver.method=schur")),
    "factors": ("Newton matrix, LU of each step", "cd14.nml", (*SMALL, "solver.method=newton", "solver.factors=exact", *LESS)),
    "harmonic": ("Newton matrix, round bodies by harmonics", "cd14.nml", (*SMALL, "solver.method=newton", "solver.factors=harmonic")),
    "large": ("large displacements", "cd14.nml", (*SMALL, "solver.kinematics=nonlinear", *LESS)),
    "quadratic": ("quadratic elements", "cd14.nml", (*SMALL, "mesh.element=hex20r")),
    "joint": ("rough joint as contact law", "cd14.nml", (*SMALL, "contact.law=joint")),
    "apart": ("non-matching meshes, mortar segments", "cd14.nml", (*SMALL, "mesh.ring_divisions=30", "mesh.ring_facets=5")),
    "drive": ("whole drive, loop of three torques", "drive14.nml", (*SMALL, "loop.torques=14, 0, -14")),
    "teeth": ("bonded ring against teeth", "teeth.nml", (*SMALL,)),
    "product": ("heights, same bits on every processor; fit of ridges", "surface.nml", ("surface.nx=192", "surface.ny=192")),
    "transform": ("heights by the NUFFT", "surface.nml", ("surface.nx=256", "surface.ny=256", "surface.ridges=200", "surface.method=nufft",
                                                         "surface.tolerance=1e-6", "fit.model=none")),
    "map": ("blind fit of a map of 64 x 64 points", "surface.nml", ("fit.first_file=map.npy", "fit.dx=1e-6")),
}
LOSS = 1.3


def rough_map(n=64, slope=-3.5):
    """Heights [m] of n x n points whose power spectrum falls with the given power; the same in every call."""
    q = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n))
    q[0, 0] = np.inf
    return 1e-8 * np.fft.irfft2(q**(slope / 2) * np.exp(2j * np.pi * np.random.default_rng(1).random(q.shape)), (n, n))


def count(name):
    """Instructions of one case.

    Parameters
    ----------
    name : str
        Of `CASES`.

    Returns
    -------
    int
    """
    _, scene, keys = CASES[name]
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder, "valgrind.log")
        np.save(Path(folder, "map.npy"), rough_map())
        done = subprocess.run(
            ["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null", f"--log-file={log}",
             program("hdengine.x"), DATA / scene, *keys, "--out", "out", "-q"], cwd=folder, capture_output=True, text=True,
            env=os.environ | ONE_THREAD | {"OMP_WAIT_POLICY": "passive", "OPENBLAS_CORETYPE": "Haswell"})  # passive: no second start of the program
        if done.returncode:
            raise RuntimeError(f"{name}: {done.stderr.strip() or log.read_text()}")
        return int(re.search(r"I\s+refs:\s+([\d,]+)", log.read_text())[1].replace(",", ""))


def counts(names=CASES):
    """Instructions by name, two cases at a time."""
    with ThreadPoolExecutor(2) as pool:
        return dict(zip(names, pool.map(count, names)))


def last_record():
    """Instructions of the last record, by name; empty without one."""
    return next(reversed(read_rows("regressions", "date").values()), {}).get("instructions", {})


def losses(found, record):
    """Cases above `LOSS` times their record: name and ratio."""
    return {name: found[name] / record[name] for name in found if name in record and found[name] > LOSS * record[name]}


def page_table():
    """The recorded history: a row per case, a column per record."""
    rows = list(read_rows("regressions", "date").values())
    return table(["case", "what it holds", *(f"{row['date']}, 10⁶ instructions" for row in rows)],
                 [[name, CASES[name][0], *(f"{row['instructions'].get(name, 0) / 1e6:.0f}" for row in rows)] for name in CASES])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", default=list(CASES))
    parser.add_argument("--record", action="store_true", help="append the counts to results/regressions.jsonl")
    arguments = parser.parse_args()
    found, record = counts(arguments.names), last_record()
    print(table(["case", "10^6 instructions", "over the record"],
                [[n, f"{c / 1e6:.0f}", f"{c / record[n]:.3f}" if n in record else ""] for n, c in found.items()]))
    lost = losses(found, record)
    if arguments.record:
        add_row("regressions", {"date": date.today().isoformat(), "instructions": {**record, **found}})
        put("regressions", page_table(), "evidence/regressions")
        return
    if lost:
        sys.exit("slower than recorded: " + ", ".join(f"{name} {ratio:.2f} times" for name, ratio in lost.items()))


if __name__ == "__main__":
    main()
