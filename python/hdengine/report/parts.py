# SPDX-License-Identifier: GPL-3.0-or-later
"""Sections of reports, as HTML: of a run, a study or a surface."""
from __future__ import annotations

import base64
import html
import re
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import paper
from .._engine import FileError, names, supported
from ..catalogue import unit_of
from ..contact import read_scene
from ..elastic import joint_of_scene
from ..files import read_json
from ..results import Result
from ..studies.study import StudyResult, read_rows
from ..summary_file import check_one, read_summary
from ..surfaces.run import SurfaceResult
from ..views.labels import LABELS, LOOP, label
from ..views.run import is_drive, reference_step
from . import charts
from .sketch import draw_scene

__all__: list[str] = []
ISO_76 = 4.2e9   # pressure of a ball at which it and its race keep a ten-thousandth of its diameter [Pa]
OPEN = ("Answer", "Ended early", "Warnings", "Loads and strength", "Inputs at a glance", "Pictures", "Failed points",
        "Figure", "Drives")  # the other sections fold away


@dataclass(frozen=True)
class Part:
    """A section of a report.

    Parameters
    ----------
    heading : str
    body : str
        HTML.
    """

    heading: str
    body: str

    @property
    def open(self) -> bool:
        """Shown without unfolding."""
        return self.heading in OPEN

    @property
    def headline(self) -> bool:
        """The box at the top."""
        return self.heading == "Answer"

    @property
    def mark(self) -> str:
        """Name for links."""
        return re.sub(r"\W+", "-", self.heading.lower()).strip("-")


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
    titles, factors = zip(*(label(name) for name in names))
    heads = [re.sub(r"[${}]", "", title).split(" / ", 1) for title in titles]  # a unit is not broken
    return _table([" /\u00a0".join([*h[:1], *(u.replace(" ", "\u00a0") for u in h[1:])]) for h in heads], [
        [v * f if f != 1 and not isinstance(v, str) else v for v, f in zip(row, factors)] for row in rows])


def _image(path, caption):
    data = base64.b64encode(Path(path).read_bytes()).decode()
    kind, screen = Path(path).suffix[1:], ' class="screen"' if Path(path).suffix == ".gif" else ""
    return f'<figure{screen}><div class="wide"><img alt="{html.escape(caption)}" src="data:image/{kind};base64,{data}"></div>' \
           f"<figcaption>{html.escape(caption)}</figcaption></figure>"


def _pairs(mapping):
    """Two columns; empty values are left out."""
    return _table(("key", "value"), [(k, ", ".join(map(_text, v)) if isinstance(v, list) else v) for k, v in mapping.items()
                                     if v not in ("", "none")])


def _inputs(scene):
    """One table per group of the keys of a drive; those that differ from the default are bold."""
    default = read_scene()
    tables: dict[str, list] = {}
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


_SHOWN = {"N m/rad": ("(kN m/rad)", 1e-3), "rad": ("µrad", 1e6), "Pa": ("MPa", 1e-6)}   # a unit, that of the report and its number


def _promised():
    """Column of each promise: its words with the unit shown, and what takes its numbers there."""
    found = {}
    for column, words, unit in zip(*(names(f"promise_{part}") for part in ("columns", "words", "units"))):
        shown, factor = _SHOWN.get(unit, (unit, 1))
        found[column] = f"{words} / {shown}", factor
    return found


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
    promised = _promised()
    if result.limits:
        rows = [[promised[key][0],
                 " to ".join(f"{promised[key][1] * v:.4g}" for v in sorted({np.nanmin(value), np.nanmax(value)})),
                 f"{100 * error:.2g}", f"{100 * (mesh - 1):+.2g}" if np.ndim(mesh) == 0 else "-"]
                for key, (value, error, mesh) in result.limits.items()]
        text += "<p>What is promised of the last step:</p>" + _table(
            ("quantity", "limit of fine meshes", "known to / %", "this mesh above it / %"), rows)
    reasons = "".join(f"<li>{html.escape(line)}</li>" for line in planned["reasons"])
    text += f"<p>Why (changes are relative, the largest of what is promised):</p><ul>{reasons}</ul>"
    if (folder / "plan.csv").is_file():
        table = read_rows(folder / "plan.csv")
        head = [*(n for n in table[0] if n in promised)]
        rows = [[_mesh(r["mesh"]), *(r[n] for n in head)] for r in table]
        text += "<p>Solved for it:</p>" + _columns(("facets without edge cells, edge cells, layers, steps, element", *head), rows)
    return text


