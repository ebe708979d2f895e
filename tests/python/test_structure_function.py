# SPDX-License-Identifier: GPL-3.0-or-later
"""Structure function of maps."""
import math

import numpy as np
import pytest

import hdengine
from hdengine import roughness


def rough(rows=40, points=90, holes=0.0):
    """A map with heights of nm on a tilt of mm and an offset of metres."""
    rng = np.random.default_rng(5)
    z = 1e-9 * rng.standard_normal((rows, points)).cumsum(0).cumsum(1)
    z += 1e-5 * np.arange(points) + 2e-6 * np.arange(rows)[:, None] + 7.0
    z[rng.random(z.shape) < holes] = np.nan
    return z


def exact(a, b):
    """Sum of squared differences in extended precision, and their number."""
    d = a.astype(np.longdouble) - b
    d = d[np.isfinite(d)]
    return math.fsum((d * d).astype(float)), d.size


@pytest.mark.parametrize("holes", [0.0, 0.1])
@pytest.mark.parametrize("direction", ["rows", "columns", (2, -1)])
def test_every_lag_is_exact(direction, holes):
    """S agrees with extended precision to 1e-12 at every lag, from 1 on, under a large tilt and offset, with and without holes."""
    z = rough(holes=holes)
    p, q = {"rows": (1, 0), "columns": (0, 1)}.get(direction, direction)
    tau, s, pairs = roughness.structure_function(z, (2e-6, 1e-6), direction=direction)
    for k, (t, value, count) in enumerate(zip(tau, s, pairs), 1):
        a = z[max(q, 0) * k:z.shape[0] + min(q, 0) * k, max(p, 0) * k:z.shape[1] + min(p, 0) * k]
        b = z[max(-q, 0) * k:z.shape[0] - max(q, 0) * k, max(-p, 0) * k:z.shape[1] - max(p, 0) * k]
        total, number = exact(a, b)
        assert count == number and t == pytest.approx(k * math.hypot(p * 1e-6, q * 2e-6))
        assert value == pytest.approx(total / number, rel=1e-12)


def test_many_lags_by_fft_are_exact():
    """On rows of 1000 points, where most lags come from FFTs, all 999 lags agree with extended precision to 1e-12."""
    z = rough(3, 1000)
    _, s, _ = roughness.structure_function(z, 1e-6)
    expected = [np.divide(*exact(z[:, k:], z[:, :-k])) for k in range(1, 1000)]
    np.testing.assert_allclose(s, expected, rtol=1e-12)


@pytest.mark.parametrize("holes", [0.0, 0.1])
def test_rings_are_exact(holes):
    """The radial mean agrees with extended precision over all lag vectors of each ring to 1e-12."""
    z = rough(20, 31, holes)
    tau, s, pairs = roughness.structure_function(z, 1e-6, lags=range(1, 13), direction="radial")
    rings = {}
    for q in range(20):
        for p in range(-30, 31):
            ring = math.floor(math.hypot(p, q) + 0.5)
            if (q > 0 or p > 0) and ring <= 12:
                a, b = z[q:, max(p, 0):31 + min(p, 0)], z[:20 - q, max(-p, 0):31 - max(p, 0)]
                total, number = exact(a, b)
                old = rings.get(ring, (0, 0, 0))
                rings[ring] = (old[0] + total, old[1] + number, old[2] + number * math.hypot(p, q) * 1e-6)
    for ring, (total, number, length) in rings.items():
        assert s[ring - 1] == pytest.approx(total / number, rel=1e-12) and pairs[ring - 1] == number
        assert tau[ring - 1] == pytest.approx(length / number, rel=1e-12)


def test_second_difference_is_blind_to_tilt():
    """A plane leaves the second-difference form at rounding; without tilt it equals 4 S(tau) - S(2 tau) on long profiles."""
    plane = 1e-3 * np.arange(50) + 5e-4 * np.arange(40)[:, None]
    assert np.nanmax(roughness.structure_function(plane, 1e-6, second=True)[1]) < 1e-34
    z = np.random.default_rng(2).standard_normal((400, 500)).cumsum(1)
    first = roughness.structure_function(z, 1e-6, range(1, 21))[1]
    second = roughness.structure_function(z, 1e-6, range(1, 11), second=True)[1]
    np.testing.assert_allclose(second, 4 * first[:10] - first[1::2], rtol=0.02)


def test_threads_do_not_change_it():
    """One thread and many give the same bits."""
    import os
    import subprocess
    import sys
    code = ("import numpy as np; from hdengine import roughness as r; z = np.random.default_rng(1).standard_normal((300, 400));"
            "print([r.structure_function(z, 1.0, direction=d)[1].tobytes().hex() for d in ('rows', 'columns', 'radial')])")
    texts = [subprocess.run([sys.executable, "-c", code], env={**os.environ, "OMP_NUM_THREADS": n}, capture_output=True,
                            check=True).stdout for n in "13"]
    assert texts[0] == texts[1]


