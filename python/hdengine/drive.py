# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole drive of a size and a ratio as it is built, from one table of stated inputs; none is fitted to a catalogue.

Sources and ranges: docs/explain/drive.md, inputs. Lengths that are not known of a size are those of size 14 times size/14.
"""
from __future__ import annotations

import argparse
import re
import shlex
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from . import _engine
from ._check import checked, flag, integer
from ._engine import InputError
from ._types import Value
from .catalogue import UNITS, rated_torque
from .contact import given_keys, read_scene, run
from .files import check_file, write_files
from .teeth.pairs import tooth_gaps
from .teeth.profile import Involute

if TYPE_CHECKING:
    from ._keys import SceneKeys

__all__ = ["as_built"]
RATIOS = (30, 200)  # of strain wave gears with two lobes: below, the teeth are too high to be bent in; above, too fine
TOOTH = 1.4e10    # stiffness of a pair of teeth over the width that touches (ISO 6336) [N/m2]
DIAPHRAGM = 0.002  # thickness by radius squared, over the pitch diameter cubed (EP 1 628 045: 0.0014 to 0.0026)
WALL = 0.36e-3   # of size 14 [m]
RIM = 0.427 / 0.36   # thickness of the rim over that of the wall, for the teeth's stiffness
BEARINGS = ((35e-3, 6e-3), (42e-3, 7e-3), (62e-3, 9e-3))    # outer diameters and widths of flexible bearings [m]
# of two faces ground to Ra 0.4 um, with the cut-offs of ISO 3274 and ISO 4288; D of machined steel
GROUND = {"fractal_dimension": 2.3, "roughness": 2.977e-13, "sample_length": 0.8e-3, "shortest_wavelength": 2.5e-6}
RINGS = ((14, 5e-3), (20, 6e-3), (25, 8e-3), (32, 10e-3), (40, 13e-3))  # sizes and widths of either ring of flat gears [m]
SHORT = re.compile(r"[-+.\d\s,eEdD]+|\.?(true|false)\.?", re.IGNORECASE)  # a value that a namelist takes without quotes


class Known(NamedTuple):
    """What is known of a size."""

    torque: float           # of the loop, rated at ratio 100 or 1.15 T2, so that it reaches K3 [N m]
    spline: float = 0.0     # outer diameter of the circular spline [mm]; 0: in proportion to size 20
    clamp: float = 0.0      # half the screws' circle of a cup and half a screw head [mm]; 0: likewise
    flange: float = 0.0     # half that of a compact hat less half a head [mm]; 0: likewise


KNOWN = {11: Known(5), 14: Known(7.8, 50, 11.25, 24.25), 17: Known(24, 60, 13.25, 30.25), 20: Known(40, 70, 15.5, 35.25),
         25: Known(67, 85, 19.25, 44.5), 32: Known(137, 110, 25.5, 57.75), 40: Known(265, 135, 30.5, 71), 45: Known(353, flange=80),
         50: Known(470, flange=88.5), 58: Known(696, flange=102.5), 65: Known(951), 80: Known(1800), 90: Known(2590)}


def _width(of, known):
    """By a table of sizes and widths [m]: between those that are known by the line, beyond them in proportion."""
    sizes, widths = zip(*known, strict=True)
    near = min(max(of, sizes[0]), sizes[-1])
    return float(np.interp(near, sizes, widths)) * of / near


def _pressure_angle(ratio):
    """Of the teeth, from a maker's formula of the axial force [deg]."""
    return 20 if ratio >= 80 else 30 if ratio >= 50 else 32


