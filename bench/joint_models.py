#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""K_TS of CD-14-100 by each model of the joint over torque, w and eccentricity; rings of the paper and ground ones; the ring slides.

The contact law is hard: all models judge the same pressures. The tangent is that of the contact with the joint in series; Eq. 45 sums
facets. boundary_elements: a table of one periodic map of the scene's D and G (256 x 256 points), left out where
nearly all contact yields.
Writes bench/results/joint_models.json and docs/figures/joint_models.png. Usage: bench/joint_models.py [--redraw]
"""
import argparse
import tempfile
from pathlib import Path

import numpy as np

import hdengine
from common import DATA, new_axes, read_record, save_figure, styled, write_record
from hdengine import Run, surface
from hdengine.elastic import moduli
from hdengine.prediction.choice import STEEP
from hdengine.prediction.half_space import stiffness_on_map

POINTS = [{"wave_generator.w": w} for w in (0.195e-3, 0.2e-3, 0.205e-3, 0.21e-3, 0.215e-3)] + [{"wave_generator.eccentricity": 1e-5}]
PRESSURE = np.geomspace(1e6, 400e6, 10)
RING = {"wave_generator.ring_tangent": "auto"}


def table_of(scene, folder):
    """Table of boundary elements on a map of the scene's D and G; None where nearly all contact yields."""
    s = hdengine.read_scene(DATA / f"{scene}.nml")
    d, g, length, shortest = (s[f"joint.{k}"] for k in ("fractal_dimension", "roughness", "sample_length", "shortest_wavelength"))
    e_star, ratio = moduli(s["material.flexspline_e"], s["material.flexspline_nu"], s["material.ring_e"], s["material.ring_nu"])
    z = surface.periodic(256, length, d, g, max(shortest, 4 * length / 256), 1)
    hardness = hdengine.Joint.of_scene(s).hardness
    steep = e_star * np.sqrt((np.hypot(*np.gradient(z, length / 256)) ** 2).mean()) / hardness
    print(scene, f"E* slope is {steep:.3g} hardnesses", flush=True)
    if steep > STEEP:
        return None
    k_n, k_t, _ = stiffness_on_map(z, (length / 256,) * 2, PRESSURE, e_star, ratio, hardness)
    path = folder / f"{scene}.csv"
    np.savetxt(path, np.c_[PRESSURE, k_n, k_t], delimiter=",", header="pressure_pa,k_n_pa_per_m,k_t_pa_per_m", comments="")
    return path


def rows_of(scene, model, keys, folder):
    """One run of five torques."""
    out = folder / "out"
    with Run(DATA / f"{scene}.nml", out, True, **{"load.torque": 5.0, "load.torque_steps": 5, "output.vtu": "none", **RING, **keys,
                                                 **model}) as run:
        for _ in run:
            pass
    result, rows = hdengine.Result(out), []
    steps = result.steps
    for i in range(len(result.torque_nm)):
        if result.torque_nm[i] > 0:
            rows.append({"scene": scene, "model": model["joint.model"], **keys, "torque_nm": round(float(result.torque_nm[i]), 6)} |
                        {name: float(f"{steps[column][i]:.5g}") for name, column in (
                            ("eq45", "k_ts_nm_per_rad"), ("tangent", "k_ts_tangent_nm_per_rad"), ("secant", "k_ts_secant_nm_per_rad"),
                            ("slip_share_force", "slip_share_force"))})
    return rows


def collect():
    rows, refused = [], []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for scene in ("cd14", "cd14_ground"):
            models = [{"joint.model": "hu2023"}, {"joint.model": "spectrum"}]
            table = table_of(scene, folder)
            if table:
                models.append({"joint.model": "boundary_elements", "joint.table_file": str(table)})
            else:
                refused.append(scene)
            for model in models:
                for keys in POINTS:
                    rows += rows_of(scene, model, keys, folder)
                    print({k: v if isinstance(v, str) else float(f"{v:.4g}") for k, v in rows[-1].items()}, flush=True)
    return rows, refused


