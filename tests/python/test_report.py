# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports: one file that holds everything, of runs and studies, finished or not."""
import re
import shutil
import sys

import pytest
from conftest import ROOT, call

import hdengine
from hdengine import picture
from hdengine.cli import main
from hdengine.report import write_report

KEYS = {"mesh.divisions": 16, "mesh.band_facets": 3, "load.torque_steps": 1, "load.assembly_steps": 1}


@pytest.fixture()
def folder(small_run, tmp_path):
    """A copy of the small run to write into."""
    return shutil.copytree(small_run, tmp_path / "run.out")


def test_report_stands_alone(folder):
    """Nothing is fetched: every image is embedded, no script, no link; inputs, provenance, convergence and citation are there."""
    page = write_report(folder, picture=False).read_text()
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert len(sources) >= 5 and all(s.startswith("data:image/png;base64,") for s in sources)
    assert "<script" not in page
    for word in ("K_TS by Eq. 45", "wave_generator.interference", "compiler", "Convergence", "10.3389/fmats.2023.1211019",
                 hdengine.__version__):
        assert word in page, word


def test_picture_is_optional(folder, monkeypatch):
    """Without PyVista the report is written and names the extra to install."""
    monkeypatch.setitem(sys.modules, "pyvista", None)
    assert "hdengine[report]" in write_report(folder).read_text()
    with pytest.raises(picture.PictureError, match="hdengine"):
        picture.draw_cup(hdengine.load(folder), folder / "x.png")


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
