# SPDX-License-Identifier: GPL-3.0-or-later
"""Fractal rough surfaces: Weierstrass-Mandelbrot heights (Eq. 1-2) and the periodic surface of the same spectrum."""
from __future__ import annotations

import math
import numbers
import operator
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from .. import _engine
from .._check import HUGE, array, checked, integer, number, seen
from .._types import Spacing

__all__ = ["choose", "generate", "periodic", "profile", "sum_waves", "waves"]
METHODS = ("auto", "direct", "product", "nufft")
_TURNS = 2.0**53  # from here a phase has no digit behind the point
_LARGE = 1 << 24  # points from which the engine is asked before memory is taken


@dataclass(frozen=True)
class Method:
    """How a sum of waves is done, as `choose` reports it.

    Parameters
    ----------
    method : str
        'direct', 'product' or 'nufft'.
    n_max, waves : int
        Largest exponent of Eq. 1 and number of waves M (n_max + 1).
    predicted_s : dict
        Predicted time of the methods considered on the machine of docs/evidence/peers.md [s].
    memory_mb : float
        Memory needed beside the heights [MB].
    """

    method: str
    n_max: int
    waves: int
    predicted_s: dict
    memory_mb: float


def _seed(seed):
    try:
        seed = operator.index(seed)
    except TypeError:
        seed = -1
    if not 0 <= seed < 2**63:
        raise _engine.InputError("seed: must be an integer from 0 to 2^63 - 1")
    return seed


def _pair(value, name, kind=float):
    try:
        if type(value) is int or (kind is float and type(value) is float):
            return kind(value), kind(value)
        values = [kind(v) for v in np.broadcast_to(value, 2)]
        if kind is float and not all(isinstance(v, numbers.Real) for v in np.broadcast_to(value, 2)):
            raise TypeError
    except (TypeError, ValueError, OverflowError):
        raise _engine.InputError(f"{name} = {value!r}: give one number or two, (y, x)") from None
    return values[0], values[1]


def _grid(shape, spacing, origin, method, dtype):
    ny, nx = _pair(shape, "shape", operator.index)
    dy, dx = (_real("spacing", v) for v in _pair(spacing, "spacing"))
    y_0, x_0 = (_real("origin", v) for v in _pair(origin, "origin"))
    if not isinstance(method, str) or method not in METHODS:
        raise _engine.InputError(f"method = {method!r}: must be one of {', '.join(METHODS)}")
    try:
        dtype = np.dtype(dtype)
    except (TypeError, ValueError):
        raise _engine.InputError(f"dtype = {dtype!r}: must be float64 or float32") from None
    if dtype not in (np.dtype(np.float64), np.dtype(np.float32)):
        raise _engine.InputError(f"dtype = {dtype}: must be float64 or float32")
    if max(abs(nx), abs(ny)) >= 2**31:
        raise _engine.InputError(f"shape = {ny, nx}: must be below 2^31")
    return (nx, ny), np.array([dx, dy, x_0, y_0]), METHODS.index(method), dtype


_list = array([(None,)])
_ridges, _tolerance = integer(1), number(least=0, optional=True)
_real = number(finite=False)  # the engine checks the range


def _spectrum(fractal_dimension, roughness, gamma, length, shortest_wavelength):
    """The numbers of Eq. 1 as the engine takes them."""
    return np.array([_real("fractal_dimension", fractal_dimension), _real("roughness", roughness), _real("gamma", gamma),
                     _real("length", length), _real("shortest_wavelength", shortest_wavelength)])


def _room(size, dtype, out):
    """Array for heights, and its kind: a new one, or `out` after a look at it."""
    if out is None:
        return np.empty(size, dtype=dtype, order="F").T
    if not isinstance(out, np.ndarray) or out.dtype not in (np.float64, np.float32) or out.shape != size[::-1] \
            or not out.flags.c_contiguous or not out.flags.writeable:
        raise _engine.InputError(f"out = {seen(out)}: must be an array of shape {size[::-1]}, float64 or float32, contiguous, "
                                 "writeable")
    return out


def _turns(largest, what):
    """Refuse waves whose phase on the grid has no digits left."""
    if largest >= _TURNS:
        raise _engine.InputError(f"{what}: {largest:.3g} turns on the grid, must be below {_TURNS:.3g}, where no digit of the "
                                 "phase is left")


def _head(shape, spacing, spectrum, ridges, seed, origin, method, dtype):
    size, grid, wanted, dtype = _grid(shape, spacing, origin, method, dtype)
    spectrum = _spectrum(*spectrum)
    reach = max(abs(grid[2]) + size[0] * grid[0], abs(grid[3]) + size[1] * grid[1])
    if spectrum[4] > 0 and np.isfinite([*grid, spectrum[4]]).all():  # else the engine says what is wrong
        _turns(reach / spectrum[4], "origin and size over shortest_wavelength")
    return (spectrum, _ridges("ridges", ridges), _seed(seed), grid), size, dtype, wanted


