# SPDX-License-Identifier: GPL-3.0-or-later
"""Stability maps of surfaces and joints, drawn by `stability.py`.

Heights are right when they are those of the direct sum, the joint of Hu et al. when it has a stiffness under load, the theory of the joint
within 25 % of boundary elements (refused: the planner takes those), the fit when two of three intervals hold D (refused: not fractal).
"""
import time
import warnings

import numpy as np
from blind_generators import field
from joint_choice import DX, RATIO
from joint_law import E_STAR, lattice, pressures, rough, scaled
from stability_peers import PATIENCE, REFUSED, RIGHT, SLOW, WRONG

from hdengine import HdengineError, Joint, surface
from hdengine.elastic import stiffness_from_spectrum
from hdengine.prediction.choice import TRUST, choose
from hdengine.prediction.half_space import HalfSpace
from hdengine.prediction.spectrum import of_map
from hdengine.surfaces import roughness

SEEDS = 3         # maps of a cell of the fit


def heights(quick):
    """Heights: D and gamma."""
    x = [2.0001, 2.01, 2.1, 2.5, 2.9, 2.99, 2.9999][:: 2 if quick else 1]
    y = [1.001, 1.01, 1.1, 1.5, 3, 10][:: 2 if quick else 1]

    def one(d, gamma):
        given = dict(fractal_dimension=d, roughness=2.4248e-7, gamma=gamma, length=0.5e-3, shortest_wavelength=4e-6, ridges=6, seed=2)
        start = time.process_time()
        try:
            exact = surface.generate(32, 0.5e-3 / 32, **given, method="direct")
            error = max(np.abs(surface.generate(32, 0.5e-3 / 32, **given, tolerance=tol, method=m) - exact).max() / exact.std()
                        for m, tol in (("product", None), ("nufft", 1e-9)))
        except HdengineError as trouble:
            return REFUSED, str(trouble)[:160]
        if time.process_time() - start > PATIENCE:
            return SLOW, ""
        return (RIGHT, "") if error < 1e-7 else (WRONG, f"error {error:.1e}")
    return "D", x, "gamma", y, one


def joint(quick):
    """Joint of Hu et al.: D and pressure."""
    warnings.simplefilter("ignore")
    x = [2.0001, 2.01, 2.2, 2.5, 2.8, 2.99, 2.9999][:: 2 if quick else 1]
    y = [1e3, 1e5, 1e7, 1e9][:: 2 if quick else 1]

    def one(d, p):
        try:
            found = Joint(fractal_dimension=d)
            k = np.asarray(found.stiffness([p, p * 1.001], area=1e-6)[0], float)
        except HdengineError as trouble:
            return REFUSED, str(trouble)[:160]
        if not np.isfinite(k).all() or (k < 0).any():
            return WRONG, f"K_N {k[0]:.3g}"
        if not k[0] > 0:
            told = [line for line in found.warnings(p) if "K_N = K_T = 0" in line]
            return (REFUSED, f"JointWarning: {told[0]}") if told else (WRONG, "no stiffness under load, and no word of it")
        return RIGHT, f"K_N {k[0]:.3g}"
    return "D", x, "pressure / Pa", y, one


def theory(contact):
    """A map of the theory of the joint over D (the slope of the spectrum) and roll-off, at a share of true contact."""
    def make(quick):
        x, y = [2.01, 2.1, 2.3, 2.5, 2.7, 2.9, 2.99][::3 if quick else 1], [1, 2, 4, 8][::3 if quick else 1]

        def one(d, times):
            z = 1e-7 * rough(256, 3 - d, 256 / times, 6, int(1000 * d) + times)
            spectrum = scaled(lattice(z))
            p = pressures(spectrum.slope_rms, (contact,))
            k, area = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, p, E_STAR, 1e15)
            seen, facts = of_map(z, DX)
            model, reason = choose([facts], p, area, seen.waves)
            if model != "spectrum":
                return REFUSED, f"boundary elements: {reason}"
            space = HalfSpace(z, DX, E_STAR, RATIO)
            off = abs(np.log(k[0] / space.normal_stiffness(space.press(p[0]) > 0)))
            return (RIGHT if off <= TRUST else WRONG), f"off by {100 * off:.1f} %"
        return "D", x, "map / longest wave", y, one
    make.__name__ = f"theory_{1000 * contact:g}"
    make.__doc__ = f"Theory of the joint at {100 * contact:g} % of contact: D and roll-off."
    return make


def fit(name, values, title):
    """A map of the fit of D, told nothing, over D and what spoils maps of 128 x 128 points."""
    def make(quick):
        x, y = [2.02, 2.1, 2.3, 2.5, 2.7, 2.9, 2.98][::3 if quick else 1], values[::3 if quick else 1]

        def one(d, amount):
            warnings.simplefilter("ignore")
            said, inside, start = [], 0, time.process_time()
            for seed in range(SEEDS):
                rng = np.random.default_rng([2911, int(1000 * d), seed])
                found = roughness.fit(*field(128, 1e-6, d, rng, finer=2, **{name: amount}))
                said += [] if found.verdict == "fractal" else [found.verdict]
                inside += found.interval[0][0] <= d <= found.interval[0][1]
            if time.process_time() - start > PATIENCE:
                return SLOW, ""
            if 2 * len(said) > SEEDS:
                return REFUSED, f"not fractal: {said[0]}"
            return (RIGHT if 2 * inside > SEEDS else WRONG), f"{inside} of {SEEDS} intervals hold D"
        return "D", x, title, y, one
    make.__name__, make.__doc__ = f"fit_{name}", f"Fit of D, told nothing: D and {name}."
    return make


MAPS = (heights, joint, theory(0.01), theory(0.1), fit("noise", [0, 0.05, 0.3, 1, 3], "noise / Sq"),
        fit("probe", [0, 0.5, 2, 5, 15], "probe / spacing"))
