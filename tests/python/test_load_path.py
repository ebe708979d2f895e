# SPDX-License-Identifier: GPL-3.0-or-later
"""Which support carries the torque, and what a run says of it."""
import pytest

import hdengine
from conftest import CD14, ROOT, SMALL, call


def solve(exe, folder, *keys, scene=CD14):
    done = call(exe, scene, *SMALL, "wave_generator.ring_tangent=auto", *keys, "output.vtu=none", "--out", folder)
    assert done.returncode == 0, done.stderr
    return hdengine.load(folder), done.stdout


@pytest.mark.parametrize("keys", [[], ["solver.kinematics=nonlinear"], ["wave_generator.ring_contact=unilateral"]])
def test_a_ring_on_balls_leaves_the_torque_to_the_hub(exe, tmp_path, keys):
    """With ring_tangent = 'auto' the hub carries the torque, the wave generator no more than the torque over the ratio; the log says so, without a
    warning, and all moments balance, those of the ring's soft springs included."""
    r, log = solve(exe, tmp_path / "a", *keys)
    s = r.steps
    assert s["hub_torque_nm"][-1] == pytest.approx(5, abs=0.05) and abs(s["wave_generator_torque_nm"][-1]) < 0.05
    parts = s["hub_torque_nm"] + s["wave_generator_torque_nm"] + s["ring_spring_torque_nm"]
    assert parts == pytest.approx(s["torque_nm"], abs=1e-8 if keys == [] else 5e-3)
    assert abs(s["torque_balance_nm"][-1]) < (5e-3 if "nonlinear" in str(keys) else 1e-8)
    assert "carried by the hub" in log and "the wave generator carries" not in str(r.summary["warnings"])


def test_springs_of_the_ring_count(exe, tmp_path):
    """Stiff springs at a free ring take a visible part of the torque, and the balance counts it."""
    r, _ = solve(exe, tmp_path / "s", "load.support_stiffness=1e6")
    s = r.steps
    assert s["ring_spring_torque_nm"][-1] > 0.01 and abs(s["torque_balance_nm"][-1]) < 1e-8


@pytest.mark.parametrize("keys", [["contact.mode=bonded"], ["contact.mode=frictionless"], ["load.support_stiffness=1e6"]])
def test_the_turn_of_a_sliding_ring_is_an_unknown_of_its_own(exe, tmp_path, keys):
    """A ring that only contact and soft springs hold takes few iterations, bonded, without friction and on stiff springs, and the turn that the
    condensed solver adds is that of Newton's matrix."""
    r, _ = solve(exe, tmp_path / "c", "solver.method=condensed", "load.torque_steps=1", *keys)
    other, _ = solve(exe, tmp_path / "n", "solver.method=newton", "solver.factors=exact", "load.torque_steps=1", *keys)
    assert r.summary["results"]["iterations"] <= 30
    for key in ("rotation_rad", "normal_force_n"):
        assert r.summary["results"][key] == pytest.approx(other.summary["results"][key], rel=1e-7), key


@pytest.mark.parametrize("scene, keys, wave_generator", [(CD14, ["wave_generator.ring_tangent=follow"], (4, 5)), ("paper.nml", [], (4.99, 5)),
                                                         (CD14, ["load.support=bearing"], (4.99, 5))])
def test_a_held_ring_is_warned_of(exe, tmp_path, scene, keys, wave_generator):
    """A ring held on the cam sends the torque through friction into the wave generator: the run says how much and what a real one takes.
    So does the paper's scene, and any with a bearing support, where nothing else takes it."""
    r, log = solve(exe, tmp_path / "w", *keys, scene=ROOT / "data" / scene)
    low, high = wave_generator
    assert low < r.summary["results"]["wave_generator_torque_nm"] <= high
    assert any(w.startswith("the wave generator carries") for w in r.summary["warnings"])
    assert "over the ratio, 0.05 N m" in log
