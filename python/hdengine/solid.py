# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic bodies of your own meshes, alone or in frictional contact, solved by the engine (small displacements)."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from . import _engine
from ._check import array, checked, fields, integer, integers, kind, number, word
from .mesh import Mesh

__all__ = ["Body", "Face", "Solution", "contact", "static"]


@dataclass
class Body:
    """A meshed body.

    Parameters
    ----------
    mesh : Mesh
        Nodes and cells.
    young, poisson : float
        Young's modulus [Pa], Poisson's ratio.
    angle : float or ndarray (n,)
        Direction of the first dof of the nodes in the x-y plane [rad]; the second is 90 degrees ahead, the third is z.
        All nodal vectors are in these dofs. Nodes of a contact face need their normal as first dof.
    """

    mesh: Mesh
    young: float
    poisson: float
    angle: ArrayLike = 0.0

    def __post_init__(self) -> None:
        n = len(kind(Mesh)("mesh", self.mesh).points)
        fields(self, young=number(above=0), poisson=number(above=-1, below=0.5), angle=array([(), (n,)]))


@dataclass
class Face:
    """A contact face on a plane or unrolled chart shared by both faces.

    Parameters
    ----------
    facets : ndarray (k, 4) or (k, 8)
        Nodes in the common numbering of all bodies.
    chart : ndarray (n, 2)
        Chart coordinates of all nodes (only those of the facets are read) [m].
    """

    facets: np.ndarray
    chart: np.ndarray

    def __post_init__(self) -> None:
        fields(self, facets=integers((None, None), 0), chart=array((None, 2)))
        if self.facets.shape[1] not in (4, 8):
            raise _engine.InputError(f"facets have {self.facets.shape[1]} nodes: must have 4 or 8")
        if self.facets.max() >= len(self.chart):
            raise _engine.InputError(f"facets name node {self.facets.max()}, the chart has {len(self.chart)} nodes, from 0")
        if any(len(set(f)) < len(f) for f in self.facets.tolist()):
            raise _engine.InputError("a facet names a node twice")

    @checked(period=number(least=0))
    def arrays(self, period: float) -> tuple[np.ndarray, np.ndarray]:
        """Node numbers (nodes, k) from 1 and corner coordinates (2, 4, k), counter-clockwise."""
        facets = np.array(self.facets)
        corners = np.asarray(self.chart, float)[facets[:, :4]]
        if period > 0:
            corners[..., 0] -= period * np.round((corners[..., 0] - corners[:, :1, 0]) / period)
        d1, d2 = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
        turn = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0] < 0
        order = np.array([0, 3, 2, 1, 7, 6, 5, 4])[:facets.shape[1]]
        facets[turn] = facets[turn][:, order]
        corners[turn] = corners[turn][:, [0, 3, 2, 1]]
        return np.asfortranarray(facets.T + 1, np.int32), np.asfortranarray(corners.transpose(2, 1, 0))


@dataclass
class Solution:
    """Fields of the load steps; those of the interface stand at the slave's corner nodes and are zero elsewhere.

    Parameters
    ----------
    u, reaction : ndarray (steps, n, 3)
        Displacements [m] and forces of the supports [N].
    traction : ndarray (steps, n, 3)
        Traction on the master, pressure first [Pa].
    slip : ndarray (steps, n, 2)
        Tangential displacement of the master against the slave [m].
    gap : ndarray (steps, n)
        Gap [m].
    state : ndarray (steps, n)
        0 open, 1 stick, 2 slip.
    area : ndarray (n,)
        Area of the multipliers [m^2]: area times traction sums to the force.
    history : ndarray (iterates, 7)
        Step, iteration, relative residual, changed multipliers, open, stick, slip.
    """

    u: np.ndarray
    reaction: np.ndarray
    traction: np.ndarray
    slip: np.ndarray
    gap: np.ndarray
    state: np.ndarray
    area: np.ndarray
    history: np.ndarray


_ELEMENTS = ("hex8", "hex8i", "hex20r")


def _bodies(name, value):
    """A rule: a sequence of bodies."""
    if not isinstance(value, (list, tuple)) or not value or not all(isinstance(b, Body) for b in value):
        raise _engine.InputError(f"{name}: must be a list of Body, at least one")
    if len({b.mesh.quadratic for b in value}) > 1:
        raise _engine.InputError(f"{name}: all must have cells of 8, or all of 20 nodes")
    return value


def _held(name, value):
    """A rule: which dofs are prescribed."""
    a = np.asarray(value)
    if a.dtype.kind not in "biu" or a.ndim != 2 or a.shape[1] != 3:
        raise _engine.InputError(f"{name}: must be true or false for every dof, shape (n, 3)")
    return a != 0


