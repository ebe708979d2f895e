# SPDX-License-Identifier: GPL-3.0-or-later
"""What the engine takes, in instructions: a loss of 1.3 in any of eleven small runs fails.

valgrind's cachegrind counts the instructions. The count is the same on a busy and on an idle machine; it says nothing of memory traffic, of
waiting and of threads. valgrind shows the engine a processor without AVX-512, and OPENBLAS_CORETYPE pins BLAS to AVX without FMA, which valgrind
computes in software, so that processors agree. One process runs all cases: what valgrind translates for one it has for the others.
`python tests/python/test_regressions.py` writes the counts to tests/cases/instructions.json.
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from conftest import ROOT

RECORD = ROOT / "tests/cases/instructions.json"
SMALL = ("mesh.divisions=24", "mesh.band_facets=4", "load.assembly_steps=1", "load.torque_steps=1", "output.vtu=none", "joint.model=hu2023",
         "joint.spectrum_file=none")  # no file: the comparison of joint models, a third of such a run, leaves Persson's theory out
LESS = ("mesh.divisions=16", "mesh.band_facets=3")
LEAST = ("mesh.divisions=12", "mesh.band_facets=2")
CASES = {  # name: what it holds, scene, keys
    "factors": ("Newton matrix, LU of each step", "cd14.nml", (*SMALL, "solver.method=newton", "solver.factors=exact", *LEAST, "mesh.divisions=8")),
    "harmonic": ("Newton matrix, round bodies by harmonics", "cd14.nml", (*SMALL, "solver.method=newton", "solver.factors=harmonic", *LESS)),
    "large": ("large displacements", "cd14.nml", (*SMALL, "solver.kinematics=nonlinear", *LEAST, "mesh.divisions=8")),
    "quadratic": ("quadratic elements", "cd14.nml", (*SMALL, "mesh.element=hex20r", *LEAST)),
    "joint": ("contact condensed by harmonics, rough joint as contact law", "cd14.nml", (*SMALL, "contact.law=joint")),
    "apart": ("non-matching meshes, mortar segments", "cd14.nml", (*SMALL, *LESS, "mesh.ring_divisions=20", "mesh.ring_facets=4")),
    "drive": ("whole drive, loop of three torques", "../tests/cases/pressed_drive.nml", (*SMALL, "loop.torques=14, 0, -14", *LEAST)),
    "teeth": ("bonded ring against teeth", "teeth.nml", (*SMALL, *LEAST)),
    "product": ("heights by matrix products; fit of ridges", "surface.nml", ("surface.nx=96", "surface.ny=96")),
    "transform": ("heights by the NUFFT", "surface.nml", ("surface.nx=256", "surface.ny=256", "surface.ridges=200", "surface.method=nufft",
                                                         "surface.tolerance=1e-6", "fit.model=none")),
    "map": ("blind fit of a map of 32 x 32 points", "surface.nml", ("fit.first_file=map.npy", "fit.dx=1e-6")),
}
LOSS = 1.3


def rough_map(n=32, slope=-3.5):
    """Heights [m] of n x n points whose power spectrum falls with the given power; the same in every call."""
    q = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n))
    q[0, 0] = np.inf
    return 1e-8 * np.fft.irfft2(q**(slope / 2) * np.exp(2j * np.pi * np.random.default_rng(1).random(q.shape)), (n, n))


RUN = """
import json, os, sys
import hdengine
from hdengine.contact import given_keys

def mark():  # a fork that ends at once leaves a log of what the process took until then
    child = os.fork() or os._exit(0)
    os.waitpid(child, 0)
    return child

marks = [mark()]
for scene, keys in json.loads(sys.argv[1]):
    if os.path.basename(scene) == "surface.nml":
        hdengine.run_surface(scene, "out", True, **given_keys(keys))
    else:
        with hdengine.Run(scene, "out", True, **given_keys(keys)) as run:
            for _ in run:
                pass
    hdengine.forget()
    marks.append(mark())
print(json.dumps(marks))
"""


def counts():
    """Instructions by name, an integer each, of the cases one after the other."""
    with tempfile.TemporaryDirectory() as folder:
        np.save(Path(folder, "map.npy"), rough_map())
        done = subprocess.run(
            ["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null", "--log-file=%p.log", sys.executable, "-c", RUN,
             json.dumps([(str(ROOT / "data" / scene), keys) for _, scene, keys in CASES.values()])], cwd=folder, capture_output=True, text=True,
            env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OPENBLAS_CORETYPE": "Sandybridge", "PYTHONHASHSEED": "0"})
        if done.returncode:
            raise RuntimeError(done.stderr)
        logs = [Path(folder, f"{child}.log").read_text() for child in json.loads(done.stdout)]
    until = [int(re.search(r"I\s+refs:\s+([\d,]+)", log)[1].replace(",", "")) for log in logs]
    return dict(zip(CASES, np.diff(until).tolist(), strict=True))


def losses(found, record):
    """Cases above `LOSS` times their record: name and ratio."""
    return {name: found[name] / record[name] for name in found if found[name] > LOSS * record.get(name, np.inf)}


@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind is not installed")
def test_no_run_takes_more_than_its_record_allows():
    """Every case has a record, and none takes 1.3 times its recorded instructions or more."""
    record = json.loads(RECORD.read_text())
    assert set(record) == set(CASES)
    assert losses(counts(), record) == {}


def test_a_loss_is_seen():
    """A case above 1.3 times its record is named with its ratio; one below, or without a record, is not."""
    assert losses({"a": 14, "b": 12, "c": 5}, {"a": 10, "b": 10}) == {"a": 1.4}


if __name__ == "__main__":
    RECORD.write_text(json.dumps(counts(), indent=1) + "\n")
