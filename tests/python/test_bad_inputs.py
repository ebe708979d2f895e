# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad inputs: exit code and the whole of stderr, and the same words as a Python exception."""
import os
import sys
from pathlib import Path

import pytest

import hdengine
from conftest import ROOT, call
from hdengine import files
from hdengine.record import Record
from hdengine.studies import planner, study, study_file
from hdengine.surfaces import specimen
from hdengine.teeth import rim_shape

HEAD = "&hd_input version = 1 /\n"

# name: (text of the file, exit code, whole stderr with {f} for the file)
CASES = {
    "misspelt_group": ("&geometri bore_radius = 1 /\n", 2, """\
error: unknown group &geometri
  --> {f}:1:1
 1 | &geometri bore_radius = 1 /
   | ^^^^^^^^^ did you mean 'geometry'?  valid: hd_input, run, geometry, cup, material, mesh, wave_generator, contact, load, \
bearing, loop, turning, fatigue, solver, joint, output, surface, fit
"""),
    "misspelt_key": ("&contact\n  frictoin = 0.2\n/\n", 2, """\
error: unknown key 'frictoin' in &contact
  --> {f}:2:3
 2 |   frictoin = 0.2
   |   ^^^^^^^^ did you mean 'friction'?  valid: mode, friction, torque_friction, law, zero_pressure, slave
"""),
    "key_without_neighbour": ("&contact qqqqqqqqq = 1 /\n", 2, """\
error: unknown key 'qqqqqqqqq' in &contact
  --> {f}:1:10
 1 | &contact qqqqqqqqq = 1 /
   |          ^^^^^^^^^ valid: mode, friction, torque_friction, law, zero_pressure, slave
"""),
    "word_for_number": ("&load torque = abc /\n", 2, """\
error: 'torque' is not a number: 'abc'
  --> {f}:1:16
 1 | &load torque = abc /
   |                ^^^ valid: number [N m]
"""),
    "real_for_integer": ("&mesh divisions = 80.5 /\n", 2, """\
error: 'divisions' is not an integer: '80.5'
  --> {f}:1:19
 1 | &mesh divisions = 80.5 /
   |                   ^^^^ valid: integer >= 8 and <= 100000
"""),
    "nan": ("&load torque = NaN /\n", 2, """\
error: 'torque' is not a number: 'NaN'
  --> {f}:1:16
 1 | &load torque = NaN /
   |                ^^^ valid: number [N m]
"""),
    "infinity": ("&wave_generator w = Infinity /\n", 2, """\
error: 'w' is not a number: 'Infinity'
  --> {f}:1:21
 1 | &wave_generator w = Infinity /
   |                     ^^^^^^^^ valid: number >= 0.0 [m]
"""),
    "negative_size": ("&geometry wall_thickness = -1e-3 /\n", 2, """\
error: 'wall_thickness' is out of range: -1e-3
  --> {f}:1:28
 1 | &geometry wall_thickness = -1e-3 /
   |                            ^^^^^ valid: number > 0.0 [m]
"""),
    "zero_size": ("&geometry ring_thickness = 0 /\n", 2, """\
error: 'ring_thickness' is out of range: 0
  --> {f}:1:28
 1 | &geometry ring_thickness = 0 /
   |                            ^ valid: number > 0.0 [m]
"""),
    "unterminated_text": ("&load support = 'hub /   \n", 2, """\
error: unterminated text
  --> {f}:1:17
 1 | &load support = 'hub /
   |                 ^^^^^^ the closing ' is missing
error: group &load is not closed
  --> {f}:1:1
 1 | &load support = 'hub /
   | ^^^^^ its '/' is missing at the end
"""),
    "missing_slash": ("&load torque = 1\n", 2, """\
error: group &load is not closed
  --> {f}:1:1
 1 | &load torque = 1
   | ^^^^^ its '/' is missing at the end
"""),
    "missing_slash_before_group": ("&load torque = 1\n&mesh divisions = 20 /\n", 2, """\
error: group &load is not closed
  --> {f}:1:1
 1 | &load torque = 1
   | ^^^^^ end it with '/' before the next group
"""),
    "empty_file": ("", 2, """\
error: the file holds no group
  --> {f}:1:1
 1 |{blank}
   | ^ an empty scene is written as "&hd_input version = 1 /"
"""),
    "text_outside": ("hello = 3\n" + HEAD, 2, """\
error: text outside a group
  --> {f}:1:1
 1 | hello = 3
   | ^^^^^ groups start with '&name'
"""),
    "no_value": ("&load torque = /\n", 2, """\
error: 'torque' has no value
  --> {f}:1:7
 1 | &load torque = /
   |       ^^^^^^ write 'key = value'
"""),
    "no_equals": ("&load torque 5 /\n", 2, """\
error: 'torque' stands alone in &load
  --> {f}:1:7
 1 | &load torque 5 /
   |       ^^^^^^ write 'key = value'
error: '5' stands alone in &load
  --> {f}:1:14
 1 | &load torque 5 /
   |              ^ write 'key = value'
"""),
    "key_twice": ("&load torque = 1, torque = 2 /\n", 2, """\
error: key 'torque' stands twice in &load
  --> {f}:1:19
 1 | &load torque = 1, torque = 2 /
   |                   ^^^^^^ keep one
"""),
    "group_twice": ("&load torque = 1 /\n&load /\n", 2, """\
error: group &load stands twice
  --> {f}:2:1
 2 | &load /
   | ^^^^^ keep one
"""),
    "too_many_values": ("&load torque = 1, 2 /\n", 2, """\
error: 'torque' takes 1 value(s), 2 found
  --> {f}:1:16
 1 | &load torque = 1, 2 /
   |                ^ valid: number [N m]
"""),
    "too_few_values": ("&output positions = 1e-3 /\n", 2, """\
error: 'positions' takes 3 value(s), 1 found
  --> {f}:1:21
 1 | &output positions = 1e-3 /
   |                     ^^^^ valid: number >= 0.0 [m]
"""),
    "wrong_choice": ("&load support = 'huub' /\n", 2, """\
error: 'support' has no choice 'huub'
  --> {f}:1:17
 1 | &load support = 'huub' /
   |                 ^^^^^^ did you mean 'hub'?  valid: hub, bearing, teeth, drive
"""),
    "text_too_long": ("&run title = '" + "x" * 121 + "' /\n", 2, """\
error: 'title' is too long: 121 characters
  --> {f}:1:14
 1 | &run title = '""" + "x" * 121 + """' /
   |              """ + "^" * 123 + """ valid: up to 120 characters
"""),
    "zero_elements": ("&mesh band_facets = 0 /\n", 2, """\
error: 'band_facets' is out of range: 0
  --> {f}:1:21
 1 | &mesh band_facets = 0 /
   |                     ^ valid: integer >= 1 and <= 10000
"""),
    "negative_friction": ("&contact friction = -0.1 /\n", 2, """\
error: 'friction' is out of range: -0.1
  --> {f}:1:21
 1 | &contact friction = -0.1 /
   |                     ^^^^ valid: number >= 0.0 and <= 10.0
"""),
    "dimension_2": ("&joint fractal_dimension = 2 /\n", 2, """\
error: 'fractal_dimension' is out of range: 2
  --> {f}:1:28
 1 | &joint fractal_dimension = 2 /
   |                            ^ valid: number > 2.0 and < 3.0
"""),
    "dimension_3": ("&joint fractal_dimension = 3.0 /\n", 2, """\
error: 'fractal_dimension' is out of range: 3.0
  --> {f}:1:28
 1 | &joint fractal_dimension = 3.0 /
   |                            ^^^ valid: number > 2.0 and < 3.0
"""),
    "incompressible": ("&material ring_nu = 0.5 /\n", 2, """\
error: 'ring_nu' is out of range: 0.5
  --> {f}:1:21
 1 | &material ring_nu = 0.5 /
   |                     ^^^ valid: number > -0.5 and < 0.5
"""),
    "wall_thicker_than_radius": ("&geometry wall_thickness = 20e-3 /\n", 2, """\
error: geometry.wall_thickness = 0.02
      valid: below bore_radius (0.0175)
"""),
    "hub_outside": ("&geometry hub_radius = 18e-3 /\n", 2, """\
error: geometry.hub_radius = 0.018
      valid: below bore_radius (0.0175)
"""),
    "hub_that_is_a_point": ("&geometry hub_radius = 1e-300 /\n", 2, """\
error: geometry.hub_radius = 1.0e-300
      valid: at least a ten-thousandth of bore_radius, for a bottom that is held at a point turns freely (1.75e-6)
hint: geometry.hub_radius = 1.0e-300 m is unusual: usual are 0.002 to 0.2 m
"""),
    "cells_without_end": ("&geometry cup_length = 200 /\n", 2, """\
error: geometry.band_length = 0.012
      valid: so long that less than 100000 cells as long as its facets lie along the cup, or mesh.wall_elements and mesh.bottom_elements given; above (0.0300014)
hint: geometry.cup_length = 200.0 m is unusual: usual are 0.005 to 0.4 m; did you mean 0.2 m (200.0 mm)?
"""),
    "band_beyond_cup": ("&geometry band_length = 30e-3 /\n", 2, """\
error: geometry.band_length = 0.03
      valid: so that the band ends before the bottom: below cup_length - bottom_thickness - band_start (0.019)
"""),
    "wavelength_above_sample": ("&joint shortest_wavelength = 1e-3 /\n", 2, """\
error: joint.shortest_wavelength = 0.001
      valid: below sample_length (5.0e-4)
hint: joint.shortest_wavelength = 0.001 m is unusual: usual are 1.0e-9 to 1.0e-4 m; did you mean 1.0e-6 m (0.001 mm)?
"""),
    "wrong_version": ("&hd_input version = 2 /\n", 2, """\
error: 'version' is out of range: 2
  --> {f}:1:21
 1 | &hd_input version = 2 /
   |                     ^ valid: integer >= 1 and <= 1
"""),
    "several_at_once": ("&load torque = x /\n&mesh divisons = 20 /\n", 2, """\
error: 'torque' is not a number: 'x'
  --> {f}:1:16
 1 | &load torque = x /
   |                ^ valid: number [N m]
error: unknown key 'divisons' in &mesh
  --> {f}:2:7
 2 | &mesh divisons = 20 /
   |       ^^^^^^^^ did you mean 'divisions'?  valid: divisions, band_facets, ring_divisions, ring_facets, wall_elements, \
bottom_elements, through_wall, through_ring, edge_length, element, memory_limit_mb
"""),
    "too_large": ("&mesh divisions = 100000, band_facets = 5000, memory_limit_mb = 1000 /\n", 6, None),
}


