# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic joints: their law, and what the theory of rough contact makes of a spectrum."""
from .joint import ElasticJoint, joint_of_scene  # noqa: F401
from .law import contact_from_spectrum, moduli, stiffness_from_spectrum  # noqa: F401  (for other modules)

__all__ = ["ElasticJoint"]
