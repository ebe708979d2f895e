# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of docs/explain and of the README, made of records of bench/results and, where a table shows constants of the engine, of its source."""
import re

from evidence_words import percent

from common import ROOT, put, read_record, table


def digits(value, count=2):
    """A number of so many digits, without a power of ten."""
    return f"{float(f'{value:.{count - 1}e}'):g}"


def power(value):
    """Two digits and a power of ten."""
    return f"{value:.1e}".replace("e+0", "e")


def ran(name):
    """What a function of bench/explained.py found."""
    return read_record("explained")[name]


# --- the drive

def wave_generators():
    """Even spring and rigid cam against the balls."""
    found = ran("wave_generators")
    drives, (columns, rows) = found["drives"], found["mesh"]
    names = tuple(drives["balls"])
    return (f"size 14, {columns} x {rows} facets, against its balls", "K1", "K2", "K3", "hysteresis"), [
        (shown, *(percent(drives[name][k] / drives["balls"][k] - 1, 0) for k in names)) for shown, name in (("one even spring", "even spring"), ("rigid", "rigid"))]


def shares():
    """The contact's share of the angle of size 14, by K_TS."""
    found = ran("default_scene")
    high, low = (next(s for s in found["drive"] if abs(s["torque_nm"] - t) < 1e-6) for t in (14, 1.4))
    rows = ((found["tangent_nm_per_rad"], "tangent, ring on a rigid cam (`data/cd14.nml`)"),
            (high["tangent_nm_per_rad"], "tangent in the whole drive at 14 N m (`data/drive14.nml`)"),
            (low["tangent_nm_per_rad"], "the same at 1.4 N m"), (found["eq45_nm_per_rad"], "Eq. 45 in the scene of the first row"))
    return ("K_TS of the contact", "where it comes from", "its turn at 5 N m", "share of the drive's angle"), [
        (f"{power(k)} N m/rad", source, f"{digits(5e6 / k)} µrad", f"{digits(100 * found['k2_catalogue_nm_per_rad'] / k)} %") for k, source in rows]


def headline():
    """The default scene in three rows."""
    found = ran("default_scene")
    tangent, k2 = found["tangent_nm_per_rad"], found["k2_catalogue_nm_per_rad"]
    return ("number", "what it says"), [
        (f"tangent, {power(tangent)} N m/rad", "slope of torque over the angle that the contact adds: what a test would measure"),
        ("catalogue, K2 of this size", f"{power(k2)} N m/rad: slope of the whole drive"),
        ("quotient", f"the contact is {round(tangent / k2, -1):.0f} times as stiff as the drive; in series it takes {digits(100 * k2 / tangent)} % of its twist")]


def torque_path():
    """Who carries the torque, by how the ring is held."""
    found = ran("ring_tangent")
    carried = {name: (s["wave_generator_torque_nm"], s["hub_torque_nm"]) for name, s in found.items()}
    words = {"follow": ("`'follow'`", "is held where the cam puts it"), "free": ("`'free'`", "slides on the cam, as on balls"),
             "auto": ("`'auto'`, the default", "slides, but is held where nothing else holds it")}
    return ("`ring_tangent`", "the ring's inner face, round the axis", "who carries 5 N m (`hub`)"), [
        (*words[name], f"hub {hub:.2f} N m" if cam < 0.005 else f"wave generator {cam:.2f}, hub {hub:.2f} N m") for name, (cam, hub) in carried.items()]


# --- the planner

def planned():
    """Meshes, times and limits by tolerance."""
    return ("tolerance in CD-14-100, `solver.kinematics=linear`", "facets", "layers through the wall", "time", "limit of the tangent / (MN m/rad)"), [
        (f"{r['tolerance']:g}", f"{r['mesh'][0]} x {r['mesh'][1]}", r["layers"], f"{digits(r['cpu_s'])} s", f"{r['k_ts_tangent_nm_per_rad'] / 1e6:.3f}")
        for r in ran("planned") if r["kinematics"] == "linear"]


def left_by_layers(name, count):
    """Errors that two and four layers leave: constants of the planner."""
    source = (ROOT / "fortran/plan/hd_mesh_series.f90").read_text()
    two = [float(x) for x in re.search(rf"\b{name}\(promises\) = \[(.*?)\]", source)[1].replace("_dp", "").split(",")][:count]
    share = float(re.search(r"\bshare = (.*?)_dp", source)[1])
    return [(2, *(f"{100 * x:.1f} %" for x in two)), (4, *(f"{digits(100 * share * x)} %" for x in two))]


