# SPDX-License-Identifier: GPL-3.0-or-later
"""Sides of the contact: slave and master swapped."""
import json

import pytest
from conftest import ROOT, call

MESH = ["mesh.divisions=40", "load.torque_steps=2", "output.vtu=none"]


def results(exe, folder, *keys):
    """Results of the peer scene on a coarse mesh."""
    done = call(exe, ROOT / "data/peer_hub.nml", *MESH, *keys, "--out", folder, "-q")
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "summary.json").read_text())["results"]


@pytest.mark.parametrize("keys, tolerance", [([], 1e-8), (["mesh.ring_divisions=32", "mesh.ring_facets=5"], 0.03)])
def test_swapped_slave(exe, tmp_path, keys, tolerance):
    """The cup as slave changes nothing on meshes that match, and on others less than the discretisation error, force and torque balanced."""
    ring, cup = (results(exe, tmp_path / side, *keys, f"contact.slave={side}") for side in ("ring", "cup"))
    for key in ("rotation_rad", "normal_force_n", "lobe_force_x_n", "friction_torque_nm"):
        assert cup[key] == pytest.approx(ring[key], rel=tolerance), key
    assert cup["facet_force_n"] == pytest.approx(cup["reaction_force_n"], rel=1e-9)
    assert abs(cup["torque_balance_nm"]) < 1e-9
