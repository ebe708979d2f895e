# SPDX-License-Identifier: GPL-3.0-or-later
"""Form removal, Gaussian filters and areal numbers of ISO 25178-2."""
import json
import re

import numpy as np
import pytest

import hdengine
from conftest import ROOT, call
from hdengine.cli import main
from hdengine.surfaces import form, gaussian, texture
from hdengine.surfaces.specimen import Specimen, clean, read, save
from hdengine.table_file import read_csv

SURFACES = ROOT.parent / "shared/surfaces"
STEP = (1.5e-6, 1e-6)


def grid(rows=160, points=240):
    """Places about the middle of a map, x and y [m]."""
    y, x = np.mgrid[:rows, :points]
    return (x - (points - 1) / 2) * STEP[1], (y - (rows - 1) / 2) * STEP[0]


@pytest.mark.parametrize("radius, axis, tilt", [(17.7e-3, 0.3, 0.0), (-2e-3, -1.2, 0.01), (0.4e-3, 1.5, 0.05), (5e-3, 0.0, -0.1)])
def test_a_cylinder_is_taken_off(radius, axis, tilt):
    """A convex, concave, tilted or strongly curved cylinder leaves nothing, and its radius and axis are found; of a rough one with
    holes the roughness is left."""
    x, y = grid()
    across, along = -np.sin(axis) * x + np.cos(axis) * y, np.cos(axis) * x + np.sin(axis) * y
    z = np.sign(radius) * np.hypot(1, tilt) * np.sqrt(radius**2 - (across - 2e-5) ** 2) + tilt * along
    found = form.remove(Specimen(z, STEP), "cylinder")
    assert found.radius_m == pytest.approx(radius, rel=1e-9) and found.axis_rad == pytest.approx(axis, abs=1e-9)
    assert np.std(found.specimen.heights) < 1e-9 * np.std(z)
    rough = 1e-8 * np.random.default_rng(3).standard_normal(z.shape)
    rough[5:20, 30:60] = np.nan
    found = form.remove(Specimen(z + rough, STEP), "cylinder")
    assert found.radius_m == pytest.approx(radius, rel=1e-3) and np.array_equal(np.isnan(found.specimen.heights), np.isnan(rough))
    left = found.specimen.heights - rough
    assert np.nanstd(left) < 5e-10 and np.nanstd(found.specimen.heights) == pytest.approx(1e-8, rel=0.01)


def test_a_circle_is_taken_off_a_profile():
    """An arc of a profile leaves nothing, and its radius is found."""
    x = grid()[0][0]
    found = form.remove(Specimen(-np.sqrt(1e-3**2 - (x - 1e-5) ** 2), STEP[1]), "cylinder")
    assert found.radius_m == pytest.approx(-1e-3, rel=1e-9) and np.ptp(found.specimen.heights) < 1e-15


def test_polynomials_are_taken_off_to_their_degree():
    """A polynomial leaves nothing from its own degree on and something below, holes or not; a map needs more heights than unknowns."""
    x, y = (v / 1e-4 for v in grid())
    z = 1e-6 * (1 + x - 2 * y + x**3 * y - y**4 + 0.5 * x**2)
    z[3, 7] = np.nan
    for kind, clear in (("plane", False), ("poly3", False), ("poly4", True), ("poly8", True)):
        left = np.nanstd(form.remove(Specimen(z, STEP), kind).specimen.heights)
        assert (left < 1e-12 * np.nanstd(z)) == clear, kind
    for bad, heights in (("poly9", z), ("round", z), (3, z), ("poly8", z[:5, :5]), ("cylinder", np.full((9, 9), np.nan))):
        with pytest.raises(hdengine.InputError):
            form.remove(Specimen(heights, STEP), bad)


