# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint of two rough surfaces (Eq. 3-44): stiffness from pressure, vectorised."""
from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from . import _engine
from ._check import AXES, array, checked, flag, integer, mapping, number, seen, together
from ._check import fields as check_fields

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Joint", "JointWarning"]
_warned: set[str] = set()  # beginnings of the warnings that were given


def scene_lines(keys: dict) -> str:
    """Lines 'group.key=value' of a scene's texts and numbers."""
    for key, value in keys.items():
        if not isinstance(value, (str, int, float, np.number, np.bool_)):
            raise _engine.InputError(f"{key} = {seen(value)}: must be a number or a text")
    return "\n".join(f"{k}='{v}'" if isinstance(v, str) else f"{k}={float(v)!r}" for k, v in keys.items())


def _joint_of(lines):
    """Values of a joint by name, as the engine makes it of a scene; lines 'group.key=value'."""
    names = _engine.names("joint")
    found = dict(zip(names, _engine.call("joint_of_scene", " ", lines, len(names)).tolist()))
    return found | {flag: found[flag] > 0 for flag in ("paper", "plastic")}


_OF_SCENES = _joint_of("joint.model='hu2023'")  # what a scene has unless it says otherwise


class JointWarning(UserWarning):
    """The joint model is used outside the range it is meant for."""


