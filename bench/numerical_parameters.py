#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotation of HUB and FREE over two decades of every numerical parameter: keys of the scene, and constants of the source in a copy built anew.

Usage: bench/numerical_parameters.py (needs meson, ninja and the compiler; some ten minutes). Writes bench/results/numerical_parameters.json and
prints Markdown.
"""
import json
import shutil
import subprocess
import tempfile
from pathlib import Path

from common import ROOT, program, write_record

EXE = program("hdengine.x")


SCENE = ["mesh.divisions=40", "load.assembly_steps=4", "load.torque_steps=10", "output.vtu=none"]
KEYS = {"solver.tolerance": (1e-7, 1e-8, 1e-9), "solver.max_iterations": (20, 60, 600), "load.support_stiffness": (10, 100, 1000)}
STEPS = {"load.torque_steps": (5, 10, 50), "load.assembly_steps": (1, 4, 40)}
CONSTANTS = {  # name: file, text, value
    "c of the semi-smooth law": ("fortran/drive/hd_drive.f90", "law%scale = sqrt(", "law%scale = {f}*sqrt("),
    "reach of the turning slip": ("fortran/interface/hd_contact_law.f90", "reach = 10 ", "reach = 10*{f} "),
    "accuracy of GMRES": ("fortran/contact/hd_newton.f90", "1e-5_dp, search)", "1e-5_dp*{f}, search)"),
    "refinement from": ("fortran/contact/hd_checked_solve.f90", "refine_above = 1e-4_dp", "refine_above = 1e-4_dp*{f}"),
    "iterations before the line search": ("fortran/contact/hd_newton.f90", "full_steps = 12 ", "full_steps = nint(12*{f}) "),
    "softest friction": ("fortran/contact/hd_newton.f90", "softest = 100 ", "softest = 100*{f} "),
}


def rotation(exe, *keys):
    """Rotation [rad], iterations, exit code."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        done = subprocess.run([exe, ROOT / "data/peer_hub.nml", *SCENE, *keys, "--out", out, "-q"], capture_output=True, text=True)
        r = json.loads((out / "summary.json").read_text())["results"]
        return r["rotation_rad"], r["iterations"], done.returncode


def row(record, name, values, runs):
    """Book and print one parameter."""
    hub, free = ([r[i] for r in runs] for i in (0, 1))
    change = [max(abs(r[0] / scene[1][0] - 1) for r in scene) for scene in (hub, free)]
    record.append({"parameter": name, "values": values, "hub": hub, "free": free, "change": change})
    its = [" / ".join(str(r[1]) for r in scene) for scene in (hub, free)]
    print(f"| {name} | {', '.join(f'{v:g}' for v in values)} | {100 * change[0]:.2g} % | {100 * change[1]:.2g} % | {its[0]} | {its[1]} |", flush=True)


def both(exe, *keys):
    """HUB and FREE."""
    return rotation(exe, *keys), rotation(exe, *keys, "load.support=bearing")


def main():
    record = []
    print("| parameter | values | HUB: rotation | FREE | HUB: iterations | FREE |\n|---|---|---|---|---|---|")
    for name, values in {**KEYS, **STEPS}.items():
        row(record, name, values, [both(EXE, f"{name}={v}") for v in values])
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "hdengine"
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".git", "build*", ".venv", "docs", "bench", "__pycache__"))
        subprocess.run(["meson", "setup", "build", "-Dpython=false"], cwd=copy, check=True, capture_output=True)
        for name, (file, old, new) in CONSTANTS.items():
            path, runs = copy / file, []
            text = path.read_text()
            assert old in text, (file, old)
            for f in (0.1, 1, 10):
                path.write_text(text.replace(old, new.format(f=f"{f:.1f}d0")))
                subprocess.run(["ninja", "-C", "build", "fortran/app/hdengine.x"], cwd=copy, check=True, capture_output=True)
                runs.append(both(copy / "build/fortran/app/hdengine.x"))
            path.write_text(text)
            row(record, name + " (times)", (0.1, 1, 10), runs)
    write_record("numerical_parameters", record)


if __name__ == "__main__":
    main()
