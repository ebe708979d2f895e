# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint against 50-digit arithmetic, against differences, and against the clock."""
import time
from dataclasses import replace

import numpy as np
import pytest

import hdengine
from conftest import ROOT, SMALL, call
from hdengine import Joint, _engine

mpmath = pytest.importorskip("mpmath")
from oracle import Oracle, mpf  # noqa: E402

pytestmark = pytest.mark.filterwarnings("ignore::hdengine.JointWarning")


def random_joint(rng):
    """A joint anywhere in the range the model is stated for."""
    return Joint(fractal_dimension=rng.uniform(2.02, 2.98), roughness=10 ** rng.uniform(-10, -6.5),
                 asperity_radius=10 ** rng.uniform(-6.5, -3.6), s_min=10 ** rng.uniform(-19, -11),
                 friction=rng.uniform(0.05, 0.5), hardness=10 ** rng.uniform(9, 10), nu_soft=rng.uniform(0.2, 0.45))


def test_random_cases():
    """Load 1e-13, K_N 1e-12 and K_T 1e-11 relative over D, nine decades of pressure, s_min, no shear to past full slip."""
    rng = np.random.default_rng(1)
    worst = np.zeros(3)
    for _ in range(600):
        joint = random_joint(rng)
        oracle = Oracle(joint)
        pressure = 10 ** rng.uniform(0, 9)
        shear = joint.friction * pressure * rng.choice([0.0, 1e-9, 1e-4, *rng.uniform(0, 1.1, 4)])
        k_n, k_t, s_l, _, iterations = _engine.call("joint_facets", joint._parameters(), np.array([pressure]),
                                                    np.array([shear]), np.array([joint.reference_area]))
        assert iterations[0] <= 12
        s = s_at(oracle, mpf(float(pressure)), mpf(float(s_l[0])))
        excess = float(s / oracle.s_min - 1)
        assert excess > 0
        worst[0] = max(worst[0], abs(mpf(float(s_l[0])) / s - 1))
        worst[1] = max(worst[1], relative(k_n[0], oracle.k_n(s)))
        if shear < joint.friction * pressure:
            expected = oracle.k_t(s, mpf(float(shear)) * oracle.a0 / oracle.area(s))
            # near the slip edge of the largest spot K_T is ill-conditioned in the shear itself: compare with the stuck value
            worst[2] = max(worst[2], abs(mpf(float(k_t[0])) - expected) / oracle.k_t(s, mpf(0)) if oracle.k_t(s, mpf(0)) else 0)
        else:
            assert k_t[0] == 0
    print("worst relative errors of s_l, K_N, K_T:", worst)
    assert worst[0] <= 1e-13 and worst[1] <= 1e-12 and worst[2] <= 1e-11


def test_one_asperity():
    """Moduli, shape and first yield of an asperity, and its state at a depth and at an area (Eq. 3-16, 39, 40), in every regime: 1e-12."""
    rng = np.random.default_rng(2)
    for _ in range(40):
        joint = random_joint(rng)
        o = Oracle(joint)
        known = (o.e, o.g_prime, o.h, o.k_hard, o.eta, o.radius, o.eps_ec, o.s_ec, o.f_ec)
        assert_near(list(joint.asperity()[0].values()), known, 1e-12)
        for x in (0.3, 3, 50, 200):
            depth = float(x * o.eps_ec)
            assert_near(joint.asperity(depth=depth)[1], o.by_depth(mpf(depth) / o.eps_ec), 1e-12)
        for x in (0.5, 4, 60, 300):
            area = float(x * o.s_ec)
            tau = float(rng.uniform(0, 0.9)) * float(o.mu * o.by_area(mpf(area), 0)[0] / area)
            assert_near(joint.asperity(area=area, tau=tau)[2], o.by_area(mpf(area), mpf(tau)), 1e-12)


