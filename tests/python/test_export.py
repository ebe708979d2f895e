# SPDX-License-Identifier: GPL-3.0-or-later
"""What other programs get of a run: MuJoCo twists as the law says, CalculiX finds the run's forces on its mesh."""
import os
import re
import shutil
import subprocess
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

import hdengine
from conftest import ROOT
from hdengine.cli import main
from hdengine.export.deck import _grid, _Mesh, flank_weights, to_deck
from hdengine.export.formats import to_mujoco
from hdengine.export.law import JointLaw, joint_law

KEYS = {"mesh.divisions": 24, "mesh.band_facets": 4, "load.torque_steps": 2}


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    """A small whole drive over a loop that goes through 0 both ways, faces bonded."""
    out = tmp_path_factory.mktemp("export") / "d.out"
    return hdengine.run(ROOT / "tests/cases/pressed_drive.nml", out, **KEYS, contact__mode="bonded", loop__torques=[14, -14, 14])


@pytest.mark.parametrize("damage", ["empty", "cut", "size", "pipe"])
def test_damaged_grids_are_one_error(small_run, tmp_path, damage, capsys):
    """A grid of the run that is cut, states another size or is a pipe ends the export of a deck with code 3 and its name."""
    pytest.importorskip("meshio")
    run = shutil.copytree(small_run, tmp_path / "r")
    grid = max(run.glob("bodies_*.vtu"))
    whole = grid.read_bytes()
    grid.unlink()
    if damage == "pipe":
        os.mkfifo(grid)
    else:
        grid.write_bytes({"empty": b"", "cut": whole[:5000], "size": re.sub(rb'NumberOfPoints="\d+', b'NumberOfPoints="99999999999', whole)}[damage])
    assert main(["export", str(run), "--to", "inp"]) == 3
    assert f"error: '{grid}' " in capsys.readouterr().err and not (run / "deck.inp").exists()


def table(path):
    """Columns of the exported table, whose head begins with #."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return dict(zip(lines[0].split(","), np.array([line.split(",") for line in lines[1:]], float).T))


def test_the_law_is_a_joint(drive, tmp_path):
    """Torque and angle rise together, odd about 0, between the branches, and the table's largest torque is that of the run."""
    assert main(["export", str(drive.folder), "--to", "csv", "--out", str(tmp_path / "j.csv")]) == 0
    t = table(tmp_path / "j.csv")
    assert (np.diff(t["torque_nm"]) > 0).all() and (np.diff(t["angle_rad"]) > 0).all() and t["torque_nm"][-1] == 14
    assert t["angle_rad"] == pytest.approx(-t["angle_rad"][::-1]) and t["angle_rad"][-1] == pytest.approx(max(drive.loop["angle_rad"]), rel=0.01)
    assert (t["angle_falling_rad"] >= t["angle_rad"] - 1e-9).all() and (t["angle_rising_rad"] <= t["angle_rad"] + 1e-9).all()
    assert f"k2_nm_per_rad = {drive.summary['results']['k2_nm_per_rad']:.6g}" in (tmp_path / "j.csv").read_text()


@pytest.mark.parametrize("torques", [[14, -4, 14], [-14, 4, -14], [5, -14, 14], [14, 0, 0, -14, -14, 0, 0, 14], [3, 0, 14]])
def test_any_list_of_torques_gives_the_law(drive, tmp_path, torques):
    """Loops that reach further on one side, that rest at a torque, or that begin with a smaller rise give the angle of the even loop at the
    largest torque, to 3 %; loops keep their width."""
    run = hdengine.run(
        ROOT / "tests/cases/pressed_drive.nml", tmp_path / "d.out", **KEYS, contact__mode="bonded", loop__torques=torques)
    law, even = joint_law(run), joint_law(drive)
    assert law.torque_nm[-1] == 14 and law.angle_rad[-1] == pytest.approx(even.angle_rad[-1], rel=0.03)
    assert law.angle_rad == pytest.approx(-law.angle_rad[::-1], abs=1e-12)
    assert (law.friction_nm > 0) == (torques[1] != 0 or len(torques) > 3)


