# SPDX-License-Identifier: GPL-3.0-or-later
"""The three trends of K_TS that Hu et al. (2023) print, premise by premise, and their bench beside the drive of size 14.

A premise is a scene and its keys; each is solved at five deformations w and with 10 um of eccentricity, at 1, 3 and 5 N m. Writes
bench/results/paper_comparison.json.

Usage: python bench/paper_comparison.py [drive] [ring] [fine] [teeth] [rigid] [cup] [formed]; without words all
"""
import sys
import tempfile

import numpy as np

from common import short, solve, write_part
from hdengine import Involute, load, paper, tooth_gaps

W = (0.195e-3, 0.2e-3, 0.205e-3, 0.21e-3, 0.215e-3)
READINGS = {"eq45": "k_ts_nm_per_rad", "bonded": "k_ts_bonded_nm_per_rad"}
COARSE = {"mesh.divisions": 48, "mesh.band_facets": 8, "load.assembly_steps": 1, "load.torque": 5, "load.torque_steps": 5, "load.tangent_steps": "all"}
DRIVE = {"scene": "drive14", "loop.torques": 5, "joint.model": "hu2023", "joint.asperity_radius": 5e-6, "joint.fractal_dimension": 2.5304,
         "joint.roughness": 2.4248e-7, "joint.sample_length": 0.5e-3, "joint.shortest_wavelength": 1e-6}
CUP = {"scene": "paper", "load.support": "hub", "wave_generator.ring_tangent": "auto"}
FORMED = {**CUP, "wave_generator.shape": "as_formed", "load.torque_load": "teeth"}
GROUPS = ("drive", "ring", "fine", "teeth", "rigid", "cup", "formed")   # how the names of premises begin


def loose(um):
    """Keys of a clearance [um]; below 0 an interference."""
    return {"wave_generator.clearance": max(um, 0) * 1e-6, "wave_generator.interference": max(-um, 0) * 1e-6}


def premises():
    """Keys by name."""
    found = {f"drive, clearance {c} µm": {**DRIVE, **loose(c)} for c in (0, 10, 20, 30, 40, 50)}
    for c in (20, 50):
        found |= {f"drive, clearance {c} µm, {words}": {**DRIVE, **loose(c), **keys} for words, keys in (
            ("angle 30°", {"load.pressure_angle_deg": 30}), ("friction 0.05", {"contact.friction": 0.05}), ("friction 0.3", {"contact.friction": 0.3}),
            ("ellipse", {"wave_generator.cam": "ellipse"}), ("rigid balls", {"bearing.balls": 0}))}
    fast = {**DRIVE, "bearing.axial_hold": "fast"}
    found |= {f"ring held fast, clearance {c} µm": {**fast, **loose(c)} for c in (20, 35, 38, 40, 42, 45)}
    found |= {f"fine mesh, clearance {c} µm{words}": {**keys, **loose(c), "mesh.divisions": 86, "mesh.band_facets": 10}
              for c in (40, 42) for words, keys in (("", DRIVE), (", fast", fast))}
    found |= {f"teeth as made, clearance {c} µm{words}": {**keys, **loose(c), "made": True} for c, words, keys in ((30, "", DRIVE), (40, ", fast", fast))}
    found |= {f"rigid balls, clearance {c} µm{words}": {**DRIVE, **loose(c), "bearing.balls": 0, **keys} for c, words, keys in (
        (30, "", {}), (40, "", {}), (45, "", {}), (60, "", {}), (50, ", friction 0.3", {"contact.friction": 0.3}), (50, ", angle 30°", {"load.pressure_angle_deg": 30}))}
    found |= {f"cup held, clearance {c} µm": {**CUP, **loose(c)} for c in (-10, 0, 20, 50)}
    found |= {f"cup held, teeth, clearance {c} µm": {**CUP, **loose(c), "load.torque_load": "teeth"} for c in (0, 20, 50)}
    found |= {f"formed, interference {i:g} µm, angle {a}°": {**FORMED, **loose(-i), "load.pressure_angle_deg": a} for i in (1.5, 5) for a in (20, 30)}
    found |= {f"formed, interference {i:g} µm, angle 30°, friction {f:g}": {**FORMED, **loose(-i), "load.pressure_angle_deg": 30, "contact.friction": f}
              for i, f in ((1.5, 0.3), (1, 0.15))}
    return found