def _found(result):
    """What `hdengine sensitivity` found of the run; nothing where that was of an earlier run in its folder."""
    path = result.folder / "sensitivity.json"
    found = read_json(path, "bands_95_nm_per_rad") if path.is_file() else {}
    return found if found.get("run") == result.summary["checksum"] else {}


def _sensitivity(result):
    """Figures and bands of `hdengine sensitivity`."""
    if found := _found(result):
        text = _table(("what varies", "low", "median", "high"), [(k, *v) for k, v in found["bands_95_nm_per_rad"].items()])
        if found.get("indices"):
            text += "<p>Shares of the variance (Sobol) with the half width of their 95 % band:</p>" + _table(
                ("key", "first order", "+-", "total", "+-"), [(k, *v) for k, v in found["indices"].items()])
        pictures = "".join(_image(result.folder / name, "Change between the ends of each range.") for name in found["figures"])
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
    k, found = result.steps["k_ts_nm_per_rad"], _readings(result.summary["results"])
    if "k_ts_bonded_nm_per_rad" in result.limits:
        limit, error, _ = result.limits["k_ts_bonded_nm_per_rad"]
        found["K_TS, tangent, limit of fine meshes / (MN m/rad)"] = f"{1e-6 * limit:.4g}, known to {100 * error:.2g} %"
    law = result.summary.get("k_ts_by_model", {}).get("chosen_rests_on", "the law of the joint")
    return found, k, \
        "The tangent K_TS is what a test can measure: the slope of torque over rotation, less what glued faces give. " \
        f"Eq. 45 assumes that nothing slips further; it rests on {html.escape(law)}."


def _readings(results):
    """K_TS in every reading, and what of it slips."""
    names = {"K_TS, tangent / (MN m/rad)": ("k_ts_bonded_nm_per_rad", 1e-6),
             "K_TS, secant / (MN m/rad)": ("k_ts_secant_nm_per_rad", 1e-6),
             "torque over rotation / (MN m/rad)": ("k_fe_secant_nm_per_rad", 1e-6),
             "K_TS by Eq. 45 / (MN m/rad)": ("k_ts_nm_per_rad", 1e-6), "Eq. 45 as printed / MN": ("k_ts_paper_n", 1e-6),
             "of Eq. 45 on points that slip / %": ("slip_share_k_ts", 100), "of the force on them / %": ("slip_share_force", 100),
             "of the area / %": ("slip_share_area", 100)}
    return {name: "-" if results[key] is None else factor * results[key] for name, (key, factor) in names.items()}


def _model_error(summary):
    """What the tolerance covers, and what the model leaves out."""
    covers = ", ".join(summary["model_error"]["tolerance_covers"])
    text = f"<p>The tolerance covers the mesh's share of {html.escape(covers)}.</p>" if covers else \
        "<p>No tolerance was promised: the mesh's share of the error is not known.</p>"
    lines = "".join(f"<li>{html.escape(line)}</li>" for line in summary["model_error"]["left_out"])
    return f"{text}<p>No mesh mends what the model leaves out:</p><ul>{lines}</ul>"


