#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint by theory beside boundary elements (tamaas): what its two constants were set on, and how it does on other surfaces.

train   periodic maps of random phases, Hurst 0.1 to 0.9, roll-off at 1/32 to 1/2 of the map: k_N by boundary elements, then a and e of
        W(A) = A (a A^e + (1 - a) A^2) by least squares of ln k_N, every decade of contact with equal weight; then the rms error over true
        contact times independent waves, `choice.SCATTER`; --refit keeps boundary elements on file
judge   ten generated surfaces that set nothing (D 2.1 to 2.9, with and without roll-off, other cut-offs and seeds) and measured ones
Writes bench/results/joint_law_training.json, joint_law.json and docs/figures/joint_law.png.
bound   the bound of the pressure: tamaas' solver beside this package's
Usage: bench/joint_law.py judge [--surfaces FOLDER] | train [--refit] | bound
"""
import argparse
import itertools
import json
import math
import time
from pathlib import Path

import numpy as np

from common import new_axes, provenance, read_record, styled, write_record
from hdengine.elastic import moduli, stiffness_from_spectrum
from hdengine.prediction.half_space import HalfSpace, corrected_area, mirrored, tamaas
from hdengine.prediction.spectrum import Spectrum, level, of_map

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "bench/results"
E_STAR, RATIO = moduli(209e9, 0.295, 219e9, 0.30)
MEASURED = {"al3d-1.al3d": None, "nanovea_test2.txt": ("mm", "um"), "sflz_test_1.opd": None}
CONTACT = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)


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


def compare(z, spacing, spectrum, tangential=False):
    """Both at each contact: pressure, k_N by theory and by boundary elements, contact, processor time, ratio k_T/k_N."""
    p = pressures(spectrum.slope_rms)
    start = time.process_time()
    k, _ = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, p, E_STAR)
    theory_s, space, rows = time.process_time() - start, HalfSpace(z, spacing, E_STAR, RATIO), []
    for i, x in enumerate(p):
        start = time.process_time()
        touching = space.press(x) > 0
        k_n = space.normal_stiffness(touching)
        row = {"pressure_pa": x, "k_n_theory": k[i], "k_n_boundary_elements": k_n, "contact": corrected_area(touching),
               "seconds": time.process_time() - start, "theory_seconds": theory_s / len(p)}
        if tangential:
            row["k_t_over_k_n"] = space.tangential_stiffness(touching) / k_n
        rows.append({name: float(f"{v:.5g}") for name, v in row.items()})
    return rows


def judge(folder):
    """Ten generated surfaces, two seeds each, and the measured ones."""
    found = []
    for d in (2.1, 2.3, 2.5, 2.7, 2.9):
        for name, roll_off in (("roll-off", 256 / 6), ("no roll-off", 256)):
            for seed in (901, 902):
                z = 1e-7 * rough(256, 3 - d, roll_off, 6, seed)
                found.append({"surface": f"D {d}, {name}", "seed": seed, "facts": of_map(z, (1e-6, 1e-6))[1], "rows": compare(z, (1e-6, 1e-6), scaled(lattice(z)), seed == 901)})
                print(found[-1]["surface"], [round(r["k_n_theory"] / r["k_n_boundary_elements"], 2) for r in found[-1]["rows"]], flush=True)
    for name, unit in MEASURED.items() if folder else ():
        from hdengine.surfaces import specimen

        s = specimen.read(Path(folder) / name, unit)
        z = level(s.heights)[0][:256, :256]
        spectrum, facts = of_map(z, s.spacing)
        found.append({"surface": f"{name} (measured)", "facts": facts, "rows": compare(mirrored(z), s.spacing, spectrum)})
        print(name, [round(r["k_n_theory"] / r["k_n_boundary_elements"], 2) for r in found[-1]["rows"]], facts, flush=True)
    if not folder:
        found += [row for row in read_record("joint_law")["surfaces"] if "(measured)" in row["surface"]]
    write_record("joint_law", {"e_star_pa": E_STAR, "k_t_over_k_n": RATIO, "surfaces": found}, seed=901, peers=(tamaas(),))
    draw(found)


def bound():
    """Where the bound of the pressure is not reached, tamaas' KatoSaturated beside its elastic solver and this package's bounded one."""
    import tamaas as tm

    z, p = rough(128, 0.8, 32, 8, 3).copy(), 0.02
    rows = []
    for name, limit in (("PolonskyKeerRey", None), ("KatoSaturated", 10.0), ("KatoSaturated", 0.2), ("HalfSpace", 10.0), ("HalfSpace", 0.2)):
        start = time.perf_counter()
        if name == "HalfSpace":
            traction = HalfSpace(z, (1.0, 1.0), 1.0, RATIO, limit).press(p)
        else:
            model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [128.0, 128.0], [128, 128])
            model.E, model.nu = 1.0, 0.0
            solver = tm.PolonskyKeerRey(model, z, 1e-6) if limit is None else tm.KatoSaturated(model, z, 1e-6, limit)
            solver.solve(p)
            traction = np.array(model.traction)
        rows.append({"solver": name, "bound_over_e_star": limit, "largest_pressure_over_e_star": float(f"{traction.max():.4g}"),
                     "contact": float(f"{(traction > 0).mean():.4g}"), "seconds": float(f"{time.perf_counter() - start:.3g}")})
        print(rows[-1], flush=True)
    write_record("joint_bound", rows, seed=3, peers=(tm,))


def scaled(s):
    """A spectrum in points as one in metres (spacing 1 um)."""
    return Spectrum(s.q * 1e6, s.height_variance, s.modes)


@styled
def draw(found):
    """Error of the theory over true contact; time of both."""
    figure, (left, right) = new_axes(1, 2, figsize=(13, 5.5))
    for s in found:
        measured, flat = "measured" in s["surface"], "no roll-off" not in s["surface"]
        style = ("C2", "s") if measured else ("C0", "o") if flat else ("C1", "^")
        area = [100 * r["contact"] for r in s["rows"]]
        left.plot(area, [100 * (r["k_n_theory"] / r["k_n_boundary_elements"] - 1) for r in s["rows"]], style[1], color=style[0],
                  label="measured maps" if measured else "generated, roll-off" if flat else "generated, no roll-off")
        right.plot(area, [r["seconds"] for r in s["rows"]], style[1], color=style[0])
        right.plot(area, [r["theory_seconds"] for r in s["rows"]], "k.")
    handles = dict(zip(*reversed(left.get_legend_handles_labels())))
    left.legend(handles.values(), handles.keys())
    left.axhspan(-10, 10, color="k", alpha=0.08, lw=0)
    left.set(xscale="log", xlabel="true contact / % of the area", ylabel="k_N by theory against boundary elements / %", ylim=(-70, 160))
    right.set(xscale="log", yscale="log", xlabel="true contact / % of the area", ylabel="processor time per pressure / s",
              title="boundary elements 256² (coloured), theory (black)")
    figure.savefig(ROOT / "docs/figures/joint_law.png")


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


def train(refit):
    """Boundary elements on the training maps, unless they are on file, the constants, and the error of the engine's law."""
    if refit:
        found = json.loads((RESULTS / "joint_law_training.json").read_text())
        rows, origin = found["rows"], found.get("solved", found["provenance"])
    else:
        rows, origin = solved(), provenance(peers=(tamaas(),))
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
    write_record("joint_law_training", {"fitted_a_e": [round(c, 4) for c in fitted], "used_a_e": [0.40, 0.12], "errors_of_used": table,
                                      "solved": origin, "rows": rows},
                 seed=sorted({r["seed"] for r in rows}), peers=(tamaas(),), arguments="train --refit" if refit else "train")
    print(fitted, *table, sep="\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("train", "judge", "bound"))
    parser.add_argument("--refit", action="store_true", help="keep the boundary elements on file")
    parser.add_argument("--surfaces", help="folder with the measured maps; without it their rows stay as they are on file")
    args = parser.parse_args()
    if args.what == "train":
        train(args.refit)
    elif args.what == "bound":
        bound()
    else:
        judge(args.surfaces)


if __name__ == "__main__":
    main()
