# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of a sensitivity."""
from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ..views.labels import LABELS
from .style import new_axes, styled

__all__: list[str] = []


@styled
def plot_tornado(base: float, ends: dict, ranges: dict, title: str = "", of: str = "K_TS by Eq. 45") -> Figure:
    """Tornado chart: change of a stiffness between the ends of each range.

    Parameters
    ----------
    base : float
        Value in the middle of all ranges [N m/rad].
    ends : dict
        By key, the value at both ends of its range [N m/rad].
    ranges : dict
        By key, the low and the high end in SI units.
    title, of : str
        Name of the figure, of the stiffness.

    Returns
    -------
    matplotlib.figure.Figure
    """
    words = {key: LABELS.get(key, (key.split(".")[-1].replace("_", " "), "", 1)) for key in ends}
    factors = {key: factor for key, (_, _, factor) in words.items()}
    figure, axis = new_axes(figsize=(9, 1.7 + 0.42 * len(ends)))
    for i, (key, values) in enumerate(reversed(ends.items())):
        changes = 100 * (np.array(values) / base - 1)
        right = changes >= 0
        if right[0] == right[1]:  # both texts on one side would cover each other: that of the shorter bar goes to the other
            short = int(np.abs(changes[1]) < np.abs(changes[0]))
            right[short] = not right[short]
        for change, end, colour, away in zip(changes, ranges[key][:2], ("C0", "C1"), right):
            axis.barh(i, change, color=colour, height=0.7)
            place = max(change, 0) if away else min(change, 0)
            text = "band" if isinstance(end, str) else f"{factors[key] * end:.4g}"
            axis.annotate(text, (place, i), xytext=(4 if away else -4, 0), textcoords="offset points", va="center",
                          ha="left" if away else "right", fontsize=9)
    axis.set_yticks(range(len(ends)), [
        f"{name} / {unit}" if unit else name for name, unit, _ in reversed(words.values())], fontsize=11)
    axis.axvspan(-1, 1, color="0.5", alpha=0.15, lw=0)
    axis.axvline(0, color="k", lw=0.8)
    axis.margins(x=0.15)
    axis.set_xlabel(f"change of {of} / % of {base:.4g} N m/rad\nblue: low end, red: high end of the range;\n"
                    "grey: below 1 %, where points change between stick and slip", fontsize=11)
    axis.set_title(title, fontsize=12)
    return figure
