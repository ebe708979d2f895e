#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shear of a joint with Coulomb friction by boundary elements, beside the law that follows from k_N alone (Ciavarella 1998, Jaeger 1998).

Rough patches, four surfaces, 1 to 20 % of contact: curve and loop beside the law; k_T/k_N in both directions beside (2 - 2 nu)/(2 - nu).
Writes bench/results/joint_shear.json. Usage: bench/joint_shear.py [--quick]: the first surface, without a record
"""
import sys

import numpy as np
from joint_law import E_STAR, RATIO, lattice, pressures, rough, scaled

from common import short, write_record
from hdengine.elastic import ElasticJoint, stiffness_from_spectrum
from hdengine.prediction.half_space import HalfSpace, corrected_area, tamaas
from hdengine.prediction.shear import Slider

FRICTION = 0.15
SURFACES = ((2.2, 21, 11), (2.5, 21, 12), (2.5, 128, 13), (2.8, 21, 14))   # D, roll-off, seed
LOADING = np.array([0.1, 0.25, 0.45, 0.7, 1.0, 1.4])           # displacements over that of full slip by k_T without slip
LOOP = np.array([0.8, 0.4, 0.0, -0.4, -0.8, -1.0, -0.6, -0.2, 0.2, 0.6, 1.0])   # over the one of the reversal
TURN = 0.5                                                      # the reversal over the end of the loading


def walk(space, pressure, load, path):
    """Shear over mu P along a path of displacements [m]."""
    slider = Slider(space, pressure, FRICTION)
    return np.array([slider.move(u) / (FRICTION * load) for u in path])


def masing(curve, turn, path):
    """Shear after a reversal at `turn` down to -turn and up again, by Masing's rule on the loading curve."""
    at_turn, down, found = curve(turn), True, []
    for i, u in enumerate(path):
        down = down and (i == 0 or u < path[i - 1])
        found.append(at_turn - 2 * curve((turn - u) / 2) if down else -at_turn + 2 * curve((u + turn) / 2))
    return np.array(found)


def law_of(space, load):
    """The law from k_N by boundary elements alone."""
    p = load * np.geomspace(1e-3, 1, 25)
    k_n = np.array([space.normal_stiffness(space.press(x) > 0) for x in p])
    return ElasticJoint(p, k_n, RATIO * k_n, FRICTION, "boundary_elements")


def patches(surfaces):
    """Rough patches beside the law."""
    rows = []
    for d, roll_off, seed in surfaces:
        z = 1e-7 * rough(128, 3 - d, roll_off, 6, seed)
        spectrum = scaled(lattice(z))
        for load in pressures(spectrum.slope_rms, (0.01, 0.05, 0.2)):
            space = HalfSpace(z, (1e-6, 1e-6), E_STAR, RATIO)
            p = load * np.geomspace(1e-3, 1, 25)
            k = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, p, E_STAR)[0]
            laws = {"law": law_of(space, load), "theory": ElasticJoint(p, k, RATIO * k, FRICTION, "spectrum")}
            pressure = space.press(load)
            touching = pressure > 0
            k_n, k_t = space.normal_stiffness(touching), space.tangential_stiffness(touching)
            across = HalfSpace(z.T, (1e-6, 1e-6), E_STAR, RATIO).tangential_stiffness(touching.T)
            path = LOADING * 2.2 * FRICTION * load / k_t
            turn = TURN * path[-1]
            back = turn * LOOP
            q, loop = walk(space, pressure, load, path), walk(space, pressure, load, [turn, *back])[1:]
            row = {"surface": f"D {d}, {'roll-off' if roll_off < 128 else 'no roll-off'}", "contact": short(corrected_area(touching), 5),
                   "k_t_over_k_n": short((k_t + across) / 2 / k_n, 5)}
            for name, joint in laws.items():
                def by(u, joint=joint, load=load):
                    return joint.shear(load, u)[0] / (FRICTION * load)
                row |= {f"{name}_curve_error": short(abs(by(path) - q).max(), 5), f"{name}_loop_error": short(abs(masing(by, turn, back) - loop).max(), 5)}
            rows.append(row)
            print(row, flush=True)
    return rows


if __name__ == "__main__":
    if "--quick" in sys.argv:
        patches(SURFACES[:1])
    else:
        write_record("joint_shear", {"k_t_over_k_n": RATIO, "patches": patches(SURFACES)}, seed=11, peers=(tamaas(),))
