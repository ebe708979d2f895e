#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene data/peer_hub.nml in hdengine and in CalculiX, on the same mesh, in one run.

Needs the Debian package calculix-ccx and the Python package meshio. CalculiX solves the mesh that hdengine wrote: C3D8I,
surface-to-surface contact, the same steps, supports and loads. Usage: bench/peer_hub.py [--quick]: on 40 divisions, without a record
"""
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import meshio
import numpy as np

from common import ROOT, measured, program, read_prints, write_record
from hdengine.export.cards import body_cards, contact_cards, node_cards, set_cards, surface_cards

W, FRICTION, TORQUE = 0.2, 0.15, 5000.0  # mm, -, N mm
BORE, RING, HUB, BAND, RIM = 17.8, 16.8, 8.0, (1.0, 7.0), 7.0
STICK = 2e5  # slope of CalculiX's stick [N/mm3]
LIMIT = 1500  # CPU seconds
FINE = 215  # divisions


def timed(command, cwd):
    """Wall clock [s], CPU [s], peak memory [MB], output of a command; None if it hits the limit."""
    done = measured(command, cwd, LIMIT)
    return {"wall_s": done.wall_s, "cpu_s": done.cpu_s, "memory_mb": done.memory_mb, "finished": done.code is not None, "text": done.text}


def write_deck(path, points, cells, body, rim_force, stiffness=2e6):
    """CalculiX deck [mm, N, MPa] of the scene on a given mesh; steps of 4 increments each."""
    r, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    angle = np.arctan2(points[:, 1], points[:, 0])
    near = 1e-5
    ring_nodes = np.unique(cells[body == 1])
    is_ring = np.zeros(len(points), bool)
    is_ring[ring_nodes] = True
    inner = np.flatnonzero(is_ring & (abs(r - RING) < near))
    middle = inner[abs(z[inner] - np.unique(np.round(z[inner], 6))[3]) < near]
    hub = np.flatnonzero(~is_ring & (abs(r - HUB) < near))
    bore = (abs(r[cells[:, [0, 3, 4, 7]]] - BORE) < near).all(1)
    low, high = z[cells].min(1), z[cells[:, [0, 3, 4, 7]]].max(1)
    ring_cells = np.flatnonzero(body == 1)
    cup_cells = np.flatnonzero((body == 2) & bore & (low > BAND[0] - near) & (high < BAND[1] + near))
    lines = node_cards(points, "ALL")
    for b, name, elastic in ((1, "RING", (219000, 0.30)), (2, "CUP", (209000, 0.295))):
        lines += body_cards(name, np.flatnonzero(body == b), cells[body == b], "hex8i", *elastic)
    lines += set_cards({"INNER": inner, "MIDDLE": middle, "HUB": hub, "LOADED": np.flatnonzero(rim_force > 0)})
    lines += ["*TRANSFORM, NSET=ALL, TYPE=C", "0., 0., 0., 0., 0., 1."]
    lines += surface_cards("SLAVE", ((e, 3) for e in ring_cells)) + surface_cards("MASTER", ((e, 5) for e in cup_cells))
    pair = contact_cards("s2s", stiffness, FRICTION, STICK)
    lines += [line + ", ADJUST=1e-4" if line.startswith("*CONTACT PAIR") else line for line in pair]
    lines += ["*BOUNDARY", "HUB, 1, 3", "MIDDLE, 3, 3", "*STEP, INC=100", "*STATIC", "0.25, 1., 1e-5, 0.25", "*BOUNDARY"]
    for i in inner:
        lines += [f"{i + 1}, 1, 1, {W * np.cos(2 * angle[i]):.12g}", f"{i + 1}, 2, 2, {-W / 2 * np.sin(2 * angle[i]):.12g}"]
    output = ["*NODE PRINT, NSET=LOADED, FREQUENCY=100", "U", "*END STEP"]
    lines += output + ["*STEP, INC=100", "*STATIC", "0.25, 1., 1e-5, 0.25", "*CLOAD"]
    lines += [f"{i + 1}, 2, {rim_force[i]:.12g}" for i in np.flatnonzero(rim_force > 0)]
    path.write_text("\n".join(lines + output) + "\n")


def rim_weights(points, cells, body):
    """Nodal forces [N] of TORQUE as an even shear on the outside of the rim."""
    r, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    faces = cells[body == 2][:, [1, 2, 5, 6]]
    outer = (r[faces] > BORE + 0.6).all(1) & (z[faces].max(1) < RIM + 1e-5)
    f = np.zeros(len(points))
    for face in faces[outer]:
        f[face] += np.ptp(z[face])
    return TORQUE * f / np.sum(f * r)


def calculix(folder, mesh):
    """Solve the mesh in CalculiX; times, iterations, rotation."""
    points, cells = 1e3 * mesh.points, mesh.cells[0].data
    body = np.asarray(mesh.cell_data["body"][0]).ravel().astype(int)
    force = rim_weights(points, cells, body)
    write_deck(folder / "peer.inp", points, cells, body, force)
    result = timed(["ccx", "-i", "peer"], folder)
    history = (folder / "peer.cvg").read_text().split("\n") if (folder / "peer.cvg").exists() else []
    result["iterations"] = sum(1 for line in history if re.match(r"\s*\d+\s+\d+\s+\d+", line))
    steps = [{n: v[1] for n, v in rows.items()} for _, rows in read_prints(folder / "peer.dat")]   # u_theta in the local system
    rotation = [sum(force[n] * u for n, u in s.items()) / TORQUE for s in steps]
    result["rotation_rad"] = rotation[-1] - rotation[0] if len(rotation) > 1 and result["finished"] else None
    return result


def main(divisions):
    """Both codes on one mesh."""
    ccx = program("ccx", "apt-get install calculix-ccx")
    with tempfile.TemporaryDirectory() as name:
        folder, runs = Path(name), {}
        for method in ("newton", "condensed"):
            run = timed([program("hdengine.x"), ROOT / "data/peer_hub.nml", f"mesh.divisions={divisions}", f"solver.method={method}",
                         "solver.factors=exact" if method == "newton" else "solver.factors=auto", "--out", folder / method, "-q"], folder)
            summary = json.loads((folder / method / "summary.json").read_text())
            runs[f"hdengine, {method}"] = run | {k: summary["results"][k] for k in ("iterations", "rotation_rad")}
        runs["CalculiX, s2s, C3D8I"] = calculix(folder, meshio.read(sorted((folder / "newton").glob("bodies_*.vtu"))[-1]))
    for label, x in runs.items():
        x.pop("text")
        print(label, x)
    if divisions == FINE:
        write_record("peer_hub", {"calculix": subprocess.run([ccx, "-v"], capture_output=True, text=True).stdout.strip(),
                                  "dof": summary["model"]["dof"], "facets": summary["model"]["facets"], "runs": runs})


if __name__ == "__main__":
    main(40 if "--quick" in sys.argv else FINE)
