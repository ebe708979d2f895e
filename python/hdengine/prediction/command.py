# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `hdengine joint`."""
from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from .._engine import InputError
from ..files import check_folder
from ..surfaces.command import add_reading, read_maps
from .bodies import Bodies
from .law import FILES, PATCHES, PRESSURES, predict
from .spectrum import SMALLEST

MOST_POINTS = 4096   # a side: boundary elements take hours beyond

__all__: list[str] = []


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    b = Bodies()
    parser.add_argument("maps", nargs="+", metavar="MAP",
                        help="one or two height maps: .sdf, .npy (with --dx), or what SurfaceTopography reads")
    add_reading(parser)
    parser.add_argument("--model", choices=("spectrum", "boundary_elements"), help="default: by the surface, the reason is said")
    parser.add_argument("--patch", choices=PATCHES, default=PATCHES[0],
                        help="boundary elements: the map goes on evenly, or nothing touches outside it (asks for them)")
    parser.add_argument("--pressure", metavar="P1,P2,...", help="rising pressures [Pa] (default: 1 to 500 MPa)")
    parser.add_argument("--longest", type=float, default=np.inf, help="longest wavelength that counts as roughness [m]")
    parser.add_argument("--loaded-area", type=float, metavar="A",
                        help="area of the contact that the band stands for [m^2] (default: that of the map)")
    parser.add_argument("--e1", type=float, default=b.e1, help="Young's modulus of the first body [Pa]")
    parser.add_argument("--nu1", type=float, default=b.nu1, help="its Poisson's ratio")
    parser.add_argument("--e2", type=float, default=b.e2, help="Young's modulus of the second body [Pa]")
    parser.add_argument("--nu2", type=float, default=b.nu2, help="its Poisson's ratio")
    parser.add_argument("--hardness", type=float, default=b.hardness, help="of the softer body [Pa]")
    parser.add_argument("--points", type=int, default=256, help="boundary elements: points a side of the map after averaging")
    parser.add_argument("--seconds", type=float, metavar="S",
                        help="most that boundary elements may take: fewer points, then the theory (default: 120; no bound "
                        "where --model or --patch asks for them)")
    parser.add_argument("--out", default="joint.out", help="folder for joint.csv, spectrum.csv, joint.json, joint.png")
    parser.add_argument("--force", action="store_true", help="replace earlier results")


def _say(text, replaces):
    """A line on stderr; one that replaces another is written at a terminal only."""
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="" if replaces else "\n", file=sys.stderr, flush=True)
    elif not replaces:
        print(text, file=sys.stderr, flush=True)


def run_joint(args: argparse.Namespace) -> int:
    """Read, predict, write, print; returns 0."""
    if len(args.maps) > 2:
        raise InputError(f"a joint has one or two maps, got {len(args.maps)}")
    pressure = list(PRESSURES)
    if args.pressure is not None:
        try:
            pressure = [float(x) for x in args.pressure.split(",")]
        except ValueError:
            raise InputError(f"--pressure {args.pressure}: numbers in Pa joined by commas, as 10e6,50e6") from None
    for name in ("longest", "seconds", "loaded_area", "e1", "e2", "hardness"):
        value = getattr(args, name)
        if value is not None and not value > 0:
            raise InputError(f"--{name.replace('_', '-')} {value:g}: valid: above 0")
    for name in ("nu1", "nu2"):
        if not -1 < getattr(args, name) < 0.5:
            raise InputError(f"--{name} {getattr(args, name):g}: valid: between -1 and 0.5")
    if not SMALLEST <= args.points <= MOST_POINTS:
        raise InputError(f"--points {args.points}: valid: {SMALLEST} to {MOST_POINTS}")
    check_folder(args.out, FILES, args.force)
    seconds = args.seconds or (np.inf if args.model or args.patch == "free" else 120.0)
    maps = read_maps(args.maps, args)
    for path, s in zip(args.maps, maps):
        if s.heights.ndim != 2:
            raise InputError(f"{Path(path).name} holds a profile of {s.heights.size} points; valid: a map, numbers in two "
                             "dimensions")
    found = predict(*maps, pressure=pressure, model=args.model, longest=args.longest, points=args.points, seconds=seconds,
                    loaded=args.loaded_area, patch=args.patch, say=_say,
                    bodies=Bodies(args.e1, args.nu1, args.e2, args.nu2, args.hardness))
    print(found)
    for s in maps:
        print("".join(f"  {s.name}: {note}\n" for note in s.notes), end="")
    for path in found.write(args.out, args.force):
        print(f"written: {path}")
    return 0