def test_parts_of_the_regimes():
    """Load, K_N (1e-12) and K_T (1e-11) of the spots of each regime beside the sum of all, the real area, and psi (1e-13), also near D = 3."""
    rng = np.random.default_rng(6)
    for _ in range(60):
        joint = random_joint(rng)
        if rng.uniform() < 0.1:
            joint = replace(joint, fractal_dimension=2.999)
        o = Oracle(joint)
        s_l = joint.s_min * 10 ** rng.uniform(0.2, 9)
        tau = rng.uniform(0, 1) * float(o.mu * o.total_load(s_l) / o.area(s_l))
        parts = joint.parts(s_l, tau=tau)
        for name, known, tol in (("load_n", o.power(s_l, o.load), 1e-12), ("k_n_n_per_m", o.power(s_l, o.stiff), 1e-12),
                                 ("k_t_n_per_m", o.k_t_parts(s_l, mpf(tau)), 1e-11)):
            assert_near(parts[name], known, tol, tol * float(sum(known)))
        assert relative(parts["psi"], o.psi) < 1e-13 and relative(parts["real_area_m2"], o.area(s_l)) < 1e-12


def assert_near(found, known, tol, off=0.0):
    """Numbers against those of 50 digits."""
    np.testing.assert_allclose(found, [float(x) for x in known], rtol=tol, atol=off)


def relative(value, expected):
    """Relative difference; both zero counts as agreement."""
    return abs(mpf(float(value)) - expected) / expected if expected else abs(mpf(float(value)))


def s_at(oracle, pressure, start):
    """Largest spot in 50 digits: Newton in s_l - s_min from the engine's value."""
    goal = pressure * oracle.a0
    s = max(start, oracle.s_min * (1 + mpf(10) ** -25))
    for _ in range(60):
        f = oracle.total_load(s)
        slope = (oracle.total_load(s * (1 + mpf(10) ** -30)) - f) / (s * mpf(10) ** -30)
        step = (goal - f) / slope
        s = max(s + step, oracle.s_min + (s - oracle.s_min) / 10)
        if abs(step) < (s - oracle.s_min) * mpf(10) ** -18:
            break
    return s


def test_oracle_by_quadrature():
    """The oracle's closed form of K_T agrees with direct quadrature to 25 digits."""
    rng = np.random.default_rng(3)
    for _ in range(8):
        oracle = Oracle(random_joint(rng))
        s = oracle.s_min * mpf(10 ** rng.uniform(0.2, 7))
        tau = mpf(rng.uniform(0, 1)) * oracle.mu * oracle.total_load(s) / oracle.area(s)
        assert relative_mp(oracle.k_t(s, tau), oracle.k_t(s, tau, direct=True)) < 1e-25


def relative_mp(a, b):
    """Relative difference in full precision."""
    return abs(a - b) / abs(b) if b else abs(a)


@pytest.mark.parametrize("paper", [False, True])
def test_derivatives(paper):
    """dK_N/dP, dK_T/dP and dK_T/dtau agree with Richardson differences to 1e-7, away from the kinks at regime edges."""
    rng = np.random.default_rng(4)
    for _ in range(60):
        joint = replace(random_joint(rng), paper=paper)
        p = 10 ** rng.uniform(4, 8.5)
        q = joint.friction * p * rng.uniform(0.05, 0.9)
        edges = np.array([1, 7.119718, 205.382706]) * joint.asperity()[0]["s_ec_m2"]
        s_l = joint.largest_spot(p)[0]
        k_n, k_t = joint.stiffness(p, q)
        if not 1.05 * joint.s_min < s_l or np.min(abs(s_l / edges - 1)) < 0.02 or not k_n > 0:
            continue
        exact = joint.derivatives(p, q)
        for i, value in enumerate(exact):
            def at(h, i=i):
                a, b = (joint.stiffness(p * (1 + x), q) if i < 2 else joint.stiffness(p, q * (1 + x)) for x in (h, -h))
                return (a[min(i, 1)] - b[min(i, 1)]) / (2 * h * (p if i < 2 else q))
            difference = (4 * at(1e-4) - at(2e-4)) / 3
            scale = (k_n if i == 0 else k_t) / (p if i < 2 else q)
            assert abs(difference - value) < 1e-6 * max(abs(value), scale), (i, joint)


