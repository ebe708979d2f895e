# SPDX-License-Identifier: GPL-3.0-or-later
"""Shards of a study: their parts make the table of one machine, whatever happens to a shard on the way."""
import errno
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from conftest import ROOT
from hdengine import InputError, StoppedError
from hdengine._engine import FileError
from hdengine.cli import main
from hdengine.studies import shard, workers
from hdengine.studies import study as study_module
from hdengine.studies.study import Study

TOML = f"""[study]
scene = "{ROOT}/data/cd14.nml"
rows = "last"
[fixed]
mesh.band_facets = 3
load.assembly_steps = 1
load.torque_steps = 1
[grid]
mesh.divisions = [16, 20]
wave_generator.w = [0.18e-3, 0.19e-3, 0.20e-3, -1.0]
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    """Name of a study of eight points, two of them not valid, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(TOML)
    return "s.toml"


@pytest.mark.parametrize("words, what", [(["--collect"], "no file"), (["--shard", "2/2"], "no regular file")])
def test_parts_are_files(tmp_path, words, what, capsys):
    """A pipe in the place of a part is refused at once, when parts are collected and when it is solved; so are brackets in brackets."""
    (tmp_path / "s.toml").write_text("[fixed]\nload.torque = 2\n")
    (tmp_path / "o").mkdir()
    os.mkfifo(tmp_path / "o/part-2.jsonl")
    assert main(["study", str(tmp_path / "s.toml"), "--out", str(tmp_path / "o"), *words]) == 3
    assert what in capsys.readouterr().err
    (tmp_path / "o/part-2.jsonl").unlink()
    (tmp_path / "o/part-2.jsonl").write_text("[" * 100_000 + "\n")
    assert main(["study", str(tmp_path / "s.toml"), "--out", str(tmp_path / "o"), *words]) == 3
    assert "is not as a shard left it" in capsys.readouterr().err


def test_parts_make_the_table_of_one_machine(study, tmp_path):
    """Three shards, one of them killed in the middle of a line and started again: table and description byte for byte."""
    assert main(["study", study, "--out", "one", "-q"]) == 0
    for i in (1, 2, 3):
        assert main(["study", study, "--out", "many", "--shard", f"{i}/3", "-q"]) == 0
    part = tmp_path / "many/part-2.jsonl"
    whole = part.read_bytes()
    part.write_bytes(whole[:whole.index(b"\n", whole.index(b"\n") + 1) + 40])
    with pytest.raises(FileError, match=r"shards are not finished: 2/3 \(2 of 3 points\)"):
        shard.collect(Study.read(study), "many")
    assert '"status": "unfinished"' in (tmp_path / "many/study.json").read_text()
    (tmp_path / "many/part-1.jsonl").rename(tmp_path / "first")
    (tmp_path / "many/part-1.jsonl").write_text('{"sha')   # killed in its first line
    with pytest.raises(FileError, match=r"shards are not finished: 1/3 \(2 of 2 points\), 2/3 \(2 of 3 points\)"):
        shard.collect(Study.read(study), "many")
    (tmp_path / "first").rename(tmp_path / "many/part-1.jsonl")
    assert main(["study", study, "--out", "many", "--shard", "2/3", "-q"]) == 0
    assert part.read_bytes() == whole
    assert main(["study", study, "--out", "many", "--collect"]) == 0
    for name in ("study.csv", "study.json"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "many" / name).read_bytes(), name


def test_parts_of_one_assembly(study, tmp_path):
    """Points that differ in their torque alone share an assembly, in shards that each solve it anew: the table stays that of one machine."""
    text = (tmp_path / study).read_text().replace("0.20e-3, -1.0]", "0.20e-3]\nload.torque = [1.0, 2.0]").replace('rows = "last"', 'rows = "all"')
    (tmp_path / study).write_text(text)
    for more in (["--out", "one"], *(["--out", "two", "--shard", f"{i}/2"] for i in (1, 2)), ["--out", "two", "--collect"]):
        assert main(["study", study, "-q", *more]) == 0
    assert (tmp_path / "one/study.csv").read_bytes() == (tmp_path / "two/study.csv").read_bytes()


def test_parts_of_drives(tmp_path, monkeypatch):
    """A study of whole drives whose first point is not valid: the parts make its table byte for byte, also the order of the columns, and K1 to K3
    stand once a point."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "d.toml").write_text(f"""[study]
