# SPDX-License-Identifier: GPL-3.0-or-later
"""The reader of namelists under attack, and beside a reader that was not written here (f90nml)."""
import random
import subprocess
import time

import f90nml
import pytest

import hdengine
from conftest import ROOT, call

SCENES = sorted((ROOT / "data").glob("*.nml"))
PIECES = ["&load", "&mesh", "&", "&end", "/", "=", ",", "!", "torque", "divisions", "positions", "support", "title", "&output", "&run",
          "2147483647*1", "99999999999*1", "3*7", "0*1", "*", "1*", "1e400", "-1e-400", "1d3", "nan", "1+5", "'", "\"", "'hub'",
          "\t", "\r", "\n", "\0", "\x1b[31m", "\xff", "\xc3\xa9", "x" * 5000, " " * 5000, "7" * 300, ".5.", "e", "'it''s'", "0x10"]


@pytest.mark.parametrize("text, what", [
    ("&load torque = 2147483647*1, 2147483647*1, 3*7 /", "takes 1 value(s), 4294967297 found"),
    ("&output positions = 999999999*1, 999999999*1 /", "takes 3 value(s), 1999999998 found"),
    ("&load torque = 99999999999999999999*1 /", "is not a number"),
    ("&load torque = +1*1 /", "is not a number"),
    ("&load" + 4090 * " " + "torque = 100000 /\n&load torqe = 1 /", "unknown key 'torqe'"),
    ("&run title = '\xff\xfe' /", "not UTF-8"),
    ("&load torque = " + 100000 * "7" + " /", "is not a number"),
    ("&load /" * 5000, "more mistakes"), ("&load\n" + "".join(f"t{i} = 1\n" for i in range(401)) + "/", "and 1 more mistakes"),
    ("&loop torques = 5, , -5 /", "an empty place in 'torques'"), ("&loop torques = ,5 /", "an empty place in 'torques'"),
    ("&loop torques = 5,\n, -5 /", "an empty place in 'torques'"), ("&load torque = 1+13 /", "is not a number: '1+13'"),
    ("&loop torques = 1;2 /", "is not a number: '1;2'"),
])
def test_crafted_namelists_are_told(exe, tmp_path, text, what):
    """Repeat counts of any size, long lines, strange bytes and endless mistakes end with code 2 and a message of bearable length."""
    path = tmp_path / "a.nml"
    path.write_bytes(text.encode("latin-1"))
    done = subprocess.run([exe, path, "--check"], capture_output=True, timeout=60)
    assert done.returncode == 2 and what in done.stderr.decode() and len(done.stderr) < 200000
    with pytest.raises(hdengine.InputError):
        hdengine.read_scene(path)


@pytest.mark.parametrize("value", ["5, , -5", ",5", "5,-5,", "1;2", "1+13", "5 / -5", "", "5,'7'"])
def test_lists_on_the_command_line_have_no_empty_place(value):
    """A list in an assignment is as strict as in a file: an empty place, or what is no number, is an error that shows it."""
    with pytest.raises(hdengine.InputError, match="is not a number: '"):
        hdengine.read_scene(**{"loop.torques": value})


@pytest.mark.parametrize("key, written, plain", [
    ("geometry.wall_thickness", "0.36 mm", 0.36e-3), ("geometry.wall_thickness", "360 \u00b5m", 360e-6), ("geometry.wall_thickness", "3.6e-4 m", 3.6e-4),
    ("geometry.wall_thickness", "360 \u03bcm", 360e-6), ("geometry.wall_thickness", "0.36mm", 0.36e-3), ("geometry.wall_thickness", "3.6e-1 mm", 0.36e-3),
    ("geometry.wall_thickness", "0.014 in", pytest.approx(0.3556e-3, rel=1e-15)), ("geometry.wall_thickness", "0.036 cm", 0.36e-3), ("material.flexspline_e", "206 GPa", 206e9),
    ("material.flexspline_e", "206000 N/mm\u00b2", 206e9), ("load.torque", "7.8 N m", 7.8), ("load.torque", "7800 Nmm", 7.8), ("load.torque", "7.8 N\u00b7m", 7.8),
    ("load.pressure_angle_deg", "20\u00b0", 20), ("load.pressure_angle_deg", "0.5 rad", pytest.approx(28.64788975654116, rel=1e-15)), ("load.pressure_angle_deg", "90 arcmin", pytest.approx(1.5, rel=1e-15)),
    ("load.tooth_stiffness", "125 N/\u00b5m", 125e6), ("joint.s_min", "2 \u00b5m\u00b2", 2e-12), ("solver.time_limit_s", "2 h", 7200)])
