# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of a study: columns over a swept key, one line per value of another."""
from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure

from .._engine import InputError
from ..catalogue import UNITS
from ..files import write_files
from ..paper import BORE, STATED, of_size
from ..views.labels import LABELS, LOOP, SHOWN, label
from .style import new_axes, styled

if TYPE_CHECKING:
    from ..studies.study import StudyResult

__all__: list[str] = []


def axes_of(result: StudyResult) -> tuple:
    """(x, y list, lines) of the figure: as the study asks, else the first numeric swept key, or the torque.

    Of a whole drive, K1 to K3 and hysteresis; a point has one of each, so the torque draws no lines of them.
    """
    figure, swept = result.summary["figure"], list(result.summary["swept"])
    varied = [name for name in swept if len({r.get(name) for r in result.rows}) > 1]
    numeric = [name for name in varied if all(isinstance(r.get(name), (int, float)) for r in result.rows)]
    x = figure.get("x") or (numeric or ["torque_nm"])[0]
    of_loop = [name for name in LOOP[:4] if x != "torque_nm" and any(name in r for r in result.rows)]
    tangent = any(r.get("k_ts_bonded_nm_per_rad") for r in result.rows)
    ys = figure.get("y") or of_loop or ["k_ts_bonded_nm_per_rad" if tangent else "k_ts_nm_per_rad", *SHOWN]
    # a point that has its own torque is drawn at that alone
    steps = [] if "load.torque" in varied or set(ys) <= set(LOOP) else ["torque_nm"]
    lines = figure.get("lines") or next((name for name in [*varied, *steps] if name != x), None)
    return x, ys, lines


STYLES = ("-", "--", ":", "-.")
MOST_NAMES = 12  # of a legend
NOISE = 0.02     # range of a curve over its mean that is none
RAMP = ListedColormap(colormaps["viridis"](np.linspace(0, 0.88, 256)))  # its last yellow is lost on white


@styled
def draw(axis: Axes, result: StudyResult, x: str, y: str, lines: str | None, chosen: dict | None = None) -> None:
    """Lines of one panel, colour by `lines`, style by the other swept keys; points that failed are left out.

    Where the other keys would take more than four styles, those that vary are held at the values of the first point.

    Parameters
    ----------
    chosen : dict, optional
        Values of the keys of this panel.
    """
    figure, chosen = result.summary["figure"], chosen or {}
    for name in (x, y):
        if not any(name in r for r in result.rows):
            raise InputError(f"figure: the study has no column '{name}'; valid: those of {result.folder / 'study.csv'}")
    rows = [r for r in result.rows if r["status"] == "done" and x in r and y in r]
    if chosen:
        rows = [r for r in rows if all(r.get(k) == v for k, v in chosen.items())]
    if "torque_nm" not in (x, lines):  # the last load step stands for the point, so it must be the one asked for
        failed = {r["point"] for r in result.failures}
        rows = [r for r in rows if r["point"] not in failed]
    if figure.get("torque"):
        rows = [r for r in rows if any(abs(r["torque_nm"] - t) < 1e-9 for t in figure["torque"])]
    if "torque_nm" not in (x, lines) and lines in (None, *result.summary["swept"]):
        rows = [*{r["point"]: r for r in rows}.values()]
    others = [n for n in result.summary["swept"] if n not in (x, lines) and not any(_follows(rows, n, m) for m in (x, lines))]
    if len({tuple(r.get(n) for n in others) for r in rows}) > len(STYLES):
        first = result.rows[0]
        rows, others = [r for r in rows if all(r.get(n) == first.get(n) for n in others)], []
    (label_x, factor_x), (label_y, factor_y) = label(x), label(y)
    colours = sorted({r.get(lines) for r in rows}, key=_order)
    styles = sorted({tuple(r.get(n) for n in others) for r in rows}, key=lambda v: [_order(w) for w in v])
    grouped: dict[tuple, list] = {}
    for r in rows:
        grouped.setdefault((r.get(lines), *(r.get(n) for n in others)), []).append(r)
    ramp = _shades(colours)
    places = {}   # of words along x, in the order of the study
    if any(isinstance(r[x], str) for r in rows):
        places = {word: i for i, word in enumerate(dict.fromkeys(r[x] for r in rows))}
        factor_x = 1
        axis.set_xticks([*places.values()], [*map(str, places)])
    for (i, colour), (j, style) in itertools.product(enumerate(colours), enumerate(styles)):
        line = grouped.get((colour, *style), [])
        if "torque_nm" not in (x, lines):
            line = list({r["point"]: r for r in line}.values())
        line.sort(key=lambda r: places.get(r[x], r[x]))
        a = np.array([[places.get(r[x], r[x]) * factor_x, r[y] * factor_y] for r in line], float)
        if not len(a):
            continue
        if figure.get("relative"):
            a[:, 1] = 100 * (a[:, 1] / a[0, 1] - 1)
        elif any(y + "_low" in r for r in line):
            ends = factor_y * np.array([[r.get(y + end, r[y]) for r in line] for end in ("_low", "_high")], float)
            axis.errorbar(a[:, 0], a[:, 1], abs(ends - a[:, 1]), fmt="none", ecolor=ramp[i], capsize=3)
            label_y = f"{label(y)[0]}, 95 % band"
        name = ", ".join(_name(n, v) for n, v in zip([lines, *others], [colour, *style]) if n)
        axis.plot(a[:, 0], a[:, 1], "o", ls=STYLES[j % 4] if len(a) > 1 else "none", color=ramp[i], ms=4, label=name)
    if not places:
        axis.locator_params(axis="x", nbins=6)
    low, high = axis.get_ylim()
    if not figure.get("relative") and high - low < NOISE * abs(low + high) / 2:  # no noise blown up to the height of the panel
        axis.set_ylim(0.99 * (low + high) / 2, 1.01 * (low + high) / 2)
    axis.set_xlabel(label_x)
    axis.set_ylabel(label_y.split(" / ")[0] + ": change / %" if figure.get("relative") else label_y)


