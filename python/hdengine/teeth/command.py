# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `hdengine teeth`."""
from __future__ import annotations

import argparse
from dataclasses import fields
from pathlib import Path

from .._engine import InputError
from ..contact import given_keys
from ..files import check_folder
from .pairs import FILES, tooth_gaps
from .profile import DoubleArc, Involute

__all__: list[str] = []
PROFILES: dict[str, type] = {"involute": Involute, "double_arc": DoubleArc}
MEANING = {
    "module": "module [m]", "pressure_angle_deg": "of the rack [deg]",
    "x1": "profile shift of the flexspline (default: its root circle is the wall's outside)",
    "x2": "profile shift of the circular spline (default: the closest pair keeps --least-gap)",
    "addendum": "of the flexspline, over the module", "spline_addendum": "of the circular spline, over the module",
    "dedendum": "over the module", "convex_radius": "of the arc at the tip, over the module",
    "convex_x": "its centre beyond the tooth's centre line", "convex_y": "its centre below the pitch circle",
    "concave_radius": "of the arc at the root, over the module", "concave_x": "its centre beyond the middle of the space",
    "concave_y": "its centre above the pitch circle",
    "pitch_radius": "of the flexspline at rest [m] (default: its root circle is the wall's outside)"}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("input", help="namelist of the scene: its teeth, rim and wave generator; or folder of a run, whose rim is "
                        "taken")
    parser.add_argument("assignments", nargs="*", metavar="group.key=value", help="keys that differ from the file")
    parser.add_argument("--profile", choices=tuple(PROFILES), required=True, help="of the flexspline's teeth")
    for name, text in MEANING.items():
        owners = [word for word, kind in PROFILES.items() if name in {f.name for f in fields(kind)}]
        told = "" if len(owners) > 1 else f"{owners[0]}: "
        parser.add_argument(f"--{name.replace('_', '-')}", type=float, required=name == "module", metavar="X", help=told + text)
    parser.add_argument("--least-gap", type=float, metavar="X",
                        help="clearance of the closest pair of a turn [m] (default: 0)")
    parser.add_argument("--spline-teeth", type=int, metavar="N", help="of the circular spline (default: two more than load.teeth)")
    parser.add_argument("--out", help=f"folder for {', '.join(FILES)} (default: the input's stem.teeth)")
    parser.add_argument("--force", action="store_true", help="replace earlier results")


def run_teeth(args: argparse.Namespace) -> int:
    """Read, compute, write, print; returns 0."""
    kind = PROFILES[args.profile]
    given = {name: getattr(args, name) for name in MEANING if getattr(args, name) is not None}
    known = {f.name for f in fields(kind)}
    for name in given:
        if name not in known:
            raise InputError(f"--{name.replace('_', '-')} with --profile {args.profile}: valid: "
                             f"{', '.join('--' + n.replace('_', '-') for n in MEANING if n in known)}")
    out = args.out or f"{Path(args.input).stem or 'results'}.teeth"
    check_folder(out, FILES, args.force)
    found = tooth_gaps(kind(**given), args.input, least_gap=args.least_gap, spline_teeth=args.spline_teeth,
                       **given_keys(args.assignments))
    print(found)
    print(f"lines for the scene, under &load:\n{found.lines()}", end="")
    for path in found.write(out, args.force):
        print(f"written: {path}")
    return 0
