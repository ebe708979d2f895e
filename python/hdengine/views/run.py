# SPDX-License-Identifier: GPL-3.0-or-later
"""What the figures of a run show: of a drive at its reference step, of a contact after its last one."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .._check import ROUNDING
from .._engine import supported
from ..catalogue import unit_of
from ..summary_file import has_table
from .palette import PARTS

if TYPE_CHECKING:
    from ..results import Result

__all__: list[str] = []
ARCMIN = np.degrees(1) * 60
COLOURED = 0.97   # share of the closed area that has colours of its own
UNLOADED = 0.01   # of the largest torque: angles are shared out from here on
EDGE = 0.35       # length of a row over that of even rows from which down it is one of the edge cells
NEAR_CATALOGUE = 0.25   # the shipped drives' K1 to K3 lie so near to the catalogue (docs/evidence/drive.md)


def is_drive(result: Result) -> bool:
    """A whole drive whose assembly was reached."""
    return supported(result.scene, "loop") and has_table(result.summary, "loop") and is_assembled(result)


def is_assembled(result: Result) -> bool:
    """The run was not stopped on its way to the assembled state."""
    return bool(np.any(result.steps["load_factor"] >= 1 - ROUNDING))


def reference_step(result: Result) -> int:
    """Row of the step that the results of a drive are of: the largest torque, of equals the last; of others the last step."""
    torque = result.summary["results"].get("reference_torque_nm", result.torque_nm[-1])
    return int(np.flatnonzero(abs(result.torque_nm - torque) <= ROUNDING * max(1.0, abs(torque)))[-1])


@dataclass(frozen=True)
class Loop:
    """Torque [N m] over the angle of the output [arc minute].

    Attributes
    ----------
    angle, torque : ndarray (steps,)
        From the assembly on.
    size : int or None
        Of the catalogue with the same T1 and T2.
    stated : ndarray (2, n)
        Angles and torques of that size; empty without one.
    chords : list of tuple
        (angles, torques, text) of K1, K2, K3: two ends each.
    title : str
    """

    angle: np.ndarray
    torque: np.ndarray
    size: int | None
    stated: np.ndarray
    chords: list
    title: str


def loop_of(result: Result) -> Loop:
    """The loop of a drive with the chords of its K1, K2, K3, beside those of the catalogue."""
    table, results, scene = result.loop, result.summary["results"], result.scene
    table = table[max(0, np.count_nonzero(table["phase"] == "assembly") - 1):]
    torque, unit = table["torque_nm"], unit_of(scene)
    top = abs(torque).max()
    stated = np.empty((2, 0))
    if unit:
        at = np.unique(np.r_[0, unit.t1_nm, unit.t2_nm, top].clip(0, top))
        stated = np.array([ARCMIN * unit.angle(at), at])
    edges, start, chords = [0.0, scene["loop.torque_1"], scene["loop.torque_2"], np.inf], np.zeros(2), []
    for i in (1, 2, 3):
        k = results.get(f"k{i}_nm_per_rad")
        if not k or top <= edges[i - 1]:
            break
        rise = min(edges[i], top) - start[1]
        end = start + np.array([ARCMIN * rise / k, rise])
        low, high = (results.get(f"k{i}_nm_per_rad_{side}") for side in ("low", "high"))
        band = f" ({low / 1e3:.3g} to {high / 1e3:.3g})" if low and high else ""
        chords.append((*np.transpose([start, end]), f"K{i} {k / 1e3:.3g}{band}"))
        start = end
    widths = ", ".join(f"{key[:-4].replace('_', ' ')} {ARCMIN * results[key]:.2f}'" for key in ("hysteresis_rad", "lost_motion_rad")
                       if results.get(key) is not None)
    return Loop(ARCMIN * table["angle_rad"], torque, unit.size if unit else None, stated, chords,
                "stiffness in kN m/rad" + (f"; {widths}" if widths else ""))


def twist_of(result: Result) -> tuple[np.ndarray, dict[str, np.ndarray], str] | None:
    """Torques of the last rise [N m], shares of a further twist by part [per cent], a title; None without shares (faces bonded)."""
    loop = result.loop
    names = [p for p in PARTS if f"share_{p}" in (loop.dtype.names or ())]
    step = reference_step(result)
    first = step
    while first > 0 and loop["torque_nm"][first - 1] < loop["torque_nm"][first]:
        first -= 1
    rows = loop[first:step + 1]
    rows = rows[rows["torque_nm"] > UNLOADED * rows["torque_nm"][-1]]
    if not names or len(rows) < 2 or not all(np.isfinite(rows[f"share_{p}"]).all() for p in names):
        return None
    shares = {p: 100 * rows[f"share_{p}"] for p in names}
    contact = sum(shares[p][-1] for p in ("gaps", "slip", "joint") if p in shares)
    return rows["torque_nm"], shares, f"what takes a further twist: the contact {contact:.0f} % at {rows['torque_nm'][-1]:.3g} N m"


def reference_twist(result: Result) -> tuple[dict[str, float], str]:
    """Shares of a further twist at the reference torque by part [per cent], empty without; a title."""
    results = result.summary["results"]
    shares = {part: 100 * share for part, share in (results.get("twist_shares") or {}).items() if share is not None}
    return shares, f"what takes a further twist at {results['reference_torque_nm']:.3g} N m" if shares else ""


@dataclass(frozen=True)
class Band:
    """The contact band of one step, facets as (angle, axis), open ones NaN.

    Attributes
    ----------
    torque : float
        [N m]
    pressure, slip : ndarray (around, along)
        [MPa], [um]
    load, moved : ndarray (around,)
        Line load [N/mm] and largest slip [um] over the angle.
    edges : ndarray (along + 1,)
        Ends of the rows from the front edge [mm].
    closed : float
        Share of the facets.
    rest : str
        What the others are: open, or in tension where faces are bonded.
    """

    torque: float
    pressure: np.ndarray
    slip: np.ndarray
    load: np.ndarray
    moved: np.ndarray
    edges: np.ndarray
    closed: float
    rest: str


def band_of(result: Result) -> Band:
    """Pressure and slip of the reference step."""
    step = reference_step(result)
    facets = result.contact_at(step)
    names = ("pressure_pa", "slip_theta_m", "slip_z_m", "area_m2")
    field = {name: np.asarray(facets[name]).reshape(result.shape) for name in names}
    closed = field["pressure_pa"] > 0
    slip = np.where(closed, 1e6 * np.hypot(field["slip_theta_m"], field["slip_z_m"]), np.nan)
    arc = 2 * np.pi * result.scene["geometry.bore_radius"] / len(closed)
    return Band(result.torque_nm[step], np.where(closed, field["pressure_pa"] / 1e6, np.nan), slip,
                1e-3 * (field["pressure_pa"] * field["area_m2"]).sum(1) / arc, np.nan_to_num(slip).max(1),
                1e3 * result.row_edges(), closed.mean(), rest_of(result))


def rest_of(result: Result) -> str:
    """What facets without pressure are."""
    return "tension" if result.scene["contact.mode"] == "bonded" else "open"


def forces_of(result: Result, table: np.ndarray) -> list:
    """(torque [N m], angles [rad], forces [N]) of balls or pairs of teeth (the larger flank): assembled, at the reference step."""
    assembled = table["step"][table["phase"] == "assembly"]
    found = []
    for number in dict.fromkeys((*assembled[-1:].tolist(), int(result.steps["step"][reference_step(result)]))):
        rows = table[table["step"] == number]
        if not len(rows):   # teeth without torque
            continue
        place, of = np.unique(np.round(rows["theta_rad"] % (2 * np.pi), 9), return_inverse=True)
        force = np.zeros(len(place))
        np.maximum.at(force, of, rows["force_n"])
        found.append((rows["torque_nm"][0], place, force))
    return found


def ball_steps(result: Result, degrees: float) -> np.ndarray:
    """Turns of the wave generator at which the balls have moved on by one, up to some degrees; empty without balls."""
    balls, teeth, outer = (result.scene[key] for key in ("bearing.balls", "load.teeth", "geometry.bore_radius"))
    if not balls:
        return np.empty(0)
    outer += result.scene.get("bearing.groove_depth", 0) - result.scene["geometry.ring_thickness"]
    cage = outer / (2 * outer - result.scene["bearing.ball_diameter"])
    pitch = 360 / balls / cage / (1 + 2 / teeth)
    return pitch * np.arange(int(degrees / pitch + 1e-6) + 1)


def positions_of(result: Result) -> list:
    """(name, pressure, shear along theta [MPa]) round the rows next to Positions I, II, III (Fig. 7 A, B), last step."""
    facets = result.contact_at(-1)
    pressure, shear = (facets[name].reshape(result.shape) / 1e6 for name in ("pressure_pa", "traction_theta_pa"))
    edges = result.row_edges()
    z, found = 0.5 * (edges[1:] + edges[:-1]), []
    for label, place in zip(("I", "II", "III"), result.scene["output.positions"]):
        row = int(np.argmin(abs(z - place)))
        narrow = np.diff(edges)[row] < EDGE * result.scene["geometry.band_length"] / result.scene["mesh.band_facets"]
        found.append((f"{label}: {1e3 * z[row]:.2g} mm" + (", edge cells" if narrow else ""), pressure[:, row], shear[:, row]))
    return found


def pair_shares(result: Result, torque: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles [degree] and shares [per cent] of the pairs of teeth at one end of the long axis at a torque; both ends are alike."""
    rows = result.teeth[abs(result.teeth["torque_nm"] - torque) < ROUNDING]
    angle = (np.degrees(rows["theta_rad"]) + 90) % 360 - 90
    near = np.argsort(angle)[np.sort(angle) < 90]
    return angle[near], 100 * rows["share"][near]


def colour_top(pressure: np.ndarray, area: np.ndarray) -> float:
    """Pressure that all but a small share of the closed area stays below: narrow rows at the edges take no part of the colours.

    Parameters
    ----------
    pressure, area : ndarray
        Of one shape.

    Returns
    -------
    float
        In the unit of the pressure; 1 where nothing is closed.
    """
    closed = pressure > 0
    if not np.any(closed):
        return 1.0
    order = np.argsort(pressure[closed])
    part = np.cumsum(area[closed][order])
    return float(pressure[closed][order][np.searchsorted(part, COLOURED * part[-1])])


def stresses_of(table: np.ndarray, scene: Mapping) -> tuple[np.ndarray, np.ndarray]:
    """Mean stress and amplitude, times the notch factor, of the points of the flexspline [MPa]."""
    return table["mean_pa"] / 1e6, scene["fatigue.notch_factor"] * table["amplitude_pa"] / 1e6