@pytest.mark.parametrize("name", CASES)
def test_bad_file(exe, tmp_path, name):
    """The mistake is named with file, line, caret and what is valid; nothing is written; Python says the same."""
    text, code, expected = CASES[name]
    file = tmp_path / "in.nml"
    file.write_text(text)
    done = call(exe, file, cwd=tmp_path)
    assert done.returncode == code
    assert done.stdout == ""
    if expected is None:
        assert "MB, the limit is 1000 MB" in done.stderr and "mesh.divisions (100000)" in done.stderr
    else:
        assert done.stderr == expected.format(f=file, blank=" ")
    assert [p.name for p in tmp_path.iterdir()] == ["in.nml"]
    kind = {2: hdengine.InputError, 6: hdengine.EngineMemoryError}[code]
    with pytest.raises(kind) as caught:
        hdengine.Run(file)
    if expected is not None:
        assert str(caught.value) == expected.format(f=file, blank=" ").strip().removeprefix("error: ")


def test_a_body_without_a_free_node(exe, tmp_path):
    """A ring so thin that all its nodes lie on the wave generator is a body that nothing holds, code 5: it was read beyond its end."""
    done = call(exe, ROOT / "data/cd14.nml", "mesh.divisions=16", "mesh.band_facets=3", "geometry.ring_thickness=1e-12", "--allow-implausible",
                "--out", tmp_path / "r", env=os.environ | {"OMP_NUM_THREADS": "4"})
    assert done.returncode == 5 and "a body is not held" in done.stderr, done


