# SPDX-License-Identifier: GPL-3.0-or-later
"""What `hdengine joint` takes, how long, and what it tells of a map that breaks the theory."""
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from test_prediction import rough

import hdengine
from hdengine import cli
from hdengine.elastic import moduli, stiffness_from_spectrum
from hdengine.prediction import half_space, patches
from hdengine.prediction.bodies import Bodies
from hdengine.prediction.choice import SCATTER, SKEWED, choose
from hdengine.prediction.law import predict
from hdengine.prediction.spectrum import Spectrum, bands, of_map

DX = (1e-6, 1e-6)
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
FINE = {"isotropy": 0.9, "skewness": 0.1, "crests": 1.05, "rolls_off": True}
P = np.array([1e6, 1e7, 1e8])


@pytest.mark.parametrize("facts, area, waves, steepness, model, words", [
    ({}, [0.02, 0.05, 0.3], 500, 0.5, "spectrum", "isotropic"),
    ({"isotropy": 0.2}, [0.01, 0.05, 0.3], 500, 0.5, "boundary_elements", "lay"),
    ({"skewness": -1.2}, [0.01, 0.05, 0.3], 500, 0.5, "boundary_elements", "skewness -1.20"),
    ({"skewness": -0.4, "crests": 0.3}, [0.02, 0.05, 0.3], 500, 0.5, "boundary_elements", "crests 0.30 times as high"),
    ({}, [5e-4, 0.07, 0.3], 100, 0.5, "boundary_elements",
     "at 1 MPa 0.05 % of the area touches, of 100 independent waves: single maps differ by up to 76 % from the theory; from 10 to 100 MPa"),
    ({}, [0.02, 0.05, 0.99], 500, 0.5, "boundary_elements", "at 100 MPa 99 % of the area touches, of 500 independent waves: single"),
    ({}, [0.02, 0.021, 0.022], 9, 0.5, "boundary_elements", "of 9 independent waves"),
    ({"isotropy": 0.2}, [0.01, 0.05, 0.3], 500, 7.0, "spectrum", "E* times slope is 7 hardnesses: nearly all contact yields")])
def test_choice_and_its_reason(facts, area, waves, steepness, model, words):
    """The planner takes what holds for the surface and the pressures, and says why and from where the theory would do."""
    found = choose({**FINE, **facts}, P, np.array(area), waves, steepness)
    assert found[0] == model and words in found[1]


def test_independent_waves():
    """Waves of equal variance count one by one, one wave that holds all counts as one, and cutting the longest off leaves the rest."""
    q = np.arange(1.0, 11.0)
    even = Spectrum(q, np.full(10, 4.0), np.full(10, 4.0))
    assert even.waves == pytest.approx(40)
    assert Spectrum(q, np.r_[1.0, np.full(9, 1e-9)], np.ones(10)).waves == pytest.approx(1, abs=1e-6)
    assert even.between(longest=2 * np.pi / 1.5).waves == pytest.approx(36)


def test_unlike_spacings_are_no_lay():
    """Rows eight times as far apart as points see fewer short waves, which is no lay; a lay stays one."""
    z, dx = hdengine.surface.periodic(512, 512e-6, 2.5, 1e-11, 2e-6, 1), 1e-6
    for heights, spacing in ((z[::8], (8 * dx, dx)), (z[:, ::8], (dx, 8 * dx))):
        assert of_map(heights, spacing)[1]["isotropy"] > 0.8
    grooves = z[0] + 0.2 * z
    assert of_map(grooves[::8], (8 * dx, dx))[1]["isotropy"] < 0.2 > of_map(grooves.T[:, ::8], (dx, 8 * dx))[1]["isotropy"]


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_smooth_face_decides_nothing():
    """A second face a thousandth as rough changes neither the waves nor the doubts nor the band, whatever its size, lay or skewness; two alike maps
    hold the waves of one."""
    first, wide = rough(128, 0.8, 16, 4, 1), rough(512, 0.8, 512, 4, 2)
    alone = predict((first, DX), pressure=[1e7, 1e8], model="spectrum")
    smooth = -np.tile(wide[0] ** 2, (512, 1)) * 1e-3 * first.std() / wide[0].var()
    assert abs(of_map(smooth, DX)[1]["skewness"]) > 0.7 and of_map(smooth, DX)[1]["isotropy"] < 0.6
    for maps in (((first, DX), (smooth, DX)), ((smooth, DX), (first, DX))):
        both = predict(*maps, pressure=[1e7, 1e8], model="spectrum")
        assert both.waves == pytest.approx(alone.waves, rel=1e-3) and both.outside == alone.outside
        for name in ("k_n_pa_per_m", "k_n_pa_per_m_low", "k_n_pa_per_m_high"):
            assert both.table[name] == pytest.approx(alone.table[name], rel=0.05)
    pair = predict((first, DX), (rough(128, 0.8, 16, 4, 3), DX), pressure=[1e7, 1e8], model="spectrum")
    assert pair.waves == pytest.approx(alone.waves, rel=0.1)


