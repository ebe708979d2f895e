# SPDX-License-Identifier: GPL-3.0-or-later
"""The band of a whole drive by the tolerances of its inputs (run.band)."""
import json
import re
import signal
import subprocess
import sys

import numpy as np
import pytest

import hdengine
from conftest import ROOT, call, solved
from hdengine.report import write_report
from hdengine.views.labels import LOOP

MESH = ["mesh.divisions=24", "mesh.band_facets=4", "load.torque_steps=2", "output.vtu=none"]  # coarse runs keep it
ALONE = "run.tolerances=" + ",".join(f"load.{key}=0" for key in ("spline", "spline_width", "tooth_gaps", "tooth_stiffness")) + ",bearing.clearance=0"
KEYS = ("k1_nm_per_rad", "k2_nm_per_rad", "k3_nm_per_rad", "hysteresis_rad", "lost_motion_rad", "k_ts_bonded_nm_per_rad",
        "k_ts_contact_nm_per_rad")


def solve(exe, folder, *keys):
    """Results of size 14 on a small mesh."""
    return solved(exe, folder, ROOT / "data/drive14.nml", *MESH, *keys).summary["results"]


@pytest.fixture(scope="module")
def folder(exe, tmp_path_factory):
    out = tmp_path_factory.mktemp("band") / "a"
    solve(exe, out, "run.band=.true.")
    return out


@pytest.fixture(scope="module")
def banded(folder):
    return json.loads((folder / "summary.json").read_text())["results"]


@pytest.fixture(scope="module")
def quick(exe, tmp_path_factory):
    """Results whose band comes from derivatives and few runs, as by default."""
    return solve(exe, tmp_path_factory.mktemp("quick") / "a")


def test_band_holds_its_value(banded):
    """Every result that has a band lies in it; the shares of the inputs add up to 1, the largest first."""
    for key in KEYS:
        assert 0 < banded[key + "_low"] < banded[key] < banded[key + "_high"], key
    shares = list(banded["band_shares"].values())
    assert sum(shares) == pytest.approx(1, abs=1e-12) and shares == sorted(shares, reverse=True) and min(shares) >= 0


def of_its_loop(row):
    """What a row holds of results of the loop."""
    return {name: row[name] for name in LOOP if name in row}


def test_a_study_has_the_results_of_the_loop(exe, tmp_path):
    """The last row of a point holds K1 to K3, hysteresis, lost motion and their bands, energies and forces as the summary of that run, and as the
    rows of its result; safety of the cup is not computed without a folder."""
    few = ("bearing.balls=0", "load.spline=rigid", "run.tolerances=" + ",".join(f"{key}=0" for key in [*RELATIVE][:8]))   # inputs, and so runs
    words, folder = (*MESH, "run.band=.true.", *few), tmp_path / "r"
    keys, of_loop = {k: int(v) if v.isdigit() else v for k, v in (word.split("=", 1) for word in words)}, of_its_loop(solve(exe, folder, *words))
    found = hdengine.Study(ROOT / "data/drive14.nml", fixed=keys).run(tmp_path / "s", show=False).rows
    del of_loop["goodman_safety_min"]
    assert set(KEYS[:5]) | {key + end for key in KEYS for end in ("_low", "_high")} < set(of_loop) and not of_its_loop(found[0])
    assert of_its_loop(found[-1]) == of_loop and of_its_loop(hdengine.load(folder).rows()[-1]).items() >= of_loop.items()


def variance(change):
    """What changes of ln K2 at the ends of an input add upwards and downwards, squared."""
    return max(0.0, *change) ** 2 + max(0.0, *(-c for c in change)) ** 2


def of_input(banded, key):
    """The same by the band and the share of the input."""
    whole = sum(np.log(banded["k2_nm_per_rad_" + end] / banded["k2_nm_per_rad"]) ** 2 for end in ("low", "high"))
    return whole * banded["band_shares"][key]


