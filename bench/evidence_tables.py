#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of the pages of docs/evidence on elements, contact, meshes, solvers and the planner, made of the records of bench/results.

Every table ends with a line that names its record and the engine that made it. Usage: bench/evidence_tables.py; run it after a bench script
has written its record. tests/python/test_evidence.py holds pages and records together.
"""
import json
from statistics import median

from common import RESULTS, ROOT, put, read_record, read_rows, table

# records that were written before records named their commit
EARLIER = {"numerical_parameters": "22 November 2026", "peer_hub_80_slopes": "21 November 2026"}


def origin(name):
    """The line below a table: its record, and the engine and the machine that made it."""
    path = next(RESULTS.glob(f"{name}.json*"))
    text = path.read_text()
    whole = json.loads(text.splitlines()[-1] if path.suffix == ".jsonl" else text)
    made = whole.get("provenance") if isinstance(whole, dict) else None
    return (f"Record: `{path.relative_to(ROOT)}`, engine `{made['commit']}`, {made['machine']}." if made else
            f"Record: `{path.relative_to(ROOT)}`, engine of {EARLIER[name]}.")


NARROW = "\u202f"  # a space that does not break


def rounded(value, digits=0):
    """A number without a minus before zero."""
    text = f"{value:,.{digits}f}".replace(",", NARROW)
    return text.lstrip("-") if not text.strip("-0.") else text


def percent(value, digits=1, sign="+"):
    """A share or a difference in per cent, 'below ...' where nothing is left after rounding."""
    text = f"{100 * value:{sign}.{digits}f} %"
    return text if float(text[:-2]) else f"below {10**-digits:g} %"


def short(value):
    """One digit and a power of ten."""
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e+")


# --- elements and closed solutions

SHOWN_ELEMENTS = ("hex8", "hex8i", "hex20r", "C3D8I", "C3D20")
SHOWN_CASES = (("straight beam, rectangles, in plane", "6x1x1", "MacNeal and Harder"), ("straight beam, trapezoids, in plane", "6x1x1", "the same"),
               ("straight beam, parallelograms, in plane", "6x1x1", "the same"), ("curved beam, in plane", "24x4x2", "beam theory"),
               ("twisted beam, in plane", "24x4x2", "MacNeal and Harder"), ("pinched cylinder", "32x32", "shell theory"),
               ("cup, cos 2 theta at its mouth", "40x8", "Sanders and Koiter"), ("cup, cos 2 theta at its mouth", "120x24", "the same"),
               ("ring t = 0.7 mm, cos 2 theta", "80", "Michell, exact"), ("ring t = 0.3 mm, cos 2 theta", "40", "Michell, exact"),
               ("ring t = 0.3 mm, cos 2 theta", "80", "Michell, exact"))


def element_errors():
    """Errors of the displacement, ours and the peer's."""
    error = {(r["case"], r["mesh"], r["element"]): r["error_percent"] for r in read_record("elements")["rows"]}

    def shown(e):
        digits = 0 if abs(e) >= 10 else 1 if abs(e) >= 0.095 else 2
        return f"{e:+.{digits}f}"
    return ("case", "mesh", *SHOWN_ELEMENTS, "reference"), [
        (case.replace(" theta", "θ").replace("t = ", ""), mesh, *(shown(error[case, mesh, e]) for e in SHOWN_ELEMENTS), reference)
        for case, mesh, reference in SHOWN_CASES]


def element_agreement():
    """Largest distance of every pair of like elements, and their times."""
    rows = {(r["case"], r["mesh"], r["element"]): r for r in read_record("elements")["rows"]}
    out = []
    for ours, theirs in (("hex8", "C3D8"), ("hex20r", "C3D20R"), ("hex8i", "C3D8I")):
        away = max(abs(r["error_percent"] - rows[case, mesh, theirs]["error_percent"]) for (case, mesh, e), r in rows.items() if e == ours)
        time = [rows["pinched cylinder", "64x64", e]["cpu_s"] for e in (ours, theirs)]
        out.append((f"`{ours}`", theirs, f"{away:.1g} points", f"{time[0] / time[1]:.2f}", short(read_record("elements")["patch_test_error"][ours])))
    return ("ours", "CalculiX", "largest difference of errors", "CPU time, ours over CalculiX", "patch test, ours"), out


