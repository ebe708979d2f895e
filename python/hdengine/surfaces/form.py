# SPDX-License-Identifier: GPL-3.0-or-later
"""Form of a specimen taken off (the F-operation of ISO 25178-2): plane, polynomial, cylinder."""
from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from .._check import checked, kind, text
from .._engine import InputError
from .specimen import Specimen

__all__ = ["Form", "remove"]
MOST = 8                                #: highest degree of a polynomial
_BLOCK = 1 << 18                        #: points taken at once
_ROOM = 0.6                             #: of the curvature at which an arc ends within the map: where the search begins at most
_SETTLED = 1e-10                        #: fall of the sum of squares, relative, that ends it
_STEP = 1e-6                            #: of numeric derivatives, relative to the longer side


@dataclass(frozen=True)
class Form:
    """What was taken off, and what is left."""

    kind: str                               #: none, plane, poly2 .. poly8 or cylinder
    specimen: Specimen = field(repr=False)  #: heights less the form, of mean 0 [m]
    range_m: float                          #: highest less lowest point of the form on the map [m]
    radius_m: float = float("nan")          #: of the cylinder; positive: the surface is convex, as the outside of a ring [m]
    axis_rad: float = float("nan")          #: direction of its axis, from x towards y, -pi/2 to pi/2 [rad]


@checked(specimen=kind(Specimen), form=text)
def remove(specimen: Specimen, form: str = "plane") -> Form:
    """Take the form off by least squares of the heights; holes stay holes.

    Parameters
    ----------
    specimen : Specimen
        Map or profile.
    form : str
        "none" (the mean alone), "plane", "poly2" to "poly8" (polynomial of that total degree), or "cylinder": a circular one of any
        radius, axis and tilt; of a profile, a circle.

    Returns
    -------
    Form

    Raises
    ------
    InputError
        Unknown form, fewer heights than unknowns, no cylinder fits.
    """
    degree = _degree(form)
    z = np.atleast_2d(np.asarray(specimen.heights, dtype=float))
    good = np.isfinite(z)
    unknowns = 5 if form == "cylinder" else (degree + 1) * (degree + 2) // 2
    if good.sum() < 2 * unknowns:
        raise InputError(f"{specimen.name}: {good.sum()} heights for the {unknowns} unknowns of the form {form!r}")
    y, x = (np.arange(n) - 0.5 * (n - 1) for n in z.shape)
    half = max(x[-1] * specimen.spacing[1], y[-1] * specimen.spacing[0])
    x, y = x * (specimen.spacing[1] / half), y * (specimen.spacing[0] / half)      # -1 to 1 along the longer side
    facts = {}
    if form == "cylinder":
        shape, curvature, angle = _cylinder(x, y, z, good, half, specimen.name)
        facts = {"radius_m": -1 / curvature if curvature else np.inf,
                 "axis_rad": angle % np.pi - np.pi / 2 if z.shape[0] > 1 else float("nan")}
    else:
        shape = _polynomial(x, y, z, good, degree)
    rest = z - shape
    rest -= rest[good].mean()
    kept = Specimen(rest.reshape(specimen.heights.shape), specimen.spacing, specimen.name, (*specimen.notes, f"form off: {form}"))
    return Form(form, kept, float(np.ptp(shape)), **facts)


def _degree(form):
    """Degree of a polynomial by its name."""
    found = {"none": 0, "plane": 1, "cylinder": 2} | {f"poly{k}": k for k in range(2, MOST + 1)}
    if not isinstance(form, str) or form not in found:
        raise InputError(f"form = {form!r}: none, plane, poly2 to poly{MOST} or cylinder" + (
            f"; a polynomial has up to degree {MOST}" if re.fullmatch(r"poly\d+", str(form)) else ""))
    return found[form]


def _polynomial(x, y, z, good, degree):
    """Least-squares polynomial of a total degree in Legendre's products, which are nearly orthogonal on the grid."""
    top = min(degree, z.shape[1] - 1), min(degree, z.shape[0] - 1)
    px, py = (np.polynomial.legendre.legvander(s / max(abs(s[0]), np.finfo(float).tiny), n) for s, n in zip((x, y), top))
    terms = [(i, j) for j in range(top[1] + 1) for i in range(top[0] + 1) if i + j <= degree]
    weight = good.astype(float)
    flat = np.where(good, z - z[good].mean(), 0.0)
    # normal equations, summed along rows first: the products are so close to orthogonal that nothing is lost
    gram = np.empty((len(terms), len(terms)))
    for a, (i, j) in enumerate(terms):
        rows = weight @ (px[:, i, None] * px)
        both = (py[:, j, None] * py).T @ rows
        gram[a] = [both[m, k] for k, m in terms]
    right = py.T @ (flat @ px)
    c = np.linalg.lstsq(gram, np.array([right[j, i] for i, j in terms]), rcond=1e-13)[0]
    coefficients = np.zeros((top[1] + 1, top[0] + 1))
    for value, (i, j) in zip(c, terms):
        coefficients[j, i] = value
    return z[good].mean() + py @ coefficients @ px.T


