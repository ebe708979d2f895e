# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic bodies of your own meshes, alone or in frictional contact, solved by the engine (small displacements)."""
from dataclasses import dataclass

import numpy as np

from . import _engine
from .mesh import Mesh


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
    angle: object = 0.0


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

    def arrays(self, period):
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


def _common(bodies, element):
    """Arguments that describe the bodies."""
    nodes = np.cumsum([len(b.mesh.points) for b in bodies])
    cells = np.cumsum([len(b.mesh.cells) for b in bodies])
    first = np.concatenate([[0], nodes[:-1]])
    x = np.asfortranarray(np.vstack([b.mesh.points for b in bodies]).T)
    angle = np.concatenate([np.broadcast_to(np.asarray(b.angle, float), len(b.mesh.points)) for b in bodies])
    connect = np.asfortranarray(np.vstack([b.mesh.cells + o for b, o in zip(bodies, first)]).T + 1, np.int32)
    if len(np.unique(connect)) != nodes[-1]:
        raise _engine.InputError("some nodes belong to no cell")
    if connect.shape[0] != (20 if element == "hex20r" else 8):
        raise _engine.InputError(f"element '{element}' does not fit cells of {connect.shape[0]} nodes")
    material = np.asfortranarray([[b.young for b in bodies], [b.poisson for b in bodies]], float)
    return element, nodes.astype(np.int32), cells.astype(np.int32), material, x, angle, connect


def _columns(values, n, steps, width):
    """Nodal values as (width, n, steps), Fortran order; None is zero."""
    if values is None:
        return np.zeros((width, n, steps), order="F")
    values = np.asarray(values, float).reshape(-1, n, width)
    return np.asfortranarray(np.broadcast_to(values, (steps, n, width)).transpose(2, 1, 0))


def static(bodies, fixed, displacement=None, force=None, element="hex8i"):
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
    n = common[4].shape[1]
    held = np.asfortranarray(np.asarray(fixed).T, np.int32)
    return _engine.call("solid_static", *common, held, _columns(displacement, n, 1, 3)[..., 0],
                        _columns(force, n, 1, 3)[..., 0]).T


def contact(bodies, slave, master, fixed, displacement=None, force=None, gap=None, friction=0.0, mode="frictional",
            element="hex8i", period=0.0, scale=None, tolerance=1e-10, max_iterations=60):
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

    Returns
    -------
    Solution

    Raises
    ------
    NotConvergedError
        A step has no equilibrium within `max_iterations`.
    """
    common = _common(bodies, element)
    x = common[4]
    n = x.shape[1]
    steps = max(len(np.reshape(v, (-1, n, w))) for v, w in ((displacement, 3), (force, 3), (gap, 1)) if v is not None)
    held = np.asfortranarray(np.asarray(fixed).T, np.int32)
    if scale is None:
        scale = min(b.young for b in bodies) / np.ptp(x, axis=1).max()
    u, reaction, traction, slip, opening, state, area, history, used = _engine.call(
        "solid_contact", *common, held, *slave.arrays(period), *master.arrays(period), float(period), mode,
        np.array([friction, scale, tolerance]), max_iterations, _columns(displacement, n, steps, 3),
        _columns(force, n, steps, 3), _columns(gap, n, steps, 1)[0], (max_iterations + 1) * steps)
    return Solution(u.T, reaction.T, traction.T, slip.T, opening.T, state.T, area, history.T[:used])
