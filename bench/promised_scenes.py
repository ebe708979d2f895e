#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes that state a tolerance: how often the planner promises it, and how often the true error keeps the promise.

The true error of K_TS, normal force and mid-band pressure is that against a mesh three refinements finer: facets and cells at the
edges shorter by 2^(3/2), twice the layers, the same load steps and (small) displacements. A promise is made where the summary
says "met": "yes"; meshes above LIMIT_MB are refused. References above level FINEST are too costly: such promises stay unjudged.
Scenes are drawn one by one and written at once, so a stopped run goes on where it was.

Usage: bench/promised_scenes.py [--count 200] [--seconds 540] [--tolerances 0.1 0.03 0.01]; writes
bench/results/promised_scenes.jsonl and a figure, prints Markdown.
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

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "bench/results/promised_scenes.jsonl"
BAND = (4, 6, 8, 12, 16, 22, 32, 46, 64)
TOLERANCES = (0.1, 0.03, 0.01)
NAMES = ("k_ts", "normal_force", "mid_band_pressure")
LIMIT_MB = 450
FINEST = 9


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


def finer(keys, plan, scene):
    """Keys of the mesh three refinements finer; None if it is too fine."""
    level = plan["level"] + 3
    if level > FINEST:
        return None
    rows = BAND[level - 1]
    around = max(16, 4 * round(np.pi * scene["geometry.bore_radius"] * rows / (3.2 * scene["geometry.band_length"])))
    return keys | {"mesh.band_facets": rows, "mesh.divisions": around, "mesh.edge_length": scene["mesh.edge_length"] / 2**1.5,
                   "mesh.through_wall": 2 * scene["mesh.through_wall"], "mesh.through_ring": 2 * scene["mesh.through_ring"],
                   "load.assembly_steps": scene["load.assembly_steps"], "load.torque_steps": scene["load.torque_steps"]}


def judge(i, folder, tolerances):
    """One row per scene: what was promised at each tolerance, and what is true."""
    keys = draw(i)
    row = {"scene": i, "keys": keys, "runs": []}
    for tolerance in tolerances:
        if row["runs"] and row["runs"][-1].get("met") == "no":  # the finest mesh allowed was not enough for a larger tolerance
            row["runs"].append({"tolerance": tolerance, "met": "no"})
            continue
        wanted = {"run.tolerance": tolerance, "mesh.memory_limit_mb": LIMIT_MB, "solver.kinematics": "linear"}
        try:
            q, s, seconds = solve(keys | wanted, folder)
        except hdengine.HdengineError as e:
            row["runs"].append({"tolerance": tolerance, "message": str(e)[:120]})
            continue
        plan, scene = s.get("plan", {}), s["scene"]
        run = {"tolerance": tolerance, "met": plan.get("met", "no plan"), "level": plan.get("level"), "seconds": seconds,
               "estimate": [plan.get(f"estimated_error_{n}") for n in NAMES], "k_ts": q[0],
               "mesh": {k: scene[f"mesh.{k}"] for k in ("divisions", "band_facets", "edge_length", "through_wall")}}
        if run["met"] == "yes" and (reference := finer(keys, plan, scene)):
            try:
                true, _, run["reference_seconds"] = solve(reference, folder)
                run["true_error"] = [abs(a / b - 1) for a, b in zip(q, true)]
            except hdengine.HdengineError as e:
                run["reference_message"] = str(e)[:120]
        row["runs"].append(run)
    return row


def report(rows):
    """Markdown table by tolerance."""
    print("| tolerance | scenes | promised | judged | kept | true error over tolerance: median, largest | estimate over true error: median | "
          "time of the reference over planned run: median, quartiles |")
    print("|---|---|---|---|---|---|---|---|")
    for tolerance in sorted({run["tolerance"] for row in rows for run in row["runs"]}, reverse=True):
        runs = [run for row in rows for run in row["runs"] if run["tolerance"] == tolerance]
        made = [run for run in runs if run.get("met") == "yes"]
        judged = [run for run in made if "true_error" in run]
        text = "- | - | - | -"
        if judged:
            worst = np.array([max(run["true_error"]) for run in judged])
            saved = np.percentile([run["reference_seconds"] / run["seconds"] for run in judged], (50, 25, 75))
            cautious = np.median([max(run["estimate"]) for run in judged] / worst)
            text = (f"{np.sum(worst <= tolerance)} | {np.median(worst) / tolerance:.2f}, {worst.max() / tolerance:.2f} | {cautious:.1f} | "
                    f"{saved[0]:.1f}, {saved[1]:.1f} to {saved[2]:.1f}")
        print(f"| {tolerance} | {len(runs)} | {len(made)} | {len(judged)} | {text} |")


def figure(rows):
    """True error over its estimate, and what the plan saves: docs/figures/promised_scenes.png."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    runs = [run for row in rows for run in row["runs"] if "true_error" in run]
    fig, axes = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained")
    for i, (name, mark) in enumerate(zip(("$K_{TS}$", "normal force", "mid-band pressure"), "os^")):
        axes[0].loglog([100 * run["estimate"][i] for run in runs], [100 * max(run["true_error"][i], 1e-5) for run in runs], mark, label=name)
    axes[0].plot([0.05, 20], [0.05, 20], "k:", label="true = estimated")
    axes[0].axhline(100 * max(run["tolerance"] for run in runs), color="C3", label="tolerance")
    axes[0].set(xlabel="estimated error / %", ylabel="true error / %")
    fig.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    axes[1].hist([run["reference_seconds"] / run["seconds"] for run in runs], bins=12)
    axes[1].set(xlabel="time of the reference over time of the planned run", ylabel="scenes")
    fig.savefig(ROOT / "docs/figures/promised_scenes.png", dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=540, help="no new scene is begun after so long")
    parser.add_argument("--tolerances", type=float, nargs="+", default=[0.1, 0.03, 0.01])
    args = parser.parse_args()
    os.nice(10)
    rows = [json.loads(line) for line in OUT.read_text().splitlines()] if OUT.exists() else []
    start = time.time()
    folder = tempfile.mkdtemp()
    for i in range(len(rows), args.count):
        if time.time() - start > args.seconds:
            break
        rows.append(judge(i, folder, args.tolerances))
        with OUT.open("a") as f:
            f.write(json.dumps(rows[-1]) + "\n")
    shutil.rmtree(folder)
    report(rows)
    figure(rows)
    print(f"{len(rows)} of {args.count} scenes; {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
