# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare with the figures that Hu et al. (2023) state, and with catalogues: tables and figures of docs/evidence/{comparison,paper_figures,causes}.md; the
scenes one by one stand in the notebook.

Solves the studies of data/ it needs (a quarter of an hour; finished points are kept in --work). `hdengine report WORK` then makes
one HTML file of the comparison and all its studies.

Usage: python bench/paper_comparison.py [--work DIR]
"""
import argparse
import json
import shutil
import tempfile
from pathlib import Path

import numpy as np

import hdengine
from common import ROOT, put, table, write_record
from hdengine.catalogue import UNITS
from hdengine.figures.study import draw_catalogue, draw_units, plot_study
from hdengine.figures.style import new_axes, styled
from hdengine.paper import comparison as paper

BALLS, DIAMETER, LOAD = 21, 3.2e-3, 15.0  # estimates, no source for this bearing: [-], [m], [N] radial tooth force of 5 N m a ball
PAGE, SCENES = "evidence/comparison", "notebook/2026-11-24-paper-scenes"
HEAD = ("shape", "support", "load", "δ / µm", "torque / %", "e / %", "best w / µm", "gain / %", "verdicts")
W = (0.195e-3, 0.2e-3, 0.205e-3, 0.21e-3, 0.215e-3)


def ball_stiffness(size=14):
    """Radial stiffness of all balls of a size together [N/m], all lengths and the load in proportion to the catalogue's.

    Hertz, sphere between two planes: F = 4/3 E* sqrt(R) (d/2)^1.5, its slope at LOAD; the number of balls is that of size 14.
    """
    e_star, scale = 209e9 / 2 / (1 - 0.3**2), size / 14
    factor = 4 / 3 * e_star * np.sqrt(scale * DIAMETER / 2) / 2**1.5
    return float(BALLS * 1.5 * (LOAD * scale**2)**(1 / 3) * factor**(2 / 3))


def study(name, work, suffix="", together=None, **fixed):
    """A study of data/, solved or continued."""
    chosen = hdengine.Study.read(ROOT / f"data/{name}.toml")
    chosen.together |= together or {}
    chosen.fixed.update({k.replace("__", "."): v for k, v in fixed.items()})
    chosen.title += ", Eq. 28 as printed" if fixed.get("joint__closure") == "paper" else ""
    return chosen.run(work / f"{name}{suffix}.out", jobs=1)


def value(result, column="k_ts_nm_per_rad", **keys):
    """One cell of a study's table; NaN where it was not solved."""
    rows = result.select(**keys)
    return rows[0].get(column, np.nan) if rows else np.nan


def trend(name, result, column="k_ts_nm_per_rad", **keys):
    """Rise from 1 to 5 N m, change by 10 um of eccentricity, place and height of the maximum over w, slip torque of one scene."""
    varied = "wave_generator.w" in result.summary["swept"]

    def k(torque, w=0.2e-3, e=0.0):
        place = {"wave_generator__w": w, "wave_generator__eccentricity": e} if varied else {}
        found = value(result, column, torque_nm=torque, **place, **keys) if varied or (w, e) == (0.2e-3, 0.0) else np.nan
        return found if found > 0 else np.nan
    curve = np.array([[k(t, w=w) for w in W] for t in paper.TORQUES_NM])
    solved = np.all(np.isfinite(curve))
    top = curve.argmax(axis=1)
    slip = [r for r in result.failures if "gross slip" in r["reason"] and r.get("wave_generator.w", 0.2e-3) == 0.2e-3
            and not r.get("wave_generator.eccentricity") and all(r[key.replace("__", ".")] == v for key, v in keys.items())]
    return {"name": name, "rise_percent": 100 * (k(5.0) / k(1.0) - 1),
            "fall_percent": [100 * (k(t, e=10e-6) / k(t) - 1) for t in paper.TORQUES_NM],
            "top_mm": [1e3 * W[i] for i in top] if solved else None,
            "gain_percent": (100 * (curve.max(axis=1) / curve.min(axis=1) - 1)).tolist() if solved else [np.nan] * 3,
            "inside": bool(solved and np.all((top > 0) & (top < len(W) - 1))
                           and np.all(curve.max(axis=1) / curve.min(axis=1) > 1.005)),
            "slip_torque_nm": slip[0]["torque_nm"] if slip else None}


def trends(work, column="k_ts_nm_per_rad"):
    """All scenes explored, in one reading of K_TS."""
    for name, shape in (("explore_trends", "pressed"), ("explore_formed", "formed")):
        result = study(name, work)
        keys = [k for k in ("load.support", "load.torque_load", "wave_generator.interference") if k in result.summary["swept"]]
        for case in sorted(dict.fromkeys(tuple(row[k] for k in keys) for row in result.rows)):
            chosen = dict(zip(keys, case))
            place = chosen.get("load.support") or result.summary["scene"]["load.support"]
            label = f"{shape}, {place}, {chosen['load.torque_load']}, {1e6 * chosen['wave_generator.interference']:g} µm"
            yield trend(label, result, column, **{k.replace(".", "__"): v for k, v in chosen.items()})


