# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: points, failing points, resuming, workers, figures."""
import csv
import io
import json
import os
import shutil
import signal
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import hdengine
from conftest import ROOT, call
from hdengine import _engine, uncertainty
from hdengine.cli import main
from hdengine.figures.study import axes_of, draw, plot_study
from hdengine.figures.style import new_axes
from hdengine.report import write_report
from hdengine.studies import progress, shard, workers
from hdengine.studies import study as study_module
from hdengine.studies.study import Study, StudyResult

SMALL = {"mesh.divisions": 16, "mesh.band_facets": 3, "load.assembly_steps": 1, "load.torque_steps": 1}
STUDIES = sorted((ROOT / "data").glob("*.toml"))


def small(**other):
    return Study(str(ROOT / "data/cd14.nml"), **{"grid": {"wave_generator.w": [0.19e-3, 0.20e-3]}, "fixed": SMALL} | other)


@pytest.mark.parametrize("path", STUDIES, ids=lambda p: p.stem)
def test_studies_of_the_paper_are_valid(path):
    """Every study in data/ is read, and the engine accepts the scene of its first forty points."""
    study = Study.read(path)
    for point in study.points[:40]:
        hdengine.read_scene(study.scene, **{**study.fixed, **point})


def test_a_study_says_what_it_varies():
    """Its text names the number of points and the keys, or the torque alone."""
    assert "2 points over load.torque;" in str(Study(grid={"load.torque": [1, 2]}))
    assert "1 points over the torque alone;" in str(Study())


def test_torques_are_drawn_at_their_last_step(tmp_path):
    """A study of final torques is one line of one point each, not one line per load step."""
    result = small(grid={"load.torque": [2.0, 3.0, 4.0]}).run(tmp_path / "t", show=False)
    x, ys, lines = axes_of(result)
    assert (x, lines) == ("load.torque", None)
    axis = new_axes()[1]
    draw(axis, result, x, ys[0], lines)
    assert [line.get_xdata().tolist() for line in axis.lines] == [[2.0, 3.0, 4.0]]
    assert axis.lines[0].get_ydata()[-1] == pytest.approx(1e-6 * result.select(torque_nm=4.0)[0]["k_ts_bonded_nm_per_rad"])


def test_points_with_units_and_words_are_drawn(tmp_path):
    """Values with units are the numbers of the table, words stand along the axis in their order, a column that is not there is named, and a
    range is a list; a key under two names is refused."""
    found = small(grid={"wave_generator.w": ["0.19 mm", "200 um"]}).run(tmp_path / "u", show=False)
    assert [p["wave_generator.w"] for p in small(grid={"wave_generator.w": ["0.19 mm", 2e-4]}).points] == [0.19e-3, 2e-4]
    assert set(found.column("wave_generator.w")) == {0.19e-3, 0.20e-3}
    words = small(grid={"load.support": ["hub", "bearing"], "load.torque": range(1, 2)}).run(tmp_path / "w", show=False)
    axis = new_axes()[1]
    draw(axis, words, "load.support", "normal_force_n", None)
    assert [t.get_text() for t in axis.get_xticklabels()] == ["hub", "bearing"] and [*axis.lines[0].get_xdata()] == [0, 1]
    with pytest.raises(hdengine.InputError, match="no column 'k2_nm_per_rad'"):
        draw(axis, words, "load.support", "k2_nm_per_rad", None)
    for keys in ({"load.torque": 1, "load__torque": 2}, {"load": {"torque": 1}, "LOAD.torque": 2}):
        with pytest.raises(hdengine.InputError, match="'load.torque' is given twice"):
            hdengine.read_scene(**keys)


