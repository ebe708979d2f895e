# SPDX-License-Identifier: GPL-3.0-or-later
"""joint.model = 'auto' in a scene: theory where it holds at the scene's pressures, else boundary elements, and what each run says of the theory's error."""
import json
import re

import numpy as np
import pytest

import hdengine
from conftest import CD14, ROOT, SMALL, call, solved
from hdengine import _engine
from hdengine.prediction.choice import STEEP, TRUST, scatter_of

PAPER = ROOT / "data/paper.nml"
FEW = ["joint.fractal_dimension=2.1", "joint.sample_length=4e-3", "joint.roughness=1e-28"]   # few long waves hold the height


def run(exe, out, *keys, scene=CD14):
    """Summary, process."""
    done = call(exe, scene, *SMALL, *keys, "output.vtu=none", "--out", out, "--force")
    return (json.loads((out / "summary.json").read_text()) if done.returncode == 0 else None), done


def half_width(error):
    """As the engine's rule has it, from its own numbers."""
    return 1.96 * scatter_of(np.array([error["contact_area_fraction"]]), error["independent_waves"])[0]


@pytest.fixture
def table(tmp_path):
    """A table of boundary elements."""
    path = tmp_path / "be.csv"
    path.write_text("pressure_pa,k_n_pa_per_m\n1e5,1e12\n1e7,5e13\n1e9,1e15\n")
    return f"joint.table_file={path}"


def test_choice_flips_at_the_edge_of_the_rule(exe, tmp_path, table):
    """With longer and longer waves fewer touch: theory up to an error of 25 %, the table from there on; the trial's error is about that of the run."""
    seen = set()
    for length in (0.8e-3, 1.8e-3, 4e-3):
        found, _ = run(exe, tmp_path / "o", "joint.model=auto", f"joint.sample_length={length}", "joint.fractal_dimension=2.1",
                       "joint.roughness=1e-28", table)
        joint = found["joint"]
        percent = float(re.search(r"lies within ([\d.]+) %", joint["chosen_because"])[1])
        assert joint["model"] == ("spectrum" if percent <= 100 * TRUST else "boundary_elements"), joint
        assert found["scene"]["joint.model"] == joint["model"] and not [w for w in found["warnings"] if "joint.model" in w]
        if joint["model"] == "spectrum":
            assert 100 * half_width(joint["theory_error"]) == pytest.approx(percent, rel=0.3)
            assert half_width(joint["theory_error"]) == pytest.approx(joint["theory_error"]["ln_k_n_half_width"], rel=1e-6)
            assert found["k_ts_by_model"]["boundary_elements_nm_per_rad"] > 0   # the table that was not taken is judged too
        seen.add(joint["model"])
    assert seen == {"spectrum", "boundary_elements"}


def test_a_trial_that_slips_ends_nothing(exe, tmp_path, table):
    """Where the trial of the choice slips, as the scene will, the run goes on to its own steps and ends there, with its last state."""
    _, done = run(exe, tmp_path / "o", "joint.model=auto", table, "load.torque=60", scene=PAPER)
    assert done.returncode == 4 and "gross slip at T = " in done.stderr
    told = json.loads((tmp_path / "o/summary.json").read_text())
    assert told["joint"]["model"] in ("spectrum", "boundary_elements")
    assert told["results"]["gross_slip_torque_nm"] == pytest.approx(told["results"]["friction_capacity_nm"], rel=5e-3)


def test_without_a_table_the_theory_warns(exe, tmp_path):
    """Where the rule fails and no table is given, the theory is taken, and the warning holds the size and a command that the parser takes."""
    from hdengine import cli

    found, done = run(exe, tmp_path / "o", "joint.model=auto", *FEW)
    assert found["joint"]["model"] == "spectrum"
    warning, = (w for w in found["warnings"] if w.startswith("joint.model: the theory is taken for want of a table"))
    assert f"warning: {warning}" in done.stdout and float(re.search(r"within ([\d.]+) %", warning)[1]) > 25
    words = re.search(r"'hdengine (joint .*)', then joint.table_file", warning)[1]
    np.save(tmp_path / "a.npy", np.random.default_rng(1).normal(size=(32, 32)) * 1e-7)
    words = words.replace("MAP MAP", f"{tmp_path / 'a.npy'} --dx 1e-5").replace("boundary_elements", "spectrum").replace("DIR", str(tmp_path / "j"))
    assert cli.main(words.split()) == 0
    pressures = np.genfromtxt(tmp_path / "j/joint.csv", delimiter=",", names=True)["pressure_pa"]
    assert pressures[2] == pytest.approx(float(re.search(r"under ([\d.]+) MPa", warning)[1]) * 1e6, rel=1e-3)


