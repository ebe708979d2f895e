# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic joints: the whole interface law from the normal stiffness per area over pressure, and from a spectrum that stiffness."""
from __future__ import annotations

import warnings
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from . import _engine
from .joint import Joint, JointWarning

_MOST = 100_000  # rows of a scene's table


def moduli(e1: float, nu1: float, e2: float, nu2: float) -> tuple[float, float]:
    """E* [Pa] of two bodies, and the stiffness ratio k_T/k_N of full stick, 4 G*/E*.

    Source: Mindlin (1949); for rough surfaces Campana, Persson and Mueser (2011), doi 10.1088/0953-8984/23/8/085001.
    """
    e_star, ratio = _engine.joint_moduli(e1, nu1, e2, nu2)
    return float(e_star), float(ratio)


def stiffness_from_spectrum(q: ArrayLike, height_variance: ArrayLike, pressure: ArrayLike, e_star: float,
                            hardness: float = np.inf) -> tuple[np.ndarray, np.ndarray]:
    """Normal stiffness per area and true contact of a rough elastic joint by Persson's theory (docs/explain/joint.md).

    Parameters
    ----------
    q : array_like
        Wavenumbers, rising [1/m].
    height_variance : array_like
        Variance of the equivalent surface's heights in the band about each [m^2].
    pressure : array_like
        Nominal pressures, above 0 [Pa].
    e_star : float
        Reduced modulus [Pa].
    hardness : float
        Pressure at which the softer body yields [Pa].

    Returns
    -------
    k_n, area : ndarray
        [Pa/m], share of the nominal area that touches.

    Raises
    ------
    InputError
        The bands do not rise or hold negative variance, the pressure is not below the hardness.
    """
    p = np.atleast_1d(np.asarray(pressure, dtype=float))
    hardness = min(hardness, 1e6 * e_star)
    if p.size and not (p.min() > 0 and p.max() < hardness):
        raise _engine.InputError(f"pressures from {p.min():g} to {p.max():g} Pa; valid: above 0 and below the hardness, "
                                 f"{hardness:g} Pa")
    return _engine.call("spectrum_joint", np.asarray(q, float), np.asarray(height_variance, float), e_star, hardness, p)


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

    @classmethod
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
        lines = "\n".join(f"{k}='{v}'" if isinstance(v, str) else f"{k}={float(v)!r}" for k, v in keys.items())
        p, k_n, k_t, rows, mu = _engine.call("elastic_of_scene", " ", lines or " ", _MOST)
        if not rows:
            return None
        mu = float(mu if friction is None else friction)
        return cls(p[:rows], k_n[:rows], k_t[:rows], mu, scene.get("joint.model", "spectrum"))

    def __str__(self):
        low, high = self.table_pressure[[0, -1]] / 1e6
        return (f"ElasticJoint from {self.model}, {len(self.k_n)} pressures from {low:.3g} to {high:.4g} MPa, mu {self.friction:g}")

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
        p, q, a = np.broadcast_arrays(np.asarray(pressure, float), np.asarray(shear, float), np.asarray(area, float))
        k_n, k_t, _ = _engine.call("elastic_facets", self.table_pressure, self.k_n, self.k_t, self.friction, p.ravel(), q.ravel())
        return k_n.reshape(p.shape) * a, k_t.reshape(p.shape) * a

    def closure(self, pressure: ArrayLike, zero_pressure: float = 1e3) -> tuple[np.ndarray, np.ndarray]:
        """Approach int dP/k_N from zero_pressure [m], and k_N [Pa/m], at pressures [Pa]."""
        p = np.asarray(pressure, dtype=float)
        d = _engine.call("elastic_normal_law", self.table_pressure, self.k_n, zero_pressure, 0, p.ravel())
        return d.reshape(p.shape), self.stiffness(p)[0]

    def pressure(self, closure: ArrayLike, zero_pressure: float = 1e3) -> tuple[np.ndarray, np.ndarray]:
        """Inverse of `closure`: pressure [Pa] and k_N [Pa/m] at approaches [m]."""
        d = np.asarray(closure, dtype=float)
        p = _engine.call("elastic_normal_law", self.table_pressure, self.k_n, zero_pressure, 1, d.ravel()).reshape(d.shape)
        return p, self.stiffness(p)[0]

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
        p, u = np.broadcast_arrays(np.asarray(pressure, dtype=float), np.asarray(displacement, dtype=float))
        q, k, slips = _engine.call("elastic_tangential_law", self.table_pressure, self.k_t, self.friction, p.ravel(), u.ravel())
        return q.reshape(p.shape), k.reshape(p.shape), slips.reshape(p.shape) > 0


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
        return ElasticJoint.of_scene(scene, friction) or Joint.of_scene(scene, friction)
