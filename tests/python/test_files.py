# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are written: whole or an error, in their own folder, on every kind of stream and path."""
import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_regressions import rough_map

import hdengine
from conftest import CD14, ROOT, call
from hdengine.cli import main

WORDS = ["mesh.divisions=16", "mesh.band_facets=3", "load.assembly_steps=1", "load.torque_steps=1"]
SURFACE = ["surface.nx=32", "surface.ny=24", "surface.ridges=3"]
FILL = [sys.executable, "-m", "hdengine"]
DRIVE = ["mesh.divisions=24", "mesh.band_facets=4", "load.assembly_steps=1", "load.torque_steps=1", "bearing.balls=12",
         "load.tooth_pairs=12", "loop.torques=6", "turning.positions=1"]
STUDY = "[fixed]\nmesh = {divisions = 16, band_facets = 3}\nload.torque_steps = 1\n[grid]\nload.torque = [2, 3]\n"


def commands(exe, folder):
    """A command by name that writes into folder/r, with what it needs beside it."""
    (folder / "s.toml").write_text(STUDY)
    np.save(folder / "map.npy", rough_map())
    return {
        "press fit": [exe, CD14, *WORDS, "output.vtu=all", "--out", "r"],
        "surface": [exe, ROOT / "data/surface.nml", *SURFACE, "--out", "r"],
        "drive": [exe, ROOT / "tests/cases/pressed_drive.nml", *DRIVE, "--out", "r"],
        "study": [*FILL, "study", "s.toml", "--out", "r", "-q"],
        "record": [*FILL, "record", ROOT / "data/torque_record.csv", "--out", "r"],
        "joint": [*FILL, "joint", "map.npy", "--dx", "1e-6", "--model", "spectrum", "--out", "r"],
        "teeth": [*FILL, "teeth", ROOT / "data/drive14.nml", "--profile", "involute", "--module", "0.1778e-3", "--out", "r"],
    }


def run_in(folder, words, **options):
    """A command in a folder, as a finished process."""
    return subprocess.run([*map(str, words)], cwd=folder, capture_output=True, text=True, timeout=120, **options)


def limited(size):
    """What a shell's `ulimit -f` does to a child."""
    return {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))}


def claims(folder):
    """The records of a folder that say that it is complete."""
    found = []
    for path in folder.glob("**/*.json"):
        if path.is_file() and not path.is_symlink():
            found += [path.name] if json.loads(path.read_text()).get("status") == "complete" else []
    return found


@pytest.mark.parametrize("name", ["press fit", "surface", "drive", "study", "joint"])
def test_a_full_disk_is_an_error(exe, tmp_path, name):
    """Where a file finds no room, at its first or its last byte, the command ends with code 3 and one line that names it, and nothing is
    complete but what has only its figures to come; with room for all it ends as ever."""
    words = commands(exe, tmp_path)[name]
    done = run_in(tmp_path, words)
    assert done.returncode == 0 and claims(tmp_path / "r"), done.stderr
    sizes = sorted({path.stat().st_size for path in (tmp_path / "r").rglob("*") if path.is_file()})
    least = sizes[-1]
    for i, size in enumerate([least - 1] if words[0] != exe else sorted({0, 1, 100, *(s - 1 for s in sizes), least})):
        out = tmp_path / f"r{i}"
        done = run_in(tmp_path, [out.name if word == "r" else word for word in words], **limited(size))
        if done.returncode == 0:
            assert size >= least and claims(out), (size, done)
            continue
        assert done.returncode == 3 and done.stderr.count("error: ") == 1 and "Traceback" not in done.stderr, (size, done.stderr)
        assert "File too large" in done.stderr or "is the disk full" in done.stderr, (size, done.stderr)
        assert ".png" in done.stderr or not (out.exists() and claims(out)), (size, done.stderr)
        assert not [path for path in out.rglob("*") if path.name == "hdengine.lock" or path.suffix == ".part"]
    if name in ("press fit", "drive"):
        done = run_in(tmp_path, ["r3" if word == "r" else word for word in [*words, "--resume"]])
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "r3/contact.csv").read_bytes() == (tmp_path / "r/contact.csv").read_bytes()


@pytest.mark.parametrize("size, name", [(0, "plan.nml"), (5000, "plan.csv")])
def test_a_full_disk_is_an_error_of_a_plan(exe, tmp_path, size, name):
    """A plan that finds no room for its table or for the scene that it chose ends with code 3 and the name, and is not complete."""
    done = run_in(tmp_path, [exe, CD14, "run.tolerance=0.5", "load.torque_steps=1", "load.assembly_steps=1", "--out", "r"], **limited(size))
    assert done.returncode == 3 and done.stderr.startswith(f"error: cannot write 'r/{name}': is the disk full") and done.stderr.count("error: ") == 1
    assert not claims(tmp_path / "r")


def test_a_full_disk_leaves_no_half_report(small_run, tmp_path):
    """A report that finds no room for its last byte ends with code 3 and its name, and leaves no file; an earlier one stays as it was."""
    words = [*FILL, "report", small_run, "--out", "r.html"]
    assert run_in(tmp_path, words).returncode == 0
    whole = (tmp_path / "r.html").read_bytes()
    for out, left in (("s.html", None), ("r.html", whole)):
        done = run_in(tmp_path, [*words[:-1], out], **limited(len(whole) - 1))
        assert done.returncode == 3 and done.stderr.count("error: ") == 1 and out in done.stderr and "Traceback" not in done.stderr, done.stderr
        assert ((tmp_path / out).read_bytes() if (tmp_path / out).exists() else None) == left
    assert sorted(path.name for path in tmp_path.iterdir()) == ["r.html"]


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
        for kind in ("link", "pipe", *(["dangling", "hard link"] if i == 1 else [])):
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
    """A folder of hard links (cp -al) stays as it was while the run that it was made of goes on."""
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
    for words in ([exe, ROOT / "data/surface.nml", *SURFACE], [exe, CD14, *WORDS], [exe, ROOT / "data/surface.nml", *SURFACE, "surface.method=direct"]):
        done = subprocess.run([*map(str, words), "--out", tmp_path / "r", "--force"], capture_output=True, text=True, timeout=60, preexec_fn=limit,
                              env=os.environ | {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"})
        assert done.returncode == 6 and "MB" in done.stderr, done
