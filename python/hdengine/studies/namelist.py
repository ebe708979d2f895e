# SPDX-License-Identifier: GPL-3.0-or-later
"""Namelist files whose keys may be dotted (`load.torque = 1, 3, 5`), for studies; scenes are read by the engine."""
from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from .._engine import FileError, InputError
from .._types import PathLike

_TOKEN = re.compile(r"""\s*(?:(?P<group>&\w+)|(?P<end>/)|(?P<text>'(?:[^']|'')*'|"[^"]*")|(?P<equal>=)|(?P<comma>,)
                        |(?P<word>[^\s,=/'"!&]+)|(?P<bad>.))""", re.X)


def _value(kind, word):
    """Text, logical, integer or real of one word."""
    if kind == "text":
        return word[1:-1].replace("''", "'") if word[0] == "'" else word[1:-1]
    if word.lower() in (".true.", ".false."):
        return word.lower() == ".true."
    for convert in (int, lambda w: float(w.lower().replace("d", "e"))):
        try:
            return convert(word)
        except ValueError:
            pass
    return word


def _tokens(text):
    """(kind, word, line) of a text without its comments."""
    for number, line in enumerate(text.splitlines(), 1):
        bare = re.sub(r"""('[^']*'|"[^"]*")|!.*""", lambda m: m.group(1) or "", line)
        for match in _TOKEN.finditer(bare.rstrip()):
            if match.lastgroup:
                yield match.lastgroup, match.group(match.lastgroup), number


def read(path: PathLike) -> Any:
    """Groups of a namelist file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    dict of dict of list
        groups[group][key] is the list of values, in the order of the file.

    Raises
    ------
    FileError
        The file cannot be read.
    InputError
        With file and line.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as e:
        raise FileError(f"'{path}' cannot be read: {e}") from None
    groups: dict[str, dict] = {}
    group, key = None, None

    def fault(line, what):
        return InputError(f"{what}\n  --> {path}:{line}")

    tokens = [*_tokens(text)]
    for i, (kind, word, line) in enumerate(tokens):
        follows = tokens[i + 1][0] if i + 1 < len(tokens) else ""
        if kind == "group":
            if group is not None:
                raise fault(line, f"'{word}' before the '/' of &{group}")
            group, key = word[1:].lower(), None
            if group in groups:
                raise fault(line, f"group &{group} stands twice")
            groups[group] = {}
        elif group is None:
            raise fault(line, f"'{word}' stands outside of a group")
        elif kind == "end":
            group = None
        elif kind == "word" and follows == "equal":
            key = word.lower()
            if key in groups[group]:
                raise fault(line, f"'{key}' stands twice in &{group}")
            groups[group][key] = []
        elif kind in ("word", "text") and key:
            times, star, rest = word.partition("*")
            repeat = kind == "word" and star and times.isdigit()
            groups[group][key] += [_value(kind, rest)] * int(times) if repeat else [_value(kind, word)]
        elif kind not in ("equal", "comma") or not key:
            raise fault(line, f"'{word}' is not expected here")
    if group is not None:
        raise fault(len(text.splitlines()), f"the '/' of &{group} is missing")
    return groups
