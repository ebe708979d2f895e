# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene takes its joint from the folder of a fit."""
import pytest

import hdengine
from conftest import SMALL, call
from hdengine import specimen, surface
from hdengine.surfaces import folder
from hdengine.surfaces.roughness import Ridges

TOLD = Ridges(length=1e-4, shortest_wavelength=4e-6, ridges=6, gamma=1.5)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """Folder of a fit of one surface, and the fit."""
    z = surface.generate((120, 120), 1e-6, 2.4, 1e-9, 1.5, 1e-4, 4e-6, 6, seed=3)
    s = specimen.Specimen(z, (1e-6, 1e-6), "ground")
    fit = s.fit(surface=TOLD)
    out = tmp_path_factory.mktemp("fit") / "surface.out"
    folder.write(out, [s], [fit])
    return out, fit


def test_a_scene_takes_the_surface_of_a_fit(fitted):
    """D, G, L, L_s and the model are those of the fit, to the digits of its scene.nml; a key that is given stays."""
    out, fit = fitted
    scene = hdengine.read_scene(joint={"from_fit": str(out), "gamma": 1.7})
    assert scene["joint.fractal_dimension"] == pytest.approx(fit.fractal_dimension, abs=1e-5)
    assert scene["joint.roughness"] == pytest.approx(fit.roughness_m, rel=1e-4)
    assert scene["joint.sample_length"] == 1e-4 and scene["joint.shortest_wavelength"] == 4e-6 and scene["joint.gamma"] == 1.7
    assert scene["joint.model"] == "spectrum"
    assert hdengine.read_scene(joint={"from_fit": str(out), "model": "hu2023"})["joint.model"] == "hu2023"


def test_a_study_names_the_folder_beside_it(fitted, tmp_path, monkeypatch):
    """Whatever the folder that it is begun from, and a folder there comes first."""
    out, fit = fitted
    (out.parent / "s.toml").write_text("[fixed]\njoint.from_fit = 'surface.out'\n[grid]\nload.torque = [1.0, 2.0]\n")
    monkeypatch.chdir(tmp_path)
    assert hdengine.Study.read(out.parent / "s.toml").check()["joint.roughness"] == pytest.approx(fit.roughness_m, rel=1e-4)
    (tmp_path / "surface.out").mkdir()
    with pytest.raises(hdengine.FileError, match="no folder with a whole fit"):
        hdengine.Study.read(out.parent / "s.toml").check()


def test_a_run_from_a_fit_is_that_of_its_numbers(fitted, exe, tmp_path):
    """A namelist names the folder beside it; the facets are those of a run with the numbers typed in, and of the echo without the folder."""
    out, _ = fitted
    (out.parent / "a.nml").write_text("&joint\n  from_fit = 'surface.out'\n/\n")
    assert call(exe, out.parent / "a.nml", *SMALL, "--out", tmp_path / "a", "-q", cwd=tmp_path).returncode == 0
    scene = hdengine.load(tmp_path / "a").summary["scene"]
    typed = [f"{k} = {scene[f'joint.{k}']!r}" for k in ("fractal_dimension", "roughness", "sample_length", "shortest_wavelength")]
    (tmp_path / "b.nml").write_text("&joint\n" + "\n".join(typed) + "\n/\n")
    assert call(exe, tmp_path / "b.nml", *SMALL, "--out", tmp_path / "b", "-q").returncode == 0
    echo = (tmp_path / "a/echo.nml").read_text().replace("surface.out", "gone.out")
    (tmp_path / "echo.nml").write_text(echo)
    assert call(exe, tmp_path / "echo.nml", "--out", tmp_path / "c", "-q").returncode == 0
    rows = [(tmp_path / name / "contact.csv").read_bytes() for name in "abc"]
    assert rows[0] == rows[1] == rows[2]


@pytest.mark.parametrize("text, words", [(None, "surface.json, scene.nml"), ("! none: not fractal\n", "has 0 joints"),
                                         ("&joint\n/\n&joint\n/\n", "2 joints"), ("&joint\n roughness = -1\n/\n", "out of range")])
def test_a_folder_without_one_joint_is_refused(tmp_path, text, words):
    """A folder that is not there, not whole, has no joint or several, or a bad one: an error that names it and says what is valid."""
    if text is not None:
        (tmp_path / "scene.nml").write_text(text)
        (tmp_path / "surface.json").write_text("{}")
    with pytest.raises(hdengine.HdengineError, match=words) as failure:
        hdengine.read_scene(joint={"from_fit": str(tmp_path)})
    assert str(tmp_path) in str(failure.value) and "valid" in str(failure.value)
