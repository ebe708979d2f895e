# SPDX-License-Identifier: GPL-3.0-or-later
"""The command hdengine: help with examples, plan, completion, sensitivity."""
import os
import re
import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import hdengine
from conftest import ROOT, call

sys.path.insert(0, str(ROOT / "tools"))
from hdengine import cli, completion
from hdengine.studies.progress import Progress
from hdengine.studies.study import StudyResult

COMMANDS = sorted(next(a for a in cli.make_parser()._actions if a.dest == "command").choices)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_an_example_that_parses(name, capsys):
    """`hdengine NAME --help` ends with one example of that command, and the command accepts it."""
    with pytest.raises(SystemExit) as end:
        cli.main([name, "--help"])
    assert end.value.code == 0
    words = " ".join(capsys.readouterr().out.split("example: hdengine ")[1].split()).split(" > ")[0].split()
    assert words[0] == name and cli.make_parser().parse_args(words).command == name


def test_a_reader_that_goes_away(exe):
    """`... | head`: program and command end with one line and code 3 (bash's PIPESTATUS)."""
    for command in ([Path(sys.executable).with_name("hdengine"), "completion", "bash"], [exe, "--explain", "all"]):
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
            running.stdout.close()
            error = running.stderr.read()
            assert error.startswith("error: cannot write the standard output: Broken pipe") and error.count("\n") == 1
            assert running.wait() == 3


def test_plan(capsys, tmp_path):
    """`hdengine plan` prints the series of meshes of a scene and of a study's first point; mistakes end with code 2."""
    assert cli.main(["plan", str(ROOT / "data/cd14.nml"), "solver.kinematics=linear", "--tolerance", "0.05"]) == 0
    assert "known to 5.0 %" in capsys.readouterr().out
    assert cli.main(["plan", str(ROOT / "data/fig13_w.toml"), "load.torque=3", "solver.kinematics=linear"]) == 0
    assert capsys.readouterr().out.startswith("10 points")
    assert cli.main(["plan", str(ROOT / "data/cd14.nml"), "load.torqe=3"]) == 2 and "did you mean 'torque'" in capsys.readouterr().err
    assert cli.main(["plan", str(tmp_path / "none.nml")]) == 3
    assert cli.main(["run", str(ROOT / "data/cd14.nml"), "torque", "--out", str(tmp_path / "x")]) == 2


def test_ctrl_c_keeps_what_was_solved(monkeypatch, capsys, tmp_path):
    """Ctrl-C ends a study without a traceback, code 7; the same command goes on to the result of an undisturbed one."""
    (tmp_path / "s.toml").write_text("[fixed]\nmesh = {divisions = 16, band_facets = 3}\nload.torque_steps = 1\n[grid]\nload.torque = [2, 3]\n")
    command = ["study", str(tmp_path / "s.toml"), "--out", str(tmp_path / "s.out")]

    def stop(self, *words):
        raise KeyboardInterrupt
    with monkeypatch.context() as patch:
        patch.setattr(Progress, "step", stop)
        assert cli.main(command) == 7 and "goes on" in capsys.readouterr().err
    assert StudyResult(tmp_path / "s.out").summary["status"] == "unfinished"
    assert cli.main(command) == 0
    assert StudyResult(tmp_path / "s.out").column("torque_nm").max() == 3


def test_completion_without_shtab_says_what_to_install(monkeypatch, capsys):
    """Where shtab is missing the command names the extra."""
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert cli.main(["completion", "bash"]) == 2 and "hdengine[completion]" in capsys.readouterr().err