def solved(keys):
    """K_TS at 1, 3 and 5 N m by reading [N m/rad]; NaN where it was not solved."""
    with tempfile.TemporaryDirectory() as folder:
        words = [f"{k}={v}" for k, v in {**COARSE, **keys}.items() if k != "scene"]
        _, command = solve(f"{keys['scene']}.nml", *words, out=f"{folder}/r", limit=10)
        if command.code != 0:
            return {name: [np.nan] * 3 for name in READINGS}
        steps = load(f"{folder}/r").steps
        at = [int(np.flatnonzero(np.abs(steps["torque_nm"] - t) < 1e-9)[0]) for t in paper.TORQUES_NM]
        return {name: [float(steps[column][i]) for i in at] for name, column in READINGS.items()}


def with_teeth(keys, x2=None):
    """Keys with the gaps of a rack on the rim that they assemble: the closest pair just touches, or a spline of the profile shift x2; and that shift."""
    with tempfile.TemporaryDirectory() as folder:
        words = [f"{k}={v}" for k, v in {**COARSE, **keys, "loop.torques": "0,0", "load.torque_steps": 1}.items() if k != "scene"]
        solve(f"{keys['scene']}.nml", *words, "output.vtu=last", out=f"{folder}/rim")
        found = tooth_gaps(Involute(2.54e-3 * 14 / 200, x2=x2), f"{folder}/rim")
    return {**keys, **{f"load.{k}": ", ".join(f"{v:.4g}" for v in found.keys()[f"load.{k}"]) for k in ("tooth_gaps", "tooth_gaps_back")}}, found.facts["x2"]


def judge(over_w, moved):
    """A premise in one reading, K_TS over w and torque (5, 3) and with eccentricity (3): changes in per cent (at 5 N m, but for the torque's); trends."""
    with np.errstate(invalid="ignore", divide="ignore"):
        k = over_w[W.index(0.2e-3)]
        rise, fall = 100 * (k[2] / k[0] - 1), 100 * (moved / k - 1)
        gain, top = 100 * (over_w.max(axis=0) / over_w.min(axis=0) - 1), over_w.argmax(axis=0)
        stated = 100 * (paper.STATED["k_ts_best_w"][2] / paper.STATED["k_ts_best_w"][0] - 1)
        trends = {"torque": paper.judge_trend([stated], [rise]) != "does not agree",
                  "eccentricity": paper.judge_trend(paper.STATED["eccentricity_percent"], fall) != "does not agree",
                  "w": bool(np.all(np.isfinite(over_w)) and np.all((top > 0) & (top < len(W) - 1)) and np.all(gain > 0.5))}
    return dict(zip(("rise_percent", "fall_percent", "gain_percent"), short([rise, fall[2], gain[2]], 4))) | {
        "trends": " ".join(name for name, given in trends.items() if given)}


def explore(keys):
    """All places of one premise: both readings at w = 0.2 mm, and what each says. Teeth as made are those for w = 0.2 mm at every place."""
    keys = dict(keys)
    x2 = with_teeth(keys)[1] if keys.pop("made", None) else None
    *found, moved = (solved(with_teeth(at, x2)[0] if x2 else at) for at in (
        *({**keys, "wave_generator.w": w} for w in W), {**keys, "wave_generator.eccentricity": 10e-6}))
    return {"bonded_nm_per_rad": short(found[W.index(0.2e-3)]["bonded"], 4),
            **{name: judge(np.array([f[name] for f in found]), np.array(moved[name])) for name in READINGS}}


def bench():
    """Slope of the drive of size 14 round 0.5 and 5 N m on its last rise, and the chord from 0 [N m/rad]."""
    with tempfile.TemporaryDirectory() as folder:
        solve("drive14.nml", "load.torque=5.25", "load.torque_steps=21", out=f"{folder}/r")
        loop = load(f"{folder}/r").loop
        begin = np.flatnonzero(np.abs(loop["torque_nm"]) < 1e-9)[-1]   # of the last rise
        torque, angle = (np.array(loop[k][begin:]) for k in ("torque_nm", "angle_rad"))
        place = {t: int(np.flatnonzero(np.abs(torque - t) < 1e-9)[0]) for t in (0.5, 5.0)}
        return {"torque_nm": [*place], "slope": [float(f"{(torque[i + 1] - torque[i - 1]) / (angle[i + 1] - angle[i - 1]):.4g}") for i in place.values()],
                "chord": [float(f"{torque[i] / (angle[i] - angle[0]):.4g}") for i in place.values()]}


def main():
    """Solve and write."""
    for group in sys.argv[1:] or GROUPS:
        write_part("paper_comparison", group, [{"premise": name} | explore(keys) for name, keys in premises().items() if name.startswith(group)], threads=1)
    write_part("paper_comparison", "bench", bench(), threads=1)


if __name__ == "__main__":
    main()
