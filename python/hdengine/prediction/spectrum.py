# SPDX-License-Identifier: GPL-3.0-or-later
"""The power spectrum of a height map as the joint needs it, and what in the map speaks against it."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from .._check import ROUNDING
from .._engine import InputError

__all__: list[str] = []
PER_OCTAVE = 16  # bands of a spectrum
SMALLEST = 16     # points a side
_MOST_HOLES = 0.2   # of the points
_TINY = np.finfo(float).tiny
_FLAT = 1e-12       # rms height over the largest height that rounding makes
_LINE = 4           # points of a spectrum that a slope is laid through, at least
_LONG = 1.9, 8.0    # of the lowest frequency: the waves between them tell a roll-off; longer ones levelling takes
CRESTS = (0.9, 0.995, 1.2943)   # shares of the points below two heights of the crests, and their distance on random waves [rms]


@dataclass(frozen=True)
class Spectrum:
    """Variance of heights over wavenumber, isotropic.

    Parameters
    ----------
    q : ndarray (bands,)
        Mean wavenumber of each band, rising [1/m].
    height_variance : ndarray (bands,)
        Variance of the heights in it [m^2].
    modes : ndarray (bands,)
        Waves of the map in it.
    freedom : ndarray (bands,), optional
        Squares that the variance is the mean of, which is known to sqrt(2 / freedom). Default: modes.
    """

    q: np.ndarray = field(repr=False)
    height_variance: np.ndarray = field(repr=False)
    modes: np.ndarray = field(repr=False)
    freedom: np.ndarray = field(repr=False, default=cast(Any, None))

    def __post_init__(self) -> None:
        if self.freedom is None:
            object.__setattr__(self, "freedom", self.modes)

    @property
    def h_rms(self) -> float:
        """Root mean square height [m]."""
        return float(np.sqrt(self.height_variance.sum()))

    @property
    def slope_rms(self) -> float:
        """Root mean square gradient."""
        return float(np.sqrt((self.height_variance * self.q**2).sum()))

    @property
    def waves(self) -> float:
        """Independent waves: of equal variance, so many would hold the heights as these do. Few long ones may hold most of it."""
        return float(self.height_variance.sum()**2 / (self.height_variance**2 / np.maximum(self.modes, _TINY)).sum())

    @property
    def c(self) -> np.ndarray:
        """Two-dimensional isotropic spectrum C(q), h_rms^2 = 2 pi int q C dq [m^4], on the width of each band."""
        edges = np.sqrt(self.q[1:] * self.q[:-1])
        edges = np.concatenate([[self.q[0]**2 / edges[0]], edges, [self.q[-1]**2 / edges[-1]]])
        return self.height_variance / (np.pi * np.diff(edges**2))

    def __add__(self, other: Spectrum) -> Spectrum:
        """Spectrum of the equivalent surface of two on one area: variances of independent surfaces add.

        The waves of a band are those of the map that holds its height; so is how well it is known (Satterthwaite 1946).
        """
        q, h, modes = (np.concatenate([getattr(s, name) for s in (self, other)]) for name in ("q", "height_variance", "modes"))
        both = bands(q, h, modes)
        place = np.split(np.unique(numbers(q), return_inverse=True)[1], [len(self.q)])
        share, m, f = (np.stack([np.bincount(at, getattr(s, name), len(both.q)) for at, s in zip(place, (self, other))])
                       for name in ("height_variance", "modes", "freedom"))
        share = share / np.maximum(both.height_variance, _TINY)
        doubt = (share**2 / np.maximum(f, 1)).sum(0)
        return Spectrum(both.q, both.height_variance, (share * m).sum(0), 1 / np.maximum(doubt, _TINY))

    def of_area(self, share: float) -> Spectrum:
        """The spectrum on a share of the map's area, which holds so many of its waves; it is known as well as before."""
        return Spectrum(self.q, self.height_variance, self.modes * share, self.freedom)

    def between(self, longest: float = np.inf, shortest: float = 0.0) -> Spectrum:
        """The spectrum of wavelengths from `shortest` to `longest` [m].

        Raises
        ------
        InputError
            Fewer than two bands are left.
        """
        length = 2 * np.pi / self.q
        keep = (length <= longest * (1 + ROUNDING)) & (length >= shortest * (1 - ROUNDING))
        if keep.sum() < 2:
            raise InputError(f"wavelengths from {shortest:g} to {longest:g} m hold {keep.sum()} bands of the spectrum; valid: two "
                             f"or more of those from {2 * np.pi / self.q[-1]:.3g} to {2 * np.pi / self.q[0]:.3g} m (--longest)")
        return Spectrum(self.q[keep], self.height_variance[keep], self.modes[keep], self.freedom[keep])


