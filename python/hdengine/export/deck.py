# SPDX-License-Identifier: GPL-3.0-or-later
"""A run as a CalculiX deck on its own mesh: what the run loads it with, and in its head what the run found.

The ring's inner face and the bottom of the cup move as in the run; forces of the teeth, or the even shear of the rim, come from the
run. CalculiX is asked for the forces that these ways take: torque at the bottom, force of every ball.
"""
from __future__ import annotations

from pathlib import Path

import numpy as np

from .._engine import FileError, InputError
from .._types import RunLike
from .cards import SIDES, body_cards, contact_cards, node_cards, set_cards, surface_cards

STIFF = 2e6   # slope of pressure over closure in place of hard contact [N/mm3]
STICK = 2e5   # slope of shear over slip before it slips [N/mm3]
MM = 1e3


def _grid(path):
    """A grid that the run wrote."""
    try:
        import meshio
    except ImportError:
        raise InputError("a CalculiX deck needs meshio, which reads the run's grids: pip install 'hdengine[export]'") from None
    return meshio.read(path)


class _Mesh:
    """Both bodies, with the sides of their elements that lie free, by where they look."""

    def __init__(self, grid, scene):
        self.points, self.cells = grid.points, grid.cells[0].data
        self.body = np.asarray(grid.cell_data["body"][0]).ravel().astype(int)
        self.element, self.scene = scene["mesh.element"], scene
        sides = np.concatenate([self.cells[:, side] for side in SIDES])
        _, which, count = np.unique(np.sort(sides, 1), axis=0, return_inverse=True, return_counts=True)
        free = np.flatnonzero(count[which.ravel()] == 1)
        self.sides, self.of, self.number = sides[free], free % len(self.cells), free // len(self.cells)
        middle = self.points[self.sides].mean(1) - self.points[self.cells[self.of]].mean(1)
        self.outward = (middle[:, :2] * self.points[self.sides].mean(1)[:, :2]).sum(1) / np.hypot(
            *self.points[self.sides].mean(1)[:, :2].T) / np.linalg.norm(middle, axis=1)
        self.z = self.points[self.sides][..., 2]

    def facing(self, body, sense, from_z=-1.0, to_z=np.inf):
        """Free sides of a body that look outwards (1) or inwards (-1) between two heights."""
        return np.flatnonzero((self.body[self.of] == body) & (sense * self.outward > 0.7) & (self.z.min(1) < to_z - 1e-9)
                              & (self.z.max(1) > from_z + 1e-9))

    def nodes(self, sides):
        """Their nodes, those between corners too."""
        corners = np.unique(self.sides[sides])
        if self.cells.shape[1] == 8:
            return corners
        edges = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
        chosen = np.zeros(len(self.points), bool)
        chosen[corners] = True
        for s in sides:
            cell, on = self.cells[self.of[s]], set(SIDES[self.number[s]])
            chosen[[cell[8 + k] for k, (a, b) in enumerate(edges) if a in on and b in on]] = True
        return np.flatnonzero(chosen)


def flank_weights(points: np.ndarray, outside: np.ndarray, theta: np.ndarray, divisions: int, rim_length: float,
                  arm: float) -> list:
    """Share of each node in the load of each pair of teeth: even along the rim, linear between meridians, with a given arm.

    Parameters
    ----------
    points : ndarray (n, 3)
    outside : ndarray of int
        Corner nodes of the rim's outside.
    theta : ndarray (pairs,)
        Places of the pairs [rad].
    divisions : int
        Meridians of the mesh.
    rim_length, arm : float
        Loaded length from the opening; moment of a unit tangential force. In the unit of the points.

    Returns
    -------
    list of dict
        Node to weight.
    """
    r, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    sector = np.round(np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi) * divisions).astype(int) % divisions
    scale = np.ptp(z[outside])
    heights = np.unique(np.round(z[outside] / scale, 9)) * scale
    along = np.zeros(len(heights))
    for i in range(len(heights) - 1):
        whole = heights[i + 1] - heights[i]
        part = np.clip((rim_length - heights[i]) / whole, 0, 1)
        along[i] += whole * (part - part**2 / 2)
        along[i + 1] += whole * part**2 / 2
    rows = []
    for angle in theta:
        place = (angle / (2 * np.pi) % 1) * divisions
        low = int(np.floor(place + 1e-9))
        weight: dict = {}
        for s, share in ((low, 1 - (place - low)), (low + 1, place - low)):
            for n in outside[sector[outside] == s % divisions]:
                w = share * along[np.argmin(abs(heights - z[n]))]
                if abs(w) > 1e-12 * scale:
                    weight[int(n)] = weight.get(int(n), 0.0) + w
        factor = arm / sum(w * r[n] for n, w in weight.items())
        rows.append({n: w * factor for n, w in weight.items()})
    return rows


