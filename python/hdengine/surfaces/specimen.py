# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured specimens: read files, level, fit, and two of them as one equivalent joint surface (Fig. 5)."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _engine
from .._check import array, checked, fields, flag, integer, kind, text
from .._check import path as a_path
from .._engine import InputError
from .._types import PathLike, Spacing
from ..files import write_files
from . import map_file, roughness

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["JointSurface", "Specimen", "clean", "equivalent", "read", "save"]
METRES = map_file.METRES
_WIDE, _COARSE = 1.0, 2e-4   # map [m] and spacing [m] beyond those of instruments that see roughness
_FLAT, _SMOOTH = 1e-8, 1e-4  # rms height over the length, rms slope: below those of finished faces
_STEEP, _ATOM = 3.0, 5e-11   # slope that no probe follows; spacing below an atom [m]
_MOST_POINTS = 65535         # of SDF in a direction
_STEPS = 64000               # of 16 bits: the range of heights, with room at its ends
LONGEST = 10.0  # of a map, and of a height [m], as in the engine: more is a wrong unit, or a mark for holes


@dataclass(frozen=True)
class Specimen:
    """A height map or profile with its spacing.

    Parameters
    ----------
    heights : ndarray (rows, points) or (points,)
        Heights [m]; NaN are holes.
    spacing : (float, float)
        (dy, dx) [m].
    name : str
        For figures and tables.
    notes : tuple of str
        What was done on reading.
    """

    heights: np.ndarray = field(repr=False)
    spacing: tuple
    name: str = "specimen"
    notes: tuple = ()

    def __post_init__(self) -> None:
        fields(self, heights=array([(None,), (None, None)], holes=True), name=text)
        step = array([(), (1,), (2,)], above=0)("spacing", self.spacing)
        object.__setattr__(self, "spacing", tuple(np.broadcast_to(step, 2).tolist()))

    @property
    def size(self) -> tuple:
        """Extent of the map (y, x) [m]; of a profile: (length,)."""
        steps = self.spacing if self.heights.ndim == 2 else self.spacing[-1:]
        return tuple((n - 1) * d for n, d in zip(self.heights.shape, steps))

    def levelled(self) -> np.ndarray:
        """Heights less their plane (`roughness.level`) [m]."""
        return roughness.level(self.heights)

    def fit(self, **options: Any) -> roughness.Fit:
        """`roughness.fit` of this specimen; takes its options."""
        return roughness.fit(self.heights, self.spacing, **options)

    def structure_function(self, lags: Sequence[int] | None = None, direction: str = "rows", second: bool = False) -> tuple:
        """`roughness.structure_function` of this specimen."""
        return roughness.structure_function(self.heights, self.spacing, lags, direction, second)


@checked(path=a_path, channel=integer(0, optional=True))
def read(path: PathLike, unit: str | tuple[str, str] | None = None, spacing: Spacing | None = None,
         channel: int | None = None) -> Specimen:
    """Read a height map or profile.

    SDF (ISO 25178-71, `save` writes it; BCR), .npy, .npz and text of bare numbers (heights; x and height; x, y and height; a
    matrix of four columns or more) are read as they are; every other format by the package SurfaceTopography (`pip install
    hdengine[io]`): VK4, VK6, X3P, OPD, PLU, AL3D, SUR and more. Nothing is guessed: a unit or size that the file lacks must be
    given.

    Parameters
    ----------
    path : path-like
        File.
    unit : str or (str, str), optional
        Unit of a file that states none; two: lateral and height.
    spacing : float or (float, float), optional
        Spacing (dy, dx) [m] of a file that states no size.
    channel : int, optional
        Channel of a file with several; default: the first height channel.

    Returns
    -------
    Specimen

    Raises
    ------
    FileError
        The file is missing or cannot be read, or states more than it can hold.
    InputError
        Unit or size is missing, or given though the file states it; wider or taller than 10 m; SurfaceTopography is missing.
    """
    heights, steps, notes = map_file.read(Path(path), unit, spacing, channel)
    return _doubt(Specimen(heights, steps, Path(path).stem, tuple(notes)))


def _doubt(s):
    """The specimen, with a note where its scale is hard to believe: a factor of 1000 shows in slope, spacing and Sq over length.

    What no instrument measures is refused.
    """
    if max(s.size) > LONGEST:
        raise InputError(f"{s.name} is {max(s.size):.4g} m wide; valid: up to {LONGEST:g} m: is the unit right?")
    tall = np.nanmax(abs(s.heights), initial=0.0)
    if tall > LONGEST:
        raise InputError(f"{s.name} has heights up to {tall:.4g} m; valid: up to {LONGEST:g} m, NaN for a hole")
    with np.errstate(all="ignore"):
        z = roughness.level(s.heights)
        ratio = np.nanstd(z) / max(s.size)
        slope = np.sqrt(np.nanmean(np.diff(z, axis=-1) ** 2)) / s.spacing[1]
    if not np.isfinite(ratio) or ratio == 0:
        return s
    words = f"rms height {ratio:.2g} of the length, rms slope {slope:.2g}"
    if max(s.size) > _WIDE or min(s.spacing) > _COARSE or ratio < _FLAT or slope < _SMOOTH:
        note = (f"{words}, length {max(s.size):.3g} m, spacing {min(s.spacing):.2g} m: flatter or coarser than maps of rough "
                "surfaces are; is the lateral scale 1000 times too large?")
    elif ratio > 0.5 or slope > _STEEP or max(s.spacing) < _ATOM:
        note = f"{words}: steeper than instruments see; is the lateral scale 1000 times too small?"
    else:
        return s
    return replace(s, notes=(*s.notes, note))


