# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear Gaussian filters of heights: profiles by ISO 16610-21, maps by ISO 16610-61.

At edges and beside holes the points that are there weigh more (the regression of order 0 of ISO 16610-31, not robust).
"""
from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._check import array, checked, number
from .._engine import InputError
from .._types import Spacing

__all__ = ["highpass", "lowpass"]
HEIGHTS = array([(None,), (None, None)], holes=True)
STEPS = array([(), (1,), (2,)], above=0)
ALPHA = np.sqrt(np.log(2) / np.pi)      #: half of a wave as long as the nesting index passes (ISO 16610-21)
_REACH = 1.5                            #: half width of the weights, in nesting indices: what lies beyond weighs 1e-14


@checked(heights=HEIGHTS, spacing=STEPS, nesting_index=number(above=0))
def lowpass(heights: ArrayLike, spacing: Spacing, nesting_index: float) -> np.ndarray:
    """The mean surface: what is longer than the nesting index.

    Parameters
    ----------
    heights : array_like (rows, points) or (points,)
        Heights [m]; NaN are holes, and stay.
    spacing : (float, float)
        (dy, dx) [m].
    nesting_index : float
        Cut-off wavelength, passed by half [m]; at least two spacings. Wavelength L is passed by exp(-pi (ALPHA index / L)^2).

    Returns
    -------
    ndarray
        Same shape [m].

    Raises
    ------
    InputError
        The nesting index is shorter than two spacings or longer than the map.
    """
    z = np.asarray(heights)
    steps = tuple(np.broadcast_to(spacing, 2).tolist())[-z.ndim:]
    sides = [n * d for n, d in zip(z.shape, steps)]
    if not 2 * max(steps) <= nesting_index <= max(sides):
        raise InputError(f"nesting index {nesting_index:.6g} m: at least two spacings, {2 * max(steps):.3g} m, and at most the "
                         f"longer side, {max(sides):.3g} m")
    good = np.isfinite(z)
    total, weight = np.where(good, z, 0.0), good.astype(float)
    for axis, step in enumerate(steps):
        total, weight = (_smooth(a, nesting_index / step, axis) for a in (total, weight))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(good, total / weight, np.nan)


@checked(heights=HEIGHTS, spacing=STEPS, nesting_index=number(above=0))
def highpass(heights: ArrayLike, spacing: Spacing, nesting_index: float) -> np.ndarray:
    """What is shorter than the nesting index: heights less `lowpass`; arguments and errors as there."""
    return heights - lowpass(heights, spacing, nesting_index)


def _smooth(a, index, axis):
    """Sums of weights times numbers along an axis, by Fourier transform with room for all of the weights."""
    n = a.shape[axis]
    reach = min(int(np.ceil(_REACH * index)), n - 1)
    w = np.exp(-np.pi * (np.arange(-reach, reach + 1) / (ALPHA * index)) ** 2)
    size = n + 2 * reach
    shape = [1] * a.ndim
    shape[axis] = -1
    spectrum = np.fft.rfft(w / w.sum(), size).reshape(shape)
    out = np.fft.irfft(np.fft.rfft(a, size, axis=axis) * spectrum, size, axis=axis)
    return np.take(out, range(reach, reach + n), axis=axis)
