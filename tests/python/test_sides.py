# SPDX-License-Identifier: GPL-3.0-or-later
"""Sides of the contact: slave and master swapped; the ring pressed against the wave generator, not tied to it."""
import csv

import numpy as np
import pytest

from conftest import ROOT, solved

MESH = ["mesh.divisions=40", "load.torque_steps=2", "output.vtu=none"]


def results(exe, folder, *keys):
    """Results of the peer scene on a coarse mesh."""
    return solved(exe, folder, ROOT / "data/peer_hub.nml", *MESH, *keys).summary["results"]


@pytest.mark.parametrize("keys, tolerance", [([], 1e-8), (["mesh.ring_divisions=32", "mesh.ring_facets=5"], 0.03)])
def test_swapped_slave(exe, tmp_path, keys, tolerance):
    """The cup as slave changes nothing on meshes that match, and on others less than the discretisation error, force and torque balanced."""
    ring, cup = (results(exe, tmp_path / side, *keys, f"contact.slave={side}") for side in ("ring", "cup"))
    for key in ("rotation_rad", "normal_force_n", "lobe_force_x_n", "friction_torque_nm"):
        assert cup[key] == pytest.approx(ring[key], rel=tolerance), key
    assert cup["facet_force_n"] == pytest.approx(cup["reaction_force_n"], rel=1e-9)
    assert abs(cup["torque_balance_nm"]) < 1e-9


def test_ring_lifts_off_the_wave_generator(exe, tmp_path):
    """A ring that is not tied feels no tension, lifts off near the short axis, hands the cup's pressure on to the cam in balance, and both
    linear solvers agree."""
    keys = ["wave_generator.ring_contact=unilateral", "wave_generator.ring_tangent=free", "wave_generator.eccentricity=20e-6",
            "load.torque_steps=0"]
    r = results(exe, tmp_path / "a", *keys)
    face = 2 * np.pi * 16.8e-3 * 6e-3
    assert r["cam_pressure_min_pa"] == 0 and r["cam_gap_max_m"] > 1e-6
    assert 0.1 * face < r["cam_contact_area_m2"] < 0.7 * face
    with (tmp_path / "a/contact.csv").open() as f:
        rows = [row for row in csv.DictReader(f) if row["step"] == "4"]
    area, theta, p, tau = (np.array([float(row[k]) for row in rows]) for k in ("area_m2", "theta_rad", "pressure_pa", "traction_theta_pa"))
    assert r["cam_force_x_n"] == pytest.approx((area * (p * np.cos(theta) - tau * np.sin(theta))).sum(), rel=0.02)
    b = results(exe, tmp_path / "b", *keys, "solver.method=newton", "solver.factors=exact")
    for key in ("cam_force_n", "cam_force_x_n", "cam_gap_max_m", "normal_force_n"):
        assert b[key] == pytest.approx(r[key], rel=1e-6), key


def test_symmetric_scene_on_a_bend_of_the_law(exe, tmp_path):
    """Where the cam neither presses nor opens (cos 2 theta = 0), rounding must not close a point and open its image: a quarter gives what the
    whole face does, in as many iterations."""
    keys = ["wave_generator.ring_contact=unilateral", "wave_generator.cam=cosine", "wave_generator.w=1e-5", "wave_generator.interference=48e-6",
            "geometry.ring_thickness=2e-4", "mesh.divisions=32", "mesh.band_facets=4", "contact.friction=0.5", "load.assembly_steps=2",
            "load.torque_steps=0"]
    quarter, full = (results(exe, tmp_path / s, *keys, f"solver.symmetry={s}") for s in ("quarter", "full"))
    for key in ("normal_force_n", "cam_force_n", "cam_gap_max_m"):
        assert quarter[key] == pytest.approx(full[key], rel=1e-6), key
    with (tmp_path / "quarter/steps.csv").open() as f:
        assert sum(int(step["iterations"]) for step in csv.DictReader(f)) <= 30
