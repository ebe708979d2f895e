# SPDX-License-Identifier: GPL-3.0-or-later
"""A stated tolerance: the plan is printed, the run says what it chose and how large its error is estimated."""
import json

import pytest

import hdengine

from conftest import ROOT, call

CD14 = ROOT / "data/cd14.nml"


def test_a_run_meets_its_tolerance(exe, tmp_path):
    """run.tolerance = 0.15: mesh and load steps are chosen, the estimate is within it and stands in the summary."""
    done = call(exe, CD14, "run.tolerance=0.15", "output.vtu=none", "--out", tmp_path / "p")
    assert done.returncode == 0, done.stderr
    s = json.loads((tmp_path / "p/summary.json").read_text())
    assert s["status"] == "complete" and s["plan"]["met"] == "yes"
    assert max(v for k, v in s["plan"].items() if k.startswith("estimated")) <= 0.15
    assert "load steps" in done.stdout and "estimated error" in done.stdout
    assert s["scene"]["mesh.band_facets"] < 15


def test_plan_is_printed_and_nothing_is_solved(exe, tmp_path):
    """--plan: one line per mesh with dof, time and memory; without a tolerance code 2."""
    done = call(exe, "--plan", CD14, "run.tolerance=0.03", cwd=tmp_path)
    assert done.returncode == 0 and "<- start" in done.stdout and not list(tmp_path.iterdir())
    done = call(exe, "--plan", CD14)
    assert done.returncode == 2 and "run.tolerance" in done.stderr


def test_python_names_a_tolerance_that_it_cannot_plan(tmp_path):
    """Through the bindings a tolerance is an error: no caller takes an unplanned mesh for a promised one."""
    with pytest.raises(hdengine.InputError, match="run.tolerance"):
        hdengine.run(CD14, out=tmp_path / "r", run__tolerance=0.1)
