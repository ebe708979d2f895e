# SPDX-License-Identifier: GPL-3.0-or-later
"""Uncertainty of K_TS: the cheap model is the engine's, ranges and indices answer known cases."""
import numpy as np
import pytest

import hdengine
from conftest import ROOT, SMALL, solved
from hdengine import uncertainty as u


@pytest.fixture(scope="module")
def field(small_run):
    return u.ContactField(hdengine.load(small_run))


def test_cheap_model_is_the_engine(field, small_run):
    """K_TS from stored pressures equals Eq. 45 of the run to 1e-9, and that of a run with other keys of the joint to 1e-3: the power means
    stored where contact ends are those of the first joint."""
    result = hdengine.load(small_run)
    assert field.k_ts() == pytest.approx(result.torsional_stiffness()[0][-1], rel=1e-9)
    keys = {"joint.fractal_dimension": 2.312, "joint.hardness": 2.5e9}
    fixed = {"mesh.divisions": 24, "mesh.band_facets": 4, "load.torque_steps": 2, "load.assembly_steps": 1}
    with hdengine.Run(ROOT / "data/cd14.nml", **fixed, **keys) as run:
        *_, last = run
    assert field.k_ts(**keys) == pytest.approx(last.k_ts_nm_per_rad, rel=1e-3)


def test_tornado_and_band_agree(field):
    """The tornado is sorted by width, and the band of all inputs holds the scene's value and both ends of the widest."""
    ends = u.joint_tornado(field)
    widths = [abs(b - a) for a, b in ends.values()]
    assert widths == sorted(widths, reverse=True) and set(ends) == set(u.JOINT) - set(u.OF_ASPERITIES)
    low, median, high = u.bands(field, draws=60)["joint"]
    assert 0 <= low < median < high and low < field.k_ts() < high


def test_indices_of_a_known_function():
    """K = 2 x_1 + x_2 has first-order indices 0.8 and 0.2, total indices alike."""
    pytest.importorskip("SALib")

    class Known:
        def k_ts(self, **keys):
            return 2 * keys["a"] + keys["b"]

    indices = u.joint_indices(Known(), {"a": (0.0, 1.0, ""), "b": (0.0, 1.0, "")}, base=256)
    for key, expected in (("a", 0.8), ("b", 0.2)):
        first, _, total, _ = indices[key]
        assert first == pytest.approx(expected, abs=0.03) and total == pytest.approx(expected, abs=0.03)


def test_one_at_a_time_changes_one_key():
    """Point 0 is the scene, each other point differs from it in one key, at five places of its range; tornado and curves read them back,
    without a point that failed. A place that is the scene's is not solved twice."""
    ranges = {"wave_generator.w": (0.19e-3, 0.21e-3, ""), "wave_generator.interference": (5e-6, 10e-6, ""), "joint.table_file": ("a", "b", "")}
    study = u.one_at_a_time(str(ROOT / "data/cd14.nml"), ranges)
    assert [sum(p[k] != study.points[0][k] for k in ranges) for p in study.points] == [0] + 10 * [1]

    class Done:
        rows = [{"point": i, "status": "done" if i != 6 else "failed", "k_ts_nm_per_rad": float(10 + i), **study.points[i]} for i in range(11)]

    base, ends = u.drive_tornado(Done(), ranges)
    assert base == 10 and ends["wave_generator.w"] == (11.0, 14.0) and ends["wave_generator.interference"] == (15.0, 10.0)
    curves = u.drive_curves(Done(), ranges)
    x, y = curves["wave_generator.interference"]
    assert x == pytest.approx([5e-6, 7.5e-6, 8.75e-6, 10e-6]) and y == [1.5, 1.7, 1.8, 1.0]
    assert curves["joint.table_file"] == ([-1.96, 0.0, 1.96], [1.9, 1.0, 2.0])


