#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Elements of hdengine beside those of CalculiX: same meshes, supports and nodal forces, one run.

Needs the Debian package calculix-ccx. Writes bench/results/elements.json; --quick takes the first cases and writes nothing.
Usage: bench/elements.py [--quick]
"""
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from common import measured, program, read_prints, write_record
from hdengine import mesh as hm
from hdengine import solid
from hdengine.export.cards import body_cards, node_cards

OURS = ("hex8", "hex8i", "hex20r")
PEERS = ("C3D8", "C3D8I", "C3D20R")


@dataclass
class Case:
    """A linear problem: mesh, material, supports, nodal forces, the displacement looked at and its reference."""

    name: str
    size: str
    mesh: hm.Mesh
    young: float
    poisson: float
    fixed: np.ndarray   # (n, 3)
    force: np.ndarray   # (n, 3)
    probe: np.ndarray   # (n, 3): result = sum(probe * u)
    exact: float


# -- loads ------------------------------------------------------------------------------------------------------------
def shapes(xi, eta, nodes):
    """Shape functions (nodes) and their two derivatives on a facet."""
    c = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    a, b = 1 + xi * c[:, 0], 1 + eta * c[:, 1]
    n, dx, de = a * b / 4, c[:, 0] * b / 4, a * c[:, 1] / 4
    if nodes == 4:
        return n, dx, de
    s = xi * c[:, 0] + eta * c[:, 1] - 1
    n, dx, de = n * s, dx * s + n * c[:, 0], de * s + n * c[:, 1]
    m = [(1 - xi**2) * (1 - eta) / 2, (1 - eta**2) * (1 + xi) / 2, (1 - xi**2) * (1 + eta) / 2, (1 - eta**2) * (1 - xi) / 2]
    mx = [-xi * (1 - eta), (1 - eta**2) / 2, -xi * (1 + eta), -(1 - eta**2) / 2]
    me = [-(1 - xi**2) / 2, -eta * (1 + xi), (1 - xi**2) / 2, -eta * (1 - xi)]
    return np.r_[n, m], np.r_[dx, mx], np.r_[de, me]


def surface_force(mesh, facets, traction):
    """Consistent nodal forces (n, 3) of a traction, a function of points (k, 3)."""
    f = np.zeros_like(mesh.points)
    g, w = np.polynomial.legendre.leggauss(4)
    x = mesh.points[facets]
    for i, xi in enumerate(g):
        for j, eta in enumerate(g):
            n, dx, de = shapes(xi, eta, facets.shape[1])
            area = np.linalg.norm(np.cross(np.einsum("a,kac->kc", dx, x), np.einsum("a,kac->kc", de, x)), axis=1)
            t = traction(np.einsum("a,kac->kc", n, x)) * (w[i] * w[j] * area)[:, None]
            np.add.at(f, facets, n[None, :, None] * t[:, None, :])
    return f


def line_weights(mesh, chosen, axis):
    """Shares of a line load that the nodes of a straight row of edges take (sum 1)."""
    nodes = np.flatnonzero(chosen)
    order = nodes[np.argsort(mesh.points[nodes, axis])]
    w = np.zeros(len(mesh.points))
    t = mesh.points[order, axis]
    if mesh.quadratic:
        for a in range(0, len(order) - 1, 2):
            w[order[a:a + 3]] += (t[a + 2] - t[a]) * np.array([1, 4, 1]) / 6
    else:
        for a in range(len(order) - 1):
            w[order[a:a + 2]] += (t[a + 1] - t[a]) / 2
    return w / w.sum()


# -- closed solutions -------------------------------------------------------------------------------------------------
def harmonic(n, r1, r2, young, poisson, outside):
    """Radial displacement of the inner face per cos(n theta), n >= 2, under an outward traction cos(n theta) on one face;
    plane strain (Michell 1899)."""
    k = np.array([n, n + 2, -n, 2 - n], float)
    rows = []
    for r in (r1, r2):
        s = (r / r2) ** (k - 2)
        rows += [(k - n**2) * s, n * (k - 1) * s]
    right = np.zeros(4)
    right[2 if outside else 0] = 1 if outside else -1  # sigma_r: outward traction is -sigma_r inside
    scale = np.abs(rows).max(0)
    a = np.linalg.solve(np.array(rows) / scale, right) / scale
    kappa = 3 - 4 * poisson
    u = np.array([-n, kappa - n - 1, n, kappa + n - 1]) * (r1 / r2) ** (k - 1) * r2
    return (1 + poisson) / young * (a @ u)


def opposite_forces(r1, r2, young, poisson):
    """Radial displacement of the inner face at 90 degrees under two outward unit forces per length on the outer face at 0 and 180."""
    e = young / (1 - poisson**2)
    p = 1 / (np.pi * r2)
    b = p * r2**2 / (r2**2 - r1**2)  # Lame: sigma = b (1 -+ r1^2 / r^2)
    u = b / e * 2 * r1  # at a free inner face only the hoop stress strains
    return u + sum(2 * p * np.cos(n * np.pi / 2) * harmonic(n, r1, r2, young, poisson, True) for n in range(2, 400, 2))


def shell_cup(radius, t, length, young, poisson, n=2, terms=50):
    """Radial displacement of the mouth per cos(n theta) of a tube clamped at its other end, under a radial line load cos(n theta) at
    the mouth: thin-shell theory of Sanders and Koiter, by Ritz's method with Legendre polynomials."""
    from numpy.polynomial import Legendre
    x, w = np.polynomial.legendre.leggauss(3 * terms)
    s, w = (x + 1) / 2, w / 2 * length

    def table(power):  # s^power P_k and two derivatives by the axial coordinate
        rows = []
        for k in range(terms):
            p = Legendre.basis(k, domain=[0, 1])
            f = p * Legendre.fromroots([0] * power, domain=[0, 1]) if power else p
            rows.append([f(s), f.deriv()(s) / length, f.deriv(2)(s) / length**2, f(1.0)])
        return rows

    u, v, w_ = table(1), table(1), table(2)
    zero = np.zeros((terms, len(s)))
    f = {name: [np.array([row[i] for row in rows]) for i in range(3)] for name, rows in (("u", u), ("v", v), ("w", w_))}
    r = radius
    strain = [  # rows: coefficients of (U, V, W)
        [f["u"][1], zero, zero],
        [zero, n * f["v"][0] / r, f["w"][0] / r],
        [-n * f["u"][0] / r, f["v"][1], zero],
        [zero, zero, -f["w"][2]],
        [zero, n * f["v"][0] / r**2, n**2 * f["w"][0] / r**2],
        [n * f["u"][0] / (2 * r**2), 1.5 * f["v"][1] / r, 2 * n * f["w"][1] / r]]
    strain = [np.vstack(row) for row in strain]
    a, k = young * t / (1 - poisson**2), np.zeros((3 * terms, 3 * terms))
    for first, c in ((0, a), (3, a * t**2 / 12)):
        e1, e2, g = strain[first:first + 3]
        k += c * ((e1 * w) @ e1.T + (e2 * w) @ e2.T + poisson * ((e1 * w) @ e2.T + (e2 * w) @ e1.T) + (1 - poisson) / 2 * (g * w) @ g.T)
    load = np.concatenate([np.zeros(2 * terms), [row[3] for row in w_]])
    scale = 1 / np.sqrt(np.diag(k))
    return load @ (scale * np.linalg.solve(scale[:, None] * k * scale, scale * load))


