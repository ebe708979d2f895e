#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cost of the scene data/peer_hub.nml over its mesh: harmonics, Schur complement, Newton matrix with exact factors and with single ones.

One load step of assembly and one of torque per mesh, one thread, CPU seconds (they bear a busy machine). A method stops where
its last run lets expect more than the limit, or at its first run beyond it. Usage: bench/cost_over_size.py [--limit 100]
[--most 1e6]; writes bench/results/cost_over_size.json and
docs/figures/cost_over_size.png.
"""
import argparse
import json
import os
import resource
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from common import ROOT, program, write_record

MESHES = [(80, 6), (120, 9), (160, 12), (240, 18), (360, 27), (584, 36), (640, 42), (870, 56)]
METHODS = {"condensed": "harmonics", "exact": "exact factors", "single": "symmetric single factors", "schur": "Schur complement"}
KEYS = {"condensed": ["solver.method=condensed"], "schur": ["solver.method=schur"],
        "exact": ["solver.method=newton", "solver.factors=exact"], "single": ["solver.method=newton", "solver.factors=single"]}


def solve(exe, divisions, facets, method, limit):
    """CPU seconds, peak memory [MB], iterations of one mesh; None past the limit or where memory is refused."""
    ratio = facets / 6
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        try:
            subprocess.run([exe, ROOT / "data/peer_hub.nml", f"mesh.divisions={divisions}", f"mesh.band_facets={facets}",
                            f"mesh.wall_elements={round(13 * ratio)}", f"mesh.bottom_elements={round(13 * ratio)}",
                            *KEYS[method], "load.assembly_steps=1", "load.torque_steps=1", "output.vtu=none",
                            "--out", f"{folder}/o", "-q"], timeout=limit * 3, capture_output=True,
                           env=os.environ | {"OPENBLAS_NUM_THREADS": "1"}, preexec_fn=lambda: resource.setrlimit(
                               resource.RLIMIT_CPU, (int(limit), int(limit) + 5)))
            s = json.loads(Path(f"{folder}/o/summary.json").read_text())
        except (subprocess.TimeoutExpired, FileNotFoundError):
            return None
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if s["code"] != 0:
        return None
    return {"method": method, "divisions": divisions, "facets": s["model"]["facets"], "dof": s["model"]["dof"],
            "cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
            "memory_mb": s["peak_memory_mb"], "iterations": s["results"]["iterations"],
            "inner_iterations": s["model"]["inner_iterations"], "normal_force_n": s["results"]["normal_force_n"]}


def fit(rows, key):
    """Exponent and factor of key ~ dof^a over the meshes from 40 000 dof."""
    rows = [r for r in rows if r["dof"] > 4e4]
    if len(rows) < 2:
        return None
    a, b = np.polyfit(np.log([r["dof"] for r in rows]), np.log([r[key] for r in rows]), 1)
    return float(a), float(np.exp(b))


def draw(rows, path):
    """Time and memory over dof, doubly logarithmic."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import NullFormatter
    fig, axes = plt.subplots(1, 2, figsize=(10, 4.4), constrained_layout=True)
    for ax, key, label in ((axes[0], "cpu_s", "CPU time / s"), (axes[1], "memory_mb", "peak memory / MB")):
        for method, name in METHODS.items():
            mine = [r for r in rows if r["method"] == method]
            if mine:
                a = fit(mine, key)
                ax.loglog([r["dof"] for r in mine], [r[key] for r in mine], "o-",
                          label=name + (f", exponent {a[0]:.2f}" if a else ""))
        ax.set_xlabel("displacement dof")
        ax.set_ylabel(label)
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.grid(True, which="both", alpha=0.3)
        ax.set_ylim(ax.get_ylim()[0], ax.get_ylim()[1] * 30)
        ax.legend(fontsize=11, loc="upper left")
    fig.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--limit", type=float, default=100, help="CPU seconds of one run")
    parser.add_argument("--most", type=float, default=2.1e6, help="largest number of dof")
    args = parser.parse_args()
    exe = program("hdengine.x")
    rows = []
    for method in METHODS:
        for divisions, facets in MESHES:
            mine = [r for r in rows if r["method"] == method]
            if divisions * facets * 41 > args.most:
                break
            if mine and mine[-1]["cpu_s"] * (divisions * facets / mine[-1]["facets"])**1.4 > args.limit:
                break
            row = solve(exe, divisions, facets, method, args.limit)
            if row is None:
                break
            rows.append(row)
            print(method, row["dof"], f"{row['cpu_s']:.1f} s {row['memory_mb']:.0f} MB, {row['iterations']} iterations", flush=True)
    fits = {m: {key: fit([r for r in rows if r["method"] == m], key) for key in ("cpu_s", "memory_mb")} for m in METHODS}
    largest = {m: (16 * 1024 / f["memory_mb"][1])**(1 / f["memory_mb"][0]) for m, f in fits.items() if f["memory_mb"]}
    record = {"threads": 1, "limit_s": args.limit, "rows": rows, "exponent_and_factor": fits,
              "largest_dof_in_16_gib": largest}
    write_record("cost_over_size", record)
    draw(rows, ROOT / "docs/figures/cost_over_size.png")
    for m, f in fits.items():
        print(METHODS[m], f, f"largest in 16 GiB (extrapolated): {largest.get(m, float('nan')):.3g} dof")


if __name__ == "__main__":
    main()
