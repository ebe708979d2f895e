# SPDX-License-Identifier: GPL-3.0-or-later
"""Every column of every table is held by a value from outside: a formula here, or the test that HELD names; numbers of JSON: test_summaries."""
import ast
import functools
import json
import re
from math import erf

import numpy as np
import pytest

import hdengine
from conftest import ROOT, call, solved
from hdengine import cli
from hdengine.table_file import read_csv
from hdengine.torsion import torsional_stiffness

R = 17.5e-3  # bore of size 14 [m]
AROUND, ALONG, BALLS, PAIRS = 24, 4, 21, 40
KEYS = [f"mesh.divisions={AROUND}", f"mesh.band_facets={ALONG}", "output.vtu=none"]


def solve(exe, out, scene, *keys):
    """Tables and summary of a run."""
    summary = solved(exe, out, ROOT / scene, *KEYS, *keys).summary
    return {p.stem: read_csv(p) for p in out.glob("*.csv")}, summary


@pytest.fixture(scope="module")
def drive(exe, tmp_path_factory):
    """A drive over a loop, with friction of the flanks, that turns."""
    return solve(exe, tmp_path_factory.mktemp("d") / "d", "data/drive14.nml", "load.torque_steps=8", "turning.positions=3", "turning.range_deg=6",
                 "turning.torque=4", "load.tooth_friction=0.1", "bearing.cage_angle_deg=3")


@pytest.fixture(scope="module")
def press(exe, tmp_path_factory):
    """A press fit, off the middle, that presses everywhere and whose cup slips at places."""
    folder = tmp_path_factory.mktemp("p")
    pressure = np.geomspace(1e4, 1e9, 60)
    np.savetxt(folder / "k.csv", np.transpose([pressure, 1e14 * (pressure / 1e7)**0.5]), delimiter=",", header="pressure_pa,k_n_pa_per_m", comments="")
    return solve(exe, folder / "p", "data/cd14.nml", "load.torque=24", "load.torque_steps=3", "load.support=bearing",
                 "wave_generator.eccentricity=2e-6", "contact.friction=0.1", "joint.model=table", f"joint.table_file={folder}/k.csv", "wave_generator.interference=6e-5",
                 "wave_generator.w=3e-5")


@pytest.fixture(scope="module")
def surface(exe, tmp_path_factory):
    """A surface of Eq. 1, and its heights."""
    out = tmp_path_factory.mktemp("s") / "s"
    done = call(exe, ROOT / "data/surface.nml", "surface.nx=128", "surface.ny=96", "--out", out, "-q")
    assert done.returncode == 0, done.stderr
    return ({p.stem: read_csv(p) for p in out.glob("*.csv")}, json.loads((out / "summary.json").read_text())), np.load(out / "heights.npy")


@pytest.fixture(scope="module")
def joint(tmp_path_factory):
    """Tables and record of `hdengine joint` on waves of random phase, isotropic, from 6 to 64 um, of which none yields."""
    folder, f = tmp_path_factory.mktemp("j"), np.hypot(*np.meshgrid(np.fft.fftfreq(64), np.fft.fftfreq(64)))
    phases = np.fft.fft2(np.random.default_rng(1).normal(size=f.shape))
    z = np.fft.ifft2(np.where((f > 0) & (f < 1 / 6), phases / abs(phases) * np.maximum(f, 1e-9)**-1.8, 0)).real
    z *= 0.005e-6 / np.sqrt(np.mean([(z - np.roll(z, 1, k))**2 for k in (0, 1)]) * 2)
    np.save(folder / "a.npy", z)
    assert cli.main(["joint", str(folder / "a.npy"), "--dx", "1e-6", "--model", "spectrum", "--pressure", "2e6,2e7,4e8", "--out", str(folder / "j")]) == 0
    return {p.stem: read_csv(p) for p in (folder / "j").glob("*.csv")}, json.loads((folder / "j/joint.json").read_text()), z


def last(table, step=None):
    """Rows of the last step."""
    return table[table["step"] == (table["step"].max() if step is None else step)]


def corners(rows, name):
    """(4, facets): low and high angle at the first end, high and low at the other."""
    return np.array([rows[f"{name}_{k}_pa"] for k in (1, 2, 3, 4)])


