#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed against accuracy: for each method the error it reaches over the CPU time it takes, peers beside it, on one page.

Usage: bench/pareto.py [--quick] [CHART ...]; writes bench/results/pareto.json, docs/figures/pareto.png and the tables of
docs/evidence/speed_accuracy.md. A chart that is named is measured anew, the others keep their record.
FINUFFT (PyPI) and CalculiX (Debian package calculix-ccx) are drawn where they are installed.
"""
import argparse
import json
import shutil
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from matplotlib.ticker import NullFormatter

from common import FIGURES, RESULTS, new_axes, put, solve, table, take_turns, write_record


@dataclass
class Point:
    """One run of a method: relative error, CPU seconds, peak memory [MB] where it was measured."""

    method: str
    setting: str
    error: float
    seconds: float
    memory_mb: float = float("nan")
    default: bool = False
    peer: bool = False


@dataclass
class Chart:
    """A family of methods on one problem."""

    name: str
    title: str
    decides: str
    points: list


def relative(value, truth):
    """Relative error, not below rounding."""
    return float(max(abs(value / truth - 1), 1e-16))


def heights(_):
    """Eq. 1 on 512 x 512 points, 160 waves."""
    from surface_generator import LENGTH, by_finufft, spectrum

    from hdengine import surface
    n = 512
    s = spectrum(n, 10, 16)
    h, step = LENGTH / n, n // 64
    exact = surface.generate(64, h * step, **s, method="direct")
    w = surface.waves(**s)
    calls = {("direct sum", "", False): lambda: surface.generate(n, h, **s, method="direct"),
             ("matrix product", "bit-exact", False): lambda: surface.generate(n, h, **s, method="product")}
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        calls["matrix product", f"{tolerance:g}", False] = lambda t=tolerance: surface.generate(n, h, **s, tolerance=t, method="product")
        calls["NUFFT", f"{tolerance:g}", False] = lambda t=tolerance: surface.generate(n, h, **s, tolerance=t, method="nufft")
        try:
            import finufft  # noqa: F401
            calls["FINUFFT", f"{tolerance:g}", True] = lambda t=tolerance: by_finufft(w, n, t, complex) + w["offset_m"]
        except ImportError:
            pass
    timing, found = take_turns(calls, turns=5, limit=20, clock=time.process_time)
    points = [Point(name, setting, float(max(np.sqrt(np.mean((found[key][::step, ::step] - exact) ** 2)) / exact.std(), 1e-16)),
                    timing[key].median, default=setting == "bit-exact", peer=peer) for key in calls for name, setting, peer in [key]]
    return Chart("heights", f"Heights of Eq. 1, {n} x {n} points, 160 waves",
                 "Without a tolerance heights are bit-exact products; with one, the engine takes the cheaper of product and NUFFT.", points)


def elements(quick):
    """A thin ring under cos 2 theta, one cell through 0.3 mm (Michell's solution)."""
    import elements as cases
    kinds = (("hex8", False, "C3D8"), ("hex8i", False, "C3D8I"), ("hex20r", True, "C3D20R"))
    points = []
    for kind, quadratic, peer in kinds:
        for divisions in (40, 80, 160) if quick else (20, 40, 80, 160, 320):
            case = cases.ring_harmonic(quadratic, 0.3, divisions)
            best = min((cases.engine(case, kind) for _ in range(3)), key=lambda r: r[1])
            points.append(Point(kind, str(divisions), relative((case.probe * best[0]).sum(), case.exact), best[1],
                                default=kind == "hex8i" and divisions == 80))
            if shutil.which("ccx") and divisions <= 160:
                with tempfile.TemporaryDirectory() as folder:
                    u, seconds = cases.calculix(case, peer, Path(folder))
                points.append(Point(f"CalculiX {peer}", str(divisions), relative((case.probe * u).sum(), case.exact), seconds, peer=True))
    return Chart("elements", "Ring of 0.3 mm under cos 2θ, one cell through the wall",
                 "hex8i is the default: hex20r is more accurate for one body, but costs more in contact and allows fewer options.", points)


def line_contact(quick):
    """Hertz's line contact: error of the pressure field."""
    import contact_cases as cc
    points = []
    for element, sizes in (("hex8i", (5, 10, 20) if quick else (5, 10, 20, 40)), ("hex20r", (5, 10) if quick else (5, 10, 20))):
        for m in sizes:
            start = time.process_time()
            found = cc.hertz_line(cc.cylinder(m, element))
            points.append(Point(element, f"{m} cells in a", float(found["field"]), time.process_time() - start,
                                default=element == "hex8i" and m == 10))
    return Chart("line_contact", "Hertz line contact, pressure field", "Contact needs five to ten cells in the half-width, whatever the element.", points)


def scene_runs(settings, truth_keys, quantities, base, method_of, default=None):
    """Points of runs of data/cd14.nml against a reference run: the largest relative error of some results."""
    def values(summary):
        return np.array([summary["results"][q] for q in quantities])

    reference, _ = solve("cd14.nml", *base, *truth_keys)
    truth, points = values(reference), []
    for setting, keys in settings.items():
        summary, command = solve("cd14.nml", *base, *keys)
        if summary is None or summary["status"] != "complete":
            continue
        error = float(max(np.abs(values(summary) / truth - 1).max(), 1e-16))
        points.append(Point(method_of(setting), setting, error, command.cpu_s, summary["peak_memory_mb"], default=setting == default))
    return points


def solvers(quick):
    """Every linear solver on one scene, against the default to a residual of 1e-12."""
    base = ["mesh.divisions=64", "mesh.band_facets=10", "load.assembly_steps=2", "load.torque_steps=2", "solver.tolerance=1e-10"]
    settings = {"condensed by harmonics": [], "Schur complement": ["solver.method=schur"],
                "Newton matrix, exact factors": ["solver.method=newton", "solver.factors=exact"],
                "Newton matrix, symmetric": ["solver.method=newton", "solver.factors=symmetric"],
                "Newton matrix, single": ["solver.method=newton", "solver.factors=single"],
                "Newton matrix, harmonics and GMRES": ["solver.method=newton", "solver.factors=harmonic"]}
    points = scene_runs(settings, ["solver.tolerance=1e-12"], ["rotation_rad", "normal_force_n", "pressure_max_pa"], base[:-1],
                        lambda s: s, "condensed by harmonics")
    return Chart("solvers", "Linear solvers, 64 x 10 facets of CD-14-100, same residual",
                 "All solve one problem: the condensation is the default because it is the fastest and the smallest.", points)


def meshes(quick):
    """Normal force and K_TS over the rows of facets, with and without short cells at the edges."""
    rows = (6, 10, 16, 24) if quick else (6, 10, 16, 24, 36)
    base = ["load.assembly_steps=1", "load.torque_steps=1", "mesh.through_ring=2", "mesh.through_wall=2"]
    settings = {}
    for r in rows:
        settings[f"{r} equal rows"] = [f"mesh.band_facets={r}", f"mesh.divisions={4 * round(5.75 * r / 4)}"]
        settings[f"{r} rows, edge cells"] = [*settings[f"{r} equal rows"], f"mesh.edge_length={0.36e-3 / r:.3g}"]
    finest = ["mesh.band_facets=64", "mesh.divisions=368", "mesh.edge_length=4e-6"]
    points = scene_runs(settings, finest, ["normal_force_n", "k_ts_nm_per_rad"], base,
                        lambda s: "edge cells" if "edge" in s else "equal rows", "16 equal rows")
    return Chart("meshes", "Mesh of the band: worst of force and K_TS (Eq. 45)",
                 "Equal rows err by some ten per cent in K_TS at any affordable size; cells shortened towards the edges pay at once.", points)


def planner(quick):
    """Tolerance asked, error reached and time of planned runs of CD-14-100."""
    finest, _ = solve("cd14.nml", "load.assembly_steps=2", "load.torque_steps=2", "mesh.through_ring=8", "mesh.through_wall=8",
                      "mesh.band_facets=64", "mesh.divisions=368", "mesh.edge_length=4e-6")
    points = []
    for tolerance in (0.1, 0.03) if quick else (0.1, 0.03, 0.01):
        summary, command = solve("cd14.nml", f"run.tolerance={tolerance}", "solver.kinematics=linear")
        plan = summary.get("plan", summary.get("planned", {}))
        errors = [relative(plan[key], finest["results"][key]) for key in ("k_ts_nm_per_rad", "normal_force_n") if key in plan]
        if errors:
            points.append(Point("planned run", f"asked {tolerance:g}", max(errors), command.cpu_s, summary["peak_memory_mb"], default=True))
            points.append(Point("tolerance asked", f"{tolerance:g}", tolerance, command.cpu_s, peer=True))
    return Chart("planner", "Planned runs: error of the promised limits", "The tolerance decides: the plan keeps it with the smallest mesh it can.", points)


def load_steps(quick):
    """Rotation over the number of load steps, against many."""
    base = ["mesh.divisions=64", "mesh.band_facets=10"]
    steps = (1, 2, 4, 8) if quick else (1, 2, 4, 8, 16)
    settings = {f"{s} + {s}": [f"load.assembly_steps={s}", f"load.torque_steps={s}"] for s in steps}
    settings["3 + 5"] = []
    points = scene_runs(settings, ["load.assembly_steps=64", "load.torque_steps=64"], ["rotation_rad", "k_ts_nm_per_rad", "friction_torque_nm"],
                        base, lambda s: "load steps", "3 + 5")
    return Chart("load_steps", "Load steps (assembly + torque)", "Three and five steps are the default; the planner halves them where that changes little.", points)


def symmetry(quick):
    """The same scene with and without its symmetry."""
    base = ["mesh.divisions=96", "mesh.band_facets=16", "load.assembly_steps=2", "load.torque_steps=2"]
    settings = {"found (auto)": [], "not used": ["solver.symmetry=full"]}
    points = scene_runs(settings, ["solver.tolerance=1e-12"], ["rotation_rad", "normal_force_n"], base, lambda s: s, "found (auto)")
    return Chart("symmetry", "Symmetry, 96 x 16 facets", "Symmetry costs no accuracy and is used wherever a scene has it.", points)


def kinematics(quick):
    """Small against large displacements, on one mesh."""
    base = ["mesh.divisions=40", "mesh.band_facets=6", "load.assembly_steps=2", "load.torque_steps=2"]
    settings = {"linear": ["solver.kinematics=linear"], "nonlinear": ["solver.kinematics=nonlinear"]}
    points = scene_runs(settings, ["solver.kinematics=nonlinear", "load.assembly_steps=8", "load.torque_steps=8"],
                        ["rotation_rad", "normal_force_n"], base, lambda s: s, "linear")
    return Chart("kinematics", "Kinematics at w = 0.2 mm", "Linear is the default; a tolerance below the difference makes the planner choose nonlinear.", points)


CHARTS = (heights, elements, line_contact, solvers, meshes, planner, load_steps, symmetry, kinematics)


def draw(charts):
    """All charts in one style: error over CPU seconds, a star for the default, hollow marks for peers."""
    columns = 3
    figure, axes = new_axes(-(-len(charts) // columns), columns, figsize=(16, 4.6 * -(-len(charts) // columns)))
    for ax, chart in zip(axes.flat, charts):
        for method in dict.fromkeys(p["method"] for p in chart["points"]):
            mine = sorted((p for p in chart["points"] if p["method"] == method), key=lambda p: p["seconds"])
            peer = mine[0]["peer"]
            line, = ax.plot([p["seconds"] for p in mine], [p["error"] for p in mine], "o--" if peer else "o-", ms=6,
                            mfc="white" if peer else None, lw=1.2, label=method)
            for p in mine:
                if p["default"]:
                    ax.plot(p["seconds"], p["error"], "*", ms=17, color=line.get_color(), mec="black", zorder=4)
        ax.set(xscale="log", yscale="log", xlabel="CPU time / s", ylabel="relative error", title=chart["title"])
        ax.title.set_fontsize(12)
        for axis in (ax.xaxis, ax.yaxis):
            low, high = axis.get_view_interval()
            if high > 10 * low:   # one decade has labels enough
                axis.set_minor_formatter(NullFormatter())
        ax.tick_params(axis="x", which="minor", labelsize=8, labelrotation=40)
        ax.legend(fontsize=8)
    for ax in axes.flat[len(charts):]:
        ax.remove()
    figure.savefig(FIGURES / "pareto.png", dpi=80)


def page(charts):
    """Sentences and tables of the page."""
    parts = []
    for c in charts:
        rows = [(p["method"], p["setting"] or "-", f"{p['error']:.1e}", f"{p['seconds']:.3g}",
                 "-" if np.isnan(p["memory_mb"] or np.nan) else f"{p['memory_mb']:.0f}", "default" if p["default"] else "peer" if p["peer"] else "")
                for p in c["points"]]
        parts.append(f"## {c['title']}\n\n{c['decides']}\n\n" + table(("method", "setting", "error", "CPU s", "MB", ""), rows))
    return "\n\n".join(parts)


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("charts", nargs="*", choices=[c.__name__ for c in CHARTS] + [[]])
    parser.add_argument("--quick", action="store_true", help="smaller sizes")
    options = parser.parse_args()
    path = RESULTS / "pareto.json"
    old = {c["name"]: c for c in json.loads(path.read_text())["charts"]} if path.exists() else {}
    charts = []
    for make in CHARTS:
        name = make.__name__
        if options.charts and name not in options.charts:
            if name in old:
                charts.append(old[name])
            continue
        start = time.time()
        charts.append(asdict(make(options.quick)))
        print(f"{name}: {len(charts[-1]['points'])} points, {time.time() - start:.0f} s", flush=True)
    for c in charts:
        for p in c["points"]:
            p["memory_mb"] = None if p["memory_mb"] is None or np.isnan(p["memory_mb"]) else p["memory_mb"]
    write_record("pareto", {"charts": charts})
    for c in charts:
        for p in c["points"]:
            p["memory_mb"] = np.nan if p["memory_mb"] is None else p["memory_mb"]
    draw(charts)
    put("charts", page(charts), "evidence/speed_accuracy")


if __name__ == "__main__":
    main()
