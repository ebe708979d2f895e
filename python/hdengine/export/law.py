# SPDX-License-Identifier: GPL-3.0-or-later
"""A drive's torque over the angle, as the joint of a simulation takes it."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._check import ROUNDING, RUN, checked
from .._engine import InputError, supported
from ..results import Result

__all__ = ["JointLaw", "joint_law"]
PAST = 0.1   # of the largest torque, that a branch reaches on either side of 0


@dataclass(frozen=True)
class JointLaw:
    """Torque of a drive over the turn of its output against its input.

    Attributes
    ----------
    torque_nm, angle_rad : ndarray (n,)
        Middle of the loop, odd about 0, both rising.
    falling_rad, rising_rad : ndarray (n,)
        The loop's branches at these torques; the middle where the run has no whole loop.
    readings : dict
        K1, K2, K3, hysteresis and lost motion by their names in summary.json, without those that the run does not have.
    title : str
        Of the run.
    """

    torque_nm: np.ndarray
    angle_rad: np.ndarray
    falling_rad: np.ndarray
    rising_rad: np.ndarray
    readings: dict
    title: str

    @property
    def friction_nm(self) -> float:
        """Torque that half of the loop's width at no torque takes: Coulomb friction beside the spring [N m]."""
        middle = int(np.argmin(abs(self.torque_nm)))
        width = self.falling_rad[middle] - self.rising_rad[middle]
        return float(abs(width) / 2 * self.stiffness_nm_per_rad[middle])

    @property
    def stiffness_nm_per_rad(self) -> np.ndarray:
        """Slope dT/dθ at each row."""
        return np.gradient(self.torque_nm, self.angle_rad)


def _angle_of(branch, at):
    """Angle at torques on a branch, which may fall; NaN where it does not reach."""
    torque, angle = branch
    order = np.argsort(torque, kind="stable")
    near = np.clip(at, torque[order[0]], torque[order[-1]])
    return np.where(abs(near - at) <= ROUNDING * abs(at).max(), np.interp(near, torque[order], angle[order]), np.nan)


def _first_rise(torque, angle, legs):
    """The largest rise from no torque, of equals the first, as a positive one from no angle."""
    top = abs(torque).max()
    a, b = max((leg for leg in legs if abs(torque[leg[0]]) <= ROUNDING * top), key=lambda leg: abs(torque[leg[1]]))
    return abs(torque[a:b + 1]), np.sign(torque[b]) * (angle[a:b + 1] - angle[a])


@checked(run=RUN)
def joint_law(run: Result) -> JointLaw:
    """Law of a run of a whole drive: the middle of the last falling and the last rising branch, or the largest rise mirrored.

    Parameters
    ----------
    run : Result

    Returns
    -------
    JointLaw

    Raises
    ------
    InputError
        The run has no loop, no torque, or an angle that does not rise with the torque.
    """
    if not supported(run.scene, "loop"):
        raise InputError(f"'{run.folder}' has no loop of torque over angle: load.support = '{run.scene['load.support']}'; "
                         "valid: a run with load.support = 'drive', as data/drive14.nml")
    loop = run.loop
    begin = max(0, int(np.count_nonzero(loop["phase"] == "assembly")) - 1)
    torque, angle = (loop[name][begin:] for name in ("torque_nm", "angle_rad"))
    top = abs(torque).max(initial=0.0)
    if not top > 0:
        raise InputError(f"'{run.folder}' has no torque: set load.torque and load.torque_steps")
    moved = np.r_[np.diff(torque) != 0, True]   # of equal torques the last
    torque, angle = torque[moved], angle[moved]
    turns = [0, *(np.flatnonzero(np.diff(np.sign(np.diff(torque))) != 0) + 1), len(torque) - 1]
    legs = [*zip(turns, turns[1:])]
    through = {}  # the last branch through 0 of either sense, ends well away from it
    for a, b in legs:
        if min(torque[a], torque[b]) < -PAST * top and max(torque[a], torque[b]) > PAST * top:
            through[np.sign(torque[b] - torque[a])] = (torque[a:b + 1], angle[a:b + 1])
    positive = np.unique(np.round(abs(torque[abs(torque) > ROUNDING * top]) / top, 9)) * top
    grid = np.r_[-positive[::-1], 0.0, positive]
    if len(through) == 2:
        falling, rising = (_angle_of(through[sense], grid) for sense in (-1.0, 1.0))
    else:
        falling = rising = np.sign(grid) * _angle_of(_first_rise(torque, angle, legs), abs(grid))
    centre = (falling + rising + (falling + rising)[::-1]) / 4   # a joint is centred: what the loop is off 0 by goes
    two_sided = np.flatnonzero(np.isfinite(centre))
    centre = np.interp(abs(grid), grid[two_sided], centre[two_sided])
    falling, rising = falling - centre, rising - centre
    both = np.isfinite(falling + rising)
    falling, rising = np.where(both, falling, -rising[::-1]), np.where(both, rising, -falling[::-1])
    reached = both | both[::-1]
    grid, falling, rising = grid[reached], falling[reached], rising[reached]
    middle = (falling + rising) / 2
    if np.any(np.diff(middle) <= 0):
        at = grid[1:][np.diff(middle) <= 0][0]
        raise InputError(f"'{run.folder}': the angle does not rise with the torque at {at:.4g} N m, so it is no joint's law; raise "
                         "load.torque_steps or look at loop.png")
    names = [*(f"k{i}_nm_per_rad" for i in (1, 2, 3)), "hysteresis_rad", "lost_motion_rad"]
    results = run.summary["results"]
    return JointLaw(grid, middle, falling, rising,
                    {n: results[n] for n in names if results.get(n) is not None}, run.summary["title"] or run.folder.name)
