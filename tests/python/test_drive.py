# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole drive in one scene: balls, ring, cup, friction, teeth, and the loop (docs/explain/drive.md)."""
import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import hdengine
from conftest import ROOT, call, solved, stopped_and_whole
from hdengine import cli, load
from hdengine.catalogue import UNITS, rated_torque, unit
from hdengine.drive import KNOWN, RATIOS, _namelist, _scene
from hdengine.figures.run import plot_run
from hdengine.table_file import read_csv
from hdengine.views.run import loop_of

AMID = 18.08325e-3  # amid the teeth: the outside of the wall, 17.86 mm, and half of teeth and clearance, 2.5 modules of 2 * 17.86 / 200 mm [m]
MESH = ["mesh.divisions=24", "mesh.band_facets=4", "bearing.balls=12", "load.tooth_pairs=12", "output.vtu=none",
        "load.torque_steps=4"]


SLIDING = [
    "mesh.divisions=32", "mesh.band_facets=5", "mesh.bottom_elements=4", "geometry.band_length=0.0103632", "geometry.ring_thickness=0.00119099",
    "wave_generator.w=0.000349968", "wave_generator.cam=arcs", "wave_generator.interference=3.10062e-05",
    "wave_generator.eccentricity=3.79219e-05", "wave_generator.eccentricity_angle_deg=17.0313", "bearing.balls=12",
    "bearing.ball_diameter=0.00279885", "bearing.outer_conformity=0.579877", "bearing.cage_angle_deg=4.7419", "contact.friction=0.048558",
    "load.teeth=320", "load.tooth_pairs=34", "load.tooth_stiffness=540792000.0", "load.tooth_clearance=2.93354e-06",
    "load.pressure_angle_deg=35.1336", "load.torque=-1.33374", "load.torque_steps=2", "load.assembly_steps=2",
    "loop.torques=-6.864,-7.52,9.744", "geometry.wall_thickness=0.000318905", "geometry.hub_radius=0.00689792",
    "geometry.cup_length=0.0235952", "geometry.rim_thickness=0.000323179"]


RIDGE = [
    "mesh.divisions=40", "mesh.band_facets=6", "mesh.bottom_elements=4", "geometry.band_length=0.00861718",
    "geometry.ring_thickness=0.000428041", "wave_generator.w=0.000245935", "wave_generator.cam=arcs",
    "wave_generator.interference=0.0", "bearing.balls=10", "bearing.ball_diameter=0.00226863",
    "bearing.outer_conformity=0.546113", "bearing.cage_angle_deg=2.18552", "contact.friction=0.0", "load.teeth=200",
    "load.tooth_pairs=36", "load.tooth_stiffness=250054000.0", "load.tooth_clearance=1.70902e-06",
    "load.pressure_angle_deg=33.7452", "load.torque=7.93042", "load.torque_steps=2", "load.assembly_steps=2",
    "loop.torques=0.08886,0.1591", "geometry.wall_thickness=0.00016961", "geometry.hub_radius=0.0103164",
    "geometry.cup_length=0.025558", "geometry.rim_thickness=0.000206736"]

DRIFTING = [
    "mesh.divisions=24", "mesh.band_facets=6", "mesh.bottom_elements=4", "geometry.band_length=0.00607061",
    "geometry.ring_thickness=0.00150652", "wave_generator.w=0.000118601", "wave_generator.cam=ellipse",
    "wave_generator.interference=2.42443e-05", "bearing.balls=19", "bearing.ball_diameter=0.00302716",
    "bearing.outer_conformity=0.553694", "bearing.cage_angle_deg=25.7077", "contact.friction=0.0", "load.teeth=160",
    "load.tooth_pairs=18", "load.tooth_stiffness=805236000.0", "load.tooth_clearance=1.52475e-06",
    "load.pressure_angle_deg=10.7797", "load.torque=-0.831052", "load.torque_steps=3", "load.assembly_steps=2",
    "loop.torques=-0.7202,0.3625,0.9066", "geometry.wall_thickness=0.000202149", "geometry.hub_radius=0.0109394",
    "geometry.cup_length=0.0207048", "geometry.rim_thickness=0.000233267", "contact.law=joint", "solver.method=newton"]


LOOSE = [
    "mesh.divisions=24", "mesh.band_facets=6", "mesh.bottom_elements=4", "geometry.band_length=0.00853854",
    "geometry.ring_thickness=0.000557482", "wave_generator.w=7.86315e-05", "wave_generator.cam=arcs",
    "wave_generator.clearance=3.68749e-05", "wave_generator.eccentricity_angle_deg=222.321", "bearing.balls=9",
    "bearing.ball_diameter=0.0035828", "bearing.outer_conformity=0.534797", "bearing.clearance=0.0", "bearing.cage_angle_deg=26.7408",
    "contact.friction=0.127886", "load.teeth=160", "load.tooth_pairs=36", "load.tooth_stiffness=729613000.0",
    "load.tooth_clearance=1.73074e-05", "load.pressure_angle_deg=33.572", "load.torque=5.49639", "load.torque_steps=1",
    "load.assembly_steps=2", "loop.torques=13.11,-11.58", "cup.sections_r=0.0175,0.0175,0.0175,0.0175,0.0175,0.0287521",
    "cup.sections_z=0,0.009,0.01,0.0263036,0.0263036,0.0263036",
    "cup.sections_thickness=0.00025706,0.00025706,0.00024573,0.00024573,0.000599128,0.000599128",
    "cup.sections_fillet=0,0,0,0.00151266,0,0", "output.vtu=none"]


def solve(exe, folder, *keys, code=0):
    """Results of a small drive: summary, loop, balls, teeth."""
    done = call(exe, ROOT / "tests/cases/pressed_drive.nml", *MESH, *keys, "--out", folder, "--force", "-q")
    assert done.returncode == code, done.stderr
    results = json.loads((folder / "summary.json").read_text())["results"]
    return results, *((folder / name).exists() and read_csv(folder / name) for name in ("loop.csv", "balls.csv", "teeth.csv"))


@pytest.fixture(scope="module")
def drive(exe, tmp_path_factory):
    return solve(exe, tmp_path_factory.mktemp("drive") / "a")


def test_summary_states_what_a_bench_measures(drive):
    """K1 to K3, hysteresis, lost motion, forces of balls and teeth and the torque on the wave generator are there and positive."""
    for key in ("k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad", "hysteresis_rad", "lost_motion_rad", "wave_generator_torque_max_nm",
                "k_ts_bonded_nm_per_rad", "ball_force_max_n", "tooth_force_max_n", "von_mises_max_pa", "goodman_safety_min"):
        assert drive[0][key] > 0, key


def test_chords_are_those_of_the_first_rise(drive):
    """K1, K2, K3 are the chords of loop.csv up to T1 = 2, T2 = 6.9 and 14 N m."""
    results, loop, _, _ = drive
    rise = loop[loop["phase"] == "torque"][:5]  # four steps, and one where lost motion is read
    torque, angle = rise["torque_nm"], rise["angle_rad"]
    assert torque[-1] == 14
    at = np.interp([0, 2, 6.9, 14], np.r_[0, torque], np.r_[0, angle])
    chords = np.diff([0, 2, 6.9, 14]) / np.diff(at)
    np.testing.assert_allclose([results[f"k{i}_nm_per_rad"] for i in (1, 2, 3)], chords, rtol=1e-9)


def test_log_states_what_a_bench_measures(exe, tmp_path):
    """The log of a drive ends with K1 to K3, hysteresis and lost motion, and shows no reading that does not exist."""
    done = call(exe, ROOT / "tests/cases/pressed_drive.nml", *MESH, "load.torque_steps=1", "--out", tmp_path / "log")
    line = next(line for line in done.stdout.splitlines() if line.startswith("drive "))
    assert "K1 " in line and "K3 " in line and "hysteresis " in line and "NaN" not in done.stdout


@pytest.mark.parametrize("keys", [[], ["contact.law=joint", "contact.friction=3", "wave_generator.clearance=9e-6"],
                                  ["bearing.balls=0", "wave_generator.ball_stiffness=1e8"], ["bearing.axial_hold=grooves"]])
def test_energy_balances(exe, tmp_path, keys):
    """Work of the torque = friction's heat + change of the stored energy, that of a rough joint or an even spring in the place of the balls
    included, to 1 % over the loop; steps are finer about no torque. Friction gives nothing back."""
    _, loop, _, _ = solve(exe, tmp_path / "e", "loop.torques=1,14,1,-1,-14,-1,0", "load.torque_steps=10", *keys)
    assert loop["dissipated_j"][-1] > 0 and np.all(np.diff(loop["dissipated_j"]) > -1e-12)
    left = loop["work_j"] - loop["stored_j"] - loop["dissipated_j"]
    assert abs(left[-1]) < 0.01 * loop["dissipated_j"][-1]


