# SPDX-License-Identifier: GPL-3.0-or-later
"""Every number of summary.json, surface.json, joint.json, record.json and study.json is met by a value from outside: one computed here, or
that of the test which HELD names. A number that is new in any of them fails until it is held."""
import ast
import json
import re
import subprocess
import sys
import time
from datetime import datetime
from math import erf
from types import SimpleNamespace

import numpy as np
import pytest
from test_blind_fit import CASES
from test_columns import joint, source_of, words  # noqa: F401

import hdengine
from conftest import ROOT, call
from hdengine import cli, roughness
from hdengine.prediction.bodies import Bodies
from hdengine.prediction.law import predict
from hdengine.table_file import read_csv
from oracle import Oracle

sys.path[:0] = str(ROOT / "bench"), str(ROOT / "data")
import make_torque_record as bench  # noqa: E402
from blind_generators import LN_G, field  # noqa: E402

DIVISIONS, FACETS = 24, 4
MESH = f"mesh.divisions={DIVISIONS}", f"mesh.band_facets={FACETS}"
EVEN = ",".join(["4e-6"] * 20)   # gaps of the teeth


class Between:
    """Equal to what lies in an interval."""

    def __init__(self, low, high):
        self.low, self.high = low, high

    def __eq__(self, value):
        return bool(np.all(np.asarray(value, float) >= self.low) and np.all(np.asarray(value, float) <= self.high))

    def __repr__(self):
        return f"{self.low} to {self.high}"


class Beside:
    """Equal to a value with the ends of a band about a truth, no wider than a share of it."""

    def __init__(self, truth, share):
        self.truth, self.share = truth, share

    def __eq__(self, found):
        value, low, high = found
        near = self.share * (abs(self.truth) or 5e-4)
        return low < value < high and abs(value - self.truth) < near and high - low < 2 * near

    def __repr__(self):
        return f"about {self.truth}"


class Around:
    """Equal to two ends about a value, as far apart as the variance says, that of the logarithm if so."""

    def __init__(self, value, variance, log=False):
        self.value, self.width, self.log = value, 2 * 1.96 * variance**0.5, log

    def __eq__(self, ends):
        low, high = np.log(ends) if self.log else ends
        return ends[0] < self.value < ends[1] and abs(high - low - self.width) < 0.03 * self.width

    def __repr__(self):
        return f"about {self.value}, {self.width} wide"


def flat(tree, path=""):
    """Numbers of a record by the names on the way to them; a list of numbers is one, null is one."""
    if isinstance(tree, dict):
        return {name: value for key, part in tree.items() for name, value in flat(part, f"{path}/{key}" if path else key).items()}
    if isinstance(tree, list) and any(isinstance(part, (dict, str)) for part in tree):
        return {name: value for i, part in enumerate(tree) for name, value in flat(part, f"{path}/{i}").items()}
    return {} if isinstance(tree, (str, bool)) or tree == [] else {path: tree}


def agree(found, wanted):
    """They are the same, or `wanted` says what is near enough."""
    if isinstance(wanted, (Between, Around, Beside)) or hasattr(wanted, "rel"):   # of pytest.approx
        return found == wanted
    if found is None or wanted is None:
        return wanted is None and found is None or found is None and wanted != wanted
    if isinstance(wanted, str):
        return found == wanted
    if isinstance(wanted, list) and isinstance(found, list):
        return len(found) == len(wanted) and all(map(agree, found, wanted))
    found, wanted = np.asarray(found, float), np.asarray(wanted, float)
    return found.shape == wanted.shape and np.allclose(found, wanted, rtol=1e-9, atol=0, equal_nan=True)


def assert_held(record, wanted):
    """Every number of a record is as wanted or held by a test that HELD names, and every wanted one is there."""
    found = flat(record)
    held = {path for pattern in HELD for path in found if re.fullmatch(pattern, path)}
    wrong = {path: (found.get(path), want) for path, want in wanted.items() if path not in found or not agree(found[path], want)}
    assert not wrong
    left = sorted(set(found) - set(wanted) - held)
    assert not left, "no test holds them"


# starts a program from a process smaller than it, which the system counts to the program until it begins
WATCH = """import os, sys
_, status, used = os.wait4(os.spawnv(os.P_NOWAIT, sys.argv[1], sys.argv[1:]), 0)
print(used.ru_maxrss)
sys.exit(os.waitstatus_to_exitcode(status))"""


