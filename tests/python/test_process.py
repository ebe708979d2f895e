# SPDX-License-Identifier: GPL-3.0-or-later
"""Processes around the engine: forks, threads, workers, locks of folders, signals."""
import contextlib
import csv
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from ctypes.util import find_library
from pathlib import Path

import pytest

import hdengine
from conftest import CD14, ROOT, call
from hdengine import _engine
from hdengine.studies.study import Study, StudyResult

SMALL = {"mesh.divisions": 16, "mesh.band_facets": 3, "load.assembly_steps": 1, "load.torque_steps": 1}
FREE = {k: v for k, v in os.environ.items() if k not in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_WAIT_POLICY", "OPENBLAS_CORETYPE")}
LONG = ["mesh.divisions=160", "mesh.band_facets=24", "load.assembly_steps=40", "load.torque_steps=40"]  # minutes


def python(code, cwd, **options):
    """Run a script as a user would, with the threads that the machine gives."""
    (cwd / "script.py").write_text(code)
    return subprocess.run([sys.executable, "script.py"], cwd=cwd, capture_output=True, text=True, timeout=120, env=FREE, **options)


def begun(exe, folder, *words, command=(), env=None):
    """A command (hdengine.x) at work on a long run, past its first load step."""
    process = subprocess.Popen([*(command or [exe]), CD14, *LONG, *words, "--out", folder], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                               env=env)
    table = folder / "checkpoint.bin"
    for _ in range(600):
        if table.exists() or process.poll() is not None:
            break
        time.sleep(0.05)
    assert process.poll() is None, process.stderr.read()
    return process


def test_a_fork_after_a_run_computes(tmp_path):
    """A child forked after a run with threads solves the same scene to the same bits; a run of the parent is not its to step."""
    done = python("""
import multiprocessing, hdengine
keys = {"mesh.divisions": 64, "mesh.band_facets": 8, "load.torque_steps": 1}
def solve(_=0):
    with hdengine.Run(**keys) as run:
        return [step.k_ts_nm_per_rad for step in run][-1]
def steal(_):
    try:
        open_run.advance()
    except hdengine.InputError as error:
        return str(error)
first, open_run = solve(), hdengine.Run(out="parent.out", **keys)
with multiprocessing.get_context("fork").Pool(2) as pool:
    print(len({first, *pool.map_async(solve, range(2)).get(60)}))
    print(pool.map_async(steal, [0]).get(60)[0])
open_run.close()
""", tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "1" and "fork" in lines[1]
    assert json.loads((tmp_path / "parent.out/summary.json").read_text())["status"] == "stopped_at_limit"


def test_threads_do_not_change_a_bit(exe, tmp_path):
    """One and three threads write the same tables of a mesh that is large enough for all of their loops."""
    keys = ["mesh.divisions=240", "mesh.band_facets=44", "load.assembly_steps=1", "load.torque_steps=1", "contact.friction=0.3", "output.vtu=none"]
    for n in (1, 3):
        done = call(exe, CD14, *keys, "--out", tmp_path / str(n), "-q", env=FREE | {"OMP_NUM_THREADS": str(n), "OPENBLAS_NUM_THREADS": str(n)})
        assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "1/summary.json").read_text())["model"]["dof"] > 100_000
    assert (tmp_path / "1/contact.csv").read_bytes() == (tmp_path / "3/contact.csv").read_bytes()


def test_small_factorisations_take_one_thread(exe, tmp_path):
    """The direct solver of a small scene takes as much processor time with three threads as with one, where those of BLAS waited for each other: 3 to
    5 times as much, and on busy cores 4 to 18 times as long."""
    spent = []
    for n in (1, 3):
        before = os.times()
        done = call(exe, CD14, "mesh.divisions=24", "mesh.band_facets=4", "load.assembly_steps=1", "load.torque_steps=1", "output.vtu=none", "solver.method=newton",
                    "solver.factors=exact", "--out", tmp_path / str(n), "-q", env=FREE | {"OMP_NUM_THREADS": str(n), "OPENBLAS_NUM_THREADS": str(n)})
        assert done.returncode == 0, done.stderr
        spent.append(sum(os.times()[2:4]) - sum(before[2:4]))
    assert spent[1] < 1.7 * spent[0]
    assert (tmp_path / "1/contact.csv").read_bytes() == (tmp_path / "3/contact.csv").read_bytes()