def _bodies(size, ratio, hat):
    """Groups &geometry and &cup. Below ratio 50, where w is larger, wall, rim and ring are thinner, so that the stress of bending
    them to the cam, E w t / r^2, stays at that of ratio 50."""
    s, thin = size / 14, min(1, ratio / 50)
    bore, rim = 17.5e-3 * s, 9e-3 * s
    width = _width(2 * bore, BEARINGS)
    geometry = {"bore_radius": bore, "rim_length": rim, "ring_thickness": 1e-3 * s * thin, "band_start": (rim - width) / 2,
                "band_length": width}
    if hat:
        flange = np.linspace(bore + 2e-3 * s, KNOWN[size].flange * 1e-3 or 35.25e-3 * size / 20, 3)
        return geometry, {
            "sections_r": [bore] * 4 + flange.tolist(), "sections_z": [x * s for x in (0, 9e-3, 10e-3, *[20e-3] * 4)],
            "sections_thickness": [x * s * thin for x in (0.427e-3, 0.427e-3, 0.36e-3, 0.36e-3)]
            + (DIAPHRAGM * (2.54e-3 * size) ** 3 / flange ** 2).tolist(),
            "sections_fillet": [0, 0, 0, 1.5e-3 * s, 0, 0, 0]}
    return geometry | {
        "wall_thickness": WALL * s * thin, "rim_thickness": RIM * WALL * s * thin, "rim_taper": 1e-3 * s, "cup_length": 20e-3 * s,
        "bottom_thickness": 0.5e-3 * s, "hub_radius": KNOWN[size].clamp * 1e-3 or 15.5e-3 * size / 20}, {}


