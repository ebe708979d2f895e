# SPDX-License-Identifier: GPL-3.0-or-later
"""The law of a joint from the maps of its two surfaces: stiffness, closure and true contact over pressure, with a band."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .. import _engine
from .._check import ROUNDING, array, checked, flag, function, integer, kind, number, optional, text
from .._check import path as a_path
from .._engine import InputError
from .._types import PathLike
from ..elastic import ElasticJoint, contact_from_spectrum, stiffness_from_spectrum
from ..files import csv_text, write_folder
from ..surfaces.specimen import Specimen
from . import half_space, patches
from .bodies import Bodies
from .choice import LAY, choose, doubts, half_width_of, scatter_of
from .spectrum import PER_OCTAVE, Spectrum, bands, numbers, of_map, of_sum

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Prediction", "predict"]
PRESSURES = tuple(float(f"{p:.4g}") for p in np.geomspace(1e6, 500e6, 15))
FILES = ("joint.json", "joint.csv", "spectrum.csv", "joint.png")
STUDENT = 3.18      # 95 % of Student's t with three degrees of freedom: four quarters
ROLLED = 3          # lengths of the longest wave in a map from which on its spectrum has rolled off
LEAST_POWER = 0.05  # of the pressure that P/k_N goes with at first touch: its integral from 0 exists
SOFTEST = 1.01      # hardness over the largest pressure
UNIT = 30.0         # slope beyond which heights are taken for those of another unit
MODULUS_ERROR, HARDNESS_ERROR = 0.02, 0.15   # standard deviations of ln E*, ln H
PATCHES = ("periodic", "free")
PUNCH = 1.15        # stiffness of a smooth square patch over E* times its side
OWN = 0.9           # share of a free patch's compliance that its own bulk may take


@dataclass(frozen=True)
class Prediction:
    """A joint law over pressure.

    Parameters
    ----------
    table : dict of ndarray
        Columns of joint.csv.
    model : str
        'spectrum' or 'boundary_elements'.
    reason : str
        Why that model.
    spectrum : Spectrum
        Of the equivalent surface.
    bodies : Bodies
    waves : float
        Its independent waves on the area that the band stands for.
    map_area : float
        Area of the smaller map [m^2].
    patch : str
        'periodic' or 'free', of boundary elements.
    notes : tuple of str
        What decides the law and what speaks against it.
    outside : tuple of str
        Where the theory is outside its validity, and why; none where it holds or boundary elements were taken.
    facts : tuple of dict
        Of each map.
    parts : dict
        What widens the band: name to half widths of ln k_N (95 %) downwards and upwards, over the pressures.
    """

    table: dict = field(repr=False)
    model: str
    reason: str
    spectrum: Spectrum = field(repr=False)
    bodies: Bodies
    waves: float
    map_area: float
    patch: str = "periodic"
    notes: tuple = ()
    outside: tuple = ()
    facts: tuple = field(default=(), repr=False)
    parts: dict = field(default_factory=dict, repr=False)

    def joint(self, friction: float = 0.15) -> ElasticJoint:
        """The law as an `ElasticJoint`."""
        return ElasticJoint(self.table["pressure_pa"], self.table["k_n_pa_per_m"], self.table["k_t_pa_per_m"], friction, self.model)

    def __str__(self):
        t = self.table
        lines = [f"joint by {self.model}: {self.reason}",
                 f"  h_rms {1e6 * self.spectrum.h_rms:.4g} um, slope {self.spectrum.slope_rms:.3g}, wavelengths "
                 f"{2e6 * np.pi / self.spectrum.q[-1]:.3g} to {2e6 * np.pi / self.spectrum.q[0]:.4g} um",
                 "  pressure/MPa   k_N/(Pa/m)       95 % band             k_T/(Pa/m)  closure/um  contact/%"]
        for i, p in enumerate(t["pressure_pa"]):
            lines.append(f"  {p / 1e6:12.4g} {t['k_n_pa_per_m'][i]:12.4g}   {t['k_n_pa_per_m_low'][i]:.3g} to "
                         f"{t['k_n_pa_per_m_high'][i]:.3g}  {t['k_t_pa_per_m'][i]:12.4g} {1e6 * t['closure_m'][i]:10.4g} "
                         f"{100 * t['contact_area_fraction'][i]:10.3g}")
        middle = len(t["pressure_pa"]) // 2
        widths = sorted(((max(low[middle], high[middle]), name) for name, (low, high) in self.parts.items()), reverse=True)
        wide = ", ".join(f"{name} {100 * width:.0f} %" for width, name in widths)
        lines.append(f"  half width of the band at {t['pressure_pa'][middle] / 1e6:.3g} MPa: {wide}")
        lines += [f"  outside its validity: {why}" for why in self.outside]
        return "\n".join(lines + [f"  {note}" for note in self.notes])

    def plot(self) -> Figure:
        """k_N and k_T over pressure with the band, and the spectrum (a matplotlib figure)."""
        from ..figures.prediction import plot_prediction

        return plot_prediction(self)

    @checked(folder=a_path, force=flag)
    def write(self, folder: PathLike, force: bool = False) -> list[Path]:
        """Write joint.csv, spectrum.csv, joint.png and, last, joint.json; returns their paths.

        Parameters
        ----------
        folder : path-like
        force : bool
            Replace files of these names.

        Raises
        ------
        FileError
            The folder holds such files, or what another command wrote, or cannot be written.
        """
        spectrum = {"q_per_m": self.spectrum.q, "height_variance_m2": self.spectrum.height_variance, "c_m4": self.spectrum.c,
                    "waves_per_m2": self.spectrum.modes / self.map_area}
        record = {"model": self.model, "patch": self.patch, "reason": self.reason, "notes": self.notes,
                  "outside_validity": self.outside, "surfaces": self.facts,
                  "e_star_pa": self.bodies.e_star, "k_t_over_k_n": self.bodies.ratio, "hardness_pa": self.bodies.hardness,
                  "h_rms_m": self.spectrum.h_rms, "slope_rms": self.spectrum.slope_rms, "independent_waves": self.waves,
                  "band_half_widths_ln_k_n": {n: {"low": low, "high": high} for n, (low, high) in self.parts.items()},
                  "tamaas": half_space.tamaas().__version__ if self.model == "boundary_elements" else None}
        return write_folder(folder, FILES[0], record, {FILES[1]: csv_text(self.table), FILES[2]: csv_text(spectrum),
                                                       FILES[3]: self.plot()}, force)


@checked(pressure=array([(), (None,)]), bodies=kind(Bodies, optional=True), model=optional(text), patch=text,
         longest=number(above=0, finite=False), draws=integer(0, 10**6), points=integer(2, 2**15), seed=integer(0, 2**63 - 1),
         seconds=number(finite=False), loaded=number(optional=True, finite=False), say=optional(function))
def predict(*maps: Specimen | tuple, pressure: ArrayLike = PRESSURES, model: str | None = None, bodies: Bodies | None = None,
            longest: float = np.inf, draws: int = 200, points: int = 256, seed: int = 1, seconds: float = np.inf,
            loaded: float | None = None, patch: str = "periodic", say: Callable[[str, bool], None] | None = None) -> Prediction:
    """The joint of one or two surfaces.

    Parameters
    ----------
    *maps : (heights, spacing) or objects with these attributes (`specimen.read`)
        One or two surfaces; one: against a smooth one. Two: taken as independent, their spectra add. The spacing [m] is one number
        or (along the columns, along the rows).
    pressure : sequence of float
        Nominal pressures, rising [Pa].
    model : str, optional
        'spectrum', 'boundary_elements'; default: `choose`.
    bodies : Bodies, optional
        Elastic constants and hardness.
    longest : float
        Longest wavelength that counts as roughness [m]; longer waves belong into the geometry.
    draws : int
        For the band.
    points : int
        Boundary elements: points a side of the map after averaging (the half space has twice as many).
    seed : int
        Of the draws.
    seconds : float
        Most that boundary elements may take: fewer points are taken first; then the theory, or an error where they were
        asked for [s].
    loaded : float, optional
        Area of the contact that the band stands for [m^2]; default: that of the smaller map. A larger contact holds more waves.
    patch : str
        'periodic' or 'free', of boundary elements: the map goes on evenly, or nothing touches outside it. 'free' asks for them.
    say : callable, optional
        Takes what boundary elements will take and how far they are: a sentence, and whether it replaces the one before.

    Returns
    -------
    Prediction

    Raises
    ------
    InputError
        No map, another thing than a map, an area of 0, pressures that do not rise or reach the hardness, tamaas missing where it is
        asked for.
    NotConvergedError, StoppedError
        Boundary elements that were asked for did not converge, or would take longer than `seconds`.
    """
    bodies = bodies or Bodies()
    pairs = [_pair(m, i) for i, m in enumerate(maps, 1)]
    names = [f"map {i} ({m.name})" if isinstance(m, Specimen) else f"map {i}" for i, m in enumerate(maps, 1)]
    if not 1 <= len(pairs) <= 2:
        raise InputError(f"a joint has one or two maps, got {len(pairs)}")
    if model not in (None, "spectrum", "boundary_elements"):
        raise InputError(f"model {model!r}; valid: spectrum, boundary_elements")
    if patch not in PATCHES:
        raise InputError(f"patch {patch!r}; valid: {', '.join(PATCHES)}")
    free = patch == "free"
    if free and model == "spectrum":
        raise InputError("patch 'free' with model 'spectrum': the theory knows no edge; valid: model 'boundary_elements'")
    p = np.atleast_1d(pressure)
    if not (np.all(np.diff(p) > 0) and p[0] > 0 and p[-1] < bodies.hardness):
        raise InputError(f"pressures {', '.join(f'{x:g}' for x in p)} Pa; valid: rising, above 0, below the hardness, "
                         f"{bodies.hardness:g} Pa")
    if loaded is not None and not 0 < loaded < np.inf:
        raise InputError(f"loaded area of {loaded:g} m^2; valid: above 0")
    found = _facts_of(pairs, names, longest)
    raw = [s for s, _ in found]
    areas = [np.size(z) * spacing[0] * spacing[1] for z, spacing in pairs]
    one_map = min(areas)
    clean = [_denoise(s, f["noise_variance_m2"], m[0].size).of_area(one_map / a) for (s, f), m, a in zip(found, pairs, areas)]
    facts = [f for _, f in found]
    whole = of_sum(sum(clean[1:], clean[0]), facts)
    spectrum, noisy = (sum(s[1:], s[0]).between(longest) for s in (clean, raw))
    k_n, area, gap = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, p, bodies.e_star, bodies.hardness)
    waves = spectrum.waves
    alone = scatter_of(area, waves)
    waves *= (loaded or one_map) / one_map   # those of a contact of so many patches
    against = whole, p, area, waves, bodies.e_star * spectrum.slope_rms / bodies.hardness
    wanted, reason = choose(*against)
    if free and not model:
        model = wanted = "boundary_elements"
        reason = "a free patch was asked for"
    elif model:
        wanted, reason = model, "asked for" if model == wanted else f"asked for ({wanted} advised: {reason})"
    rises = not whole["rolls_off"]   # a contact larger than the map has longer waves in any case
    longer = (rises or bool(loaded and loaded > one_map)) and longest > (1 + ROUNDING) * min(_length(m) for m in pairs)
    notes = _notes(facts, spectrum, rises, longer)
    if loaded is not None:
        notes += (f"band of a contact of {1e6 * loaded:.3g} mm^2, {loaded / one_map:.3g} times the map",)
    spread = (spectrum, noisy if any(f["noise_variance_m2"] for f in facts) else None,
              ((1.5, 4.0) if rises else (0.25, 0.25)) if longer else None, p, bodies, k_n, area, draws, seed)
    parts = _spread(*spread, whole=wanted == "boundary_elements")
    k_t = bodies.ratio * k_n
    if wanted == "boundary_elements":
        effort = patches.Effort(seconds, say)
        effort.tell(f"boundary elements: {reason}")
        try:
            k_n, k_t, area, scatter, coarse, points = patches.solve(pairs, p, bodies, points, longest, effort, free)
            rest = f"averaged to {points} points a side, shorter waves by theory" if coarse.any() else f"of {points} points a side"
            notes += (f"boundary elements on maps {rest}, {'as free patches' if free else 'continued evenly'}, "
                      f"{effort.spent:.0f} s; band from the four quarters, E*, hardness and the spectrum's ends",)
            if len(pairs) == 2 and patches.unlike(pairs[0][1], pairs[1][1]):
                notes += ("the finer map was resampled to the spacing of the other",)
            if free:
                notes += _free_notes(p, k_n, PUNCH * bodies.e_star / np.sqrt(one_map))
            if loaded is not None:
                notes += ("boundary elements know one map: its scatter stays in the band, however large the contact",)
            parts["four quarters"] = (STUDENT * scatter,) * 4
            parts["one map"] = (1.96 * alone, 1.96 * alone, *(np.zeros(len(p)),) * 2)
            if coarse.any():
                parts["averaging"] = (1.96 * coarse,) * 4
        except (InputError, _engine.NotConvergedError, _engine.StoppedError) as why:
            if model:
                raise
            wanted, reason = "spectrum", f"{reason}; but {why}"
            effort.tell(f"{why}: the theory is taken")
            parts = _spread(*spread)
    outside: tuple[str, ...] = ()
    if wanted == "spectrum":
        law = half_width_of(area, waves, whole["crests"])
        parts["law"] = (law,) * 4
        outside = tuple(doubts(*against))
        notes += (f"k_N by theory lies within {_percent(law.min())} to {_percent(law.max())} of boundary elements (95 of 100 "
                  "maps)",)
    bias = parts.get("longer waves", (0.0,))[0]   # only ever down: added, not a root of squares
    low, high, area_low, area_high = (np.sqrt(sum(part[i]**2 for name, part in parts.items() if name != "longer waves"))
                                      for i in range(4))
    low = low + bias
    low, high = np.exp(-low), np.exp(high)

    def theory(x):
        return contact_from_spectrum(spectrum.q, spectrum.height_variance, x, bodies.e_star, bodies.hardness)

    table, wide = {"pressure_pa": p}, (1 / high, 1 / low)
    columns = [("k_n_pa_per_m", k_n, (low, high)), ("k_t_pa_per_m", k_t, (low, high)),
               ("closure_m", _closure(p, k_n, lambda x: theory(x)[0]), wide),
               ("contact_area_fraction", area, (np.exp(-area_low), np.exp(area_high)))]
    for name, value, (a, b) in columns + ([("mean_gap_m", gap, wide)] if wanted == "spectrum" else []):
        table |= {name: value, f"{name}_low": value * a, f"{name}_high": np.minimum(value * b, 1) if "area" in name else value * b}
    if wanted == "spectrum":
        table["pressure_spread_pa"] = theory(p)[2]
    parts = {name: part[:2] for name, part in parts.items()}
    return Prediction(table, wanted, reason, spectrum, bodies, waves, one_map, patch, notes, outside, tuple(facts), parts)


def _pair(m, number):
    """Heights and (dy, dx) of a map, however it was given."""
    if hasattr(m, "heights") and hasattr(m, "spacing"):
        return m.heights, m.spacing
    try:
        heights, spacing = m
        dy, dx = np.broadcast_to(np.asarray(spacing, float), 2).tolist()
    except (TypeError, ValueError):
        raise InputError(f"map {number} is {type(m).__name__} {str(m)[:40]!r}; valid: (heights, spacing) with the spacing in m, or "
                         "what specimen.read gives") from None
    if not (0 < dy < np.inf and 0 < dx < np.inf):
        raise InputError(f"map {number} has a spacing of {dy:g}, {dx:g} m; valid: above 0")
    return heights, (dy, dx)


def _percent(log):
    """A half width of a logarithm in words."""
    return f"{100 * np.expm1(log):.0f} %" if log < np.log(2) else f"a factor of {np.exp(log):.2g}"


def _facts_of(pairs, names, longest):
    """Spectrum and facts of each map; errors name it."""
    found = []
    for m, name in zip(pairs, names):
        try:
            found.append(of_map(*m))
        except InputError as why:
            raise InputError(f"{name}: {why}") from None
        found[-1][1]["rolls_off"] |= longest < (1 - ROUNDING) * _length(m) / ROLLED
        slope = found[-1][1]["slope_rms"]
        if slope > UNIT:
            raise InputError(f"{name} has a slope of {slope:.3g} (rms): heights or spacing are in another unit than m; valid: "
                             f"up to {UNIT:g}; say --unit or --dx")
    return found


def _length(m):
    """Shorter side of a map [m]."""
    return min(n * d for n, d in zip(np.shape(m[0]), m[1]))


def _closure(p, k_n, theory):
    """Approach to each pressure [m], int dP/k_N from none; between and below the pressures k_N has the form of the theory."""
    fine = np.unique(np.concatenate([np.geomspace(1e-4 * p[0], p[-1], 300), p]))
    x = fine / (theory(fine) * np.exp(np.interp(np.log(fine), np.log(p), np.log(k_n / theory(p)))))
    steps = np.diff(np.log(fine))
    power = min(np.log(x[1] / x[0]) / steps[0], 1.0)     # x = P/k_N goes as this power of P at first touch
    d = x[0] / max(power, LEAST_POWER) + np.concatenate([[0.0], np.cumsum(steps * (x[1:] + x[:-1]) / 2)])
    return d[np.searchsorted(fine, p)]


def _denoise(spectrum, noise, points):
    """Spectrum less the white noise of a map."""
    left = np.maximum(spectrum.height_variance - spectrum.modes * noise / points, 0)
    left = np.where(left > 0, left, 1e-9 * spectrum.height_variance)
    return Spectrum(spectrum.q, left, spectrum.modes) if noise else spectrum


def _notes(facts, spectrum, rises, longer):
    """Sentences on what decides the law."""
    notes, parts = [], spectrum.height_variance.cumsum() / spectrum.height_variance.sum()
    half = 2e6 * np.pi / spectrum.q[min(int(np.searchsorted(parts, 0.5)), len(parts) - 1)]
    notes.append(f"half of the height variance lies above wavelengths of {half:.3g} um: the longest decide k_N at light load")
    for i, f in enumerate(facts, 1):
        if rises and not f["rolls_off"]:
            what = ("waves longer than it would lower k_N; the band counts one more octave" if longer
                    else "the longest wave that counts (--longest) decides k_N")
            notes.append(f"map {i} has no roll-off: {what}")
        if f["noise_variance_m2"]:
            notes.append(f"map {i} ends in a flat spectrum: noise of {1e9 * np.sqrt(f['noise_variance_m2']):.3g} nm rms: "
                         "removed, the band counts both")
        if f["isotropy"] < LAY:
            notes.append(f"map {i} has a lay (isotropy {f['isotropy']:.2f})")
        if f["holes"]:
            notes.append(f"map {i} has {100 * f['holes']:.2g} % holes: interpolated")
    return tuple(notes)


def _free_notes(p, k_n, bulk):
    """What a free patch's own bulk [Pa/m] takes of its compliance, and where that is too much."""
    own = k_n / (k_n + bulk)
    note = (f"free patch: the compliance of a smooth one, {1 / bulk:.3g} m/Pa, is taken off (it is {100 * own[0]:.2g} to "
            f"{100 * own[-1]:.2g} % of the whole); k_T follows from k_N: tamaas has no shear of a free patch")
    late = p[own > OWN]
    return (note,) + ((f"from {late[0] / 1e6:.3g} MPa on that is over {100 * OWN:g} %: k_N is the difference of near "
                       "numbers, so take a larger map or --patch periodic",) if late.size else ())


