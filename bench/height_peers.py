#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Heights of a list of waves: hdengine beside the fastest use of FINUFFT and of BLAS, at equal reached error.

Needs the Python package finufft. Every method gets the same list of waves. The peers:

- FINUFFT, its plan kept between calls, in double and in single precision, both upsampling factors, whole rows or two neighbouring
  real heights packed into one complex number (half the outputs, twice the waves);
- a matrix product of cosines and sines by numpy and its BLAS, in double and in single precision.

A method takes part with its cheapest setting whose root mean square error over 64 x 64 points, one in each part of the map, lies
below the tolerance. The error is relative to the root mean square of the waves; the truth has its phases in extended precision.

Calls take turns. With one thread the processor time of the thread counts, so that a shared machine does not decide; with two it is
the wall clock. Peers that took more than 1.5 times the best at first are not repeated. All fill arrays that are kept, but
`generate`, which makes the waves and new memory too. The ratio is that of the least times of `sum_waves` and of the best peer, with
heights of the peer's kind: what else runs on the machine only adds to a time.

Records by `--output`: height_peers, height_peers_large (4096 points a side), height_peers_threads (`--threads 2`) and height_peers_avx2: by a
build with CFLAGS=-DHD_WIDEST=32, which leaves out registers of 64 bytes, and OPENBLAS_CORETYPE=Haswell. FINUFFT stays as its wheel is.
Usage: bench/height_peers.py [--sizes N ...] [--waves J ...] [--tolerances T ...] [--limit 0.7] [--threads 1] [--output NAME]
`--more` adds to the cells of a record; `--tables` writes the tables and the figure alone.
"""
import argparse
import os
import sys
import time

if __name__ == "__main__":
    THREADS = int(sys.argv[sys.argv.index("--threads") + 1]) if "--threads" in sys.argv else 1
    for key in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[key] = str(THREADS)
else:
    THREADS = 1

import numpy as np

from common import RESULTS, new_axes, put, read_record, save_figure, styled, table, write_record
from hdengine import surface

clock = time.thread_time if THREADS == 1 else time.perf_counter
LENGTH = 0.5e-3
WAVES = {16: (4, 4), 160: (10, 16), 1600: (100, 16), 20000: (1000, 20)}  # ridges, n_max + 1
SAMPLE = 64


def spectrum(n, count):
    """Eq. 1 from the side of the map to two spacings."""
    ridges, on_each = WAVES[count]
    return dict(fractal_dimension=2.5304, roughness=2.4248e-7, gamma=(n / 2) ** (1 / (on_each - 0.5)), length=LENGTH,
                shortest_wavelength=2 * LENGTH / n, ridges=ridges, seed=1)


def exact(w, n, at):
    """Heights at the rows and columns `at`, without the constant: phases in extended precision."""
    x = at * (np.longdouble(LENGTH / n))
    turns = [f.astype(np.longdouble)[:, None] * x for f in (w["fx_per_m"], w["fy_per_m"])]
    ux, uy = ((t - np.rint(t)).astype(float) for t in turns)
    z = np.zeros((len(at), len(at)))
    for j, a in enumerate(w["amplitude_m"]):
        z -= a * np.cos(2 * np.pi * (ux[j] + (uy[j] + w["phase_turns"][j])[:, None]))
    return z


class Finufft:
    """One way to use FINUFFT; its plan is made once."""

    def __init__(self, w, n, kind, factor, packed, tolerance):
        import finufft
        self.w, self.n, self.packed = w, n, packed
        self.kind, self.real = (np.complex128, np.float64) if kind == "double" else (np.complex64, np.float32)
        shape = (n, n // 2) if packed else (n, n)
        self.plan = finufft.Plan(1, shape, eps=tolerance, isign=1, dtype=self.kind, upsampfac=factor, nthreads=THREADS)
        self.out = np.empty(shape, self.kind)

    def __call__(self):
        w, n, h = self.w, self.n, LENGTH / self.n
        fx, fy = h * w["fx_per_m"], h * w["fy_per_m"]
        z = np.exp(2j * np.pi * (w["phase_turns"] + (n // 2) * (fx + fy)))
        if not self.packed:  # the middle of FINUFFT's grid is point n // 2
            c = -w["amplitude_m"] * z
        else:  # a wave and its conjugate; the neighbour in x is the imaginary part
            z *= -0.5 * w["amplitude_m"]
            turn = np.exp(2j * np.pi * fx)
            c = np.concatenate([(1 + 1j * turn) * z, (1 + 1j * turn.conj()) * z.conj()])
            fx, fy = 2 * np.concatenate([fx, -fx]), np.concatenate([fy, -fy])
        self.plan.setpts((2 * np.pi * fy).astype(self.real), (2 * np.pi * fx).astype(self.real))
        self.plan.execute(c.astype(self.kind), out=self.out)
        return self.out.view(self.real) if self.packed else self.out.real


class Product:
    """A matrix product of cosines and sines."""

    def __init__(self, w, n, kind):
        self.w, self.kind = w, np.float64 if kind == "double" else np.float32
        self.steps = np.arange(n) * (LENGTH / n)
        self.out = np.empty((n, n), self.kind)

    def __call__(self):
        w = self.w
        tx, ty = np.outer(w["fx_per_m"], self.steps), np.outer(self.steps, w["fy_per_m"]) + w["phase_turns"]
        ax, ay = ((2 * np.pi * (t - np.rint(t))).astype(self.kind) for t in (tx, ty))
        a = w["amplitude_m"].astype(self.kind)
        return np.matmul(np.hstack([-a * np.cos(ay), a * np.sin(ay)]), np.vstack([np.cos(ax), np.sin(ax)]), out=self.out)


def candidates(w, n, tolerance):
    """The peers by name: callables of falling cheapness, of which the first that keeps the tolerance counts."""
    eps = [tolerance * f for f in (4, 2, 1, 0.5, 0.25, 0.1, 0.03)]
    found = {}
    for kind in ("double", "single") if tolerance >= 1e-6 else ("double",):
        for factor in (2.0, 1.25):
            for packed in (False, True):
                found[f"finufft {kind} {factor:g}" + (" packed" if packed else "")] = [
                    lambda k=kind, f=factor, p=packed, e=e: Finufft(w, n, k, f, p, e)
                    for e in eps if e >= (1e-15 if kind == "double" else 1e-7)]
        if 4.0 * n * n * len(w["fx_per_m"]) < 3e11:
            found[f"product {kind}"] = [lambda k=kind: Product(w, n, k)]
    return found


def fitting(makers, error, tolerance):
    """The first of the callables that keeps the tolerance, and its error."""
    for make in makers:
        try:
            call = make()
            reached = error(call())
        except RuntimeError:  # FINUFFT refuses the factor at this tolerance
            continue
        if reached <= tolerance:
            return call, reached
    return None, None


def timed(calls, limit):
    """Least time of each call [s], calls in turn; those far behind the best leave early. A short call is one of several in a row: what
    the others left in the cache is not its fault. With two threads single calls count, and many: few find both cores free."""
    spent, often = {name: [] for name in calls}, dict.fromkeys(calls, 1)
    start, alone = clock(), THREADS == 1
    for turn in range(25 if alone else 2000):
        for name in list(calls):
            t = clock()
            for _ in range(often[name]):
                calls[name]()
            spent[name].append((clock() - t) / often[name])
        if turn == (0 if alone else 10):
            often = {name: 1 + int(2e-3 / v[0]) if alone else 1 for name, v in spent.items()}
            best = min(min(v) for name, v in spent.items() if not name.startswith("hdengine"))
            calls = {name: c for name, c in calls.items() if name.startswith("hdengine") or min(spent[name]) <= (1.5 if alone else 2) * best}
        if turn >= 2 and clock() - start > limit:
            break
    return {name: float(np.min(v)) for name, v in spent.items()}


def compare(n, count, tolerance, limit):
    """One cell: times and errors of all, and the ratio to the best peer."""
    s = spectrum(n, count)
    w = surface.waves(**s)
    lists = [w[k] for k in ("fx_per_m", "fy_per_m", "amplitude_m", "phase_turns")]
    h = LENGTH / n
    at = ((np.arange(SAMPLE) + np.random.default_rng(1).random(SAMPLE)) * (n / SAMPLE)).astype(int)
    truth, scale = exact(w, n, at), np.sqrt(np.sum(w["amplitude_m"] ** 2) / 2)

    def error(z):
        return float(np.sqrt(np.mean((z[np.ix_(at, at)] - truth) ** 2)) / scale)

    options = dict(shape=n, spacing=h, tolerance=tolerance, **s)
    double, single = np.empty((n, n)), np.empty((n, n), np.float32)
    calls = {
        "hdengine": lambda: surface.sum_waves(*lists, n, h, tolerance=tolerance, out=double),
        "hdengine float32": lambda: surface.sum_waves(*lists, n, h, tolerance=tolerance, out=single),
        "hdengine generate": lambda: surface.generate(**options),
        "hdengine generate float32": lambda: surface.generate(**options, dtype=np.float32),
    }
    errors = {name: error(call() - (w["offset_m"] if "generate" in name else 0)) for name, call in calls.items()}
    for name, makers in candidates(w, n, tolerance).items():
        call, reached = fitting(makers, error, tolerance)
        if call is not None:
            calls[name], errors[name] = call, reached
    times = timed(calls, limit)
    peer = min((name for name in times if not name.startswith("hdengine")), key=times.get)
    cell = {"n": n, "waves": count, "tolerance": tolerance, "method": surface.choose(**options).method, "peer": peer,
            "ratio": times["hdengine float32" if "single" in peer else "hdengine"] / times[peer], "time_s": times, "error": errors}
    return cell | {"ratio of " + name: times[name] / times[peer] for name in times if name.startswith("hdengine")}


@styled
def draw(cells):
    """Our time over the best peer's against the number of waves, one chart for each tolerance."""
    tolerances = sorted({c["tolerance"] for c in cells}, reverse=True)
    figure, axes = new_axes(1, len(tolerances), figsize=(12, 3.6), sharey=True)
    for axis, tolerance in zip(axes, tolerances):
        for n in sorted({c["n"] for c in cells}):
            rows = [c for c in cells if (c["n"], c["tolerance"]) == (n, tolerance)]
            axis.loglog([c["waves"] for c in rows], [c["ratio"] for c in rows], "o-", label=f"{n} x {n} points")
        axis.axhline(1, color="k", linewidth=1)
        axis.set(title=f"tolerance {tolerance:g}", xlabel="waves J")
    axes[0].set(ylabel="time of hdengine / best peer", yticks=[0.2, 0.5, 1], yticklabels=["0.2", "0.5", "1"], ylim=(0.1, 1.5))
    axes[0].tick_params(axis="y", which="minor", labelleft=False)
    axes[0].legend(fontsize=8)
    save_figure(figure, "surface_generator")


