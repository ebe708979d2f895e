# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of docs/evidence on scenes, meshes, solvers, robustness and the planner, made of their records."""
from statistics import median

from evidence_words import percent, rounded, short
from promised_scenes import NAMES, is_judged, judged, judged_results

from common import read_record, read_rows


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


def cam_orders():
    """Ellipse and cosine in both descriptions."""
    return ("w / mm", "cam", "kinematics", "normal force / N", "area / mm²", "peak pressure / MPa", "mid-band pressure / MPa", "rotation / µrad"), [
        (f"{1e3 * r['w_m']:.1f}", r["cam"], r["kinematics"], f"{r['normal_force_n']:.0f}", f"{1e6 * r['contact_area_m2']:.0f}",
         f"{1e-6 * r['pressure_max_pa']:.1f}", f"{1e-6 * r['pressure_mid_mean_pa']:.3f}", f"{1e6 * r['rotation_rad']:.2f}") for r in read_record("cam_orders")]


def load_path():
    """Who carries the torque with the ring held and sliding."""
    found = read_record("explained")["ring_tangent"]
    return ("`ring_tangent`", "hub / N m", "wave generator / N m", "ring springs / N m", "normal force / N", "rotation / µrad"), [
        (name, f"{r['hub_torque_nm']:.3f}", rounded(r["wave_generator_torque_nm"], 3), short(r["ring_spring_torque_nm"]) if r["ring_spring_torque_nm"] else 0,
         f"{r['normal_force_n']:.0f}", f"{1e6 * r['rotation_rad']:.2f}") for name in ("follow", "auto") for r in [found[name]]]


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


def drive_kinematics():
    """Changes of a whole drive by large displacements, and what they cost."""
    names = ("k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad", "hysteresis_rad")
    return ("drive", "K1", "K2", "K3", "hysteresis", "time"), [
        (r["case"], *(percent(large[n] / small[n] - 1) for n in names), f"{large['cpu_s'] / small['cpu_s']:.0f} times")
        for r in read_record("drive_kinematics") for small, large in [(r["linear"], r["nonlinear"])]]


# --- meshes

def meshes():
    """HUB refined in all directions of the surface."""
    return ("divisions x rows", "dof", "normal force / N", "area / mm²", "mid-band / MPa", "rotation / µrad", "peak / MPa"), [
        (f"{r['divisions']} x {r['band_facets']}", rounded(r["dof"]), rounded(x["normal_force_n"]), f"{1e6 * x['contact_area_m2']:.0f}",
         f"{1e-6 * x['pressure_mid_mean_pa']:.2f}", f"{1e6 * x['rotation_rad']:.1f}", f"{1e-6 * x['pressure_max_pa']:.0f}")
        for r in read_record("mesh_study") for x in [r["results"]]]


def settles():
    """How near each other the last three meshes of HUB are."""
    rows = [r["results"] for r in read_record("mesh_study")][-3:]
    near = [f"{100 * (max(values) / min(values) - 1):.0f}" for k in ("normal_force_n", "rotation_rad", "pressure_mid_mean_pa") for values in [[r[k] for r in rows]]]
    return ("result", "on finer meshes"), [
        ("normal force, rotation, mid-band pressure", f"settle: the last three meshes lie within {near[0]}, {near[1]} and {near[2]} %"),
        ("peak pressure", "grows as one over the cell's length; it has no limit"), ("contact area", "shrinks with the width of the edge row")]


def layers():
    """What more layers change: HUB on 12 rows, CD-14-100 on its own mesh."""
    hub = {r["layers"]: r["results"] for r in read_record("layer_study") if (r["element"], r["band_facets"]) == ("hex8i", 12)}
    cd14 = {1: read_record("default_study")[0]["results"]} | {
        n: next(r["results"] for r in read_record("default_study") if f"mesh.through_wall={n}" in r["keys"]) for n in (2, 4)}
    keys = ("normal_force_n", "pressure_mid_mean_pa", "rotation_rad")
    return ("scene", "layers", "normal force", "mid-band pressure", "rotation"), [
        (name, f"1 to {n}", *(percent(of[n][k] / of[1][k] - 1) for k in keys)) for name, of in (("HUB, 12 rows", hub), ("CD-14-100", cd14)) for n in (2, 4)]


