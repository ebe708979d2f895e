# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangential contact of a rough half space with Coulomb friction, by boundary elements: stick, slip and their memory.

The operator is tamaas's. The solver is this package's: tamaas 2.9 has four with friction, of which one reaches the load asked
for, and that one knows no history, so no loop (bench/joint_shear.py).
"""
from __future__ import annotations

import numpy as np

from .._engine import InputError, NotConvergedError
from .half_space import HalfSpace

__all__: list[str] = []
RESIDUAL = 1e-7   # mean violation of stick and slip over mu P, in the step that the stiffest wave allows
SLIPPING = 1e-6   # below mu P, relative, where a point slips
_MOST = 20_000    # iterations of a step


class Slider:
    """A pressed patch that is moved along the second axis of the map, step after step, under constant pressure.

    Similar materials: the shear does not change the pressure. Each step is Coulomb's law for the change of slip, solved as the
    minimum of the elastic energy over all tractions inside the circles mu p (accelerated projected gradients, restarted where they
    rise).

    Parameters
    ----------
    space : HalfSpace
    pressure : ndarray (n, m)
        Of `HalfSpace.press` [Pa].
    friction : float
        Coulomb coefficient mu.
    """

    def __init__(self, space: HalfSpace, pressure: np.ndarray, friction: float) -> None:
        if not friction > 0:
            raise InputError(f"friction {friction}: a patch that slides has one above 0")
        self._space = space
        self._most = friction * pressure[..., None]
        self._touching = (pressure > 0)[..., None]
        self._step = 1 / space.softest_shear
        self.traction = np.zeros((*pressure.shape, 2))
        self.slip = np.zeros((*pressure.shape, 2))
        self.error = 0.0

    def move(self, displacement: float) -> float:
        """Mean shear [Pa] when the rigid body stands at a displacement [m]; the slip so far is remembered.

        Raises
        ------
        NotConvergedError
            The residual was not reached.
        """
        away = -self.slip
        away[..., 1] += displacement
        t = self._solve(away)
        self.traction, self.slip = t, np.where(self._touching, away - self._space.shear_displacement(t) + self.slip, 0)
        return float(t[..., 1].mean())

    @property
    def slipping(self) -> float:
        """Share of the touching points at the limit of friction."""
        size = np.linalg.norm(self.traction, axis=-1)
        return float((size > (1 - SLIPPING) * self._most[..., 0])[self._touching[..., 0]].mean())

    def _solve(self, away):
        """Tractions inside the friction circles that hold the points where they are, or slide them along."""
        t, ahead, momentum = self.traction, self.traction, 1.0
        scale = float(self._most.mean())
        for _ in range(_MOST):
            force = away - self._space.shear_displacement(ahead)
            new = self._inside(ahead + self._step * force)
            self.error = float(abs(new - ahead).mean()) / scale
            if self.error < RESIDUAL:
                return new
            if float(((ahead - new) * (new - t)).sum()) > 0:
                momentum, ahead = 1.0, new
            else:
                later = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
                ahead, momentum = new + (momentum - 1) / later * (new - t), later
            t = new
        raise NotConvergedError(f"shear by boundary elements: residual {self.error:.2g} instead of {RESIDUAL:g}; "
                                    "take smaller steps of displacement")

    def _inside(self, t):
        """Nearest tractions inside the circles; none where nothing touches."""
        size = np.linalg.norm(t, axis=-1, keepdims=True)
        return t * (self._most / np.maximum(np.maximum(size, self._most), np.finfo(float).tiny))
