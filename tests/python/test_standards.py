# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact against closed solutions, and what must not change a result. Finer meshes: court/closed_solutions.py."""
import csv
import json
import sys
from dataclasses import replace

import numpy as np
import pytest

from conftest import ROOT, call, solved
from hdengine import mesh, solid

sys.path.insert(0, str(ROOT / "court"))
import closed_solutions as cc  # noqa: E402


def test_hertz_line():
    """Ten cells in the half-width: half-width, peak and carried force of Hertz's line contact within 1 %."""
    r = cc.hertz_line(cc.cylinder(10))
    assert abs(r["half_width"]) < 0.01 and abs(r["peak"]) < 0.01 and r["balance"] < 1e-10


@pytest.mark.full
def test_hertz_sphere():
    """Six cells in the radius: load and peak of Hertz's point contact within 0.5 %, the radius within 1.5 %."""
    r = cc.sphere(6)
    assert max(abs(r[k]) for k in ("load", "peak")) < 0.005 and abs(r["radius"]) < 0.015


@pytest.mark.parametrize("matching", (True, False))
def test_cattaneo_mindlin(matching):
    """Stick width within 2 % at two loads; the shear after unloading and reversal follows the path, within 5 % of full slip."""
    run = cc.cylinder(10, friction=0.3, path=(0.5, 1.1, 0.0, -1.1), matching=matching)
    h, ratio = cc.hertz_line(run), run["drag"] / (0.3 * run["force"])
    full = np.linalg.norm(0.3 * h["p0"] * np.sqrt(np.maximum(0, 1 - (run["y"] / h["a"]) ** 2)))
    for s in (1, 2, 3, 4):
        if s < 3:
            width = cc.stick_width(run["y"], run["shear"][s], h["a"], h["p0"], 0.3) / h["a"]
            assert width == pytest.approx(np.sqrt(1 - ratio[s]), rel=0.02)
        exact = cc.mindlin_shear(run["y"], h["a"], h["p0"], 0.3, [ratio[s]] if s < 3 else [ratio[2], ratio[s]])
        assert np.linalg.norm(run["shear"][s] - exact) < 0.05 * full


def test_dragged_rod():
    """A rod dragged to gross slip, back, at half the pressure and forward again follows its closed loop within 0.1 % of µN."""
    r = cc.dragged_rod(50)
    assert np.nanmax(np.abs(r["force"] - r["exact"])) < 1e-3
    assert abs(r["force"][12] - 1) < 1e-7 and abs(r["force"][25] + 1) < 1e-7 and abs(r["force"][27] + 0.5) < 1e-7


@pytest.mark.parametrize("clearance, travel", ((1e-3, 4e-3), (-1e-3, 12e-3), (-1e-3, 2e-3)))
def test_pin_in_a_hole(clearance, travel):
    """Persson's pressure with clearance, with interference past separation and in full contact: within 1 % of the peak up to
    one cell before the edge, which lies within a cell of the closed solution."""
    r = cc.pin(5, "hex20r", clearance, travel, 1.3)
    cell = np.pi / 20
    inside = r["angle"] < r["exact_angle"] - cell
    assert np.abs(r["pressure"] - r["exact"])[inside].max() < 0.01 * r["exact"].max()
    assert r["closed_to"] - cell < r["exact_angle"] < r["next"] + cell


@pytest.mark.parametrize("swap", (False, True))
def test_lame_on_meshes_that_do_not_match(swap):
    """80/64, hex20r, either side slave: pressure and displacement within 0.1 % in the mean and 0.5 % at every point."""
    r = cc.lame(80, 64, "hex20r", swap=swap)
    assert abs(r["pressure_mean"]) < 1e-3 and abs(r["displacement_mean"]) < 1e-3
    assert r["pressure_worst"] < 5e-3 and r["displacement_worst"] < 5e-3


@pytest.mark.parametrize("swap", (False, True))
def test_curved_patch(swap):
    """On cylinders that do not match, hex8i, a uniform state leaves an even pressure to rounding, that of Lame within 2 %, either side slave. How
    much that is hangs on the processor's BLAS: 1e-13 to 3.5e-11 of two."""
    r = cc.lame(80, 64, "hex8i", swap=swap)
    assert r["unevenness"] < 1e-10 and abs(r["pressure_mean"]) < 0.02


