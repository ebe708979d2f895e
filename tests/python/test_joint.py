# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint model against 20-digit reference cases and against its own limits."""
import numpy as np
import pytest

import hdengine


def joint_of(reference, case):
    """The joint of a case."""
    i = numbers(reference["joints"][case["joint"]]["inputs"])
    return hdengine.Joint(
        e1=i["E1"], nu1=i["nu1"], e2=i["E2"], nu2=i["nu2"], nu_soft=i["nu_soft"], hardness=2.8 * i["sigma_s"], fractal_dimension=i["D"],
        roughness=i["G"], gamma=i["gamma"], asperity_radius=i["r_m"], friction=float(case.get("mu", 0.15)), s_min=float(case.get("s_min", 1e-20)))


def numbers(case):
    """The single numbers of a case."""
    return {k: float(v) for k, v in case.items() if isinstance(v, str) and k != "joint"}


def test_asperity_agrees_with_reference(reference):
    """Moduli, shape and first yield of an asperity agree with 50 digits to 1e-12."""
    for name, joint in reference["joints"].items():
        p, _, _ = joint_of(reference, {"joint": name}).asperity(depth=1e-9)
        np.testing.assert_allclose(list(p.values()), list(numbers(joint["asperity"]).values()), rtol=1e-12, err_msg=name)


def test_asperity_by_depth_agrees_with_reference(reference):
    """Area, load and stiffness at a depth follow Eq. 3-16 to 1e-12 in every regime."""
    for case in reference["by_depth"]:
        o = numbers(case)
        _, by_depth, _ = joint_of(reference, case).asperity(depth=o["eps"])
        np.testing.assert_allclose(by_depth, [o["s"], o["f"], o["k"]], rtol=1e-12, err_msg=str(case))


def test_asperity_by_area_agrees_with_reference(reference):
    """Load, normal and tangential stiffness of a spot follow Eq. 9-16, 39, 40 to 1e-12."""
    for case in reference["by_area"]:
        o = numbers(case)
        _, _, by_area = joint_of(reference, case).asperity(area=o["s"], tau=o["tau"])
        np.testing.assert_allclose(by_area, [o["f"], o["k"], o["kt"]], rtol=1e-12, err_msg=str(case))


def test_integrals_agree_with_reference(reference):
    """Loads and stiffnesses of all 16 surfaces agree with 50-digit quadrature: 1e-12, tangential 1e-11."""
    for case in reference["surfaces"]:
        o = numbers(case)
        parts = joint_of(reference, case).parts(o["s_l"], tau=o["tau"])
        assert parts["psi"] == pytest.approx(float(reference["joints"][case["joint"]]["psi"]), rel=1e-13)
        assert parts["real_area_m2"] == pytest.approx(o["S_r_smin0"], rel=1e-12)
        for key, name, tol in (("F_parts", "load_n", 1e-12), ("K_N_parts", "k_n_n_per_m", 1e-12),
                               ("K_T_parts", "k_t_n_per_m", 1e-11)):
            expected = np.array(case[key], float)
            np.testing.assert_allclose(parts[name], expected, rtol=tol, atol=tol * expected.sum(), err_msg=case["joint"] + key)


def test_psi_agrees_with_reference(reference):
    """Psi solves its transcendental equation to 1e-13, also near D = 2 and D = 3."""
    for case in reference["psi"]:
        joint = hdengine.Joint(fractal_dimension=float(case["D"]))
        assert joint.parts(1e-12)["psi"] == pytest.approx(float(case["psi"]), rel=1e-13)


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
