# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothing by cubic B-splines with a penalty on the change of curvature (P-splines)."""
from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

__all__: list[str] = []


def basis(x: ArrayLike, low: float, high: float, pieces: int, derivative: int = 0) -> np.ndarray:
    """Cubic B-splines on equal intervals.

    Parameters
    ----------
    x : array_like (n,)
        Within [low, high]; outside the last polynomial is continued.
    low, high : float
    pieces : int
        Intervals.
    derivative : int
        0 or 1.

    Returns
    -------
    ndarray (n, pieces + 3)
    """
    x = np.asarray(x, float)
    h = (high - low) / pieces
    i = np.clip(np.floor((x - low) / h).astype(int), 0, pieces - 1)
    u = (x - low) / h - i
    if derivative == 0:
        parts = ((1 - u)**3, 3 * u**3 - 6 * u**2 + 4, -3 * u**3 + 3 * u**2 + 3 * u + 1, u**3)
    else:
        parts = tuple(p / h for p in (-3 * (1 - u)**2, 9 * u**2 - 12 * u, -9 * u**2 + 6 * u + 3, 3 * u**2))
    out = np.zeros((len(x), pieces + 3))
    for k, part in enumerate(parts):
        out[np.arange(len(x)), i + k] = part / 6
    return out


class Spline:
    """A smoothing spline y(x).

    Parameters
    ----------
    x, y : array_like (n,)
    pieces : int
    penalty : float
        Weight of the squared third differences.
    pull : array_like (pieces,), optional
        What these differ from, over the root of the penalty: drawn with the scatter of y it makes fits whose spread holds the bias.

    Attributes
    ----------
    freedom : float
        Effective number of parameters.
    """

    def __init__(self, x: ArrayLike, y: ArrayLike, pieces: int, penalty: float, pull: ArrayLike | None = None) -> None:
        x = np.asarray(x, float)
        self.low, self.high, self.pieces = x.min(), x.max(), pieces
        b = basis(x, self.low, self.high, pieces)
        d = np.diff(np.eye(pieces + 3), 3, axis=0)
        system = b.T @ b + penalty * d.T @ d
        right = b.T @ np.asarray(y, float) + (0 if pull is None else np.sqrt(penalty) * (np.asarray(pull) @ d))
        self.coefficients = np.linalg.solve(system, right)
        self.freedom = np.trace(np.linalg.solve(system, b.T @ b))

    def __call__(self, x: Any, derivative: int = 0) -> Any:
        """Value, or first derivative."""
        return basis(x, self.low, self.high, self.pieces, derivative) @ self.coefficients