def _shades(values):
    """A colour for each value: by its size where there are more than a legend can name."""
    if len(values) <= 3:
        return [f"C{i}" for i in range(len(values))]
    if len(values) <= MOST_NAMES or not all(isinstance(v, (int, float)) for v in values):
        return RAMP(np.linspace(0, 1, len(values)))
    return RAMP(Normalize(min(values), max(values))(values))


def _follows(rows, name, other):
    """The column has one value at each value of the other: it draws no line of its own."""
    seen: dict = {}
    return all(seen.setdefault(r.get(other), r.get(name)) == r.get(name) for r in rows)


def _order(value):
    return (isinstance(value, str), value if value is not None else 0)


def _name(column, value):
    """Legend text of a value."""
    name, unit, factor = LABELS.get(column, (column.split(".")[-1], "", 1))
    if isinstance(value, str) or value is None:
        return value or "-"
    return f"{value * factor:.4g} {unit}" if unit else f"{name} {value:.4g}"


@styled
def plot_study(result: StudyResult) -> list:
    """Make the figure of a study in its folder.

    Parameters
    ----------
    result : StudyResult

    Returns
    -------
    list of Path
    """
    kind = result.summary["figure"].get("kind")
    if kind in KINDS:
        return [_save(KINDS[kind](result), result)]
    x, ys, lines = axes_of(result)
    keys = result.summary["figure"].get("panels", [])
    panels = [(y, {}) for y in ys] if not keys else [
        (ys[0], dict(zip(keys, values))) for values in dict.fromkeys(tuple(r.get(k) for k in keys) for r in result.rows)]
    columns = min(2 if len(panels) < 5 else 3, len(panels))
    rows = -(-len(panels) // columns)
    figure, axes = new_axes(rows, columns, figsize=(1 + 4.6 * columns, 0.8 + 3.9 * rows), squeeze=False)
    for axis, (y, chosen) in zip(axes.flat, panels):
        draw(axis, result, x, y, lines, chosen)
        axis.set_title(", ".join(_name(k, v) for k, v in chosen.items()), fontsize=12)
    handles, names = axes.flat[0].get_legend_handles_labels()
    free, title = axes.flat[len(panels):], label(lines)[0] if lines in LABELS else None
    for axis in free:
        axis.set_axis_off()
    values = [r[lines] for r in result.rows if isinstance(r.get(lines), (int, float))]
    if len(names) > MOST_NAMES and values:  # more lines than a legend can name: their values as colours
        name, unit, factor = LABELS.get(lines, (lines, "", 1))
        shades = ScalarMappable(Normalize(factor * min(values), factor * max(values)), RAMP)
        figure.colorbar(shades, ax=list(axes.flat[:len(panels)]), label=f"{name} / {unit}" if unit else name)
    elif len(names) > MOST_NAMES:
        figure.supxlabel(f"{len(names)} lines over {title or lines}, see study.csv", fontsize=11)
    elif len(names) > 1 and len(free):
        free[0].legend(handles, names, loc="center", fontsize=12, title=title)
    elif len(names) > 1:
        figure.legend(handles, names, loc="outside lower center", ncols=min(4, len(names)), fontsize=11, title=title)
    failed = result.summary["failed"]
    figure.suptitle(result.summary["title"] + (f" ({failed} of {result.summary['points']} points failed)" if failed else ""),
                    fontsize=13)
    return [_save(figure, result)]


def _save(figure, result):
    path = result.folder / "study.png"
    write_files({path: figure})
    return path


@styled
def plot_series(result: StudyResult) -> Figure:
    """K_TS, K_FTS and K_WTS (Eq. 46) over the torque, beside catalogue and paper (Fig. 10); a matplotlib figure."""
    rows, unit = result.series(), UNITS[14]
    figure, axis = new_axes(figsize=(9, 5.6))
    if not rows:
        raise InputError("figure: kind = 'series' needs points without and with load.support = 'teeth', alike in all other keys")
    swept = [k for k in rows[0] if "." in k]
    for i, line in enumerate(dict.fromkeys((r["tooth_clearance_m"], *(r[k] for k in swept)) for r in rows)):
        chosen = sorted((r for r in rows if (r["tooth_clearance_m"], *(r[k] for k in swept)) == line), key=lambda r: r["torque_nm"])
        t, contact, teeth, drive = (np.array([r[c] for r in chosen]) for c in (
            "torque_nm", "k_ts_nm_per_rad", "k_fts_nm_per_rad", "k_wts_nm_per_rad"))
        name = ", ".join([f"outermost teeth {1e6 * line[0]:g} µm open" if line[0] else "teeth closed at the start",
                          *map(_name, swept, line[1:])])
        if i == 0 or swept:
            axis.semilogy(t, contact, "s-", color="C2", ms=4, label="$K_{TS}$, contact (Eq. 45)" if i == 0 else None)
        axis.semilogy(t, teeth, "^--", color=f"C{i}", ms=5, label=f"$K_{{FTS}}$, {name}")
        axis.semilogy(t, drive, "o-", color=f"C{i}", ms=4, label=f"$K_{{WTS}}$ (Eq. 46), {name}")
    if of_size(result.summary["scene"]):
        axis.step([0, unit.t1_nm, max(t)], [unit.k1_nm_per_rad, unit.k1_nm_per_rad, unit.k2_nm_per_rad], "k-", lw=1.2,
                  where="pre", label="catalogue, size 14: K1, K2")
        axis.semilogy([0.5], [STATED["k_wts_theory"]], "r_", ms=14, mew=2, label="Hu et al.: theory")
        axis.semilogy([0.5, 5], [STATED["k_wts_test"], STATED["k_wts_highest"]], "k*", ms=9, label="Hu et al.: test")
    axis.set_xlabel("torque / N m")
    axis.set_ylabel("torsional stiffness / (N m/rad)")
    axis.set_ylim(top=3e8)
    axis.legend(fontsize=10, ncols=2, loc="upper center")
    axis.set_title(result.summary["title"], fontsize=13)
    return figure


@styled
def plot_catalogue(result: StudyResult) -> Figure:
    """K_FTS of several sizes, a line per clearance of the outermost teeth, beside the catalogue; a matplotlib figure."""
    figure, axis = new_axes(figsize=(9, 5))
    fixed = result.summary["scene"]["load.tooth_clearance"]
    clearances = sorted({r.get("load.tooth_clearance", fixed) for r in result.rows})
    own = [14 * r["geometry.bore_radius"] / BORE for r in result.rows]
    sizes = [size for size in UNITS if min(own) - 1 < size < max(own) + 1]
    for clearance, style in zip(clearances, ("o-", "s--", "^:", "v-.")):
        rows = sorted((r for r in result.rows if r["status"] == "done" and r.get("load.tooth_clearance", fixed) == clearance),
                      key=lambda r: r["geometry.bore_radius"])
        text = f"outermost teeth {1e6 * clearance:g} µm open" if clearance else "closed at the start"
        axis.loglog([14 * r["geometry.bore_radius"] / BORE for r in rows], [r["k_fe_secant_nm_per_rad"] for r in rows],
                    "C0" + style, label=f"$K_{{FTS}}$, {text}")
    for i in (1, 2, 3):
        axis.loglog(sizes, [getattr(UNITS[s], f"k{i}_nm_per_rad") for s in sizes], f"C{i}^-", label=f"catalogue K{i}")
    axis.set_xticks(sizes, [str(s) for s in sizes])
    axis.minorticks_off()
    axis.set_xlabel("size")
    axis.set_ylabel("torsional stiffness / (N m/rad)")
    axis.legend(fontsize=11)
    axis.set_title(result.summary["title"], fontsize=13)
    return figure


KINDS = {"series": plot_series, "catalogue": plot_catalogue}
