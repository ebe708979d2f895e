# SPDX-License-Identifier: GPL-3.0-or-later
"""Eq. 17-44 as printed by Hu et al. (2023), kept to show where they fail. Nothing in hdengine computes with them."""
from __future__ import annotations

from math import log, pi

import numpy as np
from numpy.typing import ArrayLike

from .._types import JointLike

__all__: list[str] = []


def spot_ratio_fit(fractal_dimension: float) -> float:
    """Psi of Eq. 17 by the printed fit in D_s = D - 1, up to 0.37 % off."""
    return 5.454 * np.exp(-(fractal_dimension - 1) / 0.628) + 1.499


def load_parts(joint: JointLike, s_l: float) -> np.ndarray:
    """Eq. 23-26 with the printed limits, which assume s_l above the last regime edge.

    Parameters
    ----------
    joint : Joint
    s_l : float
        Largest spot [m^2].

    Returns
    -------
    ndarray (4,)
        Loads [N]; negative where s_l lies below an edge.
    """
    p = joint.asperity()[0]
    s_ec, f_ec, b = p["s_ec_m2"], p["f_ec_n"], (joint.fractal_dimension - 1) / 2
    s = np.array([0, 1, 7.1197, 205.3827, s_l / s_ec]) * s_ec
    factor = np.array([1, 1.1282, 1.4988, joint.hardness * s_ec / f_ec]) * f_ec
    power = np.array([1.5, 1.2544, 1.1021, 1.0])
    e = power - b
    return _share(joint, s_l) * factor * s_ec**-power * (s[1:] ** e - s[:-1] ** e) / e


def stiffness_parts(joint: JointLike, s_l: float) -> np.ndarray:
    """Eq. 30, 33, 34 as printed: only the finite part of the divergent Eq. 30, hence negative.

    Parameters
    ----------
    joint : Joint
    s_l : float
        Largest spot [m^2].

    Returns
    -------
    ndarray (3,)
        Normal stiffness [N/m].
    """
    p = joint.asperity()[0]
    s_ec, unit, b = p["s_ec_m2"], p["f_ec_n"] / p["eps_ec_m"], (joint.fractal_dimension - 1) / 2
    power = np.array([0.5, 0.3741, 0.2295])
    factor = np.array([1.5, 1.5081, 1.7935]) * unit * s_ec**-power
    e = power - b
    s = np.array([1, 7.1197, 205.3827]) * s_ec
    low = np.array([0.0, *(s[:2] ** e[1:])])
    return _share(joint, s_l) * factor * (s**e - low) / e


def tangential_by_strength(joint: JointLike, s: ArrayLike, strength: float) -> np.ndarray:
    """Eq. 39 with t = tau_b s, tau_b a shear strength: every spot slips, and the cube root turns complex or NaN.

    Parameters
    ----------
    joint : Joint
    s : array_like
        Areas of elastic spots [m^2].
    strength : float
        tau_b [Pa].

    Returns
    -------
    ndarray
        k_t [N/m].
    """
    p = joint.asperity()[0]
    s = np.asarray(s, dtype=float)
    f = p["f_ec_n"] * (s / p["s_ec_m2"]) ** 1.5
    with np.errstate(invalid="ignore"):
        return 8 * p["g_prime_pa"] * np.sqrt(s / pi) * (1 - strength * s / (joint.friction * f)) ** (1 / 3)


def power_integral(low: float, high: float, e: float) -> float:
    """(high^e - low^e) / e, the printed form: 0/0 at e = 0, digits lost near it."""
    return (high**e - low**e) / e


def waves(length: float, shortest: float, ratio: float) -> int:
    """n_max as floor(ln(L / L_s) / ln gamma): one too few where rounding leaves 14.9999999."""
    return int(log(length / shortest) / log(ratio))


def _share(joint, s_l):
    d = joint.fractal_dimension
    return (d - 1) / 2 * spot_ratio_fit(d) ** ((3 - d) / 2) * s_l ** ((d - 1) / 2)
