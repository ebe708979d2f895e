#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The normal stiffness of the joint by theory beside boundary elements (tamaas), on periodic maps of random phases.

train   63 maps, Hurst 0.1 to 0.9, roll-off at 1/32 to 1/2 of the map: a and e of W(A) = A (a A^e + (1 - a) A^2) by least squares of ln k_N,
        every decade of contact with equal weight; then the rms error over true contact times independent waves, `choice.SCATTER`
judge   ten generated surfaces that set nothing (D 2.1 to 2.9, with and without roll-off, other cut-offs and seeds)
rule    144 maps of few long waves: where the planner takes the theory, and how far that is off; *cut* are pieces of maps four times as long
fewer   boundary elements on averaged maps, with and without the theory of the waves that averaging takes
Writes bench/results/joint_law_training.json, joint_law.json, joint_choice.json and docs/figures/joint_law.png.
Usage: bench/joint_law.py train | judge | rule | fewer | draw
"""
import itertools
import math
import sys

import numpy as np

from common import new_axes, read_record, save_figure, styled, write_part, write_record
from hdengine.elastic import moduli, stiffness_from_spectrum
from hdengine.prediction.choice import TRUST, scatter_of
from hdengine.prediction.half_space import HalfSpace, corrected_area, mirrored, stiffness_on_map, tamaas
from hdengine.prediction.patches import _averaged, on_fewer_points
from hdengine.prediction.spectrum import Spectrum, level, of_map

E_STAR, RATIO = moduli(209e9, 0.295, 219e9, 0.30)
DX = (1e-6, 1e-6)
CONTACT = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)
KINDS = [(d, n) for d in (2.1, 2.3, 2.5, 2.7, 2.9) for n in (1, 2, 4)] + [(d, "cut") for d in (2.1, 2.5, 2.9)]
SEEDS = range(3001, 3009)


def rough(n, hurst, roll_off, shortest, seed):
    """Periodic map of random phases and rms slope 1, a power law between two wavelengths [points], flat above the longer one."""
    f = np.fft.fftfreq(n)
    q = np.hypot(*np.meshgrid(f, f, indexing="ij"))
    with np.errstate(divide="ignore"):
        c = np.where((q >= 0.999 / n) & (q <= 1 / shortest), np.maximum(q, 1 / roll_off) ** (-2 - 2 * hurst), 0)
    w = np.fft.fft2(np.random.default_rng(seed).normal(size=(n, n)))
    h = w / abs(w) * np.sqrt(c)
    h *= n**2 / np.sqrt((abs(h) ** 2 * (2 * np.pi * q) ** 2).sum())
    return np.fft.ifft2(h).real


def lattice(z):
    """Spectrum of a periodic map, shell by shell."""
    n = len(z)
    h = abs(np.fft.fft2(z) / n**2) ** 2
    f = np.fft.fftfreq(n)
    q = 2 * np.pi * np.hypot(*np.meshgrid(f, f, indexing="ij"))
    shell = np.rint(q * n / (2 * np.pi)).astype(int).ravel()
    variance, weighted = np.bincount(shell, h.ravel()), np.bincount(shell, (h * q).ravel())
    use = (variance > 1e-20 * variance.max()) & (np.arange(len(variance)) > 0)
    return Spectrum(weighted[use] / variance[use], variance[use], np.bincount(shell)[use])


def pressures(slope, contact=CONTACT):
    """Pressures at which the theory expects shares of contact [Pa]."""
    low, high = np.zeros(len(contact)), np.full(len(contact), 5.0)
    for _ in range(60):
        x = 0.5 * (low + high)
        above = np.array([math.erf(v) for v in x]) > contact
        low, high = np.where(above, low, x), np.where(above, x, high)
    return E_STAR * slope * x / math.sqrt(2)


def scaled(s):
    """A spectrum in points as one in metres (spacing 1 um)."""
    return Spectrum(s.q * 1e6, s.height_variance, s.modes)


def boundary_elements(z, pressure):
    """k_N [Pa/m] and true contact by boundary elements."""
    space, rows = HalfSpace(z, DX, E_STAR, RATIO), []
    for p in pressure:
        touching = space.press(p) > 0
        rows.append((space.normal_stiffness(touching), corrected_area(touching)))
    return np.array(rows).T


def short(values, digits=4):
    """Numbers of a record."""
    return [float(f"{x:.{digits}g}") for x in values]


def judge():
    """Ten generated surfaces, two seeds each."""
    found = []
    for d, (name, roll_off), seed in itertools.product((2.1, 2.3, 2.5, 2.7, 2.9), (("roll-off", 256 / 6), ("no roll-off", 256)), (901, 902)):
        z = 1e-7 * rough(256, 3 - d, roll_off, 6, seed)
        spectrum = scaled(lattice(z))
        p = pressures(spectrum.slope_rms)
        k_n, contact = boundary_elements(z, p)
        theory, _ = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, p, E_STAR)
        found.append({"surface": f"D {d}, {name}", "seed": seed, "ratio": short(theory / k_n), "contact": short(contact, 3)})
        print(found[-1], flush=True)
    write_record("joint_law", {"surfaces": found}, seed=901, peers=(tamaas(),))
    draw(found)


@styled
def draw(found):
    """Error of the theory over true contact."""
    figure, axis = new_axes(figsize=(7, 5))
    for s in found:
        flat = "no roll-off" not in s["surface"]
        axis.plot(100 * np.array(s["contact"]), 100 * (np.array(s["ratio"]) - 1), "o" if flat else "^", color="C0" if flat else "C1",
                  label="roll-off" if flat else "no roll-off")
    handles = dict(zip(*reversed(axis.get_legend_handles_labels())))
    axis.legend(handles.values(), handles.keys())
    axis.axhspan(-10, 10, color="k", alpha=0.08, lw=0)
    axis.set(xscale="log", xlabel="true contact / % of the area", ylabel="k_N by theory against boundary elements / %")
    save_figure(figure, "joint_law")


def surface(d, kind, seed):
    """Map that the planner sees [m], periodic map for boundary elements, spectrum of it."""
    if kind == "cut":
        z = level(1e-7 * rough(512, 3 - d, 512, 6, seed)[:128, :128])[0]
        return z, mirrored(z), of_map(z, DX)[0]
    z = 1e-7 * rough(256, 3 - d, 256 / kind, 6, seed)
    return z, z, scaled(lattice(z))


def rule():
    """Error of the theory on every map, and whether the planner takes it there."""
    rows = []
    for (d, kind), seed in itertools.product(KINDS, SEEDS):
        seen, z, spectrum = surface(d, kind, seed)
        p = pressures(spectrum.slope_rms)
        k_n, contact = boundary_elements(z, p)
        theory, area = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, p, E_STAR)
        rows.append({"fractal_dimension": d, "kind": kind, "seed": seed, "contact": short(contact, 3), "ln_error": short(np.log(theory / k_n), 3),
                     "theory": (1.96 * scatter_of(area, of_map(seen, DX)[0].waves) <= TRUST).tolist()})
        print(rows[-1], flush=True)
    write_part("joint_choice", "maps", rows, seed=list(SEEDS), peers=(tamaas(),))


def fewer():
    """Errors of k_N on averaged maps against all points: without and with the theory of what averaging takes."""
    errors = {}
    for (d, kind), seed in itertools.product(KINDS[:15], SEEDS):
        z, spectrum = surface(d, kind, seed)[1:]
        p = pressures(spectrum.slope_rms)
        whole, contact = boundary_elements(z, p)
        for points in (64, 128) if seed % 4 in (1, 2) else (64,):
            k_n = on_fewer_points(z, DX, points, p, E_STAR, RATIO, periodic=True, tangential=False)[0]
            bare = stiffness_on_map(*_averaged(z, DX, points), p, E_STAR, RATIO, tangential=False)[0]
            for added, k in ((False, bare), (True, k_n)):
                for label, use in (("above 1 %", contact >= 0.01), ("below 1 %", contact < 0.01)):
                    errors.setdefault((points, added, label), []).extend(np.array(k)[use] / whole[use] - 1)
    rows = [{"points": n, "with_theory": added, "contact": label, "pressures": len(e), "within_10_percent": int((np.abs(e) < 0.1).sum()),
             "rms_error": float(f"{np.sqrt(np.mean(np.square(e))):.3g}"), "largest_error": float(f"{np.abs(e).max():.3g}")}
            for (n, added, label), e in errors.items()]
    print(*rows, sep="\n")
    write_part("joint_choice", "fewer", rows, seed=list(SEEDS), peers=(tamaas(),))


def stiffness(z, p):
    """k_N by boundary elements of a map with E* = 1, in points."""
    space = HalfSpace(z, (1.0, 1.0), 1.0, RATIO)
    return [space.normal_stiffness(space.press(x) > 0) for x in p]


def solved():
    """Boundary elements on the training maps."""
    rows = []
    for n, hursts, rolls, seeds, contact in (
            (256, (0.1, 0.3, 0.5, 0.7, 0.9), (128, 64, 32), (1, 2, 3), (0.003, 0.006, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4)),
            (512, (0.2, 0.5, 0.8), (16, 32, 64), (21, 22), (3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 0.03, 0.1))):
        for hurst, roll_off, seed in itertools.product(hursts, rolls, seeds):
            p = pressures(1.0, contact) / E_STAR
            k = stiffness(rough(n, hurst, roll_off, 8, seed), p)
            rows.append({"n": n, "hurst": hurst, "roll_off": roll_off, "seed": seed, "p": [float(f"{x:.6g}") for x in p],
                         "k": [float(f"{x:.5g}") for x in k]})
            print(rows[-1], flush=True)
    return rows


def train():
    """Boundary elements on the training maps, the constants, and the error of the engine's law."""
    rows = solved()
    from scipy.optimize import least_squares

    x, w = np.polynomial.legendre.leggauss(3)
    cases, error = [], []
    for r in rows:
        s = lattice(rough(r["n"], r["hurst"], r["roll_off"], 8, r["seed"]))
        error.extend(np.log(stiffness_from_spectrum(s.q, s.height_variance, r["p"], 1.0)[0] / r["k"]))
        v = np.cumsum(s.height_variance * s.q**2 / 4)
        low, high = np.sqrt(np.concatenate([[0], v[:-1]])), np.sqrt(v)
        root = low[:, None] + (high - low)[:, None] * (x + 1) / 2
        weight = w * root / (low + high)[:, None]
        for p, k in zip(r["p"], r["k"]):
            y = p / (math.sqrt(2) * root)
            cases.append((p, k, (s.q * s.height_variance / 4)[:, None] * weight, np.vectorize(math.erf)(y),
                          2 / math.sqrt(2 * math.pi) / root * np.exp(-(y**2)), math.erf(p / math.sqrt(2 * v[-1])), s.waves))

    def misfit(c):
        return np.array([np.log(p / (m * (c[0] * (1 + c[1]) * a**c[1] + 3 * (1 - c[0]) * a**2) * by_p).sum() / k)
                         for p, k, m, a, by_p, *_ in cases])

    contact, waves = np.array([c[-2] for c in cases]), np.array([c[-1] for c in cases])
    decade = np.floor(np.log10(contact) * 2).astype(int)
    weight = 1 / np.sqrt(np.bincount(decade - decade.min())[decade - decade.min()])
    fitted = least_squares(lambda c: weight * misfit(c), [0.5, 0.1]).x
    error, touching = np.array(error), np.log10(contact * waves)
    part = np.floor(2 * touching).astype(int)
    table = [{"touching_waves": float(f"{10 ** touching[part == n].mean():.2g}"), "rms_ln_error": float(f"{np.sqrt((error[part == n] ** 2).mean()):.2g}"),
              "mean_ln_error": round(float(error[part == n].mean()), 3), "cases": int((part == n).sum())} for n in sorted(set(part))]
    write_record("joint_law_training", {"fitted_a_e": [round(c, 4) for c in fitted], "used_a_e": [0.40, 0.12], "errors_of_used": table},
                 seed=sorted({r["seed"] for r in rows}), peers=(tamaas(),))
    print(fitted, *table, sep="\n")


if __name__ == "__main__":
    parts = {"train": train, "judge": judge, "rule": rule, "fewer": fewer, "draw": lambda: draw(read_record("joint_law")["surfaces"])}
    for name in sys.argv[1:] or ("judge", "rule", "fewer"):
        parts[name]()
