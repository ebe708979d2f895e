# SPDX-License-Identifier: GPL-3.0-or-later
"""A table of comma-separated values under a line of names."""
from __future__ import annotations

import contextlib
import itertools
import mmap
from collections.abc import Sequence

import numpy as np

from ._check import HUGE, MOST_BYTES, NUMBER, input_file, seen
from ._engine import FileError, InputError
from ._types import PathLike

__all__: list[str] = []
WORDS = ("mesh", "checksum")   # columns of words that may begin with a digit, in plan.csv
WORD = 24    # characters of a word beyond which a table is left to the slow reader
FIRST = 20   # rows that tell whether a column holds whole numbers, as they are written


def _names(line, path):
    """Names of the columns, each once."""
    names = [name.strip() for name in line.split(",")]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"'{path}': column '{twice}' stands twice")
    return names


def _is_word(name, cell):
    """Whether a cell is that of a column of words, as 'torque' in steps.csv."""
    return name in WORDS or cell[:1].isalpha() and cell.lower() not in ("nan", "inf", "infinity")


def _table(source):
    """A table without gaps by numpy's fast reader; ValueError where that does not do. Whole numbers are integers."""
    with contextlib.nullcontext(iter(source)) if isinstance(source, list) else open(source, encoding="utf-8-sig") as lines:
        names = _names(next(lines, ""), source)
        first = [*itertools.islice(lines, FIRST)]
        cells = [line.strip().split(",") for line in first]
        if not cells or any(len(row) != len(names) for row in cells):
            raise ValueError("no rows, or of another length")
        words = [_is_word(*pair) for pair in zip(names, cells[0])]
        kinds: dict = {name: f"U{WORD}" if word else float for name, word in zip(names, words)}
        table = np.loadtxt(itertools.chain(first, lines), delimiter=",", dtype=[*kinds.items()], ndmin=1, comments=None)
    for i, name in enumerate(names):
        column = table[name]
        if words[i]:
            longest = int(np.char.str_len(column).max())
            if not 0 < np.char.str_len(column).min() <= longest < WORD:
                raise ValueError("words that are too long, or missing")
            kinds[name] = f"U{longest}"
        elif (abs(column) > HUGE).any():
            raise ValueError("no number of any quantity")
        elif all(row[i].lstrip("+-").isdigit() for row in cells) and np.all((column == np.rint(column)) & (abs(column) < 2.0**53)):
            kinds[name] = int
    return table.astype([*kinds.items()])


def text_rows(path: PathLike, comment: str = "") -> tuple[list, list]:
    """Names of the columns of a table, and its rows as (line, cells); lines that begin with `comment`, if it is one, are none.

    Raises
    ------
    FileError
        The file cannot be read, or is no text.
    InputError
        A column stands twice, or a row has another length.
    """
    file = input_file(path, MOST_BYTES)
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as why:
        raise FileError(f"'{path}' cannot be read: {getattr(why, 'strerror', None) or 'it is no text in UTF-8'}") from None
    if "\0" in text:
        raise FileError(f"'{path}' holds bytes that are no text: save it as UTF-8")
    rows = [(i, [cell.strip() for cell in line.split(",")]) for i, line in enumerate(text.split("\n"), 1)
            if line.strip() and not (comment and line.lstrip().startswith(comment))]
    if not rows:
        raise InputError(f"'{path}' holds no line of names")
    names = _names(",".join(rows[0][1]), path)
    for line, cells in rows[1:]:
        if len(cells) != len(names):
            if any(";" in cell for cell in cells):
                raise InputError(f"'{path}', line {line}: decimal commas or semicolons; valid: points, and commas between cells")
            raise InputError(f"'{path}', line {line}: {len(cells)} cells; valid: {len(names)}, as the line of names")
    return names, rows[1:]


def numbers(path: PathLike, names: Sequence[str], rows: Sequence, name: str, gaps: bool = False) -> np.ndarray:
    """Numbers of a column of `text_rows`; with `gaps` an empty cell, and a NaN, is one that is absent.

    Raises
    ------
    InputError
        A cell is no number.
    """
    at, found = names.index(name), []
    for line, cells in rows:
        if not NUMBER.fullmatch(cells[at]) and not (gaps and cells[at].lower() in ("", "nan")):
            raise InputError(f"'{path}', line {line}: column {name}: {seen(cells[at])}; valid: a number")
        found.append(float(cells[at] or "nan"))
        if abs(found[-1]) > HUGE:
            raise InputError(f"'{path}', line {line}: column {name}: {seen(cells[at])}; valid: up to {HUGE:g}")
    return np.array(found)


def _table_with_gaps(path):
    """A table by cells, a gap as NaN; InputError where one is neither a number nor a word of a column of words."""
    names, rows = text_rows(path)
    columns = {}
    for i, name in enumerate(names):
        if rows and _is_word(name, next((cells[i] for _, cells in rows if cells[i]), "")):
            columns[name] = np.array([cells[i] for _, cells in rows])
            continue
        columns[name] = numbers(path, names, rows, name, gaps=True)
        if rows and all(cells[i].lstrip("+-").isdigit() for _, cells in rows) and (abs(columns[name]) < 2.0**53).all():
            columns[name] = columns[name].astype(int)
    table = np.empty(len(rows), [(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        table[name] = column
    return table


def _lines_of_step(path, step):
    """Head and lines of one load step, which rises in the first column; found by bisection, the rest of a long file is not read."""
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        def after(at):
            return data.find(b"\n", at) + 1 or len(data)

        def first_of(number):
            low, high = after(0), len(data)
            while low < high:
                line = data.rfind(b"\n", 0, (low + high) // 2) + 1
                if int(data[line:line + 20].split(b",")[0]) < number:
                    low = after(line)
                else:
                    high = line
            return low
        text = data[:after(0)] + data[first_of(step):first_of(step + 1)]
    return text.decode("utf-8-sig").splitlines()


def read_csv(path: PathLike, *needed: str, step: int | None = None) -> np.ndarray:
    """A CSV table as a structured array with the header's names; columns that are needed must be there.

    Parameters
    ----------
    path : str or Path
    *needed : str
        Columns.
    step : int, optional
        Rows of this load step alone, which the first column counts; default: all.

    Raises
    ------
    FileError
        The file cannot be read, or is no table.
    """
    input_file(path)
    try:
        try:
            table = _table(path if step is None else _lines_of_step(path, step))
        except (ValueError, IndexError, InputError):   # the slow one says where
            table = _table_with_gaps(path)
        if step is not None:
            table = table[table[table.dtype.names[0]] == step]
    except OSError as e:
        raise FileError(f"'{path}' cannot be read: {e.strerror or e}") from None
    except InputError as e:
        raise FileError(str(e)) from None
    missing = [name for name in needed if name not in table.dtype.names]
    if missing or (needed and not len(table)):   # only what every run leaves must have rows
        why = f"is not what hdengine writes: no column {', '.join(missing)}" if missing else "has no row: no load step was done"
        raise FileError(f"'{path}' {why}")
    absent = [name for name in needed if table[name].dtype.kind == "U" or (table[name] != table[name]).any()]
    if absent:
        raise FileError(f"'{path}' is not what hdengine writes: a value of column {absent[0]} is absent, or a word")
    return table