def closed_solutions():
    """Contact against formulas."""
    r = read_record("contact_standards")
    line = {(x["element"], x["cells"]): x for x in r["hertz_line"]["rows"]}
    slip = {(x["element"], x["cells"], x["matching"]): x for x in r["cattaneo"]["rows"]}
    ball = max(r["hertz_sphere"]["rows"], key=lambda x: x["cells"])
    fine = [x for x in r["persson"] if x["cells"] == 40]
    rows = []
    for e in ("hex8i", "hex20r"):
        x = line[e, 10]
        rows += [("Hertz, line: half-width, peak", f"`{e}`, {x['elements']:.0f}", f"{percent(x['half_width'])}, {percent(x['peak'])}", "1 %"),
                 ("the same: field", f"`{e}`, {x['elements']:.0f}", percent(x["field"], sign=""), "-")]
    rows += [("Hertz, sphere: load, radius, peak", "`hex8i`, 10", ", ".join(percent(ball[k]) for k in ("load", "radius", "peak")), "1 %"),
             ("the same: field", "`hex8i`, 10", percent(ball["field"], sign=""), "-")]
    for cells in (10, 20):
        x = slip["hex8i", cells, True]
        rows += [("Cattaneo-Mindlin: stick width", f"`hex8i`, {cells}", f"{percent(x['stick_low'])}, {percent(x['stick_high'])}", "2 %"),
                 ("the same: field of the shear", f"`hex8i`, {cells}", f"{percent(x['field'][0], sign='')}, {percent(x['field'][1], sign='')}", "2 %"),
                 ("the same, load reversed: field", f"`hex8i`, {cells}", percent(max(x["field"]), sign=""), "-")]
    rows += [("rod dragged to gross slip and back: force", "`hex8i`, 200", percent(r["dragged_rod"][-1]["worst"], sign=""), "-"),
             ("pin in a hole (Persson): peak, worst of ten", "`hex20r`, 40", percent(max(abs(x["peak"]) for x in fine), sign=""), "-")]
    for e, layers in (("hex20r", 3), ("hex8i", 6), ("hex8i", 3)):
        mine = [x for x in r["lame"] if (x["element"], x["layers"], x["divisions"]) == (e, layers, [80, 64])]
        worst = [max(abs(x[k]) for x in mine) for k in ("pressure_mean", "pressure_worst", "displacement_worst")]
        rows.append(("Lamé press fit: mean pressure, worst point, displacement", f"`{e}`, {layers} layers", ", ".join(percent(v, 2, "") for v in worst),
                     "0.1, 0.5, 0.5 %"))
    hold = {x["element"]: x["error"] for x in r["holding_torque"] if x["divisions"] == [80, 64]}
    rows += [("holding torque of the press fit", f"`{e}`", percent(hold[e], 2), "-") for e in ("hex20r", "hex8i")]
    return ("problem", "element, cells", "measured", "target"), rows


# --- Newton's method and load steps

def newton():
    """Iterations and order of convergence."""
    return ("scene", "iterations, sparse matrix", "iterations, condensed", "most in a step", "median order (of)", "largest r₁/r₀²"), [
        (name, x["iterations"], x["iterations_condensed"] or "-", x["most_in_a_step"], f"{median(x['orders']):.1f} ({len(x['orders'])})",
         f"{x['largest_factor']:.0e}".replace("e+0", "e"))
        for name, x in read_record("newton_history").items()]