def test_places_of_facets(press):
    """facet, i_theta, i_z count; theta_rad, area_m2 and n are those of a cylinder cut evenly; the centre x_m, y_m, z_m lies on the cam's shape,
    and bent_n leans as a ring does that keeps its length: by 3/2 w sin 2 theta over r."""
    rows = last(press[0]["contact"])
    assert list(rows["facet"]) == list(range(1, AROUND * ALONG + 1))
    assert list(rows["i_theta"]) == [1 + k // ALONG for k in range(len(rows))] and list(rows["i_z"]) == [1 + k % ALONG for k in range(len(rows))]
    theta, scene = 2 * np.pi * (rows["i_theta"] - 0.5) / AROUND, press[1]["scene"]
    length, start, w = scene["geometry.band_length"], scene["geometry.band_start"], scene["wave_generator.w"]
    np.testing.assert_allclose(rows["theta_rad"], theta, rtol=1e-12)
    np.testing.assert_allclose(rows["area_m2"], 2 * np.pi * R * length / len(rows), rtol=1e-12)
    np.testing.assert_allclose([rows["n_x"], rows["n_y"], rows["n_z"]], [np.cos(theta), np.sin(theta), 0 * theta], atol=1e-12)
    rise = np.hypot(rows["x_m"], rows["y_m"])
    assert 2 * (rise * np.cos(2 * theta)).mean() == pytest.approx(w, rel=0.1) and abs(rise.mean() / np.cos(np.pi / AROUND) - R) < 6e-5
    turned = np.angle((rows["x_m"] + 1j * rows["y_m"]) * np.exp(-1j * theta))
    assert -2 * (turned * np.sin(2 * theta)).mean() == pytest.approx(0.5 * w / R, rel=0.2)
    assert abs(rows["z_m"] - start - length * (rows["i_z"] - 0.5) / ALONG).max() < w
    lean = rows["bent_n_y"] * np.cos(theta) - rows["bent_n_x"] * np.sin(theta)
    assert 2 * (lean * np.sin(2 * theta)).mean() == pytest.approx(1.5 * w / R, rel=0.1)
    np.testing.assert_allclose(rows["bent_n_x"]**2 + rows["bent_n_y"]**2 + rows["bent_n_z"]**2, 1, rtol=1e-12)


def test_corners_of_facets(press, drive):
    """pressure_1 to 4 and shear_1 to 4 are those of points that neighbours share; their mean is pressure_pa where all press; shear is that of
    traction_theta and z where it is even; slip, state and gap_m go with them."""
    rows, mu = last(press[0]["contact"]), last(press[0]["steps"])["friction"][0]
    p, q = (corners(rows, name).reshape(4, AROUND, ALONG) for name in ("pressure", "shear"))
    for x in (p, q):
        np.testing.assert_array_equal(x[1], np.roll(x[0], -1, axis=0))
        np.testing.assert_array_equal(x[2], np.roll(x[3], -1, axis=0))
        np.testing.assert_array_equal(x[3][:, :-1], x[0][:, 1:])
    p, q = p.reshape(4, -1), q.reshape(4, -1)
    inside = p.min(0) > 0
    np.testing.assert_allclose(rows["pressure_pa"][inside], p.mean(0)[inside], rtol=1e-9)
    assert (q <= mu * p * (1 + 1e-9)).all() and inside.sum() > AROUND
    shear = np.hypot(rows["traction_theta_pa"], rows["traction_z_pa"])
    assert (shear[inside] <= q.mean(0)[inside] * (1 + 1e-5)).all() and (shear[inside] > 0.9 * q.mean(0)[inside]).mean() > 0.7
    slips = (q >= mu * p * (1 - 1e-5)) & (p > 0)
    assert ((rows["state"] == 2) == slips.all(0)).all() and set(rows["state"]) == {1, 2} and abs(rows["gap_m"]).max() < 1e-12
    rows = last(drive[0]["contact"])
    p = corners(rows, "pressure")
    assert ((rows["state"] == 0) == (p == 0).all(0)).all() and (rows["gap_m"][(p == 0).all(0)] > 0).all() and 10 < (p == 0).all(0).sum() < 90


def test_sums_over_facets(press):
    """steps.csv is the sum of contact.csv: forces, areas, capacity, the middle fifth, an edge, the shares that slip, torque over rotation."""
    rows, steps = press[0]["contact"], press[0]["steps"]
    length = press[1]["scene"]["geometry.band_length"]
    for step in steps:
        f = rows[rows["step"] == step["step"]]
        p, q, a, mu = corners(f, "pressure"), corners(f, "shear"), f["area_m2"], step["friction"]
        force = (a * f["pressure_pa"]).sum()
        assert step["normal_force_n"] == pytest.approx(force) == step["facet_force_n"]
        assert step["friction_capacity_nm"] == pytest.approx(mu * force * R) and step["reaction_force_n"] == pytest.approx(force, rel=1e-6)
        assert step["friction_torque_nm"] == pytest.approx((a * f["traction_theta_pa"]).sum() * R, rel=1e-6, abs=1e-9)
        near = abs(np.sin(f["theta_rad"])) < np.sqrt(0.5) + 1e-9
        assert step["lobe_force_x_n"] == pytest.approx((a * f["pressure_pa"] * abs(np.cos(f["theta_rad"])))[near].sum(), rel=0.02)
        points = np.broadcast_to(a / 4, p.shape)
        assert step["contact_area_m2"] == pytest.approx(points[p > 0].sum(), rel=1e-9)
        slips = (q >= mu * p * (1 - 1e-5)) & (p > 0)
        assert step["slip_share_area"] == pytest.approx(points[slips].sum() / points[p > 0].sum(), rel=1e-6)
        whole, any_of = ((a * f["pressure_pa"])[some].sum() / force for some in (slips.all(0), slips.any(0)))
        assert whole <= step["slip_share_force"] + 1e-9 and step["slip_share_force"] <= any_of + 1e-9
        assert step["pressure_max_pa"] >= p.max() * (1 - 1e-9) and step["pressure_max_pa"] < 3 * p.max()
        grid = p.reshape(4, AROUND, ALONG)
        middle = [[grid[k, :, i] + part * (grid[m, :, i] - grid[k, :, i]) for k, m in ((0, 3), (1, 2))] for i, part in ((1, 0.8), (2, 0.2))]
        middle = np.mean(middle, axis=(0, 1))
        assert step["pressure_mid_mean_pa"] == pytest.approx(middle.mean(), rel=1e-6)
        assert step["pressure_mid_max_pa"] == pytest.approx(middle.max(), rel=1e-6)
        edges = 0.1 * length * np.array([grid[0, :, 0] + 0.2 * (grid[3, :, 0] - grid[0, :, 0]), grid[3, :, -1] + 0.2 * (grid[0, :, -1] - grid[3, :, -1])])
        assert step["edge_line_load_n_per_m"] >= 0.999 * edges.max() and step["edge_line_load_n_per_m"] < 2 * edges.max()
        if step["phase"] == "torque":
            assert step["k_fe_secant_nm_per_rad"] == pytest.approx(step["torque_nm"] / step["rotation_rad"])
        else:
            assert np.isnan(step["k_fe_secant_nm_per_rad"])
    assert list(steps["phase"]).count("torque") == 3 and list(steps["load_factor"][-3:]) == pytest.approx([1 / 3, 2 / 3, 1])
    assert list(steps["step"]) == list(range(1, len(steps) + 1)) and list(steps["torque_nm"][-3:]) == pytest.approx([8, 16, 24])
    assert 0 < steps["slip_share_force"][-1] < 1


def test_stiffness_of_facets(press):
    """k_n_n_per_m is the area times the power law of the table at the corners' pressures, k_t_n_per_m that of the pressure
    less shear over friction, by the ratio of elastic bodies (Ciavarella); slip_share_k_ts lies between the shares of facets that slip wholly and at places."""
    rows, step, scene = last(press[0]["contact"]), press[0]["steps"][-1], press[1]["scene"]
    p, q = corners(rows, "pressure"), corners(rows, "shear")
    k_n = 1e14 * (p / 1e7)**0.5
    np.testing.assert_allclose(rows["k_n_n_per_m"], rows["area_m2"] * k_n.mean(0), rtol=1e-3)
    e, nu = ([scene[f"material.{body}_{name}"] for body in ("flexspline", "ring")] for name in ("e", "nu"))
    ratio = sum((1 - n**2) / x for x, n in zip(e, nu)) / sum((2 - n) * (1 + n) / (2 * x) for x, n in zip(e, nu))
    left = np.maximum(1 - q / (step["friction"] * p), 0)
    np.testing.assert_allclose(rows["k_t_n_per_m"], rows["area_m2"] * (ratio * k_n * left**0.5).mean(0), rtol=1e-3)
    slips = q >= step["friction"] * p * (1 - 1e-5)

    def stiffness(some):
        normal = np.transpose([rows["bent_n_x"], rows["bent_n_y"], rows["bent_n_z"]])
        place = np.transpose([rows["x_m"], rows["y_m"], rows["z_m"]])
        return float(np.sum(torsional_stiffness(rows["k_n_n_per_m"] * some, rows["k_t_n_per_m"] * some, place, normal)))
    assert step["k_ts_nm_per_rad"] == pytest.approx(stiffness(1), rel=1e-9)
    assert stiffness(slips.all(0)) <= step["slip_share_k_ts"] * stiffness(1) <= stiffness(slips.any(0))


@pytest.mark.parametrize("friction", [0.1, 5])
def test_stiffness_of_the_contact_alone(exe, tmp_path, press, friction):
    """k_ts_contact_nm_per_rad is the sum of area r^2 over points that stick, along their shear at its stiffness under it where that grows, else and across
    it without, and over those that slip across it alone, by the power law of the table. Directions are those of the facets."""
    keys = [f"{key}={press[1]['scene'][key]}" for key in ("load.torque", "load.support", "wave_generator.eccentricity", "joint.model", "joint.table_file",
                                                          "wave_generator.interference", "wave_generator.w")]
    tables, summary = solve(exe, tmp_path / "k", "data/cd14.nml", *keys, f"contact.friction={friction}", "load.torque_steps=3")
    rows, step = last(tables["contact"]), tables["steps"][-1]
    p, q = corners(rows, "pressure"), corners(rows, "shear")
    e, nu = ([summary["scene"][f"material.{body}_{name}"] for body in ("flexspline", "ring")] for name in ("e", "nu"))
    free = sum((1 - n**2) / x for x, n in zip(e, nu)) / sum((2 - n) * (1 + n) / (2 * x) for x, n in zip(e, nu)) * 1e14 * (p / 1e7)**0.5
    sticks, slope = q < friction * p * (1 - 1e-5), np.sqrt(np.maximum(1 - q / (friction * p), 0))
    along = rows["traction_theta_pa"]**2 / (rows["traction_theta_pa"]**2 + rows["traction_z_pa"]**2)
    assert sticks.all() == (friction > 1) and (0 < step["slip_share_area"] < 1) == (friction < 1)
    low, high = (R**2 * (rows["area_m2"] / 4 * free * (along * sticks * part + 1 - along)).sum() for part in (slope, 1))
    share = (step["k_ts_contact_nm_per_rad"] - low) / (high - low)   # the torque of a bearing drives nearly all points on where its friction is little
    assert high < 1.07 * low and (-0.05 < share < 0.4 if friction < 1 else 0 < share < 1)


def test_places_of_balls_and_teeth(drive):
    """Ball counts from the cage's angle, tooth and theta_rad lie a pitch apart round both ends of the long axis; share is force over all."""
    tables, _ = drive
    b, t = last(tables["balls"]), last(tables["teeth"])
    assert list(b["ball"]) == list(range(1, BALLS + 1))
    np.testing.assert_allclose(b["theta_rad"], np.radians(3) + 2 * np.pi * np.arange(BALLS) / BALLS, rtol=1e-12)
    half = (np.arange(PAIRS // 2) - (PAIRS / 2 - 1) / 2) * 2 * np.pi / 200
    assert list(t["tooth"]) == list(np.repeat(np.arange(1, PAIRS + 1), 2)) and list(t["flank"]) == [1, -1] * PAIRS
    np.testing.assert_allclose(t["theta_rad"][::2], np.arctan2(*[f(np.concatenate([half, half + np.pi])) for f in (np.sin, np.cos)]), atol=1e-12)
    for rows in (last(tables["balls"], 6), last(tables["teeth"], tables["teeth"]["step"].min() + 3)):
        np.testing.assert_allclose(rows["share"], rows["force_n"] / rows["force_n"].sum(), rtol=1e-12)


def test_loop_is_that_of_its_tables(drive):
    """loop.csv counts what balls.csv and teeth.csv hold; shares of the twist stand in the reference step, the last, and sum to 1."""
    tables, summary = drive
    rounding = 1e-6 * tables["teeth"]["force_n"].max()
    for row, step in zip(tables["loop"], tables["steps"]):
        b = last(tables["balls"], row["step"])["force_n"]
        t = last(tables["teeth"], row["step"])["force_n"].reshape(-1, 2)
        t = np.where(t > rounding, t, 0)
        assert row["ball_force_max_n"] == b.max() and row["balls_loaded"] == (b > 0).sum()
        assert row["tooth_force_max_n"] == t.max(initial=0) and row["pairs_loaded"] == (t > 0).any(1).sum()
        assert all(row[name] == step[name] for name in ("k_ts_nm_per_rad", "torque_nm", "wave_generator_torque_nm"))
        shares = [row[f"share_{name}"] for name in ("cup", "ring", "balls", "teeth", "spline", "gaps", "slip", "joint")]
        assert np.isnan(shares).all() or sum(shares) == pytest.approx(1, abs=1e-9)
    assert sum(shares) == pytest.approx(1, abs=1e-9)
    r, loop = summary["results"], tables["loop"]
    torque, angle, top = loop["torque_nm"][3:], loop["angle_rad"][3:], loop["torque_nm"][3:].argmax()
    fall, rise = (np.interp([0.04 * 7.8, 0, -0.04 * 7.8], torque[part], angle[part]) for part in (slice(torque.argmin(), top - 1, -1), slice(torque.argmin(), None)))
    assert r["hysteresis_rad"] == pytest.approx(fall[1] - rise[1])
    # of the closed loop: the first rise, which begins in the middle of the play, is no part of it
    assert r["lost_motion_rad"] == pytest.approx((fall[0] + rise[0]) / 2 - (fall[2] + rise[2]) / 2)
    assert r["reference_torque_nm"] == loop["torque_nm"].max()
    assert {f"share_{part}": share for part, share in r["twist_shares"].items()} == {name: loop[-1][name] for name in loop.dtype.names if name.startswith("share_")}
    assert r["ball_force_max_n"] == loop["ball_force_max_n"].max() and r["tooth_force_max_n"] == loop["tooth_force_max_n"].max()
    assert r["wave_generator_torque_max_nm"] == abs(loop["wave_generator_torque_nm"]).max()
    assert r["loop_work_j"] == loop["work_j"][-1] and r["loop_stored_j"] == loop["stored_j"][-1]
    assert r["loop_dissipated_j"] == loop["dissipated_j"][-1] and r["loop_dissipated_teeth_j"] == loop["dissipated_teeth_j"][-1]


def test_turning_is_even(drive):
    """Position counts; wave_generator_deg goes evenly over the range. Seen from the cam 202 teeth of the spline go by in a turn, and the cage turns
    back as balls of 3.2 mm roll in a race of 16.5 mm while the cup turns by 1.01; the results are the extremes."""
    t, r = drive[0]["turning"], drive[1]["results"]
    assert list(t["position"]) == [1, 2, 3] and list(np.diff(t["wave_generator_deg"])) == pytest.approx([t["wave_generator_deg"][1]] * 2)
    turn = t["wave_generator_deg"]
    np.testing.assert_allclose(t["cage_angle_deg"], 3 - 1.01 * turn * 16.5 / (2 * 16.5 - 3.2), rtol=1e-9)
    np.testing.assert_allclose(t["tooth_phase"], -turn / 360 * 202 + np.round(turn / 360 * 202), atol=1e-9)
    assert r["turning_angle_error_rad"] == pytest.approx(np.ptp(t["turn_rad"]))
    assert (r["turning_stiffness_min_nm_per_rad"], r["turning_stiffness_max_nm_per_rad"]) == (t["stiffness_nm_per_rad"].min(), t["stiffness_nm_per_rad"].max())


def test_fatigue_is_a_line(drive):
    """Safety is that of Goodman's line through limit and strength by mean_pa and amplitude_pa; the node's place is on the cup's meridian."""
    f, scene = drive[0]["fatigue"], drive[1]["scene"]
    line = abs(f["amplitude_pa"]) * scene["fatigue.notch_factor"] / scene["fatigue.fatigue_limit"] + np.maximum(f["mean_pa"], 0) / scene["fatigue.tensile_strength"]
    np.testing.assert_allclose(f["safety"], 1 / line, rtol=1e-6)
    assert list(f["node"]) == list(range(1, len(f) + 1)) and drive[1]["results"]["goodman_safety_min"] == f["safety"].min()
    assert f["r_m"].min() == pytest.approx(scene["geometry.hub_radius"]) and f["z_m"].max() == pytest.approx(scene["geometry.cup_length"])


def test_history_counts(press):
    """Iterations count up to those of the step, points in all states to all points, and the last residual lies within the tolerance."""
    h, steps = press[0]["history"], press[0]["steps"]
    assert (h["open"] + h["stick"] + h["slip"] == AROUND * (ALONG + 1)).all() and (h["change"] >= 0).all() and (h["change"] <= AROUND * (ALONG + 1)).all()
    assert ((h["damping"] > 0) & (h["damping"] <= 1)).all() and (h["linear_error"] < 1e-3).all()
    for step in steps:
        rows = h[(h["step"] == step["step"]) & (h["attempt"] == 0)]
        assert list(rows["iteration"]) == list(range(len(rows))) and rows["iteration"][-1] == step["iterations"]
        assert rows["residual"][-1] < 1e-8 and len(set(h["attempt"])) == 1
    assert sum(steps["iterations"]) == press[1]["results"]["iterations"] and press[1]["results"]["steps"] == len(steps)


def test_results_are_the_last_step(press, drive):
    """Results are those of the last step, of a loop those of its reference step; safety is strength over stress."""
    for tables, summary in (press, drive):
        steps, r = tables["steps"], summary["results"]
        row = steps[-1] if summary["scene"]["load.support"] != "drive" else steps[np.flatnonzero(steps["torque_nm"] == steps["torque_nm"].max())[-1]]
        same = [name for name in steps.dtype.names if name in r and name != "iterations"]
        assert len(same) > 25
        for name in same:
            value = float("nan") if r[name] is None else r[name]
            assert value == pytest.approx(row[name], nan_ok=True, abs=1e-12), name
        assert r["flexspline_yield_safety"] == pytest.approx(summary["scene"]["material.yield_strength"] / r["flexspline_von_mises_max_pa"])
        assert summary["scene"]["material.ring_yield_strength"] / r["ring_yield_safety"] <= r["von_mises_max_pa"] * (1 + 1e-9)
        assert r["cut_backs"] == 0 <= r["cycles"] < r["steps"]


def test_numbers_of_the_joint_and_the_model(drive, press):
    """reduced_modulus_pa of both bodies, hardness_pa of 2.8 times the yield strength, s_min_m2 of the shortest wave; facets, multipliers, dof."""
    joint, model, scene = press[1]["joint"], press[1]["model"], press[1]["scene"]
    e = [(1 - scene[f"material.{body}_nu"]**2) / scene[f"material.{body}_e"] for body in ("flexspline", "ring")]
    assert joint["reduced_modulus_pa"] == pytest.approx(1 / sum(e)) and joint["hardness_pa"] == pytest.approx(2.8 * scene["material.yield_strength"])
    assert joint["s_min_m2"] == pytest.approx(np.pi * (scene["joint.shortest_wavelength"] / 2)**2)
    assert joint["asperity_radius_m"] == scene["joint.asperity_radius"]
    assert joint["reference_area_m2"] == pytest.approx(scene["joint.sample_length"]**2)
    assert model["facets"] == AROUND * ALONG and model["multipliers"] == AROUND * (ALONG + 1) == model["unknowns"] / 3 and model["dof"] % (3 * AROUND) == 0


def waves_of_eq_1():
    """The scene of the surface, wavenumbers over 2 pi and squared amplitudes of its waves."""
    scene = hdengine.read_scene(ROOT / "data/surface.nml")
    d, g, gamma, length = (scene[f"surface.{name}"] for name in ("fractal_dimension", "roughness", "gamma", "sample_length"))
    waves = gamma**np.arange(int(np.log(length / scene["surface.shortest_wavelength"]) / np.log(gamma) + 1e-9) + 1) / length
    square = np.log(gamma) * g**(2 * (d - 2)) * waves**(-2 * (3 - d))
    return scene, waves, square


def test_structure_of_heights(surface):
    """structure.csv and fit.csv: s_m2 is the mean square of differences at lag_points, lag_m, of rows and columns; s_expected_m2 that of Eq. 1,
    its waves summed; band_low_m2, band_high_m2 lie 1.96 sample_error_ln about model_m2, and s_m2 within the errors of the model."""
    (tables, summary), heights = surface
    scene, waves, square = waves_of_eq_1()
    band = np.array([1 / waves[-1], 1 / waves[0]]) * scene["surface.gamma"]**np.array([-0.5, 0.5])
    assert summary["fits"]["generated"]["band_m"] == pytest.approx(band)
    ridges = np.pi * np.arange(1, scene["surface.ridges"] + 1) / scene["surface.ridges"]
    for row in tables["structure"]:
        z = heights if row["direction"] == "columns" else heights.T
        n = int(row["lag_points"])
        assert row["s_m2"] == pytest.approx(((z[n:] - z[:-n])**2).mean(), rel=1e-9) and row["lag_m"] == pytest.approx(n * 1e-6)
        turn = np.sin(ridges) if row["direction"] == "columns" else np.cos(ridges)
        assert row["s_expected_m2"] == pytest.approx((square[:, None] * (1 - np.cos(2 * np.pi * waves[:, None] * n * 1e-6 * turn))).sum() / len(ridges), rel=1e-6)
    fit = tables["fit"]
    for row in fit[:5]:
        n = round(row["lag_m"] / 1e-6)
        assert row["s_m2"] == pytest.approx(np.mean([((z[n:] - z[:-n])**2).mean() for z in (heights, heights.T)]), rel=0.02)
    np.testing.assert_allclose(np.log(fit["band_high_m2"] / fit["model_m2"]), 1.96 * fit["sample_error_ln"], rtol=1e-3)
    np.testing.assert_allclose(fit["band_high_m2"] * fit["band_low_m2"], fit["model_m2"]**2, rtol=1e-9)
    assert (abs(np.log(fit["s_m2"] / fit["model_m2"])) < 3 * np.hypot(fit["sample_error_ln"], fit["model_error_ln"])).mean() > 0.9


def test_spectrum_of_a_map(joint):
    """q_per_m, height_variance_m2, c_m4 and waves_per_m2 add up to the variance of heights and slopes, to the plane of wave vectors, to the waves of
    a quarter circle of the mirrored map."""
    (tables, record, z), dx = joint, 1e-6
    q, h = tables["spectrum"]["q_per_m"], tables["spectrum"]["height_variance_m2"]
    assert h.sum() == pytest.approx(z.var(), rel=0.05) and record["h_rms_m"] == pytest.approx(np.sqrt(h.sum()), rel=1e-6)
    assert record["slope_rms"] == pytest.approx(np.sqrt((q**2 * h).sum()), rel=1e-6) and record["slope_rms"] == pytest.approx(0.005, rel=0.1)
    np.testing.assert_allclose(tables["spectrum"]["waves_per_m2"].sum() * (64 * dx)**2, np.pi / 4 * 64**2, rtol=0.02)
    np.testing.assert_allclose((h / tables["spectrum"]["c_m4"]).sum(), np.pi * (np.pi / dx)**2, rtol=0.02)


def test_joint_is_that_of_its_spectrum(joint):
    """k_n_pa_per_m, contact_area_fraction, pressure_spread_pa, closure_m and mean_gap_m are those of Persson's theory, by another integrator, from the
    bands of spectrum.csv; closure and gap are the integrals of dP/k_N from no load and to full contact. Shear goes with the ratio of elastic bodies."""
    (tables, record, _), scene = joint, hdengine.read_scene(ROOT / "data/cd14.nml")
    table, q, h = tables["joint"], *(tables["spectrum"][name] for name in ("q_per_m", "height_variance_m2"))
    e, nu = ([scene[f"material.{body}_{name}"] for body in ("flexspline", "ring")] for name in ("e", "nu"))
    soft = sum((1 - n**2) / x for x, n in zip(e, nu))
    assert 1 / soft == pytest.approx(record["e_star_pa"]) and record["hardness_pa"] == pytest.approx(2.8 * scene["material.yield_strength"])
    assert record["k_t_over_k_n"] == pytest.approx(soft / sum((2 - n) * (1 + n) / (2 * x) for x, n in zip(e, nu)))
    p = np.unique(np.concatenate([table["pressure_pa"], np.geomspace(1.1e3, 1.1e9, 420)]))
    width = (h @ q)**2 / h.sum() / (h @ q**2)
    v, spread, share, energy = 0.0, np.full(len(p), 1e-99), np.ones(len(p)), 0.0
    for x, part in zip(np.repeat(q, 40), np.repeat(h / 40, 40)):
        more = (x / soft / 2)**2 * part
        v, spread = v + more, spread + more * np.where(v < p**2 / 50, 1, (5 - 2 * share**2 + 6 * share**4) / 9)
        next_share = np.vectorize(erf)(p / np.sqrt(2 * spread))
        mean, a = (share + next_share) / 2, 0.35 + 0.15 * width**9
        energy, share = energy + x / soft / 4 * part * mean * (a * mean**0.17 + (1 - a) * mean**3.15), next_share
    k_n = p / np.gradient(energy, p)  # at first touch as P**0.83
    way = p[0] / k_n[0] / 0.17 + np.concatenate([[0], np.cumsum(np.diff(p) * (1 / k_n[1:] + 1 / k_n[:-1]) / 2)])
    at = np.searchsorted(p, table["pressure_pa"])
    for name, found, within in (("k_n_pa_per_m", k_n, 0.02), ("contact_area_fraction", share, 0.002), ("pressure_spread_pa", spread**0.5, 0.002),
                                ("closure_m", way, 0.02), ("mean_gap_m", way[-1] - way, 0.02)):
        np.testing.assert_allclose(table[name], found[at], rtol=within, err_msg=name)
    np.testing.assert_allclose(table["k_t_pa_per_m"], record["k_t_over_k_n"] * table["k_n_pa_per_m"], rtol=1e-9)


def test_bands_of_the_joint(joint):
    """_low and _high of the stiffnesses are the root of the squares of the parts that the record names, and of what longer waves take; closure and
    gap, which go with 1/k_N, take them the other way round. Contact takes no part of longer waves, and less of E*: it does not go with it."""
    (tables, record, _) = joint
    table, parts = tables["joint"], {name: [np.array(part[end]) for end in ("low", "high")] for name, part in record["band_half_widths_ln_k_n"].items()}
    low, high = (np.sqrt(sum(part[k]**2 for name, part in parts.items() if name != "longer waves")) for k in (0, 1))
    low = low + parts.get("longer waves", [0])[0]
    for ends, down, up in ((("k_n_pa_per_m_low", "k_n_pa_per_m_high"), low, high), (("k_t_pa_per_m_low", "k_t_pa_per_m_high"), low, high),
                           (("closure_m_low", "closure_m_high"), high, low), (("mean_gap_m_low", "mean_gap_m_high"), high, low)):
        np.testing.assert_allclose([np.log(table[end] / table[end.rsplit("_", 1)[0]]) for end in ends], [-down, up], rtol=1e-6)
    for end in ("contact_area_fraction_low", "contact_area_fraction_high"):
        wide = abs(np.log(table[end] / table["contact_area_fraction"]))
        assert (((wide > parts["law"][0]) & (wide < 1.05 * high)) | (table[end] == 1)).all() and wide[0] > 0, (wide, parts["law"], high)


def test_numbers_of_heights(surface):
    """Results and roughness of a surface by numpy: sa_m, sq_m, sz_m, ssk, sku, sdq and nayak of its levelled heights, height_rms_m, height_min_m and
    height_max_m of the heights as they are; height_rms_expected_m and slope_rms_expected are half the squares of the waves of Eq. 1, and of their slopes."""
    (_, summary), heights = surface
    y, x = np.indices(heights.shape)
    plane = np.stack([np.ones(heights.size), x.ravel(), y.ravel()], axis=1)
    z = heights - (plane @ np.linalg.lstsq(plane, heights.ravel(), rcond=None)[0]).reshape(heights.shape)
    numbers, step, r = dict(summary["fits"]["generated"]["roughness"]), 1e-6, summary["results"]
    rows, columns = (np.mean(np.diff(z, axis=k)**2) for k in (1, 0))
    wanted = {"sa_m": abs(z).mean(), "sq_m": z.std(), "sz_m": np.ptp(z), "ssk": (z**3).mean() / z.std()**3, "sku": (z**4).mean() / z.std()**4,
              "sdq": np.sqrt(rows + columns) / step, "nayak": z.var() * np.mean(np.diff(z, 2, axis=1)**2) / rows**2}
    assert numbers.pop("bandwidth_m") == pytest.approx([2e-6, 95e-6]) and numbers == pytest.approx(wanted, rel=1e-9) and abs(wanted["ssk"]) > 0.2
    assert (r["height_min_m"], r["height_max_m"]) == (heights.min(), heights.max()) and r["height_rms_m"] == pytest.approx(heights.std())
    _, waves, square = waves_of_eq_1()
    assert r["height_rms_expected_m"] == pytest.approx(np.sqrt(square.sum() / 2))
    assert r["slope_rms_expected"] == pytest.approx(np.sqrt((square / 2 * (2 * np.pi * waves)**2).sum()))


# Columns that no formula above holds, and the test that does.
HELD = {(table, name): held for held, names in {
    "test_balance.py::test_lateral_forces_balance": "steps hub_force_x_n hub_force_y_n lateral_balance_x_n lateral_balance_y_n",
    "test_drive.py::test_balls_follow_hertz": "balls closing_m",
    "test_loose_drives.py::test_balls_hold_the_ring_along_the_axis": "balls axial_force_n",
    "test_drive.py::test_flanks_follow_their_law": "teeth closing_m",
    "test_drive.py::test_torque_balances": "steps torque_balance_nm",
    "test_drive.py::test_bonded_on_a_rigid_cam_is_k_fts": "loop angle_rad",
    "test_joint_law.py::test_shear_follows_the_partial_slip_of_the_asperities": "contact slip_theta_m slip_z_m",
    "test_load_path.py::test_a_ring_on_balls_leaves_the_torque_to_the_hub": "steps hub_torque_nm",
    "test_load_path.py::test_springs_of_the_ring_count": "steps ring_spring_torque_nm",
    "test_loose_drives.py::test_checks_of_random_drives_can_fail": "teeth moment_nm",
    "test_premises.py::test_tangent_is_the_slope_of_the_coupled_run": "steps k_ts_bonded_nm_per_rad k_ts_secant_nm_per_rad",
    "test_run.py::test_forces_balance": "steps axial_balance_n",
    "test_tooth_friction.py::test_flanks_rub_by_coulomb": "teeth friction_n",
    "test_torsion.py::test_engine_and_python_give_one_k_ts": "steps k_ts_paper_n",
}.items() for table, names in [names.split(" ", 1)] for name in names.split()}
MEASURED = {"seconds"}  # times


def words(source):
    """Words of a test as patterns; what an f-string leaves open is any word."""
    found = set()
    tree = ast.parse(source)
    told = {id(node.body[0].value) for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and isinstance(node.body[0], ast.Expr)}
    for node in ast.walk(tree):
        if id(node) in told:
            continue   # a docstring
        if isinstance(node, ast.JoinedStr) and sum(len(part.value) for part in node.values if isinstance(part, ast.Constant)) > 5:
            found.add("".join(re.escape(part.value) if isinstance(part, ast.Constant) else r"\w+" for part in node.values))
        elif isinstance(node, ast.Constant) and not isinstance(node, ast.JoinedStr) and isinstance(node.value, str):
            found.update(map(re.escape, re.findall(r"\w+", node.value)))
    return found


@functools.cache
def source_of(name):
    """Text of a test, FILE::TEST, with the helpers and constants of its file that it names."""
    path, test = name.split("::")
    text = (ROOT / "tests/python" / path).read_text()
    parts = {word.id if isinstance(word, ast.Name) else word.name: node for node in ast.parse(text).body
             for word in (ast.walk(node) if isinstance(node, ast.Assign) else [node])
             if isinstance(word, ast.FunctionDef) or isinstance(word, ast.Name) and isinstance(word.ctx, ast.Store)}
    assert test in parts, f"{name} is no test"
    own = ast.get_source_segment(text, parts[test])
    return "\n".join([own, *(ast.get_source_segment(text, node) for word, node in parts.items() if word != test and re.search(rf"\b{word}\b", own))])


def test_every_column_is_held(press, drive, surface, joint):
    """Each column is named by a test of this file or by the one that HELD gives it, which names it too; HELD names none that is not there."""
    text = (ROOT / "tests/python/test_columns.py").read_text().split("# Columns that no formula")[0]
    here = words(text) | {rf"{name}_[1-4]_pa" for name in ("pressure", "shear")}
    columns = {(name, column) for tables, *_ in (press, drive, surface[0], joint) for name, table in tables.items() for column in table.dtype.names}
    for table, column in sorted(columns):
        if column in MEASURED or (table, column) not in HELD and any(re.fullmatch(word, column) for word in here):
            continue
        assert (table, column) in HELD, f"no test holds {column} of {table}"
        assert any(re.fullmatch(word, column) for word in words(source_of(HELD[table, column]))), f"{HELD[table, column]} does not name {column}"
    assert set(HELD) <= columns