def test_torque_balances(exe, tmp_path):
    """The flanks' forces times cos(25 deg) times the radius amid the teeth are the torque; all moments balance."""
    _, loop, _, teeth = solve(exe, tmp_path / "t", "load.torque_steps=2", "solver.tolerance=1e-10")
    torque = (teeth["force_n"] * teeth["flank"]).reshape(-1, 24).sum(axis=1) * np.cos(np.radians(25)) * AMID
    np.testing.assert_allclose(torque, loop["torque_nm"][-len(torque):], rtol=1e-7, atol=1e-7)
    assert np.all(abs(read_csv(tmp_path / "t/steps.csv")["torque_balance_nm"]) < 1e-6)


def test_assembly_is_symmetric(drive):
    """Twelve balls on a symmetric cam carry alike in all four quadrants while no torque acts."""
    _, loop, balls, _ = drive
    force = balls["force_n"].reshape(-1, 12)[loop["phase"] == "assembly"][-1]
    np.testing.assert_allclose(force, np.roll(force, 6), rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(force[1:], force[:0:-1], rtol=1e-7, atol=1e-7)


def test_senses_of_torque_are_alike(exe, tmp_path):
    """The torque the other way round first turns the bottom by as much the other way."""
    _, plus, _, _ = solve(exe, tmp_path / "p", "loop.torques=8", "load.torque_steps=3")
    _, minus, _, _ = solve(exe, tmp_path / "m", "loop.torques=-8", "load.torque_steps=3")
    np.testing.assert_allclose(minus["angle_rad"], -plus["angle_rad"], rtol=1e-6)
    np.testing.assert_allclose(minus["ball_force_max_n"], plus["ball_force_max_n"], rtol=1e-6)


def race_contact(diameter, race, conformity, modulus):
    """Force over approach^1.5 of a ball on a race by scipy's elliptic integrals [N/m^1.5], and its largest pressure under 1 N [Pa]."""
    along, across = 2 / diameter + 1 / race, 2 / diameter - 1 / (conformity * diameter)
    total = along + across

    def difference(kappa):
        k, e = ellipk(1 - kappa**-2), ellipe(1 - kappa**-2)
        return ((kappa**2 + 1) * e - 2 * k) / ((kappa**2 - 1) * e) - abs(along - across) / total

    kappa = brentq(difference, 1.001, 1e3, xtol=1e-13)
    k, e = ellipk(1 - kappa**-2), ellipe(1 - kappa**-2)
    approach = 2 * k / np.pi * (np.pi / (2 * kappa**2 * e)) ** (1 / 3)
    long = (2 * kappa**2 * e / np.pi * 3 / (2 * total * modulus)) ** (1 / 3)
    return 2 / 3 * total * modulus * (2 / (approach * total)) ** 1.5, 1.5 / (np.pi * long**2 / kappa)


def test_balls_follow_hertz(drive):
    """Every ball carries K closing^1.5, K of both races in series by scipy's elliptic integrals; none pulls. The largest pressure is that of the
    largest force on the race that it is highest on."""
    balls = drive[2]
    modulus = 1 / ((1 - 0.3**2) / 208e9 + (1 - 0.3**2) / 219e9)
    rates, pressures = zip(race_contact(3.2e-3, 13.3e-3, 0.52, modulus), race_contact(3.2e-3, -16.5e-3, 0.52, modulus))
    rate = sum(k ** (-2 / 3) for k in rates) ** -1.5
    assert drive[0]["ball_pressure_max_pa"] == pytest.approx(max(pressures) * drive[0]["ball_force_max_n"] ** (1 / 3), rel=1e-8)
    np.testing.assert_allclose(balls["force_n"], rate * np.maximum(balls["closing_m"], 0) ** 1.5, rtol=1e-8, atol=1e-9)
    assert np.any(balls["force_n"] == 0) and np.any(balls["force_n"] > 50)


def test_flanks_follow_their_law(drive):
    """Every flank carries its stiffness times its closing where that is positive."""
    teeth = drive[3]
    np.testing.assert_allclose(teeth["force_n"], 1.25e8 * np.maximum(teeth["closing_m"], 0), rtol=1e-7, atol=1e-7)


def test_matrix_gives_the_same_numbers(exe, tmp_path):
    """Newton's whole matrix and condensation agree to 1e-8 in angle, balls, teeth, energy and the torque on the wave generator."""
    keys = ["loop.torques=8,-3", "load.torque_steps=3", "solver.tolerance=1e-11", "wave_generator.eccentricity=5e-6"]
    ours = solve(exe, tmp_path / "c", *keys, "bearing.balls=11")
    other = solve(exe, tmp_path / "n", *keys, "bearing.balls=11", "solver.method=newton")
    assert [json.loads((tmp_path / f / "summary.json").read_text())["model"]["solver"][:6] for f in "cn"] == ["conden", "Newton"]
    for table, columns in ((1, ("angle_rad", "stored_j", "wave_generator_torque_nm", "k_ts_nm_per_rad")), (2, ("force_n",)),
                           (3, ("force_n", "closing_m"))):
        for column in columns:
            a, b = ours[table][column], other[table][column]
            np.testing.assert_allclose(a, b, rtol=0, atol=1e-8 * abs(a).max(), err_msg=column)


def test_a_larger_mesh_takes_stored_answers(exe, tmp_path):
    """From 6000 nodes on the condensed form takes its right-hand sides from stored answers to balls and flanks, and GMRES most products
    in single precision: it gives the matrix's solution all the same, in fewer than 40 steps per iteration of Newton's."""
    keys = ["mesh.divisions=72", "mesh.band_facets=12", "load.torque_steps=1", "load.assembly_steps=1", "loop.torques=8",
            "loop.torque_1=8", "loop.torque_2=9", "loop.rated_torque=200", "solver.tolerance=1e-10"]  # no steps between
    ours, other = solve(exe, tmp_path / "c", *keys), solve(exe, tmp_path / "n", *keys, "solver.method=newton", "solver.factors=exact")
    model = json.loads((tmp_path / "c/summary.json").read_text())["model"]
    assert model["dof"] > 18000 and 0 < model["inner_iterations"] < 40 * ours[0]["iterations"]
    for table, column in ((1, "angle_rad"), (1, "stored_j"), (2, "force_n"), (3, "force_n")):
        a, b = ours[table][column], other[table][column]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-8 * abs(a).max(), err_msg=column)


def test_an_elastic_circular_spline(exe, tmp_path):
    """The drive gets softer, in the condensed form and in the matrix alike, and its energy balances as on a rigid spline: what the
    ring stores is part of it. Half as wide it gives way twice as much. A diameter inside of the rim is refused."""
    keys = ["loop.torques=8,1", "load.torque_steps=3", "solver.tolerance=1e-11"]
    soft = [*keys, "load.spline=free"]
    rigid, ours = solve(exe, tmp_path / "r", *keys), solve(exe, tmp_path / "c", *soft)
    other = solve(exe, tmp_path / "n", *soft, "solver.method=newton")
    for table, column in ((1, "angle_rad"), (1, "stored_j"), (2, "force_n"), (3, "force_n"), (3, "closing_m")):
        a, b = ours[table][column], other[table][column]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-8 * abs(a).max(), err_msg=column)
    assert 1.1 < ours[1]["angle_rad"].max() / rigid[1]["angle_rad"].max() < 1.5
    length = hdengine.read_scene(ROOT / "tests/cases/pressed_drive.nml")["geometry.rim_length"]
    wide, narrow = (solve(exe, tmp_path / "w", *soft, f"load.spline_width={width}")[1]["angle_rad"] for width in (length, length / 2))
    assert np.array_equal(wide, ours[1]["angle_rad"])
    assert (narrow - rigid[1]["angle_rad"]).max() == pytest.approx(2 * (wide - rigid[1]["angle_rad"]).max(), rel=0.1)
    left = [(loop["work_j"] - loop["stored_j"] - loop["dissipated_j"])[-1] for loop in (rigid[1], ours[1])]
    assert left[1] == pytest.approx(left[0], abs=1e-3 * ours[1]["work_j"].max())
    done = call(exe, ROOT / "data/drive14.nml", "load.spline_diameter=35e-3", "--check")
    assert done.returncode == 2 and "load.spline_diameter = 0.035" in done.stderr and "above that of the roots of its teeth" in done.stderr
    done = call(exe, ROOT / "data/drive14.nml", "load.spline_root_diameter=36.1e-3", "--check")
    assert done.returncode == 2 and "above that of the wall on the long axis (0.03612)" in done.stderr