@dataclass(frozen=True)
class Joint:
    """Material and surface of a rough joint; defaults: those of a scene.

    Parameters
    ----------
    e1, nu1, e2, nu2 : float
        Young's moduli [Pa] and Poisson's ratios of the bodies.
    nu_soft : float
        Poisson's ratio of the softer body, for the hardness coefficient k = 0.454 + 0.41 nu.
    hardness : float
        H of the softer body [Pa].
    fractal_dimension, roughness, gamma : float
        D in (2, 3), G [m], frequency ratio > 1.
    asperity_radius : float
        r_m, half the base length of an asperity [m]. The model's magnitude rests on it.
    friction : float
        Coulomb coefficient mu.
    s_min : float
        Smallest contact spot [m^2]; Eq. 30 diverges at 0. Default pi (L_s / 2)^2 with L_s = 1 um.
    reference_area : float
        A_0 [m^2]: nominal pressure P means F_r = P A_0. Default (0.5 mm)^2, the scanned patch.
    paper : bool
        Closure of Eq. 28 as printed (P = F_r / S_r), which makes the sum grow with the number of facets.
    plastic : bool
        Fully plastic spots unload elastically, k = 2 E a; otherwise they have no stiffness, as in the paper.
    """

    e1: float = _OF_SCENES["e1"]
    nu1: float = _OF_SCENES["nu1"]
    e2: float = _OF_SCENES["e2"]
    nu2: float = _OF_SCENES["nu2"]
    nu_soft: float = _OF_SCENES["nu_soft"]
    hardness: float = _OF_SCENES["hardness"]
    fractal_dimension: float = _OF_SCENES["fractal_dimension"]
    roughness: float = _OF_SCENES["roughness"]
    gamma: float = _OF_SCENES["gamma"]
    asperity_radius: float = _OF_SCENES["asperity_radius"]
    friction: float = _OF_SCENES["friction"]
    s_min: float = _OF_SCENES["s_min"]
    reference_area: float = _OF_SCENES["reference_area"]
    paper: bool = _OF_SCENES["paper"]
    plastic: bool = _OF_SCENES["plastic"]

    def __post_init__(self) -> None:
        positive, ratio = number(above=0), number(above=-1, most=0.5)
        check_fields(self, e1=positive, nu1=ratio, e2=positive, nu2=ratio, nu_soft=ratio, hardness=positive,
                     fractal_dimension=number(above=2, below=3), roughness=positive, gamma=number(above=1),
                     asperity_radius=positive, friction=number(least=0), s_min=positive, reference_area=positive, paper=flag,
                     plastic=flag)

    @classmethod
    @checked(scene=mapping, friction=number(least=0, optional=True))
    def of_scene(cls, scene: dict, friction: float | None = None) -> Joint:
        """Statistical joint (hu2023) of a scene, as the engine makes it, whatever its joint.model; `Result.joint` is of its model.

        Parameters
        ----------
        scene : dict
            'group.key' to value (`read_scene`, `Result.scene`); keys that are missing have their defaults.
        friction : float, optional
            Coefficient that caps the shear; default contact.friction. Under a torque it is that of the load step.

        Raises
        ------
        InputError
            A parameter is out of range.
        """
        keys = {k: v for k, v in scene.items() if k.startswith(("joint.", "material.")) or k == "contact.friction"}
        keys["joint.model"] = "hu2023"
        if friction is not None:
            keys["contact.friction"] = friction
        return cls(**_joint_of(scene_lines(keys)))

    def __str__(self) -> str:
        p = self.asperity()[0]
        return (f"Joint, closure {'of Eq. 28 (paper)' if self.paper else 'nominal, F_r = P A_0'}\n"
                f"  bodies    E {self.e1 / 1e9:g} and {self.e2 / 1e9:g} GPa, H {self.hardness / 1e9:.4g} GPa, "
                f"mu {self.friction:g}\n"
                f"  surface   D {self.fractal_dimension:g}, G {self.roughness:g} m, gamma {self.gamma:g}, "
                f"A_0 {1e6 * self.reference_area:g} mm^2\n"
                f"  asperity  r_m {1e6 * self.asperity_radius:g} um, R {1e6 * p['radius_m']:.4g} um, "
                f"yields at {p['s_ec_m2']:.3g} m^2; s_min {self.s_min:.3g} m^2")

    def _parameters(self):
        return _engine.named("joint", **vars(self))

    @checked(pressure=array(empty=True), shear=array(empty=True), area=array(above=0, optional=True, empty=True))
    def stiffness(self, pressure: ArrayLike, shear: ArrayLike = 0.0, area: ArrayLike | None = None) -> tuple:
        """Normal and tangential stiffness of facets.

        Parameters
        ----------
        pressure, shear : array_like
            Nominal pressure and shear traction [Pa].
        area : array_like, optional
            Areas of the facets [m^2]; default: the reference area.

        Returns
        -------
        k_n, k_t : ndarray
            Stiffness [N/m], shaped as the broadcast arguments. K_N of Eq. 35 and K_T of Eq. 44, clipped to the regimes
            present.

        Raises
        ------
        InputError
            A parameter is out of range.

        Warns
        -----
        JointWarning
            s_l > pi r_m^2, S_r > A_0, s_min plastic or not below s_l, at the largest pressure.
        """
        _, k_n, k_t, *_ = self._facets(pressure, shear, area)
        return k_n, k_t

    @checked(pressure=array(empty=True), shear=array(empty=True), area=array(above=0, optional=True, empty=True))
    def derivatives(self, pressure: ArrayLike, shear: ArrayLike = 0.0, area: ArrayLike | None = None) -> tuple:
        """Derivatives of the stiffness.

        Parameters
        ----------
        pressure, shear, area : array_like
            As in `stiffness`.

        Returns
        -------
        dk_n_dp, dk_t_dp, dk_t_dtau : ndarray
            By pressure and by nominal shear [N/(m Pa)]. dK_N/dtau is 0.
        """
        shape, *_, d, _ = self._facets(pressure, shear, area)
        return tuple(row.reshape(shape) for row in d)

    def _facets(self, pressure, shear, area):
        area = self.reference_area if area is None else area
        p, q, a = together(pressure=pressure, shear=shear, area=area)
        flat = [np.ascontiguousarray(x, dtype=float).ravel() for x in (p, q, a)]
        if not p.size:
            return p.shape, *(np.zeros(p.shape) for _ in range(3)), np.zeros((3, 0)), np.zeros(0, int)
        k_n, k_t, s_l, d, iterations = _engine.call("joint_facets", self._parameters(), *flat)
        if np.max(flat[0]) > 0:
            for line in self.warnings(np.max(flat[0])):
                kind = line.partition(",")[0]
                if kind not in _warned:  # once per process: its numbers differ from joint to joint
                    _warned.add(kind)
                    warnings.warn(line, JointWarning, stacklevel=4)
        return p.shape, k_n.reshape(p.shape), k_t.reshape(p.shape), s_l.reshape(p.shape), d, iterations

    @checked(pressure=array(empty=True))
    def largest_spot(self, pressure: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Largest contact spot s_l [m^2] under a pressure [Pa], and the Newton iterations it took."""
        _, _, _, s_l, _, iterations = self._facets(pressure, 0.0, None)
        return s_l, iterations

    @checked(pressure=number())
    def warnings(self, pressure: float) -> list:
        """What does not hold under the largest pressure [Pa].

        Returns
        -------
        list of str
            Empty inside the range.
        """
        return _engine.call_text("joint_warnings", self._parameters(), float(pressure)).splitlines()

    @checked(pressure=array(above=0), zero_pressure=number(above=0))
    def closure(self, pressure: ArrayLike, zero_pressure: float = 1e3) -> tuple:
        """Approach of the surfaces, delta(P) = int dP / k_N.

        Parameters
        ----------
        pressure : array_like
            P > 0 [Pa].
        zero_pressure : float
            Pressure at which the approach counts as 0 [Pa]; delta -> -inf as P -> 0.

        Returns
        -------
        closure, k_n : ndarray
            [m] and its inverse tangent dP/ddelta, per nominal area [Pa/m].

        Raises
        ------
        InputError
            No elastic spot, closure `paper`, zero_pressure out of range.
        """
        return self._normal_law(pressure, zero_pressure, 0)

    @checked(closure=array(), zero_pressure=number(above=0))
    def pressure(self, closure: ArrayLike, zero_pressure: float = 1e3) -> tuple[np.ndarray, np.ndarray]:
        """Inverse of `closure`: pressure [Pa] and k_N [Pa/m], smooth and positive for every approach [m]."""
        return self._normal_law(closure, zero_pressure, 1)

    def _normal_law(self, x, zero_pressure, inverse):
        x = np.asarray(x, dtype=float)
        y, k = _engine.call("joint_normal_law", self._parameters(), zero_pressure, inverse, np.ascontiguousarray(x).ravel())
        return y.reshape(x.shape), k.reshape(x.shape)

    @checked(pressure=array(), displacement=array(least=0))
    def shear(self, pressure: ArrayLike, displacement: ArrayLike) -> tuple:
        """Shear stress after a tangential displacement at constant pressure, loaded from zero.

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
        p, u = together(pressure=np.asarray(pressure, dtype=float), displacement=np.asarray(displacement, dtype=float))
        q, k, slips = _engine.call("joint_tangential_law", self._parameters(), p.ravel(), u.ravel())
        return q.reshape(p.shape), k.reshape(p.shape), slips.reshape(p.shape) > 0

    @checked(pressure=number(above=0), shear=number(), step=number(above=0, most=0.1))
    def sensitivity(self, pressure: float, shear: float = 0.0, step: float = 1e-4) -> dict:
        """Elasticities d ln K / d ln x of K_N and K_T for every number x the joint rests on.

        Parameters
        ----------
        pressure, shear : float
            Nominal pressure and shear [Pa].
        step : float
            Relative step of the central difference.

        Returns
        -------
        dict
            Name to (elasticity of K_N, elasticity of K_T); largest of the first in front.
        """
        def logs(joint, p, q):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", JointWarning)
                return np.log(np.array(joint.stiffness(p, q, self.reference_area)))

        table = {}
        for field in fields(self):
            if field.name in ("paper", "plastic"):
                continue
            value = getattr(self, field.name)
            up, down = (logs(replace(self, **{field.name: value * np.exp(s)}), pressure, shear) for s in (step, -step))
            table[field.name] = tuple((up - down) / (2 * step))
        table["pressure"] = tuple((logs(self, pressure * np.exp(step), shear) - logs(self, pressure * np.exp(-step), shear))
                                  / (2 * step))
        return dict(sorted(table.items(), key=lambda item: -abs(item[1][0])))

    @checked(d_error=number(least=0, most=1), ln_g_error=number(least=0, most=50), correlation=number(least=-1, most=1),
             count=integer(1), seed=integer(0, 2**63 - 1))
    def samples(self, d_error: float, ln_g_error: float, correlation: float = 0.0, count: int = 400, seed: int = 1) -> Iterator:
        """Joints whose D and ln G scatter with the standard errors of a surface fit.

        Parameters
        ----------
        d_error, ln_g_error : float
            Standard errors of D and of ln G.
        correlation : float
            Of both errors; a fit gives values near +1.
        count, seed : int
            Number of joints, seed.

        Yields
        ------
        Joint
            Draws outside 2 < D < 3 are repeated.
        """
        rng = np.random.default_rng(seed)
        cross = correlation * d_error * ln_g_error
        covariance = [[d_error**2, cross], [cross, ln_g_error**2]]
        while count > 0:
            d, ln_g = rng.multivariate_normal([self.fractal_dimension, np.log(self.roughness)], covariance)
            if 2 < d < 3:
                count -= 1
                yield replace(self, fractal_dimension=d, roughness=np.exp(ln_g))

    @checked(pressure=array((None,), above=0, optional=True), axis=AXES)
    def plot(self, pressure: ArrayLike | None = None, axis: Axes | None = None) -> Axes:
        """K_N and K_T per nominal area over the pressure, the regimes of the largest spot shaded.

        Parameters
        ----------
        pressure : array_like, optional
            [Pa]; default 10 kPa to 1 GPa.
        axis : matplotlib axes, optional
            Where to draw; default a new figure.

        Returns
        -------
        matplotlib axes
        """
        from .figures.joint import plot_joint

        return plot_joint(self, np.logspace(4, 9, 200) if pressure is None else np.asarray(pressure), axis)

    @checked(s_l=number(above=0), tau=number())
    def parts(self, s_l: float, tau: float = 0.0) -> dict:
        """Integrals at a given largest spot, by regime (elastic, two elastoplastic, plastic).

        Parameters
        ----------
        s_l : float
            Largest spot [m^2].
        tau : float
            Shear stress on the spots [Pa].

        Returns
        -------
        dict
            load_n (4), k_n_n_per_m (4), k_t_n_per_m (4), psi, real_area_m2.
        """
        keys = ("load_n", "k_n_n_per_m", "k_t_n_per_m", "psi", "real_area_m2")
        return dict(zip(keys, _engine.call("joint_parts", self._parameters(), s_l, tau)))

    @checked(depth=number(), area=number(least=0), tau=number())
    def asperity(self, depth: float = 0.0, area: float = 0.0, tau: float = 0.0) -> tuple:
        """One asperity (Eq. 3-16): its properties, and its state at a depth or at an area.

        Parameters
        ----------
        depth : float
            Depth eps [m].
        area : float
            Area of the spot [m^2].
        tau : float
            Shear stress on the spot [Pa].

        Returns
        -------
        properties : dict
            e_star_pa, g_prime_pa, hardness_pa, hardness_factor, amplitude_m, radius_m, eps_ec_m, s_ec_m2, f_ec_n.
        by_depth : ndarray (3,)
            Area [m^2], load [N], stiffness [N/m].
        by_area : ndarray (3,)
            Load [N], normal and tangential stiffness [N/m].
        """
        names = _engine.names("asperity")
        properties, by_depth, by_area = _engine.call("asperity", self._parameters(), depth, area, tau, len(names))
        return dict(zip(names, properties)), by_depth, by_area
