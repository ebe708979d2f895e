# SPDX-License-Identifier: GPL-3.0-or-later
"""What the problems of the court share: rows of the table, plane and quarter-round meshes, loads on faces."""
from dataclasses import dataclass

import numpy as np

from hdengine import mesh, solid

MM = 1e-3


@dataclass
class Row:
    """One judged quantity: the engine's value beside the published one."""

    quantity: str
    unit: str
    reference: float
    ours: float
    tolerance: float      # relative, as the source states it or as its own scatter allows
    remark: str = ""

    @property
    def error(self):
        """Relative difference to the reference."""
        return self.ours / self.reference - 1 if self.reference else self.ours

    @property
    def verdict(self):
        """`agrees` within the tolerance, else `differs`."""
        return "agrees" if abs(self.error) <= self.tolerance else "differs"


def nearest(points, *target):
    """Number of the node nearest to a point [m]."""
    return int(np.argmin(np.linalg.norm(points - np.array(target), axis=1)))


def symmetric_graded(h, fine, far, growth=1.25):
    """Coordinates from 0: steps of h up to `fine`, then growing up to `far` [m]."""
    uniform = np.linspace(0, fine, max(1, round(fine / h)) + 1)
    return np.concatenate([uniform, mesh.graded(fine, far, h * growth, growth)[1:]])


def quarter_disc(radii, core, angular, axial):
    """Quarter of a disc, axis along x, cells of a core square under sectors.

    Parameters
    ----------
    radii : array_like
        Radii of the rows of cells outside the core, the first one the core's [m].
    core : int
        Cells along a side of the core.
    angular : int
        Cells over the quarter; twice `core`.
    axial : array_like
        Coordinates along the axis [m].

    Returns
    -------
    Mesh
    """
    radii = np.asarray(radii, float)
    half = radii[0] / np.sqrt(2)
    index = np.linspace(0, 1, core + 1)

    def square(p):  # bulges out to the circle along its two outer sides
        u, v = p[:, 1], p[:, 2]
        bulge = 1 + 0.15 * np.maximum(u, v) ** 2 * np.cos(np.pi / 2 * np.minimum(u, v)) ** 2
        return np.c_[p[:, 0], half * u * bulge, half * v * bulge]

    inner = mesh.block(axial, index, index).warp(square)
    parts = [inner]
    for swap in (False, True):
        ring = mesh.block(axial, np.arange(len(radii)), np.linspace(0, 1, angular // 2 + 1))

        def bend(p, swap=swap):
            t = p[:, 2]
            side = square(np.c_[0 * t, np.ones_like(t), t])[:, 1:]
            turn = np.arctan2(side[:, 1], side[:, 0])
            circle = np.c_[np.cos(turn), np.sin(turn)]
            share = np.minimum(1, p[:, 1])[:, None]
            radius = np.interp(p[:, 1], np.arange(len(radii)), radii)[:, None]
            yz = (1 - share) * side + share * radius * circle
            if swap:
                yz = yz[:, ::-1]
            return np.c_[p[:, 0], yz]

        part = ring.warp(bend)
        if swap:
            part = mesh.Mesh(part.points, part.cells[:, [3, 2, 1, 0, 7, 6, 5, 4]])
        parts.append(part)
    return mesh.merge(*parts)


def face_force(points, facets, traction):
    """Nodal forces of an even traction [Pa] on facets: (n, 3) [N]."""
    force = np.zeros(points.shape)
    gauss = np.array([-1, 1]) / np.sqrt(3)
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for a in gauss:
        for b in gauss:
            shape = (1 + corner[:, 0] * a) * (1 + corner[:, 1] * b) / 4
            da, db = corner[:, 0] * (1 + corner[:, 1] * b) / 4, corner[:, 1] * (1 + corner[:, 0] * a) / 4
            x = points[facets[:, :4]]
            area = np.linalg.norm(np.cross(np.einsum("fkd,k->fd", x, da), np.einsum("fkd,k->fd", x, db)), axis=1)
            np.add.at(force, facets[:, :4], area[:, None, None] * shape[None, :, None] * np.asarray(traction, float))
    return force


def two_bodies(first, second, young, poisson, contact_first, contact_second, angle=None):
    """Two meshes as bodies with their contact faces on the y-z chart.

    Returns
    -------
    tuple
        Bodies, slave face, master face, all points, number of nodes of the first body.
    """
    points = np.vstack([first.points, second.points])
    n = len(first.points)
    angles = (0.0, 0.0) if angle is None else angle
    bodies = [solid.Body(m, e, v, a) for m, e, v, a in zip((first, second), young, poisson, angles)]
    chart = points[:, 1:]
    return (bodies, solid.Face(first.facets(contact_first), chart), solid.Face(second.facets(contact_second) + n, chart), points, n)


def blocks_in_line_contact(per_half_width, young=200e9, poisson=0.3, far=40 * MM):
    """Two blocks for a line contact of half-width about 1 mm, their far sides held along x and y.

    Returns
    -------
    tuple
        Bodies, slave face, master face, points, supports, nodes of the lower and of the upper far side.
    """
    h = MM / per_half_width
    side = symmetric_graded(h, 1.4 * MM, far)
    y = np.concatenate([-side[:0:-1], side])
    x = mesh.graded(0, far, h, 1.25)
    lower, upper = mesh.block(-x[::-1], y, [0, h]), mesh.block(x, y, [0, h])
    bodies, slave, master, points, _ = two_bodies(lower, upper, (young, young), (poisson, poisson), np.abs(lower.points[:, 0]) < 1e-12,
                                                  np.abs(upper.points[:, 0]) < 1e-12)
    fixed = np.zeros(points.shape, bool)
    fixed[:, 2] = True
    low, high = np.abs(points[:, 0] + far) < 1e-9, np.abs(points[:, 0] - far) < 1e-9
    fixed[low | high, :2] = True
    return bodies, slave, master, points, fixed, low, high
