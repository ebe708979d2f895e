# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of surfaces."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .style import new_axes, new_figure, styled

if TYPE_CHECKING:
    from ..surfaces.fit import Fit
    from ..surfaces.specimen import JointSurface, Specimen

__all__: list[str] = []


@styled
def plot_fit(fit: Fit, axis: Axes | None = None, label: str = "measured", colour: str = "C0") -> Axes:
    """S over the lag with the fitted model and its 95 % band.

    Parameters
    ----------
    fit : hdengine.roughness.Fit
        What to draw.
    axis : matplotlib.axes.Axes, optional
        Where; default: a new figure.
    label, colour : str
        Name and colour of the data.

    Returns
    -------
    matplotlib.axes.Axes
    """
    if axis is None:
        axis = new_axes(figsize=(7, 5))[1]
    fitted = np.isfinite(fit.fractal_dimension)
    low, high = fit.band
    for i, (way, part) in enumerate(fit.directions()):
        tau = fit.tau_m[part] * 1e6
        name = label if i == 0 and len(fit.directions()) == 1 else f"{label}, {way}"
        axis.loglog(tau, fit.s_m2[part] * 1e12, "os"[i], ms=5, mfc="none", color=colour, label=name)
        if fitted:
            g = f", G = {1e6 * fit.roughness_m:.4g} µm" if fit.determined else ", G not determined"
            text = f"D = {fit.fractal_dimension:.4f}{g}" if fit.verdict == "fractal" else "model, no D and G of this surface"
            axis.loglog(tau, fit.curve_m2[part] * 1e12, ("-", "--")[i], color=colour, label=text if i == 0 else None)
            axis.fill_between(tau, low[part] * 1e12, high[part] * 1e12, color=colour, alpha=0.2 if i == 0 else 0.1, lw=0)
    _label_lags(axis)
    axis.set_ylabel("S(τ) / µm²")
    axis.legend(fontsize=10)
    return axis


@styled
def plot_residual(fit: Fit, axis: Axes, colour: str = "C0") -> None:
    """What S is off the model by, in percent, with the 95 % band."""
    if not np.isfinite(fit.fractal_dimension):
        return
    low, high = (100 * (b / fit.curve_m2 - 1) for b in fit.band)
    for i, (_, part) in enumerate(fit.directions()):
        tau = fit.tau_m[part] * 1e6
        axis.semilogx(tau, 100 * (fit.s_m2 / fit.curve_m2 - 1)[part], "os"[i], ms=5, mfc="none", color=colour)
        axis.fill_between(tau, low[part], high[part], color=colour, alpha=0.2 if i == 0 else 0.1, lw=0)
    axis.axhline(0, color="k", lw=0.8)
    _label_lags(axis)
    axis.set_ylabel("S / model - 1 / %")


def _label_lags(axis):
    """Lags at 1, 2, 5 of each decade, in decimals."""
    from matplotlib.ticker import LogLocator, NullFormatter

    axis.set_xlabel("lag τ / µm")
    axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.xaxis.set_major_formatter("{x:g}")
    axis.xaxis.set_minor_formatter(NullFormatter())


@styled
def plot_map(specimen: Specimen, axis: Axes) -> None:
    """Height map, or the profile of a line scan, less its plane."""
    z = specimen.levelled() * 1e6
    if z.ndim == 1:
        axis.plot(np.arange(z.size) * specimen.spacing[1] * 1e6, z, lw=0.8)
        axis.set_ylabel("height / µm")
    else:
        size = [1e6 * s for s in specimen.size]
        image = axis.imshow(z, origin="lower", extent=(0, size[1], 0, size[0]), cmap="viridis")
        axis.grid(False)
        axis.set_ylabel("y / µm")
        axis.figure.colorbar(image, ax=axis, label="height above the mean plane / µm", shrink=0.85)
    axis.set_xlabel("x / µm")
    axis.set_title(specimen.name, fontsize=12)


@styled
def plot_specimen(specimen: Specimen, fit: Fit) -> Figure:
    """One specimen: map and structure function.

    Parameters
    ----------
    specimen : hdengine.specimen.Specimen
        What was read.
    fit : hdengine.roughness.Fit
        Its fit.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = new_figure(figsize=(12, 5.5))
    halves: Any = figure.subfigures(1, 2)
    left, right = halves
    plot_map(specimen, left.subplots())
    axes = right.subplots(2, 1, sharex=True, height_ratios=(2.2, 1))
    plot_fit(fit, axes[0])
    plot_residual(fit, axes[1])
    axes[0].set_xlabel("")
    axes[0].set_title(f"{fit.verdict}" + (f": {fit.kind}" if fit.kind not in fit.verdict else ""), fontsize=12)
    return figure


@styled
def plot_joint_surface(joint: JointSurface) -> Figure:
    """Both specimens, their middle rows, and the three structure functions with fit and 95 % band (Fig. 5).

    Parameters
    ----------
    joint : hdengine.specimen.JointSurface
        What to draw.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = new_figure(figsize=(12, 10))
    halves: Any = figure.subfigures(2, 1)
    top, bottom = halves
    for specimen, axis in zip(joint.specimens, top.subplots(1, 2)):
        plot_map(specimen, axis)
    left, right = bottom.subfigures(1, 2)
    axis = left.subplots()
    for i, specimen in enumerate(joint.specimens):
        z = specimen.levelled()
        z = z if z.ndim == 1 else z[z.shape[0] // 2]
        x = np.arange(z.size) * specimen.spacing[1] * 1e6
        axis.plot(x, 1e6 * z, color=f"C{i}", lw=1, label=specimen.name)
    axis.set_xlabel("x / µm")
    axis.set_ylabel("height / µm")
    axis.set_title("middle rows", fontsize=12)
    axis.legend(fontsize=10, loc="upper right")
    axes = right.subplots(2, 1, sharex=True, height_ratios=(2.2, 1))
    names = [s.name for s in joint.specimens] + ["equivalent, $S_1 + S_2$"]
    for i, (fit, name) in enumerate(zip((*joint.fits, joint.equivalent), names)):
        plot_fit(fit, axes[0], name, f"C{i}")
        plot_residual(fit, axes[1], f"C{i}")
    axes[0].set_title("structure functions, fit and 95 % band", fontsize=12)
    axes[0].set_xlabel("")
    axes[0].legend(fontsize=8)
    return figure
