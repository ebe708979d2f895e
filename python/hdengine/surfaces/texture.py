# SPDX-License-Identifier: GPL-3.0-or-later
"""Areal numbers of ISO 25178-2 after form removal and filters."""
from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from .._check import ROUNDING, array, checked, flag, integer, kind, number, text
from .._engine import InputError
from .._types import Spacing
from . import form as forms
from . import gaussian, roughness
from .fit import micrometres
from .specimen import Specimen, clean

__all__ = ["Texture", "numbers", "smc", "smr", "texture"]
FALL = 0.2                              #: of the autocorrelation, to which Sal and Str look (ISO 25178-2)
CORE = 0.4                              #: share of the material ratio curve that the core's line is laid through (ISO 25178-2)
_ANGLES = 360                           #: directions over half a turn
_BINS = 180                             #: of the angular spectrum over half a turn
_SHARES = ("sdr", "smrk1", "smrk2")     #: numbers that are printed in per cent
_LOBE = 1.5                             #: modes of the map that the window blurs the mean into
_FINER = 2                              #: modes per wave of the map: the window's lobe is then smooth


def _seen_heights(name, value):
    """A rule: heights, some of which are no holes."""
    z = gaussian.HEIGHTS(name, value)
    if not np.isfinite(z).any():
        raise InputError(f"{name}: all points are holes")
    return z


@dataclass(frozen=True)
class Texture:
    """Numbers of a specimen, named as in ISO 25178-2, and how it was prepared. Of a profile only those that a line has."""

    numbers: dict                           #: name with unit: value; NaN where the map does not tell it
    specimen: Specimen = field(repr=False)  #: what the numbers are of: form off, filtered [m]
    form: forms.Form                        #: what was taken off
    s_filter_m: float | None                #: nesting index of the S-filter [m]
    l_filter_m: float | None                #: nesting index of the L-filter [m]
    outliers: int                           #: single wrong points, taken for holes
    holes: int                              #: points without height, outliers among them
    filled: bool                            #: holes were filled

    @checked(count=integer(2, 10**7))
    def material_ratio(self, count: int = 101) -> tuple:
        """The material ratio curve: heights c about the mean [m], falling, and Smr(c), 0 to 1."""
        z = _descending(self.specimen.heights)
        c = np.linspace(z[0], z[-1], count)
        return c, smr(self.specimen.heights, c)

    @property
    def mended(self) -> list:
        """What was said of the seams that were levelled."""
        return [note for note in self.specimen.notes if "seams across" in note]

    def __str__(self) -> str:
        words = [f"form      {self.form.kind}, {micrometres(self.form.range_m)} over the map"
                 + (f", radius {1e3 * self.form.radius_m:.6g} mm, axis {np.degrees(self.form.axis_rad):.2f} deg from x"
                    if self.form.kind == "cylinder" else "")]
        words += [f"filter    {name} {micrometres(index, digits=4)}, Gaussian (ISO 16610)" for name, index in
                  (("S", self.s_filter_m), ("L", self.l_filter_m)) if index]
        words += [f"mended    {note}" for note in self.mended]
        if self.holes:
            words.append(f"points    {self.outliers} outliers, {self.holes} holes{', filled' if self.filled else ''}")
        def group(names, factor=1.0):
            return ", ".join(f"{name.removesuffix('_m').capitalize()} {factor * self.numbers[name]:.4g}" for name in names)
        lengths, shares = [n for n in self.numbers if n.endswith("_m")], [n for n in _SHARES if n in self.numbers]
        rest = [n for n in self.numbers if n not in (*lengths, *shares, "std_rad")]
        words += [f"areal     {group(lengths, 1e6)} µm", f"          {group(rest)}; {group(shares, 100)} %"
                  + (f"; Std {np.degrees(self.numbers['std_rad']):.4g} deg" if "std_rad" in self.numbers else "")]
        return "\n".join(words)


@checked(specimen=kind(Specimen), form=text, s_filter=number(above=0, optional=True), l_filter=number(above=0, optional=True),
         outliers=flag, fill=flag, seams=flag)