def test_a_groove_for_the_balls(exe, tmp_path):
    """The condensed form and the matrix agree on a grooved ring. One that keeps 0.91 of its second moment takes 0.93 to 0.98 of the forces
    of its balls to be pressed on the cam, with a thin cup and the balls' own compliance beside it. A depth of 0 leaves every number as it is. What does not fit into the ring, what no cell lies in and a drive without balls are refused."""
    keys = ["loop.torques=8,1", "load.torque_steps=3", "solver.tolerance=1e-11"]
    grooved = [*keys, "bearing.groove_depth=0.5e-3", "mesh.ring_facets=6"]
    plain, none = solve(exe, tmp_path / "p", *keys), solve(exe, tmp_path / "z", *keys, "bearing.groove_depth=0")
    for table, other in zip(plain[1:], none[1:]):
        assert table.tobytes() == other.tobytes()
    ours, other = solve(exe, tmp_path / "c", *grooved), solve(exe, tmp_path / "n", *grooved, "solver.method=newton")
    for table, column in ((1, "angle_rad"), (1, "stored_j"), (2, "force_n"), (3, "force_n"), (3, "closing_m")):
        a, b = ours[table][column], other[table][column]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-8 * abs(a).max(), err_msg=column)
    thin = ["mesh.divisions=48", "mesh.ring_facets=8", "wave_generator.interference=0", "geometry.wall_thickness=0.1e-3",
            "geometry.rim_thickness=0.1e-3", "loop.torques=1", "load.torque_steps=1"]
    pressed = [np.sum(balls["force_n"][balls["step"] == 3]) for _, _, balls, _ in (
        solve(exe, tmp_path / "t", *thin, f"bearing.groove_depth={depth}") for depth in (0, 0.5e-3))]
    assert 0.93 < pressed[1] / pressed[0] < 0.98
    for wrong, told in (("bearing.groove_depth=0.8e-3", "three quarters of geometry.ring_thickness"),
                        ("bearing.groove_depth=0.3e-3 geometry.band_length=1.5e-3", "narrower than the ring"),
                        ("bearing.groove_depth=0.2e-3 mesh.ring_facets=4", "the cells of the ring are not longer than the groove"),
                        ("bearing.groove_depth=0.2e-3 bearing.balls=0", "bearing.balls, that run in the groove")):
        done = call(exe, ROOT / "tests/cases/pressed_drive.nml", *wrong.split(), "--check")
        assert done.returncode == 2 and told in done.stderr and done.stderr.count("error:") == 1, done.stderr


def test_a_ring_whose_points_all_slip_is_held(exe, tmp_path):
    """Drive 239 of bench/random_runs.py: a ring with clearance touches the cup at a few points, none of which sticks; one of Newton's corrections
    turned it by metres, and the iteration ran in a cycle at some eccentricities."""
    for e in (3e-05, 3.05e-05, 3.12481e-05, 3.15e-05, 3.2e-05, 3.5e-05):
        done = call(exe, ROOT / "tests/cases/pressed_hat.nml", *LOOSE, f"wave_generator.eccentricity={e}", "--out", tmp_path / "r", "--force", "-q")
        assert done.returncode == 0, done.stderr


def test_a_tolerance_below_rounding_is_named(exe, tmp_path):
    """A residual cannot fall to 1e-14 of its parts: the message blames the tolerance, not the contact states."""
    done = call(exe, ROOT / "data/cd14.nml", "mesh.divisions=24", "mesh.band_facets=4", "solver.tolerance=1e-14", "--out", tmp_path / "r", "-q")
    assert done.returncode == 4 and "which is rounding" in done.stderr and done.stderr.rstrip().endswith("Raise solver.tolerance above it")
    assert "raise solver.max_iterations" not in done.stderr


def test_a_rigid_cam_takes_its_moment(exe, tmp_path):
    """Without balls the ring's face presses on the slopes of the cam: a small part of the torque, of the sign and near the size of
    that on balls. A ring that the cam holds tangentially puts nearly all of the torque on it, and the run warns."""
    moment = [solve(exe, tmp_path / n, "loop.torques=8", f"bearing.balls={n}")[1]["wave_generator_torque_nm"][-1] for n in ("0", "12")]
    assert moment[0] < 0 and 0.7 < moment[0] / moment[1] < 1.5
    assert 80 < -8 / moment[0] < 130
    call(exe, ROOT / "tests/cases/pressed_drive.nml", "mesh.divisions=48", "mesh.band_facets=8", "loop.torques=8", "load.torque_steps=2",
         "bearing.balls=0", "wave_generator.ring_tangent=follow", "output.vtu=none", "--out", tmp_path / "held")
    summary = json.loads((tmp_path / "held/summary.json").read_text())
    assert summary["results"]["wave_generator_torque_max_nm"] > 4
    assert any("the ring puts up to" in w and "ring_tangent holds the ring" in w for w in summary["warnings"])


@pytest.mark.parametrize("mode", ["bonded", "frictional"])
def test_a_bottom_that_the_contact_holds(exe, tmp_path, mode):
    """Where a ring that the cam holds takes the first torque and no flank pushes, the loop converges in 15 iterations a step: flanks that
    were counted in the matrix before they push, and then do not, are left out."""
    results, loop, _, teeth = solve(exe, tmp_path, "bearing.balls=0", "wave_generator.ring_tangent=follow", f"contact.mode={mode}",
                                    "load.torque_steps=10", "load.tooth_pairs=40")
    assert results["cut_backs"] == 0 and results["iterations"] < 15 * 43 and abs(loop["torque_nm"]).max() == pytest.approx(14)
    force = np.asarray(teeth["force_n"])
    assert force[np.asarray(teeth["step"]) == 4].max() == 0 and (mode == "bonded" or force.max() > 0)


@pytest.mark.parametrize("rows", [2, 9, 23])
def test_a_stopped_loop_goes_on(exe, tmp_path, rows):
    """Stopped by a signal in assembly, rise or fall: --resume ends with the same tables, to the byte, and the same summary."""
    folder, whole = stopped_and_whole(exe, [*MESH, "load.torque_steps=10"], rows, tmp_path)
    ours, other = (json.loads((f / "summary.json").read_text()) for f in (folder, whole))
    assert ours["results"] == other["results"] and ours["model"]["resumed"] and not other["model"]["resumed"]


def test_chords_of_few_steps_are_those_of_many(exe, tmp_path):
    """A loop stops at T1 and T2, so K1 to K3 of two steps to 14 N m are those of 14 within 0.5 %. A cup that fails by Goodman is warned of."""
    few, many = (solved(exe, tmp_path / str(steps), ROOT / "tests/cases/pressed_drive.nml", *MESH, "loop.torques=14", f"load.torque_steps={steps}",
                        f"fatigue.fatigue_limit={limit}") for steps, limit in ((2, 5e9), (14, 1e8)))
    for i in (1, 2, 3):
        assert few.summary["results"][f"k{i}_nm_per_rad"] == pytest.approx(many.summary["results"][f"k{i}_nm_per_rad"], rel=5e-3)
    assert [any("safety by Goodman" in w and "cup.sections_fillet" in w for w in run.summary["warnings"]) for run in (few, many)] == [False, True]
    assert few.summary["results"]["goodman_safety_min"] > 1 > many.summary["results"]["goodman_safety_min"]
    assert not {"hysteresis_rad", "lost_motion_rad"} & set(few.summary["results"])


def test_readings_of_any_list_of_torques(exe, tmp_path):
    """A torque that comes twice changes no reading; a way to 0 and back before the loop changes what slips by a tenth, and alone has no width. The results of a
    list that begins with 0 are those of the sense that follows. Where a loop is read it has steps, in a way through 0, too."""
    found = {}
    for torques in ("14,0,-14,0,14", "14,0,0,-14,-14,0,0,14", "14,0,14,0,-14,0,14", "14,0,14", "0,-14,0", "14,-14,14"):
        summary = solved(exe, tmp_path / "r", ROOT / "tests/cases/pressed_drive.nml", *MESH, f"loop.torques={torques}", "load.torque_steps=3",
                         "output.vtu=none").summary
        found[torques] = summary["results"]
    plain, twice, before, half, down, through = found.values()
    for key in ("k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad", "hysteresis_rad", "lost_motion_rad"):
        assert twice[key] == pytest.approx(plain[key], rel=5e-3) and before[key] == pytest.approx(plain[key], rel=0.1), key
        assert through[key] == pytest.approx(plain[key], rel=0.1), key  # on steps twice as long
    assert not {"hysteresis_rad", "lost_motion_rad"} & (set(half) | set(down))
    assert down["reference_torque_nm"] == -14 and sum(down["twist_shares"].values()) == pytest.approx(1) and down["k1_nm_per_rad"] > 0


def test_a_hard_even_spring_is_a_rigid_wave_generator(exe, tmp_path):
    """Readings on a spring of 1e14 N/m are those of a rigid wave generator to 1e-3: its stiffness times its way is no force that a residual is small beside."""
    hard, rigid = (solve(exe, tmp_path / "s", "bearing.balls=0", f"wave_generator.ball_stiffness={k}", "wave_generator.clearance=9e-6",
                         "loop.torques=8,0,-8,0,8")[0] for k in (1e14, 0))
    for key in ("k1_nm_per_rad", "k3_nm_per_rad", "hysteresis_rad", "lost_motion_rad", "k_ts_bonded_nm_per_rad"):
        assert hard[key] == pytest.approx(rigid[key], rel=1e-3), key


