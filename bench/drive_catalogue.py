# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole drive beside the catalogue, what its unknown inputs change, and the paper's trends in it. Tables and figure of
docs/evidence/drive.md, drive_inputs.md, drive_friction.md, drive_loads.md and drive_trends.md, raw figures in bench/results/drive_catalogue.json.

Usage: python bench/drive_catalogue.py [sizes] [inputs] [trends] [groove] [rub] [loads] | pages | fine
words: solve these, or nothing (pages), and take the rest from the record, none: all; fine: the loop of size 14 at 10^6 dof alone
(bench/results/drive_fine.json)
"""
import json
import sys
import tempfile

import numpy as np

from common import DATA, RESULTS, commit, put, read_record, save_figure, solve, table, write_record
from hdengine import load
from hdengine.catalogue import UNITS
from hdengine.figures.style import new_axes, styled

SIZES = (11, 14, 17, 20, 25, 32, 40)
ARCMIN = np.degrees(1) * 60
FAST = {"mesh.divisions": 48, "mesh.band_facets": 8}
RISE = {**FAST, "loop.torques": 14, "load.torque_steps": 7}
UNKNOWN = (
    ("19 balls", {"bearing.balls": 19}), ("23 balls", {"bearing.balls": 23}), ("balls 2.8 mm", {"bearing.ball_diameter": 2.8e-3}),
    ("balls 3.6 mm", {"bearing.ball_diameter": 3.6e-3}), ("outer conformity 0.515", {"bearing.outer_conformity": 0.515}),
    ("outer conformity 0.60", {"bearing.outer_conformity": 0.60}), ("clearance of the balls 5 µm", {"bearing.clearance": 5e-6}),
    ("teeth closed", {"load.tooth_clearance": 0}), ("outermost teeth 20 µm open", {"load.tooth_clearance": 20e-6}),
    ("outermost teeth 40 µm open", {"load.tooth_clearance": 40e-6}), ("pairs half as stiff", {"load.tooth_stiffness": 6.25e7}),
    ("pressure angle 20°", {"load.pressure_angle_deg": 20}), ("pressure angle 30°", {"load.pressure_angle_deg": 30}),
    ("ring 0.8 mm thick", {"geometry.ring_thickness": 0.8e-3}), ("ring 1.2 mm thick", {"geometry.ring_thickness": 1.2e-3}),
    ("ring and band 6 mm wide", {"geometry.band_length": 6e-3}), ("hub radius 6 mm", {"geometry.hub_radius": 6e-3}),
    ("cup 26.7 mm long", {"geometry.cup_length": 26.7e-3}), ("bottom 0.4 mm", {"geometry.bottom_thickness": 0.4e-3}),
    ("wall 0.32 mm", {"geometry.wall_thickness": 0.32e-3}), ("rim 0.36 mm", {"geometry.rim_thickness": 0.36e-3}),
    ("interference 0", {"wave_generator.interference": 0}), ("friction 0.05", {"contact.friction": 0.05}))
FINE = {"mesh.divisions": 344, "mesh.band_facets": 60, "mesh.through_wall": 4, "mesh.through_ring": 4, "output.vtu": "none"}
GROOVES = ((0, 15), (0.2e-3, 15), (0.4e-3, 15), (0.6e-3, 15))  # depth [m], cells along the ring
RUBS = [{"load.tooth_friction": mu} for mu in (0, 0.05, 0.1, 0.15)] + [{"load.pressure_angle_deg": 25 - np.degrees(np.arctan(0.1))}]
WALL = 0.36e-3
LOADS = {"rim 1.2 walls": {}, "rim 1.3 walls": {"geometry.rim_thickness": 1.3 * WALL}, "w + 8 %": {"wave_generator.w": 0.2e-3 * 1.3 / 1.2}}
TORQUES = (1, 3, 5)
CASES = [(0.0, 0.2e-3), (10e-6, 0.2e-3)] + [(0.0, w * 1e-3) for w in (0.195, 0.205, 0.21, 0.215)]


def run(scene, keys):
    """Results and steps of a run."""
    with tempfile.TemporaryDirectory() as folder:
        _, command = solve(DATA / scene, *(f"{k}={v}" for k, v in keys.items()), out=f"{folder}/r")
        if command.code != 0:
            raise SystemExit(command.text)
        result = load(f"{folder}/r")
        return result.summary | {"cpu_s": command.cpu_s}, result.steps, result.loop


def three(results):
    """K1, K2, K3 [kN m/rad]."""
    return [results[f"k{i}_nm_per_rad"] / 1e3 for i in (1, 2, 3)]


def sizes():
    """The loop of every size on the paper's mesh."""
    rows = []
    for size in SIZES:
        summary, _, loop = run(f"drive{size}.nml", {})
        r = summary["results"]
        unit = UNITS.get(size)
        rows.append({"size": size, "ours": three(r), "catalogue": [unit.k1_nm_per_rad / 1e3, unit.k2_nm_per_rad / 1e3,
                     unit.k3_nm_per_rad / 1e3] if unit else None, "hysteresis_arcmin": ARCMIN * r["hysteresis_rad"],
                     "lost_motion_arcmin": ARCMIN * r["lost_motion_rad"], "ball_force_max_n": r["ball_force_max_n"],
                     "tooth_force_max_n": r["tooth_force_max_n"], "wave_generator_torque_nm": r["wave_generator_torque_nm"],
                     "torque_max_nm": float(max(loop["torque_nm"])), "von_mises_max_pa": r["von_mises_max_pa"],
                     "torque_nm": loop["torque_nm"].tolist(), "angle_rad": loop["angle_rad"].tolist(),
                     "dissipated_j": r["loop_dissipated_j"], "unbalanced": (r["loop_work_j"] - r["loop_stored_j"]) / r["loop_dissipated_j"] - 1,
                     "steps": r["steps"], "iterations": r["iterations"], "cpu_s": summary["cpu_s"], "timers_s": summary["timers_s"], "memory_mb": summary["peak_memory_mb"]})
    return rows