# -- cases ------------------------------------------------------------------------------------------------------------
def beam(name, size, mesh, young, poisson, root, tip, direction, exact):
    """Cantilever with a unit force spread over its end."""
    facets = mesh.facets(tip)
    area = surface_force(mesh, facets, lambda x: np.ones_like(x))[:, 0].sum()
    force = surface_force(mesh, facets, lambda x: np.broadcast_to(np.asarray(direction, float) / area, x.shape))
    return Case(name, size, mesh, young, poisson, np.repeat(root[:, None], 3, 1), force, force, exact)


def straight(quadratic, tilt, shape):
    """MacNeal and Harder (1985): 6 x 0.2 x 0.1, six cells whose edges lean."""
    m = hm.block(np.linspace(0, 6, 7), [-0.1, 0.1], [-0.05, 0.05], quadratic)
    x = m.points.copy()
    x[:, 0] += np.interp(m.points[:, 0], np.arange(7), tilt) * m.points[:, 1]
    m = hm.Mesh(x, m.cells)
    return beam(f"straight beam, {shape}, in plane", "6x1x1", m, 1e7, 0.3, x[:, 0] < 1e-9, x[:, 0] > 6 - 1e-9, (0, 1, 0), 0.1081)


def twisted(quadratic, n, out):
    """MacNeal and Harder: 12 x 1.1 x 0.32, twisted by 90 degrees."""
    m = hm.block(np.linspace(0, 12, n[0] + 1), np.linspace(-0.55, 0.55, n[1] + 1), np.linspace(-0.16, 0.16, n[2] + 1), quadratic)
    s = m.points[:, 0].copy()
    c, d = np.cos(s * np.pi / 24), np.sin(s * np.pi / 24)
    m = m.warp(lambda p: np.c_[p[:, 0], p[:, 1] * c - p[:, 2] * d, p[:, 1] * d + p[:, 2] * c])
    # the width points along z at the tip: a force along z is in its plane
    return beam(f"twisted beam, {'out of' if out else 'in'} plane", "x".join(map(str, n)), m, 29e6, 0.22, s < 1e-9, s > 12 - 1e-9,
                (0, 1, 0) if out else (0, 0, 1), 0.001754 if out else 0.005424)