def test_missing_file(exe, tmp_path):
    """A file that does not exist is an error of its own kind."""
    done = call(exe, tmp_path / "none.nml")
    assert (done.returncode, done.stderr) == (3, f"error: input file '{tmp_path}/none.nml' does not exist\n")
    with pytest.raises(hdengine.FileError, match="does not exist"):
        hdengine.Run(tmp_path / "none.nml")


@pytest.fixture(scope="module")
def odd(tmp_path_factory):
    """Files that are none: a pipe that nobody writes to, an endless device, a folder, three gigabytes of nothing."""
    folder = tmp_path_factory.mktemp("odd")
    os.mkfifo(folder / "pipe")
    with open(folder / "sparse", "wb") as file:
        file.truncate(3 * 2**30)
    return [str(folder / "pipe"), "/dev/zero", str(folder), str(folder / "sparse")]


KEYS = {"cam_file": ("load.support=drive", "wave_generator.cam=table", "wave_generator.cam_file={}"), "input": ("{}",),
        "table_file": ("joint.model=table", "joint.table_file={}"), "spectrum_file": ("joint.model=spectrum", "joint.spectrum_file={}"),
        "first_file": ("surface.nx=8", "fit.dx=1e-6", "fit.first_file={}.npy")}


@pytest.mark.parametrize("key", KEYS)
def test_every_key_opens_files_alone(exe, tmp_path, odd, key):
    """What is no file that ends is refused at once, with code 3 and one line, whichever key names it."""
    (tmp_path / "in.nml").write_text(HEAD)
    for i, path in enumerate(odd):
        if key == "first_file" and i != 2:
            (tmp_path / f"{i}.npy").symlink_to(path)
        words = [word.format(tmp_path / str(i) if key == "first_file" and i != 2 else path) for word in KEYS[key]]
        done = call(exe, *([] if key == "input" else [tmp_path / "in.nml"]), *words, "--out", tmp_path / "o", timeout=20)
        assert done.returncode == 3 and done.stderr.count("\n") == 1 and done.stderr.startswith("error: "), done.stderr


