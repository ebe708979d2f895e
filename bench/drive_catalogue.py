# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole drives of data/ beside the catalogue, and what makes their slopes: fit, play of the teeth, history, friction. Writes
bench/results/drive_catalogue.json and docs/figures/slopes.png.

Usage: python bench/drive_catalogue.py [sizes] [bands] [slopes] [causes] [kin] [history] [draw]; without words all
"""
import itertools
import re
import sys
import tempfile

import numpy as np

import hdengine
from common import DATA, read_record, save_figure, short, solve, write_part
from hdengine import load
from hdengine.catalogue import UNITS, unit
from hdengine.figures.style import new_axes, styled

DRIVES = ("11", "14", "17", "20", "25", "32", "40", "14_hat", "20_30", "20_50", "20_160")
CATALOGUE = {name: u.slopes for name in DRIVES if (u := unit(int(name[:2]), int(name[3:]) if name[3:].isdigit() else 100))}
ARCMIN = np.degrees(1) * 60
COARSE = {"mesh.divisions": 48, "mesh.band_facets": 8}
FINE = {"mesh.divisions": 160, "mesh.band_facets": 20}
BONDED = {"contact.mode": "bonded"}
FITS = (0, 4.5, 9, 18)   # clearance [um]
READ = {"hysteresis_arcmin": ("hysteresis_rad", ARCMIN), "lost_motion_arcmin": ("lost_motion_rad", ARCMIN),
        "k_ts_bonded": ("k_ts_bonded_nm_per_rad", 1e-3), "k_ts_contact": ("k_ts_contact_nm_per_rad", 1e-3)}


def run(name, keys):
    """What a drive's loop reads [kN m/rad, minutes, MPa], and its steps."""
    with tempfile.TemporaryDirectory() as folder:
        summary, command = solve(f"drive{name}.nml", *(f"{k}={v}" for k, v in keys.items()), out=f"{folder}/r")
        if command.code != 0:
            return {"failed": command.text.strip().splitlines()[0]}, None
        r = summary["results"]
        row = {"k": [short(r[f"k{i}_nm_per_rad"] / 1e3, 6) for i in (1, 2, 3)]} | {k: short(r[name] and r[name] * scale, 6) for k, (name, scale) in READ.items()}
        if not keys:   # as it stands
            row |= {"shares": {k: short(v, 6) for k, v in r["twist_shares"].items()}, "cpu_s": short(command.cpu_s, 6), "memory_mb": short(summary["peak_memory_mb"], 6),
                    "cup_mpa": short(r["flexspline_von_mises_max_pa"] / 1e6, 6), "cup_safety": short(r["flexspline_yield_safety"], 6)}
        result = load(f"{folder}/r")
        return row, (result.loop, result.steps)


def fit(clearance):
    """Keys of a clearance [um]; below 0: interference."""
    return {"wave_generator.clearance": max(clearance, 0) * 1e-6, "wave_generator.interference": max(-clearance, 0) * 1e-6}


def play(name, change):
    """The clearances of the teeth, all changed by so much [m] round the axis at size 14."""
    text = (DATA / f"drive{name}.nml").read_text()
    change *= int(name[:2]) / 14 * np.cos(np.radians(float(re.search(r"pressure_angle_deg = (\S+)", text)[1])))
    return {f"load.{key}": ", ".join(f"{max(float(x) + change, 0):.4g}" for x in re.search(rf" {key} = (.*)", text)[1].split(","))
            for key in ("tooth_gaps", "tooth_gaps_back")}


CLOSING = (("14", "mesh 160 x 20", FINE), ("20", "mesh 160 x 20", FINE), ("20", "rigid spline", {"load.spline": "rigid"}),
           ("20", "friction of the flanks 0.1", {"load.tooth_friction": 0.1}),
           *((name, f"spline {w} mm wide", {"load.spline_width": 1e-3 * w}) for name, w in (("14", 5), ("14", 9), ("20", 6), ("20", 12.9))),
           ("14_hat", "flange 0.36 mm thick", {"cup.sections_thickness": "0.427e-3, 0.427e-3, 0.36e-3, 0.36e-3, 0.36e-3, 0.36e-3, 0.36e-3"}),
           ("20_30", "spline of 66 mm", {"load.spline_diameter": 0.066}), ("17", "clearance 4.5 µm", fit(4.5)), ("20", "clearance 4.5 µm", fit(4.5)),
           ("20_50", "clearance 18 µm", fit(18)), ("20_160", "clearance 0 µm", fit(0)),
           *((name, "ring held fast", {"bearing.axial_hold": "fast"}) for name in ("14", "25")))


def sizes():
    """Every shipped drive as it stands, and K1 to K3 by large displacements over those by small ones."""
    rows = []
    for name in DRIVES:
        row, large = run(name, {})[0], run(name, {"solver.kinematics": "nonlinear"})[0]
        rows.append({"drive": name, "catalogue": [k / 1e3 for k in CATALOGUE[name]] if name in CATALOGUE else None} | row
                    | {"large": [short(b / a, 6) for a, b in zip(row["k"], large["k"])]})
    return rows