def quarter(radii, cells, along, quadratic):
    """Quarter of a tube, symmetric at both ends: mesh, nodes in radius, angle and length, what is held."""
    m = hm.block(radii, np.linspace(0, np.pi / 2, cells + 1), along, quadratic)
    q = m.points.copy()
    m = m.warp(lambda p: np.c_[p[:, 0] * np.cos(p[:, 1]), p[:, 0] * np.sin(p[:, 1]), p[:, 2]])
    fixed = np.zeros(q.shape, bool)
    fixed[q[:, 1] < 1e-9, 1] = True
    fixed[q[:, 1] > np.pi / 2 - 1e-9, 0] = True
    return m, q, fixed


def pinched(quadratic, n):
    """Pinched cylinder with end diaphragms, one eighth: R 300, L 600, t 3; deep-shell solution 1.8248e-5 (Belytschko 1985)."""
    m, q, fixed = quarter([298.5, 301.5], n, np.linspace(0, 300, n + 1), quadratic)
    fixed[q[:, 2] < 1e-9, 2] = True                     # middle of the length
    fixed[q[:, 2] > 300 - 1e-9, :2] = True              # diaphragm
    at = (q[:, 1] < 1e-9) & (q[:, 2] < 1e-9)
    force = np.zeros(q.shape)
    force[:, 0] = -0.25 * line_weights(m, at, 0)
    return Case("pinched cylinder", f"{n}x{n}", m, 3e6, 0.3, fixed, force, 4 * force, 1.8248e-5)


