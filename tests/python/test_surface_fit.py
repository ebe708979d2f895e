# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit of D and G, and the verdict."""
import numpy as np
import pytest

import hdengine
from hdengine import roughness, specimen, surface

D, G, LENGTH = 2.5304, 2.4248e-7, 0.5e-3
KNOWN = roughness.Ridges(LENGTH, 1e-6)


def waves(d, ridges, seed, points=501, gamma=1.5, g=G, rows=None):
    """Eq. 1 with random phases as a product of two matrices."""
    known = roughness.Ridges(LENGTH, 1e-6, ridges, gamma)
    n, m = np.meshgrid(np.arange(known.n_max + 1), np.arange(1, ridges + 1))
    q = 2 * np.pi * gamma**n / LENGTH
    a = np.sqrt(np.log(gamma) / ridges) * g ** (d - 2) * (LENGTH / gamma**n) ** (3 - d)
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, a.shape)
    x = np.arange(points) * LENGTH / (points - 1)
    y = x[:rows] if rows else x
    u = (a * np.exp(1j * phase)).ravel() * np.exp(1j * np.outer(y, (q * np.sin(np.pi * m / ridges)).ravel()))
    return (u @ np.exp(1j * np.outer((q * np.cos(np.pi * m / ridges)).ravel(), x))).real


@pytest.fixture(scope="module")
def surfaces():
    return [waves(D, 10, seed) for seed in range(12)]


def test_exact_sum_is_found(surfaces):
    """Two-step GLS on the sum of Eq. 1: mean of 12 within 0.001 in D and 0.006 in ln G, spread within 0.002 and 0.01, chi2 as the
    degrees of freedom, most of the 95 % intervals over the truth."""
    fits = [roughness.fit(z, 1e-6, surface=KNOWN) for z in surfaces]
    d = np.array([f.fractal_dimension for f in fits]) - D
    g = np.log([f.roughness_m for f in fits]) - np.log(G)
    assert abs(d.mean()) < 1e-3 and d.std() < 2e-3 and abs(g.mean()) < 6e-3 and g.std() < 1e-2
    assert sum(f.interval[0][0] <= D <= f.interval[0][1] for f in fits) >= 10
    assert 10 < np.mean([f.chi2 for f in fits]) < 26
    assert all(f.verdict == "fractal" for f in fits)


def test_a_spectrum_of_lines_is_left_to_the_structure_function(surfaces):
    """Ten ridges that are not told make no continuous spectrum: least squares of S on the isotropic band, mean of 4 within 0.008 in D,
    spread within 0.01, residuals twice what sampling leaves at the most."""
    fits = [roughness.fit(z, 1e-6) for z in surfaces[:4]]
    assert 0.5 < np.sqrt(np.sum([f.rms**2 for f in fits]) / np.sum([f.rms_expected**2 for f in fits])) < 2
    d = np.array([f.fractal_dimension for f in fits]) - D
    assert abs(d.mean()) < 8e-3 and d.std() < 1e-2 and all(f.model == "isotropic" and f.ridges is None for f in fits)
    assert all(f.interval[0][0] <= D <= f.interval[0][1] and f.kind == "lay" for f in fits)


def test_smooth_sums_are_fitted_without_bias():
    """With no wave below four spacings S hardly scatters along some directions, where the curvature of ln S would be taken for a
    misfit: chi2 stays at its degrees of freedom and D within three errors."""
    known = roughness.Ridges(LENGTH, 4e-6)
    fits = [roughness.fit(surface.generate(501, 1e-6, 2.8, G, 1.5, LENGTH, 4e-6, 10, seed), 1e-6, surface=known) for seed in range(4, 8)]
    assert all(f.chi2 < 45 and abs(f.fractal_dimension - 2.8) < 3 * f.fractal_dimension_error < 0.01 for f in fits)


def test_tilt_does_not_matter(surfaces):
    """A tilt of 10 % changes D by less than 1e-8, for levelling takes it off."""
    a = roughness.fit(surfaces[0], 1e-6, surface=KNOWN)
    x = np.arange(501)
    b = roughness.fit(surfaces[0] + 1e-7 * x - 5e-8 * x[:, None] + 1e-3, 1e-6, surface=KNOWN)
    assert b.fractal_dimension == pytest.approx(a.fractal_dimension, abs=1e-8)
    assert b.tilt[0] - a.tilt[0] == pytest.approx(0.1, abs=1e-12)


def test_noise_is_found(surfaces):
    """White noise as strong as S(1)/20 is found within 15 %, and D within 3 standard errors."""
    sigma = 0.2e-6
    z = surfaces[0] + sigma * np.random.default_rng(9).standard_normal((501, 501))
    f = roughness.fit(z, 1e-6, surface=KNOWN, noise="fit")
    assert f.noise_m == pytest.approx(sigma, rel=0.15)
    assert abs(f.fractal_dimension - D) < 3 * f.fractal_dimension_error
    known = roughness.fit(z, 1e-6, surface=KNOWN, noise=sigma)
    assert abs(known.fractal_dimension - D) < 3 * known.fractal_dimension_error < 0.01


