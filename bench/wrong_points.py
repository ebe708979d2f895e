# SPDX-License-Identifier: GPL-3.0-or-later
"""What wrong points, seams of stitching and row jitter do to D, and what is found of them, on maps made by numpy alone.

python bench/wrong_points.py [structure] [faults] [clean] measures these parts, or all, and writes them under "now", each with its
commit, into results/wrong_points.json, and the tables and the figure of docs/evidence/wrong_points.md. --before COMMIT: run by an
earlier build's python, its rows are "before". --tables: tables and figure alone.
"""
import sys
import warnings
from functools import cache

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from blind_generators import clumps, field, line

from common import RESULTS, commit, put, read_record, save_figure, table, write_record
from hdengine.surfaces import roughness, specimen

DX, N, SEEDS = 1e-6, 128, 12


def spikes(z, rng):
    """Each fault changes a map in place and says which points are wrong by themselves."""
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


FAULTS = {"none": None, "7 spikes of 5 Sq": spikes, "0.5 % spikes of 1 to 5 Sq": many_spikes, "20 clumps of 2 x 2 at 3 Sq": clumps,
          "row jitter of 0.2 Sq": jitter, "seam of 1 Sq": seam, "seam of 0.2 Sq": small_seam, "four tiles apart by 0.7 to 1.9 Sq": tiles,
          "spikes, clumps, jitter, tiles": all_of_them}
CLEAN = {"square to Nyquist": {}, "2 times finer detail": {"finer": 2}, "probe 1": {"finer": 2, "probe": 1.0}, "probe 2": {"probe": 2.0},
         "noise 10 %": {"finer": 2, "noise": 0.1}}


def spoil(d, seed, fault):
    """A clean map, the same with a fault, and its wrong points."""
    z, spacing = field(N, DX, d, np.random.default_rng(3000 + seed), finer=2)
    bad = z.copy()
    wrong = np.zeros(z.shape, dtype=bool) if fault is None else fault(bad, np.random.default_rng(seed))
    return z, bad, wrong, spacing


def clean(z, spacing):
    """The map without wrong points and steps; an earlier build leaves the steps."""
    s = specimen.Specimen(z, spacing)
    try:
        return specimen.clean(s, seams=True)[0]
    except TypeError:
        return specimen.clean(s)[0]


@cache
def clean_d(d, seed):
    """D of the clean map."""
    return roughness.fit(*field(N, DX, d, np.random.default_rng(3000 + seed), finer=2)).fractal_dimension


def rows():
    """One row per fault: D moved by it, intervals, what was found."""
    for name, fault in FAULTS.items():
        row = {"fault": name}
        for d in (2.1, 2.5, 2.9):
            moved, bias, inside, fractal, found, lost, seams, told = [], [], [], [], [], [], [], []
            for seed in range(SEEDS):
                _, bad, wrong, spacing = spoil(d, seed, fault)
                fit = roughness.fit(bad, spacing)
                masked = np.isnan(clean(bad, spacing).heights)
                moved.append(fit.fractal_dimension - clean_d(d, seed))
                bias.append(fit.fractal_dimension - d)
                inside.append(fit.interval[0][0] <= d <= fit.interval[0][1])
                fractal.append(fit.verdict == "fractal")
                told.append(max(fit.axis_excess) > 3)
                seams.append(sum(getattr(fit, "seams", (0, 0))))
                found.append(np.mean(masked[wrong]) if wrong.any() else np.nan)
                lost.append(np.sum(masked & ~wrong))
            row[str(d)] = {"moved": float(np.median(np.abs(moved))), "moved_most": float(np.max(np.abs(moved))), "bias": float(np.mean(bias)),
                           "inside": float(np.mean(inside)), "fractal": float(np.mean(fractal)), "seams": float(np.mean(seams)),
                           "axis": float(np.mean(told)), "found": float(np.nanmean(found)) if np.isfinite(found).any() else None,
                           "lost": int(np.sum(lost))}
        print(name, {k: v for k, v in row.items() if k != "fault"}, flush=True)
        yield row


def structure_rows():
    """Largest |ln S over that of the clean map| of lags 1 to 20, median over maps: as it is, robust, and without wrong points."""
    for name, fault in FAULTS.items():
        row = {"fault": name}
        for d in (2.1, 2.5, 2.9):
            off = {"plain": [], "robust": [], "masked": []}
            for seed in range(SEEDS):
                z, bad, _, spacing = spoil(d, seed, fault)
                lags = np.arange(1, 21)
                right = roughness.structure_function(z, spacing, lags)[1]
                masked = clean(bad, spacing).heights
                for key, m, options in (("plain", bad, {}), ("robust", bad, {"robust": True}), ("masked", masked, {})):
                    try:
                        s = roughness.structure_function(m, spacing, lags, **options)[1]
                    except TypeError:       # an earlier build
                        continue
                    off[key].append(np.max(np.abs(np.log(s / right))))
            row[str(d)] = {k: float(np.median(v)) for k, v in off.items() if v}
        yield row


