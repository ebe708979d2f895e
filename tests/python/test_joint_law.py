# SPDX-License-Identifier: GPL-3.0-or-later
"""The rough joint as interface law of whole scenes."""
import numpy as np
import pytest
from conftest import ROOT, SMALL, call

import hdengine

CD14 = ROOT / "data/cd14.nml"
LAW = ["contact.law=joint", "output.vtu=none"]


def solve(exe, folder, *keys):
    done = call(exe, CD14, *SMALL, *LAW, *keys, "--out", folder, "-q")
    assert done.returncode == 0, done.stderr
    return hdengine.load(folder)


@pytest.mark.parametrize("keys", [[], ["load.support=bearing", "load.torque=3"],
                                  ["wave_generator.eccentricity=1e-5", "contact.mode=frictionless"]], ids=str)
def test_condensation_takes_the_joint(exe, tmp_path, keys):
    """Condensed and sparse Newton matrix give the same pressure with a rough joint, to 1e-8 of the peak."""
    a, b = (solve(exe, tmp_path / m, *keys, f"solver.method={m}", "solver.tolerance=1e-10") for m in ("condensed", "newton"))
    for name in ("pressure_pa", "traction_theta_pa"):
        np.testing.assert_allclose(a.contact[name], b.contact[name], atol=1e-8 * b.contact["pressure_pa"].max())


def test_facets_lie_on_the_curve_of_the_joint(exe, tmp_path):
    """Round and frictionless, closure (minus the gap) and pressure of every facet fit delta(P), 0.2 um for the mean over a facet."""
    r = solve(exe, tmp_path / "r", "wave_generator.w=0", "contact.mode=frictionless", "load.torque_steps=0")
    p, gap = r.contact["pressure_pa"][-1], r.contact["gap_m"][-1]
    joint = hdengine.Joint(fractal_dimension=2.5304, roughness=2.4248e-7, asperity_radius=5e-6)
    assert p.min() > 1e5 and np.abs(joint.closure(p)[0] + gap).max() < 2e-7 and np.ptp(gap) > 2e-7


def test_a_stiff_joint_is_hard(exe, small_run, tmp_path):
    """The smaller zero_pressure's closure and the stiffer the joint, the closer to hard contact: G / 100 gives its force to 1 %."""
    hard = hdengine.load(small_run).steps["normal_force_n"][-1]
    soft = solve(exe, tmp_path / "s").steps["normal_force_n"][-1]
    stiff = solve(exe, tmp_path / "h", "joint.roughness=2.4e-9", "joint.s_min=1e-16").steps["normal_force_n"][-1]
    assert soft < 0.97 * hard and stiff == pytest.approx(hard, rel=0.01)


def test_quadratic_convergence(exe, tmp_path):
    """Once the states have settled the residual falls as its square: r_{k+1} < 1e3 r_k^2 in the last iteration of each step."""
    r = solve(exe, tmp_path / "q")
    h = r.history
    for step in np.unique(h["step"]):
        res = h["residual"][h["step"] == step]
        assert res[-1] < max(1e3 * res[-2] ** 2, 1e-11)


@pytest.mark.parametrize("key", ["contact.mode=bonded", "joint.closure=paper"])
def test_what_the_joint_cannot_do_is_refused(exe, tmp_path, key):
    """Bonded contact and the printed closure have no law p(closure): code 2."""
    done = call(exe, CD14, *SMALL, *LAW, key, "--out", tmp_path / "x", "-q")
    assert done.returncode == 2 and "contact.law" in done.stderr
