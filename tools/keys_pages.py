#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The input keys by subject: docs/reference/parameters.md and keys_*.md from what `hdengine.x --explain all` prints.

Usage: tools/keys_pages.py; run it after a change of the table of parameters. tests/python/test_pages.py holds pages and engine together.
"""
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs/reference"
PAGES = {  # name of the page: its title, its groups, what they say
    "keys_run": ("Keys of a run, its solver and its output", ("hd_input", "run", "solver", "output"), "title, tolerance, solver, files"),
    "keys_bodies": ("Keys of cup, ring and material", ("geometry", "cup", "material"), "lengths, sections of the cup, elastic constants"),
    "keys_mesh": ("Keys of mesh and contact", ("mesh", "contact"), "elements, rows, friction, contact law"),
    "keys_wave_generator": ("Keys of the wave generator", ("wave_generator",), "cam, interference, how the ring is held"),
    "keys_load": ("Keys of load and support", ("load",), "torque, steps, support, teeth"),
    "keys_drive": ("Keys of the whole drive", ("bearing", "loop", "turning", "fatigue"), "balls, loop of torques, turn of the cam, fatigue"),
    "keys_joint": ("Keys of the rough joint", ("joint",), "law of the joint, roughness, hardness"),
    "keys_surface": ("Keys of a surface", ("surface",), "heights to generate or to read"),
    "keys_fit": ("Keys of a fit", ("fit",), "how D and G are fitted")}


def sections():
    """Text of each group of the engine's page, without its heading."""
    beside = Path(sys.executable).with_name("hdengine.x")
    engine = str(beside) if beside.exists() else shutil.which("hdengine.x")
    text = subprocess.run([engine, "--explain", "all"], capture_output=True, text=True, check=True).stdout
    return {part.split("\n", 1)[0]: part.split("\n", 1)[1].strip() for part in re.split(r"^## &", text, flags=re.M)[1:]}


def pages():
    """Text of every page by its name."""
    found = sections()
    shown = [group for _, groups, _ in PAGES.values() for group in groups]
    if sorted(shown) != sorted(found):
        raise ValueError(f"groups without a page, or pages without a group: {sorted(set(shown) ^ set(found))}; change PAGES")
    rows = "\n".join(f"| [{title}]({name}.md) | {', '.join(f'`&{g}`' for g in groups)} | {what} |" for name, (title, groups, what) in PAGES.items())
    texts = {"parameters": f"""# Input keys

Every key of an input file, by its subject. `hdengine.x --explain KEY` shows one key, `hdengine.x --explain all` all of them. All values are in SI units.
Search finds a key by its name, as `load.torque`.

| page | groups | keys |
|---|---|---|
{rows}

```{{toctree}}
:hidden:

{chr(10).join(PAGES)}
```
"""}
    for name, (title, groups, _) in PAGES.items():
        parts = "\n\n".join(f"## &{group}\n\n{found[group]}" for group in groups)
        texts[name] = f"# {title}\n\nValues are in SI units. Other groups: [input keys](parameters.md).\n\n{parts}\n"
    return texts


def write():
    """Write all pages."""
    for name, text in pages().items():
        (FOLDER / f"{name}.md").write_text(text)


if __name__ == "__main__":
    write()
