# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrong points, steps of stitching and row jitter: found, taken off, reported; maps without them stay as they are."""
import json
import sys

import numpy as np
import pytest

from conftest import ROOT
from hdengine.cli import main
from hdengine.surfaces import roughness
from hdengine.surfaces.specimen import Specimen, clean
from hdengine.surfaces.texture import texture

sys.path.insert(0, str(ROOT / "bench"))
from blind_generators import NOT_FRACTAL, clumps, field, grooves, jitter, straight, stretched  # noqa: E402

DX = 1e-6


def rough(seed, n=128, **keys):
    """A map of D = 2.5 with detail finer than the spacing."""
    return field(n, DX, 2.5, np.random.default_rng(seed), **{"finer": 2, **keys})


def test_small_clumps_are_wrong_points():
    """Of twenty clumps of 2 x 2 points at 3 Sq at least nine tenths are found, nothing else is, and D stays within its interval."""
    z, spacing = rough(1)
    bad = z.copy()
    wrong = clumps(bad, np.random.default_rng(2))
    found = np.isnan(clean(Specimen(bad, spacing))[0].heights)
    assert np.mean(found[wrong]) > 0.9 and not np.any(found & ~wrong)
    low, high = roughness.fit(z, spacing).interval[0]
    f = roughness.fit(bad, spacing)
    assert low < f.fractal_dimension < high and f.spikes == found.sum() and "wrong points masked" in str(f)
    assert not low < roughness.fit(bad, spacing, outliers=False).fractal_dimension < high


def test_what_cannot_be_seen_is_said():
    """Clumps of 3 Sq stand higher than the height from which on clumps are found at D = 2.1, and lower at D = 2.9, where fewer than half
    are found; the printed result states it."""
    for d, seen in ((2.1, True), (2.9, False)):
        z, spacing = field(128, DX, d, np.random.default_rng(1), finer=2)
        wrong = clumps(z, np.random.default_rng(2))
        f = roughness.fit(z, spacing)
        assert (f.wrong_from_m[1] < 3 * z.std()) == (f.spikes > 0.5 * wrong.sum()) == seen
        assert f"clumps {1e6 * f.wrong_from_m[1]:.3g} µm) they are not seen" in str(f)


@pytest.mark.parametrize("keys", [{}, {"finer": 1}, {"probe": 1.0}, {"noise": 0.1}, {"tilt": 5.0}])
def test_rough_maps_lose_nothing(keys):
    """Of four maps without faults none loses a point or shows a seam, and the heights come back bit by bit."""
    for seed in range(4):
        z, spacing = rough(seed, **keys)
        s, found = clean(Specimen(z, spacing), seams=True)
        assert found == 0 and np.array_equal(s.heights, z) and not s.notes


def test_tiles_are_levelled():
    """Four tiles apart by 0.7 to 1.9 Sq come back level to 0.03 Sq, with one seam each way and its largest step within 5 %."""
    z, spacing = rough(3, 192)
    bad, sq = z.copy(), z.std()
    bad[100:, :70] += 0.7 * sq
    bad[:100, 70:] -= 1.2 * sq
    s = clean(Specimen(bad, spacing), outliers=False, seams=True)[0]
    off = s.heights - z
    tiles = [off[:100, :70], off[:100, 70:], off[100:, :70], off[100:, 70:]]
    assert max(np.ptp(t) for t in tiles) < 1e-9 * sq and np.ptp([t.mean() for t in tiles]) < 0.03 * sq
    assert s.notes[-1].startswith("1 seams across x and 1 across y levelled")
    f = roughness.fit(bad, spacing)
    assert f.seams == (1, 1) and abs(f.seam_step_m / (1.2 * sq) - 1) < 0.05 and "seams     1 across x" in str(f)


def test_jitter_is_measured():
    """Offsets of rows of 0.2 Sq are reported as rms within a fifth."""
    z, spacing = rough(4)
    f = roughness.fit(z + 0.2 * z.std() * np.random.default_rng(5).standard_normal((128, 1)), spacing)
    assert f.jitter_m[0] == 0 and abs(f.jitter_m[1] / (0.2 * z.std()) - 1) < 0.2 and "offsets of rows" in str(f)


