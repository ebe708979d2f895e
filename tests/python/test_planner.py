# SPDX-License-Identifier: GPL-3.0-or-later
"""A stated tolerance: the plan is printed, the run says what it chose and why and how large its error is, and can be resumed."""
import csv
import json
import re

import numpy as np
import pytest

import hdengine
from conftest import CD14, ROOT, call, solved

NARROW = ["geometry.bore_radius=9e-3", "geometry.hub_radius=4e-3", "output.vtu=none"]  # few facets round the axis
PROMISED = ("k_ts_bonded_nm_per_rad", "rotation_rad", "normal_force_n", "pressure_mid_mean_pa", "pressure_mid_max_pa",
            "k_ts_tangent_steps_nm_per_rad", "pressure_field_pa")
QUICK = [*NARROW, "run.tolerance=0.3", "solver.kinematics=linear", "load.torque=1"]


def planned(folder):
    """Summary of a run, and its reasons in one text."""
    s = json.loads((folder / "summary.json").read_text())
    return s, "\n".join(s["plan"]["reasons"])


@pytest.fixture(scope="module")
def whole(exe, tmp_path_factory):
    """A planned run that was never stopped."""
    folder = tmp_path_factory.mktemp("planned") / "whole"
    done = call(exe, CD14, *QUICK, "--out", folder)
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def test_a_run_meets_its_tolerance_and_says_why(whole):
    """Element, kinematics, load steps, mesh and solver stand in log and summary with their reasons; all results that a contact has are promised."""
    s, reasons = planned(whole[0])
    assert s["status"] == "complete" and s["plan"]["met"] == "yes"
    assert max(v for k, v in s["plan"].items() if k.startswith("estimated")) <= 0.3
    for word in ("element hex8i", "Newton iterations to a residual of 3.0e-4", "kinematics linear", "load steps", "mesh", "solver condensed"):
        assert word in reasons and word in whole[1], word
    assert f"{s['scene']['mesh.divisions']} x " in reasons and s["scene"]["mesh.band_facets"] == 16
    assert s["model_error"]["tolerance_covers"] == list(PROMISED) and len(s["model_error"]["left_out"]) >= 5
    widths = {row.count(",") for row in (whole[0] / "plan.csv").read_text().splitlines()}
    assert widths == {6 + 17 + 64 + 3}  # mesh, six numbers, K_TS of up to 17 steps, 64 patches, seconds, stiffness of the balls, checksum
    assert all(f"limit     {words} " in whole[1] for words in ("tangent K_TS", "rotation", "normal force", "mid-band pressure"))


def test_limits_are_those_of_the_line_through_three_meshes(whole):
    """The straight line over rows^-3/2 through the last three meshes of plan.csv, by numpy, at 0."""
    table = list(csv.DictReader((whole[0] / "plan.csv").open()))
    steps = table[-1]["mesh"].split("_steps_")[1]
    meshes = {int(re.match(r"\d+x(\d+)_", row["mesh"]).group(1)): row for row in table if row["mesh"].endswith(f"_steps_{steps}")}
    table, rows = [meshes[n] for n in (8, 12, 16)], np.array([8.0, 12.0, 16.0])
    limits = hdengine.load(whole[0]).limits
    assert max(meshes) == 16 and list(limits) == list(PROMISED)
    at, field = (limits.pop(name) for name in PROMISED[-2:])
    q = np.array([[float(row[f"{PROMISED[-1]}_{i}"]) for i in range(64)] for row in table])
    np.testing.assert_allclose(field[0], np.where(q[-1] > 0, np.polyfit(rows**-1.5, q, 1)[1], 0), rtol=1e-7, atol=1)
    assert len(at[0]) == int(steps.split("_")[1]) + 1 and at[0][-1] == pytest.approx(limits[PROMISED[0]][0], rel=1e-12)
    assert at[1] >= limits[PROMISED[0]][1]
    for name, (limit, error, mesh_over_limit) in limits.items():
        q = np.array([float(row[name]) for row in table])
        assert limit == pytest.approx(np.polyfit(rows**-1.5, q, 1)[1], rel=1e-9)
        assert limit * mesh_over_limit == pytest.approx(q[-1], rel=1e-9)
        assert error >= abs(limit - q[-1]) / abs(limit)
    assert f"tangent K_TS {limits[PROMISED[0]][0]:.4g} N m/rad within" in repr(hdengine.load(whole[0]))


