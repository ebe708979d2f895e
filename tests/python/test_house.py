# SPDX-License-Identifier: GPL-3.0-or-later
"""The layout keeps its own rules."""
import re

import pytest
from conftest import ROOT

FLOOR = {"base": 0, "io": 1, "lib": 1, "surface": 2, "joint": 2, "contact": 2, "study": 3, "app": 4, "bindings": 4}
SOURCES = sorted((ROOT / "fortran").rglob("*.f90"))
ROOM = {p.stem: p.parent.name for p in SOURCES} | {"hd_version": "base"}
ALL = SOURCES + sorted((ROOT / "fortran").rglob("*.c")) + sorted((ROOT / "python").rglob("*.py"))


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: p.stem)
def test_floors_look_down(path):
    """A module uses only lower floors and its own room; rooms of one floor never use each other."""
    room = path.parent.name
    for used in re.findall(r"^\s*use\s+(hd_\w+)", path.read_text(), re.M):
        other = ROOM[used]
        assert other == room or FLOOR[other] < FLOOR[room], f"{path.name} ({room}) uses {used} ({other})"


@pytest.mark.parametrize("path", ALL, ids=lambda p: p.stem)
def test_files_are_short_and_licensed(path):
    """No file above 450 lines, each names its licence, none has a line above 132 characters."""
    lines = path.read_text().splitlines()
    assert len(lines) <= 450
    assert "SPDX-License-Identifier: GPL-3.0-or-later" in lines[0]
    assert max(map(len, lines)) <= 132


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: p.stem)
def test_uses_name_what_they_take(path):
    """Every `use` has its `only` list."""
    for line in re.findall(r"^\s*use\b.*", path.read_text(), re.M):
        assert "only:" in line, line


def test_main_is_short():
    """The main program stays under 50 lines."""
    assert len((ROOT / "fortran/app/main.f90").read_text().splitlines()) < 50


@pytest.mark.parametrize("path", [p for p in SOURCES if p.parent.name != "app"], ids=lambda p: p.stem)
def test_library_neither_stops_nor_prints(path):
    """Only the application stops, prints or reads arguments; the log is the one place that writes to the screen."""
    text = re.sub(r"!.*", "", path.read_text())
    assert not re.search(r"^\s*(error\s+)?stop\b|^\s*print\b|get_command_argument", text, re.M | re.I)
    if path.stem != "hd_log":
        assert "output_unit" not in text and not re.search(r"write\s*\(\s*(\*|6)\s*,", text)


def test_foreign_headers_stay_in_lib():
    """MUMPS and METIS are named in their adapters only."""
    for path in SOURCES:
        if path.parent.name != "lib":
            assert "dmumps_struc" not in path.read_text() and "METIS_NodeND" not in path.read_text()


def test_only_the_engine_module_imports_the_extension():
    """One door to the Fortran code."""
    for path in (ROOT / "python/hdengine").glob("*.py"):
        if path.name != "_engine.py":
            assert "import _hdengine" not in path.read_text()


def test_readme_opens_with_two_commands():
    """The first code block of the README holds exactly the two commands that .ci/run and a new user call."""
    block = re.search(r"```\w*\n(.*?)```", (ROOT / "README.md").read_text(), re.S).group(1)
    assert block.splitlines() == ["./hd run", "./hd test"]
    assert "./hd test" in (ROOT / ".ci/run").read_text()


@pytest.mark.parametrize("page", ["README.md", *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("*.md"))])
def test_python_blocks_run(page, tmp_path, monkeypatch):
    """Every Python block of the README and of the docs runs as it stands."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").symlink_to(ROOT / "data")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.S)
    space = {}
    for block in blocks:
        exec(compile(block, page, "exec"), space)


def test_links_lead_somewhere():
    """Every relative link in the README and in the docs names a file that exists."""
    for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
            assert target.startswith("http") or (page.parent / target).exists(), (page.name, target)