def conclusions(rows):
    """Changes of the tangent by scene and model [%]: with torque from 1 to 5 N m, with w from 0.195 to 0.215 mm and with 10 um of
    eccentricity at 5 N m; and the mean secant over the tangent."""
    found = []
    for scene, model in dict.fromkeys((r["scene"], r["model"]) for r in rows):
        mine = [r for r in rows if (r["scene"], r["model"]) == (scene, model)]

        def at(torque, w=0.2e-3, eccentricity=0.0, column="tangent", mine=mine):
            return next(r[column] for r in mine if r["torque_nm"] == torque and r.get("wave_generator.eccentricity", 0.0) == eccentricity
                        and r.get("wave_generator.w", 0.2e-3) == w and ("wave_generator.w" in r) == (not eccentricity))

        def change(new, old):
            return float(f"{100 * (new / old - 1):.3g}")

        found.append({"scene": scene, "model": model, "tangent_1_nm": at(1.0), "tangent_5_nm": at(5.0),
                      "eq45_5_nm": at(5.0, column="eq45"), "secant_5_nm": at(5.0, column="secant"),
                      "torque_1_to_5_percent": change(at(5.0), at(1.0)),
                      "w_0195_to_0215_percent": change(at(5.0, 0.215e-3), at(5.0, 0.195e-3)),
                      "eccentricity_10um_percent": change(at(5.0, eccentricity=1e-5), at(5.0))})
    return found


@styled
def draw(rows):
    """Tangent and Eq. 45 over the torque, and the tangent over w at 5 N m."""
    figure, axes = new_axes(3, 1, figsize=(8, 14))
    colours = {"hu2023": "C3", "spectrum": "C0", "boundary_elements": "C1"}
    for scene, style in (("cd14", "--"), ("cd14_ground", "-")):
        for model, colour in colours.items():
            mine = [r for r in rows if (r["scene"], r["model"]) == (scene, model)]
            over = [r for r in mine if r.get("wave_generator.w") == 0.2e-3]
            across = [r for r in mine if "wave_generator.w" in r and r["torque_nm"] == 5.0]
            label = f"{model}, {'ground rings' if 'ground' in scene else 'rings of the paper'}"
            if mine:
                axes[0].plot([r["torque_nm"] for r in over], [r["tangent"] / 1e6 for r in over], style, color=colour, marker="o", label=label)
                axes[1].plot([r["torque_nm"] for r in over], [r["eq45"] / 1e6 for r in over], style, color=colour, marker="o")
                axes[2].plot([1e3 * r["wave_generator.w"] for r in across], [r["tangent"] / 1e6 for r in across], style, color=colour, marker="o")
    axes[0].set(xlabel="torque / N m", ylabel="tangent K_TS / (MN m/rad)")
    axes[1].set(xlabel="torque / N m", ylabel="K_TS by Eq. 45 / (MN m/rad)", yscale="log")
    axes[2].set(xlabel="w / mm", ylabel="tangent K_TS at 5 N m / (MN m/rad)")
    axes[0].set_ylim(0, 0.6)
    axes[2].set_ylim(0, 0.6)
    axes[2].set_xticks([0.195, 0.2, 0.205, 0.21, 0.215], ["0.195", "0.200", "0.205", "0.210", "0.215"])
    axes[0].legend(fontsize=11)
    save_figure(figure, "joint_models")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--redraw", action="store_true", help="figure from the record")
    if parser.parse_args().redraw:
        rows = read_record("joint_models")["rows"]
    else:
        rows, refused = collect()
        write_record("joint_models", {"ring_tangent": "auto", "boundary_elements_refused": refused, "conclusions": conclusions(rows),
                                      "rows": rows}, seed=1)
    for line in conclusions(rows):
        print(line)
    draw(rows)


if __name__ == "__main__":
    main()
