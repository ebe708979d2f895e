# SPDX-License-Identifier: GPL-3.0-or-later
"""A stopped run goes on as if it had never stopped, with its own scene only."""
import csv
import json
import math
import random
import re
import shutil
import signal
import subprocess
import time

import pytest

import hdengine
from conftest import CD14, ROOT, call
from hdengine.studies.study import Study

SMALL = {"mesh__divisions": 20, "mesh__band_facets": 4}
WORDS = ["mesh.divisions=20", "mesh.band_facets=4"]


def rows(path):
    """Rows of a table without its clock."""
    with open(path) as f:
        return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(f)]


def stopped_run(folder, steps, **keys):
    """A run left after some load steps, in a process that remembers no other."""
    hdengine.forget()
    with hdengine.Run(CD14, folder, **SMALL, **keys) as run:
        for _ in range(steps):
            run.advance()


@pytest.mark.parametrize("steps", [1, 3, 6])
@pytest.mark.parametrize("keys", [{}, {"solver__method": "newton"}, {"contact__law": "joint"}, {"solver__kinematics": "nonlinear"}])
def test_resumed_equals_uninterrupted(exe, tmp_path, steps, keys):
    """Left after a step of the assembly or of the torque, every table ends equal to the bit."""
    words = WORDS + [f"{k.replace('__', '.')}={v}" for k, v in keys.items()]
    assert call(exe, CD14, *words, "--out", tmp_path / "whole").returncode == 0
    stopped_run(tmp_path / "cut", steps, **keys)
    with open(tmp_path / "cut/contact.csv", "a") as f:
        f.write("half a row")  # as a killed process leaves it
    done = call(exe, CD14, *words, "--out", tmp_path / "cut", "--resume")
    assert done.returncode == 0, done.stderr
    for table in ("contact", "steps", "history"):
        assert rows(tmp_path / f"cut/{table}.csv") == rows(tmp_path / f"whole/{table}.csv"), table
    a, b = (json.loads((tmp_path / x / "summary.json").read_text()) for x in ("whole", "cut"))
    assert a["results"] == b["results"] and b["status"] == "complete" and b["model"]["resumed"]
    assert not (tmp_path / "cut/checkpoint.bin").exists()


AWAY = {  # every group of keys away from its default
    "geometry.cup_length": 22e-3, "material.ring_e": 205e9, "material.yield_strength": 900e6, "mesh.wall_elements": 3,
    "mesh.edge_length": 4e-4, "wave_generator.w": 0.21e-3, "wave_generator.eccentricity": 4e-6, "contact.friction": 0.12,
    "contact.torque_friction": 0.3, "contact.law": "joint", "contact.zero_pressure": 2e3, "contact.slave": "cup",
    "load.torque": 4.0, "load.torque_load": "teeth", "load.assembly_steps": 2, "load.torque_steps": 3, "solver.tolerance": 1e-9,
    "solver.start": "rest", "joint.fractal_dimension": 2.52, "joint.gamma": 1.4, "output.vtu": "none"}


def numbers(value, place=""):
    """Every value of a summary by its path, without clocks, dates, memory and how the run came to its end."""
    if isinstance(value, dict):
        skipped = ("timers_s", "provenance", "predicted", "peak_memory_mb", "resumed", "mesh_and_factors", "inner_iterations",
                   "checksums", "checksum")   # of tables with their clocks
        return {k: v for name, part in value.items() if name not in skipped for k, v in numbers(part, f"{place}.{name}").items()}
    return {place: value}


def contents(folder):
    """Every file of a run's folder, byte for byte; tables without their clock, the summary as `numbers`."""
    files = {p.name: p.read_bytes() for p in folder.iterdir()}
    for name in ("steps.csv", "history.csv"):
        files[name] = rows(folder / name)
    return files | {"summary.json": numbers(json.loads(files["summary.json"]))}


TINY = {"mesh.divisions": 20, "mesh.band_facets": 4, "load.torque_steps": 2, "output.vtu": "all"}


