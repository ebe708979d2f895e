# SPDX-License-Identifier: GPL-3.0-or-later
"""What a chart of bench/pareto.py is made of."""
from dataclasses import dataclass


@dataclass
class Point:
    """One run of a method: relative error, CPU seconds, peak memory [MB] where it was measured."""

    method: str
    setting: str
    error: float
    seconds: float
    memory_mb: float = float("nan")
    default: bool = False
    peer: bool = False


@dataclass
class Chart:
    """A family of methods on one problem."""

    name: str
    title: str
    decides: str
    points: list


def relative(value, truth):
    """Relative error, not below rounding."""
    return float(max(abs(value / truth - 1), 1e-16))
