# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface runs: specimens from files, fit and figures from a namelist (Fig. 5)."""
import json
import struct

import numpy as np
import pytest

import hdengine
from conftest import ROOT, call
from hdengine import roughness, specimen, surface
from hdengine.cli import main
from hdengine.surfaces.texture import texture

FIG5 = ROOT / "data/fig5_surface.nml"
KNOWN = roughness.Ridges(0.5e-3, 1e-6)


@pytest.fixture(scope="module")
def fig5(exe, tmp_path_factory):
    """Folder of data/fig5_surface.nml run by hdengine.x."""
    folder = tmp_path_factory.mktemp("fig5") / "fig5.out"
    done = call(exe, FIG5, "--out", folder, "-q")
    assert done.returncode == 0, done.stderr
    return folder


def write_lines(path, z, spacing):
    """A map as SDF text."""
    rows = "\n".join(" ".join("BAD" if np.isnan(h) else repr(float(h)) for h in row) for row in z)
    head = {"ManufacID": "test", "NumPoints": z.shape[1], "NumProfiles": z.shape[0], "Xscale": spacing[1], "Yscale": spacing[0],
            "Zscale": 1e-6, "Zresolution": -1, "Compression": 0, "DataType": 7, "CheckType": 0}
    path.write_text("aISO-1.0\n" + "".join(f"{k} = {v}\n" for k, v in head.items()) + f"*\n{rows}\n*\n")


def test_figure_5_from_one_command(fig5):
    """The two specimens of data/ give, by namelist as by Python, the equivalent surface of the paper: D_s = 1.5304 and
    G = 2.4248e-7 m within 3 standard errors of 0.001 and 1 %, called fractal, and the roughness numbers of both."""
    fits = json.loads((fig5 / "summary.json").read_text())["fits"]
    assert set(fits) == {"first", "second", "equivalent"} and "roughness" not in fits["equivalent"]
    pair = [specimen.read(ROOT / f"data/specimen_{n}.sdf") for n in ("flexspline", "bearing")]
    joint = specimen.equivalent(*pair, surface=KNOWN)
    for one, s in zip(pair, fits.values()):
        numbers = texture(one).numbers
        for key in ("sa_m", "sq_m", "sz_m", "ssk", "sku", "sdq"):
            assert s["roughness"][key] == pytest.approx(numbers[key], rel=1e-9)
    for fit, s in zip((*joint.fits, joint.equivalent), fits.values()):
        assert s["fractal_dimension"] == pytest.approx(fit.fractal_dimension, rel=1e-9)
        assert s["roughness_m"] == pytest.approx(fit.roughness_m, rel=1e-8)
        assert s["fractal_dimension_error"] == pytest.approx(fit.fractal_dimension_error, rel=1e-6)
        assert s["verdict"] == fit.verdict == "fractal" and s["lags"] == [1, 20]
    s = fits["equivalent"]
    assert abs(s["fractal_dimension"] - 2.5304) < 3 * s["fractal_dimension_error"] < 3e-3
    assert abs(np.log(s["roughness_m"] / 2.4248e-7)) < 3 * s["ln_roughness_error"] < 0.03


def test_table_holds_the_band(fig5):
    """fit.csv has S of the sum equal to the sum of S, between the bounds of its 95 % band at 18 of 20 lags at least."""
    result = hdengine.SurfaceResult(fig5)
    first, second, both = result.fits.values()
    assert both.s_m2 == pytest.approx(first.s_m2 + second.s_m2, rel=1e-12)
    low, high = both.band
    assert np.sum((low < both.s_m2) & (both.s_m2 < high)) >= 18
    assert result.joint.equivalent is both and [s.name for s in result.specimens] == ["specimen_flexspline", "specimen_bearing"]
    assert "equivalent\nverdict   fractal" in str(result)


def test_echo_repeats_the_fit(exe, fig5, tmp_path):
    """The echo, run from anywhere, gives the same fits."""
    assert call(exe, fig5 / "echo.nml", "--out", tmp_path / "b.out", "-q", cwd=tmp_path).returncode == 0
    again, before = (json.loads((f / "summary.json").read_text())["fits"] for f in (tmp_path / "b.out", fig5))
    assert again == before


