# SPDX-License-Identifier: GPL-3.0-or-later
"""Torsional stiffness of the contact (Eq. 45) and of the drive (Eq. 46)."""
from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from . import _engine
from ._check import array, checked, number, together
from ._engine import InputError

__all__ = ["remaining_stiffness", "series", "torsional_stiffness", "torsional_stiffness_paper"]


@checked(position=array(), normal=array())
def facet_weights(position: ArrayLike, normal: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Weights of K_N and K_T in Eq. 45: squares of the levers of a facet's normal and of its plane about the z axis.

    Parameters
    ----------
    position, normal : array_like (..., 3)
        Point [m] and unit normal.

    Returns
    -------
    w_n, w_t : ndarray (...)
        (e_z . (r x n))^2, and what it lacks of x^2 + y^2 [m^2].
    """
    shapes = np.shape(position), np.shape(normal)
    if any(shape[-1:] != (3,) for shape in shapes):
        raise InputError(f"position {shapes[0]}, normal {shapes[1]}: their last length must be 3")
    r, n = together(position=position, normal=normal)
    w_n, w_t = _engine.ask("torsion_weights", r.reshape(-1, 3).T, n.reshape(-1, 3).T)
    return w_n.reshape(r.shape[:-1]), w_t.reshape(r.shape[:-1])


@checked(k_n=array(empty=True), k_t=array(empty=True))
def torsional_stiffness(k_n: ArrayLike, k_t: ArrayLike, position: ArrayLike, normal: ArrayLike) -> np.ndarray:
    """K_TS, [Eq. 45] put right: torque per rotation about the z axis.

    K_TS = sum w_n K_N + w_t K_T (`facet_weights`).

    Parameters
    ----------
    k_n, k_t : array_like (..., facets)
        Stiffness of the facets [N/m].
    position, normal : array_like (..., facets, 3)
        Centres [m] and outward unit normals.

    Returns
    -------
    ndarray (...)
        [N m/rad].
    """
    w_n, w_t = facet_weights(position, normal)
    k_n, k_t, w_n, w_t = together(k_n=k_n, k_t=k_t, w_n=w_n, w_t=w_t)
    return np.sum(k_n * w_n + k_t * w_t, axis=-1)


@checked(k_n=array(empty=True), k_t=array(empty=True), theta=array(), r=number(above=0), w=number(), slope=number())
def torsional_stiffness_paper(k_n: ArrayLike, k_t: ArrayLike, theta: ArrayLike, r: float, w: float,
                              slope: float = 0.0) -> np.ndarray:
    """Give [Eq. 45] as printed: a sum of forces [N], not a torsional stiffness.

    sum (K_N sin alpha cos beta + K_T cos alpha cos beta) R_a with the diameter R_a = 2 rho and
    beta = arctan(cot theta + a/b), whose first term is cut off in print; at the long axis beta is 90 degrees.
    Kept to compare with the paper's figures; not to be used as a stiffness.

    Parameters
    ----------
    k_n, k_t : array_like (..., facets)
        Stiffness of the facets [N/m].
    theta : array_like (facets,)
        Eccentric angle [rad].
    r, w : float
        Semi-axes are r + w and r - w [m].
    slope : float
        tan alpha of the cone.

    Returns
    -------
    ndarray (...)
        [N].
    """
    k_n, k_t, theta = together(k_n=k_n, k_t=k_t, theta=theta)
    angles = np.asarray(theta)
    w_n, w_t = (w.reshape(angles.shape) for w in _engine.ask("torsion_weights_printed", angles.ravel(), r, w, slope))
    return np.sum(k_n * w_n + k_t * w_t, axis=-1)


_stiffness = number(least=0)


def series(*stiffness: float) -> float:
    """Springs in series [Eq. 46], in N m/rad; 0 if any of them is 0.

    Raises
    ------
    InputError
        No stiffness, or one that is no number or negative.
    """
    if not stiffness:
        raise InputError("no stiffness: give at least one [N m/rad]")
    k = np.array([_stiffness("stiffness", k) for k in stiffness])
    return 0.0 if np.any(k == 0) else float(1 / np.sum(1 / k))


@checked(k_total=number(), k_part=number())
def remaining_stiffness(k_total: float, k_part: float) -> float:
    """Stiffness in series with `k_part` that makes `k_total` ([Eq. 46] inverted), in N m/rad.

    Raises
    ------
    InputError
        k_total >= k_part: springs in series are softer than each of them. The paper's own figures do this
        (K_WTS = 5294 against K_TS = 1820 N m/rad), so they cannot all be right.
    """
    if not 0 < k_total < k_part:
        raise InputError(
            f"K_total = {k_total:g} N m/rad in series must be positive and below each of its parts, here {k_part:g} N m/rad")
    return 1 / (1 / k_total - 1 / k_part)
