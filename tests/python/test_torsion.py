# SPDX-License-Identifier: GPL-3.0-or-later
"""Eq. 45 and 46 against quadrature in 50 digits and closed forms."""
import numpy as np
import pytest

import hdengine
from conftest import ROOT
from hdengine import torsion


def ellipse_facet(theta, r, w, slope=0.0, homothetic=False):
    """Point, normal and area per angle and length of an elliptic cone, semi-axes r + w and r - w, at eccentric angles; homothetic: slopes in
    proportion to the semi-axes."""
    c, s, a, b = np.cos(theta), np.sin(theta), r + w, r - w
    da, db = (a * slope / r, b * slope / r) if homothetic else (slope, slope)
    n = np.stack([b * c, a * s, -(a * db * s**2 + b * da * c**2)], axis=-1)
    density = np.linalg.norm(n, axis=-1)
    return np.stack([a * c, b * s, 0 * c], axis=-1), n / density[..., None], density


@pytest.mark.parametrize("r, w, slope, homothetic, by_normal, by_shear", [
    (17.5e-3, 0.2e-3, 0.02, False, 1.5830203047683252544e2, 4.0407582451529987540e5),
    (17.5e-3, 0.2e-3, 0.02, True, 1.5830203357814135717e2, 4.0407582978458339394e5),
    (17.5e-3, 1e-3, 0.3, True, 3.7907153844433027973e3, 4.1969566940429537747e5),
    (10e-3, 0.0, 0.1, False, 0.0, 7.5774277009930918048e4)])
def test_band_agrees_with_50_digits(r, w, slope, homothetic, by_normal, by_shear):
    """K_TS of an elliptic band 6 mm wide with 3 and 2 TN/m^3 along normals and faces, by quadrature in 50 digits: 64 facets have it to 1e-12
    (the trapezoidal rule is exact), by either stiffness and by both."""
    x, n, density = ellipse_facet(2 * np.pi * np.arange(64) / 64, r, w, slope, homothetic)
    area = density * 2 * np.pi / 64 * 6e-3
    for k_n, k_t, known in ((3e12, 2e12, by_normal + by_shear), (3e12, 0, by_normal), (0, 2e12, by_shear)):
        assert torsion.torsional_stiffness(k_n * area, k_t * area, x, n) == pytest.approx(known, rel=1e-12)


def test_a_circle_has_no_normal_lever():
    """On a circle normal stiffness adds nothing, tangential stiffness adds k r^2."""
    x, n, _ = ellipse_facet(np.linspace(0, 6, 7), 17.5e-3, 0.0)
    assert torsion.torsional_stiffness(1e9, 0.0, x, n) == pytest.approx(0, abs=1e-20)
    assert torsion.torsional_stiffness(0.0, 2.0, x, n) == pytest.approx(7 * 2 * 17.5e-3**2, rel=1e-14)


def test_paper_form_is_another_quantity():
    """Eq. 45 as printed weighs the long axis with zero and gives newtons."""
    assert torsion.torsional_stiffness_paper(1.0, 1.0, np.array([0.0]), 17.5e-3, 0.2e-3) == 0
    assert torsion.torsional_stiffness_paper(0.0, 1.0, np.array([np.pi / 2]), 17.5e-3, 0.2e-3) > 0


@pytest.mark.parametrize("keys", [{}, {"contact.torque_friction": 0.3, "contact.law": "joint"}, {"joint.closure": "paper"},
                                  {"wave_generator.cone_angle_deg": 1.0, "wave_generator.shape": "as_formed"}])
def test_engine_and_python_give_one_k_ts(tmp_path, keys):
    """Eq. 45 in both readings: steps.csv, summary.json and Step.sums of a run hold what `torsion` gives from its facets, to 1e-12."""
    words = {"mesh.divisions": 20, "mesh.band_facets": 4, "load.torque_steps": 1, **keys}
    result = hdengine.run(ROOT / "data/cd14.nml", tmp_path / "r", **words)
    for ours, name in zip(result.torsional_stiffness(), ("k_ts_nm_per_rad", "k_ts_paper_n")):
        np.testing.assert_allclose(result.steps[name], ours, rtol=1e-12)
        assert result.summary["results"][name] == pytest.approx(ours[-1], rel=1e-12)
    with hdengine.Run(ROOT / "data/cd14.nml", **words) as run:
        steps = list(run)
    assert [s.sums["k_ts_nm_per_rad"] for s in steps] == pytest.approx(result.torsional_stiffness()[0], rel=1e-12)


def test_springs_in_series():
    """Eq. 46 and its inverse; a soft spring of zero stiffness makes the whole zero."""
    assert torsion.series(2.0, 2.0) == pytest.approx(1.0)
    assert torsion.series(2.0, 0.0) == 0
    assert torsion.remaining_stiffness(1.0, 2.0) == pytest.approx(2.0)


def test_inverting_the_papers_figures_is_refused():
    """K_WTS = 5294 cannot come from springs in series of which one has 1820 N m/rad."""
    with pytest.raises(ValueError, match="below each of its parts"):
        torsion.remaining_stiffness(5294, 1820.44)
