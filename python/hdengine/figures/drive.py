# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the whole drive: the torsion loop, loads of balls and teeth, stress cycle of the flexspline."""
from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from .._types import RunLike
from ..catalogue import unit_of
from .style import COLOURS, PARTS, PRESSURE, REFERENCE, new_axes, new_figure, styled

ARCMIN = np.degrees(1) * 60
NEAR_CATALOGUE = 0.25   # the shipped drives' K1 to K3 lie so near to the catalogue (docs/evidence/drive.md)


def reference_step(result: RunLike) -> int:
    """Row of the step that the results of a drive are of: the largest torque, of equals the last."""
    torque = result.summary["results"].get("reference_torque_nm", result.torque_nm[-1])
    return int(np.flatnonzero(abs(result.torque_nm - torque) <= 1e-9 * max(1.0, abs(torque)))[-1])


@styled
def plot_loop(result: RunLike) -> Figure:
    """Torque over the angle of the output with the chords K1, K2, K3, beside those of the catalogue's size with the same T1, T2."""
    loop = result.loop
    loop = loop[max(0, np.count_nonzero(loop["phase"] == "assembly") - 1):]
    figure, axis = new_axes(figsize=(7.5, 5))
    results, scene = result.summary["results"], result.scene
    torque, angle = loop["torque_nm"], ARCMIN * loop["angle_rad"]
    unit, top = unit_of(scene), abs(torque).max()
    if unit:
        t = np.unique(np.r_[0, unit.t1_nm, unit.t2_nm, top].clip(0, top))
        stated = ARCMIN * unit.angle(t)
        axis.fill_betweenx(t, stated / (1 + NEAR_CATALOGUE), stated / (1 - NEAR_CATALOGUE), color=REFERENCE, alpha=0.2, lw=0)
        axis.plot(stated, t, "--", color=REFERENCE, label=f"catalogue, size {unit.size}; grey: \u00b1 {100 * NEAR_CATALOGUE:.0f} %")
    axis.plot(angle, torque, "o-", ms=3, color=COLOURS[0], label="computed loop")
    edges, at = [0.0, scene["loop.torque_1"], scene["loop.torque_2"], np.inf], np.zeros(2)
    for i in (1, 2, 3):
        k = results.get(f"k{i}_nm_per_rad")
        if not k or top <= edges[i - 1]:
            break
        end = at + np.array([ARCMIN * (min(edges[i], top) - at[1]) / k, min(edges[i], top) - at[1]])
        axis.plot(*zip(at, end), "-", color=COLOURS[1], lw=2.5, solid_capstyle="butt", label="chords" if i == 1 else None)
        low, high = (results.get(f"k{i}_nm_per_rad_{side}") for side in ("low", "high"))
        band = f" ({low / 1e3:.3g} to {high / 1e3:.3g})" if low and high else ""
        axis.annotate(f"K{i} {k / 1e3:.3g}{band}", (at + end) / 2, (10, -14), textcoords="offset points",
                      color=COLOURS[1], fontsize=11)
        at = end
    widths = ", ".join(f"{key[:-4].replace('_', ' ')} {ARCMIN * results[key]:.2f}'" for key in ("hysteresis_rad", "lost_motion_rad")
                       if results.get(key) is not None)
    axis.set_title("stiffness in kN m/rad" + (f"; {widths}" if widths else ""), fontsize=12)
    axis.set_xlabel("angle of the output / arc minute")
    axis.set_ylabel("torque / N m")
    axis.legend(loc="upper left", fontsize=10)
    return figure


