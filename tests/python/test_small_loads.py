# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes at the ends: little torque, no contact, nothing that holds, a torque that no drive bears; and first steps that take long."""
import csv
from itertools import product

import pytest

import hdengine
from conftest import CD14, ROOT, SMALL, call, solved


def solve(exe, folder, *keys):
    done = call(exe, CD14, *SMALL, *keys, "output.vtu=none", "--out", folder, "-q")
    return done, hdengine.load(folder) if done.returncode == 0 else None


@pytest.mark.parametrize("torque", [1e-4, 1e-3, 0.156])
def test_small_torques_under_large_displacements(exe, tmp_path, torque):
    """Pairs are found to rounding, so that moments balance to a thousandth of any torque; the rotation is in proportion to it."""
    done, r = solve(exe, tmp_path / "t", "solver.kinematics=nonlinear", "wave_generator.ring_tangent=follow", f"load.torque={torque}")
    assert done.returncode == 0, done.stderr
    assert abs(r.steps["torque_balance_nm"][-1]) < 1e-3 * torque
    assert r.steps["rotation_rad"][-1] / torque == pytest.approx(1.13e-6, rel=0.05)


@pytest.mark.parametrize("kinematics", ["linear", "nonlinear"])
def test_bodies_that_do_not_touch(exe, tmp_path, kinematics):
    """A ring with clearance, moved as a whole, has no forces but rounding: it converges, without contact, and the cup alone takes the torque."""
    done, r = solve(exe, tmp_path / "n", "wave_generator.w=0", "wave_generator.eccentricity=5e-6", "wave_generator.clearance=10e-6",
                    f"solver.kinematics={kinematics}")
    assert done.returncode == 0, done.stderr
    assert r.steps["normal_force_n"].max() == 0 and r.steps["rotation_rad"][-1] > 1e-5


def test_torque_on_faces_that_touch_without_pressure(exe, tmp_path):
    """Shapes formed alike, without interference: the torque step is in proportion to the torque, is not halved, and may take more than the 60
    iterations of a step with a state to start from: more friction from the solution with less."""
    done, r = solve(exe, tmp_path / "f", "wave_generator.shape=as_formed", "wave_generator.w=0.110339e-3", "wave_generator.interference=0",
                    "geometry.wall_thickness=0.189373e-3", "geometry.rim_thickness=0.246833e-3", "geometry.ring_thickness=0.135968e-3",
                    "contact.friction=0.291419", "load.torque=-0.0406737", "mesh.divisions=24", "mesh.ring_divisions=33", "mesh.ring_facets=5",
                    "mesh.wall_elements=4", "mesh.bottom_elements=3", "load.assembly_steps=2", "load.torque_steps=1")
    assert done.returncode == 0, done.stderr
    assert r.steps["iterations"][2] > 60 and abs(r.steps["torque_balance_nm"]).max() < 1e-4 * 0.04


def test_torque_presses_faces_that_fit(exe, tmp_path):
    """Random scene 260 of seed 2026: the torque alone presses two faces formed alike. Newton's method fails with all of the
    friction, and finds the solution from one with a five-hundredth of it; no step is halved."""
    done, r = solve(exe, tmp_path / "f", "geometry.wall_thickness=0.150807e-3", "geometry.ring_thickness=0.254397e-3", "geometry.rim_thickness=0.183627e-3",
                    "mesh.divisions=40", "mesh.band_facets=5", "mesh.ring_divisions=53", "mesh.ring_facets=6", "mesh.wall_elements=4", "mesh.bottom_elements=3",
                    "wave_generator.w=0.272221e-3", "wave_generator.cam=cosine", "wave_generator.interference=0", "wave_generator.shape=as_formed",
                    "contact.friction=0.107336", "load.torque=27.1626", "load.torque_load=teeth", "load.assembly_steps=2", "load.torque_steps=1")
    assert done.returncode == 0, done.stderr
    assert len(set(r.history["attempt"])) == 1 and abs(r.steps["torque_balance_nm"]).max() < 1e-4 * 27


def test_faces_pressed_by_the_torque_alone_slide_at_any(exe, tmp_path):
    """Scene 130: without a pressure from the assembly friction holds no share of the torque, so no torque is named at which it slips."""
    done, _ = solve(exe, tmp_path / "s", "geometry.wall_thickness=0.280674e-3", "geometry.ring_thickness=1.38344e-3", "geometry.rim_thickness=0.496622e-3",
                    "mesh.divisions=40", "mesh.band_facets=5", "mesh.wall_elements=4", "mesh.bottom_elements=3", "wave_generator.w=2.23835e-6",
                    "wave_generator.cam=cosine", "wave_generator.eccentricity=13.4141e-6", "wave_generator.eccentricity_angle_deg=88.288",
                    "wave_generator.interference=0", "wave_generator.shape=as_formed", "contact.friction=0.439655", "load.support=bearing",
                    "load.torque=-33.0336", "load.torque_load=teeth", "load.assembly_steps=2", "load.torque_steps=3")
    assert done.returncode == 4 and "not held: beyond torque 0.0 N m" in done.stderr


@pytest.mark.parametrize("mesh", [(), ("mesh.divisions=32", "mesh.band_facets=6")])
def test_nothing_holds_the_cup(exe, tmp_path, mesh):
    """Without interference nothing takes the torque of a bearing support: said at once on any mesh, not after hundreds of iterations, and
    never as the torque at which friction gives way."""
    done, _ = solve(exe, tmp_path / "h", *mesh, "wave_generator.w=0", "wave_generator.interference=0", "load.support=bearing")
    assert done.returncode == 4 and "not held" in done.stderr
    assert len((tmp_path / "h/history.csv").read_text().splitlines()) < 20


