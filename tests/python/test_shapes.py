# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of the wave generator and of the stress-free bodies, loads of the rim."""
import meshio
import numpy as np
import pytest

import hdengine
from conftest import CD14, SMALL, call, solve_small


@pytest.fixture(scope="module")
def teeth(exe, tmp_path_factory):
    return solve_small(exe, tmp_path_factory.mktemp("teeth") / "t.out", "load.torque_load=teeth", "load.torque=20",
                 "mesh.divisions=40")


def test_tooth_forces_balance(teeth):
    """The forces of 40 tooth pairs have the torque asked for, and all moments and axial forces balance."""
    s = teeth.steps
    assert abs(s["torque_balance_nm"][-1]) < 1e-8 * 20 and abs(s["axial_balance_n"][-1]) < 1e-8 * s["normal_force_n"][-1]


def test_teeth_press_on_the_lobes(exe, teeth, tmp_path):
    """The radial part, T tan(20 deg) / r, goes into the lobes: 50 to 100 % of it is seen there; without it nearly nothing."""
    none = solve_small(exe, tmp_path / "z.out", "load.torque_load=teeth", "load.torque=20", "load.pressure_angle_deg=0",
                 "mesh.divisions=40")
    radial = 20 / 17.927e-3 * np.tan(np.radians(20))
    gain = [r.steps["lobe_force_x_n"][-1] - r.steps["lobe_force_x_n"][0] for r in (teeth, none)]
    assert 0.5 < (gain[0] - gain[1]) / radial < 1 and abs(gain[1]) < 0.1 * radial


def test_teeth_keep_the_two_lobes_equal(teeth):
    """Forty pairs at both ends of the long axis: the pressure repeats after half a turn."""
    p = teeth.contact["pressure_pa"][-1].reshape(teeth.shape)
    np.testing.assert_allclose(p, np.roll(p, teeth.shape[0] // 2, axis=0), atol=1e-6 * p.max())


def test_formed_bodies_are_free_of_stress(exe, tmp_path):
    """Formed to the ellipse without interference there is no pressure, and the facets lie on the ellipse."""
    r = solve_small(exe, tmp_path / "f.out", "wave_generator.shape=as_formed", "wave_generator.interference=0", "load.torque_steps=0",
              "mesh.divisions=48")
    assert r.contact["pressure_pa"].max() == 0
    x, y = r.contact["x_m"][-1], r.contact["y_m"][-1]
    np.testing.assert_allclose(np.hypot(x / 17.7e-3, y / 17.3e-3), 1, atol=3e-3)
    assert x.max() - y.max() == pytest.approx(0.4e-3, rel=0.02)


def test_the_formed_shape_fades_to_the_bottom(exe, tmp_path):
    """Behind the band the shape of a formed cup, 2 w from short to long axis, falls in proportion to what is left of the way to the bottom."""
    scene = solve_small(exe, tmp_path / "f", "wave_generator.shape=as_formed", "wave_generator.interference=0", "load.torque_steps=0",
                        "mesh.wall_elements=6").scene
    grid = meshio.read(next((tmp_path / "f").glob("bodies_*.vtu")))
    x, y, z = grid.points[np.unique(grid.cells[0].data[np.ravel(grid.cell_data["body"][0]) == 2])].T
    end, corner = scene["geometry.band_start"] + scene["geometry.band_length"], scene["geometry.cup_length"] - scene["geometry.bottom_thickness"]
    heights = [h for h in np.unique(z.round(7)) if end < h < corner]
    long, short = ([np.hypot(x, y)[(abs(z - h) < 1e-6) & (abs(across) < 1e-6)].min() for h in heights] for across in (y, x))
    np.testing.assert_allclose(np.subtract(long, short), 2 * scene["wave_generator.w"] * (corner - np.array(heights)) / (corner - end), rtol=0.02, atol=1e-7)
    assert len(heights) > 2


def test_formed_cup_holds_by_its_shape(exe, tmp_path):
    """Frictionless and formed, ring and cup interlock: pressure alone carries part of the torque; moments balance."""
    r = solve_small(exe, tmp_path / "l.out", "wave_generator.shape=as_formed", "contact.mode=frictionless")
    s = r.steps
    assert abs(s["friction_torque_nm"][-1]) > 1e-4 and abs(s["torque_balance_nm"][-1]) < 1e-8 * 5


def test_round_limit_of_the_formed_scene(exe, tmp_path):
    """With w = 0 pressed and as_formed are one scene: equal pressure and rotation to 1e-7."""
    keys = ["wave_generator.w=0", "solver.tolerance=1e-10"]
    a = solve_small(exe, tmp_path / "a.out", *keys)
    b = solve_small(exe, tmp_path / "b.out", *keys, "wave_generator.shape=as_formed")
    np.testing.assert_allclose(a.contact["pressure_pa"], b.contact["pressure_pa"], atol=1e-7 * a.contact["pressure_pa"].max())
    assert a.steps["rotation_rad"][-1] == pytest.approx(b.steps["rotation_rad"][-1], rel=1e-6)


def test_cone_moves_the_load_along_the_band(exe, small_run, tmp_path):
    """A cam that tapers as the flexspline cones lowers the force and takes pressure off the rear edge."""
    r = solve_small(exe, tmp_path / "c.out", "wave_generator.cone_angle_deg=0.5")
    flat = hdengine.load(small_run)
    rows = [x.contact["pressure_pa"][-1].reshape(x.shape).sum(0) for x in (r, flat)]
    assert r.steps["normal_force_n"][-1] < flat.steps["normal_force_n"][-1]
    assert rows[0][-1] / rows[0].sum() < rows[1][-1] / rows[1].sum()


def test_free_ring_is_held_softly(exe, tmp_path):
    """A ring that slides on the cam is held by soft springs: the scene converges; with a bearing support nothing takes the torque."""
    solve_small(exe, tmp_path / "r.out", "wave_generator.ring_tangent=free", "contact.friction=0.5")
    done = call(exe, CD14, *SMALL, "wave_generator.ring_tangent=free", "load.support=bearing", "--out", tmp_path / "x", "-q")
    assert done.returncode == 2 and "nothing takes the torque" in done.stderr


def test_rim_ends_between_rows(exe, tmp_path):
    """The loaded rim ends where the scene says, not at a row of nodes: 7, 10 and 16 rows give one rotation of the whole cup to 1.5 %."""
    rotation = [solve_small(exe, tmp_path / f"{rows}.out", f"mesh.band_facets={rows}", "wave_generator.ring_tangent=free")
                .steps["rotation_rad"][-1] for rows in (7, 10, 16)]
    assert max(rotation) < 1.015 * min(rotation)  # the mesh itself: 1.2 %
