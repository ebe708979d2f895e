# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of docs/evidence on the law of the joint, made of their records."""

import json
import warnings

from evidence_words import rounded

from common import DATA, read_record
from hdengine import Joint, JointWarning


def shear():
    """Shear of rough patches: the law against boundary elements, by surface; ranges over three shares of contact."""
    rows, out = read_record("joint_shear")["patches"], []
    for surface in dict.fromkeys(r["surface"] for r in rows):
        some = [r for r in rows if r["surface"] == surface]

        def span(name, some=some, digits=1, factor=100):
            values = [factor * r[name] for r in some]
            return f"{min(values):.{digits}f} to {max(values):.{digits}f}"

        out.append((surface, *(span(f"{law}_{part}_error") for law in ("law", "theory") for part in ("curve", "loop")),
                    span("k_t_over_k_n", digits=3, factor=1)))
    return ("surface", "loading, own k_N", "loop, own k_N", "loading, spectrum", "loop, spectrum", "k_T/k_N"), out


def spot():
    """A Hertz spot against Cattaneo and Mindlin."""
    return (("points a side", "loading / % of µP", "loop / % of µP", "slipping share of the area / %"),
            [(r["points"], *(f"{100 * r[k]:.2f}" for k in ("curve_error", "loop_error", "slip_area_error"))) for r in read_record("joint_shear")["spot"]])


def peers():
    """Solvers with friction on one Hertz spot."""
    return (("solver", "mean pressure over asked", "mean shear over asked", "slipping share", "knows the slip so far"),
            [(f"hdengine `{r['solver']}`" if r["remembers_slip"] else f"tamaas `{r['solver']}`", f"{r['mean_pressure_over_asked']:.3f}",
              f"{r['mean_shear_over_asked']:.3f}", f"{r['slip_share_of_contact']:.2f}", "yes" if r["remembers_slip"] else "no")
             for r in read_record("joint_shear")["tamaas"]])


def ten():
    """Theory over boundary elements on ten generated surfaces, mean of two maps, by the share that touches."""
    surfaces, out = read_record("joint_law")["surfaces"], []
    for name in dict.fromkeys(s["surface"] for s in surfaces if "measured" not in s["surface"]):
        maps = [s["rows"] for s in surfaces if s["surface"] == name]
        ratios = [(a["k_n_theory"] * b["k_n_theory"] / a["k_n_boundary_elements"] / b["k_n_boundary_elements"])**0.5 for a, b in zip(*maps)]
        out.append((name, *(f"{r:.2f}" for r in ratios)))
    return ("surface", "0.2 %", "0.5 %", "1.5 %", "4 %", "13 %", "36 %"), out


def measured_maps():
    """Theory over boundary elements on measured maps: up to the last share of contact that is more than a tenth off, and beyond."""
    unlike = {"al3d-1.al3d": ("a lay, isotropy", "isotropy", 2), "sflz_test_1.opd": ("a lay, isotropy", "isotropy", 2), "nanovea_test2.txt": ("skewness", "skewness", 1)}
    surfaces = {s["surface"].split(" (")[0]: s for s in read_record("joint_law")["surfaces"] if "measured" in s["surface"]}

    def span(values, digits):
        ends = [f"{v:.{digits}f}" for v in (min(values), max(values))]
        return " to ".join(dict.fromkeys(ends))
    out = []
    for name, (word, fact, digits) in unlike.items():
        ratios = [(r["contact"], r["k_n_theory"] / r["k_n_boundary_elements"]) for r in surfaces[name]["rows"]]
        n = 1 + max(i for i, (_, x) in enumerate(ratios) if abs(x - 1) > 0.1)
        (some, light), (more, full) = zip(*ratios[:n]), zip(*ratios[n:])
        out.append((name.split(".")[0], f"{word} {surfaces[name]['facts'][fact]:.{digits}f}", f"{span(light, 1)} up to {100 * some[-1]:.0f} %",
                    f"{span(full, 2)} {'from' if len(more) > 1 else 'at'} {100 * more[0]:.0f} %{' on' if len(more) > 1 else ''}"))
    return ("map", "what is unlike the theory", "light contact", "more contact"), out