def test_holding_torque():
    """The press fit turns at µ p 2 pi b^2 L, within 0.1 %, with every point slipping."""
    r = cc.holding_torque(40, 32, "hex20r")
    assert r["slipping"] and abs(r["error"]) < 1e-3 and abs(r["own"]) < 1e-10


# -- what must not change a result ------------------------------------------------------------------------------------
class Call:
    """Arguments of `solid.contact` as a case passes them."""

    def __init__(self, monkeypatch, case):
        def keep(bodies, slave, master, fixed, displacement=None, force=None, **options):
            self.bodies, self.faces, self.fixed = bodies, [slave, master], fixed
            self.u, self.options = displacement, options | {"tolerance": 1e-12}
            raise StopIteration
        with monkeypatch.context() as m:
            m.setattr(cc.solid, "contact", keep)
            with pytest.raises(StopIteration):
                case()

    def solve(self):
        return solid.contact(self.bodies, *self.faces, self.fixed, self.u, **self.options)


CASES = {
    "cattaneo": lambda: cc.cylinder(4, friction=0.3, path=(1.1, 0.0), matching=False),
    "holding torque": lambda: cc.holding_torque(40, 32, "hex8i"),
}


def compare(a, b, length=1.0, force=1.0, number=slice(None)):
    """Largest differences of displacement and traction over their peaks."""
    stress = force / length**2
    u, t = b.u[:, number] / length, b.traction[:, number] / stress
    return max(np.abs(u - a.u).max() / np.abs(a.u).max(), np.abs(t - a.traction).max() / np.abs(a.traction).max())


@pytest.mark.parametrize("name", CASES)
def test_units(monkeypatch, name):
    """Millimetres and newtons instead of metres and newtons: the same physics to 1e-8."""
    one, other = Call(monkeypatch, CASES[name]), Call(monkeypatch, CASES[name])
    other.bodies = [replace(b, mesh=mesh.Mesh(1e3 * b.mesh.points, b.mesh.cells), young=1e-6 * b.young) for b in other.bodies]
    other.faces = [solid.Face(f.facets, 1e3 * f.chart) for f in other.faces]
    other.u = 1e3 * other.u
    other.options |= {"gap": 1e3 * other.options["gap"], "period": 1e3 * other.options.get("period", 0.0)}
    assert compare(one.solve(), other.solve(), length=1e3) < 1e-8


@pytest.mark.parametrize("name", CASES)
def test_numbering(monkeypatch, name):
    """Nodes, cells and facets in another order: the same result to 1e-8."""
    rng = np.random.default_rng(7)
    one, other = Call(monkeypatch, CASES[name]), Call(monkeypatch, CASES[name])
    number, bodies, first = [], [], 0  # old -> new
    for b in other.bodies:
        new = rng.permutation(len(b.mesh.points))
        old = np.argsort(new)
        angle = np.broadcast_to(b.angle, len(new))[old]
        cells = new[b.mesh.cells]
        bodies.append(replace(b, mesh=mesh.Mesh(b.mesh.points[old], cells[rng.permutation(len(cells))]), angle=angle))
        number.append(first + new)
        first += len(new)
    number = np.concatenate(number)
    old = np.argsort(number)
    other.bodies = bodies
    other.faces = [solid.Face(number[f.facets][rng.permutation(len(f.facets))], f.chart[old]) for f in other.faces]
    other.fixed, other.u = other.fixed[old], other.u[:, old]
    other.options["gap"] = other.options["gap"][old]
    assert compare(one.solve(), other.solve(), number=number) < 1e-8


@pytest.mark.parametrize("name", CASES)
def test_turned_mesh(monkeypatch, name):
    """The whole model turned about z by 0.7 rad: the same result in its own dofs to 1e-8."""
    one, other = Call(monkeypatch, CASES[name]), Call(monkeypatch, CASES[name])
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    other.bodies = [replace(b, mesh=mesh.Mesh(b.mesh.points @ turn.T, b.mesh.cells), angle=b.angle + 0.7) for b in other.bodies]
    assert compare(one.solve(), other.solve()) < 1e-8


