#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of tables of docs/explain and of the README: each a few runs of the engine. Writes bench/results/explained.json and draws the tables.

Usage: bench/explained.py [NAME ...] | --tables; names: of RUNS, none: all of them; --tables: solves nothing, draws them of the records
"""
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from explained_tables import draw
from new_element import changed_stiffness, tube_error

from common import DATA, RESULTS, solve, write_record
from hdengine import Joint, load, surface
from hdengine.catalogue import UNITS
from hdengine.studies.planner import mesh_of_level
from hdengine.torsion import torsional_stiffness

LINEAR = {"solver.kinematics": "linear"}
BELOW_SLIP = 1 - 1e-6  # of µp: so the engine takes points that slip
PER_ROW = 8            # cells at the band's edges in a row of the planner's meshes
BAND = 12e-3           # its length in cd14.nml and drive14.nml [m]


def ended(scene, keys):
    """A run that must end well: its results, its balls and its processor time."""
    with tempfile.TemporaryDirectory() as folder:
        _, done = solve(scene, *(f"{name}={value}" for name, value in keys.items()), out=f"{folder}/r")
        if done.code != 0:
            raise SystemExit(done.text)
        result = load(f"{folder}/r")
        return result, result.balls, done.cpu_s


def wave_generators():
    """Size 14 on the planner's coarse mesh: on balls, on one even spring of their radial stiffness at the end of the loop, rigid."""
    scene = DATA / "drive14.nml"
    mesh = mesh_of_level(3, scene)
    keys = {**mesh, "mesh.edge_length": BAND / PER_ROW / mesh["mesh.band_facets"], "mesh.through_wall": 2, "mesh.through_ring": 2, **LINEAR}
    names = ("k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad", "hysteresis_rad")
    on_balls, balls, _ = ended(scene, keys)
    last = balls[(balls["step"] == balls["step"].max()) & (balls["closing_m"] > 0)]
    stiffness = float(sum(1.5 * last["force_n"] / last["closing_m"]))  # of F = K closing^(3/2)
    found = {"balls": on_balls.summary}
    for name, k in (("even spring", stiffness), ("rigid", 0)):
        found[name] = ended(scene, {**keys, "bearing.balls": 0, "wave_generator.ball_stiffness": k})[0].summary
    return {"mesh": list(on_balls.shape), "ball_stiffness_n_per_m": stiffness,
            "drives": {name: {key: summary["results"][key] for key in names} for name, summary in found.items()}}


def default_scene():
    """K_TS of CD-14-100 as it stands, of size 14 on the first rise of its loop, and K2 of the catalogue."""
    scene, drive = ended(DATA / "cd14.nml", LINEAR)[0], ended(DATA / "drive14.nml", LINEAR)[0]
    ring, steps = scene.summary["results"], drive.steps
    rise = steps[:int(np.argmax(steps["torque_nm"])) + 1]
    return {"torque_nm": float(scene.torque_nm[-1]), "k2_catalogue_nm_per_rad": UNITS[14].k2_nm_per_rad,
            "tangent_nm_per_rad": ring["k_ts_tangent_nm_per_rad"], "eq45_nm_per_rad": ring["k_ts_nm_per_rad"],
            "drive": [{"torque_nm": float(s["torque_nm"]), "tangent_nm_per_rad": float(s["k_ts_tangent_nm_per_rad"])} for s in rise if s["torque_nm"] > 0]}


def ring_tangent():
    """Who carries the torque: CD-14-100 on 44 x 8 facets with its ring held and sliding."""
    names = ("hub_torque_nm", "wave_generator_torque_nm", "ring_spring_torque_nm", "normal_force_n", "rotation_rad")
    keys = {"mesh.divisions": 44, "mesh.band_facets": 8, **LINEAR}
    found = {choice: ended(DATA / "cd14.nml", {**keys, "wave_generator.ring_tangent": choice})[0] for choice in ("follow", "free", "auto")}
    return {choice: {name: result.summary["results"][name] for name in names} for choice, result in found.items()}


def planned():
    """CD-14-100 by tolerance, and once with large displacements: the mesh, its time and the limit of the tangent."""
    rows = []
    for tolerance, keys in ((0.1, LINEAR), (0.03, LINEAR), (0.01, LINEAR), (0.03, {})):
        result, _, cpu_s = ended(DATA / "cd14.nml", {"run.tolerance": tolerance, **keys})
        scene = result.scene
        rows.append({"tolerance": tolerance, "kinematics": scene["solver.kinematics"], "mesh": list(result.shape), "layers": scene["mesh.through_wall"],
                     "cpu_s": round(cpu_s, 2), "k_ts_tangent_nm_per_rad": result.summary["plan"]["k_ts_tangent_nm_per_rad"]})
    return rows


# --- the joint

def exponents():
    """D ln K_T / d ln p just below slip, from 10 to 300 MPa: least and most."""
    pressure = np.geomspace(10e6, 300e6, 40)
    joints = {"default": Joint(), "elastic": Joint(hardness=1e15), "D 2.1": Joint(fractal_dimension=2.1, asperity_radius=2e-4)}
    found = {}
    for name, joint in joints.items():
        shear = BELOW_SLIP * joint.friction * pressure
        _, by_p, by_q = joint.derivatives(pressure, shear)
        power = (pressure * by_p + shear * by_q) / joint.stiffness(pressure, shear)[1]
        found[name] = [float(power.min()), float(power.max())]
    return found


