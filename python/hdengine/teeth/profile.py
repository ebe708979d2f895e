# SPDX-License-Identifier: GPL-3.0-or-later
"""Flanks of teeth as curves: the involute of flexspline and circular spline, and a flexspline's double circular arc.

A flank is the right-hand side of its tooth, or of the space of the circular spline that the tooth enters: points (s, r) from the
root or the tip outwards, s from the centre line round the axis, r along it from the drive's axis.
"""
from __future__ import annotations

from dataclasses import dataclass
from math import asin, cos, hypot, pi, radians, tan

import numpy as np
from numpy.typing import ArrayLike

from .._check import checked, fields, integer, number
from .._engine import InputError

__all__ = ["DoubleArc", "Involute"]
_TEETH, _POINTS = integer(1, 10**6), integer(2, 10**6)


def involute_angle(radius: ArrayLike, base: float) -> np.ndarray:
    """Polar angle of an involute from its start on the base circle, tan a - a with cos a = base / radius [rad].

    Parameters
    ----------
    radius : float or ndarray
        Not below `base` [m].
    base : float
        Radius of the base circle [m].

    Returns
    -------
    float or ndarray
    """
    a = np.arccos(np.minimum(1.0, base / np.asarray(radius)))
    return np.tan(a) - a


@dataclass(frozen=True)
class Involute:
    """Involute teeth of flexspline and circular spline, cut by one rack.

    Parameters
    ----------
    module : float
        [m].
    pressure_angle_deg : float
        Of the rack.
    x1, x2 : float, optional
        Profile shifts of flexspline and circular spline over the module. x1 is by default the one whose root circle is the wall's
        outside; x2 the one with which the closest pair keeps the least clearance that is asked for.
    addendum, spline_addendum : float
        Over the module, from the shifted reference circle.
    dedendum : float
        Of both, over the module.

    Raises
    ------
    InputError
        A value out of its range.
    """

    module: float
    pressure_angle_deg: float = 20.0
    x1: float | None = None
    x2: float | None = None
    addendum: float = 0.8
    spline_addendum: float = 0.8
    dedendum: float = 1.35

    def __post_init__(self) -> None:
        fields(self, module=number(above=0, most=0.01), pressure_angle_deg=number(above=5, most=40),
               x1=number(least=-5, most=20, optional=True), x2=number(least=-5, most=20, optional=True),
               addendum=number(above=0, most=2), spline_addendum=number(above=0, most=2), dedendum=number(above=0, most=3))

    @checked(teeth=_TEETH, root=number())
    def shift(self, teeth: int, root: float) -> float:
        """Profile shift of the flexspline.

        Parameters
        ----------
        teeth : int
            Of the flexspline.
        root : float
            Radius of the root circle [m] where x1 is not given.

        Returns
        -------
        float
        """
        return root / self.module - teeth / 2 + self.dedendum if self.x1 is None else self.x1

    @checked(teeth=_TEETH, root=number(), points=_POINTS)
    def flank(self, teeth: int, root: float, points: int) -> np.ndarray:
        """Flank of the flexspline's tooth at rest.

        Parameters
        ----------
        teeth : int
        root : float
            As for `shift` [m].
        points : int

        Returns
        -------
        ndarray (points, 2)
            (s, r) from the root to the tip [m].

        Raises
        ------
        InputError
            The tooth is pointed.
        """
        x = self.shift(teeth, root)
        curve = self._curve(teeth, x, teeth / 2 + x - self.dedendum, teeth / 2 + x + self.addendum, points)
        if len(curve) < points:
            if not len(curve):
                raise InputError(f"no flank of {teeth} teeth with shift {x:.4g} has a width; valid: root = about module teeth/2")
            most = curve[-1, 1] / self.module - teeth / 2 - x
            raise InputError(f"addendum = {self.addendum:g}: flanks of {teeth} teeth with shift {x:.4g} meet {most:.4g} modules "
                             "out; valid: less than that")
        return curve

    @checked(teeth=_TEETH, x2=number(), points=_POINTS)
    def spline_flank(self, teeth: int, x2: float, points: int) -> np.ndarray:
        """Flank of the circular spline's space.

        Parameters
        ----------
        teeth : int
            Of the circular spline.
        x2 : float
            Its profile shift.
        points : int

        Returns
        -------
        ndarray (points, 2)
            (s, r) from the tip of its teeth to their root, or to where the flanks of a space meet [m].
        """
        return self._curve(teeth, x2, teeth / 2 + x2 - self.spline_addendum, teeth / 2 + x2 + self.dedendum, points)

    def _curve(self, teeth, x, low, high, points):
        """Points from a lower to an upper radius over the module, as far as a tooth or a space of shift x has a width."""
        alpha = radians(self.pressure_angle_deg)
        base = self.module * teeth / 2 * cos(alpha)
        radius = np.linspace(max(base, self.module * low), self.module * high, points)
        half = (pi / 2 + 2 * x * tan(alpha)) / teeth + (tan(alpha) - alpha) - involute_angle(radius, base)
        return np.column_stack([radius * np.sin(half), radius * np.cos(half)])[half > 0]


