#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every table that is made of a record: on the pages of docs/evidence and in the README.

Usage: bench/tables.py; run it after a bench script has written its record. tests/python/test_evidence.py holds pages and records together.
"""
import importlib.util
from statistics import median

import numpy as np

from common import ROOT, put, read_record, read_rows, table

COURT = ROOT / "court/run.py"


def percent(value, digits=1, sign="+"):
    """A share or a difference in per cent, 'below ...' where nothing is left after rounding."""
    text = f"{100 * value:{sign}.{digits}f} %"
    return text if float(text[:-2]) else f"below {10**-digits:g} %"


def digits(value, count=2):
    """A number of so many digits, without a power of ten."""
    return f"{float(f'{value:.{count - 1}e}'):g}"


def power(value):
    """Two digits and a power of ten."""
    return f"{value:.1e}".replace("e+0", "e")


def triple(values, form):
    """Numbers with strokes between them."""
    return " / ".join(form.format(v) for v in values)


# --- contact and elements

ELEMENTS = ("hex8", "hex8i", "hex20r", "C3D8I")


def elements():
    """Errors of the displacement of like elements, ours and CalculiX'."""
    rows = read_record("elements")["rows"]
    error = {(r["case"], r["mesh"], r["element"]): r["error_percent"] for r in rows}

    def shown(e):
        return f"{e:+.{0 if abs(e) >= 10 else 1 if abs(e) >= 0.095 else 2}f}"
    return ("case", "mesh", *ELEMENTS), [(case.replace(" theta", "θ").replace("t = ", ""), mesh, *(shown(error[case, mesh, e]) for e in ELEMENTS))
                                         for case, mesh in dict.fromkeys((r["case"], r["mesh"]) for r in rows)]


