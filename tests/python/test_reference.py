# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference pages say what the engine does."""
import re
import sys

import pytest

import hdengine
from conftest import ROOT, call, executable

sys.path.insert(0, str(ROOT / "tools"))
import messages_page  # noqa: E402

REFERENCE = ROOT / "docs/reference"
PLACE = "Columns that tables of steps begin with"


def _described():
    """Names in the first column of the tables, by heading."""
    found, heading = {}, ""
    for line in (REFERENCE / "outputs.md").read_text().splitlines():
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
    return [hdengine.run(ROOT / f"{name}.nml", folder / name.split("/")[-1], True, **coarse, **more)
            for name, more in (("tests/cases/pressed_drive", {"turning.positions": 1}), ("data/teeth", {}))]


def test_every_column_of_every_table_is_described(runs):
    """Each table of a run has the columns that the page of output files lists, all of them and in no table another."""
    described = _described()
    seen = set()
    for run in runs:
        for path in run.folder.glob("*.csv"):
            columns = path.read_text().split("\n", 1)[0].split(",")
            wanted = described[path.name] + ([] if path.name in ("fatigue.csv", "turning.csv") else described[PLACE])
            if path.name == "teeth.csv" and run is runs[1]:
                wanted = [column for column in wanted if column not in ("friction_n", "moment_nm")]
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
    """A run of the whole drive prints K1 to K3, hysteresis and lost motion, another scene does not; what it prints of one step is of the torque that
    it names, though the loop ends without one."""
    assert runs[0].torque_nm[-1] == 0 and "  torque 14 N m   normal force" in repr(runs[0]) and "<td>14</td>" in runs[0]._repr_html_()
    assert "\n  drive: K1 " in repr(runs[0]) and "lost motion" in repr(runs[0]) and "K1" not in repr(runs[1])
    said = repr(runs[0]).split("  warning:")[0]
    assert said.count("K_TS") == 1 and "Eq. 45" not in said


def test_exit_codes_are_those_of_the_exceptions():
    """The table of exit codes names every exception with its own code."""
    rows = re.findall(r"^\| (\d) \| `(\w+)` \|", messages_page.page(), re.M)
    kinds = {k.__name__: k.code for k in vars(hdengine).values() if isinstance(k, type) and issubclass(k, hdengine.HdengineError)}
    del kinds["HdengineError"]
    assert {name: int(code) for code, name in rows} == kinds


def test_python_page_lists_everything_public():
    """Every name of the package is on the page of the Python interface."""
    page = set(re.findall(r"^   ([\w.]+)$", (REFERENCE / "api.md").read_text(), re.M))
    named = {part for name in page for part in name.split(".")}
    assert set(hdengine.__all__) <= named


def stands(said, kind):
    """Whether a message that was met is one of the page, of this kind."""
    said = messages_page.tidy(re.sub(r"--> \S+ ", "", " ".join(said.split())))
    patterns = [re.escape(m.text).replace(messages_page.VALUE, ".+").replace("‹", "(?:").replace("›", ")").replace(r"\ /\ ", "|")
                for m in messages_page.messages() if m.kind == kind]
    return any(re.fullmatch(pattern, said) for pattern in patterns)


def test_every_message_is_on_the_page():
    """Every place of the sources that raises an error, or pushes a warning of a run, gives a message to the page."""
    raised = sum(len(re.findall(r"call raise\([^&]*?code_", path.read_text())) for path in (ROOT / "fortran").rglob("*.f90"))
    found = [*messages_page.fortran()]
    assert sum(m.kind in messages_page.CODES for m in found) >= raised > 150
    assert sum(m.kind == "warning" for m in found) > 25
    page = messages_page.page()
    assert all(messages_page.marked(m.text) in page for m in messages_page.messages()) and len(messages_page.messages()) > 350


def test_every_warning_says_what_to_do():
    """A warning has no exit code that says what to do, so its own words do: what to read, change or compare, or what is usual."""
    advice = re.compile(r"\b([Rr]ead|[Tt]ake|[Rr]aise|[Ll]ower|[Uu]se|[Qq]uote|[Cc]ompare|[Jj]udge|[Cc]heck|[Ww]ith support|usual are|stiffer, 1.67|did you mean|"
                        r"rounds it|The log says)\b")
    said = [m.text for m in messages_page.messages() if m.kind == "warning"]
    assert [text for text in said if not advice.search(text) and not text.startswith("joint.model: ")] == []


@pytest.mark.parametrize("kind, keys", [
    ("input", ["wave_generator.w=0.1"]), ("input", ["load.support=drive", "wave_generator.shape=as_formed"]), ("file", ["no_such_file.nml"]),
    ("memory", ["mesh.memory_limit_mb=1"]), ("not_converged", ["load.support=bearing", "load.torque=60", "mesh.divisions=24", "mesh.band_facets=4"])])
def test_a_message_that_is_met_stands_on_the_page(kind, keys, tmp_path):
    """Errors that a run ends with, and its exit code, are those of the page."""
    done = call(executable(), *([ROOT / "data/cd14.nml"] if "=" in keys[0] else []), *keys, "--out", tmp_path / "r")
    assert done.returncode == messages_page.CODES[kind][0]
    said = done.stderr[done.stderr.index("error: "):] if "error: " in done.stderr else done.stdout
    assert any(stands(part, kind) for part in re.split(r"(?=error: )", said) if part), said


def test_a_warning_that_is_met_stands_on_the_page(runs):
    """All warnings of two runs are those of the page."""
    met = [said for run in runs for said in run.summary["warnings"]]
    assert met and [said for said in met if not stands(said, "warning")] == []