def test_a_drive_is_judged_by_three_meshes(exe, tmp_path):
    """A first rise at tolerance 0.05 ends on 8 rows: limits are those of the line through 4, 6 and 8, by numpy, known no better than to 1.5 % beside two fifths of the way, and the run is the trial."""
    solved(exe, tmp_path / "p", ROOT / "data/drive25.nml", "run.tolerance=0.05", "solver.kinematics=linear", "loop.torques=61", "run.band=.false.", "output.vtu=none")
    s, reasons = planned(tmp_path / "p")
    assert s["plan"]["met"] == "yes" and s["plan"]["level"] == 3 and s["scene"]["mesh.band_facets"] == 8, reasons
    meshes = {int(re.match(r"\d+x(\d+)_", row["mesh"])[1]): row for row in csv.DictReader((tmp_path / "p/plan.csv").open())
              if f"_steps_{s['scene']['load.assembly_steps']}_{s['scene']['load.torque_steps']}_" in row["mesh"] and "balls_0_" not in row["mesh"]}
    rows = np.array([4.0, 6.0, 8.0])
    for name in ("k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad"):
        q = [float(meshes[n][name]) for n in (4, 6, 8)]
        limit, error, _ = hdengine.load(tmp_path / "p").limits[name]
        assert limit == pytest.approx(np.polyfit(rows**-1.5, q, 1)[1], rel=1e-9)
        assert error > np.hypot(0.015, 0.4 * (q[2] / limit - 1))
        assert s["results"][name] == pytest.approx(q[2], rel=1e-12)


def test_the_coarsest_mesh_that_keeps_the_tolerance_is_run(exe, tmp_path):
    """Limits are known from 4, 6 and 8 rows, the run takes 4: its trial's K1 to K3 lie within the tolerance with the limits' errors. The rise is
    taken over, and the run is that of a run without a plan, to the bit. Ramps in long steps show the changes of K1 to K3 by large displacements that whole loops show, to 0.6 %."""
    keys = {"run.band": False, "output.vtu": "none"}
    found = hdengine.run(ROOT / "data/drive20_160.nml", tmp_path / "p", run__tolerance=0.06, **keys)
    table = list(csv.DictReader((tmp_path / "p/plan.csv").open()))
    meshes = {int(re.match(r"\d+x(\d+)_", row["mesh"])[1]): row for row in table if "_steps_3_3_" in row["mesh"] and "balls_21_" in row["mesh"]
              and "straight" not in row["mesh"]}
    assert sorted(meshes) == [4, 6, 8] and found.scene["mesh.band_facets"] == 4 and found.summary["plan"]["level"] == 1
    ways = {kind: next(row for row in table if f"_{kind}_" in row["mesh"] and "straight" in row["mesh"]) for kind in ("linear", "nonlinear")}
    whole = {kind: hdengine.run(found.folder / "echo.nml", tmp_path / kind, True, run__tolerance=0, solver__kinematics=kind, **keys) for kind in ways}
    for name in ("k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad"):
        limit, error, over = found.limits[name]
        assert limit * over == pytest.approx(found.summary["results"][name], rel=1e-9) and abs(over - 1) + error < 0.06
        assert found.summary["results"][name] == whole["linear"].summary["results"][name]
        change = [two.summary["results"][name] / one.summary["results"][name] for one, two in [whole.values()]]
        assert float(ways["nonlinear"][name]) / float(ways["linear"][name]) == pytest.approx(change[0], abs=6e-3)


