# SPDX-License-Identifier: GPL-3.0-or-later
"""Cards of CalculiX decks that every deck of hdengine has: nodes, elements, materials, sides of elements, contact [mm, N, MPa]."""
from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

__all__: list[str] = []
ELEMENTS = {"hex8": "C3D8", "hex8i": "C3D8I", "hex20r": "C3D20R"}
METHODS = {"n2s": "NODE TO SURFACE", "s2s": "SURFACE TO SURFACE", "mortar": "MORTAR"}
SIDES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))


def wrapped(numbers: Iterable, per_line: int = 8) -> list:
    """Numbers as lines of a deck."""
    words = [str(n) for n in numbers]
    return [", ".join(words[i:i + per_line]) for i in range(0, len(words), per_line)]


def node_cards(points: np.ndarray, name: str) -> list:
    """Nodes from 1 on [mm], and the set of them."""
    return [f"*NODE, NSET={name}", *(f"{i + 1}, {p[0]:.12g}, {p[1]:.12g}, {p[2]:.12g}" for i, p in enumerate(points))]


def body_cards(name: str, numbers: Iterable, cells: np.ndarray, element: str, young: float, poisson: float) -> list:
    """Elements of a body with their numbers from 0 on, its material [MPa] and its section."""
    lines = [f"*ELEMENT, TYPE={ELEMENTS[element]}, ELSET={name}"]
    for number, nodes in zip(numbers, cells):
        words = [number + 1, *(n + 1 for n in nodes)]
        lines.append(", ".join(map(str, words[:11])) + ("," if len(words) > 11 else ""))
        if len(words) > 11:
            lines.append(", ".join(map(str, words[11:])))
    return [*lines, f"*MATERIAL, NAME=M{name}", "*ELASTIC", f"{young:.9g}, {poisson:g}",
            f"*SOLID SECTION, ELSET={name}, MATERIAL=M{name}"]


def set_cards(sets: dict) -> list:
    """Sets of nodes, counted from 0, by name."""
    return [line for name, nodes in sets.items() for line in (f"*NSET, NSET={name}", *wrapped(np.asarray(nodes) + 1))]


def surface_cards(name: str, sides: Iterable) -> list:
    """A surface of (element, side), both from 0."""
    return [f"*SURFACE, NAME={name}, TYPE=ELEMENT", *(f"{e + 1}, S{s + 1}" for e, s in sides)]


def sides_of(cells: np.ndarray, facets: np.ndarray) -> list:
    """Element and side, both from 0, of facets."""
    wanted = {frozenset(f[:4]) for f in facets.tolist()}
    return [(e, s) for e, c in enumerate(cells.tolist()) for s, side in enumerate(SIDES) if frozenset(c[k] for k in side) in wanted]


def contact_cards(method: str, stiffness: float, friction: float, stick: float, clearance: float | None = None) -> list:
    """Cards of the pair SLAVE, MASTER; stiffnesses in N/mm3, an even clearance in m."""
    behaviour = ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD"] if method == "mortar" else \
        ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{stiffness:g}" + (", 0.1" if method == "n2s" else "")]
    cards = ["*SURFACE INTERACTION, NAME=TOUCH", *behaviour]
    if friction:
        cards += ["*FRICTION", f"{friction:g}, {stick:g}"]
    cards += [f"*CONTACT PAIR, INTERACTION=TOUCH, TYPE={METHODS[method]}", "SLAVE, MASTER"]
    if clearance is not None:
        cards += [f"*CLEARANCE, SLAVE=SLAVE, MASTER=MASTER, VALUE={1e3 * clearance:.9g}"]
    return cards


def strut_cards(count: int, body: int, laws: Sequence[tuple]) -> tuple[list, np.ndarray, np.ndarray]:
    """Springs that push by a law: from an end, whose displacement along x is minus the way of what it stands for, to a ground.

    A ground that moves by -way closes its strut by way less what the end stands for. A plastic cube apart, at rest, makes CalculiX
    solve the step as nonlinear even where nothing else is.

    Parameters
    ----------
    count : int
        Nodes before.
    body : int
        Elements before.
    laws : list of (name, number of struts, forces [N], closings [mm])
        Force and closing rise from 0.

    Returns
    -------
    lines : list of str
        Sets STRUTS, GROUND and CUBE must be held in y and z, the cube in x too.
    ends, ground : ndarray of int
        Their nodes, from 1.
    """
    total = sum(law[1] for law in laws)
    ends = count + 1 + np.arange(total)
    ground = ends + total
    lines = ["*NODE, NSET=STRUTS", *(f"{e}, 0., {i}., 0." for i, e in enumerate(ends)),
             "*NODE, NSET=GROUND", *(f"{g}, 10., {i}., 0." for i, g in enumerate(ground))]
    first = 0
    for name, number, force, closing in laws:
        lines.append(f"*ELEMENT, TYPE=SPRINGA, ELSET={name}")
        lines += [f"{body + 1 + i}, {ends[i]}, {ground[i]}" for i in range(first, first + number)]
        lines += [f"*SPRING, ELSET={name}, NONLINEAR", ""]
        lines += [f"{-f:.12e}, {-x:.12e}" for f, x in zip(force[::-1], closing[::-1])] + ["0., 2.0"]
        first += number
    corner = 1 + count + 2 * total
    lines += ["*NODE, NSET=CUBE"]
    lines += [f"{corner + i}, {100 + (i in (1, 2, 5, 6))}., {i in (2, 3, 6, 7):d}., {i // 4}." for i in range(8)]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=CUBE", f"{body + 1 + total}, " + ", ".join(str(corner + i) for i in range(8)),
              "*MATERIAL, NAME=MCUBE", "*ELASTIC", "200000., 0.3", "*PLASTIC", "1000., 0.", "1001., 1.",
              "*SOLID SECTION, ELSET=CUBE, MATERIAL=MCUBE"]
    return lines, ends, ground


def equation_cards(terms: Sequence) -> list:
    """An equation of (node from 1, direction, factor) whose sum is 0; the first one is eliminated."""
    return ["*EQUATION", str(len(terms)), *wrapped([f"{n}, {d}, {f:.14g}" for n, d, f in terms], 4)]
