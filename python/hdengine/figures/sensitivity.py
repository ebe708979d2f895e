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
        one_side = changes.min() >= 0 or changes.max() < 0   # then the shorter bar lies on the longer one
        long, short = np.argsort(-abs(changes))
        texts = ["band" if isinstance(end, str) else f"{factors[key] * end:.4g}" for end in ranges[key][:2]]
        if one_side:
            texts[long], texts[short] = f"{texts[long]} (inner bar: {texts[short]})", ""
        for j in (long, short):
            axis.barh(i, changes[j], color=("C0", "C1")[j], height=0.4 if one_side and j == short else 0.7)
            axis.annotate(texts[j], (changes[j], i), xytext=(4 if changes[j] >= 0 else -4, 0), textcoords="offset points",
                          va="center", ha="left" if changes[j] >= 0 else "right", fontsize=9)
    axis.set_yticks(range(len(ends)), [
        f"{name} / {unit}" if unit else name for name, unit, _ in reversed(words.values())], fontsize=10)
    axis.axvspan(-1, 1, color="0.5", alpha=0.15, lw=0)
    axis.axvline(0, color="k", lw=0.8)
    axis.margins(x=0.15)
    axis.set_xlabel(f"change of {of} / % of {base:.4g} N m/rad\nblue: low end, red: high end of the range;\n"
                    "grey: below 1 %, where points change between stick and slip", fontsize=11)
    axis.set_title(title, fontsize=12)
    return figure