def test_swapped_slave(monkeypatch):
    """Slave and master swapped on meshes that do not match: four cells in the half-width:
    forces and peak within 1 % (the discretisation error)."""
    one, other = Call(monkeypatch, CASES["cattaneo"]), Call(monkeypatch, CASES["cattaneo"])
    other.faces.reverse()
    other.bodies = [replace(b, angle=np.pi) for b in other.bodies]
    other.u = other.u * [-1, -1, 1]
    a, b = one.solve(), other.solve()
    force = [np.abs(np.einsum("n,snc->sc", s.area, s.traction)) for s in (a, b)]
    assert np.abs(force[0] - force[1]).max() < 0.01 * force[0].max()
    assert abs(a.traction[..., 0].max() / b.traction[..., 0].max() - 1) < 0.01


SCENE = ("mesh.divisions=40", "mesh.band_facets=8", "output.vtu=none")


def last_step(folder):
    """Facets of the last step: pressure and shear (facets, 3) [Pa]."""
    rows = list(csv.DictReader((folder / "contact.csv").open()))
    return np.array([[float(r[k]) for k in ("pressure_pa", "traction_theta_pa", "traction_z_pa")] for r in rows
                     if r["step"] == rows[-1]["step"]])


def test_halved_load_steps(exe, tmp_path):
    """Twice as many load steps change no stress by more than 0.5 % of the peak: the friction history is resolved."""
    fields = []
    for factor in (1, 2):
        out = tmp_path / f"{factor}.out"
        solved(exe, out, ROOT / "data/cd14.nml", *SCENE, f"load.assembly_steps={3 * factor}", f"load.torque_steps={5 * factor}")
        fields.append(last_step(out))
    assert np.abs(fields[0] - fields[1]).max() < 5e-3 * fields[0].max()


def test_rotation_is_of_second_order_in_the_torque_steps(exe, tmp_path):
    """Five torque steps give the rotation of forty within 0.5 %, and halved steps quarter the error."""
    rotation = {}
    for n in (5, 10, 40):
        out = tmp_path / f"{n}.out"
        assert call(exe, ROOT / "data/peer_hub.nml", "mesh.divisions=40", f"load.torque_steps={n}", "output.vtu=none", "--out", out,
                    "-q").returncode == 0
        rotation[n] = json.loads((out / "summary.json").read_text())["results"]["rotation_rad"]
    error = [abs(rotation[n] / rotation[40] - 1) for n in (5, 10)]
    assert error[0] < 5e-3
    assert error[1] < 0.35 * error[0]


def test_newton_is_quadratic_once_the_states_are_settled(exe, tmp_path):
    """The last iteration of a step, whose linearisation had the final states, squares the residual down to rounding.

    The factor is large where a point has hardly begun to slip: the direction of its shear turns within a short slip."""
    out = tmp_path / "run.out"
    assert call(exe, ROOT / "data/cd14.nml", *SCENE, "--out", out, "-q").returncode == 0
    rows = list(csv.DictReader((out / "history.csv").open()))
    pairs = [(float(a["residual"]), float(b["residual"])) for a, b, c in zip(rows, rows[1:], rows[2:] + [{"step": None}])
             if a["step"] == b["step"] != c["step"]]
    assert sum(1e-8 < a < 1e-4 for a, _ in pairs) >= 4
    for before, after in pairs:
        assert after < 1e4 * before**2 + 1e-10, (before, after)


def test_mirrored_eccentricity(exe, tmp_path):
    """Shifting the cam towards either end of the long axis mirrors the frictionless field, to 1e-8 of the peak."""
    fields = []
    for angle in (0, 180):
        out = tmp_path / f"{angle}.out"
        solved(exe, out, ROOT / "data/cd14.nml", *SCENE, "contact.mode=frictionless", "wave_generator.eccentricity=10e-6",
               f"wave_generator.eccentricity_angle_deg={angle}", "load.torque=0")
        fields.append(last_step(out)[:, 0].reshape(40, 8))
    assert np.abs(fields[0] - np.roll(fields[1], 20, axis=0)).max() < 1e-8 * fields[0].max()
