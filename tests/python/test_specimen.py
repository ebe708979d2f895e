# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading specimens, the two of data/, the command `hdengine surface`."""
import json
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import hdengine
from conftest import ROOT
from hdengine import roughness, specimen
from hdengine.cli import main
from hdengine.files import write_folder
from hdengine.surfaces import folder, texture
from hdengine.table_file import read_csv

SURFACES = ROOT.parent / "shared/surfaces"
KNOWN = roughness.Ridges(0.5e-3, 1e-6)


@pytest.fixture(scope="module")
def pair():
    return [specimen.read(ROOT / f"data/specimen_{name}.sdf") for name in ("flexspline", "bearing")]


def test_specimens_give_the_paper_surface(pair):
    """The two specimens of data/ are 0.5 x 0.5 mm; their equivalent surface has D_s = 1.5304 and G = 2.4248e-7 m within 3 standard
    errors of 0.001 and 1 %, by the exact sum; within 0.01 told nothing."""
    assert all(s.size == pytest.approx((0.5e-3, 0.5e-3)) for s in pair)
    exact = specimen.equivalent(*pair, surface=KNOWN).equivalent
    assert abs(exact.fractal_dimension - 2.5304) < 3 * exact.fractal_dimension_error < 3e-3
    assert abs(np.log(exact.roughness_m / 2.4248e-7)) < 3 * exact.ln_roughness_error < 0.03
    blind = specimen.equivalent(*pair)
    assert blind.equivalent.fractal_dimension == pytest.approx(exact.fractal_dimension, abs=0.01)
    assert "equivalent surface" in str(blind)


def test_saved_specimen_reads_back(tmp_path):
    """A map with holes comes back within half a step of 1/64000 of its range, holes in place."""
    z = np.random.default_rng(1).standard_normal((20, 30))
    z[3, 4] = np.nan
    specimen.save(tmp_path / "a.sdf", specimen.Specimen(z, (2e-6, 1e-6)))
    back = specimen.read(tmp_path / "a.sdf")
    assert back.spacing == (2e-6, 1e-6) and np.isnan(back.heights[3, 4])
    shift = np.nanmean(back.heights - z)
    assert np.nanmax(abs(back.heights - z - shift)) < 1e-4
    specimen.save(tmp_path / "flat.sdf", specimen.Specimen(np.zeros((20, 30)), (2e-6, 1e-6)))
    assert specimen.read(tmp_path / "flat.sdf").notes == ()  # nothing to doubt a scale by


def test_numbers_of_a_sine():
    """Sq = A/sqrt(2), Sa = 2A/pi, Sdq = slope/sqrt(2), kurtosis 1.5 of a fine sine."""
    x = np.arange(20000)
    p = texture.numbers(1e-6 * np.sin(2 * np.pi * x / 200 + 0.3), 1e-6)
    assert p["sq_m"] == pytest.approx(1e-6 / 2**0.5, rel=1e-3) and p["sa_m"] == pytest.approx(2e-6 / np.pi, rel=1e-3)
    assert p["sdq"] == pytest.approx(2 * np.pi / 200 / 2**0.5, rel=1e-3) and p["sku"] == pytest.approx(1.5, rel=1e-3)


UNITS = {"nanovea_test2.txt": {"unit": ("mm", "um")}, "npl_edm_x_um_z_um.csv": {"unit": "um"}}
FILES = sorted(p.name for p in SURFACES.glob("*") if not p.name.startswith(("LICENSE", "MANIFEST")))
ROUGH = {"plu-1_crop_0.5mm.vk4": (1.51e-8, 499.66e-6), "plu-1_crop_0.5mm.vk6": (1.51e-8, 499.66e-6),
         "plu-1.plu": (1.83e-8, 1274.9e-6),
         "x3p-2.x3p": (7.72e-8, 83e-6), "sflz_test_1.opd": (1.927e-6, 1.2028e-3), "al3d-1.al3d": (2.9e-7, 87.6e-6)}