def test_dimension_of_exactly_one_and_a_half_works():
    """D_s = 1.5, where the literature's constant is infinity times 0, is fitted like any other, also by that constant."""
    z = waves(2.5, 10, 1)
    assert roughness.fit(z, 1e-6, surface=KNOWN).fractal_dimension == pytest.approx(2.5, abs=3e-3)
    s = 1e-7 * np.pi / 2 / np.log(1.5) * np.arange(1, 21)

    paper = roughness.fit(z, 1e-6, model="paper")
    assert np.isfinite(paper.roughness_m) and np.all(np.isfinite(s))


def test_constant_of_the_paper_overestimates():
    """The Majumdar-Bhushan constant puts G of an isotropic surface 1.2 to 1.7 times too high."""
    ratio = roughness.fit(waves(D, 40, 3), 1e-6, model="paper").roughness_m / G
    assert 1.1 < ratio < 1.8


def test_profile_of_equation_2():
    """One profile of many waves gives D_s of Eq. 2 within three standard errors by the band of Eq. 2: its spectrum has lines."""
    x = np.arange(20001) * 1e-6
    n = np.arange(0, 130)
    gamma, length = 1.08, 0.02
    rng = np.random.default_rng(4)
    a = np.sqrt(np.log(gamma)) * G ** (D - 2) * (length / gamma**n) ** (3 - D)
    z = (a * np.cos(2 * np.pi / length * np.outer(x, gamma**n) + rng.uniform(0, 2 * np.pi, n.size))).sum(1)
    f = roughness.fit(z, 1e-6)
    assert f.model == "profile" and abs(f.fractal_dimension - D) < 3 * f.fractal_dimension_error < 0.1
    assert abs(np.log(f.roughness_m / G)) < 3 * f.ln_roughness_error


def controls():
    """Maps and profiles that are not fractal, each with its name."""
    rng = np.random.default_rng(1)
    x = np.arange(300)
    row = np.ones((300, 1))
    return {
        "constant": [np.full((300, 300), 3.0), np.full(300, 2.0)],
        "plane": [1e-3 * x + 2e-4 * x[:, None] + 5, 1e-3 * x],
        "sine": [1e-6 * np.sin(2 * np.pi * x / 37.3) * row, 1e-6 * np.sin(2 * np.pi * x / 41)],
        "square wave": [1e-6 * np.sign(np.sin(2 * np.pi * x / p + 0.1)) * r for p, r in ((50, row), (41.7, 1))],
        "white noise": [1e-6 * rng.standard_normal((300, 300)), 1e-6 * rng.standard_normal(300)],
        "steps": [1e-6 * (np.cumsum(rng.random(300) < 0.05) % 7) * row, 1e-6 * (x > 150), 1e-6 * np.floor(x / 30) * row],
        "smooth": [1e-9 * (x - 150.0) ** 2 + 1e-9 * (x[:, None] - 100.0) ** 2, 1e-6 * np.sin(2 * np.pi * x / 290)],
        "periodic": [1e-8 * (x % 60) * row],
    }


@pytest.mark.parametrize("name", controls())
def test_negative_controls_are_named(name):
    """What is not fractal is called by its name, whatever D its structure function suggests."""
    for z in controls()[name]:
        f = roughness.fit(z, 1e-6)
        assert f.kind == name and f.verdict == ("noise-dominated" if name == "white noise" else "not fractal")
        assert name in str(f) and f.reason


def test_anisotropy_is_reported():
    """A map stretched along its rows shows a ratio below 1 and is said to be not isotropic."""
    z = np.repeat(waves(D, 10, 2), 4, axis=1)[:, :501] + waves(D, 10, 3)
    f = roughness.fit(z, 1e-6)
    assert f.anisotropy < 0.8
    assert 0.9 < roughness.fit(waves(D, 40, 2), 1e-6).anisotropy < 1.1


def test_rows_far_apart():
    """An isotropic map with points four to sixteen times as far apart one way has no wrong points and S alike both ways at equal distances, and so has
    the map turned by a quarter; a wrong point is found, a hole filled from what is near. S of too few rows for the lags is said to be that of rows. A
    figure names each direction where there are two."""
    z = surface.periodic(512, 512e-6, 2.3, 1e-10, 2e-6, 1)
    for far in (4, 16):
        fits = [roughness.fit(z[:, ::far], (1e-6, far * 1e-6), lags=(1, 8)), roughness.fit(z[:, ::far].T, (far * 1e-6, 1e-6), lags=(1, 8))]
        for fit in fits:
            assert fit.verdict == "fractal" and fit.spikes == 0 and 0.6 < fit.anisotropy < 1.7
        assert fits[0].fractal_dimension == pytest.approx(fits[1].fractal_dimension, abs=1e-9)
    rows = z[:, ::16].copy()
    rows[300, 20] += 6 * np.diff(rows, 2, axis=0).std()
    found, spikes = specimen.clean(specimen.Specimen(rows, (1e-6, 16e-6)), fill=True)
    assert spikes == 1 and abs(found.heights[300, 20] - z[300, 320]) < np.diff(z, axis=0).std()
    few, square = roughness.fit(z[::64], (64e-6, 1e-6)), roughness.fit(z, 1e-6)
    assert np.isfinite(few.anisotropy) and [name for name, _ in few.directions()] == ["rows"] and square.directions()[0][0] == "rows and columns"
    for fit, names in ((few, ["measured"]), (fits[0], ["measured, rows", "measured, columns"])):
        assert [line.get_label() for line in fit.plot().lines if line.get_label().startswith("measured")] == names