READINGS = {"k_ts_nm_per_rad": "Eq. 45", "k_ts_paper_n": "Eq. 45 as printed", "k_ts_tangent_nm_per_rad": "tangent",
            "k_ts_secant_nm_per_rad": "secant", "k_fe_secant_nm_per_rad": "torque over rotation"}


def reading_line(name, found):
    """Row of the verdicts on one reading: scenes that give each trend, and the ranges of the figures."""
    lines = [trend_line(t)[-1].split() for t in found]
    rise, fall = [t["rise_percent"] for t in found], [v for t in found for v in t["fall_percent"]]
    gain = [v for t in found if t["top_mm"] for v in t["gain_percent"]]
    two = sum(line.count("yes") > 1 for line in lines)
    return [name, *(sum(line[i] == "yes" for line in lines) for i in range(3)), spread(rise), spread(fall), spread(gain), two,
            sum(line.count("yes") > 2 for line in lines)]


def trend_line(t):
    """Row of the table of trends."""
    stated = 100 * (paper.STATED["k_ts_best_w"][2] / paper.STATED["k_ts_best_w"][0] - 1)
    slips = t["slip_torque_nm"]
    torque = paper.judge_trend([stated], [t["rise_percent"]])
    fall = np.array(t["fall_percent"])
    verdict = ["yes" if torque != "does not agree" else "no",
               "yes" if paper.judge_trend(paper.STATED["eccentricity_percent"], fall) != "does not agree" else
               "falls" if np.all(fall < -paper.RESOLVED) else "no", "yes" if t["inside"] else "no"]
    rise = f"slips at {slips:.2f}" if slips else bare([t["rise_percent"]])
    where = " / ".join(f"{1e3 * v:.0f}" for v in t["top_mm"]) if t["top_mm"] else "-"
    return [*t["name"].removesuffix(" µm").split(", "), rise, bare(fall), where, bare(t["gain_percent"]), " ".join(verdict)]


def bare(changes):
    """Changes in per cent without the sign of it, those beyond a hundred without decimals."""
    return paper.signed(changes, 0 if np.nanmax(np.abs(changes), initial=0) > 100 else 1).removesuffix(" %")


@styled
def catalogue_chart(work):
    """K_FTS of five sizes beside the catalogue; returns sizes and stiffness, wave generator rigid, and on balls."""
    sizes = sorted(UNITS)
    rigid = study("teeth_sizes", work)
    balls = study("teeth_sizes", work, "_balls", {"wave_generator.ball_stiffness": [ball_stiffness(s) for s in sizes]})
    figure, axis = new_axes(figsize=(9, 5))
    found = []
    for result, name, colour in ((rigid, "ours", "C0"), (balls, "on balls", "C4")):
        found += draw_catalogue(axis, result, name, colour)
    draw_units(axis)
    figure.savefig(ROOT / "docs/figures/catalogue.png")
    return sizes, found


def catalogue_table(sizes, found):
    """Ours beside K1 to K3."""
    rows = [[s, *(f"{v / 1e3:.1f}" for v in k), *(f"{v / 1e3:.1f}" for v in (u.k1_nm_per_rad, u.k2_nm_per_rad, u.k3_nm_per_rad)),
             " / ".join(f"{v / u.k3_nm_per_rad:.1f}" for v in k)]
            for s, k, u in zip(sizes, zip(*found), (UNITS[s] for s in sizes))]
    return table(("size", "K_FTS / (kN m/rad), rigid", "teeth open", "on balls", "balls, teeth open", "K1", "K2", "K3", "K_FTS / K3"), rows)


def teeth_run(work, name, **keys):
    """A run of data/teeth.nml, solved or read."""
    folder = work / name
    if not (folder / "summary.json").is_file():
        hdengine.run(str(ROOT / "data/teeth.nml"), folder, True, **keys)
    return hdengine.load(folder)


def tooth_shares(work):
    """K_FTS(T), and the largest and smallest share of a pair of teeth at one end of the long axis in per cent."""
    closed = teeth_run(work, "teeth.out")
    loose = teeth_run(work, "teeth_open.out", load__tooth_clearance=10e-6)
    share = {}
    for run, torque, label in ((closed, 5.0, "closed at the start, 1 to 5 N m"), (loose, 1.0, "outermost 10 µm open, 1 N m"),
                               (loose, 5.0, "outermost 10 µm open, 5 N m")):
        rows = run.teeth[abs(run.teeth["torque_nm"] - torque) < 1e-9]
        share[label] = [float(100 * rows["share"].max()), float(100 * rows["share"].min())]

    def secant(run):
        return run.secant_stiffness()[run.torque_nm > 0].tolist()
    return {"torque_nm": closed.torque_nm[closed.torque_nm > 0].tolist(), "closed": secant(closed), "open": secant(loose),
            "share_percent": share}


