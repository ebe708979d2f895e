# SPDX-License-Identifier: GPL-3.0-or-later
"""Von Mises stress of both bodies beside their yield strengths, in every kind of run."""
import json

import meshio
import pytest

from conftest import ROOT, call, solved

MESH = ["mesh.divisions=24", "mesh.band_facets=4", "load.torque_steps=1", "load.assembly_steps=1"]
KINDS = {"hub": ("data/cd14.nml", []), "bearing": ("data/cd14.nml", ["load.support=bearing"]), "teeth": ("data/teeth.nml", []),
         "formed": ("data/cd14.nml", ["wave_generator.shape=as_formed"]), "large": ("data/cd14.nml", ["solver.kinematics=nonlinear"]),
         "drive": ("tests/cases/pressed_drive.nml", ["bearing.balls=12", "load.tooth_pairs=12", "loop.torques=8,-3"])}


def solve(exe, folder, scene, *keys):
    """Summary of a small run, and its log."""
    done = call(exe, ROOT / scene, *MESH, *keys, "--out", folder, "--force")
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "summary.json").read_text()), done.stdout


@pytest.mark.parametrize("kind", KINDS)
def test_every_run_states_the_stress_of_both_bodies(exe, tmp_path, kind):
    """The largest of all steps' grids, by body; the safeties are the yield strengths over them; the log and model_error say the same."""
    scene, keys = KINDS[kind]
    summary, log = solve(exe, tmp_path / "r", scene, *keys, "output.vtu=all")
    r, largest = summary["results"], {1: 0.0, 2: 0.0}
    for path in (tmp_path / "r").glob("bodies_*.vtu"):
        grid = meshio.read(path)
        stress, body = grid.point_data["von_mises_pa"].ravel(), grid.cell_data["body"][0].ravel()
        largest = {b: max(most, stress[grid.cells[0].data[body == b]].max()) for b, most in largest.items()}
    ring, cup = largest[1], largest[2]
    assert r["flexspline_von_mises_max_pa"] == pytest.approx(cup, rel=1e-6)
    assert r["von_mises_max_pa"] == pytest.approx(max(cup, ring), rel=1e-6)
    assert r["flexspline_yield_safety"] == pytest.approx(835e6 / cup, rel=1e-6)
    assert r["ring_yield_safety"] == pytest.approx(1.7e9 / ring, rel=1e-6)
    line = next(line for line in log.splitlines() if line.startswith("stress"))[10:].split("; a ball presses")[0]
    assert any(f"bodies elastic: {line}" in text for text in summary["model_error"]["left_out"])


@pytest.mark.parametrize("scene", ["drive14", "drive14_hat"])
def test_the_stress_of_a_bent_wall_is_that_of_its_face(exe, tmp_path, scene):
    """One layer of cells, short at the clamped edge of the bottom, gives the stress of the cup that three of a fine bottom do, to 3 %."""
    one, fine = (solved(exe, tmp_path / str(len(keys)), ROOT / f"data/{scene}.nml", *keys, "loop.torques=7.8", "load.torque_steps=2",
                        "run.band=.false.", "output.vtu=none").summary["results"]["flexspline_von_mises_max_pa"]
                 for keys in ([], ["mesh.through_wall=3", "mesh.bottom_elements=60"]))
    assert one == pytest.approx(fine, rel=0.03)


def test_a_body_that_yields_is_warned_of(exe, tmp_path):
    """Each body has its strength; below it nothing is said."""
    strong = ["material.yield_strength=4e9", "material.ring_yield_strength=4e9", "joint.hardness=2.338e9", "output.vtu=none"]
    for weak, body in ((None, None), ("material.yield_strength=2e8", "flexspline"), ("material.ring_yield_strength=1e8", "ring")):
        warnings = [w for w in solve(exe, tmp_path / "r", "data/cd14.nml", *strong, *filter(None, [weak]))[0]["warnings"] if " yields: " in w]
        assert [w.split()[1] for w in warnings] == [body][:len(warnings)] and len(warnings) == (body is not None)
        assert all(weak.split("=")[0] in w and "Lower load.torque" in w for w in warnings)