def test_command_draws_figure_5(tmp_path, capsys):
    """`hdengine run` does the same and draws map, profiles and structure functions; `hdengine plot` draws them again."""
    out = str(tmp_path / "fig5.out")
    assert main(["run", str(FIG5), "fit.last_lag=10", "--out", out]) == 0
    text = capsys.readouterr().out
    assert text.count("verdict   fractal") == 3 and "lags 1 to 10" in text
    assert (tmp_path / "fig5.out/fit.png").stat().st_size > 20000
    assert main(["plot", out]) == 0


def test_generated_surface_is_fitted(exe, tmp_path):
    """data/surface.nml finds its own D and G within 3 standard errors; `none`, or a map too small for 4 lags, has no fit."""
    result = hdengine.run_surface(ROOT / "data/surface.nml", tmp_path / "a.out")
    fit = result.fits["generated"]
    assert abs(fit.fractal_dimension - 2.5304) < 3 * fit.fractal_dimension_error < 4e-3 and fit.model == "ridges"
    assert len(result.plot()) == 1
    for change in ({"fit__model": "none"}, {"surface__nx": 8, "surface__ny": 8}):
        result = hdengine.run_surface(ROOT / "data/surface.nml", tmp_path / "b.out", force=True, **change)
        assert result.fits == {} and result.plot() == [] and result.specimens[0].heights.ndim == 2


def test_formats_agree(exe, tmp_path):
    """A map with a hole gives one D from binary SDF, text SDF, and .npy in both orders and precisions."""
    z = specimen.read(ROOT / "data/specimen_bearing.sdf").heights[:120, :150].copy()
    z[5, 7] = np.nan
    specimen.save(tmp_path / "a.sdf", specimen.Specimen(z, (1e-6, 1e-6)))
    z = specimen.read(tmp_path / "a.sdf").heights
    write_lines(tmp_path / "b.sdf", z * 1e6, (1e-6, 1e-6))
    np.save(tmp_path / "c.npy", z)
    np.save(tmp_path / "d.npy", np.asfortranarray(z))
    np.save(tmp_path / "e.npy", z.astype("f4"))
    exact = roughness.fit(z, 1e-6)
    for name in "abcde":
        file = next(tmp_path.glob(f"{name}.*"))
        keys = {"fit__dx": 1e-6} if file.suffix == ".npy" else {}
        fit = hdengine.run_surface(out=tmp_path / f"{name}.out", fit__first_file=str(file), **keys).fits["first"]
        assert fit.fractal_dimension == pytest.approx(exact.fractal_dimension, abs=1e-6)
    pytest.importorskip("SurfaceTopography")
    again = specimen.read(tmp_path / "b.sdf")
    assert np.allclose(again.heights, z, rtol=1e-12, equal_nan=True) and again.spacing == pytest.approx((1e-6, 1e-6))


def test_profile_is_fitted(tmp_path):
    """A single line of .npy whose spectrum has lines is fitted by the structure function of a profile."""
    np.save(tmp_path / "line.npy", surface.profile(20000, 1e-6, 2.4, 1e-7, 1.5, 2e-2, 1e-6))
    keys = {"fit__first_file": str(tmp_path / "line.npy"), "fit__dx": 1e-6}
    fit = hdengine.run_surface(out=tmp_path / "a.out", **keys).fits["first"]
    assert fit.model == "profile" and abs(fit.fractal_dimension - 2.4) < 3 * fit.fractal_dimension_error