def swap():
    """Change from the ring to the cup as slave, on meshes that do not match."""
    keys = ("k_ts_tangent_nm_per_rad", "k_ts_nm_per_rad", "normal_force_n", "rotation_rad", "pressure_mid_mean_pa")
    return ("cup's mesh", "ring's cells to cup's", "tangent", "Eq. 45", "normal force", "rotation", "mid-band pressure"), [
        (f"{r['divisions']} x {r['band_facets']}", f"{r['ratio']:.2f}", *(percent(r["results"]["cup"][k] / r["results"]["ring"][k] - 1) for k in keys))
        for r in read_record("swap_study") if r["divisions"] != 96]


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


def promised_rows(record="promised_scenes"):
    """Random scenes of a record."""
    return list(read_rows(record, "scene").values())


def tolerances(rows):
    """Tolerances that were asked, the widest first."""
    return sorted({run["tolerance"] for row in rows for run in row["runs"]}, reverse=True)


def shown(reduce, values, form=lambda v: percent(v, sign="")):
    """A median or a maximum in words, "-" of nothing."""
    return form(reduce(values)) if values else "-"


def ratio(value):
    """An estimate over an error."""
    return f"{value:.1f}"


def promised_drives():
    """The same of whole drives."""
    return promises("promised_drives")


def promises(record="promised_scenes"):
    """Promised and kept by seed and tolerance."""
    every, out = promised_rows(record), []
    for seed in sorted({row["scene"].split("-")[0] for row in every}):
        rows = [row for row in every if row["scene"].startswith(f"{seed}-")]
        for tolerance in tolerances(rows):
            made = [run for row in rows for run in judged(row) if run["tolerance"] == tolerance]
            whole = [run for run in made if is_judged(run)]
            worst = [max(run["true_error"].values()) for run in whole]
            cautious = [max(run["estimate"].values()) / w for run, w in zip(whole, worst)]
            of_mesh = [max(run["true_error_of_mesh"].values()) for run in whole]
            out.append((seed, f"{100 * tolerance:g} %", sum(run["tolerance"] == tolerance for row in rows for run in row["runs"]), len(made),
                        len(whole), sum(w <= tolerance for w in worst), shown(median, worst), shown(max, worst), shown(median, cautious, ratio),
                        shown(median, of_mesh), f"{median(run['seconds'] for run in made):.0f}"))
    return ("seed", "tolerance", "scenes", "promised", "judged", "kept", "median", "largest", "estimate over it", "of the mesh", "CPU s"), out


def promised_groups():
    """Promises kept of those judged, and results within the tolerance of those judged, by what the scenes are."""
    rows, out = promised_rows(), []
    for words, key, value in (("small displacements", "solver.kinematics", "linear"), ("large displacements", "solver.kinematics", "nonlinear"),
                              ("bottom held, `hub`", "load.support", "hub"), ("bottom free, `bearing`", "load.support", "bearing"),
                              ("hard contact", "contact.law", "hard"), ("joint as contact law, `joint`", "contact.law", "joint"),
                              ("the same, shear stiffness that does not fall, `joint_elastic`", "contact.law", "joint_elastic"),
                              ("bonded, cup against the teeth", "load.support", "teeth")):
        mine = [row for row in rows if row["keys"].get(key, "teeth") == value]
        if not mine:
            continue
        made = [run for row in mine for run in judged(row)]
        whole = [run for run in made if is_judged(run)]
        results = [(run["tolerance"], e) for run in made for e in run["true_error"].values()]
        out.append((words, len(mine), len(made), len(whole), sum(max(run["true_error"].values()) <= run["tolerance"] for run in whole), len(results),
                    sum(e <= t for t, e in results)))
    return ("scenes with", "scenes", "promised", "judged", "kept", "results judged", "within the tolerance"), out


def promised_results():
    """Errors of what is promised, by result and tolerance."""
    rows, out = promised_rows(), []
    for tolerance in tolerances(rows):
        for name, words in NAMES.items():
            pairs = [(estimate, error) for n, estimate, error in judged_results(rows, tolerance) if n == name]
            if not pairs:
                continue
            errors = [e for _, e in pairs]
            out.append((f"{100 * tolerance:g} %", words, len(pairs), shown(median, errors), shown(max, errors),
                        shown(median, [a / max(e, 1e-5) for a, e in pairs], ratio), sum(e > a for a, e in pairs), sum(e > tolerance for e in errors)))
    return ("tolerance", "result", "judged", "median", "largest", "estimate over it", "above estimate", "above tolerance"), out


# --- the joint law