def _band_of(result):
    """What is known of the error of K_TS [N m/rad], as text."""
    known = []
    if "k_ts_bonded_nm_per_rad" in result.limits:
        limit, error, ratio = result.limits["k_ts_bonded_nm_per_rad"]
        known.append(f"The limit {_engineering(limit)} is known to {100 * error:.2g} %; the last mesh itself gives "
                     f"{_engineering(limit * ratio)}.")
    else:
        known.append("The error of the mesh is not known: run again with <code>run.tolerance</code>.")
    if found := _found(result):
        name, bands = ("the tangent", found["tangent"]["bands_95_nm_per_rad"]) if "tangent" in found else \
            ("K_TS by Eq. 45", found["bands_95_nm_per_rad"])
        if bands:
            low, _, high = max(bands.values(), key=lambda b: b[2] - b[0])
            known.append(f"By the inputs 95 % of {name} lie from {_engineering(low)} to {_engineering(high)}.")
    else:
        known.append("The error of the inputs is not known: <code>hdengine sensitivity</code> varies them.")
    return "Band: " + " ".join(known)


def _engineering(k):
    """A stiffness in the unit that suits it."""
    scale, unit = (1e-6, "MN m/rad") if k >= 1e6 else (1e-3, "kN m/rad") if k >= 1e3 else (1, "N m/rad")
    return f"{scale * k:.3g} {unit}"


def _answer_of_drive(result):
    """The headline of a whole drive: K1 to K3 of its loop or their limits, beside the catalogue and with their band."""
    results, limits = result.summary["results"], result.limits
    keys = {f"K{i}": f"k{i}_nm_per_rad" for i in (1, 2, 3)}
    slopes = {name: limits[key][0] if key in limits else results.get(key) for name, key in keys.items()}
    text = '<p>Torsional stiffness of the drive, as catalogues define it</p><p class="value">' + ", ".join(
        f"{name} {_engineering(k)}" for name, k in slopes.items() if k) + "</p>"
    text += f"<p>Between T1 and T2 one more newton metre turns the output by {180 * 3600 / np.pi / slopes['K2']:.3g} arcsec.</p>"

    def ends(key, scale):
        low, high = (results.get(f"{key}_{side}") for side in ("low", "high"))
        return f" ({scale * low:.3g} to {scale * high:.3g})" if low else ""
    lost = [f"{key[:-4].replace('_', ' ')} {180 * 60 / np.pi * results[key]:.3g} arcmin{ends(key, 180 * 60 / np.pi)}"
            for key in ("hysteresis_rad", "lost_motion_rad") if results.get(key) is not None]
    text += f"<p>{' and '.join(lost).capitalize()}.</p>" if lost else ""
    unit = unit_of(result.scene)
    stated = {name: getattr(unit, key) for name, key in keys.items()} if unit else {}
    banded = "band_shares" in results
    head = ["/ (kN m/rad)", "computed", *(["95 % band"] if banded else []),
            *([f"catalogue, size {unit.size}", "ratio"] if unit else [])]
    rows = []
    for name, k in slopes.items():
        if not k:
            continue
        low, high = (results.get(f"{keys[name]}_{side}") for side in ("low", "high"))
        scale = 1e-3 * k / results[keys[name]]  # a band is relative: it holds of the limit too
        rows.append([name, f"{k / 1e3:.3g}", *([f"{low * scale:.3g} to {high * scale:.3g}" if low else "-"] if banded else []),
                     *([f"{stated[name] / 1e3:.3g}", f"{k / stated[name]:.2f}"] if unit else [])])
    text += _table(head, rows)
    shares = results.get("twist_shares") or {}
    if shares and all(isinstance(v, float) for v in shares.values()):
        contact = sum(shares[part] for part in ("gaps", "slip", "joint"))
        read = ("k_ts_bonded_nm_per_rad", "beside the glued drive"), ("k_ts_contact_nm_per_rad", "of the contact alone")
        k_ts = ", ".join(f"{results[key] / 1e3:.3g}{ends(key, 1e-3)} {words}" for key, words in read if results.get(key))
        text += f"<p>The contact takes {100 * contact:.0f} % of a further twist at {results['reference_torque_nm']:.3g} N m. " \
            f"K_TS / (kN m/rad): {k_ts}.</p>"
    known = ", ".join(f"{name} to {100 * limits[key][1]:.2g} %" for name, key in keys.items() if key in limits)
    mesh = f"These limits of fine meshes are known: {known}" if known else \
        "The error of the mesh is not known: run again with <code>run.tolerance</code>"
    return text + f"<p>Band: {mesh}. {_input_band(results)}</p>"


