# SPDX-License-Identifier: GPL-3.0-or-later
"""A rigid flat punch on an elastic half space: bonded (Mossakovskii, Spence), and with friction (Spence's stick zone)."""
import numpy as np

from bodies import MM, Row, quarter_disc, two_bodies
from hdengine import mesh, solid

SOURCE = ("K. L. Johnson, Contact Mechanics, sec. 2.8 (plane, bonded, and Spence 1973 with friction); "
          "D. A. Spence, Proc. R. Soc. A 305 (1968) 55 and V. I. Mossakovskii 1954 (round, bonded)")
YOUNG, POISSON = 200e9, 0.3


def plane(friction=None, poisson=POISSON, edge=1e-3, cells=60, growth=1.15, far=1000.0):
    """Tractions of a plane punch of half-width 1 mm: position over the half-width, pressure and outward shear over P/2a.

    `friction` None: bonded. `edge` is the length of the cells at the punch's edge over its half-width, `cells` their number in it if all were equal.
    """
    near = mesh.graded(0, 10 / cells, edge, growth)
    inner = np.concatenate([np.linspace(0, 1 - near[-1], cells - 9), 1 - near[-2::-1]])
    y = MM * np.concatenate([inner, 1 + mesh.graded(0, 1, edge, growth)[1:], mesh.graded(2, far, 0.1, 1.25)[1:]])
    depth = -MM * np.concatenate([mesh.graded(0, 1, edge, growth), mesh.graded(1, far, 0.1, 1.25)[1:]])[::-1]
    thick = [0, MM * 0.1]
    space, punch = mesh.block(depth, y, thick), mesh.block([0, MM], MM * inner, thick)
    touch = (np.abs(space.points[:, 0]) < 1e-12) & (space.points[:, 1] < MM * (1 + 1e-9))
    bodies, slave, master, points, n = two_bodies(space, punch, (YOUNG, YOUNG), (poisson, poisson), touch, np.abs(punch.points[:, 0]) < 1e-12)
    fixed = np.zeros(points.shape, bool)
    fixed[:, 2] = True
    fixed[n:] = True
    fixed[:n, 1] = space.points[:, 1] < 1e-12
    fixed[:n][(space.points[:, 0] < -MM * far * (1 - 1e-9)) | (space.points[:, 1] > MM * far * (1 - 1e-9))] = True
    push = np.zeros(points.shape)
    push[n:, 0] = -1e-6
    how = {"mode": "bonded"} if friction is None else {"friction": friction}
    result = solid.contact(bodies, slave, master, fixed, push, gap=np.zeros(len(points)), **how)
    row = np.flatnonzero(touch & (space.points[:, 2] < 1e-12))
    row = row[np.argsort(points[row, 1])]
    mean = (result.area * result.traction[0, :, 0]).sum() / (MM * thick[1])
    return points[row, 1] / MM, result.traction[0, row, 0] / mean, -result.traction[0, row, 1] / mean, result.state[0, row]


def spence(friction, poisson=POISSON):
    """Stick zone over half-width of a plane punch: K'(c/a) / K(c/a) = (1 - 2 nu) / (2 mu (1 - nu)), elliptic integrals by means."""
    def quarter(k):   # K(k) by the arithmetic-geometric mean
        a, b = 1.0, np.sqrt(1 - k * k)
        while abs(a - b) > 1e-15 * a:
            a, b = (a + b) / 2, np.sqrt(a * b)
        return np.pi / (2 * a)
    want = (1 - 2 * poisson) / (2 * friction * (1 - poisson))
    low, high = 1e-12, 1 - 1e-12
    for _ in range(200):
        c = (low + high) / 2
        low, high = (c, high) if quarter(np.sqrt(1 - c * c)) / quarter(c) > want else (low, c)
    return c


def by_boundary_integral(friction, poisson, coupled=True, cells=400):
    """Stick zone over half-width, bracketed by cells of even tractions; without `coupled`, shear leaves the pressure as it is (as `spence`)."""
    x = (np.sin(np.pi / 2 * np.linspace(-1, 1, cells + 1)) + np.linspace(-1, 1, cells + 1)) / 2
    m, h = (x[1:] + x[:-1]) / 2, np.diff(x)

    def primitive(t):
        return t * np.log(np.abs(t)) - t

    logs = primitive(m[:, None] - x[:-1]) - primitive(m[:, None] - x[1:])
    signs = 2 * np.clip(m[:, None] - x[:-1], 0, h) - h
    along, across = -(1 - poisson) / np.pi * logs, (1 - 2 * poisson) / 4 * signs   # displacement along a line load, and across it
    stick, outward = np.ones(cells, bool), np.sign(m)
    while True:
        a, right = np.zeros((2, cells, 2, cells)), np.zeros(2 * cells)
        a[0, :, 0], a[0, :, 1] = along - along[0], (across - across[0]) * coupled
        a[0, 0, 0], right[0] = h, 1
        a[1, stick, 0], a[1, stick, 1] = -across[stick], along[stick]
        slips = np.flatnonzero(~stick)
        a[1, slips, 1, slips], a[1, slips, 0, slips] = 1, -friction * outward[slips]
        p, q = np.linalg.solve(a.reshape(2 * cells, 2 * cells), right).reshape(2, cells)
        moved = along @ q - across @ p
        new = np.where(stick, np.abs(q) <= friction * p, moved * outward > 0)
        if (new == stick).all():
            edge = np.flatnonzero(stick).max()
            return x[edge + 1]
        stick = new


