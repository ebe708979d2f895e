# SPDX-License-Identifier: GPL-3.0-or-later
"""The worked example of docs/explain/new_element.md: its changes fit the sources, and the element that they add does what the page says."""
import re
import shutil

import numpy as np
import pytest
from new_element import PAGE, changed_stiffness, tube_error

pytestmark = pytest.mark.skipif(not shutil.which("git"), reason="git applies the changes")


@pytest.fixture(scope="module")
def stiffness(tmp_path_factory):
    """Stiffness of elements (k, 24, 24) by the changed sources, of their name, Poisson's ratio and nodes (k, 8, 3)."""
    return changed_stiffness(tmp_path_factory.mktemp("element"))


def test_constant_strain_is_exact(stiffness):
    """The new element stores the exact energy of a constant strain on distorted nodes, and turns without a force."""
    cube = np.array([[0, 0, 0], [1.1, 0.1, 0], [1, 0.9, 0.2], [-0.1, 1, 0.1], [0.1, -0.1, 1], [0.9, 0.2, 1.2], [1.2, 1.1, 0.9], [0, 0.8, 1.1]])
    full, mean = (stiffness(name, 0.3, cube[None])[0] for name in ("hex8", "hex8b"))
    gradient = np.array([[1, 0.3, -0.2], [0.5, -1, 0.4], [0.1, 0.7, 0.6]])
    for g, energy in ((gradient, True), (np.array([[0, -1, 0], [1, 0, 0], [0, 0, 0]]), False)):
        u = (cube @ g.T).ravel()
        assert mean @ u == pytest.approx(full @ u, abs=1e-12 * np.abs(full).max())
        assert (u @ mean @ u > 1e6) == energy


def test_one_constraint_of_volume(stiffness):
    """As Poisson's ratio nears 0.5, one mode of the new element grows stiff, of the plain element seven or more; both have six rigid motions."""
    cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]])
    stiff, rigid = {}, {}
    for name in ("hex8", "hex8b"):
        values = np.linalg.eigvalsh(stiffness(name, 0.4999999, cube[None])[0])
        stiff[name], rigid[name] = int((values > 1e14).sum()), int((values < 1e6).sum())
    assert stiff["hex8b"] == 1 and stiff["hex8"] >= 7
    assert rigid == {"hex8": 6, "hex8b": 6}


def test_table_of_the_page(stiffness):
    """The page states the errors against Lame's tube that its element has."""
    rows = re.findall(r"^\| `(hex8\w*)` \| (\S+) % \| (\S+) % \|$", PAGE, re.M)
    assert {r[0] for r in rows} == {"hex8", "hex8i", "hex8b"}
    for name, *shown in rows:
        for poisson, percent in zip((0.3, 0.4999), shown):
            assert 100 * tube_error(stiffness, name, poisson, 4) == pytest.approx(float(percent), abs=0.006), (name, poisson)
