#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests require, by subject: docs/reference/requirements.md from docstrings (Python) and messages of checks (Fortran).

The page is made whenever the site is built (docs/conf.py) and is not kept in the repository. Usage: tools/requirements_page.py
"""
import ast
import html
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/reference/requirements.md"
HEAD = """# What the tests require

One sentence per test, by subject; made from `tests/` when this site is built. `./hd test` passes them all. A touch opens a subject.
"""


def python_tests(path):
    """Subject of a file, and (name, sentence) of its tests."""
    tree = ast.parse(path.read_text())
    tests = [(n.name, " ".join((ast.get_docstring(n) or "").split())) for n in tree.body
             if isinstance(n, ast.FunctionDef) and n.name.startswith("test_")]
    subject = (ast.get_docstring(tree) or path.stem).split("\n\n")[0]
    return " ".join(subject.replace("`", "").split()), tests


def fortran_checks(path):
    """Messages of the checks of a file; what a message puts together at run time is shown as '...'."""
    text = re.sub(r"&\s*\n\s*", "", path.read_text())
    for call in re.findall(r"call check\((.*)\)\s*$", text, re.M):
        parts = re.split(r"'((?:[^']|'')*)'", call)
        message, last = "...", len(parts) - 1
        if not parts[last].strip():
            message = ""
        for i in range(last - 1, 0, -1):  # from the end: texts joined by //, up to the comma before the message
            if i % 2:
                message = parts[i].replace("''", "'") + message
                continue
            comma = re.sub(r"\([^()]*\)", "", parts[i]).rpartition(",")
            if comma[2].strip("/ "):
                message = "..." + message
            if comma[1]:
                break
        else:
            if re.sub(r"\([^()]*\)", "", parts[0]).rpartition(",")[2].strip("/ "):
                message = "..." + message
        if re.search(r"[a-z]{3}", message):
            yield message


def folded(subject, path, sentences):
    """What one file of tests requires, under a line that opens it."""
    lines = "\n".join(f"- {sentence}" for sentence in sentences)
    return f"\n<details>\n<summary>{html.escape(subject, quote=False)}</summary>\n\n`{path.relative_to(ROOT)}`\n\n{lines}\n\n</details>\n"


def page():
    """The page as text."""
    parts, count = [HEAD], 0
    for path in sorted((ROOT / "tests/python").glob("test_*.py")):
        subject, tests = python_tests(path)
        count += len(tests)
        parts.append(folded(subject, path, [sentence for _, sentence in tests]))
    for path in sorted((ROOT / "tests/fortran").glob("test_*.f90")):
        checks = list(dict.fromkeys(fortran_checks(path))) or ["see the file: its messages are made at run time"]
        count += len(checks)
        parts.append(folded(f"{path.stem.removeprefix('test_').replace('_', ' ').capitalize()} (Fortran)", path, checks))
    return "".join(parts), count


def write():
    """Write the page; returns the number of requirements."""
    text, count = page()
    PAGE.write_text(text)
    return count


if __name__ == "__main__":
    print(f"{write()} requirements: {PAGE.relative_to(ROOT)}")
