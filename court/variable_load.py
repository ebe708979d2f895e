# SPDX-License-Identifier: GPL-3.0-or-later
"""A loop of shear between cylinders under a load that rises and falls with it (Mindlin and Deresiewicz 1953; Jaeger 1998)."""
import numpy as np

from bodies import MM, Row, blocks_in_line_contact
from hdengine import solid

SOURCE = ("R. D. Mindlin, H. Deresiewicz, J. Appl. Mech. 20 (1953) 327; J. Jaeger, Arch. Appl. Mech. 68 (1998) 478: "
          "contact as a stack of flat punches, each with its own load and shear")


def stack(half_widths, drags, friction, modulus, radius, cells=4000, between=20):
    """Shear of each step as a function of the place, by Jaeger's superposition of plane flat punches.

    A punch of half-width s carries the load phi ds = pi modulus s / (2 radius) ds and at most mu of it as shear. A falling load takes punches off the
    outside with what they carry. A rising load adds some. Whatever shear is then missing goes to the new ones alone where they can bear it
    (no slip), else to the limit from the outside inwards.
    """
    s = (np.arange(cells) + 0.5) / cells * max(half_widths) * 1.001
    limit = friction * np.pi * modulus * s / (2 * radius) * (s[1] - s[0])
    chi, fields, a_old, a_last, q_old = np.zeros(cells), [], 0.0, 0.0, 0.0
    for a_end, q_end in zip(half_widths, drags):
        for share in np.arange(1, between + 1) / between:
            a = np.sqrt((1 - share) * a_old**2 + share * a_end**2)     # load and shear go along a straight line
            inside, new = s < a, (s < a) & (s >= a_last)
            chi[~inside] = 0
            missing = (1 - share) * q_old + share * q_end - chi.sum()
            if new.any() and abs(missing) <= limit[new].sum():
                chi[new] = limit[new] * missing / limit[new].sum()
            else:
                sign = np.sign(missing)
                room = (sign * limit - chi)[inside][::-1]
                filled = np.cumsum(np.abs(room))
                take = np.clip((abs(missing) - (filled - np.abs(room))) / np.maximum(np.abs(room), 1e-300), 0, 1)
                chi[inside] += (take * room)[::-1]
            a_last = a
        fields.append(chi.copy())
        a_old, q_old = a_end, q_end

    def at(step, y):   # the punch's shear is chi / (pi sqrt(s^2 - y^2)); averaged over the ring of s that the cell stands for
        ds = s[1] - s[0]
        outer, inner = (np.sqrt(np.maximum((s + k * ds / 2) ** 2 - y[:, None] ** 2, 0)) for k in (1, -1))
        return (fields[step] / (s * ds) * (outer - inner)).sum(1) / np.pi
    return at


def solve(per_half_width=12, friction=0.3, phase=4):
    """Root mean square error of the shear over mu times the peak pressure, by step of the loop, and shear over the limit."""
    young, poisson, radius, h = 200e9, 0.3, 0.1, MM / per_half_width
    bodies, slave, master, points, fixed, low, high = blocks_in_line_contact(per_half_width, young, poisson)
    # load rises alone, shear rises, load falls while shear turns back, both rise again, shear turns under even load
    corners = np.array([(0, 0), (1, 0), (1, 0.6), (0.7, 0.0), (1.1, -0.4), (0.9, 0.3), (0.9, -0.5)])
    steps = np.concatenate([np.linspace(a, b, 2 * phase + 1)[1:] for a, b in zip(corners[:-1], corners[1:])])
    u = np.zeros((len(steps), len(points), 3))
    depth = 22e-6
    u[:, high, 0] = -depth * steps[:, :1]
    u[:, high, 1] = depth * friction * steps[:, 1:]
    result = solid.contact(bodies, slave, master, fixed, u, gap=points[:, 1] ** 2 / (2 * radius), friction=friction)
    row = np.flatnonzero((result.area > 0) & (points[:, 2] < 1e-12))
    row = row[np.argsort(points[row, 1])]
    load, drag = np.abs(result.reaction[:, low, 0].sum(1)) / h, -result.reaction[:, low, 1].sum(1) / h
    modulus = young / (2 * (1 - poisson**2))
    half = np.sqrt(4 * load * radius / (np.pi * modulus))
    want = stack(half, drag, friction, modulus, radius)
    peak = friction * half * modulus / (2 * radius)
    ours = -result.traction[:, row, 1]
    error = np.array([np.sqrt(np.mean((ours[k] - want(k, points[row, 1])) ** 2)) / peak[k] for k in range(len(steps))])
    return {"error": error, "ratio": drag / (friction * load), "load": load / load[2 * phase - 1], "phase": 2 * phase}


def rows():
    """All rows of the problem."""
    r = solve()
    ends = np.arange(1, 7) * r["phase"] - 1
    names = ("shear rises", "load falls, shear turns back", "load rises, shear goes on", "load falls, shear turns", "even load, shear turns")
    return [Row(f"{name}: shear, rms over mu p0", "-", 0.0, float(r["error"][a + 1:b + 1].max()), 0.04, f"ends at Q = {r['ratio'][b]:.2f} mu P, P = {r['load'][b]:.2f}")
            for name, a, b in zip(names, ends[:-1], ends[1:])]
