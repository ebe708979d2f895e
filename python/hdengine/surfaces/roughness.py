# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure height maps: structure function, and the fit of D and G."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from .. import _engine
from .._check import array, checked, flag, integers, kind, number, word
from .._engine import InputError
from .._types import Spacing
from .fit import Fit, Ridges, rows_alone

__all__ = ["expected_structure", "fit", "level", "structure_function"]
_MOST_LAGS, _MOST_WAVES = 20, 4000   # of a window that nobody states; for the covariance of random phases (hd_fit_report)
_MODELS = {"ridges": 3, "paper": 4, "spectrum": 5}
_BANDS = {"isotropic": 1, "profile": 2}
_VERDICTS = {1: "fractal", 2: "not fractal", 3: "noise-dominated"}


def _map(heights):
    """Heights as the engine takes them: (points along a row, rows), Fortran order, no copy of a C-ordered array."""
    z = array(holes=True, empty=True)("heights", heights)
    if z.ndim == 1:
        z = z[None, :]
    if z.ndim != 2 or z.size == 0:
        raise InputError(f"heights have shape {np.shape(heights)}: give a map (rows, points) or a single profile (points,)")
    if np.ndim(heights) == 2 and 1 in z.shape:
        raise InputError(f"a map of {z.shape[0]} x {z.shape[1]} points is a single line: give a profile as a one-dimensional array")
    return np.asfortranarray(z.T)


def _spacing(spacing):
    """(dx, dy) [m] of one number or of (dy, dx)."""
    d = np.atleast_1d(array(finite=False)("spacing", spacing))
    if d.shape not in ((1,), (2,)) or not np.all(np.isfinite(d)) or not np.all(d > 0):
        raise InputError(f"spacing = {spacing}: give the distance of points in m, positive, one number or (dy, dx)")
    return float(d[-1]), float(d[0])


def _direction(name, value):
    """A rule: a word, or a step in points."""
    return value if isinstance(value, str) else tuple(integers((2,), -2**30, 2**30)(name, value))