RELATIVE = {"geometry.wall_thickness": 0.1, "geometry.rim_thickness": 0.1, "geometry.cup_length": 0.1, "geometry.bottom_thickness": 0.3,
            "geometry.hub_radius": 0.05, "geometry.ring_thickness": 0.1, "geometry.band_length": 0.1, "wave_generator.w": 0.03,
            "wave_generator.clearance": 0.79, "load.tooth_stiffness": 0.3, "load.spline_root_diameter": 0.005, "load.spline_width": 0.33, "bearing.ball_diameter": 0.1, "bearing.clearance": 1}
WIDTHS = {"contact.friction": 0.05, "load.pressure_angle_deg": 3, "bearing.inner_conformity": 0.005, "bearing.outer_conformity": 0.005}


def test_band_is_that_of_runs_at_the_ends(exe, banded, tmp_path):
    """Ends _low and _high of K1 to K3, hysteresis, lost motion and both K_TS, and all band_shares, from a run with each input at either end of its
    tolerance; the gaps of both flanks move by 1 um and stay at 0 or above."""
    scene = hdengine.read_scene(ROOT / "data/drive14.nml")
    ends = {key: [[f"{key}={scene[key] * (1 + sign * share)}"] for sign in (-1, 1)] for key, share in RELATIVE.items()}
    ends |= {key: [[f"{key}={scene[key] + sign * width}"] for sign in (-1, 1)] for key, width in WIDTHS.items()}
    gaps = [{key: [max(0, g + shift) for g in scene[key]] for key in ("load.tooth_gaps", "load.tooth_gaps_back")} for shift in (-1e-6, 1e-6)]
    ends |= {"load.spline": [["load.spline=rigid"]], "load.tooth_gaps": [[f"{key}={','.join(map(str, g))}" for key, g in end.items()] for end in gaps]}
    up, down = ({} for _ in range(2))
    for key, words in ends.items():
        found = [solve(exe, tmp_path / "r", *word, "run.band=.false.") for word in words]
        change = np.array([[np.log((r[name] or banded[name]) / banded[name]) for name in KEYS] for r in found] + [[0.0] * len(KEYS)])
        up[key], down[key] = change.max(axis=0), -change.min(axis=0)
    high, low = (np.linalg.norm(list(side.values()), axis=0) for side in (up, down))
    for i, name in enumerate(KEYS):
        told = [np.log(banded[f"{name}_{end}"] / banded[name]) for end in ("low", "high")]
        assert told == pytest.approx([-low[i], high[i]], rel=1e-3), name
    part = {key: up[key][1]**2 + down[key][1]**2 for key in ends}
    assert banded["band_shares"] == pytest.approx({key: value / sum(part.values()) for key, value in part.items()}, rel=1e-2, abs=1e-5)


def test_a_hats_walls_have_a_tolerance(exe, tmp_path):
    """The thicknesses of all sections move together by a tenth, and what that adds to the variance of ln K2 is what runs say; no wall, rim or bottom
    of a hat had a part in its band."""
    def hat(name, *keys):
        return solved(exe, tmp_path / name, ROOT / "data/drive14_hat.nml", *MESH, "mesh.divisions=16", "mesh.band_facets=3", *keys).summary["results"]

    key, found = "cup.sections_thickness", hat("a", ALONE)
    walls = hdengine.read_scene(ROOT / "data/drive14_hat.nml")[key]
    ends = [hat("b", f"{key}={','.join(str(share * t) for t in walls)}", "run.band=.false.")["k2_nm_per_rad"] for share in (0.9, 1.1)]
    assert of_input(found, key) == pytest.approx(variance(np.log(np.array(ends) / found["k2_nm_per_rad"])), rel=0.1)  # of the fall