def test_steep_faces(exe, tmp_path, table):
    """On the paper's faces E* times slope is beyond the rule: the error is not said as a size, the theory warns, a table is taken."""
    found, _ = run(exe, tmp_path / "o", "joint.model=auto", scene=PAPER)
    error = found["joint"]["theory_error"]
    assert error["e_star_slope_over_hardness"] > STEEP and "ln_k_n_half_width" not in error
    assert found["joint"]["model"] == "spectrum" and any("hardnesses, where nearly all contact yields" in w for w in found["warnings"])
    assert "half of it lowers K_TS by Eq. 45 as much, and changes its tangent by -" in "".join(found["model_error"]["left_out"])
    found, _ = run(exe, tmp_path / "o", "joint.model=auto", table, scene=PAPER)
    assert found["joint"]["model"] == "boundary_elements" and "theory_error" not in found["joint"]


def test_error_of_the_theory_is_said_and_moves_the_tangent(exe, tmp_path):
    """A run by theory says the error of k_N and what it does to the tangent: the same as a table so much softer does."""
    found, _ = run(exe, tmp_path / "o")
    error, tangent = found["joint"]["theory_error"], found["results"]["k_ts_bonded_nm_per_rad"]
    said, = (line for line in found["model_error"]["left_out"] if line.startswith("joint: k_N by theory "))
    assert f"within {100 * error['ln_k_n_half_width']:.0f} % of boundary elements (95 of 100 contacts)" in said
    assert "chosen_because" not in found["joint"]
    law = hdengine.elastic.ElasticJoint.of_scene(found["scene"])
    factor = np.exp(-error["ln_k_n_half_width"])
    np.savetxt(tmp_path / "k.csv", np.column_stack([law.table_pressure, law.k_n * factor, law.k_t * factor]), delimiter=",",
               header="pressure_pa,k_n_pa_per_m,k_t_pa_per_m", comments="", fmt="%.17g")
    other, _ = run(exe, tmp_path / "p", "joint.model=table", f"joint.table_file={tmp_path / 'k.csv'}")
    assert other["results"]["k_ts_bonded_nm_per_rad"] / tangent - 1 == pytest.approx(error["k_ts_tangent_change"], rel=1e-3)
    assert other["results"]["k_ts_nm_per_rad"] / found["results"]["k_ts_nm_per_rad"] == pytest.approx(factor, rel=1e-3)
    assert -0.05 < error["k_ts_tangent_change"] < 0


@pytest.mark.parametrize("model", ["hu2023", "table"])
def test_other_models_have_no_error_of_the_theory(exe, tmp_path, table, model):
    """A scene that names another model is as it was: no choice, no error of the theory."""
    found, _ = run(exe, tmp_path / "o", f"joint.model={model}", table)
    assert found["joint"]["model"] == model and not {"theory_error", "chosen_because"} & set(found["joint"])
    assert not [line for line in found["model_error"]["left_out"] if "joint: " in line[:7]]


def test_chosen_model_is_run_as_if_it_were_named(exe, tmp_path, table):
    """Same tables, to the byte, as with the model named; the echo names it, so the run is resumed by either."""
    for keys, named in ((["contact.law=joint"], "spectrum"), ([*FEW, table], "boundary_elements")):
        for name, model in (("a", "auto"), ("b", named)):
            assert run(exe, tmp_path / name, f"joint.model={model}", *keys)[0]["joint"]["model"] == named
        for file in ("contact.csv", "steps.csv"):
            rows = [[row.rsplit(",", 1)[0] for row in (tmp_path / name / file).read_text().splitlines()] for name in "ab"]
            assert rows[0] == rows[1]
        assert f"model = '{named}'" in (tmp_path / "a/echo.nml").read_text()
        again = call(exe, CD14, *SMALL, "joint.model=auto", *keys, "output.vtu=none", "--out", tmp_path / "b", "--resume")
        assert again.returncode == 0 and "complete: nothing to do" in again.stdout, again.stderr
    other = call(exe, CD14, *SMALL, "joint.model=auto", "output.vtu=none", "--out", tmp_path / "b", "--resume")
    assert other.returncode == 2 and "joint." in other.stderr


