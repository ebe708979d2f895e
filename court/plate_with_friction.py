# SPDX-License-Identifier: GPL-3.0-or-later
"""GRECO's plate with friction (code_aster ssnv128): pressed on a rigid plane and pushed from the side, mu = 1."""
import numpy as np

from bodies import MM, Row, face_force, nearest, two_bodies
from hdengine import mesh, solid

SOURCE = "code_aster V6.04.128 (GRECO's results, stated to 5 %)"
PLACES, REFERENCE = (0.0, 1.25, 5.0, 7.5, 11.25), (28.6, 27.2, 22.8, 19.8, 15.0)


def solve(cells=32, steps=10):
    """Displacements along the foot of the plate [um]; plane strain."""
    side = 40 * MM
    t = side / cells
    plate = mesh.block(np.linspace(-side, 0, cells + 1), np.linspace(0, side, cells + 1), [0, t])
    ground = mesh.block([0, t], np.linspace(-5 * MM, side + 5 * MM, cells), [0, t])
    bodies, slave, master, points, n = two_bodies(plate, ground, (130e9, 130e9), (0.2, 0.2), np.abs(plate.points[:, 0]) < 1e-9,
                                                  np.abs(ground.points[:, 0]) < 1e-9)
    fixed = np.zeros(points.shape, bool)
    fixed[:, 2] = True
    fixed[n:] = True
    fixed[:n][plate.points[:, 1] > side - 1e-9, 1] = True
    force = face_force(points, plate.facets(plate.points[:, 0] < -side + 1e-9), [50e6, 0, 0])
    force += face_force(points, plate.facets(plate.points[:, 1] < 1e-9), [0, 150e6, 0])
    share = np.linspace(1 / steps, 1, steps)[:, None, None]
    result = solid.contact(bodies, slave, master, fixed, force=share * force, gap=np.zeros(len(points)), friction=1.0)
    return [1e6 * result.u[-1, nearest(plate.points, 0, x * MM, 0), 1] for x in PLACES]


def rows():
    """All rows of the problem."""
    return [Row(f"u_x at x = {x:g} mm", "um", want, ours, 0.05) for x, want, ours in zip(PLACES, REFERENCE, solve())]
