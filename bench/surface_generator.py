#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Heights of Eq. 1: hdengine beside FINUFFT and a vectorised numpy sum, error and time, in one run.

Needs the Python package finufft. The peers get the list of waves for nothing and are timed from there: FINUFFT with its phase
factors (double precision; single too from a tolerance of 1e-5 on), numpy wave by wave over the whole grid (timed on a few waves
and scaled, on all at 1024^2 and 160 waves). hdengine is timed twice: `sum_waves` on the same list, and `generate`, which makes
the waves as well. One thread each, processor time, so that a shared machine does not decide; the best of several, methods in
turn. HD_THREADS=2 takes two threads and wall clock. Errors: root mean square over 128 x 128 points spread over
the grid, edges included, relative to the heights; the reference is the direct sum.
Usage: bench/surface_generator.py [--sizes 256 512 1024 2048 4096] [--output bench/results/surface_generator.json]
"""
import os

THREADS = int(os.environ.get("HD_THREADS", "1"))
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = str(THREADS)

import argparse
import json
import platform
import re
import time
from pathlib import Path

import finufft
import numpy as np

import hdengine
from hdengine import surface

clock = time.thread_time if THREADS == 1 else time.perf_counter
ROOT = Path(__file__).resolve().parents[1]
LENGTH = 0.5e-3
WAVES = ((4, 4), (10, 16), (40, 16), (100, 16), (400, 16), (1000, 20))  # ridges, n_max + 1


def machine():
    """Name of the processor and number of cores."""
    names = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text()) or [platform.machine()]
    return f"{names[0]}, {os.cpu_count()} cores"


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


def times(calls, repeats, limit):
    """Best time of each call [s], calls in turn."""
    best = {name: np.inf for name in calls}
    start = clock()
    for done in range(repeats):
        for name, call in calls.items():
            t = clock()
            call()
            best[name] = min(best[name], clock() - t)
        if done > 0 and clock() - start > limit:
            break
    return best


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
    best = times(calls, 15 if n <= 1024 else 2, limit)
    step = n // 128
    exact = surface.generate(128, h * step, **s, method="direct")
    size = exact.std()
    errors = {name: float(np.sqrt(np.mean((call()[::step, ::step] + (0 if name == "generate" else w["offset_m"]) - exact) ** 2)) / size)
              for name, call in calls.items()}
    if numpy_too:
        some = chosen.waves if (n, chosen.waves) == (1024, 160) else min(chosen.waves, 4)
        t = clock()
        by_numpy(w, n, some)
        best["numpy"] = (clock() - t) * chosen.waves / some
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
        best = times(calls, 10, limit)
        for name, call in calls.items():
            error = float(np.sqrt(np.mean((call()[::step, ::step] - exact) ** 2)) / exact.std())
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
    right.set(xlabel="waves J", ylabel="time hdengine / best peer", title="same waves; tolerance 1e-12 (—), 1e-6 (- -), 1e-3 (···)")
    right.grid(alpha=0.3)
    right.legend(fontsize=9)
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[256, 512, 1024, 2048, 4096])
    parser.add_argument("--limit", type=float, default=1.0, help="seconds spent repeating one cell")
    parser.add_argument("--output", default=ROOT / "bench/results/surface_generator.json")
    parser.add_argument("--figure", default=ROOT / "docs/figures/surface_generator.png")
    a = parser.parse_args()
    cells = []
    for tolerance in (1e-12, 1e-6, 1e-3):
        for n in a.sizes:
            for ridges, count in WAVES if n < 4096 else WAVES[1::2]:
                cell = compare(n, ridges, count, tolerance, tolerance == 1e-12, a.limit)
                t = cell["time_s"]
                peer = min(v for k, v in t.items() if k in ("finufft", "finufft_single", "numpy"))
                cell["ratio"] = t["sum_waves"] / peer
                cell["ratio_generate"] = t["generate"] / peer
                cells.append(cell)
                print(f"{tolerance:7.0e} {n:5d} {cell['waves']:6d} {cell['method']:8s}", {k: f"{1e3 * v:.2f}" for k, v in t.items()},
                      f"ratio {cell['ratio']:.2f} generate {cell['ratio_generate']:.2f}",
                      {k: f"{v:.0e}" for k, v in cell["error"].items()}, flush=True)
    rows = []
    for ridges, count in ((10, 16), (400, 16)):
        rows += evaluators(1024, ridges, count, [1e-3, 1e-6, 1e-9, 1e-12], a.limit)
    result = {"machine": machine(), "hdengine": hdengine.__version__, "finufft": finufft.__version__, "numpy": np.__version__,
              "python": platform.python_version(), "threads": THREADS, "clock": clock.__name__, "cells": cells,
              "work_precision": rows}
    Path(a.output).write_text(json.dumps(result, indent=1) + "\n")
    draw(result, a.figure)


if __name__ == "__main__":
    main()
