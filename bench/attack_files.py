#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged and crafted files, pairs of runs in one folder, and kills: how does the engine end?

Usage: bench/attack_files.py [--quick | --table]
Changes checkpoints and tables of a stopped run (resumed in a child process each), feeds namelists put together at random, starts pairs of
runs into one folder, and kills runs that are then resumed. What may not happen: a wrong result called complete, a signal, a hang, output
that is no UTF-8. Record: attack_files.json, table into docs/evidence/attacks.md.
"""
import argparse
import collections
import json
import multiprocessing
import os
import random
import runpy
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

from common import ROOT, put, read_record, table, write_record  # noqa: E402

sys.path.insert(0, str(ROOT / "tests/python"))
EXE = Path(sys.executable).with_name("hdengine.x")
CD14 = ROOT / "data/cd14.nml"
KEYS = {"mesh.divisions": 16, "mesh.band_facets": 4, "load.assembly_steps": 2, "load.torque_steps": 6}
WORDS = [f"{k}={v}" for k, v in KEYS.items()]
LIMIT_S = 60


def stopped_run(folder):
    """A run of eight steps that is left after four."""
    import hdengine
    run = hdengine.Run(CD14, folder, **KEYS)
    for _ in range(4):
        run.advance()
    run.close(interrupted=True)


def resume(folder, steps, end):
    """Child: resume, and say how it ended."""
    import hdengine
    try:
        with hdengine.Run(CD14, folder, resume=True, **KEYS) as run:
            list(run)
        found = (folder / "steps.csv").read_text()
        end.send("same result" if without_times(found) == steps else "wrong result")
    except hdengine.FileError:
        end.send("refused")
    except BaseException as error:  # what a user would see
        end.send(f"raw {type(error).__name__}")


def without_times(text):
    """steps.csv without its last column."""
    return [line.rsplit(",", 1)[0] for line in text.splitlines()]


def mutated_files(count, work):
    """Outcomes of resuming with one changed file."""
    mutations = runpy.run_path(str(ROOT / "tests/python/test_resume.py"))["mutations"]
    subprocess.run([EXE, CD14, *WORDS, "--out", work / "whole", "-q"], check=True)
    steps = without_times((work / "whole/steps.csv").read_text())
    stopped_run(work / "r")
    files = {name: (work / "r" / name).read_bytes() for name in ("checkpoint.bin", "steps.csv", "history.csv", "contact.csv")}
    found = {}
    context = multiprocessing.get_context("fork")
    for name, share in (("checkpoint.bin", count), ("steps.csv", count // 8), ("history.csv", count // 8), ("contact.csv", count // 8)):
        ends = collections.Counter()
        for new in mutations(files[name], share, 7):
            tail_only = name != "checkpoint.bin" and new.startswith(files[name])  # rows behind the checkpoint are cut off: right
            folder = work / "m"
            shutil.rmtree(folder, ignore_errors=True)
            shutil.copytree(work / "r", folder)
            (folder / name).write_bytes(new)
            here, there = context.Pipe()
            child = context.Process(target=resume, args=(folder, steps, there))
            child.start()
            end = here.recv() if here.poll(LIMIT_S) else "hung"
            child.kill() if end == "hung" else child.join()
            ends["rows behind the checkpoint cut off" if tail_only and end == "same result" else end] += 1
        found[name] = dict(ends)
    return found


def crafted_namelists(count, work):
    """Outcomes of checking namelists put together at random."""
    pieces = runpy.run_path(str(ROOT / "tests/python/test_namelists.py"))["PIECES"]
    draw, ends, path = random.Random(11), collections.Counter(), work / "a.nml"
    for _ in range(count):
        path.write_bytes(" ".join(draw.choice(pieces) for _ in range(draw.randrange(1, 60))).encode("latin-1"))
        try:
            done = subprocess.run([EXE, path, "--check"], capture_output=True, timeout=LIMIT_S)
            done.stderr.decode()
            ends[{0: "valid", 2: "refused"}.get(done.returncode, f"code {done.returncode}")] += 1
        except subprocess.TimeoutExpired:
            ends["hung"] += 1
        except UnicodeDecodeError:
            ends["no UTF-8"] += 1
    return dict(ends)


def pairs(count, work):
    """Outcomes of two runs started into one folder at once."""
    ends = collections.Counter()
    for i in range(count):
        two = [subprocess.Popen([EXE, CD14, *WORDS, "--out", work / f"p{i}", "-q"], stderr=subprocess.DEVNULL) for _ in range(2)]
        codes = sorted(p.wait(LIMIT_S) for p in two)
        rows = len((work / f"p{i}/steps.csv").read_text().splitlines()) - 1
        ends["one complete, one refused" if codes == [0, 3] and rows == 8 else f"codes {codes}, {rows} rows"] += 1
    return dict(ends)


def kills(count, work):
    """Outcomes of runs killed by SIGKILL at a random time, then resumed."""
    words = [*WORDS, "mesh.divisions=48", "mesh.band_facets=8"]
    start = time.monotonic()
    subprocess.run([EXE, CD14, *words, "--out", work / "k", "-q"], check=True)
    lasts = time.monotonic() - start
    right = without_times((work / "k/steps.csv").read_text())
    draw, ends = random.Random(3), collections.Counter()
    for i in range(count):
        run = subprocess.Popen([EXE, CD14, *words, "--out", work / f"k{i}", "-q"])
        time.sleep(lasts * draw.random())
        run.send_signal(signal.SIGKILL)
        run.wait()
        again = subprocess.run([EXE, CD14, *words, "--out", work / f"k{i}", "-q", "--resume"], capture_output=True, text=True)
        if again.returncode == 3 and "complete" in again.stderr:  # it had ended before the kill
            again.returncode = 0
        same = again.returncode == 0 and without_times((work / f"k{i}/steps.csv").read_text()) == right
        ends["resumed to the same digits" if same else f"code {again.returncode}: {again.stderr[:80]}"] += 1
    return dict(ends)


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a tenth of the counts; no record")
    parser.add_argument("--table", action="store_true", help="only write the table of the record")
    options = parser.parse_args()
    part = 10 if options.quick else 1
    if options.table:
        tell(read_record("attack_files"))
        return
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        found = {"mutated": mutated_files(400 // part, work), "namelists": crafted_namelists(200 // part, work),
                 "pairs": pairs(20 // part, work), "kills": kills(25 // part or 1, work)}
    print(json.dumps(found, indent=1))
    if part > 1:
        return
    write_record("attack_files", found)
    tell(found)


def tell(found):
    """The table of the page."""
    rows = [[f"changed `{k}`, then `--resume`", sum(v.values()), told(v)] for k, v in found["mutated"].items()]
    rows += [["namelists put together at random, `--check`", 200, told(found["namelists"])],
             ["two runs started into one folder", 20, told(found["pairs"])],
             ["runs killed by SIGKILL, then `--resume`", 25, told(found["kills"])]]
    put("attack_files", table(["attack", "count", "how they ended"], rows), "evidence/attacks")


def told(ends):
    """Counts in words."""
    return ", ".join(f"{n} {end}" for end, n in sorted(ends.items(), key=lambda e: -e[1]))


if __name__ == "__main__":
    main()