@pytest.mark.parametrize("across", ["x", "y"])
def test_a_lay_is_no_jitter(across):
    """Straight, stretched and ending grooves are called a lay, nothing is taken off and the message names their direction; white
    offsets of the rows or columns of the same map are jitter, and the map is fractal."""
    rng = np.random.default_rng(11)
    maps = [straight(128, DX, 2.5, rng, 2.5), stretched(128, DX, 2.5, rng, 10), grooves(128, DX, 2.5, rng, 1.0)]
    for z in maps:
        f = roughness.fit(z if across == "x" else z.T, DX)
        assert (f.verdict, f.kind) == ("not fractal", "lay") and f.jitter_m == (0, 0) and "nothing taken off" in str(f)
        assert f"waves along {across}" in f.reason and f"grooves along {'y' if across == 'x' else 'x'}" in f.reason
    z = jitter(128, DX, 2.5, rng, 0.3)
    f = roughness.fit(z if across == "y" else z.T, DX)
    assert f.kind == "fractal" and f.jitter_m["xy".index(across)] > 0 and "white offsets" in str(f)


def test_a_blurred_map_does_not_jitter():
    """A probe of two spacings leaves so little power at short waves that the taper's leak along the axes exceeds it: no offsets are
    seen there, and those of rows of 0.05 Sq still are."""
    for seed in range(3):
        z, spacing = rough(seed, finer=1, probe=2.0)
        assert roughness.fit(z, spacing).jitter_m == (0, 0)
        z += 0.05 * z.std() * np.random.default_rng(seed).standard_normal((128, 1))
        f = roughness.fit(z, spacing)
        assert f.jitter_m[0] == 0 and abs(f.jitter_m[1] / (0.05 * z.std()) - 1) < 0.3


def test_told_models_mask_too():
    """Seven points off by 5 Sq and a seam move D of the paper's line by less than its standard error, and by more where they are kept."""
    z, spacing = rough(6)
    bad = z.copy()
    bad.flat[np.random.default_rng(7).choice(z.size, 7, replace=False)] += 5 * z.std()
    bad[:, 60:] += z.std()
    told = {"model": "paper"}
    right, masked, kept = (roughness.fit(m, spacing, outliers=o, **told) for m, o in ((z, True), (bad, True), (bad, False)))
    assert masked.spikes == 7 and masked.seams == (1, 0) and kept.spikes == 0
    assert abs(masked.fractal_dimension - right.fractal_dimension) < right.fractal_dimension_error
    assert abs(kept.fractal_dimension - right.fractal_dimension) > right.fractal_dimension_error


def test_the_command_levels_seams(tmp_path, capsys):
    """`hdengine surface --seams` says what it levelled, on the screen and in surface.json, of the fit and of the areal numbers; Sq is
    that of the map without the seam within 5 %, and without `--seams` it is not."""
    z, spacing = rough(9)
    bad = z.copy()
    bad[:, 60:] += 3 * z.std()
    np.save(tmp_path / "map.npy", bad)
    want = texture(Specimen(z, spacing)).numbers["sq_m"]
    found = []
    for more in ([], ["--seams"]):
        assert main(["surface", str(tmp_path / "map.npy"), "--spacing", "1e-6", *more, "--out", str(tmp_path / "o"), "--force"]) == 0
        found.append(json.loads((tmp_path / "o/surface.json").read_text())["surfaces"]["map"])
    assert "mended    1 seams across x" in capsys.readouterr().out
    assert [f["areal"]["mended"] == [] for f in found] == [True, False] and found[0]["seams"] == [1, 0]
    assert found[1]["areal"]["sq_m"] == pytest.approx(want, rel=0.05) and found[0]["areal"]["sq_m"] > 1.05 * want


def test_smooth_maps_have_no_seams():
    """Ten smooth maps, whose slope changes over many points, show no seam and are called smooth."""
    for seed in range(2000, 2010):
        f = roughness.fit(NOT_FRACTAL["smooth"](128, np.random.default_rng(seed)), DX)
        assert f.seams == (0, 0) and f.spikes == 0 and f.kind == "smooth"
