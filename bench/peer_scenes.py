#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The press-fit scenes HUB, FREE, INT and HUB on meshes that do not match: iterations over 8 increments, cut-backs, results.

FREE is also driven past what friction holds: the slip torque and its bracket. Usage: bench/peer_scenes.py [--divisions 80];
writes bench/results/peer_scenes.json, prints Markdown. The figures of CalculiX for the same scenes: docs/evidence/contact_scene.md.
"""
import argparse
import json
import re
import subprocess
import tempfile
from pathlib import Path

from common import ROOT, program, write_record

EXE = program("hdengine.x")
FREE = ["load.support=bearing", "load.support_stiffness=100"]
SCENES = {
    "HUB": [],
    "FREE": FREE,
    "INT": [*FREE, "wave_generator.interference=10e-6"],
    "HUB, ring 4/5 of the divisions": ["ring"],
    "INT, ring 4/5 of the divisions": [*FREE, "wave_generator.interference=10e-6", "ring"],
    "HUB, rough joint": ["contact.law=joint"],
    "HUB, large rotations": ["solver.kinematics=nonlinear"],
    "INT, large rotations": [*FREE, "wave_generator.interference=10e-6", "solver.kinematics=nonlinear"],
    "FREE, 20 N m": [*FREE, "load.torque=20", "load.torque_steps=8"],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--divisions", type=int, default=80)
    args = parser.parse_args()
    rows = []
    print("| scene | code | Newton iterations | cut-backs | rotation by 5 N m / µrad | normal force / N | capacity / N m |\n"
          + "|---" * 7 + "|")
    for name, keys in SCENES.items():
        keys = [f"mesh.ring_divisions={args.divisions * 4 // 5}" if k == "ring" else k for k in keys]
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "run.out"
            done = subprocess.run([EXE, ROOT / "data/peer_hub.nml", f"mesh.divisions={args.divisions}", *keys, "output.vtu=none",
                                   "--out", out, "-q"], capture_output=True, text=True)
            s = json.loads((out / "summary.json").read_text())
        r = s["results"]
        rows.append({"scene": name, "keys": keys, "code": done.returncode, "message": s["message"], "solver": s["model"]["solver"],
                     "total_s": s["timers_s"]["total"], "results": r})
        print(f"| {name} | {done.returncode} | {r['iterations']} | {r['cut_backs']} | {1e6 * r['rotation_rad']:.3f} | "
              f"{r['normal_force_n']:.1f} | {r['friction_capacity_nm']:.3f} |", flush=True)
        if found := re.search(r"gross slip at T = (\S+)", s["message"]):
            print(f"slip of {name}: {found.group(1)} N m, last equilibrium {-r['friction_torque_nm']:.4f} N m")
    write_record("peer_scenes", rows)


if __name__ == "__main__":
    main()