@pytest.mark.full
@pytest.mark.skipif(not FILES, reason="measured surfaces not present")
@pytest.mark.parametrize("name", FILES)
def test_measured_files_read(name):
    """Every measured file reads, with unit and size as published, and is judged; without its unit it is refused by name."""
    pytest.importorskip("SurfaceTopography")
    if name in UNITS:
        with pytest.raises(hdengine.InputError, match="states no"):
            specimen.read(SURFACES / name)
    s = specimen.read(SURFACES / name, **UNITS.get(name, {}))
    if name in ROUGH:
        sq, width = ROUGH[name]
        assert texture.texture(s).numbers["sq_m"] == pytest.approx(sq, rel=0.02) and s.size[-1] == pytest.approx(width, rel=0.01)
    f = s.fit()
    assert f.verdict in ("fractal", "not fractal", "noise-dominated") and f.reason
    if "sine" in name:
        assert f.kind == "sine"


def test_sur_file_reads(tmp_path):
    """A Digital Surf file (SUR) with lateral scales in um, heights in nm and one hole is read in metres, row by row."""
    pytest.importorskip("SurfaceTopography")
    z = np.array([[5, 7, -3, 0], [1, 2, -42, 8], [9, -6, 4, 3]], dtype="<i2")
    units = [t.encode() for t in ("X", "Y", "Z", "um", "um", "nm", "um", "um", "nm")]
    head = struct.pack("<12s4H30s30s5H8xH4iI3f" + 9 * "16s" + "3f3H12x7Hf10x2H128s3f34x", b"DIGITAL SURF", 0, 1, 1, 2, b"made", b"", 0, 0, 0, 1,
                       0, 16, -40, 9, 4, 3, 12, 2.0, 3.0, 0.5, *units, 1, 1, 1, 0, 0, 0, 1, 2, 3, 4, 5, 2020, 0, 1.0, 0, 0, b"", 0, 0, 0)
    (tmp_path / "a.sur").write_bytes(head + z.tobytes())
    s = specimen.read(tmp_path / "a.sur")
    assert s.spacing == pytest.approx((3e-6, 2e-6), rel=1e-6)
    assert np.isnan(s.heights[1, 2]) and np.nansum(s.heights != 0.5e-9 * z) == 1
    assert s.heights[2] == pytest.approx(0.5e-9 * z[2], rel=1e-6)


WALK = re.findall(r"```python\n(.*?)```", (ROOT / "docs/howto/surfaces_to_stiffness.md").read_text(), re.S)[:3]


def test_walk_from_surfaces_to_a_band_is_short():
    """The tutorial goes from two files to K_TS with a band in fewer than 30 lines of code (test_house.py runs them)."""
    lines = [line for block in WALK for line in block.splitlines() if line.strip()]
    assert len(lines) < 30 and "quantile" in lines[-1] and "specimen.read" in "".join(lines)


@pytest.mark.full
@pytest.mark.skipif(not FILES, reason="measured surfaces not present")
def test_walk_with_measured_surfaces(tmp_path):
    """The same lines give a finite K_TS inside its band from the two halves of a measured surface (no two of one joint are public)."""
    pytest.importorskip("SurfaceTopography")
    whole = specimen.read(SURFACES / "sflz_test_1.opd")
    half = whole.heights.shape[1] // 2
    for name, part in (("flexspline", whole.heights[:, :half]), ("bearing", whole.heights[:, half:2 * half])):
        specimen.save(tmp_path / f"specimen_{name}.sdf", specimen.Specimen(np.ascontiguousarray(part), whole.spacing))
    code = "\n".join(WALK).replace("(flexspline, ring)", "(flexspline, ring, model='paper')")  # the spectrum leaves G open
    code = code.replace('f"data/specimen_{name}.sdf"', f'f"{tmp_path}/specimen_{{name}}.sdf"')
    code = code.replace('"data/', f'"{ROOT}/data/').replace('"tutorial.out"', repr(str(tmp_path / "out")))
    found = {}
    exec(code, found)
    low, high = found["np"].quantile(found["values"], [0.025, 0.975])
    assert 0 < low < found["field"].k_ts() < high


