#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint by theory beside boundary elements (tamaas), on periodic maps.

train   boundary elements on the training maps: a_0, a_1, e, m, n of hd_persson by least squares of ln k_N; the rms error over the waves
        that count (hd_persson_error), and the error of skewed and worn maps per ln of their crests' height (`choice.SKEWED`)
judge   36 maps that set nothing: longest over shortest wave from 2 to 200, with and without roll-off, skewness to -3; k_N, contact, gap
rule    144 maps of few long waves: where the planner takes the theory, and how far that is off; *cut* are pieces of maps four times as long
fewer   boundary elements on averaged maps, with and without the theory of the waves that averaging takes
Writes bench/results/joint_law_training.json, joint_law.json, joint_choice.json and docs/figures/joint_law.png.
Usage: bench/joint_law.py train | judge | rule | fewer | draw
"""
import itertools
import math
import sys

import numpy as np

from common import new_axes, read_record, save_figure, short, styled, write_part, write_record
from hdengine.elastic import moduli, stiffness_from_spectrum
from hdengine.prediction.choice import CLOSING, TRUST, half_width_of, scatter_of
from hdengine.prediction.half_space import HalfSpace, corrected_area, mirrored, stiffness_on_map, tamaas
from hdengine.prediction.patches import _averaged, on_fewer_points
from hdengine.prediction.spectrum import Spectrum, bands, crests, level, of_map

E_STAR, RATIO = moduli(209e9, 0.295, 219e9, 0.30)
DX = (1e-6, 1e-6)
CONTACT = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)
WHOLE = (0.002, 0.005, 0.015, 0.04, 0.1, 0.2, 0.4, 0.6, 0.8, 0.92, 0.98)   # from first touch to nearly full contact
WIDE = (0.01, 0.05, 0.3, 0.7, 0.92)                                        # of the widest maps, which take minutes
USED = (0.35, 0.15, 0.17, 3.15, 9.0)                                       # a_0, a_1, e, m, n of hd_persson
KINDS = [(d, n) for d in (2.1, 2.3, 2.5, 2.7, 2.9) for n in (1, 2, 4)] + [(d, "cut") for d in (2.1, 2.5, 2.9)]
SEEDS = range(3001, 3009)


def rough(n, hurst, roll_off, shortest, seed, longest=None):
    """Periodic map of random phases and rms slope 1, a power law between two wavelengths [points], flat above roll_off."""
    f = np.fft.fftfreq(n)
    q = np.hypot(*np.meshgrid(f, f, indexing="ij"))
    with np.errstate(divide="ignore"):
        c = np.where((q >= 0.999 / (longest or n)) & (q <= 1 / shortest), np.maximum(q, 1 / roll_off) ** (-2 - 2 * hurst), 0)
    w = np.fft.fft2(np.random.default_rng(seed).normal(size=(n, n)))
    return steepened(np.fft.ifft2(w / abs(w) * np.sqrt(c)).real)


def steepened(z):
    """A periodic map with rms slope 1."""
    f = 2 * np.pi * np.fft.fftfreq(len(z))
    return z * z.size / np.sqrt((abs(np.fft.fft2(z)) ** 2 * (f[:, None] ** 2 + f**2)).sum())


def skewed(z, skewness):
    """The map with the heights of a gamma distribution: the higher a point was, the higher it stays."""
    from scipy.stats import gamma, norm
    sign = np.sign(skewness)
    return steepened(sign * gamma.ppf(norm.cdf(sign * z / z.std()), 4 / skewness**2))


def worn(z, plateau, seed):
    """The map cut at so many rms heights, down to a plateau that is rough itself."""
    fine = rough(len(z), 0.5, 24, 8, seed, 24)
    return steepened(np.minimum(z / z.std(), plateau + 0.15 * fine / fine.std()))


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


def made(n, hurst, roll_off, shortest, seed, longest, skewness, plateau):
    """A map of its numbers."""
    z = rough(n, hurst, roll_off, shortest, seed, longest)
    return skewed(z, skewness) if skewness else worn(z, plateau, seed + 500) if plateau is not None else z


KEYS = ("n", "hurst", "roll_off", "shortest", "seed", "longest", "skewness", "plateau")
TRAINING = [
    *((128, h, 8 * w, 8, s, 8 * w, 0, None) for w in (1.5, 2, 3, 4, 6, 10) for h in (0.3, 0.8) for s in (1, 2)),
    *((128, h, r, 6, s, 128, 0, None) for h in (0.1, 0.5, 0.9) for r in (24, 48, 128) for s in (1, 2, 3)),
    *((256, h, r, 6, 21, 256, 0, None) for h in (0.2, 0.5, 0.8) for r in (64, 256)),
    *((128, h, 24, 8, s, 64, k, None) for h in (0.5, 0.9) for k in (-0.5, -1, -2, -3) for s in (11, 12)),
    *((128, 0.7, 20, 8, s, 64, k, None) for k in (-0.4, -0.8, -1.5, -2.5) for s in (910, 911)),
    *((128, 0.8, 48, 8, s, 96, 0, x) for x in (0.3, 1.0) for s in (13, 14)), *((128, 0.7, 40, 8, s, 80, 0, x) for x in (0.0, 0.6, 1.5) for s in (912, 913))]
JUDGES = {
    "narrow, 2 to 8": [(128, 0.6, 8 * w, 8, s, 8 * w, 0, None) for w in (2, 2.5, 5, 8) for s in (901, 902)],
    "roll-off, 20 to 200": [*((128, h, 25.6, 6.4, s, 128, 0, None) for h in (0.3, 0.7) for s in (903, 904)),
                            *((256, h, 42, 4, 905, 256, 0, None) for h in (0.4, 0.7)), *((512, 0.7, 64, x, 906, 512, 0, None) for x in (5.12, 2.56))],
    "no roll-off, 20 to 64": [*((128, h, 128, 6.4, s, 128, 0, None) for h in (0.3, 0.7) for s in (907, 908)),
                              *((256, h, 256, 4, 909, 256, 0, None) for h in (0.4, 0.7))],
    "skewed": [(128, 0.6, 30, 8, s, 90, k, None) for k in (-0.3, -0.7, -1.7, -2.8) for s in (920, 921)],
    "worn to a plateau": [(128, 0.6, 30, 8, s, 64, 0, x) for x in (0.2, 0.8, 1.3) for s in (922, 923)]}


def solved(numbers, shares=WHOLE):
    """Boundary elements on a map of E* 1, in points: k_N, contact and mean gap."""
    z, p = made(*numbers), pressures(1.0, shares) / E_STAR
    space, found = HalfSpace(z, (1.0, 1.0), 1.0, RATIO), []
    for x in p:
        traction = space.press(x)
        if (traction > 0).all():   # nothing gives way any more
            break
        gap = space._displacement_of(traction) - z
        found.append((space.normal_stiffness(traction > 0), corrected_area(traction > 0), gap.mean() - gap[traction > 0].mean()))
    row = {"map": dict(zip(KEYS, numbers))} | {k: short(v, 4) for k, v in zip(("p", "k", "contact", "gap"), (p[:len(found)], *np.transpose(found)))}
    print(row, flush=True)
    return row


def theory(row):
    """Of a row of `solved`: ln of k_N, contact and gap by theory over boundary elements, stated error of ln k_N, waves, contact, height of the crests."""
    z = made(**row["map"])
    s, high = lattice(z), round(crests(z), 3)
    p = np.array(row["p"])
    k, area, gap = stiffness_from_spectrum(s.q, s.height_variance, p, 1.0)
    errors = [np.log(x / np.array(row[name])) for name, x in (("k", k), ("contact", area), ("gap", gap))]
    return errors, half_width_of(area, s.waves, high), s.waves, area, high


def judge():
    """Maps that set nothing."""
    rows = []
    for kind, maps in JUDGES.items():
        for numbers in maps:
            row = solved(numbers, WIDE if numbers[0] == 512 else WHOLE)
            errors, half = theory(row)[:2]
            rows.append({"kind": kind, **row, "half_width": short(half, 3)} | {f"ln_{k}": short(e, 3) for k, e in zip(("k", "contact", "gap"), errors)})
    write_record("joint_law", {"maps": rows}, seed=901, peers=(tamaas(),))
    draw()


@styled
def draw():
    """Error of the theory over true contact; hollow where the stated error does not hold it."""
    figure, axis = new_axes(figsize=(7, 5))
    for row in read_record("joint_law")["maps"]:
        color = f"C{list(JUDGES).index(row['kind'])}"
        x, e, half = (np.array(row[k]) for k in ("contact", "ln_k", "half_width"))
        for inside in (True, False):
            use = (abs(e) <= half) == inside
            axis.plot(100 * x[use], np.exp(e[use]), "o", ms=4, color=color, mfc=color if inside else "none", label=row["kind"])
    handles = dict(zip(*reversed(axis.get_legend_handles_labels())))
    axis.legend(handles.values(), handles.keys())
    axis.axhspan(0.9, 1.1, color="k", alpha=0.08, lw=0)
    axis.set(xscale="log", yscale="log", xlabel="true contact / % of the area", ylabel="k_N by theory over boundary elements")
    save_figure(figure, "joint_law")


def surface(d, kind, seed):
    """Map that the planner sees [m], periodic map for boundary elements, spectrum of it."""
    if kind == "cut":
        z = level(1e-7 * rough(512, 3 - d, 512, 6, seed)[:128, :128])[0]
        return z, mirrored(z), of_map(z, DX)[0]
    z = 1e-7 * rough(256, 3 - d, 256 / kind, 6, seed)
    return z, z, scaled(lattice(z))


def rule_row(rows):
    """Of maps of `rule`: scatter of maps that differ in their phases alone, up to 4 % of contact; where the theory is taken, and how far it is off there."""
    off = np.concatenate([np.exp(np.array(r["ln_error"])[r["theory"]]) - 1 for r in rows])
    scatter = [np.std([r["ln_error"][i] for r in rows if (r["fractal_dimension"], r["kind"]) == alike], ddof=1)
               for alike in dict.fromkeys((r["fractal_dimension"], r["kind"]) for r in rows) for i in range(4)]
    return {**dict(zip(("least_scatter", "most_scatter"), short([min(scatter), max(scatter)], 4))), "taken": len(off), "of": sum(len(r["theory"]) for r in rows),
            **{f"within_{x}_percent": int((abs(off) < x / 100).sum()) for x in (25, 10)}, "largest_error": float(f"{abs(off).max():.4g}")}


def rule():
    """Error of the theory on every map, and whether the planner takes it there, by kind of map."""
    rows = []
    for (d, kind), seed in itertools.product(KINDS, SEEDS):
        seen, z, spectrum = surface(d, kind, seed)
        p = pressures(spectrum.slope_rms)
        k_n, contact = boundary_elements(z, p)
        by_theory, area, _ = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, p, E_STAR)
        rows.append({"fractal_dimension": d, "kind": kind, "ln_error": short(np.log(by_theory / k_n), 3),
                     "theory": (1.96 * scatter_of(area, of_map(seen, DX)[0].waves) <= TRUST).tolist()})
        print(rows[-1], flush=True)
    kinds = {str(kind): [r for r in rows if r["kind"] == kind] for kind in (1, 2, 4, "cut")} | {"all": rows}
    write_part("joint_choice", "rule", {kind: rule_row(mine) for kind, mine in kinds.items()}, seed=list(SEEDS), peers=(tamaas(),))


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


def levels(row):
    """Steps through the scales of a training map: A and dA/dP (steps, pressures), weights of dW/dA."""
    s, p = lattice(made(**row["map"])), np.array(row["p"])
    s = bands(s.q, s.height_variance, s.modes)
    full = np.concatenate([[0], np.cumsum(s.q**2 * s.height_variance / 4)])
    v, by_p, out = np.full(p.shape, 1e-300), np.zeros(p.shape), []

    def touching(v, by_p):
        y = p / np.sqrt(2 * v)
        return np.vectorize(math.erf)(y), np.exp(-(y**2)) / np.sqrt(np.pi / 2 * v) * (1 - p * by_p / (2 * v))

    for i, q in enumerate(s.q):
        edges = np.linspace(full[i] ** 0.5, full[i + 1] ** 0.5, 2 + int(20 * (1 - (full[i] / full[i + 1]) ** 0.5))) ** 2
        for low, high in itertools.pairwise(edges):
            middle, (at, by_at) = (low**0.5 + high**0.5) ** 2 / 4, (v, by_p)
            for end in (middle, high):   # midpoint rule
                a, slope = touching(at, by_at)
                at, by_at = v + (end - low) * (5 - 2 * a**2 + 6 * a**4) / 9, by_p + (end - low) * (24 * a**3 - 4 * a) / 9 * slope
            v, by_p = at, by_at
            out.append((a, slope, q * s.height_variance[i] / 4 * (high - low) / (full[i + 1] - full[i])))
    area, slope, weight = map(np.array, zip(*out))
    moments = [(s.q**k * s.height_variance).sum() for k in range(3)]
    return area, slope, weight[:, None], moments[1] ** 2 / (moments[0] * moments[2])


def counted_of(contact, waves):
    """Waves that touch, or thirds of those that are open (hd_persson_error)."""
    return waves * np.minimum(contact, (1 - contact) / 3)


def train():
    """The constants, and the errors of the engine's law, from boundary elements on the training maps."""
    from scipy.optimize import least_squares

    cases, error, counted, skew, shares = [], [], [], [], None
    for row in map(solved, TRAINING):
        errors, _, waves, area, high = theory(row)
        contact = np.array(row["contact"])
        if row["map"]["skewness"] or row["map"]["plateau"] is not None:
            worn = abs(math.log(high))
            skew.append(np.pad(abs(errors[0]) / np.where(area < CLOSING, worn, min(worn, 1)), (0, len(WHOLE) - len(area)), constant_values=np.nan))
            shares = area if len(area) == len(WHOLE) else shares
            continue
        counted.extend(counted_of(contact, waves))
        error.extend(errors[0])
        use = (contact > 0.002) & (contact < 0.985)
        wide = 2.5 if row["map"]["longest"] > 11 * row["map"]["shortest"] else 1   # the spectra of machined faces
        cases.append((*levels(row), np.array(row["p"]) / row["k"], use * wide / np.hypot(0.03, 0.3 / np.sqrt(0.5 + counted_of(contact, waves)))))

    def misfit(c):
        found = []
        for area, slope, weight, r, flexibility, certainty in cases:
            a = c[0] + c[1] * r ** c[4]
            law = (weight * (a * (1 + c[2]) * area ** c[2] + (1 - a) * (1 + c[3]) * area ** c[3]) * slope).sum(0)
            found.extend(certainty * np.log(flexibility / law))
        return np.array(found)

    fitted = least_squares(misfit, USED).x
    error, counted = np.array(error), np.log10(counted)
    part = np.minimum(np.maximum(np.floor(2 * counted), -3), 4)
    table = [{"waves": float(f"{10 ** counted[part == n].mean():.2g}"), "rms_ln_error": float(f"{np.sqrt((error[part == n] ** 2).mean()):.2g}"),
              "mean_ln_error": round(float(error[part == n].mean()), 3), "cases": int((part == n).sum())} for n in sorted(set(part))]
    write_record("joint_law_training", {
        "fitted": short(fitted, 3), "used": USED, "rms_misfit_fitted_used": short([np.std(misfit(c)) for c in (fitted, USED)], 4), "errors_of_used": table,
        "skewed": [{"contact": float(f"{a:.2g}"), "ln_error_per_ln_crests": float(f"{e:.2g}")} for a, e in zip(shares, np.nanquantile(skew, 0.95, axis=0))]},
        seed=1, peers=(tamaas(),))
    print(fitted, *table, *np.nanquantile(skew, 0.95, axis=0), sep="\n")


if __name__ == "__main__":
    parts = {"train": train, "judge": judge, "rule": rule, "fewer": fewer, "draw": draw}
    for name in sys.argv[1:] or ("judge", "rule", "fewer"):
        parts[name]()
