# SPDX-License-Identifier: GPL-3.0-or-later
"""Each hazard of the joint model: first the formula as printed or as one would write it fails, then ours holds (docs/evidence/limits.md)."""
from dataclasses import replace

import numpy as np
import pytest

import hdengine
from hdengine import Joint, JointWarning

mpmath = pytest.importorskip("mpmath")
from oracle import Oracle, mpf  # noqa: E402


def printed_loads(joint, s_l):
    """Eq. 23-26 with the printed limits, which assume a largest spot above the last regime edge [N]."""
    p = joint.asperity()[0]
    s = np.array([0, 1, 7.1197, 205.3827, s_l / p["s_ec_m2"]])
    power = np.array([1.5, 1.2544, 1.1021, 1.0])
    factor = np.array([1, 1.1282, 1.4988, joint.hardness * p["s_ec_m2"] / p["f_ec_n"]]) * p["f_ec_n"]
    return printed_sum(joint, s_l, factor, power, s[:-1], s[1:])


def printed_stiffnesses(joint, s_l):
    """Eq. 30, 33, 34 as printed: of the divergent Eq. 30 the finite part alone [N/m]."""
    p, power, s = joint.asperity()[0], np.array([0.5, 0.3741, 0.2295]), np.array([np.inf, 1, 7.1197, 205.3827])
    return printed_sum(joint, s_l, np.array([1.5, 1.5081, 1.7935]) * p["f_ec_n"] / p["eps_ec_m"], power, s[:-1], s[1:])


def printed_sum(joint, s_l, factor, power, low, high):
    """Terms (high^e - low^e) / e over spots in units of s_ec, psi by the printed fit of Eq. 17, which is up to 0.37 % off."""
    d, unit = joint.fractal_dimension, joint.asperity()[0]["s_ec_m2"]
    b, psi = (d - 1) / 2, 5.454 * np.exp(-(d - 1) / 0.628) + 1.499
    return b * psi ** (1 - b) * (s_l / unit) ** b * factor * printed_integral(low, high, power - b)


def printed_integral(low, high, e):
    """Of sigma^(e-1), as one would write it."""
    return (high**e - low**e) / e


def test_power_difference():
    """(hi^e - lo^e)/e has no digits at e = 1e-14 and is 0/0 at 0; near D = 3, where the plastic exponent vanishes, ours keeps 13."""
    assert abs(printed_integral(1.0, 2.0, 1e-14) / np.log(2) - 1) > 1e-3
    with pytest.raises(ZeroDivisionError):
        printed_integral(1.0, 2.0, 0.0)
    joint = Joint(fractal_dimension=3 - 2e-13, asperity_radius=5e-6)
    oracle = Oracle(joint)
    s = 1e4 * joint.asperity()[0]["s_ec_m2"]
    assert joint.parts(s)["load_n"].sum() == pytest.approx(float(oracle.total_load(mpf(s))), rel=1e-13)


@pytest.mark.parametrize("edge", [0.5, 3.0, 100.0])
def test_unclipped_limits(edge):
    """Below the last regime edge the printed sum of loads is negative; clipped, every part is at least 0 and the sum is positive. Far above it both agree."""
    joint = Joint(s_min=1e-20)
    s = 1e5 * joint.asperity()[0]["s_ec_m2"]
    np.testing.assert_allclose(printed_loads(joint, s), joint.parts(s)["load_n"], rtol=1e-3)
    s = min(edge, 4.0) * joint.asperity()[0]["s_ec_m2"]
    assert printed_loads(joint, s).sum() < 0
    parts = joint.parts(s)["load_n"]
    assert np.all(parts >= 0) and parts.sum() > 0


def test_divergent_elastic_stiffness():
    """Eq. 30 as printed is negative; ours is positive and grows without bound as s_min goes to 0."""
    joint = Joint()
    s = 1e3 * joint.asperity()[0]["s_ec_m2"]
    assert printed_stiffnesses(joint, s)[0] < 0
    k = [replace(joint, s_min=m).parts(s)["k_n_n_per_m"].sum() for m in (1e-16, 1e-18, 1e-20, 1e-22)]
    assert np.all(np.diff(k) > 0) and k[-1] / k[0] > 10


def test_elastic_law_ends_at_no_pressure():
    """With k growing as the root of P the faces part at a closure of -2 sqrt(P_0)/A, and slide past mu 2 sqrt(P)/A of slip."""
    p = np.geomspace(1e3, 1e9, 13)
    law = hdengine.elastic.ElasticJoint(p, 2e10 * p**0.5, 1e10 * p**0.5, 0.2)
    np.testing.assert_allclose(law.closure([0.0, 1e3, 1e6])[0], (np.sqrt([0.0, 1e3, 1e6]) - np.sqrt(1e3)) / 1e10, rtol=1e-9)
    last = 0.2 * 2 * np.sqrt(1e6) / 1e10
    shear, _, slips = law.shear([1e6, 1e6], [0.999 * last, 1.001 * last])
    assert list(slips) == [False, True] and shear[0] < shear[1] == 0.2e6


