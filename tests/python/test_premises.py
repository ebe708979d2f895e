# SPDX-License-Identifier: GPL-3.0-or-later
"""Which K_TS: tangent and secant of the coupled joint, what they mean, and what a run warns of (docs/explain/k_ts.md)."""
import json
import re

import numpy as np
import pytest

import hdengine
from conftest import CD14, HELD, PAPER, ROOT, call, solved
from hdengine import Joint

SMALL = {"mesh__divisions": 32, "mesh__band_facets": 6}
TANGENT, SECANT, OVER = "k_ts_bonded_nm_per_rad", "k_ts_secant_nm_per_rad", "k_fe_secant_nm_per_rad"


def sums(**keys):
    """Sums of the steps from the end of the assembly on; those solved where the run ends in gross slip."""
    with hdengine.Run(PAPER, **{**HELD, **SMALL, **keys}) as run:
        steps = []
        try:
            steps.extend(run)
        except hdengine.NotConvergedError:
            steps = [*steps, run.step()]
    return [s.sums for s in steps if s.sums["in_torque"] or s.sums["load_factor"] >= 1 - 1e-9]


@pytest.mark.parametrize("support", ["hub", "bearing"])
def test_tangent_is_the_slope_of_the_coupled_run(support):
    """1/K_TS is the slope of the rotation with the joint as contact law less that with glued faces: between two near torques to 1e-4."""
    keys = {"load__support": support, "load__torque": 2.0, "load__torque_steps": 40}
    steps = sums(contact__law="joint", **keys)
    glued = sums(contact__mode="bonded", **keys)[-1]
    glued = glued["rotation_rad"] / glued["torque_nm"]
    for one, two in ((steps[1], steps[2]), (steps[20], steps[21]), (steps[39], steps[40])):
        slope = (two["rotation_rad"] - one["rotation_rad"]) / (two["torque_nm"] - one["torque_nm"])
        assert 2 / (1 / one[TANGENT] + 1 / two[TANGENT]) == pytest.approx(1 / (slope - glued), rel=1e-4)
    assert steps[-1][SECANT] == pytest.approx(1 / (1 / steps[-1][OVER] - glued), rel=1e-4)  # both are 17 times the difference


def test_hard_contact_gives_nearly_the_numbers_of_the_coupled_law():
    """With hard contact the joint is taken at its pressures: tangent and secant within 5 % of those with the joint as contact law."""
    hard, joint = (sums(contact__law=law)[-1] for law in ("hard", "joint"))
    assert hard[TANGENT] == pytest.approx(joint[TANGENT], rel=0.05)
    assert hard[SECANT] == pytest.approx(joint[SECANT], rel=0.05)


def test_less_friction_is_not_stiffer():
    """Tangent and secant fall with the friction, at 20 N m and just before gross slip, where Eq. 45 hardly moves; less with a ring that slides, whose cup
    carries the torque beside the contact."""
    for keys, values, fall in (({"load__torque": 20.0}, (0.15, 0.05), 0.8),
                               ({"load__torque": 20.0, "wave_generator__ring_tangent": "follow"}, (0.15, 0.05), 0.7),
                               ({"load__support": "bearing", "load__torque": 5.0}, (0.15, 0.06, 0.045), 0.7)):
        found = [sums(contact__friction=mu, **keys)[-1] for mu in values]
        for more, less in zip(found, found[1:]):
            assert less[TANGENT] < fall * more[TANGENT] and less[SECANT] < fall * more[SECANT]
            assert less["k_ts_nm_per_rad"] > 0.97 * more["k_ts_nm_per_rad"]


def test_tangent_does_not_depend_on_solver_symmetry_or_sense():
    """Newton matrix, Schur complement, the whole face, a torque of the other sense and a resumed state give one tangent."""
    base = sums()[-1][TANGENT]
    for keys in ({"solver__method": "newton"}, {"solver__symmetry": "full"}, {"load__torque": -5.0}):
        assert sums(**keys)[-1][TANGENT] == pytest.approx(base, rel=1e-5), keys


def test_where_there_is_no_tangent():
    """Bonded faces and Eq. 28 as printed have no tangent of the joint; without friction and with the ring held
    it is the cup alone that holds the torque."""
    assert np.isnan(sums(contact__mode="bonded")[-1][TANGENT])
    assert np.isnan(sums(joint__closure="paper")[-1][TANGENT])
    last = sums(contact__mode="frictionless", wave_generator__ring_tangent="follow")[-1]
    assert last[TANGENT] == pytest.approx(last[OVER], rel=0.01)


def test_no_friction_by_mode_or_by_coefficient():
    """Faces that are frictionless by contact.mode have every number of faces whose coefficient is 0: no friction capacity, no shear in Eq. 45."""
    mode, none = (sums(wave_generator__ring_tangent="follow", **keys)[-1] for keys in ({"contact__mode": "frictionless"}, {"contact__friction": 0.0}))
    for name in ("friction", "friction_capacity_nm", "k_ts_nm_per_rad", "k_ts_paper_n", TANGENT, "rotation_rad", "normal_force_n"):
        assert mode[name] == pytest.approx(none[name], rel=1e-6), name


def test_tangent_settles_with_the_mesh_faster_than_eq_45():
    """From 48 x 8 to 96 x 16 facets the tangent moves by less than 2 %, K_TS by Eq. 45 by more (24 x 4 is 8 % off with a sliding ring)."""
    coarse, fine = (sums(mesh__divisions=n, mesh__band_facets=m)[-1] for n, m in ((48, 8), (96, 16)))
    assert abs(coarse[TANGENT] / fine[TANGENT] - 1) < 0.02 < abs(coarse["k_ts_nm_per_rad"] / fine["k_ts_nm_per_rad"] - 1)


