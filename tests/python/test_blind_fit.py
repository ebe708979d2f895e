# SPDX-License-Identifier: GPL-3.0-or-later
"""The fit told nothing, on maps made by numpy alone: bands of any end, probes, noise, tilt, holes, spikes, jitter, lines."""
import sys

import numpy as np
import pytest

from conftest import ROOT
from hdengine.surfaces import roughness

sys.path.insert(0, str(ROOT / "bench"))
from blind_generators import LN_G, NOT_FRACTAL, field, line, stretched  # noqa: E402

DX = 1e-6
CASES = {
    "to Nyquist": {}, "circle": {"top": 0.5}, "half a band": {"top": 0.25}, "finer detail": {"finer": 4},
    "probe of a quarter": {"finer": 4, "probe": 0.25}, "probe of one": {"finer": 2, "probe": 1.0}, "longer waves": {"longer": 4},
    "noise": {"finer": 2, "noise": 0.1}, "tilt": {"finer": 2, "tilt": 3.0}, "dx unlike dy": {"finer": 2, "aspect": 1.7},
}


@pytest.mark.parametrize("case", CASES)
def test_what_is_not_told_is_found(case):
    """D within three quarters of the interval's width, and D and ln G inside the interval or within 0.05 and 0.4 of it, of two maps of
    128 x 128 at D = 2.5; intervals lie in (2, 3) and hold the estimate."""
    for seed in (1, 2):
        z, spacing = field(128, DX, 2.5, np.random.default_rng(seed), **CASES[case])
        f = roughness.fit(z, spacing)
        (d_low, d_high), (low, high) = f.interval
        assert abs(f.fractal_dimension - 2.5) < 0.75 * (d_high - d_low) < 0.6 and 2 < d_low <= f.fractal_dimension <= d_high < 3
        assert d_low - 0.05 < 2.5 < d_high + 0.05 and low / 1.5 < np.exp(LN_G) < high * 1.5
        assert f.verdict == "fractal" and f.model == "spectrum"


def test_unlike_spacings_use_the_finer_one():
    """At dy = 1.7 dx and D = 2.9 the mean D of three maps is within 0.06; windows reach beyond Nyquist's frequency along y."""
    fits = [roughness.fit(*field(128, DX, 2.9, np.random.default_rng(s), finer=2, aspect=1.7)) for s in range(3)]
    assert abs(np.mean([f.fractal_dimension for f in fits]) - 2.9) < 0.06
    assert min(f.band_m[0] for f in fits) < 2 * 1.7 * DX and all(f.verdict == "fractal" for f in fits)


@pytest.mark.parametrize("name, rises", (("crossover up", True), ("crossover down", False)))
def test_crossovers_are_told(name, rises):
    """Of three maps with two slopes at least two are called a crossover: two ranges that meet, each over a factor two of wavelengths,
    with D on the right sides, and both stand in the printed result."""
    fits = [roughness.fit(NOT_FRACTAL[name](128, np.random.default_rng(seed)), DX) for seed in range(3)]
    told = [f for f in fits if f.kind == "crossover"]
    assert len(told) >= 2
    for f in told:
        (long, middle, longest), (short, shortest, same) = f.ranges
        assert (short > long) is rises and middle == same and longest > 1.99 * middle > 3.9 * shortest
        assert f"D = {round(long, 2)} for wavelengths of {1e6 * middle:.4g} to" in str(f)
        assert f" and {round(short, 2)} for " in str(f)
    assert rises or any("this map cannot tell" in f.reason for f in told)


def test_a_fractal_map_has_one_range():
    """The range of a fractal map is its band and its D."""
    f = roughness.fit(*field(128, DX, 2.5, np.random.default_rng(1), finer=2))
    assert f.ranges == ((f.fractal_dimension, *f.band_m),)


def test_a_stretched_map_has_no_lines():
    """A map stretched threefold at an angle to its axes has one D in all directions: its spectrum is fitted, not S, and intervals hold D."""
    fits = [roughness.fit(stretched(128, DX, 2.5, np.random.default_rng(seed), 3, 0.5), DX) for seed in range(4)]
    assert all(f.model == "spectrum" and f.interval[0][0] < 2.5 < f.interval[0][1] for f in fits)


def test_lines_too():
    """Profiles of 4096 points, blurred by one spacing or not: D within 0.1."""
    for probe in (0.0, 1.0):
        f = roughness.fit(line(4096, DX, 2.4, np.random.default_rng(3), probe=probe), DX)
        assert abs(f.fractal_dimension - 2.4) < 0.1 and f.verdict == "fractal"


def test_wrong_points_do_not_move_the_fit():
    """Seven points off by 5 Sq, 5 % holes, patches of holes, row jitter of 0.2 Sq and a stitching step of 1 Sq leave D within its
    interval and the interval within a quarter of its width; they are reported."""
    rng = np.random.default_rng(3)
    z, spacing = field(192, DX, 2.5, rng, finer=2)
    clean = roughness.fit(z, spacing)
    (low, high), wide = clean.interval[0], np.ptp(clean.interval[0])
    bad = {name: z.copy() for name in ("spikes", "holes", "patches", "jitter", "stitching")}
    bad["spikes"].flat[rng.choice(z.size, 7, replace=False)] += 5 * z.std()
    bad["holes"].flat[rng.choice(z.size, z.size // 20, replace=False)] = np.nan
    for i, j in rng.integers(0, 180, (12, 2)):
        bad["patches"][i:i + 9, j:j + 9] = np.nan
    bad["jitter"] += 0.2 * z.std() * rng.standard_normal((192, 1))
    bad["stitching"][:, 80:] += z.std()
    fits = {name: roughness.fit(b, spacing) for name, b in bad.items()}
    for name, f in fits.items():
        assert low <= f.fractal_dimension <= high and f.verdict == "fractal", name
        assert abs(f.interval[0][0] - low) < 0.25 * wide and abs(f.interval[0][1] - high) < 0.25 * wide, name
    assert fits["spikes"].spikes == 7 and fits["holes"].holes >= z.size // 20
    assert fits["jitter"].axis_excess[1] > 3
    assert fits["stitching"].seams == (1, 0) and abs(fits["stitching"].seam_step_m / z.std() - 1) < 0.1


def test_maps_that_are_not_fractal_are_told():
    """Plateaus, a crossover, white noise, a smooth field and spikes on a plane are refused, by their names."""
    named = {"plateaus": "steps", "white noise": "white noise", "smooth": "smooth", "spikes": "spikes"}
    for name, kind in named.items():
        f = roughness.fit(NOT_FRACTAL[name](128, np.random.default_rng(5)), DX)
        assert f.verdict != "fractal" and f.kind == kind, name
