# SPDX-License-Identifier: GPL-3.0-or-later
"""The command hdengine: help with examples, plan, completion, sensitivity."""
import subprocess
import sys

import pytest
from conftest import ROOT

import hdengine
from hdengine import cli, completion

COMMANDS = sorted(next(a for a in cli.make_parser()._actions if a.dest == "command").choices)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_shows_an_example_that_parses(name, capsys):
    """`hdengine NAME --help` ends with one example of that command, and the command accepts it."""
    with pytest.raises(SystemExit) as end:
        cli.main([name, "--help"])
    assert end.value.code == 0
    words = " ".join(capsys.readouterr().out.split("example: hdengine ")[1].split()).split(" > ")[0].split()
    assert words[0] == name and cli.make_parser().parse_args(words).command == name


def test_plan(capsys, tmp_path):
    """`hdengine plan` prints the series of meshes of a scene and of a study's first point; mistakes end with code 2."""
    assert cli.main(["plan", str(ROOT / "data/cd14.nml"), "solver.kinematics=linear", "--tolerance", "0.05"]) == 0
    assert "below 0.05" in capsys.readouterr().out
    assert cli.main(["plan", str(ROOT / "data/fig13_w.nml"), "load.torque=3", "solver.kinematics=linear"]) == 0
    assert capsys.readouterr().out.startswith("10 points")
    assert cli.main(["plan", str(ROOT / "data/cd14.nml"), "load.torqe=3"]) == 2 and "did you mean 'torque'" in capsys.readouterr().err
    assert cli.main(["plan", str(tmp_path / "none.nml")]) == 3
    assert cli.main(["run", str(ROOT / "data/cd14.nml"), "torque", "--out", str(tmp_path / "x")]) == 2


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