def texture(specimen: Specimen, form: str = "plane", s_filter: float | None = None, l_filter: float | None = None,
            outliers: bool = False, fill: bool = False, seams: bool = False) -> Texture:
    """Prepare a specimen and take its numbers: seams, outliers, holes, S-filter, form, L-filter, in this order.

    Parameters
    ----------
    specimen : Specimen
        Map or profile.
    form : str
        As for `form.remove`: none, plane, poly2 to poly8, cylinder.
    s_filter, l_filter : float, optional
        Nesting indices [m]: waves shorter than the first and longer than the second are taken off by Gaussian filters (ISO 16610).
    outliers : bool
        Take single wrong points for holes, as the fit of D and G does.
    fill : bool
        Fill holes with what bends least. Holes that stay take no part.
    seams : bool
        Level the tiles between steps of stitching.

    Returns
    -------
    Texture

    Raises
    ------
    InputError
        As `form.remove` and `gaussian.lowpass`; an S-filter not shorter than the L-filter.
    """
    if s_filter is not None and l_filter is not None and not s_filter < l_filter:
        raise InputError(f"S-filter {s_filter:.6g} m, L-filter {l_filter:.6g} m: the first must be shorter than the second")
    cleaned, spikes = clean(specimen, outliers, fill, seams)
    holes = int(np.sum(~np.isfinite(cleaned.heights))) if not fill else int(np.sum(~np.isfinite(specimen.heights))) + spikes
    heights = cleaned.heights
    if s_filter is not None:
        heights = gaussian.lowpass(heights, specimen.spacing, s_filter)
    found = forms.remove(Specimen(heights, specimen.spacing, specimen.name, cleaned.notes), form)
    heights = found.specimen.heights
    if l_filter is not None:
        heights = gaussian.highpass(heights, specimen.spacing, l_filter)
        heights = heights - np.nanmean(heights)
    kept = Specimen(heights, specimen.spacing, specimen.name, found.specimen.notes)
    return Texture(numbers(heights, specimen.spacing), kept, found, s_filter, l_filter, spikes, holes, bool(fill and holes))


@checked(heights=_seen_heights, spacing=gaussian.STEPS)
def numbers(heights: ArrayLike, spacing: Spacing) -> dict:
    """Numbers of ISO 25178-2 of heights as they are: only their mean is taken off.

    Parameters
    ----------
    heights : array_like (rows, points) or (points,)
        Heights [m]; NaN are holes.
    spacing : (float, float)
        (dy, dx) [m].

    Returns
    -------
    dict
        sa_m, sq_m, sp_m, sv_m, sz_m, ssk, sku: heights; sdq, sdr: root mean square gradient over one spacing, developed area less
        one over cells of four points; sal_m, str: shortest distance at which the autocorrelation falls to 0.2, and that over the
        longest (NaN where it does not fall so far within half of the map); std_rad: direction of most power, from x towards y (a
        lay lies across it); sk_m, spk_m, svk_m, smrk1, smrk2: core, reduced peaks and valleys, material ratios of the core's
        ends; sxp_m: height of 2.5 % less that of 50 %. A profile has no sdr, str and std_rad.
    """
    z = np.asarray(heights, dtype=float)
    z = z - np.nanmean(z)
    dx, dy = roughness._spacing(spacing)
    good = z[np.isfinite(z)]
    sq = float(np.sqrt(np.mean(good**2)))
    out = {"sa_m": float(np.mean(abs(good))), "sq_m": sq, "sp_m": float(good.max()), "sv_m": float(-good.min()),
           "sz_m": float(np.ptp(good))}
    with np.errstate(divide="ignore", invalid="ignore"):
        out |= {"ssk": float(np.mean(good**3) / np.float64(sq) ** 3), "sku": float(np.mean(good**4) / np.float64(sq) ** 4)}
    out |= _gradients(z, dx, dy) | _correlation(z, dx, dy)
    if z.ndim == 2:
        out["std_rad"] = _direction(np.where(np.isfinite(z), z, 0.0), dx, dy)
    return out | _core(_descending(z)) | {"sxp_m": float(np.subtract(*smc(z, [0.025, 0.5])))}


