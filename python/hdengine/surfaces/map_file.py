# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of height maps and profiles: heights [m], distances of points (dy, dx) [m] and what was done on reading."""
from __future__ import annotations

import math
import re
import struct
import zipfile
import zlib
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from .._check import MOST_BYTES, NUMBER, input_file, seen
from .._engine import FileError, InputError
from .._types import Spacing
from . import roughness, text_file

__all__: list[str] = []
UNEVEN = 1e-3    # distance of a position from an even row of them, over the step: heights are interpolated beyond
METRES = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "pm": 1e-12}


def read(path: Path, unit: str | tuple[str, str] | None, spacing: Spacing | None, channel: int | None) -> tuple:
    """Read a file by what it begins with; as `specimen.read`.

    Returns
    -------
    heights : ndarray (rows, points) or (points,)
        [m]; NaN are holes.
    steps : (float, float)
        (dy, dx) [m].
    notes : list of str
    """
    path = input_file(path)
    with open(path, "rb") as file:
        head = file.read(2000)
    if not head:
        raise FileError(f"{path.name} is empty")
    if head[1:5] in (b"ISO-", b"BCR-") and head[:1] in b"ab":
        _scales(path, "m", unit)
        _check_size(path, True, spacing)
        if head[1:8] not in (b"ISO-1.0", b"BCR-1.0"):
            raise FileError(f"{path.name} is of version {head[1:8].decode('ascii', 'replace')!r}; valid: ISO-1.0, BCR-1.0")
        return _load(path) if head[:1] == b"b" else _load_text(path)
    if re.search(rb"^(\xef\xbb\xbf)?\s*[ab](iso|bcr)-\d", head, re.I | re.M):
        raise FileError(f"{path.name} is a map of the format SDF whose first word is not the first of the file, or not in its "
                        "letters; valid: a file that begins with aISO-1.0, bISO-1.0, aBCR-1.0 or bBCR-1.0")
    if head[:6] == b"\x93NUMPY":
        return _load_array(path, unit, spacing)
    input_file(path, MOST_BYTES)
    if zipfile.is_zipfile(path):
        _check_archive(path)
        if path.suffix.lower() == ".npz":
            return _load_array(path, unit, spacing, channel or 0)
    if b"<!DOCTYPE DATA" in head:
        return _softgauge(path, unit, spacing)
    table = text_file.read_table(path)
    if table is not None:
        return _plain(path, table, unit, spacing)
    return _foreign(path, unit, spacing, channel)


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


def _check_size(path, stated, spacing):
    """Refuse a lateral size that is said again, or that nobody says."""
    if stated and spacing is not None:
        raise InputError(f"{path.name} states its size: leave out spacing=")
    if not stated and spacing is None:
        raise InputError(f"{path.name} states no lateral size: say spacing= in m")


def _foreign(path, unit, spacing, channel):
    """A map or profile that SurfaceTopography reads."""
    try:
        import SurfaceTopography
    except ImportError as e:
        raise InputError(f"reading {path.name} needs the package SurfaceTopography: pip install 'hdengine[io]'") from e
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):      # its readers print what they stumble over
            reader = SurfaceTopography.open_topography(str(path))
            if reader.format() == "hgt" and path.suffix.lower() != ".hgt":      # it takes any bytes
                raise ValueError("tried all")
            info = reader.channels[channel] if channel is not None else reader.default_channel
            sized = info.physical_sizes is not None
            _check_room(path, info.nb_grid_pts)
            map_ = reader.topography(channel_index=info.index, **({} if sized else {"physical_sizes": (1.0,) * info.dim}))
            heights: np.ndarray = np.ma.filled(np.ma.asarray(map_.heights(), dtype=float), np.nan)
    except FileError:
        raise
    except Exception as e:
        raise FileError(f"{path.name} cannot be read: {_why(path, str(e) or type(e).__name__)}") from e
    if info.dim == 1 and path.suffix.lower() in (".xml", ".x3p") and not sized and map_.unit is None:
        raise FileError(f"{path.name} cannot be read: its numbers run together as one profile, for its format is not known")
    lateral, height, notes = _scales(path, map_.unit, unit)
    notes += _cut(path)
    _check_size(path, sized, spacing)
    if info.dim == 1:
        x = np.asarray(map_.positions(), dtype=float) if spacing is None else None
        return _profile(path, x, heights, lateral, height, spacing, notes)
    steps = [s * lateral / n for s, n in zip(map_.physical_sizes, map_.nb_grid_pts)]
    step = roughness._spacing(spacing) if not sized else steps
    return np.ascontiguousarray(heights.T) * height, (float(step[1]), float(step[0])), notes


