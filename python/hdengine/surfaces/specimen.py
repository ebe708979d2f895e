# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured specimens: read files, level, fit, and two of them as one equivalent joint surface (Fig. 5)."""
from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from .. import _engine
from .._check import array, checked, fields, flag, integer, kind, text
from .._check import path as a_path
from .._engine import FileError, InputError
from .._types import PathLike, Spacing
from ..files import write_files
from . import roughness

if TYPE_CHECKING:
    from matplotlib.figure import Figure

METRES = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "pm": 1e-12}


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



def _units(unit):
    """Units of length and of height."""
    pair = (unit,) * 2 if unit is None or isinstance(unit, str) else tuple(unit)
    if len(pair) != 2:
        raise InputError(f"unit={unit!r}: one unit, or two: lateral and height")
    return pair


def _factor(unit, path):
    """Metres per unit."""
    if unit is None:
        raise InputError(f'{path.name} states no unit: say unit="um" (or mm, nm, m), or unit=("mm", "um") for lateral and height')
    if unit not in METRES:
        raise InputError(f"unit {unit!r} of {path.name}: one of m, mm, um, nm, pm")
    return METRES[unit]


@checked(path=a_path, channel=integer(0, optional=True))
def read(path: PathLike, unit: str | tuple[str, str] | None = None, spacing: Spacing | None = None,
         channel: int | None = None) -> Specimen:
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
        head = file.read(2000)
    if head[:8] in (b"bISO-1.0", b"aISO-1.0"):
        if unit is not None:
            raise InputError(f"{path.name} states its unit, m: leave out unit={unit!r}")
        if spacing is not None:
            raise InputError(f"{path.name} states its size: leave out spacing=")
        return _load(path) if head[:1] == b"b" else _load_text(path)
    if head[:6] == b"\x93NUMPY":
        return _load_array(path, unit, spacing)
    if b"<!DOCTYPE DATA" in head:
        return _softgauge(path, unit, spacing)
    try:
        import SurfaceTopography
    except ImportError as e:
        raise InputError(f"reading {path.name} needs the package SurfaceTopography: pip install 'hdengine[io]'") from e
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):      # its readers print what they stumble over
            reader = SurfaceTopography.open_topography(str(path))
            info = reader.channels[channel] if channel is not None else reader.default_channel
            sized = info.physical_sizes is not None
            map_ = reader.topography(channel_index=info.index, **({} if sized else {"physical_sizes": (1.0,) * info.dim}))
            heights: np.ndarray = np.ma.filled(np.ma.asarray(map_.heights(), dtype=float), np.nan)
    except Exception as e:
        text = " ".join(str(e).split()) or type(e).__name__
        if text.startswith("tried "):           # every reader in turn
            text = ("no reader takes it: damaged or cut, or of an unknown format; valid: .sdf, .npy, or what SurfaceTopography "
                    "reads, as .x3p, .al3d, .sur, .opd, .xyz")
        raise FileError(f"{path.name} cannot be read: {text[:200]}") from e
    if info.dim == 1 and Path(path).suffix.lower() in (".xml", ".x3p") and not sized and map_.unit is None:
        raise FileError(f"{path.name} cannot be read: its numbers run together as one profile, for its format is not known")
    if map_.unit is not None and unit is not None:
        raise InputError(f"{path.name} states its unit, {map_.unit}: leave out unit={unit!r}")
    pair = _units(map_.unit or unit)
    lateral, height = (_factor(u, path) for u in pair)
    notes = [] if map_.unit else [f"unit given: lateral {pair[0]}, height {pair[1]}"]
    if path.suffix.lower() in (".csv", ".txt", ".asc", ".xyz", ".dat") and path.read_bytes()[-1:] not in b"\r\n":
        notes.append("the file ends within a line: it may be cut, and its last number short")
    if not sized and spacing is None:
        raise InputError(f"{path.name} states no lateral size: say spacing= in m")
    if sized and spacing is not None:
        raise InputError(f"{path.name} states its size: leave out spacing=")
    if info.dim == 1:
        return _profile(path, map_, heights, lateral, height, spacing, notes)
    steps = [s * lateral / n for s, n in zip(map_.physical_sizes, map_.nb_grid_pts)]
    step = roughness._spacing(spacing) if not sized else steps
    found = Specimen(np.ascontiguousarray(heights.T) * height, (float(step[1]), float(step[0])), path.stem, tuple(notes))
    return _doubt(found)


def _doubt(s):
    """The specimen, with a note where its scale is hard to believe: a factor of 1000 shows in slope, spacing and Sq over length."""
    with np.errstate(all="ignore"):
        z = roughness.level(s.heights)
        ratio = np.nanstd(z) / max(s.size)
        slope = np.sqrt(np.nanmean(np.diff(z, axis=-1) ** 2)) / s.spacing[1]
    if not np.isfinite(ratio) or ratio == 0:
        return s
    words = f"rms height {ratio:.2g} of the length, rms slope {slope:.2g}"
    if max(s.size) > 1 or min(s.spacing) > 2e-4 or ratio < 1e-8 or slope < 1e-4:
        note = (f"{words}, length {max(s.size):.3g} m, spacing {min(s.spacing):.2g} m: flatter or coarser than maps of rough "
                "surfaces are; is the lateral scale 1000 times too large?")
    elif ratio > 0.5 or slope > 3 or max(s.spacing) < 5e-11:
        note = f"{words}: steeper than instruments see; is the lateral scale 1000 times too small?"
    else:
        return s
    return replace(s, notes=(*s.notes, note))