def test_first_step_is_not_halved(exe, tmp_path):
    """From rest a linear scene is as hard at any share of the load: where it fails it is tried with less friction, but not in halves."""
    done, _ = solve(exe, tmp_path / "p", "solver.max_iterations=3", "load.torque_steps=0")
    assert done.returncode == 4 and "after 3 iterations, with less friction too" in done.stderr
    with (tmp_path / "p/history.csv").open() as f:
        history = list(csv.DictReader(f))
    assert max(int(row["iteration"]) for row in history) > 3 and {row["attempt"] for row in history} == {"0"}


@pytest.mark.parametrize("interference", [0, 10e-6])
def test_a_torque_that_no_drive_bears_ends(exe, tmp_path, interference):
    """A cup at its hub under 1e5 N m turns without end: said after the halvings that a load step has, not after 50 000 attempts whose
    shares differ in the last place."""
    done, _ = solve(exe, tmp_path / "b", "load.torque=1e5", "--allow-implausible", f"wave_generator.interference={interference}")
    assert done.returncode == 4 and "bodies move by more than" in done.stderr and "lower load.torque" in done.stderr
    with (tmp_path / "b/history.csv").open() as f:
        assert max(int(row["attempt"]) for row in csv.DictReader(f)) < 100


@pytest.mark.parametrize("torque", [1e-8, 3e-6])
def test_a_tiny_torque_finds_its_states(exe, tmp_path, torque):
    """Below the tolerance of the assembly's forces the first guess of a torque is no answer: tangent and rotation per N m are those of 1e-3 N m."""
    one, tiny = (solve(exe, tmp_path / str(t), f"load.torque={t}", "load.torque_steps=1")[1] for t in (1e-3, torque))
    assert tiny.steps["iterations"][-1] > 0
    assert tiny.steps["k_ts_bonded_nm_per_rad"][-1] == pytest.approx(one.steps["k_ts_bonded_nm_per_rad"][-1], rel=1e-3)
    assert tiny.steps["rotation_rad"][-1] / torque == pytest.approx(one.steps["rotation_rad"][-1] / 1e-3, rel=1e-2)


@pytest.mark.parametrize("friction", [1e-12, 1e-10])
def test_friction_below_the_tolerance_is_none(exe, tmp_path, friction):
    """The tangent is that without friction, and the contact alone has none."""
    none, tiny = (solve(exe, tmp_path / str(mu), f"contact.friction={mu}", "load.torque_steps=1")[1] for mu in (0, friction))
    assert tiny.steps["k_ts_bonded_nm_per_rad"][-1] == pytest.approx(none.steps["k_ts_bonded_nm_per_rad"][-1], rel=1e-6)
    for run in (none, tiny):
        assert run.summary["results"]["k_ts_contact_nm_per_rad"] is None


CONDENSED, COARSER, GMRES, LU = (("method=condensed",), ("method=condensed", "start=coarser"), ("method=newton", "factors=harmonic"),
                                 ("method=newton", "factors=exact"))
PATHS = [(*solver, f"symmetry={part}", f"tolerance={tolerance}") for solver, part, tolerance in product(
    (CONDENSED, COARSER, GMRES, LU), ("full", "half"), ("1e-6", "1e-8", "1e-10")) if (solver, part) != (LU, "half")]


@pytest.mark.parametrize(("scene", "keys", "paths", "known"), [
    ("cd14", ("load.torque_steps=0",), PATHS, "bonded contact"), ("cd14", ("load.torque=-5", "load.torque_steps=2"), PATHS[::4], "bonded contact"),
    ("cd14", ("contact.mode=frictionless", "load.torque_steps=0"), PATHS[::4], "bonded"),
    ("cd14", ("contact.friction=0", "load.torque_steps=1"), PATHS[::4], "bonded"),
    ("drive14", ("loop.torques=-6", "load.torque_steps=1"), [PATHS[0], PATHS[2], PATHS[-2]], "bonded contact shares"),
    ("drive14", ("loop.torques=1", "load.torque_steps=1", "contact.friction=0"), [PATHS[0], PATHS[2], PATHS[-1]], "bonded shares"),
    ("drive14", ("load.torque_steps=0",), [PATHS[0], PATHS[2], PATHS[-1]], "")])
def test_the_tangent_does_not_depend_on_the_path(exe, tmp_path, scene, keys, paths, known):
    """Points at the bound may hold or slip on, without torque all of them: solver, symmetry and tolerance give one tangent, of both readings, and
    one part of each body. Where nothing takes torque the reading is null: a contact without friction, a drive within its play."""
    found, mesh = [], ("mesh.divisions=32", "mesh.band_facets=6") if scene == "cd14" else (*SMALL[:2], "run.band=.false.")
    for path in paths:
        r = solved(exe, tmp_path / "p", ROOT / f"data/{scene}.nml", *mesh, *keys, "output.vtu=none", *(f"solver.{key}" for key in path)).summary["results"]
        found.append({name: r[f"k_ts_{name}_nm_per_rad"] for name in ("bonded", "contact")} | {"shares": r.get("twist_shares", {"none": None})})
    for name in ("bonded", "contact", "shares"):
        for one in found:
            if name in known:
                assert one[name] == pytest.approx(found[0][name], rel=1e-5, abs=1e-6)
            else:
                assert set(one[name].values() if name == "shares" else [one[name]]) == {None}