def test_waiting_threads_sleep(exe, tmp_path):
    """Program and package tell OpenMP to sleep soon and leave an environment that says otherwise alone; Python's stays clean."""
    def spins(*words, **variables):
        env = FREE | {"OMP_DISPLAY_ENV": "verbose"} | variables
        done = subprocess.run(words, capture_output=True, text=True, env=env, cwd=tmp_path)
        return int([line for line in done.stderr.splitlines() if "GOMP_SPINCOUNT" in line][-1].split("=")[1].strip(" '"))
    python_words = sys.executable, "-c", "import os; old = dict(os.environ); import hdengine; assert os.environ == old"
    for words in ((exe, "--version"), python_words):
        assert spins(*words) == 1000 and spins(*words, OMP_WAIT_POLICY="passive") == 0
        assert spins(*words, OMP_WAIT_POLICY="active") > 1_000_000 and spins(*words, GOMP_SPINCOUNT="77") == 77


def test_old_kernels_of_openblas(exe, tmp_path):
    """Where OpenBLAS took kernels without AVX2 on a processor that has it, program and package let it choose anew, and the summary names what is in
    use; an environment that names some stays, as does all of Python's."""
    library = find_library("openblas")
    if "avx2" not in Path("/proc/cpuinfo").read_text().split() or library is None:
        pytest.skip("the processor lacks AVX2, or OpenBLAS is not the system's")
    (tmp_path / "old.c").write_text("""static int anew;
char *openblas_get_corename(void) { return anew ? "Haswell" : "Prescott"; }
void gotoblas_dynamic_quit(void) { anew = 1; }
""")
    subprocess.run(["gcc", "-shared", "-fPIC", "old.c", "-o", "old.so"], cwd=tmp_path, check=True)
    for chosen, found in (({}, "Haswell"), ({"OPENBLAS_CORETYPE": "Nehalem"}, "Prescott")):
        done = call(exe, CD14, *(f"{k}={v}" for k, v in SMALL.items()), "--out", "o.out", "--force", "-q", cwd=tmp_path, env=FREE | {"LD_PRELOAD": "./old.so"} | chosen)
        assert done.returncode == 0, done.stderr
        assert json.loads((tmp_path / "o.out/summary.json").read_text())["provenance"]["blas_kernels"] == found
    code = f"""
import ctypes, os
os.environ["OPENBLAS_CORETYPE"] = "Prescott"   # as one that does not know the processor
ctypes.CDLL({library!r})
CHOSEN or os.environ.pop("OPENBLAS_CORETYPE")
old = dict(os.environ)
import hdengine
assert dict(os.environ) == old and (ctypes.CDLL(None)["getenv"](b"OPENBLAS_CORETYPE") != 0) == CHOSEN
print(hdengine.run(r"{CD14}", "p.out", True, **{SMALL!r}).summary["provenance"]["blas_kernels"])
"""
    for chosen, found in (("False", ("Haswell", "SkylakeX")), ("True", ("Prescott",))):
        done = python(code.replace("CHOSEN", chosen), tmp_path)
        assert done.stdout.strip() in found, done.stdout + done.stderr


def test_a_script_needs_no_main_guard(tmp_path):
    """Workers solve a study of a script without a main guard, each with one thread, also where the script stands on stdin."""
    code = f"""
import hdengine
study = hdengine.Study(grid={{"load.torque": [1.0, 2.0]}}, fixed={SMALL!r})
print(study.run("s.out", jobs=2, force=True, show=False).summary["status"])
"""
    assert python(code, tmp_path).stdout == "complete\n"
    assert subprocess.run([sys.executable], input=code, cwd=tmp_path, capture_output=True, text=True, timeout=120).stdout == "complete\n"


def test_workers_that_cannot_start_are_one_error(tmp_path):
    """Where the workers' Python cannot load the package the study ends with one error that names the exit code."""
    done = python(f"""
import sys, hdengine
sys.path[:] = []
hdengine.Study(grid={{"load.torque": [1.0, 2.0]}}, fixed={SMALL!r}).run("s.out", jobs=2, show=False)
""".replace("sys.path[:] = []", "sys.executable = '/bin/false'"), tmp_path)
    assert done.returncode == 1 and done.stderr.count("Traceback") == 1
    assert "InternalError: a worker process ended before it could begin (exit code 1)" in done.stderr


