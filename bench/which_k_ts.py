# SPDX-License-Identifier: GPL-3.0-or-later
"""K_TS in every reading over torque, eccentricity and friction for three scenes, over the mesh and over the joint's inputs: tables of
docs/evidence/readings.md, raw figures in bench/results/which_k_ts.json.

Usage: python bench/which_k_ts.py [--work DIR] [--tables]; with --tables nothing is solved, the tables are made of the record.
"""
import argparse
import tempfile
from pathlib import Path

import hdengine
from common import DATA, put, read_record, table, write_record

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
PAGE = "evidence/readings"
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
    """Every scene and variation at three torques."""
    facts = {}
    for scene, (path, base) in SCENES.items():
        for what, keys in VARIED.items():
            steps = solve(work, f"{scene} {what}".strip(), path, {**base, **ALL, **keys})
            facts |= {f"{scene}, {what or 'as it is'}, {torque:g} N m": steps[torque] for torque in TORQUES}
    return facts


def last(**keys):
    """Sums of the last step."""
    with hdengine.Run(str(DATA / "cd14.nml"), **keys) as run:
        return [*run][-1].sums


def meshes():
    """K_TS, peak and line load of the edge over the mesh."""
    return [{"divisions": n, "band_facets": m, "edge_length_m": edge, **last(mesh={"divisions": n, "band_facets": m, "edge_length": edge})}
            for n, m, edge in ((24, 4, 0.0), (48, 8, 0.0), (96, 16, 0.0), (160, 24, 0.0), (64, 12, 1e-4), (64, 12, 5e-5), (64, 12, 2.5e-5))]


def inputs():
    """K_TS over the joint's inputs."""
    cases = {"as it is": {}, "plastic spots elastic": {"plastic_spots": "elastic"}, "r_m = 20 µm": {"asperity_radius": 20e-6},
             "r_m = 3.74 µm, s_min = 6e-13 m²": {"asperity_radius": 3.74e-6, "s_min": 6e-13},
             "s_min = 1e-13 m²": {"s_min": 1e-13}, "fitted to boundary elements (no yield)": {
                 "asperity_radius": 3.74e-6, "s_min": 2.4e-12, "hardness": 1e15}, "G / 4": {"roughness": 6.062e-8}}
    return {name: last(mesh={"divisions": 48, "band_facets": 8}, joint=keys) for name, keys in cases.items()}


def laws():
    """Hard contact beside the joint as contact law, over the load steps."""
    return {f"{support}, {law}, {steps}": last(mesh={"divisions": 48, "band_facets": 8}, contact__law=law, load={"support": support, "torque_steps": steps})
            for support in ("hub", "bearing") for law in ("hard", "joint") for steps in (1, 5, 20)}


def shown(sums, names=READINGS):
    """Readings in MN m/rad."""
    return [f"{sums[k] / 1e6:.{2 if k == 'k_ts_nm_per_rad' else 3}f}" for k in names]


def write_tables(record):
    """The four tables of the page."""
    names = [f"{v} / (MN m/rad)" for v in READINGS.values()]
    most, slip = [*READINGS][:3], "slip_share_k_ts"
    rows = []
    for scene in SCENES:
        for what in VARIED:
            at = [record["readings"][f"{scene}, {what or 'as it is'}, {t:g} N m"] for t in TORQUES]
            rows.append((scene, what or "as it is", *(" / ".join(c) for c in zip(*(shown(s, most) for s in at))),
                         " / ".join(f"{100 * s[slip]:.0f}" for s in at)))
    put("readings", table(("scene", "", *names[:3], "slip of Eq. 45 / %"), rows), PAGE)
    put("meshes", table(("facets", "edge / µm", *(n.split(" /")[0] for n in names[:3]), "peak / MPa", "line load / (kN/m)"), [
        (f"{s['divisions']} x {s['band_facets']}", f"{1e6 * s['edge_length_m']:g}" if s["edge_length_m"] else "-", *shown(s, most),
         f"{s['pressure_max_pa'] / 1e6:.0f}", f"{s['edge_line_load_n_per_m'] / 1e3:.1f}") for s in record["meshes"]]), PAGE)
    put("inputs", table(("joint", *names[:3], "slip of Eq. 45 / %"), [(name, *shown(s, most), f"{100 * s[slip]:.0f}") for name, s in record["inputs"].items()]), PAGE)
    put("laws", table(("support", "contact law", "torque steps", *names[1:]), [
        (*name.split(", "), *shown(s, [*READINGS][1:])) for name, s in record["laws"].items()]), PAGE)


def main():
    """Solve and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", help="folder for the runs")
    parser.add_argument("--tables", action="store_true", help="solve nothing")
    options = parser.parse_args()
    if not options.tables:
        work = Path(options.work or tempfile.mkdtemp())
        work.mkdir(parents=True, exist_ok=True)
        write_record("which_k_ts", {"readings": readings(work), "meshes": meshes(), "inputs": inputs(), "laws": laws()})
    write_tables(read_record("which_k_ts"))


if __name__ == "__main__":
    main()
