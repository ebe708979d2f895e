# SPDX-License-Identifier: GPL-3.0-or-later
"""Boundary elements of a rough half space: the one adapter of tamaas (optional, `pip install 'hdengine[bem]'`)."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from .._engine import InputError, NotConvergedError

__all__: list[str] = []
RESIDUAL = 1e-6     # of the contact problem, relative (tamaas)
SLACK = 0.01        # of a residual that counts as reached
ROUNDING = 1e-13    # of a mean pressure that is met
STAGE = 0.7         # of the largest pressure to which a stage on the way to the hardness lowers it
WHOLE = 0.99        # of the hardness, that the largest pressure came down to: nearly all yields
STIFFNESS_RESIDUAL = 1e-5   # of the linear solves for the stiffness, relative


def tamaas() -> Any:
    """The package, quiet.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        import tamaas as package
    except ImportError:
        raise InputError("boundary elements need tamaas (AGPL-3.0): pip install 'hdengine[bem]'; "
                         "--model spectrum does without it") from None
    package.set_log_level(package.LogLevel.error)
    return package


class HalfSpace:
    """A rigid rough surface on an elastic half space with the moduli of two bodies, periodic or a free patch.

    Parameters
    ----------
    heights : ndarray (n, m)
        [m], upwards into the half space; periodic across the edges (`mirrored` makes any map so), unless `free`.
    spacing : (float, float)
        [m].
    e_star : float
        Reduced modulus E* [Pa].
    ratio : float
        k_T/k_N of full stick, 4 G*/E*.
    hardness : float
        Upper bound of the pressure [Pa]; inf: elastic.
    residual : float
        Of `press`, relative.
    free : bool
        The half space goes on beyond the map, and nothing touches there: tamaas's operator on a doubled grid.
    """

    def __init__(self, heights: np.ndarray, spacing: tuple[float, float], e_star: float, ratio: float = 0.8235,
                 hardness: float = np.inf, residual: float = RESIDUAL, free: bool = False) -> None:
        self._tm = tm = tamaas()
        self.heights = np.ascontiguousarray(heights, dtype=float)
        size = [n * d for n, d in zip(self.heights.shape, spacing)]
        nu = (2 - 2 * ratio) / (2 - ratio)
        self._model = tm.ModelFactory.createModel(tm.model_type.basic_2d, size, list(self.heights.shape))
        self._model.E, self._model.nu = e_star, 0.0
        self._shear = tm.ModelFactory.createModel(tm.model_type.surface_2d, size, list(self.heights.shape))
        self._shear.E, self._shear.nu = e_star * (1 - nu**2), nu
        self._hardness, self._residual = hardness, residual
        self._solver = tm.PolonskyKeerRey(self._model, self.heights, residual)
        self.error, self.free = 0.0, free
        if free:
            tm.ModelFactory.registerNonPeriodic(self._model, "free")
            self._solver.setIntegralOperator("free")

    def press(self, pressure: float) -> np.ndarray:
        """Solve the contact under a mean pressure.

        Parameters
        ----------
        pressure : float
            [Pa].

        Returns
        -------
        traction : ndarray
            Pressure at the points [Pa].

        Raises
        ------
        NotConvergedError
            The residual was not reached.
        """
        self._model.traction[...] = pressure
        self.error = float(self._solver.solve(float(pressure)))
        traction = np.array(self._model.traction)
        bound = float(traction.max())
        while bound > self._hardness:  # by stages: from afar nearly everything would yield at once
            bound = max(STAGE * bound, self._hardness)
            traction = self._bounded(traction, float(pressure), bound)
        if not (self.error <= self._residual * (1 + SLACK) and np.isfinite(traction).all()):
            why = "; nearly all of the contact yields, which --model spectrum can do" if bound > WHOLE * self._hardness else ""
            raise NotConvergedError(f"boundary elements under {pressure:g} Pa: residual {self.error:.2g} instead of "
                                    f"{self._residual:g}{why}")
        return traction

    def _bounded(self, start, pressure, h):
        """Contact with 0 <= p <= H: Polonsky and Keer's conjugate gradients with both bounds, from the elastic solution.

        tamaas has KatoSaturated, which stalled at an error of 0.6 where the bound was not reached, returned 0 as if it had
        converged, and took 17 times as long where it was.
        """
        z = self.heights
        p = _with_mean(np.minimum(start, h), pressure, h)
        t, old, keep = np.zeros(z.shape), 1.0, 0.0
        for _ in range(400):
            gap = self._displacement_of(p) - z
            free = (p > 0) & (p < h)
            if free.sum() < 2:  # all that touches yields: it decides the approach
                free, keep = p > 0, 0.0
            gap -= gap[free].mean()
            wrong = np.where(free, abs(gap), np.where(p <= 0, np.maximum(-gap, 0), np.maximum(gap, 0)))
            self.error = float((wrong * np.maximum(p, pressure)).mean() / (pressure * z.std()))
            if self.error < self._residual:
                return p
            new = float((gap[free]**2).sum())
            t, old = np.where(free, gap + keep * new / old * t, 0), new
            r = self._displacement_of(t)
            r -= r[free].mean()
            bend = float((r * t)[free].sum())
            if not bend > 0:
                break
            step = float((gap * t)[free].sum()) / bend
            p = np.clip(np.where(free, p - step * t, p), 0, h)
            back = ((p <= 0) & (gap < 0)) | ((p >= h) & (gap > 0))
            keep = 0.0 if back.any() else 1.0
            p = _with_mean(np.where(back, np.clip(p - step * gap, 0, h), p), pressure, h)
        return p

    def _displacement_of(self, traction):
        return np.array(self._moved(traction))

    def _moved(self, traction):
        """Displacements under pressures, in the model's own array."""
        self._model.traction[...] = traction
        if self.free:
            self._model.operators["free"](self._model.traction, self._model.displacement)
        else:
            self._model.solveNeumann()
        return self._model.displacement

    def _sheared(self, traction):
        """The same of three components (n, m, 3); periodic alone."""
        if self.free:
            raise InputError("a free patch has no shear by boundary elements, since tamaas has no operator for it; valid: a "
                             "periodic map")
        self._shear.traction[...] = traction
        self._shear.solveNeumann()
        return self._shear.displacement

    @cached_property
    def bulk(self) -> float:
        """Stiffness per area of the half space under a smooth patch as large as the map [Pa/m]; periodic: inf, as the mean
        displacement is left out."""
        return self._stiffness(self._moved, np.ones(self.heights.shape)) if self.free else np.inf

    @property
    def softest_shear(self) -> float:
        """Displacement over traction of the softest wave of shear [m/Pa]."""
        model = self._shear
        return float(2 * (1 + model.nu) / model.E * max(model.boundary_system_size) / (2 * np.pi))

    def shear_displacement(self, traction: np.ndarray) -> np.ndarray:
        """Tangential displacements (n, m, 2) [m] under tangential tractions (n, m, 2) [Pa], of similar materials."""
        return np.array(self._sheared(np.pad(traction, ((0, 0), (0, 0), (0, 1))))[..., :2])

    def approach(self, traction: np.ndarray) -> float:
        """Rigid approach of the half space under pressures from `press`, from where the highest point touches [m]."""
        carrying = (traction > 0) & (traction < self._hardness)
        return float(self.heights.max() - (self.heights - self._displacement_of(traction))[carrying].mean())

    def normal_stiffness(self, touching: np.ndarray) -> float:
        """Stiffness per area when points that touch (ndarray of bool) move together along the normal [Pa/m].

        Of a free patch: of its roughness, the compliance 1/`bulk` of a smooth patch taken off.

        Raises
        ------
        NotConvergedError
            The linear solve stopped, or all touches, which leaves the roughness no compliance.
        """
        if touching.all() and not self.free:
            raise NotConvergedError("all of the map touches: its roughness gives way no more; take lower pressures")
        whole = self._stiffness(self._moved, touching.astype(float))
        if not whole < self.bulk:
            raise NotConvergedError("all of the free patch touches: its roughness gives way no more; take lower pressures")
        return 1 / (1 / whole - 1 / self.bulk)

    def tangential_stiffness(self, touching: np.ndarray) -> float:
        """The same along the second axis of the map, full stick [Pa/m]."""
        use = np.zeros((*touching.shape, 3))
        use[touching, :2] = 1
        return self._stiffness(self._sheared, use, 1)

    def _stiffness(self, moved, use, direction=None):
        """Mean traction of a unit displacement of what is used, by conjugate gradients on tamaas's half-space operator."""
        r = use.copy()
        if direction is not None:
            r[..., 1 - direction] = 0
        d, t, rr = r.copy(), np.zeros(r.shape), float((r * r).sum())
        goal = STIFFNESS_RESIDUAL**2 * rr
        for _ in range(4000):
            ad = moved(d) * use
            step = rr / float((d * ad).sum())
            t += step * d
            r -= step * ad
            rr, old = float((r * r).sum()), rr
            if rr < goal:
                return float(t.mean() if direction is None else t[..., direction].mean())
            d = r + rr / old * d
        raise NotConvergedError("stiffness by boundary elements: the linear solve kept a residual of "
                                f"{(rr / goal)**0.5 * STIFFNESS_RESIDUAL:.2g} instead of "
                                f"{STIFFNESS_RESIDUAL:g}; take a map of fewer points, or --model spectrum")


