# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a lay along an axis is told from offsets of rows or columns (jitter), on maps made by numpy alone.

python bench/lay.py: table of docs/evidence/lay.md, record results/lay.json. --before COMMIT: run by an earlier build's python, its
verdicts are the column "without". --tables: the table alone. One thread: a minute.
"""
import sys
from collections import Counter

import numpy as np
from blind_generators import field, grooves, jitter, straight, stretched

from common import RESULTS, commit, put, read_record, table, write_record
from hdengine.surfaces import roughness

DX, SEEDS, DIMENSIONS = 1e-6, 5, (2.1, 2.5, 2.9)


MAPS = {
    "no fault": ("fractal", lambda d, rng: field(128, DX, d, rng, finer=2)[0]),
    "jitter of rows, 0.05 Sq": ("fractal", lambda d, rng: jitter(128, DX, d, rng, 0.05)),
    "jitter of rows, 0.2 Sq": ("fractal", lambda d, rng: jitter(128, DX, d, rng, 0.2)),
    "jitter of columns, 1 Sq": ("fractal", lambda d, rng: jitter(128, DX, d, rng, 1.0, way=1)),
    "jitter 0.2 Sq over a probe of 1": ("fractal", lambda d, rng: jitter(128, DX, d, rng, 0.2, probe=1.0)),
    "jitter 0.2 Sq over noise of 10 %": ("fractal", lambda d, rng: jitter(128, DX, d, rng, 0.2, noise=0.1)),
    "rows that drift by 1 Sq": ("either", lambda d, rng: jitter(128, DX, d, rng, 1.0, drift=True)),
    "straight grooves, profile of D = 2.1": ("lay", lambda d, rng: straight(128, DX, d, rng, 2.1)),
    "straight grooves, profile of D = 2.9": ("lay", lambda d, rng: straight(128, DX, d, rng, 2.9)),
    "stretched 4 times": ("lay", lambda d, rng: stretched(128, DX, d, rng, 4)),
    "stretched 30 times": ("lay", lambda d, rng: stretched(128, DX, d, rng, 30)),
    "stretched 10 times, turned by 1 degree": ("lay", lambda d, rng: stretched(128, DX, d, rng, 10, np.pi / 180)),
    "stretched 30 times, noise of 10 %": ("lay", lambda d, rng: stretched(128, DX, d, rng, 30, noise=0.1)),
    "grooves of 0.3 sides": ("lay", lambda d, rng: grooves(128, DX, d, rng, 0.3)),
    "grooves of 3 sides": ("lay", lambda d, rng: grooves(128, DX, d, rng, 3.0)),
}


def rows():
    """One row per kind of map: verdicts, and how many lost offsets."""
    for name, (wanted, make) in MAPS.items():
        kinds, lost = Counter(), 0
        for d in DIMENSIONS:
            for seed in range(SEEDS):
                f = roughness.fit(make(d, np.random.default_rng([6100, seed, int(10 * d), len(name)])), DX)
                kinds[f.kind] += 1
                lost += max(f.jitter_m) > 0
        yield {"map": name, "wanted": wanted, "of": SEEDS * len(DIMENSIONS), "kinds": dict(kinds), "taken_off": lost}


def words(row):
    """Verdicts of a row by their number."""
    return ", ".join(f"{kind} {n}" for kind, n in sorted(row["kinds"].items(), key=lambda i: -i[1]))


def main():
    """Measure, write, put."""
    path = RESULTS / "lay.json"
    found = read_record("lay") if path.exists() else {}
    if "--tables" not in sys.argv:
        when = "before" if "--before" in sys.argv else "now"
        found[when] = {"commit": sys.argv[-1] if when == "before" else commit(), "rows": []}
        for row in rows():
            print(row, flush=True)
            found[when]["rows"].append(row)
        write_record("lay", found)
    if "now" in found and "--before" not in sys.argv:
        old = {row["map"]: row for row in found.get("before", found["now"])["rows"]}
        put("lay", table(("map", "verdicts without", "verdicts with", "offsets taken off without", "with"), [
            (name, words(old[name]), words(row), f"{old[name]['taken_off']} of {row['of']}", f"{row['taken_off']} of {row['of']}")
            for name, row in ((row["map"], row) for row in found["now"]["rows"])]), "evidence/lay")


if __name__ == "__main__":
    main()