def bands():
    """95 % band of K1 to K3 [kN m/rad] of every drive that the catalogue has, and the inputs that make most of it; how wide it is where the fit is
    known to 1 um and the housing too."""
    rows = []
    for name in CATALOGUE:
        with tempfile.TemporaryDirectory() as folder:
            r = solve(f"drive{name}.nml", "run.band=auto", out=f"{folder}/r")[0]["results"]
            known = solve(f"drive{name}.nml", "run.band=auto", "run.tolerances=wave_generator.clearance=1 um, load.spline=0", out=f"{folder}/k")[0]["results"]
            shares = sorted(r["band_shares"].items(), key=lambda item: -item[1])[:3]
            rows.append({"drive": name, "catalogue": [k / 1e3 for k in CATALOGUE[name]], "shares": {k: short(v, 6) for k, v in shares},
                         "known": [short(known[f"k{i}_nm_per_rad_high"] / known[f"k{i}_nm_per_rad_low"], 6) for i in (1, 2, 3)], **{end: [short(r[f"k{i}_nm_per_rad_{end}"] / 1e3, 6) for i in (1, 2, 3)] for end in ("low", "high")}})
    return rows


def slopes():
    """Slope of the last rise of size 20 to 50 N m over each 2.5 N m, for each fit and bonded; K_TS there."""
    rows = []
    for label, keys in (("bonded", BONDED), *((f"{c:g}", fit(c)) for c in FITS)):
        row, (loop, steps) = run("20", {**keys, "load.torque": 50, "load.torque_steps": 20, "load.tangent_steps": "all"})
        torque, angle = (np.array(loop[k])[[-22, *range(-20, 0)]] for k in ("torque_nm", "angle_rad"))  # no stop at 4 % of the rated torque
        k_ts = np.array(steps["k_ts_bonded_nm_per_rad"][-20:])
        rows.append({"fit": label, "torque_nm": [short(t, 6) for t in torque], "slope": [short(s, 6) for s in np.diff(torque) / np.diff(angle) / 1e3],
                     "k_ts_bonded": [short(k / 1e3, 6) if np.isfinite(k) else None for k in k_ts]})
    return rows


def causes():
    """Sizes 14 and 20 with one input changed, on a coarser mesh; then, on the shipped one, what a finer one moves and what would close a gap."""
    known = [("as built", {}), ("interference 10 µm", fit(-10)), ("clearance 0 µm", fit(0)), ("clearance 18 µm", fit(18))]
    more = [("play of the closest pair 2 µm", {"play": 2})]
    rows = []
    for name, mine in (("14", known), ("20", known + more)):
        for label, keys in mine:
            teeth = play(name, 1e-6 * keys["play"]) if "play" in keys else {}
            rows.append({"drive": name, "case": label} | run(name, {**COARSE, **{k: v for k, v in keys.items() if k != "play"}, **teeth})[0])
    rows += [{"drive": name, "case": label} | run(name, keys)[0] for name, label, keys in CLOSING]
    return rows


def kin():
    """K1 to K3 [kN m/rad] of every size of the catalogue at ratios 100 and 50, as `hdengine new` writes them."""
    rows = []
    for size, ratio in itertools.product(UNITS, (100, 50)):
        with tempfile.TemporaryDirectory() as folder:
            r = hdengine.run("", folder + "/r", **hdengine.as_built(size, ratio, run={"band": False}))
        rows.append({"size": size, "ratio": ratio, "k": [short(k / 1e3, 6) for k in (r.k1, r.k2, r.k3)], "catalogue": list(unit(size, ratio).slopes / 1e3)})
    return rows


def history():
    """K1 to K3 of size 20 after each history, and of two more after a turn."""
    cases = *(("20", h) for h in ("loop", "assembled", "turned")), ("17", "turned"), ("20_50", "turned")
    return [{"drive": name, "history": h} | run(name, {"loop.history": h})[0] for name, h in cases]


@styled
def draw(rows):
    """Slope over torque of size 20: bonded, as built, over the fit, and the catalogue's three chords."""
    found = {r["fit"]: np.array(r["slope"]) for r in rows}
    edges = np.array(rows[0]["torque_nm"])
    middle, k = (edges[1:] + edges[:-1]) / 2, CATALOGUE["20"] / 1e3
    figure, axes = new_axes(figsize=(8, 4.8))
    fits = np.array([found[f"{c:g}"] for c in FITS])
    axes.fill_between(middle, fits.min(axis=0), fits.max(axis=0), color="C0", alpha=0.2, lw=0, label="clearance of the fit 0 to 18 µm")
    axes.annotate("the gap of the fit closes", (10, 19), (2, 4), arrowprops={"arrowstyle": "->"}, fontsize=12)
    axes.plot(middle, found["bonded"], "C1", lw=2.5, label="ring glued to the cup")
    axes.plot(middle, found["9"], "C0", lw=2.5, label="contact with friction, clearance 9 µm")
    axes.step((0, UNITS[20].t1_nm, UNITS[20].t2_nm, edges[-1]), (k[0], *k), "k--", lw=2, label="catalogue, K1 K2 K3")
    axes.set_title("whole drive, size 20, ratio 100", fontsize=13)
    axes.set_xlabel("torque / N m")
    axes.set_ylabel("slope / (kN m/rad)")
    axes.set_xlim(0, edges[-1])
    axes.set_ylim(0, 60)
    axes.legend(loc="lower right", fontsize=12.5)
    save_figure(figure, "slopes")


def main():
    """Solve, write, draw."""
    parts = {"sizes": sizes, "bands": bands, "slopes": slopes, "causes": causes, "kin": kin, "history": history}
    for name in sys.argv[1:] or parts:
        if name in parts:
            write_part("drive_catalogue", name, parts[name](), threads=1)
    draw(read_record("drive_catalogue")["slopes"])


if __name__ == "__main__":
    main()
