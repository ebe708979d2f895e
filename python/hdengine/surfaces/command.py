# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `hdengine surface`."""
from __future__ import annotations

from pathlib import Path
from typing import Any

from .._engine import InputError
from . import roughness, specimen


def add_options(parser: Any) -> None:
    """Options of the command."""
    parser.add_argument("files", nargs="+", help="SDF files (ISO 25178-71), or any that SurfaceTopography reads")
    parser.add_argument("--pair", action="store_true", help="also the equivalent surface of two files, S_1 + S_2")
    parser.add_argument("--unit", help="unit of files that state none: um, or lateral,height: mm,um")
    parser.add_argument("--spacing", type=float, help="distance of points [m] of files that state no size")
    parser.add_argument("--lags", type=int, nargs=2, default=(1, 20), metavar=("FIRST", "LAST"), help="window in points")
    parser.add_argument("--noise", default="0", help="rms of white instrument noise [m], or 'fit'")
    parser.add_argument("--model", choices=("isotropic", "profile", "ridges", "paper"), help="default: by what is known")
    parser.add_argument("--ridges", metavar="L,L_s,M,gamma", help="the surfaces are sums of Eq. 1 with these numbers")
    parser.add_argument("--out", default=".", help="folder for the figures")


def run_surface(args: Any) -> Any:
    """Read, fit, judge, plot; returns 0."""
    from ..figures.surface import plot_specimen

    unit = tuple(args.unit.split(",")) if args.unit and "," in args.unit else args.unit
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
    options = {"lags": tuple(args.lags), "noise": noise, "model": args.model, "surface": known}
    specimens = [specimen.read(f, unit, args.spacing) for f in args.files]
    out = Path(args.out)
    out.mkdir(parents=True, exist_ok=True)
    figures = {}
    fits = [s.fit(**options) for s in specimens]
    for s, fit in zip(specimens, fits):
        numbers = ", ".join(f"{k} {v:.4g}" for k, v in s.parameters().items() if k != "bandwidth_m")
        print(f"{s.name}: {' x '.join(map(str, s.heights.shape))} points, {' x '.join(f'{1e3 * x:.4g}' for x in s.size)} mm")
        print("".join(f"  {note}\n" for note in s.notes) + f"roughness {numbers}\n{fit}\n")
        figures[f"{s.name}.png"] = plot_specimen(s, fit)
    if args.pair:
        if len(specimens) != 2:
            raise InputError(f"--pair takes two files, got {len(specimens)}")
        joint = specimen.equivalent(*specimens, **options)
        print(f"equivalent surface of both\n{joint.equivalent}\n")
        figures["joint_surface.png"] = joint.plot()
    for name, figure in figures.items():
        figure.savefig(out / name)
        print(f"written: {out / name}")
    return 0