def _strength(result):
    """Largest forces and stresses of a drive with their safety, green where it holds and red where not."""
    results, scene = result.summary["results"], result.scene
    rows = []
    for name, key, of in (("largest stress of the cup / MPa", "flexspline_von_mises_max_pa", "flexspline_yield_safety"),
                          ("largest stress of the ring / MPa", "von_mises_max_pa", "ring_yield_safety")):
        if results.get(of) is not None:
            strength = scene["material.yield_strength" if of.startswith("flex") else "material.ring_yield_strength"]
            rows.append((name, f"{strength / results[of] / 1e6:.4g}", f"yield {strength / 1e6:.4g} MPa", results[of]))
    if results.get("goodman_safety_min") is not None:
        rows.append(("fatigue of the cup", "", f"Goodman, limit {scene['fatigue.fatigue_limit'] / 1e6:.4g} MPa",
                     results["goodman_safety_min"]))
    if results.get("ball_pressure_max_pa") is not None:
        pressure = results["ball_pressure_max_pa"]
        rows.append(("pressure of a ball on its race / MPa", f"{pressure / 1e6:.4g}", f"ISO 76, {ISO_76 / 1e6:.4g} MPa",
                     ISO_76 / pressure))
    cells = "".join(f'<tr class="{"good" if safety >= 1 else "failed"}"><td>{name}</td><td>{value}</td><td>{beside}</td>'
                    f"<td>{safety:.3g} {'holds' if safety >= 1 else 'does not hold'}</td></tr>"
                    for name, value, beside, safety in rows)
    loads = "".join(f"<tr><td>{name}</td><td>{results[key]:.4g}</td><td></td><td></td></tr>" for name, key in (
        ("largest force of a ball / N", "ball_force_max_n"), ("largest force of a pair's flank / N", "tooth_force_max_n"),
        ("torque on the wave generator / N m", "wave_generator_torque_max_nm")) if results.get(key) is not None)
    head = "".join(f"<th>{word}</th>" for word in ("of all load steps", "value", "beside", "safety"))
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead>' \
        f"<tbody>{loads}{cells}</tbody></table></div>"


def _glance(scene):
    """The inputs that a designer changes, in mm."""
    def mm(*keys):
        return [(key.split(".")[1].replace("_", " "), f"{1e3 * scene[key]:.4g}") for key in keys if scene.get(key)]
    rows = mm(*(f"geometry.{key}" for key in ("bore_radius", "wall_thickness", "rim_thickness", "rim_length", "cup_length",
                                              "bottom_thickness", "hub_radius", "ring_thickness", "band_length")),
              "wave_generator.w", f"wave_generator.{'clearance' if scene['wave_generator.clearance'] else 'interference'}",
              "bearing.ball_diameter", "load.spline_diameter", "load.spline_width")
    rows += [(name, f"{scene[key]:g}") for name, key in (
        ("balls", "bearing.balls"), ("teeth", "load.teeth"), ("pairs in mesh", "load.tooth_pairs"),
        ("friction", "contact.friction"), ("torque / N m", "load.torque")) if scene.get(key)]
    cells = "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in rows)
    return f'<p>Lengths in mm:</p><dl class="glance">{cells}</dl>'


def _input_band(results):
    """What the tolerances of the inputs leave open."""
    if "band_shares" not in results:
        return "The error of the inputs is not known: <code>run.band</code> finds it"
    most = ", ".join(f"{html.escape(key)} {100 * share:.2g} %" for key, share in list(results["band_shares"].items())[:3])
    return f"The 95 % bands are those of the tolerances of the inputs, that of K2 most by {most}."