def test_gaussian_filter_passes_what_iso_16610_says():
    """A wave as long as the nesting index is passed by half, others by exp(-pi (alpha index / wavelength)^2), along x and y; levels are
    kept at edges and beside holes; wavelengths that the map cannot tell are refused."""
    x, y = grid(400, 500)
    for u, index in ((x, 40e-6), (y, 40e-6)):
        for wave in (20e-6, 40e-6, 100e-6):
            z = np.cos(2 * np.pi * u / wave)
            gain = np.sum(gaussian.lowpass(z, STEP, index)[100:300, 100:400] * z[100:300, 100:400]) / np.sum(z[100:300, 100:400] ** 2)
            assert gain == pytest.approx(np.exp(-np.log(2) * (index / wave) ** 2), abs=1e-4)
    z = np.full((60, 50), 3e-6)
    z[10:20, 5] = np.nan
    low = gaussian.lowpass(z, STEP, 20e-6)
    assert np.array_equal(np.isnan(low), np.isnan(z)) and low[~np.isnan(z)] == pytest.approx(3e-6, rel=1e-12)
    line = np.cos(2 * np.pi * x[0] / 30e-6)
    assert np.ptp((gaussian.highpass(line, STEP, 30e-6) - line / 2)[100:400]) < 1e-3
    for index in (2.9e-6, 1e-3):
        with pytest.raises(hdengine.InputError, match="nesting index"):
            gaussian.lowpass(z, STEP, index)


def test_heights_and_material_ratio_of_a_known_curve():
    """A material ratio curve of three straight parts gives its core, peaks and valleys; Smr and Smc are inverse to each other."""
    n = 100_000
    p = (np.arange(n) + 0.5) / n
    z = np.where(p < 0.1, 2 + 40 * (0.1 - p), np.where(p > 0.85, -20 * (p - 0.85), 2 * (0.85 - p) / 0.75)) * 1e-6
    z = np.random.default_rng(1).permutation(z).reshape(250, 400)
    v = texture.numbers(z, STEP)
    slope, top = 2e-6 / 0.75, 2e-6 + 0.1 * 2e-6 / 0.75       # of the core's line, and where it starts
    assert v["sk_m"] == pytest.approx(slope, rel=1e-3)
    # the peaks' part leaves the line's level `top` where 2 + 40 (0.1 - p) = top
    high = 0.1 - (top - 2e-6) / 40e-6
    low = 0.85 + (0.15 * slope) / 20e-6
    assert (v["smrk1"], v["smrk2"]) == pytest.approx((high, low), abs=1e-3)
    assert v["spk_m"] == pytest.approx(40e-6 * high, rel=5e-3) and v["svk_m"] == pytest.approx(20e-6 * (1 - low), rel=5e-3)
    assert v["sp_m"] + v["sv_m"] == pytest.approx(v["sz_m"]) == pytest.approx(9e-6, rel=1e-3)
    assert texture.smr(z, texture.smc(z, [0.02, 0.3, 0.97])) == pytest.approx([0.02, 0.3, 0.97], abs=1e-4)
    assert v["sxp_m"] == pytest.approx((2 + 40 * 0.075 - 2 * 0.35 / 0.75) * 1e-6, rel=1e-3)
    c, ratio = texture.texture(Specimen(z, STEP), "none").material_ratio()
    assert ratio[0] < 1e-4 and ratio[-1] == 1 and np.all(np.diff(ratio) >= 0) and np.all(np.diff(c) < 0)


def test_gradients_of_a_slope():
    """Sdq and Sdr of a tilted plane are those of its slope, with holes too."""
    x, y = grid(40, 50)
    z = 0.3 * x - 0.4 * y
    z[3:5, 8] = np.nan
    v = texture.numbers(z, STEP)
    assert v["sdq"] == pytest.approx(0.5, rel=1e-12) and v["sdr"] == pytest.approx(np.sqrt(1.25) - 1, rel=1e-12)