def test_one_folder_one_run(exe, tmp_path):
    """While a run is at work in a folder others are refused with code 3 and its process, run or study; when it is dead, not."""
    folder = tmp_path / "r"
    first = begun(exe, folder)
    try:
        for words in (["--resume"], ["--force"], []):
            done = call(exe, CD14, *LONG, *words, "--out", folder)
            assert done.returncode == 3 and f"process {first.pid} " in done.stderr and done.stderr.count("\n") == 2
        with pytest.raises(hdengine.FileError, match=f"process {first.pid} "):
            hdengine.Run(CD14, folder, resume=True)
        with pytest.raises(hdengine.FileError, match=f"process {first.pid} "):
            Study(fixed=SMALL).run(folder, show=False)
    finally:
        first.kill()
        first.communicate()
    assert (folder / "hdengine.lock").exists()
    done = call(exe, CD14, *SMALL_WORDS, "--force", "--out", folder)
    assert done.returncode == 0 and not (folder / "hdengine.lock").exists()


SMALL_WORDS = [f"{k}={v}" for k, v in SMALL.items()]


def test_runs_of_one_process_share_no_folder(tmp_path):
    """Two runs of one Python process in a folder: the second is refused; closed, or refused for its input, a run leaves no lock."""
    with hdengine.Run(CD14, tmp_path / "r", **SMALL), pytest.raises(hdengine.FileError, match=f"process {os.getpid()} "):
        hdengine.Run(CD14, tmp_path / "r", force=True, **SMALL)
    with pytest.raises(hdengine.FileError, match="earlier run"):
        hdengine.Run(CD14, tmp_path / "r", **SMALL)
    assert not (tmp_path / "r/hdengine.lock").exists()
    with pytest.raises(hdengine.InputError):
        hdengine.Run(CD14, tmp_path / "none", **SMALL, **{"load.torque": "x"})
    assert not (tmp_path / "none").exists()


def test_pairs_of_runs_leave_whole_tables(exe, tmp_path):
    """Of two runs started into one folder at once one is complete with all its rows, the other is refused."""
    for i in range(4):
        folder = tmp_path / str(i)
        pair = [subprocess.Popen([exe, CD14, *SMALL_WORDS, "load.torque_steps=6", "--out", folder], stdout=subprocess.DEVNULL,
                                 stderr=subprocess.PIPE, text=True) for _ in range(2)]
        errors = [p.communicate()[1] for p in pair]
        assert sorted(p.returncode for p in pair) == [0, 3], errors
        rows = list(csv.DictReader((folder / "steps.csv").read_text().splitlines()))
        assert [int(row["step"]) for row in rows] == list(range(1, 8))


@pytest.mark.parametrize("name, code", [("SIGHUP", 7), ("SIGQUIT", 7), ("SIGINT", 7), ("SIGTERM", 7)])
def test_signals_end_a_run_within_a_step(exe, tmp_path, name, code):
    """A signal ends hdengine.x within two seconds, in the middle of a load step, with a summary that says so and no backtrace."""
    process = begun(exe, tmp_path / "r")
    start = time.monotonic()
    process.send_signal(getattr(signal, name))
    error = process.communicate(timeout=30)[1]
    assert process.returncode == code and time.monotonic() - start < 2
    assert error.startswith("error: interrupted after ") and error.count("\n") == 1
    assert json.loads((tmp_path / "r/summary.json").read_text())["status"] == "interrupted"
    assert not (tmp_path / "r/hdengine.lock").exists()


@pytest.mark.parametrize("name", ["SIGHUP", "SIGTERM"])
def test_signals_end_the_python_command(exe, tmp_path, name):
    """`hdengine run` ends on a signal as hdengine.x does: code 7 within two seconds, with a summary that says so."""
    process = begun(exe, tmp_path / "r", command=[sys.executable, "-m", "hdengine", "run"])
    start = time.monotonic()
    process.send_signal(getattr(signal, name))
    error = process.communicate(timeout=30)[1]
    assert process.returncode == 7 and time.monotonic() - start < 2
    assert error.splitlines()[-1].startswith("error: interrupted; what was solved is kept") and "Traceback" not in error
    assert json.loads((tmp_path / "r/summary.json").read_text())["status"] == "interrupted"


