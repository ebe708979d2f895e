# SPDX-License-Identifier: GPL-3.0-or-later
"""Two specimens as one map, and files that were once misread."""
import struct

import numpy as np
import pytest

import hdengine
from conftest import ROOT
from hdengine.surfaces import composite, specimen
from hdengine.surfaces.specimen import Specimen

SURFACES = ROOT.parent / "shared/surfaces"


def field(n, seed, exponent=1.5):
    """Gaussian map of spectral density f^(-2 exponent), by numpy alone [m]."""
    f = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    f[0, 0] = np.inf
    return 1e-6 * np.fft.irfft2(f**-exponent * np.fft.rfft2(np.random.default_rng(seed).standard_normal((n, n))), s=(n, n))


def test_prints_of_one_joint_are_registered():
    """A face and its negative print, displaced by (7, -11) points, with 20 % of own roughness, are moved back; others stay."""
    base, own = field(256, 1), 0.2 * field(256, 2)
    a = Specimen(base[50:178, 60:188], (1e-6, 1e-6), "a")
    b = Specimen(-(base + own)[57:185, 49:177], (1e-6, 1e-6), "b")
    c = composite.composite(a, b)
    assert c.registered and c.shift == (7, -11) and c.correlation < -0.9
    assert np.std(c.specimen.heights) < 0.5 * np.std(c.first.heights)
    free = composite.composite(a, Specimen(own[:128, :128], (1e-6, 1e-6)))
    assert not free.registered and free.specimen.heights.shape == (128, 128)


def test_the_same_file_twice_is_refused():
    """One map given as both specimens is an input error for the sum map and for the sum of structure functions."""
    a = Specimen(field(64, 3), (1e-6, 1e-6), "a")
    twin = Specimen(a.heights.copy(), a.spacing, "twin")
    for call in (composite.composite, specimen.equivalent):
        with pytest.raises(hdengine.InputError, match="same heights"):
            call(a, twin)


def test_maps_of_different_spacing_are_brought_to_one():
    """A cubic surface sampled at (0.5, 0.8) and at (1, 1) um adds up exactly, holes stay holes."""
    def cubic(dy, dx, n):
        y, x = np.mgrid[:n, :n]
        x, y = (x - (n - 1) / 2) * dx, (y - (n - 1) / 2) * dy
        return x**3 + y**3 - x**2 * y
    fine, coarse = cubic(0.5, 0.8, 61), cubic(1.0, 1.0, 21).T
    fine[0, 0] = np.nan
    c = composite.composite(Specimen(fine, (0.5, 0.8)), Specimen(coarse, (1.0, 1.0)), register=False)
    assert c.specimen.spacing == (1.0, 1.0) and c.specimen.heights.shape == (21, 21)
    resampled = composite.resample(Specimen(fine, (0.5, 0.8)), 1.0)
    assert np.isnan(resampled.heights[0, 0]) and np.isfinite(resampled.heights[5:, 5:]).all()
    y, x = np.mgrid[: resampled.heights.shape[0], : resampled.heights.shape[1]] - np.array([15.0, 24.0])[:, None, None]
    assert np.nanmax(abs(resampled.heights - (x**3 + y**3 - x**2 * y))) < 1e-9 * np.nanmax(abs(fine))


XML = """<?xml version='1.0'?>
<!DOCTYPE DATA SYSTEM "data.dtd">
<DATA><DATAFILE><UNITS>um</UNITS><NUMPOINTS>{n}</NUMPOINTS><SPACING>0.25</SPACING>
<DATA_POINT_VALUES>{raw}</DATA_POINT_VALUES></DATAFILE>
<ANALYSIS><ROUGHNESS><ROUGHNESS_DATA_POINT_VALUES>{other}</ROUGHNESS_DATA_POINT_VALUES></ROUGHNESS></ANALYSIS></DATA>"""


def test_four_points_hold_a_cubic():
    """Resampling keeps a cubic, of four points too; three are refused."""
    x = np.arange(4.0)
    half = composite.resample(Specimen(np.outer(x**3, x**2), (1.0, 1.0)), 0.5).heights
    np.testing.assert_allclose(half, np.outer(np.arange(0, 3.1, 0.5)**3, np.arange(0, 3.1, 0.5)**2), atol=1e-12)
    with pytest.raises(hdengine.InputError, match="at least 4"):
        composite.resample(Specimen(np.outer(x, x[:3]), (1.0, 1.0)), 0.5)