def _rounded(value):
    """Six digits, as a file has them."""
    if isinstance(value, list):
        return [_rounded(v) for v in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value


def _scene(size, ratio, hat):
    """Keys of a drive but for the clearances of its teeth, group by group."""
    s, unit, known = size / 14, UNITS[size], KNOWN[size]
    geometry, cup = _bodies(size, ratio, hat)
    breadth = (geometry["rim_length"] + _width(size, RINGS)) / 2
    groups: dict[str, dict[str, Any]] = {
        "run": {"title": f"whole drive, size {size}, ratio {ratio}" + (", silk hat" if hat else "")},
        "geometry": geometry, "cup": cup, "mesh": {"divisions": 86, "band_facets": 10},
        "wave_generator": {"w": 0.2e-3 * s * 100 / ratio, "cam": "cosine",
                           "clearance": float(_engine.call("fit_clearance", geometry["bore_radius"]))},
        "bearing": {"balls": 21, "ball_diameter": 3.2e-3 * s, "clearance": float(_engine.call(
            "ball_clearance", geometry["bore_radius"], geometry["ring_thickness"], 3.2e-3 * s))}, "contact": {"friction": 0.1},
        "load": {"support": "drive", "torque": known.torque, "torque_steps": 10, "teeth": 2 * ratio,
                 "tooth_pairs": 2 * round(0.2 * ratio), "pressure_angle_deg": _pressure_angle(ratio),
                 "tooth_stiffness": TOOTH * breadth,
                 "spline_diameter": known.spline * 1e-3 or 70e-3 * size / 20, "spline_width": breadth}, "joint": GROUND,
        "loop": {"torque_1": unit.t1_nm, "torque_2": unit.t2_nm, "rated_torque": rated_torque(size, ratio)}}
    return {group: {key: _rounded(value) for key, value in keys.items()} for group, keys in groups.items()}


def _gaps(groups, size, ratio):
    """Clearances of the teeth and roots of the circular spline's: an involute rack of 20 degrees on the assembled rim, where the
    closest pair just touches."""
    module = 2.54e-3 * size / (2 * ratio)
    assembly = groups | {"loop": {"torques": "0,0"}, "load": groups["load"] | {"torque_steps": 1}, "run": {"band": False},
                         "turning": {}, "output": {"vtu": "last"}}
    with tempfile.TemporaryDirectory() as folder:
        run("", f"{folder}/rim", show=False, **cast("SceneKeys", assembly))
        keys = tooth_gaps(Involute(module=module), f"{folder}/rim").keys()
    return {key: keys[f"load.{key}"] for key in ("tooth_gaps", "tooth_gaps_back", "spline_root_diameter")}


@checked(size=integer(), ratio=integer(least=RATIOS[0], most=RATIOS[1]), hat=flag)
def as_built(size: int, ratio: int = 100, hat: bool = False, **keys: Value) -> dict:
    """The whole drive of a size and a ratio: fit, balls, ring, contact, cup, teeth and circular spline, over the loop of a bench.

    The assembly is solved once, for the clearances of the teeth are those on the bent rim.

    Parameters
    ----------
    size : int
        11, 14, 17, 20, 25, 32, 40, 45, 50, 58, 65, 80 or 90: pitch diameter of the flexspline in tenths of an inch.
    ratio : int
        30 to 200; half the teeth of the flexspline.
    hat : bool
        A silk hat in place of the cup.
    **keys
        What you know better, as in `run`: `geometry={"wall_thickness": 0.5e-3}`. All other keys stay those of the size.

    Returns
    -------
    dict
        Keys of the scene by group, for `run(**scene)`.

    Raises
    ------
    InputError
        No such size; a key that is none, or out of its range.
    NotConvergedError
        The assembly of these keys.

    Examples
    --------
    >>> scene = as_built(20, 120, mesh={"divisions": 32, "band_facets": 4})
    >>> scene["load"]["teeth"]
    240
    """
    if size not in KNOWN:
        raise InputError(f"size = {size}: must be one of {', '.join(map(str, KNOWN))}")
    groups = _scene(size, ratio, hat)
    given: dict[str, dict[str, Any]] = {}
    for name, value in keys.items():
        group, _, key = name.lower().replace("__", ".", 1).partition(".")
        given.setdefault(group, {}).update({k.lower(): v for k, v in value.items()} if isinstance(value, dict) else {key: value})
    if "interference" in given.get("wave_generator", {}):
        del groups["wave_generator"]["clearance"]
    for group, known in given.items():
        groups[group] = groups.get(group, {}) | known
    if "wall_thickness" in given.get("geometry", {}) and "rim_thickness" not in given["geometry"] and not hat:
        wall = read_scene("", geometry__wall_thickness=given["geometry"]["wall_thickness"])["geometry.wall_thickness"]
        groups["geometry"]["rim_thickness"] = RIM * wall
    scene = read_scene("", **cast("SceneKeys", groups))
    if not _engine.supported(scene, "loop"):
        raise InputError(f"load.support = '{scene['load.support']}': must be 'drive', as this is a whole drive")
    if scene["load.teeth"] != 2 * ratio:
        raise InputError(f"load.teeth = {scene['load.teeth']} with ratio = {ratio}: must be twice that; give the ratio alone")
    if not groups["load"].keys() & {"tooth_gaps", "tooth_clearance"}:
        groups["load"] |= _gaps(groups, size, ratio)
    return {group: members for group, members in groups.items() if members}


def _namelist(groups):
    """Text of a scene."""
    def value(x):
        if isinstance(x, (list, tuple)):
            return ", ".join(map(value, x))
        if isinstance(x, str):
            return x if SHORT.fullmatch(x) else "'" + x.replace("'", "''") + "'"
        return f"{x:.6g}"
    return "".join(f"&{group}\n" + "".join(f"  {key} = {value(x)}\n" for key, x in keys.items()) + "/\n"
                   for group, keys in groups.items())


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("size", type=int, choices=tuple(KNOWN), metavar="size", help=f"one of {', '.join(map(str, KNOWN))}")
    parser.add_argument("assignments", nargs="*", metavar="group.key=value", help="what you know better of your drive")
    parser.add_argument("--ratio", type=int, default=100, help="half the teeth of the flexspline (default: 100)")
    parser.add_argument("--hat", action="store_true", help="a silk hat in place of the cup")
    parser.add_argument("--out", help="file (default: drive and the size, as drive20.nml, drive20_50.nml or drive20_hat.nml)")
    parser.add_argument("--force", action="store_true", help="replace an earlier file")


def write_drive(args: argparse.Namespace) -> int:
    """Write the namelist of a drive; returns 0."""
    name = f"drive{args.size}" + (f"_{args.ratio}" if args.ratio != 100 else "") + ("_hat" if args.hat else "")
    path = Path(args.out or f"{name}.nml")
    check_file(path, args.force)
    groups = as_built(args.size, args.ratio, args.hat, **given_keys(args.assignments))
    whole = f"Whole drive of size {args.size}, ratio {args.ratio}" + ", silk hat" * args.hat
    made = " ".join(["hdengine", "new", str(args.size), *["--ratio", str(args.ratio)] * (args.ratio != 100), *["--hat"] * args.hat,
                     *(shlex.quote(word) for text in args.assignments for word in text.splitlines())])
    head = f"""\
! {whole}, as it is built: fit, balls, ring, contact with friction, cup, teeth
! and circular spline, over the loop that a bench measures (docs/explain/drive.md). Made by '{made}' from one
! table of stated inputs. Every key and its default: hdengine.x --explain all. All values in SI units.
&hd_input
  version = 1
/
"""
    write_files({path: head + _namelist(groups)})
    print(f"written: {path}; solve it with hdengine.x {path}")
    return 0