def torque_steps():
    """Rotation over the number of torque steps, against 80 of them."""
    rows = {(r["support"], r["torque_steps"]): r["results"] for r in read_record("step_study")}
    return ("support", "5 steps", "10", "20", "40"), [
        (s, *(percent(rows[s, n]["rotation_rad"] / rows[s, 80]["rotation_rad"] - 1, 2) for n in (5, 10, 20, 40))) for s in ("hub", "bearing")] + [
        (f"{s}: Newton iterations", *(rows[s, n]["iterations"] for n in (5, 10, 20, 40))) for s in ("hub", "bearing")]


def parameters():
    """Change of the rotation over two decades of the numerical parameters."""
    return ("parameter", "values", "HUB", "FREE", "iterations, HUB"), [
        (f"`{r['parameter']}`" if "." in r["parameter"] else r["parameter"], ", ".join(f"{v:g}" for v in r["values"]),
         *(percent(c, 2, "") for c in r["change"]), " / ".join(str(x[1]) for x in r["hub"])) for r in read_record("numerical_parameters")]


# --- the contact scene

def balance():
    """Facets against reactions, and the torque."""
    return ("scene", "normal force / N", "facets against reactions", "torque out of balance / N m", "rotation / µrad"), [
        (r["scene"].replace("hex20r, 40", "`hex20r`, 40 divisions").replace("80/64", "64 on 80 divisions").replace("6/5 facets", "5 on 6 rows"),
         rounded(x["facet_force_n"]), short(abs(x["facet_force_n"] / x["reaction_force_n"] - 1)), short(abs(x["torque_balance_nm"])),
         f"{1e6 * x['rotation_rad']:.1f}") for r in read_record("balance_study") for x in [r["results"]]]


def peer_hub():
    """CalculiX and the engine on one mesh."""
    runs = list(read_record("peer_hub_215")["runs"].items())
    names = {"hdengine, newton": "hdengine, sparse matrix, exact factors", "hdengine, condensed": "hdengine, condensed (default)"}
    slow = next(x["wall_s"] for name, x in runs if "CalculiX" in name)
    return ("code", "wall / s", "over CalculiX", "memory / MB", "Newton iterations", "rotation / µrad"), [
        (names.get(name, "CalculiX 2.20, C3D8I"), f"{x['wall_s']:.1f}", f"{x['wall_s'] / slow:.2g}", f"{x['memory_mb']:.0f}", x["iterations"],
         f"{1e6 * x['rotation_rad']:.1f}") for name, x in reversed(runs)]


def stick_slopes():
    """CalculiX over its stick slope."""
    runs = {name: x for name, x in read_record("peer_hub_80_slopes")["runs"].items() if not name.endswith("newton")}
    label = lambda name: "hdengine, none" if "hdengine" in name else name.split("slope ")[1].split(" ")[0].replace("e+0", "e")  # noqa: E731
    order = sorted(runs, key=lambda name: ("hdengine" in name, name))
    return ("stick slope / (N/mm³)", "rotation / µrad", "Newton iterations"), [
        (label(n), f"{1e6 * runs[n]['rotation_rad']:.1f}" if runs[n]["rotation_rad"] else "no convergence", runs[n]["iterations"]) for n in order]


def rim():
    """Forces over the section behind the rim."""
    return ("rim until / mm", "taper over / mm", "normal force / N", "force of a lobe / N"), [
        (f"{1e3 * r['rim_length_m']:g}", f"{1e3 * r['rim_taper_m']:g}", rounded(r["results"]["normal_force_n"]), rounded(r["results"]["lobe_force_x_n"]))
        for r in read_record("rim_study")]


def slip():
    """Torque at which CD-14-100 slips as a whole."""
    return ("interference / µm", "refused at / N m", "last equilibrium / N m", "µ∫p r dA / N m", "refused, over µ∫p r dA"), [
        (f"{1e6 * r['interference_m']:.0f}", f"{x['gross_slip_torque_nm']:.2f}", f"{-x['friction_torque_nm']:.2f}", f"{x['friction_capacity_nm']:.2f}",
         percent(x["gross_slip_torque_nm"] / x["friction_capacity_nm"] - 1, 2)) for r in read_record("slip_study") for x in [r["results"]]]


