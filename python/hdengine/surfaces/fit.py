# SPDX-License-Identifier: GPL-3.0-or-later
"""What a fit of D and G is told, and what it returns."""
from __future__ import annotations

from dataclasses import dataclass, field
from math import floor, inf, log
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .. import _engine
from .._check import AXES, checked, fields, integer, number, text
from .._engine import InputError
from ..results import preformatted

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Fit", "Ridges"]

_OFFSETS = 3     # power of an axis over that of other directions that is told of (hd_map_fit)
_UNEQUAL = 0.4   # ln of S of rows over S of columns that isotropic maps stay below
_DETERMINED = _engine.ask("determined_dimension")   # lowest end of the interval of D at which G is determined (hd_verdict)


def micrometres(*lengths: float, digits: int = 3) -> str:
    """Lengths [m] as one text, "1 to 20 µm": the unit of roughness and of its standards."""
    return " to ".join(f"{1e6 * length:.{digits}g}" for length in lengths) + " µm"


def rows_alone(lags: tuple, *maps: np.ndarray) -> bool:
    """A map (rows, points) has too few rows for S along columns over the lags, as the engine has it (hd_observation)."""
    return any(lags[1] > (len(np.atleast_2d(z)) - 1) // 2 for z in maps)


@dataclass(frozen=True)
class Ridges:
    """What is known of a surface made by Eq. 1.

    Parameters
    ----------
    length : float
        L [m].
    shortest_wavelength : float
        L_s [m]; n_max = floor(ln(L/L_s)/ln gamma).
    ridges : int
        M.
    gamma : float
        Frequency ratio > 1.
    """

    length: float
    shortest_wavelength: float
    ridges: int = 10
    gamma: float = 1.5

    def __post_init__(self) -> None:
        fields(self, length=number(), shortest_wavelength=number(), ridges=integer(-2**31), gamma=number())

    @property
    def n_max(self) -> int:
        """Highest index of the sum."""
        if not (self.gamma > 1 and 0 < self.shortest_wavelength <= self.length < inf and self.ridges >= 1):
            raise InputError(f"{self}: gamma > 1, 0 < shortest_wavelength <= length and ridges >= 1 are needed")
        return floor((log(self.length) - log(self.shortest_wavelength)) / log(self.gamma) + 1e-9)

    @property
    def band(self) -> tuple:
        """Wavelengths (shortest, longest) of the continuous band with the same power [m]."""
        return self.length * self.gamma ** -(self.n_max + 0.5), self.length * self.gamma**0.5


@dataclass(frozen=True)
class Fit:
    """Result of `fit`. `print(fit)` tells it all, `fit.plot()` draws it."""

    fractal_dimension: float                #: D
    roughness_m: float                      #: G [m]
    fractal_dimension_error: float          #: standard error of D: a 3.92th of its 95 % interval
    ln_roughness_error: float               #: standard error of ln G
    covariance: np.ndarray = field(repr=False)  #: of D, ln G, noise variance [m^2] (3, 3), were that free to be negative
    interval: tuple                         #: 95 % intervals ((D_low, D_high), (G_low, G_high)) [-, m] of sampling and misfit
    sampling_interval: tuple                #: the same of sampling alone: right if the model is
    noise_m: float                          #: rms of white noise, fitted or given [m]
    verdict: str                            #: "fractal", "not fractal" or "noise-dominated"
    kind: str                               #: what it is: fractal, sine, square wave, steps, plane, constant, white noise, ...
    reason: str                             #: why
    model: str                              #: spectrum, ridges or paper; isotropic or profile where the spectrum has lines
    weighted: bool                          #: by the inverse covariance of ln S
    ensemble: str                           #: covariance taken from: "random phases" or "Gaussian field"
    lags: tuple                             #: window, first and last lag [points]
    band_m: tuple                           #: shortest and longest wavelength of the model [m]
    rms: float                              #: of the residuals of ln S
    rms_expected: float                     #: what sampling alone leaves
    misfit: float                           #: rms of ln S the model itself is off by
    chi2: float                             #: of a weighted fit
    freedom: int                            #: degrees of freedom
    anisotropy: float                       #: mean ratio of S along rows and along columns over equal distances; nan for a profile
    tilt: tuple                             #: slope of the least-squares plane along x and y
    levelled: bool                          #: that plane was taken off
    tau_m: np.ndarray = field(repr=False)       #: lags [m]
    s_m2: np.ndarray = field(repr=False)        #: measured S [m^2]
    curve_m2: np.ndarray = field(repr=False)    #: S of the model [m^2]
    curve_error: np.ndarray = field(repr=False)  #: standard error of ln of the model
    sample_error: np.ndarray = field(repr=False)  #: standard deviation of measured ln S about the model
    rows_alone: bool = False                #: S is that of rows: a profile, or a map with too few rows for the lags
    ridges: Ridges | None = None            #: the sum of Eq. 1 that was told
    probe_m: float = float("nan")           #: standard deviation of the Gaussian probe that blurs the map, fitted [m]
    finer_detail: float = float("nan")      #: detail that folds back: 0 none, 0.5 down to half the spacing, 1 to a fifth
    spikes: int = 0                         #: wrong points, masked
    wrong_from_m: tuple = (0.0, 0.0)        #: height over its surroundings from which on a point, a clump counts as wrong [m]
    holes: int = 0                          #: points filled, wrong points among them
    seams: tuple = (0, 0)                   #: steps of stitching across x and across y, levelled
    seam_step_m: float = 0.0                #: the largest of them [m]
    jitter_m: tuple = (0.0, 0.0)            #: rms offset of single columns and of single rows that was taken off [m]
    axis_excess: tuple = ()                 #: power of waves along x and along y over that of rings; above 3: jitter or a lay
    ranges: tuple = ()                      #: D, shortest and longest wavelength [m] of the range; of a crossover of both
    frequency: np.ndarray = field(repr=False, default=cast(Any, None))  #: of the rings [1/m]
    density: np.ndarray = field(repr=False, default=cast(Any, None))    #: measured power [m^4], of a line [m^3]
    density_model: np.ndarray = field(repr=False, default=cast(Any, None))  #: the model's; NaN outside the window

    @property
    def determined(self) -> bool:
        """The interval of D keeps off 2, where every G fits, by the engine's bound."""
        return bool(np.isfinite(self.fractal_dimension)) and self.interval[0][0] >= _DETERMINED

    @property
    def band(self) -> tuple:
        """95 % band of measured S about the model: (low, high) [m^2]."""
        w = np.exp(1.959964 * self.sample_error)
        return self.curve_m2 / w, self.curve_m2 * w

    def directions(self) -> list:
        """Directions of S, with the places of their lags in the arrays: [(name, indices), ..]."""
        n, count = len(self.tau_m), self.lags[1] - self.lags[0] + 1
        if n <= count:
            return [("rows" if self.rows_alone else "rows and columns", np.arange(n))]
        names = ("rows", "columns") if n == 2 * count else ("rows and columns", "diagonals")
        return [(names[0], np.arange(count)), (names[1], np.arange(count, n))]

    def __str__(self) -> str:
        lines = [f"verdict   {self.verdict}" + (f" ({self.kind})" if self.kind != self.verdict else "") + f": {self.reason}"]
        if np.isfinite(self.fractal_dimension):
            (d_low, d_high), g = self.interval
            (s_low, s_high), _ = self.sampling_interval
            lines += [
                f"D         {self.fractal_dimension:.4f}, {d_low:.4f} to {d_high:.4f} (95 %; by sampling alone {s_low:.4f} to "
                f"{s_high:.4f}), D_s = {self.fractal_dimension - 1:.4f}",
                "G         not determined: the interval of D reaches 2" if not self.determined else
                f"G         {micrometres(self.roughness_m, digits=4)}, {micrometres(*g)} (95 %)",
            ] if self.verdict == "fractal" else ["D, G      none that describe this surface"]
            how = f"{self.model}, {'weighted' if self.weighted else 'least squares of ln S'}, errors: {self.ensemble}"
            misfit = f"residual  rms of ln S {self.rms:.2g}, {self.rms_expected:.2g} expected from sampling, model off by " \
                     f"{self.misfit:.2g}" + (f", chi2 {self.chi2:.1f} / {self.freedom}" if self.weighted else "")
            if self.model == "spectrum":
                how = f"spectrum, wavelengths {micrometres(*self.band_m)}, probe {micrometres(self.probe_m, digits=2)}, " \
                      f"finer detail {self.finer_detail:.2g} of 1"
                misfit = f"misfit    {self.misfit:.2g} of ln power beyond chance, deviance {self.chi2:.1f} / {self.freedom}"
            if self.ridges:
                told = self.ridges
                how += f"\nridges    {told.ridges}, gamma {told.gamma:g}, L {micrometres(told.length, digits=6)}, L_s " \
                       f"{micrometres(told.shortest_wavelength, digits=6)}"
            lines += [f"fit       {how}", misfit]
            if len(self.ranges) == 2:
                words = (f"D = {d:.3g} from {micrometres(low, high)}" for d, low, high in self.ranges)
                lines[1:len(lines) - 2] = ["ranges    " + ", ".join(words)]
            if max(self.wrong_from_m) > 0 or self.holes:
                lines.append(f"points    {self.spikes} wrong points masked"
                             + (f", {self.holes} holes filled, wrong points among them" if self.holes else "")
                             + (f"; lower than {micrometres(self.wrong_from_m[0])} over their surroundings (clumps "
                                f"{micrometres(self.wrong_from_m[1])}) they are not seen" if max(self.wrong_from_m) > 0 else ""))
            if max(self.seams) > 0:
                across_x, across_y = self.seams
                lines.append(f"seams     {across_x} across x, {across_y} across y, steps up to "
                             f"{micrometres(self.seam_step_m)}, levelled")
            for name, what, excess, rms in zip("xy", ("columns", "rows"), self.axis_excess, self.jitter_m):
                if excess > _OFFSETS:
                    done = "nothing taken off" if not rms > 0 else \
                        f"white offsets of {what} of {micrometres(rms)} rms taken off (jitter)"
                    lines.append(f"axes      waves along {name} hold {excess:.3g} times the power of other directions: {done}")
            if self.noise_m > 0:
                lines.append(f"noise     {micrometres(self.noise_m)} rms")
        lines.append(f"window    lags {self.lags[0]} to {self.lags[1]} ({micrometres(self.tau_m.min(), self.tau_m.max())}), "
                     f"{'plane taken off' if self.levelled else 'not levelled'}, tilt {self.tilt[0]:.2g}, {self.tilt[1]:.2g}")
        if np.isfinite(self.anisotropy):
            lines.append(f"anisotropy S(rows)/S(columns) = {self.anisotropy:.3g}"
                         + (": not isotropic, D and G are means of both"
                            if self.verdict == "fractal" and abs(np.log(self.anisotropy)) > _UNEQUAL else ""))
        return "\n".join(lines)

    def _repr_html_(self):
        return preformatted(self)

    @checked(axis=AXES, label=text, colour=text)
    def plot(self, axis: Axes | None = None, label: str = "measured", colour: str = "C0") -> Axes:
        """S with the fit and its 95 % band.

        Parameters
        ----------
        axis : matplotlib.axes.Axes, optional
            Where to draw; default: a new figure.
        label : str
            Name of the data in the legend.
        colour : str
            Matplotlib colour.

        Returns
        -------
        matplotlib.axes.Axes
        """
        from matplotlib.colors import is_color_like

        from ..figures.surface import plot_fit

        if not is_color_like(colour):
            raise InputError(f"colour = {colour!r}: must be a colour of matplotlib")
        return plot_fit(self, axis, label, colour)
