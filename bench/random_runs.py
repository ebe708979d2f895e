#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes and whole drives on small meshes: how many converge, in how many iterations, and what the engine says of the rest. From the
tables alone, at every step, forces of contact, balls, teeth and hub must balance, their moments about the axis too; no ball, flank or point of
contact may pull, none rub with more than mu times its force, a point that presses has no gap, friction may give nothing back, and a loop's work
must be what is stored and what friction took. Of pairs two solvers must agree, and two threads with one, to the bit.

Usage: bench/random_runs.py [KIND ...] [--count N] [--only N] [--jobs N] [--minutes N, of each kind]; large: drives with large displacements, rub: with friction of the
flanks, loose: as built, with the bearing free in the cup, presses and built: scenes and drives as built, all keys. Writes
bench/results/random_runs.json; --count writes nothing, --only prints the keys and the result of one.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median

import numpy as np

from common import DATA, ONE_THREAD, ROOT, program, write_part
from hdengine.table_file import read_csv

sys.path.insert(0, str(ROOT / "tools"))
from table_faults import faults, tables  # noqa: E402

SCENES, DRIVES, LOOSE, EVERY = 2023, 36, 57, 55   # seeds
BODIES = {"material.flexspline_e": (1e11, 3e11), "material.flexspline_nu": (0.1, 0.45), "material.ring_e": (1e11, 3e11), "material.ring_nu": (0.1, 0.45),
          "material.yield_strength": (3e8, 2e9), "material.ring_yield_strength": (3e8, 2e9), "mesh.edge_length": (20e-6, 3e-4),
          "contact.torque_friction": (0.02, 0.8), "contact.zero_pressure": (10, 1e5), "load.support_stiffness": (1, 1e4),
          "wave_generator.cone_angle_deg": (-1, 1), "solver.tolerance": (1e-11, 1e-5),
          "joint.fractal_dimension": (2.4, 2.7), "joint.roughness": (1e-9, 3e-7), "joint.gamma": (1.2, 3), "joint.sample_length": (1e-4, 2e-3),
          "joint.shortest_wavelength": (1e-7, 1e-6), "joint.asperity_radius": (3e-6, 1e-4), "joint.hardness": (1e9, 8e9), "joint.s_min": (1e-16, 1e-13)}
PRESS = BODIES | {"geometry.bore_radius": (14e-3, 21e-3), "geometry.rim_length": (8e-3, 12e-3), "geometry.rim_taper": (2e-4, 3e-3),
                  "geometry.cup_length": (16e-3, 34e-3), "geometry.bottom_thickness": (3e-4, 2e-3), "geometry.hub_radius": (5e-3, 13e-3),
                  "geometry.band_start": (0, 3e-3), "geometry.band_length": (4e-3, 8e-3), "wave_generator.ball_stiffness": (1e6, 1e9),
                  "wave_generator.clearance": (0, 50e-6)}
BUILT = BODIES | {"bearing.inner_conformity": (0.505, 0.6), "bearing.outer_conformity": (0.505, 0.6), "bearing.groove_depth": (2e-5, 4e-4),
                  "bearing.ball_e": (1e11, 3.5e11), "bearing.ball_nu": (0.2, 0.35), "bearing.ball_rate": (1e9, 3e10),
                  "bearing.patch_length": (2e-4, 2e-3), "bearing.patch_width": (2e-4, 1e-3), "load.tooth_phase": (-0.5, 0.5),
                  "wave_generator.arc_angle_deg": (20, 70), "turning.range_deg": (1, 30), "fatigue.tensile_strength": (6e8, 1.5e9),
                  "fatigue.fatigue_limit": (2e8, 6e8), "fatigue.notch_factor": (1, 2), "load.tooth_friction": (0, 0.2)}
OPTIONS = ((0.15, "contact.law", "joint"), (0.1, "wave_generator.shape", "as_formed"), (0.15, "wave_generator.ring_contact", "unilateral"),
           (0.15, "load.torque_load", "teeth"), (0.1, "solver.kinematics", "nonlinear"), (0.2, "contact.slave", "cup"))


