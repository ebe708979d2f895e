# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction of the tooth flanks in the whole drive (docs/explain/drive.md)."""
import json

import numpy as np
import pytest

import hdengine
from conftest import ROOT, call, solved, stopped_and_whole
from hdengine.table_file import read_csv

MESH = ["mesh.divisions=24", "mesh.band_facets=4", "bearing.balls=12", "load.tooth_pairs=12", "output.vtu=none",
        "load.torque_steps=4"]
MU = 0.1
RUB = f"load.tooth_friction={MU}"
CLOSED = ["load.tooth_clearance=0", "load.torque_steps=7", "loop.torques=14"]
ANGLE = np.radians(25)
COLUMNS = (("loop", ("angle_rad", "stored_j", "dissipated_j", "dissipated_teeth_j")), ("balls", ("force_n",)),
           ("teeth", ("force_n", "closing_m", "friction_n")))


def solve(exe, folder, *keys):
    """Results and tables of a small drive."""
    results = solved(exe, folder, ROOT / "tests/cases/pressed_drive.nml", *MESH, *keys).summary["results"]
    return {"results": results} | {name: read_csv(folder / f"{name}.csv") for name in ("loop", "balls", "teeth")}


@pytest.fixture(scope="module")
def rubbing(exe, tmp_path_factory):
    return solve(exe, tmp_path_factory.mktemp("rub") / "a", RUB)


def test_flanks_rub_by_coulomb(rubbing):
    """No flank rubs with more than mu F, an open one not at all; some slide, at mu F, and after a reversal some stick."""
    teeth = rubbing["teeth"]
    pushes, bound = teeth["force_n"] > 0, MU * teeth["force_n"]
    assert np.all(abs(teeth["friction_n"]) <= bound * (1 + 1e-9) + 1e-12) and np.all(teeth["friction_n"][~pushes] == 0)
    slides = pushes & (abs(teeth["friction_n"]) >= bound * (1 - 1e-9))
    assert np.any(slides) and np.any(pushes & ~slides)


def test_torque_of_forces_and_friction(exe, tmp_path):
    """Forces along the normals and friction along the flanks together make the torque at the radius amid the teeth."""
    run = solve(exe, tmp_path / "t", RUB, "load.torque_steps=2", "solver.tolerance=1e-10")
    teeth = run["teeth"]
    around = teeth["flank"] * (teeth["force_n"] * np.cos(ANGLE) - teeth["friction_n"] * np.sin(ANGLE))
    torque = around.reshape(-1, 24).sum(axis=1) * 18.08325e-3
    np.testing.assert_allclose(torque, run["loop"]["torque_nm"][-len(torque):], rtol=1e-7, atol=1e-7)
    assert np.all(abs(read_csv(tmp_path / "t/steps.csv")["torque_balance_nm"]) < 1e-6)


def test_little_friction_is_none(exe, tmp_path):
    """With mu = 1e-7 angle and forces are those without friction to 1e-6, and hardly any work is lost at the flanks."""
    keys = ["loop.torques=8,3", "solver.tolerance=1e-11"]
    none, little = solve(exe, tmp_path / "n", *keys), solve(exe, tmp_path / "l", *keys, "load.tooth_friction=1e-7")
    for name, column in (("loop", "angle_rad"), ("loop", "stored_j"), ("balls", "force_n"), ("teeth", "force_n")):
        a, b = none[name][column], little[name][column]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-6 * abs(a).max(), err_msg=column)
    assert 0 < little["results"]["loop_dissipated_teeth_j"] < 1e-5 * none["results"]["loop_dissipated_j"]
    assert none["results"]["loop_dissipated_teeth_j"] == 0 and not np.any(none["teeth"]["friction_n"])


