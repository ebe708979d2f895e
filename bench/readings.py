#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""K_TS of the scene CD-14-100 in every reading: over friction, eccentricity and torque, over the mesh, over the joint, over the torque steps, by
small and large displacements, by the tolerance of a planned run, and beside the catalogue.

Usage: bench/readings.py [PART ...]: parts of bench/results/readings.json that are solved anew; without names all of them
"""
import sys
import tempfile

import numpy as np

import hdengine
from common import DATA, short, solve, write_part

VARIED = {"as it is": {}, "e = 10 µm": {"wave_generator.eccentricity": 10e-6}, "µ = 0.05": {"contact.friction": 0.05}, "µ = 0.3": {"contact.friction": 0.3}}
EQ45, TANGENT = "k_ts_nm_per_rad", "k_ts_bonded_nm_per_rad"
PAPER = {"load.support": "hub", "wave_generator.ring_tangent": "auto"}   # what makes data/paper.nml CD-14-100 with the paper's joint
COARSE = {"divisions": 48, "band_facets": 8}
W, WALL, TORQUES = (0.05e-3, 0.1e-3, 0.2e-3, 0.3e-3), (0.25e-3, 0.36e-3, 0.6e-3), (2.5, 5.0, 10.0)


def kept(sums, *names):
    """These sums of a step."""
    return short({name: sums[name] for name in names}, 5)


def last(*names, scene="cd14.nml", **keys):
    """These sums of the last step."""
    with hdengine.Run(DATA / scene, **keys) as run:
        return kept([*run][-1].sums, *names)


def frictions():
    """Friction and eccentricity at three torques, by the paper's joint too."""
    def steps(*names, scene="cd14.nml", **keys):
        with hdengine.Run(DATA / scene, **{"load.torque": 20.0, "load.torque_steps": 20}, **keys) as run:
            return {round(s.sums["torque_nm"], 6): kept(s.sums, *names) for s in run}
    found = {what: (steps(TANGENT, **keys), steps(EQ45, "slip_share_k_ts", scene="paper.nml", **PAPER, **keys)) for what, keys in VARIED.items()}
    return {f"CD-14-100, {what}, {torque:g} N m": ours[torque] | {"paper": paper[torque]} for what, (ours, paper) in found.items() for torque in (1.0, 5.0, 20.0)}


def meshes():
    """Equal rows, and rows that shorten towards the edges, by the paper's joint too."""
    return [{"divisions": n, "band_facets": m, "edge_length_m": edge, **last(EQ45, TANGENT, "pressure_max_pa", "edge_line_load_n_per_m", mesh=(mesh := {"divisions": n, "band_facets": m, "edge_length": edge})),
             "paper": last(EQ45, scene="paper.nml", mesh=mesh, **PAPER)} for n, m, edge in ((24, 4, 0.0), (48, 8, 0.0), (96, 16, 0.0), (160, 24, 0.0), (64, 12, 1e-4), (64, 12, 5e-5), (64, 12, 2.5e-5))]


def inputs():
    """Ground rings, and the paper's surface with its own law and others."""
    cases = {"the paper's": {}, "plastic spots elastic": {"plastic_spots": "elastic"}, "r_m = 20 µm": {"asperity_radius": 20e-6},
             "r_m = 3.74 µm, s_min = 6e-13 m²": {"asperity_radius": 3.74e-6, "s_min": 6e-13},
             "s_min = 1e-13 m²": {"s_min": 1e-13}, "fitted to boundary elements (no yield)": {
                 "asperity_radius": 3.74e-6, "s_min": 2.4e-12, "hardness": 1e15}, "G / 4": {"roughness": 6.062e-8},
             "model `spectrum`": {"model": "spectrum"}}
    return {"ground to Ra 0.4 µm (`data/cd14.nml`)": last(EQ45, TANGENT, mesh=COARSE)} | {
        name: last(EQ45, TANGENT, scene="paper.nml", mesh=COARSE, joint=keys, **PAPER) for name, keys in cases.items()}


def steps():
    """Hard contact beside the joint as contact law, over the torque steps."""
    return {f"{support}, {law}, {n}": last(TANGENT, "k_fe_secant_nm_per_rad", mesh=COARSE, contact__law=law, load={"support": support, "torque_steps": n})
            for support in ("hub", "bearing") for law in ("hard", "joint") for n in (1, 5, 20)}


def by_torque(w, wall, kinematics):
    """Tangent, normal force and mid-band pressure at every torque."""
    with hdengine.Run(DATA / "cd14.nml", mesh={"divisions": 40, "band_facets": 7}, geometry={"wall_thickness": wall, "rim_thickness": 1.186 * wall},
                      wave_generator={"w": w}, load={"torque": TORQUES[-1], "assembly_steps": 2, "torque_steps": 4, "tangent_steps": "all"},
                      solver={"kinematics": kinematics}) as run:
        at = {round(s.sums["torque_nm"], 6): s for s in run}
    return np.array([[at[t].sums[name] for name in ("k_ts_bonded_nm_per_rad", "normal_force_n", "pressure_mid_mean_pa")] for t in TORQUES])


def kinematics():
    """Largest change by large displacements over w, of walls and torques."""
    rows = []
    for w in W:
        change = [abs(by_torque(w, wall, "linear") / by_torque(w, wall, "nonlinear") - 1) for wall in WALL]
        rows.append({"w_m": w, "largest": [float(f"{x:.3g}") for x in np.max(change, axis=(0, 1))]})
    return rows


def ended(scene, **keys):
    """Result of a run that must end well, and its processor time."""
    with tempfile.TemporaryDirectory() as folder:
        _, done = solve(scene, *(f"{name.replace('__', '.')}={value}" for name, value in keys.items()), "solver.kinematics=linear", out=f"{folder}/r")
        if done.code != 0:
            raise SystemExit(done.text)
        return hdengine.load(f"{folder}/r"), done.cpu_s


def planned():
    """CD-14-100 by tolerance: the mesh, its time and the limit of the tangent."""
    rows = []
    for tolerance in (0.1, 0.03, 0.01):
        result, cpu_s = ended("cd14.nml", run__tolerance=tolerance)
        rows.append({"tolerance": tolerance, "mesh": list(result.shape), "layers": result.scene["mesh.through_wall"], "cpu_s": round(cpu_s, 2),
                     "k_ts_bonded_nm_per_rad": result.summary["plan"]["k_ts_bonded_nm_per_rad"]})
    return rows


PARTS = {f.__name__: f for f in (frictions, meshes, inputs, steps, kinematics, planned)}

if __name__ == "__main__":
    for part in sys.argv[1:] or PARTS:
        found = PARTS[part]()
        print(part, found, flush=True)
        write_part("readings", part, found, threads=1)