def sensitivity():
    """K1 to K3 of size 14 with one input changed."""
    base = three(run("drive14.nml", RISE)[0]["results"])
    rows = [{"input": "as it stands", "k": base}]
    rows += [{"input": name, "k": three(run("drive14.nml", {**RISE, **keys})[0]["results"])} for name, keys in UNKNOWN]
    chain = {}
    for name in ("hub radius 6 mm", "cup 26.7 mm long", "interference 0", "pressure angle 30°", "outermost teeth 20 µm open"):
        chain.update(dict(UNKNOWN)[name])
        rows.append({"input": f"+ {name}", "k": three(run("drive14.nml", {**RISE, **chain})[0]["results"])})
    return rows


def trends():
    """Stiffness at 1, 3 and 5 N m over eccentricity and w: of the drive (torque over angle) and of the contact."""
    rows = []
    for e, w in CASES:
        _, steps, loop = run("drive14.nml", {**FAST, "loop.torques": 5, "load.torque_steps": 5, "wave_generator.eccentricity": e,
                                             "wave_generator.w": w})
        at = [int(np.argmin(abs(steps["torque_nm"] - t))) for t in TORQUES]
        rows.append({"eccentricity_m": e, "w_m": w, "drive": [float(loop["torque_nm"][i] / loop["angle_rad"][i]) for i in at],
                     "eq45": [float(steps["k_ts_nm_per_rad"][i]) for i in at],
                     "tangent": [float(steps["k_ts_tangent_nm_per_rad"][i]) for i in at]})
    return rows


