# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports: one file that holds everything, of runs and studies, finished or not."""
import contextlib
import json
import os
import re
import resource
import shutil
import subprocess
import sys

import numpy as np
import pytest

import hdengine
from conftest import ROOT, call
from hdengine.catalogue import UNITS
from hdengine.cli import main
from hdengine.figures import cup as picture
from hdengine.figures.drive import plot_loop
from hdengine.figures.run import plot_steps
from hdengine.report import write_pdf, write_report
from hdengine.report.chart import Chart, _legend, bars, ticks
from hdengine.report.parts import _answer
from hdengine.uncertainty import analyse
from hdengine.views.palette import STEPS
from hdengine.views.run import colour_top, forces_of

KEYS = {"mesh.divisions": 16, "mesh.band_facets": 3, "load.torque_steps": 1, "load.assembly_steps": 1}


@pytest.fixture(scope="module")
def folder(small_run, tmp_path_factory):
    """A copy of the small run with its sensitivity and its report, made without PyVista."""
    out = shutil.copytree(small_run, tmp_path_factory.mktemp("report") / "run.out")
    with open(out / "progress.txt", "w") as told, contextlib.redirect_stderr(told):
        analyse(out, draws=10, sobol=4)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "pyvista", None)
        write_report(out, picture=True, animation=True)
    return out


def test_report_stands_alone(folder):
    """Nothing is fetched: every image is embedded, no script, no link; inputs, plan, convergence, comparison, provenance are there."""
    page = (folder / "report.html").read_text()
    sources = re.findall(r'(?:src|href)="([^#"]*)"', page)
    assert len(sources) == 2 and all(s.startswith(("data:image/png;base64,", "data:image/gif;base64,")) for s in sources)  # tornado, steps
    assert "<script" not in page and len(page) < 4e6
    for word in ("K_TS by Eq. 45", "<td>interference</td>", "compiler", "Convergence", "Plan", "no tolerance was stated",
                 "Compared with Hu et al.", "10.3389/fmats.2023.1211019", hdengine.__version__):
        assert word in page, word


def test_sensitivity_in_the_report(folder):
    """One command leaves tornado, bands and indices in the run's folder, and the report shows them."""
    found = json.loads((folder / "sensitivity.json").read_text())
    low, _, high = found["bands_95_nm_per_rad"]["D and G"]
    assert low < found["k_ts_nm_per_rad"] < high
    assert "Uncertainty of K_TS" in (folder / "report.html").read_text() and (folder / "tornado_joint.png").exists()


def test_what_an_earlier_run_left_is_not_shown(folder, tmp_path):
    """After a run with another load in the same folder neither the sensitivity nor a figure of the one before stands in its report, whatever the
    clock says."""
    run = shutil.copytree(folder, tmp_path / "r")
    assert len(hdengine.load(run).plot()) > 2
    hdengine.run(folder / "echo.nml", run, True, load__torque=2.5, show=False)
    for path in run.glob("*.png"):
        os.utime(path, (4e9, 4e9))
    before = {path.name: path.read_bytes() for path in run.glob("*.png")}
    assert "Uncertainty of K_TS" not in hdengine.load(run).report(tmp_path / "r.html").read_text()
    drawn = hdengine.load(run).plot()
    assert len(drawn) > 2 and all(path.read_bytes() != before.get(path.name) for path in drawn)


def test_sensitivity_shows_progress_to_its_end(folder):
    """Bands and indices are counted in tenths on standard error, up to all of them."""
    counts = re.findall(r"^(\d+)/(\d+), ", (folder / "progress.txt").read_text(), re.M)
    assert counts == [(str(i + 1), str(len(counts))) for i in range(len(counts))] and len(counts) in (20, 30)


def test_picture_is_optional(folder, monkeypatch):
    """Without PyVista the report is written and names the extra to install."""
    assert "hdengine[report]" in (folder / "report.html").read_text()
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(picture.PictureError, match="hdengine"):
        picture.draw_cup(hdengine.load(folder), folder / "x.png")


def test_pdf_without_weasyprint(folder, monkeypatch):
    """Without WeasyPrint the error names what to install."""
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    with pytest.raises(hdengine.InputError, match=r"hdengine\[pdf\]"):
        write_pdf(folder / "report.html")


