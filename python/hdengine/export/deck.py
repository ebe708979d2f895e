# SPDX-License-Identifier: GPL-3.0-or-later
"""A run as a CalculiX deck on its own mesh: what the run loads it with, and in its head what the run found.

Balls press by their law against the cam of the run; without balls the ring's inner face moves as in the run. The bottom of the cup
moves as in the run, forces of the teeth or the even shear of the rim are its own. CalculiX is asked for the forces of the balls and
at the bottom.
"""
from __future__ import annotations

import numpy as np

from .._check import input_file, package
from .._engine import FileError, HdengineError, supported
from ..results import Result
from ..teeth.rim_shape import row_weights, tooth_ends
from .cards import SIDES, body_cards, contact_cards, equation_cards, node_cards, set_cards, strut_cards, surface_cards

__all__: list[str] = []
STIFF = 2e6   # slope of pressure over closure in place of hard contact [N/mm3]
STICK = 2e5   # slope of shear over slip before it slips [N/mm3]
MM = 1e3
SAME = 1e-9     # distance of points that are one [m]; of heights and radii of a mesh that are one ten times that, and more
FACING = 0.7    # cosine of the normal of a side to the radius: cones up to 45 degrees look outwards or inwards
TELLING = 1e-12  # weight of a node of a flank over the largest: rounding is less
HAT = 1.2       # radius of the bottom over that of the bore from which on it is the collar of a hat


def _grid(path):
    """A grid that the run wrote."""
    try:
        return package("meshio", "a CalculiX deck", "export").read(input_file(path))
    except HdengineError:
        raise
    except (Exception, SystemExit):   # meshio ends Python on a file of which it knows no end
        raise FileError(f"'{path}' cannot be read: it is no grid as a run leaves it") from None


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
        return np.flatnonzero((self.body[self.of] == body) & (sense * self.outward > FACING) & (self.z.min(1) < to_z - SAME)
                              & (self.z.max(1) > from_z + SAME))

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


def flank_weights(points: np.ndarray, outside: np.ndarray, theta: np.ndarray, divisions: int, ends: tuple[float, float],
                  rim: float, arm: float, apart: float) -> list:
    """Share of each node in the load of each pair of teeth: even over what touches, linear between meridians.

    Parameters
    ----------
    points : ndarray (n, 3)
    outside : ndarray of int
        Corner nodes of the rim's outside.
    theta : ndarray (pairs,)
        Places of the pairs [rad].
    divisions : int
        Meridians of the mesh.
    ends : (float, float)
        Where the loaded length begins and ends, from the opening, in the unit of the points.
    rim, arm : float
        Radius of the rim's outside; of the circle amid the teeth, where the forces act. In the same unit.
    apart : float
        Angle on either half of which the arm of a force over the rim presses, and lifts [rad].

    Returns
    -------
    list of dict
        Node to its radial force under a unit force outwards, its radial and its tangential force under one along the rim.
    """
    r, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    sector = np.round(np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi) * divisions).astype(int) % divisions
    scale = np.ptp(z[outside])
    heights = np.unique(np.round(z[outside] / scale, 9)) * scale
    along = row_weights(heights, ends)

    def line(angle):
        place = (angle / (2 * np.pi) % 1) * divisions
        low = int(np.floor(place + 1e-9))
        weight: dict = {}
        for s, share in ((low, 1 - (place - low)), (low + 1, place - low)):
            for n in outside[sector[outside] == s % divisions]:
                w = share * along[np.argmin(abs(heights - z[n]))]
                if abs(w) > TELLING * scale:
                    weight[int(n)] = weight.get(int(n), 0.0) + w
        factor = rim / sum(w * r[n] for n, w in weight.items())
        return {n: w * factor for n, w in weight.items()}
    rows = []
    for angle in theta:
        low, middle, high = (line(angle + side * apart / 2) for side in (-1, 0, 1))
        tilt = (arm / rim - 1) / apart
        rows.append({n: (middle.get(n, 0.0), tilt * (low.get(n, 0.0) - high.get(n, 0.0)), arm / rim * middle.get(n, 0.0))
                     for n in sorted({*low, *middle, *high})})
    return rows


