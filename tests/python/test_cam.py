# SPDX-License-Identifier: GPL-3.0-or-later
"""The wave generator: fields of small displacements, places of large ones, and what a ring on it feels."""
import mpmath
import numpy as np
import pytest

import hdengine
from conftest import ROOT, solved

R, W = 16.5e-3, 0.2e-3
THETA = np.linspace(-0.3, 6.1, 23)


def profile(name, phi, lobes=2):
    """Radius of a named profile at a polar angle, in 20 digits."""
    c, s = mpmath.cos(phi), mpmath.sin(phi)
    if name == "ellipse":
        return (R + W) * (R - W) / mpmath.sqrt(((R - W) * c) ** 2 + ((R + W) * s) ** 2)
    return R + W * mpmath.cos(lobes * phi)


def length(name, lobes=2, low=0, high=2 * mpmath.pi):
    """Arc length of a named profile."""
    def speed(p):
        return mpmath.hypot(profile(name, p, lobes), mpmath.diff(lambda q: profile(name, q, lobes), p))
    n = 16
    return mpmath.quad(speed, [low + (high - low) * mpmath.mpf(k) / n for k in range(n + 1)])


@pytest.fixture(autouse=True)
def digits():
    """Twenty digits here, as many as before elsewhere."""
    with mpmath.workdps(20):
        yield


@pytest.mark.parametrize("name, lobes", [("ellipse", 2), ("cosine", 2), ("cosine", 3)])
def test_points_lie_on_the_curve(name, lobes):
    """With the profile's perimeter the points of large displacements lie on the profile and part it by arc length, to rounding against
    20 digits; their normals and curvatures are the profile's."""
    found = hdengine.cam(THETA, wave_generator={"cam": name, "lobes": lobes, "perimeter": "curve"})
    phi = np.arctan2(found.points[1], found.points[0])
    radius = [float(profile(name, p, lobes)) for p in phi]
    np.testing.assert_allclose(np.hypot(*found.points), radius, rtol=3e-16 * 4)
    whole = length(name, lobes)
    assert found.curve_m == pytest.approx(float(whole), rel=1e-15)
    for k in (5, 16):
        share = length(name, lobes, phi[0], phi[k] + 2 * np.pi * (phi[k] < phi[0])) / whole
        assert float(share) == pytest.approx((THETA[k] - THETA[0]) / (2 * np.pi), abs=1e-15)
    turn = mpmath.diff(lambda q: profile(name, q, lobes), phi[5])
    slope = float(mpmath.atan2(-turn, profile(name, phi[5], lobes))) + phi[5]
    np.testing.assert_allclose(found.normal[:, 5], [np.cos(slope), np.sin(slope)], atol=1e-14)


@pytest.mark.parametrize("name", ["ellipse", "cosine", "arcs"])
def test_kept_perimeter_is_kept(name):
    """By default the curve is parallel to the profile and as long as the circle: lengths and neighbours' distances agree to rounding."""
    t = np.linspace(0, 2 * np.pi, 4001)
    found = hdengine.cam(t, wave_generator={"cam": name})
    assert found.curve_m == pytest.approx(2 * np.pi * R, rel=1e-15)
    chord = np.hypot(*np.diff(found.points))
    bend = 0.5 * (found.curvature[1:] + found.curvature[:-1])
    arc = chord * (1 + (chord * bend) ** 2 / 24)  # to the fourth order
    np.testing.assert_allclose(arc, 2 * np.pi * R / 4000, rtol=2e-9 if name != "arcs" else 4e-9)  # a chord over the end of an arc


def test_arcs_are_arcs():
    """Four arcs: curvatures are those of two radii, the semi-axes r + w and r - w, the perimeter the circle's without any offset."""
    found = hdengine.cam([0, 0.3, np.pi / 2, 1.3, np.pi], wave_generator={"cam": "arcs", "perimeter": "curve"})
    centre = W / (1 - np.sqrt(0.5))
    np.testing.assert_allclose(1 / found.curvature, [R - centre * np.sqrt(0.5)] * 2 + [R + centre * np.sqrt(0.5)] * 2
                               + [R - centre * np.sqrt(0.5)], rtol=1e-13)
    np.testing.assert_allclose(np.hypot(*found.points)[[0, 2]], [R + W, R - W], rtol=1e-14)
    assert found.curve_m == pytest.approx(2 * np.pi * R, rel=1e-14)


