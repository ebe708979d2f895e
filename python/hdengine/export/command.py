# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `hdengine export`."""
from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from .._check import RUN, checked, optional, word
from .._check import path as a_path
from .._types import PathLike
from ..files import write_files
from ..results import Result
from .deck import to_deck
from .fmu import to_fmu
from .formats import FORMATS
from .law import JointLaw, joint_law

__all__ = ["export"]
LAWS: dict[str, tuple[Callable[[JointLaw], str | bytes], str]] = {**FORMATS, "fmu": (to_fmu, ".fmu")}
KINDS = (*LAWS, "inp")


@checked(run=RUN, kind=word(*KINDS), path=optional(a_path))
def export(run: Result, kind: str, path: PathLike | None = None) -> Path:
    """Write a run for another program.

    Parameters
    ----------
    run : Result
    kind : str
        csv, mujoco, modelica, urdf-comment, fmu: torque over angle of a whole drive; inp: CalculiX deck of any run.
    path : str or Path, optional
        Default: joint with the format's suffix, or deck.inp, in the folder of the run.

    Returns
    -------
    Path

    Raises
    ------
    InputError, FileError
        No such kind; the run has no loop, or no grid; no C compiler for an FMU; the file cannot be written.
    """
    text: str | bytes
    if kind == "inp":
        text, name = to_deck(run), "deck.inp"
    else:
        write, suffix = LAWS[kind]
        text, name = write(joint_law(run)), f"joint{suffix}"
    path = Path(path) if path else run.folder / name
    write_files({path: text})
    return path


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("folder", help="folder of a run")
    parser.add_argument("--to", required=True, choices=KINDS,
                        help="torque over angle of a drive as a table, a MuJoCo or Modelica model, a comment for URDF, an FMU; "
                             "inp: CalculiX deck of any run")
    parser.add_argument("--out", help="file (default: in the folder of the run)")
