#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured stiffness of ground and lapped joints beside the law from their roughness; nothing is fitted.

The measurements are constants C and m of the joint deflection C p^m, read in Y. Ito, Modular Design for Machine Tools (McGraw-Hill, 2008):
table 6-5 (steel S45C, Ito and Tsutsumi), tables 6-2 and 6-10 (cast iron, Back et al.). A roughness is all that is known of the surfaces, so
the law is a band over what is not known: spectrum (D 2.1 to 2.5), longest wavelength (0.25 to 2.5 mm), and R_max over Rq (4 to 8).
Writes bench/results/joint_measured.json and docs/figures/joint_measured.png. Usage: bench/joint_measured.py
"""
import itertools
import math
import sys

import numpy as np

from common import new_axes, read_record, save_figure, styled, write_record
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
TANGENTIAL = {"source": "tables 6-8 and 6-10, K_s = p^S / C_t", "joints": [(0.5, 0.8), (0.5, 0.9)]}   # cast iron, ground


def measured(case):
    """Pressures [Pa], and dp/dlambda = p^(1-m)/(C m) of each joint [Pa/m]."""
    p = np.geomspace(0.1 * case["to_pa"], case["to_pa"], 6)
    x = p / case["unit_pa"]
    return p, [x ** (1 - m) / (c * m) * case["unit_pa"] / 1e-6 for m, c in case["joints"]]


def rms(case):
    """Rq of one face [m] and its range: Rq = 1.25 R_CLA of Gaussian heights, R_max 4 to 8 times Rq."""
    r = case["roughness_um"] * 1e-6
    return [math.sqrt(math.pi / 2) * r] * 3 if case["of"] == "R_CLA" else [r / 6, r / 8, r / 4]


def law(case, p):
    """k_N by the spectrum: middle, lowest, highest over what is not known."""
    e_star, ratio = moduli(*(STEEL if case["kind"] == "steel" else IRON))
    found, (middle, *ends) = [], rms(case)
    for d, longest, rq in [(2.3, 0.8e-3, middle), *itertools.product((2.1, 2.3, 2.5), (0.25e-3, 0.8e-3, 2.5e-3), ends)]:
        a = 2 * (3 - d)
        g = (2 * rq**2 * 2 * a / (longest**a - 2.5e-6**a)) ** (0.5 / (d - 2))
        found.append(_engine.call("fractal_joint", [d, g, longest, 2.5e-6], e_star, HARDNESS[case["kind"]], p)[0])
    return found[0], np.min(found, axis=0), np.max(found, axis=0), ratio


def collect():
    rows = []
    for case in CASES:
        p, joints = measured(case)
        middle, low, high, ratio = law(case, p)
        row = {"joint": case["name"], "source": case["source"], "pressure_pa": p, "measured": joints, "law": middle, "law_low": low,
               "law_high": high, "geometric_mean_over_law": np.exp(np.log(joints).mean(0)) / middle,
               "spread": np.max(joints, axis=0) / np.min(joints, axis=0), "inside": float(np.mean((joints > low) & (joints < high)))}
        if case["kind"] == "iron":
            x = p / KGF
            shear = [x**s / c * KGF / 1e-6 for s, c in TANGENTIAL["joints"]]
            row |= {"shear_measured": shear, "shear_law": ratio * middle, "shear_source": TANGENTIAL["source"],
                    "shear_over_normal": np.mean(shear, axis=0) / np.exp(np.log(joints).mean(0)), "kappa": ratio}
        rows.append({k: np.asarray(v).tolist() if not isinstance(v, (str, float)) else v for k, v in row.items()})
        print({k: np.round(v, 3) if k in ("geometric_mean_over_law", "spread", "shear_over_normal", "inside") else v for k, v in row.items()
               if k in ("joint", "geometric_mean_over_law", "spread", "inside", "shear_over_normal")})
    return rows


@styled
def draw(rows):
    """Stiffness over pressure: every measured joint, and the band of the law."""
    figure, axes = new_axes(3, 1, figsize=(8, 15))
    for axis, row in zip(axes, rows):
        p = np.array(row["pressure_pa"]) / 1e6
        axis.fill_between(p, row["law_low"], row["law_high"], color="C0", alpha=0.2, lw=0, label="law, over what is not known")
        axis.plot(p, row["law"], "C0", label="law, D 2.3, waves to 0.8 mm")
        for i, k in enumerate(row["measured"]):
            axis.plot(p, k, "k.-", lw=0.8, label=None if i else "measured, k_N")
        for i, k in enumerate(row.get("shear_measured", [])):
            axis.plot(p, k, "C3.-", lw=0.8, label=None if i else "measured, k_T")
        if "shear_law" in row:
            axis.plot(p, row["shear_law"], "C3--", label="law, k_T without slip")
        axis.set(xscale="log", yscale="log", xlabel="pressure / MPa", title=row["joint"].replace("um", "µm"))
        axis.set_xticks([1, 3, 10] if p[-1] > 5 else [0.3, 1, 2], ["1", "3", "10"] if p[-1] > 5 else ["0.3", "1", "2"])
        axis.set_xticks([], minor=True)
        axis.set_ylabel("stiffness per area / (Pa/m)")
        axis.legend(fontsize=11)
    save_figure(figure, "joint_measured")


def main():
    """Command line; --redraw makes the figure from the record."""
    if sys.argv[1:] != ["--redraw"]:
        write_record("joint_measured", {"book": "Y. Ito, Modular Design for Machine Tools, McGraw-Hill 2008", "rows": collect()})
    draw(read_record("joint_measured")["rows"])


if __name__ == "__main__":
    main()
