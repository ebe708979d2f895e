# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as the tables of docs/evidence show them."""

NARROW = "\u202f"  # a space that does not break


def rounded(value, digits=0):
    """A number without a minus before zero."""
    text = f"{value:,.{digits}f}".replace(",", NARROW)
    return text.lstrip("-") if not text.strip("-0.") else text


def percent(value, digits=1, sign="+"):
    """A share or a difference in per cent, 'below ...' where nothing is left after rounding."""
    text = f"{100 * value:{sign}.{digits}f} %"
    return text if float(text[:-2]) else f"below {10**-digits:g} %"


def short(value):
    """One digit and a power of ten."""
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e+")


# --- elements and closed solutions
