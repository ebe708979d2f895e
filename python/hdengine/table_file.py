# SPDX-License-Identifier: GPL-3.0-or-later
"""A table of comma-separated values under a line of names."""
from __future__ import annotations

import contextlib
import itertools
import mmap
import warnings
from typing import Any

import numpy as np

from ._check import input_file
from ._engine import FileError
from ._types import PathLike

__all__: list[str] = []
WORD = 24   # characters beyond which a table is left to the slow reader


def _lines(source):
    """Lines of a file, without a mark at its begin, or those of a list; numpy asks for the working folder, which may be gone."""
    return contextlib.nullcontext(source) if isinstance(source, list) else open(source, encoding="utf-8-sig")


def _table(source):
    """A table without gaps by numpy's fast reader; ValueError or Warning where that does not do. Whole numbers are integers."""
    with _lines(source) as lines:
        head = [*itertools.islice(lines, 20)]
    first = np.genfromtxt(head, delimiter=",", names=True, dtype=None, encoding="utf-8").dtype
    if first.names is None or any(first[name].kind not in "ifU" for name in first.names):
        raise ValueError("neither numbers nor words")
    kinds: dict = {name: f"U{WORD}" if first[name].kind == "U" else float for name in first.names}
    with _lines(source) as lines:
        table = np.loadtxt(lines, delimiter=",", dtype=[*kinds.items()], skiprows=1, ndmin=1)
    for name in first.names:
        column = table[name]
        if first[name].kind == "U":
            longest = int(np.char.str_len(column).max())
            if not 0 < np.char.str_len(column).min() <= longest < WORD:
                raise ValueError("words that are too long, or missing")
            kinds[name] = f"U{longest}"
        elif first[name].kind == "i" and np.all((column == np.rint(column)) & (abs(column) < 2.0**53)):
            kinds[name] = int
    return table.astype([*kinds.items()])


def _table_with_gaps(source):
    """A table by numpy's slow reader, a gap as NaN: among whole numbers it would become -1."""
    options: dict = {"delimiter": ",", "names": True, "encoding": "utf-8"}
    with _lines(source) as lines:
        table = np.atleast_1d(np.genfromtxt(lines, dtype=None, **options))
    names = table.dtype.names or ()
    if not any(table.dtype[name].kind == "i" for name in names):
        return table
    floats = [(name, float if table.dtype[name].kind == "i" else table.dtype[name]) for name in names]
    with _lines(source) as lines:
        wide = np.atleast_1d(np.genfromtxt(lines, dtype=floats, **options))
    return wide.astype([(name, table.dtype[name] if not np.any(wide[name] != wide[name]) else float) for name in names])


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
    return text.decode("utf-8").splitlines()


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
        with open(path, "rb") as file:
            if b"\0" in file.read(4096):
                raise ValueError("it holds bytes that are no text")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", "overflow encountered in conversion")   # words are tried as numbers first
            source: Any = path
            if step is not None:
                source = _lines_of_step(path, step)
            try:
                table = _table(source)
            except (ValueError, Warning, IndexError):
                table = _table_with_gaps(source)
    except OSError as e:
        raise FileError(f"'{path}' cannot be read: {e.strerror or e}") from None
    except (ValueError, TypeError, Warning, IndexError) as e:   # TypeError: numpy, where a word follows whole numbers
        said = [line.strip() for line in str(e).splitlines() if line.strip()] or [type(e).__name__]
        first = next((line for line in said if line.startswith("Line #")), said[0])
        raise FileError(f"'{path}' is no table of comma-separated values under a line of names: {first}") from None
    if table.dtype.names is None:
        raise FileError(f"'{path}' is no table of comma-separated values under a line of names")
    missing = [name for name in needed if name not in table.dtype.names]
    if missing or (needed and not len(table)):   # only what every run leaves must have rows
        why = f"is not what hdengine writes: no column {', '.join(missing)}" if missing else "has no row: no load step was done"
        raise FileError(f"'{path}' {why}")
    return table