def default_scene():
    """CD-14-100 by two solvers."""
    names = {"": "condensed (default)", "solver.method=newton solver.factors=exact": "sparse matrix, exact factors"}
    return ("solver", "total / s", "memory / MB", "iterations", "normal force / N", "peak / MPa", "rotation / µrad"), [
        (names[" ".join(r["keys"])], f"{r['total_s']:.1f}", f"{r['peak_memory_mb']:.0f}", x["iterations"], rounded(x["normal_force_n"]),
         f"{1e-6 * x['pressure_max_pa']:.0f}", f"{1e6 * x['rotation_rad']:.2f}")
        for r in read_record("default_study") for x in [r["results"]] if " ".join(r["keys"]) in names]


# --- large displacements

def kinematics():
    """HUB and INT by both descriptions."""
    rows = {r["scene"]: r["results"] for r in read_record("peer_scenes")}
    out = []
    for scene in ("HUB", "INT"):
        small, large = rows[scene], rows[f"{scene}, large rotations"]
        out += [(scene, name, x["iterations"], rounded(x["normal_force_n"]), f"{1e6 * x['rotation_rad']:.1f}",
                 *(percent(x[k] / small[k] - 1) if x is large else "" for k in ("normal_force_n", "rotation_rad")))
                for name, x in (("small", small), ("large", large))]
    return ("scene", "displacements", "iterations", "normal force / N", "rotation / µrad", "change of force", "of rotation"), out


def kinematics_map():
    """Largest change by large displacements over w."""
    rows = read_record("kinematics_map")
    return ("w / mm", "K_TS by Eq. 45", "normal force", "mid-band pressure"), [
        (f"{1e3 * w:.2f}", *(percent(max(abs(r["error"][i]) for r in rows if r["w_m"] == w), sign="") for i in range(3)))
        for w in sorted({r["w_m"] for r in rows})]


# --- meshes

def meshes():
    """HUB refined in all directions of the surface."""
    return ("divisions x rows", "dof", "normal force / N", "area / mm²", "mid-band / MPa", "rotation / µrad", "peak / MPa"), [
        (f"{r['divisions']} x {r['band_facets']}", rounded(r["dof"]), rounded(x["normal_force_n"]), f"{1e6 * x['contact_area_m2']:.0f}",
         f"{1e-6 * x['pressure_mid_mean_pa']:.2f}", f"{1e6 * x['rotation_rad']:.1f}", f"{1e-6 * x['pressure_max_pa']:.0f}")
        for r in read_record("mesh_study") for x in [r["results"]]]


def layers():
    """What more layers change: HUB on 12 rows, CD-14-100 on its own mesh."""
    hub = {r["layers"]: r["results"] for r in read_record("layer_study") if (r["element"], r["band_facets"]) == ("hex8i", 12)}
    cd14 = {1: read_record("default_study")[0]["results"]} | {
        n: next(r["results"] for r in read_record("default_study") if f"mesh.through_wall={n}" in r["keys"]) for n in (2, 4)}
    keys = ("normal_force_n", "pressure_mid_mean_pa", "rotation_rad")
    return ("scene", "layers", "normal force", "mid-band pressure", "rotation"), [
        (name, f"1 to {n}", *(percent(of[n][k] / of[1][k] - 1) for k in keys)) for name, of in (("HUB, 12 rows", hub), ("CD-14-100", cd14)) for n in (2, 4)]