def test_table_holds_the_runs(tmp_path):
    """The table's numbers are those of single runs, each row carries its keys."""
    result = small().run(tmp_path / "a", show=False)
    assert result.summary["status"] == "complete" and result.summary["failed"] == 0
    for point, w in enumerate((0.19e-3, 0.20e-3)):
        with hdengine.Run(ROOT / "data/cd14.nml", **SMALL, **{"wave_generator.w": w}) as run:
            steps = list(run)
        rows = [r for r in result.rows if r["point"] == point]
        assert [r["k_ts_nm_per_rad"] for r in rows] == pytest.approx([s.k_ts_nm_per_rad for s in steps], rel=1e-12)
        assert all(r["wave_generator.w"] == w for r in rows)
    assert len(result.select(torque_nm=5.0, wave_generator__w=0.2e-3)) == 1
    for ask in (lambda: result.column("k_ts_nm_per_radd"), lambda: result.select(wave_generator__ww=0.2e-3)):
        with pytest.raises(hdengine.InputError, match="did you mean"):
            ask()
    assert hdengine.Study(grid={"contact__friction": [0.1]}).grid == {"contact.friction": [0.1]}
    with pytest.raises(hdengine.InputError, match="a key twice"):
        hdengine.Study(grid={"contact__friction": [0.1], "contact.friction": [0.2]})
    assert {name for r in result.rows for name in r} == {"wave_generator.w", *small()._columns()}   # of which a figure is checked
    assert plot_study(result)[0].stat().st_size > 10000


def test_a_study_of_drives_is_read_by_its_loops(tmp_path):
    """A sweep of a fit draws K1 to K3 and hysteresis over it, a line each and its band; sensitivities take K2 from it; its dataset has one value a
    point, and its report opens with K2 and a row a drive."""
    scene, keys = ROOT / "data/drive14.nml", {"mesh.divisions": 16, "mesh.band_facets": 3, "load.assembly_steps": 1, "load.torque_steps": 1}
    ranges = {"wave_generator.clearance": (0.0, 1.2e-5, "")}
    study = uncertainty.one_at_a_time(scene, ranges, keys)
    study.rows = "torque"
    found = study.run(tmp_path / "d", show=False)
    x, ys, lines = axes_of(found)
    assert (x, lines, ys) == ("wave_generator.clearance", None, [f"k{i}_nm_per_rad" for i in (1, 2, 3)] + ["hysteresis_rad"])
    k2 = {r[x]: r["k2_nm_per_rad"] for r in found.rows if "k2_nm_per_rad" in r}
    for row in found.rows:
        if "k2_nm_per_rad" in row:
            row |= {"k2_nm_per_rad_low": 0.9 * row["k2_nm_per_rad"], "k2_nm_per_rad_high": 1.2 * row["k2_nm_per_rad"]}
    axis = new_axes()[1]
    draw(axis, found, x, "k2_nm_per_rad", lines)
    places, values = axis.lines[-1].get_data()
    assert [*places] == pytest.approx([1e6 * v for v in sorted(k2)]) and [*values] == pytest.approx([1e-3 * k2[v] for v in sorted(k2)])
    ends = [bar[:, 1] for bar in axis.collections[0].get_segments()]
    np.testing.assert_allclose(ends, np.outer(values, [0.9, 1.2]))
    base, tornado = uncertainty.drive_tornado(found, ranges, "k2_nm_per_rad")
    assert base == k2[9e-6] and tornado[x] == (k2[0.0], k2[1.2e-5])
    assert found.dataset()["k2_nm_per_rad"].size == len(k2) == 5
    page = write_report(tmp_path / "d").read_text()
    assert "K2 of the drive" in page and page.index("<h2>Drives</h2>") < page.index("<details>") and f"<td>{1e-3 * k2[0.0]:.5g}</td>" in page


def test_a_failing_point_stops_nothing(tmp_path):
    """Gross slip and a value out of range are kept with their reason, in the last column; the points behind them are solved."""
    study = small(grid={"load.torque": [60.0, 1.0], "contact.friction": [0.15, -1.0]}, fixed=SMALL | {"load.support": "bearing"})
    result = study.run(tmp_path / "f", show=False)
    head = (tmp_path / "f/study.csv").read_text().splitlines()[0].split(",")
    assert (head[0], head[-1]) == ("point", "reason")
    reasons = {r["point"]: r["reason"] for r in result.failures}
    assert "gross slip" in reasons[0] and "out of range" in reasons[1] and "out of range" in reasons[3]
    assert [r["point"] for r in result.rows if r["status"] == "done" and r["torque_nm"] == 1.0] == [2]
    slipped = result.failures[0]
    # a part of the friction stays axial, as the assembly left it: less than the capacity, never more
    assert 0.98 < -slipped["friction_torque_nm"] / slipped["friction_capacity_nm"] < 1
    assert "failed" in repr(result)