def calibration():
    """The statistical model fitted to boundary elements, and that of cd14.nml, at 50 MPa."""
    record = json.loads((DATA / "joint_calibration.json").read_text())
    fitted, rows = record["fitted"], [r for r in record["rows"] if r["pressure_pa"] == 50e6]

    def span(key):
        low, high = (f"{f([r[key] for r in rows]):.1e}".replace("e+", "e") for f in (min, max))
        return f"{low.removesuffix(high[3:])} to {high}"

    def row(name, of, joint=None, misfit="-"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", JointWarning)
            k = ["-", "-"] if joint is None else [f"{x / joint.reference_area:.1e}".replace("e+", "e") for x in joint.stiffness(50e6)]
        return name, f"{1e6 * of[0]:.3g}", f"{of[1]:.3g}", *k, misfit

    def pair(of):
        return of["asperity_radius_m"], float(f"{of['s_min_m2']:.1e}")
    best, parts, default = pair(fitted), fitted["by_cut_off"], Joint()
    return ("joint", "r_m / µm", "s_min / m²", "k_N at 50 MPa / (Pa/m)", "k_T / (Pa/m)", "rms difference of ln k"), [
        ("boundary elements", "-", "-", span("k_n_pa_per_m"), span("k_t_pa_per_m"), "scatter of the seeds"),
        row("statistical, no yield, fitted to both wavelengths", best, Joint(asperity_radius=best[0], s_min=fitted["s_min_m2"], hardness=1e15), f"{fitted['rms_ln_misfit']:.2f}"),
        *(row(f"fitted to {length.removesuffix(' um')} µm alone", pair(of), misfit=f"{of['rms_ln_misfit']:.2f}") for length, of in parts.items()),
        row("`cd14.nml`, with yield, not fitted", (default.asperity_radius, default.s_min), default)]


def models():
    """K_TS of CD-14-100 by each model, and what changes it."""
    rings = {"cd14": "of the paper", "cd14_ground": "ground"}
    return (("rings", "model", "Eq. 45, 5 N m", "tangent, 1 N m", "tangent, 5 N m", "by torque / %", "by w / %", "eccentric / %"),
            [(rings[c["scene"]], f"`{c['model']}`", f"{c['eq45_5_nm'] / 1e6:.3f}", f"{c['tangent_1_nm'] / 1e6:.3f}", f"{c['tangent_5_nm'] / 1e6:.3f}",
              *(f"{c[k]:+.1f}" for k in ("torque_1_to_5_percent", "w_0195_to_0215_percent", "eccentricity_10um_percent")))
             for c in read_record("joint_models")["conclusions"]])


def bands():
    """95 % bands of both readings by group of causes."""
    found = read_record("joint_band")["summary"]
    names = {"maps": "two maps of 1 mm", "joint": "the same, scatter of the law, E*, hardness", "joint of one patch": "the same on a contact as large as one map",
             "friction": "friction 0.05 to 0.15",
             "geometry": "geometry and wave generator", "elastic constants": "Young's moduli", "all": "all"}
    return (("cause", "tangent / %", "Eq. 45 / %"),
            [(names[g], *("{:+.1f} to {:+.1f}".format(*found[r]["bands_percent"][g]) for r in ("tangent", "eq45"))) for g in names])


def shares():
    """Shares of the variance of the tangent and of Eq. 45, the largest first."""
    found = {r: read_record("joint_band")["summary"][r]["shares_of_variance"] for r in ("tangent", "eq45")}
    joint = ("sampling", "law", "E* and hardness", "noise", "longer waves")
    total = {"joint, all causes": [sum(f.get(k, 0) for k in joint) for f in found.values()]}
    total |= {f"`{k}`": [f[k] for f in found.values()] for k in found["tangent"] if k not in joint}
    shown = sorted(total.items(), key=lambda x: -max(x[1]))[:9]
    return ("input", "tangent / %", "Eq. 45 / %"), [(k, *(rounded(100 * x, 1) for x in v)) for k, v in sorted(shown, key=lambda x: -x[1][0])]


def measured():
    """Measured joints over the law at the ends of their pressures."""
    out = []
    for r in read_record("joint_measured")["rows"]:
        mean, spread = r["geometric_mean_over_law"], r["spread"]
        out.append((r["joint"], r["source"], len(r["measured"]), f"{r['pressure_pa'][0] / 1e6:.2g} to {r['pressure_pa'][-1] / 1e6:.2g}",
                    f"{mean[0]:.2f} to {mean[-1]:.2f}", f"{min(spread):.1f} to {max(spread):.1f}"))
    return ("joint", "book", "joints", "P / MPa", "mean over law", "largest over smallest"), out