@pytest.mark.full
def test_pdf(folder):
    """`report --pdf` writes a PDF beside the HTML file."""
    pytest.importorskip("weasyprint")
    assert main(["report", str(folder), "--pdf"]) == 0
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.full
def test_picture_shows_the_cup(folder):
    """With PyVista the picture has the asked size and is not blank."""
    pytest.importorskip("pyvista")
    import matplotlib.image

    picture.draw_cup(hdengine.load(folder), folder / "cup.png", size=(600, 400))
    image = matplotlib.image.imread(folder / "cup.png")
    assert image.shape[:2] == (400, 600) and image.std() > 0.05


def test_report_of_a_run_that_failed(exe, tmp_path):
    """Gross slip: the report says why the run ended, and shows the steps it kept."""
    out = tmp_path / "slip.out"
    call(exe, ROOT / "data/cd14.nml", *(f"{k}={v}" for k, v in KEYS.items()), "load.support=bearing", "load.torque=60", "--out", out)
    page = write_report(out, picture=False).read_text()
    assert "gross slip at T = " in page and "Load steps" in page


def test_report_of_a_study(tmp_path, capsys):
    """Points, failures with their reason, and the figure are in the report of a study; the command writes it."""
    study = hdengine.Study(str(ROOT / "data/cd14.nml"), grid={"contact.friction": [0.1, -1.0, 0.2]}, fixed=KEYS, title="a < b")
    study.run(tmp_path / "s.out", show=False)
    assert main(["report", str(tmp_path / "s.out"), "--out", str(tmp_path / "s.html")]) == 0
    page = (tmp_path / "s.html").read_text()
    assert "out of range" in page and "data:image/png" in page and "a &lt; b" in page
    assert main(["report", str(tmp_path)]) == 3 and "neither a run" in capsys.readouterr().err


def test_report_of_a_surface(exe, tmp_path):
    """Verdict, figure, all inputs and provenance of a surface run are in its report."""
    done = call(exe, ROOT / "data/surface.nml", "surface.nx=101", "surface.ny=101", "--out", tmp_path / "s", "-q")
    assert done.returncode == 0, done.stderr
    page = write_report(tmp_path / "s").read_text()
    for text in ("verdict", "data:image/png", "ridges = 10", "nx = 101", "Provenance"):
        assert text in page


def test_report_of_a_planned_run(tmp_path):
    """The plan's verdict, estimates, reasons and coarse runs are in the report, the mesh as it was solved, edge cells counted."""
    keys = {"run.tolerance": 0.5, "solver.kinematics": "linear", "load.torque": 1.0}
    run = hdengine.run(ROOT / "data/cd14.nml", tmp_path / "p.out", **keys)
    page = write_report(run.folder, picture=False).read_text()
    assert "Tolerance 0.5: met by the estimate" in page and "{} x {} facets".format(*run.shape) in page
    for text in (*run.summary["plan"]["reasons"][:2], "Solved for it", "K_TS, tangent, limit of fine meshes", "this mesh above it"):
        assert text in page
    assert page.count("hex8i linear") == len((run.folder / "plan.csv").read_text().splitlines()) - 1
    assert "band_facets" in page and "first_lag" not in page  # keys of surfaces are none of a drive


def test_colours_do_not_rest_on_edge_cells():
    """A thousandth of the area under a hundred times the pressure leaves the colours as they are; half of it does not."""
    pressure, area = np.ones(100), np.ones(100)
    pressure[:10], area[:10] = 100, 1e-3
    assert colour_top(pressure, area) == 1
    assert colour_top(pressure, np.ones(100)) == 100
    assert colour_top(np.zeros(4), np.ones(4)) == 1


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    """A small whole drive of size 14 over its loop, and the page of its report."""
    run = hdengine.run(ROOT / "tests/cases/pressed_drive.nml", tmp_path_factory.mktemp("drive") / "r", mesh__divisions=24, mesh__band_facets=4,
                       load__torque_steps=2, joint__model="spectrum")
    return run, write_report(run.folder).read_text()


