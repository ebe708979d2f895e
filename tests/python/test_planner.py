# SPDX-License-Identifier: GPL-3.0-or-later
"""A stated tolerance: the plan is printed, the run says what it chose and how large its error is estimated."""
import json

import pytest

import hdengine

from conftest import ROOT, call

CD14 = ROOT / "data/cd14.nml"


def test_a_run_meets_its_tolerance(exe, tmp_path):
    """run.tolerance = 0.2: mesh and load steps are chosen, the estimate is within it and stands in the summary."""
    done = call(exe, CD14, "run.tolerance=0.2", "output.vtu=none", "--out", tmp_path / "p")
    assert done.returncode == 0, done.stderr
    s = json.loads((tmp_path / "p/summary.json").read_text())
    assert s["status"] == "complete" and s["plan"]["met"] == "yes"
    assert max(v for k, v in s["plan"].items() if k.startswith("estimated")) <= 0.2
    assert "load steps" in done.stdout and "estimated error" in done.stdout
    assert s["scene"]["mesh.band_facets"] <= 16


def test_plan_is_printed_and_nothing_is_solved(exe, tmp_path):
    """--plan: one line per mesh with dof, time and memory; without a tolerance code 2."""
    done = call(exe, "--plan", CD14, "run.tolerance=0.03", cwd=tmp_path)
    assert done.returncode == 0 and "<- start" in done.stdout and not list(tmp_path.iterdir())
    done = call(exe, "--plan", CD14)
    assert done.returncode == 2 and "run.tolerance" in done.stderr


def test_python_plans_as_the_program_does(exe, tmp_path):
    """run.tolerance through the bindings: the same mesh, estimate and force as hdengine.x."""
    call(exe, CD14, "run.tolerance=0.3", "output.vtu=none", "--out", tmp_path / "x")
    one = json.loads((tmp_path / "x/summary.json").read_text())
    two = hdengine.run(CD14, out=tmp_path / "p", run__tolerance=0.3, output__vtu="none").summary
    assert one["plan"]["met"] == two["plan"]["met"] == "yes"
    assert one["scene"]["mesh.divisions"] == two["scene"]["mesh.divisions"]
    assert two["results"]["normal_force_n"] == pytest.approx(one["results"]["normal_force_n"], rel=1e-9)


def test_kinematics_are_chosen(exe, tmp_path):
    """kinematics = auto: large displacements, which change this scene by some 7 %, are left out at tolerance 0.5 only."""
    done = call(exe, CD14, "run.tolerance=0.5", "solver.kinematics=auto", "wave_generator.w=5e-5", "output.vtu=none", "--out",
                tmp_path / "p")
    assert done.returncode == 0, done.stderr
    assert "plan      kinematics linear" in done.stdout
    assert json.loads((tmp_path / "p/summary.json").read_text())["scene"]["solver.kinematics"] == "linear"