scene = "{ROOT}/data/drive14.nml"
[fixed]
mesh = {{divisions = 16, band_facets = 3}}
load = {{assembly_steps = 1, torque_steps = 1}}
[grid]
wave_generator.clearance = [-1.0, 0.0, 9e-6]
""")
    for shard_of in ([], ["--shard", "2/2"], ["--shard", "1/2"], ["--collect"]):
        assert main(["study", "d.toml", "--out", "many" if shard_of else "one", "-q", *shard_of]) == 0
    for name in ("study.csv", "study.json"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "many" / name).read_bytes(), name
    rows = shard.collect(Study.read("d.toml"), "many").rows
    assert [[r["point"] for r in rows if f"k{i}_nm_per_rad" in r] for i in (1, 2, 3)] == [[1, 2]] * 3


def test_points_are_dealt_largest_first(study):
    """Every point goes to one shard, the work differs by less than one point's, and the largest come first; a loop is as much work as its legs."""
    legs = [shard.work(Study(fixed={"load.assembly_steps": 1, "load.torque_steps": 2, "loop.torques": loop}, grid={"load.torque": [1]}))[0]
            for loop in ([5], [5, -5, 5])]
    assert legs[1] / legs[0] == pytest.approx((1 + 3 * 2) / (1 + 2))
    s = Study.read(study)
    work, dealt = shard.work(s), shard.deal(s, 3)
    assert sorted(sum(dealt, [])) == list(range(8)) and 0 < work[0] == work[3] < work[4] == work[7]
    loads = [sum(work[i] for i in mine) for mine in dealt]
    assert max(loads) - min(loads) < max(work)
    assert all([work[i] for i in mine] == sorted((work[i] for i in mine), reverse=True) for mine in dealt)


def test_a_shard_that_is_killed_goes_on(study, tmp_path):
    """A shard killed at its second point solves the rest when started again, no point twice; a second one beside it is refused."""
    command = [sys.executable, "-m", "hdengine", "study", study, "--out", "k", "--shard", "1/1", "-q"]
    part = tmp_path / "k/part-1.jsonl"
    process = subprocess.Popen(command)
    while not part.exists() or part.read_bytes().count(b"\n") < 3:
        assert process.poll() is None
        time.sleep(0.002)
    os.kill(process.pid, signal.SIGSTOP)
    with pytest.raises(FileError, match=r"another process is at work on 'k/part-1.jsonl'"):
        shard.run_shard(Study.read(study), "k", 1, 1)
    process.kill()
    process.wait()
    before = part.read_bytes()
    before = before[:before.rindex(b"\n") + 1]
    assert subprocess.run(command).returncode == 0
    after = part.read_bytes()
    assert after.startswith(before) and after.count(b"\n") == 9
    assert main(["study", study, "--out", "k", "--collect"]) == 0


def test_parts_of_another_study_are_refused(study, tmp_path):
    """Another scene, number of shards or version is named; --force solves anew; a shard that is none is refused."""
    assert main(["study", study, "--out", "p", "--shard", "2/2", "-q"]) == 0
    s = Study.read(study)
    with pytest.raises(FileError, match="'p/part-2.jsonl' is of another study: its shards is 2, here 4"):
        shard.run_shard(s, "p", 2, 4)
    s.fixed["contact.friction"] = 0.2
    with pytest.raises(FileError, match="'p/part-2.jsonl' is of another study: its sha256"):
        shard.run_shard(s, "p", 2, 2)
    with pytest.raises(FileError, match="'p/part-2.jsonl' is of another study: its sha256"):
        shard.collect(s, "p")
    assert shard.run_shard(s, "p", 2, 2, force=True, show=False) == (4, 2)
    with pytest.raises(FileError, match="holds no part"):
        shard.collect(s, tmp_path)
    assert main(["study", study, "--out", "n", "--shard", ""]) == 2 and not (tmp_path / "n").exists()
    for text in ("", "0/3", "4/3", "3", "a/b", "1/-3"):
        with pytest.raises(InputError, match="must be I/N"):
            shard.number_of(text)


