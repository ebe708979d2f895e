#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Theory beside boundary elements on maps of few long waves: how far the theory may be trusted there, and whether the planner knows.

maps   eight maps each of D 2.1 to 2.9, roll-off at the map's length, a half and a quarter of it: 256 x 256 points, periodic; and
       maps of 128 x 128 points cut from such of 512 x 512 without roll-off, continued evenly: k_N and contact by boundary elements;
       the surfaces share eight sets of phases
edge   eight other maps of each surface, no two with the same phases, at the lowest pressure at which the planner takes the theory
fewer  boundary elements on averaged maps, with and without the theory of the waves that averaging takes; seeds 3001 to 3004 set `patches.COARSE`
large  the same on maps of 1024 x 1024 points at 3 % of contact: error and processor time
ring   laws and bands from a patch of 64 x 64 points for the whole map of 16 such patches, by boundary elements on all of it
pages  tables of docs/evidence/joint_choice.md, joint_fewer.md, figure joint_scatter
None of these maps set anything else. Writes bench/results/joint_choice.json, joint_choice_edge.json, joint_fewer.json, joint_large.json, joint_ring.json.
Usage: bench/joint_choice.py [maps] [edge] [fewer] [large] [ring] [pages]
"""
import sys
import time

import numpy as np
from joint_law import CONTACT, E_STAR, lattice, pressures, rough, scaled

from common import new_axes, put, read_record, save_figure, styled, table, write_record
from hdengine.elastic import moduli, stiffness_from_spectrum
from hdengine.prediction.bodies import Bodies
from hdengine.prediction.choice import TRUST, scatter_of
from hdengine.prediction.half_space import HalfSpace, corrected_area, mirrored, stiffness_on_map, tamaas
from hdengine.prediction.law import predict
from hdengine.prediction.patches import _averaged, coarse_error, on_fewer_points
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


def fewer():
    """Logarithm of k_N on averaged maps over that on all points: without and with the theory of what averaging takes."""
    rows = []
    for row in read_record("joint_choice")["maps"]:
        if row["kind"] == "cut":
            continue
        z, p = surface(row["fractal_dimension"], row["kind"], row["seed"])[1], np.array(row["pressure_pa"])
        for points in (64, 128) if row["seed"] % 4 in (1, 2) else (64,):
            k_n, _, area, _ = on_fewer_points(z, DX, points, p, E_STAR, RATIO, periodic=True, tangential=False)
            bare = stiffness_on_map(*_averaged(z, DX, points), p, E_STAR, RATIO, tangential=False)[0]
            rows.append({"fractal_dimension": row["fractal_dimension"], "kind": row["kind"], "seed": row["seed"], "points": points,
                         "contact": row["contact"], "area": area, "bare": np.log(bare / row["k_n_pa_per_m"]),
                         "with_theory": np.log(k_n / row["k_n_pa_per_m"])})
            rows[-1] = {k: [float(f"{x:.4g}") for x in v] if isinstance(v, np.ndarray) else v for k, v in rows[-1].items()}
        print(rows[-1], flush=True)
    write_record("joint_fewer", rows, seed=list(SEEDS), peers=(tamaas(),))


def large():
    """Maps of 1024 x 1024 points without roll-off: k_N on fewer points over that on all, and the share of the processor's time."""
    rows = []
    for d in (2.1, 2.5, 2.9):
        z, found = 1e-7 * rough(1024, 3 - d, 1024, 6, 6001), {}
        for points in (64, 128, 256, 1024):
            start = time.process_time()
            k_n, _, area, _ = on_fewer_points(z, DX, points, pressures(0.1, (0.03,)), E_STAR, RATIO, periodic=True, tangential=False)
            found[points] = k_n[0], time.process_time() - start, area[0]
        whole = found[1024]
        rows += [{"fractal_dimension": d, "points": n, "contact": float(f"{whole[2]:.3g}"), "error": round(float(k / whole[0] - 1), 4),
                  "time_share": float(f"{t / whole[1]:.3g}")} for n, (k, t, _) in found.items()]
        print(*rows[-4:], sep="\n", flush=True)
    write_record("joint_large", rows, seed=6001, peers=(tamaas(),))


