# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothing by cubic B-splines with a penalty on the curvature (P-splines), the penalty by generalised cross-validation."""
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
    penalty : float, optional
        Weight of the squared second differences; default: the one with the least generalised cross-validation score.

    Attributes
    ----------
    penalty : float
    residual : float
        Standard deviation of the residuals, degrees of freedom counted.
    freedom : float
        Effective number of parameters.
    """

    def __init__(self, x: ArrayLike, y: ArrayLike, pieces: int = 24, penalty: float | None = None) -> None:
        x, y = np.asarray(x, float), np.asarray(y, float)
        self.low, self.high, self.pieces = x.min(), x.max(), pieces
        b = basis(x, self.low, self.high, pieces)
        d = np.diff(np.eye(pieces + 3), 2, axis=0)
        normal, right, rough = b.T @ b, b.T @ y, d.T @ d
        trials = [penalty] if penalty is not None else np.trace(normal) / (pieces + 3) * 10.0**np.arange(-6, 5, 0.5)
        best = np.inf
        for trial in trials:
            system = normal + trial * rough
            c = np.linalg.solve(system, right)
            freedom = np.trace(np.linalg.solve(system, normal))
            square = np.sum((y - b @ c)**2)
            score = square / max(len(x) - freedom, 1)**2
            if score < best:
                best, self.penalty, self.coefficients, self.freedom = score, trial, c, freedom
                self.residual = np.sqrt(square / max(len(x) - freedom, 1))

    def __call__(self, x: Any, derivative: int = 0) -> Any:
        """Value, or first derivative."""
        return basis(x, self.low, self.high, self.pieces, derivative) @ self.coefficients