def test_dealing_reads_few_scenes(monkeypatch):
    """A sweep of the torque is dealt from one scene, whatever values are not valid and stand first."""
    read, seen = shard.read_scene, []
    monkeypatch.setattr(shard, "read_scene", lambda *words, **keys: seen.append(keys) or read(*words, **keys))
    grid = {"load.torque": [-1e9, *(0.01 * i for i in range(1, 300))], "mesh__divisions": [-1, 16, 20]}
    work = shard.work(Study(grid=grid))
    assert len(seen) == 3 and work == work[:3] * 300 and work[0] == 0 < work[1] < work[2]
    assert shard.work(Study(grid={k: v[::-1] for k, v in grid.items()})) == work[::-1]


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGSEGV])
def test_a_stopped_worker_leaves_its_point(study, tmp_path, monkeypatch, how, capsys):
    """Points whose workers are stopped from outside are left to do, and said to be, with code 7; a worker that crashes is its point's failure."""
    send, killed = workers._Worker.give, []

    def give(self, task):
        given = send(self, task)
        if task[0] == 4 and not killed:
            killed.append(self.process.send_signal(how))
        return given
    monkeypatch.setattr(workers._Worker, "give", give)
    command = ["study", study, "--out", "w", "--shard", "1/1", "--jobs", "2", "-q"]
    code, told = main(command), capsys.readouterr()
    points = [json.loads(line)["point"] for line in (tmp_path / "w/part-1.jsonl").read_text().splitlines()[1:]]
    if how == signal.SIGSEGV:
        assert code == 0 and len(points) == 8 and "8 points, 3 failed" in told.out
        return
    assert code == StoppedError.code and sorted(points) == [0, 1, 2, 3, 5, 6, 7] and "left to do" in told.err and "4 (signal SIGTERM)" in told.err
    assert main(command) == 0 and "8 points, 2 failed" in capsys.readouterr().out


def test_a_file_system_without_locks(study, monkeypatch):
    """A shard goes on where the file system has no flock; another fault of it is one."""
    def refuse(number):
        def flock(*words):
            raise OSError(number, os.strerror(number))
        return flock
    for number in (errno.ENOSYS, errno.ENOTSUP, errno.ENOLCK):
        monkeypatch.setattr(shard.fcntl, "flock", refuse(number))
        assert main(["study", study, "--out", "f", "--shard", "1/4", "-q"]) == 0
    monkeypatch.setattr(shard.fcntl, "flock", refuse(errno.EIO))
    assert main(["study", study, "--out", "f", "--shard", "1/4", "-q"]) == 3


@pytest.mark.parametrize("entry", ['{"point": 99, "rows": [{"status": "done"}]}', '{"point": -1, "rows": [{"status": "done"}]}',
                                   '{"point": "a", "rows": [{"status": "done"}]}', '{"point": 0, "rows": 7}', '["x"]', '{"point": 0, "rows": [{}]}',
                                   '{"point": 0, "rows": []}', '{"point": 0, "rows": ["x"]}', '{"point": true, "rows": [{"status": "done"}]}'])
def test_wrong_entries_of_a_part(study, tmp_path, entry, capsys):
    """What no shard writes is named with file, line and what is valid; a file whose name has no number is no part."""
    (tmp_path / "e").mkdir()
    head = json.dumps(shard._head(Study.read(study).identity(), 1))
    (tmp_path / "e/part-1.jsonl").write_text(f"{head}\n{entry}\n")
    (tmp_path / "e/part-\u00b2.jsonl").write_text("x\n")
    for words in (["--collect"], ["--shard", "1/1"]):
        assert main(["study", study, "--out", "e", "-q", *words]) == 3
        told = capsys.readouterr().err
        assert "'e/part-1.jsonl' line 2 is not as a shard left it" in told and '"point": 0 to 7' in told and "Traceback" not in told
    (tmp_path / "e/part-1.jsonl").write_text(head.replace('"shards": 1', '"shards": "x"') + "\n")
    assert main(["study", study, "--out", "e", "--collect"]) == 3 and "line 1" in capsys.readouterr().err


def test_a_table_is_read_by_its_parts_alone(study, tmp_path, monkeypatch):
    """Collected, and collected again, no table is read; the rows that are drawn are those of the table; few parts are open at a time."""
    monkeypatch.setattr(shard, "OPEN", 1)
    for i in (1, 2):
        assert main(["study", study, "--out", "c", "--shard", f"{i}/2", "-q"]) == 0
    with monkeypatch.context() as patch:
        patch.setattr(study_module, "read_rows", lambda *words: pytest.fail("read"))
        for _ in range(2):
            kept = shard.collect(Study.read(study), "c").rows
    columns = study_module.columns_of(json.loads((tmp_path / "c/study.json").read_text()))
    assert kept == study_module.read_rows(tmp_path / "c/study.csv", columns) and len(kept) == 8