@checked(lags=integers((None,), 1, optional=True), direction=_direction, second=flag)
def structure_function(heights: ArrayLike, spacing: Spacing, lags: Sequence[int] | None = None, direction: str | tuple = "rows",
                       second: bool = False) -> tuple:
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
        lags = range(1, max(2, min(reach, default=1) // (2 if second else 1) + 1))
    chosen = np.asarray(lags, dtype=np.int32)
    if chosen.ndim != 1 or chosen.size == 0 or chosen.min() < 1:
        raise InputError("lags must be a list of whole numbers >= 1")
    s, pairs = _engine.call("structure_direction", z, p, q, int(bool(second)), chosen)
    return chosen * np.hypot(p * dx, q * dy), s, pairs


@checked(tau=array(above=0), fractal_dimension=number(above=2, below=3), roughness=number(above=0), band=array((2,), least=0),
         model=word(*_BANDS))
def expected_structure(tau: ArrayLike, fractal_dimension: float, roughness: float, band: Sequence[float],
                       model: str = "isotropic") -> np.ndarray:
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
    if not band[0] < band[1]:
        raise InputError(f"band = {tuple(band)}: shortest and longest wavelength in m, 0 <= shortest < longest")
    top = 1 / band[0] if band[0] > 0 else inf
    tau = np.asarray(tau)
    s = _engine.call("structure_expected", _BANDS[model], fractal_dimension, 1 / band[1], top, tau.ravel())
    return roughness ** (2 * (fractal_dimension - 2)) * s.reshape(tau.shape)


def level(heights: ArrayLike) -> np.ndarray:
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


def _noise(name, value):
    """A rule: rms of the noise, or 'fit'."""
    return value if isinstance(value, str) else number(least=0)(name, value)


@checked(lags=integers((2,), 0, optional=True), level=flag, band=array((2,), optional=True), noise=_noise,
         outliers=flag)
def fit(heights: ArrayLike, spacing: Spacing, lags: tuple[int, int] | None = None, model: str | None = None,
        surface: Ridges | None = None, level: bool = True, band: tuple[float, float] | None = None, noise: float | str = 0.0,
        second: ArrayLike | None = None, outliers: bool = True) -> Fit:
    """Fit D and G to the structure function over a window of short lags.

    A sum of Eq. 1 (told by `surface`): two-step generalised least squares on the exact sum, errors from random phases. Any other
    map or profile: the spectrum, told nothing: power law, Gaussian probe, detail finer than the spacing, white noise, over the
    widest window of frequencies that follows it; holes are filled, steps of stitching and offsets of
    single rows taken off. Intervals are those of the likelihood.

    Parameters
    ----------
    heights : array_like (rows, points) or (points,)
        Heights [m]; NaN are holes.
    spacing : float or (float, float)
        Spacing (dy, dx) [m].
    lags : (int, int), optional
        First and last lag [points]. Default: 1 to 20, or to half a shorter row.
    model : {"spectrum", "ridges", "paper"}, optional
        Default: "ridges" for a sum of Eq. 1 that is told, else "spectrum". Where the spectrum has lines (few waves), S over
        `lags` is fitted to a band with sharp ends, and the result names "isotropic" or, of a line, "profile".
        "paper" is the straight line with the literature's (Majumdar-Bhushan) constant: G is wrong by 2.2 (profile) or 1.4.
    surface : Ridges, optional
        What is known of a surface made by Eq. 1.
    level : bool
        Take the least-squares plane off; the model accounts for what this takes from S.
    band : (float, float), optional
        Shortest and longest wavelength of the surface [m]; the first may be 0. Default: that of `surface`, else one spacing and
        the longer side. "spectrum": the window to fit; default: looked for.
    noise : float or "fit"
        Rms of white instrument noise [m]: known, or one more unknown. "spectrum" fits it unless it is known.
    second : array_like, optional
        Another specimen with the same spacing: D and G are those of S_eq = S_1 + S_2, the equivalent rough surface of the joint.
    outliers : bool
        Take single wrong points and small clumps for holes, as `specimen.clean` does; their number is `spikes` of the result.
        Steps of stitching are levelled either way (`seams` of the result).

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        Map without heights, too small for the window, spacing not positive, unknown model.
    """
    surface = kind(Ridges, optional=True)("surface", surface)
    z = _map(heights)
    other = np.zeros((1, 1), order="F") if second is None else _map(second)
    dx, dy = _spacing(spacing)
    if lags is None:
        lags = (1, min(_MOST_LAGS, (z.shape[0] - 1) // 2))
    profile = z.shape[1] == 1
    if model is None:
        model = "ridges" if surface is not None else "spectrum"
    if not isinstance(model, str) or model not in _MODELS:
        raise InputError(f"model = {model!r}: one of {', '.join(_MODELS)}")
    if model == "ridges" and surface is None:
        raise InputError('model "ridges" needs surface=Ridges(...), what is known of the sum')
    told = band is not None
    if band is None:
        band = surface.band if surface is not None else (min(dx, dy), max((z.shape[0] - 1) * dx, (z.shape[1] - 1) * dy))
    if not 0 <= band[0] < band[1]:
        raise InputError(f"band = {band}: shortest and longest wavelength in m, 0 <= shortest < longest")
    free = isinstance(noise, str)
    rms = 0.0 if isinstance(noise, str) else noise
    if (free and noise != "fit") or not 0 <= rms < inf:
        raise InputError(f'noise = {noise!r}: rms in m, >= 0, or "fit"')
    waves = surface or Ridges(1.0, 0.5)
    if model == "ridges" and waves.ridges * (waves.n_max + 1) > _MOST_WAVES:
        raise InputError(f"{waves.ridges * (waves.n_max + 1)} waves: the covariance takes up to {_MOST_WAVES}; leave out surface=")
    options = _engine.named(
        "fit_options", first_lag=lags[0], last_lag=lags[1], level=level, model=_MODELS[model], fit_noise=free, ridges=waves.ridges,
        n_max=waves.n_max, told=told, mask=outliers, f_lo=1 / band[1], f_hi=1 / band[0] if band[0] > 0 else inf, gamma=waves.gamma,
        length=waves.length, noise=rms)
    columns = 2 * max(1, int(lags[1]) - int(lags[0]) + 1) if lags[1] <= max(z.shape) else 2  # the engine refuses such lags
    found = [_engine.names(values) for values in ("fit", "fit_curves", "fit_rings")]
    sizes = [len(found[0]), columns, _RINGS]
    *lists, text = _engine.call_with_text("surface_fit", z, other, dx, dy, options, *sizes, *map(len, found[1:]))
    v, curves, rings = (dict(zip(names, values.T)) for names, values in zip(found, lists))
    if v["of_spectrum"] > 0:
        band = (1 / v["f_hi"], 1 / v["f_lo"])
    elif model == "spectrum":
        model = "profile" if profile else "isotropic"
    result = _result(v, curves, text, model, surface, lags, band, level, dx, dy)
    result = replace(result, rows_alone=rows_alone(lags, z.T, *[] if second is None else [other.T]))
    return result if np.isnan(rings["frequency"][0]) else replace(result, **_spectrum(v, rings))


_RINGS = 300  # more than any map has


def _spectrum(v, rings):
    """What the fit of a spectrum adds."""
    n = int(np.sum(np.isfinite(rings["frequency"])))
    out = {"holes": int(v["holes"]), "axis_excess": (float(v["axis_x"]), float(v["axis_y"])),
           "frequency": rings["frequency"][:n], "density": rings["power"][:n], "density_model": rings["model"][:n]}
    if v["of_spectrum"] > 0:
        out |= {"probe_m": float(v["probe"]), "finer_detail": float(v["fold"])}
    ranges = ([float(v[f"range_{key}_{i}"]) for key in ("d", "low", "high")] for i in (1, 2))
    out["ranges"] = tuple(tuple(r) for r in ranges if r[0] > 0)
    return out


def _interval(v, kind=""):
    """((D_low, D_high), (G_low, G_high)) of the bounds of D and ln G."""
    d, ln_g = ([float(v[f"{name}_{side}{kind}"]) for side in ("low", "high")] for name in ("d", "ln_g"))
    return tuple(d), tuple(np.exp(np.clip(ln_g, -600, 600)).tolist())


def _result(v, curves, text, model, ridges, lags, band, levelled, dx, dy):
    """Pack what the engine returns."""
    name, _, reason = text.partition("\n")
    cov = np.reshape([v[f"cov_{i}"] for i in range(1, 10)], (3, 3))
    tau, s, curve, curve_error, sample_error = (curves[key][:int(v["size"])] for key in
                                                ("tau", "s", "model", "model_error", "sample_error"))
    return Fit(
        fractal_dimension=v["d"], roughness_m=float(np.exp(v["ln_g"])),
        fractal_dimension_error=v["d_error"], ln_roughness_error=v["ln_g_error"],
        covariance=cov, interval=_interval(v), sampling_interval=_interval(v, "_sampling"),
        noise_m=float(np.sqrt(v["noise_variance"])), verdict=_VERDICTS[int(v["verdict"])], kind=name.strip(), reason=reason.strip(),
        model=model, weighted=model == "ridges", ridges=ridges, lags=tuple(lags),
        ensemble="random phases" if model == "ridges" else "Gaussian field",
        band_m=tuple(band), rms=v["rms"], rms_expected=v["rms_expected"], misfit=v["misfit"], chi2=v["chi2"],
        freedom=int(v["freedom"]) if np.isfinite(v["freedom"]) else 0,
        anisotropy=float(v["anisotropy"]),
        tilt=(v["tilt_x"] / dx, v["tilt_y"] / dy), levelled=bool(levelled), tau_m=tau, s_m2=s, curve_m2=curve,
        curve_error=curve_error, sample_error=sample_error, spikes=int(v["spikes"]),
        wrong_from_m=(float(v["wrong_from"]), float(v["clumps_from"])),
        seams=(int(v["seams_x"]), int(v["seams_y"])), seam_step_m=float(v["seam_step"]),
        jitter_m=(float(v["jitter_x"]), float(v["jitter_y"])))
