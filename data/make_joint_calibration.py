#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The statistical joint against a boundary-element half space (PyPI tamaas), and (r_m, s_min) fitted to it.

Periodic surfaces of the paper's D and G, 512 x 512, three seeds, two short cut-offs; elastic, as the boundary elements are.
At each pressure tamaas solves the normal contact; on the contact area it finds, conjugate gradients with tamaas's half-space
operator give the incremental normal and tangential stiffness (full stick). The statistical model without yield (H = 1e6 GPa) is
fitted to the means in the logarithm. Writes data/joint_calibration.json.
Usage: python data/make_joint_calibration.py [--points 512] [--seeds 3]
"""
import argparse
import json
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

import hdengine
from hdengine import Joint, surface

DATA = Path(__file__).parent / "joint_calibration.json"
LENGTH, CUT_OFFS = 0.5e-3, (8e-6, 4e-6)
PRESSURE = np.array([2e6, 5e6, 10e6, 20e6, 50e6, 100e6, 200e6, 500e6])
ELASTIC = Joint(hardness=1e15)


def half_space(tm, joint, n):
    """Half space on a rigid surface with the reduced moduli E and G' of the joint."""
    p = joint.asperity()[0]
    ratio = 4 * p["g_prime_pa"] / p["e_star_pa"]  # 2 (1 - nu) / (2 - nu)
    nu = (2 - 2 * ratio) / (2 - ratio)
    model = tm.ModelFactory.createModel(tm.model_type.surface_2d, [LENGTH, LENGTH], [n, n])
    model.nu, model.E = nu, p["e_star_pa"] * (1 - nu**2)
    return model


def incremental(model, mask, direction):
    """Stiffness per area [Pa/m] of a rigid displacement of the contact area along an axis, contact area fixed."""
    goal = np.zeros(model.displacement.shape)
    goal[mask, direction] = 1
    use = np.zeros(goal.shape, bool)
    use[mask] = [False, False, True] if direction == 2 else [True, True, False]

    def displacement(t):
        model.traction[...] = t
        model.solveNeumann()
        return np.where(use, model.displacement, 0)

    t = np.zeros(goal.shape)
    r = np.where(use, goal, 0)
    d, rr = r.copy(), np.sum(r * r)
    start = rr
    for _ in range(2000):
        ad = displacement(d)
        step = rr / np.sum(d * ad)
        t += step * d
        r -= step * ad
        new = np.sum(r * r)
        if new < 1e-12 * start:
            break
        d, rr = r + new / rr * d, new
    return t[..., direction].mean()


def measure(points, seeds):
    """K_N and K_T per area over pressure for every seed and cut-off."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    joint, rows = ELASTIC, []
    for cut_off in CUT_OFFS:
        for seed in range(1, seeds + 1):
            z = surface.periodic(points, LENGTH, joint.fractal_dimension, joint.roughness, cut_off, seed)
            normal = tm.ModelFactory.createModel(tm.model_type.basic_2d, [LENGTH, LENGTH], [points, points])
            normal.E, normal.nu = joint.asperity()[0]["e_star_pa"], 0
            solver = tm.PolonskyKeerRey(normal, z, 1e-9)
            model = half_space(tm, joint, points)
            for p in PRESSURE:
                solver.solve(p)
                mask = normal.traction > 0
                rows.append({"cut_off_m": cut_off, "seed": seed, "pressure_pa": p, "area_fraction": mask.mean(),
                             "k_n_pa_per_m": incremental(model, mask, 2), "k_t_pa_per_m": incremental(model, mask, 0)})
                print({k: float(f"{v:.4g}") for k, v in rows[-1].items()}, flush=True)
    return rows, tm.__version__


def model_stiffness(joint, pressure):
    """K_N, K_T per area [Pa/m] of the statistical model."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hdengine.JointWarning)
        return np.array(joint.stiffness(pressure)) / joint.reference_area


def fit(rows):
    """(r_m, s_min) by least squares of ln K_N and ln K_T over all rows, on a grid refined about its best point."""
    p = np.array([r["pressure_pa"] for r in rows])
    goal = np.log([[r["k_n_pa_per_m"] for r in rows], [r["k_t_pa_per_m"] for r in rows]])

    def misfit(x):
        joint = replace(ELASTIC, asperity_radius=np.exp(x[0]), s_min=np.exp(x[1]))
        with np.errstate(divide="ignore"):
            return np.mean((np.log(model_stiffness(joint, p)) - goal) ** 2)

    best, width = np.log([5e-6, 1e-12]), np.array([5.0, 12.0])
    for _ in range(12):
        grid = [(best[0] + a * width[0], best[1] + b * width[1]) for a in np.linspace(-1, 1, 15) for b in np.linspace(-1, 1, 15)]
        best = np.array(min(grid, key=misfit))
        width /= 2.5
    return np.exp(best[0]), np.exp(best[1]), np.sqrt(misfit(best))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--points", type=int, default=512)
    parser.add_argument("--seeds", type=int, default=3)
    args = parser.parse_args()
    rows, version = measure(args.points, args.seeds)
    means = [{"pressure_pa": p} | {k: np.mean([r[k] for r in rows if r["pressure_pa"] == p]) for k in ("k_n_pa_per_m", "k_t_pa_per_m")} for p in PRESSURE]
    separate = {f"{1e6 * c:g} um": dict(zip(("asperity_radius_m", "s_min_m2", "rms_ln_misfit"),
                                            fit([r for r in rows if r["cut_off_m"] == c]))) for c in CUT_OFFS}
    r_m, s_min, misfit = fit(rows)
    record = {"fitted": {"asperity_radius_m": r_m, "s_min_m2": s_min, "rms_ln_misfit": misfit, "by_cut_off": separate},
              "surface": {"fractal_dimension": ELASTIC.fractal_dimension, "roughness_m": ELASTIC.roughness, "length_m": LENGTH,
                          "points": args.points, "cut_offs_m": CUT_OFFS},
              "provenance": {"script": "data/make_joint_calibration.py", "tamaas": version, "hdengine": hdengine.__version__,
                             "model": "elastic (no yield) on both sides, moduli of the default joint"}, "means": means}
    DATA.write_text(json.dumps(record, indent=1) + "\n")
    print(json.dumps(record["fitted"], indent=1))


if __name__ == "__main__":
    main()
