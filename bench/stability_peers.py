# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of bench/stability.py on which CalculiX stands beside the engine: Lame's press fit, judged by its formula."""
import shutil
import time

import contact_cases as cc
import numpy as np
import peer_contact

from hdengine import HdengineError, solid

RIGHT, REFUSED, SLOW, WRONG = "right", "refused", "slow", "wrong"
WITHIN = 0.05       # of the formula: five times what the meshes err by where the method is right
PATIENCE = 20       # CPU seconds
STIFFNESS, STICK = 1e7, 1e6


def verdict(error, seconds, trouble=""):
    """Verdict and words from the relative error to the formula."""
    if trouble:
        return (SLOW if trouble.startswith("over ") else REFUSED), trouble[:160]
    if seconds >= PATIENCE:
        return SLOW, f"{seconds:.0f} s"
    return (RIGHT, "") if error < WITHIN else (WRONG, f"off by {100 * error:.3g} %")


def fit_ours(ratio, interference):
    """Radial displacement at the interface by the engine."""
    start = time.process_time()
    try:
        found = cc.lame(24, round(24 * ratio), "hex8i", interference=interference)
    except HdengineError as trouble:
        return verdict(np.nan, 0, str(trouble))
    return verdict(found["displacement_rms"], time.process_time() - start)


def fit_peer(method, ratio, interference):
    """The same by CalculiX; n2s sees the interference as shape, the others are told it."""
    found, error = peer_contact.press_fit(method, method != "n2s", 24, round(24 * ratio), "hex8i", 3, 0.3, interference, stiffness=STIFFNESS,
                                          limit=PATIENCE)
    return verdict(error, found.seconds, found.trouble)


def torque_problem(friction, travel):
    """Rings with matching meshes; the outer one is turned by a travel at its outside, in one step after the press fit."""
    bodies, faces, polar, period = cc.two_rings(48, 48, "hex8i", 3, 0.0)
    inside, outside = polar[:, 0] < 10e-3 + 1e-9, polar[:, 0] > 30e-3 - 1e-9
    fixed = cc.fixed_z(len(polar))
    fixed[inside | outside, 1] = True
    u = np.zeros((2, len(polar), 3))
    u[1, outside, 1] = travel
    capacity = friction * cc.lame_exact(10e-6)[0] * 2 * np.pi * 20e-3**2 * 2e-3
    return bodies, faces, polar, period, fixed, u, outside, capacity


def torque_ours(friction, travel):
    """Holding torque by the engine."""
    bodies, faces, polar, period, fixed, u, outside, capacity = torque_problem(friction, travel)
    start = time.process_time()
    try:
        found = solid.contact(bodies, *faces, fixed, u, gap=np.full(len(polar), -10e-6), friction=friction, period=period)
    except HdengineError as trouble:
        return verdict(np.nan, 0, str(trouble))
    torque = (found.reaction[1, outside, 1] * polar[outside, 0]).sum()
    return verdict(abs(torque / capacity - 1), time.process_time() - start)


def torque_peer(method, friction, travel):
    """The same by CalculiX, with the increments it takes by itself."""
    bodies, faces, polar, _, fixed, u, outside, capacity = torque_problem(friction, travel)
    points, n0 = np.vstack([b.mesh.points for b in bodies]), len(bodies[0].mesh.points)
    told = method != "n2s"
    if not told:
        moved = np.flatnonzero((np.abs(polar[:, 0] - 20e-3) < 1e-9) & (np.arange(len(polar)) >= n0))
        points[moved, :2] *= 1 - 10e-6 / polar[moved, :1]
    found = peer_contact.solve(bodies, *faces, fixed, u, method=method, element="hex8i", points=points, cylindrical=True,
                               clearance=-10e-6 if told else None, friction=friction, stiffness=STIFFNESS, stick=STICK, limit=PATIENCE)
    if not found.done:
        return verdict(np.nan, found.seconds, found.trouble)
    torque = (found.reaction[outside, 1] * polar[outside, 0]).sum()
    return verdict(abs(torque / capacity - 1), found.seconds)


def fit_map(name, title, judge):
    """A map over mesh ratio and interference."""
    def make(quick):
        x, y = [0.5, 1, 1.5, 3, 10][:: 2 if quick else 1], [1e-7, 1e-6, 1e-5, 1e-4][:: 2 if quick else 1]
        return "divisions of outer / inner ring", x, "interference / m", y, judge
    make.__name__, make.__doc__ = name, title
    return make


def torque_map(name, title, judge):
    """A map over friction and travel."""
    def make(quick):
        x, y = [0.05, 0.15, 0.5, 1, 2][:: 2 if quick else 1], [1e-4, 4e-4, 1e-3][:: 2 if quick else 1]
        return "friction", x, "travel in one step / m", y, judge
    make.__name__, make.__doc__ = name, title
    return make


MAPS = [fit_map("press_fit", "Press fit of two rings: engine.", fit_ours), torque_map("press_fit_torque", "Press fit turned: engine.", torque_ours)]
if shutil.which("ccx"):
    for m in ("n2s", "s2s", "mortar"):
        MAPS += [fit_map(f"press_fit_{m}", f"Press fit of two rings: CalculiX {m}.", lambda ratio, d, m=m: fit_peer(m, ratio, d)),
                 torque_map(f"press_fit_torque_{m}", f"Press fit turned: CalculiX {m}.", lambda mu, t, m=m: torque_peer(m, mu, t))]
