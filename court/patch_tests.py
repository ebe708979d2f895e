# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact patch tests (MOOSE verification: plane, brick, cylinder, ring, mu = 0.2; code_aster ssnp170): an even pressure passes unchanged
through an interface of meshes that do not match."""
import numpy as np

from bodies import Row, face_force, quarter_disc, two_bodies
from hdengine import mesh, solid

SOURCE = "MOOSE modules/contact/test/tests/verification/patch_tests; code_aster V6.03.170 (25 MPa to 0.1 %)"
PRESSURE = 25e6


def pair(kind):
    """Lower and upper mesh of a kind, contact at x = 0."""
    low, high = np.linspace(-1, 0, 4), np.linspace(0, 1, 3)
    if kind == "plane":
        return mesh.block(low, np.linspace(0, 1, 6), [0, 0.2]), mesh.block(high, np.linspace(0, 1, 8), [0, 0.2])
    if kind == "brick":
        return (mesh.block(low, np.linspace(0, 1, 4), np.linspace(0, 1, 6)), mesh.block(high, np.linspace(0, 1, 6), np.linspace(0, 1, 5)))
    if kind == "cylinder":
        return quarter_disc([0.5, 0.75, 1.0], 4, 8, low), quarter_disc([0.5, 0.7, 0.85, 1.0], 4, 8, high)

    def bend(p):
        return np.c_[p[:, 0], p[:, 1] * np.cos(p[:, 2]), p[:, 1] * np.sin(p[:, 2])]
    return (mesh.block(low, np.linspace(0.6, 1, 4), np.linspace(0, np.pi / 2, 9)).warp(bend),
            mesh.block(high, np.linspace(0.6, 1, 3), np.linspace(0, np.pi / 2, 9)).warp(bend))


def solve(kind):
    """Worst relative deviation of the contact pressure under load control."""
    first, second = pair(kind)
    bodies, slave, master, points, n = two_bodies(first, second, (210e9, 210e9), (0.3, 0.3), np.abs(first.points[:, 0]) < 1e-9,
                                                  np.abs(second.points[:, 0]) < 1e-9)
    fixed = np.zeros(points.shape, bool)
    if kind == "plane":
        fixed[:, 2] = True
    else:
        fixed[points[:, 2] < 1e-9, 2] = True
    fixed[points[:, 1] < 1e-9, 1] = True
    if kind == "plane" or kind == "brick":
        fixed[:, 1] |= points[:, 1] < 1e-9
    fixed[:n][first.points[:, 0] < -1 + 1e-9, 0] = True
    force = face_force(points, second.facets(second.points[:, 0] > 1 - 1e-9) + n, [-PRESSURE, 0, 0])
    result = solid.contact(bodies, slave, master, fixed, force=force, gap=np.zeros(len(points)), friction=0.2)
    p = result.traction[0, result.area > 0, 0]
    return p.mean() / 1e6, np.abs(p / PRESSURE - 1).max()


def rows():
    """All rows of the problem."""
    found = {kind: solve(kind) for kind in ("plane", "brick", "cylinder", "ring")}
    return [Row(f"{kind}: pressure", "MPa", 25.0, 25.0 * (1 + worst), 1e-3, f"worst point {worst:.1e}") for kind, (_, worst) in found.items()]
