# SPDX-License-Identifier: GPL-3.0-or-later
"""3-D picture of the deformed cup and the contact pressure (needs PyVista: pip install 'hdengine[report]')."""
from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .._check import input_file
from .._engine import FileError
from .._types import PathLike
from ..files import write_files
from .run import pressure_top

if TYPE_CHECKING:
    from ..results import Result

__all__: list[str] = []


class PictureError(Exception):
    """The picture cannot be made here; the message says why."""


def _last(folder, stem):
    """Grid of the highest step."""
    found = sorted(folder.glob(f"{stem}_*.vtu"), key=lambda p: int(re.findall(r"\d+", p.name)[-1]))
    if not found:
        raise PictureError(f"the run has no {stem}_*.vtu: set output.vtu = 'last'")
    return found[-1]


def draw_cup(result: Result, path: PathLike, size: tuple = (1400, 1000)) -> float:
    """Write a PNG of the cup cut open along its axis, deformed, with the contact pressure on the ring.

    Parameters
    ----------
    result : Result
    path : str or Path
        PNG.
    size : tuple
        Pixels.

    Returns
    -------
    float
        The scale used.

    Raises
    ------
    PictureError
        PyVista is not installed, or the run wrote no grids.
    """
    bodies, contact = _last(result.folder, "bodies"), _last(result.folder, "contact")
    try:
        import pyvista
    except ImportError:
        raise PictureError("PyVista is not installed: pip install 'hdengine[report]'") from None
    try:
        grid, face = (pyvista.read(input_file(path)) for path in (bodies, contact))
    except FileError:
        raise
    except Exception as e:
        raise FileError(f"'{bodies}' cannot be read: {e}") from None
    largest = np.linalg.norm(grid["displacement_m"], axis=1).max()
    scale = float(f"{0.1 * result.scene['geometry.bore_radius'] / largest:.1g}") if largest > 0 else 1.0
    for part in (grid, face):
        part.points = 1e3 * (part.points + scale * part["displacement_m"])
    cup = grid.extract_cells(np.flatnonzero(grid["body"] == 2)).extract_surface(algorithm="dataset_surface")
    pressure = face["pressure_pa"] / 1e6
    face["contact pressure / MPa"] = np.where(pressure > 0, pressure, np.nan)
    pyvista.vtk_verbosity("off") if hasattr(pyvista, "vtk_verbosity") else None
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    plotter.add_mesh(cup.clip("-y", origin=(0, 0, 0)), color="lightsteelblue", opacity=0.55, ambient=0.3)
    plotter.add_mesh(face, scalars="contact pressure / MPa", cmap="viridis", nan_color="gainsboro", ambient=0.6,
                     diffuse=0.4, above_color="gold",
                     clim=(0, pressure_top(result)),
                     scalar_bar_args={"color": "black", "above_label": "more", "title": "contact pressure / MPa\n",
                                      "title_font_size": 28, "label_font_size": 24, "fmt": "%.0f"})
    plotter.add_text(f"displacements x {scale:g}", color="black", font_size=14, position="upper_left")
    plotter.camera_position = [(35, -75, -45), (0, 0, 7), (0, 0, -1)]
    plotter.camera.zoom(1.15)
    write_files({Path(path): lambda made: plotter.screenshot(str(made))})
    plotter.close()
    return scale
