# SPDX-License-Identifier: GPL-3.0-or-later
"""Clearance of every pair of teeth from profile, deformed rim and place: `tooth_gaps`."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .._check import checked, flag, integer, kind, number
from .._check import path as a_path
from .._engine import InputError
from .._types import PathLike, Value
from ..files import csv_text, write_folder
from .gap import envelope, flank_gap
from .profile import DoubleArc, Involute
from .rim import Rim

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["ToothGaps", "tooth_gaps"]
FILES = ("gaps.json", "gaps.csv", "gaps.nml", "gaps.png")
MOST_SPACES = 1.5   # of the circular spline over the teeth
ROOT = 0.9, 1.15    # diameter at the root of the teeth over module times teeth: else they stand on another wall
STEP = 0.5        # of the places of a turn at which the closest pair is sought [tooth pitches]
BOTH = [(side, end) for side in (1, -1) for end in (0, 1)]   # flanks of a tooth, ends of the long axis
STEPS = 0.05      # of those whose envelope is the circular spline
COARSE = 60       # points of a flank in that search
SETTLED = 1e-11   # of the least clearance [m]
NEGLIGIBLE = 1e-8  # overlap of curves as polylines that is not told [m]


@dataclass(frozen=True)
class ToothGaps:
    """Clearances of the pairs of a scene without load.

    Attributes
    ----------
    profile : Involute or DoubleArc
    table : dict
        Columns of gaps.csv, a row for each pair in the order of teeth.csv: `pair`, `theta_rad`, `place_pitches`; `gap_m` and
        `angle_deg` (pressure angle at the nearest point) of the flank that a positive torque presses; `gap_back_m` and
        `angle_back_deg` of the other.
    tooth, space : ndarray (n, 2)
        Flank of the flexspline at rest and of the circular spline's space (s, r) [m].
    least_m : float
        Clearance of the closest pair of a turn [m].
    bottom_m : float
        Radial way from the tip of the tooth on the long axis to the bottom of its space [m]; NaN of an envelope.
    facts : dict
        Numbers of teeth, profile shifts, radii, as gaps.json has them.
    outlines : dict
        Curves (s, r) for a figure: 'space', and the tooth in it near the long axis, half way and outermost [m].
    notes : tuple of str
        What speaks against the pair of profiles.
    """

    profile: Involute | DoubleArc
    table: dict = field(repr=False)
    tooth: np.ndarray = field(repr=False)
    space: np.ndarray = field(repr=False)
    least_m: float
    bottom_m: float
    facts: dict = field(default_factory=dict, repr=False)
    outlines: dict = field(default_factory=dict, repr=False)
    notes: tuple = ()

    @property
    def pressure_angle_deg(self) -> float:
        """Mean over the pairs' flanks [deg]."""
        return float(np.mean([self.table["angle_deg"], self.table["angle_back_deg"]]))

    def keys(self) -> dict:
        """Keys of a scene for `run`; a pair that interferes has the clearance 0."""
        t, half = self.table, len(self.table["pair"]) // 2
        both = [np.maximum(t[name], 0.0) for name in ("gap_m", "gap_back_m")]
        alike = all(np.allclose(g[:half], g[half:], rtol=0, atol=1e-10) for g in both)
        gaps = [[float(f"{g:.4g}") for g in (gap[:half] if alike else gap)] for gap in both]
        keys = {"load.tooth_pairs": 2 * half, "load.pressure_angle_deg": round(self.pressure_angle_deg, 2),
                "load.tooth_gaps": gaps[0], "load.tooth_gaps_back": gaps[1]}
        if "spline_root_radius_m" in self.facts:
            keys["load.spline_root_diameter"] = float(f"{2 * self.facts['spline_root_radius_m']:.5g}")
        return keys

    def lines(self) -> str:
        """The same as lines for the group &load of a namelist."""
        return "".join(f"  {name.removeprefix('load.')} = {', '.join(map(str, np.ravel(value)))}\n"
                       for name, value in self.keys().items())

    def __str__(self):
        t, f = self.table, self.facts
        half = len(t["pair"]) // 2
        shape = f"shifts {f['x1']:.4g} and {f['x2']:.4g}" if "x1" in f else f"common tangent {f['tangent_deg']:.4g} deg"
        angle = self.pressure_angle_deg
        lines = [f"{type(self.profile).__name__}: teeth {f['teeth']} / {f['spline_teeth']}, module {1e3 * self.profile.module:.5g} "
                 f"mm, {shape}",
                 f"  closest pair of a turn {1e6 * self.least_m:.3g} um, mean pressure angle {angle:.1f} deg",
                 "  place/pitches   clearance/um: flank of a positive torque, other flank   pressure angle/deg"]
        for i in range(half):
            lines.append(f"  {t['place_pitches'][i]:13.4g} {1e6 * t['gap_m'][i]:14.3f} {1e6 * t['gap_back_m'][i]:14.3f} "
                         f"{t['angle_deg'][i]:24.1f} {t['angle_back_deg'][i]:6.1f}")
        return "\n".join(lines + [f"  {note}" for note in self.notes])

    def plot(self) -> Figure:
        """Teeth in mesh and clearance over the pair (a matplotlib figure)."""
        from ..figures.teeth import plot_gaps

        return plot_gaps(self)

    @checked(folder=a_path, force=flag)
    def write(self, folder: PathLike, force: bool = False) -> list[Path]:
        """Write gaps.csv, gaps.nml (lines for the scene), gaps.png and, last, gaps.json; returns their paths.

        Parameters
        ----------
        folder : path-like
        force : bool
            Replace files of these names.

        Raises
        ------
        FileError
            The folder holds such files, or what another command wrote, or cannot be written.
        """
        record = {"kind": "tooth gaps", "profile": type(self.profile).__name__, "parameters": vars(self.profile), **self.facts,
                  "least_m": self.least_m, "bottom_m": self.bottom_m, "mean_pressure_angle_deg": self.pressure_angle_deg,
                  "notes": self.notes}
        files = dict(zip(FILES[1:], (csv_text(self.table), self.lines(), self.plot())))
        return write_folder(folder, FILES[0], record, files, force)