@pytest.mark.parametrize("reader", [
    specimen.read, Record.read, planner.plan, study_file._text, files.read_json, study.read_rows, rim_shape.read_grid,
], ids=lambda f: f.__qualname__)
def test_every_reader_opens_files_alone(odd, reader):
    """The same in Python."""
    for path in odd[:3] + odd[3:] * (reader not in (study.read_rows, rim_shape.read_grid)):
        with pytest.raises(hdengine.FileError, match="an input file|is no file|bytes|no text"):
            reader(Path(path))


def test_unwritable_output(exe, tmp_path):
    """An output folder that cannot be made is refused before anything is computed."""
    file = tmp_path / "in.nml"
    file.write_text(HEAD)
    out = file / "below"
    done = call(exe, file, "--out", out)
    assert done.returncode == 3
    assert done.stderr == f"error: cannot make the folder '{out}': Not a directory; its parent must exist and be writable: make it, or choose another folder with --out DIR\n"


def test_output_is_a_file(exe, tmp_path):
    """An output folder whose name is taken by a file is refused."""
    file = tmp_path / "in.nml"
    file.write_text(HEAD)
    done = call(exe, file, "--out", file)
    assert (done.returncode, done.stderr) == (
        3, f"error: '{file}' is a file, not a folder: choose another with --out DIR\n")


@pytest.mark.parametrize("args, expected", [
    ([], "error: no input file; usage: hdengine.x [options] input.nml (see hdengine.x --help)\n"),
    (["--chekc"], "error: unknown option '--chekc'\n      did you mean '--check'?  valid: --check, --plan, --explain, --force, "
     "--resume, --help, --out, --version, --license, --citation, --allow-implausible, -q, -v\n"),
    (["a.nml", "b.nml"], "error: two input files: 'a.nml' and 'b.nml'; valid: one\n"),
    (["a.nml", "--out", ""], "error: --out needs a value; see hdengine.x --help\n"),
    (["--out"], "error: --out needs a value; see hdengine.x --help\n"),
    (["a.nml", "--out", "--force"], "error: --out needs a value; see hdengine.x --help\n"),
    (["a.nml", "--out", "b", "--out", "c"], "error: --out is given twice: 'b' and again; valid: once\n"),
    (["--explain", "frcition"], None),
])
def test_usage(exe, args, expected):
    """A wrong command line ends with code 2 and says what is right."""
    done = call(exe, *args)
    assert done.returncode == 2
    if expected is None:
        assert "no key 'frcition'" in done.stderr and "did you mean 'friction'?" in done.stderr
    else:
        assert done.stderr == expected


