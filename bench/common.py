# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scripts of this folder share: paths, runs of the engine, timing, records, tables and figures.

A record is a JSON file of results/ whose "provenance" says how it came to be: script, commit, machine, versions, seed, threads, seconds.
Calls whose times are compared take turns in one process (`take_turns`): a busy machine slows them alike.
"""
import json
import os
import platform
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

import hdengine
import hdengine_x
from hdengine.figures.style import new_axes, new_figure, styled  # noqa: F401  (the scripts take them from here)
from hdengine.studies.planner import mesh_of_level  # noqa: F401

ROOT = Path(__file__).resolve().parents[1]
# `bench/all.py --quick` names another folder: its records of fewer points do not replace those of the pages
OUT = Path(os.environ["HDENGINE_BENCH"]) if "HDENGINE_BENCH" in os.environ else None
DATA, RESULTS, FIGURES = ROOT / "data", OUT or ROOT / "bench/results", OUT or ROOT / "docs/figures"
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
START = time.time()


def machine():
    """Name of the processor and number of cores."""
    names = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text()) or [platform.machine()]
    return f"{names[0]}, {os.cpu_count()} cores"


def commit():
    """Commit of the sources, with '+' behind it where files differ from it; '' outside of a repository and without git."""
    def git(*words):
        return subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True).stdout.strip() if shutil.which("git") else ""
    return git("rev-parse", "--short=12", "HEAD") + ("+" if git("status", "--porcelain", "--untracked-files=no", "--", "fortran", "python") else "")


def versions(*modules):
    """Versions of hdengine, Python, numpy and of imported peers, by name."""
    import numpy
    return {"hdengine": hdengine.__version__, "python": platform.python_version(), "numpy": numpy.__version__,
            **{m.__name__: m.__version__ for m in modules}}


def provenance(seed=None, peers=(), **more):
    """Where a record comes from.

    Parameters
    ----------
    seed : int, optional
        Of the random numbers.
    peers : sequence of modules
        Whose versions count.
    **more
        As threads=1.
    """
    return {"script": Path(sys.argv[0]).name, "commit": commit(), "machine": machine(), "versions": versions(*peers),
            **({"seed": seed} if seed is not None else {}), **more, "seconds": round(time.time() - START, 1)}


def write_record(name, facts, **origin):
    """Write results/NAME.json: the provenance and the facts (a list becomes "rows"); half a file is never seen.

    Parameters
    ----------
    name : str
    facts : dict or list
    **origin
        Of `provenance`.

    Returns
    -------
    Path
    """
    path = RESULTS / f"{name}.json"
    path.parent.mkdir(exist_ok=True)
    whole = {"provenance": provenance(**origin), **({"rows": facts} if isinstance(facts, list) else facts)}
    part = path.with_suffix(".json.part")
    part.write_text(record_text(whole))
    part.replace(path)
    return path


def record_text(whole):
    """JSON with its innermost lists and objects on a line each."""
    return re.sub(r"([\[{])\n\s+([^\[\]{}]*?)\n\s*([\]}])", lambda m: m[1] + re.sub(r"\n\s+", " ", m[2]) + m[3], json.dumps(whole, indent=1)) + "\n"


def short(value, digits):
    """A number of a record to so many digits, or those of a list or a mapping; None for what is none."""
    if isinstance(value, dict):
        return {key: short(v, digits) for key, v in value.items()}
    if np.ndim(value):
        return [short(v, digits) for v in value]
    return None if value is None or not np.isfinite(value) else float(f"{value:.{digits}g}")


def write_part(name, part, facts, **origin):
    """Write one part of results/NAME.json anew; "commits" says which engine made each part."""
    record = read_record(name) if (RESULTS / f"{name}.json").exists() else {}
    commits = {**record.get("commits", {}), part: commit()}
    return write_record(name, {**record, "commits": commits, part: facts}, **origin)


def read_record(name):
    """Facts of a record: a list where it holds rows alone, without the provenance."""
    found = json.loads((RESULTS / f"{name}.json").read_text())
    if isinstance(found, dict):
        found.pop("provenance", None)
    return found["rows"] if isinstance(found, dict) and list(found) == ["rows"] else found


def add_row(name, row, **origin):
    """Append a row to results/NAME.jsonl, with its provenance: a script that was stopped goes on where it was."""
    with (RESULTS / f"{name}.jsonl").open("a") as file:
        file.write(json.dumps({**row, "provenance": provenance(**origin)}) + "\n")


def read_rows(name, key):
    """Rows of results/NAME.jsonl by their value of `key`; the last of each counts."""
    path = RESULTS / f"{name}.jsonl"
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    return {row[key]: row for row in rows}


def take_turns(calls, turns=5, limit=60.0, clock=time.perf_counter):
    """Time calls that take turns.

    Parameters
    ----------
    calls : dict of callable
        By name, without arguments.
    turns : int
        Of each call.
    limit : float
        No further turn begins after so many seconds.
    clock : callable
        Seconds; `time.thread_time` bears a busy machine where a call has one thread.

    Returns
    -------
    seconds : dict of list
        Of each call, turn by turn.
    results : dict
        What each call gave last.
    """
    seconds, results, start = {name: [] for name in calls}, {}, time.perf_counter()
    for turn in range(turns):
        for name, call in calls.items():
            begun = clock()
            results[name] = call()
            seconds[name].append(clock() - begun)
        if turn and time.perf_counter() - start > limit:
            break
    return seconds, results


def program(name, hint="./hd setup"):
    """Path of a program, that of this tree's .venv first; ends the script where there is none."""
    if name == "hdengine.x":
        return hdengine_x.PROGRAM
    places = os.pathsep.join([str(ROOT / ".venv/bin"), str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    return shutil.which(name, path=places) or sys.exit(f"{name} not found: {hint}")


@dataclass
class Command:
    """What a command did: exit code, seconds, peak memory [MB], output; `code` None where it hit the limit."""

    code: object
    wall_s: float
    cpu_s: float
    memory_mb: float
    text: str


def measured(command, cwd=None, limit=None, threads=1):
    """Run a command.

    Parameters
    ----------
    command : sequence
    cwd : path, optional
    limit : float, optional
        CPU seconds.
    threads : int
        Of OpenMP and BLAS.

    Returns
    -------
    Command
    """
    start = time.time()
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen([str(c) for c in command], cwd=cwd, stdout=output, stderr=subprocess.STDOUT,
                                   env=os.environ | {name: str(threads) for name in ONE_THREAD})
        if limit:
            resource.prlimit(process.pid, resource.RLIMIT_CPU, (int(limit), int(limit) + 5))
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read().decode(errors="replace")
    code = process.returncode if process.returncode >= 0 else None
    return Command(code, time.time() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, text)


def read_prints(path):
    """Blocks of CalculiX's .dat file in order: what they print, and three components of each node, by node from 0."""
    blocks = []
    for line in Path(path).read_text().splitlines() if Path(path).exists() else []:
        if m := re.match(r"\s*(displacements|forces)", line):
            blocks.append((m[1], {}))
        elif blocks and (m := re.match(r"\s*(\d+)((?:\s+\S+){3})", line)):
            blocks[-1][1][int(m[1]) - 1] = [float(v) for v in m[2].split()]
    return blocks


def solve(scene, *assignments, out=None, limit=None, threads=1):
    """Run a scene by the command.

    Parameters
    ----------
    scene : str or path
        A file, or the name of one in data/.
    *assignments : str
        As 'mesh.divisions=80'.
    out : path, optional
        Folder of the results; default: one that is removed.
    limit, threads :
        Of `measured`.

    Returns
    -------
    summary : dict or None
        What summary.json holds.
    command : Command
    """
    with tempfile.TemporaryDirectory() as folder:
        out = Path(out or Path(folder) / "run.out")
        path = Path(scene) if Path(scene).exists() else DATA / scene
        done = measured([program("hdengine.x"), path, "output.vtu=none", "run.band=.false.", *assignments, "--out", out, "--force", "-q"], limit=limit, threads=threads)
        file = out / "summary.json"
        return json.loads(file.read_text()) if file.exists() else None, done


def save_figure(figure, name, **keys):
    """Write NAME.png into the figures, of 256 colours (a third of the bytes), and return its path."""
    path = FIGURES / f"{name}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, **keys)
    Image.open(path).convert("RGB").quantize(256).save(path, optimize=True)
    return path


def table(head, rows):
    """A Markdown table."""
    return "\n".join("| " + " | ".join(map(str, r)) + " |" for r in (head, ["---"] * len(head), *rows))


def put(name, text, page="evidence/comparison"):
    """Replace what stands in docs/PAGE.md between <!-- name --> and <!-- end of name -->."""
    page = ROOT / f"docs/{page}.md"
    old = page.read_text()
    start, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    page.write_text(old[:old.index(start) + len(start)] + text + "\n" + old[old.index(end):])
