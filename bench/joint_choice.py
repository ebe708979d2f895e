#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Theory beside boundary elements on maps of few long waves: how far the theory may be trusted there, and whether the planner knows.

maps   eight maps each of D 2.1 to 2.9, roll-off at the map's length, a half and a quarter of it: 256 x 256 points, periodic; and
       maps of 128 x 128 points cut from such of 512 x 512 without roll-off, continued evenly: k_N and contact by boundary elements;
       the surfaces share eight sets of phases
edge   eight other maps of each surface, no two with the same phases, at the lowest pressure at which the planner takes the theory
pages  tables of docs/evidence/joint_choice.md
None of these maps set anything. Writes bench/results/joint_choice.json and joint_choice_edge.json. Usage: bench/joint_choice.py [maps] [edge] [pages]
"""
import sys

import numpy as np
from joint_law import CONTACT, E_STAR, lattice, pressures, rough, scaled

from common import put, read_record, table, write_record
from hdengine.elastic import moduli, stiffness_from_spectrum
from hdengine.prediction.choice import TRUST, scatter_of
from hdengine.prediction.half_space import HalfSpace, corrected_area, mirrored, tamaas
from hdengine.prediction.spectrum import level, of_map

RATIO = moduli(209e9, 0.295, 219e9, 0.30)[1]
DX = (1e-6, 1e-6)
KINDS = [(d, n) for d in (2.1, 2.3, 2.5, 2.7, 2.9) for n in (1, 2, 4)] + [(d, "cut") for d in (2.1, 2.5, 2.9)]
NAMES = {1: "none", 2: "1/2", 4: "1/4", "cut": "cut out"}
SEEDS = range(3001, 3009)
EDGE = 4001      # seed of the first map at the edge of the rule


def surface(d, kind, seed):
    """Map that the planner sees [m], periodic map for boundary elements, spectrum of it."""
    if kind == "cut":
        z = level(1e-7 * rough(512, 3 - d, 512, 6, seed)[:128, :128])[0]
        return z, mirrored(z), of_map(z, DX)[0]
    z = 1e-7 * rough(256, 3 - d, 256 / kind, 6, seed)
    return z, z, scaled(lattice(z))


def solve(z, pressure):
    """Boundary elements: pressure, k_N, true contact."""
    space, rows = HalfSpace(z, DX, E_STAR, RATIO), []
    for p in pressure:
        touching = space.press(p) > 0
        rows.append([float(f"{x:.5g}") for x in (p, space.normal_stiffness(touching), corrected_area(touching))])
    return dict(zip(("pressure_pa", "k_n_pa_per_m", "contact"), zip(*rows)))


def maps():
    """All maps; the record is written after each surface."""
    rows = []
    for d, kind in KINDS:
        for seed in SEEDS:
            _, z, spectrum = surface(d, kind, seed)
            rows.append({"fractal_dimension": d, "kind": kind, "seed": seed, **solve(z, pressures(spectrum.slope_rms, CONTACT))})
        write_record("joint_choice", {"maps": rows}, seed=list(SEEDS), peers=(tamaas(),))
        print(rows[-1], flush=True)


def edge():
    """Boundary elements where the planner begins to take the theory, below half of full contact."""
    rows, seed = [], EDGE
    for d, kind in KINDS:
        for _ in SEEDS:
            seen, z, spectrum = surface(d, kind, seed)
            waves = of_map(seen, DX)[0].waves
            share = np.geomspace(1e-4, 0.5, 400)
            first = share[1.96 * scatter_of(share, waves) <= TRUST][:1]
            rows.append({"fractal_dimension": d, "kind": kind, "seed": seed, "independent_waves": round(waves, 2),
                         **(solve(z, pressures(spectrum.slope_rms, first)) if first.size else {})})
            print(rows[-1], flush=True)
            seed += 1
    write_record("joint_choice_edge", rows, seed=EDGE, peers=(tamaas(),))


def judged(row):
    """Logarithm of k_N by theory over boundary elements, and whether the planner takes the theory: now, and by the rule of 3 %."""
    seen, _, spectrum = surface(row["fractal_dimension"], row["kind"], row["seed"])
    k, area = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, np.array(row["pressure_pa"]), E_STAR)
    own, facts = of_map(seen, DX)
    return (np.log(k / row["k_n_pa_per_m"]), 1.96 * scatter_of(area, own.waves) <= TRUST, area >= (1e-3 if facts["rolls_off"] else 0.03),
            own.waves)


def pages():
    """Tables of the page."""
    found, edges = read_record("joint_choice")["maps"], [r for r in read_record("joint_choice_edge") if "contact" in r]
    contact = 100 * np.mean([r["contact"] for r in found], axis=0)
    rows, counts = [], {}
    for d, kind in KINDS:
        those = [r for r in found if (r["fractal_dimension"], r["kind"]) == (d, kind)]
        logs, new, old, waves = (np.array(x) for x in zip(*(judged(r) for r in those)))
        ends = np.array([judged(r)[0][0] for r in edges if (r["fractal_dimension"], r["kind"]) == (d, kind)])
        mean, spread = np.exp(logs.mean(0)), logs.std(0, ddof=1)
        cells = [f"{m:.2f} ± {2 * m * s / len(those) ** 0.5:.2f} ({100 * s:.0f} %)" for m, s in zip(mean, spread)]
        rows.append((f"{d}, {NAMES[kind]}", f"{np.median(waves):.0f}",
                     *(f"**{c}**" if n > 0.5 else c for c, n in zip(cells, new.mean(0)))))
        for name, errors in (("new", np.exp(logs[new]) - 1), ("edge", np.exp(ends) - 1), ("old", np.exp(logs[old]) - 1)):
            counts.setdefault((kind, name), []).extend(abs(errors))
    head = ("D, roll-off over the map", "waves", *(f"{c:.0f} %" if c > 3 else f"{c:.1f} %" for c in contact))
    put("joint-seeds", table(head, [r for r in rows if r[0][:3] in ("2.1", "2.5", "2.9")]), "evidence/joint_choice")

    def line(name, kinds):
        e = np.array(sum((counts[kind, name] for kind in kinds), []))
        return (str(len(e)), f"{100 * (e < 0.25).mean():.0f} %", f"{100 * (e < 0.10).mean():.0f} %", f"{100 * e.max():.0f} %")

    errors = read_record("joint_law_training")["errors_of_used"]
    put("joint-touching", table(("touching waves A N", *(f"{r['touching_waves']:g}" for r in errors)), [
        ("rms error of k_N / %", *(f"{100 * r['rms_ln_error']:.0f}" for r in errors))]), "evidence/joint_choice")
    every = [([k], NAMES[k]) for k in NAMES] + [(list(NAMES), "all")]
    put("joint-choice", table(("rule", "roll-off over the map", "pressures", "within 25 %", "within 10 %", "largest error"), [
        (rule, label, *line(name, kinds)) for rule, name, rows in (
            ("touching waves", "new", every), ("at its edge", "edge", every), ("roll-off or 3 %", "old", [every[0], every[-1]]))
        for kinds, label in rows]), "evidence/joint_choice")


def main():
    todo = sys.argv[1:] or ["maps", "edge", "pages"]
    for name, call in (("maps", maps), ("edge", edge), ("pages", pages)):
        if name in todo:
            call()


if __name__ == "__main__":
    main()
