#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Theory beside boundary elements on maps of few long waves: how far one may trust the theory there, and whether the planner knows.

maps   eight maps each of D 2.1 to 2.9, roll-off at the map's length, a half and a quarter of it: 256 x 256 points, periodic; and
       maps of 128 x 128 points cut from such of 512 x 512 without roll-off, continued evenly: k_N and contact by boundary elements
Writes bench/results/joint_choice.json. Usage: bench/joint_choice.py [maps]
"""
import sys

from joint_law import CONTACT, E_STAR, lattice, pressures, rough, scaled

from common import write_record
from hdengine.elastic import moduli
from hdengine.prediction.half_space import HalfSpace, corrected_area, mirrored, tamaas
from hdengine.prediction.spectrum import level, of_map

RATIO = moduli(209e9, 0.295, 219e9, 0.30)[1]
DX = (1e-6, 1e-6)
KINDS = [(d, n) for d in (2.1, 2.3, 2.5, 2.7, 2.9) for n in (1, 2, 4)] + [(d, "cut") for d in (2.1, 2.5, 2.9)]
SEEDS = range(3001, 3009)


def surface(d, kind, seed):
    """Map that the planner sees [m], periodic map for boundary elements, spectrum of it."""
    if kind == "cut":
        z = level(1e-7 * rough(512, 3 - d, 512, 6, seed)[:128, :128])[0]
        return z, mirrored(z), of_map(z, DX)[0]
    z = 1e-7 * rough(256, 3 - d, 256 / kind, 6, seed)
    return z, z, scaled(lattice(z))


def solve(d, kind, seed):
    """Boundary elements at the pressures where the theory expects the shares of contact."""
    _, z, spectrum = surface(d, kind, seed)
    space, rows = HalfSpace(z, DX, E_STAR, RATIO), []
    for p in pressures(spectrum.slope_rms, CONTACT):
        touching = space.press(p) > 0
        rows.append([float(f"{x:.5g}") for x in (p, space.normal_stiffness(touching), corrected_area(touching))])
    p, k, a = zip(*rows)
    return {"fractal_dimension": d, "kind": kind, "seed": seed, "pressure_pa": p, "k_n_pa_per_m": k, "contact": a}


def maps():
    """All maps; the record is written after each surface."""
    rows = []
    for d, kind in KINDS:
        rows += [solve(d, kind, seed) for seed in SEEDS]
        write_record("joint_choice", {"maps": rows}, seed=list(SEEDS), peers=(tamaas(),))
        print(rows[-1], flush=True)


def main():
    todo = sys.argv[1:] or ["maps"]
    if "maps" in todo:
        maps()


if __name__ == "__main__":
    main()
