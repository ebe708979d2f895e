# SPDX-License-Identifier: GPL-3.0-or-later
"""Every command and code block of the README and of docs is run; pages made of the sources hold all of them.

A block runs in the order of its page, in a folder that looks like a checkout. `python`: executed. `sh`: executed, must succeed.
`console`: lines after `$` are commands, the others what they print; `...` leaves lines out, numbers hold within 2 %. A block whose first line is
`# NAME.toml`, `! NAME.nml` or `# NAME.csv` is written to that file. `fortran`: lines of a file of data/ that the page names. A block with
`./hd` runs in a copy of the checkout; its line `./hd test` is what .ci/run does. Blocks with `sbatch` run in test_slurm.py, those marked
`<!-- run by tools/prove_install.sh -->` there. `<!-- not run: reason -->` before a block leaves it out.
"""
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import hdengine
from conftest import ROOT, executable

sys.path.insert(0, str(ROOT / "tools"))
import made_pages  # noqa: E402

SHORT = sorted(str(p.relative_to(ROOT)) for room in ("start", "howto") for p in (ROOT / "docs" / room).glob("*.md"))
OWN_TEST = ("docs/reference/command_line",)  # help texts
BLOCK = re.compile(r"(?:<!-- (?:not run: |run by )(?P<why>[^\n]+) -->\n)?^```(?P<kind>[^\n]*)\n(?P<text>.*?)^```", re.S | re.M)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
NOT_RUN = {"docs/start/install.md": "conda-forge is not reachable from the machine that runs the tests"}
PROVED = "tools/prove_install.sh"
BUILT = ROOT / ".venv/stamp-package"


def blocks(page):
    """Kind, text and reason not to run of each block; directives of the site, as {figure}, are none."""
    return [(m["kind"], m["text"], m["why"]) for m in BLOCK.finditer((ROOT / page).read_text()) if not m["kind"].startswith("{")]


def pages_with_blocks():
    """README, start and howto, and every other page that has a block, but for those that a test of their own holds."""
    others = sorted(str(p.relative_to(ROOT)) for room in ("explain", "evidence", "reference") for p in (ROOT / "docs" / room).glob("*.md"))
    return ["README.md", *SHORT, *(p for p in others if not p.startswith(OWN_TEST) and blocks(p))]


PAGES = pages_with_blocks()


def shell(text, folder):
    """Output of commands that must succeed; an expected failure ends in `|| test $? = CODE`."""
    path = f"{Path(executable()).parent}{os.pathsep}{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(["bash", "-e", "-c", text], cwd=folder, capture_output=True, text=True, timeout=300, env={**os.environ, "PATH": path, "HOME": str(folder), "OMP_NUM_THREADS": "1"})
    assert done.returncode == 0, f"{text}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def alike(shown, printed):
    """A printed line is the shown one but for spaces and 2 % of each number."""
    if NUMBER.sub("#", shown).split() != NUMBER.sub("#", printed).split():
        return False
    pairs = zip(map(float, NUMBER.findall(shown)), map(float, NUMBER.findall(printed)))
    return all(a == pytest.approx(b, rel=0.02, abs=1e-12) for a, b in pairs)


def check_console(text, folder):
    """Each command prints the lines that are shown below it, in their order."""
    for part in re.split(r"^\$ ", text, flags=re.M)[1:]:
        command, *shown = part.splitlines()
        printed = iter(shell(command, folder).splitlines())
        for line in shown:
            assert line == "..." or any(alike(line, p) for p in printed), f"$ {command}\ndoes not print: {line}"


def on_slurm(text):
    """Whether a block submits jobs: test_slurm.py runs it."""
    return "sbatch " in text


def copy_checkout(folder):
    """What ./hd builds from, under its own names: with the tests' .venv nothing is built again."""
    for name in ("hd", "meson.build", "meson.options", "pyproject.toml"):
        shutil.copy(ROOT / name, folder)
    for name in ("config", "fortran", "python", "tests/fortran"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "_keys.py"))
    (folder / "data").unlink()  # a coarse drive: the whole one is run by docs/start/first_run.md
    (folder / "data").mkdir()
    scene = (ROOT / "data/drive14.nml").read_text()
    (folder / "data/drive14.nml").write_text(scene.replace("divisions = 86", "divisions = 32").replace("torque_steps = 10", "torque_steps = 2").replace(
        "&run\n", "&run\n  band = .false.\n"))
    (folder / "tools").mkdir()  # the copy has no commit to take its version from: that of the checkout
    (folder / "tools/version.sh").write_text(f"#!/bin/sh\necho {(ROOT / '.venv/version').read_text()}")
    (folder / "tools/version.sh").chmod(0o755)


def check_lines(page, text):
    """A group of namelists stands, line by line, in a file of data/ that the page names."""
    named = re.findall(r"`(data/\w+\.nml)`", (ROOT / page).read_text())
    assert any(text in (ROOT / name).read_text() for name in named), f"{page}: no file of {named} holds\n{text}"


