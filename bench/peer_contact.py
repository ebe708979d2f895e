# SPDX-License-Identifier: GPL-3.0-or-later
"""Two bodies of `hdengine.solid` in contact, solved by CalculiX on the same mesh: node to surface, surface to surface, mortar.

The deck is in mm, N and MPa. The gap of the problem becomes shape: nodes of the slave move along their normal. An even interference can be
told by *CLEARANCE instead, which surface to surface and mortar contact read.
"""
import tempfile
from dataclasses import dataclass
from pathlib import Path

import closed_solutions as cc
import numpy as np

from common import measured, read_prints
from hdengine.export.cards import body_cards, contact_cards, node_cards, set_cards, sides_of, surface_cards


@dataclass
class Answer:
    """What CalculiX said: done or the trouble, CPU seconds, fields of the last increment in m and Pa."""

    done: bool
    trouble: str
    seconds: float
    u: np.ndarray = None
    traction: np.ndarray = None   # pressure and two shears
    reaction: np.ndarray = None


def write_deck(path, bodies, slave, master, fixed, steps, *, method, element, points, cylindrical=False, stiffness=1e8, friction=0.0, stick=1e7,
               clearance=None, increment=1.0):
    """Write the deck; `steps` are prescribed displacements (n, 3) [m], `stiffness` and `stick` in N/mm3."""
    lines, first, cells = node_cards(1e3 * points, "ALL"), 0, []
    for b, body in enumerate(bodies):
        numbers = len(cells) + np.arange(len(body.mesh.cells))
        cells += [*(body.mesh.cells + first)]
        lines += body_cards(f"BODY{b}", numbers, body.mesh.cells + first, element, body.young / 1e6, body.poisson)
        first += len(body.mesh.points)
    cells = np.array(cells)
    lines += set_cards({"HELD": np.flatnonzero(fixed[:, :2].any(1))})
    if cylindrical:   # mortar contact takes no transformed slave nodes
        lines += ["*TRANSFORM, NSET=HELD, TYPE=C", "0., 0., 0., 0., 0., 1."]
    for name, face in (("SLAVE", slave), ("MASTER", master)):
        lines += surface_cards(name, sides_of(cells, face.facets))
    lines += contact_cards(method, stiffness, friction, stick, clearance)
    lines += ["*BOUNDARY"] + [f"{i + 1}, {d + 1}, {d + 1}" for i, d in np.argwhere(fixed)]
    for u in steps:
        lines += ["*STEP, INC=200", "*STATIC", f"{increment}, 1., 1e-4, {increment}"]
        moved = np.argwhere(fixed & (np.abs(steps).max(0) > 0))
        lines += ["*BOUNDARY"] + [f"{i + 1}, {d + 1}, {d + 1}, {1e3 * u[i, d]:.12g}" for i, d in moved] if len(moved) else []
        lines += ["*NODE PRINT, NSET=ALL, FREQUENCY=200, GLOBAL=YES", "U", "*NODE PRINT, NSET=HELD, FREQUENCY=200", "RF", "*CONTACT FILE, FREQUENCY=200", "CSTR", "*END STEP"]
    path.write_text("\n".join(lines) + "\n")


def contact_traction(text, n):
    """Pressure and two shears [Pa] at the slave's nodes from the last CONTACT block of a .frd file."""
    traction, on = np.zeros((n, 3)), False
    for line in text.splitlines():
        if line.startswith(" -4  "):
            on = line.split()[1] == "CONTACT"
            if on:
                traction[:] = 0
        elif on and line.startswith(" -1"):
            traction[int(line[3:13]) - 1] = [1e6 * float(line[k:k + 12]) for k in (49, 61, 73)]
        elif line.startswith(" -3"):
            on = False
    return traction


def printed(blocks, word, n):
    """The last block of a kind of `read_prints`, (n, 3)."""
    field = np.zeros((n, 3))
    for number, v in [rows for kind, rows in blocks if kind == word][-1].items():
        field[number] = v
    return field


def solve(bodies, slave, master, fixed, steps, *, limit=120, **options):
    """Solve in CalculiX; `options` are those of `write_deck`. A run past `limit` CPU seconds is ended."""
    n = len(fixed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_deck(folder / "pair.inp", bodies, slave, master, fixed, np.asarray(steps), **options)
        done = measured(["ccx", "-i", "pair"], folder, limit)
        if "Job finished" not in done.text:
            told = [line.strip() for line in done.text.splitlines() if "*ERROR" in line]
            return Answer(False, f"over {limit} s" if done.code is None else told[-1] if told else "stopped without a word", done.cpu_s)
        blocks, frd = read_prints(folder / "pair.dat"), (folder / "pair.frd").read_text(errors="replace")
        return Answer(True, "", done.cpu_s, 1e-3 * printed(blocks, "displacements", n), contact_traction(frd, n), printed(blocks, "forces", n))


def press_fit(method, told, inner, outer, element, layers, start, interference=10e-6, **options):
    """Lame's press fit; the interference as shape of the outer ring, or told by *CLEARANCE. Returns the answer and the error: root mean square of
    the radial displacement at the interface over Lame's.
    """
    bodies, faces, polar, _, fixed = cc.lame_problem(inner, outer, element, layers, start)
    points, n0 = np.vstack([b.mesh.points for b in bodies]), len(bodies[0].mesh.points)
    face = np.flatnonzero(np.abs(polar[:, 0] - 20e-3) < 1e-9)
    if not told:
        moved = face[face >= n0]
        points[moved, :2] *= 1 - interference / polar[moved, :1]
    found = solve(bodies, *faces, fixed, np.zeros((1, *points.shape)), method=method, element=element, points=points, cylindrical=True,
                  clearance=-interference if told else None, **options)
    if not found.done:
        return found, np.nan
    _, inward, outward = cc.lame_exact(interference)
    radial = (found.u[face, :2] * np.c_[np.cos(polar[face, 1]), np.sin(polar[face, 1])]).sum(1)
    return found, float(np.sqrt(np.mean((radial / np.where(face < n0, inward, outward) - 1) ** 2)))
