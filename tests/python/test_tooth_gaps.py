# SPDX-License-Identifier: GPL-3.0-or-later
"""Clearance of tooth pairs from their profile: closed forms, limits, symmetry, convergence, bad input, the command."""
import json
import shutil
from types import SimpleNamespace

import meshio
import numpy as np
import pytest

import hdengine
from conftest import ROOT
from hdengine.cli import main
from hdengine.table_file import read_csv
from hdengine.teeth import pairs
from hdengine.teeth.gap import flank_gap
from hdengine.teeth.pairs import tooth_gaps
from hdengine.teeth.profile import DoubleArc, Involute, involute_angle
from hdengine.teeth.rim import Rim
from hdengine.teeth.rim_shape import RimShape, read_grid

M, SCENE = 0.1778e-3, ROOT / "tests/cases/pressed_drive.nml"
ROUND = {"wave_generator.w": 0.0}


def test_a_clearance_that_jumps_is_kept(monkeypatch):
    """Where a tip begins to reach into a space the clearance of the closest pair jumps: the least shift that keeps more. It ran to and fro, and ended."""
    monkeypatch.setattr(pairs, "_closest", lambda *of: of[2] * 6e-5 + (3e-6 if of[2] > 0.37 else -3e-6))
    monkeypatch.setattr(Involute, "spline_flank", lambda _, spaces, x2, n: x2)
    rim = SimpleNamespace(scene={"load.teeth": 200}, root=0.018)
    assert pairs._spline_shift(Involute(M), rim, None, 202, 0.0, 22e-6) == pytest.approx(0.37, abs=1e-6)
    assert pairs._spline_shift(Involute(M), rim, None, 202, 0.0, 33e-6) == pytest.approx(0.5, abs=1e-6)


@pytest.fixture(scope="module")
def involute():
    return tooth_gaps(Involute(M), SCENE)


@pytest.fixture(scope="module")
def double_arc():
    return tooth_gaps(DoubleArc(M), SCENE)


def arc(centre, radius, first, last, points):
    """Points of an arc from one angle to another [deg]."""
    t = np.radians(np.linspace(first, last, points))
    return np.column_stack([centre[0] + radius * np.cos(t), centre[1] + radius * np.sin(t)])


def test_concentric_involutes_keep_an_even_clearance():
    """Teeth as many as spaces on a round rim: every flank is m (x2 - x1) sin(alpha) clear, to 1 nm; a smaller x2 interferes as far."""
    for alpha, more in ((20.0, 0.05), (30.0, -0.05)):
        found = tooth_gaps(Involute(M, alpha, x1=1.8, x2=1.8 + more), SCENE, spline_teeth=200, **ROUND)
        want = M * more * np.sin(np.radians(alpha))
        np.testing.assert_allclose([found.table["gap_m"], found.table["gap_back_m"]], want, rtol=0, atol=1e-9)
        assert found.least_m == pytest.approx(want, abs=1e-9) and (more > 0) == (not found.notes)


def test_rack_limit():
    """With 10^5 teeth flanks are straight: moved outwards by h, a tooth has m (x2 - x1) sin(alpha) - h sin(alpha) left, to 1e-3 of m."""
    z, x2 = 100000, 0.3
    profile = Involute(M, x1=0.0, x2=x2)
    tooth, space = profile.flank(z, 0.0, 100), profile.spline_flank(z, x2, 100)
    for h in (0.0, 0.1 * M, 0.4 * M):
        gap, angle, _ = flank_gap(tooth + [0, h], space)
        assert gap == pytest.approx((M * x2 - h) * np.sin(np.radians(20)), abs=1e-3 * M)
        assert np.degrees(angle) == pytest.approx(20, abs=0.1)