@checked(profile=kind(Involute, DoubleArc), path=a_path, least_gap=number(least=0, most=1e-3, optional=True),
         spline_teeth=integer(least=8, optional=True), points=integer(least=20, most=2000))
def tooth_gaps(profile: Involute | DoubleArc, path: PathLike = "", *, least_gap: float | None = None,
               spline_teeth: int | None = None, points: int = 200, **keys: Value) -> ToothGaps:
    """Clearance of every pair of a scene along the flanks' normals, without load, from profile and deformed rim.

    The rim's neutral line lies on the wave generator and keeps its length, or the rim is that of a run. Teeth are rigid and stand
    along its normals. Pairs (`load.teeth`, `load.tooth_pairs`) and spaces stand symmetric about the long axis, as a scene's
    lists have them: the engine goes between their places where `load.tooth_phase` turns the pairs.

    Parameters
    ----------
    profile : Involute or DoubleArc
    path : path-like
        Namelist of the scene, '' takes the defaults; or the folder of a run of it, with a grid of the assembly at 0 N m: its rim is
        taken, the mean over the width of the circular spline.
    least_gap : float, optional
        Clearance of the closest pair of a turn [m], default 0: it sets x2 of an Involute where that is not given, and moves
        the envelope of a DoubleArc.
    spline_teeth : int, optional
        Teeth of the circular spline; default: two more than the flexspline's.
    points : int
        Of each flank.
    **keys
        Keys of the scene, as in `run`.

    Returns
    -------
    ToothGaps

    Raises
    ------
    InputError
        A value out of its range; least_gap together with x2; teeth that are pointed, or that keep no space.
    FileError
        The scene, or the table of its cam.

    Examples
    --------
    >>> gaps = tooth_gaps(Involute(module=0.1778e-3, addendum=0.8), "data/drive14.nml")      # doctest: +SKIP
    >>> print(gaps.lines())                                                                  # doctest: +SKIP
    """
    rim = Rim.read(path, **keys | {"load.tooth_gaps": 0, "load.tooth_gaps_back": 0})   # the scene's own say nothing here
    scene, teeth = rim.scene, rim.scene["load.teeth"]
    spaces = teeth + 2 if spline_teeth is None else spline_teeth
    if not teeth <= spaces <= MOST_SPACES * teeth:
        raise InputError(f"spline_teeth = {spaces}: must be load.teeth = {teeth} or more, up to half as many more")
    if not ROOT[0] < 2 * rim.root / (profile.module * teeth) < ROOT[1]:
        raise InputError(f"module = {profile.module:g} with load.teeth = {teeth}: must be {2 * rim.root / ROOT[1] / teeth:.4g} to "
                         f"{2 * rim.root / ROOT[0] / teeth:.4g}, for the teeth stand on a wall of {rim.root:.6g} m "
                         "(geometry.bore_radius + wall_thickness)")
    facts = {"teeth": teeth, "spline_teeth": spaces, "neutral_radius_m": rim.radius, "root_radius_m": rim.root}
    tooth = profile.flank(teeth, rim.root, points)
    lift = float(np.hypot(*rim.poses(np.zeros(1))[0][:, 0]) - rim.radius)
    turn = np.arange(-(teeth // 4), teeth // 4 + STEP / 2, STEP)
    bottom = float("nan")
    if isinstance(profile, Involute):
        x1, x2 = profile.shift(teeth, rim.root), profile.x2
        if x2 is None:
            x2 = _spline_shift(profile, rim, turn, spaces, x1, least_gap or 0.0)
        elif least_gap is not None:
            raise InputError(f"least_gap = {least_gap:g} together with x2 = {x2:g}: must be one of them")
        space = profile.spline_flank(spaces, x2, points)
        root = float(np.hypot(*space[-1]))
        bottom = root - float(np.hypot(*tooth[-1])) - lift
        facts |= {"x1": x1, "x2": x2, "spline_root_radius_m": root}
    else:
        space = _conjugate(rim, tooth, spaces, lift, points, least_gap or 0.0)
        facts |= {"tangent_deg": profile.tangent_deg}
    places = np.arange(half := scene["load.tooth_pairs"] // 2) - (half - 1) / 2
    table = _table(rim, tooth, space, places, spaces)
    least = min(_closest(rim, tooth, space, turn, spaces), float(table["gap_m"].min()), float(table["gap_back_m"].min()))
    return ToothGaps(profile, table, tooth, space, least, bottom, facts, _outlines(rim, tooth, space, places, spaces),
                     tuple(_doubts(table["gap_m"], table["gap_back_m"], least, bottom)))


def _table(rim, tooth, space, places, spaces):
    """Columns of the pairs at both ends of the long axis, each with both flanks."""
    parts = []
    for end in (0, 1):
        front, back = (np.array([flank_gap(flank, space) for flank in rim.flanks(tooth, places, spaces, side, end)]).T
                       for side in (1, -1))
        parts.append([2 * np.pi * places / rim.scene["load.teeth"] + end * np.pi, places, front[0], back[0], np.degrees(front[1]),
                      np.degrees(back[1])])
    columns = np.concatenate(parts, axis=1)
    names = ("theta_rad", "place_pitches", "gap_m", "gap_back_m", "angle_deg", "angle_back_deg")
    return {"pair": np.arange(1, len(columns[0]) + 1)} | dict(zip(names, columns))


def _outlines(rim, tooth, space, places, spaces):
    """Whole tooth in its space at three places, and the space."""
    def whole(right, left):
        return np.concatenate([left * [-1, 1], right[::-1]])
    chosen = places[np.unique([len(places) // 2, 3 * len(places) // 4, len(places) - 1])]
    right, left = (rim.flanks(tooth, chosen, spaces, side) for side in (1, -1))
    return {"space": whole(space, space)} | {f"{place:g} pitches": whole(r, b) for place, r, b in zip(chosen, right, left)}


def _closest(rim, tooth, space, places, spaces):
    """Least clearance of a turn, of the teeth that reach into a space [m]."""
    flanks = np.concatenate([rim.flanks(tooth, places, spaces, *which) for which in BOTH])
    reach = flanks[:, -1, 1] > space[0, 1]
    return min(flank_gap(flank, space)[0] for flank in (flanks[reach] if reach.any() else flanks))


def _spline_shift(profile, rim, turn, spaces, x1, least):
    """Profile shift of the circular spline with which the closest pair keeps a clearance: flanks part by module sin(angle). Where a
    tip begins to reach into a space, the clearance jumps: the least shift that keeps more."""
    tooth = profile.flank(rim.scene["load.teeth"], rim.root, COARSE)
    rate = profile.module * np.sin(np.radians(profile.pressure_angle_deg))
    x2, low, high = x1, -np.inf, np.inf
    for _ in range(60):
        miss = least - _closest(rim, tooth, profile.spline_flank(spaces, x2, COARSE), turn, spaces)
        if abs(miss) < SETTLED:
            return x2
        low, high = (x2, high) if miss > 0 else (low, x2)
        if (high - low) * rate < SETTLED:
            return high
        x2 += miss / rate
        if not low < x2 < high:
            x2 = (low + high) / 2
    raise InputError(f"no profile shift of the circular spline keeps a clearance of {least:g} m; valid: a lower addendum or "
                     "spline_addendum, or x2 given")


def _conjugate(rim, tooth, spaces, lift, points, least):
    """Envelope of a tooth's flanks as the flank of the space, moved outwards by the least clearance."""
    quarter = rim.scene["load.teeth"] // 4
    places = np.arange(-quarter, quarter + STEPS / 2, STEPS)
    swept = np.concatenate([rim.flanks(tooth, places, spaces, *which) for which in BOTH])
    low, high = np.hypot(*tooth[0]) + lift, np.hypot(*tooth[-1]) + lift
    radius = np.linspace(low + 0.15 * (high - low), high, points)     # the mouth clears the tooth's root
    half = envelope(swept, radius)
    known = np.isfinite(half)
    if known.sum() < points // 2 or not (half[known] < np.pi / spaces).all():
        raise InputError("addendum and radii of the arcs: the spaces of the circular spline are up to "
                         f"{2 * half[known].max():.4g} rad wide; must be below {2 * np.pi / spaces:.4g} (2 pi / spline_teeth)")
    space = np.column_stack([radius * np.sin(half), radius * np.cos(half)])[known]
    along = np.gradient(space, axis=0)
    return space + least * np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]


def _doubts(gap, back, least, bottom):
    """What speaks against a pair of profiles."""
    entered = int((np.minimum(gap, back) < -NEGLIGIBLE).sum())
    if entered:
        yield f"{entered} pairs interfere, by up to {-1e6 * min(gap.min(), back.min()):.3g} um: their clearance is written as 0"
    elif least < -NEGLIGIBLE:
        yield f"teeth that are not in mesh interfere, by up to {-1e6 * least:.3g} um: they would not assemble"
    if bottom < 0:
        yield f"the teeth's tips reach {-1e6 * bottom:.3g} um below the bottom of the spaces on the long axis"
