# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured specimens: read files, level, fit, and two of them as one equivalent joint surface (Fig. 5)."""
import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from . import roughness
from ._engine import FileError, InputError

_METRES = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "pm": 1e-12}


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

    @property
    def size(self):
        """Extent of the map (y, x) [m]; of a profile: (length,)."""
        steps = self.spacing if self.heights.ndim == 2 else self.spacing[-1:]
        return tuple((n - 1) * d for n, d in zip(self.heights.shape, steps))

    def fit(self, **options):
        """`roughness.fit` of this specimen; takes its options."""
        return roughness.fit(self.heights, self.spacing, **options)

    def structure_function(self, lags=None, direction="rows", second=False):
        """`roughness.structure_function` of this specimen."""
        return roughness.structure_function(self.heights, self.spacing, lags, direction, second)

    def parameters(self):
        """`roughness.parameters` of this specimen."""
        return roughness.parameters(self.heights, self.spacing)


def _factor(unit, path):
    """Metres per unit."""
    if unit is None:
        raise InputError(f'{path.name} states no unit: say unit="um" (or mm, nm, m), or unit=("mm", "um") for lateral and height')
    if unit not in _METRES:
        raise InputError(f"unit {unit!r} of {path.name}: one of m, mm, um, nm, pm")
    return _METRES[unit]


def read(path, unit=None, spacing=None, channel=None):
    """Read a height map or profile.

    SDF (ISO 25178-71, binary; `save` writes it) is read as it is; every other format by the package SurfaceTopography
    (`pip install hdengine[io]`): VK4, VK6, X3P, OPD, PLU, AL3D, SUR, plain text and more. Nothing is guessed: a unit or size
    that the file lacks must be given.

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
        The file is missing or cannot be read.
    InputError
        Unit or size is missing, or given though the file states it; SurfaceTopography is missing.
    """
    path = Path(path)
    if not path.is_file():
        raise FileError(f"{path}: no such file")
    with open(path, "rb") as file:
        if file.read(8) == b"bISO-1.0":
            return _load(path)
    try:
        import SurfaceTopography
    except ImportError as e:
        raise InputError(f"reading {path.name} needs the package SurfaceTopography: pip install hdengine[io]") from e
    try:
        reader = SurfaceTopography.open_topography(str(path))
        info = reader.channels[channel] if channel is not None else reader.default_channel
        sized = info.physical_sizes is not None
        map_ = reader.topography(channel_index=info.index, **({} if sized else {"physical_sizes": (1.0,) * info.dim}))
        heights = np.ma.filled(np.ma.asarray(map_.heights(), dtype=float), np.nan)
    except Exception as e:
        text = " ".join(str(e).split()) or type(e).__name__
        raise FileError(f"{path.name} cannot be read: {text[:200]}") from e
    if map_.unit is not None and unit is not None:
        raise InputError(f"{path.name} states its unit, {map_.unit}: leave out unit={unit!r}")
    pair = (map_.unit or unit,) * 2 if map_.unit or unit is None or isinstance(unit, str) else tuple(unit)
    lateral, height = (_factor(u, path) for u in pair)
    notes = [] if map_.unit else [f"unit given: lateral {pair[0]}, height {pair[1]}"]
    if not sized and spacing is None:
        raise InputError(f"{path.name} states no lateral size: say spacing= in m")
    if sized and spacing is not None:
        raise InputError(f"{path.name} states its size: leave out spacing=")
    if info.dim == 1:
        return _profile(path, map_, heights, lateral, height, spacing, notes)
    steps = [s * lateral / n for s, n in zip(map_.physical_sizes, map_.nb_grid_pts)]
    step = roughness._spacing(spacing) if not sized else steps
    return Specimen(np.ascontiguousarray(heights.T) * height, (float(step[1]), float(step[0])), path.stem, tuple(notes))


def _profile(path, map_, heights, lateral, height, spacing, notes):
    """A line scan; points that are not equidistant are interpolated."""
    x = np.asarray(map_.positions(), dtype=float) * lateral
    if spacing is not None:
        step = roughness._spacing(spacing)[0]
    else:
        step = (x[-1] - x[0]) / (x.size - 1)
        uneven = np.max(abs(np.diff(x) - step)) / step
        if uneven > 1e-3:
            even = x[0] + step * np.arange(x.size)
            heights = np.interp(even, x, heights)
            notes.append(f"points up to {100 * uneven:.0f} % off equidistance: interpolated, the shortest lags are smoothed")
    return Specimen(heights * height, (float(step), float(step)), path.stem, tuple(notes))


_HEADER = struct.Struct("<8s10s12s12sHHddddBBB")  # ISO 25178-71: version, maker, dates, points, rows, scales, kinds
_NUMBERS = {3: "<f4", 5: "<i2", 6: "<i4", 7: "<f8"}


def _load(path):
    """Read what `save` wrote, and other binary SDF files."""
    data = path.read_bytes()
    try:
        *_, nx, ny, dx, dy, dz, _, packed, kind, _ = _HEADER.unpack_from(data)
        z = np.frombuffer(data, _NUMBERS[kind], nx * ny, _HEADER.size).reshape(ny, nx)
    except (struct.error, KeyError, ValueError) as e:
        raise FileError(f"{path.name} is a damaged surface data file (ISO 25178-71)") from e
    if packed or min(nx, ny) < 1 or not (dx > 0 and dz > 0 and (dy > 0 or ny == 1)):
        raise FileError(f"{path.name}: compressed heights, or sizes or scales that are not positive")
    heights = z * dz
    if z.dtype.kind == "i":
        heights[z == np.iinfo(z.dtype).min] = np.nan
    return Specimen(heights if ny > 1 else heights[0], (dy if ny > 1 else dx, dx), path.stem)


def save(path, specimen):
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
    if max(z.shape) > 65535:
        raise InputError(f"{z.shape[0]} x {z.shape[1]} points: SDF holds up to 65535 in a direction")
    low, high = np.nanmin(z), np.nanmax(z)
    step = max((high - low) / 64000, np.finfo(float).tiny)
    steps = np.where(np.isnan(z), np.iinfo(np.int16).min, np.rint((z - 0.5 * (low + high)) / step)).astype("<i2")
    dates = (b" " * 12, b" " * 12)
    head = _HEADER.pack(b"bISO-1.0", b"hdengine  ", *dates, z.shape[1], z.shape[0], specimen.spacing[1], specimen.spacing[0], step,
                        -1.0, 0, 5, 0)
    Path(path).write_bytes(head + steps.tobytes())


@dataclass(frozen=True)
class JointSurface:
    """Two specimens and the surface equivalent to both in contact, S_eq = S_1 + S_2."""

    specimens: tuple
    fits: tuple = field(repr=False)         #: of each specimen
    equivalent: roughness.Fit = field(repr=False)  #: of the sum

    def __str__(self):
        names = [s.name for s in self.specimens] + ["equivalent surface"]
        return "\n\n".join(f"{n}\n{f}" for n, f in zip(names, (*self.fits, self.equivalent)))

    def plot(self):
        """Maps, profiles, structure functions with their fits and bands (Fig. 5).

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .plot_surface import plot_joint_surface

        return plot_joint_surface(self)


def equivalent(first, second, **options):
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
        raise InputError(f"spacing (dy, dx) of {first.name} is {first.spacing} m, of {second.name} {second.spacing} m: must agree")
    both = roughness.fit(first.heights, first.spacing, second=second.heights, **options)
    return JointSurface((first, second), (first.fit(**options), second.fit(**options)), both)
