#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where each equation of Hu et al. (2023) is computed: docs/reference/equations.md from tags in the source.

A tag like [Eq. 23-27] stands in the description of the procedure that computes the equation: in the !> lines above a Fortran
procedure, or in the docstring of a Python function. A mere mention is written without brackets.
"""
import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TAG = re.compile(r"\[Eq\. ([0-9, -]+)\]")
WHAT = {
    "1": "height of a surface: sum of waves", "2": "height of a profile", "3": "shape of an asperity: a cosine", "4": "its amplitude",
    "5": "radius of its peak", "6": "depth and area of a spot in the elastic regime", "7": "depth at first yield",
    "8": "area at first yield", "9": "load of an elastic spot", "10": "load at first yield",
    "11-12": "area and load of an elastoplastic spot over its depth", "13-14": "load of an elastoplastic spot over its area",
    "15-16": "area and load of a plastic spot", "17": "size distribution of the spots", "18-21": "real contact area, by regime: only their sum, known in closed form",
    "22": "real contact area", "23-26": "load, by regime", "27": "load", "28": "pressure: load over real contact area",
    "29": "normal stiffness of an elastic spot", "30": "normal stiffness of all elastic spots",
    "31-32": "normal stiffness of an elastoplastic spot", "33-34": "normal stiffness of all elastoplastic spots",
    "35": "normal stiffness of the joint", "36-37": "tangential displacement of a spot: only its derivative", "38": "reduced shear modulus",
    "39-40": "tangential stiffness of a spot", "41-43": "tangential stiffness, by regime", "44": "tangential stiffness of the joint",
    "45": "torsional stiffness of the contact", "46": "torsional stiffness of the drive",
}
HEAD = """# Equations of the paper: where each is computed

What was put right of Hu et al. (2023) is told in [the paper](../explain/paper.md). Tags `[Eq. N]` in the sources name the place.

| equation | what | computed by | in |
|---|---|---|---|
"""


def numbers(text):
    """Numbers of '3-5, 7'."""
    for part in text.split(","):
        ends = [int(n) for n in part.split("-")]
        yield from range(ends[0], ends[-1] + 1)


def fortran_tags(path):
    """(number, procedure) of the tags above its procedures."""
    comment = ""
    for line in path.read_text().splitlines():
        if line.strip().startswith("!>"):
            comment += " " + line.strip()[2:]
            continue
        found = re.match(r"\s*(?:[\w()=, ]*\b)?(?:subroutine|function)\s+(\w+)", line)
        if found and not line.strip().startswith(("end ", "!")):
            for tag in TAG.findall(comment):
                yield from ((n, found.group(1)) for n in numbers(tag))
        comment = ""


def python_tags(path):
    """(number, function) of the tags in docstrings."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef):
            for tag in TAG.findall(ast.get_docstring(node) or ""):
                yield from ((n, node.name) for n in numbers(tag))


def places():
    """Equation number to list of (file, procedure)."""
    found = {}
    for suffix, tags in ((".f90", fortran_tags), (".py", python_tags)):
        for path in sorted((ROOT / ("fortran" if suffix == ".f90" else "python")).rglob("*" + suffix)):
            for n, name in tags(path):
                found.setdefault(n, []).append((path.relative_to(ROOT).as_posix(), name))
    return found


def page():
    """The page as text."""
    found, rows = places(), []
    for equations, what in WHAT.items():
        here = dict.fromkeys(place for n in numbers(equations) for place in found.get(n, []))
        heads = [f"{equations} | {what}"] + [" | "] * (len(here) - 1)
        rows += [f"| {head} | `{name}` | `{file}` |" for head, (file, name) in zip(heads, here or [("", "")], strict=True)]
    return HEAD + "\n".join(rows) + "\n"