def test_mujoco_twists_as_the_drive(drive):
    """In MuJoCo the joint comes to rest within 1 % of the angle of the law, at every torque of it and between them, both ways."""
    mujoco = pytest.importorskip("mujoco")
    assert main(["export", str(drive.folder), "--to", "mujoco"]) == 0
    law = joint_law(drive)
    model = mujoco.MjModel.from_xml_path(str(drive.folder / "joint.xml"))
    for torque in (*law.torque_nm[law.torque_nm != 0], 1.0, -10.5):
        data = mujoco.MjData(model)
        data.qfrc_applied[0] = torque
        mujoco.mj_step(model, data, nstep=10000)
        assert abs(data.qvel[0]) < 1e-9 and data.qpos[0] == pytest.approx(np.interp(torque, law.torque_nm, law.angle_rad), rel=0.01)


def test_mujoco_keeps_the_width_of_the_loop():
    """With the friction that the file names a loop of 2 s a quarter has the width of the law at no torque to 6 %, which the damping adds; half of it is
    held at rest. By MuJoCo's own solreffriction and solimpfriction it crept to 0 in 0.5 s. The head says of which curve K1 to K3 are."""
    mujoco, torque = pytest.importorskip("mujoco"), np.linspace(-7.8, 7.8, 7)
    half = 2.5e-5 * (abs(torque) < 7.7)
    text = to_mujoco(JointLaw(torque, torque / 5275, torque / 5275 + half, torque / 5275 - half, {"k1_nm_per_rad": 4970.0}, "drive"))
    assert "K1 to K3 are chords of the rise, not of this middle: k1_nm_per_rad = 4970" in text
    friction = re.search(r'frictionloss="[^"]+"', text)[0]
    model = mujoco.MjModel.from_xml_string(text.replace('<joint name="drive"', f'<joint {friction} name="drive"'))
    data, rest = mujoco.MjData(model), []
    for ends in ((0, 7.8), (7.8, 0), (0, -7.8), (-7.8, 0)):
        for data.qfrc_applied[0] in np.repeat(np.linspace(*ends, 2001)[1:], 10):
            mujoco.mj_step(model, data)
        rest.append(data.qpos[0])
    assert rest[1] - rest[3] == pytest.approx(5e-5, rel=0.06)
    mujoco.mj_step(model, data, nstep=5000)
    assert data.qpos[0] == pytest.approx(-2.5e-5, rel=0.06)


def test_fmu_gives_the_torque_of_the_law(drive):
    """FMPy finds nothing wrong with the unit, and in it the torque of the law, between its rows and beyond them, at every twist of a rising input."""
    fmpy, validation = pytest.importorskip("fmpy"), pytest.importorskip("fmpy.validation")
    assert main(["export", str(drive.folder), "--to", "fmu"]) == 0
    law, path = joint_law(drive), str(drive.folder / "joint.fmu")
    assert not validation.validate_fmu(path)
    twist = np.linspace(1.2 * law.angle_rad[0], 1.2 * law.angle_rad[-1], 101)
    given = np.array(list(zip(np.arange(101.0), twist)), dtype=[("time", float), ("phi_rel", float)])
    found = fmpy.simulate_fmu(path, stop_time=100, step_size=1, output_interval=1, input=given, output=["phi_rel", "tau", "c"])
    inside = abs(found["phi_rel"]) <= law.angle_rad[-1]
    assert found["tau"][inside] == pytest.approx(np.interp(found["phi_rel"][inside], law.angle_rad, law.torque_nm))
    assert found["tau"][-1] == pytest.approx(law.torque_nm[-1] + found["c"][-1] * (found["phi_rel"][-1] - law.angle_rad[-1])) and inside.sum() > 80


