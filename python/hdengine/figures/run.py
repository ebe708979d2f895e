# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of a run."""
from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure

from .. import _engine
from .._types import PathLike
from ..files import write_files
from ..summary_file import has_table
from ..views.palette import PRESSURE, SIGNED
from ..views.run import colour_top, is_assembled, is_drive, pair_shares, positions_of, rest_of
from .drive import plot_contact, plot_fatigue, plot_loads, plot_loop, plot_turning, plot_twist
from .style import new_axes, styled

if TYPE_CHECKING:
    from ..results import Result

__all__: list[str] = []
MAPS, FRAMES = 6, 25   # at most, of the torque's maps and of an animation


@styled
def plot_run(result: Result, debug: bool = False) -> list:
    """Make the figures of a run in its folder: those of a drive if it is one, else of its contact.

    Figures that this version has made of the same summary are kept.

    Parameters
    ----------
    result : Result
    debug : bool
        All there are, with what is read to mend a run: Newton's iterations, pressures of every torque.

    Returns
    -------
    list of Path
    """
    figures: dict = {}
    drive, assembled = is_drive(result), is_assembled(result)
    if drive:
        figures |= {"loop.png": plot_loop, "twist.png": plot_twist, "contact.png": plot_contact, "loads.png": plot_loads}
        if has_table(result.summary, "fatigue"):
            figures["fatigue.png"] = plot_fatigue
        if result.turning is not None and len(result.turning) > 1:
            figures["turning.png"] = plot_turning
    if debug or not drive:
        figures |= {"positions.png": plot_positions, "pressure_band.png": plot_band, "pressure_steps.png": plot_steps}
        if np.any(result.torque_nm != 0) if result.against_teeth else assembled:
            figures["torsion.png"] = plot_torsion
    if debug:
        figures["newton.png"] = plot_newton
    made = f"hdengine {_engine.version()}, run {result.summary['checksum']}"
    paths, drawn = [], {}
    for name, draw in figures.items():
        path = result.folder / name
        if not _is_fresh(path, made):
            figure = draw(result)
            if figure is None:
                continue
            buffer = io.BytesIO()
            figure.savefig(buffer, format="png", metadata={"Software": made})
            drawn[path] = buffer.getvalue()
        paths.append(path)
    write_files(drawn)
    return paths


def _is_fresh(path, made):
    """A figure that this version made of this run, whatever the clocks say."""
    if not path.is_file() or path.is_symlink():
        return False
    with open(path, "rb") as file:
        return made.encode() in file.read(400)


def _band(axis, result, field, **keys):
    """Colours of the facets (axis, angle) on the unrolled band; angle in degrees, axis in mm."""
    angle = np.linspace(0, 360, result.shape[0] + 1)
    return axis.pcolormesh(angle, 1e3 * result.row_edges(), field, **keys)


def pressure_top(result: Result) -> float:
    """Top of the colours of every pressure map of a run, from the end of the assembly on [MPa]."""
    late = np.flatnonzero(result.steps["load_factor"] >= 1 - 1e-9)
    first = late[0] if len(late) else 0
    return colour_top(result.contact["pressure_pa"][first:] / 1e6, result.contact["area_m2"][first:])


def _colours(top):
    """Colours whose first half is for the lowest quarter of the pressures, where most of the band lies."""
    return {"cmap": PRESSURE, "norm": PowerNorm(0.5, vmin=0, vmax=top)}


@styled
def plot_positions(result: Result) -> Figure:
    """Normal and tangential stress over the angle at Positions I, II, III (Fig. 7 A, B), last step."""
    figure, axes = new_axes(2, 1, sharex=True, figsize=(8, 7))
    theta = np.degrees(result.contact_at(-1)["theta_rad"].reshape(result.shape)[:, 0])
    for (name, pressure, shear), style in zip(positions_of(result), ("-", "--", "-.")):
        axes[0].plot(theta, pressure, style, label=name)
        axes[1].plot(theta, shear, style, label=name)
    axes[0].set_ylabel("pressure / MPa")
    axes[1].set_ylabel("shear along θ / MPa")
    axes[1].set_xlabel("angle from the long axis / degree")
    axes[1].set_xticks(range(0, 361, 45))
    axes[0].set_title(f"Contact stress at {result.torque_nm[-1]:g} N m (rows from the band's front edge)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=11,
                  title="Position: middle of its row of facets")
    return figure


