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
