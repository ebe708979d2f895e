# SPDX-License-Identifier: GPL-3.0-or-later
"""From measured or generated surfaces to the law of their joint."""