def own_pressures(result, corner):
    """Pressures of the nodes at the corners of the facets (facets, 4) [Pa]: where those given are power means of them, they follow from the
    facets' means, which are the means of the nodes' own."""
    columns, rows = result.shape
    column, row = np.divmod(np.arange(columns * rows), rows)
    after = (column + 1) % columns
    node = np.stack([column * (rows + 1) + row, after * (rows + 1) + row, after * (rows + 1) + row + 1, column * (rows + 1) + row + 1], -1)
    means, pressure = result.contact["pressure_pa"][-1], np.zeros(columns * (rows + 1))
    pressure[node] = corner
    lower = abs(means - corner.mean(1)) > 1e-7 * np.maximum(means, 1)
    unknown = np.unique(node[lower])
    unknown = unknown[pressure[unknown] > 0]
    facets = np.flatnonzero(lower)
    matrix = (node[facets][:, :, None] == unknown).mean(1)
    more = np.linalg.lstsq(matrix, (means - corner.mean(1))[facets], rcond=None)[0]
    pressure[unknown] += np.maximum(more, 0)
    return pressure[node]


def pressure_used():
    """K_TS of CD-14-100 by Eq. 45 on 8 rows with cells of 30 µm at the edges: by the power means that a run takes, by the corners' own pressures,
    by the facets' means; and by power means on 46 rows."""
    keys = {"mesh.edge_length": 30e-6, "load.assembly_steps": 1, "load.torque_steps": 1, **LINEAR}
    coarse, fine = (ended(DATA / "cd14.nml", {"mesh.divisions": n, "mesh.band_facets": m, **keys})[0] for n, m in ((44, 8), (264, 46)))
    facets = {name: column[-1] for name, column in coarse.contact.items()}
    place, normal = coarse.vectors("x_m", "y_m", "z_m")[-1], coarse.vectors("n_x", "n_y", "n_z")[-1]
    joint = coarse.joint
    corner, shear = (np.stack([facets[f"{name}_{i}_pa"] for i in range(1, 5)], -1) for name in ("pressure", "shear"))
    own = own_pressures(coarse, corner)
    own_shear = shear * np.divide(own, corner, out=np.ones_like(own), where=corner > 0)
    mean_shear = np.hypot(facets["traction_theta_pa"], facets["traction_z_pa"])

    def k_ts(p, q):
        k = joint.stiffness(p, np.minimum(q, BELOW_SLIP * joint.friction * p), facets["area_m2"].reshape(-1, *(1,) * (p.ndim - 1)))
        return float(torsional_stiffness(*(x.reshape(len(x), -1).mean(1) for x in k), place, normal))
    return {"mesh": list(coarse.shape), "mesh_of_reference": list(fine.shape), "reference": float(fine.steps["k_ts_nm_per_rad"][-1]),
            "power means": float(coarse.steps["k_ts_nm_per_rad"][-1]), "corners": k_ts(own, own_shear), "facets": k_ts(facets["pressure_pa"], mean_shear)}


# --- surface and element

def row_structure(z, lag):
    """Structure function of a periodic map, mean of both directions."""
    return 0.5 * sum(np.mean((np.roll(z, -lag, k) - z) ** 2) for k in (0, 1))


def band_limited(tau, d, g, low, high):
    """S of the isotropic surface of Eq. 1: G^(2(D-2)) times the integral of f^(-a-1) (1 - J0(2 pi f tau)) over the band."""
    f = np.exp(np.linspace(np.log(low), np.log(high), 4001))
    j0 = np.cos(2 * np.pi * tau * np.outer(np.sin((np.arange(400) + 0.5) * np.pi / 400), f)).mean(0)
    y = f ** (-2 * (3 - d)) * (1 - j0)
    return g ** (2 * (d - 2)) * np.sum((y[1:] + y[:-1]) / 2 * np.diff(np.log(f)))


def periodic_excess():
    """S of the periodic surface over the band-limited integral, less 1, by D and lag (its amplitudes do not depend on the seed)."""
    n, length, g = 512, 0.5e-3, Joint.roughness
    found = {}
    for d in (2.1, 2.3, 2.5, 2.8):
        z = surface.periodic(n, length, d, g, 4 * length / n, 3)
        found[f"{d}"] = {f"{part}": row_structure(z, n // part) / band_limited(length / part, d, g, 1 / length, n / (4 * length)) - 1
                         for part in (128, 32, 8, 2)}
    return found


def new_element():
    """Displacement of a thick tube's inner face over Lame's, less 1, by the element and Poisson's ratio."""
    with tempfile.TemporaryDirectory() as folder:
        stiffness = changed_stiffness(Path(folder))
        return {name: {f"{nu:g}": float(tube_error(stiffness, name, nu, 4)) for nu in (0.3, 0.4999)} for name in ("hex8", "hex8i", "hex8b")}


RUNS = {f.__name__: f for f in (wave_generators, default_scene, ring_tangent, planned, exponents, pressure_used, periodic_excess, new_element)}


def main(names):
    """Run, write the record, draw the tables."""
    path = RESULTS / "explained.json"
    old = json.loads(path.read_text()) if path.exists() else {"provenance": {}}
    made = old.pop("provenance")
    if names != ["--tables"]:
        names = names or list(RUNS)
        earlier = {name: made.get("earlier", {}).get(name, made.get("commit")) for name in old if name not in names}
        for name in names:
            old[name] = RUNS[name]()
            print(name, json.dumps(old[name]), flush=True)
        write_record("explained", old, threads=1, **({"earlier": earlier} if earlier else {}))
    draw()


if __name__ == "__main__":
    main(sys.argv[1:])
