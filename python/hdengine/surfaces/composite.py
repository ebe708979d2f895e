# SPDX-License-Identifier: GPL-3.0-or-later
"""The sum map of two specimens: one spacing, common size, registered where both are faces of one joint."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .._check import ROUNDING
from .._engine import InputError
from .._types import Spacing
from . import roughness
from .specimen import Specimen

__all__: list[str] = []
_FEWEST = 8     # points a side that two maps share
_CLEAR = 12     # height of the peak of the correlation over its scatter, from which on maps are shifted to it
_EQUAL = 0.999  # correlation of maps that are one


@dataclass(frozen=True)
class Composite:
    """Sum map of two specimens, h = z_1 + z_2: what a flat rigid face would have to carry to touch as both do."""

    specimen: Specimen                      #: the sum map, both planes taken off [m]
    first: Specimen = field(repr=False)     #: what is added: resampled, cropped, plane taken off
    second: Specimen = field(repr=False)
    shift: tuple                            #: (rows, points) by which the second was moved to match the first
    correlation: float                      #: of the two maps as they were added, -1 to 1
    significance: float                     #: peak of the phase correlation over its rms; above 12: a match (chance: 5 to 7)
    registered: bool                        #: the second was moved


def resample(specimen: Specimen, spacing: Spacing) -> Specimen:
    """The same heights at another spacing, by cubic interpolation; cropped to whole steps.

    Heights are sampled, not averaged: the structure function at the lags of the new spacing stays that of the old map. Points whose
    neighbours are holes become holes.

    Parameters
    ----------
    specimen : Specimen
        Map or profile, at least 4 points each way.
    spacing : float or (float, float)
        New spacing (dy, dx) [m].

    Returns
    -------
    Specimen
    """
    dx, dy = roughness._spacing(spacing)
    z = _cubic(specimen.heights, specimen.spacing[1], dx)
    if z.ndim == 2:
        z = _cubic(z.T, specimen.spacing[0], dy).T
    return Specimen(np.ascontiguousarray(z), (dy, dx), specimen.name, (*specimen.notes, "resampled"))


def _cubic(z, old, new):
    """Cubic Lagrange interpolation along the last axis, which keeps cubics."""
    n = z.shape[-1]
    if abs(old - new) <= ROUNDING * new:
        return z
    if n < 4:
        raise InputError(f"{n} points in a direction: resampling takes at least 4")
    at = np.arange(int(np.floor((n - 1) * old / new * (1 + 1e-12))) + 1) * (new / old)
    i = np.clip(at.astype(int), 1, n - 3)
    x = at - i
    weights = (-x * (x - 1) * (x - 2) / 6, (x + 1) * (x - 1) * (x - 2) / 2, -(x + 1) * x * (x - 2) / 2, (x + 1) * x * (x - 1) / 6)
    return sum(np.where(w == 0, 0.0, z[..., i + k - 1] * w) for k, w in enumerate(weights))


def _offset(a, b):
    """Shift of b that matches a or -a best, by phase correlation of the maps under a Hann window; and its significance."""
    window = np.hanning(a.shape[0] + 2)[1:-1, None] * np.hanning(a.shape[1] + 2)[None, 1:-1]
    spectra = [np.fft.rfft2(np.nan_to_num(z) * window) for z in (a, b)]
    cross = spectra[0] * np.conj(spectra[1])
    cross /= np.maximum(abs(cross), np.finfo(float).tiny)
    peak = np.fft.irfft2(cross, s=a.shape)
    k = np.unravel_index(np.argmax(abs(peak)), peak.shape)
    return tuple(int((i + n // 2) % n - n // 2) for i, n in zip(k, peak.shape)), float(abs(peak[k]) / np.std(peak))


def composite(first: Specimen, second: Specimen, register: bool | None = None) -> Composite:
    """Sum map of two specimens.

    Both are resampled to the coarser spacing of the two in each direction and cropped to the common size about their middles; their
    planes are taken off. The second is given as seen through the first, so that points above each other have the same place.

    Parameters
    ----------
    first, second : Specimen
        Both maps, or both profiles.
    register : bool, optional
        Move the second by whole points to where it matches the first best (faces of one joint carry each other's print). Default:
        only if the match is beyond chance: the peak of the phase correlation is 12 times its rms.

    Returns
    -------
    Composite

    Raises
    ------
    InputError
        A map and a profile; less than 8 common points in a direction; both are the same heights (the same file twice): their
        sum is not that of two independent surfaces.
    """
    a, b = first, second
    if a.heights.ndim != b.heights.ndim:
        raise InputError(f"{a.name} is {'a map' if a.heights.ndim == 2 else 'a profile'} and {b.name} is not: give two of a kind")
    step = tuple(max(p, q) for p, q in zip(a.spacing, b.spacing))
    a, b = (s if np.allclose(s.spacing, step, rtol=ROUNDING) else resample(s, step) for s in (a, b))
    shape = tuple(map(min, a.heights.shape, b.heights.shape))
    if min(shape) < _FEWEST:
        raise InputError(f"{a.name} and {b.name} have {' x '.join(map(str, shape))} points in common: {_FEWEST} or more are needed")
    flat = [np.atleast_2d(roughness.level(_middle(s.heights, shape))) for s in (a, b)]
    shift, significance = _offset(*flat)
    moved = bool(register) if register is not None else significance > _CLEAR
    if moved and any(2 * abs(k) > n for k, n in zip(shift, flat[0].shape) if n > 1):
        raise InputError(f"{a.name} and {b.name} match at a shift of {shift} points, more than half a map: give the same place")
    if not moved:
        shift = (0, 0)
    flat = [_overlap(z, s) for z, s in zip(flat, (shift, tuple(-k for k in shift)))]
    good = np.isfinite(flat[0]) & np.isfinite(flat[1])
    correlation = float(np.corrcoef(flat[0][good], flat[1][good])[0, 1])
    if correlation > _EQUAL:
        raise InputError(f"{first.name} and {second.name} are the same heights (correlation {correlation:.4f})")
    if a.heights.ndim == 1:
        flat = [z[0] for z in flat]
    flat = [roughness.level(z) for z in flat]
    name = f"{first.name} + {second.name}"
    parts = [Specimen(z, step, s.name, s.notes) for z, s in zip(flat, (first, second))]
    return Composite(Specimen(flat[0] + flat[1], step, name), parts[0], parts[1], shift, correlation, significance,
                     moved and shift != (0, 0))


def _middle(z, shape):
    """The middle of an array, of a smaller shape."""
    start = [(n - m) // 2 for n, m in zip(z.shape, shape)]
    return z[tuple(slice(s, s + m) for s, m in zip(start, shape))]


def _overlap(z, shift):
    """The part of a map that another, moved by `shift`, covers."""
    return z[tuple(slice(max(k, 0), n + min(k, 0)) for k, n in zip(shift, z.shape))]