def test_autocorrelation_and_direction_of_a_lay():
    """Sal of a lay of waves is arccos(0.2) / 2 pi of the wavelength, Std its direction to 1.5 degrees, Str not told; of a Gaussian field
    three times as long along y Sal is that of its autocorrelation and Str a third."""
    x, y = grid(300, 420)
    for angle in (-1.3, 0.0, 0.5, 1.5):
        v = texture.numbers(np.sin(2 * np.pi * (np.cos(angle) * x + np.sin(angle) * y) / 20e-6), STEP)
        assert v["sal_m"] == pytest.approx(20e-6 * np.arccos(0.2) / (2 * np.pi), rel=0.02) and np.isnan(v["str"])
        assert abs(v["std_rad"] - angle) < 0.026
    rng, length = np.random.default_rng(2), 5e-6
    fx, fy = np.fft.fftfreq(800, 1e-6)[None], np.fft.fftfreq(800, 1e-6)[:, None]
    found = []
    for _ in range(3):      # autocorrelation exp(-(x/length)^2 - (y/3 length)^2)
        z = np.fft.ifft2(np.fft.fft2(rng.standard_normal((800, 800))) * np.exp(-0.5 * (np.pi * length) ** 2 * (fx**2 + 9 * fy**2))).real
        found.append(texture.numbers(z, 1e-6))
    assert np.mean([v["sal_m"] for v in found]) == pytest.approx(length * np.sqrt(np.log(5)), rel=0.05)
    assert np.mean([v["str"] for v in found]) == pytest.approx(1 / 3, rel=0.1)
    assert all(abs(v["std_rad"]) < 0.15 for v in found)


def test_outliers_and_holes_are_told():
    """Points far off become holes, holes are filled within the range of their surroundings with the tilt kept, and both are counted."""
    x, y = grid(60, 80)
    z = 1e-6 * (np.sin(x / 7e-6) + np.cos(y / 9e-6)) + 0.2 * x
    bad = z.copy()
    bad[20, 30], bad[40, 50:53], bad[0, 0] = 5e-5, np.nan, np.nan
    t = texture.texture(Specimen(bad, STEP), outliers=True, fill=True)
    assert (t.outliers, t.holes, t.filled) == (1, 5, True)
    filled, found = clean(Specimen(bad, STEP), outliers=True, fill=True)
    assert found == 1 and "filled" in filled.notes[-1] and np.array_equal(filled.heights[1:20], z[1:20])
    assert np.max(abs(filled.heights - z)) < 1.5e-6
    t = texture.texture(Specimen(bad, STEP), "none", outliers=True)
    assert (t.outliers, t.holes, t.filled) == (1, 5, False) and np.isnan(t.specimen.heights).sum() == 5
    with pytest.raises(hdengine.InputError, match="shorter"):
        texture.texture(Specimen(z, STEP), s_filter=2e-5, l_filter=1e-5)


def test_a_ring_s_roughness_is_left_by_cylinder_and_l_filter():
    """A fine roughness on a ring of 17.5 mm with waviness: form and L-filter bring Sq to that of the roughness within 5 %."""
    x, y = grid(300, 420)
    rough = 2e-8 * np.random.default_rng(5).standard_normal(x.shape)
    z = np.sqrt(17.5e-3**2 - x**2) + 3e-7 * np.sin(2 * np.pi * y / 2e-4) + rough
    t = texture.texture(Specimen(z, STEP), "cylinder", l_filter=2.5e-5)
    assert t.numbers["sq_m"] == pytest.approx(2e-8, rel=0.05)
    assert texture.texture(Specimen(z, STEP)).numbers["sq_m"] > 1e-7


FILES = sorted(p for p in SURFACES.glob("*") if p.suffix in (".vk4", ".plu", ".x3p", ".opd", ".al3d"))


@pytest.mark.full
@pytest.mark.skipif(not FILES, reason="measured surfaces not present")
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.name)
def test_measured_maps_beside_surface_topography(path):
    """On a measured map the polynomial of degree 2, Sq and the material ratio of SurfaceTopography are met: 1e-9, 1e-12 and 0.005 (it
    takes heights between points too)."""
    pytest.importorskip("SurfaceTopography")
    from SurfaceTopography import Topography

    s = clean(read(path), outliers=False, fill=True)[0]
    bent = Topography(s.heights.T, s.size).detrend("curvature").heights().T
    mine = form.remove(s, "poly2").specimen.heights
    assert np.max(abs(mine - (bent - bent.mean()))) < 1e-9 * np.std(mine)
    z = form.remove(s).specimen.heights
    flat = Topography(z.T, s.size)
    assert texture.numbers(z, s.spacing)["sq_m"] == pytest.approx(flat.rms_height_from_area(), rel=1e-12)
    for c in np.std(z) * np.array([-1, 0.5]):
        assert texture.smr(z, c) == pytest.approx(flat.bearing_area(float(c)), abs=0.005)


