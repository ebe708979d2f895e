# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and elastic bodies of the user's own: element benchmarks in small."""
import importlib.util
import sys

import numpy as np
import pytest

import hdengine
from conftest import ROOT
from hdengine import mesh, solid


def script(name):
    """A script of bench/ as a module."""
    sys.path.insert(0, str(ROOT / "bench"))
    spec = importlib.util.spec_from_file_location(name, ROOT / f"bench/{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


elements = script("elements")


def error(case, element):
    """Relative error of a benchmark case."""
    u, _ = elements.engine(case, element)
    return abs((case.probe * u).sum()) / abs(case.exact) - 1


@pytest.mark.parametrize("element", elements.OURS)
def test_patch(element):
    """Seven distorted cells carry a linear displacement field exactly, to 1e-10."""
    assert elements.patch(element) < 1e-10


@pytest.mark.parametrize("t", (0.7, 0.3))
def test_ring_at_40_divisions(t):
    """hex20r with curved sides, one through the thickness, stays within 0.1 % of Michell's ring at 40 divisions."""
    assert abs(error(elements.ring_harmonic(True, t, 40), "hex20r")) < 1e-3
    assert abs(error(elements.ring_forces(True, t, 40), "hex20r")) < 1e-3


def test_ring_order():
    """hex8i converges on the thin ring, once resolved, with order 2, and is 4 % off at 40 divisions at the most, 1 % at 80."""
    first, coarse, fine = (abs(error(elements.ring_harmonic(False, 0.3, n), "hex8i")) for n in (40, 80, 160))
    assert first < 0.04 and coarse < 0.01 and 3.5 < coarse / fine < 5


def test_michell_agrees_with_thin_ring_theory():
    """The closed solution tends to the inextensible thin ring as t goes to 0."""
    r, t, e = 1.0, 1e-3, 1.0
    thin = r**4 / (9 * e * t**3 / 12)  # plane stress: p r^4 / (9 E I) for cos 2 theta
    assert elements.harmonic(2, r - t / 2, r + t / 2, e, 0.0, True) / thin == pytest.approx(1, abs=3e-3)
    assert elements.opposite_forces(r - t / 2, r + t / 2, e, 0.0) / (-(2 / np.pi - 0.5) * r**3 / (e * t**3 / 12) / 2) == \
        pytest.approx(1, abs=3e-3)


def test_twisted_beam():
    """hex8i and hex20r stay within 1.5 % and 0.7 % of MacNeal and Harder's twisted beam."""
    for out in (0, 1):
        assert abs(error(elements.twisted(False, (12, 2, 1), out), "hex8i")) < 0.015
        assert abs(error(elements.twisted(True, (12, 2, 1), out), "hex20r")) < 0.007


def test_cup():
    """A clamped tube under cos 2 theta at its mouth: hex20r, one through the wall, within 0.2 % of Sanders and Koiter's shell."""
    assert abs(error(elements.cup(True, 40, 8), "hex20r")) < 2e-3


def test_a_body_that_is_not_held_is_an_error():
    """Missing supports are named, not solved."""
    body = solid.Body(mesh.block([0, 1], [0, 1], [0, 1, 2]), 1.0, 0.3)
    force = np.ones((12, 3))
    with pytest.raises(hdengine.LinearSolverError, match="not held"):
        solid.static([body], np.zeros((12, 3), bool), force=force)


@pytest.mark.parametrize(("free", "push", "words"), [(False, 0.0, None), (True, 1.0, "neither its supports nor the contact hold it"),
                                                      (True, -1e3, "neither its supports nor the contact hold it")])
def test_a_block_beside_another(free, push, words):
    """A block that is moved without touching is in balance, whatever rounding leaves over no force; one that nothing holds is said to move
    away, and not told to take smaller steps."""
    x = np.linspace(0, 1, 4)
    low, top = mesh.block(x - 1, x, x), mesh.block(x, x, x)
    points, n = np.vstack([low.points, top.points]), len(low.points)
    touching, end = abs(points[:, 0]) < 1e-12, points[:, 0] == 1
    fixed = np.repeat((points[:, [0]] == -1) | (end[:, None] & (not free)), 3, axis=1)
    faces = [solid.Face(k + block.facets(touching[k:k + n]), points[:, 1:]) for k, block in ((0, low), (n, top))]
    arguments = [solid.Body(low, 2e11, 0.3), solid.Body(top, 2e11, 0.3)], *faces, fixed, np.where(end[:, None], [1e-3, 2e-4, 1e-5], 0)
    options = {"gap": np.full(len(points), 1e-2), "force": np.where(end[:, None], [push, 0, 0], 0.0)}
    if words:
        with pytest.raises(hdengine.NotConvergedError, match=words):
            solid.contact(*arguments, **options)
    else:
        assert abs(solid.contact(*arguments, **options).traction).max() == 0


def test_an_unknown_element_is_an_error():
    """The valid names are listed."""
    body = solid.Body(mesh.block([0, 1], [0, 1], [0, 1]), 1.0, 0.3)
    with pytest.raises(hdengine.InputError, match="hex8, hex8i, hex20r"):
        solid.static([body], np.ones((8, 3), bool), element="tet4")


def test_blocks_join_and_show_their_sides():
    """Two quadratic blocks merge their common face; the boundary facet count is that of the union."""
    joined = mesh.merge(mesh.block([0, 1], [0, 1], [0, 1], True), mesh.block([1, 2], [0, 1], [0, 1], True))
    assert len(joined.points) == 32
    assert joined.facets(joined.points[:, 1] == 0).shape == (2, 8)


def test_a_solid_problem_knows_its_fields():
    """A field that does not exist is an internal error, put or asked for; one of the wrong size and a problem that is closed are
    errors of the input."""
    from hdengine.solid import _Problem

    with _Problem("hex8", angle=[0.0] * 8) as problem:
        with pytest.raises(hdengine.InternalError, match="no field 'angel'"):
            problem.put("angel", [0.0])
        with pytest.raises(hdengine.InternalError, match="no field 'openning'"):
            problem.get("openning")
        with pytest.raises(hdengine.InputError, match="'cell_end' of a solid problem has 0 numbers"):
            problem.solve()
    with pytest.raises(hdengine.InputError, match="closed"):
        problem.solve()


def test_names_of_numbers_fail_loudly():
    """A list of numbers for the engine takes exactly the names of the list: a misspelt, a missing and an unknown one are internal
    errors."""
    from hdengine import _engine

    given = dict.fromkeys(_engine.names("joint"), 1.0)
    assert _engine.named("joint", **given).tolist() == [1.0] * len(given)
    with pytest.raises(hdengine.InternalError, match="differ by palstic"):
        _engine.named("joint", **given, palstic=1.0)
    del given["plastic"]
    with pytest.raises(hdengine.InternalError, match="differ by plastic"):
        _engine.named("joint", **given)
    with pytest.raises(hdengine.InternalError, match="no list of names 'wrong'"):
        _engine.names("wrong")