def test_derivative_by_shear_at_zero():
    """dK_T/dtau stays finite without shear and is the limit of differences."""
    joint = Joint()
    exact = joint.derivatives(50e6, 0.0)[2]
    k = [joint.stiffness(50e6, q)[1] for q in (0.0, 1e3)]
    assert exact == pytest.approx((k[1] - k[0]) / 1e3, rel=1e-3) and exact < 0


def test_closure_is_the_integral_of_compliance():
    """delta(P) inverts to 1e-12, its slope is 1/k_N, and it agrees with quadrature of 1/k_N."""
    joint = Joint()
    p = np.logspace(-2, 9, 45)
    delta, k = joint.closure(p)
    back, k_back = joint.pressure(delta)
    np.testing.assert_allclose(back, p, rtol=1e-12)
    np.testing.assert_allclose(k_back, k, rtol=1e-12)
    np.testing.assert_allclose(k[8:], joint.stiffness(p[8:])[0] / joint.reference_area, rtol=1e-3)  # tail below
    x, w = np.polynomial.legendre.leggauss(200)
    ends = np.log([1e5, 1e8])
    y = ends.mean() + np.ptp(ends) / 2 * x
    integral = np.sum(w * np.exp(y) * joint.reference_area / joint.stiffness(np.exp(y))[0]) * np.ptp(ends) / 2
    assert joint.closure(1e8)[0] - joint.closure(1e5)[0] == pytest.approx(integral, rel=1e-6)


def test_closure_has_limits():
    """The law is refused where it does not exist, with a reason."""
    for keys, words in (({"paper": True}, "nominal closure"), ({"s_min": 1e-9}, "plastic")):
        with pytest.raises(hdengine.InputError, match=words):
            Joint(**keys).closure(1e6)
    with pytest.raises(hdengine.InputError, match="zero_pressure"):
        Joint().closure(1e6, zero_pressure=0.0)


def test_shear_ends_in_slip():
    """q(u) starts with K_T without shear, is monotone and concave, and ends at mu P."""
    joint = Joint()
    u = np.linspace(0, 2e-6, 400)
    q, k, slips = joint.shear(20e6, u)
    assert k[0] == pytest.approx(joint.stiffness(20e6)[1] / joint.reference_area, rel=1e-12)
    assert np.all(np.diff(q) >= 0) and np.all(np.diff(k) <= 0)
    assert slips[-1] and q[-1] == pytest.approx(0.15 * 20e6)


def test_facets_are_fast():
    """1290 facets take a few milliseconds, a million some seconds (measured: 1.7 ms and 1.3 s; generous for busy machines)."""
    rng = np.random.default_rng(5)
    for n, limit in ((1290, 0.02), (100_000, 1.5)):
        p = 10 ** rng.uniform(4, 9, n)
        q = 0.15 * p * rng.uniform(0, 1, n)
        start = time.perf_counter()
        _engine.call("joint_facets", Joint()._parameters(), p, q, np.full(n, 1e-6))
        assert time.perf_counter() - start < limit


def test_sensitivity():
    """Elasticities repeat a difference by hand."""
    joint = Joint()
    table = joint.sensitivity(50e6)
    up, down = (replace(joint, roughness=joint.roughness * f).stiffness(50e6)[0] for f in (1.01, 1 / 1.01))
    assert table["roughness"][0] == pytest.approx(np.log(up / down) / (2 * np.log(1.01)), rel=1e-2)


def test_a_run_holds_its_joint(exe, tmp_path):
    """The run's joint repeats its contact table to 1e-12."""
    assert call(exe, ROOT / "data/cd14.nml", *SMALL, "--out", tmp_path / "b.out", "-q").returncode == 0
    result = hdengine.load(tmp_path / "b.out")
    c = result.contact
    k_n, k_t = hdengine.results.facet_stiffness(c, result.joint)
    np.testing.assert_allclose(k_n, c["k_n_n_per_m"], rtol=1e-12)
    np.testing.assert_allclose(k_t, c["k_t_n_per_m"], rtol=1e-9, atol=1e-9 * k_t.max())


def test_plot(tmp_path):
    """K(P) is drawn with labelled axes."""
    axis = Joint().plot()
    assert axis.get_xlabel() and axis.get_ylabel()
    axis.figure.savefig(tmp_path / "joint.png")
