# SPDX-License-Identifier: GPL-3.0-or-later
"""Torsional stiffness as catalogues state it: three chords of the torque-angle curve."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ._check import ROUNDING, array, checked, number
from ._engine import InputError

__all__ = ["Unit", "stages"]


@dataclass(frozen=True)
class Unit:
    """Stated stiffness of one size at ratios above 50: K1 up to T1, K2 from T1 to T2, K3 above."""

    size: int
    t1_nm: float
    t2_nm: float
    k1_nm_per_rad: float
    k2_nm_per_rad: float
    k3_nm_per_rad: float

    @checked(torque_nm=array())
    def angle(self, torque_nm: ArrayLike) -> np.ndarray:
        """Angle of the three chords at torques [rad]."""
        t = np.abs(np.asarray(torque_nm, float))
        parts = (np.clip(t, 0, self.t1_nm) / self.k1_nm_per_rad, np.clip(t - self.t1_nm, 0, self.t2_nm - self.t1_nm)
                 / self.k2_nm_per_rad, np.clip(t - self.t2_nm, 0, None) / self.k3_nm_per_rad)
        return np.sign(torque_nm) * sum(parts)


# Harmonic Drive CHA manual, p. 50; the CHA-14A-E manual, p. 54, and Schaeffler TPI 275 agree where they overlap.
UNITS = {u.size: u for u in (Unit(14, 2, 6.9, 4.7e3, 6.1e3, 7.1e3), Unit(17, 3.9, 12, 10e3, 14e3, 16e3),
                             Unit(20, 7, 25, 16e3, 25e3, 29e3), Unit(25, 14, 48, 31e3, 50e3, 57e3),
                             Unit(32, 29, 108, 67e3, 110e3, 120e3), Unit(40, 54, 196, 130e3, 200e3, 230e3))}


def unit_of(scene: dict) -> Unit | None:
    """The size whose T1 and T2 a scene ('group.key' to value) has, if there is one."""
    return next((u for u in UNITS.values() if abs(u.t1_nm - scene["loop.torque_1"]) < ROUNDING
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
    if t.shape != a.shape or np.any(np.diff(t) < 0) or not t2_nm > t1_nm:
        raise InputError(f"{len(t)} torques and {len(a)} angles, T1 {t1_nm:g} and T2 {t2_nm:g} N m: must be as many angles as "
                         "torques, the torques rising, T1 below T2")
    edges: np.ndarray = np.minimum([0.0, t1_nm, t2_nm, np.inf], t[-1])
    turn: np.ndarray = np.interp(edges, t, a)
    return [float((edges[i + 1] - edges[i]) / (turn[i + 1] - turn[i])) if edges[i + 1] > edges[i] else float("nan")
            for i in range(3)]
