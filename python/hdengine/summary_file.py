# SPDX-License-Identifier: GPL-3.0-or-later
"""summary.json of a run: its entries, each of its kind."""
from __future__ import annotations

from pathlib import Path

from ._check import seen
from ._engine import FileError
from ._types import PathLike
from .files import read_json

__all__: list[str] = []
_KINDS: dict[str, type] = {
    **dict.fromkeys(("status", "message", "title"), str), **dict.fromkeys(("warnings", "spacing_m"), list),
    **dict.fromkeys(("results", "joint", "model", "timers_s", "model_error", "k_ts_by_model", "provenance", "scene", "fits",
                     "generator", "plan"), dict)}   # of what is in summary.json


class _Entries(dict):
    """Entries of a file that hdengine wrote, with those in them; one that is missing is an error that names it and the file."""

    def __init__(self, found, place):
        super().__init__({k: _Entries(v, f"{place}: {k}") if isinstance(v, dict) else v for k, v in found.items()})
        self._place = place

    def __missing__(self, key):
        raise FileError(f"{self._place} is not what hdengine writes: no entry {key}")


def _check_summary(path, found):
    """Refuse entries that are of another kind than hdengine writes."""
    words: dict[type, str] = {str: "a text", list: "a list", dict: "an object"}
    wrong = [(name, found[name], words[kind]) for name, kind in _KINDS.items() if not isinstance(found.get(name, kind()), kind)]
    flat = {} if wrong else dict(found.get("results", {}))
    for name in [name for name, value in flat.items() if isinstance(value, dict)]:
        flat |= {f"{name}.{key}": value for key, value in flat.pop(name).items()}
    wrong += [(f"results.{name}", value, "a number, or null") for name, value in flat.items()
              if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float)))]
    texts = [] if wrong else [*found.get("warnings", []), *found.get("model_error", {}).get("left_out", [])]
    wrong += [("warnings or model_error.left_out", value, "texts") for value in texts if not isinstance(value, str)]
    if wrong:
        name, value, what = wrong[0]
        raise FileError(f"'{path}' is not what hdengine writes: {name} = {seen(value)}: must be {what}")


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
    _check_summary(path, found)
    return _Entries(found, f"'{path}'")
