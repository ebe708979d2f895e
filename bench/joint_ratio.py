#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Why k_T/k_N rises with the contact: the ratio of one band-limited map on three grids, and for three of Poisson's ratios on one.

Writes bench/results/joint_ratio.json and the table of docs/evidence/joint_shear.md. Usage: bench/joint_ratio.py [--redraw]
"""
import sys

import numpy as np
from joint_law import E_STAR, pressures, rough

from common import put, read_record, table, write_record
from hdengine.prediction.half_space import HalfSpace, corrected_area, tamaas


def finer(z, times):
    """The same band-limited map on a finer grid, by its Fourier modes."""
    n, m = len(z), len(z) * times
    modes = np.fft.fftshift(np.fft.fft2(z))
    wide = np.zeros((m, m), complex)
    edge = (m - n) // 2
    wide[edge:edge + n, edge:edge + n] = modes
    return np.fft.ifft2(np.fft.ifftshift(wide)).real * times**2


def grid_rows():
    """k_T/k_N over its limit 4 G*/E* for spots far apart."""
    base, rows = rough(128, 0.5, 128 / 4, 8, 31), []
    for times, nu in ((1, 0.3), (2, 0.3), (4, 0.3), (2, 0.0), (2, 0.15), (2, 0.45)):
        z, ratio = finer(base, times), (2 - 2 * nu) / (2 - nu)
        space = HalfSpace(z, (1.0 / times, 1.0 / times), 1.0, ratio)
        for p in pressures(1.0, (0.01, 0.07, 0.26)) / E_STAR:
            touching = space.press(p) > 0
            k_n, both = space.normal_stiffness(touching), []
            for turned in (touching, touching.T):   # the stiffness along both axes
                both.append(space.tangential_stiffness(turned) / k_n)
            rows.append({"points": 128 * times, "poisson": nu, "contact": round(corrected_area(touching), 4), "limit": round(ratio, 5),
                         "over_limit": round(float(np.mean(both)) / ratio, 5), "along_each_axis": [round(b / ratio, 5) for b in both]})
            print(rows[-1], flush=True)
    return rows


def page(found):
    """Table of the page."""
    cases = sorted({(r["points"], r["poisson"]) for r in found}, key=lambda c: (c[1], c[0]))
    put("joint-ratio", table(("points a side", "ν", "(ν/(2 - ν))²", "k_T/k_N over κ at 1.6 % of contact", "10 %", "33 %"), [
        (n, nu, f"{(nu / (2 - nu))**2:.3f}", *(f"{r['over_limit']:.4f}" for r in found if (r["points"], r["poisson"]) == (n, nu)))
        for n, nu in cases]), "evidence/joint_shear")


def main():
    """Command line; --redraw makes the table from the record."""
    if sys.argv[1:] != ["--redraw"]:
        write_record("joint_ratio", grid_rows(), seed=31, peers=(tamaas(),))
    page(read_record("joint_ratio"))


if __name__ == "__main__":
    main()
