#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Order of convergence of the whole scene: q(h) = q_0 + C h^p fitted to meshes refined in all directions of the surface.

Writes bench/results/mesh_orders.json and docs/figures/mesh_orders.png, prints Markdown.
"""
import json
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

sys.path.insert(0, str(Path(__file__).parent))
from scene_tables import ROOT, solve  # noqa: E402

QUANTITIES = {"normal_force_n": "normal force", "rotation_rad": "rotation", "contact_area_m2": "contact area",
              "pressure_mid_mean_pa": "mid-band pressure"}
# rows of facets and cells behind the band as long as 1 mm / k: cells end where the rim's taper does
KEYS = ["mesh.wall_elements=0", "mesh.bottom_elements=0"]
CASES = {"HUB, hex8i": ([(60, 6), (120, 12), (180, 18), (240, 24)], KEYS),
         "HUB, hex8i, two layers": ([(60, 6), (120, 12), (180, 18)], KEYS + ["mesh.through_ring=2", "mesh.through_wall=2"]),
         "HUB, hex20r": ([(30, 6), (60, 12), (90, 18)], KEYS + ["mesh.element=hex20r"])}


def fit(h, q):
    """Limit, order and rms misfit (relative) of q_0 + C h^p, p in 0.3 to 4."""
    best = None
    for p in np.linspace(0.3, 4, 371):
        a = np.c_[np.ones_like(h), h**p]
        c, *_ = np.linalg.lstsq(a, q, rcond=None)
        misfit = np.sqrt(np.mean((a @ c - q) ** 2)) / abs(c[0])
        if best is None or misfit < best[2]:
            best = (float(c[0]), float(p), float(misfit))
    return best


def main():
    record, fig = {}, plt.figure(figsize=(13, 4.2), layout="constrained")
    axes = fig.subplots(1, len(CASES))
    print("| scene | quantity | " + "coarse to fine | limit | order | rms misfit |\n|---|---|---|---|---|---|")
    for ax, (name, (meshes, keys)) in zip(axes, CASES.items()):
        rows = []
        for divisions, facets in meshes:
            s, code = solve("peer_hub.nml", f"mesh.divisions={divisions}", f"mesh.band_facets={facets}", *keys)
            rows.append({"divisions": divisions, "band_facets": facets, "dof": s["model"]["dof"], "code": code,
                         **{k: s["results"][k] for k in QUANTITIES}})
        h = np.array([1 / r["divisions"] for r in rows])
        record[name] = {"rows": rows, "fits": {}}
        for key, label in QUANTITIES.items():
            q = np.array([r[key] for r in rows])
            limit, order, misfit = fit(h, q)
            record[name]["fits"][key] = {"limit": limit, "order": order, "misfit": misfit}
            print(f"| {name} | {label} | " + ", ".join(f"{v:.5g}" for v in q) + f" | {limit:.5g} | {order:.1f} | {100 * misfit:.2f} % |", flush=True)
            ax.plot([r["divisions"] for r in rows], 100 * np.abs(q / limit - 1), "o-", label=f"{label}, order {order:.1f}")
        ticks = [r["divisions"] for r in rows]
        ax.set(xscale="log", yscale="log", xlabel="divisions of the circumference", title=name)
        ax.set_xticks(ticks, [str(t) for t in ticks])
        ax.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
        ax.legend(fontsize=8)
    axes[0].set_ylabel("distance from the fitted limit / %")
    fig.savefig(ROOT / "docs/figures/mesh_orders.png", dpi=100)
    (ROOT / "bench/results/mesh_orders.json").write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