def _answer(result):
    """The headline: the stiffness, its meaning for a drive, what is known of its error."""
    results, torque = result.summary["results"], result.torque_nm[reference_step(result)]
    if (results.get("k2_nm_per_rad") or 0) > 0:
        return _answer_of_drive(result)
    limits = {key: value[0] for key, value in result.limits.items()}
    if result.against_teeth:
        k, name = limits.get("k_fe_secant_nm_per_rad", result.secant_stiffness()[-1]), "K_FTS, cup against the teeth"
    else:
        found = [(limits.get("k_ts_bonded_nm_per_rad"), "Torsional stiffness of the contact, K_TS, tangent, limit of fine meshes"),
                 (results.get("k_ts_bonded_nm_per_rad"), "Torsional stiffness of the contact, K_TS, tangent"),
                 (results.get("k_ts_nm_per_rad"), "Torsional stiffness of the contact, K_TS, by Eq. 45")]
        k, name = next(((v, n) for v, n in found if v is not None), (float("nan"), found[-1][1]))
    if not np.isfinite(k) or not k > 0:
        return f'<p>{name} at {torque:.4g} N m</p><p class="value">no value</p><p>There is no torque, or nothing that turns.</p>'
    arcsec, what = 180 * 3600 / np.pi / k, "cup against its teeth" if result.against_teeth else "contact"
    text = f'<p>{name} at {torque:.4g} N m</p><p class="value">{_engineering(k)}</p>' \
        f"<p>One more newton metre turns the {what} by {arcsec:.3g} arcsec ({1e6 / k:.3g} µrad).</p>"
    return text if result.against_teeth else text + f"<p>{_band_of(result)}</p>"


def _on_demand(result, picture, animation):
    """What takes time and libraries: the animation of the load steps, the 3-D picture of the cup."""
    if animation and len(result.steps) > 1:
        from ..figures.run import animate

        yield _image(animate(result, result.folder / "steps.gif"), "Pressure and shear on the unrolled band, step by step.")
    if picture:
        from ..figures.cup import PictureError, draw_cup

        try:
            scale = draw_cup(result, result.folder / "cup.png")
            yield _image(result.folder / "cup.png", f"The cup cut open, displacements times {scale:g}; pressure on the ring.")
        except PictureError as why:
            yield _warnings([f"3-D picture left out: {why}"])


