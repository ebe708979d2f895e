#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Why the theory of k_N misses boundary elements without a roll-off, and why k_T/k_N rises with the contact.

seeds  eight maps of each surface of `joint_law.py judge` without roll-off, none of its seeds: the mean tells a bias, the scatter that of single maps;
       and D 2.1 with the roll-off moved from the map's length to a quarter of it
ratio  k_T/k_N of one band-limited map on three grids and with a residual a thousandth as large, and for three of Poisson's ratios on one
Writes bench/results/joint_causes.json and the ratio's table of docs/evidence/joint_shear.md; joint_choice.py draws other seeds of more surfaces.
Usage: bench/joint_causes.py [seeds] [ratio] [pages]
"""
import sys

import numpy as np
from joint_law import E_STAR, compare, lattice, pressures, rough, scaled

from common import RESULTS, put, read_record, table, write_record
from hdengine.prediction import half_space
from hdengine.prediction.half_space import HalfSpace, corrected_area, tamaas

SEEDS = range(1001, 1009)


def ratios(d, roll_off, seed):
    """k_N by theory over k_N by boundary elements at each pressure, and the true contact."""
    z = 1e-7 * rough(256, 3 - d, roll_off, 6, seed)
    rows = compare(z, (1e-6, 1e-6), scaled(lattice(z)))
    return [r["k_n_theory"] / r["k_n_boundary_elements"] for r in rows], [r["contact"] for r in rows]


def over_seeds(d, roll_off):
    """Geometric mean over the maps, its standard error, and the standard deviation of one map [of ln]."""
    found = [ratios(d, roll_off, seed) for seed in SEEDS]
    logs, contact = np.log([r for r, _ in found]), np.array([c for _, c in found]).mean(0)
    spread = logs.std(0, ddof=1)
    row = {"fractal_dimension": d, "roll_off_over_map": roll_off / 256, "contact": contact, "mean_ratio": np.exp(logs.mean(0)),
           "error_of_mean_ln": spread / np.sqrt(len(SEEDS)), "std_ln_of_one_map": spread}
    row = {k: [float(f"{x:.3g}") for x in v] if isinstance(v, np.ndarray) else v for k, v in row.items()}
    print(row, flush=True)
    return row


def finer(z, times):
    """The same band-limited map on a finer grid, by its Fourier modes."""
    n, m = len(z), len(z) * times
    modes = np.fft.fftshift(np.fft.fft2(z))
    wide = np.zeros((m, m), complex)
    edge = (m - n) // 2
    wide[edge:edge + n, edge:edge + n] = modes
    return np.fft.ifft2(np.fft.ifftshift(wide)).real * times**2


def grid_rows():
    """k_T/k_N over its limit 4 G*/E* for spots far apart, and the part of the way to that of round holes far apart, 1 - nu/2."""
    base, rows, usual = rough(128, 0.5, 128 / 4, 8, 31), [], half_space.STIFFNESS_RESIDUAL
    for times, nu, residual in ((1, 0.3, usual), (2, 0.3, usual), (4, 0.3, usual), (2, 0.3, 1e-3 * usual), (2, 0.0, usual), (2, 0.15, usual),
                                (2, 0.45, usual)):
        z, ratio = finer(base, times), (2 - 2 * nu) / (2 - nu)
        half_space.STIFFNESS_RESIDUAL = residual
        space = HalfSpace(z, (1.0 / times, 1.0 / times), 1.0, ratio)
        for p in pressures(1.0, (0.01, 0.07, 0.26, 0.75, 0.97)) / E_STAR:
            touching = space.press(p) > 0
            k_n, both = space.normal_stiffness(touching), []
            for turned in (touching, touching.T):   # the stiffness along both axes
                both.append(space.tangential_stiffness(turned) / k_n)
            rows.append({"points": 128 * times, "poisson": nu, "residual": residual, "contact": round(corrected_area(touching), 4),
                         "limit": round(ratio, 5), "limit_of_holes": round(1 - nu / 2, 5),
                         "over_limit": round(float(np.mean(both)) / ratio, 5), "along_each_axis": [round(b / ratio, 5) for b in both]})
            print(rows[-1], flush=True)
    half_space.STIFFNESS_RESIDUAL = usual
    return rows


def pages(found):
    """Table of the ratio."""
    cases = sorted({(r["poisson"], r["points"], -r["residual"]) for r in found["ratio"]})
    put("joint-ratio", table(("points a side", "residual", "ν", "1.6 %", "10 %", "33 %", "79 %", "98 %", "round holes"), [
        (n, f"{-e:.0e}", nu, *(f"{r['over_limit']:.4f}" for r in found["ratio"] if (r["poisson"], r["points"], -r["residual"]) == (nu, n, e)),
         f"{(1 - nu / 2) / ((2 - 2 * nu) / (2 - nu)):.4f}") for nu, n, e in cases]), "evidence/joint_shear")


def main():
    todo = sys.argv[1:] or ["seeds", "ratio", "pages"]
    found = read_record("joint_causes") if (RESULTS / "joint_causes.json").exists() else {}
    if "ratio" in todo:
        found["ratio"] = grid_rows()
    if "seeds" in todo:
        found["seeds"] = [over_seeds(d, 256) for d in (2.1, 2.5, 2.9)] + [over_seeds(2.1, 256 / n) for n in (2, 4)]
    if {"ratio", "seeds"} & set(todo):
        write_record("joint_causes", found, seed=[31, *SEEDS], peers=(tamaas(),))
    if "pages" in todo:
        pages(found)


if __name__ == "__main__":
    main()
