# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of the test bench: the stiffness put in comes out, within a band that covers it as often as it says."""
import json
import re
import sys

import numpy as np
import pytest

import hdengine
from conftest import ROOT, call
from hdengine.catalogue import UNITS
from hdengine.cli import main
from hdengine.record import ARCSEC, Record
from hdengine.smoothing import Spline, basis
from hdengine.table_file import read_csv

sys.path.insert(0, str(ROOT / "data"))
import make_torque_record as bench  # noqa: E402


def test_committed_record_is_that_of_the_script():
    """data/torque_record.csv is what data/make_torque_record.py writes."""
    torque, turn = bench.record()
    r = Record.read(ROOT / "data/torque_record.csv")
    np.testing.assert_allclose(r.torque_nm, torque, atol=1e-9)
    np.testing.assert_allclose(r.angle_rad, turn, atol=0.006 * ARCSEC)


def test_perfect_readings_give_the_curve():
    """Without errors the middle curve's stiffness is met to 2 % from 0.5 to 4.8 N m, the hysteresis to 2 %."""
    t = np.concatenate([np.arange(5, -5, -0.01), np.arange(-5, 5.005, 0.01)])
    sense = np.where(np.arange(len(t)) < 1000, -1, 1)
    r = Record(t, bench.angle(t) - sense * bench.WIDTH * (1 - (t / 5)**2), 0, 0)
    curve = r.curve(draws=2)
    at = np.linspace(0.5, 4.8, 20)
    k = np.interp(at, curve.torque_nm, curve.stiffness_nm_per_rad)
    np.testing.assert_allclose(k, bench.stiffness(at), rtol=0.02)
    numbers = r.numbers(rated_torque_nm=5, draws=2)
    assert numbers["hysteresis_rad"][0] == pytest.approx(2 * bench.WIDTH, rel=0.02)
    assert numbers["lost_motion_rad"][0] == pytest.approx(2 * bench.angle(0.2), rel=0.02)
    assert numbers["k1_nm_per_rad"][0] == pytest.approx(2 / (bench.angle(2.0) + bench.WIDTH * 0.4**2), rel=0.01)


def test_band_covers_the_truth():
    """Over 12 records with fresh errors the 95 % bands hold K1 and K(3 N m) at least 10 times, and are no wider than 6 %."""
    hits, chords = 0, 0
    for seed in range(12):
        r = Record(*bench.record(seed))
        value, low, high = r.curve(points=51, draws=40).at(3.0)
        hits += low <= bench.stiffness(3.0) <= high
        value, low, high = r.numbers(draws=40)["k1_nm_per_rad"]
        chords += low <= 2 / (bench.angle(2.0) + bench.WIDTH * 0.4**2) <= high
        assert (high - low) / value < 0.06
    assert hits >= 10 and chords >= 10


def kinked(seed, count, even):
    """A loop of 24" with slopes of 4700, 6100 and 7100 N m/rad from 0, 2 and 6.9 to 9 N m, read with 0.4" and 0.01 N m of noise."""
    generator, torques, turns = np.random.default_rng(seed), [], []
    for start, end in ((0, 9), (9, -9), (-9, 9)):
        x = np.linspace(0, 1, count) if even else np.r_[0, np.sort(generator.uniform(0, 1, count))[1:-1], 1]
        t = start + (end - start) * x
        torques.append(t)
        turns.append(UNITS[14].angle(t) - (np.sign(end - start) * 12 * ARCSEC * (1 - (t / 9)**4) if start else 0))
    torque = np.concatenate(torques)
    return torque + generator.normal(0, 0.01, torque.size), np.concatenate(turns) + generator.normal(0, 0.4 * ARCSEC, torque.size)


def test_short_and_uneven_records_are_smoothed():
    """What is read of few or uneven readings lies within 20 % of the truth, and one band in ten misses it at most: splines through the readings made
    2" of 24" of hysteresis, 1693" of 27" of lost motion and K1 of 1402 for 4698. Readings too far apart next to zero are refused, most are not."""
    turn = [UNITS[14].angle(t) + 12 * ARCSEC * (t / 9)**4 for t in (2, 6.9, 9)]
    truth = {"hysteresis_rad": 24 * ARCSEC, "lost_motion_rad": 2 * UNITS[14].angle(0.312), "k1_nm_per_rad": 2 / turn[0],
             "k2_nm_per_rad": 4.9 / (turn[1] - turn[0]), "k3_nm_per_rad": 2.1 / (turn[2] - turn[1])}
    held = []
    for count, even, seed in [*((30, True, s) for s in range(5)), (40, True, 0), *((60, False, s) for s in range(4)), (150, False, 0)]:
        try:
            numbers = Record(*kinked(seed, count, even)).numbers(draws=40)
        except hdengine.InputError as error:
            assert not even and "N m between them; needed: 12 or more" in str(error)
            continue
        for name, true in truth.items():
            assert numbers[name][0] == pytest.approx(true, rel=0.2), (name, count, seed)
            held.append(numbers[name][1] <= true <= numbers[name][2])
    assert len(held) >= 40 and np.mean(held) >= 0.9