def test_every_pair_beside_the_distance_from_an_involute(involute):
    """A point is the base radius times the angle between two involutes away from one: both flanks, and the corner of the space, to 2 nm."""
    rim, f = Rim.read(SCENE), involute.facts
    tooth = involute.profile.flank(200, rim.root, 4000)
    base = M * np.cos(np.radians(20)) / 2 * np.array([200, 202])
    start = [np.arctan2(*c[0]) + involute_angle(np.hypot(*c[0]), b) for c, b in zip((tooth, involute.space), base)]
    corner, mouth = complex(*involute.space[0]), np.hypot(*involute.space[0])
    places = involute.table["place_pitches"][:20]
    for side, name in ((1, "gap_m"), (-1, "gap_back_m")):
        for flank, gap in zip(rim.flanks(tooth, places, f["spline_teeth"], side), involute.table[name]):
            r = np.hypot(*flank.T)
            way = base[1] * (start[1] - involute_angle(r, base[1]) - np.arctan2(*flank.T))
            at, rest = flank @ [1, 1j], tooth @ [1, 1j]
            back = (corner - at[0]) * (rest[-1] - rest[0]) / (at[-1] - at[0]) + rest[0]     # the corner beside the tooth at rest
            beside = base[0] * (np.pi / 2 - np.angle(back) + involute_angle(abs(back), base[0]) - start[0])
            assert gap == pytest.approx(min(way[r >= mouth].min(), beside), abs=2e-9)


@pytest.mark.parametrize("points", (20, 40, 80))
def test_arcs_converge_with_the_square_of_the_points(points):
    """A convex arc in a concave one: distance of radii and centres; polylines err by less than their sagitta, which falls with 1/n^2."""
    small, large, apart = 0.2e-3, 0.35e-3, (30e-6, 20e-6)
    tooth, space = arc((0, 0), small, -40, 70, points), arc(apart, large, -40, 70, points)
    want = large - small - np.hypot(*apart)
    gap, _, _ = flank_gap(tooth, space - [2 * apart[0], 2 * apart[1]])
    sagitta = large * (np.radians(110) / (points - 1))**2 / 8
    assert abs(gap - want) < 2 * sagitta
    convex = arc((1e-3, 0), 0.5e-3, 220, 140, points)
    assert flank_gap(arc((0, 0), small, -40, 40, points), convex)[0] == pytest.approx(0.3e-3, abs=2 * sagitta)


def test_corners_that_pass():
    """A corner past the other's tip has entered by the shorter way out; one that stays below is clear."""
    tooth, space = np.array([[0.0, 0.0], [0.0, 1.0]]), np.array([[-0.3, 0.9], [-0.3, 2.0]])
    assert flank_gap(tooth, space)[0] == pytest.approx(-0.1)
    assert flank_gap(tooth, space + [0.2, -0.5])[0] == pytest.approx(-0.1)
    assert flank_gap(tooth, space + [0, 0.2])[0] == pytest.approx(np.hypot(0.3, 0.1))
    assert flank_gap(tooth, space + [0.5, -0.5])[0] == pytest.approx(0.2)


def test_rim_goes_over_into_first_order():
    """For small w the neutral line has u = w cos 2t, v = -(w/2) sin 2t, its normal turns by (3/2)(w/r) sin 2t; the rest falls with w^2."""
    t, rest = np.linspace(0, np.pi, 25), []
    for w in (0.2e-3, 0.1e-3):
        rim = Rim.read(SCENE, **{"wave_generator.w": w})
        (x, y), n = rim.poses(t)
        u, v = np.cos(t) * x + np.sin(t) * y - rim.radius, np.cos(t) * y - np.sin(t) * x
        turn = np.cos(t) * n[1] - np.sin(t) * n[0]
        rest.append([abs(u - w * np.cos(2 * t)).max(), abs(v + w / 2 * np.sin(2 * t)).max(),
                     abs(turn - 1.5 * w / rim.radius * np.sin(2 * t)).max()])
    assert np.all(np.array(rest[0]) < [1e-5, 1e-5, 5e-4])
    np.testing.assert_allclose(np.divide(*rest), 4, rtol=0.1)