@pytest.mark.parametrize("more", [[], ["load.spline=free"], ["solver.kinematics=nonlinear"]])
def test_matrix_gives_the_same_numbers(exe, tmp_path, more):
    """Newton's whole matrix and condensation agree to 1e-8 in angle, and in forces, friction and work: to 1e-8 where pairs stay, to 1e-7
    where they move."""
    keys = [RUB, "loop.torques=8,-3", "load.torque_steps=3", "solver.tolerance=1e-11", "wave_generator.eccentricity=5e-6", "bearing.balls=11", *more]
    ours, other = solve(exe, tmp_path / "c", *keys), solve(exe, tmp_path / "n", *keys, "solver.method=newton", "solver.factors=exact")
    names = [json.loads((tmp_path / f / "summary.json").read_text())["model"]["solver"] for f in "cn"]
    assert "condensed" in names[0] and "MUMPS" in names[1]
    assert ours["results"]["loop_dissipated_teeth_j"] > 0
    for name, columns in COLUMNS:
        for column in columns:
            a, b = ours[name][column], other[name][column]
            near = 1e-7 if "solver.kinematics=nonlinear" in more and column != "angle_rad" else 1e-8
            np.testing.assert_allclose(a, b, rtol=0, atol=near * abs(a).max(), err_msg=column)


def test_energy_balances(exe, tmp_path):
    """Work of the torque = heat of contact and flanks + change of the stored energy, to 1 % over the loop, also on an elastic circular
    spline."""
    for more in ([], ["load.spline=free"]):
        run = solve(exe, tmp_path / "e", RUB, "loop.torques=1,14,1,-1,-14,-1,0", "load.torque_steps=12", *more)
        loop = run["loop"]
        assert np.all(np.diff(loop["dissipated_teeth_j"]) >= 0) and loop["dissipated_teeth_j"][-1] > 0.2 * loop["dissipated_j"][-1]
        left = loop["work_j"] - loop["stored_j"] - loop["dissipated_j"]
        assert abs(left[-1]) < 0.01 * loop["dissipated_j"][-1]


def test_few_steps_are_as_good_as_many(exe, tmp_path):
    """Friction follows a path: four steps up to a torque give angle and heat of sixteen to 2 and 5 %."""
    keys = [RUB, "loop.torques=12"]
    few, many = (solve(exe, tmp_path / "s", *keys, f"load.torque_steps={n}")["loop"] for n in (4, 16))
    assert few["angle_rad"][-1] == pytest.approx(many["angle_rad"][-1], rel=0.02)
    assert few["dissipated_teeth_j"][-1] == pytest.approx(many["dissipated_teeth_j"][-1], rel=0.05)


def test_friction_tilts_the_forces_alone(exe, tmp_path):
    """On the first rise of closed teeth every flank slides. Friction tilts its force by atan mu, as so much less pressure angle does, but not
    the way on which the pair closes: K1 to K3 rise by about half of what that angle does."""
    tilted = 25 - np.degrees(np.arctan(MU))
    runs = {name: solve(exe, tmp_path / "b", *CLOSED, *keys) for name, keys in {
        "none": [], "rub": [RUB], "tilted": [f"load.pressure_angle_deg={tilted}"]}.items()}
    k = {name: np.array([run["results"][f"k{i}_nm_per_rad"] for i in (1, 2, 3)]) for name, run in runs.items()}
    share = (k["rub"] - k["none"]) / (k["tilted"] - k["none"])
    assert np.all((share > 0.5) & (share < 0.6))


@pytest.mark.parametrize("friction", [0, 0.2])
def test_what_the_contact_takes_of_a_twist(exe, tmp_path, friction):
    """K_TS and the contact's part of a further twist give the slope of the loop, on a joint that hardly gives way and no finer steps: flanks
    that rub have no reciprocity, but what the contact adds is known."""
    (tmp_path / "k.csv").write_text("pressure_pa,k_n_pa_per_m,k_t_pa_per_m\n1e2,1e12,1e12\n1e9,1e19,1e19\n")
    run = solve(exe, tmp_path / "a", f"load.tooth_friction={friction}", "loop.torques=13.99,14", "joint.model=table", f"joint.table_file={tmp_path / 'k.csv'}",
                "solver.tolerance=1e-11", "wave_generator.clearance=9e-6")
    loop, results = run["loop"], run["results"]
    slope = (loop["torque_nm"][-1] - loop["torque_nm"][-3]) / (loop["angle_rad"][-1] - loop["angle_rad"][-3])
    contact = sum(results["twist_shares"][part] for part in ("gaps", "slip", "joint"))
    assert contact > 0.2 and results["k_ts_bonded_nm_per_rad"] * contact == pytest.approx(slope, rel=2e-3)


