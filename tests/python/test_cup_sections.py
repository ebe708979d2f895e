# SPDX-License-Identifier: GPL-3.0-or-later
"""Cups by sections of their meridian: fillets, tapered walls, silk hats (docs/howto/own_size.md)."""
import numpy as np
import pytest

import hdengine
from conftest import ROOT, call, solved
from hdengine.report.sketch import draw_scene
from hdengine.table_file import read_csv

SMALL = ["mesh.divisions=24", "mesh.band_facets=4", "bearing.balls=12", "load.tooth_pairs=12", "output.vtu=none", "load.torque_steps=2",
         "loop.torques=8"]
SIMPLE = ["cup.sections_r=17.5e-3,17.5e-3,17.5e-3,17.5e-3,17.5e-3,8e-3", "cup.sections_z=0,9e-3,10e-3,19.5e-3,19.5e-3,19.5e-3",
          "cup.sections_thickness=0.427e-3,0.427e-3,0.36e-3,0.36e-3,0.5e-3,0.5e-3"]


def angle(exe, folder, scene, *keys):
    """Turn of the bottom at 8 N m."""
    solved(exe, folder, ROOT / f"tests/cases/{scene}.nml", *SMALL, *keys)
    return read_csv(folder / "loop.csv")["angle_rad"][-1]


def test_sections_of_the_simple_cup_are_that_cup(exe, tmp_path):
    """The whole drive turns by the same angle, to 1e-9, whether its cup is given by simple keys or by their sections."""
    np.testing.assert_allclose(angle(exe, tmp_path / "a", "pressed_drive", *SIMPLE), angle(exe, tmp_path / "b", "pressed_drive"), rtol=1e-9)


def test_a_hat_runs_in_both_solvers(exe, tmp_path):
    """The silk hat turns by the same angle in condensation and in Newton's matrix, to 1e-8; its wider flange is stiffer than the cup's
    bottom of the same thickness."""
    hat = angle(exe, tmp_path / "c", "pressed_hat")
    np.testing.assert_allclose(angle(exe, tmp_path / "n", "pressed_hat", "solver.method=newton"), hat, rtol=1e-8)
    assert 0 < hat < angle(exe, tmp_path / "d", "pressed_drive")


def test_a_fillet_changes_little(exe, tmp_path):
    """A fillet of 1 mm between wall and bottom moves the turn of the drive by less than 2 % on a coarse mesh."""
    sharp = angle(exe, tmp_path / "s", "pressed_drive", *SIMPLE)
    rounded = angle(exe, tmp_path / "r", "pressed_drive", *SIMPLE, "cup.sections_fillet=0,0,0,1e-3,0,0")
    assert 0 < abs(rounded / sharp - 1) < 0.02


def test_teeth_stand_on_the_wall(exe, tmp_path):
    """A flange thinner than the wall leaves the circle of the teeth's forces where it is."""
    thin = "cup.sections_thickness=0.427e-3,0.427e-3,0.36e-3,0.36e-3,0.2e-3"
    circles = [solved(exe, tmp_path / "r", ROOT / "tests/cases/pressed_hat.nml", *SMALL, *keys).summary["model"]["tooth_circle_m"] for keys in ((), (thin,))]
    assert circles[0] == circles[1] > 17.5e-3 + 0.36e-3


def test_the_echo_keeps_the_sections(exe, tmp_path):
    """The echo of a hat reads back as the same scene."""
    assert call(exe, ROOT / "tests/cases/pressed_hat.nml", *SMALL, "load.torque_steps=1", "--out", tmp_path / "o", "-q").returncode == 0
    assert hdengine.read_scene(tmp_path / "o/echo.nml")["cup.sections_r"] == hdengine.read_scene(
        ROOT / "tests/cases/pressed_hat.nml")["cup.sections_r"]


@pytest.mark.parametrize("keys, what", [
    (["geometry.hub_radius=9e-3"], "geometry.hub_radius = 0.009"),
    (["cup.sections_z=0,9e-3"], "cup.sections_z: 2 values"),
    (["cup.sections_thickness=0.427e-3,0.427e-3,0.36e-3,0.36e-3,-1"], "sections_thickness"),
    (["geometry.band_length=30e-3"], "the band ends on the straight bore"),
])
def test_contradictions_are_told(exe, tmp_path, keys, what):
    """A simple key that says something else, lists of unequal length and a band beyond the bore end with code 2 and name the key."""
    done = call(exe, ROOT / "tests/cases/pressed_hat.nml", *keys, "--check")
    assert done.returncode == 2 and what in done.stderr, done.stderr


def test_the_report_draws_the_flange():
    """In the sketch of a report the flange stands beyond the bore."""
    drawn = draw_scene(hdengine.read_scene(ROOT / "tests/cases/pressed_hat.nml"))
    assert drawn.count('fill="#8fb0cc"') == 4
