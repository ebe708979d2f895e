# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the whole drive: the torsion loop, loads of balls and teeth, stress cycle of the flexspline."""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from ..views.palette import COLOURS, PARTS, PRESSURE, REFERENCE
from ..views.run import ARCMIN, NEAR_CATALOGUE, ball_steps, band_of, forces_of, loop_of, reference_twist, stresses_of, twist_of
from .style import new_axes, new_figure, styled

if TYPE_CHECKING:
    from ..results import Result

__all__: list[str] = []
WIDTH = 0.32   # of a chord's text and what is before it, over that of the frame


@styled
def plot_loop(result: Result) -> Figure:
    """Torque over the angle of the output with the chords K1, K2, K3, beside those of the catalogue's size with the same T1, T2."""
    loop = loop_of(result)
    figure, axis = new_axes(figsize=(7.5, 5))
    if loop.size:
        angle, torque = loop.stated
        axis.fill_betweenx(torque, angle / (1 + NEAR_CATALOGUE), angle / (1 - NEAR_CATALOGUE), color=REFERENCE, alpha=0.2, lw=0)
        axis.plot(angle, torque, "--", color=REFERENCE,
                  label=f"catalogue, size {loop.size}; grey: \u00b1 {100 * NEAR_CATALOGUE:.0f} %")
    axis.plot(loop.angle, loop.torque, "o-", ms=3, color=COLOURS[0], label="computed loop")
    for i, (angle, torque, text) in enumerate(loop.chords):
        axis.plot(angle, torque, "-", color=COLOURS[1], lw=2.5, solid_capstyle="butt",
                  label=None if i else "chords (95 % band)" if "(" in text else "chords")
        beside = loop.angle[(loop.torque > torque[0]) & (loop.torque < torque.mean())]
        axis.annotate(text, (max(angle.mean(), *beside, -np.inf), torque.mean()), (12, -14), textcoords="offset points",
                      color=COLOURS[1], fontsize=11)
    left, right = axis.get_xlim()
    axis.set_xlim(right=max([right, *((angle.mean() - WIDTH * left) / (1 - WIDTH) for angle, _, _ in loop.chords)]))
    axis.set_title(loop.title, fontsize=12)
    axis.set_xlabel("angle of the output / arc minute")
    axis.set_ylabel("torque / N m")
    axis.legend(loc="upper left", fontsize=10)
    return figure


@styled
def plot_twist(result: Result) -> Figure | None:
    """What takes a further twist, part by part, over the torque of the last rise, or at the reference torque alone.

    None without shares (faces bonded).
    """
    found = twist_of(result)
    at_reference, at = reference_twist(result)
    if found is None and not at_reference:
        return None
    figure, axis = new_axes(figsize=(7.5, 4.6))
    if found is None:
        bars = axis.barh(list(at_reference), list(at_reference.values()), color=[PARTS[p] for p in at_reference])
        axis.bar_label(bars, fmt="%.2g %%", padding=4, fontsize=11)
        axis.invert_yaxis()
        axis.set_title(at, fontsize=12)
        axis.set(xlim=(0, 1.1 * max(at_reference.values())), xlabel="share / %")
        return figure
    torque, by_part, title = found
    names, shares = list(by_part), np.array(list(by_part.values()))
    axis.stackplot(torque, shares, colors=[PARTS[p] for p in names], lw=0.5, ec="white")
    last, base = shares[:, -1], np.cumsum(shares[:, -1]) - shares[:, -1]
    places = base + last / 2
    for i in range(1, len(places)):
        places[i] = max(places[i], places[i - 1] + 5.5)
    places -= max(0, places[-1] - 100)
    for name, share, place in zip(names, last, places):
        axis.annotate(f"{name} {share:.2g} %", (torque[-1], place), (8, 0), textcoords="offset points", va="center",
                      fontsize=11, annotation_clip=False)
    axis.set_title(title, fontsize=12)
    axis.set(xlim=(torque[0], torque[-1]), ylim=(0, 100), xlabel="torque / N m", ylabel="share / %")
    return figure


@styled
def plot_contact(result: Result) -> Figure:
    """Pressure and slip at the largest torque: on the unrolled band, and round the ellipse, whose deformation is drawn larger."""
    band = band_of(result)
    theta = (np.arange(len(band.load)) + 0.5) * 2 * np.pi / len(band.load)
    figure = new_figure(figsize=(10, 5.4))
    axes = figure.subplots(2, 2, width_ratios=(2.4, 1))
    edges = np.linspace(0, 360, len(theta) + 1)
    for (left, right), values, along, label, around in zip(
            axes, (band.pressure, band.slip), (band.load, band.moved), ("pressure / MPa", "slip / µm"),
            ("line load / (N/mm)", "largest slip / µm")):
        top = np.nanpercentile(values, 99) if np.isfinite(values).any() else 1.0
        image = left.pcolormesh(edges, band.edges, values.T, cmap=PRESSURE, vmin=0, vmax=top)
        left.set_facecolor("0.92")
        left.grid(False)
        left.set_xticks(range(0, 361, 45))
        left.set_ylabel("from front edge / mm")
        figure.colorbar(image, ax=left, label=label, extend="max")
        outline = _ellipse(theta)
        lines = LineCollection(list(np.stack([outline, np.roll(outline, -1, 0)], 1)), cmap=PRESSURE, lw=7, norm=Normalize(
            0, along.max() or 1), array=along)
        lines.set_edgecolor("0.92") if not along.any() else None
        right.add_collection(lines)
        right.set(xlim=(-1.35, 1.35), ylim=(-1.05, 1.05), aspect="equal")
        right.set_axis_off()
        right.text(0, 0, f"{around}\nup to {along.max():.3g}", ha="center", va="center", fontsize=11)
    axes[1, 0].set_xlabel("angle from the long axis / degree")
    figure.suptitle(f"contact at {band.torque:.3g} N m, {100 * band.closed:.0f} % of the facets closed; grey: {band.rest}",
                    fontsize=12)
    return figure


