# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are written: whole or an error, in their own folder, on every kind of stream and path."""
import contextlib
import ctypes
import io
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import traceback
from pathlib import Path

import numpy as np
import pytest
from test_planner import QUICK
from test_regressions import rough_map

import hdengine
from conftest import CD14, ROOT, call
from hdengine import drive, record, uncertainty
from hdengine.cli import main, make_parser
from hdengine.figures import style
from hdengine.prediction import command as prediction
from hdengine.teeth import command as teeth

WORDS = ["mesh.divisions=16", "mesh.band_facets=3", "load.assembly_steps=1", "load.torque_steps=1"]
SURFACE = ["surface.nx=32", "surface.ny=24", "surface.ridges=3"]
FILL = [sys.executable, "-m", "hdengine"]
DRIVE = ["mesh.divisions=24", "mesh.band_facets=4", "load.assembly_steps=1", "load.torque_steps=1", "bearing.balls=12",
         "load.tooth_pairs=12", "loop.torques=6", "turning.positions=1"]
LIBC = ctypes.CDLL(None, use_errno=True)
EVERY = ("press fit", "surface", "drive")   # commands that write files one after the other, of which each is tried
GO_ON = dict.fromkeys(("press fit", "drive"), ["--resume"]) | dict.fromkeys(("surface", "planned", "run"), ["--force"])   # after a failure
PICTURE_END = b"IEND\xaeB`\x82"
STUDY = "[fixed]\nmesh = {divisions = 16, band_facets = 3}\nload.torque_steps = 1\n[grid]\nload.torque = [2, 3]\n"


def commands(exe="", folder=None):
    """A command by name that writes into r, with what it needs beside it."""
    if folder:
        (folder / "s.toml").write_text(STUDY)
        np.save(folder / "map.npy", rough_map())
    study = [*FILL, "study", "s.toml", "--out", "r", "-q"]
    return {
        "press fit": [exe, CD14, *WORDS, "output.vtu=all", "--out", "r"],
        "surface": [exe, ROOT / "data/surface.nml", *SURFACE, "--out", "r"],
        "drive": [exe, ROOT / "tests/cases/pressed_drive.nml", *DRIVE, "--out", "r"],
        "planned": [exe, CD14, *QUICK, "load.torque_steps=0", "--out", "r"],
        "run": [*FILL, "run", CD14, *WORDS, "--out", "r"],
        "study": study,
        "shard": [*study, "--shard", "1/1"],
        "collect": [*study, "--collect"],
        "record": [*FILL, "record", ROOT / "data/torque_record.csv", "--out", "r"],
        "joint": [*FILL, "joint", "map.npy", "--dx", "1e-6", "--model", "spectrum", "--out", "r"],
        "surface map": [*FILL, "surface", "map.npy", "--dx", "1e-6", "--out", "r"],
        "teeth": [*FILL, "teeth", ROOT / "data/drive14.nml", "--profile", "involute", "--module", "0.1778e-3", "--out", "r"],
        "new": [*FILL, "new", "20", "mesh.divisions=16", "mesh.band_facets=3", "--out", "r"],
        "plot": [*FILL, "plot", "r"],
        "report": [*FILL, "report", "r"],
        "export": [*FILL, "export", "r", "--to", "inp"],
        "compiled": [*FILL, "export", "r", "--to", "fmu"],
        "sensitivity": [*FILL, "sensitivity", "r", "--draws", "1"],
        "plan": [*FILL, "plan", CD14, "--tolerance", "0.5"],
        "completion": [*FILL, "completion", "bash"],
    }


def run_in(folder, words, **options):
    """A command in a folder, as a finished process."""
    return subprocess.run([*map(str, words)], cwd=folder, capture_output=True, text=True, timeout=120, **options)


def claims(folder):
    """The records of a folder that say that it is complete."""
    found = []
    for path in folder.glob("**/*.json"):
        if path.is_file() and not path.is_symlink():
            found += [path.name] if json.loads(path.read_text()).get("status") == "complete" else []
    return found


