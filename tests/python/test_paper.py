# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison with the paper: verdicts follow the figures."""
import numpy as np
import pytest

import hdengine
from conftest import ROOT
from hdengine import paper, torsion
from hdengine.figures.study import plot_study

SMALL = {"mesh.divisions": 24, "mesh.band_facets": 4, "load.assembly_steps": 1}


def curve(k, torques=paper.TORQUES_NM, **keys):
    """Rows of a curve over the torque."""
    return [{"torque_nm": t, "k_ts_nm_per_rad": v, "k_ts_paper_n": v, "pressure_long_1_pa": 90e6, "pressure_max_pa": 1e8, **keys}
            for t, v in zip(torques, k)]


def test_verdicts_follow_the_figures():
    """The paper's own figures agree, half of them is a trend, the wrong sign or a tenth of a tenth is neither."""
    stated = paper.STATED["eccentricity_percent"]
    for factor, verdict in ((1, "agrees"), (0.5, "trend agrees"), (-1, "does not agree"), (0.05, "does not agree")):
        assert paper.judge_trend(stated, factor * np.array(stated)) == verdict
    assert paper.judge_trend(stated, (-5.0, -6.6, -9.4)) == "does not agree"


def test_rows_of_the_papers_own_curves_agree():
    """Fed with the paper's figures, every row of torque, eccentricity and w says that they agree."""
    own = paper.STATED["k_ts_best_w"]
    fall = 1 + np.array(paper.STATED["eccentricity_percent"]) / 100
    rows = paper.torque_rows(curve(own))
    rise, = (r for r in rows if r.quantity == "K_TS from 1 to 5 N m")
    assert rise.verdict == "agrees" and rise.ours == rise.printed  # both columns of `curve` hold the paper's figures
    assert [r.quantity for r in paper.torque_rows(curve(own)[-1:])].count("K_TS from 1 to 5 N m") == 0  # of 5 N m alone
    key = "wave_generator.eccentricity"
    moved = curve(own, **{key: 0.0}) + curve(own * fall, **{key: 10e-6})
    assert paper.eccentricity_rows(moved)[0].verdict == "agrees"
    over = []
    for w, share in ((0.195e-3, 0.0), (0.21e-3, 1.0), (0.215e-3, 0.5)):
        over += curve(np.array(own) * (1 + share * np.array(paper.STATED["w_percent"]) / 100), **{"wave_generator.w": w})
    row, = paper.w_rows(over)
    assert row.verdict == "agrees" and row.ours.startswith("0.210 mm, ")
    for shares, why in (((0.0, 0.5, 1.0), "ours rises to the end of the range, 0.215 mm"), ((1.0, 0.5, 0.0), "ours has its maximum at an end of the range")):
        over = sum((curve(np.array(own) * (1 + 0.1 * share), **{"wave_generator.w": w}) for w, share in zip((0.195e-3, 0.21e-3, 0.215e-3), shares)), [])
        assert paper.w_rows(over)[0].because == why


def test_series_of_a_study(tmp_path):
    """The study of Fig. 10 puts K_TS and K_FTS of each torque in series, softer than both; its figure and rows are made."""
    study = hdengine.Study.read(ROOT / "data/fig10_series.toml")
    study.fixed.update(SMALL | {"load.torque_steps": 2})
    result = study.run(tmp_path / "s", show=False)
    rows = result.series()
    assert len(rows) == 4 and {r["tooth_clearance_m"] for r in rows} == {0.0, 10e-6}
    for r in rows:
        assert r["k_wts_nm_per_rad"] == pytest.approx(torsion.series(r["k_ts_nm_per_rad"], r["k_fts_nm_per_rad"]))
        assert r["k_wts_nm_per_rad"] < r["k_fts_nm_per_rad"] < r["k_ts_nm_per_rad"]
    assert plot_study(result)[0].stat().st_size > 10000
    assert [r.quantity for r in paper.of_study(result)] == ["K_WTS at 0.5 N m, theory and test", "K_WTS, highest measured"]


def test_series_of_each_point_with_its_own_contact(tmp_path):
    """Beside another swept key a point against the teeth goes with the contact of its own value: all had the K_TS of the last one. A clearance that is
    fixed is that of the rows: it was 0."""
    ends = {"load.support": ["hub", "teeth"], "contact.mode": ["frictional", "bonded"], "wave_generator.ring_tangent": ["follow", "free"]}
    study = hdengine.Study(ROOT / "data/cd14.nml", {"wave_generator.w": [0.15e-3, 0.25e-3]}, ends,
                           SMALL | {"load.torque_steps": 1, "load.tooth_clearance": 1e-5}, figure={"kind": "series"})
    result = study.run(tmp_path / "s", show=False)
    contact = {r["wave_generator.w"]: r["k_ts_nm_per_rad"] for r in result.select(5.0, load__support="hub")}
    assert len(set(contact.values())) == 2
    assert {r["wave_generator.w"]: r["k_ts_nm_per_rad"] for r in result.series()} == contact
    assert {r["tooth_clearance_m"] for r in result.series()} == {1e-5}
    assert plot_study(result)[0].stat().st_size > 10000


def test_friction_of_the_torque_step():
    """contact.torque_friction leaves the assembly as it is; when large nothing slips, and the torque turns the cup less."""
    keys = SMALL | {"load.support": "bearing", "load.torque_steps": 1, "contact.law": "joint"}
    found = []
    for friction in (0.0, 10.0):
        with hdengine.Run(ROOT / "data/cd14.nml", **keys, **{"contact.torque_friction": friction}) as run:
            found.append(list(run))
    (start, slips), (start_2, sticks) = found
    np.testing.assert_array_equal(start.facets["pressure_pa"], start_2.facets["pressure_pa"])
    assert np.count_nonzero(slips.facets["state"] == 2) > 10 > np.count_nonzero(sticks.facets["state"] == 2)
    assert sticks.sums["rotation_rad"] < slips.sums["rotation_rad"]