def orders():
    """Fitted orders of convergence."""
    def of(fit):
        return f"{fit['order']:.1f} ({percent(fit['misfit'], 1, '')})" if 0.31 < fit["order"] < 3.99 else "-"
    names = {"HUB, hex8i": "HUB, `hex8i`, one layer", "HUB, hex20r": "HUB, `hex20r`, one layer", "grid, hex8i, layers and edges too": "grid, `hex8i`"}
    return ("series", "meshes", "normal force", "rotation", "area", "mid-band profile"), [
        (names[name], f"{s['rows'][0]['divisions']} x {s['rows'][0]['band_facets']} to {s['rows'][-1]['divisions']} x {s['rows'][-1]['band_facets']}",
         *(of(s["fits"][k]) for k in ("normal_force_n", "rotation_rad", "contact_area_m2", "profile"))) for name, s in read_record("mesh_orders").items()]


def edges():
    """K_TS on equal rows and on rows that shorten towards the edges."""
    rows = read_record("edge_study")

    def shown(of):
        return [(f"{r['divisions']} x {r['rows']}", f"{1e-6 * r['results']['k_ts_nm_per_rad']:.2f}", f"{1e-6 * r['results']['k_ts_tangent_nm_per_rad']:.3f}")
                for r in of]
    hard = [r for r in rows if "contact.law=joint" not in r["keys"]]
    equal, short_rows = (shown([r for r in hard if bool(r["keys"]) is bool(e)]) for e in (0, 1))
    return ("equal rows", "Eq. 45", "tangent", "short rows at the edges", "Eq. 45", "tangent"), [(*a, *b) for a, b in zip(equal, short_rows)]


# --- solvers

METHODS = {"condensed": "harmonics", "single": "symmetric, single precision", "exact": "sparse matrix", "schur": "Schur complement"}


def cost():
    """Time and memory over the size."""
    rows = read_record("cost_over_size")["rows"]
    by = {(r["dof"], r["method"]): f"{r['cpu_s']:.1f} / {r['memory_mb']:.0f}" for r in rows}
    facets = {r["dof"]: r["facets"] for r in rows}
    fits = read_record("cost_over_size")["exponent_and_factor"]
    return ("dof", "facets", *METHODS.values()), [(rounded(n), rounded(facets[n]), *(by.get((n, m), "-") for m in METHODS)) for n in sorted(facets)] + [
        ("exponents", "", *(f"{fits[m]['cpu_s'][0]:.1f} / {fits[m]['memory_mb'][0]:.1f}" for m in METHODS))]


SOLVERS = ("condensed", "harmonic", "single", "symmetric", "exact", "schur")


def choice():
    """CPU seconds and memory of every matrix solver, and what they differ by."""
    rows = read_record("solver_choice")
    out = []
    for scene in dict.fromkeys(r["scene"] for r in rows):
        mine = {r["solver"]: r for r in rows if r["scene"] == scene}
        out.append((scene, rounded(mine["exact"]["dof"]), *(f"{mine[s]['cpu_s']:.1f} / {mine[s]['memory_mb']:.0f}" if s in mine else "-" for s in SOLVERS),
                    short(max(r["difference"] for r in mine.values()))))
    return ("scene", "dof", *(f"`{s}`" for s in SOLVERS), "largest difference"), out


def teeth():
    """K_FTS over the stiffness of a pair, clearance and torque."""
    return ("stiffness of a pair / (N/m)", "outermost pairs open / µm", "torque / N m", "K_FTS / (kN m/rad)"), [
        ("rigid" if r["tooth_stiffness_n_per_m"] > 1e12 else f"{r['tooth_stiffness_n_per_m']:.3g}".replace("e+0", "e"), f"{1e6 * r['tooth_clearance_m']:.0f}",
         r["torque_nm"], f"{1e-3 * r['k_fts_nm_per_rad']:.1f}") for r in read_record("teeth_study")]


# --- robustness and planner

def random_scenes():
    """Outcomes of random scenes."""
    r = read_record("random_scenes")
    says = {"converged": "complete, balanced", "gross slip": "error 4: gross slip at a stated torque", "not held": "error 4: the flexspline is not held"}
    return ("outcome", "scenes", "what the engine says"), [(name, r["outcomes"].get(name, 0), text) for name, text in says.items()] + [
        ("anything else", sum(n for name, n in r["outcomes"].items() if name not in says), "")]


