#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Does a shell model of the cup on the ring earn its place? First estimates beside the engine's own coarsest mesh.

Model: the wall as a thin cylindrical shell (Love), harmonics round the axis, elements along it, held at the bottom (v = w = 0); the
ring follows the wave generator and gives way through its thickness; no friction, contact by active sets. K_TS by the joint with shear
just below mu p. Scenes: CD-14-100 and random scenes of promised_scenes.py without eccentricity. Truth: the engine on 92 x 16 facets with
edge cells of 30 um. Start values: share of that mesh's facets whose open or closed state is foretold wrongly.

Usage: bench/ring_model.py [--count 6]; writes bench/results/ring_model.json, prints Markdown.
"""
import argparse
import time

import numpy as np
from promised_scenes import draw

import hdengine
from common import ROOT, write_record
from hdengine.results import row_edges

MESHES = {"engine, 24 x 4": {"divisions": 24, "band_facets": 4, "edge_length": 30e-6},
          "truth": {"divisions": 92, "band_facets": 16, "edge_length": 30e-6}}


def stations(s, rows):
    """Ends of the elements along the wall, and which of them lie in the band (rows of equal length) [m]."""
    start, length = s["geometry.band_start"], s["geometry.band_length"]
    end = s["geometry.cup_length"] - s["geometry.bottom_thickness"] / 2
    h = length / rows
    z = np.concatenate([np.linspace(0, start, 3)[:-1], start + h * np.arange(rows), np.linspace(start + length, end, 13)])
    return z, slice(2, 3 + rows)


def shell_stiffness(s, z, n):
    """Stiffness of harmonic n; dofs u, v, w, w' per station."""
    e, nu, r = s["material.flexspline_e"], s["material.flexspline_nu"], s["geometry.bore_radius"]
    k = np.zeros((4 * len(z), 4 * len(z)))
    for i, (a, b) in enumerate(zip(z, z[1:])):
        h = b - a
        rim = 0.5 * (a + b) < s["geometry.rim_length"]
        t = s["geometry.rim_thickness"] if rim else s["geometry.wall_thickness"]
        c, d = e * t / (1 - nu**2), e * t**3 / 12 / (1 - nu**2)
        law = np.zeros((6, 6))
        law[:2, :2] = c * np.array([[1, nu], [nu, 1]])
        law[3:5, 3:5] = d * np.array([[1, nu], [nu, 1]])
        law[2, 2], law[5, 5] = c * (1 - nu) / 2, d * (1 - nu) / 2
        for x, weight in zip(*np.polynomial.legendre.leggauss(3)):
            x, f = 0.5 * (x + 1), np.zeros((6, 8))
            lin, slope = np.array([1 - x, x]), np.array([-1, 1]) / h
            w = np.array([1 - 3 * x**2 + 2 * x**3, h * (x - 2 * x**2 + x**3), 3 * x**2 - 2 * x**3, h * (x**3 - x**2)])
            w1 = np.array([-6 * x + 6 * x**2, h * (1 - 4 * x + 3 * x**2), 6 * x - 6 * x**2, h * (3 * x**2 - 2 * x)]) / h
            w2 = np.array([-6 + 12 * x, h * (-4 + 6 * x), 6 - 12 * x, h * (6 * x - 2)]) / h**2
            u, v, ws = [0, 4], [1, 5], [2, 3, 6, 7]
            f[0, u] = slope
            f[1, v], f[1, ws] = n * lin.mean() / r, w / r  # constant in v: no membrane locking
            f[2, u], f[2, v] = -n * lin / r, slope
            f[3, ws] = -w2
            f[4, v], f[4, ws] = n * lin / r**2, n**2 * w / r**2
            f[5, v], f[5, ws] = 2 * slope / r, 2 * n * w1 / r
            k[4 * i:4 * i + 8, 4 * i:4 * i + 8] += 0.5 * weight * h * r * np.pi * (2 if n == 0 else 1) * f.T @ law @ f
    return k


