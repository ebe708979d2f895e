# SPDX-License-Identifier: GPL-3.0-or-later
"""Bias, spread and coverage of the fit told nothing, and error rates of its verdict, on maps made by numpy alone.

python bench/blind_fit.py [seeds] [points per side]: writes results/blind_fit.json and the tables of docs/evidence/{fit,surfaces}.md.
One thread: minutes. `--tables` only writes the tables of the record again.
python bench/blind_fit.py --sizes [seeds]: larger maps at D = 2.5, results/blind_fit_sizes.json and their table.
"""
import sys

import numpy as np
from blind_generators import LN_G, NOT_FRACTAL, field, line

from common import put, read_record, table, write_record
from hdengine.surfaces import roughness

DX = 1e-6
MAPS = {
    "square to Nyquist": {}, "circle to Nyquist": {"top": 0.5}, "circle to half of it": {"top": 0.25},
    "4 times finer detail": {"finer": 4}, "probe 0.25": {"finer": 4, "probe": 0.25}, "probe 0.5": {"finer": 4, "probe": 0.5},
    "probe 1": {"finer": 2, "probe": 1.0}, "probe 2": {"probe": 2.0}, "noise 5 %": {"finer": 2, "noise": 0.05},
    "noise 30 %": {"finer": 2, "noise": 0.3}, "tilt": {"finer": 2, "tilt": 3.0}, "waves of 4 sides": {"longer": 4},
    "dy = 1.7 dx": {"finer": 2, "aspect": 1.7}, "5 % holes": {"finer": 2}, "7 spikes": {"finer": 2},
}
LARGE = ("circle to Nyquist", "4 times finer detail", "probe 0.5", "probe 1", "noise 5 %", "noise 30 %", "tilt", "5 % holes")
LINES = {"line": {}, "line, finer detail": {"finer": 4}, "line, probe 1": {"probe": 1.0}, "line, noise 5 %": {"noise": 0.05}}


def row(make, d, seeds):
    """Statistics of one kind of map."""
    fits = [roughness.fit(*make(np.random.default_rng(1000 + s))) for s in range(seeds)]
    e = np.array([f.fractal_dimension for f in fits]) - d
    inside = [f.interval[0][0] <= d <= f.interval[0][1] for f in fits]
    g = [f.interval[1][0] <= np.exp(LN_G) <= f.interval[1][1] for f in fits]
    return {"bias": e.mean(), "median": np.median(e), "std": e.std(ddof=1), "cover_d": np.mean(inside), "cover_g": np.mean(g),
            "width": float(np.median([np.ptp(f.interval[0]) for f in fits])), "fractal": np.mean([f.verdict == "fractal" for f in fits]),
            "left": int(sum(not f.interval[0][0] <= f.fractal_dimension <= f.interval[0][1] for f in fits))}