def bands(q: np.ndarray, variance: np.ndarray, modes: np.ndarray | None = None) -> Spectrum:
    """Spectrum of single waves, or of spectra set side by side, gathered in narrow bands."""
    modes = np.ones(len(q)) if modes is None else modes
    number = numbers(q)
    h, m, qh, qm = (np.bincount(number, x) for x in (variance, modes, q * variance, q * modes))
    filled = m > 0
    h, m, qh, qm = h[filled], m[filled], qh[filled], qm[filled]
    return Spectrum(np.where(h > 0, qh / np.where(h > 0, h, 1), qm / m), h, m)


def numbers(q: np.ndarray) -> np.ndarray:
    """Numbers of the bands of wavenumbers, the lowest 0; those of waves that lie an octave apart differ by PER_OCTAVE."""
    return np.rint(np.log2(q / q.min()) * PER_OCTAVE).astype(int)


def level(heights: np.ndarray) -> tuple[np.ndarray, float]:
    """Heights without their mean plane, holes filled along the rows and columns.

    Parameters
    ----------
    heights : ndarray (rows, points)
        [m]; NaN are holes.

    Returns
    -------
    heights : ndarray
    holes : float
        Share of holes.

    Raises
    ------
    InputError
        No map, fewer than 16 points a side, holes on more than a fifth.
    """
    z = np.array(heights, dtype=float)
    if z.ndim != 2:
        raise InputError(f"a joint needs height maps, got {z.ndim} dimension(s): a profile does not tell the spectrum of an area")
    if min(z.shape) < SMALLEST:
        raise InputError(f"map of {z.shape[0]} x {z.shape[1]} points; valid: {SMALLEST} or more a side")
    good = np.isfinite(z)
    holes = 1 - float(good.mean())
    if holes > _MOST_HOLES:
        raise InputError(f"{100 * holes:.0f} % of the map are holes; valid: up to {100 * _MOST_HOLES:g} %")
    y, x = np.indices(z.shape)
    basis = np.stack([np.ones(z.size), x.ravel() / z.shape[1], y.ravel() / z.shape[0]], axis=1)
    plane = np.linalg.lstsq(basis[good.ravel()], z[good], rcond=None)[0]
    z -= (basis @ plane).reshape(z.shape)
    if holes:
        filled = [_fill(z), _fill(z.T).T]
        z = np.where(good, z, np.nanmean(filled, axis=0))
        z = np.where(np.isfinite(z), z, 0)
    return z, holes


def _fill(z):
    """Holes of each row interpolated; rows without any point stay empty."""
    out, x = z.copy(), np.arange(z.shape[1])
    for row in out:
        good = np.isfinite(row)
        if good.any():
            row[~good] = np.interp(x[~good], x[good], row[good])
    return out