def test_a_ring_that_no_ball_carries_is_named(exe, tmp_path):
    """A round cam leaves the ring loose among its balls: the error says which keys make them carry."""
    done = call(exe, ROOT / "data/drive14.nml", "mesh.divisions=24", "mesh.band_facets=4", "wave_generator.w=0", "--out", tmp_path / "o")
    assert done.returncode == 5 and "lower bearing.clearance or raise wave_generator.w" in done.stderr


@pytest.mark.parametrize("keys, named, way_out", [
    (["wave_generator.cam=table"], "wave_generator.cam = 'table'", "wave_generator.cam_file"),
    (["load.support=drive", "wave_generator.ring_contact=unilateral"], "wave_generator.ring_contact = 'unilateral'", "'tied'"),
    (["load.support=drive", "solver.kinematics=nonlinear", "solver.method=condensed"], "solver.kinematics = 'nonlinear'", "'linear'"),
    (["load.support=bearing", "contact.mode=frictionless"], "contact.mode = 'frictionless'", "'frictional'"),
    (["contact.law=joint", "contact.mode=bonded"], "contact.law = 'joint'", "'hard'"),
    (["run.tolerance=1e-4"], "run.tolerance = 1.0e-4", "0.0066"),
    (["wave_generator.cam=cosine", "wave_generator.lobes=24"], "mesh.divisions = 86", "at least (96)"),
    (["load.support=drive", "wave_generator.cam=cosine", "wave_generator.lobes=3"], "wave_generator.lobes = 3", "2 with teeth"),
    (["load.torque_load=teeth", "wave_generator.cam=cosine", "wave_generator.lobes=4"], "wave_generator.lobes = 4", "2 with teeth"),
    (["load.torque_load=teeth", "load.tooth_phase=0.3"], "load.tooth_phase = 0.3", "0, but with load.support = 'drive' or 'teeth'"),
])
def test_choices_that_do_not_fit_are_named(exe, tmp_path, keys, named, way_out):
    """The message names the key that does not fit, with its value, and what would fit."""
    file = tmp_path / "in.nml"
    file.write_text(HEAD)
    done = call(exe, file, *keys)
    assert done.returncode == 2 and f"error: {named}\n      valid: " in done.stderr and way_out in done.stderr


def test_nothing_in_contact_warns(exe, tmp_path):
    """A ring that is smaller than the bore by almost a millimetre touches nothing: the run says so and what to do."""
    file = tmp_path / "in.nml"
    file.write_text(HEAD)
    done = call(exe, file, "wave_generator.clearance=0.9e-3", "mesh.divisions=16", "mesh.band_facets=3", "--out", tmp_path / "o")
    assert done.returncode == 0 and "warning: nothing is in contact" in done.stdout and "Raise wave_generator.interference" in done.stdout


def test_bad_assignment(exe, tmp_path):
    """Assignments on the command line are checked like the file."""
    file = tmp_path / "in.nml"
    file.write_text(HEAD)
    done = call(exe, file, "load.torqe=3", "mesh.divisions=ten", "nonsense=")
    assert done.returncode == 2
    assert done.stderr == """\
error: unknown key 'torqe' in &load
  --> load.torqe=3
      did you mean 'torque'?  valid: support, torque_load, teeth, tooth_pairs, pressure_angle_deg, tooth_stiffness, tooth_gaps, tooth_gaps_back, tooth_clearance, tooth_friction, spline, spline_diameter, spline_root_diameter, spline_width, tooth_phase, torque, support_stiffness, assembly_steps, torque_steps, tangent_steps
error: 'divisions' is not an integer: 'ten'
  --> mesh.divisions=ten
      valid: integer >= 8 and <= 100000
error: 'nonsense=' is no assignment
  --> nonsense=
      write group.key=value
"""
    with pytest.raises(hdengine.InputError, match="did you mean 'torque'"):
        hdengine.Run(load={"torqe": 3})


def test_long_messages_are_whole(exe, tmp_path):
    """The exception holds every mistake of a file, as the command shows them, however many there are."""
    file = tmp_path / "in.nml"
    file.write_text(HEAD + "&contact\n" + "".join(f"  frictoin_{i} = 0.2\n" for i in range(300)) + "/\n")
    with pytest.raises(hdengine.InputError) as caught:
        hdengine.read_scene(str(file))
    assert "frictoin_299" in str(caught.value)
    assert str(caught.value) == call(exe, file).stderr.strip().removeprefix("error: ")


