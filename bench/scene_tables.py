#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies of single scenes that need no peer: meshes of the scene HUB, slip torque over interference, load steps, layers, balance of
forces, section behind the rim, rows at the edges of the band, the default scene, teeth, slave and master swapped.

Usage: bench/scene_tables.py [NAME ...]; writes bench/results/*_study.json and prints Markdown. The tables of the pages are made of the
records by bench/evidence_tables.py.
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from common import ROOT, program, write_record

EXE = program("hdengine.x")


def solve(scene, *assignments):
    """Summary of a run and its exit code."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run.out"
        done = subprocess.run([EXE, ROOT / "data" / scene, *assignments, "output.vtu=none", "--out", out, "-q"],
                              capture_output=True, text=True)
        return json.loads((out / "summary.json").read_text()), done.returncode


def save(name, rows):
    write_record(name, rows)


def meshes():
    """Normal force, area, mid-band pressure, rotation and peak on four meshes refined in both directions."""
    keys = {"normal force / N": ("normal_force_n", 1, ".1f"), "lobe force x / N": ("lobe_force_x_n", 1, ".1f"),
            "contact area / mm²": ("contact_area_m2", 1e6, ".2f"), "mid-band mean / MPa": ("pressure_mid_mean_pa", 1e-6, ".4f"),
            "rotation / µrad": ("rotation_rad", 1e6, ".3f"), "peak / MPa": ("pressure_max_pa", 1e-6, ".1f")}
    rows = []
    for divisions, facets in ((80, 6), (120, 9), (160, 12), (240, 18)):
        ratio = facets / 6
        s, code = solve("peer_hub.nml", f"mesh.divisions={divisions}", f"mesh.band_facets={facets}",
                        f"mesh.wall_elements={round(13 * ratio)}", f"mesh.bottom_elements={round(13 * ratio)}")
        r = s["results"]
        rows.append({"divisions": divisions, "band_facets": facets, "dof": s["model"]["dof"], "code": code, "results": r,
                     "total_s": s["timers_s"]["total"], "peak_memory_mb": s["peak_memory_mb"]})
    save("mesh_study", rows)
    print("| mesh | dof | " + " | ".join(keys) + " | iterations |\n|" + "---|" * (len(keys) + 3))
    for row in rows:
        values = [format(row["results"][key] * factor, form) for key, factor, form in keys.values()]
        print(f"| {row['divisions']} x {row['band_facets']} | {row['dof']} | " + " | ".join(values)
              + f" | {row['results']['iterations']} |")


def slip():
    """Support 'bearing': torque ramped past what friction holds, for four interferences."""
    rows = []
    for interference in (0, 5e-6, 10e-6, 20e-6):
        s, code = solve("cd14.nml", "load.support=bearing", "load.torque=60", "load.torque_steps=10",
                        f"wave_generator.interference={interference}")
        rows.append({"interference_m": interference, "code": code, "message": s["message"], "results": s["results"]})
    save("slip_study", rows)
    print("| interference / µm | exit code | gross slip at / N m | µ∫p r dA / N m | last converged / N m | cut-backs |\n|---|---|---|---|---|---|")
    for row in rows:
        r = row["results"]
        print(f"| {1e6 * row['interference_m']:.0f} | {row['code']} | {r.get('gross_slip_torque_nm', float('nan')):.4f} | "
              f"{r['friction_capacity_nm']:.4f} | {-r['friction_torque_nm']:.4f} | {r['cut_backs']} |")


def steps():
    """HUB and FREE with ever more torque steps: the friction history's own error."""
    rows = []
    for support in ("hub", "bearing"):
        for n in (5, 10, 20, 40, 80):
            s, code = solve("peer_hub.nml", "mesh.divisions=80", f"load.support={support}", "load.assembly_steps=4",
                            f"load.torque_steps={n}")
            rows.append({"support": support, "torque_steps": n, "code": code, "results": s["results"]})
    save("step_study", rows)
    print("| support | torque steps | rotation / µrad | against 80 steps | normal force / N | iterations |\n|---|---|---|---|---|---|")
    for row in rows:
        r = row["results"]
        last = next(x for x in rows if x["support"] == row["support"] and x["torque_steps"] == 80)["results"]["rotation_rad"]
        print(f"| {row['support']} | {row['torque_steps']} | {1e6 * r['rotation_rad']:.4f} | {100 * (r['rotation_rad'] / last - 1):+.2f} % | "
              f"{r['normal_force_n']:.3f} | {r['iterations']} |")


def layers():
    """HUB, 80 divisions: cells through ring and wall, rows of facets, elements."""
    rows = []
    for element, facets, through in (("hex8i", 6, 1), ("hex8i", 12, 1), ("hex8i", 12, 2), ("hex8i", 6, 4), ("hex8i", 12, 4), ("hex8i", 24, 4), ("hex8i", 48, 4), ("hex8i", 24, 1),
                                     ("hex20r", 6, 1), ("hex20r", 12, 1), ("hex20r", 24, 1)):
        s, code = solve("peer_hub.nml", "mesh.divisions=80", f"mesh.element={element}", f"mesh.band_facets={facets}", "mesh.wall_elements=26",
                        "mesh.bottom_elements=26", f"mesh.through_ring={through}", f"mesh.through_wall={through}")
        rows.append({"element": element, "band_facets": facets, "layers": through, "dof": s["model"]["dof"], "code": code, "results": s["results"]})
    save("layer_study", rows)
    print("| element | rows of facets | layers | dof | normal force / N | lobe force x / N | mid-band mean / MPa | rotation / µrad | iterations |\n"
          + "|---" * 9 + "|")
    for row in rows:
        r = row["results"]
        print(f"| {row['element']} | {row['band_facets']} | {row['layers']} | {row['dof']} | {r['normal_force_n']:.1f} | {r['lobe_force_x_n']:.1f} | "
              f"{1e-6 * r['pressure_mid_mean_pa']:.3f} | {1e6 * r['rotation_rad']:.3f} | {r['iterations']} |")


def balance():
    """Facet pressures against nodal reactions on scenes with and without matching meshes."""
    rows = []
    for label, *keys in (("HUB", ), ("HUB, 80/64", "mesh.ring_divisions=64"), ("HUB, 80/64, 6/5 facets", "mesh.ring_divisions=64", "mesh.ring_facets=5"),
                         ("FREE", "load.support=bearing"), ("INT", "load.support=bearing", "wave_generator.interference=10e-6"),
                         ("INT, 80/64", "load.support=bearing", "wave_generator.interference=10e-6", "mesh.ring_divisions=64"),
                         ("HUB, e = 20 µm", "wave_generator.eccentricity=20e-6"), ("HUB, hex20r, 40", "mesh.element=hex20r", "mesh.divisions=40")):
        s, code = solve("peer_hub.nml", "mesh.divisions=80", *keys, "load.assembly_steps=4", "load.torque_steps=4")
        rows.append({"scene": label, "code": code, "results": s["results"], "dof": s["model"]["dof"]})
    save("balance_study", rows)
    print("| scene | pressure sum / N | reaction / N | difference | torque balance / N m | iterations | cut-backs | rotation / µrad |\n|---|---|---|---|---|---|---|---|")
    for row in rows:
        r = row["results"]
        print(f"| {row['scene']} | {r['facet_force_n']:.3f} | {r['reaction_force_n']:.3f} | {abs(r['facet_force_n'] / r['reaction_force_n'] - 1):.0e} | "
              f"{abs(r['torque_balance_nm']):.0e} | {r['iterations']} | {r['cut_backs']} | {1e6 * r['rotation_rad']:.3f} |")


def rim():
    """Where the rim ends and how fast it thins: normal force and force of a lobe of HUB, 80 divisions."""
    rows = []
    for until, taper in ((7e-3, 1e-3), (7.5e-3, 0.5e-3), (7.5e-3, 1e-3), (8e-3, 1e-3)):
        s, code = solve("peer_hub.nml", "mesh.divisions=80", f"geometry.rim_length={until}", f"geometry.rim_taper={taper}")
        rows.append({"rim_length_m": until, "rim_taper_m": taper, "code": code, "results": s["results"]})
        r = rows[-1]["results"]
        print(f"rim to {1e3 * until:g} mm, taper {1e3 * taper:g} mm: {r['normal_force_n']:.0f} N, lobe {r['lobe_force_x_n']:.0f} N", flush=True)
    save("rim_study", rows)


def edges():
    """CD-14-100 in one step each of assembly and torque: equal rows, and rows that shorten to 30 um at the edges of the band."""
    rows = []
    for divisions, facets, *keys in ((44, 8), (68, 12), (124, 22), (264, 46), (48, 8, EDGE), (72, 12, EDGE), (128, 22, EDGE), (288, 46, EDGE),
                                     (48, 8, EDGE, "contact.law=joint"), (44, 8, "contact.law=joint"), (124, 22, "contact.law=joint")):
        s, code = solve("cd14.nml", f"mesh.divisions={divisions}", f"mesh.band_facets={facets}", "load.assembly_steps=1", "load.torque_steps=1",
                        *keys)
        rows.append({"divisions": divisions, "band_facets": facets, "rows": s["model"]["facets"] // divisions, "keys": keys, "code": code,
                     "dof": s["model"]["dof"], "results": s["results"]})
        r = rows[-1]["results"]
        print(f"{divisions} x {rows[-1]['rows']} {keys}: Eq. 45 {1e-6 * r['k_ts_nm_per_rad']:.3f}, tangent {1e-6 * r['k_ts_tangent_nm_per_rad']:.3f} "
              f"MN m/rad, {r['normal_force_n']:.0f} N, {r['iterations']} iterations", flush=True)
    save("edge_study", rows)


def default():
    """CD-14-100 as it stands, condensed and with exact factors, and with more layers."""
    rows = []
    for keys in ([], ["solver.method=newton", "solver.factors=exact"], *([f"mesh.through_ring={n}", f"mesh.through_wall={n}"] for n in (2, 4))):
        s, code = solve("cd14.nml", *keys)
        rows.append({"keys": keys, "code": code, "model": s["model"], "results": s["results"], "total_s": s["timers_s"]["total"],
                     "peak_memory_mb": s["peak_memory_mb"]})
        r = rows[-1]["results"]
        print(f"{keys}: {r['iterations']} iterations, {r['normal_force_n']:.0f} N, {1e6 * r['rotation_rad']:.3f} urad, "
              f"{rows[-1]['total_s']:.1f} s, {rows[-1]['peak_memory_mb']:.0f} MB", flush=True)
    save("default_study", rows)


def teeth():
    """The cup against the teeth: K_FTS over the stiffness of a pair, over clearance and torque."""
    rows = []
    for stiffness, clearance, torque in ((1e7, 0, 5), (1.25e8, 0, 5), (1.25e8, 0, 1), (1e13, 0, 5), (1.25e8, 10e-6, 1), (1.25e8, 10e-6, 5)):
        s, code = solve("teeth.nml", f"load.tooth_stiffness={stiffness}", f"load.tooth_clearance={clearance}", f"load.torque={torque}")
        r = s["results"]
        rows.append({"tooth_stiffness_n_per_m": stiffness, "tooth_clearance_m": clearance, "torque_nm": torque, "code": code,
                     "k_fts_nm_per_rad": torque / r["rotation_rad"], "results": r})
        print(f"{stiffness:g} N/m, {1e6 * clearance:g} um, {torque} N m: {rows[-1]['k_fts_nm_per_rad']:.5g} N m/rad", flush=True)
    save("teeth_study", rows)


def swap():
    """CD-14-100 with a ring's mesh unlike the cup's: ring or cup as slave."""
    rows = []
    for ratio in (1.3, 0.75):
        for divisions, facets in ((48, 8), (96, 16), (144, 24)):
            of = {slave: solve("cd14.nml", f"mesh.divisions={divisions}", f"mesh.band_facets={facets}", f"mesh.ring_divisions={int(ratio * divisions)}",
                               f"mesh.ring_facets={round(ratio * facets)}", f"contact.slave={slave}", "solver.kinematics=linear")[0]["results"]
                  for slave in ("ring", "cup")}
            rows.append({"ratio": ratio, "divisions": divisions, "band_facets": facets, "results": of})
            print(ratio, divisions, {k: of["cup"][k] / of["ring"][k] - 1 for k in ("k_ts_nm_per_rad", "k_ts_tangent_nm_per_rad")}, flush=True)
    save("swap_study", rows)


EDGE = "mesh.edge_length=30e-6"
STUDIES = {f.__name__: f for f in (meshes, slip, steps, layers, balance, rim, edges, default, teeth, swap)}

if __name__ == "__main__":
    for name in sys.argv[1:] or STUDIES:
        STUDIES[name]()