def test_scatter_is_that_of_the_record():
    """The errors of single maps on which the choice and the band rest are those of the record of training maps."""
    rows = json.loads((ROOT / "bench/results/joint_law_training.json").read_text())["errors_of_used"]
    assert np.array(SCATTER) == pytest.approx(np.array([(r["waves"], r["rms_ln_error"]) for r in rows]))
    rows = json.loads((ROOT / "bench/results/joint_law_training.json").read_text())["skewed"]
    assert np.transpose(SKEWED) == pytest.approx(np.array([(r["contact"], r["ln_error_per_ln_crests"]) for r in rows]))


def test_stated_error_holds():
    """On the maps of the record that set nothing, narrow to wide, skewed and worn, the stated error of k_N holds in 95 of 100 pressures at least; the
    theory of today gives on the small ones what the record says."""
    pytest.importorskip("scipy")
    import joint_law

    rows = json.loads((ROOT / "bench/results/joint_law.json").read_text())["maps"]
    assert len(rows) >= 30 and not any(tuple(row["map"].values()) in joint_law.TRAINING for row in rows)
    inside = np.concatenate([abs(np.array(row["ln_k"])) <= row["half_width"] for row in rows])
    assert inside.mean() >= 0.95
    for row in rows[::4]:
        if row["map"]["n"] == 128:
            errors, half = joint_law.theory(row)[:2]
            assert errors[0] == pytest.approx(np.array(row["ln_k"]), abs=6e-3) and half == pytest.approx(np.array(row["half_width"]), rel=0.02)


def test_prediction_says_where_it_is_outside(tmp_path, capsys):
    """Worn crests and a lay are outside of the theory, which the prediction, its record and the command say with a band that is wide enough; a sound map has none."""
    pytest.importorskip("tamaas")
    sound = rough(128, 0.8, 24, 8, 3)
    worn = np.minimum(sound, 0.6 * sound.std()) + 0.1 * rough(128, 0.5, 12, 8, 4)
    p, bodies = [5e7, 2e8], Bodies(hardness=1e13)
    assert not predict((sound, DX), pressure=[3e8], model="spectrum", bodies=bodies).outside
    found = predict((worn, DX), pressure=p, model="spectrum", bodies=bodies)
    assert "times as high as those of random waves" in found.outside[0] or "skewness" in found.outside[0]
    truth = half_space.stiffness_on_map(worn, DX, p, bodies.e_star, bodies.ratio, tangential=False)[0]
    assert (truth > 1.3 * found.table["k_n_pa_per_m"]).all() and (truth < found.table["k_n_pa_per_m_high"]).all()
    np.save(tmp_path / "a.npy", worn)
    assert cli.main(["joint", str(tmp_path / "a.npy"), "--dx", "1e-6", "--model", "spectrum", "--pressure", "5e7", "--out", str(tmp_path / "o")]) == 0
    assert "outside its validity: " in capsys.readouterr().out
    assert json.loads((tmp_path / "o/joint.json").read_text())["outside_validity"]
    with pytest.raises(hdengine.NotConvergedError, match="all of the map touches"):
        half_space.stiffness_on_map(sound, DX, [1e12], bodies.e_star, bodies.ratio)