def options():
    """Outcomes by option."""
    names = {"contact.law": "rough joint as contact law", "wave_generator.shape": "faces formed alike", "wave_generator.ring_contact":
             "ring may lift off the cam", "load.torque_load": "torque as tooth forces", "solver.kinematics": "large displacements",
             "contact.slave": "cup as slave"}
    by = read_record("random_scenes")["outcomes_by_option"]
    kinds = ("converged", "gross slip", "not held")
    return ("option", *kinds), [(f"{names[key]}", *(by[key].get(k, 0) for k in kinds)) for key in names]


def hard_scenes():
    """Scenes that gave the peer trouble."""
    return ("scene", "Newton iterations", "halved steps", "normal force / N", "rotation / µrad", "µ∫p r dA / N m"), [
        (r["scene"].replace("4/5 of the divisions", "of 64 divisions"), x["iterations"], x["cut_backs"], rounded(x["normal_force_n"]),
         f"{1e6 * x['rotation_rad']:.1f}", f"{x['friction_capacity_nm']:.1f}") for r in read_record("peer_scenes") for x in [r["results"]] if r["code"] == 0]


def promises():
    """Promised and kept by tolerance."""
    rows = [run for row in read_rows("promised_scenes", "scene").values() for run in row["runs"]]
    out = []
    for tolerance in sorted({run["tolerance"] for run in rows}, reverse=True):
        mine = [run for run in rows if run["tolerance"] == tolerance]
        made = [run for run in mine if run["met"] == "yes"]
        judged = [run for run in made if "true_error" in run]
        worst = [max(run["true_error"].values()) for run in judged]
        cautious = median(max(run["estimate"].values()) / w for run, w in zip(judged, worst))
        out.append((f"{100 * tolerance:g} %", len(mine), len(made), len(judged), sum(w <= tolerance for w in worst),
                    percent(median(worst), sign=""), percent(max(worst), sign=""), f"{cautious:.1f}",
                    percent(median(max(run["true_error_of_mesh"].values()) for run in judged), sign=""), f"{median(run['seconds'] for run in made):.0f}"))
    return ("tolerance", "scenes", "promised", "judged", "kept", "median error", "largest error", "estimate over error, median",
            "median error of the mesh", "median CPU s"), out


def promised_results():
    """Errors of what is promised, by result and tolerance."""
    rows, out = list(read_rows("promised_scenes", "scene").values()), []
    names = {"k_ts_tangent_nm_per_rad": "tangent K_TS", "rotation_rad": "rotation", "normal_force_n": "normal force", "pressure_mid_mean_pa": "mid-band pressure"}
    for tolerance in sorted({run["tolerance"] for row in rows for run in row["runs"]}, reverse=True):
        for name, words in names.items():
            pairs = [(run["true_error"][name], run["estimate"][name]) for row in rows for run in row["runs"]
                     if run["tolerance"] == tolerance and name in run.get("true_error", {}) and run["met"] == "yes"]
            out.append((f"{100 * tolerance:g} %", words, len(pairs), percent(median(t for t, _ in pairs), sign=""),
                        percent(max(t for t, _ in pairs), sign=""), sum(t > e for t, e in pairs), sum(t > tolerance for t, _ in pairs)))
    return ("tolerance", "result", "judged", "median error", "largest error", "above its estimate", "above the tolerance"), out


# --- the joint law

