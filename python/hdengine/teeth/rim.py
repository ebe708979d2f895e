# SPDX-License-Identifier: GPL-3.0-or-later
"""Places of the flexspline's teeth on its deformed rim, and the spaces of the circular spline that they enter."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .._check import array, checked, fields, integer, kind, mapping
from .._check import path as a_path
from .._engine import InputError
from .._types import PathLike, Value
from ..contact import cam, read_scene
from .rim_shape import RimShape

__all__ = ["Rim"]
PROFILE = [f"wave_generator.{key}" for key in ("w", "cam", "cam_file", "lobes", "arc_angle_deg")]   # keys of a cam's curve


def _second_order(scene):
    """What the cam's curve has beyond its first order, on the outside of a rim that keeps its length: u_r and u_theta at the
    meridians of the mesh (2, n), of the size of w^2/R. A run of small displacements leaves it out [m]."""
    n, half = scene["mesh.divisions"], scene["geometry.rim_thickness"] / 2
    radius, theta = scene["geometry.bore_radius"] + half, 2 * np.pi * np.arange(n) / n
    ring = scene["geometry.ring_thickness"]
    found = cam(theta, "", **{"geometry.bore_radius": radius + ring, "geometry.ring_thickness": ring},
                **{key: scene[key] for key in PROFILE if scene[key]})
    u, v = np.fft.rfft(found.field, axis=1)
    turn = (v - 1j * np.arange(len(u)) * u) / radius
    first = np.fft.irfft([u, v + half * turn], n, axis=1)
    c, s = np.cos(theta), np.sin(theta)
    x, y = found.points + half * found.normal
    return np.stack([c * x + s * y - radius - half, c * y - s * x]) - first


@dataclass(frozen=True)
class Rim:
    """The deformed line on whose normals the teeth stand.

    It is the neutral line of the rim, the middle of its thickness, that keeps its length on the wave generator; or the rim's
    outside as a run has deformed it.

    Parameters
    ----------
    scene : dict
        Keys of the scene, as `read_scene` gives them.
    path : path-like
        Its namelist, for the table of a measured cam.
    keys : dict
        'group.key' to value that differ from it.
    shape : RimShape, optional
        Of a run.
    """

    scene: dict
    path: Any
    keys: dict
    shape: RimShape | None = None

    def __post_init__(self) -> None:
        fields(self, scene=mapping, path=a_path, keys=mapping, shape=kind(RimShape, optional=True))

    @classmethod
    @checked(path=a_path)
    def read(cls, path: PathLike, **keys: Value) -> Rim:
        """Rim of a scene, or of a run.

        Parameters
        ----------
        path : path-like
            Namelist, '' takes the defaults; or the folder of a run, with a grid of the assembly without torque.
        **keys
            Keys of the scene, as in `run`.

        Returns
        -------
        Rim

        Raises
        ------
        InputError, FileError
            A key, the table of a measured cam, or the run is not valid.
        """
        flat: dict = {}
        for name, value in keys.items():
            flat |= {f"{name}.{k}": v for k, v in value.items()} if isinstance(value, dict) else {name.replace("__", ".", 1): value}
        if not path or not Path(path).is_dir():
            return cls(read_scene(path, **flat), path, flat)
        barred = sorted(name for name in flat if name.split(".")[0] != "load")
        if barred:
            raise InputError(f"{barred[0]} with the run '{path}': its rim is that of the run; valid: keys of load")
        scene = read_scene(Path(path) / "echo.nml", **flat)
        more = 0 if scene["solver.kinematics"] == "nonlinear" else _second_order(scene)
        return cls(scene, path, flat, RimShape.read(path, scene, more))

    @property
    def radius(self) -> float:
        """Of the line at rest [m]."""
        if self.shape is not None:
            return self.shape.radius
        return self.scene["geometry.bore_radius"] + self.scene["geometry.rim_thickness"] / 2

    @property
    def root(self) -> float:
        """Outside of the wall, where the teeth begin [m]."""
        return self.scene["geometry.bore_radius"] + self.scene["geometry.wall_thickness"]

    @checked(theta=array((None,)))
    def poses(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points of the deformed line and its outward normals.

        Parameters
        ----------
        theta : ndarray (n,)
            Angles at rest from the long axis [rad].

        Returns
        -------
        points : ndarray (2, n)
            [m].
        normals : ndarray (2, n)
        """
        if self.shape is not None:
            return self.shape.poses(theta)
        found = cam(theta, self.path, **self.keys | {
            "wave_generator.shape": "pressed", "load.spline_root_diameter": 0.0,
            "geometry.bore_radius": self.radius + self.scene["geometry.ring_thickness"]})
        return found.points, found.normal

    @checked(flank=array((None, 2)), places=array((None,)), spaces=integer(1), side=integer(-1, 1), end=integer(0, 1))
    def flanks(self, flank: np.ndarray, places: np.ndarray, spaces: int, side: int = 1, end: int = 0) -> np.ndarray:
        """A tooth's flank at places of the rim, as the space sees it that the tooth enters.

        Parameters
        ----------
        flank : ndarray (m, 2)
            (s, r) of the tooth at rest [m].
        places : ndarray (n,)
            From the end of the long axis [tooth pitches].
        spaces : int
            Teeth of the circular spline.
        side : int
            1: the flank that a positive torque presses; -1: the other, mirrored.
        end : int
            0 or 1: which end of the long axis.

        Returns
        -------
        ndarray (n, m, 2)
            (s, r) in the space, s towards the flank's own side [m].
        """
        turn = 2 * np.pi * places
        points, normals = self.poses(turn / self.scene["load.teeth"] + end * np.pi)
        height, along = flank[:, 1] - self.radius, side * flank[:, 0]
        tangents = np.stack([-normals[1], normals[0]])
        x, y = points[:, :, None] + height * normals[:, :, None] + along * tangents[:, :, None]
        space = turn / spaces + end * np.pi
        c, s = np.cos(space)[:, None], np.sin(space)[:, None]
        return np.stack([side * (c * y - s * x), c * x + s * y], axis=-1)