def test_time_left_is_that_of_the_points_so_far(monkeypatch, capsys):
    """One point solved in a minute leaves three minutes for three more, whenever the clock began and however many were done before."""
    for start in (0.0, 1e6):
        clock = iter((start, start + 60, start + 80))
        monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda clock=clock: next(clock)))
        shown = progress.Progress(6, done=2)
        shown.step("a")
        shown.step("b", failed=True)
        assert capsys.readouterr().err == "3/6, 3 min 00 s left: a\n4/6, 1 failed, 1 min 20 s left: b FAILED\n"


def test_an_unfinished_study_is_continued(tmp_path, monkeypatch):
    """After an interruption only the missing points are solved, and the table equals that of an undisturbed study.

    The interruption comes between two writings of the table.
    """
    three = {"grid": {"wave_generator.w": [0.19e-3, 0.20e-3, 0.21e-3]}}
    whole = small(**three).run(tmp_path / "whole", show=False)
    solved = []

    def interrupted(*task):
        if len(solved) == 2:
            raise KeyboardInterrupt
        solved.append(task)
        return original(*task)

    original = workers.solve
    monkeypatch.setattr(workers, "solve", interrupted)
    monkeypatch.setattr(study_module, "WRITES_APART", 1e9)
    with pytest.raises(KeyboardInterrupt):
        small(**three).run(tmp_path / "b", show=False)
    assert StudyResult(tmp_path / "b").summary["status"] == "unfinished"
    with pytest.raises(hdengine.FileError, match=r"holds a study: read it by hdengine\.StudyResult"):
        hdengine.load(tmp_path / "b")
    monkeypatch.setattr(workers, "solve", lambda *task: solved.append(task) or original(*task))
    again = small(**three).run(tmp_path / "b", show=False)
    assert len(solved) == 3
    np.testing.assert_array_equal(again.column("k_ts_nm_per_rad"), whole.column("k_ts_nm_per_rad"))


def test_another_study_is_not_overwritten(tmp_path):
    """A folder with another study is refused with code 3; force replaces it."""
    small().run(tmp_path / "c", show=False)
    other = small(grid={"wave_generator.w": [0.21e-3]})
    with pytest.raises(hdengine.FileError, match="another study"):
        other.run(tmp_path / "c", show=False)
    assert len(other.run(tmp_path / "c", force=True, show=False).rows) == 2


def test_what_a_study_did_not_write_stays(tmp_path):
    """A table or figure of somebody else, or of a study whose description is gone, is replaced with force alone, and what another command wrote
    never; a folder with a run and a study is neither plotted nor reported."""
    study = Study(fixed=SMALL | {"load.torque": 1.0})
    for name in ("study.csv", "study.png"):
        folder = tmp_path / name
        folder.mkdir()
        (folder / name).write_text("mine\n")
        shard.run_shard(study, folder, 1, 1, show=False)
        for write in (study.run, shard.collect.__get__(study)):
            with pytest.raises(hdengine.FileError, match=f"holds {name} already: add --force"):
                write(folder)
        assert {p.name for p in folder.iterdir()} == {name, "part-1.jsonl"} and (folder / name).read_text() == "mine\n"
    study.run(tmp_path / "study.csv", force=True, show=False)
    (tmp_path / "study.csv/study.json").unlink()
    with pytest.raises(hdengine.FileError, match=r"holds study\.csv already"):
        study.run(tmp_path / "study.csv", show=False)
    study.run(tmp_path / "study.csv", force=True, show=False)
    with pytest.raises(hdengine.FileError, match="holds a study: choose another folder"):
        hdengine.run(ROOT / "data/cd14.nml", tmp_path / "study.csv", force=True, show=False)
    (tmp_path / "study.csv/summary.json").write_text("{}")
    for write in (lambda f: study.run(f, force=True, show=False), lambda f: shard.run_shard(study, f, 1, 1, force=True, show=False)):
        with pytest.raises(hdengine.FileError, match=r"holds summary\.json of another command"):
            write(tmp_path / "study.csv")
    for command in ("plot", "report"):
        assert main([command, str(tmp_path / "study.csv")]) == 3


def kill_worker_at_work():
    """Kill the worker of this process that computes longest."""
    for _ in range(600):
        time.sleep(0.1)
        children = [int(pid) for task in Path("/proc/self/task").iterdir() for pid in (task / "children").read_text().split()]
        used = {pid: sum(map(int, Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13])) for pid in children}
        if used and max(used.values()) > 100:
            os.kill(max(used, key=used.get), signal.SIGKILL)
            return