def _scales(path, stated, unit):
    """Metres per unit, lateral and of height, and a note where the unit was given."""
    if stated is not None and unit is not None:
        raise InputError(f"{path.name} states its unit, {stated}: leave out unit={unit!r}")
    pair = _units(stated or unit)
    lateral, height = (_factor(u, path) for u in pair)
    return lateral, height, [] if stated else [f"unit given: lateral {pair[0]}, height {pair[1]}"]


def _cut(path):
    """A note on a text that ends within a line."""
    if not text_file.is_text(path):
        return []
    with open(path, "rb") as file:
        file.seek(-1, 2)
        return ["the file ends within a line: it may be cut, and its last number short"] if file.read(1) not in b"\r\n" else []


def _why(path, text):
    """What readers of SurfaceTopography say: of all that were tried, those of the file's ending."""
    if text.startswith("tried "):
        from SurfaceTopography.IO import readers

        ending = path.suffix.lower()[1:]
        mine = {r.__name__ for r in readers if ending in getattr(r, "_file_extensions", ())}
        said = [f"{name}: {why}" for name, why in re.findall(r"tried (\w+): \n(.*?)\n\n", text + "\n\n", re.S)
                if name in mine and why.strip()]
        text = f"no reader takes it, {'; '.join(said)}" if said else (
            "no reader takes it: damaged or cut, or of an unknown format; valid: .sdf, .npy, or what SurfaceTopography reads, as "
            ".x3p, .al3d, .sur, .opd, .xyz")
    return " ".join(text.split())[:240]


_ROOMY = 2**26  # bytes that any archive may take
_DENSE = 100    # times its own size that a larger one may take: maps pack to a third, rarely to a tenth


def _check_archive(path):
    """Refuse an archive that would take much more memory than its size tells, before anything is unpacked."""
    try:
        with zipfile.ZipFile(path) as archive:
            total = sum(member.file_size for member in archive.infolist())
    except (zipfile.BadZipFile, ValueError, NotImplementedError, OSError) as e:
        raise FileError(f"{path.name} is a damaged or cut archive: {e}") from e
    _check_room(path, (total,), "bytes when unpacked")


def _check_room(path, shape, what="points"):
    """Refuse what a header states beyond all sense for a file of this size."""
    number, size = math.prod(int(n) for n in shape), path.stat().st_size
    most = min(MOST_BYTES, max(_ROOMY, _DENSE * size)) // (1 if what != "points" else 8)
    if number > most:
        raise FileError(f"{path.name} of {size} bytes states {number} {what}; valid: up to {most}")


def _softgauge(path, unit, spacing):
    """A profile in the XML of the softgauges of NPL and NIST: the raw points of <DATAFILE> with the stated unit and spacing [unit].

    A file may hold filtered profiles too, in <ANALYSIS>; they are another curve and are left out.
    """
    from xml.etree import ElementTree

    text = re.sub(r"<\?.*?\?>|<!DOCTYPE[^>]*>", "", path.read_text(errors="replace"), flags=re.S)
    try:
        data: Any = ElementTree.fromstring(text).find("DATAFILE")
        values = [_number(v, "DATA_POINT_VALUES") for v in data.findtext("DATA_POINT_VALUES").split()]
        count = int(data.findtext("NUMPOINTS"))
        step = data.findtext("SPACING")
    except (ElementTree.ParseError, AttributeError, TypeError, ValueError) as e:
        raise FileError(f"{path.name} is a damaged or cut softgauge file (XML with <DATAFILE>): {e}") from e
    if count != len(values):
        raise FileError(f"{path.name} states {count} points and holds {len(values)}: it is damaged or cut")
    lateral, height, _ = _scales(path, (data.findtext("UNITS") or "").strip() or None, unit)
    _check_size(path, step is not None, spacing)
    try:
        step = roughness._spacing(spacing)[0] if step is None else _number(step.strip(), "SPACING") * lateral
    except ValueError as e:
        raise FileError(f"{path.name}: {e}") from e
    others = text.count("POINT_VALUES>") // 2 - 1
    notes = [f"{others} more curve{'s' * (others > 1)} of the file left out: the first raw one is read"] if others > 0 else []
    return np.array(values) * height, (step, step), notes


