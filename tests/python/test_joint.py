# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint model against its own limits; test_joint_oracle.py has it against 50 digits."""
import numpy as np
import pytest

import hdengine


def test_stiffness_is_independent_of_the_number_of_facets():
    """The nominal closure gives the same total for one facet as for four quarters; Eq. 28 as printed gives four times."""
    for paper, factor in ((False, 1), (True, 4)):
        joint = hdengine.Joint(paper=paper)
        whole = joint.stiffness(50e6, 1e6, 1e-6)
        quarters = joint.stiffness(np.full(4, 50e6), 1e6, 0.25e-6)
        for a, b in zip(whole, quarters):
            assert b.sum() == pytest.approx(factor * float(a), rel=1e-12)


def test_open_and_slipping_facets_have_no_tangential_stiffness():
    """No pressure: no stiffness at all. Shear at mu P: the facet slips and keeps only its normal stiffness."""
    k_n, k_t = hdengine.Joint().stiffness([0.0, -1.0, 50e6, 50e6], [0.0, 0.0, 7.5e6, 7.4e6], 1e-6)
    assert np.all(k_n[:2] == 0) and np.all(k_t[:3] == 0)
    assert np.all(k_n[2:] > 0) and k_t[3] > 0


@pytest.mark.parametrize("keys, word", [
    ({"fractal_dimension": 2.0}, "fractal_dimension"), ({"fractal_dimension": 3.0}, "fractal_dimension"),
    ({"s_min": 0.0}, "s_min"), ({"friction": -0.1}, "friction"), ({"roughness": float("nan")}, "roughness"),
])
def test_bad_parameters_are_named(keys, word):
    """Parameters out of range raise InputError with their name and what is valid."""
    with pytest.raises(hdengine.InputError, match=word):
        hdengine.Joint(**keys).stiffness(1e6)