@pytest.mark.parametrize("kind", ("involute", "double_arc"))
def test_clearances_are_mirrored(kind, request):
    """Flanks of a positive torque on one side of the long axis are as clear as the others on the other side, alike at both ends."""
    t = request.getfixturevalue(kind).table
    gap, back = (t[name].reshape(2, 20) for name in ("gap_m", "gap_back_m"))
    np.testing.assert_allclose(gap[0], back[0][::-1], atol=1e-12)
    np.testing.assert_allclose(gap[1], gap[0], atol=1e-12)


@pytest.mark.parametrize("profile", (Involute(M), DoubleArc(M)), ids=("involute", "double_arc"))
def test_clearances_converge(profile):
    """Twice the points of a flank move no clearance by more than 10 nm."""
    coarse, fine = (tooth_gaps(profile, SCENE, points=n).table["gap_m"] for n in (100, 200))
    np.testing.assert_allclose(coarse, fine, rtol=0, atol=1e-8)


@pytest.mark.parametrize("profile", (Involute(M), DoubleArc(M)), ids=("involute", "double_arc"))
def test_the_closest_pair_keeps_what_is_asked(profile):
    """least_gap is the clearance of the closest pair, to 10 nm, and no pair has less."""
    for least in (0.0, 3e-6):
        found = tooth_gaps(profile, SCENE, least_gap=least)
        assert found.least_m == pytest.approx(least, abs=1e-8) and found.table["gap_m"].min() >= found.least_m - 1e-12


def test_envelope_meets_the_equation_of_contact(double_arc):
    """Points of contact by the condition of Liu et al. 2025 (Eq. 14-30, radius less w^2/r, which keeps the length) lie on the space or outside, to 0.3 um."""
    line, rest, w = double_arc.tooth, Rim.read(SCENE).radius, 0.2e-3

    def placed(phi):
        """Flank at an angle of the neutral line, in the space."""
        across, height = line[:, 0], line[:, 1] - rest
        rho, gamma = rest - w**2 / rest + w * np.cos(2 * phi), phi - w * np.sin(2 * phi) / (2 * rest) - 200 / 202 * phi
        psi = 2 * w / rest * np.sin(2 * phi) + gamma
        return np.stack([across * np.cos(psi) + height * np.sin(psi) + rho * np.sin(gamma),
                         height * np.cos(psi) - across * np.sin(psi) + rho * np.cos(gamma)])
    angles, h = np.linspace(-0.5, 0.5, 4001), 1e-6
    along = np.array([np.gradient(placed(p), axis=1) for p in angles])
    moved = np.array([placed(p + h) - placed(p - h) for p in angles])
    condition = along[:, 0] * moved[:, 1] - along[:, 1] * moved[:, 0]
    met = np.argwhere(condition[:-1] * condition[1:] < 0)
    found = np.array([placed(angles[k])[:, i] for k, i in met])
    inside = found[(found[:, 1] > double_arc.space[0, 1]) & (found[:, 1] < double_arc.space[-1, 1])]
    way = np.array([flank_gap(np.array([point - [0, 1e-9], point]), double_arc.space)[0] for point in inside])
    assert len(way) > 50 and way.min() > -3e-7 and np.mean(way < 3e-7) > 0.5


def test_a_turned_scene_has_the_lists_of_one_at_rest(involute):
    """The engine goes along the lists by load.tooth_phase; lists that are turned by it too would be turned twice."""
    turned = tooth_gaps(Involute(M, x2=involute.facts["x2"]), SCENE, **{"load.tooth_phase": 0.5})
    assert turned.keys() == involute.keys()


