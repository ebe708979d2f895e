#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Heights of Eq. 1: hdengine beside FINUFFT and a vectorised numpy sum, error and time, in one run.

Needs the Python package finufft. The peers get the list of waves for nothing and are timed from there: FINUFFT with its phase
factors (double precision; single too from a tolerance of 1e-5 on), numpy wave by wave over the whole grid (timed on a few waves
and scaled, on all at 1024^2 and 160 waves). hdengine is timed twice: `sum_waves` on the same list, and `generate`, which makes
the waves as well. The best of up to 15 (2048^2: of 2, 4096^2: one), methods in turn: first one thread each and processor time, so
that a shared machine does not decide, then two threads each and wall clock, on fewer numbers of waves; each in a process of its
own. Errors: root mean square over 128 x 128 points spread over the grid, edges included, relative to the heights; the reference
is the direct sum.
Usage: bench/surface_generator.py [--sizes 256 512 1024 2048 4096] [--limit 0.7] [--output bench/results/surface_generator.json]
"""
import os

THREADS = int(os.environ.get("HD_THREADS", "0"))  # 0: run this script with 1 and with 2
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = str(max(THREADS, 1))

import argparse
import json
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import finufft
import numpy as np

import hdengine
from common import ROOT
from hdengine import surface

clock = time.thread_time if THREADS < 2 else time.perf_counter
LENGTH = 0.5e-3
WAVES = ((4, 4), (10, 16), (40, 16), (100, 16), (400, 16), (1000, 20))  # ridges, n_max + 1



def spectrum(n, ridges, count):
    """Eq. 1 with `count` waves on each ridge, from the side of the map to two spacings."""
    gamma = (n / 2) ** (1 / (count - 0.5))
    return dict(fractal_dimension=2.5304, roughness=2.4248e-7, gamma=gamma, length=LENGTH,
                shortest_wavelength=2 * LENGTH / n, ridges=ridges, seed=1)


def by_finufft(w, n, tolerance, kind):
    """Heights without the constant; the middle of FINUFFT's grid is point n // 2."""
    h = LENGTH / n
    turns = w["phase_turns"] + (n // 2) * h * (w["fx_per_m"] + w["fy_per_m"])
    strength = (-w["amplitude_m"] * np.exp(2j * np.pi * turns)).astype(kind)
    real = strength.real.dtype
    return finufft.nufft2d1((2 * np.pi * h * w["fy_per_m"]).astype(real), (2 * np.pi * h * w["fx_per_m"]).astype(real),
                            strength, (n, n), isign=1, eps=tolerance, nthreads=THREADS).real


def by_numpy(w, n, count):
    """The sum, one wave at a time over the whole grid."""
    x = 2 * np.pi * np.arange(n) * LENGTH / n
    z = np.zeros((n, n))
    for j in range(count):
        z -= w["amplitude_m"][j] * np.cos(w["fx_per_m"][j] * x + (w["fy_per_m"][j] * x + 2 * np.pi * w["phase_turns"][j])[:, None])
    return z


def times(calls, repeats, limit, step):
    """Best time of each call [s], calls in turn, and every step-th height of each in both directions."""
    best, some = dict.fromkeys(calls, np.inf), {}
    start = clock()
    for done in range(repeats):
        for name, call in calls.items():
            t = clock()
            z = call()
            best[name] = min(best[name], clock() - t)
            some[name] = z[::step, ::step].copy()
        if done > 0 and clock() - start > limit:
            break
    return best, some


def compare(n, ridges, count, tolerance, numpy_too, limit):
    """One cell of the chart."""
    s = spectrum(n, ridges, count)
    w = surface.waves(**s)
    lists = [w[k] for k in ("fx_per_m", "fy_per_m", "amplitude_m", "phase_turns")]
    h = LENGTH / n
    options = dict(shape=n, spacing=h, tolerance=tolerance, **s)
    chosen = surface.choose(**options)
    calls = {
        "generate": lambda: surface.generate(**options),
        "sum_waves": lambda: surface.sum_waves(*lists, n, h, tolerance=tolerance),
        "finufft": lambda: by_finufft(w, n, tolerance, complex),
    }
    if tolerance >= 1e-5:
        calls["finufft_single"] = lambda: by_finufft(w, n, tolerance, np.complex64)
    step = n // 128
    best, some = times(calls, 15 if n <= 1024 else 4096 // n, limit, step)
    exact = surface.generate(128, h * step, **s, method="direct")
    size = exact.std()
    errors = {name: float(np.sqrt(np.mean((z + (0 if name == "generate" else w["offset_m"]) - exact) ** 2)) / size)
              for name, z in some.items()}
    if numpy_too:
        count = chosen.waves if (n, chosen.waves) == (1024, 160) else min(chosen.waves, 4)
        t = clock()
        by_numpy(w, n, count)
        best["numpy"] = (clock() - t) * chosen.waves / count
    return {"n": n, "waves": chosen.waves, "tolerance": tolerance, "method": chosen.method, "time_s": best, "error": errors}


def evaluators(n, ridges, count, tolerances, limit):
    """Error against time of each evaluator and of FINUFFT."""
    s = spectrum(n, ridges, count)
    w = surface.waves(**s)
    h, step = LENGTH / n, n // 128
    exact = surface.generate(128, h * step, **s, method="direct")
    rows = []
    for tolerance in tolerances:
        options = dict(shape=n, spacing=h, tolerance=tolerance, **s)
        calls = {"nufft": lambda o=options: surface.generate(**o, method="nufft"),
                 "finufft": lambda t=tolerance: by_finufft(w, n, t, complex) + w["offset_m"]}
        if tolerance == tolerances[-1]:
            calls["product"] = lambda o=options: surface.generate(**o, method="product")
        best, some = times(calls, 10, limit, step)
        for name, z in some.items():
            error = float(np.sqrt(np.mean((z - exact) ** 2)) / exact.std())
            rows.append({"n": n, "waves": len(w["fx_per_m"]), "method": name, "tolerance": tolerance, "time_s": best[name],
                         "error": error})
    return rows


def draw(result, path):
    """Work and precision at one size; ratio to the best peer over the chart."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    marks = {"nufft": ("C0", "o"), "finufft": ("C3", "s"), "product": ("C2", "*")}
    for waves, line in zip(sorted({r["waves"] for r in result["work_precision"]}), ("-", "--")):
        for method, (colour, mark) in marks.items():
            rows = [r for r in result["work_precision"] if r["waves"] == waves and r["method"] == method]
            left.loglog([1e3 * r["time_s"] for r in rows], [r["error"] for r in rows], line, color=colour, marker=mark,
                        markersize=13 if mark == "*" else 6, label=f"{method}, J = {waves}")
    left.set(xlabel="time / ms", ylabel="rms error / rms height", title="1024 x 1024 heights")
    left.grid(alpha=0.3)
    left.legend(fontsize=9)
    for tolerance, line in ((1e-12, "-"), (1e-6, "--"), (1e-3, ":")):
        for k, n in enumerate(sorted({r["n"] for r in result["cells"]})):
            rows = [r for r in result["cells"] if r["n"] == n and r["tolerance"] == tolerance]
            right.loglog([r["waves"] for r in rows], [r["ratio"] for r in rows], line, color=f"C{k}", marker=".",
                         label=f"{n} x {n}" if tolerance == 1e-12 else None)
    right.axhline(1, color="k", linewidth=1)
    right.set(xlabel="waves J", ylabel="time hdengine / best peer",
              title="same waves; tolerance 1e-12 (—), 1e-6 (- -), 1e-3 (···)")
    right.grid(alpha=0.3)
    right.legend(fontsize=9)
    figure.savefig(path, dpi=110)


def measure(sizes, limit):
    """All cells of the chart with THREADS threads, and with one thread the work-precision rows."""
    cells = []
    for tolerance in (1e-12, 1e-6, 1e-3):
        for n in sizes:
            for ridges, count in WAVES if THREADS == 1 and n < 4096 else WAVES[1::2]:
                cell = compare(n, ridges, count, tolerance, THREADS == 1 and tolerance == 1e-12, limit)
                t = cell["time_s"]
                peer = min(v for k, v in t.items() if k in ("finufft", "finufft_single", "numpy"))
                cell["ratio"] = t["sum_waves"] / peer
                cell["ratio_generate"] = t["generate"] / peer
                cells.append(cell)
                print(f"{THREADS} {tolerance:7.0e} {n:5d} {cell['waves']:6d} {cell['method']:8s}",
                      {k: f"{1e3 * v:.2f}" for k, v in t.items()},
                      f"ratio {cell['ratio']:.2f} generate {cell['ratio_generate']:.2f}",
                      {k: f"{v:.0e}" for k, v in cell["error"].items()}, flush=True)
    rows = []
    for ridges, count in ((10, 16), (400, 16)) if THREADS == 1 else ():
        rows += evaluators(1024, ridges, count, [1e-3, 1e-6, 1e-9, 1e-12], limit)
    return {"cells": cells, "work_precision": rows}


def tables(result):
    """Ratios to the best peer as they stand in docs/evidence/generator.md."""
    for key in ("cells", "cells_two_threads"):
        waves = sorted({r["waves"] for r in result[key]})
        print(f"\n{key}\n| tolerance | points | " + " | ".join(f"J = {j}" for j in waves) + " |")
        print("|---" * (len(waves) + 2) + "|")
        for tolerance, n in sorted({(r["tolerance"], r["n"]) for r in result[key]}):
            found = {r["waves"]: r for r in result[key] if (r["tolerance"], r["n"]) == (tolerance, n)}
            print(f"| {tolerance:g} | {n}² | " + " | ".join(
                f"{found[j]['ratio']:.2f} ({found[j]['ratio_generate']:.2f})" if j in found else "-" for j in waves) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[256, 512, 1024, 2048, 4096])
    parser.add_argument("--limit", type=float, default=0.7, help="seconds spent repeating one cell")
    parser.add_argument("--output", default=ROOT / "bench/results/surface_generator.json")
    parser.add_argument("--figure", default=ROOT / "docs/figures/surface_generator.png")
    a = parser.parse_args()
    if THREADS:
        Path(a.output).write_text(json.dumps(measure(a.sizes, a.limit)))
        return
    parts, start = [], time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        for threads in (1, 2):
            words = ["--sizes", *map(str, a.sizes), "--limit", str(a.limit), "--output", f"{folder}/part.json"]
            subprocess.run([sys.executable, __file__, *words], env=dict(os.environ, HD_THREADS=str(threads)), check=True)
            parts.append(json.loads(Path(folder, "part.json").read_text()))
    result = {"hdengine": hdengine.__version__, "finufft": finufft.__version__, "numpy": np.__version__,
              "python": platform.python_version(), "seconds": round(time.perf_counter() - start), "cells": parts[0]["cells"],
              "cells_two_threads": parts[1]["cells"], "work_precision": parts[0]["work_precision"]}
    Path(a.output).write_text(json.dumps(result, indent=1) + "\n")
    draw(result, a.figure)
    tables(result)


if __name__ == "__main__":
    main()
