#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Band of K_TS of CD-14-100 for a user with two maps of 1 mm: the tangent and Eq. 45; what widens it. The ring slides.

Two generated maps of the ground rings (data/cd14_ground.nml), 512 x 512 points, 2 um apart. The band stands for the area that sticks, which
carries both readings; beside it the band of a patch as large as the map, and that of a law from D and G alone. Each cause of the joint's band
(`Prediction.parts`) scales k_N and k_T to its ends; friction, geometry and elastic constants go to the ends of `uncertainty.DRIVE`. Each end
is a run. The band takes each cause as a factor, a straight line from its low end over the scene to its high end; 24 runs with all causes of
the joint drawn at once test the product. Writes bench/results/joint_band.json and docs/figures/joint_band.png.
Usage: bench/joint_band.py [--redraw]
"""
import argparse
import json
import tempfile
from pathlib import Path

import numpy as np

import hdengine
from common import DATA, new_axes, read_record, save_figure, styled, write_record
from hdengine import Run, surface
from hdengine.prediction.choice import scatter_of
from hdengine.prediction.law import predict
from hdengine.prediction.spectrum import Spectrum
from hdengine.uncertainty import DRIVE

PRESSURE = np.geomspace(1e5, 400e6, 16)
FIXED = {"wave_generator.ring_tangent": "auto", "joint.model": "table", "output.vtu": "none", "load.torque": 5.0, "load.torque_steps": 5}
READINGS = {"tangent": "k_ts_tangent_nm_per_rad", "eq45": "k_ts_nm_per_rad"}
GROUPS = {"maps": ("sampling", "noise", "longer waves"), "joint": ("sampling", "noise", "longer waves", "law", "E* and hardness"),
          "friction": ("contact.friction",), "geometry": ("geometry.", "wave_generator."), "elastic constants": ("material.",)}


def law_of(side, loaded=None):
    """Law of two maps of a side [m] with the spectrum of the ground rings, for a contact of a loaded area [m^2]."""
    s = hdengine.read_scene(DATA / "cd14_ground.nml")
    d, g = s["joint.fractal_dimension"], s["joint.roughness"] / 2 ** (0.5 / (s["joint.fractal_dimension"] - 2))   # of one ring
    n = round(side / 2e-6)
    whole = [surface.periodic(2 * n, 2 * side, d, g, 6e-6, seed) for seed in (1, 2)]
    return predict(*((z[:n, :n], (2e-6, 2e-6)) for z in whole), pressure=PRESSURE, model="spectrum", longest=s["joint.sample_length"], loaded=loaded)


def of_d_and_g(contact, area):
    """Half width of ln k_N (95 %) of a law from D and G alone on a contact [m^2] of which shares touch."""
    s = hdengine.read_scene(DATA / "cd14_ground.nml")
    a = 2 * (3 - s["joint.fractal_dimension"])
    f = np.geomspace(1 / s["joint.sample_length"], 1 / s["joint.shortest_wavelength"], 200)
    waves = Spectrum(np.pi * (f[1:] + f[:-1]), f[:-1] ** -a - f[1:] ** -a, np.pi * np.diff(f**2) * contact).waves
    return 1.96 * scatter_of(area, waves)


def run(keys, table, factor, folder):
    """Both readings with keys changed and the joint's stiffness times a factor over the pressure."""
    path, out = folder / "k.csv", folder / "out"
    columns = [table["pressure_pa"], table["k_n_pa_per_m"] * factor, table["k_t_pa_per_m"] * factor]
    np.savetxt(path, np.column_stack(columns), delimiter=",", header="pressure_pa,k_n_pa_per_m,k_t_pa_per_m", comments="")
    with Run(DATA / "cd14_ground.nml", out, True, **FIXED, **{"joint.table_file": str(path)}, **keys) as steps:
        for _ in steps:
            pass
    results = json.loads((out / "summary.json").read_text())["results"]
    return {name: results[column] for name, column in READINGS.items()} | {
        "stuck_area_m2": results["contact_area_m2"] * (1 - results["slip_share_area"])}


def collect(draws):
    found = law_of(1.024e-3)
    base = hdengine.read_scene(DATA / "cd14_ground.nml")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        middle, ends = run({}, found.table, 1.0, folder), {}
        patch, found = found, law_of(1.024e-3, middle["stuck_area_m2"])
        print(found, middle, flush=True)
        one_patch = {name: [run({}, patch.table, f, folder) for f in (np.exp(-low), np.exp(high))]
                     for name, (low, high) in patch.parts.items() if name == "law"}
        for name, (low, high) in found.parts.items():
            ends[name] = [run({}, found.table, f, folder) for f in (np.exp(-low), np.exp(high))]
            print(name, ends[name], flush=True)
        for key, (low, high, _) in DRIVE.items():
            ends[key] = []
            for value in (low, high):
                try:
                    ends[key].append(run({key: value}, found.table, 1.0, folder))
                except hdengine.HdengineError as why:
                    print(key, value, why, flush=True)
                    ends[key].append(None)
            print(key, ends[key], flush=True)
        rng, drawn = np.random.default_rng(1), []
        for _ in range(draws):
            x = rng.standard_normal(len(found.parts)) / 1.96
            ln = sum(np.where(v > 0, v * high, v * low) for v, (low, high) in zip(x, found.parts.values()))
            drawn.append({"x": x.tolist(), **run({}, found.table, np.exp(ln), folder)})
    places = {key: (DRIVE[key][0], base[key], DRIVE[key][1]) for key in DRIVE}
    of_patch, touching = patch.parts["law"][0][8], found.table["contact_area_fraction"][8:9]
    return {"middle": middle, "one_patch": one_patch, "law_half_width_of_one_patch": float(of_patch),
            "law_half_width_from_d_and_g": float(of_d_and_g(middle["stuck_area_m2"], touching)[0]), "ends": ends, "places": places, "joint_causes": list(found.parts), "drawn": drawn,
            "half_widths_ln_k_n": {n: [float(low[8]), float(high[8])] for n, (low, high) in found.parts.items()},
            "at_pressure_pa": float(PRESSURE[8])}


