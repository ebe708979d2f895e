# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures that Hu et al. (2023) state beside ours, and their three trends in every reading of K_TS.

Solves the studies of data/ it needs (a quarter of an hour; finished points are kept in --work). `hdengine report WORK` then makes
one HTML file of the comparison and all its studies. Writes bench/results/paper_comparison.json.

Usage: python bench/paper_comparison.py [--work DIR]
"""
import argparse
import json
import tempfile
from pathlib import Path

import numpy as np

import hdengine
from common import ROOT, write_record
from hdengine.paper import comparison as paper

W = (0.195e-3, 0.2e-3, 0.205e-3, 0.21e-3, 0.215e-3)


def study(name, work, suffix="", **fixed):
    """A study of data/, solved or continued."""
    chosen = hdengine.Study.read(ROOT / f"data/{name}.toml")
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


def comparison(work, explored):
    """Rows of the comparison and the facts behind them."""
    torque, closure = study("fig11_torque", work), study("fig11_torque", work, "_closure", joint__closure="paper")
    series = study("fig10_series", work)
    drive = next(r for r in series.series() if r["tooth_clearance_m"] == 0 and abs(r["torque_nm"] - 0.5) < 1e-9)
    hub = {"load__support": "hub"}
    rows = paper.torque_rows(torque.select(**hub), closure.select(**hub), explored)
    rows += paper.eccentricity_rows(study("fig12_eccentricity", work).select(**hub), explored)
    rows += paper.w_rows(study("fig13_w", work).select(**hub), explored)
    rows += paper.series_rows(drive["k_ts_nm_per_rad"], drive["k_fts_nm_per_rad"]) + paper.arithmetic_rows()
    at = {s: {c: value(torque, c, torque_nm=5.0, load__support=s) for c in READINGS} for s in ("hub", "bearing")}
    return rows, {"at_5_nm": at, "rows": [dict(zip(paper.Row.HEAD, r.cells())) for r in rows]}


def spread(values):
    """The range of changes in per cent; what is above 100 % without decimals, above 1000 % without its size."""
    values = np.array([v for v in values if np.isfinite(v)])

    def shown(v):
        return "above +1000" if v > 1000 else f"{v:+.{1 if abs(v) < 100 else 0}f}"
    return f"{shown(values.min())} to {shown(values.max())} %" if len(values) else "-"


def main():
    """Solve and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", help="folder for the studies")
    work = Path(parser.parse_args().work or tempfile.mkdtemp())
    work.mkdir(parents=True, exist_ok=True)
    by_reading = {name: [*trends(work, column)] for column, name in READINGS.items()}
    rows, facts = comparison(work, by_reading["Eq. 45"])
    write_record("paper_comparison", facts | {"trends_by_reading": by_reading})
    (work / "comparison.json").write_text(json.dumps(facts, indent=1))
    print(paper.markdown(rows))


if __name__ == "__main__":
    main()
