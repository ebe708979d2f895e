# SPDX-License-Identifier: GPL-3.0-or-later
"""NAFEMS contact benchmark 2 (Konter 2006; code_aster ssna122): a punch with a rounded edge on a foundation, axisymmetric."""
import numpy as np

from bodies import MM, Row, face_force, nearest, quarter_disc, two_bodies
from hdengine import mesh, solid

SOURCE = "A. Konter, Advanced Finite Element Contact Benchmarks, NAFEMS 2006; code_aster V6.01.122"


def solve(friction, core=6, fine=1.0):
    """Rows for one coefficient of friction; `fine` is the cell length at the end of the contact [mm]."""
    out = np.concatenate([mesh.graded(0, 16, fine, 1.3)[::-1] * -1 + 40, np.arange(40 + fine, 44.01, fine), [46, 48, 50]])
    inner = MM * out
    axial = mesh.graded(0, 100 * MM, 1.5 * fine * MM, 1.35)
    punch = quarter_disc(inner, core, 2 * core, -axial[::-1])
    rise = 10 * MM - np.sqrt(np.maximum((10 * MM) ** 2 - np.maximum(np.hypot(*punch.points[:, 1:].T) - 40 * MM, 0) ** 2, 0))
    on = np.abs(punch.points[:, 0]) < 1e-9
    share = np.clip(1 + punch.points[:, 0] / (20 * MM), 0, 1)
    punch = mesh.Mesh(np.c_[punch.points[:, 0] - share * rise * 0.999, punch.points[:, 1:]], punch.cells)
    base = quarter_disc(MM * np.concatenate([out, [55, 62, 71, 84, 100]]), core, 2 * core,
                        mesh.graded(0, 200 * MM, 1.5 * fine * MM, 1.35))
    bodies, slave, master, points, n = two_bodies(punch, base, (210e9, 70e9), (0.3, 0.3), on, np.abs(base.points[:, 0]) < 1e-9)
    fixed = np.zeros(points.shape, bool)
    fixed[points[:, 1] < 1e-9, 1] = True
    fixed[points[:, 2] < 1e-9, 2] = True
    fixed[n:][base.points[:, 0] > 200 * MM - 1e-9] = True
    top = np.abs(punch.points[:, 0] + 100 * MM) < 1e-9
    force = face_force(points, punch.facets(top), [100e6, 0, 0])
    gap = np.zeros(len(points))
    gap[:n] = rise
    steps = np.linspace(0.2, 1, 5)[:, None, None] if friction else np.ones((1, 1, 1))
    result = solid.contact(bodies, slave, master, fixed, force=steps * force, gap=gap, friction=friction,
                           mode="frictional" if friction else "frictionless")
    down = -result.u[-1, n + nearest(base.points, 0, 0, 0), 0] / MM
    linear, quadratic = {0.0: (-0.13073, -0.13294), 0.1: (-0.12858, -0.13079)}[friction]
    return [Row(f"mu = {friction:g}: displacement of M", "mm", quadratic, down, 0.02, f"linear elements {linear}, quadratic {quadratic}")]


def rows():
    """All rows of the problem."""
    return solve(0.0) + solve(0.1)
