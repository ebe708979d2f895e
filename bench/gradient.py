#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the time of a loop goes, beside an earlier engine, and what gradient and band cost beside the run that they are of.

Usage: bench/gradient.py [EARLIER_HDENGINE_X]; writes bench/results/gradient.json. Runs take turns, one thread. A part is its share of the clock
times the processor time; without an earlier engine the record keeps what it has of it.
"""
import json
import sys
import tempfile
from pathlib import Path

from common import DATA, ROOT, measured, program, read_record, write_record

SCENES = {"CD-14-100": DATA / "cd14.nml", "pressed drive": ROOT / "tests/cases/pressed_drive.nml", "drive14": DATA / "drive14.nml"}


def run(engine, scene, *choices):
    """Processor time and summary of the fastest of some runs for every choice of keys, in turns."""
    found = [[] for _ in choices]
    for i in 3 * [*range(len(choices))]:
        with tempfile.TemporaryDirectory() as folder:
            done = measured([engine, scene, "run.band=.false.", *choices[i], "--out", f"{folder}/r", "-q"])
            if done.code != 0:
                raise SystemExit(done.text)
            found[i].append((done.cpu_s, json.loads(Path(folder, "r/summary.json").read_text())))
    return [min(runs, key=lambda pair: pair[0]) for runs in found]


def parts(engine, *keys):
    """Processor time of drive14 by part; what is neither of three is one part here."""
    (cpu, summary), = run(engine, SCENES["drive14"], keys)
    times = summary["timers_s"]
    times = {part: times[part] for part in ("setup", "newton", "stiffness", "total")}
    times["fields, stress, output"] = 2 * times["total"] - sum(times.values())
    return {part: float(f"{cpu * seconds / times['total']:.3g}") for part, seconds in times.items() if seconds > 1e-3}


def cost(scene):
    """Keys of a gradient, those among them that have a part, its processor time over that of the run, and that of the band of a drive."""
    choices = (), ("run.gradient=.true.",), ("run.band=auto",)
    (plain, _), (asked, summary), (banded, with_band) = run(program("hdengine.x"), SCENES[scene], *choices)
    columns = [*summary["gradient"].values()]
    return {"scene": scene, "keys": len(columns[0]), "with_part": sum(any(column[key] for column in columns) for key in columns[0]),
            "run_s": float(f"{plain:.3g}"), "gradient_over_run": float(f"{asked / plain - 1:.3g}"),
            "band_over_run": float(f"{banded / plain - 1:.3g}") if "band_shares" in with_band["results"] else None}


def main(words):
    """Measure."""
    before = parts(words[0]) if words else read_record("gradient")["before"]
    write_record("gradient", {"before": before, "now": parts(program("hdengine.x"), "bearing.axial_hold=fast"), "cost": [cost(scene) for scene in SCENES]}, threads=1)


if __name__ == "__main__":
    main(sys.argv[1:])