def run(exe, out, scene, *keys):
    """A run with what the system tells of its process."""
    begin = time.time()
    done = subprocess.run([sys.executable, "-S", "-c", WATCH, exe, ROOT / scene, *keys, "--out", out, "-v"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    log, peak = done.stdout.rstrip().rsplit("\n", 1)
    return SimpleNamespace(record=json.loads((out / "summary.json").read_text()), folder=out, code=done.returncode, begin=begin, end=time.time(),
                           peak=int(peak) / 1024, scene=scene, keys=keys, tables={p.stem: read_csv(p) for p in out.glob("*.csv")}, log=log)


@pytest.fixture(scope="module")
def press(exe, tmp_path_factory):
    """A press fit with derivatives, that may take 3 GB."""
    keys = "load.torque_steps=2", "run.gradient=.true.", "mesh.memory_limit_mb=3000"
    return run(exe, tmp_path_factory.mktemp("p") / "p", "data/cd14.nml", *MESH, *keys)


@pytest.fixture(scope="module")
def drive(exe, tmp_path_factory):
    """A drive with even gaps, its ring held fast, its band, derivatives, and a turn; no step takes a second attempt. Derivatives of
    Eq. 45, which rests on the few points that stick, ask for a small residual."""
    keys = ("mesh.divisions=16", "mesh.band_facets=3", "load.torque_steps=2", "run.gradient=.true.", "turning.positions=2",
            "turning.range_deg=5", "turning.torque=3", "solver.tolerance=1e-10", "bearing.axial_hold=fast", f"load.tooth_gaps={EVEN}", f"load.tooth_gaps_back={EVEN}")
    return run(exe, tmp_path_factory.mktemp("d") / "d", "data/drive14.nml", *keys)


@pytest.fixture(scope="module")
def teeth(exe, tmp_path_factory):
    """A cup against teeth by exact factors."""
    return run(exe, tmp_path_factory.mktemp("t") / "t", "data/teeth.nml", *MESH, "load.torque_steps=1")


@pytest.fixture(scope="module")
def planned(exe, tmp_path_factory):
    """A run for a tolerance."""
    return run(exe, tmp_path_factory.mktemp("q") / "q", "data/cd14.nml", "geometry.bore_radius=9e-3", "geometry.hub_radius=4e-3", "run.tolerance=0.3",
               "solver.kinematics=linear")


@pytest.fixture(scope="module")
def surface(exe, tmp_path_factory):
    """A surface of Eq. 1."""
    return run(exe, tmp_path_factory.mktemp("s") / "s", "data/surface.nml", "surface.nx=128", "surface.ny=96")


def keys_of(exe):
    """Unit and default of every key as the manual has them."""
    text = call(exe, "--explain", "all").stdout
    found = re.findall(r"^([a-z_]+\.\w+)\n  .*\n\n  Default `(.*?)`(?: ([^;,\n]+))?[;,]", text, re.M)
    return {key: (default.strip("'"), unit) for key, default, unit in found}


def value_of(text):
    """A value of a namelist as a record has it."""
    parts = [part.strip().strip("'\"") for part in text.split(",")]
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        return text.strip().strip("'\"")
    return numbers if len(numbers) > 1 else numbers[0]


def scene_of(exe, run):
    """Every key: the manual's default, the file's value, the command's word, the plan's choice, the last that there is."""
    values = {key: value_of(default) for key, (default, _) in keys_of(exe).items()}
    for group, text in re.findall(r"^&(\w+)\n(.*?)^/", (ROOT / run.scene).read_text(), re.M | re.S):
        values |= {f"{group}.{key}": value_of(value) for key, value in re.findall(r"^ *(\w+) *= *([^!\n]*)", text, re.M)}
    values |= {key: value_of(value) for key, value in (word.split("=") for word in run.keys)}
    if values["wave_generator.clearance"]:
        values["wave_generator.interference"] = 0
    if values["run.tolerance"]:   # what the plan chose stands in the name of its last mesh
        name = r"(\d+)x(\d+)_edge_([^_]+)_layers_(\d+)_(\d+)_steps_(\d+)_(\d+)_"
        chosen = ("mesh.divisions", "mesh.band_facets", "mesh.edge_length", "mesh.through_wall", "mesh.through_ring", "load.assembly_steps",
                  "load.torque_steps")
        values |= dict(zip(chosen, map(float, re.match(name, run.tables["plan"]["mesh"][-1]).groups())))
        values["solver.tolerance"] = 1e-3 * values["run.tolerance"]
    return values


def of_the_scene(exe, run):
    """Every number of the scene."""
    values = scene_of(exe, run)
    return {f"scene/{key}": [value] if isinstance(run.record["scene"][key], list) and not isinstance(value, list) else value
            for key, value in values.items() if key in run.record["scene"] and f"scene/{key}" in flat(run.record)}


def of_the_process(run):
    """Code, times that add up to the clock's, largest memory."""
    times = run.record.get("timers_s", {})
    found = {f"timers_s/{part}": Between(0, run.end - run.begin) for part in times}
    if times:
        whole = sum(seconds for part, seconds in times.items() if part != "total")
        found["timers_s/total"] = pytest.approx(whole)
        assert 0.5 * (run.end - run.begin) - 1 < whole < run.end - run.begin   # a busy machine starts late
    clock = [datetime.fromisoformat(when).timestamp() for name, when in run.record["provenance"].items() if name in ("started", "finished")]
    assert int(run.begin) <= clock[0] <= clock[-1] <= run.end
    return found | {"code": run.code, "peak_memory_mb": pytest.approx(run.peak, rel=0.02, abs=1)}   # libraries take some as they end


def of_the_steps(run):
    """Results that are columns of the reference step, and what its tables count."""
    steps, history = run.tables["steps"], run.tables["history"]
    drive = run.record["scene"]["load.support"] == "drive"
    row = steps[np.flatnonzero(steps["torque_nm"] == steps["torque_nm"].max())[-1]] if drive else steps[-1]
    found = {f"results/{name}": None if np.isnan(row[name]) else pytest.approx(row[name], rel=1e-9, abs=1e-12)
             for name in steps.dtype.names if name in run.record["results"]}
    ends = [history[history["step"] == step]["iteration"].max() for step in steps["step"]]
    assert history["attempt"].max() == 0
    return found | {"results/steps": len(steps), "results/iterations": sum(ends), "results/cut_backs": 0}


def joint_of(scene):
    """The joint of Hu et al. with the numbers of a scene."""
    e, nu = ([scene[f"material.{body}_{name}"] for body in ("flexspline", "ring")] for name in ("e", "nu"))
    return hdengine.Joint(e1=e[0], nu1=nu[0], e2=e[1], nu2=nu[1], nu_soft=nu[0], hardness=2.8 * scene["material.yield_strength"], s_min=np.pi * (
        scene["joint.shortest_wavelength"] / 2)**2, reference_area=scene["joint.sample_length"]**2, friction=scene["contact.friction"],
        **{key: scene[f"joint.{key}"] for key in ("fractal_dimension", "roughness", "gamma", "asperity_radius")})


def touching_share(pressure, e, hard, d, g, long, short):
    """Pressures, and the share of the area that touches or yields there by Persson's diffusion of pressures between 0 and the hardness, over the
    wavelengths of D and G."""
    length, v, share, a = np.geomspace(long, short, 601), np.zeros(len(pressure)), np.ones(len(pressure)), 2 * (3 - d)
    q, n = 2 * np.pi / np.sqrt(length[1:] * length[:-1]), np.arange(1, 31)[:, None]
    for more in np.repeat(-np.diff(g**(2 * (d - 2)) * length**a / (2 * a)) * (q * e / 2)**2 / 20, 20):
        begun = v > pressure**2 / 50
        v = v + more * np.where(begun, (5 - 2 * share**2 + 6 * share**4) / 9, 1)
        term = np.exp(-(n * np.pi / hard)**2 * v / 2) * np.sin(n * np.pi * pressure / hard) / n
        wide = 4 / np.pi * term[::2].sum(0) + pressure / hard + 2 / np.pi * ((-1.0)**n * term).sum(0)
        share = np.where(begun, np.where(v > 0.04 * hard**2, wide, np.vectorize(erf)(pressure / np.sqrt(2 * v))), 1)
    return pressure, share


def of_the_joint(run):
    """Eq. 3 to 44 by the oracle; what a spectrum of D and G holds between its two wavelengths, in closed form; pressures of the table of facets."""
    scene, o, rows = run.record["scene"], Oracle(joint_of(run.record["scene"])), run.tables["contact"]
    rows, last = rows[rows["step"] == rows["step"].max()], run.tables["steps"][-1]
    d, g, long, short = (scene[f"joint.{key}"] for key in ("fractal_dimension", "roughness", "sample_length", "shortest_wavelength"))
    e = 1 / sum((1 - scene[f"material.{body}_nu"]**2) / scene[f"material.{body}_e"] for body in ("flexspline", "ring"))
    hard, a = 2.8 * scene["material.yield_strength"], 2 * (3 - d)
    slope = 2 * np.pi * g**(d - 2) * np.sqrt((short**(a - 2) - long**(a - 2)) / (2 * (2 - a)))
    p, q = (np.array([rows[f"{name}_{k}_pa"] for k in (1, 2, 3, 4)]) for name in ("pressure", "shear"))
    sticks = (p > 0) & (q < last["friction"] * p * (1 - 1e-5))
    counts = np.broadcast_to(rows["area_m2"] / 4, p.shape) * (sticks if sticks.any() else p > 0)
    mean, near = last["normal_force_n"] * (1 - last["slip_share_force"] * sticks.any()) / counts.sum(), 1e-6
    if scene["contact.mode"] == "bonded":   # some faces are drawn apart; corners at an end of the contact are evened out
        mean, near = (counts * p).sum() / counts.sum(), 0.02
    q = np.geomspace(2 * np.pi / long, 2 * np.pi / short, 20001)
    power = q**(-a - 1)   # of the heights
    waves = np.trapezoid(power, q)**2 / np.trapezoid(power**2 / (q / (2 * np.pi)), q) * counts.sum()
    touch = touching_share(np.geomspace(1e-3, 1, 25) * min(p.max(), 0.99 * hard), e, hard, d, g, long, short)
    share = (counts * np.exp(np.interp(np.log(np.maximum(p, 1)), *np.log(touch)))).sum() / (counts * p).sum()
    share *= run.record["joint"]["theory_error"]["mean_pressure_pa"]
    error = {"area_m2": counts.sum(), "mean_pressure_pa": pytest.approx(mean, rel=near), "independent_waves": pytest.approx(waves, rel=5e-4),
             "contact_area_fraction": pytest.approx(share, rel=5e-3 if p.max() < 0.3 * hard else 0.06),   # high corners are evened out
             "e_star_slope_over_hardness": pytest.approx(e * slope / hard, rel=1e-3)}
    found = {"asperity_radius_m": scene["joint.asperity_radius"], "s_min_m2": np.pi * (short / 2)**2, "reference_area_m2": long**2,
             "hardness_pa": hard, "reduced_modulus_pa": e, "s_ec_m2": float(o.s_ec), "psi": float(o.psi)}
    return {f"joint/{name}": value for name, value in found.items()} | {f"joint/theory_error/{name}": value for name, value in error.items()}


def of_the_model(run):
    """Points of the grids, facets and multipliers of a closed band, rows of Newton's matrix; entries of the banded factors of both sections for
    every harmonic, stations of points through the wall; operations of a dense factorisation of whole rows."""
    scene, model = run.record["scene"], run.record["model"]
    n, m = (int(run.tables["contact"][name].max()) for name in ("i_theta", "i_z"))
    assert n == scene["mesh.divisions"] and (m == scene["mesh.band_facets"] or scene["mesh.edge_length"])
    points = sum(int(re.search(rb'NumberOfPoints="(\d+)"', path.read_bytes())[1]) for path in run.folder.glob("bodies_*.vtu"))
    cup, ring = (int(scene[f"mesh.through_{body}"]) + 1 for body in ("wall", "ring"))   # points through either
    free = 0 if scene["load.support"] == "drive" else 1   # a pressed ring is held on its inner face, either at a point along the axis
    entries = 6 * cup * (3 * points // n - 3 * ring * (m + 1) - 3 * cup) + 2 * (3 * ring - free) * ((3 * ring - free) * (m + 1) - 1)
    dense = 1.5 * model["factor_flops"]
    if model["solver"] == "condensed by harmonics":
        part = 2 if "half" in model["symmetry_torque"] else 1
        found = {"unknowns": 3 * n * (m + 1), "factor_entries": pytest.approx(entries * (n // 2 // part + 1), rel=0.02 if cup > 2 else 1e-12)}
        found["factor_flops"] = round(dense**(1 / 3))**3 / 1.5 if cup == 2 else Between(1, 2 / 3 * (3 * n * (m + 1))**3)
        assert round(dense**(1 / 3)) <= 3 * n * (m + 1)
    else:
        rows = 3 * points - n * (6 + m + 2) + 3 * n * (m + 1)
        least = model["factor_entries"]**2 / (2 * rows)   # all columns alike
        found = {"unknowns": rows, "factor_entries": Between(30 * rows, rows**2), "factor_flops": Between(least, rows * model["factor_entries"])}
    found |= {"dof": 3 * points, "facets": n * m, "multipliers": n * (m + 1)}
    if scene["load.support"] in ("drive", "teeth"):
        wall = scene["geometry.bore_radius"] + scene["geometry.wall_thickness"]
        roots = scene["load.spline_root_diameter"] / 2 or wall * (1 + 5 / scene["load.teeth"]) + scene["wave_generator.w"]
        found["tooth_circle_m"] = (wall + roots - scene["wave_generator.w"]) / 2
    return {f"model/{name}": value for name, value in found.items()}


DIMENSIONS = {"m": (1, 0), "Pa": (-2, 1), "N/m": (-1, 1), "N": (0, 1), "N m": (1, 1), "n": (0, 1), "pa": (-2, 1), "rad": (0, 0), "n_per_m": (-1, 1),
              "nm_per_rad": (1, 1), "min": (0, 0)}   # of length and force


def of_the_gradient(exe, run):
    """The derivatives themselves, once they say what dimensions alone do: sum of p dy/dp over all keys, times the power of the length or of the
    force in p, is y times its own. Keys that a result does not go with have none."""
    units, scene, gradient = keys_of(exe), run.record["scene"], run.record["gradient"]
    for name, by in gradient.items():
        keys = [key for key, slope in by.items() if slope is not None]
        parts = np.array([np.ravel(scene[key])[0] * by[key] for key in keys])
        powers = np.array([DIMENSIONS.get(units[key][1], (0, 0)) for key in keys])
        own = DIMENSIONS[next(end for end in sorted(DIMENSIONS, key=len, reverse=True) if name.endswith(f"_{end}"))]
        missed = parts @ powers - np.array(own) * run.record["results"][name]
        near = 1e-4 if name == "k_ts_nm_per_rad" else 3e-5   # Eq. 45 rests on few points: off by 0.3e-5 to 5e-5 as the residual is
        assert (abs(missed) < [5e-4 * abs(parts).max(), near * abs(parts).max()]).all(), (name, missed / abs(parts).max())
        both_lobes = name in ("von_mises_max_pa", "edge_line_load_n_per_m")   # they have one largest value each
        assert set(by) - set(keys) <= ({"wave_generator.eccentricity"} if both_lobes else set())
        assert all(by[key] == 0 for key in by if key.startswith("fatigue.") and not name.startswith("goodman"))
    return {f"gradient/{name}/{key}": slope for name, by in gradient.items() for key, slope in by.items()}


def of_the_plan(run):
    """Limits and their errors as the manual says (docs/explain/planner.md), from plan.csv: a line over rows^-3/2 through the last three meshes;
    the larger of what the last mesh changed of its end and of the way to it, with its standard error; the last doubling of the load steps; two
    layers."""
    table, rows = run.tables["plan"], np.array([8.0, 12.0, 16.0])
    mesh = {int(re.match(r"\d+x(\d+)_", name)[1]): row for name, row in zip(table["mesh"], table) if "_steps_1_1_" in name}
    twice = next(row for name, row in zip(table["mesh"], table) if re.match(r"\d+x8_.*_steps_2_2_", name))

    def line(columns, last):
        q = np.array([[mesh[n][column] for column in columns] for n in (6, 8, 12, 16)[last - 3:last]])
        x = rows**-1.5 if last == 4 else np.array([6.0, 8.0, 12.0])**-1.5
        slope, end = np.polyfit(x, q, 1)
        return end, np.linalg.norm(q - end - np.outer(x, slope), axis=0) * np.sqrt(1 / 3 + x.mean()**2 / ((x - x.mean())**2).sum())

    found = {"tolerance": run.record["scene"]["run.tolerance"], "level": [4, 6, 8, 12, 16].index(max(mesh)) + 1}
    for name, column, layers, count in (
            ("k_ts_tangent", "k_ts_bonded_nm_per_rad", 0.014, 0), ("rotation", "rotation_rad", 0.005, 0),
            ("normal_force", "normal_force_n", 0.002, 0),
            ("mid_band_pressure", "pressure_mid_mean_pa", 0.005, 0), ("mid_band_peak", "pressure_mid_max_pa", 0.005, 0),
            ("k_ts_tangent_steps", "k_ts_tangent_steps_nm_per_rad", 0.014, 2), ("pressure_field", "pressure_field_pa", 0.003, 64)):
        columns = [f"{column}_{i}" for i in range(count)] or [column]
        q, doubled, coarse = (np.array([row[c] for c in columns]) for row in (mesh[16], twice, mesh[8]))
        if count == 2:
            doubled = np.array([twice[f"{column}_{i}"] for i in (0, 2)])   # every second step
        (limit, scatter), (before, _) = line(columns, 4), line(columns, 3)
        error, by_steps = np.maximum(abs(limit - before), abs(limit - q)) + scatter, abs(doubled - coarse)
        limit, size = np.where(q == 0, 0, limit), np.linalg.norm if count == 64 else np.max
        if count < 64:
            error, by_steps = error / abs(limit), by_steps / coarse
        else:
            error, by_steps = error / np.linalg.norm(limit), by_steps / np.linalg.norm(coarse)
        found |= {column: limit, f"mesh_over_limit_{name}": np.divide(q, limit, out=np.ones(len(q)), where=limit != 0),
                  f"estimated_error_{name}": np.sqrt(size(error)**2 + size(by_steps)**2 + layers**2)}
    return {f"plan/{name}": pytest.approx(np.ravel(value)[0] if np.size(value) == 1 else value, rel=1e-7, abs=1e-12)
            for name, value in found.items()}


def levelled(heights):
    """A map less its plane, and the plane."""
    good, (y, x) = np.isfinite(heights), np.indices(heights.shape)
    basis = np.stack([np.ones(heights.size), x.ravel(), y.ravel()], axis=1)
    plane = np.linalg.lstsq(basis[good.ravel()], heights[good], rcond=None)[0]
    return heights - (basis @ plane).reshape(heights.shape), plane


def both_ways(*maps):
    """Mean over 20 lags of S along the rows over that along the columns, of maps added up."""
    s = [np.sum([[np.nanmean((z[:, n:] - z[:, :-n])**2), np.nanmean((z[n:] - z[:-n])**2)] for z in maps], axis=0) for n in range(1, 21)]
    return np.mean(np.divide(*np.transpose(s)))


def of_the_surface(exe, run):
    """Waves, the keys of Eq. 1, the plane and the ratio of S one way and the other by numpy, misfits by fit.csv; D and G are those put in."""
    scene, heights, table = scene_of(exe, run), np.load(run.folder / "heights.npy"), run.tables["fit"]
    fit = run.record["fits"]["generated"]
    length, gamma, ridges = (scene[f"surface.{key}"] for key in ("sample_length", "gamma", "ridges"))
    exponents = int(np.log(length / scene["surface.shortest_wavelength"]) / np.log(gamma)) + 1
    z, plane = levelled(heights)
    found = {"noise_m": 0, "misfit": 0, "freedom": len(table) - 2, "lags": [1, len(table)], "tilt": plane[1:] / 1e-6, "anisotropy": both_ways(z),
             "residual_rms": np.sqrt(np.mean(np.log(table["s_m2"] / table["model_m2"])**2)), "chi2": Between(6, 38),
             "residual_rms_expected": np.sqrt(np.mean(table["sample_error_ln"]**2 - table["model_error_ln"]**2)), "ridges/length_m": length,
             "ridges/shortest_wavelength_m": length / gamma**(exponents - 1), "ridges/ridges": ridges, "ridges/gamma": gamma,
             "fractal_dimension_error": np.sqrt(fit["covariance"][0]), "ln_roughness_error": np.sqrt(fit["covariance"][4])}
    for name, truth, error, ln in (("fractal_dimension", scene["surface.fractal_dimension"], fit["fractal_dimension_error"], False),
                                   ("roughness", scene["surface.roughness"], fit["ln_roughness_error"], True)):
        value = fit["roughness_m" if ln else name]
        ends = value * np.exp([-1.96 * error, 1.96 * error]) if ln else value + np.array([-1.96 * error, 1.96 * error])
        found |= {"roughness_m" if ln else name: pytest.approx(truth, rel=0.15 if ln else 0.01)}
        found |= {f"{name}_95{part}{'_m' if ln else ''}": pytest.approx(ends, rel=1e-3) for part in ("", "_sampling")}
    return {f"fits/generated/{name}": value for name, value in found.items()} | {
        "spacing_m": [1e-6, 1e-6], "generator/waves": exponents * ridges, "generator/sum_s": Between(0, run.end - run.begin)}


@pytest.fixture(scope="module")
def other(exe, tmp_path_factory):
    """The press fit by the joint of Hu et al., whose Newton iterations have inner ones."""
    return run(exe, tmp_path_factory.mktemp("o") / "o", "data/cd14.nml", *MESH, "load.torque_steps=2", "joint.model=hu2023")


HERE, COLUMNS = "test_summaries.py", "test_columns.py"
HELD = {   # of runs: numbers that none of the above gives, and the test that does
    "results/(flexspline_)?von_mises_max_pa": "test_strength.py::test_every_run_states_the_stress_of_both_bodies",
    "results/(flexspline|ring)_yield_safety": "test_strength.py::test_every_run_states_the_stress_of_both_bodies",
    "results/cycles": "test_run.py::test_cycling_states_are_named",
    "results/k[123]_nm_per_rad": "test_drive.py::test_chords_are_those_of_the_first_rise",
    "results/(hysteresis|lost_motion)_rad": f"{COLUMNS}::test_loop_is_that_of_its_tables",
    "results/(reference_torque_nm|wave_generator_torque_max_nm|(ball|tooth)_force_max_n)": f"{COLUMNS}::test_loop_is_that_of_its_tables",
    "results/(loop_(work|stored|dissipated|dissipated_teeth)_j|twist_shares/.*)": f"{COLUMNS}::test_loop_is_that_of_its_tables",
    "results/turning_(angle_error_rad|stiffness_(min|max)_nm_per_rad)": f"{COLUMNS}::test_turning_is_even",
    "results/goodman_safety_min": f"{COLUMNS}::test_fatigue_is_a_line",
    "results/ball_pressure_max_pa": "test_drive.py::test_balls_follow_hertz",
    "results/.*_(low|high)|results/band_shares/.*": "test_band.py::test_band_is_that_of_runs_at_the_ends",
    "results/cam_gap_max_m": "test_cam.py::test_gap_over_a_notch",
    "results/cam_(force_n|contact_area_m2|pressure_min_pa)": "test_cam.py::test_hoop_force_of_a_stretched_ring",
    "results/cam_force_x_n": "test_sides.py::test_ring_lifts_off_the_wave_generator",
    "results/gross_slip_torque_nm": "test_run.py::test_gross_slip_is_diagnosed",
    "joint/theory_error/(ln_k_n_half_width|k_ts_tangent_change)": "test_joint_auto.py::test_error_of_the_theory_is_said_and_moves_the_tangent",
    "k_ts_by_model/.*_nm_per_rad": f"{HERE}::test_other_models_are_those_of_runs_with_them",
    "predicted/memory_allowed_mb": "test_solver_choice.py::test_a_limit_of_the_shell_counts_as_the_machines",
    "predicted/(condensed|harmonic|exact)_(s|mb)": "test_solver_choice.py::test_predictions_are_near_what_was_measured",
    "results/(height|slope)_.*|fits/.*/roughness/.*": f"{COLUMNS}::test_numbers_of_heights",
    "fits/generated/band_m": f"{COLUMNS}::test_structure_of_heights",
    "surfaces/.*/wrong_from_m|fits/.*/spectrum/wrong_from_m": "test_wrong_points.py::test_what_cannot_be_seen_is_said",
    "surfaces/.*/areal/(sdq|sdr)": "test_texture.py::test_gradients_of_a_slope",
    "surfaces/.*/areal/(sal_m|str|std_rad)": "test_texture.py::test_autocorrelation_and_direction_of_a_lay",
    "surfaces/.*/areal/(sk_m|spk_m|svk_m|smrk1|smrk2|sxp_m)": "test_texture.py::test_heights_and_material_ratio_of_a_known_curve",
    "surfaces/.*/covariance_of_d_ln_g|fits/.*/covariance": f"{HERE}::test_covariance_is_that_of_many_fits",
    "band_half_widths_ln_k_n/law/.*": "test_joint_choice.py::test_stated_error_holds",
    "band_half_widths_ln_k_n/longer waves/.*": "test_joint_choice.py::test_longer_waves_are_counted",
    "(e_star_pa|k_t_over_k_n|hardness_pa)": f"{COLUMNS}::test_joint_is_that_of_its_spectrum",
    "(h_rms_m|slope_rms)": f"{COLUMNS}::test_spectrum_of_a_map",
    "model/inner_iterations": f"{HERE}::test_inner_iterations_are_those_of_the_log",
}


def test_press(exe, press):
    """A press fit with derivatives."""
    assert_held(press.record, of_the_scene(exe, press) | of_the_process(press) | of_the_steps(press) | of_the_joint(press) | of_the_model(press) |
                of_the_gradient(exe, press))


def test_drive(exe, drive):
    """A drive over its loop, with its band."""
    assert_held(drive.record, of_the_scene(exe, drive) | of_the_process(drive) | of_the_steps(drive) | of_the_joint(drive) | of_the_model(drive) |
                of_the_gradient(exe, drive))


def test_teeth(exe, teeth):
    """A cup against teeth, by factors of the matrix itself."""
    assert_held(teeth.record, of_the_scene(exe, teeth) | of_the_process(teeth) | of_the_steps(teeth) | of_the_joint(teeth) | of_the_model(teeth))


def test_planned(exe, planned):
    """A run for a tolerance."""
    assert_held(planned.record, of_the_scene(exe, planned) | of_the_process(planned) | of_the_steps(planned) | of_the_joint(planned) |
                of_the_model(planned) | of_the_plan(planned))


def test_surface(exe, surface):
    """A surface of Eq. 1 and its fit."""
    assert_held(surface.record, of_the_process(surface) | of_the_surface(exe, surface))


def test_other_models_are_those_of_runs_with_them(press, other):
    """spectrum_nm_per_rad and hu2023_nm_per_rad of a run by either: the chosen one's is its own K_TS, that of the other a run's with that model."""
    for name, this, that in (("spectrum_nm_per_rad", press, other), ("hu2023_nm_per_rad", other, press)):
        own = this.record["k_ts_by_model"][name]
        assert own == this.record["results"]["k_ts_nm_per_rad"] == pytest.approx(that.record["k_ts_by_model"][name], rel=1e-6)


def test_inner_iterations_are_those_of_the_log(exe, tmp_path):
    """inner_iterations are the steps of GMRES within Newton's method, as the log has them; those of derivatives and tangents do not count."""
    keys = "mesh.divisions=40", "mesh.band_facets=8", "load.torque_steps=1", "solver.method=condensed", "solver.symmetry=full", "output.vtu=none"
    alone, more = (run(exe, tmp_path / name, "data/cd14.nml", *keys, *also) for name, also in (
        ("a", ["load.tangent_steps=none"]), ("b", ["load.tangent_steps=all", "run.gradient=.true."])))
    steps = sum(map(int, re.findall(r"GMRES (\d+) steps", alone.log)))
    assert 0 < steps == alone.record["model"]["inner_iterations"] == more.record["model"]["inner_iterations"]


def test_covariance_is_that_of_many_fits():
    """Covariance (covariance_of_d_ln_g) of D and ln G is that of the fits of 60 surfaces of Eq. 1 to 30 %, their correlation to 0.05; of a fit told
    nothing it is the mean square of the errors over maps of all kinds, to a factor of two."""
    known, of_eq_1 = roughness.Ridges(0.5e-3, 1e-6), (128, 1e-6, 2.5304, 2.4248e-7, 1.5, 0.5e-3, 1e-6, 10)
    fits = [roughness.fit(hdengine.surface.generate(*of_eq_1, seed)[:96], 1e-6, surface=known) for seed in range(200, 260)]
    told = np.mean([f.covariance[:2, :2] for f in fits], axis=0)
    found = np.cov([(f.fractal_dimension, np.log(f.roughness_m)) for f in fits], rowvar=False)
    assert np.diag(found) == pytest.approx(np.diag(told), rel=0.3)
    assert found[0, 1] / np.sqrt(found[0, 0] * found[1, 1]) == pytest.approx(told[0, 1] / np.sqrt(told[0, 0] * told[1, 1]), abs=0.05)
    fits = [roughness.fit(*field(96, 1e-6, 2.5, np.random.default_rng(seed), **case)) for case in CASES.values() for seed in (1, 2)]
    errors = np.array([[f.fractal_dimension - 2.5, np.log(f.roughness_m) - LN_G] for f in fits])
    assert Between(0.5, 2) == np.mean([np.outer(e, e) / f.covariance[:2, :2] for e, f in zip(errors, fits)], axis=0)


def planted():
    """Maps of D = 2.5 and their truths: one tilted, seen by a probe with noise; one with spikes, holes and a seam; one whose rows jitter."""
    rng, n, dx = np.random.default_rng(1), 128, 1e-6
    seen, _ = field(n, dx, 2.5, np.random.default_rng(1), finer=4, probe=0.5)
    scale = seen.std()
    seen += 0.03 * scale * rng.standard_normal(seen.shape) + 2e-3 * dx * np.arange(n) - 1e-3 * dx * np.arange(n)[:, None]
    wrong, _ = field(n, dx, 2.5, np.random.default_rng(5), finer=2)
    step = wrong.std()
    wrong.flat[rng.choice(50 * n, 7, replace=False)] += 8 * step
    wrong[60:70, 50:62] = np.nan
    wrong[100:] += step
    shaken, _ = field(n, dx, 2.5, np.random.default_rng(2), finer=2)
    shake = 0.2 * shaken.std()
    shaken += shake * rng.standard_normal((n, 1))
    power = abs(np.fft.fft2((shaken - shaken.mean()) * np.outer(np.hanning(n), np.hanning(n))))**2
    ring = np.rint(np.hypot(*np.meshgrid(np.fft.fftfreq(n) * n, np.fft.fftfreq(n) * n)))
    excess = np.mean([power[k, 0] / np.mean(power[1:, 1:][ring[1:, 1:] == k]) for k in range(2, n // 2)])
    none = {"noise_m": 0, "probe_m": Between(0, 0.3e-6), "spikes": 0, "holes": 0, "seams": [0, 0], "seam_step_m": 0, "jitter_m": [0, 0],
            "axis_excess": Between(0.7, 1.5), "finer_detail": Between(0, 1)}
    return {"seen": (seen, none | {"noise_m": pytest.approx(0.03 * scale, rel=0.1), "probe_m": pytest.approx(0.5e-6, rel=0.1), "finer_detail": 1}),
            "wrong": (wrong, none | {"spikes": 7, "holes": 7 + 120, "seams": [0, 1], "seam_step_m": pytest.approx(step, rel=0.1)}),
            "shaken": (shaken, none | {"jitter_m": pytest.approx([0, shake], rel=0.15), "axis_excess": pytest.approx([1, excess], rel=0.6)})}


def of_a_fit(fit, truth, *maps):
    """D and G are those put in, with what else was; intervals as wide as the errors; the plane and S both ways by numpy."""
    (dd, dg), (gd, gg) = np.reshape(fit["covariance"], (3, 3))[:2, :2] if "covariance" in fit else fit["covariance_of_d_ln_g"]
    d, g, z = Around(2.5, dd), Around(len(maps) * 1e-7, gg, log=True), [levelled(heights)[0] for heights in maps]
    assert gd == dg and 0.9 < dg / np.sqrt(dd * gg) < 1 and 0.01 < np.sqrt(dd) < 0.2
    ratio, wide = both_ways(*z), np.exp(4 * np.sqrt(gg))
    return {"fractal_dimension": Between(2.35, 2.65), "roughness_m": Between(g.value / wide, g.value * wide),
            "roughness_95_m": g, "roughness_95_sampling_m": g, "fractal_dimension_95": d, "fractal_dimension_95_sampling": d,
            "misfit": Between(0, 0.02), "chi2": Between(5, 45), "lags": [1, 20], "tilt": levelled(maps[0])[1][1:] / 1e-6,
            "anisotropy": ratio if np.isfinite(maps).all() else pytest.approx(ratio, rel=0.1)} | truth


def of_areal_numbers(heights):
    """ISO 25178-2 by numpy, of the map less its plane; no form but the plane, no filters."""
    good, (z, _) = np.isfinite(heights), levelled(heights)
    plane, z = (heights - z)[good], z[good]
    found = {"form_range_m": np.ptp(plane), "outliers": 0, "holes": (~good).sum(), "sa_m": abs(z).mean(), "sq_m": z.std(), "sp_m": z.max(),
             "sv_m": -z.min(), "sz_m": np.ptp(z), "ssk": (z**3).mean() / z.std()**3, "sku": (z**4).mean() / z.std()**4}
    return found | dict.fromkeys(("form_radius_m", "form_axis_rad", "s_filter_m", "l_filter_m"))


def test_fits(exe, tmp_path, capsys):
    """surface.json of three maps, and summary.json of the program's fit of two and of both together: power of the rings is G^(2(D-2)) f^(2D-8) /
    (4 pi), less what a Gaussian probe takes, where D, G and probe were put in; the equivalent surface of two of one D has the sum of both G."""
    maps, wanted = planted(), {}
    for name, (z, _) in maps.items():
        np.save(tmp_path / f"{name}.npy", z)
    assert cli.main(["surface", *(str(tmp_path / f"{name}.npy") for name in maps), "--spacing", "1e-6", "--out", str(tmp_path / "o")]) == 0
    record, rows = json.loads((tmp_path / "o/surface.json").read_text()), read_csv(tmp_path / "o/spectrum.csv")
    files = (f"fit.{key}={tmp_path / name}.npy" for key, name in (("first_file", "seen"), ("second_file", "shaken")))
    done = run(exe, tmp_path / "f", "data/surface.nml", *files, "fit.dx=1e-6")
    told = of_the_process(done) | {"spacing_m": [1e-6, 1e-6]}
    for name, (z, truth) in maps.items():
        f, power, model = (rows[key][rows["surface"] == name] for key in ("frequency_per_m", "power", "model"))
        inside, long = np.isfinite(model), f < 2.5e5
        law = 1e-7 * f**-3 / (4 * np.pi) * np.exp(-(2 * np.pi * f * (0.5e-6 if name == "seen" else 0))**2)
        assert [np.median((power / law)[long]), np.median((model / law)[inside & long])] == pytest.approx([1, 1], abs=0.2)
        window = {"freedom": inside.sum() - 4, "band_m": [1 / f[inside].max(), 1 / f[inside].min()]}   # D, G, noise, probe
        found = of_a_fit(record["surfaces"][name], truth, z) | window | {f"areal/{key}": value for key, value in of_areal_numbers(z).items()}
        found |= {"spectrum/frequency_per_m": f, "spectrum/power": power, "spectrum/model": [None if np.isnan(m) else m for m in model],
                  "ridges": None, "points": z.shape, "spacing_m": [1e-6, 1e-6], "size_m": [127e-6, 127e-6],
                  "ranges_d_m_m": [[Between(2.35, 2.65), *window["band_m"]]]}
        wanted |= {f"surfaces/{name}/{key}": value for key, value in found.items()}
    assert_held(record, wanted)
    (seen, of_seen), (shaken, of_shaken) = maps["seen"], maps["shaken"]
    parts = {"first": (of_seen, seen), "second": (of_shaken, shaken), "equivalent": (of_shaken | {"noise_m": Between(0, 2e-7)}, seen, shaken)}
    for part, (truth, *heights) in parts.items():
        fit, table = done.record["fits"][part], done.tables["fit"][done.tables["fit"]["surface"] == part]
        beside = {"fractal_dimension_error": pytest.approx(np.ptp(fit["fractal_dimension_95"]) / 3.92, rel=1e-4),
                  "ln_roughness_error": pytest.approx(np.ptp(np.log(fit["roughness_95_m"])) / 3.92, rel=1e-4),
                  "residual_rms": np.sqrt(np.mean(np.log(table["s_m2"] / table["model_m2"])**2)),
                  "residual_rms_expected": np.sqrt(np.mean(table["sample_error_ln"]**2))}
        found = of_a_fit(fit, truth, *heights) | window | beside | {"scatter": Between(0.85, 1.15)}
        told |= {f"fits/{part}/{'spectrum/' * (key in [*truth, 'scatter'] and key != 'noise_m')}{key}": value for key, value in found.items()}
    assert_held(done.record, told)


def test_forms_and_filters_are_those_put_in(tmp_path, capsys):
    """form_radius_m, form_axis_rad, form_range_m, s_filter_m, l_filter_m and outliers of a cylinder of 5 mm at 0.3 rad, with three spikes."""
    y, x = np.mgrid[:120, :160] * 1e-6
    across = np.cos(0.3) * (y - 59.5e-6) - np.sin(0.3) * (x - 79.5e-6)
    shape = np.sqrt(5e-3**2 - across**2)
    z = shape + 1e-9 * np.random.default_rng(1).standard_normal(x.shape)
    z[[10, 60, 90], [10, 80, 140]] += 1e-6
    np.save(tmp_path / "c.npy", z)
    words = "--form", "cylinder", "--s-filter", "2.5e-6", "--l-filter", "8e-5", "--outliers", "--spacing", "1e-6", "--out", str(tmp_path / "o")
    assert cli.main(["surface", str(tmp_path / "c.npy"), *words]) == 0
    areal = json.loads((tmp_path / "o/surface.json").read_text())["surfaces"]["c"]["areal"]
    assert areal["form_radius_m"] == pytest.approx(5e-3, rel=0.01) and areal["form_axis_rad"] == pytest.approx(0.3, abs=0.01)
    assert areal["form_range_m"] == pytest.approx(np.ptp(shape), rel=0.01)
    assert (areal["s_filter_m"], areal["l_filter_m"], areal["outliers"]) == (2.5e-6, 8e-5, 3)


def test_joint(joint):  # noqa: F811 (a fixture)
    """joint.json of a map, by numpy: moments of its heights, mean squares of its slopes, waves that would hold as much; the parts of its band by 60
    maps of its spectrum, whose longest waves the fit takes for less known, and by differences."""
    (tables, record, z), p = joint, joint[0]["joint"]["pressure_pa"]
    z = levelled(z)[0]
    w, h, waves = z / z.std(), tables["spectrum"]["height_variance_m2"], tables["spectrum"]["waves_per_m2"] * (64e-6)**2
    low, high = np.quantile(w, [0.9, 0.995])
    steps = np.gradient(z, 1e-6)
    rows, columns = (np.mean(np.diff(z, axis=k)**2) / 1e-12 for k in (0, 1))
    slopes = np.array(record["surfaces"][0]["slope_moments"])
    mixed = np.mean(steps[0] * steps[1]) / np.sqrt(np.prod(np.mean(np.square(steps), axis=(1, 2))) / (slopes[0, 0] * slopes[1, 1]))
    small, large = np.linalg.eigvalsh(slopes)
    assert np.diag(slopes) == pytest.approx([rows, columns], rel=0.1)   # of waves, by differences
    wanted = {"holes": 0, "skewness": (w**3).mean(), "kurtosis": (w**4).mean(), "crests": pytest.approx((high - low) / (2.5758 - 1.2816), rel=1e-3),
              "isotropy": small / large, "slope_moments": np.array([[slopes[0, 0], mixed], [mixed, slopes[1, 1]]]), "h_rms_m": z.std(),
              "slope_rms": np.sqrt((tables["spectrum"]["q_per_m"]**2 * h).sum()), "noise_variance_m2": 0}
    wanted = {f"surfaces/0/{key}": value for key, value in wanted.items()} | {"independent_waves": h.sum()**2 / (h**2 / waves).sum(), "tamaas": None}

    def ln_k(z, **bodies):
        return np.log(predict((z, (1e-6, 1e-6)), pressure=p, model="spectrum", draws=2, bodies=Bodies(**bodies)).table["k_n_pa_per_m"])
    size, rng = abs(np.fft.fft2(z)), np.random.default_rng(3)
    drawn = [ln_k(np.fft.ifft2(size * np.fft.fft2(rng.normal(size=z.shape)) / 64).real) for _ in range(60)]
    by_e, by_h = (ln_k(z, **up) - ln_k(z) for up in ({"e1": 1.01 * Bodies.e1, "e2": 1.01 * Bodies.e2}, {"hardness": 1.01 * Bodies.hardness}))
    sampling, moduli = 1.96 * np.std(drawn, axis=0), 196 * np.hypot(0.02 * by_e, 0.15 * by_h)
    for name, half in (("sampling", Between(0.9 * sampling, 2 * sampling)), ("E* and hardness", pytest.approx(moduli, rel=0.2))):
        wanted |= {f"band_half_widths_ln_k_n/{name}/{end}": half for end in ("low", "high")}
    assert_held(record, wanted)


def test_record(tmp_path, capsys):
    """record.json of the bench's record: what the script that made it put in."""
    assert cli.main(["record", str(ROOT / "data/torque_record.csv"), "--out", str(tmp_path / "r")]) == 0
    torque, turn = bench.record()
    scatter = np.hypot(0.2 * bench.ARCSEC, 0.005 / bench.stiffness(torque).mean()) / np.sqrt(3)   # even ones
    turns = np.array([bench.angle(t) - bench.WIDTH * (1 - (t / 5)**2) for t in (0, 2, 5)])   # where the torque rises; T2 is beyond the record
    k1, k2 = np.array([2, 3]) / np.diff(turns)
    truth = {"hysteresis": 2 * bench.WIDTH, "lost_motion": 2 * bench.angle(0.04 * 7.8), "closing": 0.0}
    wanted = {"size": 14, "readings": len(turn), "torque_min_nm": torque.min(), "torque_max_nm": torque.max(), "torque_error_nm": 0.05,
              "angle_error_rad": 2 * bench.ARCSEC, "scatter_rad": pytest.approx(scatter, rel=0.1), "band_share": 0.95,
              "value_low_high/k1_nm_per_rad": Beside(k1, 0.03), "value_low_high/k2_nm_per_rad": Beside(k2, 0.03),
              "value_low_high/k3_nm_per_rad": [None] * 3}
    wanted |= {f"value_low_high/{key}_rad": Beside(value, 0.03) for key, value in truth.items()}
    assert_held(json.loads((tmp_path / "r/record.json").read_text()), wanted)


def test_study(exe, tmp_path):
    """study.json of two points of which one cannot be solved."""
    fixed = {"mesh.divisions": 16, "mesh.band_facets": 3, "load.torque_steps": 1, "load.support": "bearing"}
    hdengine.Study(ROOT / "data/cd14.nml", grid={"load.torque": [1.0, 300.0]}, fixed=fixed).run(tmp_path / "s", show=False)
    record = json.loads((tmp_path / "s/study.json").read_text())
    words = [f"{key}={value}" for key, value in ({"load.torque": 1.0} | fixed).items()]
    wanted = of_the_scene(exe, SimpleNamespace(record=record, scene="data/cd14.nml", keys=words))
    wanted |= {f"identity/fixed/{key}": value for key, value in fixed.items() if key != "load.support"}
    assert_held(record, wanted | {"points": 2, "done": 2, "failed": 1, "identity/grid": [["load.torque", [1.0, 300.0]]]})


TEXTS = {"file", "input_files", "chosen_because", "first_guesses", "message", "model_error", "tolerance_covers", "left_out"}   # of other runs, and no numbers


def test_every_number_is_held(press, drive, teeth, planned, surface):
    """What HELD names is a test that names the number; a name that the program writes into a record is in one of these, or in this file."""
    paths = {path for run in (press, drive, teeth, planned, surface) for path in flat(run.record)}
    for pattern, name in HELD.items():
        source = source_of(name)
        known = words(source) | {node.attr for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Attribute)}
        leaves = {re.sub(r".*[/.]|_low$|_high$", "", path) for path in paths if re.fullmatch(pattern, path)}
        assert not [leaf for leaf in leaves if leaf not in known and not any(re.fullmatch(word, leaf) for word in known)], name
    here = words((ROOT / "tests/python/test_summaries.py").read_text())
    names = {name for run in (press, drive, teeth, planned, surface) for path in flat(run.record) for name in path.split("/")}
    texts = {key for run in (press, drive, teeth, planned, surface) for key in re.findall(r'"(\w+)": *["tf]', json.dumps(run.record))}
    for path in [*ROOT.glob("fortran/drive/**/*.f90"), *ROOT.glob("fortran/surface/**/*.f90")]:
        for name in re.findall(r"json%(?:add|begin)\('(\w+)'", path.read_text()):
            held = any(re.fullmatch(pattern.split("/", 1)[-1], name) for pattern in HELD)
            assert held or name in names | texts | TEXTS | here, f"no test holds {name} of {path.name}"
