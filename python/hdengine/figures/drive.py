# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the whole drive: the torsion loop, loads of balls and teeth, stress cycle of the flexspline."""
from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from .._types import RunLike
from .style import new_axes, styled

ARCMIN = np.degrees(1) * 60


@styled
def plot_loop(result: RunLike) -> Figure:
    """Angle of the cup's bottom over the torque, with the chords that the catalogue calls K1, K2, K3; largest ball and tooth."""
    loop = result.loop
    loop = loop[np.flatnonzero(loop["load_factor"] >= 1 - 1e-9)[:1].tolist()[0] if loop["phase"][-1] != "assembly" else 0:]
    figure, axes = new_axes(1, 2, figsize=(11, 4.4))
    torque, angle = loop["torque_nm"], ARCMIN * loop["angle_rad"]
    axes[0].plot(angle, torque, "o-", ms=3)
    results = result.summary["results"]
    known = {k: results[f"k{k}_nm_per_rad"] / 1e3 for k in (1, 2, 3) if f"k{k}_nm_per_rad" in results}
    title = ", ".join(f"K{k} {v:.3g}" for k, v in known.items())
    widths = ", ".join(f"{key[:-4].replace('_', ' ')} {ARCMIN * results[key]:.2f}'" for key in ("hysteresis_rad", "lost_motion_rad")
                       if results.get(key) is not None)
    axes[0].set_title(f"{title} kN m/rad\n{widths}", fontsize=12)
    for limit in (result.scene["loop.torque_1"], result.scene["loop.torque_2"]):
        axes[0].axhline(limit, color="0.6", ls=":", lw=1)
    axes[0].set_xlabel("angle of the cup's bottom / arc minute")
    axes[0].set_ylabel("torque / N m")
    axes[1].plot(torque, loop["ball_force_max_n"], "C0o-", ms=3, label="ball")
    axes[1].plot(torque, loop["tooth_force_max_n"], "C1^-", ms=3, label="pair of teeth")
    axes[1].set_xlabel("torque / N m")
    axes[1].set_title("largest force / N", fontsize=12)
    axes[1].set_ylim(bottom=0)
    axes[1].legend()
    return figure


@styled
def plot_loads(result: RunLike) -> Figure:
    """Force of every ball and of every pair of teeth, the larger of its flanks', over the angle, at the end of the assembly and at the largest torque."""
    figure, axes = new_axes(1, 2, figsize=(11, 4))
    for axis, table, title in zip(axes, (result.balls, result.teeth), ("force of a ball / N", "force of a pair of teeth / N")):
        if table is None:
            continue
        assembled = table["step"][table["phase"] == "assembly"]
        steps = np.unique([assembled[-1] if len(assembled) else table["step"][0], table["step"][np.argmax(table["torque_nm"])]])
        for step, style in zip(steps, ("C0o-", "C3^-")):
            rows = table[table["step"] == step]
            label = f"{rows['torque_nm'][0]:.3g} N m"
            place, of = np.unique(rows["theta_rad"], return_inverse=True)
            force = np.zeros(len(place))
            np.maximum.at(force, of, rows["force_n"])
            for end in (0, 180):
                angle = (np.degrees(place) - end + 180) % 360 - 180
                near = np.argsort(angle)[abs(np.sort(angle)) <= 90]
                axis.plot(angle[near], force[near], style if end == 0 else style.replace("-", "--"), ms=4,
                          label=label if end == 0 else None)
        axis.set_xlabel("angle from the nearer end of the long axis / degree\n(full: θ = 0, dashed: θ = 180°)")
        axis.set_title(title, fontsize=12)
        axis.legend()
    return figure


@styled
def plot_fatigue(result: RunLike) -> Figure:
    """Mean and alternating stress of the flexspline's meridian in Goodman's diagram, and the safety of its points along the cup."""
    table = result.fatigue
    strength, limit, notch = (result.scene[f"fatigue.{k}"] for k in ("tensile_strength", "fatigue_limit", "notch_factor"))
    figure, axes = new_axes(1, 2, figsize=(11, 4.2))
    axes[0].plot([0, strength / 1e6], [limit / 1e6, 0], "k-", label="Goodman")
    axes[0].plot(table["mean_pa"] / 1e6, notch * table["amplitude_pa"] / 1e6, "o", ms=4)
    axes[0].set_xlabel("mean stress / MPa")
    axes[0].set_ylabel("amplitude / MPa")
    axes[0].legend()
    wall = table["r_m"] > 0.9 * table["r_m"].max()
    axes[1].plot(1e3 * table["z_m"][wall], table["safety"][wall], "o", ms=4)
    axes[1].axhline(1, color="k", lw=1)
    axes[1].set_ylim(0, min(10, 1.1 * table["safety"][wall].max()))
    axes[1].set_xlabel("distance from the opening / mm")
    axes[1].set_title(f"safety by Goodman, wall; least {table['safety'].min():.2f} at {table['torque_nm'][0]:.3g} N m", fontsize=12)
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
    axes[1].plot(angle, table["stiffness_nm_per_rad"] / 1e3, "C1o-", ms=4)
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