def fine():
    """The loop of size 14 on the default mesh refined four times in each direction, beside that on the default mesh: record and table."""
    rows = []
    for keys in ({"output.vtu": "none"}, FINE):
        summary, _, loop = run("drive14.nml", keys)
        r, model = summary["results"], summary["model"]
        rows.append({"facets": model["facets"], "dof": model["dof"], "steps": r["steps"], "iterations": r["iterations"],
                     "inner_iterations": model["inner_iterations"], "cpu_s": summary["cpu_s"], "timers_s": summary["timers_s"],
                     "memory_mb": summary["peak_memory_mb"], "k": three(r), "hysteresis_arcmin": ARCMIN * r["hysteresis_rad"],
                     "torque_nm": loop["torque_nm"].tolist(), "angle_rad": loop["angle_rad"].tolist()})
    write_record("drive_fine", rows, threads=1)
    fine_table(rows)


def fine_table(rows):
    """The table of the default mesh and of the refined one."""
    put("drive fine", table(("dof", "steps", "iterations", "GMRES", "time", "Newton / tangents", "memory", "target", "K1 / K2 / K3", "hysteresis"), [
        (r["dof"], r["steps"], r["iterations"], r["inner_iterations"], f"{r['cpu_s']:.1f} s",
         " / ".join(f"{100 * r['timers_s'][k] / r['timers_s']['total']:.0f}" for k in ("newton", "stiffness")) + " %",
         f"{r['memory_mb']:.0f} MB", t, " / ".join(f"{k:.4g}" for k in r["k"]), f"{r['hysteresis_arcmin']:.3f}'")
        for r, t in zip(rows, ("10 s, 200 MB", "180 s"))]), page="evidence/drive")


def groove():
    """The loop of size 14 over the depth of the balls' groove."""
    rows = []
    for depth, cells in GROOVES:
        summary, _, _ = run("drive14.nml", {"bearing.groove_depth": depth, "mesh.ring_facets": cells})
        r = summary["results"]
        rows.append({"depth_m": depth, "width_m": 2 * (depth * (2 * 0.52 * 3.2e-3 - depth)) ** 0.5, "ring_facets": cells, "k": three(r),
                     "hysteresis_arcmin": ARCMIN * r["hysteresis_rad"], "ball_force_max_n": r["ball_force_max_n"],
                     "von_mises_max_pa": r["von_mises_max_pa"], "cpu_s": summary["cpu_s"]})
    return rows


def rub():
    """The loop of size 14 over the friction of its tooth flanks, and with the pressure angle that tilts forces as much."""
    rows = []
    for keys in RUBS:
        summary, _, _ = run("drive14.nml", keys)
        r = summary["results"]
        rows.append({**keys, "k": three(r), "hysteresis_arcmin": ARCMIN * r["hysteresis_rad"], "lost_motion_arcmin": ARCMIN * r["lost_motion_rad"],
                     "dissipated_j": r["loop_dissipated_j"], "dissipated_teeth_j": r["loop_dissipated_teeth_j"],
                     "unbalanced": (r["loop_work_j"] - r["loop_stored_j"]) / r["loop_dissipated_j"] - 1, "tooth_force_max_n": r["tooth_force_max_n"],
                     "iterations": r["iterations"], "cpu_s": summary["cpu_s"]})
    return rows


def loads():
    """Largest ball and pair of size 14 over the first rise, with a stiffer rim and a deeper cam."""
    rows = []
    for name, keys in LOADS.items():
        _, _, loop = run("drive14.nml", {"geometry.rim_thickness": 1.2 * WALL, "loop.torques": 8, "load.torque_steps": 4} | keys)
        at = [int(np.flatnonzero(loop["phase"] == "assembly")[-1]), len(loop) - 1]
        rows.append({"what": name, **{key: [float(loop[key][i]) for i in at] for key in (
            "torque_nm", "ball_force_max_n", "tooth_force_max_n", "balls_loaded", "pairs_loaded")}})
    return rows


