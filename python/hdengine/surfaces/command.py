# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `hdengine surface`."""
from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from .._engine import InputError
from ..files import check_folder
from . import composite, folder, form, roughness, specimen, texture

__all__: list[str] = []


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("files", nargs="+", help="SDF files (ISO 25178-71), or any that SurfaceTopography reads")
    parser.add_argument("--pair", action="store_true", help="also the equivalent surface of two files, S_1 + S_2")
    add_reading(parser)
    parser.add_argument("--lags", type=int, nargs=2, metavar=("FIRST", "LAST"), help="window in points")
    parser.add_argument("--noise", default="0", help="rms of white instrument noise [m], or 'fit'")
    parser.add_argument("--model", choices=("spectrum", "ridges", "paper"), help="default: by what is known")
    parser.add_argument("--ridges", metavar="L,L_s,M,gamma", help="the surfaces are sums of Eq. 1 with these numbers")
    parser.add_argument("--form", default="plane", help="form taken off first: none, plane, poly2 to poly8, or cylinder (rings)")
    parser.add_argument("--s-filter", type=float, metavar="M", help="nesting index of the S-filter of the areal numbers [m]")
    parser.add_argument("--l-filter", type=float, metavar="M", help="nesting index of their L-filter [m]")
    parser.add_argument("--outliers", action="store_true",
                        help="areal numbers without single wrong points (the fit masks them too)")
    parser.add_argument("--seams", action="store_true",
                        help="areal numbers with the tiles between steps of stitching levelled (the fit levels them too)")
    parser.add_argument("--fill", action="store_true", help="areal numbers with holes filled (the fit fills them too)")
    parser.add_argument("--out", help="folder for surface.json, tables, scene.nml and figures (default: the "
                        "first file's stem.out)")
    parser.add_argument("--force", action="store_true", help="replace earlier results")


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Options of commands that read height maps."""
    parser.add_argument("--unit", help="unit of those maps that state none: um, or lateral,height: mm,um; heights of .npy (else m)")
    parser.add_argument("--dx", "--spacing", type=float, help="spacing of those maps that state no size, as .npy [m]")
    parser.add_argument("--dy", type=float, help="spacing along the columns, if it differs from --dx [m]")


def read_maps(paths: list, args: argparse.Namespace) -> list:
    """Maps and profiles of files. The unit and spacing of the options go to those that do not state them.

    Parameters
    ----------
    paths : list of path-like
    args : Namespace
        Options of `add_reading`.

    Returns
    -------
    list of Specimen

    Raises
    ------
    InputError, FileError
        As `specimen.read`; a unit or a spacing that no file lacks.
    """
    unit = tuple(args.unit.split(",")) if args.unit and "," in args.unit else args.unit
    for word in (unit,) if isinstance(unit, str) else unit or ():
        if word not in specimen.METRES or len(unit) > 2 and not isinstance(unit, str):
            raise InputError(f"--unit {args.unit}: valid: {', '.join(specimen.METRES)}, or two as lateral,height")
    for name in ("dx", "dy"):
        value = getattr(args, name)
        if value is not None and not 0 < value < np.inf:
            raise InputError(f"--{name} {value:g}: valid: above 0")
    if args.dy and not args.dx:
        raise InputError(f"--dy {args.dy:g}: valid: with --dx")
    spacing = None if args.dx is None else (args.dy or args.dx, args.dx)
    offers = [(unit, spacing), (unit, None), (None, spacing), (None, None)]
    found, lacking = [], [offers[0]]
    for path in paths:
        refusal = None
        for offer in dict.fromkeys(offers):
            try:
                found.append(specimen.read(path, *offer))
                lacking.append(offer)
                break
            except InputError as why:
                refusal = refusal or why
        else:
            raise InputError(str(refusal).replace("spacing=", "--dx")) from None
    for i, option in enumerate(("--unit", "--dx")):
        if lacking[0][i] is not None and all(offer[i] is None for offer in lacking[1:]):
            stated = "its unit" if i == 0 else "its size"
            raise InputError(f"{' and '.join(Path(p).name for p in paths)} states {stated}: leave out {option}")
    return found


def run_surface(args: argparse.Namespace) -> int:
    """Read, fit, judge, write; returns 0."""
    known = None
    if args.ridges:
        try:
            length, shortest, count, gamma = (float(x) for x in args.ridges.split(","))
        except ValueError:
            raise InputError(f"--ridges {args.ridges}: four numbers L,L_s,M,gamma") from None
        known = roughness.Ridges(length, shortest, int(count), gamma)
    try:
        noise = args.noise if args.noise == "fit" else float(args.noise)
    except ValueError:
        raise InputError(f"--noise {args.noise}: rms in m, or fit") from None
    options = {"lags": args.lags, "noise": noise, "model": args.model, "surface": known}
    if args.pair and len(args.files) != 2:
        raise InputError(f"--pair takes two files, got {len(args.files)}")
    out = args.out or f"{Path(args.files[0]).stem or 'surface'}.out"
    specimens = read_maps(args.files, args)
    check_folder(out, folder.files_of(specimens, args.pair), args.force)
    textures = [texture.texture(s, form=args.form, s_filter=args.s_filter, l_filter=args.l_filter, outliers=args.outliers,
                                fill=args.fill, seams=args.seams)
                for s in specimens]
    if args.form != "plane":    # the fit takes the plane off itself, with what that does to the spectrum
        specimens = [form.remove(s, args.form).specimen for s in specimens]
    fits = [s.fit(**options) for s in specimens]
    for s, fit, areal in zip(specimens, fits, textures):
        print(f"{s.name}: {' x '.join(map(str, s.heights.shape))} points, {' x '.join(f'{1e3 * x:.4g}' for x in s.size)} mm")
        print("".join(f"  {note}\n" for note in s.notes) + f"{areal}\n{fit}\n")
    joint = None
    if args.pair:
        coarse = tuple(map(max, *(s.spacing for s in specimens)))
        pair = [s if np.allclose(s.spacing, coarse, rtol=1e-3) else composite.resample(s, coarse) for s in specimens]
        for s in (p for p in pair if "resampled" in p.notes):
            print(f"{s.name} resampled to {coarse[0]:.4g} x {coarse[1]:.4g} m")
        joint = specimen.equivalent(*pair, **options)
        print(f"equivalent surface of both\n{joint.equivalent}\n")
    for path in folder.write(out, specimens, fits, joint, args.files, args.force, textures):
        print(f"written: {path}")
    return 0
