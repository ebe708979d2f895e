#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands and their options: docs/reference/command_line.md from the parsers themselves."""
import argparse
import os
import subprocess

from keys_page import engine

from hdengine.cli import make_parser

HEAD = """# Command line

Two commands. `hdengine.x` is the engine: it solves one input. `hdengine` is the Python command: it solves too, and plots, plans, sweeps and reports.
What to do at an exit code: [warnings and errors](errors.md). This page shows what the commands print with `--help`.
"""


def helps():
    """Help text of every command by its name."""
    found = {"hdengine.x": subprocess.run([engine(), "--help"], capture_output=True, text=True, check=True).stdout}
    os.environ["COLUMNS"] = "100"
    parser = make_parser()
    found["hdengine"] = parser.format_help()
    commands = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    return found | {f"hdengine {name}": command.format_help() for name, command in commands.choices.items()}


def page():
    """The page as text."""
    return HEAD + "".join(f"\n## {name}\n\n```text\n{text.strip()}\n```\n" for name, text in helps().items())
