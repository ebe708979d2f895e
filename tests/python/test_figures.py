# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures leave the user's session as it was."""
import subprocess
import sys

import numpy as np
import pytest

import hdengine
from conftest import ROOT
from hdengine.figures.run import plot_positions, plot_run, plot_torsion
from hdengine.figures.study import _shades
from hdengine.views.run import band_of, positions_of

CODE = """
import matplotlib
matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np
import pytest
before = dict(matplotlib.rcParams)
import hdengine, hdengine.cli
from hdengine.figures import cup, record, run, sensitivity, study, surface
figure = hdengine.Joint(asperity_radius=1e-6, s_min=1e-14).plot().figure
figure.savefig("joint.png")
matplotlib.rcParams["font.size"] = 30.0
figure.savefig("again.png")
matplotlib.rcParams["font.size"] = before["font.size"]
changed = [key for key, value in before.items() if matplotlib.rcParams[key] != value]
assert not changed, changed
assert plt.get_backend().lower() == "svg" and not plt.get_fignums()
assert open("joint.png", "rb").read() == open("again.png", "rb").read()
"""


def test_the_session_stays_as_it_was(tmp_path):
    """Importing the package and drawing choose no backend, change no setting of matplotlib, open no figure of pyplot, and take
    no setting of the session for what the style names."""
    done = subprocess.run([sys.executable, "-c", CODE], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_run_stopped_in_the_assembly_is_drawn(tmp_path):
    """A run that ended before the torque has figures of its contact, and none of the torque; so has a drive without torque steps."""
    small = {"mesh.divisions": 16, "mesh.band_facets": 3}
    with hdengine.Run(ROOT / "data/cd14.nml", tmp_path / "a", **small) as run:
        next(iter(run))
    names = {p.name for p in plot_run(hdengine.load(tmp_path / "a"))}
    assert "pressure_band.png" in names and "torsion.png" not in names
    assert "loads.png" in {p.name for p in plot_run(hdengine.run(ROOT / "data/drive14.nml", tmp_path / "b", load__torque_steps=0, **small))}


def test_the_band_of_eq_45_is_one_per_cent(small_run):
    """Beside K_TS of Eq. 45 lies a band of 1 %."""
    axis = plot_torsion(hdengine.load(small_run)).axes[1]
    line, band = axis.lines[0].get_ydata(), axis.collections[0].get_paths()[0].vertices[:, 1]
    assert (band.min(), band.max()) == pytest.approx((0.99 * line.min(), 1.01 * line.max()))


def test_tangent_and_secant_are_drawn(small_run):
    """The first panel over the torque holds the columns of both, in MN m/rad."""
    result = hdengine.load(small_run)
    drawn = {line.get_label(): line.get_ydata() for line in plot_torsion(result).axes[0].lines}
    for label, name in (("tangent", "k_ts_bonded_nm_per_rad"), ("secant", "k_ts_secant_nm_per_rad")):
        assert np.allclose(1e6 * drawn[label], result.steps[name][-len(drawn[label]):], equal_nan=True)
    assert len(drawn["tangent"]) == 1 + np.count_nonzero(result.torque_nm)


def test_stresses_are_drawn_in_megapascal(small_run):
    """The lines of the contact's stresses are the columns of contact.csv over 1e6, at the angles in degrees."""
    result = hdengine.load(small_run)
    contact = np.genfromtxt(small_run / "contact.csv", delimiter=",", names=True)
    last = contact[contact["step"] == contact["step"].max()]
    for axis, name in zip(plot_positions(result).axes, ("pressure_pa", "traction_theta_pa")):
        for line in axis.lines[:3]:
            rows = [last[last["i_z"] == i] for i in np.unique(last["i_z"])]
            assert any(np.allclose(line.get_ydata(), row[name] / 1e6) for row in rows)
            assert np.allclose(line.get_xdata(), np.degrees(rows[0]["theta_rad"]))


def test_the_band_is_the_table_of_facets(small_run):
    """Pressures in MPa, slip in µm, line loads that carry the force, and for each position the row of facets that is nearest to it."""
    result = hdengine.load(small_run)
    contact = np.genfromtxt(small_run / "contact.csv", delimiter=",", names=True)
    last, band, scene = contact[contact["step"] == contact["step"].max()], band_of(result), result.scene
    np.testing.assert_allclose(np.nan_to_num(band.pressure).ravel(), last["pressure_pa"] / 1e6)
    slip = 1e6 * np.sqrt(last["slip_theta_m"] ** 2 + last["slip_z_m"] ** 2)
    np.testing.assert_allclose(np.nan_to_num(band.slip).ravel(), np.where(last["pressure_pa"] > 0, slip, 0))
    arc = 1e3 * 2 * np.pi * scene["geometry.bore_radius"] / scene["mesh.divisions"]
    assert (band.load * arc).sum() == pytest.approx((last["pressure_pa"] * last["area_m2"]).sum())
    middles = scene["geometry.band_length"] * (np.arange(scene["mesh.band_facets"]) + 0.5) / scene["mesh.band_facets"]
    for place, (_, pressure, _) in zip(scene["output.positions"], positions_of(result)):
        row = 1 + np.argmin(abs(middles - place))
        np.testing.assert_allclose(pressure, last["pressure_pa"][last["i_z"] == row] / 1e6)


def test_three_lines_have_the_colours_of_the_style():
    """Four take shades of one colour."""
    assert _shades([1, 2, 3]) == ["C0", "C1", "C2"] and len(_shades([1, 2, 3, 4])) == 4
