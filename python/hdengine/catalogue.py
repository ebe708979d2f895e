# SPDX-License-Identifier: GPL-3.0-or-later
"""Torsional stiffness as catalogues state it: three chords of the torque-angle curve."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._check import ROUNDING, array, checked, integer, number
from ._engine import InputError

__all__ = ["Unit", "stages", "unit"]
SAME_ABOVE = 80   # from this ratio on, catalogues state one stiffness


@dataclass(frozen=True)
class Unit:
    """Stated stiffness of one size at a ratio: K1 up to T1, K2 from T1 to T2, K3 above."""

    size: int
    t1_nm: float
    t2_nm: float
    k1_nm_per_rad: float
    k2_nm_per_rad: float
    k3_nm_per_rad: float

    @property
    def slopes(self) -> np.ndarray:
        """K1, K2, K3 [N m/rad]."""
        return np.array([self.k1_nm_per_rad, self.k2_nm_per_rad, self.k3_nm_per_rad])

    @checked(torque_nm=array())
    def angle(self, torque_nm: ArrayLike) -> np.ndarray:
        """Angle of the three chords at torques [rad]."""
        t = np.abs(np.asarray(torque_nm, float))
        parts = (np.clip(t, 0, self.t1_nm) / self.k1_nm_per_rad, np.clip(t - self.t1_nm, 0, self.t2_nm - self.t1_nm)
                 / self.k2_nm_per_rad, np.clip(t - self.t2_nm, 0, None) / self.k3_nm_per_rad)
        return np.sign(torque_nm) * sum(parts)


# T1, T2 [N m]; K1, K2, K3 [kN m/rad] at ratios from 80 on, then at 50 and at 30. Sizes 14 to 40 from ratio 80: Harmonic Drive CHA
# manual, p. 50, with which the CHA-14A-E manual, p. 54, and Schaeffler TPI 275 agree. The others: typed from catalogues by the
# project AimanHaidar/harmonic-drive-selector, whose figures agree with the manual's where both exist.
_STATED: dict[int, tuple[Any, ...]] = {
    11: (0.8, 2.0, (2.7, 3.4, 4.4), (2.2, 3.0, 3.2)), 14: (2, 6.9, (4.7, 6.1, 7.1), (3.4, 4.7, 5.7), (1.9, 2.4, 3.4)),
    17: (3.9, 12, (10, 14, 16), (8.1, 11, 13), (3.4, 4.4, 6.7)), 20: (7, 25, (16, 25, 29), (13, 18, 23), (5.7, 7.1, 11)),
    25: (14, 48, (31, 50, 57), (25, 34, 44), (10, 13, 21)), 32: (29, 108, (67, 110, 120), (54, 78, 98), (24, 30, 49)),
    40: (54, 196, (130, 200, 230), (100, 140, 180)), 45: (76, 275, (180, 290, 330), (150, 200, 260)),
    50: (108, 382, (250, 400, 440), (200, 280, 340)), 58: (168, 598, (400, 610, 710), (310, 440, 540)),
    65: (235, 843, (540, 880, 980), (440, 610, 780)), 80: (430, 1570, (1000, 1620, 1850), (810, 1150, 1450)),
    90: (618, 2260, (1450, 2300, 2630), (1180, 1620, 2060))}
UNITS, AT_50, AT_30 = ({size: Unit(size, t1, t2, *(1e3 * k for k in stated[i]))
                        for size, (t1, t2, *stated) in _STATED.items() if i < len(stated)} for i in range(3))

# Rated torques [N m] at 2000 rpm at these ratios, 0 where none is stated: HFUC and, divided by 1.3, CSG of the same project;
# ZD Motor's SHF-2UH (en.zd-motor.com) has the same for sizes 14 to 32 at 50 to 120.
_RATIOS = (30, 50, 80, 100, 120, 160)
_RATED = {11: (0, 3.5, 0, 5), 14: (4, 5.4, 7.8, 7.8), 17: (8.8, 16, 22, 24, 24), 20: (15, 25, 34, 40, 40, 40),
          25: (27, 39, 63, 67, 67, 67), 32: (54, 76, 118, 137, 137, 137), 40: (0, 137, 206, 265, 294, 294),
          45: (0, 176, 313, 353, 402, 402), 50: (0, 122, 372, 470, 529, 529), 58: (0, 176, 549, 696, 745, 745),
          65: (0, 245, 745, 951, 951, 951), 80: (0, 436, 1320, 1700, 1990, 1990), 90: (0, 590, 1550, 2270, 2570, 2700)}


def rated_torque(size: int, ratio: int = 100) -> float:
    """Rated torque of a size, linear between the ratios at which catalogues state it, level beyond them [N m]."""
    known = [(at, torque) for at, torque in zip(_RATIOS, _RATED[size]) if torque]
    return float(np.interp(ratio, *np.transpose(known)))


@checked(size=integer(), ratio=integer(least=1))
def unit(size: int, ratio: int = 100) -> Unit | None:
    """What catalogues state of a size at a ratio; None where they state nothing: a size between, a ratio below 80 but 30 and 50.

    Parameters
    ----------
    size : int
        Pitch diameter of the flexspline in tenths of an inch.
    ratio : int

    Returns
    -------
    Unit or None
    """
    return (UNITS if ratio >= SAME_ABOVE else {50: AT_50, 30: AT_30}.get(ratio, {})).get(size)


def unit_of(scene: dict) -> Unit | None:
    """What catalogues state of the size whose T1 and T2 a scene ('group.key' to value) has, at its ratio."""
    found = (unit(size, scene["load.teeth"] // 2) for size in UNITS)
    return next((u for u in found if u and abs(u.t1_nm - scene["loop.torque_1"]) < ROUNDING
                 and abs(u.t2_nm - scene["loop.torque_2"]) < ROUNDING), None)


@checked(torque_nm=array((None,)), angle_rad=array((None,)), t1_nm=number(above=0), t2_nm=number(above=0))
def stages(torque_nm: ArrayLike, angle_rad: ArrayLike, t1_nm: float, t2_nm: float) -> list:
    """K1, K2, K3 of a curve: the chords from 0 to T1, from T1 to T2, and from T2 to its end.

    Parameters
    ----------
    torque_nm, angle_rad : array_like (n,)
        One loading branch, torque rising from 0.
    t1_nm, t2_nm : float
        Torques at which the catalogue changes its slope.

    Returns
    -------
    list of float
        [N m/rad]; a chord that the data end within is taken to their end, one beyond them is NaN.
    """
    t, a = np.asarray(torque_nm), np.asarray(angle_rad)
    if t.shape != a.shape or np.any(np.diff(t) < 0) or not t2_nm > t1_nm or t[0] > ROUNDING * t[-1]:
        raise InputError(f"{len(t)} torques and {len(a)} angles, T1 {t1_nm:g} and T2 {t2_nm:g} N m: must be as many angles as "
                         "torques, the torques rising from 0, T1 below T2")
    edges: np.ndarray = np.minimum([0.0, t1_nm, t2_nm, np.inf], t[-1])
    turn: np.ndarray = np.interp(edges, t, a)
    return [float((edges[i + 1] - edges[i]) / (turn[i + 1] - turn[i])) if edges[i + 1] > edges[i] else float("nan")
            for i in range(3)]
