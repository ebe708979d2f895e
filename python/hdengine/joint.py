# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint of two rough surfaces (Eq. 3-44): stiffness from pressure, vectorised."""
from dataclasses import astuple, dataclass
from math import pi

import numpy as np

from . import _engine


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
        """
        area = self.reference_area if area is None else area
        p, q, a = np.broadcast_arrays(pressure, shear, area)
        flat = [np.ascontiguousarray(x, dtype=float).ravel() for x in (p, q, a)]
        k_n, k_t, *_ = _engine.call("joint_facets", self._parameters(), *flat)
        return k_n.reshape(p.shape), k_t.reshape(p.shape)

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

    def asperity(self, depth=0.0, area=0.0, tau=0.0):
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
        keys = ("e_star_pa", "g_prime_pa", "hardness_pa", "hardness_factor", "amplitude_m", "radius_m", "eps_ec_m", "s_ec_m2",
                "f_ec_n")
        properties, by_depth, by_area = _engine.asperity(self._parameters(), depth, area, tau)
        return dict(zip(keys, properties)), by_depth, by_area
