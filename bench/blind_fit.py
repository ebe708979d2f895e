# SPDX-License-Identifier: GPL-3.0-or-later
"""Bias, spread and coverage of the fit told nothing, and error rates of its verdict, on maps made by numpy alone.

python bench/blind_fit.py [maps|kinds|sizes|bias|crossovers [seeds]]: maps and lines of known D on 128 points a side, kinds that are
not fractal, larger maps at D = 2.5, more maps of the rows whose bias lies above 0.02, more crossovers. Each writes its record
(results/blind_fit.json, blind_fit_{kinds,sizes,bias,crossovers}.json) row by row, and its table of docs/evidence/{fit,surfaces}.md at
the end. One thread: minutes. `--tables` only writes the tables of the records again.
"""
import sys
import zlib

import numpy as np
from blind_generators import LN_G, NOT_FRACTAL, field, line

from common import put, read_record, table, write_record
from hdengine.surfaces import roughness

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


def row(name, n, d, seeds, error=np.inf):
    """Statistics of one kind of map: of so many maps, or of more until the standard error of the bias is small enough."""
    make = maker(name, n, d)
    fits = []
    for rng in generators(f"{name}, {n}, {d}", seeds if error == np.inf else 600):
        fits.append(roughness.fit(*make(rng)))
        if len(fits) >= seeds and np.std([f.fractal_dimension for f in fits], ddof=1) < error * len(fits)**0.5:
            break
    e = np.array([f.fractal_dimension for f in fits]) - d
    inside = [f.interval[0][0] <= d <= f.interval[0][1] for f in fits]
    g = [f.interval[1][0] <= np.exp(LN_G) <= f.interval[1][1] for f in fits]
    return {"bias": float(e.mean()), "median": float(np.median(e)), "std": float(e.std(ddof=1)), "cover_d": float(np.mean(inside)),
            "cover_g": float(np.mean(g)),
            "width": float(np.median([np.ptp(f.interval[0]) for f in fits])), "fractal": float(np.mean([f.verdict == "fractal" for f in fits])),
            "left": int(sum(not f.interval[0][0] <= f.fractal_dimension <= f.interval[0][1] for f in fits)), "maps": len(fits)}


def spoiled(name, z, rng):
    """Holes or spikes of a map."""
    if "holes" in name:
        z.flat[rng.choice(z.size, z.size // 20, replace=False)] = np.nan
    if "spikes" in name:
        z.flat[rng.choice(z.size, 7, replace=False)] += 5 * z.std()
    return z


def put_maps(found):
    """The twelve kinds of maps of known D with the largest bias."""
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


def put_kinds(found):
    """Kinds that are not fractal."""
    put("kinds", table(("kind", "called fractal", "named"), [
        (name, f"{v['called_fractal']} of {v['of']}", ", ".join(f"{kind} {n}" for kind, n in sorted(v["kinds"].items(), key=lambda i: -i[1])))
        for name, v in found["maps"].items()]), "evidence/surfaces")


def put_bias(found):
    """Rows of many maps."""
    put("bias", table(("row", "maps", "bias of ten maps", "bias of all", "median", "std of D", "D inside, %", "not called fractal"), [
        (name, v["maps"], f"{v['ten']:+.3f}", f"{v['bias']:+.4f} ± {v['std'] / v['maps']**0.5:.4f}", f"{v['median']:+.3f}",
         f"{v['std']:.2f}", f"{100 * v['cover_d']:.0f}", f"{v['maps'] * (1 - v['fractal']):.0f}")
        for name, v in found["maps"].items()]), "evidence/fit_bound")


def maker(name, n, d):
    """A function that makes one map of a kind, or a line of 4096 points."""
    def make(rng):
        if name in LINES:
            return line(4096, DX, d, rng, **LINES[name]), DX
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


def maps(seeds=10):
    """Maps of 128 points a side and lines of 4096 of known D: a row each."""
    for d in (2.5, 2.1, 2.9):
        for name in (*MAPS, *LINES):
            yield f"{name}, D = {d}", row(name, 128, d, seeds)


def kinds(seeds=20, names=tuple(NOT_FRACTAL)):
    """Maps of 128 points a side that are not fractal: a row each."""
    for name in names:
        fits = [roughness.fit(NOT_FRACTAL[name](128, rng), DX) for rng in generators(name, seeds)]
        yield name, {"cannot_tell": sum("cannot tell" in f.reason for f in fits),
                     "called_fractal": sum(f.verdict == "fractal" for f in fits), "of": len(fits),
                     "kinds": {k: sum(f.kind == k for f in fits) for k in sorted({f.kind for f in fits})}}


def sizes(seeds=10):
    """Maps of 256 to 1024 points a side: a row each."""
    for n in (1024, 512, 256):
        for name in LARGE:
            yield f"{name}, {n}", row(name, n, 2.5, seeds)


def bias(seeds=60):
    """Fresh maps of the rows of results/blind_fit.json whose bias lies above 0.02, until its standard error is below 0.007."""
    global SEED
    SEED += 3000
    for key, old in sorted(read_record("blind_fit")["maps"].items(), key=lambda i: -abs(i[1]["bias"])):
        if abs(old["bias"]) > 0.02:
            name, d = key.split(", D = ")
            yield key, {**row(name, 128, float(d), seeds, 0.007), "ten": old["bias"]}


def crossovers(seeds=100):
    """Fresh maps of both crossovers: a row each."""
    global SEED
    SEED += 4000
    yield from kinds(seeds, ("crossover up", "crossover down"))


PARTS = {"maps": ("blind_fit", maps, put_maps), "kinds": ("blind_fit_kinds", kinds, put_kinds),
         "sizes": ("blind_fit_sizes", sizes, put_sizes), "bias": ("blind_fit_bias", bias, put_bias),
         "crossovers": ("blind_fit_crossovers", crossovers, print)}


def main(part, *seeds):
    """One part: its record grows by each row."""
    record, rows, put_table = PARTS[part]
    out = {"seeds": seeds[0] if seeds else rows.__defaults__[0], "maps": {}}
    for name, values in rows(*seeds):
        out["maps"][name] = {k: round(v, 5) if isinstance(v, float) else v for k, v in values.items()}
        print(name, out["maps"][name], flush=True)
        write_record(record, out, seed=SEED)
    put_table(out)


if __name__ == "__main__":
    if "--tables" in sys.argv:
        for record, _, put_table in PARTS.values():
            put_table(read_record(record))
    elif len(sys.argv) > 1:
        main(sys.argv[1], *map(int, sys.argv[2:]))
    else:
        for each in PARTS:
            main(each)