def joint_shear():
    """Shear of rough patches: the law against boundary elements, by surface; ranges over three shares of contact."""
    rows, out = read_record("joint_shear")["patches"], []
    for surface in dict.fromkeys(r["surface"] for r in rows):
        some = [r for r in rows if r["surface"] == surface]

        def span(name, some=some, digits=1, factor=100):
            values = [factor * r[name] for r in some]
            return f"{min(values):.{digits}f} to {max(values):.{digits}f}"

        out.append((surface, *(span(f"{law}_{part}_error") for law in ("law", "theory") for part in ("curve", "loop")),
                    span("k_t_over_k_n", digits=3, factor=1)))
    return ("surface", "k_N of boundary elements: loading / % of µP", "loop", "k_N of the spectrum: loading / % of µP", "loop", "k_T/k_N"), out


def joint_spot():
    """A Hertz spot against Cattaneo and Mindlin."""
    return (("points a side", "loading / % of µP", "loop / % of µP", "slipping share of the area / %"),
            [(r["points"], *(f"{100 * r[k]:.2f}" for k in ("curve_error", "loop_error", "slip_area_error"))) for r in read_record("joint_shear")["spot"]])


def joint_peers():
    """Solvers with friction on one Hertz spot."""
    return (("solver", "mean pressure over asked", "mean shear over asked", "slipping share", "knows the slip so far"),
            [(f"hdengine `{r['solver']}`" if r["remembers_slip"] else f"tamaas `{r['solver']}`", f"{r['mean_pressure_over_asked']:.3f}",
              f"{r['mean_shear_over_asked']:.3f}", f"{r['slip_share_of_contact']:.2f}", "yes" if r["remembers_slip"] else "no")
             for r in read_record("joint_shear")["tamaas"]])


def joint_ten():
    """Theory over boundary elements on ten generated surfaces, mean of two maps, by the share that touches."""
    surfaces, out = read_record("joint_law")["surfaces"], []
    for name in dict.fromkeys(s["surface"] for s in surfaces if "measured" not in s["surface"]):
        maps = [s["rows"] for s in surfaces if s["surface"] == name]
        ratios = [(a["k_n_theory"] * b["k_n_theory"] / a["k_n_boundary_elements"] / b["k_n_boundary_elements"])**0.5 for a, b in zip(*maps)]
        out.append((name, *(f"{r:.2f}" for r in ratios)))
    return ("surface", "0.2 %", "0.5 %", "1.5 %", "4 %", "13 %", "36 %"), out


def joint_models():
    """K_TS of CD-14-100 by each model, and what changes it."""
    rings = {"cd14": "of the paper", "cd14_ground": "ground"}
    return (("rings", "model", "Eq. 45 at 5 N m / (MN m/rad)", "tangent at 1 N m", "tangent at 5 N m", "tangent, 1 to 5 N m / %",
             "tangent, w 0.195 to 0.215 mm / %", "tangent, 10 µm eccentric / %"),
            [(rings[c["scene"]], f"`{c['model']}`", f"{c['eq45_5_nm'] / 1e6:.3f}", f"{c['tangent_1_nm'] / 1e6:.3f}", f"{c['tangent_5_nm'] / 1e6:.3f}",
              *(f"{c[k]:+.1f}" for k in ("torque_1_to_5_percent", "w_0195_to_0215_percent", "eccentricity_10um_percent")))
             for c in read_record("joint_models")["conclusions"]])


def joint_bands():
    """95 % bands of both readings by group of causes."""
    found = read_record("joint_band")["summary"]
    names = {"maps": "two maps of 1 mm", "joint": "the same, scatter of the law, E*, hardness", "friction": "friction 0.05 to 0.15",
             "geometry": "geometry and wave generator", "elastic constants": "Young's moduli", "all": "all"}
    return (("cause", "tangent / %", "Eq. 45 / %"),
            [(names[g], *("{:+.1f} to {:+.1f}".format(*found[r]["bands_percent"][g]) for r in ("tangent", "eq45"))) for g in names])


