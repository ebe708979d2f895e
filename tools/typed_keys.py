#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""python/hdengine/_keys.py: a TypedDict for each group of keys, made of the engine's table of keys, so that editors complete them.

Usage: tools/typed_keys.py [--check]; with --check it says whether the file is out of date, and changes nothing.
"""
import re
import sys
from pathlib import Path

import hdengine
from hdengine import _engine

FILE = Path(__file__).resolve().parents[1] / "python/hdengine/_keys.py"
HEAD = '''# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of a scene by group, for editors and type checkers. Made by tools/typed_keys.py of the engine's table; do not edit."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

'''


def kind(value, explained, unit):
    """Type of a key by its default, the text that explains it and its unit, in which a text may be given: '0.36 mm'."""
    number = "float | str" if unit else "float"
    if isinstance(value, list):
        return f"Sequence[{number}] | {number}"
    if ".true." in explained.partition("valid: ")[2]:
        return "bool | str"
    return {int: "int", float: number, str: "str"}[type(value)]


def text():
    """The module."""
    groups = {}
    for key, value in hdengine.read_scene().items():
        group, name = key.split(".", 1)
        explained = _engine.call_text("explain_text", key)
        unit = re.match(r"&\S+ \S+ = .*? \[(.+)\]\n", explained)
        groups.setdefault(group, []).append((name, kind(value, explained, unit), f"  # {unit[1]}" if unit else ""))
    classes = {group: "".join(part.title() for part in group.split("_")) + "Keys" for group in groups}
    out = HEAD
    for group, keys in groups.items():
        out += f'\nclass {classes[group]}(TypedDict, total=False):\n    """Keys of &{group}."""\n\n'
        out += "".join(f"    {name}: {form}{unit}\n" for name, form, unit in keys) + "\n"
    out += '\nclass SceneKeys(TypedDict, total=False):\n    """Groups of a scene, and every key as group__key."""\n\n'
    out += "".join(f"    {group}: {name}\n" for group, name in classes.items())
    return out + "".join(f"    {group}__{name}: {form}\n" for group, keys in groups.items() for name, form, _ in keys)


if __name__ == "__main__":
    if "--check" in sys.argv:
        sys.exit(FILE.read_text() != text() and f"{FILE} is out of date: tools/typed_keys.py")
    FILE.write_text(text())
