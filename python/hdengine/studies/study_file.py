# SPDX-License-Identifier: GPL-3.0-or-later
"""Study files: TOML. The earlier form, a namelist with dotted keys, which is no valid namelist, is still read."""
from __future__ import annotations

import re
import sys
import warnings
from pathlib import Path

from .._engine import FileError, InputError
from .._types import PathLike
from . import namelist

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


def is_study(path: PathLike) -> bool:
    """A file is a study, by its ending or by its groups.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    bool
    """
    path = Path(path)
    if path.suffix.lower() == ".toml":
        return True
    with open(path, encoding="utf-8", errors="replace") as file:
        return any(re.match(r"\s*&(study|grid|together)\b", line, re.I) for line in file)


def read(path: PathLike) -> dict[str, dict[str, list]]:
    """Groups of a study file.

    Parameters
    ----------
    path : str or Path
        TOML, or a namelist if it does not end in .toml.

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
        groups = namelist.read(path)
        warnings.warn(f"'{path}' is a study in the form of a namelist; write it as TOML (docs/howto/study.md): the next "
                      "release reads no other", DeprecationWarning, stacklevel=3)
        text, mark = "", "&"
    else:
        text, mark = _text(path), ""
        try:
            groups = tomllib.loads(text)
        except tomllib.TOMLDecodeError as e:
            line = re.search(r"line (\d+)", str(e))
            raise InputError(f"{e}\n  --> {path}:{line.group(1) if line else len(text.splitlines())}") from None
        groups = {name: _lists(path, text, name, keys) for name, keys in groups.items()}
    if mark and not set(groups) & set(GROUPS):
        raise InputError(f"'{path}' holds one scene, not a study of many: 'hdengine run {path}' solves it")
    for group, keys in groups.items():
        valid = GROUPS.get(group, ())
        if group not in GROUPS:
            raise InputError(f"unknown group {mark}{group}; valid: {', '.join(mark + g for g in GROUPS)}\n"
                             f"  --> {path}{_line(text, group)}")
        for key in keys:
            if valid and key not in valid:
                raise InputError(f"unknown key '{key}' of {mark}{group}; valid: {', '.join(sorted(valid))}\n"
                                 f"  --> {path}{_line(text, key)}")
    return groups


def _text(path):
    """A text file."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as e:
        raise FileError(f"'{path}' cannot be read: {e}") from None


def _line(text, name):
    """':line' of a group or key, as far as a search finds it."""
    name = re.escape(name.rsplit(".", 1)[-1])
    for number, line in enumerate(text.splitlines(), 1):
        if re.match(rf"\s*(\[\s*{name}\s*\]|[\w.\"']*\b{name}[\"']?\s*=)", line):
            return f":{number}"
    return ""


def _lists(path, text, name, keys):
    """'group.key' to a list of values, from nested tables."""
    if not isinstance(keys, dict):
        raise InputError(f"'{name}' stands outside of a table; valid: [{'], ['.join(GROUPS)}]\n  --> {path}{_line(text, name)}")
    found = {}  # type: ignore[var-annotated]
    for key, value in keys.items():
        if isinstance(value, dict):
            found |= {f"{key}.{rest}": v for rest, v in _lists(path, text, name, value).items()}
            continue
        found[key] = values = value if isinstance(value, list) else [value]
        for v in (w for item in values for w in (item if isinstance(item, list) else [item])):
            if isinstance(v, bool) or not isinstance(v, (int, float, str)):
                raise InputError(f"'{key}' in [{name}] holds {v!r}; valid: numbers and texts, alone or in a list\n"
                                 f"  --> {path}{_line(text, key)}")
    return found