def scene(i):
    """Keys of scene i: drawn from its own generator, so a scene stays the same whatever the count."""
    r = np.random.default_rng([SCENES, i])
    divisions, facets = int(r.choice([24, 32, 40])), int(r.integers(3, 7))
    keys = {
        "geometry.wall_thickness": 10 ** r.uniform(-4, np.log10(2e-3)),
        "geometry.ring_thickness": 10 ** r.uniform(-4, np.log10(2e-3)),
        "mesh.divisions": divisions,
        "mesh.band_facets": facets,
        "mesh.wall_elements": 4,
        "mesh.bottom_elements": 3,
        "wave_generator.w": r.uniform(0, 0.4e-3),
        "wave_generator.cam": str(r.choice(["ellipse", "cosine"])),
        "wave_generator.ring_tangent": str(r.choice(["follow", "free"], p=[0.8, 0.2])),  # drawn, then left to the engine
        "wave_generator.eccentricity": float(r.choice([0, 1])) * r.uniform(0, 50e-6),
        "wave_generator.eccentricity_angle_deg": r.uniform(0, 360),
        "wave_generator.interference": float(r.choice([0, 1], p=[0.25, 0.75])) * r.uniform(0, 50e-6),
        "contact.friction": float(r.choice([0, 1], p=[0.1, 0.9])) * r.uniform(0, 1),
        "load.support": str(r.choice(["hub", "bearing"])),
        "load.torque": 10 ** r.uniform(-1, 2) * r.choice([-1, 1]),
        "load.assembly_steps": 2,
        "load.torque_steps": 3,
    }
    keys["geometry.rim_thickness"] = keys["geometry.wall_thickness"] * r.uniform(1, 2)
    if r.random() < 0.3:
        keys["mesh.ring_divisions"] = int(divisions * r.uniform(0.6, 1.5))
        keys["mesh.ring_facets"] = int(r.integers(2, 8))
    for chance, key, value in OPTIONS:
        if (key != "wave_generator.ring_contact" or "wave_generator.shape" not in keys) and r.random() < chance:
            keys[key] = value
    return written(keys) | {"wave_generator.ring_tangent": "auto"}


def cup(r):
    """Keys of a cup by sections: short or long, fillet, tapered wall, bottom inside or flange outside of the bore."""
    bore = 17.5e-3
    rim, wall, bottom = 10 ** r.uniform(-3.7, -3.1), 10 ** r.uniform(-3.8, -3.2), 10 ** r.uniform(-3.7, -2.9)
    end, hat = r.uniform(16e-3, 32e-3), r.random() < 0.5
    hub = r.uniform(23e-3, 30e-3) if hat else r.uniform(5e-3, 12e-3)
    fillet = r.uniform(1.05, 3) * max(wall, bottom) if hat or r.random() < 0.6 else 0
    return {"cup.sections_r": [bore, bore, bore, bore, bore, hub], "cup.sections_z": [0, 9e-3, 10e-3, end, end, end],
            "cup.sections_thickness": [rim, rim, wall, wall, bottom, bottom], "cup.sections_fillet": [0, 0, 0, fillet, 0, 0]}


def written(keys):
    """Six digits of every number, lists as the command takes them."""
    return {k: ",".join(f"{x:.6g}" for x in v) if isinstance(v, list) else float(f"{v:.6g}") if isinstance(v, float) else v
            for k, v in keys.items()}


