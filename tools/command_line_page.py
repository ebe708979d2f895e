#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands and their options: docs/reference/command_line.md from the parsers themselves.

The page is made whenever the site is built (docs/conf.py) and is not kept in the repository. Usage: tools/command_line_page.py
"""
import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

from hdengine.cli import make_parser

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/reference/command_line.md"
HEAD = """# Command line

Two commands. `hdengine.x` is the engine: it solves one input. `hdengine` is the Python command: it solves too, and plots, plans, sweeps and reports.
Exit codes are listed in [errors](errors.md). This page shows what the commands print with `--help`.
"""


def pages():
    """Name and help text of every command."""
    beside = Path(sys.executable).with_name("hdengine.x")
    engine = str(beside) if beside.exists() else shutil.which("hdengine.x")
    yield "hdengine.x", subprocess.run([engine, "--help"], capture_output=True, text=True, check=True).stdout
    os.environ["COLUMNS"] = "100"
    parser = make_parser()
    yield "hdengine", parser.format_help()
    commands = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    for name, command in commands.choices.items():
        yield f"hdengine {name}", command.format_help()


def write():
    """Write the page where it differs."""
    text = HEAD + "".join(f"\n## {name}\n\n```text\n{shown.strip()}\n```\n" for name, shown in pages())
    if not PAGE.exists() or PAGE.read_text() != text:
        PAGE.write_text(text)


if __name__ == "__main__":
    write()
