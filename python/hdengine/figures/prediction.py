# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure of a predicted joint."""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from .style import new_axes, styled

if TYPE_CHECKING:
    from ..prediction.law import Prediction

__all__: list[str] = []


@styled
def plot_prediction(found: Prediction) -> Figure:
    """Stiffness over pressure with the band, and the spectrum (a figure).

    Parameters
    ----------
    found : Prediction
    """
    figure, (left, right) = new_axes(1, 2, figsize=(12, 5))
    t, p = found.table, found.table["pressure_pa"] / 1e6
    for name, label, colour in (("k_n_pa_per_m", "normal", "C0"), ("k_t_pa_per_m", "tangential, full stick", "C1")):
        left.plot(p, t[name], "o-", color=colour, label=label, ms=4)
        left.fill_between(p, t[f"{name}_low"], t[f"{name}_high"], color=colour, alpha=0.2, lw=0)
    left.set(xscale="log", yscale="log", xlabel="nominal pressure / MPa", ylabel="stiffness per area / (Pa/m)",
             title=f"by {found.model.replace('_', ' ')}, 95 % band")
    left.legend()
    s = found.spectrum
    right.plot(s.q, np.where(s.c > 0, s.c, np.nan), "C2")
    right.set(xscale="log", yscale="log", xlabel="wavenumber q / (1/m)", ylabel=r"$C(q)$ / m$^4$",
              title=f"equivalent surface, {1e6 * s.h_rms:.3g} µm rms, slope {s.slope_rms:.2g}")
    return figure
