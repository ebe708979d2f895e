#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes that state a tolerance: how often the planner promises it, and how often the true error keeps the promise.

Promised are the limits of K_TS, normal force and mid-band pressure for fine facets. True are those of five levels of the series, from
2^(1/2) coarser to 2^(3/2) finer than the mesh that was run, with cells at the edges 2^(3/2) shorter and four layers, the same load steps
and (small) displacements, to a residual of 1e-5; what eight layers change is taken from the level next to that mesh, what more change
from 8 and 16 of them on 16 rows, to the end of the line. All three go as the square of a row's height; in references without
"reference_ends", which are of nodes' pressures and not of power means where contact ends, K_TS as the height. Earlier ones rest on
the three finest levels; "reference_meshes":
"former": before rows kept their lengths as a mesh is refined; without "reference_layers": all layers from 16 rows. What the levels
scatter about their line is said of each kind; a reference of former meshes does not judge SHARP promises, one with longer cells at the
edges than a plan's does not judge that (it may be another tolerance's; of former meshes they were not recorded).
A promise is made where the summary says "met": "yes"; meshes above LIMIT_MB are refused. References above level --finest are too
costly: such promises stay unjudged. One reference serves all tolerances of a scene, that of the smallest.

Usage: bench/promised_scenes.py [--count 200] [--first 0] [--every 1] [--seconds 540] [--tolerances 0.1 0.03 0.01] [--finest 10];
what bench/results/promised_scenes.jsonl holds is not run again; several may run at once on different scenes (the last row of a scene counts).
--record NAME writes another record, as of a sample by another engine. Figure (of the whole record) and Markdown at the end.
"""
import argparse
import json
import os
import resource
import shutil
import tempfile
import time
from pathlib import Path

import numpy as np

import hdengine
from common import ROOT, add_row, mesh_of_level, read_rows

BAND = tuple(mesh_of_level(level)["mesh.band_facets"] for level in range(1, 14))
TOLERANCES = (0.1, 0.03, 0.01)
NAMES = ("k_ts", "normal_force", "mid_band_pressure")
LIMITS = ("k_ts_nm_per_rad", "normal_force_n", "pressure_mid_mean_pa")
CHOSEN = ("mesh.divisions", "mesh.band_facets", "mesh.edge_length", "mesh.through_wall", "load.assembly_steps", "load.torque_steps",
          "geometry.bore_radius", "geometry.band_length")
LIMIT_MB = 3000
SHARP = 0.02
FINEST = 10


def draw(i):
    """Keys of scene i, from its own generator."""
    r = np.random.default_rng([611, i])
    wall = r.uniform(0.25e-3, 0.8e-3)
    keys = {
        "geometry.wall_thickness": wall,
        "geometry.rim_thickness": wall * r.uniform(1, 2),
        "geometry.ring_thickness": r.uniform(0.5e-3, 1.5e-3),
        "geometry.band_length": r.uniform(9e-3, 14e-3),
        "wave_generator.w": r.uniform(0.1e-3, 0.3e-3),
        "wave_generator.interference": r.uniform(0, 30e-6),
        "wave_generator.eccentricity": float(r.random() < 0.3) * r.uniform(0, 20e-6),
        "contact.friction": r.uniform(0.05, 0.3),
        "load.torque": r.uniform(0.5, 10),
    }
    return {k: float(f"{v:.6g}") for k, v in keys.items()}


def solve(keys, folder):
    """Quantities, summary, CPU seconds of a run; all meshes forgotten before."""
    groups = {}
    for key, value in keys.items():
        group, name = key.split(".")
        groups.setdefault(group, {})[name] = value
    hdengine.forget()
    start = time.process_time()
    with hdengine.Run(ROOT / "data/cd14.nml", out=folder, force=True, output={"vtu": "none"}, **groups) as run:
        for step in run:
            pass
    seconds = time.process_time() - start
    summary = json.loads((Path(folder) / "summary.json").read_text())
    return [step.k_ts_nm_per_rad, step.sums["normal_force_n"], step.sums["pressure_mid_mean_pa"]], summary, seconds


def finer(keys, level, scene, layers=4):
    """Keys of a mesh of the series with cells at the edges three refinements finer than those of a plan."""
    mesh = mesh_of_level(level, geometry={k.split(".")[1]: scene[k] for k in ("geometry.bore_radius", "geometry.band_length")})
    return keys | mesh | {"mesh.edge_length": scene["mesh.edge_length"] / 2**1.5,
                   "mesh.through_wall": layers, "mesh.through_ring": layers, "solver.tolerance": 1e-5,
                   "load.assembly_steps": scene["load.assembly_steps"], "load.torque_steps": scene["load.torque_steps"]}


def beyond_eight(keys, scene, folder):
    """What layers beyond eight change, from 8 and 16 of them on 16 rows to the end of the line."""
    eight, sixteen = (np.array(solve(finer(keys, 5, scene, layers), folder)[0]) for layers in (8, 16))
    return (2 * sixteen - eight) / eight


def truth(keys, level, scene, folder):
    """K_TS, force and pressure of the five levels up to three after one, and the CPU seconds of each: four layers, times what eight of
    them change on the level after it, times what more change."""
    found = [solve(finer(keys, k, scene), folder) for k in range(level - 1, level + 4)]
    eight = np.array(solve(finer(keys, level + 1, scene, 8), folder)[0])
    change = eight / np.array(found[2][0]) * beyond_eight(keys, scene, folder)
    return [(q * change).tolist() for q, _, _ in found], [seconds for _, _, seconds in found]


def limit(row):
    """Limits of a reference, straight lines over a power of the height of a row, and their standard deviations, relative, from its scatter."""
    values = np.array(row["reference"])
    h = 1 / np.array(BAND[row["reference_level"] - len(values):row["reference_level"]])
    found, sure = np.zeros(3), np.zeros(3)
    for i in range(3):
        line = np.stack([np.ones_like(h), h if i == 0 and "reference_ends" not in row else h**2], axis=1)
        solution, rest = np.linalg.lstsq(line, values[:, i], rcond=None)[:2]
        found[i] = solution[0]
        sure[i] = np.sqrt(np.linalg.inv(line.T @ line)[0, 0] * rest[0] / (len(values) - 2)) / solution[0]
    return found, sure


def planned(keys, tolerance, folder):
    """What a planned run promises, with what a reference needs of the scene that it chose."""
    wanted = {"run.tolerance": tolerance, "mesh.memory_limit_mb": LIMIT_MB, "solver.kinematics": "linear"}
    try:
        q, s, seconds = solve(keys | wanted, folder)
    except hdengine.HdengineError as e:
        return {"tolerance": tolerance, "message": str(e)[:120]}
    plan, scene = s["plan"], s["scene"]
    if not plan["level"]:
        return {"tolerance": tolerance, "met": "no", "level": 0, "seconds": seconds, "message": plan["reasons"][-2]}
    return {"tolerance": tolerance, "met": plan["met"], "level": plan["level"], "seconds": seconds,
            "estimate": [plan[f"estimated_error_{n}"] for n in NAMES], "limit": [plan[n] for n in LIMITS], "mesh_gives": q,
            "scene": {k: scene[k] for k in CHOSEN}}


def judge(row, folder, finest_level):
    """What is true of the promises of a scene, with one reference for all: an earlier one if it is fine enough."""
    runs = [run for run in row["runs"] if run.get("met") == "yes"]
    made = [run for run in runs if run["level"] + 3 <= finest_level and "scene" in run]
    finest = max(made, key=lambda run: (run["level"], -run["scene"]["mesh.edge_length"]), default={"level": 0})
    sharp = row.get("reference_meshes") != "former" or finest.get("tolerance", 1) > SHARP
    edges = not made or row.get("reference_edge_length", 0) <= finest["scene"]["mesh.edge_length"]
    if made and (row.get("reference_level", 0) < finest["level"] + 3 or not (sharp and edges)):
        try:
            row["reference"], row["reference_seconds"] = truth(row["keys"], finest["level"], finest["scene"], folder)
            row["reference_level"] = finest["level"] + 3
            row["reference_layers"] = BAND[finest["level"]]
            row["reference_edge_length"] = finest["scene"]["mesh.edge_length"] / 2**1.5
            row["reference_ends"] = "power means"
            row.pop("reference_meshes", None)
        except hdengine.HdengineError as e:
            row["reference_message"] = str(e)[:120]
    if "reference" in row:
        true, _ = limit(row)
        for run in row["runs"]:
            run.pop("true_error", None)
            run.pop("true_error_of_mesh", None)
        for run in runs:
            sharp = run["tolerance"] > SHARP or row.get("reference_meshes") != "former"
            edges = row.get("reference_edge_length", 0) <= run.get("scene", {}).get("mesh.edge_length", 0)
            if run["level"] + 3 <= row["reference_level"] and sharp and edges:
                run["true_error"] = abs(np.array(run["limit"]) / true - 1).tolist()
                run["true_error_of_mesh"] = abs(np.array(run["mesh_gives"]) / true - 1).tolist()
    return row


def report(rows):
    """Markdown table by tolerance."""
    print("| tolerance | scenes | promised | judged | kept | true error over tolerance: median, largest | estimate over true error: median | "
          "error of the mesh itself: median | CPU seconds: median | time of the finest reference mesh over it: median, quartiles |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for tolerance in sorted({run["tolerance"] for row in rows for run in row["runs"]}, reverse=True):
        runs = [run | {"reference": row.get("reference_seconds", [np.nan])[-1]} for row in rows for run in row["runs"]
                if run["tolerance"] == tolerance]
        made = [run for run in runs if run.get("met") == "yes"]
        judged = [run for run in made if "true_error" in run]
        text = "- | - | - | - | - | -"
        if judged:
            worst = np.array([max(run["true_error"]) for run in judged])
            saved = np.percentile([run["reference"] / run["seconds"] for run in judged], (50, 25, 75))
            cautious = np.median([max(run["estimate"]) for run in judged] / worst)
            text = (f"{np.sum(worst <= tolerance)} | {np.median(worst) / tolerance:.2f}, {worst.max() / tolerance:.2f} | {cautious:.1f} | "
                    f"{100 * np.median([max(run['true_error_of_mesh']) for run in judged]):.1f} % | "
                    f"{np.median([run['seconds'] for run in made]):.0f} | {saved[0]:.1f}, {saved[1]:.1f} to {saved[2]:.1f}")
        print(f"| {tolerance} | {len(runs)} | {len(made)} | {len(judged)} | {text} |")
    kinds = {}
    for row in rows:
        if "reference" in row:
            kind = f"{len(row['reference'])} levels" + (", former meshes" if row.get("reference_meshes") == "former" else "")
            kinds.setdefault(kind, []).append(100 * limit(row)[1])
    for kind, found in kinds.items():
        sure = np.sqrt(np.mean(np.square(found), axis=0))
        print(f"references of {kind}: {len(found)}; standard deviation, rms: K_TS {sure[0]:.2f} %, mid-band pressure {sure[2]:.2f} %")


def figure(rows):
    """True error over its estimate, and what the limit gains: docs/figures/promised_scenes.png."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    runs = [run for row in rows for run in row["runs"] if "true_error" in run]
    tolerances = sorted({run["tolerance"] for run in runs}, reverse=True)
    fig, axes = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    for i, tolerance in enumerate(tolerances):
        own = [run for run in runs if run["tolerance"] == tolerance]
        worst = [100 * max(run["true_error"]) for run in own]
        axes[0].loglog([100 * max(run["estimate"]) for run in own], worst, "os^"[i], ms=4, label=f"tolerance {100 * tolerance:g} %")
        axes[1].loglog([run["seconds"] for run in own], worst, "os^"[i], ms=4, color=f"C{i}")
        axes[1].loglog([run["seconds"] for run in own], [100 * max(run["true_error_of_mesh"]) for run in own], "os^"[i], ms=4,
                       mfc="none", color=f"C{i}")
        axes[0].axhline(100 * tolerance, color=f"C{i}", lw=0.8, ls="--")
    axes[0].plot([0.2, 12], [0.2, 12], "k:", label="true = estimated")
    axes[0].set(xlabel="estimated error / %", ylabel="true error, the largest of three / %", title="K_TS, normal force, mid-band pressure")
    axes[1].plot([], [], "ko", ms=4, label="limit that is promised")
    axes[1].plot([], [], "ko", ms=4, mfc="none", label="mesh that was run")
    axes[1].set(xlabel="time of plan and run / CPU s", ylabel="true error, the largest of three / %")
    axes[0].legend(fontsize=8)
    axes[1].legend(fontsize=8)
    for axis, marks in ((axes[0].xaxis, (1, 2, 5, 10)), (axes[0].yaxis, (0.1, 0.3, 1, 3, 10)), (axes[1].xaxis, (0.5, 1, 2, 5, 10, 20, 50)),
                        (axes[1].yaxis, (0.1, 0.3, 1, 3, 10))):
        axis.set_major_locator(plt.FixedLocator(marks))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(plt.NullFormatter())
    fig.savefig(ROOT / "docs/figures/promised_scenes.png", dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--again", action="store_true", help="plan again what the file holds; references are kept")
    parser.add_argument("--seconds", type=float, default=540, help="no new scene is begun after so long")
    parser.add_argument("--tolerances", type=float, nargs="+", default=TOLERANCES)
    parser.add_argument("--finest", type=int, default=FINEST, help="level of the finest reference; 0: plans only")
    parser.add_argument("--record", default="promised_scenes", help="name of the record")
    args = parser.parse_args()
    os.nice(10)

    def known():
        """Rows of the record by scene; the last of a scene counts."""
        return [row for _, row in sorted(read_rows(args.record, "scene").items())]

    rows = {row["scene"]: {k: v for k, v in row.items() if k != "provenance"} for row in known()}
    start = time.time()
    folder = tempfile.mkdtemp()
    for i in range(args.first, args.count, args.every):
        if time.time() - start > args.seconds:
            break
        row = rows.get(i, {"scene": i, "keys": draw(i), "runs": []})
        before = json.dumps(row)
        for tolerance in args.tolerances:
            others = [run for run in row["runs"] if run["tolerance"] != tolerance]
            if args.again or len(others) == len(row["runs"]):
                row["runs"] = sorted([*others, planned(row["keys"], tolerance, folder)], key=lambda run: -run["tolerance"])
        after = json.dumps(judge(row, folder, args.finest))
        if after != before:
            add_row(args.record, row)
    shutil.rmtree(folder)
    report(known())
    if args.record == "promised_scenes":
        figure(known())
    print(f"{len(known())} of {args.count} scenes; {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
