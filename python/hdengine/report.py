# SPDX-License-Identifier: GPL-3.0-or-later
"""One self-contained HTML file of a run, of a study, or of a comparison with its studies; PDF on request."""
import base64
import datetime
import html
import json
import os
import warnings
from pathlib import Path

import numpy as np

from . import _engine, paper
from ._engine import FileError, InputError
from .picture import PictureError, draw_cup
from .results import Result
from .study import StudyResult
from .surface_run import SurfaceResult
from .uncertainty import scene_joint

_STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}
h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2em;border-bottom:1px solid #ccc}table{border-collapse:collapse;font-size:.85em}
td,th{padding:.2em .7em;border-bottom:1px solid #ddd;text-align:right}
td:first-child,th:first-child,.text{text-align:left}
.scroll{overflow-x:auto}img{max-width:100%}.warning{background:#fff3cd;padding:.5em 1em;border-left:4px solid #e0a800}
.bad{background:#f8d7da;padding:.5em 1em;border-left:4px solid #c00}figcaption{color:#555;font-size:.9em}pre{white-space:pre-wrap}
@page{size:A4;margin:15mm}@media print{details{display:block}body{max-width:none;font-size:11px}table{font-size:8px}
td,th{padding:1px 4px}
.scroll{overflow:visible}.screen{display:none}figure{break-inside:avoid}}"""
_CITE = """hdengine {version}. Model: Hu, Li, Wang, Li (2023), Front. Mater. 10:1211019, doi:10.3389/fmats.2023.1211019
Solvers: MUMPS (Amestoy, Duff, L'Excellent, Koster 2001), METIS (Karypis, Kumar 1998)"""
_CAPTIONS = {
    "positions.png": "Contact stress over the angle in the rows next to Positions I, II, III.",
    "pressure_band.png": "Contact pressure on the unrolled band, last step.",
    "pressure_steps.png": "Contact pressure on the unrolled band over the torque.",
    "torsion.png": "Torsional stiffness by Eq. 45, the printed form, and the FE rotation.",
    "newton.png": "Convergence: relative residual of every Newton iterate.",
}


def _text(value):
    """A value for a cell."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        return html.escape(str(value).strip())
    return f"{value:.6g}"


def _table(columns, rows):
    rows = [list(row) for row in rows]
    words = [any(isinstance(row[i], str) and row[i] for row in rows) for i in range(len(columns))]
    mark = [' class="text"' if word else "" for word in words]
    head = "".join(f"<th{m}>{html.escape(str(c)).replace('_', '_<wbr>')}</th>" for c, m in zip(columns, mark))
    body = "".join("<tr>" + "".join(f"<td{m}>{_text(v)}</td>" for v, m in zip(row, mark)) + "</tr>" for row in rows)
    return f'<div class="scroll"><table><tr>{head}</tr>{body}</table></div>'


def _image(path, caption):
    data = base64.b64encode(Path(path).read_bytes()).decode()
    kind, screen = Path(path).suffix[1:], ' class="screen"' if Path(path).suffix == ".gif" else ""
    return f'<figure{screen}><img alt="{html.escape(caption)}" src="data:image/{kind};base64,{data}">' \
           f"<figcaption>{html.escape(caption)}</figcaption></figure>"


def _pairs(mapping):
    return _table(("key", "value"), [(k, ", ".join(map(_text, v)) if isinstance(v, list) else v) for k, v in mapping.items()])


def _warnings(texts):
    return "".join(f'<p class="warning">{html.escape(w)}</p>' for w in texts)


def _comparison(rows):
    """Section with rows of `paper`; nothing where there are none."""
    if rows:
        text = "<p>What the paper states, ours, and a verdict; every row is computed from the results.</p>"
        yield "Compared with Hu et al. (2023)", text + _table(paper.Row.HEAD, [r.cells() for r in rows])


def _plan(scene, planned):
    """What was planned and why, or the mesh alone."""
    text = f"<p>{scene['mesh.divisions']} x {scene['mesh.band_facets']} facets, {scene['load.assembly_steps']} + " \
           f"{scene['load.torque_steps']} load steps"
    if not planned:
        return text + ", as the scene says: no tolerance was stated (<code>run.tolerance</code>; <code>hdengine plan</code>).</p>"
    reasons = "".join(f"<li>{html.escape(line)}</li>" for line in planned["reasons"])
    return text + ".</p>" + _pairs({k: str(v) for k, v in planned.items() if k != "reasons"}) + f"<ul>{reasons}</ul>"


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


def _run_parts(result, picture):
    """(heading, HTML) of a run."""
    from .plot import animate, plot_run

    s = result.summary
    if not result.complete:
        yield "Ended early", f'<p class="bad">{html.escape(s["message"])}</p>'
    k, printed = result.torsional_stiffness()
    yield "Result", _pairs({
        "torque / N m": result.torque_nm[-1], "K_TS by Eq. 45 / (N m/rad)": k[-1], "Eq. 45 as printed / N": printed[-1],
        "rotation / rad": s["results"]["rotation_rad"], "normal force / N": s["results"]["normal_force_n"],
        "peak pressure at a node / Pa (grows with a finer mesh)": s["results"]["pressure_max_pa"]}) + \
        "<p>The magnitude of K_TS rests on r_m and s_min, which are inputs; trends can be trusted.</p>"
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
    yield "Load steps", _table([*names, "k_ts_nm_per_rad"], [[*(row[n] for n in names), value] for row, value in zip(steps, k)])
    yield "Plan", _plan(result.scene, s.get("plan"))
    yield "Convergence", _image(result.folder / "newton.png", _CAPTIONS["newton.png"]) + _pairs(
        {k: s["results"][k] for k in ("steps", "iterations", "cut_backs", "torque_balance_nm", "axial_balance_n")})
    yield "Model", _pairs({**s["model"], **{f"time {k} / s": v for k, v in s["timers_s"].items()},
                           "peak memory / MB": s["peak_memory_mb"]})
    yield "Joint", _pairs(s["joint"])
    yield "Inputs", f"<details><summary>all keys, SI units</summary>{_pairs(s['scene'])}</details>"
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
    yield "Points", _table(names, [[r.get(n, "") for n in names] for r in result.rows if r["status"] == "done"])
    yield "Convergence", _study_convergence(result.rows)
    yield "Inputs", f"<p>Fixed:</p>{_pairs(s['identity']['fixed'])}<details><summary>all keys of the first point</summary>" \
                    f"{_pairs(s['scene'])}</details>"
    yield "Provenance", _pairs({"hdengine": s["hdengine"], "SHA-256 of the scene": s["identity"]["scene_sha256"]})


def _surface_parts(result):
    """(heading, HTML) of a surface run."""
    yield "Result", f"<pre>{html.escape(str(result))}</pre>"
    yield "Figures", "".join(_image(p, Path(p).stem.replace("_", " ")) for p in result.plot() if Path(p).suffix == ".png")
    for name in ("scene", "provenance"):
        if result.summary.get(name):
            yield name.capitalize().replace("Scene", "Inputs"), _pairs(result.summary[name])


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