def ring(count=6):
    """From a patch to a contact of 16 such: errors [ln] and whether the bands hold, of a patch and of the contact."""
    rows, whole, bodies = [], 16 * 64**2 * 1e-12, Bodies(hardness=1e15)
    for d in (2.1, 2.5, 2.9):
        for roll_off in (64, 64 / 3):
            for seed in range(5001, 5001 + count):
                z = 1e-7 * rough(256, 3 - d, roll_off, 6, seed)
                p = pressures(0.1, (0.004, 0.02, 0.1))
                truth, patch = np.array(solve(z, p)["k_n_pa_per_m"]), (z[:64, :64], DX)
                row = {"fractal_dimension": d, "roll_off": roll_off / 64, "seed": seed}
                for name, options in (("patch", {}), ("contact", {"loaded": whole})):
                    t = predict(patch, pressure=p, model="spectrum", bodies=bodies, **options).table
                    row[f"theory_{name}_holds"] = ((t["k_n_pa_per_m_low"] < truth) & (truth < t["k_n_pa_per_m_high"])).tolist()
                    row[f"theory_{name}_width"] = np.log(t["k_n_pa_per_m_high"] / t["k_n_pa_per_m_low"]) / 2
                    row["theory"] = np.log(t["k_n_pa_per_m"] / truth)
                t = predict(patch, pressure=p, model="boundary_elements", points=64, bodies=bodies, loaded=whole).table
                row["boundary_elements"] = np.log(t["k_n_pa_per_m"] / truth)
                row["boundary_elements_holds"] = ((t["k_n_pa_per_m_low"] < truth) & (truth < t["k_n_pa_per_m_high"])).tolist()
                row["boundary_elements_width"] = np.log(t["k_n_pa_per_m_high"] / t["k_n_pa_per_m_low"]) / 2
                rows.append({k: [float(f"{x:.3g}") for x in v] if isinstance(v, np.ndarray) else v for k, v in row.items()})
                print(rows[-1], flush=True)
    write_record("joint_ring", rows, seed=5001, peers=(tamaas(),))


def judged(row):
    """Logarithm of k_N by theory over boundary elements, and whether the planner takes the theory: now, and by the rule of 3 %."""
    seen, _, spectrum = surface(row["fractal_dimension"], row["kind"], row["seed"])
    k, area = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, np.array(row["pressure_pa"]), E_STAR)
    own, facts = of_map(seen, DX)
    return (np.log(k / row["k_n_pa_per_m"]), 1.96 * scatter_of(area, own.waves) <= TRUST, area >= (1e-3 if facts["rolls_off"] else 0.03),
            own.waves)


@styled
def draw(found):
    """Scatter of boundary elements over maps that differ in their phases alone, and the theory beside their mean."""
    figure, axes = new_axes(1, 3, figsize=(13, 5))
    for axis, d in zip(axes, (2.1, 2.5, 2.9)):
        rows = [r for r in found if (r["fractal_dimension"], r["kind"]) == (d, 1)]
        k = np.log([r["k_n_pa_per_m"] for r in rows])
        contact = 100 * np.mean([r["contact"] for r in rows], axis=0)
        for i, one in enumerate(np.exp(k - k.mean(0)) - 1):
            axis.plot(contact, 100 * one, "o", color="0.5", ms=5, label=None if i else "boundary elements, one map each")
        theory = np.mean([judged(r)[0] for r in rows], axis=0)
        axis.plot(contact, 100 * (np.exp(theory) - 1), "C1^-", label="theory, mean")
        axis.axhspan(-10, 10, color="k", alpha=0.08, lw=0)
        axis.set(xscale="log", ylim=(-60, 90), xlabel="true contact / % of the area", title=f"D {d}, no roll-off")
    axes[0].set_ylabel("k_N against the mean of boundary elements / %")
    axes[0].legend(loc="upper right", fontsize=11)
    save_figure(figure, "joint_scatter")


def percent(logs):
    """Share within 10 %, rms and largest error of logarithms, as words."""
    e = np.exp(np.asarray(logs)) - 1
    return f"{100 * (abs(e) < 0.1).mean():.0f} %", f"{100 * np.sqrt((e**2).mean()):.1f} %", f"{100 * abs(e).max():.0f} %"