def clean_rows():
    """Points that clean maps and lines lose, and seams that are seen where none is."""
    for name, keys in CLEAN.items():
        for n, seeds in ((128, 40), (512, 6)):
            row = {"map": name, "points": n, "maps": 3 * seeds, "lost": 0, "maps_that_lose": 0, "maps_with_seams": 0, "maps_with_axes": 0}
            for d in (2.1, 2.5, 2.9):
                for seed in range(seeds):
                    z, spacing = field(n, DX, d, np.random.default_rng(5000 + seed), **keys)
                    lost = specimen.clean(specimen.Specimen(z, spacing))[1]
                    row["lost"] += lost
                    row["maps_that_lose"] += lost > 0
                    if n == 128:
                        f = roughness.fit(z, spacing)
                        row["maps_with_seams"] += sum(getattr(f, "seams", (0, 0))) > 0
                        row["maps_with_axes"] += max(f.axis_excess) > 3
            print(row, flush=True)
            yield row
    row = {"map": "lines, probe 0 and 1", "points": 4096, "maps": 0, "lost": 0, "maps_that_lose": 0}
    for d in (2.1, 2.5, 2.9):
        for probe in (0.0, 1.0):
            for seed in range(40):
                lost = specimen.clean(specimen.Specimen(line(4096, DX, d, np.random.default_rng(seed), probe=probe), DX))[1]
                row["maps"] += 1
                row["lost"] += lost
                row["maps_that_lose"] += lost > 0
    yield row


def put_tables(record):
    """What each fault does to the present build; rows of an earlier one stay in the record."""
    now = record["now"]

    def each(row, key, text, scale=1):
        return "/".join("-" if row[d][key] is None else text.format(scale * row[d][key]) for d in ("2.1", "2.5", "2.9"))

    put("faults", table(("fault", "D moved", "largest", "D inside, %", "fractal, %", "found, %", "lost", "seams"), [
        (r["fault"], each(r, "moved", "{:.3f}"), each(r, "moved_most", "{:.2f}"),
         each(r, "inside", "{:.0f}", 100), each(r, "fractal", "{:.0f}", 100), each(r, "found", "{:.0f}", 100), each(r, "lost", "{}"),
         each(r, "seams", "{:.1f}")) for r in now["faults"]]), "evidence/wrong_points")
    put("structure", table(("fault", "as it is", "robust estimator", "masked"), [
        (r["fault"], *(each(r, k, "{:.3f}") for k in ("plain", "robust", "masked"))) for r in now["structure"] if "jitter of" not in r["fault"]]), "evidence/wrong_points")
    put("clean", table(("maps", "points", "number", "points lost", "maps that lose", "maps with a seam", "with an axis"), [
        (r["map"], r["points"], r["maps"], r["lost"], r["maps_that_lose"],
         *(r[key] if r["points"] == 128 else "-" for key in ("maps_with_seams", "maps_with_axes"))) for r in now["clean"]]),
        "evidence/wrong_points")


def put_figure(record):
    """A map with every fault, the same cleaned, and how far each fault moves D."""
    z, bad, _, spacing = spoil(2.5, 3, all_of_them)
    mended = clean(bad, spacing).heights
    fig, axes = plt.subplots(1, 3, figsize=(12, 3.8), width_ratios=(1, 1, 1.5), layout="constrained")
    low, high = np.quantile(bad, (0.005, 0.995)) * 1e6
    for ax, m, title in ((axes[0], bad, "as it came"), (axes[1], mended, "cleaned: levelled, holes red")):
        ax.imshow(m * 1e6, origin="lower", extent=(0, 128, 0, 128), vmin=low, vmax=high, cmap=matplotlib.colormaps["viridis"].with_extremes(bad="red"))
        ax.set(title=title, xlabel="x / µm", ylabel="y / µm" if m is bad else "")
    names = [r["fault"] for r in record["now"]["faults"]][1:]
    rows_of = {r["fault"]: r for r in record["now"]["faults"]}
    for d, marker in (("2.1", "v"), ("2.5", "o"), ("2.9", "^")):
        axes[2].plot([max(rows_of[n][d]["moved"], 1e-4) for n in names], np.arange(len(names)), marker, label=f"D = {d}")
    axes[2].set(xscale="log", xlabel="|change of D by the fault|, median of 12 maps", yticks=range(len(names)), yticklabels=names)
    axes[2].invert_yaxis()
    axes[2].grid(alpha=0.3)
    axes[2].legend(fontsize=7)
    save_figure(fig, "wrong_points")


PARTS = {"structure": structure_rows, "faults": rows, "clean": clean_rows}


def main(name, build, parts):
    """Rows of one build."""
    warnings.simplefilter("ignore")
    record = read_record("wrong_points") if (RESULTS / "wrong_points.json").exists() else {}
    for key in parts:
        record.setdefault(name, {}).setdefault("commits", {})[key] = build
        record[name][key] = list(PARTS[key]())
        write_record("wrong_points", record, seed=3000)
    if "now" in record:
        put_tables(record)
        put_figure(record)


if __name__ == "__main__":
    if "--tables" in sys.argv:
        put_tables(read_record("wrong_points"))
        put_figure(read_record("wrong_points"))
    else:
        asked = [a for a in sys.argv[1:] if a in PARTS] or list(PARTS)
        main(*("before", sys.argv[sys.argv.index("--before") + 1]) if "--before" in sys.argv else ("now", commit()), asked)
