# SPDX-License-Identifier: GPL-3.0-or-later
"""Study files: TOML."""
from __future__ import annotations

import re
import sys
from pathlib import Path

from .._check import MOST_BYTES, input_file
from .._engine import FileError, InputError
from .._types import PathLike

__all__: list[str] = []

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

GROUPS: dict[str, tuple[str, ...] | None] = {
    "study": ("title", "scene", "rows"),
    "fixed": None,
    "grid": None,
    "together": None,
    "figure": ("kind", "x", "y", "lines", "panels", "relative", "torque"),
}


def read(path: PathLike) -> dict[str, dict[str, list]]:
    """Groups of a study file.

    Parameters
    ----------
    path : str or Path
        TOML.

    Returns
    -------
    dict of dict of list
        groups[group][key] is the list of values, in the order of the file.

    Raises
    ------
    FileError
        The file cannot be read.
    InputError
        With file and line, or with the valid names.
    """
    path = Path(path)
    if path.suffix.lower() != ".toml":
        raise InputError(f"'{path}' is no study, which ends in .toml: 'hdengine run {path}' solves one scene")
    text = _text(path)
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError) as e:   # RecursionError: brackets in brackets
        line = re.search(r"line (\d+)", str(e))
        raise InputError(f"{e}\n  --> {path}:{line.group(1) if line else len(text.splitlines())}") from None
    groups = {name: _lists(path, text, name, keys) for name, keys in tables.items()}
    for group, keys in groups.items():
        valid = GROUPS.get(group, ())
        if group not in GROUPS:
            raise InputError(f"unknown group {group}; valid: {', '.join(GROUPS)}\n"
                             f"  --> {path}{_line(text, group)}")
        for key in keys:
            if valid and key not in valid:
                raise InputError(f"unknown key '{key}' of {group}; valid: {', '.join(sorted(valid))}\n"
                                 f"  --> {path}{_line(text, key)}")
            if group == "study" and [type(v) for v in keys[key]] != [str]:
                raise InputError(f"'{key}' of study = {', '.join(map(repr, keys[key]))}; valid: a text\n"
                                 f"  --> {path}{_line(text, key)}")
    return groups


def _text(path):
    """A text file."""
    path = input_file(path, MOST_BYTES)
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as e:
        raise FileError(f"'{path}' cannot be read: {e}") from None


def _line(text, name):
    """':line' of a group or key, as far as a search finds it."""
    name = re.escape(name.rsplit(".", 1)[-1])
    for number, line in enumerate(text.splitlines(), 1):
        if re.match(rf"\s*(\[\s*{name}\s*\]|[\w.\"']*\b{name}[\"']?\s*=)", line):
            return f":{number}"
    return ""


def line_of(path: PathLike, message: str) -> str:
    """':line' of the key that a message names first, as far as a search finds it."""
    named = re.search(r"(?:figure\.|')([\w.]+)", message)
    return _line(_text(path), named.group(1)) if named else ""


def _lists(path, text, name, keys):
    """'group.key' to a list of values, from nested tables."""
    if not isinstance(keys, dict):
        raise InputError(f"'{name}' stands outside of a table; valid: [{'], ['.join(GROUPS)}]\n  --> {path}{_line(text, name)}")
    found = {}  # type: ignore[var-annotated]
    for key, value in keys.items():
        if isinstance(value, dict):
            more = {f"{key}.{rest}": v for rest, v in _lists(path, text, name, value).items()}
        else:
            more = {key: value if isinstance(value, list) else [value]}
            for v in (w for item in more[key] for w in (item if isinstance(item, list) else [item])):
                if isinstance(v, bool) or not isinstance(v, (int, float, str)):
                    raise InputError(f"'{key}' in [{name}] holds {v!r}; valid: numbers and texts, alone or in a list\n"
                                     f"  --> {path}{_line(text, key)}")
        if twice := sorted(found.keys() & more.keys()):
            raise InputError(f"'{twice[0]}' stands twice in [{name}], quoted and dotted; valid: one list of its values\n"
                             f"  --> {path}{_line(text, twice[0])}")
        found |= more
    return found