def test_bad_files_are_named(tmp_path):
    """A missing file, damaged ones and an unreadable one are one FileError each, with the file's name."""
    (tmp_path / "cut.sdf").write_bytes((ROOT / "data/specimen_bearing.sdf").read_bytes()[:-1])
    (tmp_path / "zeros.sdf").write_bytes(b"bISO-1.0" + bytes(200))
    (tmp_path / "noise.x3p").write_bytes(b"no surface")
    for name in ("missing.vk4", "cut.sdf", "zeros.sdf", "noise.x3p"):
        if name.endswith("x3p"):
            pytest.importorskip("SurfaceTopography")
        with pytest.raises(hdengine.FileError, match=name):
            specimen.read(tmp_path / name)


def test_command_reads_fits_and_plots(tmp_path, capsys):
    """`hdengine surface` prints verdict, D and G of both specimens and of their sum and writes a folder; bad calls are one line
    on stderr and the code of the error, and leave the folder as it is."""
    files = [str(ROOT / f"data/specimen_{n}.sdf") for n in ("flexspline", "bearing")]
    assert main(["surface", *files, "--pair", "--ridges", "5e-4,1e-6,10,1.5", "--out", str(tmp_path / "o")]) == 0
    text = capsys.readouterr().out
    assert text.count("verdict   fractal") == 3 and "D         2.53" in text
    figures = {"joint_surface.png", "specimen_flexspline.png", "specimen_bearing.png"}
    assert {p.name for p in (tmp_path / "o").iterdir()} == {"surface.json", "structure.csv", "spectrum.csv", "material_ratio.csv", "scene.nml", *figures}
    found = json.loads((tmp_path / "o/surface.json").read_text())
    assert found["status"] == "complete" and set(found["surfaces"]) == {"specimen_flexspline", "specimen_bearing", "equivalent"}
    rows = read_csv(tmp_path / "o/structure.csv")
    assert set(rows["surface"]) == set(found["surfaces"]) and np.all(abs(np.log(rows["s_m2"] / rows["model_m2"])) < 0.1)
    scene = hdengine.read_scene(tmp_path / "o/scene.nml")
    joint = found["surfaces"]["equivalent"]
    assert scene["joint.fractal_dimension"] == pytest.approx(joint["fractal_dimension"], abs=1e-5)
    assert scene["joint.roughness"] == pytest.approx(joint["roughness_m"], rel=1e-4) and scene["joint.sample_length"] == 5e-4
    before = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "o").iterdir()}
    assert main(["surface", files[0], "--out", str(tmp_path / "o")]) == 3 and "--force" in capsys.readouterr().err
    for words, code in ((["--pair", files[0]], 2), (["none.vk4"], 3), ([files[0], "--lags", "1", "400"], 2)):
        assert main(["surface", *words, "--out", str(tmp_path / "o"), "--force"]) == code
        stderr = capsys.readouterr().err
        assert stderr.startswith("error: ") and stderr.count("\n") == 1
    assert before == {p.name: p.stat().st_mtime_ns for p in (tmp_path / "o").iterdir()}


@pytest.fixture(scope="module")
def small():
    """A map with dx unlike dy and one of white noise, with their fits."""
    rng = np.random.default_rng(1)
    f = np.hypot(np.fft.fftfreq(48, 2.0)[:, None], np.fft.rfftfreq(64)[None])
    f[0, 0] = np.inf
    z = 1e-7 * np.fft.irfft2(f**-1.5 * np.fft.rfft2(rng.standard_normal((48, 64))), s=(48, 64))
    maps = [specimen.Specimen(z, (2e-6, 1e-6), "same"), specimen.Specimen(1e-7 * rng.standard_normal((48, 64)), (1e-6, 1e-6), "same")]
    return maps, [m.fit() for m in maps]