def test_softgauge_of_two_curves_is_read_as_its_raw_one(tmp_path):
    """The XML of a softgauge with a raw and a filtered curve gives all raw points in metres and its spacing."""
    raw = np.round(np.sin(np.arange(40.0)), 6)
    text = XML.format(n=40, raw="\n".join(map(str, raw)), other="\n".join(map(str, raw[1:-1] / 2)))
    (tmp_path / "two.xml").write_text(text)
    s = specimen.read(tmp_path / "two.xml")
    assert s.heights == pytest.approx(raw * 1e-6) and s.spacing == (0.25e-6, 0.25e-6) and "left out" in s.notes[0]


@pytest.mark.parametrize("kind, letter, hole", [(0, "B", None), (1, "H", 2**16 - 1), (2, "I", 2**32 - 1), (4, "b", None)])
def test_sdf_of_every_whole_number_reads(tmp_path, kind, letter, hole):
    """SDF with 8-bit or unsigned heights reads alike in Python and in the engine; the top of 16 and 32 bits is a hole."""
    top = {"B": 255, "H": 65534, "I": 2**32 - 2, "b": 127}[letter]
    values = [(top * i) // 143 for i in range(144)]
    if hole:
        values[7] = hole
    head = struct.pack("<8s10s12s12sHHddddBBB", b"bISO-1.0", b"m", b" ", b" ", 12, 12, 1e-6, 1e-6, 1e-9, -1.0, 0, kind, 0)
    (tmp_path / "a.sdf").write_bytes(head + struct.pack(f"<144{letter}", *values))
    s = specimen.read(tmp_path / "a.sdf")
    hdengine.run_surface(out=str(tmp_path / "out"), fit__first_file=str(tmp_path / "a.sdf"), fit__model="none")
    expected = np.array(values, dtype=float).reshape(12, 12) * 1e-9
    if hole:
        expected[0, 7] = np.nan
    for z in (s.heights, np.load(tmp_path / "out/first.npy")):
        assert np.array_equal(np.isnan(z), np.isnan(expected)) and np.nanmax(abs(z - expected)) <= 1e-12 * np.nanmax(expected)


def test_a_lateral_scale_wrong_by_1000_is_called_out(tmp_path):
    """A ground surface with metres for millimetres across the plane, gets a note; a right one none."""
    np.save(tmp_path / "a.npy", 1e5 * field(64, 6))
    for step, doubt in ((1e-6, False), (1e-9, True), (1e-3, True)):
        assert any("lateral scale" in n for n in specimen.read(tmp_path / "a.npy", "um", step).notes) is doubt


@pytest.mark.parametrize("letter", "ba")
def test_sdf_of_a_wrong_scale_is_called_out(tmp_path, letter):
    """Spacings 1000 times too small or too large in a binary or text SDF, which states metres, get a note; the right one none."""
    for step, doubt in ((1e-6, False), (1e-9, True), (1e-3, True)):
        s = specimen.Specimen(0.1 * field(64, 6), (step, step))
        specimen.save(tmp_path / "b.sdf", s)
        body = " ".join(map(repr, s.heights.ravel().tolist()))
        (tmp_path / "a.sdf").write_text(f"aISO-1.0\nNumPoints = 64\nNumProfiles = 64\nXscale = {step}\nYscale = {step}\n"
                                        f"Zscale = 1\n*\n{body}\n*\n")
        assert any("lateral scale" in n for n in specimen.read(tmp_path / f"{letter}.sdf").notes) is doubt


def test_a_text_that_ends_within_a_line_is_noted(tmp_path):
    """A list of points whose last line has no end may be cut: the specimen says so, and one with an end does not."""
    pytest.importorskip("SurfaceTopography")
    lines = [f"{i:.4f},{np.sin(i):.6f}" for i in range(40)]
    for name, text, noted in (("whole.csv", "\n".join(lines) + "\n", False), ("cut.csv", "\n".join(lines)[:-3], True)):
        (tmp_path / name).write_text(text)
        assert any("ends within a line" in n for n in specimen.read(tmp_path / name, "um").notes) is noted


@pytest.mark.skipif(not (SURFACES / "npl_sine.xml").is_file(), reason="measured surfaces not present")
def test_npl_sine_is_read_as_it_states():
    """The NPL softgauge sine has 8000 points, 0.5 um apart, of 1 um amplitude, by what the file states."""
    s = specimen.read(SURFACES / "npl_sine.xml")
    assert s.heights.shape == (8000,) and s.spacing[1] == 0.5e-6 and s.heights.max() == pytest.approx(1e-6, rel=1e-3)