def test_lines_are_a_scene(involute, tmp_path):
    """The lines, pasted under &load, give the scene that the keys give; each clearance is that of the table to four digits."""
    keys = involute.keys()
    text = SCENE.read_text().replace("  tooth_pairs = 40\n  pressure_angle_deg = 25\n", "").replace("  tooth_clearance = 1e-05   ! of the outermost pairs\n", involute.lines())
    (tmp_path / "scene.nml").write_text(text)
    scene = hdengine.read_scene(tmp_path / "scene.nml")
    assert {name: scene[name] for name in keys} == keys
    np.testing.assert_allclose(keys["load.tooth_gaps"], involute.table["gap_m"][:20], rtol=1e-3)


def test_lists_of_the_scene_itself_do_not_count():
    """Clearances that a scene holds for its pairs bind neither their number nor what is computed."""
    few = tooth_gaps(Involute(M, x2=1.8), ROOT / "data/drive14.nml", points=20, load={"tooth_pairs": 2, "tooth_gaps": [1e-6] * 5})
    assert len(few.table["gap_m"]) == 2


BAD = (
    (lambda: Involute(-1.0), "module = -1.0: must be a finite number above 0"),
    (lambda: Involute(M, 50.0), "pressure_angle_deg = 50.0: must be a finite number above 5 and up to 40"),
    (lambda: DoubleArc(M, convex_radius=0.5), "addendum + convex_y = 0.86: must be below convex_radius = 0.5"),
    (lambda: DoubleArc(M, concave_radius=1.0), "dedendum + concave_y = 1.018: must be below concave_radius = 1"),
    (lambda: DoubleArc(M, convex_radius=5.0), "convex_radius + concave_radius = 6.57: must be below 2.95"),
    (lambda: tooth_gaps("involute", SCENE), "profile = 'involute': must be of type Involute or DoubleArc"),
    (lambda: tooth_gaps(Involute(0.5e-3), SCENE), "module = 0.0005 with load.teeth = 200: must be 0.0001553 to 0.0001984"),
    (lambda: tooth_gaps(Involute(M), SCENE, spline_teeth=150), "spline_teeth = 150: must be load.teeth = 200 or more"),
    (lambda: tooth_gaps(Involute(M, x2=2.0), SCENE, least_gap=1e-6), "least_gap = 1e-06 together with x2 = 2: must be one of them"),
    (lambda: tooth_gaps(Involute(M, 30.0, addendum=2.0), SCENE), "addendum = 2: flanks of 200 teeth with shift 1.8 meet 1.226 modules out; valid: less"),
    (lambda: tooth_gaps(Involute(M), SCENE, load={"tooth": 3}), "load.tooth"),
)


@pytest.mark.parametrize("act, message", BAD, ids=range(len(BAD)))
def test_what_is_not_valid_is_named(act, message):
    """Each bad value is refused with its name, the value seen and what is valid."""
    with pytest.raises(hdengine.InputError) as caught:
        act()
    assert message in str(caught.value)


@pytest.fixture(scope="module")
def assembled(tmp_path_factory):
    """Folder of a run of the assembly alone."""
    folder = tmp_path_factory.mktemp("rim") / "r"
    hdengine.run(SCENE, folder, **{"mesh.divisions": 44, "mesh.band_facets": 6, "loop.torques": [0, 0], "load.torque_steps": 1, "output.vtu": "last"})
    return folder


def test_grid_is_what_meshio_reads(assembled):
    """Places and displacements of the engine's grid are those that meshio reads, to the last bit."""
    path = next(assembled.glob("bodies_*.vtu"))
    grid, other = read_grid(path, "Points", "displacement_m"), meshio.read(path)
    assert np.array_equal(grid["Points"], other.points) and np.array_equal(grid["displacement_m"], other.point_data["displacement_m"])
    assert grid["torque_nm"] == 0 and grid["TimeValue"] == 1


