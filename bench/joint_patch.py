#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Free patches beside periodic maps, by boundary elements: how much the edge changes k_N once the patch's own bulk is taken off.

periodic  generated periodic maps of 128 x 128 points, D 2.1 to 2.9, roll-off at 1/16 and 1/6 of the map and none: the same map as a free patch
measured  maps of a folder, their first 128 x 128 points, continued evenly and as a free patch
Writes bench/results/joint_patch.json and the tables of docs/evidence/joint_patch.md. Usage: bench/joint_patch.py --surfaces FOLDER | --pages
"""
import argparse
from pathlib import Path

import numpy as np
from joint_law import E_STAR, MEASURED, RATIO, pressures, rough

from common import put, read_record, table, write_record
from hdengine.prediction.half_space import HalfSpace, mirrored, tamaas
from hdengine.prediction.spectrum import level, of_map

POINTS, CONTACT, SEEDS = 128, (0.001, 0.003, 0.01, 0.03, 0.1, 0.3), (5001, 5002, 5003, 5004)
SHARES = (0, 0.3, 0.6, 0.8, 0.9, 0.95, 1)


def compare(z, spacing, slope, continued):
    """k_N of a map continued (or periodic) and of the same map as a free patch, at each contact."""
    spaces, rows = (HalfSpace(continued, spacing, E_STAR, RATIO), HalfSpace(z, spacing, E_STAR, RATIO, free=True)), []
    for p in pressures(slope, CONTACT):
        (a, k), (b, patch) = ((touching.mean(), s.normal_stiffness(touching)) for s in spaces for touching in [s.press(p) > 0])
        row = {"pressure_pa": p, "contact": a, "contact_free": b, "k_n": k, "k_n_free": patch, "bulk_share": patch / (patch + spaces[1].bulk)}
        rows.append({name: float(f"{v:.5g}") for name, v in row.items()})
    return rows


def solve(folder):
    """All maps."""
    found = []
    for d in (2.1, 2.5, 2.9):
        for over, name in ((16, "1/16"), (6, "1/6"), (1, "none")):
            for seed in SEEDS:
                z = 1e-7 * rough(POINTS, 3 - d, POINTS / over, 6, seed)
                rows = compare(z, (1e-6, 1e-6), 0.1, z)
                found.append({"surface": f"D {d}, roll-off {name}", "seed": seed, "rows": rows})
                print(found[-1]["surface"], [round(r["k_n_free"] / r["k_n"], 3) for r in rows], flush=True)
    for name, unit in MEASURED.items():
        from hdengine.surfaces import specimen

        s = specimen.read(Path(folder) / name, unit)
        z = level(s.heights)[0][:POINTS, :POINTS]
        rows = compare(z, s.spacing, of_map(z, s.spacing)[1]["slope_rms"], mirrored(z))
        found.append({"surface": f"{name} (measured)", "rows": rows})
        print(name, [round(r["k_n_free"] / r["k_n"], 3) for r in rows], flush=True)
    write_record("joint_patch", {"e_star_pa": E_STAR, "surfaces": found}, seed=list(SEEDS), peers=(tamaas(),))


def pages():
    """Tables by the share of the bulk, and of the measured maps."""
    surfaces, out = read_record("joint_patch")["surfaces"], []
    for kind, ends in (("1/16, 1/6", ("1/16", "1/6")), ("none", ("none",))):
        rows = [r for s in surfaces if s["surface"].endswith(ends) for r in s["rows"]]
        for low, high in zip(SHARES, SHARES[1:]):
            some = [r for r in rows if low <= r["bulk_share"] < high]
            e, left = np.array([r["k_n_free"] / r["k_n"] for r in some]), np.array([1 - r["bulk_share"] for r in some])
            out.append((kind, f"{100 * low:.0f} to {100 * high:.0f}", len(e), f"{np.exp(np.log(e).mean()):.2f}", f"{e.min():.2f} to {e.max():.2f}",
                        f"{(left * e).min():.2f} to {(left * e).max():.2f}"))
    put("joint-patch", table(("roll-off over the map", "share of the bulk / %", "pressures", "mean", "range", "range with the bulk left in"), out),
        "evidence/joint_patch")
    names = [s for s in surfaces if "measured" in s["surface"]]
    put("joint-patch-measured", table(("map", "what", *(f"{100 * c:g} %" for c in CONTACT)), [
        (s["surface"].split(" (")[0], what, *(show(r) for r in s["rows"])) for s in names for what, show in (
            ("k_N free over continued", lambda r: f"{r['k_n_free'] / r['k_n']:.2f}"), ("share of the bulk / %", lambda r: f"{100 * r['bulk_share']:.0f}"),
            ("contact free over continued", lambda r: f"{r['contact_free'] / r['contact']:.2f}"))]), "evidence/joint_patch")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--surfaces", default="surfaces", help="folder with the measured maps")
    parser.add_argument("--pages", action="store_true", help="tables from the record")
    args = parser.parse_args()
    if not args.pages:
        solve(args.surfaces)
    pages()


if __name__ == "__main__":
    main()
