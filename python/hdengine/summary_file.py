# SPDX-License-Identifier: GPL-3.0-or-later
"""summary.json of a run, and the files whose checksums it holds."""
from __future__ import annotations

import json
from pathlib import Path

from ._check import input_file
from ._engine import FileError, InputError, call_text, checksum
from ._types import PathLike
from .files import read_json

__all__: list[str] = []


class _Entries(dict):
    """Entries of a file that hdengine wrote, with those in them; one that is missing is an error that names it and the file."""

    def __init__(self, found, place):
        super().__init__({k: _Entries(v, f"{place}: {k}") if isinstance(v, dict) else v for k, v in found.items()})
        self._place = place

    def __missing__(self, key):
        raise FileError(f"{self._place} is not what hdengine writes: no entry {key}")


def written(folder: PathLike, name: str, summary: dict) -> Path:
    """Path of a file of a run, which is as the run left it.

    Raises
    ------
    FileError
        It is absent, or its checksum is not that in the summary of the run.
    """
    path = input_file(Path(folder) / name)
    if checksum(path) != summary["checksums"].get(name):
        raise _changed(path)
    return path


def check_same_run(folder: PathLike, summary: dict) -> None:
    """Raise FileError unless a folder still holds the run whose summary this is."""
    path = input_file(Path(folder) / "summary.json")
    if f'"checksum": "{summary["checksum"]}"'.encode() not in path.read_bytes()[-80:]:
        raise FileError(f"'{folder}' holds another run by now: give every run a folder of its own, or hdengine.load it anew")


def check_one(folder: PathLike) -> None:
    """Raise FileError where a folder holds a run and a study: neither says which of them is meant."""
    if all((Path(folder) / name).is_file() for name in ("summary.json", "study.json")):
        raise FileError(f"'{folder}' holds both a run (summary.json) and a study (study.json): give each a folder of its own")


def has_table(summary: dict, name: str) -> bool:
    """Whether a run wrote a table, whatever became of it since."""
    return f"{name}.csv" in summary["checksums"]


def echo_of(folder: PathLike, summary: dict) -> Path:
    """echo.nml of a run.

    Raises
    ------
    FileError
        It is absent, or its scene is not that of the summary.
    """
    path = input_file(Path(folder) / "echo.nml")
    try:
        scene = json.loads(call_text("scene_text", str(path), " ", 0))["scene"]
    except InputError:
        scene = None
    if scene != summary["scene"]:
        raise _changed(path, "its scene is not that of summary.json")
    return path


def check_inputs(summary: dict) -> None:
    """Raise FileError where a table that a key names is not as the run read it."""
    for key, kept in summary.get("input_files", {}).items():
        if checksum(summary["scene"][key]) != kept:
            raise FileError(f"'{summary['scene'][key]}' ({key}) is not as the run read it: run it again")


def _changed(path, why="its checksum differs"):
    return FileError(f"'{path}' is not as the run left it ({why}): run it again")


def read_summary(folder: PathLike, *needed: str) -> dict:
    """summary.json of a finished run; entries that are needed must be there.

    Raises
    ------
    FileError
        There is none, or it is not what a run left.
    """
    path = Path(folder) / "summary.json"
    if not path.is_file():
        what = "a study: read it by hdengine.StudyResult" if (Path(folder) / "study.json").is_file() else \
            "no finished run: summary.json is missing"
        raise FileError(f"'{folder}' holds {what}")
    if "scene" in needed and read_json(path).get("kind") == "surface":
        raise FileError(f"'{folder}' holds a run of surfaces: read it by hdengine.SurfaceResult")
    found = read_json(path, *needed)
    if not {"checksum", "checksums"} <= found.keys():
        raise FileError(f"'{path}' has no checksums: it is of an earlier hdengine, or was changed: run it again")
    if checksum(path, path.read_bytes().rfind(b',\n  "checksum": ')) != found["checksum"]:
        raise _changed(path)
    return _Entries(found, f"'{path}'")
