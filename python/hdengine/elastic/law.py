# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact of a rough elastic joint by Persson's theory, from its spectrum (docs/explain/joint.md)."""
from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .. import _engine

__all__: list[str] = []


def moduli(e1: float, nu1: float, e2: float, nu2: float) -> tuple[float, float]:
    """E* [Pa] of two bodies, and the stiffness ratio k_T/k_N of full stick, 4 G*/E*.

    Source: Mindlin (1949); for rough surfaces Campana, Persson and Mueser (2011), doi 10.1088/0953-8984/23/8/085001.
    """
    e_star, ratio = _engine.ask("joint_moduli", e1, nu1, e2, nu2)
    return float(e_star), float(ratio)


def stiffness_from_spectrum(q: ArrayLike, height_variance: ArrayLike, pressure: ArrayLike, e_star: float,
                            hardness: float = np.inf) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normal stiffness per area, true contact and mean gap.

    Parameters
    ----------
    q : array_like
        Wavenumbers, rising [1/m].
    height_variance : array_like
        Variance of the equivalent surface's heights in the band about each [m^2].
    pressure : array_like
        Nominal pressures, above 0 [Pa].
    e_star : float
        Reduced modulus [Pa].
    hardness : float
        Pressure at which the softer body yields [Pa].

    Returns
    -------
    k_n, area, gap : ndarray
        [Pa/m], share of the nominal area that touches, distance of the two mean planes [m]. The gap is that of the elastic contact:
        yield leaves less.

    Raises
    ------
    InputError
        The bands do not rise or hold negative variance, the pressure is not below the hardness.
    """
    k_n, area, _, gap = _contact(q, height_variance, pressure, e_star, hardness, gap=True)
    return k_n, area, gap


def contact_from_spectrum(q: ArrayLike, height_variance: ArrayLike, pressure: ArrayLike, e_star: float,
                          hardness: float = np.inf) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normal stiffness per area, true contact, and the spread of the local pressures (Persson 2001) [Pa].

    Arguments and errors as of `stiffness_from_spectrum`; the gap is left out, which takes longer than all of these.
    """
    k_n, area, variance, _ = _contact(q, height_variance, pressure, e_star, hardness, gap=False)
    return k_n, area, np.sqrt(variance)


def _contact(q, height_variance, pressure, e_star, hardness, gap):
    p = np.atleast_1d(np.asarray(pressure, dtype=float))
    hardness = min(hardness, 1e6 * e_star)
    if p.size and not (p.min() > 0 and p.max() < hardness):
        raise _engine.InputError(f"pressures from {p.min():g} to {p.max():g} Pa; valid: above 0 and below the hardness, "
                                 f"{hardness:g} Pa")
    return _engine.call("spectrum_joint", np.asarray(q, float), np.asarray(height_variance, float), e_star, hardness, p, int(gap))