def spoiled(name, z, rng):
    """Holes or spikes of a map."""
    if "holes" in name:
        z.flat[rng.choice(z.size, z.size // 20, replace=False)] = np.nan
    if "spikes" in name:
        z.flat[rng.choice(z.size, 7, replace=False)] += 5 * z.std()
    return z


def put_tables(found):
    """The twelve kinds of maps of known D with the largest bias; kinds that are not fractal."""
    kinds, rows = {}, []
    for name, values in found["maps"].items():
        kind, d = name.split(", D = ")
        kinds.setdefault(kind, {})[float(d)] = values
    for kind, at in kinds.items():
        every = [at[d] for d in sorted(at)]
        rows.append((max(abs(v["bias"]) for v in every), (
            kind, *(f"{v['bias']:+.3f}" for v in every), f"{min(v['std'] for v in every):.2f} to {max(v['std'] for v in every):.2f}",
            " / ".join(f"{100 * v['cover_d']:.0f}" for v in every), " / ".join(f"{100 * v['cover_g']:.0f}" for v in every),
            f"{found['seeds'] * sum(1 - v['fractal'] for v in every):.0f} of {3 * found['seeds']}")))
    put("blind", table(("kind of map", "bias, D = 2.1", "2.5", "2.9", "std of D", "D inside, %", "G inside, %", "refused"),
                       [row for _, row in sorted(rows, key=lambda r: -r[0])[:12]]), "evidence/fit")
    put("kinds", table(("kind", "called fractal", "named"), [
        (name, f"{v['called_fractal']} of {v['of']}", ", ".join(f"{kind} {n}" for kind, n in sorted(v["kinds"].items(), key=lambda i: -i[1])))
        for name, v in found["not_fractal"].items()]), "evidence/surfaces")


def maker(name, n, d):
    """A function that makes one map of a kind."""
    def make(rng):
        z, spacing = field(n, DX, d, rng, **MAPS[name])
        return spoiled(name, z, rng), spacing
    return make


def put_sizes(found):
    """Bias, spread and coverage over the number of points, one row for each kind."""
    sizes = sorted({int(key.split(", ")[1]) for key in found["maps"]})
    rows = []
    for name in LARGE:
        at = [found["maps"].get(f"{name}, {n}") for n in sizes]
        rows.append((name, *(f"{v['bias']:+.4f} ± {v['std']:.3f}" if v else "-" for v in at),
                     " / ".join(f"{found['seeds'] * v['cover_d']:.0f}" if v else "-" for v in at),
                     " / ".join(f"{found['seeds'] * v['cover_g']:.0f}" if v else "-" for v in at),
                     " / ".join(f"{found['seeds'] * (1 - v['fractal']):.0f}" if v else "-" for v in at)))
    put("sizes", table(("kind of map", *(f"{n}²" for n in sizes), "D inside", "G inside", "refused"), rows), "evidence/fit")


def larger(seeds=10):
    """Maps of 256 to 1024 points a side; the record grows by each row."""
    out = {"seeds": seeds, "maps": {}}
    for n in (256, 512, 1024):
        for name in LARGE:
            values = row(maker(name, n, 2.5), 2.5, seeds)
            out["maps"][f"{name}, {n}"] = {k: round(float(v), 5) for k, v in values.items()}
            print(n, name, out["maps"][f"{name}, {n}"], flush=True)
            write_record("blind_fit_sizes", out, seed=1000)
    put_sizes(out)


def main(seeds=20, n=128):
    """All rows."""
    out = {"seeds": seeds, "points": n, "maps": {}, "not_fractal": {}}

    def keep(name, d, values):
        out["maps"][f"{name}, D = {d}"] = {k: round(float(v), 4) for k, v in values.items()}
        print(name, d, out["maps"][f"{name}, D = {d}"], flush=True)

    for name, make in NOT_FRACTAL.items():
        kinds = [roughness.fit(make(n, np.random.default_rng(2000 + s)), DX) for s in range(min(seeds, 20))]
        out["not_fractal"][name] = {"called_fractal": sum(f.verdict == "fractal" for f in kinds), "of": len(kinds),
                                    "kinds": {k: sum(f.kind == k for f in kinds) for k in sorted({f.kind for f in kinds})}}
        print(name, out["not_fractal"][name], flush=True)
    for d in (2.5, 2.1, 2.9):
        for name in MAPS:
            keep(name, d, row(maker(name, n, d), d, seeds))
        for name, keys in LINES.items():
            keep(name, d, row(lambda rng, keys=keys, d=d: (line(4096, DX, d, rng, **keys), DX), d, seeds))
    write_record("blind_fit", out, seed=1000)
    put_tables(out)


if __name__ == "__main__":
    if "--tables" in sys.argv:
        put_tables(read_record("blind_fit"))
        put_sizes(read_record("blind_fit_sizes"))
    elif "--sizes" in sys.argv:
        larger(*map(int, sys.argv[2:]))
    else:
        main(*map(int, sys.argv[1:]))