def _rim_forces(run, mesh, step):
    """Forces of a step on the outside of the rim (n, 3) [N]; the radial and tangential ones of teeth, or an even shear."""
    scene, points = run.scene, mesh.points
    rim = mesh.facing(2, 1, to_z=scene["geometry.rim_length"])
    theta = np.arctan2(points[:, 1], points[:, 0])
    radial, around = np.zeros(len(points)), np.zeros(len(points))
    outside, alpha = scene["geometry.bore_radius"] + scene["geometry.rim_thickness"], np.radians(scene["load.pressure_angle_deg"])
    arm = run.summary["model"].get("tooth_circle_m", outside)
    torque = float(run.torque_nm[step])
    if supported(scene, "teeth"):
        table = run.teeth[run.teeth["step"] == run.steps["step"][step]]
        rubbed = "friction_n" in table.dtype.names
        pairs = [(row["theta_rad"], row["force_n"], row["friction_n"] if rubbed else 0.0, row["flank"]) for row in table
                 if row["force_n"] > 0]
        sense = -1.0
    elif scene["load.torque_load"] == "teeth":
        half = scene["load.tooth_pairs"] // 2
        places = (np.arange(half) - (half - 1) / 2) * 2 * np.pi / scene["load.teeth"]
        force = torque / (scene["load.tooth_pairs"] * arm * np.cos(alpha))
        pairs, sense = [(a, force, 0.0, 1) for a in np.r_[places, places + np.pi]], 1.0
    else:
        for s in rim:
            part = min(1.0, (scene["geometry.rim_length"] - mesh.z[s].min()) / np.ptp(mesh.z[s]))
            around[mesh.sides[s]] += part * np.ptp(mesh.z[s])
        around *= torque / max(np.sum(around * np.hypot(points[:, 0], points[:, 1])), np.finfo(float).tiny)
        pairs = []
    if pairs:
        rows = flank_weights(points, np.unique(mesh.sides[rim]), np.array([p[0] for p in pairs]), scene["mesh.divisions"],
                             tooth_ends(scene), outside, arm,
                             2 * np.pi / min(scene["mesh.divisions"], scene["load.teeth"]))
        for (_, force, rub, flank), row in zip(pairs, rows):
            inwards = force * np.sin(alpha) + rub * np.cos(alpha)
            along = sense * flank * (force * np.cos(alpha) - rub * np.sin(alpha))
            for n, (push, tilt, shear) in row.items():
                radial[n] += along * tilt - inwards * push
                around[n] += along * shear
    return np.stack([radial * np.cos(theta) - around * np.sin(theta), radial * np.sin(theta) + around * np.cos(theta),
                     np.zeros(len(points))], 1)


