# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene against the teeth of the circular spline (Sec. 3.1), and the catalogue's chords."""
import numpy as np
import pytest

import hdengine
from conftest import ROOT, call, solved
from hdengine.catalogue import UNITS, stages
from hdengine.figures.run import plot_teeth
from hdengine.figures.study import plot_catalogue
from hdengine.report import write_report
from hdengine.studies import workers
from hdengine.table_file import read_csv

MESH = ["mesh.divisions=24", "mesh.band_facets=4", "load.torque_steps=2", "output.vtu=none"]


def solve(exe, folder, *keys):
    """Steps and teeth of a small run."""
    steps = solved(exe, folder, ROOT / "data/teeth.nml", *MESH, *keys).steps
    return steps[steps["torque_nm"] != 0], read_csv(folder / "teeth.csv")


def test_teeth_carry_the_torque(exe, tmp_path):
    """With a ring free to slide, sum f cos(alpha) r = T to 1e-9; no tooth pulls; all moments balance; both lobes share alike."""
    steps, teeth = solve(exe, tmp_path / "a")
    force = teeth["force_n"].reshape(2, 40)
    run = hdengine.load(tmp_path / "a")
    scene, radius = run.scene, run.summary["model"]["tooth_circle_m"]
    torque = force.sum(axis=1) * np.cos(np.radians(scene["load.pressure_angle_deg"])) * radius
    np.testing.assert_allclose(torque, steps["torque_nm"], rtol=1e-9)
    assert force.min() >= 0 and np.all(abs(steps["torque_balance_nm"]) < 1e-9)
    np.testing.assert_allclose(force[:, :20], force[:, 20:], rtol=1e-6)
    assert teeth["share"].reshape(2, 40).sum(axis=1) == pytest.approx(1)


def test_springs_follow_their_law(exe, tmp_path):
    """Each pair's force is its stiffness times its closing where that is positive, else 0; with clearance some stay open."""
    _, teeth = solve(exe, tmp_path / "c", "load.tooth_clearance=20e-6")
    np.testing.assert_allclose(teeth["force_n"], 1.25e8 * np.maximum(teeth["closing_m"], 0), rtol=1e-6, atol=1e-9)
    assert 0 < np.count_nonzero(teeth["force_n"][-40:] == 0) < 40


def test_teeth_that_touch_make_a_constant_stiffness(exe, tmp_path):
    """Closed at the start, the scene is homogeneous: K_FTS does not depend on T. Clearance makes it rise with T."""
    steps, _ = solve(exe, tmp_path / "a")
    k = steps["torque_nm"] / steps["rotation_rad"]
    assert k[1] == pytest.approx(k[0], rel=1e-10)
    steps, _ = solve(exe, tmp_path / "b", "load.tooth_clearance=20e-6")
    loose = steps["torque_nm"] / steps["rotation_rad"]
    assert loose[0] < loose[1] < k[0]


def test_both_senses_of_torque_are_alike(exe, tmp_path):
    """Without clearance -5 N m turns the hub back by what +5 N m turned it."""
    plus, _ = solve(exe, tmp_path / "p")
    minus, _ = solve(exe, tmp_path / "m", "load.torque=-5")
    np.testing.assert_allclose(minus["rotation_rad"], -plus["rotation_rad"], rtol=1e-9)


def test_stiff_teeth_leave_the_cup(exe, tmp_path):
    """Softer pairs lower K_FTS; with rigid ones what remains lies below the tube behind the held ring and the bottom in series."""
    stiffness = []
    for k in ("1e7", "1.25e8", "1e13"):
        steps, _ = solve(exe, tmp_path / k, f"load.tooth_stiffness={k}")
        stiffness.append(steps["torque_nm"][-1] / steps["rotation_rad"][-1])
    assert stiffness[0] < stiffness[1] < stiffness[2]
    g, r, s = 209e9 / 2.59, 17.5e-3, hdengine.load(tmp_path / "1e13").scene
    tube = 2 * np.pi * g * r**3 * s["geometry.wall_thickness"] / (
        s["geometry.cup_length"] - s["geometry.band_start"] - s["geometry.band_length"])
    bottom = 4 * np.pi * g * s["geometry.bottom_thickness"] / (1 / s["geometry.hub_radius"]**2 - 1 / r**2)
    assert 0.5 < stiffness[2] * (1 / tube + 1 / bottom) < 1.05


def test_modes_that_do_not_fit_are_refused(exe, tmp_path):
    """Support 'teeth' without bonded contact, or an odd number of pairs: code 2 with the reason."""
    for keys, what in ((["contact.mode=frictional"], "'bonded' with load.support = 'teeth'"), (["load.tooth_pairs=39"], "an even number")):
        done = call(exe, ROOT / "data/teeth.nml", *keys, "--out", tmp_path / "x", "-q")
        assert done.returncode == 2 and what in done.stderr


def test_chords_of_a_catalogue_curve():
    """K1, K2, K3 are recovered from the curve they make; one that the data end within is cut there, one beyond them is NaN. Data that begin above 0 are
    refused: from 1 N m on K1 of size 14 read as 9.4 kN m/rad, twice what it is."""
    for unit in UNITS.values():
        t = np.union1d(np.linspace(0, 1.5 * unit.t2_nm, 50), [unit.t1_nm, unit.t2_nm])
        assert stages(t, unit.angle(t), unit.t1_nm, unit.t2_nm) == pytest.approx(unit.slopes, rel=1e-6)
    unit = UNITS[14]
    t = np.array([0, 2, 5])
    k = stages(t, unit.angle(t), unit.t1_nm, unit.t2_nm)
    assert k[:2] == pytest.approx([4.7e3, 6.1e3]) and np.isnan(k[2])
    with pytest.raises(hdengine.InputError, match="rising from 0"):
        stages(np.array([1, 2, 5]), unit.angle([1, 2, 5]), unit.t1_nm, unit.t2_nm)


