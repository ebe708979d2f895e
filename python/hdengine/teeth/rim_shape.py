# SPDX-License-Identifier: GPL-3.0-or-later
"""The rim as a run has deformed it, from the grids that the run wrote."""
from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._check import ROUNDING, input_file
from .._engine import FileError, InputError
from .._types import PathLike

__all__: list[str] = []
ON = 1e-6   # of the radius, by which nodes lie on a surface


def tooth_ends(scene: dict) -> tuple[float, float]:
    """Places along the axis between which teeth touch: the width of the circular spline, amid the rim [m]."""
    rim, width = scene["geometry.rim_length"], scene["load.spline_width"]
    width = min(width or rim, rim)
    return (rim - width) / 2, (rim + width) / 2


def row_weights(heights: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """Integrals over a length of the axis of the functions that are 1 on one row of nodes and fall linearly to 0 on the next.

    Parameters
    ----------
    heights : ndarray (rows,)
        Rising places of the rows.
    ends : (float, float)
        Where the length begins and ends, in the unit of the heights.

    Returns
    -------
    ndarray (rows,)
        Their sum is the length.
    """
    z = np.clip(np.union1d(heights, ends), *ends)
    shape = np.array([np.interp(z, heights, row) for row in np.eye(len(heights))])
    return (shape[:, 1:] + shape[:, :-1]) / 2 @ np.diff(z)


def read_grid(path: PathLike, *names: str) -> dict:
    """Arrays and numbers of a grid that the engine wrote.

    Parameters
    ----------
    path : path-like
        bodies_*.vtu.
    *names : str
        Arrays, as 'Points' and 'displacement_m'.

    Returns
    -------
    dict
        Arrays (points, components) by their names, and the numbers that stand in the head ('torque_nm').

    Raises
    ------
    FileError
        It is cut short, or no grid of the engine.
    """
    raw = input_file(path).read_bytes()
    head, found, rest = raw.partition(b'<AppendedData encoding="raw">\n_')
    text = head.decode("ascii", "replace")
    out: dict = {name: float(value) for name, value in re.findall(r'Name="(\w+)" NumberOfTuples="1" format="ascii">([^<]+)<', text)}
    for name in names:
        place = re.search(rf'type="Float64" Name="{name}" NumberOfComponents="(\d+)" format="appended" offset="(\d+)"', text)
        if not found or not place:
            raise FileError(f"'{path}' has no array {name}: a grid that hdengine wrote is needed")
        components, at = map(int, place.groups())
        size = int.from_bytes(rest[at:at + 8], "little")
        if len(rest) < at + 8 + size:
            raise FileError(f"'{path}' is cut short: run the scene again")
        out[name] = np.frombuffer(rest, "<f8", size // 8, at + 8).reshape(-1, components)
    return out


@dataclass(frozen=True)
class RimShape:
    """Deformed outside of the rim: mean over what touches the teeth, between the meridians of the mesh by harmonics.

    Parameters
    ----------
    radius : float
        At rest [m].
    harmonics : ndarray (2, n)
        Coefficients c_k of u_r and u_theta over the angle at rest, c_0 + 2 Re sum c_k exp(i k theta) [m].
    """

    radius: float
    harmonics: np.ndarray = field(repr=False)

    @classmethod
    def read(cls, folder: PathLike, scene: dict, more: ArrayLike = 0) -> RimShape:
        """Shape at the end of the assembly.

        Parameters
        ----------
        folder : path-like
            Of a run.
        scene : dict
            Its keys.
        more : ndarray (2, n)
            u_r and u_theta at the meridians of the mesh that the run leaves out [m].

        Returns
        -------
        RimShape

        Raises
        ------
        InputError
            No grid of the run is without torque.
        FileError
            A grid cannot be read.
        """
        grids = sorted(Path(folder).glob("bodies_*.vtu"), key=lambda p: int(re.findall(r"\d+", p.name)[-1]))
        tried = []
        for path in grids:
            grid = read_grid(path, "Points", "displacement_m")
            tried.append(f"{grid.get('torque_nm', np.nan):g}")
            if grid.get("TimeValue", 0) >= 1 - ROUNDING and abs(grid.get("torque_nm", 1)) < ROUNDING:
                return cls._of(grid["Points"], grid["displacement_m"], scene, more)
        seen = f"grids at {', '.join(tried)} N m" if tried else "no bodies_*.vtu"
        raise InputError(f"'{folder}' has {seen}: must have one of the whole assembly at 0 N m; run it with loop.torques=0,0 "
                         "load.torque_steps=1 output.vtu=last (support 'drive'), or load.torque_steps=0")

    @classmethod
    def _of(cls, points, moved, scene, more) -> Any:
        """Mean over what of the rim's outside touches the teeth."""
        radius = scene["geometry.bore_radius"] + scene["geometry.rim_thickness"]
        r, turn = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0]) % (2 * np.pi)
        on = np.flatnonzero((abs(r - radius) < ON * radius) & (points[:, 2] <= scene["geometry.rim_length"] * (1 + ROUNDING)))
        sectors = scene["mesh.divisions"]
        step = np.round(turn[on] * sectors / (2 * np.pi), 6)
        on, step = on[step % 1 == 0], step[step % 1 == 0].astype(int) % sectors    # not the middles of quadratic elements
        heights = np.unique(np.round(points[on, 2], 9))
        if len(on) != sectors * len(heights) or len(heights) < 2:
            raise InputError(f"the rim of the run has {len(on)} nodes on {len(heights)} rows of {sectors} at {radius:.6g} m: must "
                             "be whole rows of a pressed cup (wave_generator.shape = 'pressed')")
        row = np.searchsorted(heights, points[on, 2] - ROUNDING)
        low, high = tooth_ends(scene)
        share = row_weights(heights, (low, min(high, heights[-1])))    # the rim may end within a facet
        share = (share / share.sum())[row]
        c, s = np.cos(turn[on]), np.sin(turn[on])
        u = moved[on]
        mean = [np.bincount(step, share * part, sectors) for part in (c * u[:, 0] + s * u[:, 1], c * u[:, 1] - s * u[:, 0])]
        harmonics = np.fft.rfft(np.add(mean, more), axis=1) / sectors
        if sectors % 2 == 0:
            harmonics[:, -1] /= 2      # counts once, others for two signs
        return cls(radius, harmonics)

    def poses(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points of the deformed outside and its normals, as `Rim.poses` has them."""
        k = np.arange(self.harmonics.shape[1])
        weight = np.where(k == 0, 1, 2) * np.exp(1j * np.outer(theta, k))
        u, v = (np.real(weight @ h) for h in self.harmonics)
        du, dv = (np.real(weight @ (1j * k * h)) for h in self.harmonics)
        out, along = self.radius + u, np.stack([du - v, self.radius + u + dv])       # of the polar axes
        c, s = np.cos(theta), np.sin(theta)
        points = np.stack([c * out - s * v, s * out + c * v])
        normals = np.stack([c * along[1] + s * along[0], s * along[1] - c * along[0]]) / np.hypot(*along)
        return points, normals