def _ellipse(theta):
    """The oval that the cup is bent to, of radius 1, enlarged."""
    radius = 1 + 0.18 * np.cos(2 * theta)
    return np.stack([radius * np.cos(theta), radius * np.sin(theta)], 1)


@styled
def plot_loads(result: Result) -> Figure:
    """Force of every ball, and of every pair's larger flank, round the axis: assembled and at the largest torque."""
    figure, axes = new_axes(1, 2, figsize=(9.5, 4.8), subplot_kw={"projection": "polar"})
    for axis, table, title in zip(axes, (result.balls, result.teeth), ("balls", "pairs of teeth")):
        axis.set_title(f"{title}: force / N", fontsize=12)
        if table is None:
            continue
        forces = forces_of(result, table)
        for (torque, place, force), colour in zip(forces, (REFERENCE, COLOURS[1])[-len(forces):]):
            axis.vlines(place, 0, force, color=colour, lw=1.5)
            axis.plot(place, force, "o", ms=4, color=colour, label=f"{torque:.3g} N m")
        axis.set_thetagrids(range(0, 360, 45))
        axis.set_rlabel_position(67)
        axis.tick_params(labelsize=10)
    figure.legend(*axes[0 if result.balls is not None else 1].get_legend_handles_labels(), loc="outside lower center", ncols=2,
                  fontsize=11, title="torque; the long axis lies at 0° and 180°")
    return figure


@styled
def plot_fatigue(result: Result) -> Figure:
    """Mean and alternating stress of the flexspline's points beside Goodman's limit line, and their safety along the cup."""
    table = result.fatigue
    strength, limit = (result.scene[f"fatigue.{k}"] for k in ("tensile_strength", "fatigue_limit"))
    mean, amplitude = stresses_of(table, result.scene)
    figure, axes = new_axes(1, 2, figsize=(10, 4.2))
    axes[0].plot([0, strength / 1e6], [limit / 1e6, 0], "-", color=COLOURS[1], label="limit (Goodman)")
    axes[0].plot(mean, amplitude, "o", ms=4, color=COLOURS[0],
                 label="points of the cup")
    worst = int(np.argmin(table["safety"]))
    axes[0].plot(mean[worst], amplitude[worst], "s", ms=8, color=COLOURS[2],
                 label=f"least safety {table['safety'][worst]:.2f}")
    axes[0].set(xlabel="mean stress / MPa", ylabel="amplitude / MPa", ylim=(0, None))
    axes[0].legend(fontsize=10)
    way = table["z_m"] + abs(table["r_m"] - table["r_m"][table["z_m"].argmin()])   # wall, then bottom or flange
    axes[1].plot(1e3 * way, table["safety"], "o", ms=4, color=COLOURS[0], label="points of the cup")
    axes[1].plot(1e3 * way[worst], table["safety"][worst], "s", ms=8, color=COLOURS[2])
    axes[1].axhline(1, color=COLOURS[1], label="limit: safety 1")
    axes[1].set_ylim(0, min(10, 1.1 * max(1.1, table["safety"].max())))
    axes[1].set(xlabel="way from the opening to the hub / mm", ylabel="safety against fatigue")
    axes[1].legend(fontsize=10)
    figure.suptitle(f"stress cycle of one turn at {table['torque_nm'][0]:.3g} N m", fontsize=12)
    return figure


@styled
def plot_turning(result: Result) -> Figure:
    """Turn of the bottom about its mean and stiffness, over the angle of the turning wave generator; dotted: one ball on."""
    table = result.turning
    assert table is not None, "the wave generator stands"
    angle = table["wave_generator_deg"]
    figure, axes = new_axes(1, 2, figsize=(11, 4))
    axes[0].plot(angle, ARCMIN * 60 * (table["turn_rad"] - table["turn_rad"].mean()), "o-", ms=4)
    axes[1].plot(angle, table["stiffness_nm_per_rad"] / 1e3, "o-", color=COLOURS[1], ms=4)
    torque = result.scene["turning.torque"] or result.scene["loop.rated_torque"]
    error = ARCMIN * 60 * result.summary["results"]["turning_angle_error_rad"]
    axes[0].set_title(f"turn of the bottom about its mean / arc second\nerror {error:.2f}'' at {torque:g} N m", fontsize=12)
    axes[1].set_title("stiffness / (kN m/rad)\nfrom half to all of the torque", fontsize=12)
    whole = len(angle) * angle[-1] / max(1, len(angle) - 1)  # the last place would be the first again
    for axis in axes:
        axis.set_xlabel("turn of the wave generator / degree")
        for turn in ball_steps(result, whole):
            axis.axvline(turn, color="0.6", ls=":", lw=1)
    return figure
