# SPDX-License-Identifier: GPL-3.0-or-later
"""The element of docs/explain/new_element.md: the page's changes on a copy of the sources, its stiffness, and its error in Lame's tube."""
import re
import shutil
import subprocess

import numpy as np

from conftest import ROOT
from hdengine import mesh

PAGE = (ROOT / "docs/explain/new_element.md").read_text()
CHANGES = "".join(re.findall(r"^```diff\n(.*?)^```", PAGE, re.S | re.M))
SOURCES = ("hd_kinds.f90", "hd_gauss.f90", "hd_text.f90", "hd_error.f90", "hd_openblas.c", "hd_lapack.f90", "hd_hexahedron.f90")
PROGRAM = """program stiffness
  use hd_error, only: error_t
  use hd_hexahedron, only: element_kind, element_stiffness, elasticity_matrix
  use hd_kinds, only: dp
  implicit none
  character(len=8) :: name
  real(dp) :: poisson, x(3, 8), ke(24, 24)
  integer :: kind, status
  type(error_t), allocatable :: error
  do
    read (*, *, iostat=status) name, poisson, x
    if (status /= 0) exit
    call element_kind(trim(name), kind, error)
    if (allocated(error)) error stop
    call element_stiffness(kind, x, elasticity_matrix(210e9_dp, poisson), ke, error)
    print '(576es25.16)', ke
  end do
end program stiffness
"""


def changed_stiffness(folder):
    """Compile the changed sources in a folder.

    Returns
    -------
    callable
        Stiffness of elements (k, 24, 24) of their name, Poisson's ratio and nodes (k, 8, 3).
    """
    for room in ("fortran", "python", "tests"):
        shutil.copytree(ROOT / room, folder / room, ignore=shutil.ignore_patterns("__pycache__"))
    subprocess.run(["git", "apply", "-"], input=CHANGES, text=True, cwd=folder, check=True, env={"GIT_CEILING_DIRECTORIES": str(folder.parent), "PATH": "/usr/bin:/bin"})
    (folder / "program.f90").write_text(PROGRAM)
    blas = subprocess.run(["pkg-config", "--libs", "openblas"], capture_output=True, text=True, check=True).stdout.split()
    subprocess.run(["gfortran", "-O1", *(next((folder / "fortran").rglob(name)) for name in SOURCES), "program.f90", "-o", "stiffness", *blas], cwd=folder, check=True)

    def of(name, poisson, nodes):
        lines = "\n".join(f"{name} {poisson} " + " ".join(map(repr, map(float, x.ravel()))) for x in nodes)
        printed = subprocess.run([folder / "stiffness"], input=lines, capture_output=True, text=True, check=True).stdout
        return np.array(printed.split(), float).reshape(len(nodes), 24, 24)
    return of


def tube_error(stiffness, name, poisson, cells):
    """Displacement of the inner face of a thick tube under inner pressure, plane strain, over Lame's, less 1."""
    a, b, young, pressure = 10e-3, 20e-3, 210e9, 1e6
    grid = mesh.block(np.linspace(a, b, cells + 1), np.linspace(0, np.pi / 2, 2 * cells + 1), [0, 1e-3])
    r, angle, _ = grid.points.T
    tube = grid.warp(lambda q: np.c_[q[:, 0] * np.cos(q[:, 1]), q[:, 0] * np.sin(q[:, 1]), q[:, 2]])
    free = ~np.c_[angle > np.pi / 2 - 1e-9, angle < 1e-9, np.ones(len(r), bool)].ravel()
    force = np.zeros((len(r), 3))
    for facet in tube.facets(r < a + 1e-9):
        x = tube.points[facet]
        push = pressure * np.cross(x[2] - x[0], x[3] - x[1]) / 8
        force[facet] += push * np.sign(push @ x.mean(0))
    whole = np.zeros((free.size, free.size))
    for nodes, ke in zip(tube.cells, stiffness(name, poisson, tube.points[tube.cells])):
        dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        whole[np.ix_(dofs, dofs)] += ke
    u = np.zeros(free.size)
    u[free] = np.linalg.solve(whole[np.ix_(free, free)], force.ravel()[free])
    lame = (1 + poisson) * pressure * a / young / (b**2 - a**2) * ((1 - 2 * poisson) * a**2 + b**2)
    return np.hypot(*u.reshape(-1, 3)[r < a + 1e-9, :2].T).mean() / lame - 1