def test_an_even_spring_has_the_share_of_the_balls(exe, tmp_path):
    """Pressed faces that hold make all linear: shares of balls and ring are the turn's derivatives by the logarithm of their compliances, less what the
    joint adds, to 1e-3. The spring's share stood in the ring's."""
    def run(*keys):
        result, rows, *_ = solve(exe, tmp_path / "s", "bearing.balls=0", "wave_generator.ball_stiffness=1e8", "wave_generator.w=2e-5", "contact.friction=10",
                                "wave_generator.interference=1e-4", "load.tooth_clearance=0", "loop.torques=2", *keys)
        return rows["angle_rad"][-1], result["twist_shares"]
    turn, shares = run()
    assert shares["gaps"] == shares["slip"] == 0
    for part, key, value in (("balls", "wave_generator.ball_stiffness", 1e8), ("ring", "material.ring_e", 2.19e11)):
        slope = np.log(run(f"{key}={0.99 * value}")[0] / run(f"{key}={1.01 * value}")[0]) / np.log(1.01 / 0.99)
        assert shares[part] == pytest.approx((1 - shares["joint"]) * slope, rel=1e-3), part


def test_lost_motion_of_a_loop_that_does_not_close(exe, tmp_path):
    """Read on the first ramp where no later one comes back to 4 % of the rated torque: 4 steps give the lost motion of 40 to 1 %."""
    few, many = (solve(exe, tmp_path / str(n), "loop.torques=14,0,-14,0", "load.tooth_clearance=2e-5", f"load.torque_steps={n}")[0]["lost_motion_rad"]
                 for n in (4, 40))
    assert few == pytest.approx(many, rel=1e-2)


def test_slip_under_a_held_bottom_is_no_gross_slip(exe, tmp_path):
    """The bottom takes what friction does not: a torque beyond any drive ends without convergence or complete, never as gross slip."""
    done = call(exe, ROOT / "data/cd14.nml", "load.torque=5000", "--allow-implausible", "output.vtu=none", "--out", tmp_path / "r", "-q")
    assert "gross slip" not in done.stderr and (done.returncode == 0 or "in the torque step" in done.stderr and "lower load.torque" in done.stderr)


def test_a_rough_tolerance_hides_no_gross_slip(exe, tmp_path):
    """Friction carries 21 N m: at a tolerance of 1e-5 soft springs took the rest of 60, turned by thousands of radians, and the run was complete."""
    done = call(exe, ROOT / "data/cd14.nml", "load.support=bearing", "load.torque=60", "load.torque_steps=1", "solver.tolerance=1e-5", "mesh.divisions=20",
                "mesh.band_facets=4", "output.vtu=none", "--allow-implausible", "--out", tmp_path / "r", "-q")
    assert done.returncode == 4 and "gross slip at T = " in done.stderr


RISE = ["loop.torques=14", "load.torque_steps=4", "joint.model=hu2023", "output.vtu=none"]
NARROW = [*RISE, "geometry.bore_radius=0.015", "bearing.balls=12", "load.tooth_pairs=8"]  # few facets round the axis


def changed_by_large_displacements(said):
    """By how much large displacements change K1 to K3, as a plan says [%]."""
    return float(re.search("kinematics linear: large displacements change K[123] by ([0-9.]+) %, a correction known to [01]", said)[1])


def test_a_planned_drive_promises_k1_to_k3(exe, tmp_path):
    """Limits of K1 to K3 stand in the summary with their errors, a rise alone promises no hysteresis, and Python reads them. Large
    displacements correct them."""
    found = solved(exe, tmp_path / "p", ROOT / "tests/cases/pressed_drive.nml", *NARROW, "run.tolerance=0.2", "bearing.model=given")
    plan, names = found.summary["plan"], ["k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad"]
    assert plan["met"] == "yes" and list(found.limits) == names == found.summary["model_error"]["tolerance_covers"]
    assert found.balls is not None and any("wave generator as the scene says" in line for line in plan["reasons"])
    assert 2 < changed_by_large_displacements("\n".join(plan["reasons"])) < 6
    for name in names:
        limit, error, over = found.limits[name]
        assert 0.004 < error < 0.2 and limit * over == pytest.approx(found.summary["results"][name], rel=1e-9)
    rows = read_csv(tmp_path / "p/plan.csv")
    assert rows["ball_stiffness_n_per_m"].min() > 1e8


@pytest.mark.parametrize("tolerance, chosen", [(0.5, "rigid"), (0.3, "even spring"), (0.02, "on its balls")])
def test_the_plan_takes_the_simplest_wave_generator(exe, tolerance, chosen):
    """A rigid one, an even spring as stiff as all balls, or the balls: what changes K1 to K3 by less than half the tolerance. A rigid one is tried where
    the spring will do."""
    done = call(exe, "--plan", ROOT / "tests/cases/pressed_drive.nml", *NARROW, f"run.tolerance={tolerance}", "solver.kinematics=linear")
    assert done.returncode == 0, done.stderr
    assert f"wave generator {chosen}: an even spring changes K" in done.stdout
    assert ("a rigid one changes K3 by" in done.stdout) == (chosen != "on its balls")


def test_large_displacements_keep_the_balls(exe):
    """A cam that pushes on the ring's own points turns its waves with the ring (K1 of ratio 30 27 % higher): refused where the ring may slide on the cam,
    and a plan that takes large displacements leaves the balls."""
    def answer(*keys):
        return call(exe, ROOT / "tests/cases/pressed_drive.nml", *NARROW, "solver.kinematics=nonlinear", *keys)
    refused = answer("--check", "bearing.balls=0")
    assert refused.returncode == 2 and "solver.kinematics" in refused.stderr and "wave_generator.ring_tangent" in refused.stderr, refused.stderr
    assert answer("--check", "bearing.balls=0", "wave_generator.ring_tangent=follow").returncode == 0
    planned = answer("--plan", "run.tolerance=0.5")
    assert planned.returncode == 0 and "wave generator as the scene says" in planned.stdout, planned.stderr


def test_large_displacements_of_a_drive(exe, tmp_path):
    """Balls slide along the deformed ring: torques balance, energy as under small displacements (to 1 % of friction's), both solvers
    agree, and a shallow cam gives what small displacements give."""
    keys = ["solver.kinematics=nonlinear", "loop.torques=8,0,-8,0"]
    small, *_ = solve(exe, tmp_path / "s", keys[1])
    large, *_ = solve(exe, tmp_path / "a", *keys)
    short = [keys[0], "loop.torques=8,0", "load.torque_steps=2"]
    (ours, loop, *_), (exact, other, *_) = (solve(exe, tmp_path / "b", *short, f"solver.factors={factors}") for factors in ("auto", "exact"))
    np.testing.assert_allclose(other["angle_rad"], loop["angle_rad"], atol=1e-8*np.ptp(loop["angle_rad"]))
    assert abs(large["torque_balance_nm"]) < 1e-5*8
    left = [r["loop_work_j"] - r["loop_stored_j"] - r["loop_dissipated_j"] for r in (small, large)]
    assert abs(left[1] - left[0]) < 0.01*small["loop_dissipated_j"]
    assert ours["von_mises_max_pa"] == pytest.approx(exact["von_mises_max_pa"], rel=1e-6)
    for w, near, far in ((1e-5, 0, 0.003), (2e-4, 0.003, 0.1)):
        key = [f"wave_generator.w={w}", "loop.torques=8"]
        small, large = (solve(exe, tmp_path / "c", *key, f"solver.kinematics={k}")[0]["k3_nm_per_rad"] for k in ("linear", "nonlinear"))
        assert near <= abs(large/small - 1) < far


@pytest.mark.parametrize("kinematics", ["linear", "nonlinear"])
def test_the_balls_do_not_stretch_the_ring(exe, tmp_path, kinematics):
    """A ring that keeps its length stands off the balls near the short axis, at w = 0.95 mm too, unless the cup tilts it in their grooves: a cam without the shrinkage of its mean
    radius by w^2/r pressed them with 330 to 390 N by large displacements."""
    balls = solved(exe, tmp_path / "r", ROOT / "data/drive20_30.nml", "mesh.divisions=36", "mesh.band_facets=4", f"solver.kinematics={kinematics}", "output.vtu=none",
                   "bearing.axial_hold=fast", "load.assembly_steps=1", "load.torque_steps=1", "loop.torques=1", "run.band=.false.").balls
    force, side = (balls[name][balls["step"] == 1] for name in ("force_n", "theta_rad"))
    assert force.max() > 100 and force[abs(np.cos(side)) < 0.5].max() < 0.1*force.max()


