# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint of two rough surfaces (Eq. 3-44): stiffness from pressure, vectorised."""
import warnings
from dataclasses import astuple, dataclass, fields, replace
from math import pi

import numpy as np

from . import _engine


class JointWarning(UserWarning):
    """The joint model is used outside the range it is meant for."""


@dataclass(frozen=True)
class Joint:
    """Material and surface of a rough joint.

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
    """

    e1: float = 209e9
    nu1: float = 0.295
    e2: float = 219e9
    nu2: float = 0.30
    nu_soft: float = 0.295
    hardness: float = 2.8 * 835e6
    fractal_dimension: float = 2.5304
    roughness: float = 2.4248e-7
    gamma: float = 1.5
    asperity_radius: float = 5e-6
    friction: float = 0.15
    s_min: float = pi * 0.5e-6**2
    reference_area: float = 0.25e-6
    paper: bool = False

    def __str__(self):
        p = self.asperity()[0]
        return (f"Joint, closure {'of Eq. 28 (paper)' if self.paper else 'nominal, F_r = P A_0'}\n"
                f"  bodies    E {self.e1 / 1e9:g} and {self.e2 / 1e9:g} GPa, H {self.hardness / 1e9:.4g} GPa, "
                f"mu {self.friction:g}\n"
                f"  surface   D {self.fractal_dimension:g}, G {self.roughness:g} m, gamma {self.gamma:g}, "
                f"A_0 {1e6 * self.reference_area:g} mm^2\n"
                f"  asperity  r_m {1e6 * self.asperity_radius:g} um, R {1e6 * p['radius_m']:.4g} um, "
                f"yields at {p['s_ec_m2']:.3g} m^2; s_min {self.s_min:.3g} m^2")

    def _parameters(self):
        return np.array(astuple(self), dtype=float)

    def stiffness(self, pressure, shear=0.0, area=None):
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

    def derivatives(self, pressure, shear=0.0, area=None):
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
        p, q, a = np.broadcast_arrays(pressure, shear, area)
        flat = [np.ascontiguousarray(x, dtype=float).ravel() for x in (p, q, a)]
        k_n, k_t, s_l, d, iterations = _engine.call("joint_facets", self._parameters(), *flat)
        if p.size and np.nanmax(flat[0]) > 0:
            for line in self.warnings(np.nanmax(flat[0])):
                warnings.warn(line, JointWarning, stacklevel=3)
        return p.shape, k_n.reshape(p.shape), k_t.reshape(p.shape), s_l.reshape(p.shape), d, iterations

    def largest_spot(self, pressure):
        """Largest contact spot s_l [m^2] under a pressure [Pa], and the Newton iterations it took."""
        _, _, _, s_l, _, iterations = self._facets(pressure, 0.0, None)
        return s_l, iterations

    def warnings(self, pressure):
        """What does not hold under the largest pressure [Pa].

        Returns
        -------
        list of str
            Empty inside the range.
        """
        text = _engine.call("joint_warnings", self._parameters(), float(pressure))
        return (text.decode() if isinstance(text, bytes) else str(text)).split("\n") if text.strip() else []

    def closure(self, pressure, zero_pressure=1e3):
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

    def pressure(self, closure, zero_pressure=1e3):
        """Inverse of `closure`: pressure [Pa] and k_N [Pa/m], smooth and positive for every approach [m]."""
        return self._normal_law(closure, zero_pressure, 1)

    def _normal_law(self, x, zero_pressure, inverse):
        x = np.asarray(x, dtype=float)
        y, k = _engine.call("joint_normal_law", self._parameters(), zero_pressure, inverse, np.ascontiguousarray(x).ravel())
        return y.reshape(x.shape), k.reshape(x.shape)

    def shear(self, pressure, displacement):
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
        p, u = np.broadcast_arrays(np.asarray(pressure, dtype=float), np.asarray(displacement, dtype=float))
        q, k, slips = _engine.call("joint_tangential_law", self._parameters(), p.ravel(), u.ravel())
        return q.reshape(p.shape), k.reshape(p.shape), slips.reshape(p.shape) > 0

    def sensitivity(self, pressure, shear=0.0, step=1e-4):
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
            if field.name == "paper":
                continue
            value = getattr(self, field.name)
            up, down = (logs(replace(self, **{field.name: value * np.exp(s)}), pressure, shear) for s in (step, -step))
            table[field.name] = tuple((up - down) / (2 * step))
        table["pressure"] = tuple((logs(self, pressure * np.exp(step), shear) - logs(self, pressure * np.exp(-step), shear))
                                  / (2 * step))
        return dict(sorted(table.items(), key=lambda item: -abs(item[1][0])))

    def samples(self, d_error, ln_g_error, correlation=0.0, count=400, seed=1):
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

    def band(self, pressure, shear=0.0, *, level=0.95, **errors):
        """K_N and K_T with a band from the standard errors of D and G.

        Parameters
        ----------
        pressure, shear : array_like
            [Pa].
        level : float
            Probability inside the band.
        **errors
            As in `samples`.

        Returns
        -------
        dict
            "k_n" and "k_t": each (low, median, high) [N/m] over the pressures.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", JointWarning)
            values = np.array([joint.stiffness(pressure, shear) for joint in self.samples(**errors)])
        quantiles = np.quantile(values, [(1 - level) / 2, 0.5, (1 + level) / 2], axis=0)
        return {"k_n": tuple(quantiles[:, 0]), "k_t": tuple(quantiles[:, 1])}

    def plot(self, pressure=None, axis=None):
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
        from .plot import plot_joint

        return plot_joint(self, np.logspace(4, 9, 200) if pressure is None else np.asarray(pressure), axis)

    def parts(self, s_l, tau=0.0):
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

    def asperity(self, depth=0.0, area=0.0, tau=0.0, smooth=False):
        """One asperity (Eq. 3-16): its properties, and its state at a depth or at an area.

        Parameters
        ----------
        depth : float
            Depth eps [m].
        area : float
            Area of the spot [m^2].
        tau : float
            Shear stress on the spot [Pa].
        smooth : bool
            Blend the jumps of the Kogut-Etsion branches by depth (C1, over 10 % of the depth on both sides).

        Returns
        -------
        properties : dict
            e_star_pa, g_prime_pa, hardness_pa, hardness_factor, amplitude_m, radius_m, eps_ec_m, s_ec_m2, f_ec_n.
        by_depth : ndarray (3,)
            Area [m^2], load [N], stiffness [N/m].
        by_area : ndarray (3,)
            Load [N], normal and tangential stiffness [N/m].
        """
        keys = ("e_star_pa", "g_prime_pa", "hardness_pa", "hardness_factor", "amplitude_m", "radius_m", "eps_ec_m", "s_ec_m2",
                "f_ec_n")
        properties, by_depth, by_area = _engine.asperity(self._parameters(), depth, area, tau, int(smooth))
        return dict(zip(keys, properties)), by_depth, by_area
