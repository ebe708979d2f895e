#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes that state a tolerance: how often the planner promises it, and how often the true error keeps the promise.

The true error of K_TS, normal force and mid-band pressure is that against a mesh three refinements finer (mesh sizes fall by
2^(1/2) each), at most level 8 of the series. A promise is made where the summary says "met": "yes"; memory is limited so that
levels above 7 are refused. Scenes are drawn one by one and written at once, so a stopped run goes on where it was.

Usage: bench/promised_scenes.py [--count 200] [--seconds 540]; writes bench/results/promised_scenes.jsonl, prints Markdown.
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
BAND = (4, 6, 8, 11, 16, 23, 32, 45)
TOLERANCES = (0.1, 0.03, 0.01)
NAMES = ("k_ts", "normal_force", "mid_band_pressure")
LIMIT_MB = 330


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


def judge(i, folder):
    """One row per scene: what was promised at each tolerance, and what is true."""
    keys = draw(i)
    row = {"scene": i, "keys": keys, "runs": []}
    references = {}
    for tolerance in TOLERANCES:
        if row["runs"] and row["runs"][-1].get("met") == "no":  # the finest mesh allowed was not enough for a larger tolerance
            row["runs"].append({"tolerance": tolerance, "met": "no"})
            continue
        try:
            q, s, seconds = solve(keys | {"run.tolerance": tolerance, "mesh.memory_limit_mb": LIMIT_MB}, folder)
        except hdengine.HdengineError as e:
            row["runs"].append({"tolerance": tolerance, "message": str(e)[:120]})
            continue
        plan = s.get("plan", {})
        run = {"tolerance": tolerance, "met": plan.get("met", "no plan"), "level": plan.get("level"), "seconds": seconds,
               "estimate": [plan.get(f"estimated_error_{n}") for n in NAMES]}
        if run["met"] == "yes":
            level = min(run["level"] + 3, len(BAND))
            if level not in references:
                scene = hdengine.read_scene(ROOT / "data/cd14.nml", geometry={k.split(".")[1]: v for k, v in keys.items() if k.startswith("geometry")})
                cells = {"mesh.band_facets": BAND[level - 1],
                         "mesh.divisions": max(16, 2 * round(np.pi * scene["geometry.bore_radius"] * BAND[level - 1] / (1.6 * scene["geometry.band_length"])))}
                cells |= {k: s["scene"][k] for k in ("load.assembly_steps", "load.torque_steps")}
                references[level] = solve(keys | cells, folder)
            true, _, run["reference_seconds"] = references[level]
            run |= {"reference_level": level, "true_error": [abs(a / b - 1) for a, b in zip(q, true)]}
        row["runs"].append(run)
    return row


def report(rows):
    """Markdown table by tolerance and by how much finer the reference is."""
    print("| tolerance | scenes | refinements to the reference | promised | kept | largest true error over tolerance | time of the reference over planned run |")
    print("|---|---|---|---|---|---|---|")
    for tolerance in TOLERANCES:
        runs = [run for row in rows for run in row["runs"] if run["tolerance"] == tolerance]
        made = [run for run in runs if run.get("met") == "yes"]
        if not made:
            print(f"| {tolerance} | {len(runs)} | - | 0 | - | - | - |")
        for finer in (3, 2, 1):
            part = [run for run in made if run["reference_level"] - run["level"] == finer]
            if part:
                worst = [max(run["true_error"]) / tolerance for run in part]
                print(f"| {tolerance} | {len(runs)} | {finer} | {len(part)} | {sum(w <= 1 for w in worst)} | {max(worst):.2f} | "
                      f"{np.median([run['reference_seconds'] / run['seconds'] for run in part]):.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=540, help="no new scene is begun after so long")
    args = parser.parse_args()
    os.nice(10)
    rows = [json.loads(line) for line in OUT.read_text().splitlines()] if OUT.exists() else []
    start = time.time()
    folder = tempfile.mkdtemp()
    for i in range(len(rows), args.count):
        if time.time() - start > args.seconds:
            break
        rows.append(judge(i, folder))
        with OUT.open("a") as f:
            f.write(json.dumps(rows[-1]) + "\n")
    shutil.rmtree(folder)
    report(rows)
    print(f"{len(rows)} of {args.count} scenes; {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