def _rim_forces(run, mesh, step):
    """Forces of a step on the outside of the rim (n, 3) [N]; the radial and tangential ones of teeth, or an even shear."""
    scene, points = run.scene, mesh.points
    rim = mesh.facing(2, 1, to_z=scene["geometry.rim_length"])
    theta = np.arctan2(points[:, 1], points[:, 0])
    radial, around = np.zeros(len(points)), np.zeros(len(points))
    arm, alpha = scene["geometry.bore_radius"] + scene["geometry.rim_thickness"], np.radians(scene["load.pressure_angle_deg"])
    torque = float(run.torque_nm[step])
    if scene["load.support"] in ("drive", "teeth"):
        table = run.teeth[run.teeth["step"] == run.steps["step"][step]]
        pairs = [(row["theta_rad"], row["force_n"], row["flank"]) for row in table if row["force_n"] > 0]
        sense = -1.0
    elif scene["load.torque_load"] == "teeth":
        half = scene["load.tooth_pairs"] // 2
        places = (np.arange(half) - (half - 1) / 2) * 2 * np.pi / scene["load.teeth"]
        force = torque / (scene["load.tooth_pairs"] * arm * np.cos(alpha))
        pairs, sense = [(a, force, 1) for a in np.r_[places, places + np.pi]], 1.0
    else:
        for s in rim:
            part = min(1.0, (scene["geometry.rim_length"] - mesh.z[s].min()) / np.ptp(mesh.z[s]))
            around[mesh.sides[s]] += part * np.ptp(mesh.z[s])
        around *= torque / max(np.sum(around * np.hypot(points[:, 0], points[:, 1])), 1e-300)
        pairs = []
    if pairs:
        rows = flank_weights(points, np.unique(mesh.sides[rim]), np.array([p[0] for p in pairs]), scene["mesh.divisions"],
                             scene["geometry.rim_length"], arm)
        for (_, force, flank), row in zip(pairs, rows):
            for n, weight in row.items():
                radial[n] -= force * np.sin(alpha) * weight
                around[n] += sense * flank * force * np.cos(alpha) * weight
    return np.stack([radial * np.cos(theta) - around * np.sin(theta), radial * np.sin(theta) + around * np.cos(theta),
                     np.zeros(len(points))], 1)


def _sets(run, mesh):
    """Nodes that the deck moves, and of them those beside each ball."""
    inside = mesh.nodes(mesh.facing(1, -1))
    cup = np.unique(mesh.cells[mesh.body == 2])
    r = np.hypot(mesh.points[:, 0], mesh.points[:, 1])
    bottom = cup[mesh.points[cup, 2] > 0.5 * mesh.points[cup, 2].max()]
    end = r[bottom].max() if r[bottom].max() > run.scene["geometry.bore_radius"] * 1.2 else r[bottom].min()  # a hat's hub is outside
    sets = {"INSIDE": inside, "HUB": bottom[abs(r[bottom] - end) < 1e-7]}
    if run.balls is not None:
        places = np.unique(run.balls["theta_rad"])
        theta = np.arctan2(mesh.points[inside, 1], mesh.points[inside, 0])
        nearest = np.argmax(np.cos(theta[:, None] - places), 1)
        sets |= {f"BALL{i + 1}": inside[nearest == i] for i in range(len(places)) if np.any(nearest == i)}
    return sets


def _found(run, step):
    """What the run says of a step, as lines of the head."""
    s = run.steps[step]
    lines = [f"step {s['step']}: torque {s['torque_nm'] * MM:.6g} N mm, turn of the bottom {s['rotation_rad']:.6g} rad, "
             f"contact's normal force {s['normal_force_n']:.6g} N"]
    if run.balls is not None:
        balls = run.balls[run.balls["step"] == s["step"]]
        order = np.argsort(balls["theta_rad"])
        lines += [f"  BALL{i + 1}: {force:.6g} N" for i, force in enumerate(balls["force_n"][order]) if force > 0]
    return lines