def test_too_few_readings_are_refused(tmp_path):
    """Ten readings a branch, even or not, or none near zero torque, are refused with the file, what there is and what is needed: they had figures."""
    torque, turn = kinked(0, 200, True)
    for t, a, says in ((*kinked(0, 10, True), "branch has 5 readings below and 5 above zero torque"), (*kinked(1, 12, False), "needed: 12 or more"),
                       (torque[abs(torque) > 0.6], turn[abs(torque) > 0.6], r"1\.\d* N m between them; needed: 12 or more, and at most 0\.9")):
        np.savetxt(tmp_path / "few.csv", np.c_[t, a], delimiter=",", header="torque_nm,angle_rad", comments="")
        with pytest.raises(hdengine.InputError, match=rf"few\.csv.*{says}"):
            Record.read(tmp_path / "few.csv")


def test_no_stiffness_beyond_the_torques():
    """At a torque that the record does not reach the stiffness and its band are NaN: the last were given."""
    curve = Record(*kinked(0, 60, True)).curve(points=5, draws=2)
    assert np.isnan(curve.at(100.0)).all() and np.isnan(curve.at(-100.0)).all() and np.isfinite(curve.at(8.0)).all()


@pytest.mark.parametrize(("size", "play", "offset"), [(14, 0, 0), (14, 1, 0.03), (14, 2, 0), (20, 0, 0), (20, 1, 0), (20, 2, -0.03)])
def test_a_loop_with_play_reads_as_its_run(exe, tmp_path, size, play, offset):
    """The engine's loop, read by a bench with 5 urad and 0.01 N m of noise, a torque that is off and play of 0 to 2 um in the closest pair, has the
    readings of its run: hysteresis to 6 % or two readings' noise (ten noises read the 57 urad of size 20
    without play as 50 +- 4), lost motion and K1 to K3 to 3 %. A spline across the jump read 38 to 71 % less
    hysteresis."""
    scene = (ROOT / f"data/drive{size}.nml").read_text()
    gaps = {key: np.array(re.search(rf"{key} = (.*)", scene)[1].split(","), float) for key in ("tooth_gaps", "tooth_gaps_back")}
    shift, top = play * 1e-6 - min(map(min, gaps.values())), float(re.search(r"\n  torque = (.*)", scene)[1])
    ends = [f"{share * top:.6g}" for share in (1, .05, .004, 0, -.004, -.05, -1, -.05, -.004, 0, .004, .05, 1)]
    done = call(exe, ROOT / f"data/drive{size}.nml", *(f"load.{key}={','.join(f'{g + shift:.6g}' for g in gap)}" for key, gap in gaps.items()),
                f"loop.torques={','.join(ends)}", "load.torque_steps=14", "mesh.divisions=24", "mesh.band_facets=4",
                "output.vtu=none", "run.band=.false.", "load.tangent_steps=none", "--out", tmp_path / "r", "-q")
    assert done.returncode == 0, done.stderr
    run, loop = json.loads((tmp_path / "r/summary.json").read_text())["results"], read_csv(tmp_path / "r/loop.csv")
    way = np.r_[0, np.cumsum(abs(np.diff(loop["torque_nm"])))]
    noise, time = np.random.default_rng(size), np.arange(0, way[-1], top / 400)
    torque, turn = (np.interp(time, way, loop[name]) + noise.normal(0, error, time.size) for name, error in (("torque_nm", 0.01), ("angle_rad", 5e-6)))
    read = Record(torque + offset, turn).numbers(UNITS[size], draws=2)
    assert read.pop("hysteresis_rad")[0] == pytest.approx(run["hysteresis_rad"], rel=0.06, abs=10e-6)
    ends_at = loop["angle_rad"][abs(loop["torque_nm"] - top) < 1e-9]
    assert read.pop("closing_rad")[0] == pytest.approx(ends_at[-1] - ends_at[0], abs=6e-6)   # what the run's own loop leaves open
    for name, value in read.items():
        assert value[0] == pytest.approx(run[name], rel=0.03), name