@pytest.mark.parametrize("keys", [{"cam": "ellipse"}, {"cam": "cosine"}, {"cam": "cosine", "lobes": 4}, {"cam": "arcs", "arc_angle_deg": 30}])
def test_field_is_the_first_order(keys):
    """What is left between the exact placement and the first-order field falls with the square of w; the field is linear in w and keeps
    every length."""
    left, scaled = [], []
    for w in (2e-4, 1e-4):
        c = hdengine.cam(THETA, wave_generator={**keys, "w": w})
        e_r, e_t = np.array([np.cos(THETA), np.sin(THETA)]), np.array([-np.sin(THETA), np.cos(THETA)])
        exact = np.array([(c.points * e_r).sum(0) - R, (c.points * e_t).sum(0)])
        left.append(np.abs(exact - c.field).max())
        scaled.append(c.field / w)
    assert 3.5 < left[0] / left[1] < 4.5 and left[1] < 100 * (1e-4) ** 2 / R
    np.testing.assert_allclose(*scaled, atol=1e-12)
    t = np.linspace(0.1, 0.4, 301)
    u, v = hdengine.cam(t, wave_generator=keys).field
    np.testing.assert_allclose(np.gradient(v, t, edge_order=2) + u, 0, atol=2e-4 * 1e-3)


def test_ellipse_and_cosine_are_one_field():
    """To first order the ellipse and the cosine are the same displacement, bit by bit."""
    a, b = (hdengine.cam(THETA, wave_generator={"cam": c}).field for c in ("ellipse", "cosine"))
    np.testing.assert_array_equal(a, b)


def table(path, base, w):
    """A measured cosine at uneven angles."""
    t = np.sort(np.random.default_rng(3).uniform(0, 360, 200))
    path.write_text("# a cam\ntheta_deg,radius_m\n" + "\n".join(f"{a:.12g},{base + w * np.cos(2 * np.radians(a)):.15g}" for a in t) + "\n")
    return {"cam": "table", "cam_file": str(path)}


def test_measured_table_is_the_curve_it_was_taken_from(tmp_path):
    """A table of a cosine gives the field and the places of the cosine, as near as a cubic spline through 200 points, also when measured
    on the smaller cam of a bearing; another perimeter adds its share of the radius."""
    named = hdengine.cam(THETA, wave_generator={"cam": "cosine"})
    for base in (R, R - 2e-6):
        found = hdengine.cam(THETA, wave_generator=table(tmp_path / "c.csv", base, W))
        np.testing.assert_allclose(found.field, named.field, atol=1e-4 * W)
        np.testing.assert_allclose(found.points, named.points, atol=1e-4 * W)
    found = hdengine.cam(THETA, wave_generator=table(tmp_path / "c.csv", R + 3e-6, W) | {"perimeter": "curve"})
    np.testing.assert_allclose(found.field[0], named.field[0] + 3e-6, atol=1e-4 * W)
    found = hdengine.cam(THETA, wave_generator={"cam": "cosine", "perimeter": "given", "perimeter_length": 2 * np.pi * (R + 5e-6)})
    np.testing.assert_allclose(found.field[0], named.field[0] + 5e-6, rtol=1e-10)
    assert found.curve_m == pytest.approx(2 * np.pi * (R + 5e-6), rel=1e-14)


def test_a_table_written_anew_is_read_anew(tmp_path):
    """A process that goes on keeps no model of what the file held before, and w is half the range of the radii, whatever is said."""
    keys = {"wave_generator.shape": "as_formed", "wave_generator.w": 0.7e-3, "mesh.divisions": 16, "mesh.band_facets": 3, "output.vtu": "none"}
    found = []
    for w, forget in ((W, True), (1.5 * W, False), (1.5 * W, True)):
        if forget:
            hdengine.forget()
        of = {f"wave_generator.{key}": value for key, value in table(tmp_path / "c.csv", R, w).items()}
        run = hdengine.run(ROOT / "data/cd14.nml", tmp_path / "r", True, **keys, **of)
        found.append(run.summary["results"]["k_ts_nm_per_rad"])
        assert run.scene["wave_generator.w"] == pytest.approx(w, rel=1e-3)
    assert found[1] == pytest.approx(found[2], rel=1e-12) and found[1] != pytest.approx(found[0], rel=1e-2)


HEAD = "theta_deg,radius_m\n0,0.0165\n"


@pytest.mark.parametrize("text, words", [("theta,r\n0,1\n", "line 1: the header is 'theta,r'"), (HEAD + "5\n", "line 3: 1 cells; valid: 2"),
                                         (HEAD + "-5,0.0165\n", "line 3: the angle does not rise"),
                                         (HEAD + "360,0.0165\n", "line 3: the angle leaves the first turn"),
                                         (HEAD, "1 points; valid: 8 or more"), (HEAD + "50,/\n", "line 3: column radius_m: '/'"),
                                         (HEAD + "5,0.0165,7\n", "line 3: 3 cells"), (HEAD + "5,1+13\n", "'1+13'; valid: a number"),
                                         (HEAD + f"5,0.0165{' ' * 300}1\n", "column radius_m: '0.0165 "),
                                         (HEAD + "5,2*0.0165\n", "'2*0.0165'"), (HEAD + "5,0.0165;\n", "'0.0165;'"), (HEAD + "5,\33[2J\n", "'?[2J'"),
                                         (HEAD + "".join(f"{t},0.0165\n" for t in range(5, 180, 5)), "line 37: no point within 185.0 deg after this one")])
