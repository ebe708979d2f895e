# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces: generator, specimens, fit of D and G, and runs without contact."""
