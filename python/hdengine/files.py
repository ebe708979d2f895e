# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders of results that Python writes: nothing is overwritten unasked, and what is cut short does not look whole."""
from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from . import _engine
from ._engine import FileError
from ._types import PathLike
from .results import read_json

# files that say what a folder holds
_MARKS = ("summary.json", "study.json", "echo.nml", "record.json", "surface.json", "joint.json", "gaps.json")


def check_folder(folder: PathLike, names: Sequence[str], force: bool = False) -> None:
    """Refuse a folder in which files would be overwritten.

    Parameters
    ----------
    folder : path-like
    names : iterable of str
        Files that are to be written.
    force : bool
        Files of these names may be replaced; what another command wrote never is.

    Raises
    ------
    FileError
        The folder holds what another command wrote, or one of the files.
    """
    folder, names = Path(folder), list(names)
    for name in (m for m in _MARKS if m not in names):
        if (folder / name).exists():
            raise FileError(f"'{folder}' holds {name} of another command: choose another folder with --out")
    for name in names:
        if (folder / name).exists() and not force:
            raise FileError(f"'{folder}' holds {name} already: add --force to replace it, or choose another folder with --out")


def write_folder(folder: PathLike, record: str, head: dict, files: dict, force: bool = False) -> list:
    """Write files into a folder and last of all the JSON record that lists them: without it they are not whole.

    Parameters
    ----------
    folder : path-like
    record : str
        Name of the record; an earlier one is removed first, with the files it lists.
    head : dict
        What the record holds besides "status", "hdengine" and "files".
    files : dict
        Text, or a matplotlib figure, by name.
    force : bool
        Replace files of these names.

    Returns
    -------
    list of Path
        The record first.

    Raises
    ------
    FileError
        As `check_folder`, or the folder cannot be written.
    """
    folder = Path(folder)
    check_folder(folder, [record, *files], force)
    whole = {"status": "complete", "hdengine": _engine.version(), **head, "files": list(files)}
    text = json.dumps(_plain(whole), indent=1, allow_nan=False) + "\n"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if (folder / record).exists():
            earlier = read_json(folder / record).get("files", [])
            (folder / record).unlink()
            for name in (n for n in earlier if isinstance(n, str) and Path(n).name == n):
                (folder / name).unlink(missing_ok=True)
        for name, content in (*files.items(), (record, text)):
            part = folder / f".{name}"
            try:
                if isinstance(content, str):
                    part.write_text(content, encoding="utf-8")
                else:
                    content.savefig(part)
                os.replace(part, folder / name)
            finally:
                part.unlink(missing_ok=True)
    except OSError as e:
        raise FileError(f"'{folder}' cannot be written: {e.strerror or e}") from None
    return [folder / record, *(folder / name for name in files)]


def _plain(value):
    """The same for JSON: arrays as lists, numbers that are not finite as null."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(v) for v in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def csv_text(columns: dict) -> str:
    """A CSV table of columns: words as they are, numbers with ten digits, NaN as an empty cell."""
    def cell(v):
        return v if isinstance(v, str) else "" if v != v else f"{v:.10g}"
    return "\n".join([",".join(columns), *(",".join(map(cell, row)) for row in zip(*columns.values()))]) + "\n"
