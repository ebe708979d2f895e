# SPDX-License-Identifier: GPL-3.0-or-later
"""Torque-angle records of a test bench: stiffness by a fit that is differentiated, hysteresis, lost motion, K1 to K3."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ._check import array, checked, fields, flag, integer, kind, mapping, number, word
from ._check import path as a_path
from ._engine import InputError
from ._types import PathLike
from .catalogue import UNITS, Unit, rated_torque, stages
from .files import check_folder, csv_text, write_folder
from .smoothing import Spline
from .table_file import numbers, text_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Curve", "Record"]
ARCSEC = np.pi / 180 / 3600
FEWEST = 20      # readings of a record
MOST = 1e9       # N m, rad: beyond, no bench reads
SIDE = 12        # of a branch before and behind zero torque: with fewer the error of the splines is not in the band
GAP = 0.05       # of a branch's range of torque, that its readings next to zero may lie apart
ROBUST = 1.4     # parameters that the score counts for one: by plain cross-validation few readings are interpolated
PENALTIES = 10.0**np.arange(4.5, -6.5, -0.5)   # that are tried
BENDS = 0.1      # of the penalty with the least score, that is used: that one smears the bend at zero by more than the scatter
DOUBT = 10       # by which -2 log of the likelihood must fall for a passage elsewhere: that of 40 by chance is 7
MOST_PLACES = 40  # at which the torque may pass zero that are tried
PEAK = 2e-2      # momentary torque of catalogues over the cube of the size [N m]
OVERLOAD = 5     # times that: beyond, the unit or the size is another
DRIFT = 0.1      # of the hysteresis, by which a loop that closes may miss its beginning
CLOSED = 0.02    # of the range of torque, by which ends of branches may differ that meet
TURN = 0.1       # of the range of torque: a smaller reversal is noise, and both ends of a branch are so far from zero


@dataclass
class Curve:
    """Angle and stiffness over torque with a band that holds the given share of the draws.

    Attributes are arrays over `torque_nm`: angle_rad, stiffness_nm_per_rad, low_nm_per_rad, high_nm_per_rad.
    """

    torque_nm: np.ndarray
    angle_rad: np.ndarray
    stiffness_nm_per_rad: np.ndarray
    low_nm_per_rad: np.ndarray
    high_nm_per_rad: np.ndarray

    def __post_init__(self) -> None:
        fields(self, **dict.fromkeys(vars(self), array((None,), finite=False)))

    def __str__(self) -> str:
        lines = ["torque / N m   K / (N m/rad)   band"]
        for t in np.linspace(self.torque_nm[0], self.torque_nm[-1], 5):
            lines.append("{:12.4g}   {:13.0f}   {:.0f} to {:.0f}".format(t, *self.at(t)))
        return "\n".join(lines)

    @checked(torque_nm=number())
    def at(self, torque_nm: float) -> tuple[float, ...]:
        """Stiffness and its band at a torque, NaN beyond those of the curve [N m/rad]."""
        return tuple(float(np.interp(torque_nm, self.torque_nm, y, np.nan, np.nan))
                     for y in (self.stiffness_nm_per_rad, self.low_nm_per_rad, self.high_nm_per_rad))


def _band(value, sample, share):
    """Ends that hold the share of the draws and, as a spline errs twice to one side in them, their mirror images."""
    low, high = np.percentile(sample, [50 * (1 - share), 50 * (1 + share)], axis=0)
    return np.minimum(low, 2 * value - high), np.maximum(high, 2 * value - low)


class _Branch:
    """Angle over the torque of a branch: one spline until the torque passes zero and one behind, for play lies between them.

    Parameters
    ----------
    torque_nm, angle_rad : ndarray (n,)
        In the order of time.
    sense : int
        1: the torque rises, -1: it falls.
    pieces : int
        Intervals of either spline.
    error_nm : float
        The torque passes zero where it reads so much at most: next to zero, or where the robust cross-validation score says so.
    like : _Branch, optional
        Fit of nearly the same readings, whose place and penalty are taken.
    pulls : ndarray (2, pieces), optional
        Of the splines.

    Attributes
    ----------
    place : int
        Readings before the passage.
    penalty : float
    parts : list of Spline
    fitted : ndarray (n,)
        At the readings [rad].
    residual : float
        Standard deviation of the readings about it [rad].
    """

    def __init__(self, torque_nm, angle_rad, sense, pieces, error_nm=0.0, like=None, pulls=(None, None)):
        self.sense, self.low, self.high, n = sense, torque_nm.min(), torque_nm.max(), len(torque_nm)

        def fit(place, penalty):
            cut = slice(place), slice(place, n)
            self.place, self.penalty = place, penalty
            self.parts = [Spline(torque_nm[s], angle_rad[s], pieces, penalty, pull) for s, pull in zip(cut, pulls)]
            self.fitted = np.concatenate([part(torque_nm[s]) for part, s in zip(self.parts, cut)])
            freedom, square = sum(part.freedom for part in self.parts), np.sum((angle_rad - self.fitted)**2)
            self.residual, free = np.sqrt(square / max(n - freedom, 1)), n - ROBUST * freedom
            return square / free**2 if free > 0 else np.inf

        if like:
            fit(like.place, like.penalty)
            return
        ends = np.sort([torque_nm[:-1], torque_nm[1:]], axis=0)
        before, behind = np.sum(torque_nm < 0), np.sum(torque_nm > 0)
        gap = torque_nm[torque_nm >= 0].min() - torque_nm[torque_nm <= 0].max()
        places = [k for k in 1 + np.flatnonzero((ends[0] <= error_nm) & (ends[1] >= -error_nm)) if SIDE <= k <= n - SIDE]
        if not places or min(before, behind) < SIDE or gap > GAP * (self.high - self.low):
            raise InputError(f"the {'rising' if sense > 0 else 'falling'} branch has {before} readings below and {behind} above "
                             f"zero torque, {gap:.3g} N m between them; needed: {SIDE} or more, and at most "
                             f"{GAP * (self.high - self.low):.3g} N m ({GAP:.0%} of its range)")
        nearest = min(places, key=lambda k: abs(torque_nm[k - 1] + torque_nm[k]))
        best = min((fit(k, penalty) * (1 if k == nearest else np.exp(DOUBT / n)), k, penalty)
                   for k in {nearest, *places[::1 + len(places) // MOST_PLACES]} for penalty in PENALTIES)
        for factor in np.geomspace(BENDS, 1, 5):
            if np.isfinite(fit(best[1], factor * best[2])):
                break

    def __call__(self, torque_nm, derivative=0):
        """Angle or its derivative by the torque; at zero what is left of before [rad]."""
        return np.where(self.sense * np.asarray(torque_nm) <= 0, *(part(torque_nm, derivative) for part in self.parts))


class Record:
    """Readings of a test bench in the order of time: output torque and angle, the input held.

    Parameters
    ----------
    torque_nm, angle_rad : array_like (n,)
        A loop: up to the highest torque, down to the lowest, up again.
    torque_error_nm, angle_error_rad : float
        Largest error of the instruments. Default: those of Hu et al. (2023), 0.05 N m and 2 arcsec. The band takes each
        error as a straight line over the range whose ends lie anywhere within these limits, and adds the scatter of the readings.
    pieces : int
        Intervals of the smoothing splines angle(torque) of each branch, on either side of zero torque.

    Raises
    ------
    InputError
        No rising and falling branch that cross zero torque, or too few readings on a side of it or next to it.
    """

    @checked(torque_nm=array((None,), least=-MOST, most=MOST), angle_rad=array((None,), least=-MOST, most=MOST),
             torque_error_nm=number(least=0, most=MOST), angle_error_rad=number(least=0, most=MOST), pieces=integer(1, 1000))
    def __init__(self, torque_nm: ArrayLike, angle_rad: ArrayLike, torque_error_nm: float = 0.05,
                 angle_error_rad: float = 2 * ARCSEC, pieces: int = 24) -> None:
        self.torque_nm, self.angle_rad = np.asarray(torque_nm, float), np.asarray(angle_rad, float)
        if self.torque_nm.shape != self.angle_rad.shape or len(self.torque_nm) < FEWEST:
            raise InputError(f"a record needs as many torques as angles, {FEWEST} or more; "
                             f"it has {self.torque_nm.size} torques and {self.angle_rad.size} angles")
        self.torque_error_nm, self.angle_error_rad, self.pieces = torque_error_nm, angle_error_rad, pieces
        self._drawn: dict[tuple, list] = {}
        self.branches = self._split()
        self.up, self.down = (self._branch(sense) for sense in (1, -1))
        for sense, part in ((1, self.up), (-1, self.down)):
            if not sense * (self.angle_rad[part][-1] - self.angle_rad[part][0]) > 0:
                raise InputError(f"the angle does not {'rise' if sense > 0 else 'fall'} with the torque: turn the sign of one, "
                                 "or look whether the columns are what their names say")
        self._fits = {sense: _Branch(self.torque_nm[part], self.angle_rad[part], sense, pieces, torque_error_nm)
                      for sense, part in ((1, self.up), (-1, self.down))}

    @classmethod
    @checked(path=a_path)
    def read(cls, path: PathLike, **errors: Any) -> Record:
        """Record of a CSV table with columns torque_nm and angle_rad or angle_arcsec."""
        names, rows = text_rows(path, comment="#")
        angles = [name for name in ("angle_rad", "angle_arcsec") if name in names]
        if "torque_nm" not in names or not angles:
            raise InputError(f"'{path}' begins with '{','.join(names)[:80]}'; needed: a line of names, torque_nm and angle_rad or "
                             "angle_arcsec, with commas between them")
        if not rows:
            raise InputError(f"'{path}' holds no reading below its line of names")
        if len(angles) == 2:
            raise InputError(f"'{path}' has angle_rad and angle_arcsec: leave out one")
        torque, angle = (numbers(path, names, rows, name) for name in ("torque_nm", angles[0]))
        try:
            return cls(torque, angle * (ARCSEC if angles[0] == "angle_arcsec" else 1), **errors)
        except InputError as error:
            raise InputError(f"'{path}': {error}") from None

    def _split(self):
        """Slices between turning points of the torque, both ends in; a reversal counts once it exceeds a tenth of the range."""
        t, limit = self.torque_nm, TURN * np.ptp(self.torque_nm)
        turns, sense, extreme = [0], 0, 0
        for i, value in enumerate(t):
            if sense == 0:
                if abs(value - t[0]) > limit:
                    sense, extreme = np.sign(value - t[0]), i
            elif sense * (value - t[extreme]) >= 0:
                extreme = i
            elif sense * (t[extreme] - value) > limit:
                turns.append(extreme)
                sense, extreme = -sense, i
        turns.append(len(t))
        return [slice(a, min(b + 1, len(t))) for a, b in zip(turns, turns[1:])]

    def _branch(self, sense):
        """Last branch of a sense that crosses zero with both ends well away from it."""
        for part in reversed(self.branches):
            t = self.torque_nm[part]
            if sense * (t[-1] - t[0]) > 0 and t.min() < -TURN * np.ptp(t) < TURN * np.ptp(t) < t.max():
                return part
        raise InputError(f"the record has no {'rising' if sense > 0 else 'falling'} branch through zero torque: give a whole loop")

    def _angle(self, branch, fits, torque, derivative=0):
        if branch == "middle":
            return 0.5 * (fits[1](torque, derivative) + fits[-1](torque, derivative))
        return fits[{"up": 1, "down": -1}[branch]](torque, derivative)

    def _draws(self, count, seed):
        """Fits of disturbed readings: straight-line errors of both instruments and the scatter of the angle."""
        if (count, seed) in self._drawn:
            return self._drawn[count, seed]
        drawn = self._drawn[count, seed] = []
        generator = np.random.default_rng(seed)
        x = (self.torque_nm - self.torque_nm.min()) / np.ptp(self.torque_nm)
        for _ in range(count):
            torque, angle = (reading + error * (ends[0] * (1 - x) + ends[1] * x) for reading, error, ends in zip(
                (self.torque_nm, self.angle_rad), (self.torque_error_nm, self.angle_error_rad), generator.uniform(-1, 1, (2, 2))))
            fits = {}
            for sense, part in ((1, self.up), (-1, self.down)):
                fit = self._fits[sense]
                clean = fit.fitted - self.angle_rad[part] + angle[part]
                noise = generator.normal(0, fit.residual, len(clean))
                fits[sense] = _Branch(torque[part], clean + noise, sense, self.pieces, like=fit,
                                      pulls=generator.normal(0, fit.residual, (2, self.pieces)))
            drawn.append(fits)
        return drawn

    @checked(branch=word("middle", "up", "down"), points=integer(2, 10**6), share=number(above=0, below=1), draws=integer(2, 10**5),
             seed=integer(0, 2**63 - 1))
    def curve(self, branch: str = "middle", points: int = 201, share: float = 0.95, draws: int = 200, seed: int = 1) -> Curve:
        """Stiffness dT/dθ over torque.

        Parameters
        ----------
        branch : str
            'middle' (mean of rising and falling branch at equal torque), 'up' or 'down'.
        points : int
        share : float
            Share of the draws in the band.
        draws, seed : int
            Disturbed copies of the record, and the seed of their errors.

        Returns
        -------
        Curve
        """
        torque = np.linspace(max(f.low for f in self._fits.values()), min(f.high for f in self._fits.values()), points)
        k = 1 / self._angle(branch, self._fits, torque, 1)
        sample = np.array([1 / self._angle(branch, fits, torque, 1) for fits in self._draws(draws, seed)])
        return Curve(torque, self._angle(branch, self._fits, torque), k, *_band(k, sample, share))

    @checked(unit=kind(Unit, optional=True), rated_torque_nm=number(above=0, optional=True), share=number(above=0, below=1),
             draws=integer(2, 10**5), seed=integer(0, 2**63 - 1))
    def numbers(self, unit: Unit | None = None, rated_torque_nm: float | None = None, share: float = 0.95, draws: int = 200,
                seed: int = 1) -> dict:
        """Figures of a catalogue with their bands.

        Parameters
        ----------
        unit : catalogue.Unit, optional
            Its T1 and T2 are used for K1, K2, K3 (chords of the rise from zero torque, as of a run's loop); default: size 14.
        rated_torque_nm : float, optional
            Lost motion is the turn of the middle curve between -4 % and +4 % of it; default: the size's at ratio 100.

        Returns
        -------
        dict
            hysteresis_rad (between the branches at zero torque), lost_motion_rad, k1, k2, k3 [N m/rad], closing_rad (by how much
            the later branch ends beyond the beginning of the other, where both have one torque: drift, half of which the
            hysteresis holds); each (value, low, high), NaN beyond the torques.

        Raises
        ------
        InputError
            The torques are no such size's.
        """
        unit = unit or UNITS[14]
        top, peak = abs(self.torque_nm).max(), PEAK * unit.size**3
        if top > OVERLOAD * peak:
            raise InputError(f"the record goes to {top:.4g} N m, drives of size {unit.size} to {peak:.2g} N m for a moment: "
                             f"give its size; or did you mean {top / 1e3:.4g} N m ({top:.4g} mN m)?")
        torque = np.linspace(0, min(f.high for f in self._fits.values()), 400)
        four = 0.04 * (rated_torque_nm or rated_torque(unit.size))
        later = 1 if self.up.start > self.down.start else -1
        ends = [f.high if later > 0 else f.low for f in self._fits.values()]
        turned = np.array([later * min(later * end for end in ends)])
        meet = 1 if np.ptp(ends) < CLOSED * np.ptp(self.torque_nm) else np.nan

        def evaluate(fits):
            zero = np.zeros(1)
            turn = fits[1](torque)
            lost = self._angle("middle", fits, np.array([-four, four]))
            return [float(abs(fits[1](zero) - fits[-1](zero))[0]), lost[1] - lost[0],
                    *stages(torque, turn - turn[0], unit.t1_nm, unit.t2_nm), meet * (fits[later](turned) - fits[-later](turned))[0]]
        sample = np.array([evaluate(fits) for fits in self._draws(draws, seed)])
        values = np.array(evaluate(self._fits))
        names = ("hysteresis_rad", "lost_motion_rad", "k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad", "closing_rad")
        return {n: tuple(map(float, row)) for n, *row in zip(names, values, *_band(values, sample, share))}

    FILES = ("record.json", "curve.csv", "record.png", "scene.nml")  #: that `write` leaves in a folder

    @checked(folder=a_path, numbers=mapping, source=a_path, size=integer(), force=flag)
    def write(self, folder: PathLike, numbers: dict, source: PathLike, size: int, force: bool = False) -> list:
        """Write what the record gives into a folder.

        Parameters
        ----------
        folder : str or Path
            curve.csv (angle and stiffness over torque), record.png, scene.nml (the lines of a scene under the record's highest
            torque), and last of all record.json (figures with their bands), without which the others are not whole.
        numbers : dict
            Of `numbers`.
        source : str or Path
            File of the readings.
        size : int
            Size whose T1 and T2 were used.
        force : bool
            Replace these files where the folder holds them.

        Returns
        -------
        list of Path

        Raises
        ------
        FileError
            The folder holds these files, or a run or a study, or cannot be written.
        """
        check_folder(folder, self.FILES, force)
        found = {"kind": "record", "source": str(source), "size": size, "readings": len(self.torque_nm),
                 "torque_min_nm": float(self.torque_nm.min()), "torque_max_nm": float(self.torque_nm.max()),
                 "torque_error_nm": self.torque_error_nm, "angle_error_rad": self.angle_error_rad,
                 "scatter_rad": float(self._fits[1].residual), "band_share": 0.95, "value_low_high": numbers}
        curve = self.curve()
        columns = ("torque_nm", "angle_rad", "stiffness_nm_per_rad", "low_nm_per_rad", "high_nm_per_rad")
        scene = (f"! for a scene under the highest torque of {Path(source).name}\n&load\n  torque = {self.torque_nm.max():.6g}\n"
                 "  torque_steps = 5\n/\n")
        return write_folder(folder, "record.json", found, {
            "curve.csv": csv_text({c: getattr(curve, c) for c in columns}), "record.png": self.plot(), "scene.nml": scene}, force)

    def __repr__(self) -> str:
        return (f"Record: {len(self.torque_nm)} readings, {len(self.branches)} branches, {self.torque_nm.min():.3g} to "
                f"{self.torque_nm.max():.3g} N m, scatter of the angle {self._fits[1].residual / ARCSEC:.2f} arcsec")

    def plot(self) -> Figure:
        """Loop and stiffness with its band (a matplotlib figure)."""
        from .figures.record import plot_record

        return plot_record(self)