@pytest.mark.parametrize("scene", ["cd14", "paper", "drive20", "drive20_30"])
def test_ranges_lie_about_the_scene(scene):
    """Those of CD-14 are stated; another size, surface or fit has its own about its own values, of the same relative width."""
    own = hdengine.read_scene(ROOT / f"data/{scene}.nml", joint__fractal_dimension=2.3, joint__roughness=1e-9, joint__s_min=1e-15,
                              material__yield_strength=9e8, geometry__bore_radius=0.025)
    found = u.ranges_of(own, u.JOINT | u.DRIVE)
    assert found["joint.fractal_dimension"][:2] == pytest.approx((2.288, 2.312))
    assert own["wave_generator.clearance"] == 0 or (found["wave_generator.clearance"][1] == 2 * own["wave_generator.clearance"]
                                                    and "wave_generator.interference" not in found)
    for key, (low, high, _) in found.items():
        assert low <= (own[key] or 2.52e9) <= high or key in ("joint.s_min", "wave_generator.eccentricity"), key
    for key in set(found) & {k for k in u.DRIVE if k.startswith("geometry.")}:
        assert found[key][1] / found[key][0] == pytest.approx(u.DRIVE[key][1] / u.DRIVE[key][0])
    assert u.ranges_of(hdengine.read_scene(ROOT / "data/cd14.nml"), u.DRIVE) == u.DRIVE
    assert (set(u.OF_ASPERITIES) <= found.keys()) == (own["joint.model"] == "hu2023")


def test_both_ends_of_a_hats_ranges_are_scenes():
    """What its sections settle has no range: bore, walls and length were refused at 23 points of 52, and their shares of the variance stood as 0."""
    hat = ROOT / "data/drive14_hat.nml"
    found = u.ranges_of(hdengine.read_scene(hat), u.DRIVE)
    assert "geometry.ring_thickness" in found
    for key, ends in found.items():
        assert hdengine.read_scene(hat, **{key: ends[0]})[key] < hdengine.read_scene(hat, **{key: ends[1]})[key]


def test_bands_and_shares_of_factors():
    """Two inputs that act as straight lines of +-20 and +-10 % have shares of 0.8 and 0.2 of the variance, and a band of both within their
    product; a table's band of +-30 % is drawn as its 95 %; an input whose points failed has no share."""
    ranges = {"contact.friction": (0.05, 0.15), "geometry.bore_radius": (0.9, 1.1), "joint.table_file": ("low", "high"),
              "material.ring_e": (0.5, 1.5)}
    curves = {"contact.friction": ([0.05, 0.1, 0.15], [0.8, 1.0, 1.2]), "geometry.bore_radius": ([0.9, 0.95, 1.0, 1.1], [1.1, 1.05, 1.0, 0.9]),
              "material.ring_e": ([1.0], [1.0])}
    bands, shares = u.drive_bands(u.drive_factors(curves, ranges), 10.0)
    assert shares["contact.friction"] == pytest.approx(0.8, abs=0.03) and "material.ring_e" not in shares
    assert 7.2 < bands["all"][0] < bands["friction"][0] < 8.2 and 11.8 < bands["friction"][2] < bands["all"][2] < 13.2
    joint = u.drive_factors({"joint.table_file": ([-1.96, 0.0, 1.96], [0.7, 1.0, 1.3])}, ranges)["joint.table_file"]
    assert np.quantile(joint, [0.025, 0.975]) == pytest.approx([0.7, 1.3], abs=0.03)


def test_factors_follow_a_bent_curve():
    """The monotone cubic is scipy's; an input that saturates has the variance of its own curve to 10 %, which a straight line through its
    ends exceeds by a fifth."""
    interpolate = pytest.importorskip("scipy.interpolate")
    draw = np.random.default_rng(3)
    for _ in range(50):
        x, y = np.cumsum(draw.random(draw.integers(3, 6)) + 0.01), draw.normal(size=5)
        curve, at = (x, y[:len(x)]), draw.uniform(x[0], x[-1], 200)
        np.testing.assert_allclose(u._follow(curve, at), interpolate.PchipInterpolator(*curve)(at), rtol=0, atol=1e-12)

    def saturating(friction):
        return 1 - np.exp(-np.asarray(friction) / 0.03)

    low, high, fine = 0.05, 0.15, np.linspace(0.05, 0.15, 20001)
    places = np.linspace(low, high, 5)
    factors = u.drive_factors({"contact.friction": (places, saturating(places))}, {"contact.friction": (low, high)}, 20000)
    exact = np.var(np.log(saturating(fine)))
    assert np.var(np.log(factors["contact.friction"])) == pytest.approx(exact, rel=0.1)
    assert np.var(np.log(np.interp(fine, [low, high], saturating([low, high])))) > 1.2 * exact


