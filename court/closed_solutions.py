# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact problems with closed solutions: Hertz, Cattaneo and Mindlin, a dragged rod, Persson's pin, Lame's press fit.

Each function solves one problem and returns measured and exact figures. Bodies touch at x = 0 (planes) or at a cylinder round z;
plane problems are one cell thick in z with u_z = 0.
"""
import numpy as np

from bodies import Row
from hdengine import mesh as hm
from hdengine import solid

E, NU = 200e9, 0.3
RADIUS = 0.1   # of the cylinders and of the sphere [m]


def fixed_z(n):
    """Supports (n, 3) of plane strain."""
    fixed = np.zeros((n, 3), bool)
    fixed[:, 2] = True
    return fixed


def both(values):
    """Coordinates mirrored to negative values."""
    return np.concatenate([-values[:0:-1], values])


def fine_then_graded(h, fine, far, growth=1.25):
    """0 to `fine` in steps of h, then growing to `far`."""
    uniform = np.linspace(0, fine, round(fine / h) + 1)
    return np.concatenate([uniform, hm.graded(fine, far, h * growth, growth)[1:]])


def edge(position, pressure):
    """Half-width: zero of p^2, linear in the square of the position where p ~ sqrt(a^2 - s^2), fitted above a quarter of the peak."""
    use = pressure > 0.25 * pressure.max()
    c = np.polyfit(position[use] ** 2, pressure[use] ** 2, 1)
    return np.sqrt(-c[1] / c[0])


def iterations(solution):
    """Newton iterations of each step."""
    h = solution.history
    return [int(h[h[:, 0] == s, 1].max()) for s in np.unique(h[:, 0])]


# -- Hertz, Cattaneo and Mindlin -----------------------------------------------------------------------------------------
def cylinder_pair(per_half_width, element, matching=True, far=40.0):
    """Two equal elastic blocks for a contact of half-width about 1 mm; bodies, faces, gap, nodes of the far sides."""
    h, unit = 1 / per_half_width, 1e-3
    quadratic = element == "hex20r"
    bodies, chart = [], []
    for b, sign in ((0, -1), (1, 1)):
        step = h if matching or b == 0 else h / 1.13
        y = both(fine_then_graded(step, 1.5 if matching or b == 0 else 1.5 * 1.02, far))
        x = hm.graded(0, far, h, 1.25)
        m = hm.block(unit * (-x[::-1] if sign < 0 else x), unit * y, [0, unit * h], quadratic)
        bodies.append(solid.Body(m, E, NU))
    points = np.vstack([b.mesh.points for b in bodies])
    n0 = len(bodies[0].mesh.points)
    touching = np.abs(points[:, 0]) < 1e-12
    chart = points[:, 1:]
    slave = solid.Face(bodies[0].mesh.facets(touching[:n0]), chart)
    master = solid.Face(bodies[1].mesh.facets(touching[n0:]) + n0, chart)
    return bodies, points, slave, master, np.abs(points[:, 0] + unit * far) < 1e-9, np.abs(points[:, 0] - unit * far) < 1e-9


def cylinder_problem(per_half_width=10, element="hex8i", friction=0.0, path=(), matching=True):
    """Bodies, points, slave, master, supports, displacements of the steps and gap of `cylinder`; nodes of the lower far side."""
    bodies, points, slave, master, low, high = cylinder_pair(per_half_width, element, matching)
    modulus = E / (2 * (1 - NU**2))
    load = np.pi * modulus * (1e-3) ** 2 / (4 * RADIUS)          # N/m for a = 1 mm
    flex = 2 * (1 - NU**2) / (np.pi * E) * (2 * np.log(2 * 40.0) - 1)  # approach per load, two bodies, roughly
    fixed = fixed_z(len(points))
    fixed[low | high, :2] = True
    u = np.zeros((1 + len(path), len(points), 3))
    u[:, high, 0] = -load * flex
    for s, share in enumerate(path):
        u[s + 1, high, 1] = share * friction * load * flex
    return bodies, points, slave, master, fixed, u, points[:, 1] ** 2 / (2 * RADIUS), low


def cylinder_fields(points, chosen, pressure, shear, reaction, low, per_half_width):
    """What `hertz_line` and `mindlin_shear` ask for: fields (steps, n) along the row z = 0 of chosen nodes, forces per length."""
    row = np.flatnonzero(chosen & (points[:, 2] < 1e-12))
    row = row[np.argsort(points[row, 1])]
    thickness = 1e-3 / per_half_width
    return {"y": points[row, 1], "pressure": pressure[:, row], "shear": shear[:, row],
            "force": np.abs(reaction[:, low, 0].sum(1)) / thickness, "drag": -reaction[:, low, 1].sum(1) / thickness, "radius": RADIUS,
            "modulus": E / (2 * (1 - NU**2)), "h": thickness, "thickness": thickness}


def cylinder(per_half_width=10, element="hex8i", friction=0.0, path=(), matching=True, **options):
    """Hertz's line contact of two equal cylinders, then a tangential path of the far side [share of full slip travel].

    Returns
    -------
    dict
        y (k,) [m]; pressure and shear that answers the drag (steps, k) [Pa]; force and drag (steps,) [N/m]; radius, h [m]; solution.
    """
    bodies, points, slave, master, fixed, u, gap, low = cylinder_problem(per_half_width, element, friction, path, matching)
    sol = solid.contact(bodies, slave, master, fixed, u, gap=gap, friction=friction,
                        mode="frictional" if friction else "frictionless", element=element, **options)
    return {"solution": sol, **cylinder_fields(points, sol.area > 0, sol.traction[:, :, 0], -sol.traction[:, :, 1], sol.reaction, low, per_half_width)}


def line_errors(run):
    """Errors of the peak and of the pressure field of the first step against Hertz, for the load carried."""
    p, a = run["pressure"][0], np.sqrt(4 * run["force"][0] * run["radius"] / (np.pi * run["modulus"]))
    p0 = 2 * run["force"][0] / (np.pi * a)
    exact = p0 * np.sqrt(np.maximum(0, 1 - (run["y"] / a) ** 2))
    return {"peak": p.max() / p0 - 1, "field": np.sqrt(((p - exact) ** 2).sum() / (exact**2).sum())}


def hertz_line(run):
    """Errors of half-width, peak and pressure field of the first step against Hertz, for the load carried."""
    p, y = run["pressure"][0], run["y"]
    a = np.sqrt(4 * run["force"][0] * run["radius"] / (np.pi * run["modulus"]))
    p0 = 2 * run["force"][0] / (np.pi * a)
    sol = run["solution"]
    return line_errors(run) | {"half_width_m": a, "elements": a / run["h"], "half_width": edge(np.abs(y), p) / a - 1,
            "balance": abs((sol.area * sol.traction[0, :, 0]).sum() / run["thickness"] / run["force"][0] - 1),
            "a": a, "p0": p0, "iterations": iterations(sol)[0]}


def mindlin_shear(y, a, p0, friction, ratios):
    """Shear [Pa] of Cattaneo and Mindlin after turning points Q/(mu P), the last being the present one, on loading from zero.

    `ratios`: [q] loading; [q_max, q] unloading from q_max (Mindlin and Deresiewicz 1953).
    """
    def full(c):
        return friction * p0 * (c / a) * np.sqrt(np.maximum(0, 1 - (y / c) ** 2)) if c > 0 else 0 * y

    q = full(a) - full(a * np.sqrt(1 - ratios[0]))
    if len(ratios) > 1:
        q = q - 2 * (full(a) - full(a * np.sqrt(1 - (ratios[0] - ratios[1]) / 2)))
    return q


def stick_width(y, shear, a, p0, friction, sign=1):
    """Half-width of the stick zone: zero of (mu p - q)^2 fitted over the middle of it."""
    lack = friction * p0 * np.sqrt(np.maximum(0, 1 - (y / a) ** 2)) - sign * shear
    use = (lack > 0.3 * lack.max()) & (np.abs(y) < 0.95 * a)
    c = np.polyfit(y[use] ** 2, lack[use] ** 2, 1)
    return np.sqrt(-c[1] / c[0])


def sphere(per_half_width=10, element="hex8i", far=15.0):
    """Hertz: a rigid sphere on an elastic half-space (a quarter, Boussinesq's displacements far away), given approach.

    Returns
    -------
    dict
        Errors of load, contact radius, peak and pressure field; dof; iterations.
    """
    h, unit, radius, quadratic = 1 / per_half_width, 1e-3, 0.1, element == "hex20r"
    side = unit * fine_then_graded(h, 1.3, far, 1.3)
    depth = -unit * hm.graded(0, far, h, 1.25)[::-1]
    space = hm.block(depth, side, side, quadratic)
    flat = hm.block([0, unit], [0, unit * far], [0, unit * far], quadratic)
    bodies = [solid.Body(space, E, NU), solid.Body(flat, E, NU)]
    points = np.vstack([space.points, flat.points])
    n0, n = len(space.points), len(space.points) + len(flat.points)
    modulus = E / (1 - NU**2)
    approach = unit**2 / radius
    load = 4 / 3 * modulus * np.sqrt(radius) * approach**1.5
    fixed = np.zeros((n, 3), bool)
    fixed[n0:] = True
    fixed[:n0, 1] = space.points[:, 1] < 1e-12
    fixed[:n0, 2] = space.points[:, 2] < 1e-12
    edge_of = (space.points[:, 0] < -unit * far + 1e-12) | (space.points[:, 1:] > unit * far - 1e-12).any(1)
    fixed[:n0][edge_of] = True
    u = np.zeros((n, 3))
    d, r = -space.points[edge_of, 0], np.hypot(space.points[edge_of, 1], space.points[edge_of, 2])  # depth, distance from the axis
    rho = np.hypot(d, r)
    shear = E / (2 * (1 + NU))
    u_r = load / (4 * np.pi * shear) * (r * d / rho**3 - (1 - 2 * NU) * r / (rho * (rho + d)))
    u_d = load / (4 * np.pi * shear) * (d**2 / rho**3 + 2 * (1 - NU) / rho)
    u[:n0][edge_of] = np.c_[-u_d, u_r * space.points[edge_of, 1] / np.maximum(r, 1e-30),
                            u_r * space.points[edge_of, 2] / np.maximum(r, 1e-30)]
    gap = (points[:, 1] ** 2 + points[:, 2] ** 2) / (2 * radius) - approach
    top = np.abs(points[:, 0]) < 1e-12
    sol = solid.contact(bodies, solid.Face(space.facets(top[:n0]), points[:, 1:]),
                        solid.Face(flat.facets(top[n0:]) + n0, points[:, 1:]), fixed, u, gap=gap, mode="frictionless",
                        element=element)
    p = sol.traction[0, :, 0]
    force = 4 * (sol.area * p).sum()
    a = (3 * force * radius / (4 * modulus)) ** (1 / 3)
    p0 = 3 * force / (2 * np.pi * a**2)
    s = np.hypot(points[:, 1], points[:, 2])
    on = sol.area > 0
    exact = p0 * np.sqrt(np.maximum(0, 1 - (s[on] / a) ** 2))
    weight = sol.area[on]
    return {"elements": a / (h * unit), "load": force / load - 1, "radius": edge(s[on], p[on]) / a - 1,
            "peak": p[on][np.argmin(s[on])] / p0 - 1, "field": np.sqrt((weight * (p[on] - exact) ** 2).sum() / (weight * exact**2).sum()),
            "dof": 3 * n0, "iterations": max(iterations(sol)), "r": s[on], "pressure": p[on], "a": a, "p0": p0}


# -- dragged block ---------------------------------------------------------------------------------------------------------
def dragged_rod(cells=100, element="hex8i", friction=0.3):
    """A rod of length 1, height 0.01, Poisson 0, clamped on a rigid flat by an even pressure and dragged at one end to gross
    slip, back, at half the pressure, and forward again. Closed solution: slip runs in from the end, F = sqrt(2 E A mu p b u);
    a reversal follows Masing's rule.

    Returns
    -------
    dict
        travel, force, exact (steps,), where exact is nan if no closed value is known.
    """
    length, height, pressure, quadratic = 1.0, 0.01, 1e8, element == "hex20r"
    rod = hm.block([-height, 0], np.linspace(0, length, cells + 1), [0, height], quadratic)
    flat = hm.block([0, height], [-0.2, length + 0.2], [0, height], quadratic)
    bodies = [solid.Body(rod, E, 0.0), solid.Body(flat, 1e8 * E, 0.0)]
    points = np.vstack([rod.points, flat.points])
    n0, n = len(rod.points), len(points)
    fixed = fixed_z(n)
    fixed[n0:] |= flat.points[:, :1] > height - 1e-12
    top = points[:n0, 0] < -height + 1e-12
    end = points[:n0, 1] > length - 1e-12
    fixed[:n0, 0] = top
    fixed[:n0, 1] = end
    drag = friction * pressure * height           # per length
    full = drag * length**2 / (2 * E * height**2)  # travel at which all slips
    rise = np.linspace(0, 1.2, 13)
    path = [(1.0, t) for t in rise] + [(1.0, 1.2 - t) for t in np.linspace(0.2, 2.6, 13)] + [(0.5, -1.4), (0.5, -1.8)] \
        + [(0.5, -1.8 + t) for t in np.linspace(0.1, 1.2, 12)]
    u = np.zeros((len(path), n, 3))
    for s, (level, travel) in enumerate(path):
        u[s, :n0][top, 0] = level * pressure / E * height
        u[s, :n0][end, 1] = travel * full
    on = np.abs(points[:, 0]) < 1e-12
    sol = solid.contact(bodies, solid.Face(rod.facets(on[:n0]), points[:, 1:]),
                        solid.Face(flat.facets(on[n0:]) + n0, points[:, 1:]), fixed, u, gap=np.zeros(n), friction=friction,
                        element=element, max_slip=np.inf)
    force = sol.reaction[:, :n0][:, end, 1].sum(1)
    limit = drag * length

    def masing(travel, level):  # force after a travel from rest, slip limited
        return level * limit * min(1.0, np.sqrt(travel / level))

    exact = [masing(t, 1) for t in rise] + [limit - 2 * masing(t / 2, 1) for t in np.linspace(0.2, 2.6, 13)]
    exact += [np.nan, -limit / 2] + [-limit / 2 + 2 * masing(t / 2, 0.5) for t in np.linspace(0.1, 1.2, 12)]
    return {"travel": np.array([t for _, t in path]), "force": force / limit, "exact": np.array(exact) / limit, "solution": sol}


# -- pin in a hole -----------------------------------------------------------------------------------------------------------
def half_disc(radius, n, quadratic):
    """Half disc y >= 0, 4 n cells round its edge: a core of squares under two rows of sectors."""
    def side(turn):  # sector between core and circle, quarter pi wide on either side
        m = hm.block(hm.graded(0, 1, 1 / max(2, n // 2), 1.0), np.linspace(-1, 1, 2 * n + 1), [0, 1], quadratic)

        def shape(p):
            angle = p[:, 1] * np.pi / 4
            inner = 0.45 * np.c_[np.ones(len(p)), p[:, 1]]
            outer = np.c_[np.cos(angle), np.sin(angle)]
            q = radius * ((1 - p[:, :1]) * inner + p[:, :1] * outer)
            c, s = np.cos(turn), np.sin(turn)
            return np.c_[q[:, 0] * c - q[:, 1] * s, q[:, 0] * s + q[:, 1] * c, p[:, 2]]
        return m.warp(shape)

    core = hm.block(0.45 * radius * np.linspace(-1, 1, 2 * n + 1), 0.45 * radius * np.linspace(-1, 1, 2 * n + 1), [0, 1], quadratic)
    whole = hm.merge(core, *(side(t) for t in (0, np.pi / 2, np.pi, 3 * np.pi / 2)))
    keep = (whole.points[whole.cells][:, :, 1].min(1) > -1e-9 * radius)
    used, number = np.unique(whole.cells[keep], return_inverse=True)
    return hm.Mesh(whole.points[used], number.reshape(-1, whole.cells.shape[1]))


def pin(n=10, element="hex20r", clearance=0.0, travel=0.0, ratio=1.0, swap=False):
    """A pin in a hole of an infinite plate of the same material, frictionless, pushed by a displacement of its centre (half model).

    `clearance` is the difference of the radii per radius, negative for interference; `ratio` cells of plate per cell of pin.

    Returns
    -------
    dict
        angle (k,) [rad], pressure and exact (k,) [Pa], force Q [N/m], exact_angle [rad], angles of the last closed and the first
        open node, balance of pressure and force, iterations.
    """
    radius, far, quadratic = 0.01, 80.0, element == "hex20r"
    disc = half_disc(radius, n, quadratic)
    m = round(4 * n * ratio)
    r = np.exp(np.linspace(0, np.log(far), max(8, round(m * np.log(far) / np.pi / 1.5)) + 1))
    plate = hm.block(radius * r, np.linspace(0, np.pi, m + 1), [0, 1], quadratic)
    plate = plate.warp(lambda p: np.c_[p[:, 0] * np.cos(p[:, 1]), p[:, 0] * np.sin(p[:, 1]), p[:, 2]])
    for part in (disc, plate):
        part.points[:, 2] *= radius / n
    points = np.vstack([disc.points, plate.points])
    n0, total = len(disc.points), len(points)
    rho, theta = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])
    theta = np.where(theta < -1e-9, np.pi, np.maximum(theta, 0))
    on = np.abs(rho - radius) < 1e-9
    angle = np.where(on, theta + (np.pi if swap else 0), 0.0)
    bodies = [solid.Body(disc, E, NU, angle[:n0]), solid.Body(plate, E, NU, angle[n0:])]
    fixed = fixed_z(total)
    fixed[np.abs(points[:, 1]) < 1e-12, 1] = True
    fixed[rho > radius * far * (1 - 1e-9), :2] = True
    centre = rho[:n0] < 1e-9
    fixed[:n0][centre, 0] = True
    u = np.zeros((total, 3))
    u[:n0][centre, 0] = travel * radius
    gap = clearance * radius * (1 - np.cos(theta)) if clearance > 0 else np.full(total, clearance * radius)
    chart = np.c_[radius * theta, points[:, 2]]
    faces = [solid.Face(disc.facets(on[:n0]), chart), solid.Face(plate.facets(on[n0:]) + n0, chart)]
    if swap:
        faces.reverse()
    sol = solid.contact(bodies, *faces, fixed, u, gap=gap, mode="frictionless", element=element)
    row = np.flatnonzero((sol.area > 0) & (points[:, 2] < 1e-12))
    row = row[np.argsort(theta[row])]
    thickness = radius / n
    q = abs(2 * sol.reaction[0, :n0][centre, 0].sum() / thickness)
    p = sol.traction[0, row, 0]
    half = persson_angle(E / (1 - NU**2) * clearance * radius / q)
    closed = theta[row][p > 0].max()
    return {"angle": theta[row], "pressure": p, "closed_to": closed, "next": np.append(theta[row][theta[row] > closed + 1e-9], np.pi)[0], "force": q, "exact_angle": half,
            "exact": persson_pressure(theta[row], half, q, radius, E / (1 - NU**2) * clearance),
            "balance": abs(2 * (sol.area * sol.traction[0, :, 0] * np.cos(theta)).sum() / thickness / q - 1),
            "iterations": max(iterations(sol)), "radius": radius}


def persson_angle(parameter):
    """Half-angle of contact [rad] for E' dR / Q (Persson 1964; Ciavarella and Decuzzi 2001, equal materials); pi if all touches.

    E' dR / Q = (2 - ln(b^2 + 1) - 2 b^4) / (pi b^2 (b^2 + 1)), b = tan(half-angle / 2).
    """
    if parameter <= -2 / np.pi:
        return np.pi
    low, high = 1e-3, np.pi - 1e-6
    while high - low > 1e-14:
        x = (low + high) / 2
        b = np.tan(x / 2)
        if (2 - np.log(b**2 + 1) - 2 * b**4) / (np.pi * b**2 * (b**2 + 1)) > parameter:  # falls with the angle
            low = x
        else:
            high = x
    return (low + high) / 2


def persson_pressure(theta, half, q, radius, strain_modulus):
    """Pressure [Pa] at angles theta; where all touches, p = -E' dR / (2 R) + Q cos(theta) / (pi R)."""
    if half >= np.pi:
        return -strain_modulus / 2 + q * np.cos(theta) / (np.pi * radius)
    b, y = np.tan(half / 2), np.tan(np.minimum(theta, half) / 2)
    s, t = np.sqrt(b**2 + 1), np.sqrt(np.maximum(0, b**2 - y**2))
    return q / radius * (2 / (np.pi * s) * t / (1 + y**2) + np.log((s + t) / (s - t)) / (2 * np.pi * b**2 * (1 + b**2)))


# -- press fit -----------------------------------------------------------------------------------------------------------------
def two_rings(inner, outer, element, layers=3, start=0.0):
    """Rings 10-20-30 mm with given divisions, cylindrical dofs, plane strain: bodies, faces, radius and angle of all nodes, period."""
    quadratic, bodies, polar = element == "hex20r", [], []
    for k, (divisions, r1, r2) in enumerate(((inner, 10e-3, 20e-3), (outer, 20e-3, 30e-3))):
        m = hm.block(np.linspace(r1, r2, layers + 1), start * k + np.linspace(0, 2 * np.pi, divisions + 1), [0, 2e-3], quadratic)
        m = hm.merge(m.warp(lambda p: np.c_[p[:, 0] * np.cos(p[:, 1]), p[:, 0] * np.sin(p[:, 1]), p[:, 2]]))
        theta = np.arctan2(m.points[:, 1], m.points[:, 0])
        bodies.append(solid.Body(m, *((210e9, 0.3) if k == 0 else (110e9, 0.25)), theta))
        polar.append(np.c_[np.hypot(m.points[:, 0], m.points[:, 1]), theta, m.points[:, 2]])
    polar = np.vstack(polar)
    n0 = len(bodies[0].mesh.points)
    on = np.abs(polar[:, 0] - 20e-3) < 1e-9
    chart = np.c_[20e-3 * polar[:, 1], polar[:, 2]]
    faces = [solid.Face(bodies[0].mesh.facets(on[:n0]), chart), solid.Face(bodies[1].mesh.facets(on[n0:]) + n0, chart)]
    return bodies, faces, polar, 2 * np.pi * 20e-3


def lame_problem(inner, outer, element, layers=3, start=0.3):
    """Bodies, faces, polar coordinates, period and supports of Lame's press fit."""
    bodies, faces, polar, period = two_rings(inner, outer, element, layers, start)
    fixed = fixed_z(len(polar))
    n0 = len(bodies[0].mesh.points)
    fixed[:n0][polar[:n0, 0] < 10e-3 + 1e-9, 1] = True
    fixed[n0:][polar[n0:, 0] > 30e-3 - 1e-9, 1] = True
    return bodies, faces, polar, period, fixed


def lame_exact(interference):
    """Pressure [Pa] and radial displacements of inner and outer ring at the interface [m]."""
    a, b, c = 10e-3, 20e-3, 30e-3
    e1, n1, e2, n2 = 210e9 / (1 - 0.3**2), 0.3 / 0.7, 110e9 / (1 - 0.25**2), 0.25 / 0.75
    f1, f2 = b / e1 * ((b**2 + a**2) / (b**2 - a**2) - n1), b / e2 * ((c**2 + b**2) / (c**2 - b**2) + n2)
    p = interference / (f1 + f2)
    return p, -p * f1, p * f2


def lame(inner, outer, element, layers=3, swap=False, interference=10e-6, start=0.3):
    """Lame's press fit: errors of pressure and radial displacement at the interface, mean and worst point."""
    bodies, faces, polar, period, fixed = lame_problem(inner, outer, element, layers, start)
    if swap:
        faces.reverse()
        for b in bodies:
            b.angle = b.angle + np.pi
    n0 = len(bodies[0].mesh.points)
    sol = solid.contact(bodies, *faces, fixed, gap=np.full(len(polar), -interference), mode="frictionless", element=element,
                        period=period, tolerance=1e-12)
    exact, inward, outward = lame_exact(interference)
    on = sol.area > 0
    p = sol.traction[0, on, 0]
    sign = -1 if swap else 1
    face = np.flatnonzero(np.abs(polar[:, 0] - 20e-3) < 1e-9)
    wrong = sign * sol.u[0, face, 0] / np.where(face < n0, inward, outward) - 1
    mean = (sol.area[on] * p).sum() / sol.area[on].sum()
    return {"pressure_mean": mean / exact - 1, "pressure_worst": np.abs(p / exact - 1).max(),
            "displacement_mean": np.mean(wrong), "displacement_worst": np.abs(wrong).max(), "displacement_rms": np.sqrt(np.mean(wrong**2)),
            "unevenness": np.ptp(p) / exact, "pressure": exact, "iterations": max(iterations(sol))}


def holding_torque(inner, outer, element, friction=0.15, interference=10e-6):
    """Torque of the press fit when the outer ring is turned: reactions over the friction of Lame's pressure, and of the measured one."""
    bodies, faces, polar, period = two_rings(inner, outer, element, 3, 0.3)
    n = len(polar)
    fixed = fixed_z(n)
    inside, outside = polar[:, 0] < 10e-3 + 1e-9, polar[:, 0] > 30e-3 - 1e-9
    fixed[inside | outside, 1] = True
    u = np.zeros((6, n, 3))
    u[:, outside, 1] = 5e-6 * np.arange(6)[:, None]
    sol = solid.contact(bodies, *faces, fixed, u, gap=np.full(n, -interference), friction=friction, element=element, period=period)
    torque = (sol.reaction[:, outside, 1] * polar[outside, 0]).sum(1)
    b = 20e-3
    exact = lame_exact(interference)[0]
    capacity = friction * exact * 2 * np.pi * b**2 * 2e-3
    return {"torque": torque, "capacity": capacity, "error": torque[-1] / capacity - 1,
            "own": torque[-1] / (friction * b * (sol.area * sol.traction[-1, :, 0]).sum()) - 1,
            "slipping": bool((sol.state[-1, sol.area > 0] == 2).all())}


def rows():
    """All rows of the problem: errors against the formulas."""
    line, ball, rod = hertz_line(cylinder(10)), sphere(10), dragged_rod(200)
    slip = cylinder(20, friction=0.3, path=(0.5, 1.1))
    h, ratio = hertz_line(slip), slip["drag"] / (0.3 * slip["force"])
    stick = [stick_width(slip["y"], slip["shear"][s], h["a"], h["p0"], 0.3) / h["a"] / np.sqrt(1 - ratio[s]) - 1 for s in (1, 2)]
    full = np.sqrt(((0.3 * h["p0"]) ** 2 * np.maximum(0, 1 - (slip["y"] / h["a"]) ** 2)).sum())
    field = [np.sqrt(((slip["shear"][s] - mindlin_shear(slip["y"], h["a"], h["p0"], 0.3, [ratio[s]])) ** 2).sum()) / full for s in (1, 2)]
    hole = pin(10, "hex20r", 1e-3, 4e-3, 1.3)
    fits = {"hex20r, 3 layers": lame(80, 64, "hex20r"), "hex8i, 6 layers": lame(80, 64, "hex8i", 6), "hex8i, 3 layers": lame(80, 64, "hex8i")}
    found = [("Hertz, line, 10 cells: half-width", line["half_width"], 0.01), ("Hertz, line, 10 cells: peak", line["peak"], 0.01)]
    found += [(f"Hertz, sphere, 10 cells: {k}", ball[k], 0.01) for k in ("load", "radius", "peak")]
    found += [("Cattaneo and Mindlin, 20 cells: width of stick", max(stick, key=abs), 0.02),
              ("Cattaneo and Mindlin, 20 cells: field of the shear", max(field), 0.02),
              ("rod dragged to gross slip and back: force", np.nanmax(np.abs(rod["force"] - rod["exact"])), 0.01),
              ("pin in a hole (Persson), hex20r: peak", hole["pressure"].max() / hole["exact"].max() - 1, 0.01)]
    found += [(f"press fit of two rings (Lamé), worst pressure: {name}", fit["pressure_worst"], 0.005) for name, fit in fits.items()]
    found += [(f"the same turned to gross slip, torque: {e}", holding_torque(80, 64, e)["error"], 0.005) for e in ("hex20r", "hex8i")]
    return [Row(quantity, "-", 1.0, 1 + float(error), tolerance) for quantity, error, tolerance in found]
