# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of docs/evidence on elements and closed solutions, made of their records."""

from evidence_words import percent, short

from common import read_record

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
