# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare with the figures that Hu et al. (2023) state, and with catalogues: writes docs/comparison.md and its figures.

Solves the studies of data/ it needs (about half an hour; finished points are kept in --work).

Usage: python bench/paper_comparison.py [--work DIR]
"""
import argparse
import json
import tempfile
from pathlib import Path

import numpy as np

import hdengine
from hdengine import torsion
from hdengine.catalogue import UNITS
from hdengine.plot import plt
from hdengine.results import read_csv

ROOT = Path(__file__).resolve().parents[1]
TORQUES = (1.0, 3.0, 5.0)
W = (0.195e-3, 0.2e-3, 0.205e-3, 0.21e-3, 0.215e-3)


def study(name, work):
    """A study of data/, solved or continued."""
    return hdengine.Study.read(ROOT / f"data/{name}.nml").run(work / f"{name}.out", jobs=1)


def value(result, column="k_ts_nm_per_rad", **keys):
    """One cell of a study's table; NaN where it was not solved."""
    rows = result.select(**keys)
    return rows[0].get(column, np.nan) if rows else np.nan


def percent(values):
    """Changes as text."""
    return " / ".join("-" if np.isnan(v) else f"{100 * v:+.1f}" for v in values)


def trends(result, **keys):
    """Rise from 1 to 5 N m, change by 10 um of eccentricity, place and height of the maximum over w; with verdicts."""
    def k(torque, w=0.2e-3, e=0.0):
        return value(result, torque_nm=torque, wave_generator__w=w, wave_generator__eccentricity=e, **keys)
    rise = k(5.0) / k(1.0) - 1
    fall = np.array([k(t, e=10e-6) / k(t) - 1 for t in TORQUES])
    curve = np.array([[k(t, w=w) for w in W] for t in TORQUES])
    top = [f"{1e3 * W[int(np.argmax(c))]:.3f}" if np.all(np.isfinite(c)) else "-" for c in curve]
    gain = curve.max(axis=1) / curve.min(axis=1) - 1
    verdict = ["yes" if rise > 0.05 else "no",
               "yes" if np.all(fall < -0.005) and fall[0] < fall[2] else "falls" if np.all(fall < -0.005) else "no",
               "yes" if np.all([0 < np.argmax(c) < len(W) - 1 for c in curve]) and np.all(gain > 0.005) else "no"]
    return rise, fall, top, gain, verdict


def trend_rows(work):
    """Rows of the table of trends."""
    for name, shape, keys in (("explore_trends", "pressed", ("load.torque_load", "load.support", "wave_generator.interference")),
                              ("explore_formed", "formed", ("load.torque_load", "wave_generator.interference"))):
        result = study(name, work)
        cases = dict.fromkeys(tuple(row[k] for k in keys) for row in result.rows)
        for case in sorted(cases, key=str):
            chosen = dict(zip(keys, case))
            rise, fall, top, gain, verdict = trends(result, **{k.replace(".", "__"): v for k, v in chosen.items()})
            yield (shape, chosen.get("load.support", "hub"), chosen["load.torque_load"],
                   1e6 * chosen["wave_generator.interference"], rise, fall, top, gain, verdict)


def catalogue_chart(work):
    """K_FTS of five sizes beside the catalogue; returns sizes and stiffness."""
    result = study("teeth_sizes", work)
    sizes = sorted(UNITS)
    figure, axis = plt.subplots(figsize=(9, 5))
    for clearance, mark, label in ((0.0, "o-", "ours, cup and teeth, closed at the start"),
                                   (10e-6, "s--", "ours, outermost teeth 10 µm open")):
        k = [value(result, "k_fe_secant_nm_per_rad", geometry__bore_radius=17.5e-3 * s / 14, load__tooth_clearance=clearance)
             for s in sizes]
        axis.loglog(sizes, k, mark, color="C0", label=label)
        if clearance == 0:
            ours = k
    for i, colour in ((1, "C1"), (2, "C2"), (3, "C3")):
        axis.loglog(sizes, [getattr(UNITS[s], f"k{i}_nm_per_rad") for s in sizes], "^-", color=colour, label=f"catalogue K{i}")
    axis.set_xticks(sizes, sizes)
    axis.minorticks_off()
    axis.set_xlabel("size")
    axis.set_ylabel("torsional stiffness / (N m/rad)")
    axis.legend(fontsize=11)
    figure.savefig(ROOT / "docs/figures/catalogue.png")
    return sizes, ours


