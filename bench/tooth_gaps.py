# SPDX-License-Identifier: GPL-3.0-or-later
"""What clearances from the tooth profile change in the loop of size 14. Table of docs/evidence/drive_teeth.md, figure of docs/explain/tooth_gaps.md,
raw figures in bench/results/tooth_gaps.json.

Usage: python bench/tooth_gaps.py
"""
import tempfile

import numpy as np

import hdengine
from common import DATA, put, save_figure, table, write_record
from hdengine.results import read_csv

SCENE = DATA / "drive14.nml"
MESH = {"mesh.divisions": 44, "output.vtu": "none"}
M = 0.1778e-3
ARCMIN = 60 * 180 / np.pi
PROFILES = {"involute": hdengine.Involute(M), "double arc": hdengine.DoubleArc(M)}
LEAST = (0.0, 2e-6, 5e-6)


def loop(keys):
    """Readings of a loop, and the pairs that push at its largest torque."""
    with tempfile.TemporaryDirectory() as folder:
        result = hdengine.run(SCENE, f"{folder}/r", **MESH, **keys)
        teeth = read_csv(f"{folder}/r/teeth.csv")
        r = result.summary["results"]
        at = teeth["step"] == result.loop["step"][np.argmax(result.loop["torque_nm"])]
    force = teeth["force_n"][at]
    return {"k": [r[f"k{i}_nm_per_rad"] / 1e3 for i in (1, 2, 3)], "hysteresis_arcmin": ARCMIN * r["hysteresis_rad"],
            "lost_motion_arcmin": ARCMIN * r["lost_motion_rad"], "tooth_force_max_n": r["tooth_force_max_n"],
            "pairs": int((force > 1e-6 * force.max()).sum())}


def on_solved_rims():
    """Keys of both profiles on the rim of the assembled drive."""
    with tempfile.TemporaryDirectory() as folder:
        hdengine.run(SCENE, f"{folder}/r", **MESH | {"output.vtu": "last", "loop.torques": 0, "load.torque_steps": 1})
        return [(f"{name} on the solved rim, 0 µm", hdengine.tooth_gaps(p, f"{folder}/r").keys()) for name, p in PROFILES.items()]


def main():
    """Solve, write, draw."""
    angles = {name: hdengine.tooth_gaps(p, SCENE).pressure_angle_deg for name, p in PROFILES.items()}
    cases = [("parabola up to 10 µm, 25°", {})]
    cases += [(f"parabola up to 10 µm, {a:.1f}°", {"load.pressure_angle_deg": round(a, 2)}) for a in angles.values()]
    for name, profile in PROFILES.items():
        for least in LEAST:
            cases.append((f"{name}, closest pair {1e6 * least:g} µm", hdengine.tooth_gaps(profile, SCENE, least_gap=least).keys()))
    cases += on_solved_rims()
    rows = [{"teeth": name, "angle_deg": keys.get("load.pressure_angle_deg", 25.0), "gaps_m": keys.get("load.tooth_gaps"), **loop(keys)}
            for name, keys in cases]
    write_record("tooth_gaps", rows, threads=1)
    put("drive teeth", table(("clearance", "K1 / K2 / K3 in kN m/rad", "change in %", "hysteresis", "lost motion", "pairs", "pair / N"), [
        (r["teeth"], " / ".join(f"{k:.3g}" for k in r["k"]), " / ".join(f"{100 * (k / o - 1):+.0f}" for k, o in zip(r["k"], rows[0]["k"])),
         f"{r['hysteresis_arcmin']:.2f}'", f"{r['lost_motion_arcmin']:.2f}'", r["pairs"], f"{r['tooth_force_max_n']:.0f}")
        for r in rows]), page="evidence/drive_teeth")
    save_figure(hdengine.tooth_gaps(PROFILES["involute"], SCENE).plot(), "tooth_gaps")


if __name__ == "__main__":
    main()