def tree(folder):
    """Bytes of all files below a folder, by path."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def gist(files):
    """What a command leaves each time, timers and roundings aside: names, numbers of lines, ends of pictures and grids."""
    return {name: data.count(b"\n") if name.endswith(("csv", "nml")) else data[-2:] for name, data in files.items() if "history" not in name}


def mount(disk, flags=0, pages=9999, files=999):
    """A disk with so much room; flags 32: the same with more or less."""
    return LIBC.mount(b"tmpfs", bytes(disk), b"tmpfs", flags, f"size={pages * os.sysconf('SC_PAGESIZE')},nr_inodes={files}".encode()) == 0


def own_disks(disk):
    """Let this process alone mount disks, as `unshare -rm` does; whether it may."""
    ids = {"setgroups": "deny", "uid_map": f"0 {os.getuid()} 1", "gid_map": f"0 {os.getgid()} 1"}
    with contextlib.suppress(OSError):
        if LIBC.unshare(0x10020000) == 0:   # CLONE_NEWUSER, CLONE_NEWNS
            for name, text in ids.items():
                Path("/proc/self", name).write_text(text)
            return mount(disk)
    return False


def fill(disk, files, mounted):
    """A folder, or a disk of its own, with these files alone."""
    os.chdir("/")
    LIBC.umount2(bytes(disk), 2)
    shutil.rmtree(disk)
    disk.mkdir()
    assert not mounted or mount(disk)
    for name, data in files.items():
        (disk / name).parent.mkdir(exist_ok=True)
        (disk / name).write_bytes(data)
    os.chdir(disk)


@contextlib.contextmanager
def little(disk, kind, room):
    """Room for so many pages or files more on a disk, or for so many bytes in a file."""
    now, least = os.statvfs(disk), resource.getrlimit(resource.RLIMIT_FSIZE)
    if kind == "bytes":
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, least[1]))
    elif kind == "pages":   # of which 0 would be no limit
        assert mount(disk, 32, pages=max(1, now.f_blocks - now.f_bfree + room))
    else:
        assert mount(disk, 32, files=now.f_files - now.f_ffree + room)
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, least)
        assert kind == "bytes" or mount(disk, 32)


def once(work):
    """Work that takes long, done once: its answer stays the same."""
    found = []
    return lambda *words, **keys: found[0] if found else found.append(work(*words, **keys)) or found[0]


def obey(words):
    """Code and standard error of a command; that of Python without its start."""
    if words[:3] != FILL:
        done = subprocess.run(words, capture_output=True, text=True)
        return done.returncode, done.stderr
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as said:
        return main(words[3:]), said.getvalue()


def starve(disk, words, start, more, every):
    """A command where it finds little room, in a process of its own; whether disks were tried."""
    style.StyledFigure.savefig = lambda _, file, **__: file.write(bytes(30000) + PICTURE_END)
    uncertainty.bands = uncertainty.joint_indices = lambda *_: {}
    for owner, work in ((record.Record, "numbers"), (record.Record, "curve"), (drive, "_gaps"), (teeth, "tooth_gaps"), (prediction, "predict")):
        setattr(owner, work, once(getattr(owner, work)))
    disk.mkdir()
    mounted, whole_or_none = own_disks(disk), words[:3] == FILL and "--out" in words and words[3] not in ("run", "study")
    fill(disk, start, mounted)
    assert obey(words)[0] == 0
    whole = tree(disk)
    sizes = sorted(len(data) for name, data in whole.items() if start.get(name) != data)
    pages = sum(-(-len(data) // 4096) for data in whole.values()) - sum(-(-len(data) // 4096) for data in start.values())
    rooms = [*[("bytes", size - 1) for size in sorted({1, *sizes[-1 if not every else 0:]})], *[("files", n) for n in (0, 2)] * mounted,
             *[("pages", n) for n in (pages // 2, pages - 1, pages)] * mounted] if sizes else []
    for files, room in [(start, room) for room in rooms] + [(whole, room) for room in rooms[-2:-1]] * whole_or_none:
        fill(disk, files, mounted)
        with little(disk, *room):
            code, said = obey([*words, *["--force"] * (files is whole)])
        if code != 0:
            left = tree(disk)
            assert code == 3 and said.count("error: ") == 1 and "Traceback" not in said, (room, said)
            assert re.search(r"'([^']*/)?(r|rim|spring.*)(/[^']+)?'", said) and re.search("No space|too large|is the disk full", said), (room, said)
            assert not whole_or_none or left == files, (room, sorted(left))
            assert ".png'" in said or not [n for n, d in left.items() if files.get(n) != d and b'"status": "complete"' in d], (room, said)
            assert not [n for n, d in left.items() if n.endswith((".part", ".lock")) or (n.endswith(".png") and d[-8:] != PICTURE_END)], room
            if files is whole or not (every or room == rooms[-2]):
                continue
            code, said = obey([*words, *more])
        assert code == 0 and gist(tree(disk)) == gist(whole), (room, said, set(gist(tree(disk)).items()) ^ set(gist(whole).items()))
    return mounted


@pytest.mark.parametrize("name", commands())
def test_a_full_disk_is_an_error(exe, small_run, tmp_path, name):
    """Where a file finds no room, at its first or its last byte, on a disk or under a limit, the command ends with code 3 and one line that
    names it; nothing says that it is complete but what has only its figures to come, no picture is cut, what stood there before stays, and with
    room for all it ends as ever."""
    words = [*map(str, commands(exe, tmp_path)[name])]
    if name == "compiled" and not shutil.which("cc"):
        pytest.skip("no C compiler")
    if name in ("plot", "report", "export", "sensitivity"):
        shutil.copytree(small_run, tmp_path / "r")
    elif name in ("collect", "compiled"):
        assert run_in(tmp_path, commands(exe)["shard" if name == "collect" else "drive"]).returncode == 0
    start = tree(tmp_path)
    said = tmp_path / "said"
    if (child := os.fork()) == 0:
        try:
            said.write_text(str(starve(tmp_path / "disk", words, start, GO_ON.get(name, []), name in EVERY)))
        except BaseException:
            said.write_text(traceback.format_exc())
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    assert said.read_text() in ("True", "False"), said.read_text()
    if said.read_text() == "False":
        pytest.skip("only limits of the size of files were tried: no disk can be mounted (unshare -rm)")


def test_every_command_meets_a_full_disk():
    """The test above holds every command of hdengine."""
    known = make_parser()._subparsers._group_actions[0].choices
    assert {words[3] for words in commands().values() if words[:3] == FILL} == set(known)


@pytest.mark.parametrize("command, last, work", [
    ("record", "scene.nml", "record.Record.numbers"), ("joint", "joint.png", "prediction.command.predict"),
    ("teeth", "gaps.png", "teeth.command.tooth_gaps"), ("surface map", "specimen_bearing.png", "surfaces.texture.texture")])
def test_an_unusable_place_is_found_before_the_work(tmp_path, command, last, work, monkeypatch, capsys):
    """A file in the place of the folder, or above it, and a link in the place of an output are refused before anything is computed."""
    words = {"surface map": ["surface", str(ROOT / "data/specimen_bearing.sdf"), "--out", "r"]}.get(command) or [
        str(word) for word in commands("", tmp_path)[command][len(FILL):]]
    monkeypatch.setattr(f"hdengine.{work}", lambda *_, **__: pytest.fail("work was done"))
    (tmp_path / "file").write_text("mine\n")
    (tmp_path / "r").mkdir()
    (tmp_path / "r" / last).symlink_to(tmp_path / "file")
    for out in ("file", "file/below", "r"):
        assert main([str(tmp_path / out) if word == "r" else word for word in words] + ["--force"]) == 3
        assert capsys.readouterr().err.count("error: ") == 1
    assert (tmp_path / "file").read_text() == "mine\n"


def test_a_named_file_is_replaced_with_force_alone(small_run, tmp_path, capsys):
    """A report and a deck go to a file that is there already, as one of the run itself, with --force alone; a folder that is not there is told
    before the work."""
    mine = tmp_path / "mine"
    mine.write_text("mine\n")
    for words in (["report", str(small_run)], ["export", str(small_run), "--to", "inp"]):
        assert main([*words, "--out", str(mine)]) == 3 and "add --force" in capsys.readouterr().err
        assert main([*words, "--out", str(tmp_path / "none/mine")]) == 3 and "no folder" in capsys.readouterr().err
    assert mine.read_text() == "mine\n"
    assert main(["report", str(small_run), "--out", str(mine), "--force"]) == 0 and mine.read_text().startswith("<!")


def test_what_runs_write_is_replaced_with_force_alone(exe, tmp_path):
    """A file of somebody else with the name of a table stays without --force; an input with such a name is never run."""
    words = ["mesh.divisions=16", "mesh.band_facets=3", "load.torque_steps=0", "output.vtu=none", "--out", tmp_path / "o"]
    (tmp_path / "o").mkdir()
    (tmp_path / "o/steps.csv").write_text("mine")
    done = call(exe, ROOT / "data/cd14.nml", *words)
    assert done.returncode == 3 and "holds steps.csv" in done.stderr and (tmp_path / "o/steps.csv").read_text() == "mine"
    assert call(exe, ROOT / "data/cd14.nml", *words, "--force").returncode == 0
    named = shutil.copy(ROOT / "data/cd14.nml", tmp_path / "history.csv")
    done = call(exe, named, *words[:-2], "--out", tmp_path, "--force")
    assert done.returncode == 3 and "give it another" in done.stderr and named.read_bytes() == (ROOT / "data/cd14.nml").read_bytes()


def test_pictures_follow_no_links(small_run, tmp_path):
    """The moving picture of a report neither follows a link nor waits for a pipe, as figures do not."""
    (tmp_path / "outside").write_text("mine\n")
    for kind in ("link", "pipe"):
        run = shutil.copytree(small_run, tmp_path / f"r {kind}")
        special(run / "steps.gif", kind, tmp_path / "outside")
        assert main(["report", str(run), "--animation"]) == 3 and not (run / "report.html").exists()
    assert (tmp_path / "outside").read_text() == "mine\n"


def special(place, kind, outside):
    """Something else than a free place where an output is to go."""
    place.parent.mkdir(exist_ok=True)
    if kind == "link":
        place.symlink_to(outside)
    elif kind == "dangling":
        place.symlink_to(outside.with_name("none"))
    elif kind == "hard link":
        os.link(outside, place)
    else:
        os.mkfifo(place)


@pytest.mark.parametrize("name", ["press fit", "surface"])
def test_outputs_follow_no_links_and_wait_for_no_pipe(exe, tmp_path, name):
    """A link, a pipe or a second name in the place of any output, with --force too: nothing outside changes or appears, nothing hangs, and
    the command ends with its own files or with code 3 and the name."""
    words, outside = commands(exe, tmp_path)[name], tmp_path / "outside"
    assert run_in(tmp_path, words).returncode == 0
    names = sorted(path.name for path in (tmp_path / "r").iterdir())
    outside.write_text("mine\n")
    tried = 0
    for i, output in enumerate([*names, f"{names[-1]}.part", "hdengine.lock"]):
        for kind in ("link", "pipe", *(["dangling", "hard link"] if i == 1 or output == "hdengine.lock" else [])):
            folder = tmp_path / f"{output}.{kind}".replace(" ", ".")
            special(folder / output, kind, outside)
            done = run_in(tmp_path, [*(folder.name if word == "r" else word for word in words), "--force"])
            assert outside.read_text() == "mine\n" and not (tmp_path / "none").exists()
            assert done.returncode in (0, 3), done.stderr
            if done.returncode == 0:
                assert claims(folder) and not any(p.is_symlink() for p in folder.iterdir() if not p.name.endswith(".part"))
            else:
                assert output in done.stderr and "regular file" in done.stderr and not claims(folder)
            tried += 1
    assert tried > 10


def test_python_writes_through_no_link(tmp_path):
    """A figure, a report and a table of the package neither follow a link nor wait for a pipe; what stood there before stays."""
    from hdengine.files import write_files
    outside = tmp_path / "outside"
    outside.write_text("mine\n")
    for kind in ("link", "dangling", "pipe"):
        special(tmp_path / kind, kind, outside)
        with pytest.raises(hdengine.FileError, match="no regular file"):
            write_files({tmp_path / "first": "new", tmp_path / kind: "new"})
    assert sorted(p.name for p in tmp_path.iterdir()) == ["dangling", "link", "outside", "pipe"] and outside.read_text() == "mine\n"


def test_a_run_resumes_beside_its_copy(exe, tmp_path):
    """A folder of hard links (cp -al) stays as it was while the run, or the shard of a study, that it was made of goes on."""
    shard, part = commands(exe, tmp_path)["shard"], tmp_path / "r/part-1.jsonl"
    assert run_in(tmp_path, shard).returncode == 0
    whole = part.read_bytes()
    part.write_bytes(cut := b"".join(whole.splitlines(True)[:2]))
    os.link(part, tmp_path / "copy.jsonl")
    assert run_in(tmp_path, shard).returncode == 0
    assert [line.split(b",")[0] for line in part.read_bytes().splitlines()] == [line.split(b",")[0] for line in whole.splitlines()]
    assert (tmp_path / "copy.jsonl").read_bytes() == cut
    part.unlink()
    with hdengine.Run(CD14, tmp_path / "r", **dict(word.split("=") for word in WORDS)) as run:
        run.advance()
    (tmp_path / "copy").mkdir()
    for path in (tmp_path / "r").iterdir():
        os.link(path, tmp_path / "copy" / path.name)
    before = {path.name: path.read_bytes() for path in (tmp_path / "copy").iterdir()}
    assert call(exe, CD14, *WORDS, "--out", tmp_path / "r", "--resume").returncode == 0
    assert before == {path.name: path.read_bytes() for path in (tmp_path / "copy").iterdir()}


def test_closed_and_full_streams(exe, tmp_path):
    """Closed standard streams change no file and no exit code, a full one ends with code 3 and one line; the results are there."""
    run = [exe, CD14, *WORDS, "--out", "r", "--force"]
    assert run_in(tmp_path, run).returncode == 0
    whole = (tmp_path / "r/contact.csv").read_bytes()
    for words in (run, [*FILL, *run[1:]], [*FILL, "completion", "bash"]):
        words = [*words[:3], "run", *words[3:]] if words[3:4] == [CD14] else words
        for closed in ((1,), (2,), (0, 1, 2))[2 * (words is not run):]:
            done = run_in(tmp_path, words, preexec_fn=lambda: [os.close(file) for file in closed])
            assert done.returncode == 0 and "Traceback" not in done.stderr, (closed, done.stderr)
        with open("/dev/full", "w") as full:
            done = subprocess.run([*map(str, words)], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True)
        assert done.returncode == 3 and done.stderr.count("standard output: No space left on device") == 1, done.stderr
        assert "Traceback" not in done.stderr and "Exception" not in done.stderr
        assert (tmp_path / "r/contact.csv").read_bytes() == whole and claims(tmp_path / "r")


def test_streams_that_know_few_letters(exe, tmp_path):
    """A title beyond ASCII on a stream of ASCII, and no standard error at all: the work is done, without a traceback."""
    done = run_in(tmp_path, [*FILL, "run", CD14, *WORDS, "run.title=Prüfling µ", "--out", "r"],
                  env=os.environ | {"PYTHONIOENCODING": "ascii", "LC_ALL": "C"})
    assert done.returncode == 0 and "Pr\\xfcfling" in done.stdout, done.stderr
    keys = dict(word.split("=") for word in WORDS)
    done = run_in(tmp_path, [sys.executable, "-c", f"""
