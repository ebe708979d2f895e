# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure height maps: structure function, roughness numbers, and the fit of D and G."""
from dataclasses import dataclass, field
from math import floor, inf, log

import numpy as np

from . import _engine
from ._engine import InputError

_MODELS = {"isotropic": 1, "profile": 2, "ridges": 3, "paper": 4}
_VERDICTS = {1: "fractal", 2: "not fractal", 3: "noise-dominated"}


def _map(heights):
    """Heights as the engine takes them: (points along a row, rows), Fortran order, no copy of a C-ordered array."""
    z = np.asarray(heights, dtype=float)
    if z.ndim == 1:
        z = z[None, :]
    if z.ndim != 2 or z.size == 0:
        raise InputError(f"heights have shape {np.shape(heights)}: give a map (rows, points) or a single profile (points,)")
    if np.ndim(heights) == 2 and 1 in z.shape:
        raise InputError(f"a map of {z.shape[0]} x {z.shape[1]} points is a single line: give a profile as a one-dimensional array")
    return np.asfortranarray(z.T)


def _spacing(spacing):
    """(dx, dy) [m] of one number or of (dy, dx)."""
    d = np.atleast_1d(np.asarray(spacing, dtype=float))
    if d.shape not in ((1,), (2,)) or not np.all(np.isfinite(d)) or not np.all(d > 0):
        raise InputError(f"spacing = {spacing}: give the distance of points in m, positive, one number or (dy, dx)")
    return float(d[-1]), float(d[0])


