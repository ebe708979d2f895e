# SPDX-License-Identifier: GPL-3.0-or-later
"""Theory or boundary elements: what of the surface and of the pressures decides, and how far single maps lie from the theory."""
from __future__ import annotations

import numpy as np

from .. import _engine

LAY = 0.6           # isotropy below which a surface has a lay
SKEW = 0.7          # skewness beyond which heights are not those of random waves
# The engine's rule (hd_persson_error): TRUST, ln k_N within which the theory must hold 95 of 100 single maps to be taken; STEEP,
# E* slope over hardness beyond which boundary elements may not converge; rms errors of ln k_N over touching waves
(TRUST, STEEP), *_errors = _engine.call("theory_rule")
SCATTER = tuple(zip(*_errors))


def scatter_of(area: np.ndarray, waves: float) -> np.ndarray:
    """How far k_N of a single map lies from the theory: rms of ln k_N.

    Few long waves may hold most of the height. Until a few of them touch, their phases decide k_N, which no spectrum tells.

    Parameters
    ----------
    area : ndarray
        True contact, as a share.
    waves : float
        Independent waves (`Spectrum.waves`).
    """
    return _engine.call("theory_scatters", np.atleast_1d(np.asarray(area * waves, dtype=float)))


def choose(facts: list[dict], pressure: np.ndarray, area: np.ndarray, waves: float, steepness: float = 0.0) -> tuple[str, str]:
    """Theory or boundary elements, with the reason.

    Parameters
    ----------
    facts : list of dict
        Of each map (`of_map`).
    pressure, area : ndarray
        Pressures [Pa] and the true contact that the theory expects.
    waves : float
        Independent waves of the equivalent surface (`Spectrum.waves`).
    steepness : float
        E* slope over hardness.

    Returns
    -------
    model, reason : str
    """
    if steepness > STEEP:
        return "spectrum", (f"E* times slope is {steepness:.2g} hardnesses: nearly all contact yields, where boundary elements "
                            "may not converge")
    lay, skew = min(f["isotropy"] for f in facts), max((f["skewness"] for f in facts), key=abs)
    if lay < LAY:
        return "boundary_elements", (f"the surface has a lay (slopes differ by {lay**-0.5:.1f} in two directions), the "
                                     "theory takes the mean of all directions")
    if abs(skew) > SKEW:
        return "boundary_elements", f"skewness {skew:.2f}: not the heights of random waves, which the theory takes"
    half, touches = 1.96 * scatter_of(area, waves), f"of the area touches, of {waves:.0f} independent waves"
    if half[0] > TRUST:
        enough = pressure[half <= TRUST]
        hint = f"; from {enough[0] / 1e6:.3g} MPa on the theory would do (--pressure)" if enough.size else ""
        return "boundary_elements", (f"at {pressure[0] / 1e6:.3g} MPa {100 * area[0]:.2g} % {touches}: single maps differ by up to "
                                     f"{100 * half[0]:.0f} % from the theory{hint}")
    return "spectrum", f"{100 * area[0]:.2g} to {100 * area[-1]:.2g} % {touches}, isotropic, no marked skewness"
