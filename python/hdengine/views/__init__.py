# SPDX-License-Identifier: GPL-3.0-or-later
"""What figures and reports show, not yet drawn: numbers in the units of a reader, names, colours. Needs numpy alone."""