def problems():
    """Names of the problems of the court."""
    spec = importlib.util.spec_from_file_location("court", COURT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.PROBLEMS


def closed():
    """Contact against formulas."""
    found = {}
    for r in read_record("court"):
        if r["problem"] == "closed_solutions":
            problem, quantity = r["quantity"].split(": ")
            found.setdefault((problem, f"{100 * r['tolerance']:g} %"), []).append(f"{quantity} {percent(r['ours'] - r['reference'], 2)}")
    return ("problem", "error", "held to"), [(problem, ", ".join(errors), held) for (problem, held), errors in found.items()]


def court():
    """Published problems: how many quantities agree, and the one that is farthest off."""
    rows, out = read_record("court"), []
    for name, words in problems().items():
        mine = [r for r in rows if r["problem"] == name]
        if mine and name != "closed_solutions":
            away = max(abs(r["ours"] / r["reference"] - 1) if r["reference"] else abs(r["ours"]) for r in mine)
            out.append((words, len(mine), sum(r["verdict"] == "agrees" for r in mine), percent(away, 1, "")))
    return ("problem", "quantities", "agree", "largest difference"), out


def peer_hub():
    """CalculiX and the engine on one mesh."""
    names = {"hdengine, newton": "hdengine, sparse matrix, exact factors", "hdengine, condensed": "hdengine, condensed (default)"}
    return ("code", "wall clock / s", "memory / MB", "Newton iterations", "rotation / µrad"), [
        (names.get(name, "CalculiX 2.20, C3D8I"), f"{x['wall_s']:.1f}", f"{x['memory_mb']:.0f}", x["iterations"], f"{1e6 * x['rotation_rad']:.1f}")
        for name, x in reversed(read_record("peer_hub")["runs"].items())]


def peer_drive():
    """A whole drive by both codes, at the largest torque."""
    rows = read_record("peer_drive")["rows"]
    return (f"at {rows[-1]['torque_nm']:g} N m", "hdengine", "CalculiX", "difference"), [
        (r["what"], f"{r['ours']:.5g} {r['unit']}", f"{r['calculix']:.5g} {r['unit']}", percent(r["difference"], 1, ""))
        for r in rows if r["torque_nm"] == rows[-1]["torque_nm"]]


def heights():
    """Time of heights over the best peer's: least and most over the sizes."""
    cells = read_record("height_peers")["cells"]
    waves, sizes = ([*dict.fromkeys(c[k] for c in cells)] for k in ("waves", "n"))
    found = {}
    for c in cells:
        found.setdefault((c["tolerance"], c["waves"]), []).append(c["ratio"])
    return (f"tolerance, {min(sizes)}² to {max(sizes)}² points", *(f"J = {j}" for j in waves)), [
        (f"{t:g}", *(f"{min(found[t, j]):.2f} to {max(found[t, j]):.2f}" for j in waves)) for t in dict.fromkeys(c["tolerance"] for c in cells)]


# --- K_TS in scenes

KINDS = {"k_ts_nm_per_rad": ("Eq. 45", 2), "k_ts_bonded_nm_per_rad": ("tangent", 3), "k_ts_secant_nm_per_rad": ("secant", 3),
         "k_fe_secant_nm_per_rad": ("torque over rotation", 4)}


def reading(sums, key):
    """A reading of K_TS [MN m/rad]."""
    return f"{sums[key] / 1e6:.{KINDS[key][1]}f}"


def meshes():
    """CD-14-100 over its mesh."""
    return ("facets", "cells at the edges / µm", "Eq. 45, `hu2023`", *(name for name, _ in [*KINDS.values()][:2]), "peak / MPa", "line load / (kN/m)"), [
        (f"{s['divisions']} x {s['band_facets']}", f"{1e6 * s['edge_length_m']:g}" if s["edge_length_m"] else "even",
         reading(s["paper"], "k_ts_nm_per_rad"), *(reading(s, k) for k in [*KINDS][:2]), f"{s['pressure_max_pa'] / 1e6:.0f}", f"{s['edge_line_load_n_per_m'] / 1e3:.1f}")
        for s in read_record("readings")["meshes"]]


def steps():
    """CD-14-100 by 1, 5 and 20 torque steps, by support and law of contact."""
    found = {}
    for name, s in read_record("readings")["steps"].items():
        found.setdefault(tuple(name.split(", ")[:2]), []).append(s)
    kinds = ("k_ts_bonded_nm_per_rad", "k_fe_secant_nm_per_rad")
    return ("support", "contact law", *(KINDS[k][0] for k in kinds)), [
        (*case, *(triple([reading(s, k) for s in sums], "{}") for k in kinds)) for case, sums in found.items()]


def kinematics():
    """Largest change by large displacements over w."""
    return ("w / mm", "tangent", "normal force", "mid-band pressure"), [
        (f"{1e3 * r['w_m']:.2f}", *(percent(x, sign="") for x in r["largest"])) for r in read_record("readings")["kinematics"]]


def frictions():
    """CD-14-100 at 1, 5 and 20 N m over friction and eccentricity."""
    found = {}
    for name, s in read_record("readings")["frictions"].items():
        found.setdefault(name.split(", ")[1], []).append(s)
    return ("scene", "tangent", "Eq. 45, `hu2023`", "its slip / %"), [
        (what, *(" / ".join(reading(s, "k_ts_bonded_nm_per_rad") for s in at), " / ".join(reading(s["paper"], "k_ts_nm_per_rad") for s in at),
                 triple([100 * s["paper"]["slip_share_k_ts"] for s in at], "{:.0f}"))) for what, at in found.items()]


def joints():
    """CD-14-100 over the joint."""
    return ("joint", *(name for name, _ in [*KINDS.values()][:2])), [
        (name, *(reading(s, k) for k in [*KINDS][:2])) for name, s in read_record("readings")["inputs"].items()]


def headline():
    """K1 to K3 of two shipped drives with their bands beside the catalogue, and what the contact takes of a further twist."""
    found, bands = ({r["drive"]: r for r in drive_rows(part)} for part in ("sizes", "bands"))

    def cells(size, i):
        low, high, k, stated = bands[size]["low"], bands[size]["high"], found[size]["k"], found[size]["catalogue"]
        return digits(k[i], 3), f"{digits(low[i], 3)} to {digits(high[i], 3)}", digits(stated[i], 3)
    shares = [f"{100 * sum(found[size]['shares'][part] for part in ('gaps', 'slip', 'joint')):.0f}" for size in ("14", "20")]
    return ("reading", "size 14", "95 % band", "catalogue", "size 20", "95 % band", "catalogue"), [
        *((f"K{i + 1} in kN m/rad", *cells("14", i), *cells("20", i)) for i in range(3)),
        ("the contact's share of a further twist at the rated torque in %", shares[0], "-", "-", shares[1], "-", "-")]


def indices():
    """Shares of the inputs in the tangent."""
    found = read_record("sensitivity")
    return ("input", "total share", "by factors"), [
        (f"`{r['input']}`", f"{r['ST']:.2f} ± {r['ST_conf']:.2f}", f"{found['share_by_factors'][r['input']]:.2f}") for r in found["indices"] if r["ST"] >= 0.015]


# --- the drive and the paper

def over(row, other):
    """K1 to K3 over those of a catalogue or of another drive, and both ratios over its own."""
    k = np.array(row["k"]) / other
    return triple(k, "{:.2f}"), triple(k[1:] / k[0], "{:.2f}")


def drive_rows(part="sizes"):
    """Rows of a part of the record that were solved, by what they are of."""
    return [r for r in read_record("drive_catalogue")[part] if "failed" not in r]


def drive_sizes():
    """Shipped drives beside the catalogue."""
    def cubes(r):
        return ", ".join(f"{1e3 * k[2] / int(r['drive'][:2])**3:.2f}" for k in (r["k"], r["catalogue"]) if k)
    return ("drive", "K1 / K2 / K3, kN m/rad", "over catalogue's", "K2/K1, K3/K1 over", "K3/size³", "hysteresis, lost motion", "cup / MPa", "CPU s", "large"), [
        (r["drive"].replace("_", "-"), triple(r["k"], "{:.3g}"), *(over(r, r["catalogue"]) if r["catalogue"] else ("-", "-")), cubes(r),
         f"{r['hysteresis_arcmin']:.2f}', {r['lost_motion_arcmin']:.2f}'", f"{r['cup_mpa']:.0f} ({r['cup_safety']:.1f})", f"{r['cpu_s']:.1f}",
         triple(r["large"], "{:.2f}")) for r in drive_rows()]


def drive_kin():
    """Every size of the catalogue at two ratios."""
    found = {(r["size"], r["ratio"]): r for r in drive_rows("kin")}
    pairs = {size: (r, found[size, 50]) for (size, ratio), r in found.items() if ratio == 100}
    return ("size", "ratio 100, over the catalogue's", "ratio 50", "ratio 50 over 100", "catalogue"), [
        (f"{size}", over(a, a["catalogue"])[0], over(b, b["catalogue"])[0], over(b, a["k"])[0], over({"k": b["catalogue"]}, a["catalogue"])[0])
        for size, (a, b) in pairs.items()]


def drive_shares():
    """Shares of the twist at the rated torque [%]."""
    names = ("cup", "ring", "balls", "teeth", "spline", "gaps", "slip", "joint")
    return ("drive", *names), [(r["drive"].replace("_", "-"), *(f"{100 * r['shares'][n]:.0f}" for n in names)) for r in drive_rows() if r["drive"] in ("14", "20", "20_50", "20_160")]


def drive_slopes():
    """Slope of size 20 over each 5 N m, by fit, and K_TS as built."""
    def halves(slope):
        return [2 / (1 / a + 1 / b) for a, b in zip(slope[::2], slope[1::2])]
    rows = drive_rows("slopes")
    out = [("bonded" if r["fit"] == "bonded" else f"{r['fit']} µm", *(f"{v:.0f}" for v in halves(r["slope"]))) for r in rows]
    built = next(r for r in rows if r["fit"] == "9")
    return ("clearance", *(f"to {t:g}" for t in built["torque_nm"][2::2])), [*out, ("K_TS, 9 µm", *(f"{k:.0f}" for k in built["k_ts_bonded"][1::2]))]


def cause(size, row):
    """K1 to K3 of a case over the catalogue and what else it reads."""
    from drive_catalogue import CATALOGUE
    return *over(row, CATALOGUE[size] / 1e3), f"{row['hysteresis_arcmin']:.2f}', {row['lost_motion_arcmin']:.2f}'", \
        "-" if row["k_ts_bonded"] is None else f"{digits(row['k_ts_bonded'], 3)} / {digits(row['k_ts_contact'], 3)}"


READ = ("K1 / K2 / K3 over the catalogue's", "K2/K1, K3/K1 over", "hysteresis, lost motion", "K_TS, bonded / contact")


def drive_causes():
    """What fit, play, gluing and what holds the ring along the axis change."""
    return ("size", "case", *READ), [
        (r["drive"], r["case"], *cause(r["drive"], r)) for r in drive_rows("causes")]


def drive_bands():
    """95 % bands over the catalogue, how wide they are, and the inputs that make them."""
    def cells(r):
        low, high, known = (np.array(r[k]) for k in ("low", "high", "catalogue"))
        return (r["drive"].replace("_", "-"), *(f"{a:.2f} to {b:.2f}" for a, b in zip(low / known, high / known)), " / ".join(f"{w:.2f}" for w in high / low), " / ".join(f"{w:.2f}" for w in r["known"]),
                ", ".join(f"`{key.split('.')[1]}` {100 * share:.0f} %" for key, share in list(r["shares"].items())[:2]))
    return ("drive", "K1 over the catalogue's", "K2", "K3", "high over low", "fit, housing known", "what makes K2's"), [cells(r) for r in drive_rows("bands")]


def drive_history():
    """What the drive has been through."""
    return ("size", "history", *READ), [(r["drive"], f"`{r['history']}`", *cause(r["drive"], r)) for r in drive_rows("history")]


def premises():
    """Trends of the paper by premise, in both readings of K_TS: plain drives and cups, and all that give two trends; then counts."""
    from paper_comparison import GROUPS, READINGS

    def shown(found):
        changes = [found[f"{what}_percent"] for what in ("rise", "fall", "gain")]
        return [*("-" if v is None else f"{v:+.0f}" for v in changes), " ".join(t[0].upper() for t in found["trends"].split()) or "-"]
    record = read_record("paper_comparison")
    rows = [r for group in GROUPS for r in record[group]]
    out = [(r["premise"].replace("clearance -10", "interference 10"), " / ".join("-" if v is None else digits(v / 1e3, 3) for v in r["bonded_nm_per_rad"]), *shown(r["bonded"]), *shown(r["eq45"]))
           for r in rows if r["premise"].startswith(("drive", "cup")) and r["premise"].count(",") == 1
           or any(len(r[reading]["trends"].split()) > 1 for reading in READINGS)]
    counts = {reading: ", ".join(f"{name[0].upper()} {sum(name in r[reading]['trends'].split() for r in rows)}" for name in ("torque", "eccentricity", "w"))
              for reading in READINGS}
    return ("premise", "bonded reading at 1 / 3 / 5 N m", "torque", "e", "w", "has", "Eq. 45: torque", "e", "w", "has"), [
        *out, (f"all {len(rows)}", *[""] * 4, counts["bonded"], *[""] * 3, counts["eq45"])]


def paper_bench():
    """The paper's test beside the drive of size 14."""
    found = read_record("paper_comparison")["bench"]
    return ("torque / N m", "paper / (kN m/rad)", "slope", "chord from 0"), [
        (f"{t:g}", f"{p / 1e3:.2f}", f"{s / 1e3:.2f}", f"{c / 1e3:.2f}") for t, p, s, c in zip(found["torque_nm"], (2723.75, 5294), found["slope"], found["chord"])]


# --- surfaces and joints

def fits():
    """The fit told nothing, by the size of the maps."""
    found, out = read_record("blind_fit"), []
    groups = {"128², lines of 4096": found["maps"]} | {f"{n}²": {k: v for k, v in found["sizes"].items() if k.endswith(f", {n}")} for n in (256, 512, 1024)}
    for name, rows in groups.items():
        count = sum(v["maps"] for v in rows.values())
        inside = [sum(v["maps"] * v[k] for v in rows.values()) / count for k in ("cover_d", "cover_g", "fractal")]
        worst = max(rows, key=lambda k: abs(rows[k]["bias"]))
        out.append((name, len(rows), count, *(f"{100 * x:.0f} %" for x in inside[:2]), f"{100 * (1 - inside[2]):.1f} %",
                    f"{min(v['std'] for v in rows.values()):.3f} to {max(v['std'] for v in rows.values()):.3f}", f"{rows[worst]['bias']:+.3f} ({worst.split(',')[0]})"))
    return ("points", "kinds and D", "maps", "D inside", "G inside", "refused", "scatter of D", "largest bias of ten maps"), out


def kinds():
    """Maps that are not fractal."""
    found = read_record("blind_fit")["kinds"]
    called = {name: v["called_fractal"] for name, v in found.items() if v["called_fractal"]}
    return ("maps that are not fractal", "called fractal", "which"), [
        (f"{sum(v['of'] for v in found.values())} of {len(found)} kinds", sum(called.values()), ", ".join(f"{name} {n}" for name, n in called.items()))]


def faults():
    """What wrong points and seams do to D."""
    def each(row, key, text, scale=1):
        return "/".join("-" if row[d][key] is None or row[d][key] != row[d][key] else text.format(scale * row[d][key]) for d in ("2.1", "2.5", "2.9"))
    return ("fault", "D moved, median", "largest", "found / %"), [
        (r["fault"], each(r, "moved", "{:.3f}"), each(r, "moved_most", "{:.2f}"), each(r, "found", "{:.0f}", 100))
        for r in read_record("blind_fit")["faults"]]


def joint_law():
    """Theory over boundary elements on maps that set nothing: nine of ten ratios by kind and contact."""
    rows, out = read_record("joint_law")["maps"], []

    def nine(maps, name, low, high):
        e = np.concatenate([np.array(r[name])[(np.array(r["contact"]) > low) & (np.array(r["contact"]) <= high)] for r in maps])
        return " to ".join(f"{x:.2f}" for x in np.exp(np.quantile(e, (0.05, 0.95))))

    for kind in dict.fromkeys(r["kind"] for r in rows):
        maps = [r for r in rows if r["kind"] == kind]
        held = np.concatenate([abs(np.array(r["ln_k"])) <= r["half_width"] for r in maps])
        out.append((kind, len(maps), *(nine(maps, "ln_k", *ends) for ends in ((0, 0.05), (0.05, 0.6), (0.6, 0.9))),
                    nine(maps, "ln_contact", 0, 1), nine(maps, "ln_gap", 0, 0.9), f"{100 * held.mean():.0f} %"))
    return ("maps", "number", "k_N to 5 %", "k_N, 5 to 60 %", "k_N, 60 to 90 %", "contact", "gap to 90 %", "inside"), out


def joint_rule():
    """Where the planner takes the theory: the error of k_N there."""
    names = {"1": "none", "2": "1/2", "4": "1/4", "cut": "cut out of a larger map"}
    return ("roll-off over the map", "scatter of maps", "theory taken", "within 25 %", "within 10 %", "largest error"), [
        (names.get(kind, kind), f"{100 * r['least_scatter']:.0f} to {100 * r['most_scatter']:.0f} %", f"{r['taken']} of {r['of']}",
         *(f"{100 * r[f'within_{x}_percent'] / r['taken']:.0f} %" for x in (25, 10)), f"{100 * r['largest_error']:.0f} %")
        for kind, r in read_record("joint_choice")["rule"].items()]


def joint_fewer():
    """Boundary elements on averaged maps."""
    return ("points", "what averaging takes", "contact", "within 10 %", "rms error", "largest"), [
        (f"{r['points']}²", "added" if r["with_theory"] else "left out", r["contact"], f"{r['within_10_percent']} of {r['pressures']}",
         percent(r["rms_error"], 1, ""), percent(r["largest_error"], 0, "")) for r in read_record("joint_choice")["fewer"] if r["with_theory"] or r["points"] == 64]


def joint_shear():
    """The law of shear beside boundary elements, by surface; ranges over three shares of contact."""
    rows, out = read_record("joint_shear")["patches"], []
    for surface in dict.fromkeys(r["surface"] for r in rows):
        def span(name, surface=surface):
            values = [100 * r[name] for r in rows if r["surface"] == surface]
            return f"{min(values):.1f} to {max(values):.1f}"
        out.append((surface, *(span(f"{law}_{part}_error") for law in ("law", "theory") for part in ("curve", "loop"))))
    return ("surface", "loading, own k_N", "loop, own k_N", "loading, theory", "loop, theory"), out


def joint_measured():
    """Measured joints over the law at the ends of their pressures."""
    return ("joint", "joints", "pressure / MPa", "mean over law", "largest over smallest"), [
        (r["joint"].replace("um", "µm"), r["joints"], " to ".join(f"{p / 1e6:.2g}" for p in r["pressure_pa"]),
         " to ".join(f"{x:.2f}" for x in r["mean_over_law"]), " to ".join(f"{x:.1f}" for x in r["spread"]) if r["joints"] > 1 else "-")
        for r in read_record("joint_measured")["rows"]]


# --- stability and planner

GROUPS = {"drive": "whole drives", "scene": "contact scenes", "heights": "heights", "joint": "joint of Hu et al.", "theory": "theory of the joint",
          "fit": "fit of D, told nothing"}


def maps():
    """Cells of the maps of hard parameters by verdict, by what they are of."""
    kinds, counts = ("right", "refused", "slow", "wrong"), {}
    for m in read_record("stability")["maps"]:
        first = m["name"].split("_")[0]
        group = "drive" if m["title"].startswith("Whole drive") else first if first in GROUPS else "scene"
        counts.setdefault(group, []).append([sum(row.count(v) for row in m["verdict"]) for v in kinds])
    return ("maps of", "maps", *kinds), [(GROUPS[group], len(rows), *map(sum, zip(*rows))) for group, rows in counts.items()]


def random_runs():
    """Outcomes of random scenes and drives."""
    return ("random", "runs", "converged", "else", "iterations, 95 %"), [
        (name, r["count"], r["outcomes"].get("converged", 0), ", ".join(f"{what.removeprefix('stopped at a ').removeprefix('run in a ')} {n}" for what, n in r["outcomes"].items() if what != "converged") or "-",
         f"{r['iterations_per_step_median']:.0f}, {r['iterations_per_step_95']:.0f}") for name, r in read_record("random_runs").items() if name != "commits"]


def planned():
    """Meshes, times and limits by tolerance."""
    return ("tolerance", "facets", "layers", "time / s", "limit of the tangent / (MN m/rad)"), [
        (f"{r['tolerance']:g}", f"{r['mesh'][0]} x {r['mesh'][1]}", r["layers"], digits(r["cpu_s"]), f"{r['k_ts_bonded_nm_per_rad'] / 1e6:.3f}")
        for r in read_record("readings")["planned"]]


def is_judged(run):
    """All that a promise names is judged, or one of it is beyond the tolerance; the peak, which the refinement does not wait for, need not be."""
    errors = [error for name, (_, error) in run["results"].items() if name != "pressure_mid_max_pa"]
    return None not in errors or max(known(run), default=0) > run["tolerance"]


def known(run):
    """True errors of the results that are judged."""
    return [error for _, error in run["results"].values() if error is not None]


def promises(*records):
    """Promised and kept by record and tolerance."""
    out = []
    for record, what in records or (("promised_scenes", "scenes"), ("promised_drives", "whole drives")):
        rows = [*read_rows(record, "scene").values()]
        for tolerance in sorted({t for row in rows for t in row["asked"]}, reverse=True):
            made = [run for row in rows for run in row["runs"] if run["tolerance"] == tolerance]
            whole = [run for run in made if is_judged(run)]
            worst = [max(known(run)) for run in whole]
            out.append((what, f"{100 * tolerance:g} %", sum(tolerance in row["asked"] for row in rows), len(made), len(whole), sum(w <= tolerance for w in worst),
                        percent(median(worst), 1, ""), percent(max(worst), 1, ""),
                        f"{median(max(e for e, _ in run['results'].values()) / w for run, w in zip(whole, worst)):.1f}", f"{median(r['seconds'] for r in made):.0f}"))
    return ("planned", "tolerance", "asked", "promised", "judged", "kept", "median error", "largest", "estimate over it", "CPU s"), out


def promised_results():
    """Errors of what is promised, by result."""
    from promised import NAMES
    runs = [run for row in read_rows("promised_scenes", "scene").values() for run in row["runs"]]
    out = []
    for name, words in NAMES.items():
        pairs = [(run["tolerance"], *run["results"][name]) for run in runs if run["results"].get(name, (0, None))[1] is not None]
        out.append((words, len(pairs), percent(median(e for *_, e in pairs), 1, ""), percent(max(e for *_, e in pairs), 1, ""),
                    sum(e > estimate for _, estimate, e in pairs), sum(e > t for t, _, e in pairs)))
    return ("result", "judged", "median error", "largest", "above its estimate", "above the tolerance"), out


# --- charts and records

def figures():
    """The charts, one by one, with the error and the time of the default."""
    from pareto import section
    return "\n\n".join(map(section, read_record("pareto")["charts"]))


def loop_time():
    """Processor time of drive14 by part, before and now."""
    found = read_record("gradient")
    before, now = found["before"], found["now"]
    return ("part", "before / s", "now / s"), [(part, digits(before[part]), digits(now[part]))
                                              for part in sorted(before, key="total".__eq__)]


def thread_gain():
    """Wall clock of one thread, the gain of more, and that of all of them before."""
    rows = read_record("threads")
    seconds = {(r["engine"], r["scene"], r["threads"]): r["wall_s"] for r in rows}
    one, *more = sorted({r["threads"] for r in rows})

    def gain(engine, scene, n):
        return digits(seconds[engine, scene, one] / seconds[engine, scene, n])
    return ("scene", "1 thread / s", *map(str, more), f"{more[-1]}, before"), [
        (scene, digits(t), *(gain("now", scene, n) for n in more), gain("before", scene, more[-1]))
        for (engine, scene, n), t in seconds.items() if (engine, n) == ("now", one)]


def gradient_cost():
    """Cost of a gradient and of a band by scene, in runs."""
    return ("scene", "keys", "gradient / runs", "band / runs"), [(r["scene"], r["keys"], digits(r["gradient_over_run"]), digits(r["band_over_run"])
                                                                  if r["band_over_run"] else "") for r in read_record("gradient")["cost"]]


TABLES = {  # marker: page from docs on, records, builder
    "headline": ("../README", ["drive_catalogue"], headline),
    "elements": ("evidence/accuracy", ["elements"], elements),
    "closed": ("evidence/accuracy", ["court"], closed),
    "meshes": ("evidence/accuracy", ["readings"], meshes),
    "steps": ("evidence/accuracy", ["readings"], steps),
    "kinematics": ("evidence/accuracy", ["readings"], kinematics),
    "fits": ("evidence/surfaces", ["blind_fit"], fits),
    "kinds": ("evidence/surfaces", ["blind_fit"], kinds),
    "faults": ("evidence/surfaces", ["blind_fit"], faults),
    "joint-law": ("evidence/joint", ["joint_law"], joint_law),
    "joint-rule": ("evidence/joint", ["joint_choice"], joint_rule),
    "joint-fewer": ("evidence/joint", ["joint_choice"], joint_fewer),
    "joint-shear": ("evidence/joint", ["joint_shear"], joint_shear),
    "joint-measured": ("evidence/joint", ["joint_measured"], joint_measured),
    "planned": ("evidence/planner", ["readings"], planned),
    "promises": ("evidence/planner", ["promised_scenes", "promised_drives"], promises),
    "promised-results": ("evidence/planner", ["promised_scenes"], promised_results),
    "figures": ("evidence/speed_accuracy", ["pareto"], figures),
    "loop-time": ("evidence/speed_accuracy", ["gradient"], loop_time),
    "thread-gain": ("evidence/speed_accuracy", ["threads"], thread_gain),
    "gradient-cost": ("evidence/speed_accuracy", ["gradient"], gradient_cost),
    "maps": ("evidence/stability", ["stability"], maps),
    "random": ("evidence/stability", ["random_runs"], random_runs),
    "peer-hub": ("evidence/peers", ["peer_hub"], peer_hub),
    "peer-drive": ("evidence/peers", ["peer_drive"], peer_drive),
    "court": ("evidence/peers", ["court"], court),
    "heights": ("evidence/peers", ["height_peers"], heights),
    "premises": ("evidence/comparison", ["paper_comparison"], premises),
    "paper-bench": ("evidence/comparison", ["paper_comparison"], paper_bench),
    "drive-sizes": ("evidence/drive", ["drive_catalogue"], drive_sizes),
    "drive-kin": ("evidence/drive", ["drive_catalogue"], drive_kin),
    "drive-shares": ("evidence/drive", ["drive_catalogue"], drive_shares),
    "drive-slopes": ("evidence/drive", ["drive_catalogue"], drive_slopes),
    "drive-causes": ("evidence/drive", ["drive_catalogue"], drive_causes),
    "drive-bands": ("evidence/drive", ["drive_catalogue"], drive_bands),
    "drive-history": ("evidence/drive", ["drive_catalogue"], drive_history),
    "frictions": ("evidence/inputs", ["readings"], frictions),
    "joints": ("evidence/inputs", ["readings"], joints),
    "indices": ("evidence/inputs", ["sensitivity"], indices),
}


def text_of(marker):
    """What stands between the markers of a table."""
    made = TABLES[marker][2]()
    return made if isinstance(made, str) else table(*made)


def write():
    """Put every table on its page."""
    for marker, (page, *_) in TABLES.items():
        put(marker, text_of(marker), page)


if __name__ == "__main__":
    write()