def test_report_of_a_drive_opens_with_its_slopes(drive):
    """The report of a whole drive opens with K1 to K3 of its summary, hysteresis in minutes of arc, and its loop."""
    run, page = drive
    head, found = page.split("<nav>")[0], run.summary["results"]
    assert "data:image" not in page and not [*run.folder.glob("*.png")]
    unit = UNITS[14]  # T1 and T2 of the scene are those of size 14
    for i in (1, 2):
        k, stated = found[f"k{i}_nm_per_rad"], getattr(unit, f"k{i}_nm_per_rad")
        assert f"<td>{k / 1e3:.3g}</td><td>{stated / 1e3:.3g}</td><td>{k / stated:.2f}</td>" in head.replace(' class="text"', "")
    assert len(re.findall('<tr class="(?:good|failed)">', head)) == 4
    safety = found["flexspline_yield_safety"], found["ring_yield_safety"], found["goodman_safety_min"], 4.2e9 / found["ball_pressure_max_pa"]
    assert ('class="failed"' in head) == (min(safety) < 1) and f"<td>{safety[3]:.3g} holds</td>" in head
    assert "<dt>wall thickness</dt><dd>0.36</dd>" in head and head.split('class="views"')[1].split("</div>")[0].count("<circle") == run.scene["bearing.balls"]
    assert f"it rests on {run.summary['k_ts_by_model']['chosen_rests_on']}." in page and "r_m" not in page
    places = [head.index(text) for text in ("K1 ", "Torque over the angle", "largest force of a ball", "front view", "Stress cycle")]
    assert places == sorted(places)
    assert "K1 {:.3g} kN m/rad, K2 {:.3g} kN m/rad".format(*(1e-3 * found[f"k{i}_nm_per_rad"] for i in (1, 2))) in head
    loop = next(svg for svg in page.split("<svg ")[1:] if "catalogue, size" in svg)
    frame = [float(x) for x in re.search(r'<rect class="line" x="([\d.]+)" y="[\d.]+" width="([\d.]+)"', loop).groups()]
    across = [float(place.split()[0]) for path in re.findall(r'd="M([^"VH]*)Z?"', loop) for place in path.strip("Z").split("L")]
    assert len(across) > 20 and frame[0] - 0.1 <= min(across) and max(across) <= sum(frame) + 0.1
    assert f"Hysteresis {found['hysteresis_rad'] * 180 * 60 / np.pi:.3g} arcmin" in head
    for i, part in enumerate(found["twist_shares"]):
        assert f">{part}</text>" in head and f">{100 * found['twist_shares'][part]:.2g} %</text>" in head, i


@pytest.mark.parametrize("name", ["loop", "fatigue", "balls"])
def test_a_lost_table_is_an_error(drive, tmp_path, capsys, name):
    """A table of a drive that its run wrote and that is gone ends plot and report with its name; no figure is left out."""
    folder = shutil.copytree(drive[0].folder, tmp_path / "r")
    (folder / f"{name}.csv").unlink()
    for command in ("plot", "report"):
        assert main([command, str(folder)]) == 3 and f"{name}.csv' cannot be read" in capsys.readouterr().err


def test_the_band_of_the_catalogue_is_as_wide_as_its_name_says(drive):
    """In the report and in the figure the shaded band reaches, at every torque, from the angle of a drive stiffer than the catalogue's by the
    percentage of its label to that of one softer by it."""
    run, page = drive
    loop = next(svg for svg in page.split("<svg ")[1:] if "catalogue, size" in svg)
    line, band = (np.array([place.split() for place in re.search(rf'd="M([^"]*?)Z?"[^>]*{mark}', loop)[1].split("L")], float)
                  for mark in ("stroke-dasharray", "fill-opacity"))
    share = float(re.search(r"band: ± (\d+) %", loop)[1]) / 100
    across = band[:, 0].reshape(2, -1) - line[0, 0]   # the catalogue's line begins at the angle 0
    assert [across[0, -1], across[1, 0]] == pytest.approx((line[-1, 0] - line[0, 0]) / (1 + share * np.array([1, -1])), abs=0.3)
    axis = plot_loop(run).axes[0]
    share = float(re.search(r"± (\d+) %", axis.lines[0].get_label())[1]) / 100
    ends, unit = axis.collections[0].get_paths()[0].vertices, UNITS[14]
    for torque in (unit.t1_nm, unit.t2_nm, run.torque_nm.max()):
        found = ends[np.isclose(ends[:, 1], torque), 0]
        assert [found.min(), found.max()] == pytest.approx(np.degrees(unit.angle(torque)) * 60 / (1 + share * np.array([1, -1])))