def test_run_against_teeth_says_what_it_is_for(exe, tmp_path):
    """Printed objects, figures and report name K_FTS, in kN m/rad, and the pairs' shares, not Eq. 45 or the joint, which a bonded ring has not."""
    solve(exe, tmp_path / "r", "load.tooth_clearance=20e-6")
    result = hdengine.load(tmp_path / "r")
    k = result.secant_stiffness()
    assert np.isnan(k[0]) and k[-1] == pytest.approx(5 / result.steps["rotation_rad"][-1])
    page = write_report(tmp_path / "r", picture=False).read_text()
    for text in (repr(result), page):
        assert "K_FTS" in text and "Eq. 45" not in text.replace("Eq. 45 says", "") and "spot" not in text.replace("plastic_spots", "")
    stiffness, _, shares = plot_teeth(result).axes
    steps = result.steps[result.torque_nm != 0]
    np.testing.assert_allclose(stiffness.lines[0].get_ydata(), 1e-3 * steps["torque_nm"] / steps["rotation_rad"])
    assert "kN m/rad" in stiffness.get_title() and shares.get_ylim()[1] > 100 * result.teeth["share"].max()
    assert "shares of the pairs 0.0 to" in repr(result) and f"{1e-3 * k[-1]:.5g}" in page
    solve(exe, tmp_path / "r", "load.torque_steps=0")
    assert "no torque" in repr(hdengine.load(tmp_path / "r"))
    assert "no torque" in write_report(tmp_path / "r", picture=False).read_text()
    with hdengine.Run(ROOT / "data/teeth.nml", mesh={"divisions": 24, "band_facets": 4}, load={"torque_steps": 1}) as run:
        steps = list(run)
    assert "K_FTS -" in str(steps[0]) and f"K_FTS {5 / steps[-1].sums['rotation_rad']:.4g} N m/rad" in str(steps[-1])


def test_figure_beside_the_catalogue(tmp_path):
    """The study of sizes draws K_FTS over the size, one line per clearance, beside K1, K2, K3 of the same sizes."""
    study = hdengine.Study.read(ROOT / "data/teeth_sizes.toml")
    study.together = {key: values[:2] for key, values in study.together.items()}
    study.fixed |= {"mesh.divisions": 16, "mesh.band_facets": 3}
    figure = plot_catalogue(study.run(tmp_path / "s.out", show=False))
    lines = {line.get_label(): line for line in figure.axes[0].lines}
    assert len(lines) == 5
    for i in (1, 2, 3):
        size, k = lines[f"catalogue K{i}"].get_data()
        assert [*size] == [14, 17] and [*k] == [UNITS[s].slopes[i - 1] for s in size]
    ours = next(line for name, line in lines.items() if "closed" in name)
    np.testing.assert_allclose(ours.get_xdata(), [14, 17], rtol=1e-3)
    assert ours.get_ydata()[1] / ours.get_ydata()[0] == pytest.approx((17 / 14) ** 3, rel=2e-2)


def test_balls_between_wave_generator_and_ring(exe, tmp_path):
    """Stiff balls (1e14 N/m) give the rigid wave generator's K_FTS to 1e-4, real ones (1.3e8 N/m) between 0.5 and 0.9 of it."""
    rigid, stiff, real = (solve(exe, tmp_path / k, f"wave_generator.ball_stiffness={k}")[0]["rotation_rad"][-1] for k in ("0", "1e14", "1.3e8"))
    assert stiff == pytest.approx(rigid, rel=1e-4) and 1 / 0.9 < real / rigid < 1 / 0.5


def test_soft_balls_pull_with_their_stiffness(exe, tmp_path):
    """Frictionless and round, an eccentricity e on balls of 1e4 N/m together pulls the cup sideways by 1e4 e / 2, to 2 %."""
    keys = ["wave_generator.w=0", "wave_generator.eccentricity=1e-5", "wave_generator.ring_tangent=free", "contact.mode=frictionless",
            "wave_generator.ball_stiffness=1e4", "load.torque=0", "load.assembly_steps=1"]
    c = {name: field[-1] for name, field in solved(exe, tmp_path / "e", ROOT / "data/cd14.nml", *MESH, *keys).contact.items()}
    assert (c["pressure_pa"] * c["area_m2"] * np.cos(c["theta_rad"])).sum() == pytest.approx(1e4 * 1e-5 / 2, rel=0.02)


def test_a_study_against_the_teeth_claims_no_contact_stiffness():
    """The bonded ring has no contact of Eq. 45: its columns are empty, torque over rotation is K_FTS."""
    keys = {"mesh.divisions": 24, "mesh.band_facets": 4, "load.torque_steps": 1}
    row = workers.solve(ROOT / "data/teeth.nml", keys, "last")[0]
    assert row["status"] == "done" and np.isnan([row["k_ts_nm_per_rad"], row["k_ts_normal_nm_per_rad"], row["k_ts_paper_n"]]).all()
    assert row["k_fe_secant_nm_per_rad"] == pytest.approx(row["torque_nm"] / row["rotation_rad"])