@pytest.mark.parametrize(("scene", "keys"), [
    ("cd14", {"mesh.divisions": 48, "mesh.band_facets": 8, "solver.start": "coarser"}),
    ("cd14", {"load.support": "bearing", "load.torque": 10.0, "solver.max_iterations": 7, "solver.start": "rest"}),
    ("../tests/cases/pressed_drive", {"mesh.divisions": 24, "bearing.balls": 12, "load.tooth_pairs": 12, "loop.torques": "6,0", "load.tooth_friction": 0.1,
                 "turning.positions": 1}),
    ("cd14", {"output.vtu": "last"}),
    ("../tests/cases/pressed_drive", {"mesh.divisions": 24, "bearing.balls": 12, "load.tooth_pairs": 12, "loop.torques": "6,0", "output.vtu": "last",
                 "turning.positions": 1}),
], ids=["coarser", "cuts", "drive", "last", "last of a drive"])
def test_a_run_taken_up_after_every_load_step_leaves_the_same_folder(exe, tmp_path, scene, keys):
    """Stopped after each load step and taken up again in a process that remembers nothing: the folder is the same, byte for byte."""
    path, keys = ROOT / f"data/{scene}.nml", TINY | keys
    assert call(exe, path, *(f"{k}={v}" for k, v in keys.items()), "--out", tmp_path / "whole").returncode == 0
    done = False
    while not done:
        hdengine.forget()
        with hdengine.Run(path, tmp_path / "cut", resume=True, **{k.replace(".", "__"): v for k, v in keys.items()}) as run:
            run.advance()
            done = run.done
    whole, cut = contents(tmp_path / "whole"), contents(tmp_path / "cut")
    assert sorted(cut) == sorted(whole) and [name for name in whole if cut[name] != whole[name]] == []
    results = whole["summary.json"]
    assert (results[".results.cut_backs"] > 0) == ("solver.max_iterations" in keys) and (".model.first_guesses" in results) == (
        keys.get("solver.start") == "coarser")


@pytest.mark.parametrize(("scene", "keys"), [
    ("cd14", {"run.tolerance": 0.5, "load.torque_steps": 1, "geometry.bore_radius": 9e-3, "geometry.hub_radius": 4e-3}),
    ("cd14", {"run.tolerance": 0.5, "geometry.bore_radius": 9e-3, "geometry.hub_radius": 4e-3, "load.support": "bearing", "load.torque": 2.0, "solver.max_iterations": 11, "solver.kinematics": "linear", "solver.start": "rest"}),
    ("../tests/cases/pressed_drive", {"run.tolerance": 0.4, "solver.kinematics": "linear", "loop.torques": "6,0", "load.tooth_friction": 0.1, "turning.positions": 1}),
], ids=["fit", "cuts", "drive"])
def test_a_plan_that_goes_on_with_its_last_run_leaves_the_same_folder(exe, tmp_path, scene, keys):
    """What is left of the plan is its table: the run solves what it would have taken over from the trial of its mesh, and the folder is the same, byte for byte."""
    words = [ROOT / f"data/{scene}.nml", *(f"{k}={v}" for k, v in keys.items())]
    assert call(exe, *words, "--out", tmp_path / "whole").returncode == 0
    (tmp_path / "cut").mkdir()
    for name in ("plan.nml", "plan.csv"):
        shutil.copy(tmp_path / "whole" / name, tmp_path / "cut")
    assert call(exe, *words, "--out", tmp_path / "cut", "--resume").returncode == 0
    whole, cut = contents(tmp_path / "whole"), contents(tmp_path / "cut")
    assert sorted(cut) == sorted(whole) and [name for name in whole if cut[name] != whole[name]] == []
    assert (whole["summary.json"][".results.cut_backs"] > 0) == ("solver.max_iterations" in keys)


def test_a_resumed_run_with_every_group_away_from_its_default_has_the_same_summary(exe, tmp_path):
    """Friction of the torque, joint, supports, cells: left after the assembly and after a torque step, every number is the same."""
    words = WORDS + [f"{k}={v}" for k, v in AWAY.items()]
    assert call(exe, CD14, *words, "--out", tmp_path / "whole").returncode == 0
    whole = numbers(json.loads((tmp_path / "whole/summary.json").read_text()))
    for steps in (2, 4):
        stopped_run(tmp_path / f"cut{steps}", steps, **{k.replace(".", "__"): v for k, v in AWAY.items()})
        done = call(exe, CD14, *words, "--out", tmp_path / f"cut{steps}", "--resume")
        assert done.returncode == 0, done.stderr
        assert numbers(json.loads((tmp_path / f"cut{steps}/summary.json").read_text())) == whole
    assert whole[".results.friction"] == 0.3
    capacity = 0.3 * whole[".results.normal_force_n"] * whole[".scene.geometry.bore_radius"]
    assert whole[".results.friction_capacity_nm"] == pytest.approx(capacity, rel=1e-12)