def _spread(spectrum, noisy, longer, p, bodies, k_n, area, draws, seed, whole=False):
    """What widens the band, by name: half widths (95 %) of ln k_N downwards and upwards, and of ln A. `whole`: of boundary
    elements, which take the map with its noise, and whose quarters tell its sampling."""
    rng = np.random.default_rng(seed)
    freedom = np.maximum(spectrum.freedom, 1)

    def change(q, h, modulus=1.0, hardness=1.0):
        hard = max(bodies.hardness * hardness, SOFTEST * p[-1])
        k, a, _ = contact_from_spectrum(q, h, p, bodies.e_star * modulus, hard)
        return np.log(k / k_n), np.log(a / area)

    def quantiles(many):
        k, a = np.transpose(many, (1, 0, 2))
        low, high = (abs(np.quantile(k, x, axis=0)) for x in (0.025, 0.975))
        return low, high, 1.96 * np.std(a, axis=0), 1.96 * np.std(a, axis=0)

    h, parts, none = spectrum.height_variance, {}, np.zeros(len(p))
    if not whole:
        parts["sampling"] = quantiles([change(spectrum.q, h * rng.chisquare(freedom) / freedom) for _ in range(draws)])
    errors = np.exp(rng.standard_normal((draws, 2)) * (MODULUS_ERROR, HARDNESS_ERROR))
    parts["E* and hardness"] = quantiles([change(spectrum.q, h, *e) for e in errors])
    if noisy is not None:
        less, less_area = (np.maximum(-x, 0) for x in change(noisy.q, noisy.height_variance))
        parts["noise"] = (none, less, none, none) if whole else (less, none, less_area, none)
    if longer is not None:
        more = _longer(spectrum, *longer)
        parts["longer waves"] = (np.maximum(-change(more.q, more.height_variance)[0], 0), none, none, none)
    return parts


def _longer(spectrum, least, most):
    """Spectrum with the waves from the length of the map to twice that.

    Levelling took them: their variance is that of the octaves below times their growth (flat: 0.25). On maps cut from four times as
    long ones without roll-off this is 0.77 to 0.83 of the true change of ln k_N (Hurst exponents from 0.3 to 0.9).
    """
    q, h = spectrum.q, spectrum.height_variance

    def octave(n):
        return h[numbers(q) // PER_OCTAVE == n].sum()

    growth = min(max((octave(1) + octave(2)) / max(octave(2) + octave(3), np.finfo(float).tiny), least), most)
    below = max(octave(1), octave(2) * growth)
    missing = [max(below * growth - octave(0), 0.0), below - octave(1)]
    return bands(np.concatenate([q[0] * 2 ** np.array([0.5, 1.5]), q]), np.concatenate([missing, h]))
