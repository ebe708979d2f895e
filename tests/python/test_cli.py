# SPDX-License-Identifier: GPL-3.0-or-later
"""The command hdengine: help with examples, plan, completion, sensitivity."""
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

import hdengine
from hdengine import cli, completion
from hdengine.progress import Progress
from hdengine.study import StudyResult

COMMANDS = sorted(next(a for a in cli.make_parser()._actions if a.dest == "command").choices)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_an_example_that_parses(name, capsys):
    """`hdengine NAME --help` ends with one example of that command, and the command accepts it."""
    with pytest.raises(SystemExit) as end:
        cli.main([name, "--help"])
    assert end.value.code == 0
    words = " ".join(capsys.readouterr().out.split("example: hdengine ")[1].split()).split(" > ")[0].split()
    assert words[0] == name and cli.make_parser().parse_args(words).command == name


def test_a_reader_that_goes_away(exe):
    """`hdengine ... | head`: no traceback, code 3 (bash's PIPESTATUS)."""
    command = [Path(exe).with_name("hdengine"), "completion", "bash"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        running.stdout.close()
        assert running.stderr.read() == "" and running.wait() == 3


def test_plan(capsys, tmp_path):
    """`hdengine plan` prints the series of meshes of a scene and of a study's first point; mistakes end with code 2."""
    assert cli.main(["plan", str(ROOT / "data/cd14.nml"), "solver.kinematics=linear", "--tolerance", "0.05"]) == 0
    assert "known to 5.0 %" in capsys.readouterr().out
    assert cli.main(["plan", str(ROOT / "data/fig13_w.nml"), "load.torque=3", "solver.kinematics=linear"]) == 0
    assert capsys.readouterr().out.startswith("10 points")
    assert cli.main(["plan", str(ROOT / "data/cd14.nml"), "load.torqe=3"]) == 2 and "did you mean 'torque'" in capsys.readouterr().err
    assert cli.main(["plan", str(tmp_path / "none.nml")]) == 3
    assert cli.main(["run", str(ROOT / "data/cd14.nml"), "torque", "--out", str(tmp_path / "x")]) == 2


def test_ctrl_c_keeps_what_was_solved(monkeypatch, capsys, tmp_path):
    """Ctrl-C ends a study without a traceback, code 7; the same command goes on to the result of an undisturbed one."""
    (tmp_path / "s.nml").write_text("&fixed mesh.divisions = 16, mesh.band_facets = 3, load.torque_steps = 1 /\n"
                                    "&grid load.torque = 2, 3 /\n")
    command = ["study", str(tmp_path / "s.nml"), "--out", str(tmp_path / "s.out")]

    def stop(self, *words):
        raise KeyboardInterrupt
    with monkeypatch.context() as patch:
        patch.setattr(Progress, "step", stop)
        assert cli.main(command) == 7 and "goes on" in capsys.readouterr().err
    assert StudyResult(tmp_path / "s.out").summary["status"] == "unfinished"
    assert cli.main(command) == 0
    assert StudyResult(tmp_path / "s.out").column("torque_nm").max() == 3


def test_completion_without_shtab_says_what_to_install(monkeypatch, capsys):
    """Where shtab is missing the command names the extra."""
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert cli.main(["completion", "bash"]) == 2 and "hdengine[completion]" in capsys.readouterr().err


def test_completion_completes(tmp_path):
    """In bash, commands and keys of scenes are completed."""
    pytest.importorskip("shtab")
    (tmp_path / "c.sh").write_text(completion.script(cli.make_parser(), "bash"))
    ask = 'source c.sh; COMP_WORDS=({}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _shtab_hdengine; echo "${{COMPREPLY[@]}}"'
    for words, expected in (("hdengine rep", "report"), ("hdengine run x.nml load.torque_s", "load.torque_steps=")):
        done = subprocess.run(["bash", "-c", ask.format(words)], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.stdout.split() == [expected], done


def test_tables_for_pandas_and_xarray(small_run):
    """A run's steps are a frame, its contact fields a dataset with torque, angle and place along the band."""
    pytest.importorskip("pandas"), pytest.importorskip("xarray")
    result = hdengine.load(small_run)
    frame, data = result.frame(), result.dataset()
    assert frame["k_ts_nm_per_rad"].iloc[-1] == pytest.approx(result.torsional_stiffness()[0][-1])
    assert data["pressure_pa"].dims == ("step", "theta_rad", "z_m")
    assert float((data["pressure_pa"] * data["area_m2"]).isel(step=-1).sum()) == pytest.approx(
        float((result.contact["pressure_pa"] * result.contact["area_m2"])[-1].sum()))


@pytest.mark.parametrize("rows", ["torque", "last"])
def test_studies_for_xarray(tmp_path, rows):
    """A grid becomes dimensions, keys side by side coordinates of the points; with one row per point its torque is a variable."""
    pytest.importorskip("pandas"), pytest.importorskip("xarray")
    coarse = {"mesh.divisions": 16, "mesh.band_facets": 3, "load.torque_steps": 1, "load.assembly_steps": 1}
    values = {"wave_generator.w": [0.19e-3, 0.20e-3], "load.torque": [2.0, 3.0]}
    for name, kind in (("g", {"grid": values}), ("t", {"together": values})):
        result = hdengine.Study(str(ROOT / "data/cd14.nml"), fixed=coarse, rows=rows, **kind).run(tmp_path / name, show=False)
        data, over = result.dataset(), ["torque_nm"] * (rows == "torque")
        if name == "g":
            assert list(data.sizes) == ["wave_generator.w", "load.torque", *over] and data.sizes["load.torque"] == 2
            place = {"wave_generator.w": 0.20e-3, "load.torque": 3.0}
        else:
            assert list(data.sizes) == ["point", *over]
            assert data["wave_generator.w"].dims == ("point",) and list(data["load.torque"]) == values["load.torque"]
            place = {"point": 1}
        if rows == "torque":
            place["torque_nm"] = 3.0
        else:
            assert float(data["torque_nm"].sel(place)) == pytest.approx(3.0)
        want = result.select(torque_nm=3.0, wave_generator__w=0.20e-3)[0]["k_ts_nm_per_rad"]
        assert float(data["k_ts_nm_per_rad"].sel(place)) == pytest.approx(want)