def test_detail_between_rows_far_apart_folds_back():
    """Rows 16 points apart of maps that go on below the points: five of six intervals hold D, and half of the fits are within 0.01. What lies
    between the rows folds back many times; of two cells alone, fits of such maps had D = 2.57 in place of 2.3, with no interval around it."""
    fits = [roughness.fit(surface.periodic(1024, 512e-6, 2.3, 1e-10, 1e-6, seed)[::2, ::32], (1e-6, 16e-6)) for seed in range(6)]
    assert sum(f.interval[0][0] <= 2.3 <= f.interval[0][1] for f in fits) >= 5
    assert np.median([f.fractal_dimension for f in fits]) == pytest.approx(2.3, abs=0.01)


def test_rectangles_and_holes():
    """Points that are no squares, and a tenth of holes, leave D within four standard errors."""
    z = waves(D, 10, 5)[::2]
    f = roughness.fit(z, (2e-6, 1e-6), surface=KNOWN)
    assert f.tau_m.size == 40 and abs(f.fractal_dimension - D) < 4 * f.fractal_dimension_error
    z = waves(D, 10, 5)
    z[np.random.default_rng(1).random(z.shape) < 0.1] = np.nan
    f = roughness.fit(z, 1e-6)
    assert abs(f.fractal_dimension - D) < 4 * f.fractal_dimension_error


def test_two_specimens_add():
    """Two specimens of equal D give the equivalent surface G_eq^(2(D-2)) = G_1^(2(D-2)) + G_2^(2(D-2)), with smaller errors;
    one that is not fractal is named."""
    share = 0.6 ** (1 / (2 * (D - 2))), 0.4 ** (1 / (2 * (D - 2)))
    a, b = (waves(D, 10, 20 + i, g=G * x) for i, x in enumerate(share))
    both = roughness.fit(a, 1e-6, surface=KNOWN, second=b)
    assert abs(both.fractal_dimension - D) < 3 * both.fractal_dimension_error
    assert abs(np.log(both.roughness_m / G)) < 3 * both.ln_roughness_error < 0.02
    assert both.fractal_dimension_error < roughness.fit(a, 1e-6, surface=KNOWN).fractal_dimension_error
    np.testing.assert_allclose(both.s_m2, sum(roughness.fit(z, 1e-6, surface=KNOWN).s_m2 for z in (a, b)), rtol=1e-12)
    odd = roughness.fit(a, 1e-6, second=np.random.default_rng(1).standard_normal(a.shape))
    assert odd.verdict == "noise-dominated" and "second map" in odd.reason


@pytest.mark.parametrize("keys, words", [
    ({"model": "best"}, "model"), ({"model": "ridges"}, "surface"),
    ({"band": (2e-6, 1e-6)}, "band"),
    ({"noise": -1.0}, "noise"), ({"noise": "much"}, "noise"), ({"noise": 1.0}, "nothing is left"),
    ({"surface": roughness.Ridges(1e-3, 1e-6, gamma=1.0)}, "gamma"), ({"surface": roughness.Ridges(1e-6, 1e-3)}, "shortest"),
])
def test_bad_options_are_named(keys, words, surfaces):
    """Each bad option raises one InputError with its name."""
    with pytest.raises(hdengine.InputError, match=words):
        roughness.fit(surfaces[0], 1e-6, **keys)


def test_spectra_of_two_maps_add(tmp_path):
    """Two independent maps of one D and G are fitted by the sum of their spectra: twice the square of the heights is 2**(1/(2(D - 2))) G; also
    where the process has fitted neither of them before (tables that are kept are of the grid, not of the map). A band of which one end alone is
    told leaves the fit of the spectrum as it is."""
    maps = [surface.periodic(256, 2.56e-4, 2.5, 1e-8, 2e-6, seed=seed)[:200, :180] for seed in (1, 2)]
    both = [roughness.fit(maps[0], 1e-6, second=maps[1])]
    alone = roughness.fit(maps[0], 1e-6)
    both.append(roughness.fit(maps[0], 1e-6, second=maps[1]))
    assert both[0].fractal_dimension == both[1].fractal_dimension == pytest.approx(2.5, abs=0.03)
    assert both[0].model == "spectrum" and both[0].roughness_m == pytest.approx(2e-8, rel=0.1)
    assert alone.fractal_dimension == pytest.approx(2.5, abs=0.03)
    np.save(tmp_path / "a.npy", maps[0])
    told = hdengine.run_surface(out=tmp_path / "a", fit__first_file=str(tmp_path / "a.npy"), fit__dx=1e-6, fit__longest_wavelength=5e-5).fits["first"]
    assert told.model == "spectrum" and told.fractal_dimension == alone.fractal_dimension
