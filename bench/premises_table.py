#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Three scenes over w, torque, eccentricity and friction: by c6eee82, by this engine with the ring held, and with the ring sliding. Writes
bench/results/premises_table.json and a table of docs/notebook/2026-11-24-cam-and-load-path.md.

Usage: bench/premises_table.py OLD   (OLD: a tree of c6eee82, built in its folder build)
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from which_k_ts import SEVENTEEN

from common import ROOT, program, put, table, write_record

EXE = program("hdengine.x")
MESH = ("mesh.divisions=48", "mesh.band_facets=8", "mesh.wall_elements=0", "mesh.bottom_elements=0", "load.torque=5")
SCENES = {"CD-14-100": ("cd14.nml", 200e-6, ()), "HUB": ("peer_hub.nml", 200e-6, ()),
          "CD-17-100": ("cd14.nml", SEVENTEEN["wave_generator.w"], tuple(f"{k}={v}" for k, v in SEVENTEEN.items() if not k.endswith(".w")))}
VARIED = {"as it is": (1, ()), "w / 2": (0.5, ()), "1.5 w": (1.5, ()), "T = 1 N m": (1, ("load.torque=1",)), "T = 20 N m": (1, ("load.torque=20",)),
          "e = 10 µm": (1, ("wave_generator.eccentricity=1e-5",)), "µ = 0.05": (1, ("contact.friction=0.05",)), "µ = 0.3": (1, ("contact.friction=0.3",))}
VALUES = {"N / N": ("normal_force_n", 1, ".0f"), "area / mm²": ("contact_area_m2", 1e6, ".0f"), "peak / MPa": ("pressure_max_pa", 1e-6, ".0f"),
          "mid-band / MPa": ("pressure_mid_mean_pa", 1e-6, ".2f"), "rotation / µrad": ("rotation_rad", 1e6, ".1f"),
          "Eq. 45": ("k_ts_nm_per_rad", 1e-6, ".2f"), "tangent": ("k_ts_tangent_nm_per_rad", 1e-6, ".3f"),
          "secant": ("k_ts_secant_nm_per_rad", 1e-6, ".3f"), "T over rotation": ("k_fe_secant_nm_per_rad", 1e-6, ".3f")}


def solve(exe, tree, scene, *words):
    """Results of a run and its exit code."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        done = subprocess.run([exe, tree / "data" / scene, *words, "output.vtu=none", "--out", out, "-q"], capture_output=True, text=True)
        return json.loads((out / "summary.json").read_text())["results"] | {"code": done.returncode}


def main():
    """Solve all, write record and table."""
    old = Path(sys.argv[1]).resolve()
    rows, facts = [], []
    for scene, (path, w, keys) in SCENES.items():
        for what, (factor, more) in VARIED.items():
            words = (*keys, *MESH, f"wave_generator.w={factor * w:.9g}", *more)
            runs = [solve(old / "build/fortran/app/hdengine.x", old, path, *words), *(solve(EXE, ROOT, path, *words, f"wave_generator.ring_tangent={t}") for t in ("follow", "auto"))]
            facts.append({"scene": scene, "variation": what, **dict(zip(("before", "held", "sliding"), runs))})
            rows.append([scene, what, *(" / ".join(format(f * r[k], form) for r in runs if r.get(k) is not None) for k, f, form in VALUES.values())])
    write_record("premises_table", facts)
    parts = [table(("scene", "", *[*VALUES][part]), [r[:2] + r[2:][part] for r in rows]) for part in (slice(4), slice(4, None))]
    put("before and after", "\n\n".join(parts), "notebook/2026-11-24-cam-and-load-path")


if __name__ == "__main__":
    main()
