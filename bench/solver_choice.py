#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every matrix solver on the same scenes: CPU time, memory, largest difference of a facet's traction, and what was predicted.

One load step of assembly and one of torque, residual 1e-10, one thread. Usage: bench/solver_choice.py [--limit 200];
writes bench/results/solver_choice.json and prints Markdown. --predict only enters new predictions there.
"""
import argparse
import json
import os
import resource
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import hdengine
from common import ROOT, program, read_record, write_record

SOLVERS = {"condensed": ["solver.method=condensed"], "schur": ["solver.method=schur"],
           **{f: ["solver.method=newton", f"solver.factors={f}"] for f in ("harmonic", "single", "symmetric", "exact")}}
FORMED = ["wave_generator.shape=as_formed", "wave_generator.interference=10e-6"]
LARGE = ["solver.kinematics=nonlinear"]


def mesh(divisions, facets):
    """Assignments of a mesh of `divisions` and `facets` along the band."""
    cells = round(13 * facets / 6)
    return [f"mesh.divisions={divisions}", f"mesh.band_facets={facets}", f"mesh.wall_elements={cells}", f"mesh.bottom_elements={cells}"]


SCENES = {
    "pressed": mesh(80, 6),
    "pressed, fine": mesh(160, 12),
    "pressed, eccentric": mesh(80, 6) + ["wave_generator.eccentricity=5e-6", "wave_generator.eccentricity_angle_deg=30"],
    "pressed, two layers": mesh(80, 6) + ["mesh.through_wall=2", "mesh.through_ring=2"],
    "pressed, hex20r": mesh(40, 4) + ["mesh.element=hex20r"],
    "as formed": mesh(80, 6) + FORMED,
    "as formed, fine": mesh(160, 12) + FORMED,
    "large rotations": mesh(80, 6) + LARGE,
    "large rotations, fine": mesh(160, 12) + LARGE,
}


def solve(exe, keys, solver, limit):
    """One run: its figures and its tractions, or None where the solver does not apply or takes too long."""
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        try:
            done = subprocess.run([exe, ROOT / "data/peer_hub.nml", *keys, *SOLVERS.get(solver, []), "load.assembly_steps=1",
                                   "load.torque_steps=1", "solver.tolerance=1e-10", "output.vtu=none", "--out", f"{folder}/o", "-q"],
                                  capture_output=True, env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
                                  preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5)))
        except subprocess.TimeoutExpired:
            return None
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            return None
        r = hdengine.load(f"{folder}/o")
        tractions = np.stack([r.contact[k][-1] for k in ("pressure_pa", "traction_theta_pa", "traction_z_pa")])
        return {"solver": solver, "name": r.summary["model"]["solver"], "dof": r.summary["model"]["dof"],
                "cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
                "memory_mb": r.summary["peak_memory_mb"], "iterations": r.summary["results"]["iterations"],
                "inner_iterations": r.summary["model"]["inner_iterations"], "symmetry": r.summary["model"]["symmetry_torque"],
                "predicted": r.summary.get("predicted"), "tractions": tractions}


def applies(scene, solver):
    """Condensation needs small displacements of round bodies; by Schur complement, small ones of any."""
    round_and_small = not ("as formed" in scene or "large" in scene)
    return {"condensed": round_and_small, "harmonic": not round_and_small, "schur": "large" not in scene}.get(solver, True)


def refresh(exe):
    """Predictions of the installed engine for the recorded rows: runs that stop before their first load step."""
    record = read_record("solver_choice")
    for row in record["rows"]:
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([exe, ROOT / "data/peer_hub.nml", *SCENES[row["scene"]], *SOLVERS[row["solver"]], "solver.time_limit_s=1e-9",
                            "output.vtu=none", "--out", f"{folder}/o", "-q"], capture_output=True)
            row["predicted"] = json.loads(Path(f"{folder}/o/summary.json").read_text())["predicted"]
    write_record("solver_choice", record)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--limit", type=float, default=200, help="CPU seconds of one run")
    parser.add_argument("--predict", action="store_true", help="enter new predictions into the recorded results")
    args = parser.parse_args()
    exe = program("hdengine.x")
    if args.predict:
        refresh(exe)
        return
    rows = []
    print("| scene | dof | solver | CPU s | MB | Newton, inner iterations | difference of tractions |")
    print("|---|---|---|---|---|---|---|")
    for scene, keys in SCENES.items():
        exact = solve(exe, keys, "exact", args.limit)
        for solver in SOLVERS:
            if not applies(scene, solver) or (solver == "schur" and "fine" in scene):
                continue
            row = exact if solver == "exact" else solve(exe, keys, solver, args.limit)
            if row is None:
                continue
            row = dict(row, scene=scene)
            if exact:
                row["difference"] = float(np.max(np.abs(row["tractions"] - exact["tractions"])) / np.max(np.abs(exact["tractions"])))
            row.pop("tractions")
            rows.append(row)
            print(f"| {scene} | {row['dof']} | {solver} | {row['cpu_s']:.1f} | {row['memory_mb']:.0f} | {row['iterations']}, "
                  f"{row['inner_iterations']} | {row.get('difference', float('nan')):.1e} |", flush=True)
    write_record("solver_choice", {"rows": rows})


if __name__ == "__main__":
    main()
