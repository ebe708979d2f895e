# SPDX-License-Identifier: GPL-3.0-or-later
"""A stopped run goes on as if it had never stopped, with its own scene only."""
import csv
import json

import pytest

import hdengine
from conftest import ROOT, call

CD14 = ROOT / "data/cd14.nml"
SMALL = {"mesh__divisions": 20, "mesh__band_facets": 4}
WORDS = ["mesh.divisions=20", "mesh.band_facets=4"]


def rows(path):
    """Rows of a table without its clock."""
    with open(path) as f:
        return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(f)]


def stopped_run(folder, steps, **keys):
    """A run left after some load steps, in a process that remembers no other."""
    hdengine.forget()
    with hdengine.Run(CD14, folder, **SMALL, **keys) as run:
        for _ in range(steps):
            run.advance()


@pytest.mark.parametrize("steps", [1, 3, 6])
@pytest.mark.parametrize("keys", [{}, {"solver__method": "newton"}, {"contact__law": "joint"}, {"solver__kinematics": "nonlinear"}])
def test_resumed_equals_uninterrupted(exe, tmp_path, steps, keys):
    """Left after a step of the assembly or of the torque, every table ends equal to the bit."""
    words = WORDS + [f"{k.replace('__', '.')}={v}" for k, v in keys.items()]
    assert call(exe, CD14, *words, "--out", tmp_path / "whole").returncode == 0
    stopped_run(tmp_path / "cut", steps, **keys)
    with open(tmp_path / "cut/contact.csv", "a") as f:
        f.write("half a row")  # as a killed process leaves it
    done = call(exe, CD14, *words, "--out", tmp_path / "cut", "--resume")
    assert done.returncode == 0, done.stderr
    for table in ("contact", "steps", "history"):
        assert rows(tmp_path / f"cut/{table}.csv") == rows(tmp_path / f"whole/{table}.csv"), table
    a, b = (json.loads((tmp_path / x / "summary.json").read_text()) for x in ("whole", "cut"))
    assert a["results"] == b["results"] and b["status"] == "complete" and b["model"]["resumed"]
    assert not (tmp_path / "cut/checkpoint.bin").exists()


def test_only_the_same_scene_goes_on(exe, tmp_path):
    """Another torque is an error that names both values, and the folder stays as it was; a longer time limit is taken."""
    stopped_run(tmp_path / "r", 2)
    before = {p.name: p.read_bytes() for p in (tmp_path / "r").iterdir()}
    done = call(exe, CD14, *WORDS, "load.torque=4", "--out", tmp_path / "r", "--resume")
    assert done.returncode == 2 and "load.torque = 4.0" in done.stderr and "began with 5.0" in done.stderr
    assert before == {p.name: p.read_bytes() for p in (tmp_path / "r").iterdir()}
    done = call(exe, CD14, *WORDS, "solver.time_limit_s=600", "--out", tmp_path / "r", "--resume")
    assert done.returncode == 0, done.stderr
    done = call(exe, CD14, *WORDS, "--out", tmp_path / "r", "--resume")
    assert done.returncode == 0 and "is complete" in done.stdout
    with pytest.raises(hdengine.InputError, match="is complete"):
        hdengine.Run(CD14, tmp_path / "r", resume=True, **SMALL)


def test_broken_checkpoint_or_table_is_named(exe, tmp_path):
    """A checkpoint cut short and a table that lost rows are errors of code 3; --resume without a run begins one."""
    stopped_run(tmp_path / "r", 2)
    whole = (tmp_path / "r/checkpoint.bin").read_bytes()
    (tmp_path / "r/checkpoint.bin").write_bytes(whole[:5000])
    done = call(exe, CD14, *WORDS, "--out", tmp_path / "r", "--resume")
    assert done.returncode == 3 and "checkpoint.bin" in done.stderr
    (tmp_path / "r/checkpoint.bin").write_bytes(whole)
    (tmp_path / "r/contact.csv").write_text("step\n")
    done = call(exe, CD14, *WORDS, "--out", tmp_path / "r", "--resume")
    assert done.returncode == 3 and "contact.csv" in done.stderr
    done = call(exe, CD14, *WORDS, "--out", tmp_path / "new", "--resume")
    assert done.returncode == 0, done.stderr
    done = call(exe, CD14, *WORDS, "--force", "--resume")
    assert done.returncode == 2 and "--force" in done.stderr
