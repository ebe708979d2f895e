# SPDX-License-Identifier: GPL-3.0-or-later
"""Large displacements in whole scenes."""
import numpy as np
import pytest
from conftest import ROOT, SMALL, call

import hdengine

CD14 = ROOT / "data/cd14.nml"


def solve(exe, folder, *keys):
    done = call(exe, CD14, *SMALL, *keys, "output.vtu=none", "--out", folder, "-q")
    assert done.returncode == 0, done.stderr
    return hdengine.load(folder)


def test_small_displacements_are_the_limit(exe, tmp_path):
    """With a hundredth of the deformation the forces of both kinematics differ a hundred times less than with the whole."""
    difference = []
    for scale in (1, 0.01):
        keys = [f"wave_generator.w={2e-4 * scale}", f"wave_generator.interference={1e-5 * scale}", "load.torque_steps=0",
                "wave_generator.cam=cosine"]
        a, b = (solve(exe, tmp_path / f"{k}{scale}", *keys, f"solver.kinematics={k}") for k in ("linear", "nonlinear"))
        difference.append(abs(b.steps["normal_force_n"][-1] / a.steps["normal_force_n"][-1] - 1))
    assert difference[0] > 0.01 and difference[1] < difference[0] / 50


def test_newton_is_quadratic_and_moments_balance(exe, tmp_path):
    """Consistent tangent: the last step of each load step squares the residual; moments balance to a thousandth of the torque."""
    r = solve(exe, tmp_path / "q", "solver.kinematics=nonlinear")
    h = r.history
    for step in np.unique(h["step"]):
        res = h["residual"][h["step"] == step]
        assert res[-1] < max(3e3 * res[-2] ** 2, 1e-11)
    assert abs(r.steps["torque_balance_nm"][-1]) < 1e-3 * 5


@pytest.mark.parametrize("key", ["solver.method=condensed", "load.support=teeth"])
def test_needs_the_sparse_matrix(exe, tmp_path, key):
    """Condensation and superposition rest on a constant stiffness: refused with code 2."""
    done = call(exe, CD14, *SMALL, "solver.kinematics=nonlinear", key, "--out", tmp_path / "x", "-q")
    assert done.returncode == 2 and "nonlinear" in done.stderr


def test_slip_that_is_not_small_is_refused(exe, tmp_path):
    """Past the torque that friction holds, no state is passed off as balanced: code 4, the message names the slip; what is out of balance
    is the integral of pressure times slip round the axis (docs/limits.md)."""
    done = call(exe, CD14, *SMALL, "solver.kinematics=nonlinear", "load.support=bearing", "contact.friction=0.02", "load.torque=10",
                "output.vtu=none", "--out", tmp_path / "s", "-q")
    assert done.returncode == 4 and "slip" in done.stderr, done.stderr
    r = hdengine.load(tmp_path / "s")
    moment = (r.contact["pressure_pa"][-1] * r.contact["slip_theta_m"][-1] * r.contact["area_m2"][-1]).sum()
    assert abs(moment / r.steps["torque_balance_nm"][-1] - 1) < 0.02