def test_planned_scene(exe, tmp_path, table):
    """With a tolerance the reason stands in --plan and among the reasons of the plan, and the plan is that of the model named."""
    keys = ["run.tolerance=0.3", "solver.kinematics=linear", "geometry.bore_radius=9e-3", "geometry.hub_radius=4e-3", "joint.model=auto", *FEW, table]
    plan = call(exe, CD14, *keys, "--plan")
    assert plan.returncode == 0 and "\njoint boundary_elements: k_N by theory lies within" in "\n" + plan.stdout
    found = solved(exe, tmp_path / "o", CD14, *keys, "output.vtu=none").summary
    assert [r for r in found["plan"]["reasons"] if r.startswith("joint boundary_elements: k_N by theory lies within")]
    assert found["joint"]["model"] == "boundary_elements"
    told = _engine.call_text("scene_text", str(CD14), "\n".join(keys), 1)
    assert "joint boundary_elements: k_N by theory lies within" in told


def test_python_and_studies(tmp_path, table):
    """From Python a scene's own model is chosen, a study over the torque keeps the mesh of the run before, and a joint alone asks for a model."""
    keys = dict(key.split("=") for key in SMALL) | {"joint.model": "auto", "output.vtu": "none"}
    found = [hdengine.run(CD14, tmp_path / f"o{torque}", **keys, **{"load.torque": torque}) for torque in (4.0, 5.0)]
    assert [r.scene["joint.model"] for r in found] == ["spectrum", "spectrum"]
    assert [json.loads((tmp_path / f"o{t}/summary.json").read_text())["model"]["mesh_and_factors"] for t in (4.0, 5.0)][1] == "kept"
    with pytest.raises(hdengine.InputError, match="joint.model = 'auto' is chosen when the scene is run"):
        hdengine.elastic.ElasticJoint.of_scene(hdengine.read_scene(CD14, **keys))


def test_bad_tables_and_spectra_end_before_the_run(exe, tmp_path):
    """A table or a spectrum that cannot be read ends the run with its key or name, and nothing is written; a spectrum without waves of its own has them
    from its bands, fewer at most by half, and one with waves that are none is refused."""
    done = call(exe, CD14, *SMALL, "joint.model=auto", "joint.table_file=none.csv", "--out", tmp_path / "o")
    assert done.returncode == 3 and "joint.table_file: " in done.stderr and not (tmp_path / "o/summary.json").exists()
    done = call(exe, CD14, *SMALL, "joint.model=auto", "joint.spectrum_file=none.csv", "--out", tmp_path / "o")
    assert done.returncode == 3 and "joint.spectrum_file: " in done.stderr
    q, h = np.array([1e4, 2e4, 4e4, 8e4]), np.array([4e-14, 1e-14, 2.5e-15, 6e-16])
    waves = {}
    for name, m in (("without", None), ("with", np.array([5e7, 1e8, 4e8, 1e9])), ("bad", np.array([5e7, 0, 4e8, 1e9]))):
        columns = [q, h] if m is None else [q, h, m]
        np.savetxt(tmp_path / "s.csv", np.column_stack(columns), delimiter=",", comments="",
                   header="q_per_m,height_variance_m2" + ("" if m is None else ",waves_per_m2"))
        found, done = run(exe, tmp_path / "o", f"joint.spectrum_file={tmp_path / 's.csv'}")
        if name == "bad":
            assert done.returncode == 2 and "waves_per_m2 from 0" in done.stderr
        else:
            error = found["joint"]["theory_error"]
            waves[name] = error["independent_waves"] / error["area_m2"]
    assert waves["with"] == pytest.approx(h.sum() ** 2 / (h**2 / np.array([5e7, 1e8, 4e8, 1e9])).sum(), rel=1e-6)
    assert waves["without"] == pytest.approx(h.sum() ** 2 / (h**2 / (q**2 * 1.5 / (4 * np.pi))).sum(), rel=1e-6)