def comparison(work, explored):
    """Rows of the comparison and the facts behind them."""
    torque, closure = study("fig11_torque", work), study("fig11_torque", work, "_closure", joint__closure="paper")
    series = study("fig10_series", work)
    shutil.copy(plot_study(series)[0], ROOT / "docs/figures/series.png")
    drive = next(r for r in series.series() if r["tooth_clearance_m"] == 0 and abs(r["torque_nm"] - 0.5) < 1e-9)
    hub = {"load__support": "hub"}
    rows = paper.torque_rows(torque.select(**hub), closure.select(**hub), explored)
    rows += paper.eccentricity_rows(study("fig12_eccentricity", work).select(**hub), explored)
    rows += paper.w_rows(study("fig13_w", work).select(**hub), explored)
    rows += paper.series_rows(drive["k_ts_nm_per_rad"], drive["k_fts_nm_per_rad"]) + paper.arithmetic_rows()
    at = {s: {c: value(torque, c, torque_nm=5.0, load__support=s) for c in
              (*READINGS, "pressure_long_1_pa", "pressure_max_pa", "slip_share_force")} for s in ("hub", "bearing")}
    return rows, {"at_5_nm": at, "series": series.series(), "rows": [dict(zip(paper.Row.HEAD, r.cells())) for r in rows]}


def spread(values):
    """The range of changes in per cent; what is above 100 % without decimals, above 1000 % without its size."""
    values = np.array([v for v in values if np.isfinite(v)])

    def shown(v):
        return "above +1000" if v > 1000 else f"{v:+.{1 if abs(v) < 100 else 0}f}"
    return f"{shown(values.min())} to {shown(values.max())} %" if len(values) else "-"


def group_lines(found):
    """Scenes by shape and support: ranges of what they give."""
    for group in dict.fromkeys(tuple(t["name"].split(", ")[:2]) for t in found):
        here = [t for t in found if tuple(t["name"].split(", ")[:2]) == group]
        verdicts = [trend_line(t)[-1].split() for t in here]
        slips = sum(t["slip_torque_nm"] is not None for t in here)
        yield (*group, len(here), spread([t["rise_percent"] for t in here]) + (f", {slips} slips" if slips else ""),
               spread([v for t in here for v in t["fall_percent"]]), spread([v for t in here if t["top_mm"] for v in t["gain_percent"]]),
               " / ".join(str(sum(v[i] == "yes" for v in verdicts)) for i in range(3)))


def put_readings(every):
    """Verdict on each reading, the scenes in groups, and one by one."""
    put("readings", table(("reading", "rise", "fall", "inside", "1 to 5 N m", "e = 10 µm", "over w", "two", "three"),
                          [reading_line(name, every[column]) for column, name in READINGS.items()]), PAGE)
    put("groups", table(("shape", "support", "scenes", "1 to 5 N m", "e = 10 µm", "over w", "each trend"),
                        group_lines(every["k_ts_nm_per_rad"])), PAGE)
    put("trends", table(HEAD, map(trend_line, every["k_ts_nm_per_rad"])), SCENES)
    put("tangents", table(HEAD, map(trend_line, every["k_ts_tangent_nm_per_rad"])), SCENES)


def main():
    """Solve and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", help="folder for the studies")
    work = Path(parser.parse_args().work or tempfile.mkdtemp())
    work.mkdir(parents=True, exist_ok=True)
    explored = [*trends(work)]
    rows, facts = comparison(work, explored)
    teeth = tooth_shares(work)
    sizes, found = catalogue_chart(work)
    every = {column: explored if column == "k_ts_nm_per_rad" else [*trends(work, column)] for column in READINGS}
    facts |= {"teeth": teeth, "sizes": dict(zip(map(str, sizes), zip(*found))), "ball_stiffness_n_per_m": ball_stiffness(),
              "trends": explored, "trends_by_reading": {READINGS[c]: v for c, v in every.items()}}
    write_record("paper_comparison", facts)
    (work / "comparison.json").write_text(json.dumps(facts, indent=1))
    put("verdicts", paper.markdown(rows), "evidence/paper_figures")
    at, stated = facts["at_5_nm"], paper.STATED["k_ts_5_nm"]
    put("magnitude", table(("reading", "cup bottom held", "paper's load path", "over the paper's", "verdict"), [
        (name, *(f"{at[s][c] / 1e6:.3g}" for s in ("hub", "bearing")), *((f"{at['bearing'][c] / stated:.0f}", "does not agree")
         if c != "k_ts_paper_n" else ("-", "cannot agree: newtons"))) for c, name in READINGS.items()]), PAGE)
    put_readings(every)
    put("catalogue", catalogue_table(sizes, found), "evidence/cup_and_catalogue")
    print(paper.markdown(rows))


if __name__ == "__main__":
    main()