@checked(heights=_seen_heights, c=array())
def smr(heights: ArrayLike, c: ArrayLike) -> np.ndarray:
    """Areal material ratio Smr(c): share of the heights at or above c [m] about their mean."""
    z = _descending(heights)[::-1]
    return 1 - np.searchsorted(z, np.asarray(c, dtype=float), side="left") / len(z)


@checked(heights=_seen_heights, ratio=array(least=0, most=1))
def smc(heights: ArrayLike, ratio: ArrayLike) -> np.ndarray:
    """Inverse areal material ratio Smc(mr): height about the mean [m] that a share mr, 0 to 1, reaches."""
    z = _descending(heights)
    return np.interp(np.asarray(ratio, float), (np.arange(len(z)) + 0.5) / len(z), z)


def _descending(heights):
    """Heights about their mean, highest first, without holes."""
    z = np.asarray(heights, dtype=float)
    z = z[np.isfinite(z)]
    return np.sort(z - z.mean())[::-1]


def _gradients(z, dx, dy):
    """Sdq over single steps; of a map Sdr over cells of four points, each the mean of the two ways to cut it into two triangles."""
    along = np.diff(z, axis=-1) / dx
    square = np.nanmean(along**2)
    if z.ndim == 1:
        return {"sdq": float(np.sqrt(square))}
    across = np.diff(z, axis=0) / dy
    area = sum(np.sqrt(1 + a**2 + b**2) - 1 for a in (along[:-1], along[1:]) for b in (across[:, :-1], across[:, 1:])) / 4
    return {"sdq": float(np.sqrt(square + np.nanmean(across**2))), "sdr": float(np.nanmean(area))}


