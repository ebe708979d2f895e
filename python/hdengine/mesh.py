# SPDX-License-Identifier: GPL-3.0-or-later
"""Hexahedral meshes for `hdengine.solid`: mapped blocks, joined where nodes meet, and their boundary facets."""
from dataclasses import dataclass

import numpy as np

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

    @property
    def quadratic(self):
        """Whether the cells have mid-side nodes."""
        return self.cells.shape[1] == 20

    def facets(self, chosen):
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
        sides = _SIDES if self.quadratic else _FACES
        every = self.cells[:, sides].reshape(-1, sides.shape[1])
        return every[np.asarray(chosen)[every].all(1)]

    def warp(self, function):
        """The mesh with its points (n, 3) moved by a function."""
        return Mesh(np.asarray(function(self.points), float), self.cells)


def block(x, y, z, quadratic=False):
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
    n = [len(x) - 1, len(y) - 1, len(z) - 1]
    fine = [np.interp(np.arange(2 * k + 1) / 2, np.arange(k + 1), np.asarray(c, float)) for k, c in zip(n, (x, y, z))]
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


def merge(*meshes, tolerance=1e-9):
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
    points = np.vstack([m.points for m in meshes])
    offset = np.cumsum([0] + [len(m.points) for m in meshes])
    cells = np.vstack([m.cells + o for m, o in zip(meshes, offset)])
    grid = np.round(points / (tolerance * np.ptp(points, axis=0).max()) / 10).astype(np.int64)
    _, first, number = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    return Mesh(points[first], number.reshape(-1)[cells])


def graded(first, last, size, growth):
    """Coordinates from `first` to `last` whose intervals start near `size` and grow by a factor.

    Returns
    -------
    ndarray
        Ascending coordinates [m].
    """
    if growth <= 1:
        return np.linspace(first, last, max(1, round((last - first) / size)) + 1)
    n = max(1, int(np.ceil(np.log1p((last - first) * (growth - 1) / size) / np.log(growth))))
    steps = growth ** np.arange(n)
    return first + (last - first) * np.concatenate([[0], np.cumsum(steps)]) / steps.sum()
