# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference pages say what the engine does."""
import re

import pytest

import hdengine
from conftest import ROOT

REFERENCE = ROOT / "docs/reference"
PLACE = "Columns that tables of steps begin with"


def _described():
    """Names in the first column of the tables, by heading."""
    found, heading = {}, ""
    for line in "\n".join(path.read_text() for path in sorted(REFERENCE.glob("outputs*.md"))).splitlines():
        if line.startswith("## "):
            heading = line[3:]
        elif line.startswith("| `"):
            found.setdefault(heading, []).extend(re.findall(r"`(\w+)`", line.split("|")[1]))
    return found


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """The whole drive, and the cup against its teeth."""
    folder = tmp_path_factory.mktemp("reference")
    coarse = {"mesh.divisions": 24, "mesh.band_facets": 4, "load.assembly_steps": 1, "load.torque_steps": 1}
    return [hdengine.run(ROOT / f"data/{name}.nml", folder / name, True, **coarse, **more)
            for name, more in (("drive14", {"turning.positions": 1}), ("teeth", {}))]


def test_every_column_of_every_table_is_described(runs):
    """Each table of a run has the columns that the page of output files lists, all of them and in no table another."""
    described = _described()
    seen = set()
    for run in runs:
        for path in run.folder.glob("*.csv"):
            columns = path.read_text().split("\n", 1)[0].split(",")
            wanted = described[path.name] + ([] if path.name in ("fatigue.csv", "turning.csv") else described[PLACE])
            if path.name == "teeth.csv" and run is runs[1]:
                wanted = [column for column in wanted if column not in ("flank", "friction_n")]
            assert sorted(columns) == sorted(wanted), path
            seen.add(path.name)
    assert seen == {name for name in described if name.endswith(".csv")}


def test_every_entry_of_the_summary_is_described(runs):
    """Groups of summary.json and entries of its results stand on the page of output files."""
    described = _described()
    for run in runs:
        assert set(run.summary) <= set(described["summary.json"])
        assert set(run.summary["results"]) <= set(described["summary.json"]) | set(described["steps.csv"])


def test_a_drive_prints_what_a_catalogue_states(runs):
    """A run of the whole drive prints K1 to K3, hysteresis and lost motion; another scene does not."""
    assert "\n  drive: K1 " in repr(runs[0]) and "lost motion" in repr(runs[0]) and "K1" not in repr(runs[1])


def test_exit_codes_are_those_of_the_exceptions():
    """The table of exit codes names every exception with its own code."""
    rows = re.findall(r"^\| (\d) \| `(\w+)` \|", (REFERENCE / "errors.md").read_text(), re.M)
    kinds = {k.__name__: k.code for k in vars(hdengine).values() if isinstance(k, type) and issubclass(k, hdengine.HdengineError)}
    del kinds["HdengineError"]
    assert {name: int(code) for code, name in rows} == kinds


def test_python_page_lists_everything_public():
    """Every name of the package is on the page of the Python interface."""
    page = {name for path in ("api.md", "api_surfaces.md") for name in re.findall(r"^   ([\w.]+)$", (REFERENCE / path).read_text(), re.M)}
    named = {part for name in page for part in name.split(".")}
    assert set(hdengine.__all__) <= named
