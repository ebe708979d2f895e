# SPDX-License-Identifier: GPL-3.0-or-later
"""One self-contained HTML file of a run or a study."""
import base64
import datetime
import html
import os
from pathlib import Path

import numpy as np

from . import _engine
from ._engine import FileError
from .picture import PictureError, draw_cup
from .results import Result
from .study import StudyResult

_STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}
h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2em;border-bottom:1px solid #ccc}table{border-collapse:collapse;font-size:.85em}
td,th{padding:.2em .7em;border-bottom:1px solid #ddd;text-align:right}td:first-child,th:first-child{text-align:left}
.scroll{overflow-x:auto}img{max-width:100%}.warning{background:#fff3cd;padding:.5em 1em;border-left:4px solid #e0a800}
.bad{background:#f8d7da;padding:.5em 1em;border-left:4px solid #c00}figcaption{color:#555;font-size:.9em}pre{white-space:pre-wrap}
@media print{details{display:block}body{max-width:none}}"""
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
    head = "".join(f"<th>{html.escape(str(c))}</th>" for c in columns)
    body = "".join("<tr>" + "".join(f"<td>{_text(v)}</td>" for v in row) + "</tr>" for row in rows)
    return f'<div class="scroll"><table><tr>{head}</tr>{body}</table></div>'


def _image(path, caption):
    data = base64.b64encode(Path(path).read_bytes()).decode()
    return f'<figure><img alt="{html.escape(caption)}" src="data:image/png;base64,{data}">' \
           f"<figcaption>{html.escape(caption)}</figcaption></figure>"


def _pairs(mapping):
    return _table(("key", "value"), [(k, ", ".join(map(_text, v)) if isinstance(v, list) else v) for k, v in mapping.items()])


def _run_parts(result, picture):
    """(heading, HTML) of a run."""
    from .plot import plot_run

    s = result.summary
    if not result.complete:
        yield "Ended early", f'<p class="bad">{html.escape(s["message"])}</p>'
    k, paper = result.torsional_stiffness()
    yield "Result", _pairs({
        "torque / N m": result.torque_nm[-1], "K_TS by Eq. 45 / (N m/rad)": k[-1], "Eq. 45 as printed / N": paper[-1],
        "rotation / rad": s["results"]["rotation_rad"], "normal force / N": s["results"]["normal_force_n"],
        "peak pressure / Pa (grows with a finer mesh)": s["results"]["pressure_max_pa"]}) + \
        "<p>The magnitude of K_TS rests on r_m and s_min, which are inputs; trends can be trusted.</p>"
    if s["warnings"]:
        yield "Warnings", "".join(f'<p class="warning">{html.escape(w)}</p>' for w in s["warnings"])
    figures = "".join(_image(p, _CAPTIONS.get(p.name, p.stem)) for p in plot_run(result) if p.name != "newton.png")
    if picture:
        try:
            scale = draw_cup(result, result.folder / "cup.png")
            figures += _image(result.folder / "cup.png", f"The cup cut open, displacements times {scale:g}; pressure on the ring.")
        except PictureError as why:
            figures += f'<p class="warning">3-D picture left out: {html.escape(str(why))}</p>'
    yield "Figures", figures
    steps = result.steps
    names = [n for n in ("step", "phase", "torque_nm", "rotation_rad", "normal_force_n", "contact_area_m2", "pressure_max_pa",
                         "friction_torque_nm", "torque_balance_nm", "iterations") if n in steps.dtype.names]
    yield "Load steps", _table([*names, "k_ts_nm_per_rad"], [[*(row[n] for n in names), value] for row, value in zip(steps, k)])
    yield "Convergence", _image(result.folder / "newton.png", _CAPTIONS["newton.png"]) + _pairs(
        {k: s["results"][k] for k in ("steps", "iterations", "cut_backs", "torque_balance_nm", "axial_balance_n")})
    yield "Model", _pairs({**s["model"], **{f"time {k} / s": v for k, v in s["timers_s"].items()},
                           "peak memory / MB": s["peak_memory_mb"]})
    yield "Joint", _pairs(s["joint"])
    yield "Inputs", f"<details><summary>all keys</summary>{_pairs(s['scene'])}</details>"
    yield "Provenance", _pairs(s["provenance"])


def _study_parts(result):
    """(heading, HTML) of a study."""
    from .plot_study import plot_study

    s = result.summary
    yield "Result", _pairs({"status": s["status"], "points": s["points"], "solved": s["done"] - s["failed"], "failed": s["failed"],
                            "swept": ", ".join(s["swept"]) or "torque"})
    if result.failures:
        yield "Failed points", _table(("point", *s["swept"], "reason"), [
            (r["point"], *(r.get(k, "") for k in s["swept"]), str(r["reason"]).splitlines()[0]) for r in result.failures])
    yield "Figure", "".join(_image(p, s["title"]) for p in plot_study(result))
    names = ["point", *s["swept"], "torque_nm", "k_ts_nm_per_rad", "k_fe_secant_nm_per_rad", "normal_force_n", "pressure_max_pa",
             "rotation_rad"]
    yield "Points", _table(names, [[r.get(n, "") for n in names] for r in result.rows if r["status"] == "done"])
    yield "Inputs", f"<p>Fixed:</p>{_pairs(s['identity']['fixed'])}<details><summary>all keys of the first point</summary>" \
                    f"{_pairs(s['scene'])}</details>"
    yield "Provenance", _pairs({"hdengine": s["hdengine"], "SHA-256 of the scene": s["identity"]["scene_sha256"]})


def write_report(folder, path=None, picture=True):
    """Write the report of a run or a study.

    Parameters
    ----------
    folder : str or Path
        Folder with summary.json or study.json.
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
        The folder holds neither a run nor a study.
    """
    folder = Path(folder)
    if (folder / "study.json").is_file():
        result = StudyResult(folder)
        title, parts = result.summary["title"] or folder.name, [*_study_parts(result)]
    elif (folder / "summary.json").is_file():
        result = Result(folder)
        title, parts = result.summary["title"] or folder.name, [*_run_parts(result, picture)]
    else:
        raise FileError(f"'{folder}' holds neither a run (summary.json) nor a study (study.json)")
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
