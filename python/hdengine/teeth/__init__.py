# SPDX-License-Identifier: GPL-3.0-or-later
"""Clearance of tooth pairs from their profile and the deformed rim."""