def test_rim_of_a_run(assembled):
    """Points of a run's rim are the places of its nodes, mean over its length or the width of the circular spline amid it, w^2/R = 2.26 um nearer on
    the long axis, which a ring that keeps its length is and small displacements are not; the normal is right on a shape known in closed form."""
    rim = Rim.read(assembled)
    grid = read_grid(next(assembled.glob("bodies_*.vtu")), "Points", "displacement_m")
    x, u = grid["Points"], grid["displacement_m"]
    on = (abs(np.hypot(x[:, 0], x[:, 1]) - rim.radius) < 1e-8) & (x[:, 2] < 9.01e-3) & (x[:, 0] > 0) & (abs(x[:, 1]) < 1e-9)
    order = np.argsort(x[on, 2])
    mean = (np.diff(x[on, 2][order])[:, None] * (u[on][order][1:] + u[on][order][:-1]) / 2).sum(axis=0) / np.ptp(x[on, 2])
    nearer = 0.2e-3**2 / (17.5e-3 + rim.scene["geometry.rim_thickness"] / 2)
    np.testing.assert_allclose(rim.poses(np.zeros(1))[0][:, 0], [rim.radius + mean[0] - nearer, mean[1]], rtol=0, atol=5e-9)
    narrow = RimShape.read(assembled, rim.scene | {"load.spline_width": 4e-3}).poses(np.zeros(1))[0][0, 0]
    amid = np.interp(np.linspace(2.5e-3, 6.5e-3, 4001), x[on, 2][order], u[on][order][:, 0]).mean()
    assert narrow == pytest.approx(rim.radius + amid, rel=0, abs=1e-9)
    w, r, t = 1e-3, 18e-3, np.linspace(0, 6, 30)
    shape = RimShape(r, np.array([[0, 0, w / 2], [0, 0, 0]], complex))     # r + w cos 2t
    points, normals = shape.poses(t)
    np.testing.assert_allclose(points, (r + w * np.cos(2 * t)) * [np.cos(t), np.sin(t)], atol=1e-15)
    slope = np.array([-2 * w * np.sin(2 * t) * np.cos(t) - (r + w * np.cos(2 * t)) * np.sin(t),
                      -2 * w * np.sin(2 * t) * np.sin(t) + (r + w * np.cos(2 * t)) * np.cos(t)])
    np.testing.assert_allclose((normals * slope).sum(axis=0), 0, atol=1e-15)
    np.testing.assert_allclose(np.hypot(*normals), 1)


def test_gaps_on_the_rim_of_a_run(assembled, tmp_path, capsys):
    """The assembled rim stands further out than the cam alone says: teeth made for the cam interfere, others keep what is asked. Runs that do not serve are refused."""
    ideal = tooth_gaps(Involute(M), SCENE)
    tight, free = tooth_gaps(Involute(M, x2=ideal.facts["x2"]), assembled), tooth_gaps(Involute(M), assembled)
    assert tight.least_m < -1e-6 and "interfere" in tight.notes[0] and free.least_m == pytest.approx(0, abs=1e-8)
    assert free.facts["x2"] > ideal.facts["x2"] and free.table["gap_m"].max() > 5e-6
    half = len(free.table["pair"]) // 2
    ends = [min(free.table[name][which].min() for name in ("gap_m", "gap_back_m")) for which in (slice(half), slice(half, None))]
    assert min(ends) > -1e-11 and abs(ends[1] - ends[0]) > 1e-8 and not free.notes     # 21 balls hold both ends of the long axis unlike
    with pytest.raises(hdengine.InputError, match=r"wave_generator.w with the run .* valid: keys of load"):
        tooth_gaps(Involute(M), assembled, wave_generator={"w": 1e-4})
    copy = tmp_path / "c"
    shutil.copytree(assembled, copy)
    grid = next(copy.glob("bodies_*.vtu"))
    whole = grid.read_bytes()
    grid.write_bytes(whole[:60000])
    assert main(["teeth", str(copy), "--profile", "involute", "--module", str(M)]) == 3 and "is cut short: run the scene again" in capsys.readouterr().err
    grid.write_bytes(whole.replace(b'Name="torque_nm" NumberOfTuples="1" format="ascii">0.0', b'Name="torque_nm" NumberOfTuples="1" format="ascii">5.0'))
    with pytest.raises(hdengine.InputError, match=r"has grids at 5 N m: must have one of the whole assembly at 0 N m"):
        tooth_gaps(Involute(M), copy)


