# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a run for other programs: the joint of a drive for simulations of robots, the mesh with its loads for CalculiX."""