def test_values_with_units(tmp_path, key, written, plain):
    """A value with its unit between quotes, in a file or from Python, is the same bits as in the key's unit, where a power of ten lies between."""
    group, name = key.split(".")
    (tmp_path / "a.nml").write_text(f"&hd_input\n version = 1\n/\n&{group}\n {name} = '{written}'\n/\n", encoding="utf-8")
    assert hdengine.read_scene(tmp_path / "a.nml")[key] == hdengine.read_scene(**{key: written})[key] == plain


@pytest.mark.parametrize("key, value, says_nothing", [
    ("wave_generator.clearance", 0.0, {"wave_generator.interference": 0.0}), ("wave_generator.clearance", 5e-6, {"wave_generator.interference": 0.0}),
    ("wave_generator.interference", 5e-6, {"wave_generator.clearance": 0.0}),
    ("load.tooth_clearance", 2e-5, {"load.tooth_gaps": [0.0], "load.tooth_gaps_back": [0.0]})])
def test_of_two_keys_for_one_thing_the_later_one_counts(key, value, says_nothing):
    """A fit, or a clearance of the teeth, that is given beside a file takes the place of what the file gives by the other key: a clearance of 0
    left the default's interference of 10 um, and an interference or a parabola beside the file's other key did nothing."""
    scene = hdengine.read_scene(ROOT / "data/drive14.nml", **{key: value})
    assert {name: scene[name] for name in (key, *says_nothing)} == {key: value, **says_nothing}
    assert hdengine.read_scene(ROOT / "data/drive14.nml")["wave_generator.interference"] == 0
    assert hdengine.read_scene(ROOT / "tests/cases/pressed_drive.nml", load__torque=3.0)["loop.torques"] == [0]
    gaps = hdengine.read_scene(ROOT / "data/drive14.nml")["load.tooth_gaps"]  # a list alone is that of both flanks
    assert hdengine.read_scene(ROOT / "data/drive14.nml", load__tooth_gaps=gaps)["load.tooth_gaps_back"] == [0.0]
    for clearance, left in ((0.0, 3e-6), (5e-6, 0.0)):  # both in one source
        both = hdengine.read_scene(wave_generator={"clearance": clearance, "interference": 3e-6})
        assert (both["wave_generator.clearance"], both["wave_generator.interference"]) == (clearance, left)


def test_lists_with_units(tmp_path):
    """Each number of a list may have its unit, in a file, in an assignment and from Python."""
    (tmp_path / "a.nml").write_text("&load tooth_pairs = 4, tooth_gaps = '2 um', 3e-6, '4um', '0.005 mm' /\n")
    assert hdengine.read_scene(tmp_path / "a.nml")["load.tooth_gaps"] == [2e-6, 3e-6, 4e-6, 5e-6]
    for value in ("2 um, 3e-6, 4um, 0.005 mm", ["2 um", 3e-6, "4um", "0.005 mm"]):
        assert hdengine.read_scene(load__tooth_pairs=4, load__tooth_gaps=value)["load.tooth_gaps"] == [2e-6, 3e-6, 4e-6, 5e-6]
    with pytest.raises(hdengine.InputError, match="or between quotes with one of mm, cm, um, nm, in"):
        hdengine.read_scene(geometry__wall_thickness="0.36 inches")


@pytest.mark.parametrize("value", ["0.36 inch", "0.36 MPa", "0.36 m mm", "'0.36'", "2*1 mm", "mm", "1e mm"])
def test_units_that_do_not_fit(value):
    """A unit that is unknown or of another kind, and a number between quotes, are no number."""
    with pytest.raises(hdengine.InputError, match="is not a number: '"):
        hdengine.read_scene(geometry__wall_thickness=value)


def test_long_lists_are_whole(tmp_path):
    """All 150 and all 400 clearances of a list come back: those beyond 100 were what lay behind an array."""
    for n in (150, 400):
        gaps = [1e-6 * (1 + i % 7) for i in range(n)]
        (tmp_path / "a.nml").write_text(f"&load support = 'drive', teeth = 402, tooth_pairs = {n}, tooth_gaps = {', '.join(map(repr, gaps))} /\n")
        assert hdengine.read_scene(tmp_path / "a.nml")["load.tooth_gaps"] == gaps