def test_level_takes_the_plane_off():
    """A tilted map with holes keeps its roughness and its holes and loses its plane, to 1e-15 of the tilt."""
    z = rough(holes=0.1)
    flat = roughness.level(z)
    np.testing.assert_array_equal(np.isnan(z), np.isnan(flat))
    assert abs(np.nanmean(flat)) < 1e-15 and np.nanmax(abs(flat)) < 1e-5
    again = roughness.level(flat + 3.0)
    np.testing.assert_allclose(again, flat, atol=1e-15)


@pytest.mark.parametrize("heights, spacing, words", [
    (np.full((30, 30), np.nan), 1e-6, "no height"),
    (np.zeros((1, 60)), 1e-6, "single line"), (np.zeros((60, 1)), 1e-6, "single line"),
    (np.zeros((30, 30)), 0.0, "spacing"), (np.zeros((30, 30)), (1e-6, -1e-6), "spacing"), (np.zeros((30, 30)), np.nan, "spacing"),
    (np.zeros((2, 2, 2)), 1e-6, "shape"), (np.zeros((0, 4)), 1e-6, "shape"),
])
def test_bad_maps_are_named(heights, spacing, words):
    """Each bad map raises one InputError that says what is wrong."""
    for f in (roughness.structure_function, roughness.fit):
        with pytest.raises(hdengine.InputError, match=words):
            f(heights, spacing)


def test_bad_lags_are_named():
    """Lags below 1 and windows that do not fit are refused, a billion of them before anything of their size is taken."""
    z = np.random.default_rng(1).standard_normal((30, 30))
    with pytest.raises(hdengine.InputError, match="lags"):
        roughness.structure_function(z, 1e-6, [0, 1])
    for lags in ((0, 10), (1, 3), (1, 20), (1, 10**9)):
        with pytest.raises(hdengine.InputError, match="lags"):
            roughness.fit(z, 1e-6, lags)


@pytest.mark.parametrize("model", ["isotropic", "profile"])
def test_band_integral_is_that_of_mpmath(model):
    """The integral over the band agrees to 1e-11 with generalised hypergeometric functions in 40 digits, for D from 2.02 to 2.98,
    D_s = 1.5 included, and lags from 1/2000 to 3000 times the ends of the band, an open end too."""
    mpmath = pytest.importorskip("mpmath")
    longest, numbers = 1e-3, {"isotropic": (4, 2), "profile": (2, mpmath.mpf(3) / 2)}[model]

    def below(u, a):                                         # integral of u^(-a-1) (1 - c(u)) from 0
        return u ** (2 - a) / (numbers[0] * (2 - a)) * mpmath.hyper([1, 1 - a / 2], [numbers[1], 2, 2 - a / 2], -u * u / 4)

    with mpmath.workdps(40):
        for d in (2.02, 2.3, 2.5, 2.5304, 2.98):
            a = 6 - 2 * mpmath.mpf(d)
            for tau in (1e-7, 1e-6, 7e-6, 1e-4, 3e-3):
                for shortest in (1e-6, 5e-5):
                    u = [2 * mpmath.pi * mpmath.mpf(tau) / mpmath.mpf(w) for w in (longest, shortest)]
                    exact = (2 * mpmath.pi * mpmath.mpf(tau)) ** a * (below(u[1], a) - below(u[0], a))
                    s = roughness.expected_structure([tau], d, 1.0, (shortest, longest), model)[0]
                    assert s == pytest.approx(float(exact), rel=1e-11)
            if model == "isotropic":
                whole = 2 ** (-a) * mpmath.gamma(1 - a / 2) / (a * mpmath.gamma(1 + a / 2))
            else:
                whole = mpmath.pi / (2 * mpmath.gamma(1 + a) * mpmath.sin(mpmath.pi * a / 2))
            exact = (2 * mpmath.pi * mpmath.mpf(1e-5)) ** a * (whole - below(2 * mpmath.pi * mpmath.mpf("0.01"), a))
            assert roughness.expected_structure(1e-5, d, 1.0, (0, longest), model) == pytest.approx(float(exact), rel=1e-11)


def test_bad_bands_are_refused():
    """D, G, lags and bands out of range are one error each."""
    for tau, d, g, band in ((0, 2.5, 1, (0, 1)), (1, 3, 1, (0, 1)), (1, 2.5, 0, (0, 1)), (1, 2.5, 1, (2, 1))):
        with pytest.raises(hdengine.InputError):
            roughness.expected_structure(tau, d, g, band)
    with pytest.raises(hdengine.InputError, match="model"):
        roughness.expected_structure(1, 2.5, 1, (0, 1), "ridges")