def drive(i):
    """Keys of drive i."""
    r = np.random.default_rng([DRIVES, i])

    def sometimes(chance, value, other=0.0):
        return value if r.random() < chance else other
    teeth = int(r.choice([100, 160, 200, 320]))
    keys = {
        "mesh.divisions": int(r.choice([24, 32, 40])), "mesh.band_facets": int(r.integers(3, 7)), "mesh.bottom_elements": 4,
        "geometry.band_length": r.uniform(6e-3, 12e-3), "geometry.ring_thickness": 10 ** r.uniform(-3.4, -2.7),
        "wave_generator.w": r.uniform(0.05e-3, 0.45e-3), "wave_generator.cam": str(r.choice(["ellipse", "cosine", "arcs"])),
        "wave_generator.interference": r.choice([0, 1, -1], p=[0.25, 0.6, 0.15]) * r.uniform(0, 40e-6), "wave_generator.clearance": 0.0,
        "wave_generator.eccentricity": sometimes(0.4, r.uniform(0, 50e-6)), "wave_generator.eccentricity_angle_deg": r.uniform(0, 360),
        "bearing.balls": int(r.choice([0, *range(7, 26)])), "bearing.ball_diameter": r.uniform(2e-3, 3.6e-3),
        "bearing.outer_conformity": r.uniform(0.505, 0.6), "bearing.clearance": sometimes(0.5, r.uniform(-10e-6, 60e-6)),
        "bearing.cage_angle_deg": r.uniform(0, 30),
        "contact.friction": sometimes(0.9, r.uniform(0, 0.6)), "load.teeth": teeth,
        "load.tooth_pairs": 2 * int(r.integers(2, teeth // 8)), "load.tooth_stiffness": 10 ** r.uniform(7, 9),
        "load.tooth_clearance": sometimes(0.8, 10 ** r.uniform(-6, -3.7)), "load.tooth_gaps": 0, "load.tooth_gaps_back": 0,
        "load.spline_root_diameter": 0, "load.spline_width": 0, "load.pressure_angle_deg": sometimes(0.9, r.uniform(0, 40)),
        "load.torque": 10 ** r.uniform(-1, 2) * r.choice([-1, 1]), "load.torque_steps": int(r.integers(1, 5)), "load.assembly_steps": 2,
        "loop.torques": [float(f"{v:.4g}") for v in 10 ** r.uniform(-0.5, 1.6) * r.uniform(-1, 1, int(r.integers(2, 5)))],
    }
    if r.random() < 0.5:
        keys |= cup(r)
    else:
        keys |= {"geometry.wall_thickness": 10 ** r.uniform(-3.8, -3.1), "geometry.hub_radius": r.uniform(5e-3, 12e-3),
                 "geometry.cup_length": r.uniform(14e-3, 32e-3)}
        keys["geometry.rim_thickness"] = keys["geometry.wall_thickness"] * r.uniform(1, 1.6)
    if keys["wave_generator.interference"] < 0:
        keys |= {"wave_generator.clearance": -keys["wave_generator.interference"], "wave_generator.interference": 0.0}
    for chance, key, value in ((0.15, "contact.mode", "frictionless"), (0.1, "contact.law", "joint"), (0.2, "contact.slave", "cup"),
                               (0.1, "mesh.element", "hex20r"), (0.15, "solver.method", "newton"), (0.2, "mesh.through_wall", 2)):
        if r.random() < chance:
            keys[key] = value
    keys["bearing.axial_hold"] = "grooves" if r.random() < 0.8 else "fast"
    return written(keys)


def loose(i):
    """Keys of drive i as it is built: lengths in proportion to its bore, the bearing free in the cup by up to 100 um."""
    r = np.random.default_rng([LOOSE, i])

    def sometimes(chance, value, other=0.0):
        return value if r.random() < chance else other
    size, ratio = r.uniform(11, 40), int(r.choice([50, 100, 160]))
    s = size / 14
    wall, rated = r.uniform(0.25e-3, 0.5e-3) * s, 7.8 * s**3
    band = r.uniform(4e-3, 8e-3) * s
    torque = rated * r.uniform(0.1, 2)
    keys = {
        "mesh.divisions": int(r.choice([24, 32, 40, 48])), "mesh.band_facets": int(r.integers(4, 9)),
        "geometry.bore_radius": 17.5e-3 * s, "geometry.rim_length": 9e-3 * s, "geometry.band_start": r.uniform(0, 9e-3 * s - band),
        "geometry.band_length": band, "geometry.ring_thickness": r.uniform(0.5e-3, 1.5e-3) * s, "geometry.wall_thickness": wall,
        "geometry.rim_thickness": wall * r.uniform(1, 1.5), "geometry.rim_taper": 1e-3 * s, "geometry.cup_length": r.uniform(18e-3, 26e-3) * s,
        "geometry.bottom_thickness": r.uniform(0.3e-3, 0.8e-3) * s, "geometry.hub_radius": r.uniform(8e-3, 11.25e-3) * s,
        "wave_generator.w": 0.2e-3 * s * 100 / ratio * r.uniform(0.8, 1.2), "wave_generator.cam": str(r.choice(["ellipse", "cosine", "arcs"])),
        "wave_generator.clearance": r.uniform(0, 100e-6), "wave_generator.eccentricity": sometimes(0.5, r.uniform(0, 20e-6)),
        "wave_generator.eccentricity_angle_deg": r.uniform(0, 360), "bearing.balls": int(r.choice([0, *range(15, 28)])),
        "bearing.ball_diameter": 3.2e-3 * s, "bearing.clearance": sometimes(0.5, r.uniform(-5e-6, 20e-6)),
        "bearing.cage_angle_deg": sometimes(0.5, r.uniform(0, 12)), "contact.friction": r.uniform(0.02, 0.3),
        "load.torque": torque, "load.teeth": 2 * ratio, "load.tooth_pairs": 2 * round(0.2 * ratio), "load.tooth_stiffness": 1.25e8 * s,
        "load.pressure_angle_deg": {50: 30, 100: 20, 160: 20}[ratio], "load.tooth_friction": sometimes(0.3, r.uniform(0.02, 0.15)),
        "load.spline": str(r.choice(["free", "rigid"])), "load.spline_diameter": 50e-3 * s, "load.torque_steps": int(r.integers(4, 7)),
        "loop.history": str(r.choice(["loop", "assembled"])), "loop.torque_1": 0.25 * torque, "loop.torque_2": 0.8 * torque,
        "loop.rated_torque": torque, "load.tooth_gaps": 0, "load.tooth_gaps_back": 0, "load.spline_root_diameter": 0,
        "load.spline_width": 0}
    if r.random() < 0.6:
        pairs = keys["load.tooth_pairs"]
        way = np.tile(abs(np.arange(pairs // 2) + 0.5 - r.uniform(0.3, 0.7) * pairs / 2) / (pairs / 4), 2)
        keys["load.tooth_gaps"] = list(r.uniform(0.3e-6, 3e-6) * s + r.uniform(5e-6, 30e-6) * s * way**2)
        keys["load.tooth_gaps_back"] = sometimes(0.5, list(keys["load.tooth_gaps"][::-1]))
    else:
        keys["load.tooth_clearance"] = r.uniform(0, 40e-6) * s
    keys["solver.kinematics"] = "linear" if r.random() < 0.9 else "nonlinear"
    keys["bearing.axial_hold"] = "grooves" if r.random() < 0.8 else "fast"
    if keys["solver.kinematics"] == "nonlinear":
        keys |= {"load.torque_steps": 2, "loop.torques": [torque, 0]}
    return written(keys)


def varied(base, spans):
    """Keys of `base` on fewer cells, and a fifth of the keys of `spans` that it does not draw."""
    def keys(i):
        r, found = np.random.default_rng([EVERY, i]), base(i)
        found |= {"mesh.divisions": found["mesh.divisions"] // 2 + 4, "mesh.band_facets": min(4, found["mesh.band_facets"])}
        for key, (low, high) in spans.items():
            value = low * (high / low) ** r.random() if low > 0 and high > 4 * low else r.uniform(low, high)
            if r.random() < 0.2 and key not in found:
                found[key] = float(f"{value:.6g}")
        return found
    return keys


def solve(data, keys, limit, threads="1"):
    """Outcome of a run: exit code, message, iterations of each step, seconds, memory, and the faults that its tables show."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        done = subprocess.Popen([program("hdengine.x"), DATA / data, *(f"{k}={v}" for k, v in keys.items()), "output.vtu=none",
                                 "run.band=.false.", f"solver.time_limit_s={limit}", "--out", out, "-q"], stderr=subprocess.PIPE, text=True,
                                env=os.environ | ONE_THREAD | {"OMP_NUM_THREADS": threads})
        with done.stderr:
            message = done.stderr.read().strip()
        done.wait()
        row = {"code": done.returncode, "message": message, "iterations": [], "cut_backs": 0, "faults": []}
        if row["code"] not in (0, 2, 3, 4, 5, 6, 7) or row["code"] and not message:
            row["faults"] = ["an end of no kind"]
        if (out / "summary.json").exists():
            row["results"] = json.loads((out / "summary.json").read_text())["results"]
            row["iterations"] = [int(n) for n in read_csv(out / "steps.csv")["iterations"]] if (out / "steps.csv").exists() else []
            row["cut_backs"] = row["results"].get("cut_backs", 0)
            row["faults"] += faults(*tables(out)) if row["code"] == 0 else []
    return row


def outcome(row):
    """Class of a result."""
    if row["faults"]:
        return "with a fault"
    if row["code"] == 0:
        return "converged"
    words = ("not held", "gross slip", "slip is too large", "does not settle", "time limit", "stopped at a limit", "run in a cycle", "no convergence", "bodies move")
    return next((word for word in words if word in row["message"]), "refused" if row["code"] == 2 else f"code {row['code']}")


def rub(i):
    """Keys of drive i with friction of its flanks."""
    return drive(i) | {"load.tooth_friction": float(f"{np.random.default_rng([DRIVES, i, 1]).uniform(0.02, 0.3):.3g}")}


def pair(i):
    """Faults of press fit i where a second solver, no symmetry or two threads change a result."""
    keys, limit = KINDS["presses"][0](i) | {"solver.tolerance": 1e-10}, 600
    others = {"condensed": {"solver.method": "condensed"}, "exact": {"solver.method": "newton", "solver.factors": "exact"},
              "harmonic": {"solver.method": "newton", "solver.factors": "harmonic"}, "no symmetry": {"solver.symmetry": "full"}, "threads": {}}
    name = list(others)[i % len(others)]
    if name == "condensed":  # which is linear
        keys["solver.kinematics"] = "linear"
    first = solve("paper.nml", keys, limit)
    second = solve("paper.nml", keys | others[name], limit, threads="4" if name == "threads" else "1")
    if second["code"] == 2:   # it does not take this scene
        return second
    if first["code"] != second["code"]:
        first["faults"] += [f"{name}: code {second['code']} beside {first['code']}: {second['message'][:80]}"]
    elif first["code"] == 0:
        close = 0 if name == "threads" else 1e-5 if first["cut_backs"] == second["cut_backs"] else 1e-3  # other steps are another path
        names = ("rotation_rad", "normal_force_n", "contact_area_m2", "pressure_max_pa", "friction_torque_nm")
        a, b = ([row["results"][k] for k in names] for row in (first, second))
        scale = [abs(x) for x in a[:4]] + [abs(keys["load.torque"])]
        first["faults"] += [f"{name}: {x:.8g} beside {y:.8g}" for x, y, s in zip(b, a, scale) if abs(x - y) > close * s]
    return first


KINDS = {"scenes": (scene, 500, 400), "drives": (lambda i: drive(i) | {"solver.kinematics": "linear"}, 300, 600),
         "large": (lambda i: drive(i) | {"solver.kinematics": "nonlinear"}, 30, 120),
         "loose": (loose, 200, 120),
         "rub": (lambda i: rub(i) | {"solver.kinematics": "linear"}, 30, 600),
         "presses": (varied(scene, PRESS), 3600, 120), "built": (varied(loose, BUILT), 400, 120), "pairs": (varied(scene, PRESS), 300, 120)}
NAMES = {"large": "drives, large displacements", "rub": "drives, friction of the flanks", "loose": "drives, bearing free in the cup",
         "presses": "press fits, all keys", "built": "drives as built, all keys", "pairs": "press fits by two solvers"}


def one(kind, i):
    """Solve run i; print what does not converge."""
    keys_of, _, limit = KINDS[kind]
    keys = keys_of(i)
    data = "paper.nml" if kind in ("scenes", "presses") else "drive14_hat.nml" if "cup.sections_r" in keys else "drive14.nml"
    row = pair(i) if kind == "pairs" else solve(data, keys, limit)
    if outcome(row) != "converged":
        print(kind, i, outcome(row), row["message"][:160].replace("\n", " "), row["faults"], flush=True)
    return row


def run(kind, numbers, jobs, minutes):
    """Solve runs, `jobs` at a time, until the time is over."""
    end = time.monotonic() + 60 * minutes
    with ThreadPoolExecutor(jobs) as pool:
        rows = [row for row in pool.map(lambda i: one(kind, i) if time.monotonic() < end else None, numbers) if row]
    steps = [n for row in rows for n in row["iterations"]] or [0]
    return {"count": len(rows), "outcomes": dict(Counter(map(outcome, rows)).most_common()), "iterations_per_step_median": median(steps),
            "iterations_per_step_95": float(np.quantile(steps, 0.95))}


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kinds", nargs="*", choices=[*KINDS, []])
    parser.add_argument("--count", type=int)
    parser.add_argument("--only", type=int)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=1e4)
    args = parser.parse_args()
    for kind in args.kinds or KINDS:
        if args.only is not None:
            print(" ".join(f"'{k}={v}'" for k, v in KINDS[kind][0](args.only).items()))
        found = run(kind, [args.only] if args.only is not None else range(args.count or KINDS[kind][1]), args.jobs, args.minutes)
        print(kind, found, flush=True)
        if args.only is None and args.count is None:
            write_part("random_runs", NAMES.get(kind, kind), found, seed=SCENES, threads=1)


if __name__ == "__main__":
    main()