def test_pairs_of_large_displacements_are_where_they_belong(exe, tmp_path):
    """K1 to K3 of a coarse size 14 are those of pairs within 1e-8 rad and 1e-8 of the radius of their places and a tolerance of 1e-10, to 3e-7."""
    found = solved(exe, tmp_path / "r", ROOT / "data/drive14.nml", "mesh.divisions=44", "mesh.band_facets=6",
                   "solver.kinematics=nonlinear", "output.vtu=none", "run.band=.false.").summary["results"]
    for name, value in {"k1": 4862.995105467, "k2": 5874.605676580, "k3": 9610.858076923}.items():
        assert found[f"{name}_nm_per_rad"] == pytest.approx(value, rel=3e-7)


def test_a_ring_without_friction_stands_under_large_displacements(exe, tmp_path):
    """Nothing resists its turn: it drifted from round to round of the pairs, and the torque ended with code 4 below 1.1 N m. What holds its
    mean turn takes next to no moment, and few iterations settle a step."""
    steps = solved(exe, tmp_path / "f", ROOT / "data/drive14.nml", "mesh.divisions=32", "mesh.band_facets=4", "load.assembly_steps=2",
                   "load.torque_steps=1", "solver.kinematics=nonlinear", "loop.torques=5,0", "contact.friction=0", "output.vtu=none", "run.band=.false.").steps
    assert abs(steps["ring_spring_torque_nm"]).max() < 1e-3 * 5 and abs(steps["torque_balance_nm"]).max() < 1e-6
    assert steps["iterations"].max() < 20


def test_no_torque_turns_no_bottom(exe, tmp_path):
    """With large displacements the bottom never came to rest in the play of the teeth, drawn to and fro between flanks and contact: code 4."""
    run = solved(exe, tmp_path / "z", ROOT / "data/drive14.nml", "mesh.divisions=32", "mesh.band_facets=4", "load.assembly_steps=2", "load.torque_steps=1",
                 "solver.kinematics=nonlinear", "loop.torques=0,0", "output.vtu=none", "run.band=.false.", "solver.time_limit_s=60")
    assert abs(run.steps["rotation_rad"]).max() < 1e-6


@pytest.mark.parametrize("keys", [["load.tooth_phase=0"], ["load.tooth_gaps=" + ",".join(["4e-4"] * 64), "--allow-implausible"]])
def test_the_bottom_stays_in_the_play_where_the_torque_left_it(exe, tmp_path, keys):
    """Without a torque it lies at the flank that it came from: it lay anywhere in the play, so that K1 missed 2 % and the hysteresis 67 %. Over a play of
    0.4 mm no step led."""
    run = solved(exe, tmp_path / "r", ROOT / "data/drive20_160.nml", "mesh.divisions=24", "mesh.band_facets=4",
                 "load.torque_steps=3", "contact.friction=0.3", *keys, "output.vtu=none", "run.band=.false.")
    loop, teeth = run.loop, run.teeth
    at_rest = [k for k in range(1, len(loop)) if loop["torque_nm"][k] == 0 != loop["torque_nm"][k - 1]]
    assert len(at_rest) == 2
    for k in at_rest:
        mine = (teeth["step"] == loop["step"][k]) & (teeth["flank"] == np.sign(loop["torque_nm"][k - 1]))
        assert abs(teeth["closing_m"][mine].max()) < 1e-12


def test_the_plan_measures_large_displacements_on_the_drive(exe):
    """They correct the limits of K1 to K3 by what they change on the coarse mesh."""
    done = call(exe, "--plan", ROOT / "tests/cases/pressed_drive.nml", *RISE, "run.tolerance=0.03", "bearing.model=given")
    assert done.returncode == 0, done.stderr
    assert 1.5 < changed_by_large_displacements(done.stdout) < 6


def test_clearances_of_single_pairs(exe, tmp_path):
    """The parabola of load.tooth_clearance as a list gives the same loop; a list of both ends tells them apart; a short one is refused."""
    keys = ["load.tooth_pairs=8", "loop.torques=6", "load.torque_steps=2"]
    _, one, _, _ = solve(exe, tmp_path / "a", *keys, "load.tooth_clearance=9e-6")
    _, two, _, _ = solve(exe, tmp_path / "b", *keys, "load.tooth_gaps=9e-6,1e-6,1e-6,9e-6")
    np.testing.assert_allclose(two["angle_rad"], one["angle_rad"], rtol=1e-9)
    *_, teeth = solve(exe, tmp_path / "c", *keys, "load.tooth_gaps=0,0,0,0,0,0,0,1e-3")
    last = teeth[(teeth["step"] == teeth["step"].max()) & (teeth["flank"] == 1)]
    assert last["force_n"][-1] == 0 < last["force_n"][3]
    done = call(exe, ROOT / "tests/cases/pressed_drive.nml", *MESH, *keys, "load.tooth_gaps=1e-6,2e-6", "--out", tmp_path / "d")
    assert done.returncode == 2 and "as many values as pairs" in done.stderr
    pair = ["load.tooth_pairs=2", *keys[1:]]  # a list of one value, which counted as none
    three, four = (solve(exe, tmp_path / "e", *pair, f"load.tooth_gaps={gaps}")[1]["angle_rad"] for gaps in ("9e-6", "9e-6,9e-6"))
    np.testing.assert_allclose(three, four, rtol=1e-9)


def test_where_no_tooth_pushes_there_is_no_tangent(exe, tmp_path):
    """Between the flanks the bottom turns freely: no K_TS and no shares there, which were those of a residual; elsewhere there are."""
    keys = ["load.tooth_clearance=2e-5", "load.torque_steps=2", "loop.torques=6,0,-6", "load.tangent_steps=all"]
    _, loop, *_ = solve(exe, tmp_path / "a", *keys)
    loop = loop[loop["phase"] == "torque"]
    free = loop["pairs_loaded"] == 0
    k_ts = read_csv(tmp_path / "a/steps.csv")["k_ts_bonded_nm_per_rad"][-len(loop):]
    assert free.any() and np.isnan(k_ts[free]).all() and np.isnan(loop["share_cup"][free]).all() and (k_ts[~free] > 0).all()


@pytest.mark.parametrize("torque, number", [(1.0, 1), (4.0, 2), (7.0, None)])
def test_a_rise_that_ends_within_a_chord_is_said(exe, tmp_path, torque, number):
    """K1 of a loop that ends below T1 is another chord than a catalogue's, and so is K2 below T2: the run says which and where it ends."""
    text = warnings_of(exe, tmp_path / "r", f"loop.torques={torque}", "load.torque_steps=2")[1]
    assert ("the rise ends at" in text) == (number is not None)
    assert number is None or f"the rise ends at {torque} N m, below loop.torque_{number} = " in text and f": K{number} is" in text


def test_clearances_of_both_flanks(exe, tmp_path):
    """A drive whose flanks change their clearances, places mirrored, turns under -T as the other under T; a short list is refused."""
    keys = ["load.tooth_pairs=8", "load.torque_steps=2"]
    front, back = "9e-6,4e-6,0,1e-6", "2e-6,1e-6,3e-6,8e-6"

    def mirrored(gaps):
        return ",".join(reversed(gaps.split(",")))
    _, one, _, teeth = solve(exe, tmp_path / "a", *keys, "loop.torques=6", f"load.tooth_gaps={front}", f"load.tooth_gaps_back={back}")
    _, two, _, _ = solve(exe, tmp_path / "b", *keys, "loop.torques=-6", f"load.tooth_gaps={mirrored(back)}", f"load.tooth_gaps_back={mirrored(front)}")
    _, alike, _, _ = solve(exe, tmp_path / "c", *keys, "loop.torques=6", f"load.tooth_gaps={front}")
    np.testing.assert_allclose(two["angle_rad"], -one["angle_rad"], rtol=1e-7)
    np.testing.assert_allclose(alike["angle_rad"], one["angle_rad"], rtol=1e-9)     # a positive torque opens the other flanks
    assert teeth["force_n"].max() > 0
    done = call(exe, ROOT / "tests/cases/pressed_drive.nml", *MESH, *keys, f"load.tooth_gaps={front}", "load.tooth_gaps_back=1e-6,2e-6", "--out", tmp_path / "d")
    assert done.returncode == 2 and "none, or as many values as load.tooth_gaps" in done.stderr


