# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: many runs of one scene, in processes side by side, and the planner's answers."""
