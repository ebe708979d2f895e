# SPDX-License-Identifier: GPL-3.0-or-later
"""NAFEMS contact benchmark 1 (Konter 2006; code_aster ssnp154): a cylindrical roller on a block, plane strain."""
import numpy as np

from bodies import MM, Row, face_force, nearest, symmetric_graded, two_bodies
from hdengine import mesh, solid

SOURCE = "A. Konter, Advanced Finite Element Contact Benchmarks, NAFEMS 2006; code_aster V6.03.154"


def solve(h=0.25, friction=0.0):
    """Rows for one coefficient of friction; h is the cell size in the contact [mm]."""
    radius, load = 50 * MM, 17.5e6
    y = symmetric_graded(h * MM, 9 * MM, 48 * MM, 1.2)
    depth = mesh.graded(0, 1, h * MM / radius, 1.25)[::-1]
    t = h * MM

    def column(p):  # from the plane through the roller's axis down to its surface
        surface = radius - np.sqrt(radius**2 - p[:, 1] ** 2)
        return np.c_[-surface - p[:, 0] * (radius - surface), p[:, 1:]]

    roller = mesh.block(depth[::-1], y, [0, t]).warp(column)
    roller = mesh.Mesh(roller.points, roller.cells[:, [3, 2, 1, 0, 7, 6, 5, 4]])
    block = mesh.block(symmetric_graded(h * MM, 9 * MM, 200 * MM, 1.2), symmetric_graded(1.07 * h * MM, 10 * MM, 100 * MM, 1.2), [0, t])
    surface = radius - np.sqrt(radius**2 - roller.points[:, 1] ** 2)
    bodies, slave, master, points, n = two_bodies(roller, block, (210e9, 70e9), (0.3, 0.3),
                                                  np.abs(roller.points[:, 0] + surface) < 1e-9, np.abs(block.points[:, 0]) < 1e-9)
    fixed = np.zeros(points.shape, bool)
    fixed[:, 2] = True
    fixed[points[:, 1] < 1e-9, 1] = True
    fixed[n:][block.points[:, 0] > 200 * MM - 1e-9, 0] = True
    top = np.abs(roller.points[:, 0] + radius) < 1e-9
    force = face_force(points, roller.facets(top), [1.0, 0, 0])
    force *= load * t / force[:, 0].sum()
    gap = np.zeros(len(points))
    gap[:n] = surface
    steps = np.linspace(0.1, 1, 10)[:, None, None] if friction else np.ones((1, 1, 1))
    result = solid.contact(bodies, slave, master, fixed, force=steps * force, gap=gap, friction=friction,
                           mode="frictional" if friction else "frictionless")
    line = np.flatnonzero((result.area > 0) & (points[:, 2] < 1e-9))
    line = line[np.argsort(points[line, 1])]
    p, y = result.traction[-1, line, 0], points[line, 1]
    use = p > 0.25 * p.max()
    fit = np.polyfit(y[use] ** 2, p[use] ** 2, 1)
    down = -result.u[-1, n + nearest(block.points, 0, 0, 0), 0] / MM
    case = f"mu = {friction:g}"
    if friction:
        return [Row(f"{case}: displacement of B", "mm", -1.30264, down, 0.002, "MARC, Abaqus: -1.30108, -1.30264; with large displacements"),
                Row(f"{case}: pressure at B", "MPa", 3543.0, p[0] / 1e6, 0.05, "MARC, Abaqus: 3670 linear, 3543 quadratic elements")]
    return [Row(f"{case}: half-width", "mm", 6.21, np.sqrt(-fit[1] / fit[0]) / MM, 0.02, "Hertz"),
            Row(f"{case}: peak pressure", "MPa", 3585.4, p[0] / 1e6, 0.02, "Hertz; MARC, Abaqus: 3800 linear, 3513 quadratic elements"),
            Row(f"{case}: displacement of B", "mm", -1.30802, down, 0.002, "MARC, Abaqus: -1.30690, -1.30802; with large displacements")]


def rows():
    """All rows of the problem."""
    return solve() + solve(friction=0.1)