def test_forces_round_the_axis_are_those_of_two_steps(drive):
    """The charts of the balls show the forces of balls.csv after the assembly and at the largest torque, each at the angle of its ball."""
    run, _ = drive
    shown = forces_of(run, run.balls)
    assembled = run.balls["step"][run.balls["phase"] == "assembly"].max()
    largest = run.steps["step"][run.torque_nm == run.torque_nm.max()][-1]
    assert len(shown) == 2
    for (torque, angle, force), step in zip(shown, (assembled, largest)):
        rows = run.balls[run.balls["step"] == step]
        rows = rows[np.argsort(rows["theta_rad"] % (2 * np.pi))]
        assert torque == rows["torque_nm"][0]
        np.testing.assert_allclose(angle, rows["theta_rad"] % (2 * np.pi), atol=1e-8)
        np.testing.assert_array_equal(force, rows["force_n"])


def test_figures_made_again_are_not_drawn(tmp_path, monkeypatch):
    """Figures that this version drew of this summary are kept; a newer summary, or another version's figure, is drawn anew."""
    from hdengine.figures import run as figures

    result = hdengine.run(ROOT / "data/cd14.nml", tmp_path / "r", mesh__divisions=16, mesh__band_facets=3, load__torque_steps=1)
    figures.plot_run(result)
    stamps = {p.name: p.stat().st_mtime_ns for p in result.folder.glob("*.png")}
    figures.plot_run(result)
    assert len(stamps) >= 3 and stamps == {p.name: p.stat().st_mtime_ns for p in result.folder.glob("*.png")}
    monkeypatch.setattr(figures._engine, "version", lambda: "0.0.0")
    figures.plot_run(result)
    assert all(p.stat().st_mtime_ns > stamps[p.name] for p in result.folder.glob("*.png"))


def processor_time(*command):
    """Of a command, user and system, one thread [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    one = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    subprocess.run([*map(str, command)], env=os.environ | one, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.fixture(scope="module")
def main_scene(exe, tmp_path_factory):
    """Folder of the main scene's run, as it left it, and the processor time of the run."""
    out = tmp_path_factory.mktemp("main") / "r"
    return out, processor_time(exe, ROOT / "data/drive14.nml", "run.band=.false.", "--out", out)


def test_a_report_takes_a_fifth_of_its_run(main_scene):
    """The main scene's report in a fresh folder costs at most a fifth of its run's processor time, the best of three (11 % on a quiet
    machine), and draws its charts without matplotlib."""
    out, run = main_scene
    code = "import sys; from hdengine.cli import main; assert main(['report', sys.argv[1]]) == 0; assert 'matplotlib' not in sys.modules"
    command = sys.executable, "-c", code, out
    assert min(processor_time(*command) for _ in range(3)) <= 0.2 * run
    page = (out / "report.html").read_text()
    assert page.count('<svg class="chart') == 8 and len(page) < 2e5   # loop, twist, pressure, slip, line load, balls, teeth, fatigue


# What is wider than its frame, words that leave their chart, and letters below 8 pixels, as JSON
LOOK = """<!DOCTYPE html><html><body><script>
const page = %s, found = [], widths = [1280, 390];
let left = widths.length;
for (const width of widths) {
  const frame = document.createElement('iframe');
  frame.style.width = width + 'px';
  frame.srcdoc = page;
  frame.onload = () => {
    const root = frame.contentDocument.documentElement;
    if (root.scrollWidth > width) found.push(`${width}: ${root.scrollWidth} wide`);
    for (const chart of root.querySelectorAll('svg')) for (const text of chart.querySelectorAll('text')) {
      const a = chart.getBoundingClientRect(), b = text.getBoundingClientRect();
      if (b.left < a.left - 1 || b.right > a.right + 1 || b.top < a.top - 1 || b.bottom > a.bottom + 1 ||
        a.width / chart.viewBox.baseVal.width * parseFloat(getComputedStyle(text).fontSize) < 8) found.push(`${width}: ${text.textContent}`);
    }
    if (!--left) document.body.innerText = 'looked: ' + JSON.stringify(found);
  };
  document.body.append(frame);
}
</script></body></html>"""