def fewer_pages():
    """Tables of docs/evidence/joint_fewer.md."""
    rows = read_record("joint_fewer")
    lines = []
    for points in (64, 128):
        for name, key in (("averaged map alone", "bare"), ("with the theory of what averaging takes", "with_theory")):
            for label, low, high in (("above 1 %", 0.01, 1.0), ("below 1 %", 0.0, 0.01)):
                those = [x for r in rows if r["points"] == points for x, a in zip(r[key], r["contact"]) if low <= a < high]
                lines.append((f"{points}² of 256²", name, label, len(those), *percent(those)))
    put("joint-fewer", table(("points", "boundary elements", "contact", "pressures", "within 10 %", "rms error", "largest"), lines),
        "evidence/joint_fewer")
    judge = [r for r in rows if r["seed"] > 3004]
    z = np.concatenate([np.array(r["with_theory"]) / coarse_error(np.array(r["area"]) * r["points"]**2) for r in judge])
    put("joint-coarse", f"On the {len({(r['fractal_dimension'], r['kind'], r['seed']) for r in judge})} maps that did not set the error of averaging, {100 * (abs(z) < 1.96).mean():.0f} % of {z.size} errors lie within its "
        "1.96-fold.", "evidence/joint_fewer")
    rows, lines = read_record("joint_large"), []
    for d in dict.fromkeys(r["fractal_dimension"] for r in rows):
        those = [r for r in rows if r["fractal_dimension"] == d and r["points"] < 1024]
        lines.append((d, *(f"{100 * r['error']:+.1f} % in 1/{1 / r['time_share']:.0f}" for r in those)))
    put("joint-large", table(("D, no roll-off", "64²", "128²", "256²"), lines), "evidence/joint_fewer")
    rows, lines = read_record("joint_ring"), []
    for name, key, spread in (("theory, as if the contact were a patch", "theory_patch", "theory"), ("theory, contact stated", "theory_contact", "theory"),
                              ("boundary elements, contact stated", "boundary_elements", "boundary_elements")):
        for label, roll in (("none", lambda r: r > 0.9), ("1/3 of the patch", lambda r: r < 0.9)):
            those = [r for r in rows if roll(r["roll_off"])]
            hold = np.array([r[f"{key}_holds"] for r in those])
            error, width = np.array([r[spread] for r in those]), np.array([r[f"{key}_width"] for r in those])
            lines.append((name, label, f"{hold.mean(1).sum() * hold.shape[1]:.0f} of {hold.size}", f"{100 * np.sqrt((error**2).mean()):.0f} %",
                          f"{100 * width.mean():.0f} %"))
    put("joint-ring", table(("law of one patch", "roll-off", "contact in the band", "rms error",
                             "half width, mean"), lines), "evidence/joint_fewer")


def pages():
    """Tables and the figure of the pages."""
    draw(read_record("joint_choice")["maps"])
    fewer_pages()
    found, edges = read_record("joint_choice")["maps"], [r for r in read_record("joint_choice_edge") if "contact" in r]
    contact = 100 * np.mean([r["contact"] for r in found], axis=0)
    rows, counts = [], {}
    for d, kind in KINDS:
        those = [r for r in found if (r["fractal_dimension"], r["kind"]) == (d, kind)]
        logs, new, old, waves = (np.array(x) for x in zip(*(judged(r) for r in those)))
        ends = np.array([judged(r)[0][0] for r in edges if (r["fractal_dimension"], r["kind"]) == (d, kind)])
        mean, spread = np.exp(logs.mean(0)), logs.std(0, ddof=1)
        cells = [f"{m:.2f}±{2 * m * s / len(those) ** 0.5:.2f}, {100 * s:.0f}" for m, s in zip(mean, spread)]
        rows.append((f"{d}, {NAMES[kind]}", f"{np.median(waves):.0f}",
                     *(f"**{c}**" if n > 0.5 else c for c, n in zip(cells, new.mean(0)))))
        for name, errors in (("new", np.exp(logs[new]) - 1), ("edge", np.exp(ends) - 1), ("old", np.exp(logs[old]) - 1)):
            counts.setdefault((kind, name), []).extend(abs(errors))
    head = ("D, roll-off", "waves", *(f"{c:.0f} %" if c > 3 else f"{c:.1f} %" for c in contact))
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
    todo = sys.argv[1:] or ["maps", "edge", "fewer", "large", "ring", "pages"]
    for name, call in (("maps", maps), ("edge", edge), ("fewer", fewer), ("large", large), ("ring", ring), ("pages", pages)):
        if name in todo:
            call()


if __name__ == "__main__":
    main()