def test_folder_of_two_files_of_one_stem(small, tmp_path):
    """Maps of one name keep a figure each, directions of unlike spacing are named, and what is not fractal gets no D and G to paste."""
    folder.write(tmp_path / "o", *small)
    assert {"same.png", "same_2.png"} < {p.name for p in (tmp_path / "o").iterdir()}
    rows = read_csv(tmp_path / "o/structure.csv")
    assert set(rows["direction"][rows["surface"] == "same"]) == {"rows", "columns"}
    text = (tmp_path / "o/scene.nml").read_text()
    assert "same_2: " in text and "white noise" in text and "fractal_dimension" not in text.split("same_2")[1]
    json.loads((tmp_path / "o/surface.json").read_text(), parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


def test_unlike_spacing_is_drawn_as_two_lines(small):
    """S along rows and along columns of a map with dx unlike dy are two rising lines of points, and two of the model."""
    lines = small[1][0].plot().get_lines()
    assert len(lines) == 4 and all(np.all(np.diff(line.get_xdata()) > 0) for line in lines)


def test_a_broken_folder_is_never_whole(tmp_path):
    """A write that fails midway over an earlier folder leaves that as it was, and one error; the next one is whole, without the files
    of the first; a folder of another command is never written to."""
    class Broken:
        def savefig(self, file, format):
            file.write(b"half")
            raise OSError(28, "no space left")

    write_folder(tmp_path, "surface.json", {}, {"a.csv": "1", "old.csv": "2"})
    with pytest.raises(hdengine.FileError, match="--force"):
        write_folder(tmp_path, "surface.json", {}, {"a.csv": "3"})
    with pytest.raises(hdengine.FileError, match="no space left"):
        write_folder(tmp_path, "surface.json", {}, {"a.csv": "3", "b.png": Broken()}, force=True)
    assert {p.name for p in tmp_path.iterdir()} == {"a.csv", "old.csv", "surface.json"} and (tmp_path / "a.csv").read_text() == "1"
    write_folder(tmp_path, "surface.json", {"x": float("nan")}, {"a.csv": "4"}, force=True)
    found = json.loads((tmp_path / "surface.json").read_text())
    assert found["x"] is None and found["files"] == ["a.csv"] and (tmp_path / "a.csv").read_text() == "4"
    (tmp_path / "surface.json").rename(tmp_path / "summary.json")
    with pytest.raises(hdengine.FileError, match="another command"):
        write_folder(tmp_path, "surface.json", {}, {"a.csv": "5"}, force=True)


def test_the_specimens_of_data_are_what_their_script_makes(tmp_path):
    """data/make_specimens.py gives both files again, byte for byte, on any platform."""
    script = Path(shutil.copy(ROOT / "data/make_specimens.py", tmp_path))
    subprocess.run([sys.executable, script], check=True, cwd=tmp_path)
    for name in ("specimen_flexspline.sdf", "specimen_bearing.sdf"):
        assert (tmp_path / name).read_bytes() == (ROOT / "data" / name).read_bytes()


@pytest.mark.parametrize("name, keys, says", [
    ("m.npy", {}, "no lateral size"), ("m.npy", {"unit": "furlong", "spacing": 1e-6}, "furlong"), ("cube.npy", {"spacing": 1e-6}, r"\(4, 5, 6\)"),
    ("m.npy", {"unit": ("um",) * 3, "spacing": 1e-6}, "one unit, or two"),
    ("g.xml", {"unit": "um"}, "states its unit"), ("g.xml", {"spacing": 1e-6}, "states its size"), ("bare.xml", {"unit": "um"}, "no lateral size"),
    ("few.xml", {}, "states 3 points and holds 2"), ("cut.xml", {}, "damaged or cut"),
    *((f"{i}.sdf", {"unit": "um", "spacing": 1e-6}, "format SDF") for i in range(4)),
    ("t.sdf", {}, "states 2 x 2 points and holds 3"), ("words.sdf", {}, "damaged"),
])
def test_what_a_file_states_is_not_said_again(tmp_path, name, keys, says):
    """What a file lacks is asked for, what it states and a caller says again is refused, and counts that do not fit are named."""
    gauge = ("<SOFTGAUGE><DATAFILE><NUMPOINTS>{}</NUMPOINTS>{}<DATA_POINT_VALUES>{}</DATA_POINT_VALUES></DATAFILE></SOFTGAUGE>")
    files = {"g.xml": gauge.format(2, "<UNITS>um</UNITS><SPACING>0.5</SPACING>", "1 2"), "bare.xml": gauge.format(2, "", "1 2"),
             "few.xml": gauge.format(3, "<UNITS>um</UNITS><SPACING>0.5</SPACING>", "1 2"), "cut.xml": "<SOFTGAUGE><DATAFILE>",
             "t.sdf": "aISO-1.0\nNumPoints = 2\nNumProfiles = 2\nXscale = 1\nYscale = 1\nZscale = 1\n*\n1 2 3\n*\n",
             **{f"{i}.sdf": first + "-1.0\nNumPoints = 2\nNumProfiles = 1\nXscale = 1\nYscale = 1\nZscale = 1\n*\n1 2\n*\n"
                for i, first in enumerate(("\ufeffaISO", "aiso", "\n aISO", "# a map\naISO"))},
             "words.sdf": "aISO-1.0\nNumPoints = two\n*\n1\n*\n"}
    if name in files:
        (tmp_path / name).write_text(files[name].replace("<SOFT", "<!DOCTYPE DATA SYSTEM 'softgauge.dtd'>\n<SOFT", 1))
    np.save(tmp_path / "m.npy", np.ones((4, 5)))
    np.save(tmp_path / "cube.npy", np.ones((4, 5, 6)))
    with pytest.raises(hdengine.HdengineError, match=says):
        specimen.read(tmp_path / name, **keys)


X = [0.5 * i for i in range(200)]
Z = [0.01 * (i * 7 % 11) for i in range(200)]
GRID = [(0.1 * j / 3, 0.2 * i, 0.01 * (i * j % 7)) for i in range(20) for j in range(30)]


def lines(rows):
    return "".join(" ".join(f"{v:.9g}" if isinstance(v, float) else v for v in row) + "\n" for row in rows)


def test_plain_tables_are_read_as_they_stand(tmp_path):
    """Profiles and points of a map, in any order, with gaps, holes, a byte-order mark or falling x, give their heights at their places."""
    def read(text, encoding="utf-8"):
        (tmp_path / "a.txt").write_text(text, encoding=encoding)
        return specimen.read(tmp_path / "a.txt", unit="um")

    rows = list(zip(X, Z))
    for s in (read(lines(rows)), read(lines(rows), "utf-8-sig"), read(lines(rows[::-1]))):
        assert s.heights * 1e6 == pytest.approx(Z, abs=1e-12) and s.spacing[1] == pytest.approx(0.5e-6)
    holed = read(lines([*rows[:30], (X[30], "Bad"), *rows[31:]]))
    assert np.flatnonzero(np.isnan(holed.heights)).tolist() == [30] and np.nanmax(abs(holed.heights * 1e6 - Z)) < 1e-12
    whole = np.reshape([row[2] for row in GRID], (20, 30))
    order = np.random.default_rng(1).permutation(len(GRID))
    s = read(lines([GRID[k] for k in order]))
    assert s.heights * 1e6 == pytest.approx(whole, abs=1e-12) and s.spacing == pytest.approx((0.2e-6, 0.1e-6 / 3))
    s = read("# Lateral units: um\n" + lines(GRID[k] for k in order[40:]))
    assert np.isnan(s.heights).sum() == 40 and np.nanmax(abs(s.heights * 1e6 - whole)) < 1e-12 and "40 of 600 places" in s.notes[-1]


def test_tables_without_positions(tmp_path):
    """Bare heights, a column or a matrix with blanks, commas or semicolons, are read with their holes, also a row of holes; they ask for a spacing."""
    for separator in (" ", ",", "; "):
        for z in (np.array(Z[:40])[:, None], np.reshape(Z, (20, 10))):
            z = z.copy()
            z[7] = np.nan
            (tmp_path / "a.csv").write_text("".join(separator.join(map(str, row)) + "\n" for row in z.tolist()))
            s = specimen.read(tmp_path / "a.csv", unit="um", spacing=(2e-6, 1e-6))
            assert np.allclose(s.heights * 1e6, z.squeeze(), equal_nan=True) and s.spacing[1] == 1e-6
            with pytest.raises(hdengine.InputError, match="no lateral size"):
                specimen.read(tmp_path / "a.csv", unit="um")


@pytest.mark.parametrize("text, says", [
    (lines([*zip(X[:30], Z), (X[30], "***"), *zip(X[31:], Z)]), r"line 31: '15 \*\*\*'"),
    (lines(zip([*X[:50], *X[50:56][::-1], *X[56:]], Z)), r"line 52: position 27 behind 27\.5"),
    (lines(zip([X[0], X[0], *X[2:]], Z)), "line 2: position 0 behind 0"), (lines([(1.0, 2.0), (2.0,), (3.0, 4.0)]), "line 2: 1 numbers"),
    (lines((x * x, y + x * y, z) for x, y, z in GRID), "lie on no grid"), (lines([*GRID, GRID[7]]), "line 601: a second height"),
    (lines([(*row, row[2]) for row in GRID[:5]] + [(0.1, 0.2, 0.3, "x")]), "line 6: '0.1 0.2 0.3 x'"),
    ("0,5;1,25\n1,0;1,5\n", "decimal"), ("0 1\n1,,2\n3 4\n", "line 2: '1,,2'"), ("", "is empty"), ("0 1\n80e6 2\n160e6 0\n", "160 m wide"),
])
def test_plain_tables_that_say_something_else(tmp_path, text, says):
    """A word or a gap for a height, an overhang, points on no grid, rows of another length and decimal commas are named with their line."""
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(hdengine.HdengineError, match=says):
        specimen.read(tmp_path / "a.txt", unit="um")


def test_archives_take_no_more_than_they_tell(tmp_path):
    """An archive of arrays has rows and columns as its array has; one that would grow a hundredfold is refused unread."""
    z = 1e-7 * np.random.default_rng(1).normal(size=(64, 48))
    np.savez_compressed(tmp_path / "a.npz", z)
    assert np.array_equal(specimen.read(tmp_path / "a.npz", spacing=1e-6).heights, z)
    for name in ("bomb.npz", "bomb.x3p"):
        with zipfile.ZipFile(tmp_path / name, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("main.xml", "w") as member:
            for _ in range(70):
                member.write(bytes(2**20))
        with pytest.raises(hdengine.FileError, match=f"states {70 * 2**20} bytes when unpacked"):
            specimen.read(tmp_path / name, spacing=1e-6)


def test_refusals_of_readers_are_shown(tmp_path):
    """Where the reader of a format refuses, its reason stands in the message; bytes of no format are not called a map."""
    pytest.importorskip("SurfaceTopography")
    with zipfile.ZipFile(tmp_path / "a.x3p", "w") as archive:
        archive.writestr("map/main.xml", "<x/>")
    (tmp_path / "a.dat").write_bytes(np.random.default_rng(1).bytes(5000))
    for name, says in (("a.x3p", "X3PReader: .*main.xml"), ("a.dat", "no reader takes it")):
        with pytest.raises(hdengine.FileError, match=says):
            specimen.read(tmp_path / name, unit="um", spacing=1e-6)


def test_short_maps_are_fitted_by_the_command(tmp_path):
    """A map of 40 points a side is fitted over the lags that it has, as a namelist fits it."""
    np.save(tmp_path / "a.npy", 1e-7 * np.random.default_rng(1).normal(size=(40, 40)))
    assert main(["surface", str(tmp_path / "a.npy"), "--spacing", "1e-6", "--out", str(tmp_path / "o")]) == 0
    found = json.loads((tmp_path / "o/surface.json").read_text())["surfaces"]["a"]
    summary = hdengine.run_surface(out=tmp_path / "p", fit__first_file=str(tmp_path / "a.npy"), fit__dx=1e-6).summary
    assert found["lags"] == summary["fits"]["first"]["lags"] == [1, 19]