RECORDS = {"height_peers": "generator", "height_peers_large": "generator_more", "height_peers_threads": "generator_more", "height_peers_avx2": "generator_more"}


def page(name, cells):
    """A table of a page of docs/evidence."""
    waves = sorted({c["waves"] for c in cells})
    found = {(c["tolerance"], c["n"], c["waves"]): f"{c['ratio']:.2f}" for c in cells}
    rows = [(f"{t:g}", f"{n}²", *(found.get((t, n, j), "-") for j in waves)) for t, n in sorted({k[:2] for k in found})]
    put(name, table(["tolerance", "points", *(f"J = {j}" for j in waves)], rows), page=f"evidence/{RECORDS[name]}")


def tables():
    """All tables and the figure."""
    for name in RECORDS:
        page(name, read_record(name)["cells"])
    draw(read_record("height_peers")["cells"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[256, 512, 1024, 2048])
    parser.add_argument("--waves", type=int, nargs="+", default=list(WAVES))
    parser.add_argument("--tolerances", type=float, nargs="+", default=[1e-3, 1e-6, 1e-9, 1e-12])
    parser.add_argument("--limit", type=float, default=0.7, help="seconds spent repeating one cell")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--output", default="height_peers", help="name of the record")
    parser.add_argument("--more", action="store_true")
    parser.add_argument("--tables", action="store_true")
    a = parser.parse_args()
    if a.tables:
        return tables()
    import finufft
    cells = read_record(a.output)["cells"] if a.more and (RESULTS / f"{a.output}.json").exists() else []
    cells = [c for c in cells if not (c["n"] in a.sizes and c["waves"] in a.waves and c["tolerance"] in a.tolerances)]
    for n in a.sizes:
        for count in a.waves:
            for tolerance in a.tolerances:
                cells.append(cell := compare(n, count, tolerance, a.limit))
                ours = " ".join(f"{v:5.2f}" for k, v in cell.items() if k.startswith("ratio of"))
                print(f"{n:5d} {count:6d} {tolerance:7.0e} {cell['method']:8s} {cell['ratio']:5.2f} ({ours}) {cell['peer']:28s} "
                      f"{1e6 * cell['time_s'][cell['peer']]:9.0f} us, errors {cell['error']['hdengine']:.1e} "
                      f"{cell['error'][cell['peer']]:.1e}", flush=True)
                write_record(a.output, {"cells": cells}, seed=1, peers=(finufft,), threads=a.threads)
    return None


if __name__ == "__main__":
    main()
