#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Order of convergence of the whole scene: q(h) = q_0 + C h^p fitted to meshes refined in all directions of the surface.

Writes bench/results/mesh_orders.json and docs/figures/mesh_orders.png, prints Markdown.
"""
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

import hdengine  # noqa: E402
from common import ROOT, program, read_record, write_record

EXE = program("hdengine.x")

QUANTITIES = {"normal_force_n": "normal force", "rotation_rad": "rotation", "contact_area_m2": "contact area",
              "pressure_mid_mean_pa": "mid-band pressure", "profile": "mid-band profile"}
# rows of facets and cells behind the band as long as 1 mm / k: cells end where the rim's taper does
KEYS = ["mesh.wall_elements=0", "mesh.bottom_elements=0"]
# a section whose corners, and the middle fifth of whose band, lie on a grid of 1.2 mm: they are nodes of every mesh; cells at the
# edges of the band fall with the square of the others, as the edge asks for
GRID = ["geometry.band_start=1.2e-3", "geometry.rim_length=7.2e-3", "geometry.rim_taper=1.2e-3", "geometry.cup_length=19.6e-3",
        "geometry.hub_radius=8.2e-3"]
CASES = {"HUB, hex8i": ([(60, 6, 1), (120, 12, 1), (180, 18, 1), (240, 24, 1)], KEYS),
         "HUB, hex20r": ([(30, 6, 1), (60, 12, 1), (90, 18, 1), (120, 24, 1)], KEYS + ["mesh.element=hex20r"]),
         "grid, hex8i, layers and edges too": ([(32 * k, 5 * k, k) for k in (2, 3, 4, 5, 6, 8)], GRID)}


def solve(divisions, facets, layers, keys):
    """Results and size of a run, pressure of the band's middle fifth by column of facets / Pa."""
    if keys is GRID:
        keys = [*keys, f"mesh.wall_elements={2 * facets}", f"mesh.bottom_elements={8 * facets // 5}", f"mesh.edge_length={0.3e-3 / layers**2}"]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        subprocess.run([EXE, ROOT / "data/peer_hub.nml", f"mesh.divisions={divisions}", f"mesh.band_facets={facets}", f"mesh.through_ring={layers}",
                        f"mesh.through_wall={layers}", *keys, "output.vtu=none", "--out", out, "-q"], check=True)
        results = hdengine.load(out)
    area, pressure = (results.contact[k][-1].reshape(divisions, -1) for k in ("area_m2", "pressure_pa"))
    end = np.cumsum(area[0]) / area[0].sum()
    rows = np.clip(np.minimum(end, 0.6) - np.maximum(end - area[0] / area[0].sum(), 0.4), 0, None)
    return results.summary, pressure @ rows / rows.sum()


def fit(h, q):
    """Limit, order and rms misfit (relative) of q_0 + C h^p, p in 0.3 to 4; q (meshes) or, for a profile, (meshes, values)."""
    best = None
    for p in np.linspace(0.3, 4, 371):
        a = np.c_[np.ones_like(h), h**p]
        c, *_ = np.linalg.lstsq(a, q, rcond=None)
        misfit = np.sqrt(np.mean((a @ c - q) ** 2) / np.mean(c[0] ** 2))
        if best is None or misfit < best[2]:
            best = (c[0], float(p), float(misfit))
    return best


def shown(order):
    """Order of a fit; at a bound of the search there is none."""
    return f"order {order:.1f}" if 0.3 < order < 4 else "no order"


def draw(record, path):
    """Distance from the fitted limits over the divisions, one panel per series."""
    fig = plt.figure(figsize=(7.5, 14), layout="constrained")
    axes = fig.subplots(len(record), 1)
    for ax, (name, series) in zip(axes, record.items()):
        ticks = [r["divisions"] for r in series["rows"]]
        for key, label in QUANTITIES.items():
            f = series["fits"][key]
            ax.plot(ticks, 100 * np.array(f["away"]), "o-" if 0.3 < f["order"] < 4 else "o:", label=f"{label}, {shown(f['order'])}")
        ax.set(xscale="log", yscale="log", xlabel="divisions of the circumference", title=name, ylim=(2e-3, 200))
        ax.set_xticks(ticks, [str(t) for t in ticks])
        ax.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
        ax.grid(alpha=0.3)
        ax.set_ylabel("distance from the fitted limit / %")
        ax.legend(fontsize=10, loc="lower left")
    fig.savefig(path, dpi=100)


def main():
    """Command line; --redraw makes the figure from the record."""
    if sys.argv[1:] == ["--redraw"]:
        draw(read_record("mesh_orders"), ROOT / "docs/figures/mesh_orders.png")
        return
    record = {}
    print("| scene | quantity | coarse to fine | limit | order | rms misfit |\n|---|---|---|---|---|---|")
    for name, (meshes, keys) in CASES.items():
        rows, columns = [], math.gcd(*(m[0] for m in meshes))
        for mesh in meshes:
            s, profile = solve(*mesh, keys)
            rows.append({"divisions": mesh[0], "band_facets": mesh[1], "layers": mesh[2], "dof": s["model"]["dof"],
                         "iterations": s["results"]["iterations"], **{k: s["results"][k] for k in list(QUANTITIES)[:-1]},
                         "profile": list(profile.reshape(columns, -1).mean(1))})
        h = np.array([1 / r["divisions"] for r in rows])
        record[name] = {"rows": rows, "fits": {}}
        for key, label in QUANTITIES.items():
            q = np.array([r[key] for r in rows])
            limit, order, misfit = fit(h, q)
            away = np.linalg.norm((q - limit).reshape(len(h), -1), axis=1) / np.linalg.norm(limit)
            record[name]["fits"][key] = {"limit": np.asarray(limit).tolist(), "order": order, "misfit": misfit, "away": away.tolist()}
            values, end = (", ".join(f"{v:.2%}" for v in away), "") if key == "profile" else (", ".join(f"{v:.5g}" for v in q), f"{limit:.5g}")
            print(f"| {name} | {label} | {values} | {end} | {shown(order)} | {misfit:.2%} |", flush=True)
    write_record("mesh_orders", record)
    draw(record, ROOT / "docs/figures/mesh_orders.png")


if __name__ == "__main__":
    main()