def _softgauge(path, unit, spacing):
    """A profile in the XML of the softgauges of NPL and NIST: the raw points of <DATAFILE> with the stated unit and spacing [unit].

    A file may hold filtered profiles too, in <ANALYSIS>; they are another curve and are left out.
    """
    text = re.sub(r"<\?.*?\?>|<!DOCTYPE[^>]*>", "", path.read_text(errors="replace"), flags=re.S)
    try:
        data: Any = ElementTree.fromstring(text).find("DATAFILE")
        values = [float(v) for v in data.findtext("DATA_POINT_VALUES").split()]
        count = int(data.findtext("NUMPOINTS"))
        step = data.findtext("SPACING")
    except (ElementTree.ParseError, AttributeError, TypeError, ValueError) as e:
        raise FileError(f"{path.name} is a damaged or cut softgauge file (XML with <DATAFILE>): {e}") from e
    if count != len(values):
        raise FileError(f"{path.name} states {count} points and holds {len(values)}: it is damaged or cut")
    stated = (data.findtext("UNITS") or "").strip() or None
    if stated is not None and unit is not None:
        raise InputError(f"{path.name} states its unit, {stated}: leave out unit={unit!r}")
    if step is not None and spacing is not None:
        raise InputError(f"{path.name} states its size: leave out spacing=")
    if step is None and spacing is None:
        raise InputError(f"{path.name} states no lateral size: say spacing= in m")
    lateral, height = (_factor(u, path) for u in _units(stated or unit))
    step = roughness._spacing(spacing)[0] if step is None else float(step) * lateral
    others = text.count("POINT_VALUES>") // 2 - 1
    notes = [f"{others} more curve{'s' * (others > 1)} of the file left out: the first raw one is read"] if others > 0 else []
    return _doubt(Specimen(np.array(values) * height, (step, step), path.stem, tuple(notes)))


def _load_array(path, unit, spacing):
    """Heights of a .npy file: rows x points, or one row of points; it states neither unit nor spacing."""
    try:
        z = np.load(path, allow_pickle=False)
    except (ValueError, EOFError, OSError) as e:
        raise FileError(f"{path.name} is a damaged or cut .npy file: {e}") from e
    if z.ndim not in (1, 2) or z.dtype.kind not in "fiu":
        raise FileError(f"{path.name} holds {z.dtype} of shape {z.shape}: heights are real numbers, rows x points or one row")
    if spacing is None:
        raise InputError(f"{path.name} states no lateral size: say spacing= in m")
    factor = _factor(_units("m" if unit is None else unit)[1], path)
    dx, dy = roughness._spacing(spacing)
    notes = () if unit else ("heights taken as metres",)
    return _doubt(Specimen(z.astype(float) * factor, (dy, dx), path.stem, notes))


def _load_text(path):
    """Text form of ISO 25178-71, metres: lines 'key = value' up to a star, then numbers or BAD up to a star."""
    head, _, body = path.read_text(errors="replace").partition("*")
    keys = {k.strip().lower(): v.strip() for k, _, v in (line.partition("=") for line in head.splitlines()) if v}
    try:
        nx, ny = int(keys["numpoints"]), int(keys["numprofiles"])
        dx, dy, dz = (float(keys[k]) for k in ("xscale", "yscale", "zscale"))
        z = np.array([np.nan if w.lower() == "bad" else float(w) for w in body.partition("*")[0].split()])
    except (KeyError, ValueError) as e:
        raise FileError(f"{path.name} is a damaged surface data file (ISO 25178-71): {e}") from e
    if z.size != nx * ny or not (dx > 0 and dz > 0 and (dy > 0 or ny == 1)):
        raise FileError(f"{path.name} states {nx} x {ny} points and holds {z.size}, or a scale is not positive: damaged or cut")
    z = z.reshape(ny, nx) * dz
    return _doubt(Specimen(z if ny > 1 else z[0], (dy if ny > 1 else dx, dx), path.stem))


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
    return _doubt(Specimen(heights * height, (float(step), float(step)), path.stem, tuple(notes)))


_HEADER = struct.Struct("<8s10s12s12sHHddddBBB")  # ISO 25178-71: version, maker, dates, points, rows, scales, kinds
_NUMBERS = {0: "u1", 1: "<u2", 2: "<u4", 3: "<f4", 4: "i1", 5: "<i2", 6: "<i4", 7: "<f8"}
_HOLES = {1: 2**16 - 1, 2: 2**32 - 1, 5: -2**15, 6: -2**31}  # 8-bit numbers have no mark for a hole


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
    if kind in _HOLES:
        heights[z == _HOLES[kind]] = np.nan
    return _doubt(Specimen(heights if ny > 1 else heights[0], (dy if ny > 1 else dx, dx), path.stem))


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
    if max(z.shape) > 65535:
        raise InputError(f"{z.shape[0]} x {z.shape[1]} points: SDF holds up to 65535 in a direction")
    low, high = np.nanmin(z), np.nanmax(z)
    step = max((high - low) / 64000, np.finfo(float).tiny)
    steps = np.where(np.isnan(z), np.iinfo(np.int16).min, np.rint((z - 0.5 * (low + high)) / step)).astype("<i2")
    dates = (b" " * 12, b" " * 12)
    head = _HEADER.pack(b"bISO-1.0", b"hdengine  ", *dates, z.shape[1], z.shape[0], specimen.spacing[1], specimen.spacing[0], step,
                        -1.0, 0, 5, 0)
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
    (found, across_x, across_y), step = _engine.call("surface_clean", z, int(seams), int(outliers), int(fill))
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