def test_tendons_add_up_to_the_law(drive):
    """The springs of the MuJoCo model, each of which pulls beyond the ends of its length, give the torques of the law at its angles."""
    assert main(["export", str(drive.folder), "--to", "mujoco"]) == 0
    model, law = ElementTree.parse(drive.folder / "joint.xml"), joint_law(drive)
    torque = float(model.find(".//joint[@name='drive']").get("stiffness")) * law.angle_rad
    for spring in model.iter("fixed"):
        low, high = map(float, spring.get("springlength").split())
        torque += float(spring.get("stiffness")) * (np.maximum(law.angle_rad - high, 0) + np.minimum(law.angle_rad - low, 0))
    np.testing.assert_allclose(torque, law.torque_nm, atol=1e-6 * law.torque_nm.max())


def test_texts_hold_the_law(drive):
    """Modelica and the comment for URDF hold every angle of the law; a comment ends once."""
    for kind, suffix in (("modelica", ".mo"), ("urdf-comment", ".urdf.xml")):
        assert main(["export", str(drive.folder), "--to", kind]) == 0
        text = (drive.folder / f"joint{suffix}").read_text()
        numbers = np.array(re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", text), float)
        assert all(np.isclose(numbers, a, rtol=1e-5, atol=0).any() for a in joint_law(drive).angle_rad)
    assert text.count("--") == 2


def test_calculix_finds_the_forces(drive, tmp_path):
    """CalculiX solves the deck: torque at the bottom within 0.1 %, largest ball within 2 % of the run, though the mesh is coarse."""
    pytest.importorskip("meshio")
    assert main(["export", str(drive.folder), "--to", "inp", "--out", str(tmp_path / "d.inp")]) == 0
    deck = (tmp_path / "d.inp").read_text()
    assert "torque 14000 N mm" in deck and deck.count("*STEP") == 1
    if not shutil.which("ccx"):
        pytest.skip("CalculiX is not installed")
    done = subprocess.run(["ccx", "-i", "d"], cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert "Job finished" in done.stdout, done.stdout[-2000:]
    sums: dict = {}
    for part in re.split(r"forces \(fx,fy,fz\) for set ", (tmp_path / "d.dat").read_text())[1:]:
        sums[part.split()[0]] = np.array([line.split()[1:4] for line in part.splitlines()[1:] if re.match(r"\s*\d+\s+\S+\s+\S+\s+\S+", line)], float)
    assert 8 * sums["HUB"][:, 1].sum() == pytest.approx(14000, rel=1e-3)
    balls = drive.balls["force_n"][drive.balls["step"] == drive.steps["step"][-1]]
    assert abs(sums["GROUND"][:, 0]).max() == pytest.approx(balls.max(), rel=0.02)


def test_a_deck_has_the_friction_of_every_step(tmp_path):
    """A friction that the torque finds another than the assembly is changed between their steps."""
    pytest.importorskip("meshio")
    run = hdengine.run(ROOT / "data/cd14.nml", tmp_path / "r.out", **{
        "mesh.divisions": 16, "mesh.band_facets": 3, "load.torque_steps": 1, "contact.torque_friction": 0.4, "output.vtu": "all"})
    values = re.findall(r"\*CHANGE FRICTION, INTERACTION=TOUCH\n\*FRICTION\n([\d.]+),", to_deck(run))
    assert [float(v) for v in values] == run.steps["friction"].tolist() and set(values) == {"0.15", "0.4"}


def test_a_deck_has_the_friction_of_the_flanks(tmp_path):
    """The forces on the rim turn it by the torque of the run, friction of the flanks included."""
    pytest.importorskip("meshio")
    run = hdengine.run(ROOT / "tests/cases/pressed_drive.nml", tmp_path / "d.out", **KEYS, load__tooth_friction=0.2, loop__torques=[14])
    assert abs(run.teeth["friction_n"]).max() > 1
    cards = to_deck(run).partition("*CLOAD, OP=NEW\n")[2].partition("*")[0].split()
    place = _grid(max(run.folder.glob("bodies_*.vtu"))).points
    moment = sum({"1": -place[int(n) - 1][1], "2": place[int(n) - 1][0]}.get(d, 0.0) * float(f)
                 for n, d, f in (line.split(",") for line in " ".join(cards).replace(", ", ",").split()))
    assert -moment == pytest.approx(14, rel=1e-6)


def test_a_pair_of_teeth_loads_the_nodes_beside_it():
    """The load of a pair lies on the two meridians beside its place, its middle at that place and at half of the loaded length; the moment of one along
    the rim is the arm, of which its radial forces hold what the teeth stand over the rim."""
    divisions, radius, ends, arm, apart = 12, 0.02, (0.3e-3, 1.5e-3), 0.03, 0.5
    angle, z = (grid.ravel() for grid in np.meshgrid(2 * np.pi * np.arange(divisions) / divisions, [0, 1e-3, 2e-3]))
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], 1)
    places = np.array([0.0, 0.3, 2.0, 4.5, 6.2, -0.1])
    for place, weights in zip(places, flank_weights(points, np.arange(len(points)), places, divisions, ends, radius, arm, apart)):
        nodes, (weight, tilt, shear) = np.array([*weights]), np.array([*weights.values()]).T
        off = (angle[nodes] - place + np.pi) % (2 * np.pi) - np.pi
        assert shear.sum() * radius == pytest.approx(arm) and tilt.sum() == pytest.approx(0, abs=1e-12)
        assert tilt @ off * radius == pytest.approx(radius - arm)  # as the way of a point on the tooth, which rises where the rim falls
        nodes, off, weight = nodes[weight > 0], off[weight > 0], weight[weight > 0]
        assert abs(off).max() < 2 * np.pi / divisions and weight @ off == pytest.approx(0, abs=1e-12)
        assert weight @ z[nodes] == pytest.approx(weight.sum() * sum(ends) / 2) and weight.sum() == pytest.approx(1)