def stick_zone(friction, poisson):
    """Stick zone over half-width by the engine: where the square of the shear's distance from the limit is zero."""
    y, p, q, state = plane(friction, poisson)
    last = np.flatnonzero(state == 1).max()
    use = slice(max(0, last - 6), last)
    slope, start = np.polyfit(y[use], (1 - q[use] / (friction * p[use])) ** 2, 1)
    return -start / slope


def round_bonded(core=6, edge=0.02, growth=1.25, far=20.0):
    """Load over the travel of a bonded round punch, over G a; the far side moves as Boussinesq's point load moves it."""
    inside = 1 - mesh.graded(0, 0.5, edge, growth)[::-1]
    outside = 1 + mesh.graded(0, far - 1, edge, growth)[1:]
    down = -MM * mesh.graded(0, far, edge, growth)[::-1]
    space = quarter_disc(MM * np.concatenate([inside, outside]), core, 2 * core, down)
    punch = quarter_disc(MM * inside, core, 2 * core, [0, MM])
    rho = np.hypot(space.points[:, 1], space.points[:, 2])
    touch = (np.abs(space.points[:, 0]) < 1e-12) & (rho < MM * (1 + 1e-9))
    bodies, slave, master, points, n = two_bodies(space, punch, (YOUNG, YOUNG), (POISSON, POISSON), touch, np.abs(punch.points[:, 0]) < 1e-12)
    away = (space.points[:, 0] < -MM * far * (1 - 1e-9)) | (rho > MM * far * (1 - 1e-9))
    fixed = np.zeros(points.shape, bool)
    fixed[n:] = True
    fixed[:n, 1], fixed[:n, 2] = space.points[:, 1] < 1e-12, space.points[:, 2] < 1e-12
    fixed[:n][away] = True
    shear = YOUNG / (2 * (1 + POISSON))
    d, r = -space.points[away, 0], rho[away]
    s = np.hypot(d, r)
    radial = (r * d / s**3 - (1 - 2 * POISSON) * r / (s * (s + d))) / (4 * np.pi * shear)
    sink = (d**2 / s**3 + 2 * (1 - POISSON) / s) / (4 * np.pi * shear)
    loads = []
    for travel, load in ((1e-6, 0.0), (0.0, 1e3)):   # the load follows from both by superposition
        u = np.zeros(points.shape)
        u[n:, 0] = -travel
        u[:n][away] = load * np.c_[-sink, radial[:, None] * space.points[away, 1:] / np.maximum(r, 1e-30)[:, None]]
        result = solid.contact(bodies, slave, master, fixed, u, gap=np.zeros(len(points)), mode="bonded")
        loads.append(4 * (result.area * result.traction[0, :, 0]).sum())
    return loads[0] / (1 - loads[1] / 1e3) / 1e-6 / (shear * MM)


def rows():
    """All rows of the problem."""
    eta = np.log(3 - 4 * POISSON) / (2 * np.pi)
    y, p, q, _ = plane()
    half = np.argmin(np.abs(y - 0.5))
    found = [Row("bonded, plane: pressure at the centre over P/2a", "-", 4 * (1 - POISSON) / (np.pi * np.sqrt(3 - 4 * POISSON)), p[0], 5e-3),
             Row("bonded, plane: shear over pressure at a/2", "-", np.tan(eta * np.log((1 + y[half]) / (1 - y[half]))), q[half] / p[half], 1e-2),
             Row("bonded, round: stiffness over G a", "-", 4 * np.log(3 - 4 * POISSON) / (1 - 2 * POISSON), round_bonded(), 1e-2)]
    for friction, poisson, tolerance in ((0.0955, 0.45, 0.02), (0.3, 0.3, 0.02)):
        ours = stick_zone(friction, poisson)
        found.append(Row(f"stick zone c/a, nu = {poisson:g}, mu = {friction:g}", "-", spence(friction, poisson), ours, tolerance,
                         "the relation leaves the pressure as without friction"))
    found.append(Row("the same, boundary integral with coupling", "-", by_boundary_integral(0.3, 0.3), ours, 0.01))
    return found