@pytest.mark.parametrize("command", ["program", "python", "surface"])
def test_every_signal_of_the_list_ends_in_order(exe, tmp_path, command):
    """SIGUSR1, SIGUSR2, SIGALRM and SIGXCPU, as batch systems send them, end program, command and surface with code 7; a run says so in
    its summary."""
    words = {"program": [exe, CD14], "python": [sys.executable, "-m", "hdengine", "run", CD14],
             "surface": [exe, ROOT / "data/surface.nml", "surface.nx=4000", "surface.ny=4000", "surface.method=direct"]}[command]
    words += ["load.assembly_steps=400", "mesh.divisions=40"] if command != "surface" else []
    for name in ("SIGUSR1", "SIGUSR2", "SIGALRM", "SIGXCPU"):
        folder = tmp_path / name
        process = subprocess.Popen([*words, "--out", folder], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while process.poll() is None and not (folder / ("echo.nml" if command == "surface" else "checkpoint.bin")).exists():
            time.sleep(0.01)
        process.send_signal(getattr(signal, name))
        error = process.communicate(timeout=30)[1]
        assert process.returncode == 7 and error.splitlines()[-1].startswith("error: interrupted"), error
        if command != "surface":
            said = json.loads((folder / "summary.json").read_text())
            assert said["status"] == "interrupted" and said["message"].startswith("interrupted after ")
        else:
            assert not (folder / "summary.json").exists()


def test_an_ignored_signal_stays_ignored(exe, tmp_path):
    """Under nohup a closed terminal does not end the run."""
    process = subprocess.Popen(["nohup", exe, CD14, *SMALL_WORDS, "mesh.divisions=80", "mesh.band_facets=12", "--out", tmp_path / "r"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    while not (tmp_path / "r/echo.nml").exists():
        time.sleep(0.01)
    process.send_signal(signal.SIGHUP)
    process.communicate(timeout=60)
    assert process.returncode == 0


@pytest.mark.parametrize("keys", ["", ", **{'run.tolerance': 0.01}"], ids=["step", "plan"])
def test_interrupts_in_python_act_at_once(tmp_path, keys):
    """SIGINT raises KeyboardInterrupt within two seconds inside of a load step or a plan; the engine then computes as ever."""
    words = {w.split("=")[0]: int(w.split("=")[1]) for w in LONG}
    done = python(f"""
import os, signal, threading, time, hdengine
small = {SMALL!r}
def solve():
    with hdengine.Run(**small) as run:
        return [step.k_ts_nm_per_rad for step in run]
before = solve()
threading.Timer(2.5, lambda: (globals().update(sent=time.monotonic()), os.kill(os.getpid(), signal.SIGINT))).start()
try:
    hdengine.run({str(CD14)!r}, "r.out", **{words!r}{keys})
except KeyboardInterrupt:
    print(time.monotonic() - sent)
hdengine.forget()
print(solve() == before)
""", tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.split()
    assert float(lines[0]) < 2 and lines[1] == "True"
    if not keys:
        assert json.loads((tmp_path / "r.out/summary.json").read_text())["status"] == "interrupted"


def test_the_log_is_told_while_it_grows(caplog):
    """Lines of the log reach the logger `hdengine` at level INFO, those of the plan too, and none at the level above."""
    with caplog.at_level("INFO", logger="hdengine"), hdengine.Run(CD14, **SMALL) as run:
        steps = len(list(run))
    lines = [r.getMessage() for r in caplog.records if r.name == "hdengine"]
    assert sum("assembly" in line or "torque  " in line for line in lines) == steps and any("solver" in line for line in lines)
    caplog.clear()
    with hdengine.Run(CD14, **SMALL) as run:
        list(run)
    assert not caplog.records


def test_a_bar_follows_a_run(tmp_path, capsys):
    """`show` draws a bar that counts the load steps."""
    hdengine.run(CD14, tmp_path / "r", show=True, **SMALL)
    assert "2 [" in capsys.readouterr().err.split("\r")[-1]


def test_a_time_limit_that_is_too_short_is_told(exe, tmp_path):
    """A limit within which no load step fits ends a run, and those that resume it, with code 7, a word of it and a summary that says so."""
    for words in ([], ["--resume"]):
        done = call(exe, CD14, *SMALL_WORDS, "solver.time_limit_s=1e-4", "--out", tmp_path / "r", *words)
        assert done.returncode == 7 and "longer solver.time_limit_s" in done.stderr and "\nended " in done.stdout and "\ndone " not in done.stdout
        assert json.loads((tmp_path / "r/summary.json").read_text())["status"] == "stopped_at_limit"


def test_two_studies_share_no_folder(tmp_path):
    """The second of two studies in one folder is refused; the first ends complete."""
    study, errors = Study(grid={"load.torque": [1.0, 2.0, 3.0]}, fixed=SMALL), []

    def run():
        try:
            study.run(tmp_path / "s", show=False)
        except hdengine.FileError as error:
            errors.append(str(error))
    threads = [threading.Thread(target=run) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(errors) == 1 and f"process {os.getpid()} " in errors[0]
    assert StudyResult(tmp_path / "s").summary["status"] == "complete"


def test_lines_fit_a_terminal(exe, tmp_path):
    """On a terminal no line of the log has more than 80 columns; its words are those of a file, where a message keeps its line."""
    keys = [CD14, *(f"{key}={value}" for key, value in SMALL.items()), "--force", "--out", tmp_path / "o"]
    near, far = os.openpty()
    with os.fdopen(near, "rb", buffering=0) as terminal, subprocess.Popen([exe, *map(str, keys)], stdout=far, stderr=far) as process:
        os.close(far)
        shown = b""
        with contextlib.suppress(OSError):   # the end of a terminal is an error of reading
            while part := terminal.read(4096):
                shown += part
    assert process.returncode == 0
    lines, whole = shown.decode().splitlines(), call(exe, *keys).stdout
    assert max(map(len, lines)) <= 80 < max(map(len, whole.splitlines()))

    def words(text):
        return [w for w in text.split() if not re.search(r"\d", w)]
    assert words("\n".join(lines)) == words(whole)


@pytest.mark.parametrize("limit, threads, code", [("-S -s 128", "1", 0), ("-s 128", "1", 6), ("-S -s 8192", "100000", 0)])
def test_small_stacks_and_many_threads(exe, tmp_path, limit, threads, code):
    """A small stack grows where its hard limit lets it, else it is named with code 6; more threads than a machine has are none. All ended in a
    segmentation fault."""
    keys = "mesh.divisions=16 mesh.band_facets=2 load.torque_steps=0 load.assembly_steps=1"
    done = subprocess.run(["bash", "-c", f"ulimit {limit} && exec '{exe}' '{ROOT}/data/cd14.nml' {keys} --out '{tmp_path}/r' -q"], text=True,
                          capture_output=True, env=os.environ | {"OMP_NUM_THREADS": threads}, timeout=120)
    assert done.returncode == code and ("ulimit -s" in done.stderr) == (code == 6)
    if threads == "100000":
        done = subprocess.run([sys.executable, "-m", "hdengine", "run", ROOT / "data/cd14.nml", *keys.split(), "--out", tmp_path / "p", "-q"],
                              capture_output=True, env=os.environ | {"OMP_NUM_THREADS": threads}, timeout=120)
        assert done.returncode == 0 and (tmp_path / "p/summary.json").exists(), done.stderr


def test_a_turkish_locale(tmp_path):
    """Where the capital of i is no I, a scene is solved from Python as elsewhere: the compiler's library took (i0) for no format."""
    made = subprocess.run(["localedef", "-i", "tr_TR", "-f", "UTF-8", tmp_path / "tr_TR.UTF-8"], capture_output=True)
    if not (tmp_path / "tr_TR.UTF-8/LC_CTYPE").exists():
        pytest.skip(f"no Turkish locale: {made.stderr.decode()[:80]}")
    keys = [f"{key}={value}" for key, value in SMALL.items()]
    done = subprocess.run([sys.executable, "-m", "hdengine", "run", CD14, *keys, "--out", tmp_path / "r", "-q"], capture_output=True, text=True,
                          env=os.environ | {"LC_ALL": "tr_TR.UTF-8", "LOCPATH": str(tmp_path)}, timeout=120)
    assert done.returncode == 0 and not done.stderr, done.stderr


def test_a_working_folder_that_is_gone(small_run, tmp_path):
    """Runs are read by their whole path where the working folder was removed meanwhile: numpy asked for it and the file was called absent."""
    (tmp_path / "gone").mkdir()
    code = f"import os; os.rmdir(os.getcwd()); import hdengine; print(len(hdengine.load({str(small_run)!r}).steps))"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path / "gone", capture_output=True, text=True)
    assert done.stdout.strip() == "3", done.stderr


def test_as_many_locks_as_there_are_can_be_taken_again(tmp_path):
    """A process holds 64 folders at a time; one more is refused, and all are free once they are given back."""
    for _ in range(2):
        with contextlib.ExitStack() as held:
            for i in range(64):
                held.enter_context(_engine.FolderLock(tmp_path / str(i)))
            with pytest.raises(hdengine.InputError, match="64 folders are locked"):
                held.enter_context(_engine.FolderLock(tmp_path / "more"))
