# SPDX-License-Identifier: GPL-3.0-or-later
"""Theory or boundary elements: what of the surface and of the pressures decides, and how far single maps lie from the theory."""
from __future__ import annotations

import numpy as np

from .. import _engine

__all__: list[str] = []
LAY = 0.6           # isotropy below which a surface has a lay
SKEW = 0.7          # skewness beyond which heights are not those of random waves
WORN, PEAKED = 0.5, 1.9   # height of the crests over that of random waves where a map is none of them (77 such: 0.53 to 1.7)
# The engine's rule (hd_persson_error): TRUST, ln k_N within which the theory must hold 95 of 100 single maps to be taken; STEEP,
# E* slope over hardness beyond which boundary elements may not converge; rms errors of ln k_N over touching waves
(TRUST, STEEP), *_errors = _engine.ask("theory_rule")
SCATTER = tuple(zip(*_errors))
# ln k_N within which 95 of 100 maps lie per ln of their crests' height, over true contact (bench/joint_law.py fit); from CLOSING on
# a crest counts as worn to a third at most, since the valleys decide
SKEWED = ((0.0027, 0.0067, 0.02, 0.054, 0.13, 0.27, 0.49, 0.67, 0.83, 0.93, 0.98),
          (1.2, 1.1, 0.86, 0.84, 0.72, 0.48, 0.35, 0.19, 0.53, 1.2, 2.7))
CLOSING = 0.75


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
    return _engine.ask("theory_scatters", np.atleast_1d(np.asarray(area, dtype=float)), float(waves))


def half_width_of(area: np.ndarray, waves: float, crests: float = 1.0) -> np.ndarray:
    """Half width of ln k_N by theory that holds 95 of 100 single maps: phases of few waves, crests of other than random waves.

    Parameters
    ----------
    area, waves :
        As of `scatter_of`.
    crests : float
        Height of the crests over that of random waves (`spectrum.crests`).
    """
    worn = abs(np.log(crests))
    by_crests = np.where(area < CLOSING, worn, min(worn, 1.0)) * np.interp(area, *SKEWED)
    return np.hypot(1.96 * scatter_of(area, waves), by_crests)


def doubts(facts: dict, pressure: np.ndarray, area: np.ndarray, waves: float, steepness: float = 0.0) -> list[str]:
    """Where the theory is outside its validity, and why.

    Parameters
    ----------
    facts : dict
        Of the map (`of_map`), of two of their sum (`of_sum`).
    pressure, area : ndarray
        Pressures [Pa] and the true contact that the theory expects.
    waves : float
        Independent waves of the equivalent surface (`Spectrum.waves`).
    steepness : float
        E* slope over hardness.
    """
    found = []
    if steepness > STEEP:
        found.append(f"E* times slope is {steepness:.2g} hardnesses: nearly all contact yields, where the error is not known and "
                     "boundary elements may not converge")
    lay, skew, crests = (facts[key] for key in ("isotropy", "skewness", "crests"))
    if lay < LAY:
        found.append(f"the surface has a lay (slopes differ by {lay**-0.5:.1f} in two directions), the theory takes the mean of "
                     "all directions, and k_N may differ by a factor of 3")
    if abs(skew) > SKEW:
        found.append(f"skewness {skew:.2f}: not the heights of random waves, which the theory takes")
    elif not WORN < crests < PEAKED:
        found.append(f"crests {crests:.2f} times as high as those of random waves, which the theory takes")
    half = 1.96 * scatter_of(area, waves)
    if half.max() > TRUST:
        at, enough = int(half.argmax()), pressure[half <= TRUST]
        hint = f"; from {enough[0] / 1e6:.3g} to {enough[-1] / 1e6:.3g} MPa the theory would do (--pressure)" if enough.size else ""
        found.append(f"at {pressure[at] / 1e6:.3g} MPa {100 * area[at]:.2g} % of the area touches, of {waves:.0f} independent "
                     f"waves: single maps differ by up to {100 * half[at]:.0f} % from the theory{hint}")
    return found


def choose(facts: dict, pressure: np.ndarray, area: np.ndarray, waves: float, steepness: float = 0.0) -> tuple[str, str]:
    """Theory or boundary elements, with the reason; arguments as of `doubts`.

    Returns
    -------
    model, reason : str
    """
    against = doubts(facts, pressure, area, waves, steepness)
    if against:
        return "spectrum" if steepness > STEEP else "boundary_elements", against[0]
    return "spectrum", (f"{100 * area[0]:.2g} to {100 * area[-1]:.2g} % of the area touches, of {waves:.0f} independent waves, "
                        "isotropic, no marked skewness")