def factors(record, reading, count=20_000, seed=1):
    """Factors of each cause on K_TS, drawn: normal for the joint's causes, even over their range for the others."""
    rng, middle, found = np.random.default_rng(seed), record["middle"][reading], {}
    for name, two in record["ends"].items():
        low, high = (None if e is None else e[reading] / middle for e in two)
        if name in record["joint_causes"]:
            x = rng.standard_normal(count) / 1.96
            found[name] = np.where(x < 0, 1 + (1 - low) * x, 1 + (high - 1) * x)
        else:
            at = record["places"][name]
            line = [(a, f) for a, f in zip(at, (low, 1.0, high)) if f is not None]
            line = dict(line)   # a scene at the end of its range
            found[name] = np.interp(rng.uniform(at[0], at[2], count), sorted(line), [line[a] for a in sorted(line)])
    return found


def summary(record):
    """Bands by group, and shares of the variance of ln K_TS (first order; the causes are factors, so nothing is shared)."""
    out = {}
    for reading in READINGS:
        f = {n: np.maximum(v, 1e-6) for n, v in factors(record, reading).items()}
        groups = {**GROUPS, "all": ("",)}
        patch = factors({**record, "ends": {**record["ends"], **record["one_patch"]}}, reading)
        bands = {}
        for name, starts in groups.items():
            use = [v for n, v in f.items() if n.startswith(starts)]
            low, high = np.quantile(np.prod(use, axis=0) if use else [1.0], [0.025, 0.975])
            bands[name] = [float(f"{100 * (low - 1):.3g}"), float(f"{100 * (high - 1):.3g}")]
            if name == "joint":
                low, high = np.quantile(np.prod([np.maximum(patch[n], 1e-6) for n in patch if n.startswith(starts)], axis=0), [0.025, 0.975])
                bands["joint of one patch"] = [float(f"{100 * (low - 1):.3g}"), float(f"{100 * (high - 1):.3g}")]
        logs = {n: float(np.var(np.log(v))) for n, v in f.items()}
        shares = {n: float(f"{v / sum(logs.values()):.3g}") for n, v in sorted(logs.items(), key=lambda x: -x[1])}
        direct = [d[reading] / record["middle"][reading] - 1 for d in record["drawn"]]
        joint = np.prod([f[n] for n in record["joint_causes"]], axis=0)
        out[reading] = {"bands_percent": bands, "shares_of_variance": shares,
                        "joint_std_percent": {"drawn": float(f"{100 * np.std(direct):.3g}"), "product": float(f"{100 * np.std(joint):.3g}")}}
    return out


@styled
def draw(record, found):
    """Tornado of both readings."""
    figure, axes = new_axes(2, 1, figsize=(9.5, 12.5))
    for axis, (reading, title) in zip(axes, (("tangent", "tangent K_TS"), ("eq45", "K_TS by Eq. 45"))):
        middle = record["middle"][reading]
        bars = {n: [100 * (e[reading] / middle - 1) if e else 0.0 for e in two] for n, two in record["ends"].items()}
        order = sorted(bars, key=lambda n: max(map(abs, bars[n])))[-14:]
        for i, name in enumerate(order):
            low, high = bars[name]
            axis.barh(i, low, color="C0", height=0.6)
            axis.barh(i, high, color="C1", height=0.6)
        axis.set_yticks(range(len(order)), [f"joint: {n}" if n in record["joint_causes"] else n for n in order], fontsize=11)
        low, high = found[reading]["bands_percent"]["all"]
        axis.set(xlabel="change / %", title=f"{title}, {middle / 1e6:.3g} MN m/rad; all: {low:+.0f} to {high:+.0f} %")
    axes[0].plot([], [], color="C0", lw=6, label="low end")
    axes[0].plot([], [], color="C1", lw=6, label="high end")
    axes[0].legend(loc="lower right")
    save_figure(figure, "joint_band")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--redraw", action="store_true", help="figure and bands from the record")
    parser.add_argument("--draws", type=int, default=24)
    options = parser.parse_args()
    record = read_record("joint_band") if options.redraw else collect(options.draws)
    record["summary"] = summary(record)
    print(json.dumps(record["summary"], indent=1))
    if not options.redraw:
        write_record("joint_band", record, seed=1)
    draw(record, record["summary"])


if __name__ == "__main__":
    main()