def test_what_a_scene_does_not_have_is_not_promised(exe, tmp_path):
    """No pressure where the middle of the band is open, no rotation without a torque: no limit, no estimate, no word in the log."""
    done = call(exe, CD14, *NARROW, "run.tolerance=0.3", "solver.kinematics=linear", "wave_generator.clearance=30e-6",
                "load.torque_steps=0", "--out", tmp_path / "p")
    assert done.returncode == 0, done.stderr
    s, _ = planned(tmp_path / "p")
    assert s["results"]["pressure_mid_mean_pa"] == 0 and s["plan"]["level"] > 0
    assert s["model_error"]["tolerance_covers"] == ["k_ts_bonded_nm_per_rad", "normal_force_n", *PROMISED[-2:]] == list(
        hdengine.load(tmp_path / "p").limits)
    assert not any("mid_band" in key or "rotation" in key for key in s["plan"]) and "limit     mid-band" not in done.stdout
    assert any("nothing is promised of its pressure" in w for w in s["warnings"])


def test_patches_are_those_of_the_table_of_facets(whole):
    """Mean pressures of 16 x 4 equal patches from contact.csv, each facet shared out by its overlap, by numpy; they carry the force."""
    found = hdengine.load(whole[0])
    area, pressure, theta = (found.contact[n][-1].reshape(found.shape) for n in ("area_m2", "pressure_pa", "theta_rad"))
    z, n = np.append(0, np.cumsum(area[0])) / area[0].sum(), len(theta)
    turn = (np.arange(-n, 2 * n + 1) + 0.5) / n + theta[0, 0] / (2 * np.pi) - 1 / n
    force = np.add.accumulate(np.vstack([np.zeros(len(z) - 1), *([area * pressure] * 3)]))
    force = np.array([np.interp(np.arange(17) / 16, turn, column) for column in force.T])
    force = np.add.accumulate(np.vstack([np.zeros(17), force]))
    force = np.array([np.interp(np.arange(5) / 4, z, row) for row in force.T])
    ours = np.diff(np.diff(force, axis=0), axis=1) * 64 / area.sum()
    limit, _, over = (np.array(v) for v in found.limits["pressure_field_pa"])
    np.testing.assert_allclose((limit * over).reshape(16, 4), ours, rtol=1e-7, atol=1e-7 * ours.max())
    assert ours.sum() * area.sum() / 64 == pytest.approx(found.summary["results"]["facet_force_n"], rel=1e-9)
    peak = found.summary["results"]["pressure_mid_max_pa"]
    assert found.summary["results"]["pressure_mid_mean_pa"] < peak < found.summary["results"]["pressure_max_pa"]


def test_what_does_not_settle_is_left_out(exe, tmp_path):
    """K_TS after the assembly, where few points stick, at a tolerance below its estimated error: not promised, with the reason;
    that of the last step is."""
    solved(exe, tmp_path / "p", CD14, *NARROW, "run.tolerance=0.1", "solver.kinematics=linear")
    s, reasons = planned(tmp_path / "p")
    assert s["plan"]["met"] == "yes" and "not promised: K_TS of all steps where its estimated error is up to 1" in reasons
    k, error, _ = hdengine.load(tmp_path / "p").limits["k_ts_tangent_steps_nm_per_rad"]
    assert np.isnan(k[0]) and k[-1] == pytest.approx(s["plan"]["k_ts_bonded_nm_per_rad"]) and error <= 0.1


def test_k_fts_is_promised_against_the_teeth(exe, tmp_path):
    """A bonded ring has no K_TS: the limit of torque over rotation is promised, known as well as that of the rotation."""
    found = solved(exe, tmp_path / "p", ROOT / "data/teeth.nml", "geometry.bore_radius=5e-3", "geometry.hub_radius=2e-3",
                   "load.tooth_pairs=8", "geometry.cup_length=14e-3", "run.tolerance=0.2", "load.torque_steps=1", "output.vtu=none")
    assert list(found.limits) == ["rotation_rad", "k_fe_secant_nm_per_rad"] == found.summary["model_error"]["tolerance_covers"]
    k, error, over = found.limits["k_fe_secant_nm_per_rad"]
    assert k * over == pytest.approx(found.secant_stiffness()[-1], rel=1e-9) and error < 0.2


