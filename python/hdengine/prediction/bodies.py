# SPDX-License-Identifier: GPL-3.0-or-later
"""The two bodies of a joint."""
from __future__ import annotations

from dataclasses import dataclass

from .._check import fields, number
from ..elastic import moduli
from ..joint import Joint

__all__ = ["Bodies"]


@dataclass(frozen=True)
class Bodies:
    """Elastic constants and hardness of the two bodies; defaults: those of the scene."""

    e1: float = Joint.e1
    nu1: float = Joint.nu1
    e2: float = Joint.e2
    nu2: float = Joint.nu2
    hardness: float = Joint.hardness

    def __post_init__(self) -> None:
        positive, ratio = number(above=0), number(above=-1, most=0.5)
        fields(self, e1=positive, nu1=ratio, e2=positive, nu2=ratio, hardness=positive)

    @property
    def e_star(self) -> float:
        """E* [Pa]."""
        return moduli(self.e1, self.nu1, self.e2, self.nu2)[0]

    @property
    def ratio(self) -> float:
        """k_T/k_N of full stick."""
        return moduli(self.e1, self.nu1, self.e2, self.nu2)[1]