@checked(path=a_path, specimen=kind(Specimen))
def save(path: PathLike, specimen: Specimen) -> None:
    """Write a specimen as binary SDF (ISO 25178-71, metres) with heights in 16-bit steps of 1/64000 of the range.

    hdengine.x, SurfaceTopography and Gwyddion read it.

    Parameters
    ----------
    path : path-like
        File to write.
    specimen : Specimen
        What to write.

    Raises
    ------
    InputError
        More than 65535 points in a direction.
    """
    z = np.atleast_2d(specimen.heights)
    if max(z.shape) > _MOST_POINTS:
        raise InputError(f"{z.shape[0]} x {z.shape[1]} points: SDF holds up to {_MOST_POINTS} in a direction")
    low, high = np.nanmin(z), np.nanmax(z)
    step = max((high - low) / _STEPS, np.finfo(float).tiny)
    steps = np.where(np.isnan(z), np.iinfo(np.int16).min, np.rint((z - 0.5 * (low + high)) / step)).astype("<i2")
    dates = (b" " * 12, b" " * 12)
    head = map_file.HEADER.pack(b"bISO-1.0", b"hdengine  ", *dates, z.shape[1], z.shape[0], specimen.spacing[1],
                                specimen.spacing[0], step, -1.0, 0, 5, 0)
    write_files({Path(path): head + steps.tobytes()})


@checked(specimen=kind(Specimen), outliers=flag, fill=flag, seams=flag)
def clean(specimen: Specimen, outliers: bool = True, fill: bool = False, seams: bool = False) -> tuple:
    """Level steps of stitching, take wrong points for holes, fill holes with what bends least.

    Filling solves Laplace's equation; tilt is kept.

    Parameters
    ----------
    specimen : Specimen
        Map or profile.
    outliers : bool
        Take points for holes that stand more than six robust standard deviations off those around, alone or in small clumps.
    fill : bool
        Fill the holes.
    seams : bool
        Level the tiles between straight steps that cross the map along its rows or columns.

    Returns
    -------
    Specimen
        Its notes say what was done.
    found : int
        Number of wrong points.

    Raises
    ------
    InputError
        The map holds no height.
    """
    z = np.array(roughness._map(specimen.heights), order="F", copy=True)
    dy, dx = specimen.spacing
    (found, across_x, across_y), step = _engine.call("surface_clean", z, dx, dy, int(seams), int(outliers), int(fill))
    holes = int(np.sum(~np.isfinite(specimen.heights))) + int(found)
    notes = [f"{across_x} seams across x and {across_y} across y levelled, steps up to {step:.3g} m"] * bool(across_x + across_y)
    notes += [f"{found} outliers taken for holes"] * bool(found) + [f"{holes} holes filled"] * (fill and holes > 0)
    return replace(specimen, heights=z.T.reshape(specimen.heights.shape), notes=(*specimen.notes, *notes)), int(found)


@dataclass(frozen=True)
class JointSurface:
    """Two specimens and the surface equivalent to both in contact, S_eq = S_1 + S_2."""

    specimens: tuple
    fits: tuple = field(repr=False)         #: of each specimen
    equivalent: roughness.Fit = field(repr=False)  #: of the sum

    def __str__(self) -> str:
        names = [s.name for s in self.specimens] + ["equivalent surface"]
        return "\n\n".join(f"{n}\n{f}" for n, f in zip(names, (*self.fits, self.equivalent)))

    def plot(self) -> Figure:
        """Maps, profiles, structure functions with their fits and bands (Fig. 5).

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ..figures.surface import plot_joint_surface

        return plot_joint_surface(self)


@checked(first=kind(Specimen), second=kind(Specimen))
def equivalent(first: Specimen, second: Specimen, **options: Any) -> JointSurface:
    """Fit two specimens and their equivalent surface.

    Parameters
    ----------
    first, second : Specimen
        Both sides of the joint, with equal spacing.
    **options
        As for `roughness.fit`.

    Returns
    -------
    JointSurface

    Raises
    ------
    InputError
        Spacings differ, or as `roughness.fit`.
    """
    if not np.allclose(first.spacing, second.spacing, rtol=1e-3):
        raise InputError(f"spacing (dy, dx) of {first.name} is {first.spacing} m, of {second.name} {second.spacing} m: must agree; "
                         "composite.resample gives both one")
    if first.heights.shape == second.heights.shape and np.array_equal(first.heights, second.heights, equal_nan=True):
        raise InputError(f"{first.name} and {second.name} are the same heights: S_1 + S_2 holds for independent surfaces")
    both = roughness.fit(first.heights, first.spacing, second=second.heights, **options)
    return JointSurface((first, second), (first.fit(**options), second.fit(**options)), both)