def _autocorrelation(z):
    """Normalised autocorrelation at lags 0 to half of the points, along y also negative; pairs of two good points count."""
    flat, good = np.atleast_2d(np.where(np.isfinite(z), z, 0.0)), np.atleast_2d(np.isfinite(z)).astype(float)
    size = [2 * n if n > 1 else 1 for n in flat.shape]
    power = [np.fft.irfft2(abs(np.fft.rfft2(a, size)) ** 2, size) for a in (flat, good)]
    with np.errstate(invalid="ignore", divide="ignore"):
        c = power[0] / np.where(power[1] > 0.5, power[1], np.nan)
        c = np.roll(c, size[0] // 2, axis=0) / c[0, 0]
    ny, nx = (n // 2 for n in flat.shape)
    middle = size[0] // 2
    return c[middle - ny:middle + ny + 1, :nx + 1]


def _correlation(z, dx, dy):
    """Sal and Str: along each direction the first place where the autocorrelation falls to FALL, between points bilinear."""
    c = _autocorrelation(z)
    ny, nx = c.shape[0] // 2, c.shape[1] - 1
    angles = np.array([0.0]) if z.ndim == 1 else (np.arange(_ANGLES) / _ANGLES - 0.5) * np.pi
    step = dx if z.ndim == 1 else min(dx, dy)
    reach = np.hypot(nx * dx, ny * dy if z.ndim == 2 else 0)
    at = step * np.arange(int(reach / step) + 2)
    fall = np.full(len(angles), np.nan)
    for k, angle in enumerate(angles):
        u, v = at * np.cos(angle) / dx, at * np.sin(angle) / dy if z.ndim == 2 else np.zeros_like(at)
        inside = (u <= nx + ROUNDING) & (abs(v) <= ny + ROUNDING)
        values = _bilinear(c, v[inside] + ny, u[inside])
        below = np.nonzero(values <= FALL)[0]
        if len(below):
            i = below[0]
            fall[k] = at[i] - step * (FALL - values[i]) / (values[i - 1] - values[i])
    out = {"sal_m": float(np.nanmin(fall)) if np.isfinite(fall).any() else float("nan")}
    return out if z.ndim == 1 else out | {"str": out["sal_m"] / float(np.max(fall))}


def _bilinear(c, row, column):
    """Values between points."""
    i = np.clip(row.astype(int), 0, max(c.shape[0] - 2, 0))
    j = np.clip(column.astype(int), 0, c.shape[1] - 2)
    p, q = row - i, column - j
    down = np.minimum(i + 1, c.shape[0] - 1)
    return (1 - p) * ((1 - q) * c[i, j] + q * c[i, j + 1]) + p * ((1 - q) * c[down, j] + q * c[down, j + 1])


def _direction(z, dx, dy):
    """Std: direction of most power under a Hann window, -pi/2 to pi/2 from x towards y [rad].

    Each mode spreads its power over the angle that it takes in the plane of frequencies; beyond Nyquist's frequency of the coarser
    direction, where not all directions have modes, none counts.
    """
    window = np.hanning(z.shape[0] + 2)[1:-1, None] * np.hanning(z.shape[1] + 2)[None, 1:-1]
    ny, nx = (_FINER * n for n in z.shape)
    power = abs(np.fft.rfft2((z - np.sum(z * window) / np.sum(window)) * window, (ny, nx))) ** 2
    fx, fy = np.meshgrid(np.arange(nx // 2 + 1) / (nx * dx), np.fft.fftfreq(ny, dy))
    f = np.hypot(fx, fy)
    keep = (f > _LOBE * _FINER * max(1 / (nx * dx), 1 / (ny * dy))) & (f <= 0.5 / max(dx, dy)) & ((fx > 0) | (fy > 0))
    if not keep.any() or not power[keep].any():
        return float("nan")
    angle = np.arctan2(fy[keep], fx[keep])
    half = 0.5 * np.hypot(fx[keep] / (ny * dy), fy[keep] / (nx * dx)) / f[keep] ** 2        # of the angle of a mode
    density = np.zeros(_BINS)
    edges = np.arange(_BINS + 1) * np.pi / _BINS - np.pi / 2
    weight = power[keep] / (2 * half)
    for turn in (-np.pi, 0.0, np.pi):
        density += np.diff(_ramps(angle + turn - half, weight, edges) - _ramps(angle + turn + half, weight, edges))
    k = int(np.argmax(density))
    left, middle, right = density[(k - 1) % _BINS], density[k], density[(k + 1) % _BINS]
    bend = left - 2 * middle + right
    top = edges[k] + np.pi / _BINS * (0.5 + (0.5 * (left - right) / bend if bend < 0 else 0))
    return float((top + np.pi / 2) % np.pi - np.pi / 2)


def _ramps(start, weight, at):
    """Sum of weight times what lies between start and each place, where that is positive."""
    order = np.argsort(start)
    start, weight = start[order], weight[order]
    total, moment = (np.concatenate([[0.0], np.cumsum(v)]) for v in (weight, weight * start))
    k = np.searchsorted(start, at)
    return at * total[k] - moment[k]


def _core(z):
    """Sk, Spk, Svk, Smrk1, Smrk2 from heights, highest first: the line through the 40 % of the material ratio curve with the
    gentlest secant, extended to 0 and 100 %; triangles of the areas that stand out (ISO 25178-2, as ISO 13565-2 of profiles)."""
    n = len(z)
    ratio = (np.arange(n) + 0.5) / n
    wide = max(1, round(CORE * n))
    if n <= wide + 1:
        return dict.fromkeys(("sk_m", "spk_m", "svk_m", "smrk1", "smrk2"), float("nan"))
    first = int(np.argmin(z[:n - wide] - z[wide:]))
    slope, offset = np.polyfit(ratio[first:first + wide + 1] - 0.5, z[first:first + wide + 1], 1)
    top, bottom = offset - 0.5 * slope, offset + 0.5 * slope
    above, below = z > top, z < bottom
    high, low = float(above.mean()), float(1 - below.mean())
    peaks, valleys = np.sum(z[above] - top) / n, np.sum(bottom - z[below]) / n
    return {"sk_m": float(top - bottom), "spk_m": float(2 * peaks / high) if high > 0 else 0.0,
            "svk_m": float(2 * valleys / (1 - low)) if low < 1 else 0.0, "smrk1": high, "smrk2": low}