def test_a_report_fits_a_telephone(main_scene, tmp_path):
    """In Chromium the main scene's report is not wider than 1280 or 390 pixels; the words of each chart stay in it and can be read."""
    chromium = shutil.which("chromium") or pytest.skip("Chromium is not installed")
    page = write_report(main_scene[0], tmp_path / "r.html").read_text()
    (tmp_path / "look.html").write_text(LOOK % json.dumps(page).replace("</", "<\\/"))
    seen = subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=9000", "--dump-dom",
                           (tmp_path / "look.html").as_uri()], capture_output=True, text=True, timeout=100).stdout
    assert re.search(r"looked: (\[.*?\])<", seen, re.S)[1] == "[]"


def test_colours_of_cells():
    """Cells between edges keep their place and colour: equal neighbours are one outline, what is not known has none. The scale of the colours is as
    high as the axes."""
    chart = Chart("t", "x", "y", [0, 4], [0, 1])
    chart.cells([0, 1, 2, 3, 4], [0, 1], np.array([[0.0, 0.0, np.nan, 9.0]]), 9.0, "MPa")
    left, right = (56 + (480 - 56 - 14) * at / 4 for at in (2, 3))
    low, high = chart.parts[:2]
    assert low.count("M") == 1 and f"H{left:.1f}" in low and STEPS[0] in low
    assert high.count("M") == 1 and f"M{right:.1f}" in high and STEPS[-1] in high
    y, height = zip(*(map(float, re.search(r' y="([-\d.]+)".*height="([\d.]+)"', part).groups()) for part in chart.parts if part.startswith("<rect")))
    top, frame = map(float, re.search(r' y="([\d.]+)".* height="([\d.]+)"', chart.frame[0]).groups())
    assert len(y) == len(STEPS) and [min(y), max(y) + height[0]] == pytest.approx([top, top + frame], abs=0.11)


def test_words_fit_beside_a_point_inside_of_the_axes():
    """Words that begin at the right end of the axes do not fit into them, at the left end they do; so with any margin."""
    for right in (14, 100):
        chart = Chart("t", "x", "y", [0, 4], [0, 1], right=right)
        assert chart.fits(0, "K1") and not chart.fits(4, "K1") and not chart.fits(4, "")


def test_bars_are_as_long_as_their_values():
    """Bars begin at one place and are as long as their values; each name ends before its bar, no farther off than a line is high, and names and
    values of eight letters lie in the chart."""
    rows = [("teeth", "red", 40.0), ("balls", "blue", 10.0), ("gaps", "green", 0.0)]
    svg = bars("t", rows, "abcde")
    width, line = (float(re.search(rf'{key}[ "]+([\d.]+)', svg)[1]) for key in ('viewBox="0 0', "font-size="))
    start, long = np.array(re.findall(r'<rect x="([\d.]+)" y="[\d.]+" width="([\d.]+)"', svg), float).T
    ends, begins = (np.array(re.findall(rf'<text x="([\d.]+)" y="[\d.]+" text-anchor="{anchor}"', svg), float) for anchor in ("end", "start"))
    assert np.ptp(start) == 0 and long / long[0] == pytest.approx([value / rows[0][2] for *_, value in rows], abs=1e-3)
    assert (ends < start).all() and (start - ends < line).all() and (begins > start + long).all()
    assert ends.min() > 8 * line / 2 and begins.max() + 8 * line / 2 < width


def test_a_name_wider_than_the_chart_stays_in_the_first_row():
    """The next one goes below it."""
    found, low = _legend([("red", 60 * "a"), ("blue", "b")], 100, 10.0)
    assert low == 28.0 and 'y="2.0"' in found[0]


def test_ticks_are_round():
    """Ticks are multiples of 1, 2 or 5 times a power of ten inside of the range, at most seven; a range of nothing has one."""
    assert ticks(-4.3, 6.2) == [-4, -2, 0, 2, 4, 6] and ticks(0, 100, 5) == [0, 20, 40, 60, 80, 100] and ticks(2, 2) == [2]
    assert ticks(0.0, 3e-7, 3) == pytest.approx([0, 1e-7, 2e-7, 3e-7])