def ring_model(s, rows=16, columns=24, harmonics=16):
    """Pressure on (angle in a quarter, station in the band) and what follows from it."""
    r, mu = s["geometry.bore_radius"], s["contact.friction"]
    z, band = stations(s, rows)
    theta = (np.arange(columns) + 0.5) * np.pi / 2 / columns
    length = np.gradient(z)[band]
    length[[0, -1]] /= 2
    area = np.tile(r * np.pi / 2 / columns * length, (columns, 1))
    m = len(length)
    flexible = np.zeros((columns, m, columns, m))
    for n in range(0, 2 * harmonics, 2):
        k = shell_stiffness(s, z, n)
        held = [len(k) - 3, len(k) - 2] + ([len(k) - 4, *range(1, len(k), 4)] if n == 0 else [])
        free = np.setdiff1d(np.arange(len(k)), held)
        inverse = np.linalg.inv(k[np.ix_(free, free)])
        w = np.searchsorted(free, np.arange(band.start, band.stop) * 4 + 2)
        wave = np.cos(n * theta)
        flexible += 4 * np.einsum("a,ij,b->aibj", wave, inverse[np.ix_(w, w)], wave)  # four quarters load each harmonic alike
    a = (flexible.reshape(columns * m, -1) * area.ravel())
    soft = s["geometry.ring_thickness"] / s["material.ring_e"] + s["geometry.wall_thickness"] / s["material.flexspline_e"]
    a[np.diag_indices_from(a)] += soft
    aim = np.repeat(s["wave_generator.w"] * np.cos(2 * theta) + s["wave_generator.interference"], m)
    p, closed = np.zeros_like(aim), aim > 0
    for iteration in range(60):
        p[:] = 0
        p[closed] = np.linalg.solve(a[np.ix_(closed, closed)], aim[closed])
        new = np.where(closed, p > 0, aim - a @ p > 0)
        if np.array_equal(new, closed):
            break
        closed = new
    p = np.maximum(p, 0).reshape(columns, m)
    joint = hdengine.Joint.of_scene(s)
    _, k_t = joint.stiffness(p.ravel(), (1 - 1e-6) * mu * p.ravel(), area.ravel())
    middle = abs(z[band] - z[band].mean()) <= 0.1 * s["geometry.band_length"]
    return {"k_ts": 4 * r**2 * k_t.sum(), "normal_force": 4 * (p * area).sum(),
            "mid_band_pressure": (p * area)[:, middle].sum() / area[:, middle].sum()}, (theta, z[band] - z[band][0], p > 0)


def engine(keys, mesh):
    """The same from the engine, and the state of its facets (angle, axis)."""
    groups = {"mesh": mesh, "load": {"assembly_steps": 1, "torque_steps": 1}}
    for key, value in keys.items():
        groups.setdefault(key.split(".")[0], {})[key.split(".")[1]] = value
    hdengine.forget()
    with hdengine.Run(ROOT / "data/cd14.nml", **groups) as run:
        for step in run:
            pass
    f, shape = step.facets, (run.facets // run.axial_facets, run.axial_facets)
    edges = row_edges(f["area_m2"], shape, keys.get("geometry.band_length", 12e-3))
    values = {"k_ts": step.k_ts_nm_per_rad, "normal_force": step.sums["normal_force_n"],
              "mid_band_pressure": step.sums["pressure_mid_mean_pa"]}
    return values, (f["theta_rad"].reshape(shape)[:, 0], 0.5 * (edges[1:] + edges[:-1]), f["pressure_pa"].reshape(shape) > 0)


def wrong(guess, truth):
    """Share of the facets whose state the nearest point of a guess misses."""
    theta, z, closed = truth
    angle = np.arcsin(abs(np.sin(theta))) if len(guess[0]) == 24 and guess[0].max() < np.pi / 2 else theta
    i = abs(angle[:, None] - guess[0]).argmin(1)
    j = abs(z[:, None] - guess[1]).argmin(1)
    return float(np.mean(guess[2][np.ix_(i, j)] != closed))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=6)
    count = parser.parse_args().count
    scenes, i = [{}], 0
    while len(scenes) < count:
        keys = {k: v for k, v in draw(i)[1].items() if not isinstance(v, str)}
        if keys["wave_generator.eccentricity"] == 0:
            scenes.append(keys)
        i += 1
    rows = []
    for keys in scenes:
        s = hdengine.read_scene(ROOT / "data/cd14.nml", **{k.replace(".", "__"): v for k, v in keys.items()})
        answers = {}
        for name in ("ring model", *MESHES):
            start = time.process_time()
            answers[name] = (*(ring_model(s) if name == "ring model" else engine(keys, MESHES[name])), time.process_time() - start)
        truth = answers.pop("truth")
        rows.append({"keys": keys, "truth_s": truth[2]} | {name: {
            **{f"error_{k}": v / truth[0][k] - 1 for k, v in values.items()}, "wrong_states": wrong(state, truth[1]), "cpu_s": seconds}
            for name, (values, state, seconds) in answers.items()})
    write_record("ring_model", rows)
    print("| estimate | K_TS: median, largest error | normal force | mid-band pressure | wrong states | CPU time / s |")
    print("|---|---|---|---|---|---|")
    for name in ("ring model", "engine, 24 x 4"):
        part = [row[name] for row in rows]
        errors = [np.abs([p[f"error_{k}"] for p in part]) for k in ("k_ts", "normal_force", "mid_band_pressure")]
        print(f"| {name} | " + " | ".join(f"{100 * np.median(e):.0f} %, {100 * e.max():.0f} %" for e in errors)
              + f" | {100 * np.median([p['wrong_states'] for p in part]):.0f} % | {np.median([p['cpu_s'] for p in part]):.2f} |")


if __name__ == "__main__":
    main()