def structure_function(heights, spacing, lags=None, direction="rows", second=False):
    """Structure function S(tau) = mean (z(x + tau) - z(x))^2; NaN are holes.

    Short lags are summed directly, long ones come from FFTs; every value has a relative error below 1e-12.

    Parameters
    ----------
    heights : array_like (rows, points) or (points,)
        Heights [m].
    spacing : float or (float, float)
        Spacing (dy, dx) [m].
    lags : sequence of int, optional
        Lags in steps, >= 1. Default: all.
    direction : "rows", "columns", "radial" or (int, int)
        Along rows, along columns, mean over rings one spacing wide, or a step (p, q) in points along a row and in rows.
    second : bool
        Second-difference form, mean (z(x + tau) - 2 z(x) + z(x - tau))^2 = 4 S(tau) - S(2 tau): blind to tilt.

    Returns
    -------
    tau, s, pairs : ndarray
        Lags [m], S [m^2] (NaN where no pair is left), numbers of pairs.

    Raises
    ------
    InputError
        No finite height, a row of one point, a spacing or lag that is not positive.
    """
    z = _map(heights)
    dx, dy = _spacing(spacing)
    if isinstance(direction, str) and direction == "radial":
        if second:
            raise InputError("the second-difference form is along a direction, not radial")
        n = max(1, max(z.shape) // 2) if lags is None else int(np.max(lags))
        tau, s, pairs = _engine.call("structure_rings", z, dx, dy, max(n, 1))
        pick = slice(None) if lags is None else np.asarray(lags, dtype=int) - 1
        return tau[pick], s[pick], pairs[pick]
    steps = {"rows": (1, 0), "columns": (0, 1)}
    if isinstance(direction, str) and direction not in steps:
        raise InputError(f'direction = {direction!r}: "rows", "columns", "radial" or a step (p, q)')
    p, q = steps[direction] if isinstance(direction, str) else (int(direction[0]), int(direction[1]))
    if q < 0:
        p, q = -p, -q
    if lags is None:
        reach = [(n - 1) // abs(k) for n, k in zip(z.shape, (p, q)) if k]
        lags = np.arange(1, max(2, min(reach, default=1) // (2 if second else 1) + 1))
    lags = np.asarray(lags, dtype=np.int32)
    if lags.ndim != 1 or lags.size == 0 or lags.min() < 1:
        raise InputError("lags must be a list of whole numbers >= 1")
    s, pairs = _engine.call("structure_direction", z, p, q, int(bool(second)), lags)
    return lags * np.hypot(p * dx, q * dy), s, pairs


def expected_structure(tau, fractal_dimension, roughness, band, model="isotropic"):
    """Mean structure function of a continuous band with the power of Eq. 1 (isotropic) or Eq. 2 (profile).

    S = G^(2(D-2)) times the integral of f^(-a-1) (1 - c(2 pi f tau)) over the band, a = 6 - 2D, c = J0 or cos.

    Parameters
    ----------
    tau : array_like
        Lags [m], > 0.
    fractal_dimension, roughness : float
        D in (2, 3), G [m].
    band : (float, float)
        Shortest and longest wavelength [m]; the first may be 0.
    model : {"isotropic", "profile"}
        All directions of a surface, or one profile.

    Returns
    -------
    ndarray
        S [m^2].

    Raises
    ------
    InputError
        A number is out of range.
    """
    tau = np.asarray(tau, dtype=float)
    if model not in ("isotropic", "profile"):
        raise InputError(f'model = {model!r}: "isotropic" or "profile"')
    if not (2 < fractal_dimension < 3 and roughness > 0 and np.all((tau > 0) & (tau < inf)) and 0 <= band[0] < band[1]):
        raise InputError("2 < D < 3, G > 0, lags > 0 and 0 <= shortest < longest wavelength are needed")
    top = 1 / band[0] if band[0] > 0 else inf
    s = _engine.call("structure_expected", _MODELS[model], fractal_dimension, 1 / band[1], top, tau.ravel())
    return roughness ** (2 * (fractal_dimension - 2)) * s.reshape(tau.shape)


def level(heights):
    """Heights less their least-squares plane (a profile: line); holes stay holes.

    Parameters
    ----------
    heights : array_like (rows, points) or (points,)
        Heights [m].

    Returns
    -------
    ndarray
        Same shape [m].
    """
    z = np.array(_map(heights), order="F", copy=True)
    _engine.call("surface_level", z)
    return z.T.reshape(np.shape(heights))


def parameters(heights, spacing):
    """Roughness numbers named as in ISO 25178-2, of the heights less their plane.

    Parameters
    ----------
    heights : array_like (rows, points) or (points,)
        Heights [m]; NaN are holes.
    spacing : float or (float, float)
        Spacing (dy, dx) [m].

    Returns
    -------
    dict
        sa_m, sq_m, sz_m, ssk, sku; sdq (root mean square gradient over one spacing: Sdq^2 = S_x(1)/dx^2 + S_y(1)/dy^2);
        bandwidth_m: shortest and longest wavelength that the map holds, two spacings and its shorter side; nayak: Nayak's
        bandwidth parameter m0 m4/m2^2 along rows, from first and second differences.
    """
    dx, dy = _spacing(spacing)
    v = _engine.call("surface_roughness", _map(heights), dx, dy).tolist()
    names = ("sa_m", "sq_m", "sz_m", "ssk", "sku", "sdq")
    return dict(zip(names, v)) | {"bandwidth_m": (v[6], v[7]), "nayak": v[8]}


def psd(heights, spacing, direction="rows"):
    """Power spectral density of the heights less their plane, under a Hann window.

    Parameters
    ----------
    heights : array_like (rows, points) or (points,)
        Heights [m], without holes.
    spacing : float or (float, float)
        Spacing (dy, dx) [m].
    direction : "rows", "columns" or "radial"
        One-sided spectrum of profiles, mean over all; or two-dimensional spectrum, mean over rings.

    Returns
    -------
    frequency : ndarray
        1/wavelength [1/m], without 0.
    density : ndarray
        [m^3] of profiles: its integral over the frequency is Sq^2; [m^4] radial.

    Raises
    ------
    InputError
        The map has holes.
    """
    z = _map(heights)
    dx, dy = _spacing(spacing)
    if direction not in ("rows", "columns", "radial"):
        raise InputError(f'direction = {direction!r}: "rows", "columns" or "radial"')
    if direction == "radial":
        rings = floor(0.5 * max(z.shape[0] * dx, z.shape[1] * dy) / max(dx, dy) + 1e-9)
        return _engine.call("surface_spectrum", z, dx, dy, 1, rings)
    if direction == "columns":
        z, dx = np.asfortranarray(z.T), dy
    return _engine.call("surface_spectrum", z, dx, dy, 0, z.shape[0] // 2)


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

    @property
    def n_max(self):
        """Highest index of the sum."""
        if not (self.gamma > 1 and 0 < self.shortest_wavelength <= self.length < inf and self.ridges >= 1):
            raise InputError(f"{self}: gamma > 1, 0 < shortest_wavelength <= length and ridges >= 1 are needed")
        return floor(log(self.length / self.shortest_wavelength) / log(self.gamma) + 1e-9)

    @property
    def band(self):
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
    model: str                              #: isotropic, profile, ridges or paper
    weighted: bool                          #: by the inverse covariance of ln S
    ensemble: str                           #: covariance taken from: "random phases" or "Gaussian field"
    lags: tuple                             #: window, first and last lag [points]
    band_m: tuple                           #: shortest and longest wavelength of the model [m]
    rms: float                              #: of the residuals of ln S
    rms_expected: float                     #: what sampling alone leaves
    misfit: float                           #: rms of ln S the model itself is off by
    chi2: float                             #: of a weighted fit
    freedom: int                            #: degrees of freedom
    anisotropy: float                       #: mean ratio of S along rows and along columns; nan for a profile
    tilt: tuple                             #: slope of the least-squares plane along x and y
    levelled: bool                          #: that plane was taken off
    tau_m: np.ndarray = field(repr=False)       #: lags [m]
    s_m2: np.ndarray = field(repr=False)        #: measured S [m^2]
    curve_m2: np.ndarray = field(repr=False)    #: S of the model [m^2]
    curve_error: np.ndarray = field(repr=False)  #: standard error of ln of the model
    sample_error: np.ndarray = field(repr=False)  #: standard deviation of measured ln S about the model
    ridges: Ridges | None = None            #: the sum of Eq. 1 that was told or recognised

    @property
    def band(self):
        """95 % band of measured S about the model: (low, high) [m^2]."""
        w = np.exp(1.959964 * self.sample_error)
        return self.curve_m2 / w, self.curve_m2 * w

    def __str__(self):
        lines = [f"verdict   {self.verdict}" + (f" ({self.kind})" if self.kind != self.verdict else "") + f": {self.reason}"]
        if np.isfinite(self.fractal_dimension):
            (d_low, d_high), (low, high) = self.interval
            (s_low, s_high), _ = self.sampling_interval
            lines += [
                f"D         {self.fractal_dimension:.4f}, {d_low:.4f} to {d_high:.4f} (95 %; by sampling alone {s_low:.4f} to "
                f"{s_high:.4f}), D_s = {self.fractal_dimension - 1:.4f}",
                f"G         {self.roughness_m:.4g} m, {low:.3g} to {high:.3g} m (95 %)",
                f"fit       {self.model}, {'weighted' if self.weighted else 'least squares of ln S'}, errors: {self.ensemble}",
                *([f"ridges    {self.ridges}"] if self.ridges else []),
                f"residual  rms of ln S {self.rms:.2g}, {self.rms_expected:.2g} expected from sampling, model off by "
                f"{self.misfit:.2g}" + (f", chi2 {self.chi2:.1f} / {self.freedom}" if self.weighted else ""),
            ]
            if self.noise_m > 0:
                lines.append(f"noise     {self.noise_m:.3g} m rms")
        lines.append(f"window    lags {self.lags[0]} to {self.lags[1]} ({self.tau_m.min():.3g} to {self.tau_m.max():.3g} m), "
                     f"{'plane taken off' if self.levelled else 'not levelled'}, tilt {self.tilt[0]:.2g}, {self.tilt[1]:.2g}")
        if np.isfinite(self.anisotropy):
            lines.append(f"anisotropy S(rows)/S(columns) = {self.anisotropy:.3g}"
                         + (": not isotropic, D and G are means of both" if abs(np.log(self.anisotropy)) > 0.4 else ""))
        return "\n".join(lines)

    def plot(self, axis=None, label="measured", colour="C0"):
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
        from .plot_surface import plot_fit

        return plot_fit(self, axis, label, colour)


def fit(heights, spacing, lags=(1, 20), model=None, surface=None, weighted=None, level=True, band=None, noise=0.0, second=None):
    """Fit D and G to the structure function over a window of short lags.

    A sum of Eq. 1 (told by `surface`, or recognised by the lines of its spectrum): two-step generalised least squares on the exact
    sum, errors from random phases. Any other map: least squares of ln S on a continuous isotropic band (of a single profile:
    Eq. 2), errors from the covariance of S of a Gaussian field plus what the model is seen to be off by.

    Parameters
    ----------
    heights : array_like (rows, points) or (points,)
        Heights [m]; NaN are holes.
    spacing : float or (float, float)
        Spacing (dy, dx) [m].
    lags : (int, int)
        First and last lag [points].
    model : {"isotropic", "profile", "ridges", "paper"}, optional
        Default: "ridges" for a sum of Eq. 1, else "isotropic" or "profile"; a model given is fitted without looking for lines.
        "paper" is the straight line with the literature's (Majumdar-Bhushan) constant: G is wrong by 2.2 (profile) or 1.4.
    surface : Ridges, optional
        What is known of a surface made by Eq. 1. Without it, M, gamma and the frequencies are looked for in the spectrum.
    weighted : bool, optional
        Weight by the inverse covariance; default: for "ridges" only, where the model is exact.
    level : bool
        Take the least-squares plane off; the model accounts for what this takes from S.
    band : (float, float), optional
        Shortest and longest wavelength of the surface [m]; the first may be 0. Default: that of `surface`, else one spacing and
        the longer side.
    noise : float or "fit"
        Rms of white instrument noise [m]: known, or a third unknown.
    second : array_like, optional
        Another specimen with the same spacing: D and G are those of S_eq = S_1 + S_2, the equivalent rough surface of the joint.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        Map without heights, too small for the window, spacing not positive, unknown model.
    """
    z = _map(heights)
    other = np.zeros((1, 1), order="F") if second is None else _map(second)
    dx, dy = _spacing(spacing)
    profile = z.shape[1] == 1
    search = model is None and surface is None and not profile
    if model is None:
        model = "ridges" if surface is not None else "profile" if profile else "isotropic"
    if model not in _MODELS:
        raise InputError(f"model = {model!r}: one of {', '.join(_MODELS)}")
    if model == "ridges" and surface is None:
        raise InputError('model "ridges" needs surface=Ridges(...), what is known of the sum')
    weighted = model == "ridges" if weighted is None else bool(weighted)
    if weighted and model != "ridges":
        raise InputError(f'weighted=True is sound for the exact model "ridges" only: with {model!r} it is biased many times over')
    if band is None:
        band = surface.band if surface is not None else (min(dx, dy), max((z.shape[0] - 1) * dx, (z.shape[1] - 1) * dy))
    if not 0 <= band[0] < band[1]:
        raise InputError(f"band = {band}: shortest and longest wavelength in m, 0 <= shortest < longest")
    free = isinstance(noise, str)
    if (free and noise != "fit") or (not free and not 0 <= noise < inf):
        raise InputError(f'noise = {noise!r}: rms in m, >= 0, or "fit"')
    known = surface is not None
    waves = surface if known else Ridges(1.0, 0.5)
    if known and waves.ridges * (waves.n_max + 1) > 4000:
        raise InputError(f"{waves.ridges * (waves.n_max + 1)} waves: the covariance takes up to 4000; leave out surface=")
    whole = [lags[0], lags[1], bool(level), _MODELS[model], weighted, known, free, waves.ridges, waves.n_max, search]
    reals = [1 / band[1], 1 / band[0] if band[0] > 0 else inf, waves.gamma, waves.length, 0.0 if free else noise]
    columns = 2 * max(1, int(lags[1]) - int(lags[0]) + 1)
    whole = np.array(whole, dtype=np.int32)
    numbers, curves, name, reason = _engine.call("surface_fit", z, other, dx, dy, whole, np.array(reals), columns)
    if numbers[29] > 0:
        count, n_max, gamma, length = numbers[29:33].tolist()
        surface = Ridges(length, length * gamma**-n_max, int(count), gamma)
        model, weighted, band = "ridges", True, surface.band
    return _result(numbers, curves, name, reason, model, weighted, surface, lags, band, level, profile, dx, dy)


def _interval(v):
    """((D_low, D_high), (G_low, G_high)) of bounds of D and ln G."""
    return tuple(v[:2].tolist()), tuple(np.exp(np.clip(v[2:], -600, 600)).tolist())


def _result(numbers, curves, name, reason, model, weighted, ridges, lags, band, levelled, profile, dx, dy):
    """Pack what the engine returns."""
    text = [t.decode() if isinstance(t, bytes) else str(t) for t in (name, reason)]
    cov = numbers[3:12].reshape(3, 3)
    count = lags[1] - lags[0] + 1
    with np.errstate(all="ignore"):
        anisotropy = float("nan") if profile else float(np.mean(curves[:count, 5] / curves[:count, 6]))
    tau, s, curve, curve_error, sample_error = curves[: int(numbers[20]), :5].T
    return Fit(
        fractal_dimension=numbers[0], roughness_m=float(np.exp(numbers[1])),
        fractal_dimension_error=(numbers[22] - numbers[21]) / 3.919928, ln_roughness_error=(numbers[24] - numbers[23]) / 3.919928,
        covariance=cov, interval=_interval(numbers[21:25]), sampling_interval=_interval(numbers[25:29]),
        noise_m=float(np.sqrt(numbers[2])), verdict=_VERDICTS[int(numbers[19])], kind=text[0].strip(), reason=text[1].strip(),
        model=model, weighted=weighted, ridges=ridges, ensemble="random phases" if ridges else "Gaussian field", lags=tuple(lags),
        band_m=tuple(band), rms=numbers[12], rms_expected=numbers[13], misfit=numbers[14], chi2=numbers[15],
        freedom=int(numbers[16]) if np.isfinite(numbers[16]) else 0,
        anisotropy=anisotropy,
        tilt=(numbers[17] / dx, numbers[18] / dy), levelled=bool(levelled), tau_m=tau, s_m2=s, curve_m2=curve,
        curve_error=curve_error, sample_error=sample_error)
