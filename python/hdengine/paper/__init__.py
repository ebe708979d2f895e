# SPDX-License-Identifier: GPL-3.0-or-later
"""What Hu et al. (2023) state, and their forms as printed."""
