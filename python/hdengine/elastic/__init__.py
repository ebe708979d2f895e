# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic joints: the whole interface law from the normal stiffness per area, and that from a power spectrum."""
from .law import ElasticJoint, joint_of_scene, moduli, stiffness_from_spectrum

__all__ = ["ElasticJoint", "joint_of_scene", "moduli", "stiffness_from_spectrum"]
