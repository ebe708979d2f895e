# SPDX-License-Identifier: GPL-3.0-or-later
"""The figure of a record of a test bench."""
from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from .style import new_axes, styled

if TYPE_CHECKING:
    from ..record import Record

__all__: list[str] = []
ARCMIN = 180 * 60 / pi


@styled
def plot_record(record: Record) -> Figure:
    """Loop of torque over angle, and stiffness over torque with its 95 % band.

    Parameters
    ----------
    record : hdengine.record.Record

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = new_axes(1, 2, figsize=(11, 4.4))
    axes[0].plot(record.angle_rad * ARCMIN, record.torque_nm, ".", ms=2, color="0.6", label="readings")
    curve = record.curve()
    axes[0].plot(curve.angle_rad * ARCMIN, curve.torque_nm, color="C0", label="middle curve")
    axes[0].set_xlabel("angle / arcmin")
    axes[0].set_ylabel("torque / N m")
    axes[0].legend()
    branches = {branch: record.curve(branch) for branch in ("middle", "up", "down")}
    for (branch, c), colour in zip(branches.items(), ("C0", "C1", "C2")):
        axes[1].plot(c.torque_nm, c.stiffness_nm_per_rad / 1e3, color=colour, label={
            "middle": "middle", "up": "rising torque", "down": "falling torque"}[branch])
        axes[1].fill_between(c.torque_nm, c.low_nm_per_rad / 1e3, c.high_nm_per_rad / 1e3, color=colour, alpha=0.2, lw=0)
    axes[1].set_xlabel("torque / N m")
    axes[1].set_ylabel("stiffness dT/dθ / (kN m/rad)")
    axes[1].set_ylim(0, 1.1e-3 * max(np.percentile(c.stiffness_nm_per_rad, 99) for c in branches.values()))
    axes[1].legend(title="95 % band")
    return figure
