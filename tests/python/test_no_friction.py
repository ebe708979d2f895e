# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction 0: shear that is rounding has no direction and holds nothing."""
from conftest import ROOT, call

KEYS = ["contact.friction=0", "mesh.divisions=24", "mesh.band_facets=4", "mesh.wall_elements=4", "mesh.bottom_elements=3", "load.assembly_steps=2",
        "load.torque_steps=2", "output.vtu=none", "solver.time_limit_s=30"]


def test_shear_of_rounding_has_no_direction(exe, tmp_path):
    """Torque steps go on from tractions so small that their squares vanish."""
    done = call(exe, ROOT / "data/cd14.nml", *KEYS, "solver.kinematics=nonlinear", "wave_generator.ring_tangent=free", "wave_generator.w=3.84408e-4",
                "wave_generator.cam=cosine", "wave_generator.interference=3.37137e-5", "geometry.wall_thickness=2.57631e-4", "mesh.band_facets=5",
                "geometry.rim_thickness=3.59023e-4", "geometry.ring_thickness=1.39904e-3", "load.torque=-0.150384", "--out", tmp_path / "a", "-q")
    assert done.returncode == 0, done.stderr


def test_shear_of_rounding_holds_nothing(exe, tmp_path):
    """A free flexspline on an eccentric cam is not held; the step is not cut to nothing for ever."""
    done = call(exe, ROOT / "data/cd14.nml", *KEYS, "load.support=bearing", "wave_generator.shape=as_formed", "wave_generator.eccentricity=36e-6",
                "wave_generator.eccentricity_angle_deg=139", "geometry.ring_thickness=1.3e-4", "geometry.wall_thickness=7.2e-4",
                "geometry.rim_thickness=9e-4", "wave_generator.w=8.5e-5", "load.torque=-0.23", "--out", tmp_path / "b", "-q")
    assert done.returncode == 4 and "not held" in done.stderr, done.stderr
