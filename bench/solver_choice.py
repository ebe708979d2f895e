#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every matrix solver on the same scenes: CPU time and memory beside what was predicted; tests/python/test_solver_choice.py compares them.

One load step of assembly and one of torque, residual 1e-10, one thread. Usage: bench/solver_choice.py [--quick | --predict]; writes
bench/results/solver_choice.json. --quick takes the coarse scenes and writes nothing, --predict only enters new predictions.
"""
import sys

from common import read_record, solve, write_record

SOLVERS = {"condensed": ["solver.method=condensed"], **{f: ["solver.method=newton", f"solver.factors={f}"] for f in ("harmonic", "exact")}}
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


def run(scene, solver, *more):
    """Summary and command of a scene by a solver."""
    return solve("peer_hub.nml", *SCENES[scene], *SOLVERS[solver], "load.assembly_steps=1", "load.torque_steps=1", "solver.tolerance=1e-10", *more, limit=200)


def predicted(summary, solver):
    """Predicted time and memory of a solver."""
    return {f"predicted_{k}": float(f"{summary['predicted'][f'{solver}_{k}']:.4g}") for k in ("s", "mb")}


def main(words):
    """Measure, or predict anew."""
    if "--predict" in words:
        rows = [row | predicted(run(row["scene"], row["solver"], "solver.time_limit_s=1e-9")[0], row["solver"]) for row in read_record("solver_choice")]
    else:
        rows = []
        for scene in [s for s in SCENES if "fine" not in s or "--quick" not in words]:
            for solver in ("harmonic" if "formed" in scene or "large" in scene else "condensed", "exact"):   # condensation needs small displacements of round bodies
                summary, done = run(scene, solver)
                rows.append({"scene": scene, "solver": solver, "cpu_s": float(f"{done.cpu_s:.3g}"),
                             "memory_mb": float(f"{summary['peak_memory_mb']:.3g}")} | predicted(summary, solver))
                print(rows[-1], flush=True)
    if "--quick" not in words:
        write_record("solver_choice", rows, threads=1)


if __name__ == "__main__":
    main(sys.argv[1:])
