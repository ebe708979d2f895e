# SPDX-License-Identifier: GPL-3.0-or-later
"""Generated surfaces."""
from math import gamma, pi

import numpy as np
import pytest

import hdengine
from hdengine import surface

D, G = 2.5304, 2.4248e-7


def row_structure(z, lag):
    """Structure function of a periodic map, mean of both directions."""
    return 0.5 * sum(np.mean((np.roll(z, -lag, k) - z) ** 2) for k in (0, 1))


def band_limited(tau, d, g, low, high):
    """S of the isotropic surface of Eq. 1: G^(2(D-2)) times the integral of f^(-a-1) (1 - J0(2 pi f tau)) over the band."""
    f = np.exp(np.linspace(np.log(low), np.log(high), 4001))
    j0 = np.cos(2 * pi * tau * np.outer(np.sin((np.arange(400) + 0.5) * pi / 400), f)).mean(0)
    y = f ** (-2 * (3 - d)) * (1 - j0)
    return g ** (2 * (d - 2)) * np.sum((y[1:] + y[:-1]) / 2 * np.diff(np.log(f)))


def continuum(tau, d, g):
    """The same without band limits: G^(2(D-2)) (2 pi tau)^a I(a) c_a."""
    a = 2 * (3 - d)
    c = gamma((a + 1) / 2) / (pi**0.5 * gamma(a / 2 + 1))
    return g ** (2 * (d - 2)) * (2 * pi * tau) ** a * pi / (2 * gamma(1 + a) * np.sin(pi * a / 2)) * c


@pytest.mark.parametrize("d", [2.3, 2.5, D, 2.8])
def test_periodic_has_the_continuum_structure_function(d):
    """One realisation follows the band-limited integral to 1.5 % (D = 2.3, where few long waves carry it: 5 %) and, between the
    cut-offs, at D = 2.53 the power law to 6 %."""
    n, length = 2048, 0.5e-3
    z = surface.periodic(n, length, d, G, 4 * length / n, 1)
    assert abs(z.mean()) < 1e-12 * z.std()
    for lag in (1, 3, 16, 32, 48):
        tau = lag * length / n
        s = row_structure(z, lag)
        assert s / band_limited(tau, d, G, 1 / length, n / (4 * length)) == pytest.approx(1, abs=0.05 if d < 2.5 else 0.015)
        assert lag < 16 or d != D or s / continuum(tau, d, G) == pytest.approx(1, abs=0.06)


def test_periodic_seed_fixes_the_surface_at_every_resolution():
    """A finer grid samples the same surface; another seed is another surface."""
    coarse = surface.periodic(64, 1e-3, D, G, 1e-4, 7)
    fine = surface.periodic(256, 1e-3, D, G, 1e-4, 7)
    assert np.allclose(fine[::4, ::4], coarse, rtol=0, atol=1e-13 * coarse.std())
    assert not np.allclose(coarse, surface.periodic(64, 1e-3, D, G, 1e-4, 8))


def test_periodic_matches_stored_heights():
    """The phases of a seed are the same on every platform."""
    z = surface.periodic(8, 1.0, 2.5, 1.0, 0.25, 12345)
    assert z[0, :3] == pytest.approx(STORED_PERIODIC, rel=1e-12)


STORED_PERIODIC = [-0.6344484169832967, -0.969877431531003, -0.9443065654707041]

BAD_PERIODIC = {
    "n": (dict(n=1), "n = 1"),
    "length": (dict(length=0.0), "length = 0.0 m"),
    "nan": (dict(length=float("nan")), "length = NaN m"),
    "dimension": (dict(fractal_dimension=2.0), "fractal_dimension = 2.0"),
    "roughness": (dict(roughness=-1.0), "roughness = -1.0 m"),
    "long": (dict(shortest_wavelength=2e-3), "must not exceed the length"),
    "short": (dict(shortest_wavelength=1e-5), "at least two spacings"),
    "seed": (dict(seed=-1), "seed"),
    "memory": (dict(n=2_000_000, shortest_wavelength=1e-4), "MB"),
}


@pytest.mark.parametrize("change, says", BAD_PERIODIC.values(), ids=BAD_PERIODIC)
def test_periodic_refuses_bad_input(change, says):
    """Each bad value is one clear error."""
    good = dict(n=64, length=1e-3, fractal_dimension=D, roughness=G, shortest_wavelength=1e-4, seed=1)
    with pytest.raises(hdengine.HdengineError, match=says):
        surface.periodic(**good | change)
