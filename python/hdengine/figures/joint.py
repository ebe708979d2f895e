# SPDX-License-Identifier: GPL-3.0-or-later
"""The figure of a joint."""
from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from .style import new_axes, styled

if TYPE_CHECKING:
    from ..joint import Joint

__all__: list[str] = []


@styled
def plot_joint(joint: Joint, pressure: np.ndarray, axis: Axes | None = None) -> Axes:
    """K_N and K_T per nominal area over the pressure, with the regime of the largest spot shaded.

    Parameters
    ----------
    joint : Joint
    pressure : ndarray
        [Pa].
    axis : matplotlib axes, optional

    Returns
    -------
    matplotlib axes
    """
    axis = axis or new_axes(figsize=(8, 5))[1]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        k_n, k_t = joint.stiffness(pressure)
        s_l, _ = joint.largest_spot(pressure)
    area = joint.reference_area
    axis.loglog(pressure / 1e6, k_n / area, label="$K_N / A_0$")
    axis.loglog(pressure / 1e6, k_t / area, "--", label="$K_T / A_0$, no shear")
    edges = np.array([0, 1, 7.119718, 205.382706, np.inf]) * joint.asperity()[0]["s_ec_m2"]
    for i, (name, colour) in enumerate(zip(("elastic", "elastoplastic 1", "elastoplastic 2", "plastic"), "wygr")):
        inside = (s_l > edges[i]) & (s_l <= edges[i + 1])
        if colour != "w" and inside.any():
            axis.axvspan(pressure[inside].min() / 1e6, pressure[inside].max() / 1e6, color=colour, alpha=0.12, lw=0,
                         label=f"largest spot {name}")
    axis.set_xlabel("nominal pressure / MPa")
    axis.set_ylabel("stiffness per area / (Pa/m)")
    axis.set_title(f"D = {joint.fractal_dimension:g}, G = {joint.roughness:.4g} m, $r_m$ = {1e6 * joint.asperity_radius:g} µm, "
                   f"$s_{{min}}$ = {joint.s_min:.3g} m²", fontsize=12)
    axis.legend(loc="upper left", fontsize=11)
    return axis