def test_a_joint_without_stiffness_is_refused_with_the_way_out(exe, tmp_path):
    """Plastic spots from s_min on: code 2 before anything is solved; each way out that the message names works."""
    words = ["mesh.divisions=16", "mesh.band_facets=3", "joint.asperity_radius=3.7e-6", "joint.s_min=2.4e-12"]
    done = call(exe, PAPER, *words, "--out", tmp_path / "a")
    assert done.returncode == 2 and "K_N = K_T = 0" in done.stderr and "plastic_spots" in done.stderr
    assert not (tmp_path / "a/summary.json").exists()
    for i, way in enumerate(("joint.plastic_spots=elastic", "joint.s_min=6e-13", "joint.asperity_radius=20e-6")):
        found = solved(exe, tmp_path / str(i), PAPER, *words, way).summary["results"]
        assert found["k_ts_nm_per_rad"] > 1e5 and found[TANGENT] > 1e5


def test_the_calibrated_pair_gives_what_it_was_fitted_to():
    """r_m and s_min of data/joint_calibration.json with elastic spots: k_N at 50 MPa as the boundary elements', within a factor of 2."""
    table = json.loads((ROOT / "data/joint_calibration.json").read_text())
    fitted, means = table["fitted"], {r["pressure_pa"]: r["k_n_pa_per_m"] for r in table["means"]}
    joint = Joint(asperity_radius=fitted["asperity_radius_m"], s_min=fitted["s_min_m2"], hardness=1e15)
    k_n = joint.stiffness(50e6)[0] / joint.reference_area
    assert 0.5 < k_n / means[50e6] < 2


def test_plastic_spots_that_unload_elastically():
    """Their stiffness is that of elastic spots of the same size; derivatives agree with differences; elastic joints do not change."""
    joint = Joint(s_min=2.4e-12, asperity_radius=3.7e-6, plastic=True)
    parts = joint.parts(3e-12)
    s = np.linspace(2.4e-12, 3e-12, 20001)
    b = (joint.fractal_dimension - 1) / 2
    e_star = joint.asperity()[0]["e_star_pa"]
    density = b * parts["psi"]**((3 - joint.fractal_dimension) / 2) * 3e-12**b * s**(-b - 1)
    assert parts["k_n_n_per_m"][3] == pytest.approx(np.trapezoid(2 * e_star * np.sqrt(s / np.pi) * density, s), rel=1e-8)
    p, q, h = 50e6, 3e6, 1e-5
    exact = joint.derivatives(p, q)
    by_p = [(joint.stiffness(p * (1 + h), q)[i] - joint.stiffness(p * (1 - h), q)[i]) / (2 * h * p) for i in (0, 1)]
    by_q = (joint.stiffness(p, q * (1 + h))[1] - joint.stiffness(p, q * (1 - h))[1]) / (2 * h * q)
    assert exact == pytest.approx((*by_p, by_q), rel=1e-5)
    assert joint.stiffness(p, 0.15 * p)[1] == 0
    soft, hard = Joint(hardness=1e15), Joint(hardness=1e15, plastic=True)
    assert soft.stiffness(p, q) == hard.stiffness(p, q)


def test_a_run_warns_of_slip_and_of_peaks_beyond_strength(exe, tmp_path):
    """The log states one K_TS, with -v the others; slip above half of K_TS and a peak above yield or hardness are warned of, with the way out."""
    done = call(exe, PAPER, "load.support=hub", "mesh.divisions=32", "mesh.band_facets=8", "mesh.edge_length=2e-5", "-v", "--out", tmp_path / "a")
    warnings = json.loads((tmp_path / "a/summary.json").read_text())["warnings"]
    assert any("slip" in w and TANGENT in w for w in warnings)
    assert any("above the" in w and "edge_line_load_n_per_m" in w for w in warnings)
    assert re.search(r"^K_TS      \S+ N m/rad, the tangent beside bonded faces\n          secant \S+, contact alone", done.stdout, re.M)
    result = hdengine.load(tmp_path / "a")
    assert "tangent" in repr(result)
    stuck = hdengine.run(PAPER, tmp_path / "b", True, **HELD, **SMALL, contact__torque_friction=10.0)
    assert not any(TANGENT in w for w in stuck.summary["warnings"])


def test_bonded_faces_have_no_tangent(exe, tmp_path):
    """Log and result of faces without a tangent say so, in place of NaN."""
    done = call(exe, CD14, "mesh.divisions=16", "mesh.band_facets=3", "contact.mode=bonded", "--out", tmp_path / "a")
    assert "K_TS      none" in done.stdout and "NaN" not in done.stdout and "K_TS none" in repr(hdengine.load(tmp_path / "a"))


def test_range_warnings_come_once_per_process(recwarn):
    """A kind of JointWarning is given once, however its numbers change, and says what to do."""
    hdengine.joint._warned.clear()
    for pressure in (40e6, 50e6, 60e6):
        Joint().stiffness(pressure)
    texts = [str(w.message) for w in recwarn if issubclass(w.category, hdengine.JointWarning)]
    assert len(texts) == 1 and "raise joint.asperity_radius to" in texts[0]


def test_model_error_stands_beside_the_tolerance(tmp_path):
    """summary.json says what the tolerance covers and what the model leaves out, with sizes where they are known."""
    plan = hdengine.run(CD14, tmp_path / "a", True, run__tolerance=0.3, solver__kinematics="linear", geometry={"bore_radius": 9e-3, "hub_radius": 4e-3})
    left_out = plan.summary["model_error"]
    assert "k_ts_bonded_nm_per_rad" in left_out["tolerance_covers"] and len(left_out["left_out"]) >= 5
    assert any("read" in line or "slip" in line for line in left_out["left_out"])
