# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface runs: a namelist with &surface or &fit alone, and its results."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from .. import _engine
from .._check import checked, flag
from .._check import path as a_path
from .._engine import InputError
from .._types import PathLike, Value
from ..contact import _assignments
from ..files import write_files
from ..summary_file import read_summary, written
from ..table_file import read_csv
from .fit import Fit, Ridges, rows_alone
from .specimen import JointSurface, Specimen

__all__ = ["SurfaceResult", "run_surface"]


@checked(path=a_path, out=a_path, force=flag)
def run_surface(path: PathLike | None = "", out: PathLike = "surface.out", force: bool = False,
                **keys: Value) -> SurfaceResult:
    """Generate a surface, or read one or two specimens, and fit D and G, as hdengine.x does.

    Parameters
    ----------
    path : str, optional
        Namelist with no groups but &surface, &fit, &run.
    out : str
        Folder for the results.
    force : bool
        Replace earlier results in the folder.
    **keys
        Keys as fit__last_lag=10, or one dict per group.

    Returns
    -------
    SurfaceResult

    Raises
    ------
    InputError
        The input asks for a contact run, or holds mistakes.
    FileError
        A specimen is missing or cannot be read.
    """
    if not _run(path, out, force, keys):
        raise InputError("the input asks for a contact run: use hdengine.run")
    return SurfaceResult(out)


def _run(path, out, force, keys):
    """True if the input was a surface alone, which then has run."""
    return bool(_engine.call("surface_run", str(path), "\n".join(_assignments(keys)) or " ", str(out), int(force)))


class SurfaceResult:
    """A finished surface run.

    Attributes
    ----------
    folder : Path
    summary : dict
        summary.json.
    specimens : tuple of Specimen
        The generated surface, or what was read.
    fits : dict of Fit
        By name: generated; or first, second, equivalent. Empty if no fit was asked for.
    """

    @checked(folder=a_path)
    def __init__(self, folder: PathLike) -> None:
        self.folder = Path(folder)
        self.summary = read_summary(folder, "fits", "spacing_m")
        fits, spacing = self.summary["fits"], tuple(self.summary["spacing_m"])
        specimens = []
        names = {"generated": "heights.npy"} if "generator" in self.summary else {"first": "first.npy", "second": "second.npy"}
        for name, file in names.items():   # the folder may hold those of an earlier run besides
            if (self.folder / file).is_file() and (name in fits or not fits):
                z = np.load(written(self.folder, file, self.summary))
                specimens.append(Specimen(z if len(z) > 1 else z[0], spacing, Path(fits.get(name, {}).get("file", name)).stem))
        self.specimens = tuple(specimens)
        table = read_csv(written(self.folder, "fit.csv", self.summary)) if fits else None
        heights = [s.heights for s in specimens]
        self.fits = {name: _fit(name, s, table, heights) for name, s in fits.items()}

    @property
    def joint(self) -> JointSurface | None:
        """Both specimens with their equivalent surface, or None."""
        if "equivalent" not in self.fits:
            return None
        return JointSurface(self.specimens, (self.fits["first"], self.fits["second"]), self.fits["equivalent"])

    def __str__(self) -> str:
        return "\n\n".join(f"{name}\n{fit}" for name, fit in self.fits.items()) or f"{self.folder}: surface without a fit"

    def plot(self) -> list:
        """Draw fit.png in the folder: maps, middle rows, structure functions with fit and 95 % band (Fig. 5).

        Returns
        -------
        list of Path
            Files written, none without a fit.
        """
        from ..figures.surface import plot_joint_surface, plot_specimen

        if not self.fits:
            return []
        name = next(iter(self.fits))
        figure = plot_joint_surface(self.joint) if self.joint else plot_specimen(self.specimens[0], self.fits[name])
        path = self.folder / "fit.png"
        write_files({path: figure})
        return [path]


def _fit(name, s, table, heights):
    """Fit of the summary, of the rows of fit.csv and of the maps."""
    rows = table[table["surface"] == name]
    nan = float("nan")
    none = nan, nan
    return Fit(
        fractal_dimension=s.get("fractal_dimension", nan), roughness_m=s.get("roughness_m", nan),
        fractal_dimension_error=s.get("fractal_dimension_error", nan), ln_roughness_error=s.get("ln_roughness_error", nan),
        covariance=np.reshape(s.get("covariance", [nan] * 9), (3, 3)),
        interval=tuple(tuple(s.get(key, none)) for key in ("fractal_dimension_95", "roughness_95_m")),
        sampling_interval=tuple(tuple(s.get(key, none)) for key in ("fractal_dimension_95_sampling", "roughness_95_sampling_m")),
        noise_m=s.get("noise_m", nan), verdict=s["verdict"],
        kind=s["kind"], reason=s["reason"], model=s["model"], weighted=s["weighted"],
        ensemble="random phases" if s["weighted"] else "Gaussian field", lags=tuple(map(int, s["lags"])), band_m=tuple(s["band_m"]),
        rms=s.get("residual_rms", nan), rms_expected=s.get("residual_rms_expected", nan), misfit=s.get("misfit", nan),
        chi2=s.get("chi2", nan), freedom=s.get("freedom", 0), anisotropy=s.get("anisotropy", nan), tilt=tuple(s["tilt"]),
        levelled=s["levelled"], tau_m=rows["lag_m"], s_m2=rows["s_m2"], curve_m2=rows["model_m2"],
        curve_error=rows["model_error_ln"], sample_error=rows["sample_error_ln"],
        rows_alone=rows_alone(s["lags"], *heights), ridges=_ridges(s.get("ridges")))


def _ridges(s):
    """The sum of Eq. 1 in the summary, if there is one."""
    return s and Ridges(s["length_m"], s["shortest_wavelength_m"], s["ridges"], s["gamma"])