def test_maps_as_pairs():
    """A pair has one spacing or two; anything else is refused by what was given."""
    z = rough(64, 0.8, 16, 8, 3)
    one, two = (predict((z, spacing), pressure=[1e8], model="spectrum", draws=2) for spacing in (1e-6, (1e-6, 1e-6)))
    assert one.table["k_n_pa_per_m"] == two.table["k_n_pa_per_m"]
    for wrong in (z, 5, (z, "a"), (z, (1e-6, 1e-6, 1e-6)), (z, -1e-6), (z, None)):
        with pytest.raises(hdengine.InputError, match="map 1 "):
            predict(wrong)


def test_breaking_points_are_told():
    """A map with a lay, noise, holes or no roll-off is told so in the prediction's text; a sound one is not."""
    def text(z, **more):
        return str(predict((z, DX), pressure=[1e8, 3e8], model="spectrum", draws=10, **more))

    sound = rough(128, 0.8, 32, 8, 3)
    y, x = np.indices(sound.shape)
    holes = sound.copy()
    holes[10:14, 5:40] = np.nan
    noisy = sound + np.random.default_rng(1).normal(scale=2e-8, size=sound.shape)
    found = text(sound)
    for words in ("lay", "noise", "holes", "no roll-off"):
        assert words not in found
    assert "map 1 has a lay (isotropy 0.0" in text(sound + 1e-6 * np.sin((x + y) / 3))
    assert "noise of 20" in text(noisy) and "nm rms: removed, the band counts both" in text(noisy)
    assert "0.85 % holes: interpolated" in text(holes)
    assert "no roll-off: waves longer than it would lower k_N" in text(rough(256, 0.9, 256, 8, 3)[:128, :128])


def test_noise_and_a_missing_roll_off_widen_the_band():
    """Without yield the area's band of a noisy map reaches down to that with the noise; k_N's of a map without roll-off to the law with longer waves."""
    def low(z, name):
        t = predict((z, DX), pressure=[1e8], model="spectrum", draws=50, bodies=Bodies(hardness=1e12)).table
        return float(t[f"{name}_low"][0] / t[name][0])

    sound = rough(128, 0.8, 32, 8, 3)
    noisy = sound + np.random.default_rng(1).normal(scale=5e-8, size=sound.shape)
    assert low(noisy, "contact_area_fraction") < low(sound, "contact_area_fraction") - 0.1
    assert low(rough(256, 0.9, 256, 8, 3)[:128, :128], "k_n_pa_per_m") < low(sound, "k_n_pa_per_m") - 0.1


def test_band_is_the_sum_of_its_parts(tmp_path):
    """The band's half width is the root of squares of its named parts, and longer waves, which only soften, on top; a longest wave that the user sets leaves no longer ones; the parts
    stand in joint.json and the widest first in the text."""
    z = rough(256, 0.9, 256, 8, 3)[:128, :128]
    found = predict((z, DX), pressure=[1e7, 1e8], model="spectrum", draws=30)
    assert set(found.parts) == {"sampling", "E* and hardness", "law", "longer waves"}
    total = np.sqrt(sum(low**2 for name, (low, _) in found.parts.items() if name != "longer waves")) + found.parts["longer waves"][0]
    assert found.table["k_n_pa_per_m_low"] == pytest.approx(found.table["k_n_pa_per_m"] * np.exp(-total), rel=1e-9)
    widest = max(found.parts, key=lambda name: max(side[1] for side in found.parts[name]))
    assert f"half width of the band at 100 MPa: {widest} " in str(found)
    cut = predict((z, DX), pressure=[1e7, 1e8], model="spectrum", draws=30, longest=100e-6)
    assert "longer waves" not in cut.parts and "(--longest) decides" in str(cut)
    found.write(tmp_path)
    record = json.loads((tmp_path / "joint.json").read_text())
    assert record["band_half_widths_ln_k_n"]["law"]["low"] == pytest.approx(found.parts["law"][0].tolist())


