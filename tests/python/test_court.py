# SPDX-License-Identifier: GPL-3.0-or-later
"""Problems that others have defined and solved: court/ on meshes that take a second each."""
import importlib
import sys

import numpy as np
import pytest

from conftest import ROOT
from hdengine import HdengineError

sys.path.insert(0, str(ROOT / "court"))


@pytest.mark.parametrize("name", ["block_on_slope", "plate_with_friction", "patch_tests", "two_spheres"])
def test_court(name):
    """The engine's answers agree with the published ones within the tolerance of their source."""
    for row in importlib.import_module(name).rows():
        assert row.verdict == "agrees", (row.quantity, row.reference, row.ours)


def test_stick_zone_of_a_punch():
    """The stick zone under a flat punch is the one of a boundary integral, which itself keeps Spence's relation where shear leaves the pressure alone."""
    punches = importlib.import_module("punches")
    for friction in (0.2, 0.4):
        assert punches.by_boundary_integral(friction, 0.3, coupled=False) == pytest.approx(punches.spence(friction, 0.3), rel=0.015)
    assert punches.stick_zone(0.3, 0.3) == pytest.approx(punches.by_boundary_integral(0.3, 0.3), rel=0.015)


def test_load_that_varies():
    """Shear through a loop with a load that falls and rises keeps the superposition of flat punches, of which it remembers every turn."""
    loop = importlib.import_module("variable_load").solve(per_half_width=8, phase=3)
    assert loop["error"].max() < 0.06
    assert loop["ratio"].min() < -0.3 and loop["ratio"].max() > 0.35 and loop["load"].min() < 0.75


def test_distorted_patch_is_exact():
    """An even pressure passes through meshes of distorted facets that do not match, to rounding."""
    patch = importlib.import_module("patch_tests")
    for kind in ("cylinder", "ring"):
        assert patch.solve(kind)[1] < 1e-12


def test_far_sliding_is_refused(monkeypatch):
    """A block that slides farther than a facet is long gets an error that says so, not a result."""
    slope = importlib.import_module("block_on_slope")
    real = slope.solid.contact

    def far(bodies, slave, master, fixed, travel, *rest, **options):
        return real(bodies, slave, master, fixed, np.asarray(travel) * 2e3, *rest, **options)

    monkeypatch.setattr(slope.solid, "contact", far)
    with pytest.raises(HdengineError, match="slides by 0.402 m, farther than"):
        slope.solve(0.2)
