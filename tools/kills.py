#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that are killed at random moments: python tools/kills.py [--count 60] [--seed 1]

Press fits, drives and plans get SIGKILL, SIGTERM or SIGINT up to three times and go on with --resume; studies and joints are begun again. In the
end every table must be that of a run that nobody disturbed, to the byte but for the columns of seconds, and no stop may leave a complete record.
"""
import argparse
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import hdengine_x

ROOT = Path(__file__).resolve().parents[1]
SMALL = ["mesh.divisions=16", "mesh.band_facets=3", "load.assembly_steps=2"]
STUDY = "[fixed]\nmesh = {divisions = 16, band_facets = 3}\nload.torque_steps = 2\n[grid]\nload.torque = [1, 2, 3, 4]\n"
HDENGINE = [sys.executable, "-m", "hdengine"]


def commands(folder):
    """A command by name, the words that go on with it, and those of its outputs that are compared."""
    (folder / "s.toml").write_text(STUDY)
    exe = hdengine_x.PROGRAM
    return {
        "run": ([exe, ROOT / "data/cd14.nml", *SMALL, "load.torque_steps=60", "output.vtu=all", "-q"], ["--resume"]),
        "loop": ([exe, ROOT / "tests/cases/pressed_drive.nml", *SMALL, "load.torque_steps=12", "load.tooth_friction=0.1", "turning.positions=3", "-q"], ["--resume"]),
        "plan": ([exe, ROOT / "data/cd14.nml", "run.tolerance=0.5", "load.torque_steps=1", "load.assembly_steps=1", "-q"], ["--resume"]),
        "study": ([*HDENGINE, "study", folder / "s.toml", "-q"], []),
        "joint": ([*HDENGINE, "joint", ROOT / "data/specimen_flexspline.sdf"], ["--force"])}


def table(path):
    """Bytes of a table without what differs from run to run."""
    lines = path.read_text().splitlines()
    times = [k for k, name in enumerate(lines[0].split(",")) if name in ("seconds", "checksum") or name.endswith(("_s", "_mb"))]   # the checksum is of seconds too
    return [[cell for k, cell in enumerate(line.split(",")) if k not in times] for line in lines]


def contents(out):
    """What must be the same: tables and grids by name."""
    return {path.name: table(path) if path.suffix == ".csv" else path.read_bytes() for path in sorted(out.rglob("*"))
            if path.suffix in (".csv", ".vtu", ".pvd", ".nml") and "/points/" not in str(path)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("kinds", nargs="*")
    args = parser.parse_args()
    lot, folder, kills, wrong = random.Random(args.seed), Path(tempfile.mkdtemp()), {}, 0
    known, whole, seconds = commands(folder), {}, {}
    for part in ("whole", "out"):
        (folder / part).mkdir()
    for name in args.kinds or known:
        start = time.monotonic()
        subprocess.run([*map(str, known[name][0]), "--out", folder / "whole" / name], check=True, stdout=subprocess.DEVNULL)
        whole[name], seconds[name] = contents(folder / "whole" / name), time.monotonic() - start
    while sum(kills.values()) < args.count:
        name = lot.choice(sorted(whole))
        words, on = known[name]
        out, more = folder / "out" / name, []
        shutil.rmtree(out, ignore_errors=True)
        for _ in range(lot.randint(1, 3)):
            process = subprocess.Popen([*map(str, words), *more, "--out", out], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(lot.uniform(0, seconds[name]))
            number = lot.choice((signal.SIGKILL, signal.SIGTERM, signal.SIGINT))
            process.send_signal(number)
            code = process.wait()
            kills[name] = kills.get(name, 0) + (code != 0)
            more = on if out.exists() else []
            if code == 0:
                break
            complete = any(re.search(r'"status": "complete"', p.read_text()) for p in out.glob("summary.json"))
            if code not in (-number, 1, 7, 130, 128 + number) or complete and contents(out) != whole[name]:
                print(f"{name}: {number.name} ends with code {code}, or leaves a complete record of less than all")
                wrong += 1
            if complete:
                code = 0
                break
        if code != 0:
            done = subprocess.run([*map(str, words), *more, "--out", out], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            if done.returncode:
                print(f"{name}: code {done.returncode} when it goes on: {done.stderr.strip()}")
                wrong += 1
                continue
        found = contents(out)
        if different := [n for n in whole[name] if found.get(n) != whole[name][n]]:
            print(f"{name}: other {different} after its kills")
            wrong += 1
    shutil.rmtree(folder)
    print(f"{sum(kills.values())} kills {kills}, {wrong} wrong")
    return min(1, wrong)


if __name__ == "__main__":
    sys.exit(main())
