#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A second opinion on boundary elements, and what the adapter costs: one rough map by ContactMechanics (PyPI) and by tamaas alone.

Writes bench/results/joint_second.json. Needs both packages: pip install tamaas ContactMechanics. Usage: bench/joint_second.py
"""
import time

import ContactMechanics
import numpy as np
from joint_law import pressures, rough
from SurfaceTopography import Topography

from common import take_turns, write_record
from hdengine.elastic import moduli
from hdengine.prediction.half_space import RESIDUAL, HalfSpace, tamaas

E_STAR, RATIO = moduli(209e9, 0.295, 219e9, 0.30)
POINTS = 128


def main():
    z, tm, rows = 1e-7 * rough(POINTS, 0.7, POINTS / 6, 6, 901), tamaas(), []
    other = ContactMechanics.Factory.make_system(substrate="periodic", young=1.0,
                                                 surface=Topography(z * 1e6, (float(POINTS),) * 2, periodic=True))   # lengths in um
    for p in pressures(0.1, (0.01, 0.03, 0.1)):
        space = HalfSpace(z, (1e-6, 1e-6), E_STAR, RATIO)

        def alone(p=p):
            model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [POINTS * 1e-6] * 2, [POINTS] * 2)
            model.E, model.nu = E_STAR, 0.0
            tm.PolonskyKeerRey(model, z, RESIDUAL).solve(p)
            return np.array(model.traction)

        timings, found = take_turns({"adapter": lambda p=p: HalfSpace(z, (1e-6, 1e-6), E_STAR, RATIO).press(p), "tamaas": alone}, turns=21, clock=time.process_time)
        answer = other.minimize_proxy(external_force=p / E_STAR * POINTS**2, pentol=1e-8)
        theirs, ours = abs(np.asarray(answer.jac)) * E_STAR, space.press(p)
        over = timings["adapter"].over(timings["tamaas"])
        rows.append({"pressure_pa": float(f"{p:.5g}"), "contact": float((ours > 0).mean()), "contact_second": float((theirs > 0).mean()),
                     "rms_difference_over_mean_pressure": float(f"{np.sqrt(((theirs - ours) ** 2).mean()) / p:.2g}"),
                     "k_n_ratio": float(space.normal_stiffness(theirs > 0) / space.normal_stiffness(ours > 0)),
                     "adapter_over_tamaas": [float(f"{x:.4g}") for x in over], "difference_from_tamaas": float(f"{abs(found['adapter'] - found['tamaas']).max() / p:.2g}")})
        print(rows[-1], flush=True)
    write_record("joint_second", rows, seed=901, peers=(tm, ContactMechanics), threads=1)


if __name__ == "__main__":
    main()