def test_a_finer_mesh_that_does_not_converge_ends_the_plan(exe, tmp_path):
    """Eighteen iterations from rest do for 16 rows, not for finer ones: the mesh before is run, and the run says that the tolerance is not met."""
    solved(exe, tmp_path / "p", CD14, *NARROW, "run.tolerance=0.01", "solver.kinematics=linear", "solver.start=rest", "solver.max_iterations=18",
           "solver.max_cuts=0", "load.torque=1")
    s, reasons = planned(tmp_path / "p")
    assert "the next mesh does not converge: this one is run" in reasons.splitlines()
    assert s["status"] == "complete" and s["plan"]["met"] == "no" and s["plan"]["level"] == 5
    assert s["scene"]["mesh.band_facets"] == 16
    assert any("the tolerance is not met: the estimated error of the tangent K_TS is" in w for w in s["warnings"])


def test_too_little_memory_ends_the_plan(exe, tmp_path):
    """The mesh that fits is run; the reason names the mesh that does not, what it needs and the limit."""
    solved(exe, tmp_path / "p", CD14, *NARROW, "run.tolerance=0.01", "load.torque=1", "mesh.memory_limit_mb=30")
    s, reasons = planned(tmp_path / "p")
    told = re.search(r"no finer mesh: \d+ x \d+ facets need about (\d+) MB, the limit is 30 MB \(mesh.memory_limit_mb\)", reasons)
    assert told and int(told[1]) >= 30 and s["plan"]["met"] == "no"


def test_given_mesh_does_not_bind_a_plan(exe, tmp_path):
    """A given mesh that no memory holds is no reason against a plan, which takes its own; its coarsest mesh may be one."""
    huge = "mesh.divisions=40000", "mesh.band_facets=2000"
    done = call(exe, CD14, *NARROW, *huge, "load.torque=1", "run.tolerance=0.5", "mesh.memory_limit_mb=100", "--out", tmp_path / "p")
    s, _ = planned(tmp_path / "p")
    assert done.returncode == 0 and s["plan"]["met"] == "yes" and s["scene"]["mesh.divisions"] < 1000
    done = call(exe, CD14, *NARROW, *huge, "load.torque=1", "run.tolerance=0.2", "mesh.memory_limit_mb=1", "--out", tmp_path / "q")
    assert done.returncode == 6 and "the coarsest mesh of a plan needs about" in done.stderr and not (tmp_path / "q").exists()


def test_plan_is_printed_and_nothing_is_written(exe, tmp_path):
    """--plan: choices with reasons, one line per mesh with facets, time and memory; without a tolerance code 2."""
    done = call(exe, "--plan", CD14, *QUICK, cwd=tmp_path)
    assert done.returncode == 0 and "<- start" in done.stdout and "load steps" in done.stdout and not list(tmp_path.iterdir())
    meshes = np.array([line.split()[:7] for line in done.stdout.splitlines() if re.match(r" +\d+ +\d+ +\d+ ", line)], float)
    assert len(meshes) > 4 and (np.diff(meshes[:, [1, 2]], axis=0) > 0).all() and meshes[-1, 4] > 10 * meshes[0, 4]
    assert (np.diff(meshes[:, 4:], axis=0) >= 0).all() and (meshes[-1, 4:] > meshes[0, 4:]).all()  # to a tenth of a second
    done = call(exe, "--plan", CD14)
    assert done.returncode == 2 and "--plan needs a tolerance" in done.stderr


def test_a_tolerance_that_no_mesh_can_promise_is_refused(exe, tmp_path):
    """Code 2 at once, with the least that can be promised, not a plan that refines until memory ends."""
    done = call(exe, CD14, "run.tolerance=1e-4", "--out", tmp_path / "r")
    assert done.returncode == 2 and "run.tolerance = 1.0e-4" in done.stderr and "0.0066" in done.stderr
    assert not (tmp_path / "r").exists()


def test_python_plans_as_the_program_does(whole, tmp_path):
    """run.tolerance through the bindings: the same mesh, estimate and force as hdengine.x."""
    one, _ = planned(whole[0])
    keys = dict(k.split("=") for k in QUICK)
    two = hdengine.run(CD14, out=tmp_path / "p", **{k.replace(".", "__"): v for k, v in keys.items()}).summary
    assert one["plan"]["met"] == two["plan"]["met"] == "yes"
    assert one["scene"]["mesh.divisions"] == two["scene"]["mesh.divisions"]
    assert two["results"]["normal_force_n"] == pytest.approx(one["results"]["normal_force_n"], rel=1e-9)


