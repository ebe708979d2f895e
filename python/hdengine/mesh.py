# SPDX-License-Identifier: GPL-3.0-or-later
"""Hexahedral meshes for `hdengine.solid`: mapped blocks, joined where nodes meet, and their boundary facets."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ._check import array, checked, fields, flag, integers, number
from ._check import function as a_function
from ._engine import InputError

__all__ = ["Mesh", "block", "graded", "merge"]
_MOST = 1e8   # intervals of a line
_CORNERS = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]])
_EDGES = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]])
_FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])


def _middles():
    """Mid-side nodes of the faces, in the order of their sides."""
    number = {frozenset(e): 8 + i for i, e in enumerate(_EDGES.tolist())}
    return np.array([[number[frozenset((f[i], f[(i + 1) % 4]))] for i in range(4)] for f in _FACES.tolist()])


_SIDES = np.hstack([_FACES, _middles()])


@dataclass
class Mesh:
    """Nodes and cells.

    Parameters
    ----------
    points : ndarray (n, 3)
        Coordinates [m].
    cells : ndarray (m, 8) or (m, 20)
        Nodes of the cells from 0, in the order of VTK types 12 and 25.
    """

    points: np.ndarray
    cells: np.ndarray

    def __post_init__(self) -> None:
        fields(self, points=array((None, 3)), cells=integers((None, None)))
        if self.cells.shape[1] not in (8, 20):
            raise InputError(f"cells have {self.cells.shape[1]} nodes: must have 8 or 20")
        if self.cells.min() < 0 or self.cells.max() >= len(self.points):
            worst = self.cells.min() if self.cells.min() < 0 else self.cells.max()
            raise InputError(f"cells name node {worst}; valid: 0 to {len(self.points) - 1}")
        ordered = np.sort(self.cells, axis=1)
        twice = (ordered[:, 1:] == ordered[:, :-1]).any(1)
        if twice.any():
            raise InputError(f"cell {np.argmax(twice)} names a node twice")

    @property
    def quadratic(self) -> bool:
        """Whether the cells have mid-side nodes."""
        return self.cells.shape[1] == 20

    def facets(self, chosen: np.ndarray) -> np.ndarray:
        """Facets all of whose nodes are chosen.

        Parameters
        ----------
        chosen : ndarray of bool (n,)
            Nodes on the face.

        Returns
        -------
        ndarray (k, 4) or (k, 8)
            Nodes, corners in turn, then mid-sides.
        """
        try:
            chosen = np.asarray(chosen)
        except ValueError:  # a list of unlike lengths
            raise InputError("chosen is no array: must be true or false for each node") from None
        if chosen.shape != (len(self.points),) or chosen.dtype.kind != "b":
            raise InputError(f"chosen has shape {chosen.shape}, {chosen.dtype}: must be true or false for each of "
                             f"{len(self.points)} nodes")
        sides = _SIDES if self.quadratic else _FACES
        every = self.cells[:, sides].reshape(-1, sides.shape[1])
        return every[chosen[every].all(1)]

    @checked(function=a_function)
    def warp(self, function: Callable[[np.ndarray], ArrayLike]) -> Mesh:
        """The mesh with its points (n, 3) moved by a function."""
        return Mesh(function(self.points), self.cells)  # type: ignore[arg-type]  # checked there


def _ascending(name, value):
    """A rule: ascending coordinates."""
    a = array((None,))(name, value)
    if len(a) < 2 or not np.all(np.diff(a) > 0):
        raise InputError(f"{name}: must be two or more ascending coordinates [m]")
    return a


@checked(x=_ascending, y=_ascending, z=_ascending, quadratic=flag)
def block(x: ArrayLike, y: ArrayLike, z: ArrayLike, quadratic: bool = False) -> Mesh:
    """Block of cells between given coordinates.

    Parameters
    ----------
    x, y, z : array_like
        Ascending coordinates of the corner nodes [m].
    quadratic : bool
        Add mid-side nodes, halfway between the corners.

    Returns
    -------
    Mesh
    """
    corners = [np.asarray(c, float) for c in (x, y, z)]
    n = [len(c) - 1 for c in corners]
    fine = [np.interp(np.arange(2 * k + 1) / 2, np.arange(k + 1), c) for k, c in zip(n, corners)]
    index = np.stack(np.meshgrid(*(np.arange(2 * k + 1) for k in n), indexing="ij"), -1)
    odd = (index % 2).sum(-1)
    used = odd <= (1 if quadratic else 0)
    number = np.full(used.shape, -1)
    number[used] = np.arange(used.sum())
    points = np.stack([fine[d][index[used][:, d]] for d in range(3)], -1)
    local = np.vstack([_CORNERS, (_CORNERS[_EDGES[:, 0]] + _CORNERS[_EDGES[:, 1]]) // 2]) if quadratic else _CORNERS
    base = 2 * np.stack(np.meshgrid(*(np.arange(k) for k in n), indexing="ij"), -1).reshape(-1, 1, 3)
    at = base + local
    return Mesh(points, number[at[..., 0], at[..., 1], at[..., 2]])


@checked(tolerance=number(above=0, below=1))
def merge(*meshes: Mesh, tolerance: float = 1e-9) -> Mesh:
    """Join meshes where their nodes meet.

    Parameters
    ----------
    *meshes : Mesh
        Meshes of one cell type.
    tolerance : float
        Nodes closer than this share of the size are one.

    Returns
    -------
    Mesh
    """
    if not meshes or not all(isinstance(m, Mesh) for m in meshes) or len({m.quadratic for m in meshes}) > 1:
        raise InputError("merge takes one Mesh or more, all with cells of 8 or all of 20 nodes")
    points = np.vstack([m.points for m in meshes])
    offset = np.cumsum([0] + [len(m.points) for m in meshes])
    cells = np.vstack([m.cells + o for m, o in zip(meshes, offset)])
    grid = np.round(points / (tolerance * np.ptp(points, axis=0).max()) / 10).astype(np.int64)
    _, first, place = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    return Mesh(points[first], place.reshape(-1)[cells])


@checked(first=number(), last=number(), size=number(above=0), growth=number(above=0))
def graded(first: float, last: float, size: float, growth: float) -> np.ndarray:
    """Coordinates from `first` to `last` whose intervals start near `size` and grow by a factor.

    Returns
    -------
    ndarray
        Ascending coordinates [m].
    """
    if not last > first:
        raise InputError(f"last = {last:g}: must be above first = {first:g}")
    if (last - first) / size > _MOST:
        raise InputError(f"size = {size:g}: {(last - first) / size:.3g} intervals from {first:g} to {last:g}, at most {_MOST:g}")
    if growth <= 1:
        return np.linspace(first, last, max(1, round((last - first) / size)) + 1)
    n = max(1, int(np.ceil(np.log1p((last - first) * (growth - 1) / size) / np.log(growth))))
    steps = growth ** np.arange(n)
    return first + (last - first) * np.concatenate([[0], np.cumsum(steps)]) / steps.sum()