@pytest.mark.parametrize("page", PAGES)
def test_blocks_run(page, tmp_path, monkeypatch):
    """Every block of the page runs as it stands, and prints what the page shows."""
    monkeypatch.chdir(tmp_path)
    for name in ("data", "hpc", "docs"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    space = {}
    for kind, text, why in blocks(page):
        name = re.match(r"[#!] (\S+\.(?:toml|nml|csv))\n", text)
        if why or on_slurm(text):
            continue
        if name:
            (tmp_path / name[1]).write_text(text)
        elif kind == "python":
            exec(compile(text, page, "exec"), space)
        elif kind == "fortran":
            check_lines(page, text)
        elif "./hd " in text:
            if BUILT.exists() and Path(sys.prefix) == ROOT / ".venv":
                copy_checkout(tmp_path)
                shell(text.replace("./hd test\n", ""), tmp_path)
        elif kind == "sh":
            shell(text, tmp_path)
        elif kind == "console":
            check_console(text, tmp_path)
        else:
            raise AssertionError(f"{page}: a block of kind '{kind}' is neither run nor marked")


def test_one_block_is_not_run():
    """One block is not run, for its reason; the build by pip is proved by a tool, and .ci/run does what the README says."""
    marked = {page: [why for _, _, why in blocks(page) if why] for page in PAGES}
    assert {page: whys[-1] for page, whys in marked.items() if whys} == NOT_RUN
    assert sum(marked.values(), []) == [PROVED, *NOT_RUN.values()]
    proved, = (text for page in PAGES for _, text, why in blocks(page) if why == PROVED)
    assert json.loads((ROOT / PROVED).with_suffix(".json").read_text())["commands"] == "; ".join(proved.splitlines()), f"run {PROVED}"
    assert (ROOT / ".ci/run").read_text().endswith("exec ./hd test\n") and "\n./hd test\n" in (ROOT / "README.md").read_text()


def test_shown_output_is_compared():
    """A shown number that is 5 % off, or another word, is found."""
    assert alike("K_TS 3.06e5 N m/rad", "K_TS   3.07e5 N m/rad")
    assert not alike("K_TS 3.06e5 N m/rad", "K_TS 3.25e5 N m/rad") and not alike("K_TS 3.06e5 N", "K 3.06e5 N")
    with pytest.raises(AssertionError):
        check_console("$ echo one 2\none 3\n", ".")


def kept_pages():
    """Pages of docs that the repository keeps: without those that the build of the site makes."""
    made = {ROOT / f"docs/reference/{name}.md" for name in made_pages.PAGES}
    return [p for p in sorted((ROOT / "docs").rglob("*.md")) if p not in made and not {"api", "gallery", "_build"} & set(p.parts)]


def test_pages_have_few_words():
    """The README has at most 60 lines, all of docs at most 35 000 words on 70 pages, with tables and code."""
    assert len((ROOT / "README.md").read_text().splitlines()) <= 60
    pages = kept_pages()
    assert len(pages) <= 70 and sum(len(p.read_text().split()) for p in pages) <= 35_000


def tables(page):
    """Tables of a page as they are shown, each a list of rows of cells: without the targets of links and the marks of code and formulas."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.S | re.M)
    for table in re.findall(r"(?:^\|.*\n)+", text, re.M):
        lines = [line.strip()[1:-1] for line in table.splitlines() if not re.match(r"\|[-| :]+\|$", line)]
        yield [[re.sub(r"\]\([^)]*\)|\{term\}|<[^>]*>|[`$*[]", "", cell).strip() for cell in re.split(r"(?<!\\)\|", line)] for line in lines]


def test_cells_fit_a_line():
    """The longest cells of a table's columns and two characters for each column's edges have at most 150 characters together, what a line of
    960 pixels holds (7 pixels a character); no cell has more than 90."""
    for page in (ROOT / "README.md", *kept_pages()):
        for rows in tables(page):
            longest = [max(map(len, column)) for column in zip(*rows, strict=True)]
            assert sum(longest) + 2 * len(longest) <= 150, (page, longest)
            assert max(longest) <= 90, (page, longest)


def test_glossary_is_sorted():
    """The glossary has each word once, in alphabetical order, and explains it."""
    block = re.search(r"```{glossary}\n(.*?)```", (ROOT / "docs/reference/glossary.md").read_text(), re.S)[1]
    words = re.findall(r"^(\S.*)\n  \S", block, re.M)
    assert words == re.findall(r"^(\S.*)$", block, re.M) and len(words) > 70
    assert [w.lower() for w in words] == sorted({w.lower() for w in words})


def test_keys_page_holds_every_key():
    """The page of keys has every key of a scene, each once."""
    shown = re.findall(r"^\w+\.\w+$", made_pages.PAGES["keys"](), re.M)
    assert len(shown) == len(set(shown)) > 100 and set(shown) == set(hdengine.read_scene(ROOT / "data/cd14.nml"))
