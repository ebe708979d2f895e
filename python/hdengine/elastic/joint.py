# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic joints: the whole interface law from the normal stiffness per area over pressure."""
from __future__ import annotations

import warnings
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from .. import _engine
from .._check import array, checked, fields, mapping, number, text, together
from ..joint import Joint, JointWarning, scene_lines

__all__ = ["ElasticJoint"]
_MOST = 100_000  # rows of a scene's table


@dataclass(frozen=True)
class ElasticJoint:
    """A joint whose law follows from k_N(P) alone: closure, shear with partial slip, loops (docs/explain/joint.md).

    Parameters
    ----------
    table_pressure : ndarray
        Rising [Pa].
    k_n, k_t : ndarray
        Stiffness per area there, k_T without shear [Pa/m].
    friction : float
        Coulomb coefficient mu.
    model : str
        Where k_N comes from: 'spectrum', 'boundary_elements' or 'table'.
    """

    table_pressure: np.ndarray = field(repr=False)
    k_n: np.ndarray = field(repr=False)
    k_t: np.ndarray = field(repr=False)
    friction: float = 0.15
    model: str = "table"
    paper = False

    def __post_init__(self) -> None:
        column = array((None,), least=0)
        fields(self, table_pressure=column, k_n=column, k_t=column, friction=number(least=0), model=text)
        rows = len(self.table_pressure)
        if not (rows > 1 and rows == len(self.k_n) == len(self.k_t) and (np.diff(self.table_pressure) > 0).all()):
            raise _engine.InputError(f"table of {rows} pressures, {len(self.k_n)} k_n, {len(self.k_t)} k_t: must be as many, two "
                                     "or more, at rising pressures")

    @classmethod
    @checked(scene=mapping, friction=number(least=0, optional=True))
    def of_scene(cls, scene: dict, friction: float | None = None) -> ElasticJoint | None:
        """Elastic joint of a scene as the engine makes it; None where joint.model is 'hu2023'.

        Parameters
        ----------
        scene : dict
            'group.key' to value (`read_scene`, `Result.scene`); keys that are missing have their defaults.
        friction : float, optional
            Coefficient that caps the shear; default contact.friction.

        Raises
        ------
        InputError, FileError
            A parameter is out of range, a table cannot be read.
        """
        keys = {k: v for k, v in scene.items()
                if k.startswith(("joint.", "material.")) or k in ("contact.friction", "contact.zero_pressure")}
        p, k_n, k_t, rows, mu = _engine.call("elastic_of_scene", " ", scene_lines(keys) or " ", _MOST)
        if not rows:
            return None
        mu = float(mu if friction is None else friction)
        return cls(p[:rows], k_n[:rows], k_t[:rows], mu, scene.get("joint.model", "spectrum"))

    def __str__(self):
        low, high = self.table_pressure[[0, -1]] / 1e6
        return (f"ElasticJoint from {self.model}, {len(self.k_n)} pressures from {low:.3g} to {high:.4g} MPa, mu {self.friction:g}")

    @checked(pressure=array(), shear=array(), area=array())
    def stiffness(self, pressure: ArrayLike, shear: ArrayLike = 0.0, area: ArrayLike = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """K_N and K_T of facets [N/m]: `area` times k_N(P) and k_T(P - q/mu); no K_T where q reaches mu P.

        Parameters
        ----------
        pressure, shear : array_like
            P, q [Pa].
        area : array_like
            [m^2].

        Returns
        -------
        k_n, k_t : ndarray
        """
        p, q, a = together(pressure=pressure, shear=shear, area=area)
        k_n, k_t, _ = _engine.call("elastic_facets", self.table_pressure, self.k_n, self.k_t, self.friction, p.ravel(), q.ravel())
        return k_n.reshape(p.shape) * a, k_t.reshape(p.shape) * a

    @checked(pressure=array(), zero_pressure=number(above=0))
    def closure(self, pressure: ArrayLike, zero_pressure: float = 1e3) -> tuple[np.ndarray, np.ndarray]:
        """Approach int dP/k_N from zero_pressure [m], and k_N [Pa/m], at pressures [Pa]."""
        p = np.asarray(pressure, float)
        d = _engine.call("elastic_normal_law", self.table_pressure, self.k_n, zero_pressure, 0, p.ravel())
        return d.reshape(p.shape), self.stiffness(p)[0]

    @checked(closure=array(), zero_pressure=number(above=0))
    def pressure(self, closure: ArrayLike, zero_pressure: float = 1e3) -> tuple[np.ndarray, np.ndarray]:
        """Inverse of `closure`: pressure [Pa] and k_N [Pa/m] at approaches [m]."""
        d = np.asarray(closure, dtype=float)
        p = _engine.call("elastic_normal_law", self.table_pressure, self.k_n, zero_pressure, 1, d.ravel()).reshape(d.shape)
        return p, self.stiffness(p)[0]

    @checked(pressure=array(), displacement=array(least=0))
    def shear(self, pressure: ArrayLike, displacement: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Shear after a tangential displacement at constant pressure, loaded from zero.

        Ciavarella 1998, Jaeger 1998.

        Parameters
        ----------
        pressure : array_like
            P [Pa].
        displacement : array_like
            u >= 0 [m]. A reversal at (u_r, q_r) follows q = q_r - 2 q((u_r - u) / 2) (Masing).

        Returns
        -------
        shear, k_t : ndarray
            [Pa], at most mu P, and its tangent [Pa/m].
        slipping : ndarray of bool
            The friction limit is reached.
        """
        p, u = together(pressure=pressure, displacement=displacement)
        q, k, slips = _engine.call("elastic_tangential_law", self.table_pressure, self.k_t, self.friction, p.ravel(), u.ravel())
        return q.reshape(p.shape), k.reshape(p.shape), slips.reshape(p.shape) > 0


@checked(scene=mapping, friction=number(least=0, optional=True))
def joint_of_scene(scene: dict, friction: float | None = None) -> Joint | ElasticJoint:
    """The joint of a scene by its joint.model: `Joint` (hu2023) or `ElasticJoint`.

    Parameters
    ----------
    scene : dict
    friction : float, optional
        As `Joint.of_scene`.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", JointWarning)
        elastic = None if scene.get("joint.model") == "hu2023" else ElasticJoint.of_scene(scene, friction)  # parsing takes long
        return elastic or Joint.of_scene(scene, friction)