def test_workers_give_the_same_table_and_may_die(tmp_path):
    """Two processes give the table of one; a worker that dies marks its point as failed and is replaced."""
    one, two = small().run(tmp_path / "one", show=False), small().run(tmp_path / "two", jobs=2, show=False)
    np.testing.assert_array_equal(one.column("k_ts_nm_per_rad"), two.column("k_ts_nm_per_rad"))
    path = str(ROOT / "data/cd14.nml")
    long = SMALL | {"mesh.divisions": 160, "mesh.band_facets": 24, "load.assembly_steps": 40, "load.torque_steps": 40}
    killer = threading.Thread(target=kill_worker_at_work)
    killer.start()
    results = dict(workers.solve_all([(0, path, long, "last"), (1, path, SMALL, "last")], jobs=2))
    killer.join()
    assert "died (signal SIGKILL" in results[0][0]["reason"] and results[1][0]["status"] == "done"


def test_mutated_studies_are_refused(tmp_path):
    """A row lost, cut or changed in study.csv, and a changed or cut study.json, are errors of code 3 for who reads and who goes on;
    a study that was killed between the two files goes on."""
    study, folder = small(), tmp_path / "s"
    study.run(folder, show=False)
    whole = {name: (folder / name).read_bytes() for name in ("study.csv", "study.json")}
    lines = whole["study.csv"].splitlines(keepends=True)
    changed = [("study.csv", new) for new in (b"".join(lines[:-1]), whole["study.csv"][:-20], b"".join(lines[:2] + lines[1:]),
               whole["study.csv"].replace(b"0.00019", b"0.00018", 1), b"", lines[0], whole["study.csv"] + b"\xff")]
    changed += [("study.json", new) for new in (whole["study.json"][:100], b"[]", b"", b"\xff", whole["study.json"].replace(
        b'"done": 2', b'"done": 1'), whole["study.json"].replace(b'"checksum": "', b'"checksum": "0'))]
    for name, new in changed:
        (folder / name).write_bytes(new)
        for read in (StudyResult, lambda f: study.run(f, show=False)):
            with pytest.raises(hdengine.FileError, match=name.replace("study.json", "study.")):
                read(folder)
        for other, right in whole.items():
            (folder / other).write_bytes(right)
    summary = json.loads(whole["study.json"])
    os.replace(folder / "study.json", folder / "study.json.part")
    Study.run(small(grid={"wave_generator.w": [0.19e-3]}), tmp_path / "t", show=False)
    shutil.copy(tmp_path / "t/study.json", folder / "study.json")  # as an earlier state would be
    assert StudyResult(folder).summary == summary
    assert len(study.run(folder, show=False).rows) == len(lines) - 1


def test_rows_of_another_version_are_kept_only_if_asked(tmp_path, monkeypatch):
    """Rows of another version of the engine are refused with both versions named, taken if told, replaced with force."""
    half = small()
    half.run(tmp_path / "v", show=False)
    monkeypatch.setattr(_engine, "version", lambda: "9.9.9")
    with pytest.raises(hdengine.FileError, match="9.9.9.*--other-version"):
        half.run(tmp_path / "v", show=False)
    monkeypatch.setattr(workers, "solve", lambda *task: pytest.fail("solved again"))
    assert half.run(tmp_path / "v", show=False, other_version=True).summary["versions"] == [hdengine.__version__, "9.9.9"]
    with pytest.raises(pytest.fail.Exception):
        half.run(tmp_path / "v", show=False, force=True)