def test_texts_have_one_line(exe, tmp_path):
    """A line end in a text of the command line is refused, for no echo holds it; in a key from Python too, where it gave another key a value."""
    done = call(exe, ROOT / "data/cd14.nml", "run.title=a\nb", "--out", tmp_path / "o")
    assert done.returncode == 2 and "'title' has a line end: 'a?b'" in done.stderr and not (tmp_path / "o").exists()
    with pytest.raises(hdengine.InputError, match="valid is group.key"):
        hdengine.read_scene(**{"load.torque=3\nload.torque_steps": 7})


def test_quotes_in_texts_survive_the_echo(exe, tmp_path):
    """A doubled quote is one quote, in the scene, in the echo that is read back, and in the summary."""
    (tmp_path / "a.nml").write_text("&run title = 'it''s \"so\"' /\n&mesh divisions = 16, band_facets = 3 /\n")
    assert call(exe, tmp_path / "a.nml", "load.assembly_steps=1", "load.torque_steps=1", "--out", tmp_path / "o").returncode == 0
    assert hdengine.read_scene(tmp_path / "a.nml")["run.title"] == 'it\'s "so"'
    assert hdengine.read_scene(tmp_path / "o/echo.nml")["run.title"] == 'it\'s "so"'
    assert hdengine.load(tmp_path / "o").summary["title"] == 'it\'s "so"'


def test_nothing_hides_behind_a_column(tmp_path):
    """A value that crosses column 4096 is read whole."""
    path = tmp_path / "a.nml"
    for start in range(4076, 4100, 3):
        path.write_text("&load" + (start - 5) * " " + "torque = 100.5 /\n")
        assert hdengine.read_scene(path)["load.torque"] == 100.5


@pytest.mark.parametrize("body", ["\n" * 1_000_000, "!" + 10_000_000 * "x" + "\n", "! " + 200_000 * "&load torque = 1 /\n! " + "\n"])
def test_large_files_take_linear_time(tmp_path, body):
    """A million blank lines or a comment of ten megabytes are read in seconds."""
    path = tmp_path / "a.nml"
    path.write_text(body + "&load torque = 3 /\n")
    start = time.monotonic()
    assert hdengine.read_scene(path)["load.torque"] == 3
    assert time.monotonic() - start < 5


def test_random_namelists_end_in_order(exe, tmp_path):
    """Files put together at random are valid or refused with code 2 in UTF-8; none ends by a signal or silently."""
    draw, path = random.Random(31), tmp_path / "a.nml"
    for _ in range(40):
        text = " ".join(draw.choice(PIECES) for _ in range(draw.randrange(1, 30)))
        path.write_bytes(text.encode("latin-1"))
        done = subprocess.run([exe, path, "--check"], capture_output=True, timeout=60)
        assert done.returncode in (0, 2) and (done.returncode == 0) == (not done.stderr), text
        done.stderr.decode()


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_scenes_are_namelists_to_others(path):
    """f90nml reads every scene of data/ and finds the values that the engine finds."""
    scene = hdengine.read_scene(path)
    found = {f"{group}.{key}": value for group, keys in f90nml.read(path).items() for key, value in keys.items()}
    assert found and all(scene[key] == value for key, value in found.items())


def test_the_echo_is_a_namelist_to_others(small_run):
    """f90nml reads the echo of a run, every key of it, with the values of the run."""
    scene = hdengine.read_scene(small_run / "echo.nml")
    found = {f"{group}.{key}": value for group, keys in f90nml.read(small_run / "echo.nml").items() for key, value in keys.items()}
    lists = {key: [value] if isinstance(scene[key], list) and not isinstance(value, list) else value for key, value in found.items()}
    assert len(found) > 70 and {key: scene[key] for key in found} == lists


@pytest.mark.parametrize("coding", ["utf-16", "utf-16-be", "utf-32"])
def test_other_codings_are_one_error(exe, tmp_path, coding):
    """A scene in UTF-16 or UTF-32 ends with one line, of code 2, that says how to save it."""
    (tmp_path / "a.nml").write_text((ROOT / "data/cd14.nml").read_text(), encoding=coding)
    done = call(exe, tmp_path / "a.nml", "--check")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "save it as UTF-8" in done.stderr
