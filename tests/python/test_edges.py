# SPDX-License-Identifier: GPL-3.0-or-later
"""Cells at the edges of the band, and what does not depend on the mesh."""

import numpy as np
import pytest

import hdengine
from conftest import CD14, HELD, PAPER, solved

ONE = {"load__assembly_steps": 1, "load__torque_steps": 1}


def last(**keys):
    """Last load step of the reference scene, and its facets round the axis and along the band."""
    with hdengine.Run(PAPER, **HELD, **ONE, **keys) as run:
        for step in run:
            pass
    return step, (run.facets // run.axial_facets, run.axial_facets)


def rows_of(facets):
    """Lengths of the rows of CD-14-100 with so many facets along the band [m], the shortest 0.1 mm."""
    step, shape = last(mesh={"divisions": 24, "band_facets": facets, "edge_length": 0.1e-3})
    equal, _ = last(mesh={"divisions": 24, "band_facets": 6})
    assert step.facets["area_m2"].sum() == pytest.approx(equal.facets["area_m2"].sum(), rel=1e-12)
    return np.diff(hdengine.results.row_edges(step.facets["area_m2"], shape, 12e-3))


def test_the_edges_stay_as_rows_are_refined():
    """mesh.edge_length: rows grow by half from that length at either edge, the same on all meshes; a row ends where the rim begins to thin
    (8.5 mm behind the edge) and where it has (9.5 mm), behind which rows are half as long."""
    coarse, fine = rows_of(8), rows_of(12)
    for rows in (coarse, fine):
        np.testing.assert_allclose(rows[:3], 1e-4 * 1.5 ** np.arange(3), rtol=1e-6)
        assert rows[-1] == pytest.approx(1e-4, rel=1e-6)
        ends = np.cumsum(rows)
        for place in (8.5e-3, 9.5e-3):
            assert np.min(np.abs(ends - place)) < 1e-9
        assert max(rows[ends > 8.6e-3]) < 0.6 * max(rows[ends < 8.6e-3])
    assert len(fine) > len(coarse)


def test_edge_cells_take_the_error_from_k_ts():
    """Eight rows with cells of 30 um at the edges are within 1 % of K_TS = 2.689 MN m/rad (200 x 46 facets, same edges), 16 rows without are not within 12 %."""
    edges, _ = last(mesh={"divisions": 44, "band_facets": 8, "edge_length": 30e-6})
    plain, _ = last(mesh={"divisions": 92, "band_facets": 16})
    assert edges.k_ts_nm_per_rad == pytest.approx(2.689e6, rel=0.01) and plain.k_ts_nm_per_rad > 1.12 * 2.689e6


def test_power_means_stand_where_contact_ends():
    """The joint takes less pressure than the nodes have at the last two rows of contact only, never more, and shear in the same proportion;
    force and mid-band pressure are of the nodes' own."""
    step, (columns, rows) = last(mesh={"divisions": 44, "band_facets": 8, "edge_length": 30e-6})
    f = step.facets
    corners = np.mean([f[f"pressure_{i}_pa"] for i in (1, 2, 3, 4)], axis=0)
    lower = (corners < (1 - 1e-6) * f["pressure_pa"]).reshape(columns, rows)
    opened = np.any([f[f"pressure_{i}_pa"] == 0 for i in (1, 2, 3, 4)], axis=0).reshape(columns, rows)
    assert lower.any() and not lower.all() and np.all(corners <= (1 + 1e-9) * f["pressure_pa"])
    near = sum(np.roll(opened, (i, j), (0, 1)) for i in range(-2, 3) for j in range(-2, 3)) > 0
    assert not np.any(lower & ~near) and not near.all()
    joint = hdengine.Joint.of_scene(hdengine.read_scene(PAPER))
    assert all(np.all(f[f"shear_{i}_pa"] <= joint.friction * f[f"pressure_{i}_pa"] * (1 + 1e-12)) for i in (1, 2, 3, 4))
    assert step.sums["normal_force_n"] == pytest.approx((f["pressure_pa"] * f["area_m2"]).sum(), rel=1e-9)


def test_points_that_slip_apart_do_not_stiffen_their_facet():
    """A facet's K_T is the mean of its corners', by the Joint of Python: below that of its means, by a tenth in K_TS at 8 rows."""
    step, _ = last(mesh={"divisions": 44, "band_facets": 8, "edge_length": 30e-6})
    f, joint = step.facets, hdengine.Joint.of_scene(hdengine.read_scene(PAPER))
    corners = [joint.stiffness(f[f"pressure_{i}_pa"], f[f"shear_{i}_pa"], f["area_m2"])[1] for i in (1, 2, 3, 4)]
    np.testing.assert_allclose(f["k_t_n_per_m"], np.mean(corners, axis=0), rtol=1e-9, atol=1e-3)
    q, limit = np.hypot(f["traction_theta_pa"], f["traction_z_pa"]), joint.friction * f["pressure_pa"]
    means = joint.stiffness(f["pressure_pa"], np.minimum(q, (1 - 1e-6) * limit), f["area_m2"])[1]
    assert means.sum() > 1.1 * f["k_t_n_per_m"].sum()


def test_rounding_does_not_decide_k_ts():
    """Points that slip count with the limit from below: no facet that is pressed has K_T = 0, half and full model agree."""
    full, _ = last(mesh={"divisions": 44, "band_facets": 8}, solver={"symmetry": "full"})
    half, _ = last(mesh={"divisions": 44, "band_facets": 8})
    f = full.facets
    assert np.all(f["k_t_n_per_m"][f["pressure_pa"] > 1e3] > 0)
    assert half.k_ts_nm_per_rad == pytest.approx(full.k_ts_nm_per_rad, rel=1e-6)


def test_points_beyond_the_slip_limit_slip():
    """The residual leaves some that slip beyond mu p by more than rounding, where K_T of the model is 0: they count as the others."""
    step, _ = last(mesh={"divisions": 44, "band_facets": 8, "edge_length": 23.4e-6}, solver={"kinematics": "linear"})
    f, joint = step.facets, hdengine.Joint.of_scene(hdengine.read_scene(PAPER))
    for i in (1, 2, 3, 4):
        assert np.all(f[f"shear_{i}_pa"] <= (1 - 0.9e-6) * joint.friction * f[f"pressure_{i}_pa"])


def test_mid_band_pressure_is_of_a_fixed_region():
    """The mean pressure of the middle fifth of the band, linear along a facet, changes by less than 2 % from 8 to 20 rows of equal
    length, none of which begins where the fifth does."""
    coarse, _ = last(mesh={"divisions": 44, "band_facets": 8})
    fine, _ = last(mesh={"divisions": 92, "band_facets": 21})
    assert coarse.sums["pressure_mid_mean_pa"] == pytest.approx(fine.sums["pressure_mid_mean_pa"], rel=0.02)


def test_rows_grow_on_past_the_rim():
    """A band that ends 31 um behind the rim's taper: K_TS of cells of 8 and 4 um is the same to 0.6 % (3 % where the rows in front of the
    taper's end begin long again; neighbours' lengths: test_section.f90)."""
    geometry = {"wall_thickness": 0.515881e-3, "rim_thickness": 1.02647e-3, "ring_thickness": 0.910129e-3, "band_length": 9.5305e-3}
    wide, thin = (last(mesh={"divisions": 60, "band_facets": 12, "edge_length": e, "through_wall": 2, "through_ring": 2}, geometry=geometry,
                       solver={"kinematics": "linear"}, wave_generator={"w": 0.128133e-3, "interference": 0.994672e-6},
                       contact={"friction": 0.129882}, load={"torque": 7.15399})[0].k_ts_nm_per_rad for e in (8e-6, 4e-6))
    assert thin == pytest.approx(wide, rel=0.006)


def test_lobe_force_is_an_integral():
    """The force of a lobe moves by 0.2 % at most with the number of divisions: it is not cut at a node."""
    forces = [last(mesh={"divisions": n, "band_facets": 4})[0].sums["lobe_force_x_n"] for n in (38, 40, 42, 44)]
    assert np.ptp(forces) < 2e-3 * forces[0]


def test_line_load_of_the_edge_converges_where_the_peak_does_not():
    """Cells at the edge a quarter as long: the peak doubles at least, the force per length of the last tenth stays within 1 %."""
    coarse, fine = (last(mesh={"divisions": 40, "band_facets": 12, "edge_length": edge})[0].sums for edge in (1e-4, 2.5e-5))
    assert fine["pressure_max_pa"] > 2 * coarse["pressure_max_pa"]
    assert fine["edge_line_load_n_per_m"] == pytest.approx(coarse["edge_line_load_n_per_m"], rel=0.01)


@pytest.mark.parametrize("keys", [["mesh.edge_length=1e-4"], ["mesh.edge_length=2.5e-5"], ["mesh.element=hex20r", "mesh.wall_elements=4"]])
def test_strong_friction_does_not_cycle(exe, tmp_path, keys):
    """Friction 0.63 with thin edge cells, and quadratic elements: no contact state runs in a cycle, no load step is halved, moments balance."""
    r = solved(exe, tmp_path / "r", CD14, "mesh.divisions=32", "mesh.band_facets=6", "contact.friction=0.63", *keys,
               "output.vtu=none").summary["results"]
    assert r["iterations"] <= 60 and r["cut_backs"] == 0 and abs(r["torque_balance_nm"]) < 1e-8