@dataclass(frozen=True)
class DoubleArc:
    """Tooth of a flexspline of a convex arc at its tip, their common tangent, and a concave arc at its root.

    The circular spline's flank is the envelope of this one. Heights y count from the pitch circle outwards, x from the tooth's
    centre line; names as in Liu et al., Machines 2025, 13, 535: r1, c1, e1, r2, c2, e2, ha, hf.

    Parameters
    ----------
    module : float
        Unit of what follows [m].
    convex_radius, convex_x, convex_y : float
        Radius of the convex arc and its centre, over the module: beyond the centre line and below the pitch circle, where positive.
    concave_radius, concave_x, concave_y : float
        Radius of the concave arc and its centre, over the module: beyond the middle of the space and above the pitch circle.
    addendum, dedendum : float
        Over the module.
    pitch_radius : float, optional
        Of the pitch circle [m]; default: the one whose root circle is the wall's outside.

    Attributes
    ----------
    tangent_deg : float
        Inclination of the common tangent to the centre line.

    Raises
    ------
    InputError
        A value out of its range; arcs without a common tangent between them.
    """

    module: float
    convex_radius: float = 1.37
    convex_x: float = 0.664
    convex_y: float = 0.31
    concave_radius: float = 1.57
    concave_x: float = 0.66
    concave_y: float = 0.268
    addendum: float = 0.55
    dedendum: float = 0.75
    pitch_radius: float | None = None

    def __post_init__(self) -> None:
        size = number(above=0, most=20)
        way = number(least=-20, most=20)
        fields(self, module=number(above=0, most=0.01), convex_radius=size, concave_radius=size, convex_x=way, convex_y=way,
               concave_x=way, concave_y=way, addendum=number(above=0, most=2), dedendum=number(above=0, most=3),
               pitch_radius=number(above=0, optional=True))
        self._angles()

    @property
    def tangent_deg(self) -> float:
        """Inclination of the common tangent to the centre line [deg]."""
        return float(np.degrees(self._angles()[1]))

    def _angles(self):
        """Angles of the convex arc at the tip, of the common tangent, and of the concave arc at the root [rad]."""
        up, down = self.addendum + self.convex_y, self.dedendum + self.concave_y
        if not abs(up) < self.convex_radius:
            raise InputError(f"addendum + convex_y = {up:g}: must be below convex_radius = {self.convex_radius:g}, for the arc "
                             "ends at the tip")
        if not abs(down) < self.concave_radius:
            raise InputError(f"dedendum + concave_y = {down:g}: must be below concave_radius = {self.concave_radius:g}, for the "
                             "arc ends at the root")
        dx, dy = pi / 2 + self.concave_x + self.convex_x, self.concave_y + self.convex_y
        far = hypot(dx, dy)
        radii = self.convex_radius + self.concave_radius
        if not radii < far:
            raise InputError(f"convex_radius + concave_radius = {radii:g}: must be below {far:.6g}, the distance of the arcs' "
                             "centres, for they have a common tangent between them")
        tangent = np.arccos(radii / far) + np.arctan2(dy, dx)
        tip, root = asin(up / self.convex_radius), asin(down / self.concave_radius)
        if not (tangent < tip and tangent < root):
            raise InputError(f"the common tangent is inclined by {np.degrees(tangent):.4g} deg: the arcs end at "
                             f"{np.degrees(tip):.4g} deg (tip) and {np.degrees(root):.4g} deg (root); valid: larger "
                             "ends, by addendum and dedendum, or arcs nearer to each other")
        return tip, tangent, root

    @checked(teeth=_TEETH, root=number(), points=_POINTS)
    def flank(self, teeth: int, root: float, points: int) -> np.ndarray:
        """Flank of the flexspline's tooth at rest; arguments, result and error as of `Involute.flank`."""
        tip, tangent, end = self._angles()
        lower, upper = np.linspace(end, tangent, points // 2), np.linspace(tangent, tip, points - points // 2)
        concave = np.column_stack([pi / 2 + self.concave_x - self.concave_radius * np.cos(lower),
                                   self.concave_y - self.concave_radius * np.sin(lower)])
        convex = np.column_stack([self.convex_radius * np.cos(upper) - self.convex_x,
                                  self.convex_radius * np.sin(upper) - self.convex_y])
        curve = np.concatenate([concave, convex])
        if not (curve[:, 0] > 0).all() or not (curve[:, 0] < pi / 2).all():
            raise InputError(f"the half thickness of the tooth goes from {curve[:, 0].min():.4g} to "
                             f"{curve[:, 0].max():.4g} modules; valid: within 0 and pi/2, by the arcs' centres and radii")
        pitch = root + self.dedendum * self.module if self.pitch_radius is None else self.pitch_radius
        return self.module * curve + [0, pitch]
