# SPDX-License-Identifier: GPL-3.0-or-later
"""What is found of height maps, as a folder: numbers, tables, figures, and the lines to paste into a scene."""
from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._types import PathLike
from ..files import csv_text, write_folder
from .fit import Fit
from .specimen import JointSurface, Specimen
from .texture import Texture, texture

__all__: list[str] = []


def write(folder: PathLike, specimens: Sequence[Specimen], fits: Sequence[Fit], joint: JointSurface | None = None,
          sources: Sequence[PathLike] = (), force: bool = False, textures: Sequence[Texture] = ()) -> list:
    """Write specimens and their fits into a folder.

    Parameters
    ----------
    folder : path-like
        Gets structure.csv (S over the lag with the model), spectrum.csv (power over frequency with the model), material_ratio.csv
        (Smr over the height), scene.nml (the lines of a scene), a figure of each specimen, joint_surface.png of two, and last
        surface.json (D, G, intervals, bands, verdicts, spectra, areal numbers): without it the others are not whole.
    specimens : sequence of Specimen
    fits : sequence of Fit
        Of each specimen.
    joint : JointSurface, optional
        Both specimens as one surface.
    sources : sequence of path-like, optional
        Files of the specimens: their SHA-256 is kept.
    force : bool
        Replace these files where the folder holds them.
    textures : sequence of Texture, optional
        Areal numbers of each specimen. Default: less the plane, without filters.

    Returns
    -------
    list of Path
        The record first.

    Raises
    ------
    FileError
        The folder holds such files, or a run, or cannot be written.
    """
    from ..figures.surface import plot_specimen

    names = _names([s.name for s in specimens])
    found = dict(zip(names, fits))
    textures = textures or [texture(s) for s in specimens]
    surfaces = {}
    for i, (name, s) in enumerate(zip(names, specimens)):
        surfaces[name] = {"points": s.heights.shape, "spacing_m": s.spacing, "size_m": s.size, "notes": s.notes,
                          "areal": _areal(textures[i]), **_told(fits[i])}
        if i < len(sources):
            surfaces[name] |= {"file": str(sources[i]), "sha256": hashlib.sha256(Path(sources[i]).read_bytes()).hexdigest()}
    files: dict[str, Any] = {}
    if joint is not None:
        found["equivalent"] = joint.equivalent
        surfaces["equivalent"] = _told(joint.equivalent)
    files["structure.csv"], files["spectrum.csv"] = _structure(found), _spectrum(found)
    files["material_ratio.csv"] = _material(dict(zip(names, textures)))
    sides = {name: (max(s.size), s.spacing) for name, s in zip(names, specimens)}
    if joint is not None:
        sides = {"equivalent": min(sides.values())}
    files["scene.nml"] = "\n".join(_scene(name, found[name], *side) for name, side in sides.items())
    files |= {f"{name}.png": plot_specimen(s, f) for name, s, f in zip(names, specimens, fits)}
    if joint is not None:
        files["joint_surface.png"] = joint.plot()
    return write_folder(folder, "surface.json", {"kind": "surfaces", "surfaces": surfaces}, files, force)


def files_of(specimens: Sequence[Specimen], pair: bool) -> list:
    """Names of what `write` leaves in a folder."""
    drawn = [*_names([s.name for s in specimens]), *["joint_surface"] * pair]
    return ["surface.json", "structure.csv", "spectrum.csv", "material_ratio.csv", "scene.nml", *(f"{name}.png" for name in drawn)]


def _names(names):
    """Names that differ from each other and from what else lies in the folder, fit to be part of a file's."""
    out: list[str] = []
    for name in names:
        plain = "".join(c if c.isalnum() or c in "-_. " else "_" for c in name) or "specimen"
        n, wanted = 1, plain
        while wanted in (*out, "joint_surface", "equivalent"):
            n += 1
            wanted = f"{plain}_{n}"
        out.append(wanted)
    return out