def to_deck(run: RunLike) -> str:
    """Text of the deck [mm, N, MPa]; a step of the deck for every grid that the run wrote.

    Parameters
    ----------
    run : Result

    Returns
    -------
    str

    Raises
    ------
    FileError
        The run wrote no grid.
    InputError
        meshio is missing.
    """
    grids = sorted(run.folder.glob("bodies_*.vtu"), key=lambda p: int(p.stem.split("_")[1]))
    if not grids:
        raise FileError(f"'{run.folder}' has no bodies_*.vtu: run again with output.vtu = 'last', or 'all' for a deck of every step")
    read = [_grid(path) for path in grids]
    steps = [int(np.flatnonzero(run.steps["step"] == int(Path(path).stem.split("_")[1]))[0]) for path in grids]
    scene, mesh = run.scene, _Mesh(read[0], run.scene)
    sets = _sets(run, mesh)
    band = scene["geometry.band_start"], scene["geometry.band_start"] + scene["geometry.band_length"]
    told = [line for step in steps for line in _found(run, step)]
    lines = ["** " + line for line in (
        f"{run.summary['title'] or run.folder.name}: the run's mesh, ways and forces, by hdengine; mm, N, MPa",
        "The .dat file holds the forces that the ways take: HUB 2 times its radius is the torque, BALLn 1 less the force of a ball.",
        "A slip path needs every step: output.vtu = 'all'. The run found:", *told)]
    lines += node_cards(MM * mesh.points, "ALL")
    for number, name, of in ((1, "RING", "ring"), (2, "CUP", "flexspline")):
        own = np.flatnonzero(mesh.body == number)
        lines += body_cards(name, own, mesh.cells[own], mesh.element, scene[f"material.{of}_e"] / 1e6, scene[f"material.{of}_nu"])
    lines += set_cards(sets)
    lines += ["*TRANSFORM, NSET=INSIDE, TYPE=C", "0., 0., 0., 0., 0., 1.", "*TRANSFORM, NSET=HUB, TYPE=C", "0., 0., 0., 0., 0., 1."]
    for name, of in (("SLAVE", mesh.facing(1, 1)), ("MASTER", mesh.facing(2, -1, *band))):
        lines += surface_cards(name, zip(mesh.of[of], mesh.number[of]))
    if scene["contact.mode"] == "bonded" or scene["load.support"] == "teeth":
        lines += ["*TIE, NAME=GLUE, POSITION TOLERANCE=0.1", "SLAVE, MASTER"]
    else:
        friction = scene["contact.friction"] * (scene["contact.mode"] == "frictional")
        lines += contact_cards("s2s", STIFF, friction, STICK, scene["wave_generator.clearance"] or -scene["wave_generator.interference"])
    moved = np.unique(np.r_[sets["INSIDE"], sets["HUB"]])
    theta = np.arctan2(mesh.points[moved, 1], mesh.points[moved, 0])
    large = ", NLGEOM" if scene["solver.kinematics"] == "nonlinear" else ""
    for step, grid in zip(steps, read):
        u = MM * grid.point_data["displacement_m"][moved]
        polar = np.stack([u[:, 0] * np.cos(theta) + u[:, 1] * np.sin(theta), u[:, 1] * np.cos(theta) - u[:, 0] * np.sin(theta), u[:, 2]], 1)
        force = _rim_forces(run, mesh, step)
        lines += [f"*STEP, INC=200{large}", "*STATIC", "0.2, 1., 1e-6, 0.5", "*BOUNDARY"]
        lines += [f"{n + 1}, {d + 1}, {d + 1}, {polar[i, d]:.12g}" for i, n in enumerate(moved) for d in range(3)]
        loaded = np.argwhere(abs(force) > 0)
        lines += ["*CLOAD, OP=NEW", *(f"{n + 1}, {d + 1}, {force[n, d]:.9g}" for n, d in loaded)] if len(loaded) else []
        lines += [line for name in sets for line in (f"*NODE PRINT, NSET={name}, TOTALS=ONLY, GLOBAL=NO, FREQUENCY=200", "RF")]
        lines += ["*NODE FILE, FREQUENCY=200", "U", "*END STEP"]
    return "\n".join(lines) + "\n"
