# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of runs, studies and surfaces, and the picture of the cup."""
from importlib.util import find_spec

from .._engine import InputError

if find_spec("matplotlib") is None:
    raise InputError("figures need matplotlib: pip install 'hdengine[plot]'")
