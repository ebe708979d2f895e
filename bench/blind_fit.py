#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The fit told nothing, on maps made by numpy alone: bias, scatter and coverage, verdicts, and what wrong points and seams do to D.

Usage: bench/blind_fit.py [maps] [sizes] [kinds] [faults]: maps and lines of known D on 128 points a side; larger maps at D = 2.5; maps that are not
fractal; maps of known D with faults. Each writes its part of bench/results/blind_fit.json. One thread: minutes.
"""
import sys
import warnings
import zlib

import numpy as np
from blind_generators import LN_G, NOT_FRACTAL, clumps, field, line

from common import short, write_part
from hdengine.surfaces import roughness, specimen

DX = 1e-6
SEED = 48000     # with name, size and number the seed of a map: no two kinds share a map, none was looked at while the fit was built
MAPS = {
    "square to Nyquist": {}, "circle to Nyquist": {"top": 0.5}, "circle to half of it": {"top": 0.25},
    "4 times finer detail": {"finer": 4}, "probe 0.25": {"finer": 4, "probe": 0.25}, "probe 0.5": {"finer": 4, "probe": 0.5},
    "probe 1": {"finer": 2, "probe": 1.0}, "probe 2": {"probe": 2.0}, "noise 5 %": {"finer": 2, "noise": 0.05},
    "noise 30 %": {"finer": 2, "noise": 0.3}, "tilt": {"finer": 2, "tilt": 3.0}, "waves of 4 sides": {"longer": 4},
    "dy = 1.7 dx": {"finer": 2, "aspect": 1.7}, "5 % holes": {"finer": 2}, "7 spikes": {"finer": 2},
}
LARGE = ("circle to Nyquist", "4 times finer detail", "probe 0.5", "probe 1", "probe 2", "noise 5 %", "noise 30 %", "tilt", "5 % holes")
LINES = {"line": {}, "line, finer detail": {"finer": 4}, "line, probe 1": {"probe": 1.0}, "line, noise 5 %": {"noise": 0.05}}


def generators(name, seeds):
    """A random generator for each map of a kind."""
    return (np.random.default_rng([SEED, zlib.crc32(name.encode()), s]) for s in range(seeds))


def make(name, n, d, rng):
    """One map of a kind, or a line of 4096 points."""
    if name in LINES:
        return line(4096, DX, d, rng, **LINES[name]), DX
    z, spacing = field(n, DX, d, rng, **MAPS[name])
    if "holes" in name:
        z.flat[rng.choice(z.size, z.size // 20, replace=False)] = np.nan
    if "spikes" in name:
        z.flat[rng.choice(z.size, 7, replace=False)] += 5 * z.std()
    return z, spacing


def row(name, n, d, seeds=10):
    """Statistics of one kind of map."""
    fits = [roughness.fit(*make(name, n, d, rng)) for rng in generators(f"{name}, {n}, {d}", seeds)]
    e = np.array([f.fractal_dimension for f in fits]) - d
    return short({"bias": e.mean(), "std": e.std(ddof=1), "cover_d": np.mean([f.interval[0][0] <= d <= f.interval[0][1] for f in fits]),
                  "cover_g": np.mean([f.interval[1][0] <= np.exp(LN_G) <= f.interval[1][1] for f in fits]),
                  "fractal": np.mean([f.verdict == "fractal" for f in fits])}, 3) | {"maps": len(fits)}


def maps():
    """Maps of 128 points a side and lines of 4096 of known D."""
    return {f"{name}, D = {d}": row(name, 128, d) for d in (2.5, 2.1, 2.9) for name in (*MAPS, *LINES)}


def sizes():
    """Maps of 256 to 1024 points a side."""
    return {f"{name}, {n}": row(name, n, 2.5) for n in (1024, 512, 256) for name in LARGE}


def kinds(seeds=20):
    """Maps of 128 points a side that are not fractal."""
    return {name: {"called_fractal": sum(roughness.fit(NOT_FRACTAL[name](128, rng), DX).verdict == "fractal" for rng in generators(name, seeds)),
                   "of": seeds} for name in NOT_FRACTAL}


# --- faults: each changes a map in place and says which points are wrong by themselves

def spikes(z, rng):
    wrong = np.zeros(z.shape, dtype=bool)
    wrong.flat[rng.choice(z.size, 7, replace=False)] = True
    z[wrong] += 5 * z.std()
    return wrong


def many_spikes(z, rng):
    wrong = np.zeros(z.shape, dtype=bool)
    wrong.flat[rng.choice(z.size, z.size // 200, replace=False)] = True
    z[wrong] += z.std() * rng.uniform(1, 5, wrong.sum()) * rng.choice([-1, 1], wrong.sum())
    return wrong


def jitter(z, rng):
    z += 0.2 * z.std() * rng.standard_normal((z.shape[0], 1))
    return np.zeros(z.shape, dtype=bool)


def seam(z, rng, step=1.0):
    z[:, rng.integers(20, z.shape[1] - 20):] += step * z.std()
    return np.zeros(z.shape, dtype=bool)


def small_seam(z, rng):
    return seam(z, rng, 0.2)


def tiles(z, rng):
    i, j = rng.integers(50, min(z.shape) - 50, 2)
    z[i:, :j] += 0.7 * z.std()
    z[:i, j:] -= 1.2 * z.std()
    return np.zeros(z.shape, dtype=bool)


def all_of_them(z, rng):
    return spikes(z, rng) | clumps(z, rng) | jitter(z, rng) | tiles(z, rng)


FAULTS = {"7 spikes of 5 Sq": spikes, "0.5 % spikes of 1 to 5 Sq": many_spikes, "20 clumps of 2 x 2 at 3 Sq": clumps, "row jitter of 0.2 Sq": jitter,
          "seam of 1 Sq": seam, "seam of 0.2 Sq": small_seam, "four tiles apart by 0.7 to 1.9 Sq": tiles, "spikes, clumps, jitter, tiles": all_of_them}


def faulty(fault, d, seeds=12):
    """How far a fault moves D, how often the interval holds it, and which wrong points are found."""
    moved, inside, found, lost = [], [], [], 0
    for seed in range(seeds):
        z, spacing = field(128, DX, d, np.random.default_rng(3000 + seed), finer=2)
        clean = roughness.fit(z, spacing).fractal_dimension
        wrong = fault(z, np.random.default_rng(seed))
        fit = roughness.fit(z, spacing)
        masked = np.isnan(specimen.clean(specimen.Specimen(z, spacing), seams=True)[0].heights)
        moved.append(abs(fit.fractal_dimension - clean))
        inside.append(fit.interval[0][0] <= d <= fit.interval[0][1])
        found.append(np.mean(masked[wrong]) if wrong.any() else np.nan)
        lost += np.sum(masked & ~wrong)
    return short({"moved": np.median(moved), "moved_most": np.max(moved), "inside": np.mean(inside), "found": np.mean(found), "lost": lost}, 3)


def faults():
    """A row for each fault."""
    return [{"fault": name, **{str(d): faulty(fault, d) for d in (2.1, 2.5, 2.9)}} for name, fault in FAULTS.items()]


PARTS = {f.__name__: f for f in (maps, sizes, kinds, faults)}

if __name__ == "__main__":
    warnings.simplefilter("ignore")
    for part in sys.argv[1:] or PARTS:
        found = PARTS[part]()
        print(part, found, flush=True)
        write_part("blind_fit", part, found, seed=SEED)