def quarter_ring(quadratic, t, divisions):
    """Quarter of a ring, one cell through thickness and height, plane strain; radii in mm."""
    m, q, fixed = quarter([17.8, 17.8 + t], divisions // 4, [0, 1.0], quadratic)
    fixed[:, 2] = True
    return m, q, fixed


def ring_harmonic(quadratic, t, divisions):
    """Radial traction cos 2 theta on the inner face; displacement of that face at theta = 0."""
    m, q, fixed = quarter_ring(quadratic, t, divisions)
    inner = m.facets(q[:, 0] < 17.8 + 1e-9)

    def traction(x):
        r = np.hypot(x[:, 0], x[:, 1])
        return ((x[:, 0]**2 - x[:, 1]**2) / r**3)[:, None] * x * [1, 1, 0]

    probe = np.zeros(q.shape)
    probe[:, 0] = line_weights(m, (q[:, 0] < 17.8 + 1e-9) & (q[:, 1] < 1e-9), 2)
    return Case(f"ring t = {t} mm, cos 2 theta", str(divisions), m, 210e3, 0.3, fixed, surface_force(m, inner, traction), probe,
                harmonic(2, 17.8, 17.8 + t, 210e3, 0.3, False))


def ring_forces(quadratic, t, divisions):
    """Two opposite outward forces of 1 N/mm on the outer face; radial displacement of the inner face at 90 degrees."""
    m, q, fixed = quarter_ring(quadratic, t, divisions)
    force, probe = np.zeros(q.shape), np.zeros(q.shape)
    force[:, 0] = 0.5 * line_weights(m, (q[:, 0] > 17.8 + t - 1e-9) & (q[:, 1] < 1e-9), 2)
    probe[:, 1] = line_weights(m, (q[:, 0] < 17.8 + 1e-9) & (q[:, 1] > np.pi / 2 - 1e-9), 2)
    return Case(f"ring t = {t} mm, two forces", str(divisions), m, 210e3, 0.3, fixed, force, probe,
                opposite_forces(17.8, 17.8 + t, 210e3, 0.3))


def cup(quadratic, divisions, facets):
    """Tube 17.8 x 0.3 x 20 mm clamped at its end, radial load cos 2 theta of 1 N/mm at its mouth; one cell through the wall."""
    r, t, length = 17.8, 0.3, 20.0
    m, q, fixed = quarter([r - t / 2, r + t / 2], divisions // 4, np.linspace(0, length, facets + 1), quadratic)
    fixed[q[:, 2] > length - 1e-9] = True

    def traction(x):  # 1 N/mm of middle line over the thickness
        radius = np.hypot(x[:, 0], x[:, 1])
        return ((x[:, 0]**2 - x[:, 1]**2) / radius**3 * r / (radius * t))[:, None] * x * [1, 1, 0]

    probe = np.zeros(q.shape)
    probe[:, 0] = line_weights(m, (q[:, 2] < 1e-9) & (q[:, 1] < 1e-9), 0)
    return Case("cup, cos 2 theta at its mouth", f"{divisions}x{facets}", m, 210e3, 0.3, fixed,
                surface_force(m, m.facets(q[:, 2] < 1e-9), traction), probe, shell_cup(r, t, length, 210e3, 0.3))


CASES = (lambda q: straight(q, np.zeros(7), "rectangles"), lambda q: straight(q, [0, 1, -1, 1, -1, 1, 0], "trapezoids"), lambda q: twisted(q, (24, 4, 2), False),
         lambda q: ring_harmonic(q, 0.3, 80), lambda q: pinched(q, 32), lambda q: cup(q, 120, 24))


# -- solving ----------------------------------------------------------------------------------------------------------
def calculix(case, element, folder):
    """Displacements (n, 3) by CalculiX and the CPU time of the process [s]."""
    ours = OURS[PEERS.index(element)]
    lines = [*node_cards(case.mesh.points, "ALL"), *body_cards("E", range(len(case.mesh.cells)), case.mesh.cells, ours, case.young, case.poisson), "*BOUNDARY"]
    lines += [f"{i + 1},{d + 1},{d + 1}" for i, d in np.argwhere(case.fixed)]
    lines += ["*STEP", "*STATIC", "*CLOAD"]
    lines += [f"{i + 1},{d + 1},{case.force[i, d]:.12g}" for i, d in np.argwhere((case.force != 0) & ~case.fixed)]
    lines += ["*NODE PRINT, NSET=ALL", "U", "*END STEP"]
    (folder / "case.inp").write_text("\n".join(lines) + "\n")
    done = measured(["ccx", "-i", "case"], folder)
    u = np.zeros(case.mesh.points.shape)
    for n, v in read_prints(folder / "case.dat")[-1][1].items():
        u[n] = v
    return u, done.cpu_s


def engine(case, element):
    """Displacements (n, 3) by hdengine and the CPU time of the call [s]."""
    start = time.process_time()
    u = solid.static([solid.Body(case.mesh, case.young, case.poisson)], case.fixed, force=case.force, element=element)
    return u, time.process_time() - start


def patch(element):
    """MacNeal-Harder patch of seven distorted cells under prescribed linear displacements: worst error of the inner nodes."""
    inner = [[.249, .342, .192], [.826, .288, .288], [.850, .649, .263], [.273, .750, .230],
             [.320, .186, .643], [.677, .305, .683], [.788, .693, .644], [.165, .745, .702]]
    outer = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    points = np.array(outer + inner, float)
    cells = [list(range(8, 16))]
    for f in hm._FACES:
        cells.append([f[0], f[1], f[2], f[3], *(f[k] + 8 for k in range(4))])
    cells = np.array(cells)
    x = points[cells]
    volume = np.einsum("kc,kc->k", np.cross(x[:, 1] - x[:, 0], x[:, 3] - x[:, 0]), x[:, 4] - x[:, 0])
    cells[volume < 0] = cells[volume < 0][:, [0, 3, 2, 1, 4, 7, 6, 5]]
    if element == "hex20r":
        middles = (points[cells[:, hm._EDGES[:, 0]]] + points[cells[:, hm._EDGES[:, 1]]]) / 2
        m = hm.merge(hm.Mesh(np.vstack([points[cells].reshape(-1, 3), middles.reshape(-1, 3)]),
                             np.hstack([np.arange(56).reshape(7, 8), 56 + np.arange(84).reshape(7, 12)])))
    else:
        m = hm.Mesh(points, cells)
    gradient = 1e-3 * np.array([[1, 0.5, 0.2], [-0.3, -0.4, 0.7], [0.6, 0.1, 0.8]])
    exact = m.points @ gradient.T
    edge = (np.abs(m.points - 0.5) > 0.5 - 1e-9).any(1)
    u = solid.static([solid.Body(m, 1e6, 0.25)], np.repeat(edge[:, None], 3, 1), exact, element=element)
    return float(np.abs(u - exact).max() / np.abs(exact).max())


def main(quick):
    """Every case by our elements and the like of the default."""
    ccx, rows = program("ccx", "apt-get install calculix-ccx"), []
    for make in CASES[:4] if quick else CASES:
        pair = {q: make(q) for q in (False, True)}
        for e in (*OURS, "C3D8I"):
            case = pair[e == "hex20r"]
            with tempfile.TemporaryDirectory() as folder:
                u, _ = engine(case, e) if e in OURS else calculix(case, e, Path(folder))
            error = 100 * (abs((case.probe * u).sum()) / abs(case.exact) - 1)
            rows.append({"case": case.name, "mesh": case.size, "element": e, "error_percent": float(f"{error:.3g}")})
            print(rows[-1], flush=True)
    if not quick:
        version = subprocess.run([ccx, "-v"], capture_output=True, text=True).stdout.strip()
        write_record("elements", {"calculix": version, "rows": rows})


if __name__ == "__main__":
    main("--quick" in sys.argv)