def joint_shares():
    """Shares of the variance of the tangent and of Eq. 45, the largest first."""
    found = {r: read_record("joint_band")["summary"][r]["shares_of_variance"] for r in ("tangent", "eq45")}
    joint = ("sampling", "law", "E* and hardness", "noise", "longer waves")
    total = {"joint, all causes": [sum(f.get(k, 0) for k in joint) for f in found.values()]}
    total |= {f"`{k}`": [f[k] for f in found.values()] for k in found["tangent"] if k not in joint}
    shown = sorted(total.items(), key=lambda x: -max(x[1]))[:9]
    return ("input", "tangent / %", "Eq. 45 / %"), [(k, *(rounded(100 * x, 1) for x in v)) for k, v in sorted(shown, key=lambda x: -x[1][0])]


def joint_measured():
    """Measured joints over the law at the ends of their pressures."""
    out = []
    for r in read_record("joint_measured")["rows"]:
        mean, spread = r["geometric_mean_over_law"], r["spread"]
        out.append((r["joint"], r["source"], len(r["measured"]), f"{r['pressure_pa'][0] / 1e6:.2g} to {r['pressure_pa'][-1] / 1e6:.2g}",
                    f"{mean[0]:.2f} to {mean[-1]:.2f}", f"{min(spread):.1f} to {max(spread):.1f}"))
    return ("joint", "of the book", "joints", "pressure / MPa", "measured mean over law, over that range", "largest over smallest measured"), out


TABLES = {  # marker: page, record, builder
    "joint-shear": ("joint_law", "joint_shear", joint_shear),
    "joint-spot": ("joint_law", "joint_shear", joint_spot),
    "joint-peers": ("joint_law", "joint_shear", joint_peers),
    "joint-ten": ("joint_law", "joint_law", joint_ten),
    "joint-models": ("joint_k_ts", "joint_models", joint_models),
    "joint-bands": ("joint_k_ts", "joint_band", joint_bands),
    "joint-shares": ("joint_k_ts", "joint_band", joint_shares),
    "joint-measured": ("joint_measured", "joint_measured", joint_measured),
    "element-errors": ("elements", "elements", element_errors),
    "element-agreement": ("elements", "elements", element_agreement),
    "closed-solutions": ("contact_standards", "contact_standards", closed_solutions),
    "newton": ("newton", "newton_history", newton),
    "torque-steps": ("newton", "step_study", torque_steps),
    "parameters": ("newton", "numerical_parameters", parameters),
    "balance": ("contact_scene", "balance_study", balance),
    "peer-hub": ("contact_scene", "peer_hub_215", peer_hub),
    "stick-slopes": ("contact_scene", "peer_hub_80_slopes", stick_slopes),
    "rim": ("contact_scene", "rim_study", rim),
    "slip": ("contact_scene", "slip_study", slip),
    "default-scene": ("contact_scene", "default_study", default_scene),
    "kinematics": ("kinematics", "peer_scenes", kinematics),
    "kinematics-map": ("kinematics", "kinematics_map", kinematics_map),
    "meshes": ("meshes", "mesh_study", meshes),
    "layers": ("meshes", "layer_study", layers),
    "orders": ("meshes", "mesh_orders", orders),
    "edges": ("meshes", "edge_study", edges),
    "cost": ("solvers", "cost_over_size", cost),
    "choice": ("solvers", "solver_choice", choice),
    "teeth": ("teeth_and_records", "teeth_study", teeth),
    "random-scenes": ("robustness", "random_scenes", random_scenes),
    "options": ("robustness", "random_scenes", options),
    "hard-scenes": ("robustness", "peer_scenes", hard_scenes),
    "promises": ("planner_promises", "promised_scenes", promises),
    "promised-results": ("planner_promises", "promised_scenes", promised_results),
}


def text_of(marker):
    """What stands between the markers of a table."""
    _, record, build = TABLES[marker]
    return f"{table(*build())}\n\n{origin(record)}"


if __name__ == "__main__":
    for marker, (page, record, _) in TABLES.items():
        if list(RESULTS.glob(f"{record}.json*")):
            put(marker, text_of(marker), f"evidence/{page}")
        else:
            print(f"no record {record}")
