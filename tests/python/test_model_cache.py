# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh and factors are kept from one run of a process to the next, and only where they are the same."""
import json
import subprocess
import sys

import numpy as np
import pytest

import hdengine
from conftest import CD14, ROOT

BASE = {"mesh__divisions": 24, "mesh__band_facets": 4, "load__torque_steps": 1, "load__assembly_steps": 1}


def solve(folder, **keys):
    """Result of a scene and whether its model was kept from the run before."""
    result = hdengine.run(out=folder, force=True, **(BASE | keys))
    return result, json.loads((folder / "summary.json").read_text())["model"]["mesh_and_factors"] == "kept"


@pytest.mark.parametrize("method", ["auto", "newton"])
def test_kept_factors_change_nothing(tmp_path, method):
    """A run on kept factors gives bit by bit what a fresh one gives: torque, w, eccentricity, interference, friction, joint."""
    points = [{}, {"load__torque": 2.0}, {"wave_generator__w": 0.21e-3}, {"wave_generator__eccentricity": 5e-6},
              {"wave_generator__interference": 5e-6}, {"contact__friction": 0.2}, {"joint__asperity_radius": 4e-6}, {}]
    hdengine.forget()
    for i, keys in enumerate(points if method == "auto" else points[:4]):
        a, kept = solve(tmp_path / "kept", solver__method=method, **keys)
        assert kept == (i > 0)
        if method == "auto" or i == 3:
            hdengine.forget()
            b, kept = solve(tmp_path / "fresh", solver__method=method, **keys)
            assert not kept
            for name in ("pressure_pa", "traction_theta_pa", "k_n_n_per_m"):
                np.testing.assert_array_equal(a.contact[name], b.contact[name])


@pytest.mark.parametrize("keys", [{"mesh__divisions": 26}, {"geometry__wall_thickness": 0.4e-3}, {"material__ring_nu": 0.29},
                                  {"load__support": "bearing", "load__torque": 1.0}, {"solver__method": "newton"}],
                         ids=lambda k: next(iter(k)))
def test_other_models_are_not_kept(tmp_path, keys):
    """Another mesh, section, material, support or method makes a new model."""
    solve(tmp_path / "a")
    assert not solve(tmp_path / "b", **keys)[1]


def test_a_drive_that_has_turned_is_no_guess(tmp_path):
    """After a run with loop.history = 'turned' the next one on its model begins at the assembly at rest: its
    bodies moved off, or it came out otherwise by rounding."""
    drive = {"path": ROOT / "data/drive14.nml", "mesh__band_facets": 3, "bearing__balls": 13, "loop__torques": 5.0, "output__vtu": "none", "run__band": False}
    slopes = [solve(tmp_path / "a", **drive, loop__history=history)[0].k1 for history in ("turned", "assembled", "turned")]
    hdengine.forget()
    assert slopes[0] == slopes[2] and slopes[1] == solve(tmp_path / "b", **drive, loop__history="assembled")[0].k1


GROWTH = """
import resource
import hdengine

def resident():
    return int(open("/proc/self/statm").read().split()[1]) * resource.getpagesize() / 1e6

for i in range(8):
    with hdengine.Run(mesh={"divisions": 124, "band_facets": 22}, solver={"kinematics": "linear"},
                      load={"assembly_steps": 1, "torque_steps": 0}, geometry={"wall_thickness": 0.3e-3 + 1e-6 * i}) as run:
        list(run)
    hdengine.forget()
    if i == 2:
        before = resident()
print(resident() - before)
"""


def test_runs_leave_no_memory_behind():
    """Five runs after the third, each on a model of its own, in a process of their own: all memory is given back (30 MB stay where
    only the harmonics are lost)."""
    done = subprocess.run([sys.executable, "-c", GROWTH], capture_output=True, text=True, check=True)
    assert float(done.stdout.split()[-1]) < 15


def test_states_of_a_known_assembly_stay(tmp_path):
    """At a loose residual open points are found closed when their state is judged again: an assembly that is taken over keeps its states, point by point."""
    keys = {"mesh.divisions": 24, "mesh.band_facets": 6, "mesh.edge_length": 2.5e-4, "load.assembly_steps": 1, "load.torque_steps": 1, "solver.tolerance": 0.01,
            "output.contact": "all", "output.vtu": "none"}
    hdengine.forget()
    first, again = (hdengine.run(CD14, tmp_path / name, **keys) for name in ("first", "again"))
    assert again.steps["iterations"][0] == 0 < first.steps["iterations"][0]
    assert (again.contact["state"] == first.contact["state"]).all()