def test_slanted_sides_look_outwards_by_their_cosine():
    """A side whose middle lies 60 degrees off the radius looks outwards by 0.5, an end by nothing: neither is one that presses; a radial one is."""
    for angle, found in ((60, 0), (0, 1)):
        along = np.array([[np.cos(np.radians(angle)), 0, np.sin(np.radians(angle))], [0, 1, 0], [0, 0, 1]])
        corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
        grid = SimpleNamespace(points=[0.02, -0.5e-3, 0] + 1e-3 * corners @ along, cells=[SimpleNamespace(data=np.arange(8)[None])],
                               cell_data={"body": [np.array([1])]})
        mesh = _Mesh(grid, {"mesh.element": "hex8i"})
        assert sorted(np.round(mesh.outward, 6))[::5] == pytest.approx([-np.cos(np.radians(angle)), np.cos(np.radians(angle))])
        assert len(mesh.facing(1, 1)) == found


def test_runs_without_a_loop_say_so(small_run, capsys):
    """A run that is no whole drive has no joint to export, and says what has; it has a deck, whose faces overlap by the interference or are the
    clearance apart, in mm."""
    assert main(["export", str(small_run), "--to", "csv"]) == 2 and "load.support = 'drive'" in capsys.readouterr().err
    pytest.importorskip("meshio")
    assert main(["export", str(small_run), "--to", "inp"]) == 0
    deck, run = (small_run / "deck.inp").read_text(), hdengine.load(small_run)
    assert deck.count("*STEP") == len(list(small_run.glob("bodies_*.vtu")))
    for interference, clearance in ((run.scene["wave_generator.interference"], 0.0), (0.0, 9e-6)):
        run.scene.update({"wave_generator.interference": interference, "wave_generator.clearance": clearance})
        apart = float(re.search(r"\*CLEARANCE, .*VALUE=(\S+)", to_deck(run))[1])
        assert apart == pytest.approx(1e3 * (clearance - interference)) and apart != 0