BAD = {
    "missing.sdf": (3, {}), "short.sdf": (3, {}), "cut.sdf": (3, {}), "lines.sdf": (3, {}), "kind.sdf": (3, {}),
    "array.npy": (3, {"fit__dx": 1e-6}), "whole.npy": (3, {"fit__dx": 1e-6}), "good.npy": (2, {}), "map.vk4": (2, {}),
    "good.sdf": (2, {"fit__dx": 1e-6}), "tiny.sdf": (2, {}),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_one_error_each(tmp_path, name):
    """Files that are missing, cut off, of another kind, without spacing or too small: one error with the name or the lags."""
    z = np.random.default_rng(1).standard_normal((60, 60))
    specimen.save(tmp_path / "good.sdf", specimen.Specimen(z, (1e-6, 1e-6)))
    specimen.save(tmp_path / "tiny.sdf", specimen.Specimen(z[:6, :6], (1e-6, 1e-6)))
    data = (tmp_path / "good.sdf").read_bytes()
    (tmp_path / "short.sdf").write_bytes(b"bISO")
    (tmp_path / "cut.sdf").write_bytes(data[:-1])
    (tmp_path / "kind.sdf").write_bytes(data[:79] + b"\2" + data[80:])
    write_lines(tmp_path / "lines.sdf", z[:3, :3], (1e-6, 1e-6))
    (tmp_path / "lines.sdf").write_text((tmp_path / "lines.sdf").read_text().replace("*\n", "* \n1 x "))
    (tmp_path / "array.npy").write_bytes(b"no array at all")
    np.save(tmp_path / "whole.npy", np.zeros((5, 5), dtype=int))
    np.save(tmp_path / "good.npy", z)
    (tmp_path / "map.vk4").write_bytes(b"")
    code, keys = BAD[name]
    with pytest.raises(hdengine.HdengineError) as e:
        hdengine.run_surface(out=tmp_path / "a.out", fit__first_file=str(tmp_path / name), **keys)
    assert e.value.code == code and (name in str(e.value) or "at least 4 lags" in str(e.value))
    assert "\n" not in str(e.value)


def raw_npy(shape, body=bytes(80)):
    """A .npy of reals of 8 bytes whose header says what it likes."""
    text = f"{{'descr': '<f8', 'fortran_order': False, {shape}}}".ljust(117) + "\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text.encode() + body


@pytest.mark.parametrize("head, fits", [("'fortran_order':True,'shape':(2,5)", True), ("'fortran_order':  True, 'shape': ( 2, 5 )", True),
                                        ("'fortran_order': 1, 'shape': (2, 5)", False), ("'shape': (2, 5)", False),
                                        ("'fortran_order': True, 'shape': (2, 5), 'shape': (5, 2)", False)])
def test_headers_may_be_spaced_in_any_way(tmp_path, head, fits):
    """A .npy by columns is read so however its header is spaced; one that does not say its order once is refused."""
    z = 1e-6 * np.arange(10.0).reshape(2, 5)
    text = f"{{'descr': '<f8', {head}}}".ljust(117) + "\n"
    (tmp_path / "a.npy").write_bytes(b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text.encode() + z.tobytes("F"))
    keys = {"fit__first_file": str(tmp_path / "a.npy"), "fit__dx": 1e-6, "fit__model": "none"}
    if fits:
        hdengine.run_surface(out=tmp_path / "a.out", **keys)
        np.testing.assert_array_equal(np.load(tmp_path / "a.out/first.npy"), z)
    else:
        with pytest.raises(hdengine.FileError, match="no array of heights"):
            hdengine.run_surface(out=tmp_path / "a.out", **keys)


@pytest.mark.parametrize("shape", ["", "'shape': ()", "'shape': (5,)", "'shape': (1000000, 1000000)", "'shape': (3000000000, 3000000000)",
                                   "'shape': (2147483647, 2147483647)", "'shape': (-2, -5)", "'shape': (2*5,)", "'shape': (2, 5/)",
                                   "'shape': (5, 2", "'shape': (11,)", "'shape': (1, 2, 5)", "'shape': (2.0, 5)"])
def test_shapes_are_those_of_the_bytes(tmp_path, shape):
    """A .npy whose header states no shape, or another than its bytes hold, is one FileError in Python and in a run."""
    path = tmp_path / "a.npy"
    path.write_bytes(raw_npy("'shape': (2, 5)"))
    assert specimen.read(path, spacing=1e-6).heights.shape == (2, 5)
    hdengine.run_surface(out=tmp_path / "a.out", fit__first_file=str(path), fit__dx=1e-6, fit__model="none")
    path.write_bytes(raw_npy(shape))
    with pytest.raises(hdengine.FileError, match="a.npy"):
        specimen.read(path, spacing=1e-6)
    with pytest.raises(hdengine.FileError, match="a.npy"):
        hdengine.run_surface(out=tmp_path / "b.out", fit__first_file=str(path), fit__dx=1e-6)


@pytest.mark.parametrize("old, new, says", [
    ("1 2 3", "1 / 3", "'/'"), ("1 2 3", "1 2*2 3", "'2[*]2'"), ("1 2 3", "1 1;2 3", "'1;2'"), ("1 2 3", "1 1+13 3", r"'1\+13'"),
    ("1 2 3", "1 , 3", "','"), ("1 2 3", "1 inf 3", "'inf'"), ("1 2 3", "1 3", "[*]|holds 8"), ("1 2 3", "1 2 3 4", "'9'|holds 10"),
    ("NumPoints = 3", "NumPoints = 3/", "'3/'"), ("NumPoints = 3", "NumPoints = 2000000000", "cut"), ("Zscale = 1", "Zscale = 1,2", "'1,2'"),
    ("NumPoints = 3", "NumPoints = 4.5", "4.5"), ("NumPoints = 3", "NumPoints = -3", "-3"), ("NumProfiles = 3", "NumProfiles = 0", "x 0 points"),
    ("Zscale = 1", "Zscale = 1\nZscale = 2", "(?i)zscale stands (twice|2 times)"), ("Xscale = 1\n", "", "(?i)xscale|scales are"),
    *((f"{name} = 1", f"{name} = 0", "scale") for name in ("Xscale", "Yscale", "Zscale")),
    ("aISO-1.0", "aISO-2.0", "ISO-2.0"), ("Xscale = 1", "Xscale = 80", r"160(\.0)? m wide"), ("1 2 3", "1 1e300 3", r"1(.0)?e\+?300"),
])
def test_text_is_read_as_it_stands(tmp_path, old, new, says):
    """What is no number in a text SDF, a count that does not fit, another version and heights of no instrument are one error each,
    with the word that was seen; the file without the fault is read, under the first word of BCR too."""
    text = "aISO-1.0\nNumPoints = 3\nNumProfiles = 3\nXscale = 1\nYscale = 1\nZscale = 1\n*\n1 2 3\nBAD 5 NaN\n7 8 9\n*\n"
    for good in (text, text.replace("ISO", "BCR")):
        (tmp_path / "a.sdf").write_text(good)
        hdengine.run_surface(out=tmp_path / "a.out", fit__first_file=str(tmp_path / "a.sdf"), fit__model="none", force=True)
        for z in (specimen.read(tmp_path / "a.sdf").heights, np.load(tmp_path / "a.out/first.npy")):
            assert np.array_equal(z, [[1, 2, 3], [np.nan, 5, np.nan], [7, 8, 9]], equal_nan=True)
    assert old in text
    (tmp_path / "a.sdf").write_text(text.replace(old, new))
    for call_it in (lambda: specimen.read(tmp_path / "a.sdf"),
                    lambda: hdengine.run_surface(out=tmp_path / "b.out", fit__first_file=str(tmp_path / "a.sdf"))):
        with pytest.raises(hdengine.HdengineError, match=says) as e:
            call_it()
        assert "\n" not in str(e.value)


@pytest.mark.parametrize("keys, says", [
    ({"fit__second_file": "a.sdf"}, "without fit.first_file"),
    ({"surface__ridges": 1000, "fit__model": "ridges"}, "up to 4000 waves"),
    ({"fit__first_lag": 5, "fit__last_lag": 6}, "at least 4 lags"), ({"fit__last_lag": 400}, "half the length of a row"),
    ({"fit__shortest_wavelength": 1.0, "fit__longest_wavelength": 0.5}, "band"), ({"load__torque": 1.0}, "contact run"),
], ids=lambda v: None if isinstance(v, str) else next(iter(v)))
def test_bad_fits_are_refused(tmp_path, keys, says):
    """Windows, bands and models that make no sense are one InputError each."""
    with pytest.raises(hdengine.InputError, match=says):
        hdengine.run_surface(out=tmp_path / "a.out", **({"surface__nx": 128, "surface__ny": 128} | keys))