def test_the_command_takes_forms_and_filters(tmp_path, capsys):
    """`hdengine surface --form cylinder --l-filter` writes areal numbers and the material ratio curve; a bad form or filter is one error
    and code 2."""
    file, out = str(tmp_path / "specimen_bearing.sdf"), tmp_path / "o"
    whole = read(ROOT / "data/specimen_bearing.sdf")
    save(file, Specimen(whole.heights[:150, :180], whole.spacing))
    options = ["--form", "cylinder", "--s-filter", "2.5e-6", "--l-filter", "8e-5", "--outliers", "--fill"]
    assert main(["surface", file, *options, "--out", str(out)]) == 0
    assert "form      cylinder" in capsys.readouterr().out
    areal = json.loads((out / "surface.json").read_text())["surfaces"]["specimen_bearing"]["areal"]
    want = texture.texture(read(file), form="cylinder", s_filter=2.5e-6, l_filter=8e-5, outliers=True, fill=True)
    assert areal["form"] == "cylinder" and areal["form_radius_m"] == pytest.approx(want.form.radius_m)
    assert {k: areal[k] for k in ("sq_m", "sdr", "sk_m")} == pytest.approx({k: want.numbers[k] for k in ("sq_m", "sdr", "sk_m")})
    rows = read_csv(out / "material_ratio.csv")
    assert len(rows["smr"]) == 101 and rows["height_m"][0] == pytest.approx(areal["sp_m"])
    for bad in (["--form", "ball"], ["--l-filter", "1"], ["--s-filter", "1e-4", "--l-filter", "1e-5"]):
        assert main(["surface", file, *bad, "--out", str(out), "--force"]) == 2
        assert capsys.readouterr().err.startswith("error: ")


def test_what_is_printed_is_in_micrometres(tmp_path, exe):
    """Heights and lengths print in micrometres under the names of ISO 25178-2; a fit that is refused prints no D and G, in the
    command, the figure and the log, one that holds its G."""
    fine = read(ROOT / "data/specimen_bearing.sdf")
    found = texture.texture(fine)
    said, fit = str(found), str(fine.fit(surface=hdengine.roughness.Ridges(5e-4, 1e-6, 10, 1.5)))
    assert f"Sa {1e6 * found.numbers['sa_m']:.4g}, Sq {1e6 * found.numbers['sq_m']:.4g}, " in said
    assert f"Sdr {100 * found.numbers['sdr']:.4g}, " in said
    assert re.search(r"^G +0\.09\d* µm, ", fit, re.M) and not re.search(r"e-\d+ m\b|\d m\b", said + fit)
    sine = np.tile(1e-6 * np.sin(np.arange(200) * 2 * np.pi / 40), (200, 1))
    fits = [Specimen(sine, (1e-6, 1e-6), "sine").fit(), fine.fit(surface=hdengine.roughness.Ridges(5e-4, 1e-6, 10, 1.5))]
    drawn = [" ".join(t.get_text() for t in fit.plot().get_legend().get_texts()) for fit in fits]
    assert "no D and G" in drawn[0] and "D =" not in drawn[0] and re.search(r"D = 2\.\d{4}, G = 0\.09\d* µm", drawn[1]), drawn
    refused = str(fits[0])
    assert "not fractal" in refused and "none that describe this surface" in refused and not re.search(r"^[DG] |2\.\d{4}", refused, re.M)
    np.save(tmp_path / "sine.npy", sine)
    (tmp_path / "s.nml").write_text(f"&hd_input\n version = 1\n/\n&fit\n first_file = '{tmp_path}/sine.npy'\n dx = 1e-6\n/\n")
    refused, held = (next(line for line in call(exe, *words, "--out", tmp_path / "o", "--force").stdout.splitlines() if line.startswith("fit "))
                     for words in ((tmp_path / "s.nml",), (ROOT / "data/surface.nml", "surface.nx=101", "surface.ny=101")))
    assert "not fractal" in refused and "D =" not in refused and re.search(r"D = 2\.\d{4} .*, G = 0\.2\d* um, fractal", held)