def _load_array(path, unit, spacing, channel=None):
    """Heights of a .npy file, or of one of an archive of them: rows x points, or one row; they state no unit or spacing."""
    notes = [] if unit else ["heights taken as metres"]
    try:
        if channel is None:
            with open(path, "rb") as file:
                z = _array(file, path.stat().st_size)
        else:
            with zipfile.ZipFile(path) as archive:
                members = [m for m in archive.infolist() if m.filename.endswith(".npy")]
                if channel >= len(members):
                    raise InputError(f"channel = {channel}: {path.name} holds {len(members)} arrays; the first is 0")
                with archive.open(members[channel]) as file:
                    z = _array(file, members[channel].file_size)
                notes += [f"{members[channel].filename[:-4]} of {len(members)} arrays is read"] * (len(members) > 1)
    except (ValueError, EOFError, OSError, zipfile.BadZipFile, zlib.error) as e:
        raise FileError(f"{path.name} is a damaged or cut {'.npy' if channel is None else '.npz'} file: {e}") from e
    if z.ndim not in (1, 2) or z.dtype.kind not in "fiu":
        raise FileError(f"{path.name} holds {z.dtype} of shape {z.shape}: heights are real numbers, rows x points or one row")
    _check_size(path, False, spacing)
    factor = _factor(_units("m" if unit is None else unit)[1], path)
    dx, dy = roughness._spacing(spacing)
    return z.astype(float) * factor, (dy, dx), notes


def _array(file, size):
    """The array of an open .npy; ValueError where its header states other than the bytes there are, before it takes memory."""
    version = np.lib.format.read_magic(file)
    read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    try:
        shape, _, kind = read_header(file)
    except Exception as e:      # what Python's parser finds, too
        raise ValueError("its header states no array") from e
    if math.prod(shape) * kind.itemsize != size - file.tell():
        raise ValueError(f"it states shape {shape} of {kind.itemsize} bytes each and holds {size - file.tell()}")
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)


def _plain(path, table, unit, spacing):
    """A profile or map of a plain table of numbers."""
    stated = tuple(table.units[k] for k in ("Lateral", "Value")) if len(table.units) == 2 else None
    lateral, height, notes = _scales(path, stated, unit)
    notes += _cut(path)
    columns = table.values.shape[1]
    sized = columns in (2, 3)
    _check_size(path, sized, spacing)
    if columns == 1:
        return _profile(path, None, table.values[:, 0], lateral, height, spacing, notes)
    if columns > 3:
        dx, dy = roughness._spacing(spacing)
        return table.values * height, (dy, dx), notes
    if columns == 2:
        x, z, more = text_file.profile(path, table)
        return _profile(path, x * lateral, z, 1.0, height, None, notes + more)
    z, (dy, dx), more = text_file.points(path, table)
    line = 1 in z.shape
    steps = (max(dx, dy),) * 2 if line else (dy, dx)
    if not min(steps) > 0:
        raise FileError(f"{path.name} holds one point")
    return (z.ravel() if line else z) * height, tuple(s * lateral for s in steps), notes + more


def _number(word, place):
    """A number of a text: digits, a point, an exponent; ValueError with its line or key for all else, also what `float` takes."""
    if not NUMBER.fullmatch(word):
        raise ValueError(f"{place}: {seen(word)}; valid: a number")
    return float(word)