def test_small_multiples_of_any_number_of_steps(tmp_path):
    """Four panels in rows of three, so two empty places: the figure is drawn, with four panels and a colour bar for pressure and for change."""
    run = hdengine.run(ROOT / "data/cd14.nml", tmp_path / "r", mesh__divisions=16, mesh__band_facets=3, load__torque_steps=3)
    assert len(plot_steps(run).axes) == 6


def test_report_opens_with_the_answer(folder):
    """Stiffness, its meaning, what is known of its error, a sketch and charts stand open; all else folds away, with links."""
    page = (folder / "report.html").read_text()
    assert 'name="viewport"' in page
    head, rest = page.split("<nav>")
    assert "<details" not in head and head.count('<svg class="chart') == 5 and "front view" in head
    assert "m/rad</p>" in head and "arcsec" in head and "Band: The error of the mesh is not known: run again" in head
    k, said = hdengine.load(folder).k_ts, re.search(r"by ([\d.e+-]+) arcsec \(([\d.e+-]+) µrad", head)
    assert [float(v) for v in said.groups()] == pytest.approx([206264.806 / k, 1e6 / k], rel=5e-3)  # 206264.806 arcsec a radian
    links = re.findall(r'href="#([^"]+)"', rest)
    assert len(links) > 6 and len(set(links)) == len(links) == rest.count("<details><summary><h2>")
    assert all(page.count(f'id="{mark}"') == 1 for mark in links)
    assert "max-width:600px" in page and "prefers-color-scheme:dark" in page and "counter(pages)" in page


@pytest.mark.parametrize("k", [0.0, float("inf")])
def test_no_stiffness_is_no_value(folder, k):
    """Where nothing carries the torque the headline says so instead of an angle."""
    result = hdengine.load(folder)
    result.summary["results"]["k_ts_bonded_nm_per_rad"] = k
    assert "no value" in _answer(result)


def test_one_scale_for_every_pressure_map(folder):
    """Map, steps and animation of a run have one top of their colours, and half of the colours are for the lowest quarter."""
    from hdengine.figures import run

    result = hdengine.load(folder)
    top = run.pressure_top(result)
    band, steps = run.plot_band(result), run.plot_steps(result)
    norms = [figure.axes[0].collections[0].norm for figure in (band, steps)]
    assert [n.vmax for n in norms] == [top, top] and norms[0](top / 4) == pytest.approx(0.5)


def test_maps_that_are_alike_are_drawn_as_changes(folder):
    """Where the torque hardly changes the pressure, one map is drawn and the others as their difference from it."""
    figure = plot_steps(hdengine.load(folder))
    titles = [axis.get_title() for axis in figure.axes]
    assert titles[0] == "0 N m" and titles[1].endswith("less 0 N m")
    assert "change over the torque" in figure.get_suptitle()


def test_many_lines_get_a_colour_bar(tmp_path):
    """A study with more lines than a legend can name has a colour bar with the key's unit, and no legend."""
    from hdengine.figures import study as figures

    rows = [{"point": i, "wave_generator.w": 1e-4 * (i % 4 + 1), "contact.friction": 0.01 * (i // 4 + 1), "torque_nm": 5.0,
             "k_ts_nm_per_rad": 3e6 + i, "pressure_max_pa": 1e6, "normal_force_n": 1.0, "status": "done"} for i in range(200)]
    result = type("Study", (), {"rows": rows, "failures": [], "folder": tmp_path, "summary": {
        "figure": {}, "swept": ["wave_generator.w", "contact.friction"], "title": "t", "failed": 0, "points": 200}})()
    saved = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "_save", lambda figure, _: saved.append(figure))
        figures.plot_study(result)
    assert not saved[0].legends and "friction" in [a.get_ylabel() for a in saved[0].axes]


def test_tornado_in_words(folder):
    """A tornado chart names its inputs in words and engineering units."""
    from hdengine.figures.sensitivity import plot_tornado

    figure = plot_tornado(1e6, {"wave_generator.w": (0.9e6, 1.1e6)}, {"wave_generator.w": (0.195e-3, 0.215e-3)})
    texts = [t.get_text() for t in figure.axes[0].texts]
    assert sorted(texts) == ["0.195", "0.215"] and figure.axes[0].get_yticklabels()[0].get_text() == "radial deformation w / mm"
