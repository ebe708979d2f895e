#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The input keys by group: docs/reference/keys.md, what `hdengine.x --explain all` prints."""
import re
import shutil
import subprocess
import sys
from pathlib import Path

HEAD = """# Input keys

Every key of an input file, by its group. All values are in SI units. `hdengine.x --explain KEY` shows one key, `hdengine.x --explain all` this page.
Search finds a key by its name, as `load.torque`.

"""


def engine():
    """Path of hdengine.x, of the environment that runs this."""
    beside = Path(sys.executable).with_name("hdengine.x")
    return str(beside) if beside.exists() else shutil.which("hdengine.x")


def page():
    """The page as text."""
    text = subprocess.run([engine(), "--explain", "all"], capture_output=True, text=True, check=True).stdout
    return HEAD + text[re.search(r"^## &", text, re.M).start():]
