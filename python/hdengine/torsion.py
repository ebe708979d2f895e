# SPDX-License-Identifier: GPL-3.0-or-later
"""Torsional stiffness of the contact (Eq. 45) and of the drive (Eq. 46)."""
from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._check import array, checked, flag, number, together
from ._engine import InputError


@checked(position=array(), normal=array())
def lever_arms(position: ArrayLike, normal: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Lever of the normal and squared distance from the axis.

    Parameters
    ----------
    position, normal : array_like (..., 3)
        Point [m] and unit normal.

    Returns
    -------
    lever_m, rho2_m2 : ndarray (...)
        e_z . (r x n) and x^2 + y^2.
    """
    shapes = np.shape(position), np.shape(normal)
    if any(shape[-1:] != (3,) for shape in shapes):
        raise InputError(f"position {shapes[0]}, normal {shapes[1]}: their last length must be 3")
    r, n = together(position=position, normal=normal)
    return r[..., 0] * n[..., 1] - r[..., 1] * n[..., 0], r[..., 0] ** 2 + r[..., 1] ** 2


@checked(theta=array(), r=number(above=0), w=number(), slope=number(), homothetic=flag)
def ellipse_facet(theta: ArrayLike, r: float, w: float, slope: float = 0.0, homothetic: bool = False) -> tuple:
    """Point, normal and area density of an elliptic cone at eccentric angle theta.

    Parameters
    ----------
    theta : array_like
        Eccentric angle [rad].
    r, w : float
        Semi-axes are r + w and r - w [m].
    slope : float
        tan of the cone angle.
    homothetic : bool
        Generator slopes in proportion to the semi-axes; otherwise equal.

    Returns
    -------
    position, normal : ndarray (..., 3)
        [m], unit vector.
    density : ndarray (...)
        dA / (dtheta dz) [m].
    """
    theta = np.asarray(theta, float)
    c, s = np.cos(theta), np.sin(theta)
    a, b = r + w, r - w
    da, db = (a * slope / r, b * slope / r) if homothetic else (slope, slope)
    n = np.stack([b * c, a * s, -(a * db * s**2 + b * da * c**2)], axis=-1)
    density = np.linalg.norm(n, axis=-1)
    return np.stack([a * c, b * s, 0 * c], axis=-1), n / density[..., None], density


@checked(k_n=array(empty=True), k_t=array(empty=True))
def torsional_stiffness(k_n: ArrayLike, k_t: ArrayLike, position: ArrayLike, normal: ArrayLike) -> np.ndarray:
    """K_TS, [Eq. 45] put right: torque per rotation about the z axis.

    K_TS = sum K_N lever^2 + K_T (rho^2 - lever^2).

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
    lever, rho2 = lever_arms(position, normal)
    k_n, k_t, lever, rho2 = together(k_n=k_n, k_t=k_t, lever=lever, rho2=rho2)
    return np.sum(k_n * lever**2 + k_t * (rho2 - lever**2), axis=-1)


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
    a, b = r + w, r - w
    alpha = np.arctan(slope)
    s, c = np.sin(theta), np.cos(theta)
    cos_beta = np.abs(s) * b / np.hypot(b * s, b * c + a * s)
    diameter = 2 * np.hypot(a * c, b * s)
    return np.sum((k_n * np.sin(alpha) + k_t * np.cos(alpha)) * cos_beta * diameter, axis=-1)


_stiffness = number(least=0)


def series(*stiffness: Any) -> Any:
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
def remaining_stiffness(k_total: Any, k_part: Any) -> Any:
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
