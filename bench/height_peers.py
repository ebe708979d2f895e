#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Heights of a list of waves: hdengine beside the fastest use of FINUFFT and of BLAS, at equal reached error.

Needs the Python package finufft. Every method gets the same list of waves. The peers:

- FINUFFT, its plan kept between calls, in double and in single precision, both upsampling factors, whole rows or two neighbouring
  real heights packed into one complex number (half the outputs, twice the waves);
- a matrix product of cosines and sines by numpy and its BLAS, in double and in single precision.

A method takes part with its cheapest setting whose root mean square error over 64 x 64 points, one in each part of the map, lies
below the tolerance. The error is relative to the root mean square of the waves; the truth has its phases in extended precision.

Calls take turns, and the processor time of the one thread counts, so that a shared machine does not decide. Peers that took more than 1.5
times the best at first are not repeated. All fill arrays that are kept. The ratio is that of the least times of `sum_waves` and of the best
peer, with heights of the peer's kind: what else runs on the machine only adds to a time.

Usage: bench/height_peers.py [--quick]: 256 points a side, without a record
"""
import sys
import time

import numpy as np

from common import write_record
from hdengine import surface

LENGTH = 0.5e-3
WAVES = {16: (4, 4), 160: (10, 16), 1600: (100, 16), 20000: (1000, 20)}  # ridges, n_max + 1
SAMPLE = 64
TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-12)
LIMIT = 0.7  # seconds of repeating a cell


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
        self.plan = finufft.Plan(1, shape, eps=tolerance, isign=1, dtype=self.kind, upsampfac=factor, nthreads=1)
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


def timed(calls):
    """Least time of each call [s], calls in turn; those far behind the best leave early. A short call is one of several in a row: what
    the others left in the cache is not its fault."""
    clock = time.thread_time
    spent, often, start = {name: [] for name in calls}, dict.fromkeys(calls, 1), clock()
    for turn in range(25):
        for name in list(calls):
            t = clock()
            for _ in range(often[name]):
                calls[name]()
            spent[name].append((clock() - t) / often[name])
        if turn == 0:
            often = {name: 1 + int(2e-3 / v[0]) for name, v in spent.items()}
            best = min(min(v) for name, v in spent.items() if not name.startswith("hdengine"))
            calls = {name: c for name, c in calls.items() if name.startswith("hdengine") or min(spent[name]) <= 1.5 * best}
        if turn >= 2 and clock() - start > LIMIT:
            break
    return {name: float(np.min(v)) for name, v in spent.items()}


def compare(n, count, tolerance):
    """One cell: the ratio of our time to the best peer's."""
    s = spectrum(n, count)
    w = surface.waves(**s)
    lists = [w[k] for k in ("fx_per_m", "fy_per_m", "amplitude_m", "phase_turns")]
    h = LENGTH / n
    at = ((np.arange(SAMPLE) + np.random.default_rng(1).random(SAMPLE)) * (n / SAMPLE)).astype(int)
    truth, scale = exact(w, n, at), np.sqrt(np.sum(w["amplitude_m"] ** 2) / 2)

    def error(z):
        return float(np.sqrt(np.mean((z[np.ix_(at, at)] - truth) ** 2)) / scale)

    double, single = np.empty((n, n)), np.empty((n, n), np.float32)
    calls = {
        "hdengine": lambda: surface.sum_waves(*lists, n, h, tolerance=tolerance, out=double),
        "hdengine float32": lambda: surface.sum_waves(*lists, n, h, tolerance=tolerance, out=single),
    }
    for name, makers in candidates(w, n, tolerance).items():
        call, _ = fitting(makers, error, tolerance)
        if call is not None:
            calls[name] = call
    times = timed(calls)
    peer = min((name for name in times if not name.startswith("hdengine")), key=times.get)
    return {"n": n, "waves": count, "tolerance": tolerance, "method": surface.choose(shape=n, spacing=h, tolerance=tolerance, **s).method, "peer": peer,
            "ratio": float(f"{times['hdengine float32' if 'single' in peer else 'hdengine'] / times[peer]:.3g}"), "seconds": float(f"{times['hdengine']:.3g}")}


def main(quick):
    """All cells."""
    import finufft
    cells = []
    for n in (256,) if quick else (256, 512, 1024, 2048):
        for count in WAVES:
            for tolerance in TOLERANCES:
                cells.append(compare(n, count, tolerance))
                print(cells[-1], flush=True)
    if not quick:
        write_record("height_peers", {"cells": cells}, seed=1, peers=(finufft,), threads=1)


if __name__ == "__main__":
    main("--quick" in sys.argv)