def test_long_lines_are_whole(tmp_path):
    """A line of an input file counts to its end, however long it is, the last one without its end too."""
    file = tmp_path / "in.nml"
    file.write_text(HEAD + "&load" + " " * 5000 + "torque = 3.25 /\r\n&joint gamma = 1.25 /")
    scene = hdengine.read_scene(str(file))
    assert (scene["load.torque"], scene["joint.gamma"]) == (3.25, 1.25)


@pytest.mark.parametrize("words, text, where", [
    (["joint.model=table", "joint.table_file={}"], "pressure_pa,k_n_pa_per_m\n1e5,1e12\n1e7,nan\n", "line 3: column k_n_pa_per_m: 'nan'"),
    (["joint.model=spectrum", "joint.spectrum_file={}"], "q_per_m,height_variance_m2\n1e4,1e-14\n1e5,NaN\n", "line 3: column height_variance_m2: 'NaN'"),
    (["joint.model=table", "joint.table_file={}"], "pressure_pa,k_n_pa_per_m,k_n_pa_per_m\n1e5,1e12,2e12\n1e7,2e12,3e12\n", "column 'k_n_pa_per_m' stands twice"),
    (["wave_generator.cam=table", "wave_generator.cam_file={}"], "theta_deg,radius_m\n0,0.0165\nNaN,0.0165\n", "line 3: column theta_deg: 'NaN'"),
    (["record", "{}"], "torque_nm,angle_arcsec\n0.1,1\n0.2,nan\n0.3,3\n", "line 3: column angle_arcsec: 'nan'"),
    (["surface", "{}", "--unit", "m"], "0,nan\n1e-6,nan\n2e-6,nan\n", "every point is NaN")])
def test_nan_in_tables_is_named(exe, tmp_path, words, text, where):
    """A table with a NaN for a number, or a map of nothing else, is an error of one line that says where."""
    path = tmp_path / "t.csv"
    path.write_text(text)
    words = [word.format(path) for word in words]
    command = [exe, ROOT / "data/cd14.nml", *words] if "=" in words[0] else [sys.executable, "-m", "hdengine", *words]
    done = call(command[0], *command[1:], "--out", tmp_path / "r")
    assert done.returncode in (2, 3) and done.stderr.startswith("error: ") and where in done.stderr, done.stderr
    assert done.stderr.count("error: ") == 1 and not (tmp_path / "r/summary.json").exists()


@pytest.mark.parametrize("scene, words, told", [
    ("cd14", ["bearing.ball_diameter=0.003", "fatigue.notch_factor=2", "load.spline=rigid"],
     "this scene does not use load.spline, bearing.ball_diameter, fatigue.notch_factor: take it out"),
    ("paper", ["joint.s_min=1e-12", "joint.table_file=t.csv"], "this scene does not use joint.table_file: take it out"),
    ("drive14", ["joint.s_min=1e-12", "contact.mode=bonded", "contact.friction=0.2", "turning.torque=2", "bearing.balls=0", "bearing.ball_diameter=0.003"],
     "does not use contact.friction, bearing.ball_diameter, bearing.clearance, turning.torque, joint.s_min: take it out"),
    ("drive14", ["cup.sections_fillet=1e-3"], "does not use cup.sections_fillet: take it out"), ("drive14_hat", ["contact.friction=0.2"], ""),
    ("cd14", ["wave_generator.w=0"], "the cup stays round"), ("drive14", ["load.teeth=201"], "load.teeth = 201 is odd"),
    ("cd14", ["bearing.ball_diameter=0.0032", "contact.friction=0.2", "joint.sample_length=1e-3"], "")])
def test_keys_that_change_nothing_are_said(exe, scene, words, told):
    """A key that differs from its default and is of a part that the scene lacks is named, as are a round cam and an odd number of teeth; a scene whose
    keys all count, and values that are the defaults, are passed in silence."""
    done = call(exe, ROOT / f"data/{scene}.nml", *words, "--check")
    assert done.returncode == 0 and told in done.stdout + done.stderr
    assert ("warning: " in done.stdout + done.stderr) == bool(told)
