# SPDX-License-Identifier: GPL-3.0-or-later
"""Plain text of numbers: heights in one column, a profile in two, points of a map in three, the map itself in more."""
from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .._check import NUMBER
from .._engine import FileError

__all__: list[str] = []
_ROW = re.compile(r"[\d\s,;.eE+-]+", re.ASCII)
_HOLES = ("bad", "nan")  # the words of SDF and of C
_UNITS = re.compile(r"#\s*(Lateral|Value) units:\s*(\S+)")  # of Gwyddion's XYZ export
_VALUED = re.compile(r"#[^:=]*[:=]\s*[-+.\d]")  # a comment that gives a size: of a matrix, which SurfaceTopography reads
_FAR = 2**31  # places of a grid along a side
_EVEN = 0.05  # of a step: points off a grid by less belong to it


class Table(NamedTuple):
    """Rows of numbers as they stand, NaN for holes."""

    values: np.ndarray  #: (rows, columns)
    lines: list         #: of the rows in the file
    units: dict         #: stated, "Lateral" and "Value"


def _words(line):
    """Words of a line; a separator may end it."""
    line = line.strip()
    return re.split(r"\s*[,;]\s*|\s+", line[:-1].rstrip() if line[-1] in ",;" else line)


def _row(line):
    """Numbers of a line, or None."""
    words = line.split() if "," not in line and ";" not in line else _words(line)
    if _ROW.fullmatch(line):
        try:
            return [float(w) for w in words]
        except ValueError:
            return None
    found = [float("nan") if w.lower() in _HOLES else float(w) if NUMBER.fullmatch(w) else None for w in words]
    return None if None in found else found


def is_text(path: Path) -> bool:
    """The file begins as UTF-8 text."""
    with open(path, "rb") as file:
        head = file.read(4096)
    return b"\0" not in head and "\ufffd" not in head.decode("utf-8", "replace")[:-4]


def read_table(path: Path) -> Table | None:
    """Read columns of numbers; None for what has headers, which other readers know.

    Raises
    ------
    FileError
        A word in place of a number, decimal commas, a row of another length: file, line and what is seen.
    """
    if not is_text(path):
        return None
    rows, lines, units, header, valued = [], [], {}, [], False  # type: ignore[var-annotated]
    for number, line in enumerate(path.read_text(encoding="utf-8-sig", errors="replace").splitlines(), 1):
        if not line.strip():
            continue
        if line.lstrip()[0] in "#%":
            valued |= bool(_VALUED.match(line))
            units.update(_UNITS.findall(line))
            continue
        row = _row(line)
        if row is not None and (rows or any(x == x for x in row)):      # a row of holes begins nothing: names of columns do
            if "," in line and re.search(r"\d,\d", line) and (";" in line or re.search(r"\d\s+[-+.\d]", line)):
                raise FileError(f"{path.name}, line {number}: {_short(line)} has decimal commas or two separators; valid: "
                                "decimal points, one separator")
            rows.append(row)
            lines.append(number)
        elif not rows:
            header.append((number, line))
        elif len(rows[-1]) == len(_words(line)) or (len(rows[0]) < 4 and len(header) < 2 and not valued):
            raise FileError(f"{path.name}, line {number}: {_short(line)} stands among rows of numbers; valid: numbers, Bad or "
                            "NaN for a hole")
        else:
            return None
    if not rows or (len(rows[0]) > 3 and (header or len({len(row) for row in rows}) > 1)) or len(header) > 1 or valued:
        return None
    for row, number in zip(rows, lines):
        if len(row) != len(rows[0]):
            raise FileError(f"{path.name}, line {number}: {len(row)} numbers; valid: {len(rows[0])}, as in line {lines[0]}")
    if header and any(NUMBER.fullmatch(w) for w in re.split(r"[\s,;]+", header[0][1])):
        raise FileError(f"{path.name}, line {header[0][0]}: {_short(header[0][1])} is neither names of columns nor numbers")
    return Table(np.array(rows), lines, units)


def _short(line):
    line = " ".join(line.split())
    return repr(line if len(line) <= 60 else line[:57] + "...")


def profile(path: Path, table: Table) -> tuple:
    """Positions that rise, and heights, of a table of two columns.

    Returns
    -------
    x, z : ndarray
    notes : list of str

    Raises
    ------
    FileError
        Positions go back and forth: points without order, or an overhang, which no height map holds.
    """
    x, z = table.values.T
    if not np.isfinite(x).all():
        raise FileError(f"{path.name}, line {table.lines[int(np.argmax(~np.isfinite(x)))]}: a position is missing")
    d = np.diff(x)
    if x.size < 2 or (d > 0).all():
        return x, z, []
    if (d < 0).all():
        return x[::-1], z[::-1], ["positions fall: the profile is turned round"]
    at = int(np.argmax(d <= 0 if np.sum(d > 0) > np.sum(d < 0) else d >= 0)) + 1
    raise FileError(f"{path.name}, line {table.lines[at]}: position {x[at]:g} behind {x[at - 1]:g}; valid: positions that rise, or "
                    "that fall, from line to line (an overhang is no height profile)")


def lattice(x: np.ndarray) -> tuple:
    """Place of each position on an even grid, and its step (0: all are one), infinite where there is no such grid."""
    lines = np.unique(x)
    if lines.size == 1:
        return np.zeros(x.size, int), 0.0
    d = np.diff(lines)
    k = np.concatenate(([0], np.cumsum(np.rint(d / np.median(d)))))
    if (np.diff(k) < 1).any() or k[-1] > _FAR:
        return np.zeros(x.size, int), np.inf
    step = (lines[-1] - lines[0]) / k[-1]
    if np.max(abs(lines - lines[0] - k * step)) > _EVEN * step:
        return np.zeros(x.size, int), np.inf
    return k[np.searchsorted(lines, x)].astype(int), float(step)


def points(path: Path, table: Table) -> tuple:
    """Heights of a table of x, y and height on the grid on which they lie; places without a point are holes.

    Returns
    -------
    z : ndarray (rows, points)
    steps : (float, float)
        Of y and x; 0 where there is one row, one column.
    notes : list of str

    Raises
    ------
    FileError
        The points lie on no grid, on less than half of one, or two on one place.
    """
    x, y, z = table.values.T
    if not np.isfinite(table.values[:, :2]).all():
        raise FileError(f"{path.name}, line {table.lines[int(np.argmax(~np.isfinite(x + y)))]}: a position is missing")
    found = [lattice(v) for v in (x, y)]
    size = [int(k.max()) + 1 for k, _ in found]
    if np.inf in (found[0][1], found[1][1]) or size[0] * size[1] > 2 * len(z):
        raise FileError(f"{path.name}: three columns are x, y and height, and its {len(z)} points lie on no grid; valid: points of "
                        "an even grid, of which some may be missing, or a matrix of four columns or more")
    (i, dx), (j, dy) = found
    flat = j * size[0] + i
    order = np.argsort(flat, kind="stable")
    twice = np.flatnonzero(np.diff(flat[order]) == 0)
    if twice.size:
        at = int(order[twice[0] + 1])
        raise FileError(f"{path.name}, line {table.lines[at]}: a second height at x = {x[at]:g}, y = {y[at]:g}")
    grid = np.full(size[0] * size[1], np.nan)
    grid[flat] = z
    missing = grid.size - len(z)
    notes = [f"{missing} of {grid.size} places of the grid have no point: holes"] if missing else []
    return grid.reshape(size[1], size[0]), (dy, dx), notes