def _arguments(shape, spacing, spectrum, ridges, seed, origin, tolerance, method, dtype):
    head, size, dtype, wanted = _head(shape, spacing, spectrum, ridges, seed, origin, method, dtype)
    found = _engine.call("surface_method", *head, *size, _tolerance("tolerance", tolerance) or 0.0, dtype.itemsize, wanted)
    n_max, waves, evaluator, seconds, memory = found
    predicted = {name: t for name, t in zip(METHODS[1:], seconds.tolist()) if t < HUGE}
    return head, size, dtype, int(evaluator), Method(METHODS[evaluator], int(n_max), int(waves), predicted, float(memory))


def choose(shape: Sequence[int], spacing: Spacing, fractal_dimension: float, roughness: float, gamma: float, length: float,
           shortest_wavelength: float, ridges: int, seed: int = 0, *, origin: float | Sequence[float] = 0.0,
           tolerance: float | None = None, method: str = "auto", dtype: DTypeLike = float) -> Method:
    """What `generate` would do with the same arguments: evaluator, waves, predicted times, memory.

    Returns
    -------
    Method

    Raises
    ------
    InputError, EngineMemoryError
        As `generate`.
    """
    spectrum = (fractal_dimension, roughness, gamma, length, shortest_wavelength)
    return _arguments(shape, spacing, spectrum, ridges, seed, origin, tolerance, method, dtype)[-1]


def generate(shape: Sequence[int], spacing: Spacing, fractal_dimension: float, roughness: float, gamma: float, length: float,
             shortest_wavelength: float, ridges: int, seed: int = 0, *, origin: float | Sequence[float] = 0.0,
             tolerance: float | None = None, method: str = "auto", dtype: DTypeLike = float,
             out: np.ndarray | None = None) -> np.ndarray:
    """Weierstrass-Mandelbrot surface (Eq. 1) on a rectangular grid.

    Parameters
    ----------
    shape : int or (int, int)
        Points (ny, nx).
    spacing : float or (float, float)
        Spacing (dy, dx) [m].
    fractal_dimension : float
        D in (2, 3).
    roughness : float
        G [m].
    gamma : float
        Frequency ratio, above 1.
    length : float
        L, the longest wavelength [m].
    shortest_wavelength : float
        L_s [m]: n_max = floor(ln(L / L_s) / ln gamma). Waves below two spacings are aliased, as in any sampling.
    ridges : int
        M, the number of directions.
    seed : int
        Seed of the phases. The heights of a seed are the same bits for any number of threads, those of 'direct' on every
        platform too.
    origin : float or (float, float)
        First point (y, x) [m]. Eq. 1 has z(0, 0) = 0.
    tolerance : float or None
        Root mean square error allowed, relative to the waves, 1e-13 to 0.1: lets 'auto' take the non-uniform FFT, which many
        waves need, and 'product' single precision. None: exact to rounding.
    method : str
        'direct' (term by term), 'product' (matrix products), 'nufft' (without a tolerance: to 1e-12); 'auto' takes the one
        predicted to be the fastest that keeps the tolerance.
    dtype : dtype
        float64 or float32.
    out : ndarray (ny, nx), optional
        Array to fill, float64 or float32, which replaces `dtype`: new memory costs as much as a small surface.

    Returns
    -------
    ndarray (ny, nx)
        Heights [m], ``[row, column]`` is ``[y, x]``.

    Raises
    ------
    InputError
        A parameter is out of range.
    EngineMemoryError
        The machine's memory does not hold it; the message says how much is needed.
    """
    spectrum = (fractal_dimension, roughness, gamma, length, shortest_wavelength)
    head, size, kind, wanted = _head(shape, spacing, spectrum, ridges, seed, origin, method, dtype if out is None else float)
    within = _tolerance("tolerance", tolerance) or 0.0
    if not 0 < min(size) <= size[0] * size[1] <= _LARGE:
        _engine.call("surface_method", *head, *size, within, kind.itemsize, wanted)
    heights = _room(size, kind, out)
    _engine.call("surface_heights", *head, *size, within, heights.itemsize, wanted, heights.ctypes.data)
    return heights


@checked(n=integer(-2**31), origin=_real)
def profile(n: int, spacing: float, fractal_dimension: float, roughness: float, gamma: float, length: float,
            shortest_wavelength: float, seed: int = 0, *, origin: float = 0.0, tolerance: float | None = None,
            method: str = "auto", dtype: DTypeLike = float) -> np.ndarray:
    """Weierstrass-Mandelbrot profile (Eq. 2): n heights [m] along x, with D_s = fractal_dimension - 1.

    Parameters as in `generate`; Eq. 2 is its row y = 0 with one ridge.

    Returns
    -------
    ndarray (n,)
        Heights [m] at ``origin + i * spacing``.

    Raises
    ------
    InputError, EngineMemoryError
        As `generate`.
    """
    return generate((1, n), spacing, fractal_dimension, roughness, gamma, length, shortest_wavelength, 1, seed,
                    origin=(0.0, origin), tolerance=tolerance, method=method, dtype=dtype)[0]


