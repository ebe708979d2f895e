# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh, load steps, time and memory for a tolerance, as hdengine.x --plan tells them."""
from __future__ import annotations

from .. import _engine
from .._check import checked, input_file, mapping, number
from .._check import path as a_path
from .._types import PathLike, Value
from ..contact import _assignments, read_scene
from .study import Study

__all__ = ["plan"]
TOLERANCE = 0.1  # where the scene names none


def _keys(name, value):
    """A rule: keys, or None."""
    return value if value is None else mapping(name, value)


@checked(path=a_path, tolerance=number(above=0, below=1, optional=True), keys=_keys)
def plan(path: PathLike, tolerance: float | None = None, keys: dict | None = None) -> str:
    """The planner's text for a scene, or for the first point of a study; only coarse meshes are solved for it.

    Parameters
    ----------
    path : str or Path
        Namelist of a scene, or a study.
    tolerance : float, optional
        Relative error wanted of tangent K_TS, rotation, normal force and mid-band pressure; default: that of the scene, else 0.1.
    keys : dict, optional
        'group.key' to value, as on the command line.

    Returns
    -------
    str

    Raises
    ------
    InputError, FileError
        The input is not valid or cannot be read.
    """
    file, keys = input_file(path), dict(keys or {})
    head = ""
    if file.suffix.lower() == ".toml":
        study = Study.read(path)
        head = f"{len(study.points)} points; the first of them:\n"
        path, keys = study.scene, {**study.fixed, **study.points[0], **keys}
    scene = read_scene(str(path), **keys)
    if tolerance is None and not scene["run.tolerance"] > 0:
        tolerance = TOLERANCE
    if tolerance is not None:
        keys["run.tolerance"] = tolerance
    text = _engine.call_text("scene_text", str(path), "\n".join(_assignments(keys)), 1)
    return head + text


def mesh_of_level(level: int, path: PathLike | None = "", **keys: Value) -> dict:
    """Mesh of the planner's series for a scene: from level to level about 2^(1/2) finer in all directions.

    Parameters
    ----------
    level : int
        1 to 13; plans use 1 to 10.
    path : str, optional
        Namelist; default: the default scene.
    **keys
        As for Run.

    Returns
    -------
    dict
        The keys mesh.divisions and mesh.band_facets.

    Raises
    ------
    InputError
        No such level, mistakes of the input.
    """
    divisions, facets = _engine.call("series_mesh", str(path), "\n".join(_assignments(keys)) or " ", level)
    return {"mesh.divisions": int(divisions), "mesh.band_facets": int(facets)}
