#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands and their options: docs/reference/command_line*.md from the parsers themselves.

The pages are made whenever the site is built (docs/conf.py) and are not kept in the repository. Usage: tools/command_line_page.py
"""
import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

from hdengine.cli import make_parser

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs/reference"
PAGES = {  # name of the page: its title and its commands
    "command_line_run": ("Commands that solve: run, plan, study", ("run", "plan", "study")),
    "command_line_results": ("Commands that show results: plot, report, sensitivity, record", ("plot", "report", "sensitivity", "record", "completion")),
    "command_line_surfaces": ("Commands on surfaces and joints", ("surface", "joint")),
    "command_line_teeth": ("Command on teeth", ("teeth",))}
HEAD = """# Command line

Two commands. `hdengine.x` is the engine: it solves one input. `hdengine` is the Python command: it solves too, and plots, plans, sweeps and reports.
Exit codes are listed in [errors](errors.md). These pages show what the commands print with `--help`.
"""


def helps():
    """Help text of every command by its name."""
    beside = Path(sys.executable).with_name("hdengine.x")
    engine = str(beside) if beside.exists() else shutil.which("hdengine.x")
    found = {"hdengine.x": subprocess.run([engine, "--help"], capture_output=True, text=True, check=True).stdout}
    os.environ["COLUMNS"] = "100"
    parser = make_parser()
    found["hdengine"] = parser.format_help()
    commands = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    return found | {f"hdengine {name}": command.format_help() for name, command in commands.choices.items()}


def pages():
    """Text of every page by its name; a command without a page goes to the first."""
    found = helps()

    def shown(names):
        return "".join(f"\n## {name}\n\n```text\n{found.pop(name).strip()}\n```\n" for name in names)

    texts = {name: f"# {title}\n\nWhat the commands print with `--help`. Others: [command line](command_line.md).\n" + shown(f"hdengine {c}" for c in commands)
             for name, (title, commands) in PAGES.items()}
    links = "".join(f"- [{title}]({name}.md)\n" for name, (title, _) in PAGES.items())
    toctree = "\n".join(PAGES)
    return texts | {"command_line": f"{HEAD}\n{links}{shown(list(found))}\n```{{toctree}}\n:hidden:\n\n{toctree}\n```\n"}


def write():
    """Write the pages where they differ."""
    for name, text in pages().items():
        path = FOLDER / f"{name}.md"
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


if __name__ == "__main__":
    write()
