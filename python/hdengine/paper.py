# SPDX-License-Identifier: GPL-3.0-or-later
"""What Hu et al. (2023) state, beside what hdengine gives: rows with a verdict, each computed."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import torsion
from ._check import ROUNDING
from ._engine import supported
from .catalogue import UNITS

if TYPE_CHECKING:
    from .results import Result
    from .studies.study import StudyResult

__all__: list[str] = []
TORQUES_NM = (1.0, 3.0, 5.0)
STATED: dict[str, Any] = {
    "k_ts_5_nm": 1820.44, "pressure_long_1_mpa": 96.35, "eccentricity_percent": (-9.40, -6.61, -5.02),
    "w_best_m": 0.21e-3, "w_percent": (12.65, 8.76, 7.12), "k_ts_best_w": (1009.11, 1552.69, 1940.49),
    "k_wts_theory": 2524.92, "k_wts_test": 2723.75, "k_wts_highest": 5294.0,
}
BORE, NEAR = 17.5e-3, 0.3e-3   # of size 14, and a tenth of the way to the next size [m]
CLOSE, SIZE, RESOLVED = 0.1, 0.1, 1.0  # shares of a figure; in per cent: points that turn from stick to slip move K_TS by that much


@dataclass(frozen=True)
class Row:
    """One line of the comparison: texts, with `verdict` 'agrees', 'trend agrees', 'does not agree' or 'cannot agree'."""

    quantity: str
    paper: str
    ours: str
    printed: str
    verdict: str
    because: str = ""

    HEAD = ("quantity", "paper", "ours", "by the printed forms", "verdict", "because")

    def cells(self) -> tuple:
        """Texts in the order of HEAD."""
        return self.quantity, self.paper, self.ours, self.printed, self.verdict, self.because


def signed(values: ArrayLike, digits: int = 1) -> str:
    """Changes in per cent as one text."""
    text = " / ".join("-" if not np.isfinite(v) else f"{v:+.{digits}f}" for v in np.ravel(np.asarray(values, float)))
    return f"{text} %" if np.any(np.isfinite(np.asarray(values, float))) else "-"


def judge_figure(paper: float, ours: float) -> str:
    """'agrees' within a tenth."""
    return "agrees" if abs(ours / paper - 1) <= CLOSE else "does not agree"


def judge_trend(paper: ArrayLike, ours: ArrayLike) -> str:
    """Figures within a tenth agree. A trend agrees where the signs do, no figure is below a tenth of the paper's or 1 %, and the
    order is not reversed by more than 1 %, that of the extremes kept by more."""
    paper, ours = np.asarray(paper, float), np.asarray(ours, float)
    if np.all(np.abs(ours / paper - 1) <= CLOSE):
        return "agrees"
    rising = ours[np.argsort(paper)]
    order = np.all(np.diff(rising) > -RESOLVED) and (len(rising) == 1 or rising[-1] - rising[0] > RESOLVED)
    large = np.all(ours * np.sign(paper) > np.maximum(RESOLVED, SIZE * np.abs(paper)))
    return "trend agrees" if order and large else "does not agree"


def of_size(scene: Mapping[str, Any]) -> bool:
    """The scene is that of the paper in size."""
    return abs(scene["geometry.bore_radius"] - BORE) < NEAR


def applies(scene: Mapping[str, Any]) -> bool:
    """The scene is that of the paper in size, and its torque passes the contact."""
    return of_size(scene) and scene["contact.mode"] != "bonded" and supported(scene, "contact")


def at(rows: Sequence[Mapping], torque_nm: float, column: str = "k_ts_nm_per_rad") -> float:
    """A column at a torque; NaN where it was not solved."""
    return next((r.get(column, np.nan) for r in rows if abs(r.get("torque_nm", -1) - torque_nm) < ROUNDING), np.nan)


def torque_rows(rows: list) -> list:
    """K_TS and pressure at 5 N m, rise from 1 to 5 N m.

    Parameters
    ----------
    rows : list of dict
        One curve over the torque, as in study.csv.

    Returns
    -------
    list of Row
    """
    k, paper = at(rows, 5.0), at(rows, 5.0, "k_ts_paper_n")
    table = []
    if np.isfinite(k):
        stated = STATED["k_ts_5_nm"]
        table.append(Row("K_TS at 5 N m", f"{stated:.0f} N m/rad", f"{k:.3g} N m/rad", f"{paper:.3g} N", "cannot agree",
                         f"ours is {k / stated:.0f} times as stiff; it rests on r_m, s_min, γ and τ_b, which are not given, and "
                         "Eq. 45 as printed gives newtons"))
    if np.isfinite(k) and np.isfinite(at(rows, 1.0)):
        stated = 100 * (STATED["k_ts_best_w"][2] / STATED["k_ts_best_w"][0] - 1)
        rise = 100 * (k / at(rows, 1.0) - 1)
        printed = 100 * (paper / at(rows, 1.0, "k_ts_paper_n") - 1)
        gauge = STATED["k_ts_5_nm"] / k
        table.append(Row("K_TS from 1 to 5 N m", f"+{stated:.0f} % (w = 0.21 mm)", signed([rise]), signed([printed]),
                         judge_trend([stated], [rise])))
        table.append(Row("K_TS at 1 / 3 N m, gauged at 5 N m", "{:.0f} / {:.0f} (w = 0.21 mm)".format(
            *STATED["k_ts_best_w"]), f"{gauge * at(rows, 1.0):.0f} / {gauge * at(rows, 3.0):.0f} N m/rad (gauge {gauge:.2e})", "-",
            judge_figure(STATED["k_ts_best_w"][0], gauge * at(rows, 1.0)), "a factor cannot turn a flat curve into a rising one"))
    p, peak = (1e-6 * at(rows, 5.0, c) for c in ("pressure_long_1_pa", "pressure_max_pa"))
    if np.isfinite(p):
        stated = STATED["pressure_long_1_mpa"]
        table.append(Row("pressure at Position I, long axis, 5 N m", f"{stated} MPa", f"{p:.3g} MPa", "-",
                         judge_figure(stated, p) if p > 0 else "cannot agree",
                         (f"front edge open there, as the bottom tilts the wall; highest of the band {peak:.0f} MPa, at the rear "
                          "edge, growing with a finer mesh") if p <= 0 else f"highest of the band {peak:.0f} MPa, at an edge"))
    return table


def eccentricity_rows(rows: Sequence[Mapping]) -> list:
    """Change of K_TS by 10 um of eccentricity; rows with and without it, of one support."""
    def change(column):
        values = {e: [at([r for r in rows if abs(r.get("wave_generator.eccentricity", -1) - e) < ROUNDING], t, column)
                      for t in TORQUES_NM] for e in (0.0, 10e-6)}
        return 100 * (np.divide(values[10e-6], values[0.0]) - 1)
    ours, stated = change("k_ts_nm_per_rad"), STATED["eccentricity_percent"]
    if not np.all(np.isfinite(ours)):
        return []
    return [Row("eccentricity of 10 µm at 1 / 3 / 5 N m", signed(stated), signed(ours), signed(change("k_ts_paper_n")),
                judge_trend(stated, ours))]


def w_rows(rows: Sequence[Mapping]) -> list:
    """Place and height of the maximum of K_TS over w."""
    widths = sorted({r["wave_generator.w"] for r in rows if "wave_generator.w" in r})

    def curve(column):
        return np.array([[at([r for r in rows if r["wave_generator.w"] == w], t, column) for w in widths] for t in TORQUES_NM])
    k, printed = curve("k_ts_nm_per_rad"), curve("k_ts_paper_n")
    if len(widths) < 3 or not np.all(np.isfinite(k)):
        return []

    def best(values):
        places = [f"{1e3 * widths[i]:.3f}" for i in values.argmax(axis=1)]
        return " / ".join(places[:1] if len(set(places)) == 1 else places) + " mm, " + gain(values)

    def gain(values):
        return signed(100 * (values.max(axis=1) / values.min(axis=1) - 1))
    inside = np.all((k.argmax(axis=1) > 0) & (k.argmax(axis=1) < len(widths) - 1))
    height = 100 * (k.max(axis=1) / k.min(axis=1) - 1)
    verdict = judge_trend(STATED["w_percent"], height) if inside else "does not agree"
    because = "" if inside else f"ours rises to the end of the range, {1e3 * widths[-1]:g} mm" if np.all(
        k.argmax(axis=1) == len(widths) - 1) else "ours has its maximum at an end of the range"
    return [Row("gain of K_TS over w at 1 / 3 / 5 N m",
                f"{1e3 * STATED['w_best_m']:g} mm, {signed(STATED['w_percent'], 2)}", best(k), best(printed), verdict, because)]


def series_rows(k_ts: float, k_fts: float) -> list:
    """K_WTS by Eq. 46 beside theory, test and catalogue; stiffness of contact and of cup against teeth [N m/rad]."""
    k, unit, s = torsion.series(k_ts, k_fts), UNITS[14], STATED
    because = f"the scene holds cup, ring and teeth alone; {k / unit.k1_nm_per_rad:.1f} times the catalogue's K1"
    ours = f"{k:.4g} N m/rad"
    return [Row("K_WTS at 0.5 N m, theory and test", f"{s['k_wts_theory']:.0f} and {s['k_wts_test']:.0f} N m/rad", ours, "-",
                judge_figure(s["k_wts_test"], k).replace("does not", "cannot"), because),
            Row("K_WTS, highest measured", f"{s['k_wts_highest']:.0f} N m/rad", ours, "-",
                judge_figure(s["k_wts_highest"], k).replace("does not", "cannot"), because)]


def of_run(result: Result) -> list:
    """Rows that a run can answer; none for a scene unlike the paper's."""
    steps = [i for i, torque in enumerate(result.torque_nm) if any(abs(torque - t) < ROUNDING for t in TORQUES_NM)]
    return torque_rows(result.rows(steps)) if applies(result.scene) else []


def of_study(result: StudyResult) -> list:
    """Rows that a study can answer: the first curve over torque, eccentricity or w at the scene's other values."""
    scene, swept = result.summary["scene"], result.summary["swept"]
    if result.summary["figure"].get("kind") == "series":
        rows = result.series()
        return series_rows(rows[0]["k_ts_nm_per_rad"], rows[0]["k_fts_nm_per_rad"]) if rows else []
    if not applies(scene):
        return []
    known = {"wave_generator.eccentricity": eccentricity_rows, "wave_generator.w": w_rows}
    key = next((k for k in known if k in swept), None)
    done = [r for r in result.rows if r["status"] == "done"]
    same = [r for r in done if all(r.get(k) == scene[k] for k in swept if k != key)]
    return known[key](same) if key else torque_rows(same)