@styled
def draw(rows):
    """Loop of size 14 beside the catalogue's chords; K over the size."""
    figure, axes = new_axes(1, 2, figsize=(11, 4.4))
    row = next(r for r in rows if r["size"] == 14)
    torque = np.array(row["torque_nm"])
    axes[0].plot(ARCMIN * np.array(row["angle_rad"]), torque, label="whole drive")
    line = np.linspace(-14, 14, 200)
    axes[0].plot(ARCMIN * UNITS[14].angle(line), line, "C3--", label="catalogue, K1 K2 K3")
    axes[0].set_xlabel("angle / arc minute")
    axes[0].set_ylabel("torque / N m")
    axes[0].set_title("size 14, ratio 100", fontsize=12)
    axes[0].legend()
    for i, colour in enumerate(("C0", "C1", "C2")):
        axes[1].loglog([r["size"] for r in rows], [r["ours"][i] for r in rows], "o-", color=colour, label=f"K{i + 1}")
        known = [r for r in rows if r["catalogue"]]
        axes[1].loglog([r["size"] for r in known], [r["catalogue"][i] for r in known], "s--", color=colour, mfc="none",
                       label=f"K{i + 1}, catalogue")
    axes[1].set_xlabel("size")
    axes[1].set_ylabel("stiffness / (kN m/rad)")
    axes[1].set_xticks(SIZES, [str(s) for s in SIZES])
    axes[1].set_yticks((5, 10, 20, 50, 100, 200), ["5", "10", "20", "50", "100", "200"])
    axes[1].minorticks_off()
    axes[1].legend(fontsize=10, ncols=2, loc="upper left")
    save_figure(figure, "drive_catalogue")


def change(rows, name, reference=0):
    """Changes against a row at the three torques, as text."""
    return lambda r: " / ".join(f"{100 * (a / b - 1):+.1f}" for a, b in zip(r[name], rows[reference][name]))