@pytest.mark.parametrize("rows", [2, 10, 25, 39])
def test_a_stopped_loop_goes_on_to_the_same_numbers(exe, tmp_path, rows):
    """Stopped by a signal in assembly, rise, fall or rise: --resume ends with the same tables, to the byte."""
    stopped_and_whole(exe, [*MESH, RUB, "load.torque_steps=10"], rows, tmp_path)


def test_turned_drives_rub_too(exe, tmp_path):
    """At places of the turning wave generator flanks begin without friction; the kept model gives the numbers of a new matrix."""
    keys = [*MESH, RUB, "loop.torques=6,0", "load.torque_steps=2", "turning.positions=2"]
    tables = []
    for method in ("condensed", "newton"):
        solved(exe, tmp_path / method, ROOT / "tests/cases/pressed_drive.nml", *keys, f"solver.method={method}")
        tables.append(read_csv(tmp_path / method / "turning.csv"))
    for column in ("turn_rad", "stiffness_nm_per_rad", "tooth_force_max_n"):
        np.testing.assert_allclose(tables[0][column], tables[1][column], rtol=1e-7)


@pytest.mark.parametrize("seed", range(20))
def test_random_drives_rub_by_their_law(exe, tmp_path, seed):
    """A random drive with friction of its flanks converges, or says why not. No flank rubs with more than mu F, all moments balance, and flanks
    give no heat back."""
    r = np.random.default_rng([36, seed])
    mu = r.uniform(0.02, 0.3)
    keys = {"load.tooth_friction": mu, "contact.friction": r.uniform(0.03, 0.4), "wave_generator.w": r.uniform(0.1e-3, 0.3e-3),
            "wave_generator.interference": r.uniform(0, 3e-5), "bearing.balls": r.choice([0, 8, 11, 19]), "bearing.cage_angle_deg": r.uniform(0, 30),
            "load.pressure_angle_deg": r.uniform(0, 40), "load.tooth_pairs": 2 * r.integers(3, 20), "load.tooth_clearance": r.uniform(0, 3e-5),
            "load.tooth_stiffness": 10 ** r.uniform(7.5, 8.5), "load.spline": r.choice(["rigid", "free"]), "load.torque_steps": 3,
            "loop.torques": f"{r.uniform(1, 15):.3g},{r.uniform(-15, 15):.3g}", "load.tooth_phase": r.uniform(-0.5, 0.5)}
    done = call(exe, ROOT / "tests/cases/pressed_drive.nml", *MESH, *(f"{k}={v}" for k, v in keys.items()), "--out", tmp_path / "r", "-q")
    if done.returncode == 4:
        assert "no convergence" in done.stderr or "run in a cycle" in done.stderr
        return
    assert done.returncode == 0, done.stderr
    teeth, loop, steps = (read_csv(tmp_path / "r" / f"{name}.csv") for name in ("teeth", "loop", "steps"))
    assert np.all(abs(teeth["friction_n"]) <= mu * teeth["force_n"] * (1 + 1e-9))
    assert np.all(np.diff(loop["dissipated_teeth_j"]) >= -1e-15)
    assert np.all(abs(steps["torque_balance_nm"]) < 1e-4 * abs(loop["torque_nm"]).max())


def test_a_kept_model_learns_and_forgets_friction(tmp_path):
    """Runs in one process with and without friction give the same bits whichever came before."""
    keys = dict(k.split("=") for k in [*MESH, "loop.torques=8,-3", "load.torque_steps=2"])
    angles = {}
    for mu in (0, MU, 0.2, 0, MU):
        angle = hdengine.run(ROOT / "tests/cases/pressed_drive.nml", tmp_path / "r", True, **keys, **{"load.tooth_friction": mu}).loop["angle_rad"]
        np.testing.assert_array_equal(angle, angles.setdefault(mu, angle))
    assert len({angle[-1] for angle in angles.values()}) == 3


def test_other_supports_refuse_it(exe):
    """Without struts for its flanks a scene has no friction there."""
    done = call(exe, ROOT / "data/cd14.nml", RUB, "--check")
    assert done.returncode == 2 and "load.tooth_friction = 0.1" in done.stderr and "load.support = 'drive'" in done.stderr