def _told(fit):
    """What a fit says, with units in the names."""
    dimension = dict(zip(("fractal_dimension_95", "roughness_95_m"), fit.interval))
    sampling = dict(zip(("fractal_dimension_95_sampling", "roughness_95_sampling_m"), fit.sampling_interval))
    told = {"verdict": fit.verdict, "what": fit.kind, "reason": fit.reason, "model": fit.model,
            "fractal_dimension": fit.fractal_dimension, "roughness_m": fit.roughness_m if fit.determined else None,
            **dimension, **sampling, "covariance_of_d_ln_g": fit.covariance[:2, :2], "band_m": fit.band_m, "noise_m": fit.noise_m,
            "misfit": fit.misfit, "chi2": fit.chi2, "freedom": fit.freedom, "lags": fit.lags, "tilt": fit.tilt,
            "levelled": fit.levelled, "anisotropy": fit.anisotropy, "ridges": fit.ridges and vars(fit.ridges),
            "probe_m": fit.probe_m, "finer_detail": fit.finer_detail, "spikes": fit.spikes, "holes": fit.holes,
            "seams": fit.seams, "seam_step_m": fit.seam_step_m,
            "jitter_m": fit.jitter_m, "axis_excess": fit.axis_excess, "wrong_from_m": fit.wrong_from_m, "ranges_d_m_m": fit.ranges}
    if fit.frequency is not None:
        told["spectrum"] = {"frequency_per_m": fit.frequency, "power": fit.density, "model": fit.density_model}
    return told


def _areal(t):
    """Areal numbers with how the map was prepared."""
    return {"form": t.form.kind, "form_range_m": t.form.range_m, "form_radius_m": t.form.radius_m, "form_axis_rad": t.form.axis_rad,
            "s_filter_m": t.s_filter_m, "l_filter_m": t.l_filter_m, "mended": t.mended,
            "outliers": t.outliers, "holes": t.holes, "filled": t.filled, **t.numbers}


def _material(textures):
    """Smr over the height of every surface."""
    columns: dict[str, list] = {n: [] for n in ("surface", "height_m", "smr")}
    for name, t in textures.items():
        c, ratio = t.material_ratio()
        columns["surface"] += [name] * len(c)
        columns["height_m"] += list(c)
        columns["smr"] += list(ratio)
    return csv_text(columns)


def _structure(found):
    """S over the lags of every surface; NaN where there is no model."""
    names = ("surface", "direction", "lag_m", "s_m2", "model_m2", "model_error_ln", "sample_error_ln")
    columns: dict[str, list] = {n: [] for n in names}
    for name, fit in found.items():
        for direction, part in fit.directions():
            for key, values in (("surface", [name] * len(part)), ("direction", [direction] * len(part)), ("lag_m", fit.tau_m[part]),
                                ("s_m2", fit.s_m2[part]), ("model_m2", fit.curve_m2[part]),
                                ("model_error_ln", fit.curve_error[part]), ("sample_error_ln", fit.sample_error[part])):
                columns[key] += list(values)
    return csv_text(columns)


def _spectrum(found):
    """Power over the rings of every surface that has one; the model is empty outside of the window."""
    columns: dict[str, list] = {n: [] for n in ("surface", "frequency_per_m", "power", "model", "unit")}
    for name, fit in found.items():
        n = 0 if fit.frequency is None else len(fit.frequency)
        columns["surface"] += [name] * n
        columns["unit"] += ["m3" if np.isnan(fit.anisotropy) else "m4"] * n
        for key, values in (("frequency_per_m", fit.frequency), ("power", fit.density), ("model", fit.density_model)):
            columns[key] += list(values) if n else []
    return csv_text(columns)


def _scene(name, fit, side, spacing):
    """Lines of a scene for one surface, or why there are none."""
    if fit.verdict != "fractal" or not fit.determined:
        why = f"{fit.verdict} ({fit.kind})" if fit.verdict != "fractal" else "G is not determined, for the interval of D reaches 2"
        return (f"! {name}: {why}. D and G would say nothing of its joint.\n! Take the spectrum as measured: "
                "hdengine joint MAP --out joint.out, then joint.spectrum_file = 'joint.out/spectrum.csv'.\n")
    (d_low, d_high), (g_low, g_high) = fit.interval
    told = fit.ridges
    shortest = told.shortest_wavelength if told else max(fit.band_m[0], 2 * min(spacing))
    ends = ("L and L_s as told" if told else "L the map's longer side, L_s the shortest wavelength that follows the fit.\n"
            "! Both ends are the instrument's: waves beyond them are not seen, and the stiffness depends on them")
    return (f"! {name}: D and G with their 95 % intervals, {ends}.\n"
            f"&joint\n  model = 'spectrum'\n  fractal_dimension = {fit.fractal_dimension:.5f}   ! {d_low:.4f} to {d_high:.4f}\n"
            f"  roughness = {fit.roughness_m:.5g}   ! {g_low:.3g} to {g_high:.3g} m\n"
            f"  sample_length = {told.length if told else side:.6g}\n  shortest_wavelength = {shortest:.6g}\n/\n")