def test_bad_tables_are_named(tmp_path, text, words):
    """A fault of a measured table is named with file, line and what is valid."""
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(hdengine.InputError, match=".*") as e:
        hdengine.cam([0.0], wave_generator={"cam": "table", "cam_file": str(path)})
    assert words in str(e.value) and "bad.csv" in str(e.value)


def scene(kinematics, part, **keys):
    """Sums and K_TS after the assembly of a share of w and interference, on a coarse mesh; the ring held: with a sliding one single points
    turn from stick to slip there, and K_TS by Eq. 45 jumps."""
    with hdengine.Run(ROOT / "data/paper.nml", mesh={"divisions": 32, "band_facets": 4, "wall_elements": 4, "bottom_elements": 3},
                      solver={"kinematics": kinematics}, load={"support": "hub", "torque_steps": 0, "assembly_steps": 1},
                      wave_generator={"w": W * part, "interference": 1e-5 * part, **keys}) as run:
        step = list(run)[-1]
    return np.array([step.sums["normal_force_n"], step.k_ts_nm_per_rad])


@pytest.mark.parametrize("name", ["ellipse", "cosine"])
def test_kinematics_meet_as_w_vanishes(name):
    """Displacements that shrink together leave the linear problem alike, and in the nonlinear one terms of one order more: normal force
    and K_TS of both kinematics meet with the first power of w, and at w/r = 0.012 forces are 2 % apart."""
    apart = [scene("nonlinear", part, cam=name) / scene("linear", part, cam=name) - 1 for part in (1, 0.25, 0.125)]
    assert np.abs(apart[0]).max() < 0.02
    np.testing.assert_allclose(apart[1] / apart[2], 2, rtol=0.05)


@pytest.mark.parametrize("kinematics", ["linear", "nonlinear"])
def test_hoop_force_of_a_stretched_ring(exe, tmp_path, kinematics):
    """A round cam that is larger by 5 um presses a ring that touches nothing else as a thick ring under inner pressure (Lame)."""
    inside, outside, width, modulus, poisson, over = 16.5e-3, 17.5e-3, 12e-3, 219e9, 0.3, 5e-6
    results = solved(exe, tmp_path / "r", ROOT / "data/cd14.nml", "mesh.divisions=96", "mesh.band_facets=4", "mesh.wall_elements=4",
                     "mesh.bottom_elements=3", f"solver.kinematics={kinematics}", "load.torque_steps=0", "load.assembly_steps=1",
                     "wave_generator.w=0", "output.vtu=none", "wave_generator.clearance=5e-5", "wave_generator.ring_contact=unilateral",
                     "wave_generator.perimeter=given", f"wave_generator.perimeter_length={2 * np.pi * (inside + over)!r}").summary["results"]
    pressure = over * modulus / inside / ((outside**2 + inside**2) / (outside**2 - inside**2) + poisson)
    assert results["cam_force_n"] == pytest.approx(2 * np.pi * inside * width * pressure, rel=2e-3)
    assert results["cam_contact_area_m2"] == pytest.approx(2 * np.pi * inside * width) and results["cam_gap_max_m"] < 1e-12
    assert results["cam_pressure_min_pa"] == pytest.approx(pressure, rel=0.02)


def test_gap_over_a_notch(exe, tmp_path):
    """A stiff ring that a round cam stretches by 0.5 um bridges a notch of 20 um, 24 degrees wide: it hangs into it by less than 1 um, as a beam."""
    t = np.arange(0, 360)
    notch = 20e-6 * np.where(abs(t - 180) < 12, np.cos(np.radians(90 / 12 * (t - 180))), 0)**2
    (tmp_path / "c.csv").write_text("theta_deg,radius_m\n" + "".join(f"{a},{16.5e-3 + 5e-7 - x:.15g}\n" for a, x in zip(t, notch)))
    results = solved(exe, tmp_path / "r", ROOT / "data/cd14.nml", "mesh.divisions=48", "mesh.band_facets=4", "load.torque_steps=0",
                     "load.assembly_steps=1", "wave_generator.w=0", "wave_generator.clearance=1e-4", "wave_generator.ring_contact=unilateral",
                     "output.vtu=none", "wave_generator.cam=table", f"wave_generator.cam_file={tmp_path / 'c.csv'}", "wave_generator.perimeter=curve").summary["results"]
    assert 19e-6 < results["cam_gap_max_m"] < 20e-6 and results["cam_pressure_min_pa"] == 0
