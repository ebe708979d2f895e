# SPDX-License-Identifier: GPL-3.0-or-later
"""One self-contained HTML file of a run, of a study, or of a comparison with its studies; PDF on request."""
import base64
import datetime
import html
import json
import os
import re
import warnings
from pathlib import Path

import numpy as np

from . import _engine, paper
from ._engine import FileError, InputError
from .contact import read_scene
from .picture import PictureError, draw_cup
from .results import Result
from .study import StudyResult, read_rows
from .surface_run import SurfaceResult
from .uncertainty import scene_joint

_STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}
h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2em;border-bottom:1px solid #ccc}table{border-collapse:collapse;font-size:.85em}
td,th{padding:.2em .7em;border-bottom:1px solid #ddd;text-align:right}
td:first-child,th:first-child,.text{text-align:left}
.scroll{overflow-x:auto}figure{margin:1em 0}img{max-width:100%}
.warning{background:#fff3cd;padding:.5em 1em;border-left:4px solid #e0a800}
.bad{background:#f8d7da;padding:.5em 1em;border-left:4px solid #c00}figcaption{color:#555;font-size:.9em}pre{white-space:pre-wrap}
@page{size:A4;margin:15mm}@media print{details{display:block}body{max-width:none;font-size:11px}table{font-size:8px}
td,th{padding:1px 4px}
.scroll{overflow:visible}.screen{display:none}figure{break-inside:avoid}img{max-height:115mm}h2{break-after:avoid}}
.groups{columns:2;column-gap:2em}.groups table{width:100%;margin-bottom:1em}.groups th{color:#555}
@page{@bottom-right{content:counter(page) " / " counter(pages);font:9px sans-serif;color:#555}}"""
_CITE = """hdengine {version}. Model: Hu, Li, Wang, Li (2023), Front. Mater. 10:1211019, doi:10.3389/fmats.2023.1211019
Solvers: MUMPS (Amestoy, Duff, L'Excellent, Koster 2001), METIS (Karypis, Kumar 1998)"""
_CAPTIONS = {
    "positions.png": "Contact stress over the angle in the rows next to Positions I, II, III.",
    "pressure_band.png": "Contact pressure on the unrolled band, last step.",
    "pressure_steps.png": "Contact pressure on the unrolled band over the torque.",
    "torsion.png": "Stiffness and rotation over the torque.",
    "newton.png": "Convergence: relative residual of every Newton iterate.",
}


def _text(value):
    """A value for a cell."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        return html.escape(str(value).strip())
    return "-" if np.isnan(value) else f"{value:.6g}" if isinstance(value, (int, np.integer)) else f"{value:.5g}"


def _table(columns, rows):
    rows = [list(row) for row in rows]
    words = [any(isinstance(row[i], str) and row[i] for row in rows) for i in range(len(columns))]
    mark = [' class="text"' if word else "" for word in words]
    head = "".join(f"<th{m}>{html.escape(str(c)).replace('_', '_<wbr>')}</th>" for c, m in zip(columns, mark))
    body = "".join("<tr>" + "".join(f"<td{m}>{_text(v)}</td>" for v, m in zip(row, mark)) + "</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _columns(names, rows):
    """Columns of a table of load steps, in the units of the figures."""
    from .plot_study import label

    heads, factors = zip(*(label(name) for name in names))
    heads = [re.sub(r"[${}]", "", head).split(" / ", 1) for head in heads]  # a unit is not broken
    return _table([" /\u00a0".join([*h[:1], *(u.replace(" ", "\u00a0") for u in h[1:])]) for h in heads], [
        [v * f if f != 1 and not isinstance(v, str) else v for v, f in zip(row, factors)] for row in rows])


def _image(path, caption):
    data = base64.b64encode(Path(path).read_bytes()).decode()
    kind, screen = Path(path).suffix[1:], ' class="screen"' if Path(path).suffix == ".gif" else ""
    return f'<figure{screen}><img alt="{html.escape(caption)}" src="data:image/{kind};base64,{data}">' \
           f"<figcaption>{html.escape(caption)}</figcaption></figure>"


def _pairs(mapping):
    """Two columns; empty values are left out."""
    return _table(("key", "value"), [(k, ", ".join(map(_text, v)) if isinstance(v, list) else v) for k, v in mapping.items()
                                     if v not in ("", "none")])


def _inputs(scene):
    """One table per group of the keys of a drive; those that differ from the default are bold."""
    default, tables = read_scene(), {}
    for key, value in scene.items():
        group, name = key.split(".", 1)
        if group not in ("surface", "fit"):
            text = ", ".join(map(_text, value)) if isinstance(value, list) else _text(value)
            tables.setdefault(group, []).append((name, f"<b>{text}</b>" if value != default.get(key) else text))
    body = ""
    for group, rows in tables.items():
        cells = "".join(f"<tr><td>{html.escape(name)}</td><td>{text}</td></tr>" for name, text in rows)
        body += f'<table><tr><th class="text" colspan="2">{html.escape(group)}</th></tr>{cells}</table>'
    return f'<details><summary>all keys, SI units; bold: not the default</summary><div class="groups">{body}</div></details>'


def _warnings(texts):
    return "".join(f'<p class="warning">{html.escape(w)}</p>' for w in texts)


def _comparison(rows):
    """Section with rows of `paper`; nothing where there are none."""
    if rows:
        text = "<p>What the paper states, ours, and a verdict; every row is computed from the results.</p>"
        yield "Compared with Hu et al. (2023)", text + _table(paper.Row.HEAD, [r.cells() for r in rows])


_PROMISED = {"K_TS / (MN m/rad)": 1e-6, "normal force / N": 1, "mid-band pressure / MPa": 1e-6}
_PLANNED = ("k_ts_nm_per_rad", "normal_force_n", "pressure_mid_mean_pa", "seconds")


def _mesh(text):
    """36x6_edge_5.0e-4_layers_1_1_steps_1_1_hex8i_linear as words."""
    words = text.split("_")
    if len(words) < 10:
        return text
    edge = f"{1e6 * float(words[2]):.4g} µm" if float(words[2]) else "none"
    return f"{words[0].replace('x', ' x ')}, {edge}, {words[4]} + {words[5]}, {words[7]} + {words[8]}, " \
           f"{' '.join(words[9:])}"


def _plan(result):
    """What was planned and why, or the mesh alone."""
    folder, planned, (around, along) = result.folder, result.summary.get("plan"), result.shape
    steps = " + ".join(str(result.scene[f"load.{name}_steps"]) for name in ("assembly", "torque"))
    text = f"<p>{around} x {along} facets, {steps} load steps"
    if not planned:
        return text + ", as the scene says: no tolerance was stated (<code>run.tolerance</code>; <code>hdengine plan</code>).</p>"
    kept = planned["met"] == "yes"
    text += f'.</p><p{"" if kept else " class=bad"}>Tolerance {planned["tolerance"]:g}: {"met" if kept else "not met"} ' \
        "by the estimate.</p>"
    if result.limits:
        rows = [[name, factor * value, f"{100 * error:.2g}", f"{100 * (mesh - 1):+.2g}"]
                for (name, factor), (value, error, mesh) in zip(_PROMISED.items(), result.limits.values())]
        text += "<p>What is promised of the last step:</p>" + _table(
            ("quantity", "limit of fine meshes", "known to / %", "this mesh above it / %"), rows)
    reasons = "".join(f"<li>{html.escape(line)}</li>" for line in planned["reasons"])
    text += f"<p>Why (changes are relative, the largest of the three quantities):</p><ul>{reasons}</ul>"
    if (folder / "plan.csv").is_file():
        rows = [[_mesh(r["mesh"]), *(r[n] for n in _PLANNED)] for r in read_rows(folder / "plan.csv")]
        head = ("facets without edge cells, edge cells, layers, steps, element", *_PLANNED)
        text += "<p>Solved for it:</p>" + _columns(head, rows)
    return text


def _sensitivity(folder):
    """Figures and bands that `hdengine sensitivity` left in the folder."""
    path = folder / "sensitivity.json"
    if path.is_file():
        found = json.loads(path.read_text())
        text = _table(("what varies", "low", "median", "high"), [(k, *v) for k, v in found["bands_95_nm_per_rad"].items()])
        if found.get("indices"):
            text += "<p>Shares of the variance (Sobol) with the half width of their 95 % band:</p>" + _table(
                ("key", "first order", "+-", "total", "+-"), [(k, *v) for k, v in found["indices"].items()])
        pictures = "".join(_image(p, "Change of K_TS between the ends of its range.") for p in sorted(folder.glob("tornado_*.png")))
        yield "Uncertainty of K_TS", "<p>95 % bands / (N m/rad):</p>" + text + pictures


def _stiffness(result):
    """Results by name, stiffness of each step, and what they rest on."""
    if result.against_teeth:
        k, found = result.secant_stiffness(), {"K_FTS": "no torque"}
        if result.torque_nm[-1] != 0:
            share = 100 * result.teeth["share"][result.teeth["step"] == result.steps["step"][-1]]
            found = {"K_FTS, torque over rotation / (kN m/rad)": 1e-3 * k[-1],
                     "share of a pair of teeth, smallest and largest / %": f"{share.min():.1f}, {share.max():.1f}"}
        return found, k, \
            "The ring is bonded to the flexspline: no K_TS of the contact is computed here (Eq. 46 puts both in series)."
    k, printed = result.torsional_stiffness()
    found = {"K_TS by Eq. 45 / (MN m/rad)": 1e-6 * k[-1], "Eq. 45 as printed / MN": 1e-6 * printed[-1]}
    if result.limits:
        limit, error, _ = result.limits["k_ts_nm_per_rad"]
        found["K_TS, limit of fine meshes / (MN m/rad)"] = f"{1e-6 * limit:.4g}, known to {100 * error:.2g} %"
    return found, k, \
        "The magnitude of K_TS rests on r_m and s_min, which are inputs; trends can be trusted."


def _run_parts(result, picture):
    """(heading, HTML) of a run."""
    from .plot import animate, plot_run

    s = result.summary
    if not result.complete:
        yield "Ended early", f'<p class="bad">{html.escape(s["message"])}</p>'
    stiffness, k, note = _stiffness(result)
    yield "Result", _pairs({
        "torque / N m": result.torque_nm[-1], **stiffness,
        "rotation / µrad": 1e6 * s["results"]["rotation_rad"], "normal force / N": s["results"]["normal_force_n"],
        "peak pressure at a node / MPa (grows with a finer mesh)": 1e-6 * s["results"]["pressure_max_pa"]}) + f"<p>{note}</p>"
    if s["warnings"]:
        yield "Warnings", _warnings(s["warnings"])
    figures = "".join(_image(p, _CAPTIONS.get(p.name, p.stem)) for p in plot_run(result) if p.name != "newton.png")
    if len(result.steps) > 1:
        figures += _image(animate(result, result.folder / "steps.gif"), "Pressure and shear on the unrolled band, step by step.")
    if picture:
        try:
            scale = draw_cup(result, result.folder / "cup.png")
            figures += _image(result.folder / "cup.png", f"The cup cut open, displacements times {scale:g}; pressure on the ring.")
        except PictureError as why:
            figures += _warnings([f"3-D picture left out: {why}"])
    yield "Figures", figures
    yield from _comparison(paper.of_run(result))
    yield from _sensitivity(result.folder)
    steps = result.steps
    names = [n for n in ("step", "phase", "torque_nm", "rotation_rad", "normal_force_n", "contact_area_m2", "pressure_max_pa",
                         "friction_torque_nm", "torque_balance_nm", "iterations") if n in steps.dtype.names]
    name = "k_fts_nm_per_rad" if result.against_teeth else "k_ts_nm_per_rad"
    yield "Load steps", _columns([*names, name], [[*(row[n] for n in names), value] for row, value in zip(steps, k)])
    yield "Plan", _plan(result)
    yield "Convergence", _image(result.folder / "newton.png", _CAPTIONS["newton.png"]) + _pairs(
        {k: s["results"][k] for k in ("steps", "iterations", "cut_backs", "torque_balance_nm", "axial_balance_n")})
    yield "Model", _pairs({**s["model"], **{f"time {k} / s": v for k, v in s["timers_s"].items()},
                           "peak memory / MB": s["peak_memory_mb"]})
    if not result.against_teeth:
        yield "Joint", _pairs(s["joint"])
    yield "Inputs", _inputs(s["scene"])
    yield "Provenance", _pairs(s["provenance"])


def _failures(result):
    swept = result.summary["swept"]
    return _table(("point", *swept, "reason"), [
        (r["point"], *(r.get(k, "") for k in swept), str(r["reason"]).splitlines()[0]) for r in result.failures])


def _study_warnings(result):
    """Where the joint of the first point leaves its range at the highest pressure of the study."""
    peak = np.nanmax([r.get("pressure_max_pa", np.nan) for r in result.rows] + [0.0])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene_joint(result.summary["scene"]).stiffness(peak)
    if caught:
        yield "Warnings", _warnings(dict.fromkeys(str(w.message) for w in caught))


def _study_convergence(rows):
    """Iterations and balance over all load steps."""
    done = [r for r in rows if r["status"] == "done"]
    if not done:
        return "<p>No load step was solved.</p>"
    iterations = [r["iterations"] for r in done]
    return _pairs({"load steps solved": len(done), "Newton iterations of a load step, mean": np.mean(iterations),
                   "most": max(iterations), "time in all / s": sum(r["seconds"] for r in done),
                   "largest torque out of balance / N m": max(abs(r["torque_balance_nm"]) for r in done)})


def _study_parts(result):
    """(heading, HTML) of a study."""
    from .plot_study import plot_study

    s = result.summary
    yield "Result", _pairs({"status": s["status"], "points": s["points"], "solved": s["done"] - s["failed"], "failed": s["failed"],
                            "swept": ", ".join(s["swept"]) or "torque"})
    if result.failures:
        yield "Failed points", _failures(result)
    yield from _study_warnings(result)
    yield "Figure", "".join(_image(p, s["title"]) for p in plot_study(result))
    yield from _comparison(paper.of_study(result))
    names = ["point", *s["swept"], "torque_nm", "k_ts_nm_per_rad", "k_fe_secant_nm_per_rad", "normal_force_n", "pressure_max_pa",
             "rotation_rad"]
    yield "Points", _columns(names, [[r.get(n, "") for n in names] for r in result.rows if r["status"] == "done"])
    yield "Convergence", _study_convergence(result.rows)
    fixed = s["identity"]["fixed"]
    text = f"<p>Fixed at every point:</p>{_pairs(fixed)}" if fixed else ""
    yield "Inputs", f"{text}<p>Of the first point:</p>{_inputs(s['scene'])}"
    yield "Provenance", _pairs({"hdengine": s["hdengine"], "SHA-256 of the scene": s["identity"]["scene_sha256"]})


def _surface_parts(result):
    """(heading, HTML) of a surface run."""
    yield "Result", f"<pre>{html.escape(str(result))}</pre>"
    yield "Figures", "".join(_image(p, "Heights, middle rows, structure functions with their fits.")
                             for p in result.plot() if Path(p).suffix == ".png")
    yield "Inputs", f"<pre>{html.escape((result.folder / 'echo.nml').read_text())}</pre>"
    yield "Provenance", _pairs(result.summary["provenance"])


def _collection_parts(folder):
    """(heading, HTML) of a comparison and of the studies beside it."""
    from .plot_study import plot_study

    rows = json.loads((folder / "comparison.json").read_text())["rows"]
    yield from _comparison([paper.Row(*(row[name] for name in paper.Row.HEAD)) for row in rows])
    for path in sorted(folder.glob("*/study.json")):
        result = StudyResult(path.parent)
        s = result.summary
        text = f"<p>{s['done'] - s['failed']} of {s['points']} points solved, {s['failed']} failed; {path.parent.name}.</p>"
        if result.failures:
            text += f"<details><summary>failed points</summary>{_failures(result)}</details>"
        yield s["title"], text + "".join(_image(p, s["title"]) for p in plot_study(result))
    yield "Provenance", _pairs({"hdengine": _engine.version()})


def _parts(folder, picture):
    """Title and sections of whatever the folder holds."""
    if (folder / "study.json").is_file():
        result = StudyResult(folder)
        return result.summary["title"], [*_study_parts(result)]
    if (folder / "summary.json").is_file():
        summary = json.loads((folder / "summary.json").read_text())
        if summary.get("kind") == "surface":
            return summary.get("title"), [*_surface_parts(SurfaceResult(folder))]
        result = Result(folder)
        return result.summary["title"], [*_run_parts(result, picture)]
    if (folder / "comparison.json").is_file():
        return "hdengine beside Hu et al. (2023)", [*_collection_parts(folder)]
    raise FileError(f"'{folder}' holds neither a run (summary.json) nor a study (study.json)")


def write_report(folder, path=None, picture=True):
    """Write the report of a run, a study or a comparison.

    Parameters
    ----------
    folder : str or Path
        Folder with summary.json, study.json or comparison.json.
    path : str or Path, optional
        HTML file; default: report.html in the folder.
    picture : bool
        3-D picture of a run (needs PyVista; the report says so where it is missing).

    Returns
    -------
    Path

    Raises
    ------
    FileError
        The folder holds none of them.
    """
    folder = Path(folder)
    title, parts = _parts(folder, picture)
    title = title or folder.name
    parts.append(("How to cite", f"<pre>{html.escape(_CITE.format(version=_engine.version()))}</pre>"))
    body = "".join(f"<h2>{html.escape(heading)}</h2>{text}" for heading, text in parts)
    made = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    page = f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>' \
           f"<style>{_STYLE}</style></head>" \
           f"<body><h1>{html.escape(title)}</h1><p>hdengine {_engine.version()}, {made}</p>{body}</body></html>\n"
    path = Path(path) if path else folder / "report.html"
    part = path.with_name(path.name + ".part")
    part.write_text(page, encoding="utf-8")
    os.replace(part, path)
    return path


def write_pdf(path):
    """The report as a PDF beside its HTML file (needs WeasyPrint).

    Raises
    ------
    InputError
        WeasyPrint, or a library of the system that it needs, is not installed.
    """
    try:
        import weasyprint
    except (ImportError, OSError) as why:
        raise InputError("a PDF needs WeasyPrint and its system library Pango: pip install 'hdengine[pdf]', apt install "
                         f"libpangoft2-1.0-0; or print the HTML file from a browser ({str(why).splitlines()[0]})") from None
    out = Path(path).with_suffix(".pdf")
    weasyprint.HTML(filename=str(path)).write_pdf(str(out))
    return out
