# SPDX-License-Identifier: GPL-3.0-or-later
"""hdengine/_keys.py, which the build makes: a TypedDict for each group of keys, so that editors complete them.

Called with the path of hdengine.x; prints the module, made of what `hdengine.x --explain all` says.
"""
import re
import subprocess
import sys

HEAD = '''# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of a scene by group, for editors and type checkers. Made by python/typed_keys.py of the engine's table."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

'''
ENTRY = re.compile(r"^(\w+)\.(\w+)\n  .*\n\n  Default `(.*?)`(?: ([^,;\n]+))?(?:, chosen by .*?)?; valid: (.*)$", re.M)


def kind(default, unit, valid):
    """Type of a key by its default, its unit, in which a text may be given ('0.36 mm'), and what is valid."""
    number = "float | str" if unit else "float"
    if default.startswith("'"):
        return "bool | str" if ".true." in valid else "str"
    if valid.startswith("numbers"):
        return f"Sequence[{number}] | {number}"
    return number if valid.startswith("number") else "int"


def text(page):
    """The module of a page of all keys."""
    groups = {}
    for group, name, default, unit, valid in ENTRY.findall(page):
        groups.setdefault(group, []).append((name, kind(default, unit, valid), f"  # {unit}" if unit else ""))
    classes = {group: "".join(part.title() for part in group.split("_")) + "Keys" for group in groups}
    out = HEAD
    for group, keys in groups.items():
        out += f'\nclass {classes[group]}(TypedDict, total=False):\n    """Keys of &{group}."""\n\n'
        out += "".join(f"    {name}: {form}{unit}\n" for name, form, unit in keys) + "\n"
    out += '\nclass SceneKeys(TypedDict, total=False):\n    """Groups of a scene, and every key as group__key."""\n\n'
    out += "".join(f"    {group}: {name}\n" for group, name in classes.items())
    return out + "".join(f"    {group}__{name}: {form}\n" for group, keys in groups.items() for name, form, _ in keys)


if __name__ == "__main__":
    print(text(subprocess.run([sys.argv[1], "--explain", "all"], capture_output=True, text=True, check=True).stdout), end="")
