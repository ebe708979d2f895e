#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured stiffness of ground and lapped joints beside the law from their roughness; nothing is fitted.

The measurements are constants C and m of the joint deflection C p^m, read in Y. Ito, Modular Design for Machine Tools (McGraw-Hill, 2008):
table 6-5 (steel S45C, Ito and Tsutsumi), tables 6-2 and 6-10 (cast iron, Back et al.). A roughness is all that is known of the surfaces, so
the law takes D 2.3, waves up to 0.8 mm, and R_max over Rq of 6. Of the Brake-Reuss beam the asperities are published that were found in scans
of its faces (`BEAM`); their stiffness is Greenwood and Williamson's, under shear times Mindlin's (2 - 2 nu)/(2 - nu), as the law's.
Writes bench/results/joint_measured.json. Usage: bench/joint_measured.py
"""
import itertools
import math

import numpy as np

from common import short, write_record
from hdengine import _engine
from hdengine.elastic import moduli

KGF = 98066.5   # kgf/cm^2 in Pa
STEEL, IRON = (205e9, 0.29, 205e9, 0.29), (110e9, 0.26, 110e9, 0.26)   # not stated in the source: usual values
HARDNESS = {"steel": 2.0e9, "iron": 1.8e9}
CASES = [
    {"name": "steel S45C, ground, R_max 1.0 um", "source": "table 6-5 (i)", "kind": "steel", "roughness_um": 1.0, "of": "R_max",
     "unit_pa": 1e6, "to_pa": 100 * KGF, "joints": [(0.40, 0.089), (0.36, 0.046), (0.75, 0.017), (0.58, 0.008), (0.39, 0.090), (0.58, 0.053),
                                                   (0.61, 0.022), (0.21, 0.048)]},
    {"name": "steel S45C, lapped, R_max 1.4 um", "source": "table 6-5 (ii)", "kind": "steel", "roughness_um": 1.4, "of": "R_max",
     "unit_pa": 1e6, "to_pa": 100 * KGF, "joints": [(0.54, 0.051), (0.60, 0.039), (0.60, 0.032), (0.56, 0.045), (0.43, 0.074), (0.55, 0.027)]},
    {"name": "cast iron, ground, R_CLA 1.0 um", "source": "table 6-2", "kind": "iron", "roughness_um": 1.0, "of": "R_CLA", "unit_pa": KGF,
     "to_pa": 25 * KGF, "joints": list(itertools.product((0.4, 0.5), (0.6, 0.7)))},
]
BEAM = {"joint": "steel 304, Brake-Reuß beam, asperities of scans", "source": "tmd-lab/tmdsimpy, brb_surface_data.mat", "radius_m": 1.365e-3,
        "per_m2": 1.371e6, "deviation_m": 3.17e-6, "modulus_pa": 192.31e9, "ratio": 0.3, "bolts_pa": 3 * 12249 / 2.921e-3}   # of both faces
SUMMITS = np.linspace(-6, 6, 2001)   # their heights over the standard deviation


def measured(case):
    """Pressures [Pa], and dp/dlambda = p^(1-m)/(C m) of each joint [Pa/m]."""
    p = np.geomspace(0.1 * case["to_pa"], case["to_pa"], 6)
    x = p / case["unit_pa"]
    return p, [x ** (1 - m) / (c * m) * case["unit_pa"] / 1e-6 for m, c in case["joints"]]


def law(case, p):
    """k_N by the spectrum; Rq = 1.25 R_CLA of Gaussian heights."""
    r = case["roughness_um"] * 1e-6
    rq, d, longest = (math.sqrt(math.pi / 2) * r if case["of"] == "R_CLA" else r / 6), 2.3, 0.8e-3
    a = 2 * (3 - d)
    g = (2 * rq**2 * 2 * a / (longest**a - 2.5e-6**a)) ** (0.5 / (d - 2))
    e_star = moduli(*(STEEL if case["kind"] == "steel" else IRON))[0]
    return _engine.call("fractal_joint", [d, g, longest, 2.5e-6], e_star, HARDNESS[case["kind"]], p)[0]


def beam():
    """Pressures [Pa], k_N of the beam's asperities with Gaussian heights (Greenwood and Williamson 1966) and of the law [Pa/m]."""
    radius, deviation, e_star = BEAM["radius_m"], BEAM["deviation_m"], BEAM["modulus_pa"] / (2 * (1 - BEAM["ratio"]**2))
    weight = BEAM["per_m2"] * e_star * math.sqrt(radius / (2 * math.pi)) * np.exp(-SUMMITS**2 / 2)
    closure = np.linspace(-3, 3, 601)[:, None]
    depth = deviation * np.maximum(closure - SUMMITS, 0)
    pressure, stiffness = (np.trapezoid(c * weight * depth**e, SUMMITS, axis=1) for c, e in ((4 / 3, 1.5), (2.0, 0.5)))
    p = BEAM["bolts_pa"] * np.array([0.1, 1.0])
    return p, np.exp(np.interp(np.log(p), np.log(pressure), np.log(stiffness))), law({"roughness_um": 6e6 * deviation, "of": "R_max", "kind": "steel"}, p)


def main():
    """Every set of joints, at the ends of its pressures."""
    rows = []
    for case in CASES:
        p, joints = measured(case)
        mean, spread = np.exp(np.log(joints).mean(0)) / law(case, p), np.max(joints, axis=0) / np.min(joints, axis=0)
        ends = {"pressure_pa": p[[0, -1]], "mean_over_law": mean[[0, -1]], "spread": [spread.min(), spread.max()]}
        rows.append({"joint": case["name"], "source": case["source"], "joints": len(joints)} | {k: short(v, 3) for k, v in ends.items()})
    p, asperities, theory = beam()
    rows.append({"joint": BEAM["joint"], "source": BEAM["source"], "joints": 1, "pressure_pa": short(p, 3), "mean_over_law": short(asperities / theory, 3),
                 "spread": [1.0, 1.0]})
    print(*rows, sep="\n")
    write_record("joint_measured", {"book": "Y. Ito, Modular Design for Machine Tools, McGraw-Hill 2008", "rows": rows})


if __name__ == "__main__":
    main()