@styled
def plot_band(result: Result) -> Figure:
    """Contact pressure on the unrolled band, last step."""
    figure, axis = new_axes(figsize=(9, 4))
    p = result.contact["pressure_pa"][-1].reshape(result.shape).T / 1e6
    top = pressure_top(result)
    image = _band(axis, result, np.where(p > 0, p, np.nan), **_colours(top))
    axis.set_facecolor("0.9")
    axis.grid(False)
    axis.set_xticks(range(0, 361, 45))
    axis.set_xlabel("angle from the long axis / degree")
    axis.set_ylabel("distance from the\nfront edge / mm")
    node = result.steps["pressure_max_pa"][-1] / 1e6
    axis.set_title(f"Contact pressure at {result.torque_nm[-1]:g} N m\ngrey: {rest_of(result)}; means of facets up to "
                   f"{p.max():.0f} MPa, nodes up to {node:.0f} MPa", fontsize=12)
    figure.colorbar(image, label="pressure / MPa", extend="max" if p.max() > top else "neither")
    return figure


@styled
def plot_steps(result: Result) -> Figure:
    """Contact pressure on the unrolled band over the torque: the first map, and what the others differ by from it.

    Where they differ by half of the scale or more, every map is drawn as it is, all on one scale.
    """
    steps = np.flatnonzero(result.steps["load_factor"] >= 1 - 1e-9)[:1].tolist()
    steps += [i for i in range(len(result.torque_nm)) if i > steps[0]] if steps else range(len(result.torque_nm))
    steps = [steps[i] for i in np.unique(np.linspace(0, len(steps) - 1, MAPS).round().astype(int))]
    columns = min(3, len(steps))
    rows = -(-len(steps) // columns)
    figure, axes = new_axes(rows, columns, figsize=(4 * columns + 1, 2.1 * rows + 1.2), sharex=True, sharey=True, squeeze=False)
    p = result.contact["pressure_pa"] / 1e6
    top, first = pressure_top(result), p[steps[0]]
    change = max((colour_top(abs(p[i] - first), result.contact["area_m2"][i]) for i in steps[1:]), default=top)
    alike = len(steps) > 1 and change < 0.5 * top
    images = []
    for axis, i in zip(axes.flat, steps):
        closed, torque = p[i] > 0, f"{result.torque_nm[i]:.3g} N m"
        if alike and i != steps[0]:
            field, keys = np.where(closed | (first > 0), p[i] - first, np.nan), {"cmap": SIGNED, "vmin": -change, "vmax": change}
            axis.set_title(f"{torque} less {result.torque_nm[steps[0]]:.3g} N m", fontsize=12)
        else:
            field, keys = np.where(closed, p[i], np.nan), _colours(top)
            axis.set_title(torque, fontsize=12)
        images.append(_band(axis, result, field.reshape(result.shape).T, **keys))
        axis.set_facecolor("0.8")
        axis.grid(False)
        axis.set_xticks(range(0, 361, 90))
    for axis in axes.flat[len(steps):]:
        axis.remove()
    title = f"Contact pressure (grey: {rest_of(result)})"
    if alike:
        title += f" and its change over the torque, {_against_resolution(result, p, steps)}"
    figure.suptitle(title, fontsize=12)
    figure.supxlabel("angle from the long axis / degree", fontsize=12)
    figure.supylabel("from the front edge / mm", fontsize=12)
    used = list(axes.flat[:len(steps)])
    figure.colorbar(images[0], ax=used, label="pressure / MPa", extend="max")
    if alike:
        figure.colorbar(images[-1], ax=used, label="change / MPa", extend="both")
    return figure


def _against_resolution(result, p, steps):
    """The largest change in words, beside what is known of the pressure."""
    text = f"{abs(p[steps] - p[steps[0]]).max():.2g} MPa at most"
    if "pressure_mid_mean_pa" in result.limits:
        error = result.limits["pressure_mid_mean_pa"][1]
        text += f"; mid-band pressure is known to {100 * error:.2g} %"
    return text


@styled
def animate(result: Result, path: PathLike) -> Path:
    """Write a GIF of pressure and shear on the unrolled band over the load steps.

    Parameters
    ----------
    result : Result
    path : str or Path

    Returns
    -------
    Path
    """
    from matplotlib.animation import FuncAnimation, PillowWriter

    p, q = result.contact["pressure_pa"] / 1e6, result.contact["traction_theta_pa"] / 1e6
    frames = np.unique(np.linspace(0, len(p) - 1, FRAMES).round().astype(int))
    area = result.contact["area_m2"]
    top, shear = pressure_top(result), colour_top(np.where(p > 0, np.abs(q), 0), area)
    figure, axes = new_axes(2, 1, figsize=(8, 5.4), sharex=True)
    images = []
    for axis, low, high, cmap, label in zip(axes, (0, -shear), (top, shear), (PRESSURE, SIGNED),
                                            ("pressure / MPa", "shear along θ / MPa")):
        keys = _colours(high) if low == 0 else {"vmin": low, "vmax": high, "cmap": cmap}
        images.append(_band(axis, result, np.zeros(result.shape).T, **keys))
        axis.set_facecolor("0.9")
        axis.grid(False)
        axis.set_ylabel("from front edge / mm")
        figure.colorbar(images[-1], ax=axis, label=label, extend="max" if low == 0 else "both")
    axes[1].set_xticks(range(0, 361, 45))
    axes[1].set_xlabel("angle from the long axis / degree")

    def show(i):
        for image, field in zip(images, (p, q)):
            image.set_array(np.where(p[i] > 0, field[i], np.nan).reshape(result.shape).T)
        load, torque = result.steps["load_factor"][i], result.torque_nm[i]
        axes[0].set_title(f"torque {torque:.3g} N m" if torque else f"assembly, {100 * load:.0f} %", fontsize=13)

    write_files({Path(path): lambda made: FuncAnimation(figure, show, frames.tolist()).save(made, PillowWriter(fps=3), dpi=80)})
    return Path(path)


@styled
def plot_torsion(result: Result) -> Figure:
    """K_TS over the torque, coupled and by Eq. 45, and the FE rotation; against the teeth K_FTS, rotation, shares of the pairs."""
    if result.against_teeth:
        return plot_teeth(result)
    select = np.flatnonzero(result.steps["load_factor"] >= 1 - 1e-9)[0]
    t, steps = result.torque_nm[select:], result.steps[select:]
    figure, axes = new_axes(1, 3, figsize=(11, 3.6))
    for reading, column, style in (("tangent", "k_ts_bonded_nm_per_rad", "o-"), ("secant", "k_ts_secant_nm_per_rad", "s--")):
        if column in (steps.dtype.names or ()) and np.any(np.isfinite(steps[column])):
            axes[0].plot(t, steps[column] / 1e6, style, label=reading)
    axes[0].set_title("$K_{TS}$ / (MN m/rad)", fontsize=12)
    axes[0].set_xlabel("torque / N m")
    axes[0].set_ylim(bottom=0)
    if axes[0].lines:
        axes[0].legend(fontsize=11)
    k = result.torsional_stiffness()[0][select:] / 1e6
    _over_torque(axes[1], t, k, "$K_{TS}$ (Eq. 45) / (MN m/rad)")
    axes[1].fill_between(t, 0.99 * k, 1.01 * k, color="C0", alpha=0.15, lw=0, label="1 %: points between stick and slip")
    axes[1].legend(fontsize=10)
    _over_torque(axes[2], t, 1e6 * steps["rotation_rad"], "FE rotation / µrad")
    return figure


def _over_torque(axis, torque, values, label):
    """A line over the torque; changes below 5 % are not blown up to the height of the panel."""
    axis.plot(torque, values, "o-")
    axis.set_xlabel("torque / N m")
    axis.set_title(label, fontsize=12)
    if np.ptp(values) < 0.05 * abs(np.mean(values)):
        axis.set_ylim(np.mean(values) * np.array([0.95, 1.05]))


@styled
def plot_teeth(result: Result) -> Figure:
    """K_FTS and rotation over the torque; share of each pair of teeth at one end of the long axis, first and last torque."""
    figure, axes = new_axes(1, 3, figsize=(11, 3.6))
    after = result.torque_nm != 0
    torque = result.torque_nm[after]
    _over_torque(axes[0], torque, result.secant_stiffness()[after] / 1e3, "$K_{FTS}$ / (kN m/rad)")
    _over_torque(axes[1], torque, 1e6 * result.steps["rotation_rad"][after], "rotation of the cup's bottom / µrad")
    draw_shares(axes[2], result, torque[-1], "C0o-", f"{torque[-1]:g} N m")
    if len(torque) > 1:
        draw_shares(axes[2], result, torque[0], "C1^--", f"{torque[0]:g} N m")
    axes[2].set_ylim(bottom=0)
    axes[2].set_title("share of each pair of teeth / %", fontsize=12)
    axes[2].set_xlabel("angle from the long axis / degree")
    axes[2].legend(fontsize=11)
    return figure


@styled
def draw_shares(axis: Axes, result: Result, torque: float, style: str, label: str) -> None:
    """Share of each pair of teeth at one end of the long axis at a torque [per cent]; the other end is alike."""
    axis.plot(*pair_shares(result, torque), style, ms=4, label=label)


@styled
def plot_newton(result: Result) -> Figure:
    """Relative residual over the Newton iterations of all steps."""
    h = result.history
    figure, axis = new_axes(figsize=(9, 4.2))
    marks = np.flatnonzero(h["iteration"] == 0)
    for a, b in zip(marks, np.append(marks[1:], len(h))):
        colour = "C0" if str(h["phase"][a]).strip() == "assembly" else "C1"
        axis.semilogy(np.arange(a, b), np.maximum(h["residual"][a:b], 1e-17), "o-", color=colour, ms=4)
    axis.axhline(result.scene["solver.tolerance"], color="k", ls=":", label="tolerance")
    axis.plot([], [], "o-", color="C0", label="assembly")
    axis.plot([], [], "o-", color="C1", label="torque")
    axis.set_xlabel("Newton iterate, all load steps in a row")
    axis.set_ylabel("relative residual")
    axis.legend()
    return figure
