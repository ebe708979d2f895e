# SPDX-License-Identifier: GPL-3.0-or-later
"""The figure of tooth profiles: teeth in mesh, and the clearance of the pairs."""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from .style import new_axes, styled

if TYPE_CHECKING:
    from ..teeth.pairs import ToothGaps

__all__: list[str] = []


@styled
def plot_gaps(gaps: ToothGaps) -> Figure:
    """Tooth and space of three places, and clearance and pressure angle over the place.

    Parameters
    ----------
    gaps : hdengine.teeth.pairs.ToothGaps

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = new_axes(1, 3, figsize=(15, 4.6), width_ratios=(1.2, 1, 1))
    table, half = gaps.table, len(gaps.table["pair"]) // 2
    bottom = min(curve[:, 1].min() for curve in gaps.outlines.values())
    for name, curve in gaps.outlines.items():
        fixed = name == "space"
        axes[0].plot(1e6 * curve[:, 0], 1e6 * (curve[:, 1] - bottom), color="k" if fixed else None, lw=2 if fixed else 1.2,
                     label="circular spline" if fixed else name)
    axes[0].set_aspect("equal")
    axes[0].set_xlabel("round the axis / µm")
    axes[0].set_ylabel("outwards / µm")
    axes[0].legend(fontsize=9, loc="lower center")
    place = table["place_pitches"][:half]
    for axis, names, scale, what in ((axes[1], ("gap_m", "gap_back_m"), 1e6, "clearance / µm"),
                                     (axes[2], ("angle_deg", "angle_back_deg"), 1, "pressure angle / °")):
        for name, mark, label in zip(names, ("o-", "s--"), ("flank of a positive torque", "other flank")):
            axis.plot(place, scale * np.asarray(table[name])[:half], mark, ms=4, label=label)
        axis.set_xlabel("place from the long axis / pitches")
        axis.set_ylabel(what)
    axes[1].axhline(0, color="k", lw=0.8)
    axes[1].legend(fontsize=10)
    return figure
