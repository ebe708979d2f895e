# SPDX-License-Identifier: GPL-3.0-or-later
"""Fractal rough surfaces: Weierstrass-Mandelbrot heights (Eq. 1-2) and the periodic surface of the same spectrum."""
import operator

import numpy as np

from . import _engine


def _seed(seed):
    try:
        seed = operator.index(seed)
    except TypeError:
        seed = -1
    if not 0 <= seed < 2**63:
        raise _engine.InputError("seed: must be an integer from 0 to 2^63 - 1")
    return seed


def periodic(n, length, fractal_dimension, roughness, shortest_wavelength, seed):
    """Periodic surface with the continuum spectrum of Eq. 1: isotropic, band limited, random phases.

    Parameters
    ----------
    n : int
        Points per side.
    length : float
        Period and longest wavelength [m].
    fractal_dimension : float
        D in (2, 3).
    roughness : float
        G [m].
    shortest_wavelength : float
        Short cut-off [m], at least two spacings.
    seed : int
        Seed of the phases. The same seed is the same surface at every n.

    Returns
    -------
    ndarray (n, n)
        Heights [m] with mean zero at the points ``i * length / n``; ``[row, column]`` is ``[y, x]``.

    Raises
    ------
    InputError
        A parameter is out of range.
    EngineMemoryError
        The machine's memory does not hold it.
    """
    parameters = (length, fractal_dimension, roughness, shortest_wavelength)
    _engine.call("surface_check_periodic", n, *parameters)
    heights = np.empty((n, n), order="F")
    _engine.call("surface_periodic", *parameters, _seed(seed), heights)
    return heights.T