@styled
def plot_twist(result: RunLike) -> Figure | None:
    """What takes a further twist, part by part, over the torque of the last rise; None without shares (faces bonded)."""
    loop = result.loop
    names = [p for p in PARTS if f"share_{p}" in (loop.dtype.names or ())]
    step = reference_step(result)
    first = step
    while first > 0 and loop["torque_nm"][first - 1] < loop["torque_nm"][first]:
        first -= 1
    rows = loop[first:step + 1]
    rows = rows[rows["torque_nm"] > 0.01 * rows["torque_nm"][-1]]
    if not names or len(rows) < 2 or not all(np.isfinite(rows[f"share_{p}"]).all() for p in names):
        return None
    figure, axis = new_axes(figsize=(7.5, 4.6))
    shares = np.array([100 * rows[f"share_{p}"] for p in names])
    axis.stackplot(rows["torque_nm"], shares, colors=[PARTS[p] for p in names], lw=0.5, ec="white")
    last, base = shares[:, -1], np.cumsum(shares[:, -1]) - shares[:, -1]
    places = base + last / 2
    for i in range(1, len(places)):
        places[i] = max(places[i], places[i - 1] + 5.5)
    places -= max(0, places[-1] - 100)
    for name, share, place in zip(names, last, places):
        axis.annotate(f"{name} {share:.2g} %", (rows["torque_nm"][-1], place), (8, 0), textcoords="offset points", va="center",
                      fontsize=11, annotation_clip=False)
    contact = np.cumsum(last)[names.index("spline")] if "spline" in names else 0.0
    axis.set_title(f"what takes a further twist: the contact {100 - contact:.0f} % at {rows['torque_nm'][-1]:.3g} N m", fontsize=12)
    axis.set(xlim=(rows["torque_nm"][0], rows["torque_nm"][-1]), ylim=(0, 100), xlabel="torque / N m", ylabel="share / %")
    return figure


@styled
def plot_contact(result: RunLike) -> Figure:
    """Pressure and slip at the largest torque: on the unrolled band, and round the ellipse, whose deformation is drawn larger."""
    step = reference_step(result)
    facets = result.contact_at(step)
    names = ("pressure_pa", "slip_theta_m", "slip_z_m", "area_m2")
    field = {name: np.asarray(facets[name]).reshape(result.shape) for name in names}
    closed = field["pressure_pa"] > 0
    pressure = np.where(closed, field["pressure_pa"] / 1e6, np.nan)
    slip = np.where(closed, 1e6 * np.hypot(field["slip_theta_m"], field["slip_z_m"]), np.nan)
    arc = 2 * np.pi * result.scene["geometry.bore_radius"] / len(pressure)
    load = 1e-3 * (field["pressure_pa"] * field["area_m2"]).sum(1) / arc
    moved = np.nan_to_num(slip).max(1)
    theta = (np.arange(len(load)) + 0.5) * 2 * np.pi / len(load)
    figure = new_figure(figsize=(10, 5.4))
    axes = figure.subplots(2, 2, width_ratios=(2.4, 1))
    edges = np.linspace(0, 360, len(load) + 1)
    for (left, right), values, along, label, around in zip(
            axes, (pressure, slip), (load, moved), ("pressure / MPa", "slip / µm"), ("line load / (N/mm)", "largest slip / µm")):
        top = np.nanpercentile(values, 99) if np.isfinite(values).any() else 1.0
        image = left.pcolormesh(edges, 1e3 * result.row_edges(), values.T, cmap=PRESSURE, vmin=0, vmax=top)
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
    figure.suptitle(f"contact at {result.torque_nm[step]:.3g} N m, {100 * closed.mean():.0f} % of the facets closed; grey: open",
                    fontsize=12)
    return figure


def _ellipse(theta):
    """The oval that the cup is bent to, of radius 1, enlarged."""
    radius = 1 + 0.18 * np.cos(2 * theta)
    return np.stack([radius * np.cos(theta), radius * np.sin(theta)], 1)