def _run_parts(result, picture, animation):
    """(heading, HTML) of a run."""
    s = result.summary
    if not result.complete:
        yield "Ended early", f'<p class="bad">{html.escape(s["message"])}</p>'
    yield "Answer", _answer(result) + (charts.answer(result) if is_drive(result) else "")
    if s["warnings"]:
        yield "Warnings", _warnings(s["warnings"])
    if supported(result.scene, "struts"):
        yield "Loads and strength", _strength(result)
    yield "Inputs at a glance", draw_scene(result.scene) + _glance(result.scene)
    yield "Pictures", "".join(charts.pictures(result))
    stiffness, k, note = _stiffness(result)
    yield "All results", _pairs({
        "torque / N m": result.torque_nm[reference_step(result)], **stiffness,
        "rotation / µrad": 1e6 * s["results"]["rotation_rad"], "normal force / N": s["results"]["normal_force_n"],
        "peak pressure at a node / MPa (grows with a finer mesh)": 1e-6 * s["results"]["pressure_max_pa"],
        "line load of the band's ends / (kN/m) (converges)": 1e-3 * s["results"]["edge_line_load_n_per_m"]}) + f"<p>{note}</p>"
    yield "What the figures leave out", _model_error(s)
    figures = "".join(_on_demand(result, picture, animation))
    if figures:
        yield "More figures", figures
    yield from _comparison(paper.of_run(result))
    yield from _sensitivity(result)
    steps = result.steps
    names = [n for n in ("step", "phase", "torque_nm", "rotation_rad", "normal_force_n", "contact_area_m2", "pressure_max_pa",
                         "friction_torque_nm", "torque_balance_nm", "k_ts_bonded_nm_per_rad", "k_ts_secant_nm_per_rad",
                         "iterations") if n in steps.dtype.names]
    name = "k_fts_nm_per_rad" if result.against_teeth else "k_ts_nm_per_rad"
    yield "Load steps", _columns([*names, name], [[*(row[n] for n in names), value] for row, value in zip(steps, k)])
    yield "Plan", _plan(result)
    yield "Convergence", _pairs(
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
        joint_of_scene(result.summary["scene"]).stiffness(peak)
    if caught:
        yield "Warnings", _warnings(dict.fromkeys(str(w.message) for w in caught))


def _study_convergence(rows):
    """Balance over all load steps."""
    done = [r for r in rows if r["status"] == "done"]
    if not done:
        return "<p>No load step was solved.</p>"
    return _pairs({"load steps solved": len(done),
                   "largest torque out of balance / N m": max(abs(r["torque_balance_nm"]) for r in done)})


def _study_answer(result):
    """The headline of a study: from where to where the stiffness goes."""
    s = result.summary
    against = s["scene"].get("load.support") in names("support_against_teeth")
    column, name = ("k_fe_secant_nm_per_rad", "K_FTS") if against else ("k_ts_nm_per_rad", "K_TS by Eq. 45")
    if any("k2_nm_per_rad" in r for r in result.rows):
        column, name = "k2_nm_per_rad", "K2 of the drive"
    rows = [r for r in result.rows if r["status"] == "done" and np.isfinite(r.get(column, np.nan))]
    failed = f", {s['failed']} failed" if s["failed"] else ""
    text = f"<p>{s['done'] - s['failed']} of {s['points']} points solved{failed}.</p>"
    if not rows:
        return text
    low, high = (choose(rows, key=lambda r: r[column]) for choose in (min, max))

    def place(row):
        torque = [] if column in LOOP else ["torque_nm"]
        return ", ".join(f"{html.escape(str(k))} = {_text(row[k])}" for k in (*s["swept"], *torque) if k in row)
    return f'<p>{name}</p><p class="value">{_engineering(low[column])} to {_engineering(high[column])}</p>' \
        f"<p>Lowest at {place(low)}; highest at {place(high)}.</p>{text}"


def _study_parts(result):
    """(heading, HTML) of a study."""
    from ..figures.study import plot_study

    s = result.summary
    yield "Answer", _study_answer(result)
    yield "Status", _pairs({"status": s["status"], "points": s["points"], "solved": s["done"] - s["failed"], "failed": s["failed"],
                            "swept": ", ".join(s["swept"]) or "torque"})
    if result.failures:
        yield "Failed points", _failures(result)
    yield from _study_warnings(result)
    yield "Figure", "".join(_image(p, s["title"]) for p in plot_study(result))
    drives = [r for r in result.rows if not r.keys().isdisjoint(LOOP)]
    if drives:
        names = ["point", *s["swept"], *(n for n in LOOP if n in LABELS and any(n in r for r in drives))]
        yield "Drives", _columns(names, [[r.get(n, "") for n in names] for r in drives])
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
    yield "Answer", f"<pre>{html.escape(str(result))}</pre>"
    yield "Pictures", "".join(_image(p, "Heights, middle rows, structure functions with their fits.")
                             for p in result.plot() if Path(p).suffix == ".png")
    yield "Inputs", f"<pre>{html.escape((result.folder / 'echo.nml').read_text())}</pre>"
    yield "Provenance", _pairs(result.summary["provenance"])


def parts_of(folder: Path, picture: bool, animation: bool = False) -> tuple[str, list]:
    """Title and sections of whatever the folder holds."""
    check_one(folder)
    if (folder / "study.json").is_file():
        study = StudyResult(folder)
        return study.summary["title"], [*_study_parts(study)]
    if (folder / "summary.json").is_file():
        summary = read_summary(folder)
        if summary.get("kind") == "surface":
            return summary.get("title", ""), [*_surface_parts(SurfaceResult(folder))]
        result = Result(folder)
        return result.summary["title"], [*_run_parts(result, picture, animation)]
    raise FileError(f"'{folder}' holds neither a run (summary.json) nor a study (study.json); "
                        "valid: a folder that hdengine.x or hdengine study wrote")
