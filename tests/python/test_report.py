# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports: one file that holds everything, of runs and studies, finished or not."""
import json
import re
import shutil
import sys

import numpy as np
import pytest
from conftest import ROOT, call

import hdengine
from hdengine import paper, picture
from hdengine.cli import main
from hdengine.plot import colour_top, plot_steps
from hdengine.report import write_pdf, write_report

KEYS = {"mesh.divisions": 16, "mesh.band_facets": 3, "load.torque_steps": 1, "load.assembly_steps": 1}


@pytest.fixture(scope="module")
def folder(small_run, tmp_path_factory):
    """A copy of the small run with its sensitivity and its report, made without PyVista."""
    out = shutil.copytree(small_run, tmp_path_factory.mktemp("report") / "run.out")
    assert main(["sensitivity", str(out), "--draws", "30"]) == 0
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "pyvista", None)
        write_report(out)
    return out


def test_report_stands_alone(folder):
    """Nothing is fetched: every image is embedded, no script, no link; inputs, plan, convergence, comparison, provenance are there."""
    page = (folder / "report.html").read_text()
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert len(sources) >= 5 and all(s.startswith(("data:image/png;base64,", "data:image/gif;base64,")) for s in sources)
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
    assert main(["report", str(folder), "--no-picture", "--pdf"]) == 0
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")


def test_report_of_a_comparison(tmp_path):
    """A folder with a comparison and studies gives one file with the table and every study."""
    rows = [dict(zip(paper.Row.HEAD, r.cells())) for r in paper.arithmetic_rows()]
    (tmp_path / "comparison.json").write_text(json.dumps({"rows": rows}))
    hdengine.Study(str(ROOT / "data/cd14.nml"), fixed=KEYS, title="a study of it").run(tmp_path / "s.out", show=False)
    page = write_report(tmp_path).read_text()
    assert "7.30 %" in page and "a study of it" in page


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
    for text in (*run.summary["plan"]["reasons"][:2], "Solved for it", "K_TS, limit of fine meshes", "this mesh above it"):
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


def test_small_multiples_of_any_number_of_steps(tmp_path):
    """Four panels in rows of three, so two empty places: the figure is drawn, with four panels and a colour bar."""
    run = hdengine.run(ROOT / "data/cd14.nml", tmp_path / "r", mesh__divisions=16, mesh__band_facets=3, load__torque_steps=3)
    assert len(plot_steps(run).axes) == 5
