#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of docs/reference that are made of the sources whenever the site is built, and not kept in the repository.

Usage: tools/made_pages.py; docs/conf.py calls write(). None can be out of date, and no change of a key, a message or an option touches docs.
"""
from pathlib import Path

import command_line_page
import equation_map
import keys_page
import messages_page

FOLDER = Path(__file__).resolve().parents[1] / "docs/reference"
PAGES = {"keys": keys_page.page, "command_line": command_line_page.page, "errors": messages_page.page, "equations": equation_map.page}


def write():
    """Write the pages where they differ."""
    for name, page in PAGES.items():
        path, text = FOLDER / f"{name}.md", page()
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


if __name__ == "__main__":
    write()