def main():
    """Solve, write, draw."""
    if sys.argv[1:] == ["fine"]:
        fine()
        return
    parts = {"sizes": sizes, "inputs": sensitivity, "trends": trends, "groove": groove, "rub": rub, "loads": loads}
    found = json.loads((RESULTS / "drive_catalogue.json").read_text())
    found["commits"] = found.get("commits", dict.fromkeys(parts, found.pop("provenance", {}).get("commit", "")))
    for name in [] if sys.argv[1:] == ["pages"] else sys.argv[1:] or parts:
        found[name] = parts[name]()
        found["commits"][name] = commit()
        write_record("drive_catalogue", {key: found[key] for key in (*parts, "commits") if key in found}, threads=1)
    size, inputs, path = found["sizes"], found["inputs"], found["trends"]
    put("drive sizes", table(("size", "K1 / K2 / K3", "catalogue", "ours over it", "hysteresis", "lost motion", "ball, pair / N", "cam / N m", "T over it"), [
        (r["size"], " / ".join(f"{k:.3g}" for k in r["ours"]), " / ".join(f"{k:.3g}" for k in r["catalogue"] or []) or "not known",
         " / ".join(f"{a / b:.2f}" for a, b in zip(r["ours"], r["catalogue"] or [])) or "-", f"{r['hysteresis_arcmin']:.2f}'",
         f"{r['lost_motion_arcmin']:.2f}'", f"{r['ball_force_max_n']:.0f}, {r['tooth_force_max_n']:.0f}",
         f"{r['wave_generator_torque_nm']:.3g}", f"{r['torque_max_nm'] / r['wave_generator_torque_nm']:.0f}") for r in size]),
        page="evidence/drive")
    put("drive loops", table(("size", "iterations", "time", "Newton / tangents / files", "memory", "energy balance"), [
        (r["size"], r["iterations"], f"{r['cpu_s']:.1f} s", " / ".join(f"{100 * r['timers_s'][k] / r['timers_s']['total']:.0f}" for k in (
            "newton", "stiffness")) + f" / {100 * (r['timers_s']['output'] - r['timers_s']['stiffness']) / r['timers_s']['total']:.0f} %",
         f"{r['memory_mb']:.0f} MB", f"{100 * r['unbalanced']:+.1f} %") for r in size]), page="evidence/drive")
    base = inputs[0]["k"]
    put("drive inputs", table(("input", "K1 / K2 / K3 in kN m/rad", "change in %"), [
        (r["input"], " / ".join(f"{k:.3g}" for k in r["k"]), " / ".join(f"{100 * (k / b - 1):+.0f}" for k, b in zip(r["k"], base)))
        for r in inputs]), page="evidence/drive_inputs")
    plain = {r["ring_facets"]: r["k"] for r in found["groove"] if not r["depth_m"]}
    put("drive groove", table(("depth, width, ring / mm", "cells", "K1 / K2 / K3", "change in %", "hysteresis", "ball / N", "stress / MPa"), [
        (f"{1e3 * r['depth_m']:.1f}, {1e3 * r['width_m']:.2f}, {1 - 1e3 * r['depth_m']:.1f}", r["ring_facets"],
         " / ".join(f"{k:.3g}" for k in r["k"]), " / ".join(f"{100 * (k / b - 1):+.1f}" for k, b in zip(r["k"], plain[r["ring_facets"]])),
         f"{r['hysteresis_arcmin']:.2f}'", f"{r['ball_force_max_n']:.0f}", f"{r['von_mises_max_pa'] / 1e6:.0f}")
        for r in found["groove"]]), page="evidence/drive_inputs")
    plain = found["rub"][0]
    put("drive rub", table(("flanks", "K1 / K2 / K3", "change in %", "hysteresis", "lost motion", "lost by contact, flanks", "iterations"), [
        (f"μ = {r['load.tooth_friction']:g}" if "load.tooth_friction" in r else f"pressure angle {r['load.pressure_angle_deg']:.1f}°",
         " / ".join(f"{k:.3g}" for k in r["k"]), " / ".join(f"{100 * (k / b - 1):+.0f}" for k, b in zip(r["k"], plain["k"])),
         f"{r['hysteresis_arcmin']:.3f}'", f"{r['lost_motion_arcmin']:.3f}'",
         f"{1e3 * (r['dissipated_j'] - r['dissipated_teeth_j']):.2f}, {1e3 * r['dissipated_teeth_j']:.2f} mJ", r["iterations"])
        for r in found["rub"]]), page="evidence/drive_friction")
    plain = found["loads"][0]["ball_force_max_n"]
    put("drive loads", table(("drive", "largest ball at 0, 8 N m / N", "change in %", "balls loaded", "largest pair / N", "pairs loaded"), [
        (r["what"], " / ".join(f"{f:.0f}" for f in r["ball_force_max_n"]), " / ".join(f"{100 * (f / b - 1):+.0f}" for f, b in zip(r["ball_force_max_n"], plain)),
         " / ".join(f"{n:.0f}" for n in r["balls_loaded"]), f"{r['tooth_force_max_n'][1]:.0f}", f"{r['pairs_loaded'][1]:.0f}") for r in found["loads"]]),
        page="evidence/drive_loads")
    kinds = ("drive", "eq45", "tangent")
    lines = [(f"{1e6 * r['eccentricity_m']:.0f} µm", f"{1e3 * r['w_m']:.3f} mm", *(" / ".join(f"{v / 1e3:.4g}" for v in r[k]) for k in kinds)) for r in path]
    lines += [(*line[:2], *(f"{change(path, k)(r)} %" for k in kinds)) for r, line in zip(path[1:], lines[1:])]
    put("drive trends", table(("eccentricity", "w", "torque over angle", "K_TS by Eq. 45", "K_TS, tangent"), lines), page="evidence/drive_trends")
    fine_table(read_record("drive_fine"))
    draw(size)


if __name__ == "__main__":
    main()