def _circle(s, slope, curvature):
    """Height over s of an arc through 0 with a slope there: regular where the curvature is 0; NaN beyond its end."""
    start = slope / np.hypot(1, slope)
    turn = start + curvature * s
    with np.errstate(invalid="ignore"):
        return s * (turn + start) / (np.sqrt(1 - turn**2) + np.sqrt(1 - start**2))


def _model(p, x, y):
    """Cylinder of height p[0] in the middle, slopes p[1] along and p[2] across its axis, curvature p[3], across direction p[4]."""
    across, along = np.cos(p[4]) * x + np.sin(p[4]) * y, -np.sin(p[4]) * x + np.cos(p[4]) * y
    # a tilt of the axis by t stretches the section by 1 / cos t
    return p[0] + p[1] * along + np.hypot(1, p[1]) * _circle(across, p[2], p[3])


def _cylinder(x, y, z, good, half, name):
    """Least squares by Levenberg and Marquardt from the polynomial of degree 2; lengths are in units of `half`."""
    xx, yy = np.broadcast_arrays(x[None, :], y[:, None])
    points = xx[good], yy[good], z[good] / half
    if z.shape[0] == 1:
        start = np.polynomial.polynomial.polyfit(points[0], points[2], 2)
        angle, along, across, bend = 0.0, 0.0, start[1], 2 * start[2]
    else:
        u, v, h = points
        start = np.linalg.lstsq(np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=1), h, rcond=None)[0]
        values, vectors = np.linalg.eigh([[2 * start[3], start[4]], [start[4], 2 * start[5]]])
        k = int(np.argmax(abs(values)))
        bend, (cos, sin) = values[k], vectors[:, k]
        angle, along, across = float(np.arctan2(sin, cos)), cos * start[2] - sin * start[1], cos * start[1] + sin * start[2]
    room = 1 - abs(across) / np.hypot(1, across)        # from the sine of the slope in the middle to that where the arc ends
    bend = np.clip(bend * (1 + across**2) ** -1.5, -_ROOM * room, _ROOM * room)
    found = _least(np.array([start[0], along, across, bend, angle]), [0, 2, 3] if z.shape[0] == 1 else [0, 1, 2, 3, 4], points)
    if found is None:
        raise InputError(f"{name}: no cylinder follows the heights; take a polynomial")
    return _model(found, xx, yy) * half, found[3] / half, found[4]


def _least(p, free, points):
    """Minimum of the sum of squares over the free numbers; None where the arc ends within the map."""
    cost, normal, right = _normal(p, free, points)
    if not np.isfinite(cost):
        return None
    damping = 1e-3
    for _ in range(60):
        for _ in range(12):
            trial = p.copy()
            trial[free] -= np.linalg.lstsq(normal + damping * np.diag(np.diag(normal)), right, rcond=None)[0]
            now, *system = _normal(trial, free, points)
            if now <= cost:
                break
            damping *= 4
        else:                                                 # no step gains: rounding is reached
            break
        gain, p, cost, (normal, right), damping = cost - now, trial, now, system, damping / 9
        if gain <= _SETTLED * cost:
            break
    return p


def _normal(p, free, points):
    """Sum of squares, normal matrix and right side of the linear problem about p, block by block."""
    cost, normal, right = 0.0, np.zeros((len(free), len(free))), np.zeros(len(free))
    for first in range(0, len(points[0]), _BLOCK):
        x, y, h = (v[first:first + _BLOCK] for v in points)
        rest = _model(p, x, y) - h
        steps = _STEP * np.eye(5)[free]
        jacobian = np.stack([_model(p + s, x, y) - _model(p - s, x, y) for s in steps], axis=1) / (2 * _STEP)
        cost, normal, right = cost + rest @ rest, normal + jacobian.T @ jacobian, right + jacobian.T @ rest
    return (cost, normal, right) if np.isfinite(normal).all() else (np.inf, normal, right)
