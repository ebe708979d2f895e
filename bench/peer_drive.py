#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small whole drive in hdengine and in CalculiX, on the same mesh, in one run: loads of balls, shares of teeth, turn of the bottom.

Needs the Debian package calculix-ccx and the Python package meshio. CalculiX solves the mesh that hdengine wrote (C3D8I, ring and cup
merged at their contact), with SPRINGA elements by tables for balls and flanks. Usage: bench/peer_drive.py
"""
import subprocess
import tempfile
from pathlib import Path

import meshio
import numpy as np

from common import ROOT, measured, program, read_prints, solve, write_record
from hdengine.export.cards import body_cards, equation_cards, node_cards, set_cards, strut_cards
from hdengine.export.deck import flank_weights
from hdengine.table_file import read_csv

KEYS = {"mesh.divisions": 48, "mesh.band_facets": 8, "bearing.balls": 16, "bearing.patch_length": 1e-9, "bearing.patch_width": 1e-9,
        "contact.mode": "bonded", "wave_generator.interference": 0, "loop.torques": 8, "load.torque_steps": 2, "loop.torque_1": 4, "loop.torque_2": 8, "load.assembly_steps": 1,
        "output.vtu": "last", "solver.tolerance": 1e-10, "load.spline_root_diameter": 37e-3}
BORE, RING, HUB, RIM, RIM_LENGTH = 17.5, 16.5, 8.0, 17.927, 9.0  # mm
ARM = 18.08  # mm, amid the teeth: (17.86 + 37 / 2 - W) / 2
TEETH, PAIRS, RATE, CLEARANCE, ANGLE = 200, 40, 1.25e5, 0.01, np.radians(25)  # -, -, N/mm, mm, rad
W, TORQUES = 0.2, (4000.0, 8000.0)  # mm, N mm
FAR = 1.0  # mm: flanks before the teeth touch
NEAR = 1e-6


def tooth_places():
    """Angles of the pairs and their clearances [rad, mm]: half of them about each end of the long axis."""
    half = PAIRS // 2
    k = np.arange(half) - (half - 1) / 2
    gap = CLEARANCE * (2 * k / (half - 1)) ** 2
    return np.r_[k, k] * 2 * np.pi / TEETH + np.repeat([0, np.pi], half), np.r_[gap, gap]


def flank_equations(points, outside, divisions):
    """Closings of the flanks by displacements in cylindrical dofs: per flank a list of (node, dof, weight)."""
    rows = flank_weights(points, outside, tooth_places()[0], divisions, (0, RIM_LENGTH), RIM, ARM, 2 * np.pi / divisions)
    return [[(n, d, f) for n, (push, tilt, shear) in weight.items()
             for d, f in ((1, np.sin(ANGLE) * push + sense * np.cos(ANGLE) * tilt), (2, sense * np.cos(ANGLE) * shear))]
            for weight in rows for sense in (1, -1)]


def write_deck(path, points, cells, body, rate, touch, turns):
    """CalculiX deck [mm, N, MPa]; `touch`: closings of the flanks when the teeth touch, None: the assembly alone [mm].
    The bottom is turned by `turns` [rad]: so every step has one solution whatever teeth are in mesh."""
    r, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    angle = np.arctan2(points[:, 1], points[:, 0])
    ring, cup = np.unique(cells[body == 1]), np.unique(cells[body == 2])
    inner = ring[abs(r[ring] - RING) < NEAR]
    middle = np.unique(np.round(z[inner], 6))
    middle = inner[abs(z[inner] - middle[len(middle) // 2]) < 1e-5]
    hub = cup[abs(r[cup] - HUB) < NEAR]
    outside = cup[(r[cup] > BORE + 0.3) & (z[cup] < RIM_LENGTH + 2)]
    divisions = KEYS["mesh.divisions"]
    n_balls = KEYS["bearing.balls"]
    balls = [int(middle[np.argmin(abs(np.exp(1j * angle[middle]) - np.exp(2j * np.pi * b / n_balls)))]) for b in range(n_balls)]
    flanks = flank_equations(points, outside, divisions)
    lines = node_cards(points, "BODY")
    for b, name, elastic in ((1, "RING", (219000, 0.30)), (2, "CUP", (209000, 0.295))):
        lines += body_cards(name, np.flatnonzero(body == b), cells[body == b], "hex8i", *elastic)
    way = 0.4 * np.linspace(0, 1, 801) ** 2
    struts, ends, ground = strut_cards(len(points), len(cells), [("BALLS", n_balls, rate * way**1.5, way), ("FLANKS", len(flanks), (0.0, RATE * FAR), (0.0, FAR))])
    lines += [*struts, "*TRANSFORM, NSET=BODY, TYPE=C", "0., 0., 0., 0., 0., 1."]
    for e, row in zip(ends, [[(b, 1, -1.0)] for b in balls] + flanks):
        lines += equation_cards([(e, 1, -1.0), *((k + 1, d, w) for k, d, w in row)])
    lines += set_cards({"HUB": hub, "ENDS": ends - 1})
    fixed = ["HUB, 1, 3", *(f"{k + 1}, 3, 3" for k in middle), "STRUTS, 2, 3", "GROUND, 2, 3", "CUBE, 1, 3"]
    way = W * np.cos(2 * angle[balls])                          # closing = way - u_r > 0 where x of the end comes above the ground's
    places = lambda offset: [f"{g}, 1, 1, {o:.12g}" for g, o in zip(ground, offset)]  # noqa: E731
    output = ["*NODE PRINT, NSET=ENDS, FREQUENCY=1000", "U", "*NODE PRINT, NSET=GROUND, FREQUENCY=1000", "RF",
              "*NODE PRINT, NSET=HUB, FREQUENCY=1000", "RF", "*END STEP"]
    lines += ["*STEP, INC=1000", "*STATIC", "0.1, 1., 1e-6, 0.1", "*BOUNDARY", *fixed,
              *places(np.r_[-way, np.full(len(flanks), FAR)]), *output]
    if touch is not None:
        gaps = np.repeat(tooth_places()[1], 2)
        for turn in (0.0, *turns):
            lines += ["*STEP, INC=1000", "*STATIC", "0.1, 1., 1e-6, 0.1", "*BOUNDARY", *places(np.r_[-way, touch + gaps]),
                      f"HUB, 2, 2, {turn * HUB:.15g}", *output]
    path.write_text("\n".join(lines) + "\n")
    return n_balls, len(flanks)


def calculix(folder, mesh, rate, turns):
    """Assembly, then assembly and torque against flanks that touch; loads of balls and pairs and the turn at each torque."""
    points, cells = 1e3 * mesh.points, mesh.cells[0].data
    body = np.asarray(mesh.cell_data["body"][0]).ravel().astype(int)
    at_contact = {}
    merged = np.arange(len(points))
    for i in np.unique(cells[body == 1]):                       # bonded on equal meshes: one node instead of two
        if abs(np.hypot(*points[i, :2]) - BORE) < NEAR:
            at_contact[tuple(np.round(points[i], 6) + 0.0)] = i
    for i in np.unique(cells[body == 2]):
        merged[i] = at_contact.get(tuple(np.round(points[i], 6) + 0.0), i)
    used, inverse = np.unique(merged[cells], return_inverse=True)
    cells, points = inverse.reshape(cells.shape), points[used]
    touch = None
    for name in ("assembly", "whole"):
        n_balls, n_flanks = write_deck(folder / f"{name}.inp", points, cells, body, rate, touch, turns)
        done = measured([program("ccx", "apt-get install calculix-ccx"), "-i", name], folder, 3000)
        if done.code != 0 or "error" in done.text.lower():
            raise SystemExit(done.text[-3000:])
        blocks = [rows for _, rows in read_prints(folder / f"{name}.dat")]
        first = len(points)
        touch = np.array([blocks[0][first + n_balls + i][0] for i in range(n_flanks)])
    out = []
    for i in range(len(TORQUES)):
        _, forces, hub = blocks[3 * (i + 2):3 * (i + 3)]
        f = np.array([abs(forces[k][0]) for k in sorted(forces)])
        out.append({"balls": f[:n_balls], "pairs": f[n_balls::2] + f[n_balls + 1::2], "torque": HUB * sum(v[1] for v in hub.values())})
    assembled = np.array([abs(blocks[1][k][0]) for k in sorted(blocks[1])])[:n_balls]
    return out, assembled


def main():
    """Both codes, one record."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        summary, done = solve(ROOT / "tests/cases/pressed_drive.nml", *(f"{k}={v}" for k, v in KEYS.items()), "output.vtu=last", out=folder / "ours")
        if done.code != 0:
            raise SystemExit(done.text)
        loop, balls, teeth = (read_csv(folder / "ours" / f) for f in ("loop.csv", "balls.csv", "teeth.csv"))
        closed = balls["closing_m"] > 1e-7
        rate = float(np.median(balls["force_n"][closed] / (1e3 * balls["closing_m"][closed]) ** 1.5))
        theirs, assembled = calculix(folder, meshio.read(sorted((folder / "ours").glob("bodies_*.vtu"))[-1]), rate, loop["angle_rad"][-2:])
    forces = {"balls": balls["force_n"].reshape(-1, KEYS["bearing.balls"]), "pairs": teeth["force_n"].reshape(-1, PAIRS, 2).sum(2)}

    def row(torque, what, unit, x, y):
        x, y = np.atleast_1d(x), np.atleast_1d(y)
        return {"torque_nm": torque, "what": what, "unit": unit, "ours": float(f"{max(x):.5g}"), "calculix": float(f"{max(y):.5g}"),
                "difference": float(f"{max(abs(x - y)) / max(x):.2g}")}
    rows = [row(0, "largest ball", "N", forces["balls"][-3], assembled)]
    for i, (torque, found) in enumerate(zip(TORQUES, theirs)):
        rows += [row(torque / 1e3, what, "N", forces[key][i - 2], found[key]) for key, what in (("balls", "largest ball"), ("pairs", "largest pair of teeth"))]
        rows.append(row(torque / 1e3, "torque at the same turn", "N m", torque / 1e3, found["torque"] / 1e3))
    print(*rows, sep="\n")
    version = subprocess.run([program("ccx"), "-v"], capture_output=True, text=True).stdout.strip()
    write_record("peer_drive", {"calculix": version, "dof": summary["model"]["dof"], "rows": rows}, threads=1)


if __name__ == "__main__":
    main()
