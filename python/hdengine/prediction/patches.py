# SPDX-License-Identifier: GPL-3.0-or-later
"""Boundary elements on the maps of a joint: the patches that are solved, their foretold time and its bound."""
from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from .._check import ROUNDING
from .._engine import StoppedError
from ..elastic.law import contact_from_spectrum
from ..surfaces.composite import resample
from ..surfaces.specimen import Specimen
from . import half_space
from .bodies import Bodies
from .spectrum import SMALLEST, averaged, bands, level, waves

__all__: list[str] = []
FEWEST = 64      # points a side to which the bound of time may take a map
GROWTH = 4.6     # time of twice the points a side, over that of the points: transforms and iterations
COARSE = 0.3, 0.02   # rms error of ln k_N of an averaged map: over the root of its touching points, and however many touch
SHEAR = 2.2      # time with the tangential stiffness, over that without it


@dataclass
class Effort:
    """Time of boundary elements: how much they may take, what was foretold, and whom to tell.

    Parameters
    ----------
    most : float
        [s]; inf: no bound.
    say : callable, optional
        Takes a sentence, and whether it replaces the one before.
    """

    most: float = np.inf
    say: Callable[[str, bool], None] | None = None
    foretold: float = np.nan
    start: float = field(default_factory=time.monotonic)
    done: int = 0
    count: int = 1

    @property
    def spent(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self.start

    def tell(self, text: str, replaces: bool = False) -> None:
        """Pass a sentence on."""
        if self.say:
            self.say(text, replaces)

    def step(self, patch: str, pressure: float) -> None:
        """Count one pressure of one patch.

        Raises
        ------
        StoppedError
            Twice the bound is used up: the foretold time was wrong.
        """
        self.done += 1
        self.tell(f"boundary elements: {patch}, {pressure / 1e6:.3g} MPa ({self.done} of {self.count}), {self.spent:.0f} s of "
                  f"about {self.foretold:.0f} s", True)
        if self.spent > 2 * self.most:
            raise StoppedError(f"boundary elements had used {self.spent:.0f} s, twice the {self.most:g} s that --seconds allows, "
                              f"at {self.done} of {self.count} solutions")


def solve(maps: list, pressure: np.ndarray, bodies: Bodies, points: int, longest: float, effort: Effort,
          free: bool = False) -> tuple:
    """Stiffness and contact on the sum of the maps, and its scatter among the four quarters.

    Parameters
    ----------
    maps : list of (heights, spacing)
        One or two.
    pressure : ndarray
        Rising [Pa].
    bodies : Bodies
    points : int
        A side of the map after averaging; the half space of one continued evenly has twice as many.
    longest : float
        Longest wavelength that counts [m].
    effort : Effort
        Its bound makes the points fewer, to `FEWEST`.
    free : bool
        Nothing touches outside the map and, solved alone, outside each quarter; k_T is then ratio times k_N.

    Returns
    -------
    k_n, k_t, area : ndarray
        [Pa/m], [Pa/m], share.
    scatter, coarse : ndarray
        Standard deviation of ln k_N of the mean of four quarters, and by the averaging.
    points : int
        That were taken.

    Raises
    ------
    StoppedError
        Longer than it may.
    InputError, NotConvergedError
        Spacings differ, tamaas is missing, a residual was not reached.
    """
    z, spacing = _sum(maps, longest)
    quarters = [level(part)[0] for part in _quarters(z)]
    args = (bodies.e_star, bodies.ratio, bodies.hardness)
    points = min(points, max(z.shape))
    trial, step = _averaged(quarters[0], spacing, max(SMALLEST, points // 4))
    begun = time.monotonic()
    some = pressure[::4]
    half_space.stiffness_on_map(trial if free else half_space.mirrored(trial), step, some, *args, tangential=False, free=free)
    unit = (time.monotonic() - begun) * pressure.size / some.size / GROWTH ** np.log2(max(trial.shape))

    def foretell(n):
        return unit * GROWTH ** np.log2(n) * ((1 if free else SHEAR) + 4 / GROWTH)

    first = foretell(points)
    while foretell(points) > effort.most and points // 2 >= FEWEST:
        points //= 2
    effort.foretold = foretell(points)
    if effort.foretold > effort.most:
        raise StoppedError(f"boundary elements would take about {effort.foretold:.0f} s on {points} points a side, and --seconds "
                          f"allows {effort.most:g}")
    fewer = f" (more points would take about {first:.0f} s, --seconds allows {effort.most:g})" if first > effort.most else ""
    effort.tell(f"boundary elements: {pressure.size} pressures on {points} points a side and on four quarters, about "
                f"{effort.foretold:.0f} s{fewer}")
    effort.count, effort.start = 5 * pressure.size, time.monotonic()
    logs = []
    for i, part in enumerate(quarters, 1):
        found = on_fewer_points(part, spacing, points // 2, pressure, *args, free=free, tangential=False,
                                tell=partial(effort.step, f"quarter {i}"))
        logs.append(np.log(found[0]))
    k_n, k_t, area, coarse = on_fewer_points(z, spacing, points, pressure, *args, free=free, tell=partial(effort.step, "whole map"))
    return k_n, k_t, area, np.maximum(np.std(logs, axis=0, ddof=1) / 2, COARSE[1]), coarse, points


def on_fewer_points(z: np.ndarray, spacing: tuple[float, float], points: int, pressure: np.ndarray, e_star: float, ratio: float,
                    hardness: float = np.inf, periodic: bool = False, free: bool = False, **options: Any) -> tuple:
    """Boundary elements on an averaged map; the waves that averaging takes add their compliance by theory.

    Parameters
    ----------
    z : ndarray
        Levelled heights [m].
    spacing : (float, float)
        [m].
    points : int
        Most points a side after averaging over blocks.
    pressure : ndarray
        Rising [Pa].
    e_star, ratio, hardness : float
        As `HalfSpace`.
    periodic, free : bool
        Take the map as periodic, or as a free patch (`HalfSpace`); else it is continued evenly.
    **options
        Of `half_space.stiffness_on_map`.

    Returns
    -------
    k_n, k_t, area, error : ndarray
        [Pa/m], [Pa/m], share that touches, standard deviation of ln k_N by the averaging.
    """
    small, step = _averaged(z, spacing, points)
    heights = small if periodic or free else half_space.mirrored(small)
    k_n, k_t, area = half_space.stiffness_on_map(heights, step, pressure, e_star, ratio, hardness, free=free, **options)
    if small.shape == z.shape:
        return k_n, k_t, area, np.zeros(len(k_n))
    (k_all, a_all), (k_small, a_small) = (_by_theory(m, d, pressure, e_star, hardness) for m, d in ((z, spacing), (small, step)))
    softer = 1 / (1 + k_n * np.maximum(1 / k_all - 1 / k_small, 0))
    area = np.minimum(area * a_all / a_small, 1)
    return k_n * softer, k_t * softer, area, coarse_error(area * small.size)


def coarse_error(touching: np.ndarray) -> np.ndarray:
    """Standard deviation of ln k_N of an averaged map of which so many points touch (bench/joint_law.py fewer)."""
    return np.hypot(COARSE[0] / np.sqrt(np.maximum(touching, 1)), COARSE[1])


def _by_theory(z, spacing, pressure, e_star, hardness):
    qy, qx, power = waves(z, spacing)
    q = np.hypot(qy, qx)
    s = bands(q[q > 0], power[q > 0])
    return contact_from_spectrum(s.q, s.height_variance, pressure, e_star, hardness)[:2]


def _sum(maps, longest):
    """Levelled heights of the equivalent surface, and their spacing."""
    z, spacing = level(maps[0][0])[0], maps[0][1]
    if len(maps) == 2:
        other = level(maps[1][0])[0]
        if unlike(spacing, maps[1][1]):
            coarser = tuple(np.maximum(spacing, maps[1][1]))
            z, other = (resample(Specimen(h, d), coarser).heights for h, d in ((z, spacing), (other, maps[1][1])))
            spacing = coarser
        n, m = (min(a, b) for a, b in zip(z.shape, other.shape))
        z = level(z[:n, :m] + other[:n, :m])[0]
    if np.isfinite(longest):
        z = _shortened(z, spacing, longest)
    return z, spacing


def unlike(first: tuple[float, float], second: tuple[float, float]) -> bool:
    """Two spacings differ: the finer map is resampled to the coarser one."""
    return not np.allclose(first, second, rtol=1e-3)


def _quarters(z):
    n, m = (s // 2 for s in z.shape)
    return z[:n, :m], z[n:, :m], z[:n, m:], z[n:, m:]


def _averaged(z, spacing, points):
    """Map averaged over blocks to at most `points` a side."""
    return averaged(z, spacing, [max(1, -(-n // points)) for n in z.shape])


def _shortened(z, spacing, longest):
    """Map without the waves longer than `longest`."""
    n, m = z.shape
    h = np.fft.fft2(half_space.mirrored(z))
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(2 * n, spacing[0]), np.fft.fftfreq(2 * m, spacing[1]), indexing="ij"))
    h[q < (1 - ROUNDING) / longest] = 0
    return np.fft.ifft2(h).real[:n, :m]