def test_a_signal_while_the_tangent_of_a_step_is_found(exe, tmp_path):
    """A step that is solved is booked with its tangent, or not at all: stopped near the top of a loop, where that takes longest, a run goes on equal to the bit."""
    words = ["mesh.divisions=16", "mesh.band_facets=3", "load.assembly_steps=2", "load.torque_steps=12", "load.tooth_friction=0.1"]
    scene, top = ROOT / "tests/cases/pressed_drive.nml", 14
    assert call(exe, scene, *words, "--out", tmp_path / "whole").returncode == 0
    for k in range(4):
        cut = tmp_path / f"cut{k}"
        process = subprocess.Popen([exe, scene, *words, "--out", cut, "-q"], stderr=subprocess.DEVNULL)
        while process.poll() is None and (not (cut / "steps.csv").exists() or (cut / "steps.csv").read_bytes().count(b"\n") < top):
            time.sleep(0.001)
        time.sleep(0.005 * k)
        process.send_signal(signal.SIGINT)
        assert process.wait() == 7
        assert call(exe, scene, *words, "--out", cut, "--resume").returncode == 0
        for table in ("loop", "history"):
            assert rows(cut / f"{table}.csv") == rows(tmp_path / f"whole/{table}.csv"), k


def test_a_signal_while_a_run_closes(exe, tmp_path):
    """What the error of the joint changes of K_TS is found after the last load step: a signal then ends with code 7, and the run goes on to it."""
    words = [exe, CD14, "mesh.divisions=96", "mesh.band_facets=16", "load.torque_steps=1", "output.vtu=none"]

    def change(folder):
        return json.loads((folder / "summary.json").read_text())["joint"]["theory_error"].get("k_ts_tangent_change")
    subprocess.run([*words, "--out", tmp_path / "whole", "-q"], check=True)
    codes = []
    for k in range(2):
        cut = tmp_path / f"cut{k}"
        process = subprocess.Popen([*words, "--out", cut], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        assert any(" 1.000 " in line and " torque " in line for line in process.stdout)
        time.sleep(0.01 * k)
        process.send_signal(signal.SIGTERM)
        process.communicate()
        codes.append(process.returncode)
        if codes[-1] == 7:
            subprocess.run([*words, "--out", cut, "--resume", "-q"], check=True)
        assert change(cut) == change(tmp_path / "whole") is not None, codes
    assert set(codes) <= {0, 7} and 7 in codes


def test_only_the_same_scene_goes_on(exe, tmp_path):
    """Another torque is an error that names both values, and the folder stays as it was; a longer time limit is taken."""
    stopped_run(tmp_path / "r", 2)
    before = {p.name: p.read_bytes() for p in (tmp_path / "r").iterdir()}
    done = call(exe, CD14, *WORDS, "load.torque=4", "--out", tmp_path / "r", "--resume")
    assert done.returncode == 2 and "load.torque = 4.0" in done.stderr and "began with 5.0" in done.stderr
    assert before == {p.name: p.read_bytes() for p in (tmp_path / "r").iterdir()}
    done = call(exe, CD14, *WORDS, "solver.time_limit_s=600", "--out", tmp_path / "r", "--resume")
    assert done.returncode == 0, done.stderr
    done = call(exe, CD14, *WORDS, "--out", tmp_path / "r", "--resume")
    assert done.returncode == 0 and "is complete" in done.stdout
    with pytest.raises(hdengine.InputError, match="is complete"):
        hdengine.Run(CD14, tmp_path / "r", resume=True, **SMALL)


@pytest.mark.parametrize("name, text, keys", [
    ("k.csv", lambda x: f"pressure_pa,k_n_pa_per_m\n1e6,2e12\n1e8,{x}e14\n", {"joint.model": "table", "joint.table_file": "k.csv"}),
    ("cam.csv", lambda x: "theta_deg,radius_m\n" + "".join(
        f"{t},{16.5e-3 + x * 1e-4 * math.cos(math.radians(2 * t))}\n" for t in range(0, 360, 10)), {"wave_generator.cam": "table", "wave_generator.cam_file": "cam.csv"})])
def test_only_the_same_tables_go_on(exe, tmp_path, name, text, keys, monkeypatch):
    """A file that a key names is part of the scene, of a run and of a study: changed while the work rests, it is refused."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text(text(1.9))
    stopped_run(tmp_path / "r", 2, **{key.replace(".", "__"): value for key, value in keys.items()})
    study = Study(grid={"load.torque": [1, 2]}, fixed={"mesh.divisions": 16, "mesh.band_facets": 3, "load.torque_steps": 1, **keys})
    study.run(tmp_path / "s", show=False)
    (tmp_path / name).write_text(text(1.8))
    words = [*WORDS, *(f"{key}={value}" for key, value in keys.items()), "--out", tmp_path / "r", "--resume"]
    done = call(exe, CD14, *words)
    assert done.returncode == 3 and "of other tables" in done.stderr and ".".join(list(keys)[1].split(".")) in done.stderr
    with pytest.raises(hdengine.FileError, match="holds another study"):
        study.run(tmp_path / "s", show=False)
    (tmp_path / name).write_text(text(1.9))
    assert call(exe, CD14, *words).returncode == 0


@pytest.mark.parametrize("spoil", [lambda path: path.unlink(), lambda path: (path.unlink(), path.mkdir())])
def test_grids_of_earlier_steps_are_still_there(exe, tmp_path, spoil):
    """A grid that the lists name and that is gone, or is no file, is named; the run does not go on."""
    stopped_run(tmp_path / "r", 2, output__vtu="all")
    spoil(tmp_path / "r/contact_0001.vtu")
    done = call(exe, CD14, *WORDS, "output.vtu=all", "--out", tmp_path / "r", "--resume")
    assert done.returncode == 3 and "contact_0001.vtu' of an earlier load step is gone" in done.stderr
    assert json.loads((tmp_path / "r/summary.json").read_text())["status"] != "complete"


def test_broken_checkpoint_or_table_is_named(exe, tmp_path):
    """A checkpoint cut short and a table that lost rows are errors of code 3; --resume without a run begins one."""
    stopped_run(tmp_path / "r", 2)
    whole = (tmp_path / "r/checkpoint.bin").read_bytes()
    (tmp_path / "r/checkpoint.bin").write_bytes(whole[:5000])
    done = call(exe, CD14, *WORDS, "--out", tmp_path / "r", "--resume")
    assert done.returncode == 3 and "checkpoint.bin" in done.stderr
    (tmp_path / "r/checkpoint.bin").write_bytes(whole)
    (tmp_path / "r/contact.csv").write_text("step\n")
    done = call(exe, CD14, *WORDS, "--out", tmp_path / "r", "--resume")
    assert done.returncode == 3 and "contact.csv" in done.stderr
    done = call(exe, CD14, *WORDS, "--out", tmp_path / "new", "--resume")
    assert done.returncode == 0, done.stderr
    done = call(exe, CD14, *WORDS, "--force", "--resume")
    assert done.returncode == 2 and "--force" in done.stderr


def test_killed_between_the_last_checkpoint_and_the_summary(exe, tmp_path):
    """A run that lost only its summary is ended by --resume without a further load step."""
    with hdengine.Run(CD14, tmp_path / "r", **SMALL) as run:
        steps = len(list(run))
        kept = (tmp_path / "r/checkpoint.bin").read_bytes()
    whole = (tmp_path / "r/steps.csv").read_text()
    (tmp_path / "r/checkpoint.bin").write_bytes(kept)
    (tmp_path / "r/summary.json").unlink()
    done = call(exe, CD14, *WORDS, "--out", tmp_path / "r", "--resume")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "r/steps.csv").read_text() == whole and len(hdengine.load(tmp_path / "r").steps) == steps


def mutations(data, count, seed):
    """Copies of a file with bits, bytes or blocks changed, cut, put in, put twice or exchanged."""
    draw = random.Random(seed)
    for _ in range(count):
        new, i, j = bytearray(data), draw.randrange(len(data)), draw.randrange(len(data))
        i, j = min(i, j), max(i, j) + 1
        kind = draw.choice(["bit", "byte", "zero", "cut", "middle", "insert", "twice", "swap", "tail", "head"])
        if kind == "bit":
            new[i] ^= 1 << draw.randrange(8)
        elif kind == "byte":
            new[i] = (new[i] + draw.randrange(1, 256)) % 256
        elif kind == "zero":
            new[i:j] = bytes(j - i)
        elif kind == "cut":
            new = new[:i]
        elif kind == "middle":
            del new[i:j]
        elif kind == "insert":
            new[i:i] = draw.randbytes(draw.randrange(1, 100))
        elif kind == "twice":
            new[j:j] = new[i:j]
        elif kind == "swap":
            new[:j - i], new[i:j] = new[i:j], new[:j - i]
        elif kind == "tail":
            new += draw.randbytes(draw.randrange(1, 100))
        else:
            k = draw.randrange(200)  # magic, version, length, marks
            new[k] ^= draw.randrange(1, 256)
        if bytes(new) != data:
            yield bytes(new)


def test_mutated_checkpoints_and_tables_are_refused(tmp_path):
    """No changed checkpoint and no changed table is taken up: each is an error of code 3, and the right ones still go on."""
    stopped_run(tmp_path / "r", 2)
    whole = {name: (tmp_path / "r" / name).read_bytes() for name in ("checkpoint.bin", "steps.csv", "history.csv", "contact.csv")}
    for seed, (name, data) in enumerate(whole.items()):
        for new in mutations(data, 24 if seed == 0 else 6, seed):
            if name != "checkpoint.bin" and new.startswith(data):
                continue  # rows behind the checkpoint are cut off
            (tmp_path / "r" / name).write_bytes(new)
            with pytest.raises(hdengine.FileError, match=name):
                hdengine.Run(CD14, tmp_path / "r", resume=True, **SMALL)
            for other, right in whole.items():
                (tmp_path / "r" / other).write_bytes(right)
    with hdengine.Run(CD14, tmp_path / "r", resume=True, **SMALL) as run:
        assert len(list(run)) > 0


def test_a_checkpoint_of_another_run_is_refused(tmp_path):
    """A checkpoint of the same mesh but another scene, and one of another version, are told as such."""
    stopped_run(tmp_path / "a", 2)
    stopped_run(tmp_path / "b", 2, load__torque=4.0)
    right = (tmp_path / "a/checkpoint.bin").read_bytes()
    shutil.copy(tmp_path / "b/checkpoint.bin", tmp_path / "a/checkpoint.bin")
    with pytest.raises(hdengine.FileError, match="of another scene"):
        hdengine.Run(CD14, tmp_path / "a", resume=True, **SMALL)
    (tmp_path / "a/checkpoint.bin").write_bytes(re.sub(rb"checkpoint [A-Z]", b"checkpoint 3", right))
    with pytest.raises(hdengine.FileError, match="no checkpoint of this version"):
        hdengine.Run(CD14, tmp_path / "a", resume=True, **SMALL)


def test_a_plan_takes_up_no_trials_of_other_tables(exe, tmp_path):
    """A table that a key names and that has changed since makes every trial anew: limits are those of a plan that begins with it."""
    words = ["geometry.bore_radius=9e-3", "geometry.hub_radius=4e-3", "solver.kinematics=linear", "run.tolerance=0.3",
             "load.torque=1", "joint.model=table", "contact.law=joint", f"joint.table_file={tmp_path / 'k.csv'}", "--out"]
    found = {}
    for name, k in (("stiff", 1e14), ("soft", 1e13)):
        (tmp_path / "k.csv").write_text(f"pressure_pa,k_n_pa_per_m\n1e6,{k / 50}\n1e8,{k}\n")
        assert call(exe, CD14, *words, tmp_path / name).returncode == 0
        found[name] = json.loads((tmp_path / name / "summary.json").read_text())["plan"]
    (tmp_path / "cut").mkdir()
    for name in ("plan.nml", "plan.csv"):
        shutil.copy(tmp_path / "stiff" / name, tmp_path / "cut")
    assert call(exe, CD14, *words, tmp_path / "cut", "--resume").returncode == 0
    cut = json.loads((tmp_path / "cut/summary.json").read_text())["plan"]
    assert cut["pressure_field_pa"] == found["soft"]["pressure_field_pa"] != found["stiff"]["pressure_field_pa"]


def test_a_mutated_plan_is_refused(exe, tmp_path):
    """A changed row of plan.csv ends a resumed plan with code 3 that names the row."""
    words = ["geometry.bore_radius=9e-3", "geometry.hub_radius=4e-3", "solver.kinematics=linear", "run.tolerance=0.3", "load.torque=1", "--out", tmp_path / "p"]
    assert call(exe, CD14, *words).returncode == 0
    (tmp_path / "p/summary.json").unlink()
    text = (tmp_path / "p/plan.csv").read_text()
    for old, new in ((text.splitlines()[2][-30:], text.splitlines()[2][-30:].replace("E", "F", 1)), (",", ";")):
        (tmp_path / "p/plan.csv").write_text(text.replace(old, new))
        done = call(exe, CD14, *words, "--resume")
        assert done.returncode == 3 and "plan.csv' is not as the plan left it" in done.stderr