def _fitting(n, **arrays):
    """Refuse arrays that are not one row per node."""
    for name, (a, width) in arrays.items():
        shape = np.shape(a)
        one, many = ((n, width), 3) if width > 1 else ((n,), 2)
        if a is not None and shape[-len(one):] != one or len(shape) > many:
            raise _engine.InputError(f"{name} has shape {shape}: must be {one}, or that for every load step")


class _Problem:
    """A problem of the engine, held by its handle: fields enter by name, results are asked for by name."""

    def __init__(self, element, mode=" ", **given):
        self._handle = _engine.call("solid_open", element, mode)
        for name, values in given.items():
            self.put(name, values)

    def put(self, name, values):
        """Enter a field, first index fastest."""
        _engine.call("solid_put", self._handle, name, np.ravel(np.asarray(values, float), order="F"))

    def solve(self):
        """Solve with the fields that were entered."""
        _engine.call("solid_solve", self._handle)

    def get(self, name, *shape):
        """A field in Fortran's shape, the last length open; axes turned round, as Python has them."""
        flat = _engine.call("solid_get", self._handle, name, _engine.call("solid_size", self._handle, name))
        return flat.reshape((*shape, -1), order="F").T

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        _engine.ask("solid_close", self._handle)


def _common(bodies, element):
    """Fields that describe the bodies."""
    nodes = np.cumsum([len(b.mesh.points) for b in bodies])
    cells = np.cumsum([len(b.mesh.cells) for b in bodies])
    first = np.concatenate([[0], nodes[:-1]])
    angle = np.concatenate([np.broadcast_to(np.asarray(b.angle, float), len(b.mesh.points)) for b in bodies])
    connect = np.vstack([b.mesh.cells + o for b, o in zip(bodies, first)]).T + 1
    if len(np.unique(connect)) != nodes[-1]:
        raise _engine.InputError("some nodes belong to no cell")
    if connect.shape[0] != (20 if element == "hex20r" else 8):
        raise _engine.InputError(f"element '{element}' does not fit cells of {connect.shape[0]} nodes")
    return {"node_end": nodes, "cell_end": cells, "material": [[b.young for b in bodies], [b.poisson for b in bodies]],
            "x": np.vstack([b.mesh.points for b in bodies]).T, "angle": angle, "cells": connect}


def _refuse_far_slip(slip, limit, *faces):
    """Raise NotConvergedError where slip (2, n, steps) passes the limit, by default the shortest side of a facet."""
    if limit is None:
        limit = min(np.linalg.norm(np.diff(c[:, [0, 1, 2, 3, 0]], axis=1), axis=2).min()
                    for c in (np.asarray(f.chart, float)[np.asarray(f.facets)[:, :4]] for f in faces))
    length = np.hypot(*slip).max(0)
    step = int(np.argmax(length > limit))
    if length[step] > limit:
        raise _engine.NotConvergedError(
            f"load step {step + 1} slides by {length[step]:.3g} m, farther than the shortest side of a facet ({limit:.3g} m): "
            "hdengine.solid is for small displacements; use coarser facets, a shorter way, or max_slip on a flat, even master")


def _columns(values, n, steps, width):
    """Nodal values as (width, n, steps), Fortran order; None is zero."""
    if values is None:
        return np.zeros((width, n, steps), order="F")
    values = np.reshape(values, (-1, n, width))
    return np.asfortranarray(np.broadcast_to(values, (steps, n, width)).transpose(2, 1, 0))


@checked(bodies=_bodies, fixed=_held, displacement=array(optional=True), force=array(optional=True), element=word(*_ELEMENTS))
def static(bodies: Sequence[Body], fixed: np.ndarray, displacement: np.ndarray | None = None, force: np.ndarray | None = None,
           element: str = "hex8i") -> np.ndarray:
    """Displacements of elastic bodies under forces and supports.

    Parameters
    ----------
    bodies : sequence of Body
        Their nodes are numbered one body after the other.
    fixed : ndarray of bool (n, 3)
        Prescribed dofs.
    displacement : ndarray (n, 3), optional
        Their values [m], default 0.
    force : ndarray (n, 3), optional
        Nodal forces [N].
    element : str
        hex8, hex8i or hex20r.

    Returns
    -------
    ndarray (n, 3)
        Displacements [m].

    Raises
    ------
    InputError
        Unknown element, inverted cell.
    LinearSolverError
        A body is not held.
    """
    common = _common(bodies, element)
    n = common["x"].shape[1]
    _fitting(n, fixed=(fixed, 3), displacement=(displacement, 3), force=(force, 3))
    for name, field in (("displacement", displacement), ("force", force)):
        if field is not None and field.ndim > 2:
            raise _engine.InputError(f"{name} has shape {field.shape}: there is one load step, give {(n, 3)}")
    with _Problem(element, **common, fixed=np.asarray(fixed).T, displacement=_columns(displacement, n, 1, 3),
                  force=_columns(force, n, 1, 3)) as problem:
        problem.solve()
        return problem.get("u", 3)


