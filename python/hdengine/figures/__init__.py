# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of runs, studies and surfaces, and the picture of the cup."""