def test_lines_of_a_figure():
    """Keys that follow x draw no line of their own, too many keys are held at the first point, failed points are not drawn."""
    asked = []

    class Row(dict):
        def get(self, *words):
            asked.append(words)
            return super().get(*words)

    class Table:
        summary = {"figure": {}, "swept": ["a", "b", "c", "d"]}

        def __init__(self, rows):
            self.rows = [Row({"point": i, "status": "done", "torque_nm": 0.0, "k": 1.0, **r}) for i, r in enumerate(rows)]

        @property
        def failures(self):
            return [r for r in self.rows if r["status"] == "failed"]

    def lines(rows, *names):
        axis = new_axes()[1]
        draw(axis, Table(rows), *names)
        assert all((line.get_linestyle() == "None") == (len(line.get_xdata()) == 1) for line in axis.lines)  # one point is a dot
        return [len(line.get_xdata()) for line in axis.lines]

    assert lines([{"a": i, "b": 10 * i} for i in range(3)], "a", "k", "c") == [3]
    grid = [{"a": a, "b": b, "c": c, "d": d} for a in range(2) for b in range(2) for c in range(3) for d in range(2)]
    assert lines(grid, "a", "k", "b") == [2, 2] and lines(grid[:2] + grid[-2:], "a", "k", "a") == [1, 1, 1, 1]
    assert lines([{"a": 1}, {"a": 2}, {"a": 3}, {"a": 3, "point": 2, "status": "failed"}], "a", "k", "c") == [2]
    asked.clear()
    assert lines([{"a": a, "b": b} for a in range(5) for b in range(100)], "a", "k", "b") == [5] * 100
    assert len(asked) < 50 * 500   # no pass over all rows for each line


def test_a_table_is_written_as_csv_writes_it():
    """Lines that are joined are those of csv.writer, with quotes where a text needs them."""
    for cells in (["1.5", "nan", ""], ["a,b", "c"], ['"', "d"], ["e\nf"], ["g\rh"], [1.5, 7, "x"]):
        text = io.StringIO(newline="")
        csv.writer(text).writerow(cells)
        assert study_module._csv_line(cells) == text.getvalue()


def test_axes():
    """Lists side by side make one axis, the grid every combination, the last key fastest."""
    study = Study(together={"load.torque": [1, 2], "geometry.cup_length": [3, 4]}, grid={"wave_generator.w": [5, 6]})
    assert [tuple(p.values()) for p in study.points] == [(1, 3, 5), (1, 3, 6), (2, 4, 5), (2, 4, 6)]
    with pytest.raises(hdengine.InputError, match="differ in length"):
        Study(together={"a.b": [1], "c.d": [1, 2]})


@pytest.mark.parametrize("text, what", [
    ("[grid]\nload.torque = [1, 2\n", "s.toml:2"), ("[grids]\n", "unknown group grids.*s.toml:1"), ("[study]\n\nscen = 'a'\n", "s.toml:3"),
    ("title = 'a'\n", "outside of a table.*s.toml:1"), ("[grid]\nload.torque = true\n", "holds True.*s.toml:2"),
    ("[grid]\nload.torque = []\n", "has no value"), ("[grid]\nload.torque = 1\nload.torque = 2\n", "s.toml:3"),
    ("[study]\ntitle = 'a'\nscene = 5\n", "'scene' of study = 5; valid: a text.*s.toml:3"),
    ("[grid]\nload.torque = [1979-05-27]\n", "valid: numbers and texts"),
    ("[grid]\nload.torque = [1, 2]\n[fixed]\nload.torque = 3\n", "'load.torque' stands in two groups.*s.toml"),
    ("[figure]\ny = 3\n", "figure.y = .3.: must be text.*s.toml"), ("[figure]\ntorque = 'a'\n", "figure.torque = .'a'.: must be numbers"),
    ("[figure]\nkind = 'pie'\n", "figure.kind = 'pie': must be one of series, catalogue"),
    ("[grid]\nload.torque = [1, 2]\n[figure]\nx = 'mesh.divisions'\n", "figure.x = 'mesh.divisions': must be one of load.torque"),
    ("[study]\ntitle = 'a'\n[figure]\nx = 'torque'\n", "figure.x = 'torque': did you mean torque_nm.*must be one of point.*s.toml:4"),
    ("[figure]\ny = ['k_ts_nm_per_rad',\n 'k_tss']\n", "figure.y = 'k_tss'.*s.toml:2"), ("[figure]\nlines = 'k9'\n", "figure.lines = 'k9'.*s.toml:2"),
    ("[fixed]\nload.support = 'hub'\n[figure]\ny = 'k2_nm_per_rad'\n", "figure.y = 'k2_nm_per_rad'.*s.toml:4"),
    ("[fixed]\na.b = " + 5000 * "[" + "\n", "s.toml:2"), ("[fixed]\nmesh.divisions = " + 5000 * "9" + "\n", "s.toml:2"),
    ("[grid]\n" + "".join(f"a.b{i} = {[*range(100)]}\n" for i in range(4)), "100000000 points; valid: up to 1000000"),
])
def test_faults_of_study_files(tmp_path, text, what):
    """A study that is no valid TOML, holds what a study has not, or more points than it may, is refused with its file and line."""
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(hdengine.InputError, match=f"(?s){what}"):
        Study.read(tmp_path / "s.toml")
    with pytest.raises(hdengine.InputError, match="is no study, which ends in .toml"):
        Study.read(ROOT / "data/cd14.nml")