def waves(z: np.ndarray, spacing: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Wave vectors and variances of a map continued evenly across its edges (cosine transform): no window, no jump at the seams.

    Parameters
    ----------
    z : ndarray (rows, points)
        Levelled heights [m].
    spacing : (float, float)
        (dy, dx) [m].

    Returns
    -------
    qy, qx, variance : ndarray (rows, points)
        [1/m], [m^2]; the first is the mean.
    """
    ny, nx = z.shape
    mirrored = np.concatenate([z, z[::-1]], axis=0)
    mirrored = np.concatenate([mirrored, mirrored[:, ::-1]], axis=1)
    power = np.abs(np.fft.rfft2(mirrored) / mirrored.size)**2
    power = power[:ny, :nx]
    power[1:] *= 2
    power[:, 1:] *= 2
    qy, qx = np.meshgrid(np.pi * np.arange(ny) / (ny * spacing[0]), np.pi * np.arange(nx) / (nx * spacing[1]), indexing="ij")
    power[0, 0] = 0
    return qy, qx, power


def averaged(z: np.ndarray, spacing: tuple[float, float], by: Sequence[int]) -> tuple[np.ndarray, tuple]:
    """A map averaged over blocks of so many (rows, points), and its spacing."""
    n, m = (s // b * b for s, b in zip(z.shape, by))
    return z[:n, :m].reshape(n // by[0], by[0], m // by[1], by[1]).mean((1, 3)), tuple(d * b for d, b in zip(spacing, by))


def crests(z: np.ndarray) -> float:
    """Height of the crests, from where a tenth of the points is higher to where one in two hundred is, over that of random waves.

    The waves have the same rms height. Less than 1: crests are worn off, or few valleys hold the height; more: few peaks do.
    """
    low, high = np.quantile(z, CRESTS[:2])
    return float(max((high - low) / (CRESTS[2] * z.std()), 1e-3))


def of_map(heights: np.ndarray, spacing: tuple[float, float]) -> tuple[Spectrum, dict]:
    """Spectrum of a map, and what is to be said of it.

    Parameters
    ----------
    heights : ndarray (rows, points)
        [m]; NaN are holes.
    spacing : (float, float)
        (dy, dx) [m].

    Returns
    -------
    spectrum : Spectrum
    facts : dict
        holes, skewness, kurtosis, crests (`crests`), isotropy (smaller over larger principal variance of the slope),
        slope_moments (its mean squares and products, rows first),
        noise_variance_m2 (white noise that the spectrum's end shows, 0: none), rolls_off (the map is longer than its longest waves
        that matter).

    Raises
    ------
    InputError
        As `level`; a flat map.
    """
    z, holes = level(heights)
    if not z.std() > _FLAT * np.nanmax(np.abs(heights)):
        raise InputError("the map is flat: no roughness, no joint")
    qy, qx, power = waves(z, spacing)
    finest = min(qy.max(), qx.max())    # of both directions: of unlike spacings one sees shorter waves
    alike = power * (np.maximum(qy, qx) <= finest * (1 + ROUNDING))
    moments = np.array([[(alike * a * b).sum() for a in (qy, qx)] for b in (qy, qx)])
    # the even continuation makes the mixed moment positive whatever the lay: take it from the gradients
    even, steps = averaged(z, spacing, [max(1, round(max(spacing) / d)) for d in spacing])
    gy, gx = np.gradient(even, *steps)
    both = max((gy**2).mean() * (gx**2).mean(), _TINY)
    moments[0, 1] = moments[1, 0] = (gy * gx).mean() * np.sqrt(moments[0, 0] * moments[1, 1] / both)
    q = np.hypot(qy, qx)
    inside = (q > 0) & (q <= finest)  # a whole quarter circle of directions
    spectrum = bands(q[inside], power[inside])
    w = z / z.std()
    facts = {"holes": holes, "skewness": float((w**3).mean()), "kurtosis": float((w**4).mean()), "crests": crests(z),
             "isotropy": isotropy(moments), "slope_moments": moments.tolist(),
             "h_rms_m": float(z.std()), "slope_rms": spectrum.slope_rms, "noise_variance_m2": _noise(spectrum, z.size),
             "rolls_off": _rolls_off(spectrum)}
    return spectrum, facts


def isotropy(moments: np.ndarray) -> float:
    """Smaller over larger principal value of mean squares and products of the slope."""
    small, large = np.linalg.eigvalsh(moments)
    return float(small / large)


def of_sum(spectrum: Spectrum, facts: list[dict]) -> dict:
    """What is to be said of the sum of independent maps: those that hold the height decide.

    Parameters
    ----------
    spectrum : Spectrum
        Of the sum.
    facts : list of dict
        Of each map (`of_map`).

    Returns
    -------
    dict
        skewness, crests, isotropy, rolls_off.
    """
    h, skew, high = np.array([[f[key] for key in ("h_rms_m", "skewness", "crests")] for f in facts]).T
    rms = np.sqrt((h**2).sum())
    return {"skewness": float((skew * (h / rms)**3).sum()), "crests": float(np.sqrt(((high * h / rms)**2).sum())),
            "isotropy": isotropy(np.sum([f["slope_moments"] for f in facts], axis=0)),
            "rolls_off": all(f["rolls_off"] for f in facts) or (len(facts) > 1 and _rolls_off(spectrum))}


def _per_wave(spectrum):
    """Height variance of a wave [m^2]; 0 where no wave is."""
    return spectrum.height_variance / np.where(spectrum.modes > 0, spectrum.modes, 1)


def _noise(spectrum, points):
    """Variance of white noise over all points that a flat end of the spectrum shows [m^2]; 0 where it still falls."""
    last = spectrum.q > spectrum.q[-1] / 2
    per_wave = _per_wave(spectrum)
    if last.sum() < _LINE or not np.all(per_wave[last] > 0):
        return 0.0
    fall = np.polyfit(np.log(spectrum.q[last]), np.log(per_wave[last]), 1, w=np.sqrt(spectrum.modes[last]))[0]
    return float(np.median(per_wave[last]) * points) if fall > -0.5 else 0.0


def _rolls_off(spectrum):
    """Whether the power per wave no longer rises towards the longest waves of the map: a roll-off at a third of the map or shorter.

    Waves longer than the map are left out, since levelling takes them. On 16 generated maps each with Hurst exponents from 0.2 to
    0.8, 94 % of those with a roll-off at a third of the map or less are told, and 87 to 100 % of those without one.
    """
    first = (spectrum.q > _LONG[0] * spectrum.q[0]) & (spectrum.q < _LONG[1] * spectrum.q[0])
    per_wave = _per_wave(spectrum)
    use = first & (per_wave > 0)
    if use.sum() < _LINE:
        return False
    fall = np.polyfit(np.log(spectrum.q[use]), np.log(per_wave[use]), 1, w=np.sqrt(spectrum.modes[use]))[0]
    return bool(fall > -1)