def test_completion_completes(tmp_path):
    """In bash, commands and keys of scenes are completed."""
    pytest.importorskip("shtab")
    (tmp_path / "c.sh").write_text(completion.script(cli.make_parser(), "bash"))
    ask = 'source c.sh; COMP_WORDS=({}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _shtab_hdengine; echo "${{COMPREPLY[@]}}"'
    for words, expected in (("hdengine rep", "report"), ("hdengine run x.nml load.torque_s", "load.torque_steps=")):
        done = subprocess.run(["bash", "-c", ask.format(words)], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.stdout.split() == [expected], done


def test_tables_for_pandas_and_xarray(small_run):
    """A run's steps are a frame, its contact fields a dataset with torque, angle and place along the band; a table that it has not is named, with
    those that it has."""
    pytest.importorskip("pandas"), pytest.importorskip("xarray")
    result = hdengine.load(small_run)
    frame, data = result.frame(), result.dataset()
    assert frame["k_ts_nm_per_rad"].iloc[-1] == pytest.approx(result.torsional_stiffness()[0][-1])
    for ask in (lambda: result.frame("loop"), lambda: result.fatigue):
        with pytest.raises(hdengine.FileError, match="has no (loop|fatigue)[.]csv.* valid: steps, history, contact"):
            ask()
    assert data["pressure_pa"].dims == ("step", "theta_rad", "band_z_m")
    assert all(v.attrs["units"] and v.attrs["long_name"] for v in data.data_vars.values())
    assert float(abs(data["z_m"][-1].mean("theta_rad") - data["band_z_m"] - result.scene["geometry.band_start"]).max()) < 1e-4
    assert "<td>K_TS, tangent / (MN m/rad)</td>" in result._repr_html_()
    assert float((data["pressure_pa"] * data["area_m2"]).isel(step=-1).sum()) == pytest.approx(
        float((result.contact["pressure_pa"] * result.contact["area_m2"])[-1].sum()))


@pytest.mark.parametrize("rows", ["torque", "last"])
def test_studies_for_xarray(tmp_path, rows):
    """A grid becomes dimensions, keys side by side coordinates of the points; with one row per point its torque is a variable."""
    pytest.importorskip("pandas"), pytest.importorskip("xarray")
    coarse = {"mesh.divisions": 16, "mesh.band_facets": 3, "load.torque_steps": 1, "load.assembly_steps": 1}
    values = {"wave_generator.w": [0.19e-3, 0.20e-3], "load.torque": [2.0, 3.0]}
    for name, kind in (("g", {"grid": values}), ("t", {"together": values})):
        result = hdengine.Study(str(ROOT / "data/cd14.nml"), fixed=coarse, rows=rows, **kind).run(tmp_path / name, show=False)
        data, over = result.dataset(), ["torque_nm"] * (rows == "torque")
        if name == "g":
            assert list(data.sizes) == ["wave_generator.w", "load.torque", *over] and data.sizes["load.torque"] == 2
            place = {"wave_generator.w": 0.20e-3, "load.torque": 3.0}
        else:
            assert list(data.sizes) == ["point", *over]
            assert data["wave_generator.w"].dims == ("point",) and list(data["load.torque"]) == values["load.torque"]
            place = {"point": 1}
        if rows == "torque":
            place["torque_nm"] = 3.0
        else:
            assert float(data["torque_nm"].sel(place)) == pytest.approx(3.0)
        want = result.select(torque_nm=3.0, wave_generator__w=0.20e-3)[0]["k_ts_nm_per_rad"]
        assert float(data["k_ts_nm_per_rad"].sel(place)) == pytest.approx(want)


WRONG = {"bad.csv": b"a,b\n1,2\n", "words.csv": b"torque_nm,angle_rad\n1,x\n2,3\n", "bytes.png": b"\x89PNG\r\n\x1a\n\x00\x01", "empty": b"",
         "brace.out/summary.json": b"{", "list.out/study.json": b"[]", "other.out/summary.json": b'{"kind": "x"}',
         "other.out/study.csv": b"\xff"}


@pytest.mark.parametrize("command", ("record", "report", "plot", "sensitivity", "study", "plan", "run", "surface"))
def test_wrong_files_end_with_one_error(command, tmp_path, monkeypatch, capsys):
    """Every command ends with one line `error: ...` and code 2 or 3 for files and folders that are not what it takes."""
    monkeypatch.chdir(tmp_path)
    for name, content in WRONG.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    for name in {*WRONG, "brace.out", "list.out", "other.out", "nothing", "."}:
        code, told = cli.main([command, name]), capsys.readouterr().err
        assert code in (2, 3) and told.startswith("error: ") and told.count("error: ") == 1, (name, code, told)


def test_forms_of_run(tmp_path, monkeypatch, capsys):
    """Keys stand anywhere; --check, --plan, --explain, -q, -v and --version do what hdengine.x does with them."""
    monkeypatch.chdir(tmp_path)
    scene = str(ROOT / "data/cd14.nml")
    assert cli.main(["run", scene, "--out", "o", "load.torque=3", "--check"]) == 0 and "is valid" in capsys.readouterr().out
    assert cli.main(["run", scene, "--check", "load.torqe=3"]) == 2 and "did you mean 'torque'" in capsys.readouterr().err
    small = ["mesh.divisions=16", "mesh.band_facets=3", "load.torque_steps=1", "load.assembly_steps=1"]
    assert cli.main(["run", scene, *small, "--out", "o", "-v", "load.torque=3"]) == 0
    told = capsys.readouterr().out
    assert "3.0000 N m" in told and "residual" in told
    assert cli.main(["run", scene, *small, "-q", "--out", "quiet"]) == 0 and "N m  normal" not in capsys.readouterr().out
    for words, found in ((["--version"], hdengine.__version__), (["run", "--explain", "load.torque"], "torque at the end")):
        with pytest.raises(SystemExit) as end:
            cli.main(words)
        assert end.value.code == 0 and found in capsys.readouterr().out
    for words, found in ((["run", "--explain", "load.torqe"], "torque"), (["study", "x", "--jobs", "-3"], "1 or more"),
                         (["study", "x", "--shard", "1/2", "--other-version"], "not allowed"), (["run", scene, "--bogus"], "--bogus"), (["plot", "o", "load.torque=3"], "no place in")):
        with pytest.raises(SystemExit) as end:
            cli.main(words)
        assert end.value.code == 2 and found in capsys.readouterr().err


def test_run_says_what_it_will_take(tmp_path, capsys):
    """Before the first load step of a planned run stand its trials, what they decide, and the size of the mesh: a fine one takes minutes."""
    assert cli.main(["run", str(ROOT / "data/cd14.nml"), "run.tolerance=0.5", "solver.kinematics=linear",
                     "geometry.bore_radius=9e-3", "geometry.hub_radius=4e-3", "--out", str(tmp_path / "r")]) == 0
    ahead = capsys.readouterr().out.split("\nstep ")[0]
    assert all(re.search(words, ahead, re.M) for words in (r"^  trial .* facets", "^plan ", r"^mesh +\d+ dof"))


def test_the_distribution_states_its_python_and_its_licences():
    """Python 3.9 is refused on installing, and the installed package brings its licence files."""
    told = metadata.distribution("hdengine")
    assert told.metadata["Requires-Python"] == ">=3.10"
    files = {Path(str(f)).name for f in told.files if "licenses" in str(f)}
    assert files >= {"LICENSE", "LICENSE-EXCEPTION", "THIRD_PARTY.md"}


DOUBTS = {"material.flexspline_e=209": "209 GPa", "material.ring_e=219e3": "GPa|MPa", "wave_generator.w=1.6e-3": "times the wall",
          "geometry.rim_thickness=0.3e-3": "thinner than the wall", "contact.friction=1.5": "contact.friction",
          "wave_generator.w=0": "stays round", "load.torque=5000": "5.0 N m .5000.0 N mm", "joint.asperity_radius=5e-3": "joint.asperity_radius", "joint.s_min=0.8": r"um\^2"}


@pytest.mark.parametrize("key", DOUBTS)
def test_values_that_are_hardly_meant(exe, key):
    """A value far from any drive is told with its usual range and the slip of units; the scene is valid, if it is meant."""
    scene = str(ROOT / ("data/paper.nml" if key.startswith("joint.") else "data/cd14.nml"))
    said = [call(exe, scene, "--check", "--allow-implausible", *keys).stdout for keys in ((), (key,))]
    assert "warning" not in said[0] and "is valid" in said[1] and re.search(DOUBTS[key].replace("209 GPa", "209.0 GPa"), said[1]), said
    group, name = key.split("=")[0].split(".")
    assert len(hdengine.contact.doubts(scene, **{group: {name: float(key.split("=")[1])}})) == 1


@pytest.mark.parametrize("key, meant", [("geometry.cup_length=30", "0.03 m"), ("geometry.bore_radius=17.5", "0.0175 m"),
                                        ("material.flexspline_e=209", "2.09e11 Pa"), ("load.torque=7800", "7.8 N m")])
def test_a_slip_of_units_stops_the_run(exe, key, meant, tmp_path):
    """A value some thousand times off ends with an error that names what was meant, in Python too; --allow-implausible goes on."""
    done = call(exe, ROOT / "data/cd14.nml", key, "--out", tmp_path / "r")
    assert done.returncode == 2 and f"did you mean {meant}" in done.stderr and "--allow-implausible" in done.stderr and not (tmp_path / "r").exists()
    group, name = key.split("=")[0].split(".")
    with pytest.raises(hdengine.InputError, match="allow_implausible=True"):
        hdengine.Run(ROOT / "data/cd14.nml", **{group: {name: float(key.split("=")[1])}})
    assert "--allow-implausible" not in call(exe, ROOT / "data/cd14.nml", key, "--check", "--allow-implausible").stderr


@pytest.mark.parametrize("key, meant", [("geometry.wall_thickness=0.35", "0.35 mm"), ("wave_generator.w=0.2", "0.2 mm"),
                                        ("geometry.ring_thickness=1", "1.0 mm"), ("geometry.band_length=6", "6.0 mm"),
                                        ("wave_generator.interference=10", "10.0 um")])
def test_a_hard_limit_names_the_unit_too(exe, key, meant):
    """A value beyond what any scene may have is refused with the unit that it was given in."""
    done = call(exe, ROOT / "data/cd14.nml", key, "--check")
    assert done.returncode == 2 and "valid: " in done.stderr and f"({meant})?" in done.stderr


# Given in this by mistake: the factor, what the message says. Then keys that have no usual value: springs soft or rigid, angles of any size, a
# pressure or roughness that only a law bounds, places on the band.
SLIPS = {"m": (1e3, "mm"), "Pa": (1e-6, "MPa"), "N m": (1e3, "N mm"), "N/m": (1e-3, "N/mm"), "deg": (np.pi / 180, "rad")}
ANY = {"load.support_stiffness", "wave_generator.ball_stiffness", "wave_generator.cone_angle_deg", "wave_generator.eccentricity_angle_deg", "bearing.cage_angle_deg",
       "turning.range_deg", "contact.zero_pressure", "joint.roughness", "output.positions"}
TYPICAL = {"wave_generator.perimeter_length": 0.1037, "turning.torque": 7.0, "loop.torques": 7.8, "bearing.patch_length": 1e-3, "bearing.patch_width": 1e-3,
           "joint.hardness": 2e9,
           "cup.sections_r": 0.0175, "cup.sections_z": 0.02, "cup.sections_thickness": 4e-4, "cup.sections_fillet": 1.5e-3}


def test_every_key_knows_the_slip_of_its_unit(exe):
    """Every length, modulus, torque, stiffness and angle of a drive that is given in mm, MPa, N mm, N/mm or rad stops the run, and the message
    says what was meant."""
    scene = hdengine.read_scene(ROOT / "data/drive14.nml")
    units = re.findall(r"^(\w+\.\w+)\n.*\n\n  Default `[^`]*` (Pa|N m|N/m|deg|m)[,;]", call(exe, "--explain", "all").stdout, re.M)
    keys = {key: unit for key, unit in units if key not in ANY and not key.startswith(("surface.", "fit."))}
    silent = {}
    for key, unit in keys.items():
        factor, said = SLIPS[unit]
        value = np.max(scene[key]) or TYPICAL.get(key, 2e-5)
        values = [factor * TYPICAL.get(key, value)] * (np.size(scene[key]) if key.startswith("load.tooth_gaps") else 1)
        done = call(exe, ROOT / "data/drive14.nml", f"{key}={','.join(f'{v:.9g}' for v in values)}", "--check")
        hint = re.search(rf"{key} = .*did you mean ([\d.e-]+) {unit} \([\d.e]+ {said}\)\?", done.stderr)
        if not (done.returncode == 2 and hint and float(hint[1]) == pytest.approx(value, rel=1e-4)):
            silent[key] = done.stdout + done.stderr
    assert silent == {} and len(keys) > 45


def test_no_hint_makes_it_worse(exe):
    """A value just outside of what is usual, and no slip of units, is warned of without a hint."""
    done = call(exe, ROOT / "data/cd14.nml", "wave_generator.interference=2e-4", "--check")
    assert done.returncode == 0 and "is unusual" in done.stdout and "did you mean" not in done.stdout


def test_every_warning_has_its_number(exe):
    """The log ends each warning with its number, `--explain warnings` lists as many as the sources have, and each has one."""
    import messages_page

    listed = re.findall(r"^W(\d+) +(.*) - ", call(exe, "--explain", "warnings").stdout, re.M)
    said = [m.text for m in messages_page.messages() if m.kind == "warning"]
    assert [int(n) for n, _ in listed] == list(range(1, len(listed) + 1))
    bare = [re.sub(r"[‹›…]", "", text) for text in said]
    assert [text for text in said if not any(mark.strip() in text or mark.strip() in bare[said.index(text)] for _, mark in listed)] == []
    assert [mark for _, mark in listed if sum(mark.strip() in text for text in bare + said) == 0] == []
    assert call(exe, ROOT / "data/cd14.nml", "contact.friction=1.5", "--check").stdout.splitlines()[0].endswith("(W1)")


def test_typed_keys_are_those_of_the_engine():
    """The module that editors complete keys from has every key of a scene, and the kind of each: numbers, lists and texts."""
    from hdengine._keys import SceneKeys

    kinds, scene = SceneKeys.__annotations__, hdengine.read_scene()
    assert {key.replace("__", ".", 1) for key in kinds if "__" in key} == set(scene)
    for key, value in scene.items():
        kind = kinds[key.replace(".", "__", 1)].__forward_arg__.replace(" | str", "")
        assert kind in {int: ("int",), float: ("float",), str: ("str", "bool"), list: ("Sequence[float] | float",)}[type(value)], key


def test_a_result_answers_in_words(tmp_path):
    """A whole drive's result has K1 to K3, K_TS, its tables by name, its figures, its report and a table with the loop for notebooks."""
    pytest.importorskip("pandas")
    keys = {"mesh": {"divisions": 24, "band_facets": 4}, "load": {"torque_steps": 2, "tangent_steps": "all"}}
    result = hdengine.run(ROOT / "tests/cases/pressed_drive.nml", tmp_path / "r", **keys)
    found = result.summary["results"]
    assert (result.k1, result.k2, result.k3, result.k_ts) == tuple(found[f"{n}_nm_per_rad"] for n in ("k1", "k2", "k3", "k_ts_bonded"))
    loop = result.frame("loop")
    shares = loop[[c for c in loop if c.startswith("share_")]].to_numpy()
    assert len(loop) == len(result.steps) and shares[loop.phase == "torque"].sum(axis=1) == pytest.approx(1)
    assert {p.name for p in result.plot()} >= {"loop.png", "twist.png", "contact.png", "loads.png", "fatigue.png"}
    assert result.report() == tmp_path / "r/report.html" and result.report().stat().st_size > 4e4
    page = result._repr_html_()
    assert "<td>K2 / (kN m/rad)</td>" in page and "data:image/png;base64," in page
    assert f"<td>hysteresis / arcmin</td><td>{found['hysteresis_rad'] * 180 * 60 / np.pi:.4g}</td>" in page
    with pytest.raises(hdengine.FileError, match="nothing.csv"):
        result.frame("nothing")


def test_the_example_of_run_runs():
    """The example in the documentation of hdengine.run prints what it shows."""
    import doctest

    tests = doctest.DocTestFinder().find(hdengine.run, "run", globs={})
    assert sum(doctest.DocTestRunner().run(test).failed for test in tests) == 0 and tests[0].examples


def test_grid_of_the_contact_face(small_run):
    """The contact grid holds the points of its facets alone, and pressure, K_N, K_T and state of contact.csv."""
    meshio = pytest.importorskip("meshio")
    result = hdengine.load(small_run)
    grid = meshio.read(sorted(small_run.glob("contact_*.vtu"))[-1])
    assert set(grid.cells[0].data.ravel()) == set(range(len(grid.points)))
    for name, column in (("k_n_n_per_m", "k_n_n_per_m"), ("k_t_n_per_m", "k_t_n_per_m"), ("pressure_pa", "pressure_pa"),
                         ("state_0_open_1_stick_2_slip", "state")):
        assert grid.cell_data[name][0].ravel() == pytest.approx(result.contact[column][-1])


def test_advice_fits_the_shell(tmp_path, capsys):
    """A file without unit is answered with the option --unit at the shell, where `unit="um"` would be Python."""
    pytest.importorskip("SurfaceTopography")
    (tmp_path / "a.txt").write_text("1 2 3\n4 5 6\n7 8 9\n")
    assert cli.main(["surface", str(tmp_path / "a.txt"), "--out", str(tmp_path / "o")]) == 2
    said = capsys.readouterr().err
    assert "say --unit um (or mm, nm, m), or --unit mm,um for" in said and "unit=" not in said


def test_plan_of_run_and_wrong_words(capsys, tmp_path, monkeypatch):
    """`run --plan` prints the plan and writes nothing; a word that is no assignment and a count of processes below 1 are refused."""
    monkeypatch.chdir(tmp_path)
    scene = str(ROOT / "data/cd14.nml")
    assert cli.main(["run", scene, "mesh.divisions=24", "mesh.band_facets=4", "run.tolerance=0.3", "--plan"]) == 0
    assert "tolerance" in capsys.readouterr().out and not list(tmp_path.iterdir())
    for words in (["run", scene, "torque"], ["run", scene, "torque=3"], ["new", "20", "torque=3"]):
        assert cli.main(words) == 2 and "group.key=value" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        cli.main(["study", scene, "--jobs", "none"])
    assert "'none' must be a whole number of 1 or more" in capsys.readouterr().err


def test_figures_that_need_matplotlib(tmp_path, monkeypatch, capsys):
    """Where matplotlib is missing a run is solved and says what figures need, `report` works, `plot` ends with one line."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    for name in [m for m in sys.modules if m.startswith("hdengine.figures")]:
        monkeypatch.delitem(sys.modules, name)
    assert cli.main(["run", str(ROOT / "data/cd14.nml"), "mesh.divisions=16", "mesh.band_facets=3", "load.torque_steps=1", "--out", str(tmp_path / "r")]) == 0
    assert "figures need matplotlib: pip install 'hdengine[plot]'" in capsys.readouterr().err
    assert cli.main(["report", str(tmp_path / "r")]) == 0
    assert cli.main(["plot", str(tmp_path / "r")]) == 2
    assert capsys.readouterr().err == "error: figures need matplotlib: pip install 'hdengine[plot]'\n"


def test_figures_need_no_backend(small_run, tmp_path):
    """A backend of matplotlib that is not there, as a notebook's in the environment of another Python, hinders no figure."""
    run = shutil.copytree(small_run, tmp_path / "r")
    done = subprocess.run([sys.executable, "-m", "hdengine", "plot", run], capture_output=True, text=True, env=os.environ | {"MPLBACKEND": "none"})
    assert done.returncode == 0 and (run / "positions.png").exists(), done.stderr


def test_program_starts_by_its_command(tmp_path):
    """`hdengine.x` of the installed commands is the program, with its arguments and exit code, from any folder."""
    command = Path(sys.executable).with_name("hdengine.x")
    assert subprocess.run([command, "--version"], cwd=tmp_path, capture_output=True, text=True).stdout.startswith("hdengine ")
    assert subprocess.run([command, "none.nml"], cwd=tmp_path, capture_output=True).returncode == 3