def test_study_files(tmp_path):
    """Numbers, texts and lists of a TOML study arrive as they stand, dotted keys and tables alike; what is not UTF-8 is no study."""
    path = tmp_path / "s.toml"
    path.write_text("[grid]\nload.torque = [1, 2.5e-3]\n\"load.support\" = ['hub', \"bearing\"]\n[fixed]\noutput.positions = [0, 1e-3, 2e-3]\n"
                    "mesh = {divisions = 16}\n[study]\nrows = 'last'\n[figure]\ny = ['friction', 'step']\nx = 'torque_nm'\n")
    study = Study.read(path)
    assert study.grid == {"load.torque": [1, 2.5e-3], "load.support": ["hub", "bearing"]} and list(study.grid)[0] == "load.torque"
    assert study.fixed == {"output.positions": [0, 1e-3, 2e-3], "mesh.divisions": 16} and study.rows == "last"
    assert study.figure == {"y": ["friction", "step"], "x": "torque_nm"} and study.title == "s"
    path.write_text("[grid]\n\"load.torque\" = [2, 3]\nload.torque = [4]\n")
    with pytest.raises(hdengine.InputError, match=r"(?s)'load.torque' stands twice in \[grid\].*s.toml"):
        Study.read(path)
    path.write_bytes(b"[study]\ntitle = '\xff'\n")
    with pytest.raises(hdengine.FileError, match="s.toml"):
        Study.read(path)


def test_command(tmp_path, monkeypatch, capsys):
    """`hdengine study` writes table and figure, a wrong key ends with code 2 before anything is solved."""
    monkeypatch.chdir(tmp_path)
    keys = "\n".join(f"{k} = {v}" for k, v in SMALL.items())
    (tmp_path / "s.toml").write_text(f"[fixed]\n{keys}\n[grid]\nwave_generator.interference = [0, 5e-6]\n")
    assert main(["study", "s.toml"]) == 0
    assert json.loads((tmp_path / "s.out/study.json").read_text())["status"] == "complete"
    assert (tmp_path / "s.out/study.png").exists() and "2 of 2 points" in capsys.readouterr().out
    (tmp_path / "t.toml").write_text("[grid]\nwave_generator.interferenz = [0, 5e-6]\n")
    assert main(["study", "t.toml"]) == 2 and "did you mean 'interference'" in capsys.readouterr().err
    assert main(["plot", str(tmp_path)]) == 3


def test_the_program_hands_a_study_to_the_command(exe, tmp_path):
    """`hdengine.x` runs a study by the command beside it; options pass, assignments are refused, and so is a lone program."""
    path = tmp_path / "two.toml"
    path.write_text("[fixed]\nmesh = {divisions = 16, band_facets = 3}\nload.torque_steps = 1\n[grid]\nload.torque = [1.0, 2.0]\n")
    assert "2 points" in call(exe, path, "--check").stdout
    done = call(exe, path, "-q", "--out", tmp_path / "o")
    assert done.returncode == 0 and len(StudyResult(tmp_path / "o").rows) > 1 and not done.stderr
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/hdengine").write_text("#!/bin/sh\nprintf '<%s>' \"$@\"\n")
    (tmp_path / "bin/hdengine").chmod(0o755)
    for given, handed in ((["-q"], ["-q"]), ([], []), (["--out", "o", "--force"], ["--force", "--out", "o"])):
        told = call(exe, path, *given, env={"PATH": f"{tmp_path}/bin:/usr/bin:/bin"}).stdout
        assert told == "".join(f"<{word}>" for word in ["study", path, *handed]), told
    done = call(exe, path, "load.torque=3", "--out", tmp_path / "p")
    assert done.returncode == 2 and "[fixed]" in done.stderr and not (tmp_path / "p").exists()
    done = call(exe, path, "--out", tmp_path / "p", env={"PATH": ""})
    assert done.returncode == 2 and done.stderr.count("error: ") == 1 and "hdengine study" in done.stderr
    assert not (tmp_path / "p").exists()