def waves(fractal_dimension: float, roughness: float, gamma: float, length: float, shortest_wavelength: float, ridges: int,
          seed: int = 0) -> dict:
    """The plane waves of Eq. 1: height = offset - sum of amplitude cos(2 pi (fx x + fy y + phase)).

    Returns
    -------
    dict
        fx_per_m, fy_per_m, amplitude_m, phase_turns (arrays, exponent outer, ridge inner) and offset_m.

    Raises
    ------
    InputError
        A parameter is out of range.
    """
    spectrum = (fractal_dimension, roughness, gamma, length, shortest_wavelength)
    count = _arguments(1, 1.0, spectrum, ridges, seed, 0.0, None, "direct", float)[-1].waves
    keys = ("fx_per_m", "fy_per_m", "amplitude_m", "phase_turns", "offset_m")
    return dict(zip(keys, _engine.call("surface_waves", _spectrum(*spectrum), ridges, _seed(seed), count)))


def sum_waves(fx: ArrayLike, fy: ArrayLike, amplitude: ArrayLike, phase: ArrayLike, shape: Sequence[int], spacing: Spacing, *,
              origin: float | Sequence[float] = 0.0, tolerance: float | None = None, method: str = "auto", dtype: DTypeLike = float,
              out: np.ndarray | None = None) -> np.ndarray:
    """Any sum of plane waves on a rectangular grid: - sum of amplitude cos(2 pi (fx x + fy y + phase)).

    Parameters
    ----------
    fx, fy : array_like (J,)
        Wave numbers [1/m].
    amplitude : array_like (J,)
        Amplitudes [m].
    phase : array_like (J,)
        Phases at x = y = 0 [turns].
    shape, spacing, origin, tolerance, method, dtype, out
        As in `generate`.

    Returns
    -------
    ndarray (ny, nx)
        Heights [m].

    Raises
    ------
    InputError, EngineMemoryError
        As `generate`; lengths that differ, no wave, numbers that are not finite.
    """
    size, grid, wanted, kind = _grid(shape, spacing, origin, method, dtype if out is None else float)
    given = {"fx": fx, "fy": fy, "amplitude": amplitude, "phase": phase}
    lists = [np.ascontiguousarray(_list(name, v)) for name, v in given.items()]
    tolerance = _tolerance("tolerance", tolerance)
    if len({v.size for v in lists}) != 1 or lists[0].size == 0:
        raise _engine.InputError(f"fx, fy, amplitude, phase: {[v.size for v in lists]} numbers, must be equally many, at least one")
    largest = [float(np.abs(v).max()) for v in lists]
    if not largest[2] * lists[2].size < HUGE**0.5:
        raise _engine.InputError(f"amplitude: {lists[2].size} waves of up to {largest[2]:.3g} m; valid: up to {HUGE**0.5:g} m")
    dx, dy, x_0, y_0 = grid.tolist()
    if math.isfinite(dx + dy + x_0 + y_0):  # else the engine says what is wrong
        _turns(largest[0] * (abs(x_0) + size[0] * dx), "fx")
        _turns(largest[1] * (abs(y_0) + size[1] * dy), "fy")
    _turns(largest[3], "phase")
    if not 0 < min(size) <= size[0] * size[1] <= _LARGE:
        _engine.call("surface_free_method", lists[0].size, grid, *size, tolerance or 0.0, kind.itemsize, wanted)
    heights = _room(size, kind, out)
    _engine.call("surface_free_heights", *lists, grid, *size, tolerance or 0.0, heights.itemsize, wanted, heights.ctypes.data)
    return heights


@checked(n=integer(-2**31), length=_real, fractal_dimension=_real, roughness=_real, shortest_wavelength=_real)
def periodic(n: int, length: float, fractal_dimension: float, roughness: float, shortest_wavelength: float,
             seed: int) -> np.ndarray:
    """Periodic surface with the continuum spectrum of Eq. 1: isotropic, band limited, random phases.

    Parameters
    ----------
    n : int
        Points per side.
    length : float
        Period and longest wavelength [m].
    fractal_dimension : float
        D in (2, 3).
    roughness : float
        G [m].
    shortest_wavelength : float
        Short cut-off [m], at least two spacings.
    seed : int
        Seed of the phases. The same seed is the same surface at every n.

    Returns
    -------
    ndarray (n, n)
        Heights [m] with mean zero at the points ``i * length / n``; ``[row, column]`` is ``[y, x]``.

    Raises
    ------
    InputError
        A parameter is out of range.
    EngineMemoryError
        The machine's memory does not hold it.
    """
    parameters = (length, fractal_dimension, roughness, shortest_wavelength)
    _engine.call("surface_check_periodic", n, *parameters)
    heights = np.empty((n, n), order="F")
    _engine.call("surface_periodic", *parameters, _seed(seed), heights)
    return heights.T
