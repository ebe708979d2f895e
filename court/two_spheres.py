# SPDX-License-Identifier: GPL-3.0-or-later
"""Two equal spheres pressed together (code_aster ssnv104); by symmetry a hemisphere on a rigid plane."""
import numpy as np

from bodies import MM, Row, nearest, quarter_disc, two_bodies
from hdengine import mesh, solid

SOURCE = "code_aster V6.04.104; p0 = E / (pi (1 - nu^2)) sqrt(2 h / R) of Hertz, h the travel of each equator"


def solve(core=10, fine=0.9):
    """Peak pressure [MPa] of a hemisphere whose equator is moved by 2 mm; `fine` is the cell length in the contact [mm]."""
    radius, travel = 50 * MM, 2 * MM
    radii = MM * np.concatenate([np.arange(7, 14.01, fine), [15.5, 17.5, 20, 23.5, 28, 34, 41, 48.5]])
    ball = quarter_disc(radii, core, 2 * core, -mesh.graded(0, radius, fine * MM, 1.25)[::-1])
    rho = np.hypot(ball.points[:, 1], ball.points[:, 2])
    surface = radius - np.sqrt(radius**2 - rho**2)
    on = np.abs(ball.points[:, 0]) < 1e-9
    ball = mesh.Mesh(np.c_[-surface + ball.points[:, 0] * (1 - surface / radius), ball.points[:, 1:]], ball.cells)
    plane = mesh.block([0, 5 * MM], [0, 60 * MM], [0, 60 * MM])
    bodies, slave, master, points, n = two_bodies(ball, plane, (20e9, 20e9), (0.3, 0.3), on, np.abs(plane.points[:, 0]) < 1e-9)
    fixed = np.zeros(points.shape, bool)
    fixed[n:] = True
    fixed[:n][ball.points[:, 1] < 1e-9, 1] = True
    fixed[:n][ball.points[:, 2] < 1e-9, 2] = True
    equator = ball.points[:, 0] < -radius + 1e-9
    fixed[:n][equator, 0] = True
    push = np.zeros(points.shape)
    push[:n][equator, 0] = travel
    gap = np.zeros(len(points))
    gap[:n] = surface
    result = solid.contact(bodies, slave, master, fixed, push, gap=gap, mode="frictionless")
    p = result.traction[0, :, 0]
    force = 4 * (result.area * p).sum()
    modulus = 20e9 / (1 - 0.3**2)
    at_load = 2 / np.pi * modulus * np.sqrt((3 * force / (4 * 2 * modulus * np.sqrt(radius))) ** (2 / 3) / radius) / 2 ** 0
    return p[nearest(points[:n], 0, 0, 0)] / 1e6, force, at_load / 1e6


def rows():
    """All rows of the problem."""
    peak, force, _ = solve()
    star, r = 20e9 / (1 - 0.3**2), 50 * MM     # rigid plane: E* = E / (1 - nu^2)
    by_load = (6 * force * star**2 / (np.pi**3 * r**2)) ** (1 / 3) / 1e6
    return [Row("peak pressure for the travel", "MPa", 2798.0, peak, 0.05, "the equator's travel holds the bulk's compression too"),
            Row("peak pressure for the load carried", "MPa", by_load, peak, 0.03, "Hertz; contact radius a fifth of the sphere's")]