def test_a_stopped_plan_goes_on(exe, whole, tmp_path):
    """Stopped between coarse runs: --resume takes those from plan.csv, solves the others, and ends with the same results."""
    folder = tmp_path / "r"
    lines = (whole[0] / "plan.csv").read_text().splitlines()
    stopped = call(exe, CD14, *QUICK, "solver.time_limit_s=1e-3", "--out", folder)
    assert stopped.returncode == 7 and not (folder / "summary.json").exists()
    assert "stopped at a limit while planning before a run of the plan was done" in stopped.stderr
    printed = call(exe, "--plan", CD14, *QUICK, "solver.time_limit_s=1e-3")
    assert printed.returncode == 7 and "while planning" in printed.stderr and "resume" not in printed.stderr
    (folder / "plan.csv").write_text("\n".join(lines[:4]) + "\n")  # three runs were solved
    other = call(exe, CD14, *QUICK, "load.torque=4", "--out", folder, "--resume")
    assert other.returncode == 2 and "load.torque" in other.stderr
    done = call(exe, CD14, *QUICK, "--out", folder, "--resume")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("  trial ") == whole[1].count("  trial ") - 3
    one, two = (planned(f)[0] for f in (whole[0], folder))
    assert two["plan"].pop("reasons") == one["plan"].pop("reasons")
    for key, value in one["plan"].items():
        assert two["plan"][key] == (value if isinstance(value, str) else pytest.approx(value, rel=1e-7)), key
    assert two["results"]["normal_force_n"] == pytest.approx(one["results"]["normal_force_n"], rel=1e-7)
    again = call(exe, CD14, *QUICK, "--out", folder, "--resume")
    assert again.returncode == 0 and "nothing to do" in again.stdout


def test_a_stopped_planned_run_goes_on(exe, whole, tmp_path):
    """Left after a load step of the mesh that was chosen: --resume plans from plan.csv alone and goes on from the checkpoint."""
    folder = tmp_path / "r"
    keys = {k.replace(".", "__"): v for k, v in (k.split("=") for k in QUICK)}
    hdengine.forget()
    with hdengine.Run(CD14, folder, **keys) as run:
        run.advance()
    assert planned(folder)[0]["status"] == "stopped_at_limit"
    hdengine.forget()
    with hdengine.Run(CD14, folder, resume=True, **keys) as run:
        for _ in run:
            pass
    s, reasons = planned(folder)
    assert s["status"] == "complete" and s["model"]["resumed"] and s["plan"]["met"] == "yes" and "mesh" in reasons
    one = planned(whole[0])[0]
    assert s["results"]["normal_force_n"] == pytest.approx(one["results"]["normal_force_n"], rel=1e-7)


def test_an_unplanned_run_is_not_resumed_with_a_plan(exe, small_run):
    """A tolerance cannot be added to a run that began without: code 2, and what to do."""
    done = call(exe, CD14, *QUICK, "--out", small_run, "--resume")
    assert done.returncode == 2 and "was not planned" in done.stderr


def test_linear_where_that_is_enough(exe, tmp_path):
    """No word on kinematics: small displacements at w = 20 um, where large ones change 0.2 %; no mirror plane that a shift of
    1 nm takes away."""
    solved(exe, tmp_path / "p", CD14, *NARROW, "run.tolerance=0.3", "load.torque=1", "wave_generator.w=2e-5",
           "wave_generator.eccentricity=1e-9", "wave_generator.eccentricity_angle_deg=30")
    s, reasons = planned(tmp_path / "p")
    assert "kinematics linear: large displacements change" in reasons and s["scene"]["solver.kinematics"] == "linear"
    assert s["model"]["symmetry_assembly"] == "full" == s["model"]["symmetry_torque"]


