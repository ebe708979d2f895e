# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmark scripts share."""
import importlib
import re
import sys
import time

import pytest

import hdengine
from conftest import ROOT
from hdengine.studies.planner import mesh_of_level

sys.path.insert(0, str(ROOT / "bench"))
import common  # noqa: E402


def test_series_is_the_engines():
    """The mesh of a level is that of the planner: rows and divisions of level 4 of CD-14-100, finer with every level, 13 of them."""
    meshes = [mesh_of_level(level) for level in range(1, 14)]
    assert meshes[3] == {"mesh.band_facets": 12, "mesh.divisions": 72}
    for before, after in zip(meshes, meshes[1:]):
        assert after["mesh.band_facets"] > before["mesh.band_facets"] and after["mesh.divisions"] > before["mesh.divisions"]
    with pytest.raises(hdengine.InputError, match="valid are 1 to 13"):
        mesh_of_level(14)


def test_every_benchmark_is_listed():
    """Each script of bench/ that can be called stands in the list of `./hd bench`, and the house of benches stays small."""
    known, scripts = importlib.import_module("all").known(), [*(ROOT / "bench").glob("*.py")]
    assert {path.stem for path in scripts if "__main__" in path.read_text()} - {"all", "tables"} == set(known) - {"court"}
    assert len(scripts) <= 25 and sum(len(path.read_text().splitlines()) for path in scripts) <= 4500
    assert sum(path.stat().st_size for path in (ROOT / "bench/results").iterdir()) <= 1.5e6


def test_every_record_is_shown_or_held():
    """Each record of bench/results is read by a table of a page, or by a test."""
    from tables import TABLES
    shown = {name for _, names, _ in TABLES.values() for name in names}
    tests = "".join(path.read_text() for path in (ROOT / "tests/python").glob("*.py"))
    assert [path.name for path in (ROOT / "bench/results").iterdir() if path.stem not in shown and f"results/{path.name}" not in tests] == []


def test_every_figure_has_a_script_and_a_page():
    """A script writes each figure of the pages, and a page or the README shows it."""
    pages = "".join(path.read_text() for path in (*(ROOT / "docs").rglob("*.md"), ROOT / "README.md"))
    scripts = "".join(path.read_text() for path in (*(ROOT / "bench").glob("*.py"), *(ROOT / "docs/drawings").glob("*.py")))
    charts = {f"speed/{chart['name']}" for chart in common.read_record("pareto")["charts"]}
    for path in (ROOT / "docs/figures").rglob("*.png"):
        name = str(path.relative_to(ROOT / "docs/figures"))[:-4]
        assert f"figures/{name}.png" in pages, f"{name}: no page shows it"
        assert name in charts or re.search(rf'save_figure\(.*"{name}"|(figures/|FIGURES / ")[^"]*{name}\.png', scripts), f"{name}: no script writes it"


def test_calls_take_turns():
    """Timed calls alternate, and each turn of each call is timed by itself."""
    order = []
    seconds, results = common.take_turns({"a": lambda: (order.append("a"), time.sleep(2e-3)), "b": lambda: order.append("b")}, turns=3)
    assert order == ["a", "b"] * 3 and set(results) == {"a", "b"}
    assert min(seconds["a"]) >= 2e-3 > min(seconds["b"]) and len(seconds["a"]) == len(seconds["b"]) == 3


def test_records_say_where_they_come_from(tmp_path, monkeypatch):
    """A record holds commit, machine, versions and seed beside its facts, and reads back as the facts alone."""
    monkeypatch.setattr(common, "RESULTS", tmp_path)
    path = common.write_record("some", [{"x": 1}], seed=3)
    text = path.read_text()
    assert all(f'"{word}"' in text for word in ("commit", "machine", "versions", "seed")) and common.read_record("some") == [{"x": 1}]
    assert [p.name for p in tmp_path.iterdir()] == ["some.json"]
    common.add_row("lines", {"scene": 1, "y": 2})
    common.add_row("lines", {"scene": 1, "y": 3})
    assert common.read_rows("lines", "scene")[1]["y"] == 3


def test_commands_are_measured():
    """A command's exit code, CPU seconds, memory and output are its own; one that hits its limit has no code."""
    done = common.measured([sys.executable, "-c", "print(sum(range(10**6))); raise SystemExit(3)"])
    assert done.code == 3 and 0 < done.cpu_s < 30 and done.memory_mb > 1 and done.text.strip() == "499999500000"
    assert common.measured([sys.executable, "-c", "while True: pass"], limit=1).code is None