def _sets(run, mesh):
    """Nodes that the deck moves."""
    inside = mesh.nodes(mesh.facing(1, -1))
    heights = np.unique(np.round(mesh.points[inside, 2], 9))
    cup = np.unique(mesh.cells[mesh.body == 2])
    r = np.hypot(mesh.points[:, 0], mesh.points[:, 1])
    bottom = cup[mesh.points[cup, 2] > 0.5 * mesh.points[cup, 2].max()]
    hat = r[bottom].max() > HAT * run.scene["geometry.bore_radius"]
    end = r[bottom].max() if hat else r[bottom].min()
    middle = inside[abs(mesh.points[inside, 2] - heights[len(heights) // 2]) < 10 * SAME]
    return {"INSIDE": inside, "MIDDLE": middle, "HUB": bottom[abs(r[bottom] - end) < 100 * SAME]}


def _patch(mesh, inside, scene, theta):
    """Weights of the ring's inner corner nodes under a ball: the mean over its patch (see `hd_ball_bearing`)."""
    points = mesh.points[inside]
    heights, of_height = np.unique(np.round(points[:, 2], 9), return_inverse=True)
    sectors = len(inside) // len(heights)
    sector = np.round(np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi) * sectors).astype(int) % sectors
    node = np.empty((sectors, len(heights)), int)
    node[sector, of_height] = inside
    thick = scene["geometry.ring_thickness"]
    race = scene["geometry.bore_radius"] - thick + scene["bearing.groove_depth"]
    angle = (scene["bearing.patch_length"] or max(thick, 2 * np.pi * race / sectors)) / race
    width = min(np.ptp(heights), scene["bearing.patch_width"] or max(thick, np.ptp(heights) / (len(heights) - 1)))
    weight: dict = {}
    even = (np.arange(12) + 0.5) / 12 - 0.5
    for place in ((theta + angle * even) / (2 * np.pi) % 1) * sectors:
        for z in heights.mean() + width * even:
            i, row = int(place) % sectors, min(max(int(np.searchsorted(heights, z)) - 1, 0), len(heights) - 2)
            x, y = place - int(place), (z - heights[row]) / (heights[row + 1] - heights[row])
            for n, w in ((node[i, row], (1 - x) * (1 - y)), (node[i, row + 1], (1 - x) * y),
                         (node[(i + 1) % sectors, row], x * (1 - y)), (node[(i + 1) % sectors, row + 1], x * y)):
                weight[int(n)] = weight.get(int(n), 0.0) + w / 144
    return {n: w for n, w in weight.items() if w > SAME}


def _balls(run, step=None):
    """Rows of the balls of a step, or of all."""
    table = run.balls
    return None if table is None else table if step is None else table[table["step"] == run.steps["step"][step]]


def _found(run, step):
    """What the run says of a step, as lines of the head."""
    s, balls = run.steps[step], _balls(run, step)
    lines = [f"step {s['step']}: torque {s['torque_nm'] * MM:.6g} N mm, turn of the bottom {s['rotation_rad']:.6g} rad, "
             f"contact's normal force {s['normal_force_n']:.6g} N"]
    return lines if balls is None else [*lines, f"  forces of the balls: {', '.join(f'{f:.5g}' for f in balls['force_n'])} N"]


def _ball_struts(run, mesh):
    """Struts of the balls on the ring: cards, ground nodes, and the weights of each ball's patch."""
    balls = _balls(run)
    closed = balls["closing_m"] > 100 * SAME
    rate = float(np.median(balls["force_n"][closed] / (MM * balls["closing_m"][closed]) ** 1.5)) if closed.any() else 0.0
    places = [float(theta) for theta in balls["theta_rad"][balls["step"] == balls["step"][0]]]
    closing = 2 * MM * max(balls["closing_m"].max(), 1e-6) * np.linspace(0, 1, 801) ** 2
    lines, ends, ground = strut_cards(len(mesh.points), len(mesh.cells), [("BALLS", len(places), rate * closing**1.5, closing)])
    corners = np.unique(mesh.sides[mesh.facing(1, -1)])
    patches = [_patch(mesh, corners, run.scene, theta) for theta in places]
    equations = [line for e, patch in zip(ends, patches) for line in equation_cards(
        [(e, 1, -1.0), *((n + 1, 1, -w) for n, w in patch.items())])]
    return lines, equations, ground, patches


def to_deck(run: Result) -> str:
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
        raise FileError(f"'{run.folder}' has no bodies_*.vtu: run again with output.vtu = 'last', or 'all' "
                        "for a deck of every step")
    read = [_grid(path) for path in grids]
    numbers = [int(path.stem.split("_")[1]) for path in grids]
    if not np.isin(numbers, run.steps["step"]).all():
        raise FileError(f"'{run.folder}' has bodies_*.vtu of load steps that steps.csv lacks: run it again")
    steps = np.searchsorted(run.steps["step"], numbers).tolist()
    scene, mesh = run.scene, _Mesh(read[0], run.scene)
    sets = _sets(run, mesh)
    struts, equations, ground, patches = _ball_struts(run, mesh) if run.balls is not None else ([], [], [], [])
    lines = ["** " + line for line in (
        f"{run.summary['title'] or run.folder.name}: mesh, ways and forces of its run, by hdengine; mm, N, MPa",
        "In the .dat file the sum of HUB's second forces times HUB's radius is the torque at the bottom, GROUND's first ones",
        "are those of the balls. A slip path needs every step: output.vtu = 'all'. The run found:",
        *(line for step in steps for line in _found(run, step)))]
    lines += node_cards(MM * mesh.points, "ALL")
    for number, name, of in ((1, "RING", "ring"), (2, "CUP", "flexspline")):
        own = np.flatnonzero(mesh.body == number)
        lines += body_cards(name, own, mesh.cells[own], mesh.element, scene[f"material.{of}_e"] / 1e6, scene[f"material.{of}_nu"])
    lines += set_cards(sets) + struts
    for name in ("INSIDE", "HUB"):
        lines += [f"*TRANSFORM, NSET={name}, TYPE=C", "0., 0., 0., 0., 0., 1."]
    lines += equations
    band = scene["geometry.band_start"], scene["geometry.band_start"] + scene["geometry.band_length"]
    for name, of in (("SLAVE", mesh.facing(1, 1)), ("MASTER", mesh.facing(2, -1, *band))):
        lines += surface_cards(name, zip(mesh.of[of], mesh.number[of]))
    friction = (run.steps["friction"][steps] * (scene["contact.mode"] == "frictional")).tolist()
    bonded = scene["contact.mode"] == "bonded" or not supported(scene, "contact")
    if bonded:
        lines += ["*TIE, NAME=GLUE, POSITION TOLERANCE=0.1", "SLAVE, MASTER"]
    else:
        apart = scene["wave_generator.clearance"] or -scene["wave_generator.interference"]
        lines += contact_cards("s2s", STIFF, max(friction), STICK, apart)
    held = [(n, d) for n in sets["HUB"] for d in range(3)] + [(n, 2) for n in sets["MIDDLE"]]
    if not struts:
        held += [(n, 0) for n in sets["INSIDE"]]
        if scene["wave_generator.ring_tangent"] == "follow" or supported(scene, "friction_alone"):
            held += [(n, 1) for n in sets["INSIDE"]]
    if not (any(friction) or bonded):
        held += [(sets["MIDDLE"][0], 1)]
    theta = np.arctan2(mesh.points[:, 1], mesh.points[:, 0])
    along, around = (np.stack(way, 1) for way in ((np.cos(theta), np.sin(theta)), (-np.sin(theta), np.cos(theta))))
    large = ", NLGEOM" if scene["solver.kinematics"] == "nonlinear" else ""
    for step, grid, mu in zip(steps, read, friction):
        u = MM * grid.point_data["displacement_m"]
        way = np.stack([(u[:, :2] * along).sum(1), (u[:, :2] * around).sum(1), u[:, 2]], 1)
        force = _rim_forces(run, mesh, step)
        lines += [f"*STEP, INC=200{large}", "*STATIC", "0.2, 1., 1e-6, 0.5"]
        if not bonded and min(friction) < max(friction):
            lines += ["*CHANGE FRICTION, INTERACTION=TOUCH", "*FRICTION", f"{mu:g}, {STICK:g}"]
        lines += ["*BOUNDARY, OP=NEW"]
        lines += [f"{n + 1}, {d + 1}, {d + 1}, {way[n, d]:.12g}" for n, d in dict.fromkeys(held)]
        if struts:
            lines += ["STRUTS, 2, 3", "GROUND, 2, 3", "CUBE, 1, 3"]
            lines += [f"{g}, 1, 1, {-MM * c - sum(w * way[n, 0] for n, w in patch.items()):.12g}"
                      for g, c, patch in zip(ground, _balls(run, step)["closing_m"], patches)]
        rim = np.argwhere(abs(force) > 0)
        lines += ["*CLOAD, OP=NEW", *(f"{n + 1}, {d + 1}, {force[n, d]:.9g}" for n, d in rim)] if len(rim) else []
        for name in ("HUB", "GROUND" if struts else "INSIDE"):
            lines += [f"*NODE PRINT, NSET={name}, FREQUENCY=200", "RF"]
        lines += ["*NODE FILE, FREQUENCY=200", "U", "*END STEP"]
    return "\n".join(lines) + "\n"