def _load_text(path):
    """Text form of ISO 25178-71, metres: lines 'key = value' up to a star, then numbers, or BAD or NaN, up to a star."""
    head, *parts = re.split(r"(?<!\S)\*", input_file(path, MOST_BYTES).read_text(errors="replace"), maxsplit=2)
    body = parts[0] if parts else ""
    keys: dict[str, list] = {k: [] for k in ("numpoints", "numprofiles", "xscale", "yscale", "zscale")}
    for key, _, value in (line.partition("=") for line in head.splitlines()):
        keys.get(key.strip().lower(), []).append(value.strip())
    try:
        for key, values in keys.items():
            if len(values) != 1:
                raise ValueError(f"{key} stands {len(values)} times; valid: once")
        nx, ny, dx, dy, dz = (_number(values[0], key) for key, values in keys.items())
        z = [np.nan if word.lower() in ("bad", "nan") else _number(word, f"line {number}")
             for number, line in enumerate(body.split("\n"), head.count("\n") + 1) for word in line.split()]
    except ValueError as e:
        raise FileError(f"{path.name} is a damaged surface data file (ISO 25178-71): {e}") from e
    if len(z) != nx * ny or nx % 1 or ny % 1 or min(nx, ny) < 1 or not (dx > 0 and dz > 0 and (dy > 0 or ny == 1)):
        raise FileError(f"{path.name} states {nx:g} x {ny:g} points and holds {len(z)}, or a scale is not positive: damaged or cut")
    heights = np.reshape(z, (int(ny), int(nx))) * dz
    return heights if ny > 1 else heights[0], (dy if ny > 1 else dx, dx), []


def _profile(path, x, heights, lateral, height, spacing, notes):
    """A line scan over positions [unit] that rise; points that are not equidistant are interpolated."""
    if x is None:
        step = roughness._spacing(spacing)[0]
    else:
        x = x * lateral
        step = (x[-1] - x[0]) / max(x.size - 1, 1)
        if not (np.diff(x) > 0).all() or x.size < 2:
            raise FileError(f"{path.name}: its positions do not rise, or are less than two")
        uneven = np.max(abs(np.diff(x) - step)) / step
        if uneven > UNEVEN:
            even = x[0] + step * np.arange(x.size)
            heights = np.interp(even, x, heights)
            notes.append(f"points up to {100 * uneven:.0f} % off equidistance: interpolated, the shortest lags are smoothed")
    return heights * height, (float(step), float(step)), notes


HEADER = struct.Struct("<8s10s12s12sHHddddBBB")  # ISO 25178-71: version, maker, dates, points, rows, scales, kinds
_NUMBERS = {0: "u1", 1: "<u2", 2: "<u4", 3: "<f4", 4: "i1", 5: "<i2", 6: "<i4", 7: "<f8"}
_HOLES = {1: 2**16 - 1, 2: 2**32 - 1, 5: -2**15, 6: -2**31}  # 8-bit numbers have no mark for a hole


def _load(path):
    """Read what `save` wrote, and other binary SDF files."""
    try:
        with open(path, "rb") as file:
            *_, nx, ny, dx, dy, dz, _, packed, kind, _ = HEADER.unpack(file.read(HEADER.size))
            if nx * ny * np.dtype(_NUMBERS[kind]).itemsize > path.stat().st_size - HEADER.size:
                raise ValueError(f"it states {nx} x {ny} heights of kind {kind}, more than its bytes hold")
            z = np.fromfile(file, _NUMBERS[kind], nx * ny).reshape(ny, nx)
    except (struct.error, KeyError, ValueError) as e:
        raise FileError(f"{path.name} is a damaged or cut surface data file (ISO 25178-71): {e}") from e
    if packed or min(nx, ny) < 1 or not (dx > 0 and dz > 0 and (dy > 0 or ny == 1)):
        raise FileError(f"{path.name}: compressed heights, or sizes or scales that are not positive")
    with np.errstate(over="ignore"):
        heights = z * dz
    if kind in _HOLES:
        heights[z == _HOLES[kind]] = np.nan
    return heights if ny > 1 else heights[0], (dy if ny > 1 else dx, dx), []


