# SPDX-License-Identifier: GPL-3.0-or-later
"""Uncertainty of K_TS: the cheap model is the engine's, ranges and indices answer known cases."""
import numpy as np
import pytest

import hdengine
from conftest import ROOT
from hdengine import uncertainty as u


@pytest.fixture(scope="module")
def field(small_run):
    return u.ContactField(hdengine.load(small_run))


def test_cheap_model_is_the_engine(field, small_run):
    """K_TS from stored pressures equals Eq. 45 of the run to 1e-9, and that of a run with other keys of the joint to 1e-3: the power means
    stored where contact ends are those of the first joint."""
    result = hdengine.load(small_run)
    assert field.k_ts() == pytest.approx(result.torsional_stiffness()[0][-1], rel=1e-9)
    keys = {"joint.fractal_dimension": 2.52, "joint.hardness": 2.5e9}
    fixed = {"mesh.divisions": 24, "mesh.band_facets": 4, "load.torque_steps": 2, "load.assembly_steps": 1}
    with hdengine.Run(ROOT / "data/cd14.nml", **fixed, **keys) as run:
        *_, last = run
    assert field.k_ts(**keys) == pytest.approx(last.k_ts_nm_per_rad, rel=1e-3)


def test_tornado_and_band_agree(field):
    """The tornado is sorted by width, and the band of all inputs holds the scene's value and both ends of the widest."""
    ends = u.joint_tornado(field)
    widths = [abs(b - a) for a, b in ends.values()]
    assert widths == sorted(widths, reverse=True) and set(ends) == set(u.JOINT)
    low, median, high = u.joint_band(field, draws=60)
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
    """Point 0 is the scene, each other point differs from it in one key; the tornado reads the ends back."""
    ranges = {"wave_generator.w": (0.19e-3, 0.21e-3, ""), "wave_generator.interference": (5e-6, 15e-6, "")}
    study = u.one_at_a_time(str(ROOT / "data/cd14.nml"), ranges)
    assert len(study.points) == 5
    assert [sum(p[k] != study.points[0][k] for k in ranges) for p in study.points] == [0, 1, 1, 1, 1]

    class Done:
        rows = [{"point": i, "status": "done" if i != 4 else "failed", "k_ts_nm_per_rad": float(10 + i)} for i in range(5)]

    base, ends = u.drive_tornado(Done(), ranges)
    assert base == 10 and ends["wave_generator.w"] == (11.0, 12.0) and np.isnan(ends["wave_generator.interference"][1])