def test_longer_waves_are_counted():
    """On maps cut from four times as long ones without roll-off the part for waves up to twice the map is 0.6 to 1.1 of the true change of
    ln k_N, on the average, and the band's low end reaches the true k_N in nine of ten at least."""
    parts, changes, reached, bodies = [], [], 0, Bodies(hardness=1e12)
    for seed in range(5):
        z = rough(512, 0.6, 512, 6, seed)
        h = abs(np.fft.fft2(z) / z.size) ** 2
        f = np.hypot(*np.meshgrid(*[np.fft.fftfreq(512, 1e-6)] * 2, indexing="ij"))
        use = f > 0.97 / 256e-6
        whole = bands(2 * np.pi * f[use], h[use])
        true = stiffness_from_spectrum(whole.q, whole.height_variance, [1e8], bodies.e_star, 1e12)[0][0]
        for at in (0, 256):
            found = predict((z[at:at + 128, at:at + 128], DX), pressure=[1e8], model="spectrum", draws=20, bodies=bodies)
            parts.append(found.parts["longer waves"][0][0] if "longer waves" in found.parts else 0.0)
            changes.append(np.log(found.table["k_n_pa_per_m"][0] / true))
            reached += found.table["k_n_pa_per_m_low"][0] < true
    assert 0.6 < np.mean(parts) / np.mean(changes) < 1.1
    assert reached >= 9


def test_roll_off_is_seen():
    """Maps cut from ones without roll-off are told so, and those with one at a quarter of the map are not: nine of ten at least."""
    seen = {"none": 0, "quarter": 0}
    for seed in range(10):
        seen["none"] += of_map(rough(256, 0.6, 256, 6, seed)[:128, :128], DX)[1]["rolls_off"]
        seen["quarter"] += of_map(rough(256, 0.6, 32, 6, seed)[:128, :128], DX)[1]["rolls_off"]
    assert seen["none"] <= 1 and seen["quarter"] >= 9


@pytest.mark.parametrize("change, words", [
    (lambda z: z * 0 + 3.0, "map 1: the map is flat"), (lambda z: z * 0 + np.arange(64) * 1e-7, "map 1: the map is flat"),
    (lambda z: 1e6 * z, "another unit"), (lambda z: np.where(np.arange(64) < 20, np.nan, z), "map 1: 31 % of the map are holes"),
    (lambda z: z[:8], "map 1: map of 8 x 64 points"), (lambda z: z[0], "map 1: a joint needs height maps")])
def test_maps_that_are_none(change, words):
    """Flat, tilted and flat, in another unit, full of holes, too small or a profile: an error that names the map and what is wrong."""
    with pytest.raises(hdengine.InputError, match=words):
        predict((change(rough(64, 0.7, 16, 6, 1)), DX), model="spectrum")


@pytest.mark.parametrize("option", [["--dx", "0"], ["--dx", "1e-6", "--seconds", "-1"], ["--dx", "1e-6", "--pressure", ""]])
def test_values_that_are_none(tmp_path, capsys, option):
    """A spacing or time of nothing and an empty list of pressures are input errors that name the option."""
    np.save(tmp_path / "a.npy", rough(32, 0.7, 16, 6, 20))
    assert cli.main(["joint", str(tmp_path / "a.npy"), *option, "--out", str(tmp_path / "o")]) == 2
    assert option[-2] in capsys.readouterr().err


def test_time_is_foretold_told_and_bound():
    """Boundary elements say why, how many and how long before they start and tell each step; within the time allowed they take fewer
    points; with none the theory is taken at once, and the reason names the option; asked for, that is an error of code 7."""
    pytest.importorskip("tamaas")
    said = []

    def say(text, replaces):
        said.append((text, replaces))

    z = rough(128, 0.7, 128, 6, 9)
    found = predict((z, DX), pressure=[3e6, 3e7], points=64, say=say)
    lines = [t for t, replaces in said if not replaces]
    assert "of the area touches" in lines[0] and "2 pressures on 64 points a side and on four quarters, about" in lines[1]
    assert [t for t, replaces in said if replaces][-1].startswith("boundary elements: whole map, 30 MPa (10 of 10)")
    assert found.model == "boundary_elements"

    with pytest.raises(hdengine.StoppedError, match="--seconds allows 1e-09"):
        predict((z, DX), pressure=[3e6, 3e7], model="boundary_elements", seconds=1e-9)
    assert hdengine.StoppedError.code == 7
    theory = predict((z, DX), pressure=[3e6, 3e7], seconds=1e-9)
    assert theory.model == "spectrum" and "--seconds allows" in theory.reason and "touches" in theory.reason