def test_large_displacements_correct_limits(exe, tmp_path):
    """W = 0.3 mm at tolerance 0.03: what large displacements change on the mesh of 8 rows is the ratio of the limits to those of small
    ones, two meshes agree on it, and the run stays linear."""
    keys = [*NARROW, "run.tolerance=0.03", "run.wanted=rotation normal_force", "wave_generator.w=3e-4", "load.torque=1"]
    solved(exe, tmp_path / "p", CD14, *keys)
    s, reasons = planned(tmp_path / "p")
    assert s["scene"]["solver.kinematics"] == "linear" and "a correction known to" in reasons, reasons
    table = list(csv.DictReader((tmp_path / "p/plan.csv").open()))
    small, large = (next(row for row in table if "x8_" in row["mesh"] and kind in row["mesh"]) for kind in ("linear", "nonlinear"))
    limits, meshes = hdengine.load(tmp_path / "p").limits, {}
    steps = table[-1]["mesh"].split("_steps_")[1]
    for row in table:
        if row["mesh"].endswith(f"_steps_{steps}"):
            meshes[int(re.match(r"\d+x(\d+)_", row["mesh"])[1])] = row
    last = sorted(meshes)[-3:]
    for name in ("rotation_rad", "normal_force_n"):
        line = np.polyfit(np.array(last, float)**-1.5, [float(meshes[n][name]) for n in last], 1)[1]
        assert limits[name][0] == pytest.approx(line * float(large[name]) / float(small[name]), rel=1e-9)


def test_layers_correct_limits_below_three_per_cent(exe, tmp_path):
    """At tolerance 0.02 two layers are solved, and 1/0.65 of what four change on the coarse mesh is added: the rotation is nearer to that of
    four layers on the plan's own mesh than without, by half at least."""
    solved(exe, tmp_path / "p", CD14, *NARROW, "run.tolerance=0.02", "run.wanted=rotation", "solver.kinematics=linear", "load.torque=1")
    s, reasons = planned(tmp_path / "p")
    assert s["scene"]["mesh.through_wall"] == 2 and "layers 2: four change" in reasons
    mesh = [f"{k}={v}" for k, v in s["scene"].items() if k.startswith(("mesh.divisions", "mesh.band_facets", "mesh.edge_length", "load.assembly_steps", "load.torque"))]
    rotation = {}
    for layers in (2, 4):
        rotation[layers] = solved(exe, tmp_path / str(layers), CD14, *NARROW, *mesh, f"mesh.through_wall={layers}",
                                  f"mesh.through_ring={layers}").summary["results"]["rotation_rad"]
    table = list(csv.DictReader((tmp_path / "p/plan.csv").open()))
    two, four = (next(row for row in table if "x8_" in row["mesh"] and f"layers_{n}_{n}" in row["mesh"] and "steps_1_1_" in row["mesh"]) for n in (2, 4))
    gain = float(four["rotation_rad"]) / float(two["rotation_rad"])
    assert abs(gain - rotation[4] / rotation[2]) < 0.5 * abs(rotation[4] / rotation[2] - 1)
    limit, _, over = hdengine.load(tmp_path / "p").limits["rotation_rad"]
    assert limit * over == pytest.approx(rotation[2], rel=1e-5)


def test_trials_of_a_loop_end_with_its_first_rise(exe, tmp_path):
    """The limits of K1 to K3 are those of whole loops to 2 %, and the log says to quote them; a hysteresis is promised where it is wanted, by trials
    of whole loops."""
    keys = ["run.tolerance=0.3", "solver.kinematics=linear", "bearing.model=given", "output.vtu=none"]
    log = call(exe, ROOT / "data/drive14.nml", *keys, "--out", tmp_path / "a").stdout
    assert "quote     K1 to K3 by their limits below, with these 95 % bands in proportion, that of K2 made most by" in log
    rise = hdengine.load(tmp_path / "a")
    loop = solved(exe, tmp_path / "b", ROOT / "data/drive14.nml", *keys, "run.band=.false.", "run.wanted=k1 k2 k3 hysteresis")
    slopes = ["k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad"]
    assert list(rise.limits) == slopes and list(loop.limits) == [*slopes, "hysteresis_rad"]
    assert ["first rise" in " ".join(found.summary["plan"]["reasons"]) for found in (rise, loop)] == [True, False]
    for name in slopes:
        assert rise.limits[name][0] == pytest.approx(loop.limits[name][0], rel=0.02)