def test_a_table_with_a_band_widens_the_tangent(exe, tmp_path, monkeypatch):
    """`analyse` with the drive gives the tangent's ends, bands and shares; the table's own band is one of the inputs, and a softer joint
    has the smaller tangent."""
    p = np.array([1e5, 1e6, 1e7, 1e8, 4e8])
    k = 3e13 * (p / 1e7) ** 0.9
    names = "pressure_pa,k_n_pa_per_m,k_n_pa_per_m_low,k_n_pa_per_m_high,k_t_pa_per_m"
    np.savetxt(tmp_path / "k.csv", np.c_[p, k, 0.3 * k, 3 * k, 0.8 * k], delimiter=",", header=names, comments="")
    solved(exe, tmp_path / "r", ROOT / "data/cd14.nml", *SMALL, "joint.model=table", f"joint.table_file={tmp_path / 'k.csv'}", "output.vtu=none",
           "wave_generator.ring_tangent=auto")
    monkeypatch.setattr(u, "DRIVE", {"contact.friction": u.DRIVE["contact.friction"]})
    found = u.analyse(tmp_path / "r", drive=True, draws=20, sobol=0, show=False)["tangent"]
    low, high = found["drive"]["joint.table_file"]
    assert low < found["base_nm_per_rad"] < high
    assert found["bands_95_nm_per_rad"]["joint"][0] < found["base_nm_per_rad"] < found["bands_95_nm_per_rad"]["joint"][2]
    assert sum(found["shares_of_variance"].values()) == pytest.approx(1)
    assert (tmp_path / "r/tornado_tangent.png").is_file()
    assert u.table_ranges({"joint.model": "spectrum"}, tmp_path) == {}


def test_a_whole_drive_has_no_band_of_factors(exe, tmp_path, monkeypatch):
    """Of 200 drives drawn at once 95 % had a tangent of 20 to 42 kN m/rad, by factors it was 26 to 48: a whole drive has a tornado and shares, and a
    note that names what gives the band. A K_TS of 0, where every spot is plastic, is named too."""
    solved(exe, tmp_path / "d", ROOT / "tests/cases/pressed_drive.nml", "mesh.divisions=16", "mesh.band_facets=3", "load.assembly_steps=1",
           "load.torque_steps=1", "loop.torques=14", "output.vtu=none")
    monkeypatch.setattr(u, "DRIVE", {"material.ring_e": u.DRIVE["material.ring_e"]})
    found = u.analyse(tmp_path / "d", drive=True, draws=4, sobol=0, show=False)
    assert set(found["bands_95_nm_per_rad"]) == {"D and G", "joint"} and found["bands_95_nm_per_rad"]["joint"][0] == 0
    for name in ("tangent", "k2"):
        assert found[name]["bands_95_nm_per_rad"] == {} and set(found[name]["drive"]) == set(u.DRIVE)
        assert sum(found[name]["shares_of_variance"].values()) == pytest.approx(1)
    assert "run.band" in found["note"] and "no spot has stiffness" in found["note"]


def test_a_run_that_was_replaced_is_solved_anew_with_force(exe, tmp_path, monkeypatch):
    """The scenes of an earlier run in the same folder are no part of another's: a message says so, and force solves them anew."""
    monkeypatch.setattr(u, "DRIVE", {"contact.friction": u.DRIVE["contact.friction"]})

    def base(torque, **options):
        solved(exe, tmp_path / "r", ROOT / "data/cd14.nml", *SMALL, f"load.torque={torque}", "output.vtu=none", "wave_generator.ring_tangent=auto",
               "--force")
        return u.analyse(tmp_path / "r", drive=True, draws=20, sobol=0, show=False, **options)["tangent"]["base_nm_per_rad"]

    first = base(5)
    with pytest.raises(hdengine.FileError, match="another study: add --force"):
        base(4)
    assert base(4, force=True) != first
