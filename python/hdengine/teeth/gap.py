# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance of two flanks: curves as polylines, the shortest way between them, negative where one enters the other's body."""
from __future__ import annotations

import numpy as np

from .._check import array, checked
from .._engine import InputError

__all__ = ["envelope", "flank_gap"]
TOUCH = 1e-12   # of two points that are one [m]


def _line(name, value):
    """A rule: a polyline."""
    points = array((None, 2))(name, value)
    if len(points) < 2 or not np.diff(points, axis=0).any(1).all():
        raise InputError(f"{name} of {len(points)} points: must be two or more, none twice in turn")
    return points


def _onto(points, curve, left):
    """Nearest places of a curve for points: distance, side (positive: free), before or after the curve's ends, way, normal."""
    a, d = curve[:-1], np.diff(curve, axis=0)
    x, y = points[:, :1] - a[:, 0], points[:, 1:] - a[:, 1]
    share = (x * d[:, 0] + y * d[:, 1]) / np.einsum("sk,sk->s", d, d)
    inside = np.clip(share, 0.0, 1.0)
    foot_x, foot_y = x - inside * d[:, 0], y - inside * d[:, 1]
    i = np.argmin(foot_x * foot_x + foot_y * foot_y, axis=1)
    row = np.arange(len(points))
    foot = np.column_stack([foot_x[row, i], foot_y[row, i]])
    cross = left * (d[i, 0] * y[row, i] - d[i, 1] * x[row, i])
    before, after = (i == 0) & (share[row, i] < 0), (i == len(d) - 1) & (share[row, i] > 1)
    normal = left * np.column_stack([d[i, 1], -d[i, 0]]) / np.hypot(d[i, 0], d[i, 1])[:, None]
    return np.hypot(*foot.T), cross, before, after, -foot, normal


@checked(tooth=_line, space=_line)
def flank_gap(tooth: np.ndarray, space: np.ndarray) -> tuple[float, float, float]:
    """Clearance of a tooth's flank from the flank of the space it is in.

    Both are open polylines whose points lie outwards, from the tooth's root to its tip and from the space's mouth to its bottom. A
    corner that has passed the other's tip has entered as far as the shorter way out, past the flank or past the tip.

    Parameters
    ----------
    tooth, space : ndarray (n, 2)
        (s, r), s towards the flank's side [m].

    Returns
    -------
    gap : float
        [m]; negative: they enter each other.
    angle : float
        Of the way from the tooth to the space, from the tangent outwards [rad].
    radius : float
        Radius at which the tooth is nearest [m].
    """
    best = (np.inf, 0.0, 0.0)
    for points, curve, left, sign in ((tooth, space, 1, 1), (space, tooth, -1, -1)):
        far, cross, before, after, way, normal = _onto(points, curve, left)
        depth = sign * (points[:, 1] - curve[0 if sign > 0 else -1, 1])     # past the other's tip, where positive
        entered = (cross < 0) & (depth > 0) & ~(after if sign > 0 else before)
        gap = np.where(entered, -np.minimum(far, depth), far)
        i = int(np.argmin(gap))
        if gap[i] < best[0]:
            corner = (before[i] or after[i]) and not entered[i] and far[i] > TOUCH
            n = sign * (way[i] / far[i] if corner else normal[i])
            best = (float(gap[i]), float(np.arctan2(n[1], n[0])), float(points[i, 1] if sign > 0 else points[i, 1] + way[i, 1]))
    return best


@checked(flanks=array((None, None, 2)), radius=array((None,)))
def envelope(flanks: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Half angles of the space that a flank in all its places leaves free, at radii.

    Parameters
    ----------
    flanks : ndarray (n, m, 2)
        (s, r) of the flank in the space [m].
    radius : ndarray (k,)
        [m].

    Returns
    -------
    ndarray (k,)
        [rad]; -inf where no flank comes.
    """
    half = np.full(len(radius), -np.inf)
    for flank in flanks:
        r, angle = np.hypot(flank[:, 0], flank[:, 1]), np.arctan2(flank[:, 0], flank[:, 1])
        order = np.argsort(r)
        half = np.maximum(half, np.interp(radius, r[order], angle[order], left=-np.inf, right=-np.inf))
    return half