def test_psi_near_three():
    """The equation of psi as written is 0/0 towards D = 3; ours tends to e - 1, and to the golden ratio squared at D = 2."""
    def residual(psi, d_s):
        return (psi ** ((2 - d_s) / 2) - (1 + psi ** (-d_s / 2)) ** (-(2 - d_s) / d_s)) / ((2 - d_s) / d_s) - 1

    assert abs(residual(np.e - 1, 2 - 4e-16)) > 0.1
    assert Joint(fractal_dimension=3 - 4e-16).parts(1e-12)["psi"] == pytest.approx(np.e - 1, rel=1e-13)
    assert Joint(fractal_dimension=2 + 4e-16).parts(1e-12)["psi"] == pytest.approx((3 + 5**0.5) / 2, rel=1e-13)


def test_cusp_at_the_slip_edge():
    """A Gauss rule of 24 points across the slip edge loses K_T at the fourth digit; ours agrees with the oracle to 1e-12."""
    joint = Joint(s_min=1e-17)
    s_l = 0.8 * joint.asperity()[0]["s_ec_m2"]
    oracle = Oracle(joint)
    tau = float(mpf("0.3") * oracle.mu * oracle.total_load(mpf(s_l)) / mpf(s_l))
    exact = float(oracle.k_t(mpf(s_l), mpf(tau)))
    x, w = np.polynomial.legendre.leggauss(24)
    s = joint.s_min + (s_l - joint.s_min) * (x + 1) / 2
    p = joint.asperity()[0]
    stuck = np.maximum(0, 1 - tau * s / (joint.friction * p["f_ec_n"] * (s / p["s_ec_m2"]) ** 1.5)) ** (1 / 3)
    n = (joint.fractal_dimension - 1) / 2 * joint.parts(s_l)["psi"] ** ((3 - joint.fractal_dimension) / 2) * (
        s_l ** ((joint.fractal_dimension - 1) / 2) * s ** (-(joint.fractal_dimension + 1) / 2))
    naive = np.sum(w * 8 * p["g_prime_pa"] * np.sqrt(s / np.pi) * stuck * n) * (s_l - joint.s_min) / 2
    assert abs(naive / exact - 1) > 1e-4
    assert joint.parts(s_l, tau)["k_t_n_per_m"].sum() == pytest.approx(exact, rel=1e-12)


def test_vanishing_exponent_and_shear():
    """At D - 2 = 1e-10 the difference of hypergeometric values keeps 7 digits; ours keeps 11, also for a shear of 1e-12 mu P."""
    joint = Joint(fractal_dimension=2 + 1e-10, s_min=1e-17)
    oracle = Oracle(joint)
    s_l = 0.5 * joint.asperity()[0]["s_ec_m2"]
    for part in (1e-12, 0.2):
        tau = float(mpf(part) * oracle.mu * oracle.total_load(mpf(s_l)) / oracle.area(mpf(s_l)))
        exact = float(oracle.k_t(mpf(s_l), mpf(tau)))
        assert joint.parts(s_l, tau)["k_t_n_per_m"].sum() == pytest.approx(exact, rel=1e-11)


def test_eq_28_has_no_root_at_hardness():
    """Bisection of Eq. 28 above H runs to its bound; ours finds no spot and says so."""
    joint = Joint(paper=True)
    parts = [joint.parts(s) for s in np.logspace(-10, 3, 20)]
    assert max(p["load_n"].sum() / p["real_area_m2"] for p in parts) < 1.05 * joint.hardness
    with pytest.warns(JointWarning, match="0.99 H"):
        k_n, k_t = joint.stiffness(1.01 * joint.hardness)
    assert k_n == 0 and k_t == 0


def test_load_is_not_monotone_in_area():
    """f(s) falls where the second branch ends, so two areas carry one load; by depth the branch is unique and s, f, k are defined."""
    joint = Joint()
    p = joint.asperity()[0]
    below, above = (joint.asperity(area=7.119718 * p["s_ec_m2"] * x)[2][0] for x in (0.9999, 1.0001))
    assert above < below
    depth = np.array([5.999, 6.001]) * p["eps_ec_m"]
    states = np.array([joint.asperity(depth=d)[1] for d in depth])
    assert np.all(states[1, :2] > states[0, :2])


def test_warnings_outside_the_range():
    """Spots larger than an asperity, real area above the nominal, plastic s_min: each has its own warning; inside there is none."""
    assert Joint(asperity_radius=250e-6, s_min=1e-15).warnings(1e6) == []
    for joint, pressure, word in ((Joint(), 50e6, "base of an asperity"), (Joint(), 5e9, "exceeds the nominal"),
                                  (Joint(s_min=1e-10), 1e6, "plastic already")):
        assert any(word in line for line in joint.warnings(pressure)), word
        hdengine.joint._warned.clear()
        with pytest.warns(JointWarning, match=word):
            joint.stiffness(pressure)