def test_only_what_is_wanted_is_refined_for(exe, whole, tmp_path):
    """run.wanted: the rotation alone ends on the first mesh that is judged, at a tolerance that the pressure field needs finer ones
    for; a name that is not promised is refused with those that are."""
    keys = [*NARROW, "run.tolerance=0.05", "solver.kinematics=linear"]
    solved(exe, tmp_path / "p", CD14, *keys, "run.wanted=rotation")
    s, reasons = planned(tmp_path / "p")
    assert s["plan"]["met"] == "yes" and "the estimated error of the rotation is" in reasons
    solved(exe, tmp_path / "q", CD14, *keys)
    assert planned(tmp_path / "q")[0]["plan"]["level"] > s["plan"]["level"]
    done = call(exe, CD14, *keys, "run.wanted=rotation k1", "--out", tmp_path / "r")
    assert done.returncode == 2 and "names 'k1'" in done.stderr and "normal_force" in done.stderr and not (tmp_path / "r").exists()


def test_without_a_tolerance_kinematics_stay_linear(small_run):
    """solver.kinematics = 'auto', the default, means small displacements where nothing is promised."""
    assert json.loads((small_run / "summary.json").read_text())["scene"]["solver.kinematics"] == "linear"


def test_where_coarse_runs_end_early_nothing_is_promised(exe, tmp_path):
    """From rest and with few iterations the planner's coarse runs do not converge: the scene is run as it stands, nothing is promised."""
    solved(exe, tmp_path / "p", CD14, *NARROW, "run.tolerance=0.1", "solver.kinematics=linear", "solver.start=rest", "solver.max_iterations=8",
           "solver.max_cuts=0", "contact.friction=0.05", "mesh.divisions=40", "mesh.band_facets=8")
    s, reasons = planned(tmp_path / "p")
    assert "a coarse run ended early: the scene is run as it stands" in reasons
    assert s["status"] == "complete" and s["plan"]["met"] == "no" and s["scene"]["mesh.band_facets"] == 8
    assert any("nothing is known of the error" in w for w in s["warnings"])


@pytest.mark.full
def test_cost_of_large_displacements_is_foretold(exe, tmp_path):
    """W = 0.3 mm at tolerance 0.05, large displacements asked for: the run ends at most one level beyond the marked one, time and memory of the run are within a factor of 2 of what --plan says for its level (time: 3, as other
    work shares the machine)."""
    keys = [*NARROW, "run.tolerance=0.05", "wave_generator.w=3e-4", "solver.kinematics=nonlinear"]
    plan = call(exe, "--plan", CD14, *keys)
    assert "kinematics nonlinear" in plan.stdout, plan.stderr
    start = int(re.search(r"^ +(\d+) .*<- start", plan.stdout, re.M)[1])
    solved(exe, tmp_path / "p", CD14, *keys)
    s, reasons = planned(tmp_path / "p")
    assert s["scene"]["solver.kinematics"] == "nonlinear" and "kinematics nonlinear" in reasons
    level = s["plan"]["level"]
    assert start <= level <= start + 1 and s["model"]["solver"].startswith("GMRES")
    foretold = re.search(rf"^ +{level} .*", plan.stdout, re.M)[0].split()
    seconds, memory = float(foretold[5]), float(foretold[7])
    assert 0.5 < s["peak_memory_mb"] / memory < 2
    assert 1 / 3 < s["timers_s"]["newton"] / seconds < 3


def test_a_planned_drive_turns_from_the_command_line_and_from_python(exe, tmp_path):
    """A plan chooses the mesh of a drive whose wave generator turns afterwards: both ways in write turning.csv, byte for byte."""
    words = ["run.tolerance=0.5", "loop.torques=2", "load.torque_steps=1", "bearing.model=given", "solver.kinematics=linear",
             "output.vtu=none", "turning.positions=2", "geometry.bore_radius=0.014", "bearing.balls=12", "load.tooth_pairs=8"]
    solved(exe, tmp_path / "app", ROOT / "tests/cases/pressed_drive.nml", *words)
    hdengine.run(ROOT / "tests/cases/pressed_drive.nml", tmp_path / "python", **dict(w.split("=") for w in words))
    app, python = ((tmp_path / x / "turning.csv").read_bytes() for x in ("app", "python"))
    assert app == python and len(app.splitlines()) == 3