def test_bonded_on_a_rigid_cam_is_k_fts(exe, tmp_path):
    """Without balls, bonded and with closed teeth the bottom turns as in the scene of K_FTS, to 1e-7."""
    keys = ["bearing.balls=0", "contact.mode=bonded", "load.tooth_clearance=0", "load.torque=5", "loop.torques=5",
            "wave_generator.ring_tangent=free"]
    _, loop, _, teeth = solve(exe, tmp_path / "d", *keys)
    folder = tmp_path / "k"
    solved(exe, folder, ROOT / "tests/cases/pressed_drive.nml", *MESH, *keys, "load.support=teeth")
    steps = read_csv(folder / "steps.csv")
    np.testing.assert_allclose(loop["angle_rad"][-1], steps["rotation_rad"][-1], rtol=1e-7)
    np.testing.assert_allclose(teeth["force_n"][-24::2], read_csv(folder / "teeth.csv")["force_n"][-12:], rtol=1e-6)


def test_many_balls_become_an_even_spring(exe, tmp_path):
    """With the sum of all rates kept, the turn settles to 1e-3 as the balls grow in number; few differ several times as much."""
    angle = [solve(exe, tmp_path / f"b{n}", f"bearing.balls={n}", f"bearing.ball_rate={2e11 / n}", "bearing.ball_diameter=0.5e-3",
                   "loop.torques=6", "load.torque_steps=1")[1]["angle_rad"][-1] for n in (12, 17, 24, 48, 96, 150)]
    apart = abs(np.array(angle[:-1]) / angle[-1] - 1)
    assert apart[3:].max() < 1e-3 and apart[3:].max() < 0.3 * apart[:3].max()


def shipped(exe, folder, name, *keys):
    """K1, K2, K3 [N m/rad] and results of a shipped drive on a coarse mesh."""
    r = solved(exe, folder, ROOT / f"data/{name}.nml", "mesh.divisions=48", "mesh.band_facets=6", "load.torque_steps=4",
               "run.band=.false.", *keys).summary["results"]
    assert min(r["flexspline_yield_safety"], r["ring_yield_safety"]) > 1, (name, r["flexspline_yield_safety"], r["ring_yield_safety"])
    return np.array([r[f"k{i}_nm_per_rad"] for i in (1, 2, 3)]), r


def test_shipped_drives_are_those_of_the_catalogue(exe, tmp_path):
    """K1, K2, K3 of sizes 25 and 40 lie within 25 and 20 % of the catalogue's and so do K2/K1, K3/K1, and the catalogue's lie in their 95 % bands; no
    input was fitted to them. Of size 14, which the catalogue makes softer than its size, K3 is a third more, above its band. Hysteresis and lost motion
    stay below an arc minute."""
    for size, of_k, of_ratio in ((14, 0.35, 0.36), (25, 0.25, 0.2), (40, 0.2, 0.2)):
        k, r = shipped(exe, tmp_path / str(size), f"drive{size}", "run.band=auto")
        over = k / UNITS[size].slopes
        low, high = (np.array([r[f"k{i}_nm_per_rad_{end}"] for i in (1, 2, 3)]) / k for end in ("low", "high"))
        inside = (low < 1 / over) & (1 / over < high)
        assert list(inside) == [True, True, size > 14], (size, low, over, high)
        assert abs(over - 1).max() < of_k, (size, over)
        assert abs(over[1:] / over[0] - 1).max() < of_ratio, (size, over)
        assert max(r["hysteresis_rad"], r["lost_motion_rad"]) < np.radians(1 / 60)
        assert r["reference_torque_nm"] == hdengine.read_scene(ROOT / f"data/drive{size}.nml")["load.torque"]


def test_bearings_are_as_wide_as_those_of_their_diameter():
    """6 mm at 35 mm outside, 7 at 42, 9 at 62, within 1 %, in the middle of the rim: size 25 had 10.7 mm."""
    for size, width in ((14, 6e-3), (17, 7e-3), (25, 9e-3)):
        length, start, rim = (hdengine.read_scene(ROOT / f"data/drive{size}.nml")[f"geometry.{key}"] for key in ("band_length", "band_start", "rim_length"))
        assert length == pytest.approx(width, rel=0.01) and 2 * start + length == pytest.approx(rim, rel=1e-5)


def test_other_ratios_and_the_hat(exe, tmp_path):
    """Size 20 lies within 18 % of the catalogue, and ratio 50 over 100 is that of it (0.81, 0.72, 0.79) within 12 %; the silk hat has the cup's K1 to K3
    within 11 %; ratios 30 and 160 run."""
    k, _ = shipped(exe, tmp_path / "100", "drive20")
    half, _ = shipped(exe, tmp_path / "50", "drive20_50")
    np.testing.assert_allclose(k, UNITS[20].slopes, rtol=0.18)
    np.testing.assert_allclose(half / k, [13 / 16, 18 / 25, 23 / 29], rtol=0.12)
    cup, _ = shipped(exe, tmp_path / "14", "drive14")
    hat, _ = shipped(exe, tmp_path / "hat", "drive14_hat")
    np.testing.assert_allclose(hat, cup, rtol=0.11)
    for ratio in (30, 160):
        assert shipped(exe, tmp_path / str(ratio), f"drive20_{ratio}")[0].min() > 0


@pytest.mark.parametrize("name, args", [("drive14_hat", ["14", "--hat"]), ("drive20_30", ["20", "--ratio", "30"])])
def test_shipped_drives_are_written_by_the_command(name, args, tmp_path, monkeypatch):
    """The command writes the files of data/ and replaces none unasked. The clearances of the teeth have four digits, of which another engine's
    last bits move the last."""
    monkeypatch.chdir(tmp_path)
    assert cli.main(["new", *args]) == 0
    made, shipped = ([line.split(" = ") for line in (folder / f"{name}.nml").read_text().splitlines()] for folder in (tmp_path, ROOT / "data"))
    assert len(made) == len(shipped) and any("tooth_gaps" in line[0] for line in made)
    for (key, *value), (other, *stated) in zip(made, shipped):
        assert key == other
        if "tooth_gaps" in key:
            np.testing.assert_allclose(*(np.array(text[0].split(","), float) for text in (value, stated)), rtol=2e-3)
        else:
            assert value == stated
    assert cli.main(["new", *args]) == cli.main(["new", *args, "--out", "none/x.nml"]) == hdengine.FileError.code
    assert cli.main(["new", *args, "run.title=it's 'so'", "mesh.divisions=24", "mesh.band_facets=3", "--out", "t.nml"]) == 0 and hdengine.read_scene("t.nml")["run.title"] == "it's 'so'"
    assert "mesh.band_facets=3' from one" in Path("t.nml").read_text()   # the command that makes it again


def test_any_size_and_ratio_is_built(tmp_path):
    """Sizes and ratios that no file has: K1, K2, K3 within 30 % of the catalogue's on a coarse mesh. The report's figure takes the values of
    that ratio; those of ratio 100 stood beside ratio 50."""
    mesh = {"mesh": {"divisions": 48, "band_facets": 6}, "load": {"torque_steps": 3}, "run": {"band": False}}
    for size, ratio in ((58, 120), (32, 50)):
        result = hdengine.run("", tmp_path / f"{size}", **hdengine.as_built(size, ratio, **mesh))
        known = unit(size, ratio)
        assert abs(np.array([result.k1, result.k2, result.k3]) / known.slopes - 1).max() < 0.3, (size, ratio, result)
        angle, torque = loop_of(result).stated
        assert np.interp(known.t1_nm, torque, angle) == pytest.approx(np.degrees(known.t1_nm / known.k1_nm_per_rad) * 60)


@pytest.mark.parametrize("size", KNOWN)
def test_no_scene_as_built_is_unusual(exe, tmp_path, size):
    """No number of the table is said to be unusual, at either end of the ratios, cup or hat: w at ratio 30 from size 65 on and the hat's hub at 90 were."""
    for ratio in RATIOS:
        for hat in (False, True):
            (tmp_path / "d.nml").write_text(_namelist({group: keys for group, keys in _scene(size, ratio, hat).items() if keys}))
            done = call(exe, tmp_path / "d.nml", "--check")
            assert done.returncode == 0 and "usual" not in done.stdout + done.stderr, (ratio, hat, done.stdout)


@pytest.mark.parametrize("size, clearance", [(11, 7.5e-6), (14, 9e-6), (40, 12.5e-6), (58, 14.5e-6), (65, 16.25e-6), (80, 19e-6), (90, 19e-6)])
def test_the_fit_is_that_of_the_standards(size, clearance):
    """Mean clearance of a bore to H7 (ISO 286: 21, 25, 35, 40, 40, 46, 46 um) and a bearing of normal class (ISO 492: 9, 11, 15, 18, 25, 30, 30 um):
    that of size 11 was the one of 30 to 50 mm, above 150 mm it was that of class 6."""
    assert _scene(size, 100, False)["wave_generator"]["clearance"] == pytest.approx(clearance)