def test_fewer_points_where_time_is_short(monkeypatch):
    """Where the points asked for would take too long, fewer are taken, and both times are said."""
    pytest.importorskip("tamaas")
    said, clock = [], [0.0]

    def tick():
        clock[0] += 0.01    # the trial takes a hundredth of a second of this clock, whatever the machine
        return clock[0]

    monkeypatch.setattr(patches.time, "monotonic", tick)
    effort = patches.Effort(most=0.3, say=lambda text, replaces: said.append(text))
    k_n, _, area, scatter, coarse, points = patches.solve([(rough(128, 0.7, 32, 6, 9), DX)], np.array([1e8]), Bodies(), 128, np.inf, effort)
    assert points == 64 and "more points would take about" in said[0]
    assert k_n[0] > 0 and 0 < area[0] < 1 and scatter[0] >= 0.02 and coarse[0] > 0


def test_averaged_maps_keep_their_short_waves():
    """Boundary elements on a quarter of the points a side, with the theory of what averaging takes, are within 10 % of those on all points; without it
    they are up to 20 % too stiff. No averaging changes nothing."""
    pytest.importorskip("tamaas")
    e_star, ratio = moduli(209e9, 0.295, 219e9, 0.30)
    z = 1e-7 / 5e-8 * rough(128, 0.2, 128, 6, 5)
    p = 0.1 * e_star * np.array([0.03, 0.1, 0.3])
    whole = half_space.stiffness_on_map(z, DX, p, e_star, ratio, tangential=False)
    same = patches.on_fewer_points(z, DX, 128, p, e_star, ratio, periodic=True, tangential=False)
    few = patches.on_fewer_points(z, DX, 32, p, e_star, ratio, periodic=True, tangential=False)
    bare = half_space.stiffness_on_map(*patches._averaged(z, DX, 32), p, e_star, ratio, tangential=False)
    assert same[0].tolist() == whole[0].tolist() and not same[3].any()
    assert few[0] == pytest.approx(whole[0], rel=0.1) and few[2] == pytest.approx(whole[2], rel=0.15)
    assert bare[0][-1] > 1.15 * whole[0][-1]
    assert (abs(np.log(few[0] / whole[0])) < 2 * few[3]).all()
    found = predict((z, DX), pressure=[2e8], model="boundary_elements", points=64, bodies=Bodies(hardness=1e13))
    assert "averaging" in found.parts and "shorter waves by theory" in str(found)


def test_band_of_a_contact_of_many_patches():
    """Of patches that measure a sixteenth of a contact, the theory's band for the whole contact holds its true k_N in nine of ten at least, is narrower than that
    of a patch, and widens on a contact smaller than the map; boundary elements on the one patch keep their scatter."""
    pytest.importorskip("tamaas")
    e_star, ratio = moduli(209e9, 0.295, 219e9, 0.30)
    p, held, errors, widths, bodies = 0.05 * e_star * np.array([0.01, 0.05]), 0, [], [], Bodies(hardness=1e13)

    def width(found):
        return np.log(found.table["k_n_pa_per_m_high"] / found.table["k_n_pa_per_m_low"])

    for seed in range(10):
        z = rough(192, 0.7, 16, 6, seed)
        truth = half_space.stiffness_on_map(z, DX, p, e_star, ratio, tangential=False)[0]
        patch, same = (z[:48, :48], DX), dict(pressure=p, bodies=bodies, draws=60)
        one, whole = (predict(patch, model="spectrum", loaded=area, **same) for area in (None, z.size * 1e-12))
        held += np.sum((whole.table["k_n_pa_per_m_low"] < truth) & (truth < whole.table["k_n_pa_per_m_high"]))
        errors.append(np.log(whole.table["k_n_pa_per_m"] / truth))
        widths.append(width(whole) / width(one))
    assert held >= 18 and np.mean(widths) < 0.95 and np.std(errors) < 0.25
    assert whole.waves == pytest.approx(16 * one.waves) and "16 times the map" in str(whole)
    assert (width(predict(patch, model="spectrum", loaded=48**2 * 0.25e-12, **same)) > width(one)).all()
    bem = [width(predict(patch, model="boundary_elements", points=48, loaded=area, **same)) for area in (None, z.size * 1e-12)]
    assert (bem[1] >= bem[0]).all() and bem[1] == pytest.approx(bem[0], rel=0.05)
    with pytest.raises(hdengine.InputError, match="loaded area of 0"):
        predict(patch, model="spectrum", loaded=0.0, pressure=p)
