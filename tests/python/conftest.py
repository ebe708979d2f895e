# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths and helpers shared by the tests."""
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import hdengine_x

os.environ["PATH"] += f"{os.pathsep}{Path(sys.executable).parent}"  # hdengine.x becomes `hdengine` for a study
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # the scenes are small: more threads only wait for each other; tests of threads say how many

for _name in (signal.SIGINT, signal.SIGHUP):  # a shell ignores them for what it starts in the background, and so would the runs of the tests
    if signal.getsignal(_name) == signal.SIG_IGN:
        signal.signal(_name, signal.SIG_DFL)

ROOT = Path(__file__).resolve().parents[2]
CD14, PAPER = ROOT / "data/cd14.nml", ROOT / "data/paper.nml"
HELD = {"load__support": "hub", "wave_generator__ring_tangent": "auto"}  # what makes PAPER CD14 with the paper's joint
SMALL = ["mesh.divisions=24", "mesh.band_facets=4", "load.torque_steps=2", "load.assembly_steps=1"]


def pytest_configure(config):
    """Known warnings of the joint are not news; named here because pytest imports the package for it, after the line above."""
    config.addinivalue_line("filterwarnings", "ignore::hdengine.JointWarning")


def executable():
    """hdengine.x of the installed package, or what HDENGINE_EXE names (./hd coverage)."""
    return os.environ.get("HDENGINE_EXE") or hdengine_x.PROGRAM


@pytest.fixture(scope="session")
def exe():
    return executable()


def call(exe, *args, **options):
    """Run hdengine.x and return the finished process."""
    return subprocess.run([exe, *map(str, args)], capture_output=True, text=True, **{"timeout": 600} | options)


def solved(exe, out, scene, *words):
    """Result of a scene that ends well, in a folder whose earlier results it replaces."""
    done = call(exe, scene, *words, "--out", out, "--force", "-q")
    assert done.returncode == 0, done.stderr
    import hdengine  # after the variables above
    return hdengine.load(out)


def solve_small(exe, out, *words):
    """Result of CD-14-100 on a small mesh."""
    return solved(exe, out, CD14, *SMALL, *words)


def stopped_and_whole(exe, keys, rows, tmp_path):
    """Folders of the loop of size 14, one stopped by a signal after so many load steps and resumed: the same tables, to the byte."""
    folder, whole = tmp_path / "stopped", tmp_path / "whole"
    process = subprocess.Popen([exe, ROOT / "tests/cases/pressed_drive.nml", *keys, "--out", folder, "-q"], stderr=subprocess.DEVNULL)
    while not (folder / "loop.csv").exists() or (folder / "loop.csv").read_bytes().count(b"\n") < 1 + rows:
        assert process.poll() is None
        time.sleep(0.001)
    process.send_signal(signal.SIGTERM)
    assert process.wait() == 7
    for out, more in ((folder, ["--resume"]), (whole, [])):
        done = call(exe, ROOT / "tests/cases/pressed_drive.nml", *keys, "--out", out, "-q", *more)
        assert done.returncode == 0, done.stderr
    for name in ("loop.csv", "balls.csv", "teeth.csv", "fatigue.csv"):
        assert (folder / name).read_bytes() == (whole / name).read_bytes(), name
    return folder, whole


@pytest.fixture(scope="session")
def small_run(exe, tmp_path_factory):
    """Folder of a small finished run of the default scene."""
    return solve_small(exe, tmp_path_factory.mktemp("runs") / "small.out", "output.vtu=all").folder