@pytest.mark.parametrize("size, clearance", [(11, 3.125e-6), (14, 3.125e-6), (20, 3.25e-6), (40, 5e-6), (58, 7e-6), (90, 8.875e-6)])
def test_the_balls_have_the_clearance_of_the_standard(size, clearance):
    """A quarter of the mean that ISO 5753-1 gives a normal bearing across its bore (19.3, 24.6, 35.1, 70.3, 102, 158 mm: 12.5, 12.5, 13, 20, 28, 35.5 um):
    half of it to either side, and half of that for the fit on the cam."""
    assert _scene(size, 100, False)["bearing"]["clearance"] == pytest.approx(clearance)


def test_the_catalogue_states_ratio_30():
    """Sizes 14 to 32 have K1 to K3 at ratio 30, larger ones have not; we said that none has."""
    assert list(unit(20, 30).slopes) == [5700, 7100, 11000] and unit(40, 30) is None and unit(20, 31) is None


@pytest.mark.parametrize("size, torques", [(14, (5.4, 7.8, 7.8)), (17, (16, 22, 24)), (20, (25, 34, 40, 40)), (25, (39, 63, 67, 67)), (32, (76, 118, 137, 137))])
def test_rated_torques_are_those_of_another_maker(size, torques):
    """ZD Motor rates its SHF-2UH at ratios 50, 80, 100 and 120 as the series whose table is kept, which another hand typed."""
    assert [rated_torque(size, ratio) for ratio in (50, 80, 100, 120)[:len(torques)]] == pytest.approx(torques)


@pytest.mark.parametrize("size, ratio, torque", [(14, 50, 5.4), (20, 30, 15), (20, 50, 25), (20, 65, 29.5), (20, 200, 40), (40, 30, 137), (90, 100, 2270)])
def test_lost_motion_is_read_at_the_rated_torque_of_the_ratio(size, ratio, torque):
    """Catalogues rate size 20 at 15, 25 and 40 N m at ratios 30, 50 and 100: all were read at 4 % of the last, and ratio 30 had 2.5' in place of 1.3'."""
    scene = _scene(size, ratio, False)
    assert scene["loop"]["rated_torque"] == pytest.approx(torque) and scene["load"]["torque"] > scene["loop"]["torque_2"]


def test_what_is_known_of_a_drive_takes_its_place():
    """A key that is given replaces the table's and the teeth are those of that drive; a wrong one is named, and so is a size that is none."""
    mesh = {"divisions": 24, "band_facets": 3}
    plain = hdengine.as_built(20, 80, mesh=mesh)
    pressed = hdengine.as_built(20, 80, mesh=mesh, wave_generator={"interference": 5e-6}, geometry__wall_thickness="0.6 mm")
    assert pressed["geometry"]["wall_thickness"] == "0.6 mm" and "clearance" not in pressed["wave_generator"]
    assert pressed["geometry"]["rim_thickness"] == pytest.approx(0.6e-3 * 0.427 / 0.36)   # the teeth stiffen the wall that is given
    assert pressed["load"]["tooth_gaps"] != plain["load"]["tooth_gaps"] and pressed["loop"] == plain["loop"]
    asked = hdengine.as_built(20, 80, mesh=mesh, run={"tolerance": 0.1}, turning={"positions": 3})
    assert asked["load"] == plain["load"] and asked["run"]["tolerance"] == 0.1  # what a run is asked for does not touch its assembly
    both = hdengine.as_built(20, 80, mesh=mesh, wave_generator={"interference": 0.0, "clearance": 2e-6}, load={"tooth_clearance": 1e-5})
    assert both["wave_generator"]["clearance"] == 2e-6
    assert hdengine.as_built(20, 80, mesh=mesh, load={"tooth_clearance": 1e-5})["load"].keys() & {"tooth_gaps", "tooth_gaps_back"} == set()
    for args, keys, what in (((21,), {}, "size = 21: must be one of 11, 14"), ((20, 29), {}, "ratio"), ((20,), {"mesh": {"division": 3}}, "mesh.division"),
                             ((20,), {"wave_generator__w": -1}, "wave_generator.w"),
                             ((20,), {"load": {"support": "hub"}}, "load.support = 'hub': must be 'drive'"),
                             ((20,), {"load.teeth": 300}, "load.teeth = 300 with ratio = 100")):
        with pytest.raises(hdengine.InputError, match=what):
            hdengine.as_built(*args, **keys)


def test_every_size_grows_stiffer_and_is_drawn(exe, tmp_path):
    """K2 grows from size 11 to 40; hdengine plot draws loop, twist, loads and life of one."""
    k = [shipped(exe, tmp_path / str(size), f"drive{size}", "mesh.divisions=32", "mesh.band_facets=4")[0][1]
         for size in (11, 17, 25, 40)]
    assert np.all(np.diff(k) > 0)
    names = {p.name for p in plot_run(load(tmp_path / "40"))}
    assert {"loop.png", "twist.png", "loads.png", "fatigue.png"} <= names


def test_a_sliding_ring_is_no_gross_slip(exe, tmp_path):
    """A bearing whose contact slips as a whole under torque converges: the teeth hold the torque. It ended as gross slip of a torque
    far beyond the loop's."""
    solve(exe, tmp_path / "g", *SLIDING)


@pytest.mark.parametrize("keys", [RIDGE, DRIFTING], ids=["ridge", "drifting"])
def test_drives_without_friction_converge(exe, tmp_path, keys):
    """Two that did not: damping kept flanks from touching, and a ring that nothing held round the axis drifted off in the matrix."""
    solve(exe, tmp_path / "f", *keys)


def warnings_of(exe, folder, *keys):
    """The results and all warnings of a drive in one text."""
    results = solve(exe, folder, *keys)
    return results, " ".join(json.loads((folder / "summary.json").read_text())["warnings"])


def test_balls_that_carry_nothing_are_said(exe, tmp_path):
    """A clearance beyond the cam's way leaves every ball unloaded: the run says so."""
    _, text = warnings_of(exe, tmp_path / "w", "bearing.clearance=5e-4", "loop.torques=1", "load.torque_steps=1")
    assert "no ball carries the ring" in text


@pytest.mark.parametrize("interference", [1e-5, 1.01e-5])
def test_open_teeth_are_said_with_their_play(exe, tmp_path, interference):
    """Pairs that all lie 0.1 mm apart leave the bottom a play of 0.2 mm / (cos 25 deg 18.08 mm), where a torque of 0 leaves it at the
    flanks that pushed last; closed teeth leave none."""
    keys = ["load.tooth_pairs=4", "loop.torques=4,0,-4,0", "load.torque_steps=2", f"wave_generator.interference={interference}"]
    (results, *_), text = warnings_of(exe, tmp_path / "o", *keys, "load.tooth_clearance=1e-4")
    play = float(re.search(r"free to turn by (\S+) rad", text)[1])
    assert play == pytest.approx(2e-4 / np.cos(np.radians(25)) / AMID, rel=1e-3)
    assert results["hysteresis_rad"] == pytest.approx(play, rel=2e-2)
    assert "free to turn" not in warnings_of(exe, tmp_path / "c", *keys, "load.tooth_clearance=0")[1]


def test_a_small_torque_leads_across_the_play(exe, tmp_path):
    """Without friction, a torque of -0.1 mN m carries the bottom from one flank to the other in a few iterations."""
    keys = ["contact.mode=frictionless", "load.tooth_pairs=4", "load.tooth_clearance=1e-4", "load.torque_steps=1",
            "loop.torques=0.4,-1e-4,-1.7", "solver.time_limit_s=30"]
    _, loop, *_ = solve(exe, tmp_path / "o", *keys)
    play = 2e-4 / np.cos(np.radians(25)) / AMID
    assert np.diff(loop["angle_rad"])[loop["torque_nm"][1:] == -1e-4] == pytest.approx(-play, rel=5e-2)
    assert read_csv(tmp_path / "o/steps.csv")["iterations"].sum() < 60


def test_a_ball_that_jumps_is_said(exe, tmp_path):
    """A ball that one step of torque loads from nothing to more than a fifth of the largest force is named; finer steps follow it."""
    (_, _, balls, _), text = warnings_of(exe, tmp_path / "j", "loop.torques=80,-80", "load.torque_steps=1", "loop.torque_1=80", "loop.torque_2=90")
    number, force, *ends = re.search(r"ball (\d+) comes or goes with (\S+) N between (\S+) and (\S+) N m", text).groups()
    of_one = balls["force_n"][(balls["ball"] == int(number)) & np.isin(balls["torque_nm"], [float(t) for t in ends])][-2:]
    assert of_one.min() == 0 and of_one.max() == pytest.approx(float(force), rel=1e-5)
    assert float(force) > 0.2 * balls["force_n"].max()
    assert "comes or goes" not in warnings_of(exe, tmp_path / "f", "loop.torques=80,-80", "load.torque_steps=20")[1]


