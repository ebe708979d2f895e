# SPDX-License-Identifier: GPL-3.0-or-later
"""NAFEMS CGS-4: a block is pushed up a slope by a horizontal force; meshes that do not match."""
import numpy as np

from bodies import Row, two_bodies
from hdengine import mesh, solid

SOURCE = "NAFEMS benchmark CGS-4; F/G = (tan a + mu) / (1 - mu tan a)"


def solve(friction, slope=0.1):
    """Horizontal force over weight of a block that slides, in the frame of the slope."""
    alpha = np.arctan(slope)
    block = mesh.block(np.linspace(-1, 0, 5), np.linspace(0, 4, 14), [0, 0.3])
    ground = mesh.block([0, 0.5], np.linspace(-1, 6, 19), [0, 0.3])
    push = (block.points[:, 1] < 1e-9) & (block.points[:, 0] < -1e-9) & (block.points[:, 0] > -0.6)
    angle = np.where(push, np.pi / 2 - alpha, 0.0)   # first dof of the pushed nodes is horizontal, seen from the slope
    bodies, slave, master, points, n = two_bodies(block, ground, (206e9, 206e9), (0.3, 0.3), np.abs(block.points[:, 0]) < 1e-9,
                                                  np.abs(ground.points[:, 0]) < 1e-9, (angle, 0.0))
    weight = 1e6
    cells = block.points[block.cells]
    volume = np.abs(np.linalg.det(np.stack([cells[:, 1] - cells[:, 0], cells[:, 3] - cells[:, 0], cells[:, 4] - cells[:, 0]], 1)))
    lump = np.zeros(len(points))
    np.add.at(lump, block.cells, volume[:, None] / 8)
    pull = weight * lump / lump.sum()
    down = np.array([np.cos(alpha), -np.sin(alpha)])   # normal into the slope, tangential up the slope
    force = np.zeros(points.shape)
    first = np.concatenate([angle, np.zeros(len(ground.points))])
    force[:, 0] = pull * (down[0] * np.cos(first) + down[1] * np.sin(first))
    force[:, 1] = pull * (-down[0] * np.sin(first) + down[1] * np.cos(first))
    fixed = np.zeros(points.shape, bool)
    fixed[:, 2] = True
    fixed[n:] = True
    fixed[:n][push, 0] = True
    travel = np.zeros((4, len(points), 3))
    travel[:, :n][:, push, 0] = np.array([0, 1e-5, 1e-4, 2e-4])[:, None]
    result = solid.contact(bodies, slave, master, fixed, travel, np.broadcast_to(force, travel.shape), np.zeros(len(points)),
                           friction=friction, mode="frictional" if friction else "frictionless")
    applied = result.reaction[-1, :n][push, 0].sum()
    return Row(f"mu = {friction:g}: F/G", "-", (slope + friction) / (1 - friction * slope), abs(applied) / weight, 1e-6)


def rows():
    """All rows of the problem."""
    return [solve(mu) for mu in (0.0, 0.1, 0.2, 0.3)]
