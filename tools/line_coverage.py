#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of the sources that the tests run, by folder, and those of each file that they do not. Called by ./hd coverage.

Usage: tools/line_coverage.py BUILD PYTHON.json (a build with counters of gcov, and what coverage.py wrote)
"""
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def fortran_lines(build):
    """File to (lines run, lines not run). A line of an included file counts as run where any module that includes it runs it."""
    found = {}
    for data in sorted(Path(build).resolve().rglob("*.gcda")):
        done = subprocess.run(["gcov", "--json-format", "--stdout", data], cwd=build, capture_output=True, text=True)
        for text in done.stdout.splitlines():
            for file in json.loads(text)["files"]:
                name = file["file"].removeprefix("../")
                if name.startswith("fortran/") and (ROOT / name).exists():  # not what f2py writes
                    counts = found.setdefault(name, {})
                    for line in file["lines"]:
                        counts[line["line_number"]] = counts.get(line["line_number"], 0) + line["count"]
    return {name: ([n for n, c in counts.items() if c], sorted(n for n, c in counts.items() if not c)) for name, counts in found.items()}


def python_lines(path):
    """As `fortran_lines`."""
    files = json.loads(Path(path).read_text())["files"]
    return {"python/hdengine/" + name.partition("/hdengine/")[2]: (data["executed_lines"], data["missing_lines"]) for name, data in files.items()}


def ranges(lines):
    """Line numbers as text: 3-5, 9."""
    parts = []
    for n in lines:
        if parts and parts[-1][1] == n - 1:
            parts[-1][1] = n
        else:
            parts.append([n, n])
    return ", ".join(f"{a}-{b}" if b > a else str(a) for a, b in parts)


def share(run, missed):
    """Per cent of the lines that were run."""
    return 100 * run / max(1, run + missed)


def show(files):
    """Print shares by folder, then the lines of each file that no test runs."""
    rooms = {}
    for name, (run, missed) in files.items():
        room = rooms.setdefault(name.rpartition("/")[0], [0, 0])
        room[0] += len(run)
        room[1] += len(missed)
    for name, (_, missed) in sorted(files.items(), key=lambda item: -len(item[1][1])):
        if missed:
            print(f"{name}: {len(missed)} lines not run: {ranges(missed)}")
    for room, (run, missed) in sorted(rooms.items()):
        print(f"{room}: {share(run, missed):.1f} % of {run + missed} lines")
    print(f"{share(*(sum(r[i] for r in rooms.values()) for i in (0, 1))):.1f} % of the lines are run by the tests")


if __name__ == "__main__":
    show(fortran_lines(sys.argv[1]) | python_lines(sys.argv[2]))