def test_a_loop_that_drifts_says_so(tmp_path, capsys):
    """An angle that creeps by 1 urad a reading leaves the loop open by that of both branches, to 2 %, and half of it is lost to the hysteresis: it was
    told nowhere. A loop that closes has none, one that ends elsewhere no value."""
    torque, turn = bench.record()
    for creep in (0, 1e-6):
        numbers = Record(torque, turn + creep * np.arange(len(torque))).numbers(draws=2)
        assert numbers["closing_rad"][0] == pytest.approx(creep * 1000, rel=0.02, abs=2e-6)
        np.savetxt(tmp_path / "r.csv", np.c_[torque, turn + creep * np.arange(len(torque))], delimiter=",", header="torque_nm,angle_rad", comments="")
        assert main(["record", str(tmp_path / "r.csv"), "--out", str(tmp_path / "o"), "--force"]) == 0
        assert ("does not close" in capsys.readouterr().out) == (creep > 0)
    assert np.isnan(Record(torque[:-30], turn[:-30]).numbers(draws=2)["closing_rad"][0])


def test_branches_are_found():
    """A virgin branch and a loop make three branches; without a loop the record is refused."""
    torque, turn = bench.record()
    r = Record(torque, turn)
    assert len(r.branches) == 3 and r.torque_nm[r.up][-1] > 4.9 and r.torque_nm[r.down][-1] < -4.9
    few = np.concatenate([np.linspace(*ends, 32, endpoint=False) for ends in ((0, 28), (28, -28), (-28, 28), (28, 0))] + [[0.0]])
    stiff = Record(few, few / 2e4)   # a branch has both of its ends
    assert stiff.torque_nm[stiff.up].tolist() == np.linspace(-28, 28, 33).tolist() and stiff.torque_nm[stiff.down][[0, -1]].tolist() == [28, -28]
    assert stiff.numbers(UNITS[20], draws=2)["k3_nm_per_rad"][0] == pytest.approx(2e4)
    assert stiff.numbers(UNITS[20], draws=2)["lost_motion_rad"][0] == pytest.approx(0.08 * 40 / 2e4)   # at 4 % of the size's rated torque
    with pytest.raises(hdengine.InputError, match="no rising branch"):
        Record(torque[:250], turn[:250])
    with pytest.raises(hdengine.InputError, match="as many torques as angles"):
        Record(torque, turn[:-1])


def test_columns_are_named(tmp_path):
    """A table without the needed columns is refused with its first line and their names."""
    for line in ("t,a", "Torque [Nm];Angle [deg]"):
        (tmp_path / "r.csv").write_text(f"{line}\n1,2\n3,4\n" if "," in line else f"{line}\n1;2\n3;4\n")
        with pytest.raises(hdengine.InputError, match=rf"begins with '{re.escape(line)}'; needed: a line of names, torque_nm and .*angle_arcsec"):
            Record.read(tmp_path / "r.csv")


def test_gaps_are_no_readings(tmp_path):
    """An empty cell among whole numbers is refused, not read as -1."""
    (tmp_path / "r.csv").write_text("torque_nm,angle_arcsec\n" + "".join(f"{t},{'' if i == 30 else 2 * t}\n" for i, t in enumerate(range(-40, 41))))
    with pytest.raises(hdengine.InputError, match=r"line 32: column angle_arcsec: ''"):
        Record.read(tmp_path / "r.csv")


@pytest.mark.parametrize("cell", ["0x10", "1_0", "1+2j", "True", "\u0661", "\uff11", "\u22121", "1e400j", "'1'", "1 2", "nan", "=1+1", "1d0", "."])
def test_readings_are_numbers_as_they_stand(tmp_path, cell):
    """A cell that Python or numpy takes for a number, and a table of numbers has not, is refused with its line, column and text."""
    lines = (ROOT / "data/torque_record.csv").read_text().splitlines()
    (tmp_path / "r.csv").write_text("\n".join([lines[0], "# a word of the bench", *lines[1:40], f"{cell},1", *lines[40:]]), encoding="utf-8")
    with pytest.raises(hdengine.InputError, match=re.escape(f"line 42: column torque_nm: {cell!r}" if cell != "'1'" else "line 42: column torque_nm")):
        Record.read(tmp_path / "r.csv")


def test_tables_of_readings_are_whole_texts(tmp_path):
    """A column that stands twice, a row of another length and a byte of 0 anywhere are refused: two torques gave K1 = 0."""
    lines = (ROOT / "data/torque_record.csv").read_text().splitlines()
    for rows, says in (([f"torque_nm,{lines[0]}", *(f"0,{line}" for line in lines[1:])], "'torque_nm' stands twice"),
                       ([*lines[:1200], f"{lines[1200]},7", *lines[1201:]], "line 1201: 3 cells"),
                       ([*lines[:1200], "\0", *lines[1200:]], "no text")):
        (tmp_path / "r.csv").write_text("\n".join(rows))
        with pytest.raises(hdengine.HdengineError, match=says):
            Record.read(tmp_path / "r.csv")
    for name in ("--torque-error", "--angle-error"):
        assert main(["record", str(ROOT / "data/torque_record.csv"), "--out", str(tmp_path / "o"), name, "1e300"]) == 2
    assert not (tmp_path / "o").exists()


