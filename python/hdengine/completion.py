# SPDX-License-Identifier: GPL-3.0-or-later
"""Shell completion of the command `hdengine`, by shtab (pip install 'hdengine[completion]')."""
from __future__ import annotations

import argparse

from ._check import package
from .contact import read_scene

__all__: list[str] = []
SHELLS = ("bash", "zsh")


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """Completion script of a parser: commands, options, files, keys of scenes.

    Raises
    ------
    InputError
        shtab is not installed.
    """
    shtab = package("shtab", "completion", "completion")
    keys = " ".join(f"{key}=" for key in read_scene())
    words = {"bash": f'_hdengine_keys() {{ compgen -W "{keys}" -- "$1"; compopt -o nospace 2>/dev/null; }}',
             "zsh": f"_hdengine_keys() {{ compadd -S '' -- {keys} }}"}
    for action in _actions(parser):
        if action.dest in ("input", "files"):
            action.complete = shtab.FILE
        elif action.dest == "folder":
            action.complete = shtab.DIRECTORY
        elif action.dest == "assignments":
            action.complete = dict.fromkeys(SHELLS, "_hdengine_keys")
    return shtab.complete(parser, shell, preamble=words)


def _actions(parser):
    """Arguments of the parser and of its subcommands."""
    for action in parser._actions:
        if action.choices and isinstance(action.choices, dict):
            for sub in action.choices.values():
                yield from _actions(sub)
        else:
            yield action