def test_teeth_stand_on_a_rim_that_keeps_its_length(tmp_path):
    """At ratio 30 of size 20 the cam's curve leaves its first order by up to w^2/R = 36 um, which a run of small displacements lacked: its clearances were
    off by up to 6 um from those on the rim of large displacements. They agree within 1.6 um of 2 to 78, the mean radii within a tenth."""
    scene = hdengine.as_built(20, 30, mesh={"divisions": 44, "band_facets": 4})
    load = {key: value for key, value in scene["load"].items() if "tooth_gaps" not in key}
    scene |= {"loop": {"torques": "0,0"}, "load": load | {"torque_steps": 1}, "run": {"band": False}, "output": {"vtu": "last"}}
    found = {}
    for kinematics in ("linear", "nonlinear"):
        hdengine.run("", tmp_path / kinematics, show=False, **scene, solver__kinematics=kinematics)
        rim = Rim.read(tmp_path / kinematics)
        found[kinematics] = (tooth_gaps(Involute(2.54e-3 * 20 / 60), tmp_path / kinematics, least_gap=1.2e-6), rim.shape.harmonics[:, [0, 4]])
    (small, few), (large, many) = found.values()
    for name in ("gap_m", "gap_back_m"):
        np.testing.assert_allclose(small.table[name], large.table[name], rtol=0, atol=1.6e-6)
    u, v = RimShape.read(tmp_path / "linear", hdengine.read_scene(tmp_path / "linear/echo.nml")).harmonics[:, [0, 4]]
    r = rim.radius - scene["geometry"]["rim_thickness"] / 2
    assert few[0, 0] - u[0] == pytest.approx(-9 / 16 * scene["wave_generator"]["w"] ** 2 / r, rel=0.02)
    assert abs(few - many)[0, 0] < 0.15 * abs(u[0] - many[0, 0])


def test_interference_is_told():
    """A space that is too narrow gives negative clearances, a note, and clearances of 0 in the scene."""
    found = tooth_gaps(Involute(M, x2=1.9), SCENE)
    assert found.table["gap_m"].min() < -1e-6 and "pairs interfere, by up to" in found.notes[0] and found.notes[0] in str(found)
    assert min(found.keys()["load.tooth_gaps"]) == 0
    assert "below the bottom" in tooth_gaps(Involute(M, dedendum=0.7, x1=1.8), SCENE).notes[-1]


def test_command(tmp_path, capsys):
    """`hdengine teeth` writes table, lines, figure and record; options of the other profile and earlier results are refused."""
    words = ["teeth", str(SCENE), "--profile", "involute", "--module", str(M), "--out", str(tmp_path / "t")]
    assert main([*words, "load.tooth_pairs=20"]) == 0
    assert "lines for the scene, under &load:\n  tooth_pairs = 20\n" in capsys.readouterr().out
    record = json.loads((tmp_path / "t/gaps.json").read_text())
    assert record["status"] == "complete" and record["parameters"]["module"] == M and (tmp_path / "t/gaps.png").stat().st_size > 10000
    assert len(read_csv(tmp_path / "t/gaps.csv")["gap_m"]) == 20 and (tmp_path / "t/gaps.nml").read_text().startswith("  tooth_pairs")
    assert main(words) == 3 and "add --force" in capsys.readouterr().err
    assert main([*words, "--force", "--convex-radius", "1.4"]) == 2
    assert "--convex-radius with --profile involute: valid: --module" in capsys.readouterr().err
    assert main([*words[:2], "w", *words[2:], "--force"]) == 2 and "is no assignment" in capsys.readouterr().err