def test_torque_beyond_ratcheting_is_said(exe, tmp_path):
    """A torque at which loaded pairs move out of mesh by more than w is called one that would ratchet, and implausible."""
    text = warnings_of(exe, tmp_path / "r", "loop.torques=1200", "--allow-implausible")[1]
    assert "would ratchet" in text and "loop.torques = 1200.0 N m: drives of this bore hold some 54.0 N m" in text
    assert "would ratchet" not in warnings_of(exe, tmp_path / "s", "loop.torques=14")[1]


def test_a_cam_that_does_not_go_with_the_teeth_is_said(exe, tmp_path):
    """Three times as many teeth need a third of w: the moment on the cam is too large for their ratio, and the run says why."""
    keys = ["loop.torques=14", "load.torque_steps=2"]
    assert "on the cam" not in warnings_of(exe, tmp_path / "a", *keys)[1]
    text = warnings_of(exe, tmp_path / "b", *keys, "load.teeth=600", "load.tooth_pairs=36")[1]
    assert "does not go with load.teeth = 600" in text and "support 'hub'" not in text


# balls of 3.3 mm take the cage along by 5/9: one ball follows the next of 12 after 30 teeth
TURNING = ["bearing.ball_diameter=3.3e-3", "loop.torques=1", "load.torque_steps=1", "turning.torque=6", "solver.tolerance=1e-11"]


def turned(exe, folder, *keys):
    solve(exe, folder, *TURNING, *keys)
    return read_csv(folder / "turning.csv")


def test_turning_repeats_after_a_ball(exe, tmp_path):
    """Turned on by one ball, which is 30 teeth here, the drive has the same turn, stiffness and forces again, to 1e-7."""
    pitch = 360 / 12 * 9 / 5 / 1.01
    rows = turned(exe, tmp_path / "t", "turning.positions=4", f"turning.range_deg={2 * pitch!r}")
    np.testing.assert_allclose(rows["cage_angle_deg"], [0, 345, 330, 315], atol=1e-9)
    np.testing.assert_allclose(np.diff(rows["wave_generator_deg"]), pitch / 2)
    for column in ("turn_rad", "stiffness_nm_per_rad", "wave_generator_torque_nm", "ball_force_max_n", "tooth_force_max_n"):
        np.testing.assert_allclose(rows[column][2:], rows[column][:2], rtol=1e-7)
    assert abs(rows["turn_rad"][1] / rows["turn_rad"][0] - 1) > 1e-4
    results = json.loads((tmp_path / "t/summary.json").read_text())["results"]
    assert results["turning_angle_error_rad"] == pytest.approx(np.ptp(rows["turn_rad"]))


def test_a_place_is_read_at_half_and_all_of_the_torque(exe, tmp_path):
    """The first place is the drive itself, whose loop has the same turn and slope, whatever torques its catalogue reads at."""
    row = turned(exe, tmp_path / "t", "turning.positions=1", "loop.torque_1=2.7", "loop.torque_2=5")[0]
    solve(exe, tmp_path / "l", *TURNING[:1], *TURNING[4:], "loop.torques=6", "load.torque_steps=2", "loop.torque_1=7", "loop.torque_2=8")
    (half, all_), angle = read_csv(tmp_path / "l/loop.csv")["torque_nm"][-2:], read_csv(tmp_path / "l/loop.csv")["angle_rad"][-2:]
    assert (half, all_) == (3, 6) and row["turn_rad"] == pytest.approx(angle[1], rel=1e-3)
    assert row["stiffness_nm_per_rad"] == pytest.approx(3 / (angle[1] - angle[0]), rel=2e-3)


def test_turning_is_symmetric(exe, tmp_path):
    """The mirror image of a place is the place as far the other way under the opposite torque: turns are opposite, the rest equal."""
    plus = turned(exe, tmp_path / "p", "turning.positions=5")
    minus = turned(exe, tmp_path / "m", "turning.positions=5", "turning.torque=-6")
    order = [0, 4, 3, 2, 1]
    np.testing.assert_allclose(minus["turn_rad"], -plus["turn_rad"][order], rtol=1e-7)
    for column in ("stiffness_nm_per_rad", "ball_force_max_n", "tooth_force_max_n", "balls_loaded", "pairs_loaded"):
        np.testing.assert_allclose(minus[column], plus[column][order], rtol=1e-6)


def test_turned_condensed_model_is_that_of_the_matrix(exe, tmp_path):
    """Places that reuse the condensed bodies give the numbers of a matrix that is made anew for each, to 1e-8."""
    ours, other = (turned(exe, tmp_path / method, "turning.positions=2", f"solver.method={method}") for method in ("condensed", "newton"))
    for column in ("turn_rad", "stiffness_nm_per_rad", "ball_force_max_n", "tooth_force_max_n"):
        np.testing.assert_allclose(ours[column], other[column], rtol=1e-8)


def test_turning_leaves_the_loop_as_it_is(exe, tmp_path):
    """A loop and its summary are the same whether the wave generator turns afterwards or not; the model that is kept is the loop's."""
    still, _, _, _ = solve(exe, tmp_path / "a", "loop.torques=6,0", "load.torque_steps=2")
    moved, _, _, _ = solve(exe, tmp_path / "b", "loop.torques=6,0", "load.torque_steps=2", "turning.positions=2")
    assert {k: v for k, v in moved.items() if not k.startswith("turning_")} == still
    for name in ("loop.csv", "balls.csv", "teeth.csv", "fatigue.csv", "steps.csv"):
        a, b = (read_csv(tmp_path / f / name) for f in "ab")
        assert all(np.array_equal(a[c], b[c], equal_nan=a[c].dtype.kind == "f") for c in a.dtype.names if c != "seconds"), name


def test_turning_is_drawn_and_asked_for_with_a_drive_only(exe, tmp_path):
    """The turn is drawn from Python's run too; another support refuses turning.positions."""
    keys = dict(k.split("=") for k in [*MESH, *TURNING, "turning.positions=3"])
    result = hdengine.run(ROOT / "tests/cases/pressed_drive.nml", tmp_path / "r", True, **keys)
    assert len(result.turning) == 3 and "turning.png" in {p.name for p in plot_run(result)}
    done = call(exe, ROOT / "data/cd14.nml", "turning.positions=3", "--out", tmp_path / "c")
    assert done.returncode == 2 and "turning.positions = 3" in done.stderr and "load.support = 'drive'" in done.stderr


def test_contact_table_of_one_step(exe, tmp_path):
    """With output.contact = 'last' contact.csv holds the step of the results alone, with the same bytes, and Python says so."""
    for steps in ("all", "last"):
        solve(exe, tmp_path / steps, f"output.contact={steps}")
    whole, one = load(tmp_path / "all"), load(tmp_path / "last")
    lines = (tmp_path / "last/contact.csv").read_text().splitlines(keepends=True)
    row = int(lines[1].split(",")[0]) - 1
    assert whole.torque_nm[row] == max(whole.torque_nm) and row < len(whole.steps) - 1 and len(lines) == 1 + whole.shape[0] * whole.shape[1]
    assert "".join(lines[1:]) in (tmp_path / "all/contact.csv").read_text()
    assert all(np.array_equal(column, whole.contact_at(row)[name]) for name, column in one.contact_at(row).items())
    assert np.array_equal(one.row_edges(), whole.row_edges()) and [i for i, r in enumerate(one.rows()) if "shear_long_1_pa" in r] == [row]
    for ask in (lambda: one.contact, lambda: one.contact_at(0)):
        with pytest.raises(hdengine.InputError, match="output.contact = 'last'"):
            ask()


def test_tangents_and_times_of_a_loop(exe, drive, tmp_path):
    """A loop has a tangent where its torque is largest, the same as among tangents in all steps; the parts of its time add up to the total."""
    found = {}
    for steps in ("needed", "all", "none"):
        results = solve(exe, tmp_path / steps, f"load.tangent_steps={steps}")[0]
        found[steps] = load(tmp_path / steps).steps["k_ts_bonded_nm_per_rad"]
        assert results | {"k_ts_bonded_nm_per_rad": 0, "k_ts_contact_nm_per_rad": 0, "twist_shares": 0} == drive[0] | {
            "k_ts_bonded_nm_per_rad": 0, "k_ts_contact_nm_per_rad": 0, "twist_shares": 0}
        assert steps == "none" or results == drive[0]
        times = json.loads((tmp_path / steps / "summary.json").read_text())["timers_s"]
        assert sum(times.values()) == pytest.approx(2 * times["total"], rel=1e-9) and min(times.values()) >= 0
    known = np.isfinite(found["needed"])
    assert list(np.flatnonzero(known)) == [7] and np.all(found["needed"][known] == found["all"][known])
    assert np.isfinite(found["all"][3:]).sum() > 10 and np.isnan(found["none"]).all()
    refused = call(exe, ROOT / "data/drive14.nml", "load.tangent_steps=none", "run.band=.true.", "--out", tmp_path / "no")
    assert refused.returncode == 2 and "load.tangent_steps = 'none'" in refused.stderr