import sys; sys.stderr = None
import hdengine
print(hdengine.Study(grid={{"load.torque": [1.0, 2.0]}}, fixed={keys!r}).run("s", show=True).summary["status"])
print(hdengine.run(out="q", show=True, **{keys!r}).summary["status"])
"""])
    assert done.stdout.splitlines() == ["complete", "complete"], done


def test_optimised_python(tmp_path):
    """`python -OO`, which has no docstrings, runs and plots a scene."""
    done = run_in(tmp_path, [sys.executable, "-OO", "-m", "hdengine", "run", CD14, *WORDS, "--out", "r"])
    assert done.returncode == 0 and (tmp_path / "r/pressure_band.png").is_file(), done.stderr


@pytest.mark.parametrize("command", ["press fit", "surface", "study", "record"])
def test_paths_that_are_no_utf8(exe, tmp_path, command):
    """Input and output in folders whose names are no UTF-8: the JSON is, and plot and report read the folder."""
    words = commands(exe, tmp_path)[command]
    odd = tmp_path / os.fsdecode(b"b\xff\xed\xa0\x80x")
    odd.mkdir()
    source = next(word for word in words if str(word).endswith((".nml", ".toml", ".csv")))
    target = odd / Path(source).name
    target.write_bytes((tmp_path / source).read_bytes())
    done = run_in(tmp_path, [target if word == source else odd / "r" if word == "r" else word for word in words], errors="replace")
    assert done.returncode == 0, done.stderr
    for path in (odd / "r").glob("*.json"):
        json.loads(path.read_bytes().decode("utf-8")).__repr__().encode("utf-8")
    for more in {"press fit": ["plot", "report"], "surface": ["plot"]}.get(command, []):
        done = run_in(tmp_path, [*FILL, more, odd / "r"], errors="replace")
        assert done.returncode == 0, done.stderr


def test_the_working_folder_may_change_between_steps(tmp_path, monkeypatch):
    """A run in a relative folder ends where it began after os.chdir between two load steps."""
    (tmp_path / "a").mkdir()
    monkeypatch.chdir(tmp_path / "a")
    with hdengine.Run(CD14, "r", **dict(word.split("=") for word in WORDS)) as run:
        run.advance()
        os.chdir(tmp_path)
        list(run)
    assert claims(tmp_path / "a/r") and [p.name for p in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("what, mb", [("AS", 250), ("AS", 450), ("DATA", 200)])
def test_few_addresses_are_an_error(exe, tmp_path, what, mb):
    """Under `ulimit -v` or `ulimit -d` too small for the threads of the libraries each command ends at once, with code 6 and what is free."""
    def limit():
        resource.setrlimit(getattr(resource, f"RLIMIT_{what}"), (mb << 20, mb << 20))
    for words in ([exe, ROOT / "data/surface.nml", *SURFACE], [exe, CD14, *WORDS], [exe, CD14, *WORDS, "mesh.memory_limit_mb=1000"], [exe, ROOT / "data/surface.nml", *SURFACE, "surface.method=direct"]):
        done = subprocess.run([*map(str, words), "--out", tmp_path / "r", "--force"], capture_output=True, text=True, timeout=60, preexec_fn=limit,
                              env=os.environ | {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"})
        assert done.returncode == 6 and "MB" in done.stderr, done
