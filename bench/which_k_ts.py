# SPDX-License-Identifier: GPL-3.0-or-later
"""K_TS in every reading over torque, eccentricity and friction for three scenes, over the mesh and over the joint's inputs: tables of
docs/evidence/readings.md, raw figures in bench/results/which_k_ts.json.

Usage: python bench/which_k_ts.py [--work DIR]
"""
import argparse
import tempfile
from pathlib import Path

import hdengine
from common import DATA, put, table, write_record

SEVENTEEN = {  # CD-14-100 with all lengths in the ratio of the catalogue's pitch radii
    "geometry.bore_radius": 21.25e-3, "geometry.wall_thickness": 0.437143e-3, "geometry.rim_thickness": 0.5185e-3,
    "geometry.rim_length": 10.92857e-3, "geometry.rim_taper": 1.214286e-3, "geometry.cup_length": 24.28571e-3,
    "geometry.bottom_thickness": 0.607143e-3, "geometry.hub_radius": 9.714286e-3, "geometry.ring_thickness": 1.214286e-3,
    "geometry.band_start": 0.607143e-3, "geometry.band_length": 14.57143e-3, "wave_generator.w": 0.242857e-3,
    "wave_generator.interference": 12.14286e-6}
HUB = {"mesh.divisions": 86, "mesh.wall_elements": 0, "mesh.bottom_elements": 0, "load.assembly_steps": 3}
SCENES = {"CD-14-100": ("cd14.nml", {}), "HUB": ("peer_hub.nml", HUB), "CD-17-100": ("cd14.nml", SEVENTEEN)}
VARIED = {"": {}, "e = 10 µm": {"wave_generator.eccentricity": 10e-6}, "µ = 0.05": {"contact.friction": 0.05},
          "µ = 0.3": {"contact.friction": 0.3}}
TORQUES = (1.0, 5.0, 20.0)
READINGS = {"k_ts_nm_per_rad": "Eq. 45", "k_ts_tangent_nm_per_rad": "tangent", "k_ts_secant_nm_per_rad": "secant",
            "k_fe_secant_nm_per_rad": "torque over rotation"}
ALL = {"load.torque": 20.0, "load.torque_steps": 20, "output.vtu": "none"}


def solve(work, name, path, keys):
    """Steps of a run, by torque."""
    folder = work / name.replace(" ", "_").replace("µ", "mu").replace("=", "")
    if not (folder / "summary.json").is_file():
        hdengine.run(str(DATA / path), str(folder), True, **keys)
    steps = hdengine.load(folder).steps
    return {round(float(s["torque_nm"]), 6): {m: float(s[m]) for m in steps.dtype.names if m != "phase"} for s in steps}


def readings(work):
    """Every scene and variation: rows of the table, and figures."""
    rows, facts = [], {}
    for scene, (path, base) in SCENES.items():
        for what, keys in VARIED.items():
            steps = solve(work, f"{scene} {what}".strip(), path, {**base, **ALL, **keys})
            for torque in TORQUES:
                s = facts[f"{scene}, {what or 'as it is'}, {torque:g} N m"] = steps[torque]
                rows.append([scene, what or "as it is", f"{torque:g}", *(f"{s[k] / 1e6:.3f}" for k in READINGS), f"{s['k_ts_paper_n'] / 1e6:.0f}",
                             " / ".join(f"{100 * s[k]:.0f}" for k in ("slip_share_area", "slip_share_force", "slip_share_k_ts"))])
    return rows, facts


def last(**keys):
    """Sums of the last step."""
    with hdengine.Run(str(DATA / "cd14.nml"), **keys) as run:
        return [*run][-1].sums


def meshes():
    """Rows over the mesh: K_TS, peak and line load of the edge."""
    rows, facts = [], []
    for n, m, edge in ((24, 4, 0.0), (48, 8, 0.0), (96, 16, 0.0), (160, 24, 0.0), (64, 12, 1e-4), (64, 12, 5e-5), (64, 12, 2.5e-5)):
        s = last(mesh={"divisions": n, "band_facets": m, "edge_length": edge})
        facts.append({"divisions": n, "band_facets": m, "edge_length_m": edge, **s})
        rows.append([f"{n} x {m}", f"{1e6 * edge:g}" if edge else "-", *(f"{s[k] / 1e6:.3f}" for k in (*READINGS,)),
                     f"{s['pressure_max_pa'] / 1e6:.0f}", f"{s['edge_line_load_n_per_m'] / 1e3:.2f}"])
    return rows, facts


def inputs():
    """Rows over the joint's inputs."""
    cases = {"as it is": {}, "plastic spots elastic": {"plastic_spots": "elastic"}, "r_m = 20 µm": {"asperity_radius": 20e-6},
             "r_m = 3.74 µm, s_min = 6e-13 m²": {"asperity_radius": 3.74e-6, "s_min": 6e-13},
             "s_min = 1e-13 m²": {"s_min": 1e-13}, "fitted to boundary elements (no yield)": {
                 "asperity_radius": 3.74e-6, "s_min": 2.4e-12, "hardness": 1e15}, "G / 4": {"roughness": 6.062e-8}}
    rows, facts = [], {}
    for name, keys in cases.items():
        s = last(mesh={"divisions": 48, "band_facets": 8}, joint=keys)
        facts[name] = s
        rows.append([name, *(f"{s[k] / 1e6:.3f}" for k in (*READINGS,)[:3]), f"{100 * s['slip_share_k_ts']:.0f}"])
    return rows, facts


def laws():
    """Rows of hard contact beside the joint as contact law, and of the secant over the load steps."""
    rows, facts = [], {}
    for support in ("hub", "bearing"):
        for law in ("hard", "joint"):
            for steps in (1, 5, 20):
                s = last(mesh={"divisions": 48, "band_facets": 8}, contact__law=law, load={"support": support, "torque_steps": steps})
                facts[f"{support}, {law}, {steps}"] = s
                rows.append([support, law, steps, *(f"{s[k] / 1e6:.3f}" for k in (*READINGS,)[1:])])
    return rows, facts


def main():
    """Solve and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", help="folder for the runs")
    options = parser.parse_args()
    work = Path(options.work or tempfile.mkdtemp())
    work.mkdir(parents=True, exist_ok=True)
    names = [f"{v} / (MN m/rad)" for v in READINGS.values()]
    rows, facts = readings(work)
    put("readings", table(("scene", "", "T / N m", *names, "printed / MN", "slip of area / force / Eq. 45 / %"), rows),
        "evidence/readings")
    mesh_rows, mesh_facts = meshes()
    put("meshes", table(("facets", "edge cells / µm", *names, "peak / MPa", "line load of the ends / (kN/m)"), mesh_rows), "evidence/readings")
    input_rows, input_facts = inputs()
    put("inputs", table(("joint", *names[:3], "slip of Eq. 45 / %"), input_rows), "evidence/readings")
    law_rows, law_facts = laws()
    put("laws", table(("support", "contact law", "torque steps", *names[1:]), law_rows), "evidence/readings")
    write_record("which_k_ts", {"readings": facts, "meshes": mesh_facts, "inputs": input_facts, "laws": law_facts})


if __name__ == "__main__":
    main()
