# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh, load steps, time and memory for a tolerance, as hdengine.x --plan tells them."""
from pathlib import Path

from . import _engine
from ._engine import FileError
from .contact import _assignments, read_scene
from .study import Study

TOLERANCE = 0.1  # where the scene names none


def plan(path, tolerance=None, keys=None):
    """The planner's text for a scene, or for the first point of a study; only coarse meshes are solved for it.

    Parameters
    ----------
    path : str or Path
        Namelist of a scene or of a study.
    tolerance : float, optional
        Relative error wanted of K_TS, normal force and mid-band pressure; default: that of the scene, else 0.1.
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
    path, keys = Path(path), dict(keys or {})
    if not path.is_file():
        raise FileError(f"'{path}' cannot be read")
    head = ""
    text = path.read_text(encoding="utf-8", errors="replace")
    if "&study" in text or "&grid" in text:
        study = Study.read(path)
        head = f"{len(study.points)} points; the first of them:\n"
        path, keys = study.scene, {**study.fixed, **study.points[0], **keys}
    scene = read_scene(str(path), **keys)
    if tolerance is None and not scene["run.tolerance"] > 0:
        tolerance = TOLERANCE
    if tolerance is not None:
        keys["run.tolerance"] = tolerance
    text = _engine.call("scene_text", str(path), "\n".join(_assignments(keys)), 1)
    return head + text.decode().rstrip()