@checked(bodies=_bodies, slave=kind(Face), master=kind(Face), fixed=_held, displacement=array(optional=True),
         force=array(optional=True), gap=array(optional=True), friction=number(least=0),
         mode=word("bonded", "frictionless", "frictional"), element=word(*_ELEMENTS), period=number(least=0),
         scale=number(above=0, optional=True), tolerance=number(above=0, below=1), max_iterations=integer(1, 10000),
         max_slip=number(above=0, finite=False, optional=True))
def contact(bodies: Sequence[Body], slave: Face, master: Face, fixed: np.ndarray, displacement: np.ndarray | None = None,
            force: np.ndarray | None = None, gap: np.ndarray | None = None, friction: float = 0.0, mode: str = "frictional",
            element: str = "hex8i", period: float = 0.0, scale: float | None = None, tolerance: float = 1e-10,
            max_iterations: int = 60, max_slip: float | None = None) -> Solution:
    """Contact of two faces through load steps, with friction history (mortar coupling, semi-smooth Newton).

    Parameters
    ----------
    bodies, fixed, element :
        As in `static`.
    slave, master : Face
        Faces; the normal, first dof of their nodes, points from slave to master.
    displacement, force : ndarray (steps, n, 3) or (n, 3), optional
        Prescribed displacements [m] and nodal forces [N] at the end of each step.
    gap : ndarray (steps, n) or (n,), optional
        Initial gap at the slave's corner nodes, negative for interference [m].
    friction : float
        Coulomb coefficient.
    mode : str
        bonded, frictionless or frictional.
    period : float
        Length after which the first chart coordinate repeats, 0: never [m].
    scale : float, optional
        Constant c of the iteration [Pa/m]; the solution does not depend on it.
    tolerance : float
        Relative residual.
    max_slip : float, optional
        Longest slip that is accepted [m]; default: the shortest side of a facet. Pairs of facets do not follow the slip, which
        matters unless the master is flat and evenly supported.

    Returns
    -------
    Solution

    Raises
    ------
    NotConvergedError
        A step has no equilibrium within `max_iterations`, or slides farther than a facet is long, where pairs of facets do not
        follow.
    """
    common = _common(bodies, element)
    x = common["x"]
    n = x.shape[1]
    _fitting(n, fixed=(fixed, 3), displacement=(displacement, 3), force=(force, 3), gap=(gap, 1))
    nodes = 8 if element == "hex20r" else 4
    for name, face in (("slave", slave), ("master", master)):
        if len(face.chart) != n or face.facets.shape[1] != nodes:
            raise _engine.InputError(f"{name}: a chart of {len(face.chart)} nodes and facets of {face.facets.shape[1]}; the bodies "
                                     f"have {n} nodes, and element '{element}' has facets of {nodes}")
    loads = ((displacement, 3), (force, 3), (gap, 1))
    counts = {len(np.reshape(v, (-1, n, w))) for v, w in loads if v is not None} - {1} or {1}
    if len(counts) > 1:
        raise _engine.InputError(f"displacement, force and gap have different numbers of load steps: {sorted(counts)}")
    steps = counts.pop()
    if scale is None:
        scale = min(b.young for b in bodies) / np.ptp(x, axis=1).max()
    with _Problem(element, mode, **common, fixed=np.asarray(fixed).T, period=[period], friction=[friction], scale=[scale],
                  tolerance=[tolerance], max_iterations=[max_iterations], displacement=_columns(displacement, n, steps, 3),
                  force=_columns(force, n, steps, 3), gap=_columns(gap, n, steps, 1)) as problem:
        for name, face in (("slave", slave), ("master", master)):
            facets, chart = face.arrays(period)
            problem.put(name, facets)
            problem.put(name + "_chart", chart)
        problem.solve()
        slip = problem.get("slip", 2, n)
        _refuse_far_slip(slip.T, max_slip, slave, master)
        return Solution(problem.get("u", 3, n), problem.get("reaction", 3, n), problem.get("traction", 3, n), slip,
                        problem.get("opening", n), problem.get("contact", n).astype(np.int32), problem.get("area"),
                        problem.get("history", 7))
