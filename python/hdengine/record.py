# SPDX-License-Identifier: GPL-3.0-or-later
"""Torque-angle records of a test bench: stiffness by a fit that is differentiated, hysteresis, lost motion, K1 to K3."""
from dataclasses import dataclass

import numpy as np

from ._engine import InputError
from .catalogue import stages
from .results import read_csv
from .spline import Spline

ARCSEC = np.pi / 180 / 3600


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

    def __str__(self):
        lines = ["torque / N m   K / (N m/rad)   band"]
        for t in np.linspace(self.torque_nm[0], self.torque_nm[-1], 5):
            lines.append("{:12.4g}   {:13.0f}   {:.0f} to {:.0f}".format(t, *self.at(t)))
        return "\n".join(lines)

    def at(self, torque_nm):
        """Stiffness and its band at a torque [N m/rad]."""
        return tuple(float(np.interp(torque_nm, self.torque_nm, y))
                     for y in (self.stiffness_nm_per_rad, self.low_nm_per_rad, self.high_nm_per_rad))


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
        Intervals of the smoothing spline angle(torque) of each branch; its curvature may jump at zero torque.

    Raises
    ------
    InputError
        No rising and falling branch that cross zero torque.
    """

    def __init__(self, torque_nm, angle_rad, torque_error_nm=0.05, angle_error_rad=2 * ARCSEC, pieces=12):
        self.torque_nm, self.angle_rad = np.asarray(torque_nm, float), np.asarray(angle_rad, float)
        if self.torque_nm.shape != self.angle_rad.shape or self.torque_nm.ndim != 1 or len(self.torque_nm) < 20 \
                or not np.all(np.isfinite(self.torque_nm + self.angle_rad)):
            raise InputError("a record needs as many torques as angles, at least 20, all finite")
        self.torque_error_nm, self.angle_error_rad, self.pieces = torque_error_nm, angle_error_rad, pieces
        self._drawn = {}
        self.branches = self._split()
        self.up, self.down = (self._branch(sense) for sense in (1, -1))
        self._fits = {sense: Spline(self.torque_nm[part], self.angle_rad[part], pieces, 0.0)
                      for sense, part in ((1, self.up), (-1, self.down))}

    @classmethod
    def read(cls, path, **errors):
        """Record of a CSV table with columns torque_nm and angle_rad or angle_arcsec."""
        table = read_csv(path)
        names = table.dtype.names
        if "torque_nm" not in names or not {"angle_rad", "angle_arcsec"} & set(names):
            raise InputError(f"'{path}' has the columns {', '.join(names)}; needed: torque_nm and angle_rad or angle_arcsec")
        angle = table["angle_rad"] if "angle_rad" in names else table["angle_arcsec"] * ARCSEC
        return cls(table["torque_nm"], angle, **errors)

    def _split(self):
        """Slices between turning points of the torque; a reversal counts once it exceeds a tenth of the range."""
        t, limit = self.torque_nm, 0.1 * np.ptp(self.torque_nm)
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
        return [slice(a, b) for a, b in zip(turns, turns[1:])]

    def _branch(self, sense):
        """Last branch of a sense that crosses zero with both ends well away from it."""
        for part in reversed(self.branches):
            t = self.torque_nm[part]
            if sense * (t[-1] - t[0]) > 0 and t.min() < -0.1 * np.ptp(t) and t.max() > 0.1 * np.ptp(t):
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
                clean = fit(np.clip(self.torque_nm[part], fit.low, fit.high)) - self.angle_rad[part] + angle[part]
                noise = generator.normal(0, fit.residual, len(clean))
                fits[sense] = Spline(torque[part], clean + noise, self.pieces, 0.0, fit.penalty)
            drawn.append(fits)
        return drawn

    def curve(self, branch="middle", points=201, share=0.95, draws=200, seed=1):
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
        tail = 50 * (1 - share)
        sample = np.array([1 / self._angle(branch, fits, torque, 1) for fits in self._draws(draws, seed)])
        low, high = np.percentile(sample, [tail, 100 - tail], axis=0)
        return Curve(torque, self._angle(branch, self._fits, torque), k, low, high)

    def numbers(self, unit=None, rated_torque_nm=None, share=0.95, draws=200, seed=1):
        """Figures of a catalogue with their bands.

        Parameters
        ----------
        unit : catalogue.Unit, optional
            Its T1 and T2 are used for K1, K2, K3 (chords of the middle curve from zero torque); default: size 14.
        rated_torque_nm : float, optional
            Lost motion is the turn of the middle curve between -4 % and +4 % of it; default: the highest torque.

        Returns
        -------
        dict
            hysteresis_rad (between the branches at zero torque), lost_motion_rad, k1, k2, k3 [N m/rad]; each (value, low, high).
        """
        from .catalogue import UNITS
        unit = unit or UNITS[14]
        torque = np.linspace(0, min(f.high for f in self._fits.values()), 400)
        four = 0.04 * (rated_torque_nm or self.torque_nm.max())

        def evaluate(fits):
            zero = np.zeros(1)
            turn = self._angle("middle", fits, torque)
            ends = self._angle("middle", fits, np.array([-four, four]))
            return [float(abs(fits[1](zero) - fits[-1](zero))[0]), ends[1] - ends[0],
                    *stages(torque, turn - turn[0], unit.t1_nm, unit.t2_nm)]
        sample = np.array([evaluate(fits) for fits in self._draws(draws, seed)])
        tail = 50 * (1 - share)
        low, high = np.percentile(sample, [tail, 100 - tail], axis=0)
        names = ("hysteresis_rad", "lost_motion_rad", "k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad")
        return {n: (float(v), float(a), float(b)) for n, v, a, b in zip(names, evaluate(self._fits), low, high)}

    def __repr__(self):
        return (f"Record: {len(self.torque_nm)} readings, {len(self.branches)} branches, {self.torque_nm.min():.3g} to "
                f"{self.torque_nm.max():.3g} N m, scatter of the angle {self._fits[1].residual / ARCSEC:.2f} arcsec")

    def plot(self):
        """Loop and stiffness with its band (a matplotlib figure)."""
        from .plot import plt

        figure, axes = plt.subplots(1, 2, figsize=(11, 4.4))
        axes[0].plot(self.angle_rad / ARCSEC / 60, self.torque_nm, ".", ms=2, color="0.6", label="readings")
        curve = self.curve()
        axes[0].plot(curve.angle_rad / ARCSEC / 60, curve.torque_nm, color="C0", label="middle curve")
        axes[0].set_xlabel("angle / arcmin")
        axes[0].set_ylabel("torque / N m")
        axes[0].legend()
        for branch, colour in (("middle", "C0"), ("up", "C1"), ("down", "C2")):
            c = self.curve(branch)
            axes[1].plot(c.torque_nm, c.stiffness_nm_per_rad / 1e3, color=colour, label={
                "middle": "middle", "up": "rising torque", "down": "falling torque"}[branch])
            axes[1].fill_between(c.torque_nm, c.low_nm_per_rad / 1e3, c.high_nm_per_rad / 1e3, color=colour, alpha=0.2, lw=0)
        axes[1].set_xlabel("torque / N m")
        axes[1].set_ylabel("stiffness dT/dθ / (kN m/rad)")
        axes[1].set_ylim(0, 1.3e-3 * np.percentile(self.curve().stiffness_nm_per_rad, 99))
        axes[1].legend(title="95 % band")
        return figure