def layers():
    """Of a scene."""
    return ("layers", "tangent K_TS", "rotation", "normal force", "mid-band pressure"), left_by_layers("left", 4)


def layers_of_a_drive():
    """Of a whole drive."""
    return ("layers, whole drive", "K1", "K2", "K3", "hysteresis"), left_by_layers("left_drive", 4)


# --- the joint

def theory():
    """k_N by theory over boundary elements: range over D, by contact and roll-off."""
    surfaces = [s for s in read_record("joint_law")["surfaces"] if "measured" not in s["surface"]]
    of = {}
    for s in surfaces:
        of.setdefault(s["surface"], []).append([r["k_n_theory"] / r["k_n_boundary_elements"] for r in s["rows"]])
    ratios = {kind: [[(a * b)**0.5 for a, b in zip(*maps)] for name, maps in of.items() if name.endswith(f", {kind}")] for kind in ("roll-off", "no roll-off")}

    def span(kind, i):
        values = [r[i] for r in ratios[kind]]
        return f"{min(values):.2f} to {max(values):.2f}"
    return ("true contact / %", "roll-off at 1/6 of the map", "no roll-off"), [
        (share, *(span(kind, i) for kind in ratios)) for i, share in enumerate(("0.5", "1.5", "4", "13", "36"), 1)]


def exponents():
    """Exponent of K_T over the pressure near slip."""
    words = {"default": "`hu2023` as it stands", "elastic": "elastic spots", "D 2.1": "D = 2.1, r_m = 0.2 mm"}
    return ("joint, 10 to 300 MPa", "a"), [(words[name], f"{low:.2f} to {high:.2f}") for name, (low, high) in ran("exponents").items()]


def pressure_used():
    """Error of K_TS on 8 rows."""
    found = ran("pressure_used")
    words = {"power means": "power means at the corners", "corners": "corners' own pressures", "facets": "facets' means"}
    return ("pressure used", "error of K_TS on 8 rows"), [(text, percent(abs(found[name] / found["reference"] - 1), 1, "")) for name, text in words.items()]


def frictions():
    """Readings of CD-14-100 at 5 N m by friction."""
    found, unit = read_record("which_k_ts")["readings"], 1e6
    return ("friction", "Eq. 45 / (MN m/rad)", "tangent / (MN m/rad)", "secant / (MN m/rad)", "Eq. 45 on slipping points"), [
        (f"{r['friction']:.2f}", *(f"{r[k] / unit:.2f}" for k in ("k_ts_nm_per_rad", "k_ts_tangent_nm_per_rad", "k_ts_secant_nm_per_rad")),
         f"{100 * r['slip_share_k_ts']:.0f} %") for r in (found[f"CD-14-100, {mu}, 5 N m"] for mu in ("µ = 0.05", "as it is", "µ = 0.3"))]


# --- surface and element

def periodic_excess():
    """Excess of the periodic surface's structure function at long lags."""
    found = ran("periodic_excess")
    return ("D", "lag of 1/128 of the period", "1/32", "1/8", "1/2"), [(d, *(f"{abs(100 * x):.0f} %" for x in row.values())) for d, row in found.items()]


def new_element():
    """Errors in a thick tube."""
    return ("element", "0.3", "0.4999"), [(f"`{name}`", *(f"{100 * x:.2f} %" for x in row.values())) for name, row in ran("new_element").items()]


TABLES = {  # marker: page from docs on, builder
    "wave-generators": ("explain/drive_planned", wave_generators),
    "exponents": ("explain/joint_in_detail", exponents),
    "pressure-used": ("explain/joint_in_detail", pressure_used),
    "theory": ("explain/joint_law", theory),
    "shares": ("explain/k_ts_and_drive", shares),
    "new-element": ("explain/new_element_tests", new_element),
    "periodic-excess": ("explain/periodic_surface", periodic_excess),
    "planned": ("explain/planner", planned),
    "layers": ("explain/planner_refinement", layers),
    "layers-of-a-drive": ("explain/planner_refinement", layers_of_a_drive),
    "frictions": ("explain/premises", frictions),
    "torque-path": ("explain/torque_path", torque_path),
    "headline": ("../README", headline),
}


def draw():
    """Put every table on its page."""
    for marker, (page, build) in TABLES.items():
        put(marker, table(*build()), page)