def test_spline_reproduces_cubics():
    """B-splines sum to one, their derivatives to zero; a line is met exactly whatever the penalty, slope included."""
    x = np.linspace(-1, 2, 101)
    np.testing.assert_allclose(basis(x, -1, 2, 7).sum(axis=1), 1, atol=1e-14)
    np.testing.assert_allclose(basis(x, -1, 2, 7, 1).sum(axis=1), 0, atol=1e-13)
    fit = Spline(x, 3 - 2 * x, 7, 1)
    np.testing.assert_allclose(fit(x), 3 - 2 * x, atol=1e-9)
    np.testing.assert_allclose(fit(x, 1), -2, atol=1e-8)
    fine = Spline(x, x**3, 30, penalty=1e-12)
    np.testing.assert_allclose(fine(x, 1), 3 * x**2, atol=1e-6)


def test_command(tmp_path, monkeypatch, capsys):
    """`hdengine record` prints K1 with its band and writes a whole folder, the lines of a scene among it, which it replaces with --force
    alone and never where a run lies there."""
    monkeypatch.chdir(tmp_path)
    words, out = ["record", str(ROOT / "data/torque_record.csv")], tmp_path / "torque_record.out"
    assert main(words) == 0 and "k1" in capsys.readouterr().out
    found = json.loads((out / "record.json").read_text())
    assert found["status"] == "complete" and {p.name for p in out.iterdir()} == {"record.json", "record.png", *found["files"]}
    low, high = found["value_low_high"]["k1_nm_per_rad"][1:]
    assert low < found["value_low_high"]["k1_nm_per_rad"][0] < high and read_csv(out / "curve.csv")["stiffness_nm_per_rad"].min() > 0
    assert hdengine.read_scene(out / "scene.nml")["load.torque"] == pytest.approx(found["torque_max_nm"], rel=1e-5)
    rated = Record.read(ROOT / "data/torque_record.csv").numbers(rated_torque_nm=7.8, draws=2)  # of the size, as in a run; not the record's 5 N m
    assert found["value_low_high"]["lost_motion_rad"][0] == rated["lost_motion_rad"][0]
    assert main(words) == 3 and "--force" in capsys.readouterr().err
    assert main([*words, "--force"]) == 0
    assert main([*words, "--force", "--rated-torque", "0"]) == 2 and "above 0" in capsys.readouterr().err
    (out / "summary.json").write_text("{}")
    assert main([*words, "--force"]) == 3 and "summary.json" in capsys.readouterr().err


def test_torques_of_no_such_size_are_refused():
    """A record in mN m read as N m had K1 to K3 of its first readings; the message names the torque in N m, and the size."""
    turn = np.concatenate([np.linspace(0, 5, 20), np.linspace(5, -5, 40), np.linspace(-5, 5, 40)])
    milli = Record(1e3 * turn, turn / 5e3)
    with pytest.raises(hdengine.InputError, match=r"goes to 5000 N m, drives of size 14 to 55 .* did you mean 5 N m \(5000 mN m\)"):
        milli.numbers(draws=2)
    assert milli.numbers(UNITS[90], draws=2)["k1_nm_per_rad"][0] == pytest.approx(5e6, rel=1e-3)


def test_tables_that_say_something_else_are_refused(tmp_path):
    """A table with decimal commas, without rows, with the angle twice, or whose angle stays or falls as the torque rises is refused with the
    reason; a byte order mark before the first name is none of it."""
    turn = np.concatenate([np.linspace(0, 5, 20), np.linspace(5, -5, 40), np.linspace(-5, 5, 40)])
    for name, head, angles, says in (("empty", "torque_nm,angle_rad", [], "no reading"), ("twice", "torque_nm,angle_rad,angle_arcsec", [turn, turn], "angle_rad and angle_arcsec"),
                                     ("stays", "torque_nm,angle_rad", [0 * turn], "does not rise"), ("falls", "torque_nm,angle_rad", [-turn], "does not rise")):
        np.savetxt(tmp_path / name, np.c_[(turn, *angles)] if angles else np.empty((0, 2)), delimiter=",", header=head, comments="")
        with pytest.raises(hdengine.InputError, match=says):
            Record.read(tmp_path / name)
    (tmp_path / "decimal").write_text("torque_nm;angle_rad\n0,021;0,36\n")
    with pytest.raises(hdengine.InputError, match="line 2: decimal commas or semicolons; valid: points"):
        Record.read(tmp_path / "decimal")
    np.savetxt(tmp_path / "mark", np.c_[turn, turn / 5e3], delimiter=",", header="\ufefftorque_nm,angle_rad", comments="", encoding="utf-8")
    assert Record.read(tmp_path / "mark").torque_nm.max() == 5
