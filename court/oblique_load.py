# SPDX-License-Identifier: GPL-3.0-or-later
"""Cylinders under a growing load and a growing shear at once, then under shear alone (Mindlin and Deresiewicz 1953; Jaeger 1998)."""
import numpy as np

from bodies import MM, Row, blocks_in_line_contact
from hdengine import solid

SOURCE = "K. L. Johnson, Contact Mechanics, ch. 7; J. Jaeger, Arch. Appl. Mech. 68 (1998) 478: no slip while dQ < mu dP"


def solve(per_half_width=12, friction=0.3, growing=12, shearing=4):
    """Errors of the shear field (root mean square over mu times the peak pressure) after oblique loading and after partial slip."""
    young, poisson, radius, h = 200e9, 0.3, 0.1, MM / per_half_width
    bodies, slave, master, points, fixed, low, high = blocks_in_line_contact(per_half_width, young, poisson)
    depth = 22e-6
    travel = np.concatenate([np.linspace(1 / growing, 1, growing), np.ones(shearing)])
    # the shear's compliance is about the load's: half of mu while the load grows, towards mu afterwards
    shear = np.concatenate([0.5 * friction * np.linspace(1 / growing, 1, growing), friction * np.linspace(0.6, 0.85, shearing)])
    u = np.zeros((len(travel), len(points), 3))
    u[:, high, 0] = -depth * travel[:, None]
    u[:, high, 1] = depth * shear[:, None]
    result = solid.contact(bodies, slave, master, fixed, u, gap=points[:, 1] ** 2 / (2 * radius), friction=friction)
    row = np.flatnonzero((result.area > 0) & (points[:, 2] < 1e-12))
    row = row[np.argsort(points[row, 1])]
    y = points[row, 1]
    load = np.abs(result.reaction[:, low, 0].sum(1)) / h
    drag = np.abs(result.reaction[:, low, 1].sum(1)) / h
    modulus = young / (2 * (1 - poisson**2))
    half = np.sqrt(4 * load * radius / (np.pi * modulus))

    def pressure(a):
        return np.sqrt(np.maximum(a * a - y * y, 0)) * modulus / (2 * radius)

    def stuck(last):   # q = int dQ / (pi sqrt(a^2 - y^2)) over a contact that only grew, dQ/da linear between the steps of the run
        a = np.concatenate([[0], half[:last + 1]])
        q = np.concatenate([[0], drag[:last + 1]])
        field = np.zeros_like(y)
        for i in range(last + 1):
            slope = (q[i + 1] - q[i]) / (a[i + 1] ** 2 - a[i] ** 2)   # per a^2, as the load goes with it
            high_part = np.sqrt(np.maximum(a[i + 1] ** 2 - y * y, 0))
            low_part = np.sqrt(np.maximum(a[i] ** 2 - y * y, 0))
            field += 2 * slope / np.pi * (high_part - low_part)
        return field

    peak = friction * half * modulus / (2 * radius)
    ours = np.abs(result.traction[:, row, 1])
    use = slice(None)
    oblique = np.sqrt(np.mean((ours[growing - 1] - stuck(growing - 1))[use] ** 2)) / peak[growing - 1]
    slipping = result.state[growing - 1, row][result.traction[growing - 1, row, 0] > 0.05 * result.traction[growing - 1, row, 0].max()]
    worst = 0.0
    for s in range(growing, len(travel)):   # slip from c to a: Q = Q(c) + mu (P - P(c)), as if the load had grown with full slip since
        limit = np.interp(drag[s] - friction * load[s], (drag - friction * load)[:growing][::-1], np.arange(growing)[::-1])
        k = int(np.floor(limit))
        share = limit - k
        c = np.sqrt((1 - share) * half[k] ** 2 + share * half[min(k + 1, growing - 1)] ** 2)
        inner = (1 - share) * stuck(k) + share * stuck(min(k + 1, growing - 1))
        want = inner + friction * (pressure(half[s]) - pressure(c))
        worst = max(worst, np.sqrt(np.mean((ours[s] - want) ** 2)) / peak[s])
    return {"oblique": oblique, "partial": worst, "slipping": float(np.mean(slipping == 2)), "ratio": drag / (friction * load)}


def rows():
    """All rows of the problem."""
    r = solve()
    return [Row("shear after oblique loading, rms over mu p0", "-", 0.0, r["oblique"], 0.02, f"Q = {r['ratio'][11]:.2f} mu P"),
            Row("shear in partial slip after it, rms over mu p0", "-", 0.0, r["partial"], 0.03, f"Q up to {r['ratio'][-1]:.2f} mu P"),
            Row("share of points that slip while the load grows", "-", 0.0, r["slipping"], 0.05, "none in theory; edge points of the mesh")]
