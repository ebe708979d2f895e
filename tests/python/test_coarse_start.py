# SPDX-License-Identifier: GPL-3.0-or-later
"""First guesses from a coarser mesh: fewer iterations, the same solution."""
import json
from pathlib import Path

import pytest

import hdengine

CD14 = Path(__file__).resolve().parents[2] / "data/cd14.nml"
STEPS = {"assembly_steps": 1, "torque_steps": 1}


def solve(folder, start, mesh, **groups):
    """Last step and summary of CD-14-100 on a mesh."""
    groups = {"load": STEPS, **groups}
    groups["solver"] = {"start": start, "tolerance": 1e-11, **groups.get("solver", {})}
    with hdengine.Run(CD14, out=folder, force=True, mesh=mesh, output={"vtu": "none"}, **groups) as run:
        for step in run:
            pass
    return step, json.loads((Path(folder) / "summary.json").read_text())


@pytest.mark.parametrize("mesh, groups", [
    ({"divisions": 48, "band_facets": 9}, {}),
    ({"divisions": 48, "band_facets": 9, "edge_length": 2e-4}, {"wave_generator": {"eccentricity": 1e-5}}),
    ({"divisions": 48, "band_facets": 9, "ring_divisions": 40, "ring_facets": 8}, {"contact": {"slave": "cup"}}),
    ({"divisions": 64, "band_facets": 12}, {"wave_generator": {"ring_contact": "unilateral"}}),
    ({"divisions": 48, "band_facets": 9}, {"solver": {"kinematics": "nonlinear"}}),
    ({"divisions": 48, "band_facets": 9}, {"contact": {"law": "joint"}}),
], ids=["plain", "edges", "unmatched", "unilateral", "nonlinear", "joint"])
def test_the_solution_is_that_from_rest(tmp_path, mesh, groups):
    """The start changes the way, not the end (with large displacements as far as pairs may be left from their places, 1e-5 of the
    radius); iterations are no more than from rest."""
    rest, slow = solve(tmp_path / "rest", "rest", mesh, **groups)
    near, fast = solve(tmp_path / "near", "coarser", mesh, **groups)
    loose = 1000 if "solver" in groups else 1
    assert near.k_ts_nm_per_rad == pytest.approx(rest.k_ts_nm_per_rad, rel=1e-7 * loose)
    assert near.sums["normal_force_n"] == pytest.approx(rest.sums["normal_force_n"], rel=1e-8 * loose)
    assert near.sums["rotation_rad"] == pytest.approx(rest.sums["rotation_rad"], rel=1e-6 * loose)
    assert fast["results"]["iterations"] <= slow["results"]["iterations"]
    assert "first_guesses" in fast["model"] and "first_guesses" not in slow["model"]


def test_a_drive_starts_from_a_coarser_mesh(tmp_path):
    """Balls and teeth included, the loop is that from rest, in fewer iterations."""
    def drive(start):
        with hdengine.Run(CD14.parents[1] / "tests/cases/pressed_drive.nml", out=tmp_path / start, mesh={"divisions": 64, "band_facets": 16},
                          load={"torque_steps": 1}, loop={"torques": [3.0, 0.0]}, output={"vtu": "none"},
                          solver={"start": start, "tolerance": 1e-11}) as run:
            for _ in run:
                pass
        return hdengine.load(tmp_path / start)

    rest, near = drive("rest"), drive("auto")
    assert near.loop["angle_rad"] == pytest.approx(rest.loop["angle_rad"], rel=1e-7)
    assert near.loop["ball_force_max_n"] == pytest.approx(rest.loop["ball_force_max_n"], rel=1e-7)
    assert near.loop["tooth_force_max_n"] == pytest.approx(rest.loop["tooth_force_max_n"], rel=1e-7)
    assert near.summary["results"]["iterations"] < rest.summary["results"]["iterations"]
    assert "first_guesses" in near.summary["model"]


def test_iterations_do_not_grow_with_the_mesh(tmp_path):
    """From rest they grow twice as much or more."""
    def count(start, rows):
        mesh = {"divisions": 6 * rows, "band_facets": rows}
        return solve(tmp_path / "run", start, mesh, solver={"tolerance": 1e-8})[1]["results"]["iterations"]

    near, rest = ([count(start, rows) for rows in (14, 24)] for start in ("auto", "rest"))
    assert 2 * (near[1] - near[0]) < rest[1] - rest[0] and near[0] < rest[0] / 2


def test_a_coarser_run_that_fails_is_no_failure(tmp_path):
    """Gross slip ends the coarser run early, then the run itself with its own message and result."""
    with pytest.raises(hdengine.HdengineError, match="gross slip at T = "):
        solve(tmp_path, "coarser", {"divisions": 48, "band_facets": 8}, wave_generator={"interference": 0.0, "w": 5e-5},
              load={"support": "bearing", "torque": 10.0, **STEPS}, solver={"tolerance": 1e-6, "max_cuts": 2})
    assert json.loads((tmp_path / "summary.json").read_text())["results"]["steps"] > 0


def test_formed_faces_start_from_rest(tmp_path):
    """The coarser solution is a bad guess there, and is not asked for."""
    _, s = solve(tmp_path / "formed", "auto", {"divisions": 84, "band_facets": 12}, wave_generator={"shape": "as_formed"},
                 contact={"mode": "frictionless"}, solver={"tolerance": 1e-6})
    assert "first_guesses" not in s["model"]