def test_band_leaves_the_run_as_it_is(exe, folder, banded, tmp_path):
    """Files, tables and results are those of a run without a band."""
    alone = solve(exe, tmp_path / "b", "run.band=.false.")
    assert {p.name for p in folder.iterdir()} == {p.name for p in (tmp_path / "b").iterdir()}
    for name in ("loop.csv", "balls.csv", "teeth.csv", "fatigue.csv", "contact.csv"):
        assert (folder / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    assert {k: banded[k] for k in alone if k != "seconds"} == {k: v for k, v in alone.items() if k != "seconds"}
    assert set(banded) - set(alone) == {k + end for k in KEYS for end in ("_low", "_high")} | {"band_shares"}


def test_stopped_band_is_found_by_a_resumed_run(exe, quick, tmp_path):
    """A signal ends the band in order; --resume solves no load step again and finds it; a complete run has nothing to do."""
    out = tmp_path / "c"
    keys = [exe, ROOT / "data/drive14.nml", *MESH, "--out", out]
    process = subprocess.Popen(keys, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert any(line.startswith("band ") and process.send_signal(signal.SIGTERM) is None for line in process.stdout)
    _, message = process.communicate()
    assert process.returncode == 7 and "before the band was found" in message
    before = json.loads((out / "summary.json").read_text())
    assert before["status"] == "interrupted" and not any(k.endswith("_low") for k in before["results"])
    done = call(*keys, "--resume")
    assert done.returncode == 0 and not re.search(r"^ *\d+ torque", done.stdout, re.M), done.stdout
    after = json.loads((out / "summary.json").read_text())["results"]
    assert {k: after[k] for k in after if k[-4:] in ("_low", "high")} == pytest.approx(
        {k: quick[k] for k in quick if k[-4:] in ("_low", "high")}, rel=1e-6)
    assert "nothing to do" in call(*keys, "--resume").stdout


def test_quick_band_is_that_of_all_runs(banded, quick):
    """By default small tolerances count by derivatives and loops end at the opposite torque: the ends of K1 to K3 are those of whole loops within 5 %,
    those of hysteresis and lost motion too to a tenth of the band."""
    for i, key in enumerate(KEYS[:5]):
        low, high = (np.log(banded[key + end] / banded[key]) for end in ("_low", "_high"))
        found = [np.log(quick[key + end] / quick[key]) for end in ("_low", "_high")]
        assert found == pytest.approx([low, high], abs=min(0.1 * (high - low), 0.05 if i < 3 else np.inf)), key
    assert not any(f"{key}_low" in quick for key in KEYS[5:]) and set(quick["band_shares"]) == set(banded["band_shares"])


def test_drives_drawn_by_the_tolerances_lie_in_the_band(exe, tmp_path):
    """Of 16 drives whose inputs are drawn, nine in ten have their K1 to K3 in the band; and they fill half of it at least."""
    small = [*MESH, "load.tangent_steps=none", "output.contact=last"]
    widths = {"wave_generator.clearance": 7.11e-6, "load.pressure_angle_deg": 3, "contact.friction": 0.05, "load.tooth_stiffness": 3.75e7,
              "geometry.rim_thickness": 4.27e-5, "geometry.ring_thickness": 1e-4, "geometry.cup_length": 2e-3, "geometry.band_length": 6e-4,
              "geometry.bottom_thickness": 1e-4, "geometry.hub_radius": 5.6e-4}
    scene = hdengine.read_scene(ROOT / "data/drive14.nml")
    draw = np.random.default_rng(57).standard_normal((16, len(widths) + 2)) / 1.96
    found = []
    for row in draw:
        keys = [f"{key}={max(1e-9, scene[key] + width * z)}" for (key, width), z in zip(widths.items(), row)]
        keys += [f"load.{key}=" + ",".join(str(max(0, g + 1e-6 * row[-1])) for g in scene[f"load.{key}"]) for key in ("tooth_gaps", "tooth_gaps_back")]
        keys += ["load.spline=rigid"] if row[-2] > 0.5 else []
        results = solved(exe, tmp_path / "s", ROOT / "data/drive14.nml", *small, *keys, "run.band=.false.").summary["results"]
        found.append([results[key] for key in KEYS[:3]])
    call(exe, ROOT / "data/drive14.nml", *small, "--out", tmp_path / "b", "-q")
    results = json.loads((tmp_path / "b/summary.json").read_text())["results"]
    low, high = (np.array([results[key + end] for key in KEYS[:3]]) for end in ("_low", "_high"))
    assert np.all(np.mean((low < found) & (found < high), axis=0) >= 0.9)
    assert np.all(np.ptp(np.log(found), axis=0) > 0.5 * np.log(high / low))


@pytest.mark.parametrize("key", ["load.tooth_friction=0.05", "loop.history=turned", "solver.time_limit_s=1e3"])
def test_quick_band_is_left_out_in_silence(exe, tmp_path, key):
    """A loop without derivatives has no band unless it is asked for, and no word of it; a time limit that is not met takes none away."""
    done = call(exe, ROOT / "data/drive14.nml", *MESH, key, "load.torque_steps=2", "--out", tmp_path / "f")
    assert done.returncode == 0 and "WARNING" not in done.stdout, done.stdout
    results = json.loads((tmp_path / "f/summary.json").read_text())["results"]
    assert ("k2_nm_per_rad_low" in results) == ("time_limit" in key)


def test_time_limit_ends_the_band(exe, tmp_path):
    """A limit that passes while the band is found stops the run; its load steps are kept."""
    solve(exe, tmp_path / "d", "run.band=.false.")
    seconds = json.loads((tmp_path / "d/summary.json").read_text())["timers_s"]["total"]
    done = call(exe, ROOT / "data/drive14.nml", *MESH, "run.band=.true.", f"solver.time_limit_s={3 * seconds}", "--out", tmp_path / "e")
    assert done.returncode == 7 and "stopped at a limit before the band was found" in done.stderr


@pytest.mark.parametrize("value", ["yes", "1", "true", "T", ".truely."])
def test_bad_values_are_refused(exe, tmp_path, value):
    """The key takes auto, .true. and .false. alone."""
    done = call(exe, ROOT / "data/drive14.nml", f"run.band={value}", "--out", tmp_path / "f")
    assert done.returncode != 0 and "'band' has no choice" in done.stderr and not (tmp_path / "f").exists()


def test_tolerances_of_ones_own(exe, banded, tmp_path):
    """run.tolerances takes the place of the stated ones: 1 um of the fit moves K2 by less, an input of width 0 has no share, one without a stated
    width gets a part; what is wrong is said."""
    own = solve(exe, tmp_path / "own", "run.tolerances=wave_generator.clearance=1 um, load.spline=0,geometry.band_start=0.1 mm")
    assert "load.spline" not in own["band_shares"] and own["band_shares"]["geometry.band_start"] > 0
    assert own["k2_nm_per_rad"] == banded["k2_nm_per_rad"]
    ends = [solve(exe, tmp_path / "r", f"wave_generator.clearance={9e-6 + step}", "run.band=.false.")["k2_nm_per_rad"] for step in (-1e-6, 1e-6)]
    assert of_input(own, "wave_generator.clearance") == pytest.approx(variance([np.log(k / own["k2_nm_per_rad"]) for k in ends]), rel=0.3)  # by slopes of the fall
    for wrong in ("contact.friction", "contact.frction=0.1", "contact.friction=-0.1", "mesh.edge_length=1e-3", "contact.friction=1 mm", "load.support=0"):
        done = call(exe, ROOT / "data/drive14.nml", f"run.tolerances={wrong}", "--out", tmp_path / "w")
        assert done.returncode == 2 and f"run.tolerances: '{wrong}'" in done.stderr and not (tmp_path / "w").exists(), wrong


def test_fit_crosses_zero(exe, tmp_path):
    """The tolerance of the fit is that of bore and bearing whatever the clearance: 7.1 um below 1 um there is an interference of 6.1 um, and a bearing
    with an interference has the same width."""
    for key, value in (("clearance", 1e-6), ("interference", 2e-6)):
        found = solve(exe, tmp_path / key, f"wave_generator.{key}={value}", ALONE)
        fits = [(value if key == "clearance" else -value) + side * 0.79 * 9e-6 for side in (-1, 1)]
        ends = [solve(exe, tmp_path / "r", f"wave_generator.{'clearance' if fit > 0 else 'interference'}={abs(fit)}", "run.band=.false.")["k2_nm_per_rad"]
                for fit in fits]
        part = variance([np.log(k / found["k2_nm_per_rad"]) for k in ends])
        assert of_input(found, f"wave_generator.{key}") == pytest.approx(part, rel=0.1), key  # of the fall


def test_balls_without_clearance_have_its_tolerance(exe, tmp_path):
    """The tolerance of the balls' clearance is that of the bearing whatever the value: 3.125 um at 0, where it had none."""
    found = solve(exe, tmp_path / "b", "bearing.clearance=0", ALONE.replace("bearing.clearance", "wave_generator.clearance"))
    ends = [solve(exe, tmp_path / "r", f"bearing.clearance={side * 3.125e-6}", "run.band=.false.")["k2_nm_per_rad"] for side in (-1, 1)]
    part = variance([np.log(k / found["k2_nm_per_rad"]) for k in ends])
    assert of_input(found, "bearing.clearance") == pytest.approx(part, rel=0.1)


def test_only_a_drive_has_a_band(exe, tmp_path):
    """Another support is refused."""
    done = call(exe, ROOT / "data/cd14.nml", "run.band=.true.", "--out", tmp_path / "g")
    assert done.returncode != 0 and "load.support = 'drive'" in done.stderr


def test_explain_shows_tolerances(exe):
    """Half width and source stand in the text of a key; a key without one says nothing."""
    assert "tolerance (95 %): +-0.05 (" in call(exe, "--explain", "contact.friction").stdout
    assert "tolerance" not in call(exe, "--explain", "geometry.rim_length").stdout


def test_report_gives_the_band(banded, folder, monkeypatch):
    """The report's headline gives the ends of K2, and the input that makes most of it first."""
    monkeypatch.setitem(sys.modules, "pyvista", None)
    page = write_report(folder).read_text()
    low, high = map(float, re.search(r">K2</td><td[^>]*>[\d.]+</td><td[^>]*>([\d.]+) to ([\d.]+)</td>", page).groups())
    assert [1e3 * low, 1e3 * high] == pytest.approx([banded["k2_nm_per_rad_low"], banded["k2_nm_per_rad_high"]], rel=0.01)
    line = page[page.index("The 95 % bands"):].split("</p>")[0]
    first, second = list(banded["band_shares"])[:2]
    assert 0 < line.index(first) < line.index(second)


def test_python_takes_a_truth_value():
    """True and False stand for .true. and .false.; a key that takes a number refuses them."""
    for value, text in ((True, ".true."), (False, ".false.")):
        assert hdengine.read_scene(ROOT / "data/drive14.nml", run__band=value)["run.band"] == text
    with pytest.raises(hdengine.InputError, match="is not a number"):
        hdengine.read_scene(contact__friction=True)


def test_an_assembly_alone_has_no_readings(exe, tmp_path):
    """Without torque there is neither K1 to K3 nor a band, and the log says so; what is left out of a drive is not its load path."""
    done = call(exe, ROOT / "data/drive14.nml", *MESH, "loop.torques=0,0", "--out", tmp_path / "a")
    assert "band      none" in done.stdout and "drive     no K1 to K3" in done.stdout and "quote" not in done.stdout
    summary = json.loads((tmp_path / "a/summary.json").read_text())
    assert "band_shares" not in summary["results"] and not any("load path" in line for line in summary["model_error"]["left_out"])