def tooth_chart(folder):
    """Share of each pair of teeth; returns the largest."""
    teeth = read_csv(folder / "teeth.csv")
    last = teeth[teeth["step"] == teeth["step"].max()]
    figure, axis = plt.subplots(figsize=(8, 4))
    axis.bar((np.degrees(last["theta_rad"]) + 90) % 360 - 90, 100 * last["share"], width=1.5)
    axis.set_xlabel("angle from the long axis / degree")
    axis.set_ylabel("share of the tooth forces / %")
    figure.savefig(ROOT / "docs/figures/tooth_shares.png")
    return 100 * last["share"].max(), 100 * last["share"].min()


def coupled(work):
    """Torque, K_TS by Eq. 45, and secant and tangent of the coupled model: torque over the turn that the joint adds [N m/rad]."""
    result = study("coupled", work)
    torque = sorted({row["torque_nm"] for row in result.rows})
    turn = np.array([[value(result, "rotation_rad", torque_nm=t, contact__law=law) for t in torque] for law in ("hard", "joint")])
    added = turn[1] - turn[0]
    eq45 = [value(result, torque_nm=t, contact__law="joint") for t in torque]
    return [[float(t), float(k), float(t / a), float(c)] for t, k, a, c in zip(
        torque[1:], eq45[1:], added[1:], np.diff(torque) / np.diff(added))]


def main():
    """Solve and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", help="folder for the studies")
    work = Path(parser.parse_args().work or tempfile.mkdtemp())
    work.mkdir(parents=True, exist_ok=True)
    rows = [*trend_rows(work)]
    base = study("fig11_torque", work)
    slip = study("explore_slip", work)
    teeth = work / "teeth.out"
    if not (teeth / "summary.json").is_file():
        hdengine.run(str(ROOT / "data/teeth.nml"), teeth, True)
    run = hdengine.load(teeth)
    k_fts = float(run.torque_nm[-1] / run.steps["rotation_rad"][-1])
    shares = tooth_chart(teeth)
    sizes, ours = catalogue_chart(work)
    at = {s: {c: value(base, c, torque_nm=5.0, load__support=s) for c in
              ("k_ts_nm_per_rad", "k_ts_paper_n", "pressure_long_1_pa", "pressure_max_pa")} for s in ("hub", "bearing")}
    facts = {"k_fts_nm_per_rad": k_fts, "at_5_nm": at, "tooth_share_percent": shares, "k_series_nm_per_rad": torsion.series(
        at["hub"]["k_ts_nm_per_rad"], k_fts), "sizes": dict(zip(map(str, sizes), ours)),
        "slip_torque_nm": {f"{r['load.torque_load']}, {1e6 * r['wave_generator.interference']:g} um": r["torque_nm"]
                           for r in slip.failures if "gross slip" in r["reason"]},
        "coupled_nm_and_nm_per_rad": coupled(work), "trends": [[*map(str, row[:4]), row[4], *row[5], *row[6], *row[7], *row[8]] for row in rows]}
    (ROOT / "bench/results/paper_comparison.json").write_text(json.dumps(facts, indent=1) + "\n")
    table = "\n".join(
        f"| {shape} | {support} | {load} | {delta:g} | {100 * rise:+.1f} | {percent(fall)} | {' / '.join(top)} | "
        f"{percent(gain)} | {' '.join(verdict)} |" for shape, support, load, delta, rise, fall, top, gain, verdict in rows)
    page = ROOT / "docs/comparison.md"
    text = page.read_text()
    start, end = "<!-- trends -->\n", "<!-- end of trends -->"
    head = "| shape | support | load | δ / µm | 1 to 5 N m / % | e = 10 µm / % at 1 / 3 / 5 N m | maximum at w / mm | " \
           "over the minimum / % | torque, e, w as in the paper |\n|---|---|---|---|---|---|---|---|---|\n"
    page.write_text(text[:text.index(start) + len(start)] + head + table + "\n" + text[text.index(end):])
    print(json.dumps(facts, indent=1))


if __name__ == "__main__":
    main()