@styled
def plot_loads(result: RunLike) -> Figure:
    """Force of every ball, and of every pair's larger flank, round the axis: assembled and at the largest torque."""
    figure, axes = new_axes(1, 2, figsize=(9.5, 4.8), subplot_kw={"projection": "polar"})
    step = result.steps["step"][reference_step(result)]
    for axis, table, title in zip(axes, (result.balls, result.teeth), ("balls", "pairs of teeth")):
        axis.set_title(f"{title}: force / N", fontsize=12)
        if table is None:
            continue
        assembled = table["step"][table["phase"] == "assembly"]
        for at, colour in ((assembled[-1:].tolist(), REFERENCE), ([step], COLOURS[1])):
            for number in at:
                rows = table[table["step"] == number]
                place, of = np.unique(np.round(rows["theta_rad"] % (2 * np.pi), 9), return_inverse=True)
                force = np.zeros(len(place))
                np.maximum.at(force, of, rows["force_n"])
                axis.vlines(place, 0, force, color=colour, lw=1.5)
                axis.plot(place, force, "o", ms=4, color=colour, label=f"{rows['torque_nm'][0]:.3g} N m")
        axis.set_thetagrids(range(0, 360, 45))
        axis.set_rlabel_position(67)
        axis.tick_params(labelsize=10)
    figure.legend(*axes[0 if result.balls is not None else 1].get_legend_handles_labels(), loc="outside lower center", ncols=2,
                  fontsize=11, title="torque; the long axis lies at 0° and 180°")
    return figure


@styled
def plot_fatigue(result: RunLike) -> Figure:
    """Mean and alternating stress of the flexspline's points beside Goodman's limit line, and their safety along the cup."""
    table = result.fatigue
    strength, limit, notch = (result.scene[f"fatigue.{k}"] for k in ("tensile_strength", "fatigue_limit", "notch_factor"))
    figure, axes = new_axes(1, 2, figsize=(10, 4.2))
    axes[0].plot([0, strength / 1e6], [limit / 1e6, 0], "-", color=COLOURS[1], label="limit (Goodman)")
    axes[0].plot(table["mean_pa"] / 1e6, notch * table["amplitude_pa"] / 1e6, "o", ms=4, color=COLOURS[0],
                 label="points of the cup")
    worst = int(np.argmin(table["safety"]))
    axes[0].plot(table["mean_pa"][worst] / 1e6, notch * table["amplitude_pa"][worst] / 1e6, "s", ms=8, color=COLOURS[2],
                 label=f"least safety {table['safety'][worst]:.2f}")
    axes[0].set(xlabel="mean stress / MPa", ylabel="amplitude / MPa", ylim=(0, None))
    axes[0].legend(fontsize=10)
    wall = table["r_m"] > 0.9 * table["r_m"].max()
    axes[1].plot(1e3 * table["z_m"][wall], table["safety"][wall], "o", ms=4, color=COLOURS[0], label="wall")
    axes[1].axhline(1, color=COLOURS[1], label="limit: safety 1")
    axes[1].set_ylim(0, min(10, 1.1 * max(1.1, table["safety"][wall].max())))
    axes[1].set(xlabel="distance from the opening / mm", ylabel="safety against fatigue")
    axes[1].legend(fontsize=10)
    figure.suptitle(f"stress cycle of one turn at {table['torque_nm'][0]:.3g} N m", fontsize=12)
    return figure


@styled
def plot_turning(result: RunLike) -> Figure:
    """Turn of the bottom about its mean and stiffness, over the angle of the turning wave generator; dotted: one ball on."""
    table = result.turning
    assert table is not None, "the wave generator stands"
    angle = table["wave_generator_deg"]
    balls, teeth, outer = (result.scene[key] for key in ("bearing.balls", "load.teeth", "geometry.bore_radius"))
    outer += result.scene.get("bearing.groove_depth", 0) - result.scene["geometry.ring_thickness"]
    cage = outer / (2 * outer - result.scene["bearing.ball_diameter"])
    pitch = 360 / balls / cage / (1 + 2 / teeth) if balls else np.inf
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
        for i in range(int(whole / pitch + 1e-6) + 1 if balls else 0):
            axis.axvline(i * pitch, color="0.6", ls=":", lw=1)
    return figure