def _with_mean(p, mean, most):
    """Pressures between 0 and `most` with a given mean."""
    for _ in range(50):
        free, lacks = (p > 0) & (p < most), (mean - p.mean()) * p.size
        if abs(lacks) <= ROUNDING * mean * p.size:
            break
        if lacks < 0 and not p[free].sum() > -lacks:
            return p * (mean / p.mean())
        if free.any():
            p = np.minimum(np.where(free, p * (1 + lacks / p[free].sum()), p), most)
        else:
            p = np.where(p <= 0, lacks / max((p <= 0).sum(), 1), p)
    return p


def mirrored(z: np.ndarray) -> np.ndarray:
    """A map continued evenly across its edges: periodic, with the map's own heights and no jump."""
    z = np.concatenate([z, z[::-1]], axis=0)
    return np.concatenate([z, z[:, ::-1]], axis=1)


def stiffness_on_map(heights: np.ndarray, spacing: tuple[float, float], pressure: Sequence[float] | np.ndarray, e_star: float,
                     ratio: float, hardness: float = np.inf, tangential: bool = True,
                     tell: Callable[[float], None] | None = None, free: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness per area of a periodic map, or of a free patch, under pressures.

    Parameters
    ----------
    heights : ndarray (n, m)
        Periodic, unless `free` [m].
    spacing : (float, float)
        [m].
    pressure : sequence of float
        Rising [Pa].
    e_star, ratio, hardness : float
        As `HalfSpace`.
    tangential : bool
        Also k_T, about as long again; without it ratio times k_N.
    tell : callable, optional
        Takes each pressure that is done.
    free : bool
        As `HalfSpace`; k_T is then ratio times k_N.

    Returns
    -------
    k_n, k_t, area : ndarray
        [Pa/m], [Pa/m], share of the area that touches (`corrected_area`).
    """
    space = HalfSpace(heights, spacing, e_star, ratio, hardness, free=free)
    rows = []
    for p in pressure:
        touching = space.press(p) > 0
        k_n = space.normal_stiffness(touching)
        k_t = space.tangential_stiffness(touching) if tangential and not free else ratio * k_n
        rows.append((k_n, k_t, corrected_area(touching, free)))
        if tell:
            tell(float(p))
    k_n_all, k_t_all, areas = np.array(rows).T
    return k_n_all, k_t_all, areas


def corrected_area(touching: np.ndarray, free: bool = False) -> float:
    """Share that touches with the grid's excess along the rim of spots removed: A - (pi - 1 + ln 2)/24 S_d h (arXiv 1701.02727).

    The edge of a free patch is no such rim.
    """
    rim = (np.diff(touching, axis=0).sum() + np.diff(touching, axis=1).sum() if free else
           sum((touching != np.roll(touching, 1, axis)).sum() for axis in (0, 1)))
    return float((touching.sum() - (np.pi - 1 + np.log(2)) / 24 * rim) / touching.size)
