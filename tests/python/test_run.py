# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole runs of hdengine.x and of hdengine.Run: equilibrium, history, output, slip."""
import copy
import json
import pickle
import re

import meshio
import numpy as np
import pytest

import hdengine
from conftest import CD14, ROOT, SMALL, call, solve_small
from hdengine import _engine, uncertainty


def summary(folder):
    return json.loads((folder / "summary.json").read_text())


def test_every_step_converges(small_run):
    """Each load step ends with a relative residual below 1e-8."""
    h = hdengine.load(small_run).history
    for step in np.unique(h["step"]):
        assert h["residual"][h["step"] == step][-1] <= 1e-8


def test_forces_balance(small_run):
    """Moments and axial forces of supports and load balance to 1e-8; the facets' pressure integrates to the reaction."""
    s = hdengine.load(small_run).steps
    assert np.all(abs(s["torque_balance_nm"]) <= 1e-8 * 5)
    assert np.all(abs(s["axial_balance_n"]) <= 1e-8 * s["normal_force_n"])
    np.testing.assert_allclose(s["facet_force_n"], s["reaction_force_n"], rtol=1e-8)
    np.testing.assert_allclose(s["normal_force_n"], s["reaction_force_n"], rtol=1e-8)


def test_coulomb_holds_on_every_facet(small_run):
    """No facet pulls, and no shear exceeds mu p."""
    r = hdengine.load(small_run)
    p, t = r.contact["pressure_pa"], np.hypot(r.contact["traction_theta_pa"], r.contact["traction_z_pa"])
    assert p.min() >= 0
    assert np.all(t <= r.scene["contact.friction"] * p * (1 + 1e-6) + 1e-3)


def test_two_lobes_are_equal(small_run):
    """Without eccentricity the pressure repeats after half a turn."""
    r = hdengine.load(small_run)
    p = r.contact["pressure_pa"][-1].reshape(r.shape)
    np.testing.assert_allclose(p, np.roll(p, r.shape[0] // 2, axis=0), atol=1e-6 * p.max())


def test_eccentricity_loads_one_lobe_more(exe, tmp_path):
    """10 um towards theta = 0 raise the force there and lower it opposite; K_TS stays positive."""
    out = tmp_path / "e.out"
    r = solve_small(exe, out, "wave_generator.eccentricity=10e-6", "load.torque_steps=0")
    force = (r.contact["pressure_pa"] * r.contact["area_m2"])[-1]
    side = np.cos(r.contact["theta_rad"][-1])
    assert force[side > 0.7].sum() > 1.05 * force[side < -0.7].sum()


def test_echo_repeats_the_run_bit_by_bit(exe, small_run, tmp_path):
    """The echoed input gives the same contact table to the last digit."""
    done = call(exe, small_run / "echo.nml", "--out", tmp_path / "again.out", "-q")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "again.out/contact.csv").read_text() == (small_run / "contact.csv").read_text()


@pytest.mark.parametrize("name, folder", [("a.b.nml", "a.b.out"), (".nml", ".nml.out")])
def test_results_land_where_the_run_starts(exe, tmp_path, name, folder):
    """Without --out they are in a folder of the input's name, its extension replaced."""
    (tmp_path / name).write_text("&hd_input version = 1 /\n&load torque_steps = 1, assembly_steps = 1 /\n&mesh divisions = 16, band_facets = 3 /\n")
    (tmp_path / "here").mkdir()
    assert call(exe, tmp_path / name, "-q", cwd=tmp_path / "here").returncode == 0
    assert [path.name for path in (tmp_path / "here").iterdir()] == [folder]


def test_paths_end_with_no_blank(exe, small_run, tmp_path, monkeypatch):
    """A path that ends with a blank is refused: the engine would take the file or folder without it. An empty one is no folder of results."""
    before = (small_run / "summary.json").read_bytes()
    for words in ([f"{CD14} "], [CD14, "--out", f"{small_run} ", "--force"]):
        done = call(exe, *words, cwd=tmp_path)
        assert done.returncode == 2 and "ends with a blank" in done.stderr
    with pytest.raises(hdengine.InputError, match="no blank at its end"):
        hdengine.run(CD14, f"{small_run} ", force=True)
    monkeypatch.chdir(tmp_path)
    for act in (lambda: hdengine.run(CD14, "", force=True), lambda: hdengine.load(""), lambda: hdengine.Study().run("")):
        with pytest.raises(hdengine.InputError, match="= '': must be the path of a folder"):
            act()
    assert before == (small_run / "summary.json").read_bytes() and not list(tmp_path.iterdir())


def test_earlier_results_are_kept(exe, small_run):
    """A folder with results is refused with code 3 and left as it was; --force replaces it."""
    before = (small_run / "summary.json").read_text()
    done = call(exe, CD14, "--out", small_run)
    assert done.returncode == 3 and "--force" in done.stderr
    assert (small_run / "summary.json").read_text() == before


def test_nothing_of_an_earlier_run_stays(exe, tmp_path):
    """A press fit in the folder of a turning drive, by --force, leaves no table or grid of it, and none of a plan: what is read belongs together.
    Other files stay. Nor does a surface leave one; from files it is not read as the generated one before."""
    keys = ["mesh.divisions=16", "mesh.band_facets=2", "load.torque_steps=1", "load.assembly_steps=1"]
    assert call(exe, CD14, *keys, "--out", tmp_path / "new", "-q").returncode == 0
    for first in (["drive14.nml", "turning.positions=2", "output.vtu=all", "loop.torques=2", "run.band=.false."], ["cd14.nml", "run.tolerance=0.5",
                  "geometry.bore_radius=9e-3", "geometry.hub_radius=4e-3", "solver.kinematics=linear"]):
        assert call(exe, ROOT / "data" / first[0], *keys, *first[1:], "--out", tmp_path / "r", "--force", "-q").returncode == 0
        (tmp_path / "r/notes.csv").write_text("mine")
        assert call(exe, CD14, *keys, "--out", tmp_path / "r", "--force", "-q").returncode == 0
        assert {f.name for f in (tmp_path / "r").iterdir()} == {"notes.csv"} | {f.name for f in (tmp_path / "new").iterdir()}
    assert hdengine.load(tmp_path / "r").turning is None
    (tmp_path / "s.nml").write_text("&surface nx = 32 ny = 32 /\n")
    for folder, kept in (("s", set()), ("r", {"notes.csv"})):
        assert call(exe, tmp_path / "s.nml", "--out", tmp_path / folder, "--force", "-q").returncode == 0
        assert {f.name for f in (tmp_path / folder).iterdir()} == kept | {f.name for f in (tmp_path / "s").iterdir()}
    with pytest.raises(hdengine.FileError, match="a run of surfaces"):
        hdengine.load(tmp_path / "s")
    np.save(tmp_path / "m.npy", np.random.default_rng(1).normal(size=(40, 40)))
    found = hdengine.run_surface(tmp_path / "s.nml", tmp_path / "s", True, fit={"first_file": str(tmp_path / "m.npy"), "dx": 1e-6, "model": "none"})
    assert [s.heights.shape for s in found.specimens] == [(40, 40)]


def test_golden(small_run):
    """The small scene gives the stored results within the stored tolerances (relative; they change only with a reason)."""
    golden = json.loads((ROOT / "tests/cases/cd14_small.json").read_text())
    results = summary(small_run)["results"]
    for key, (value, tolerance) in golden["results"].items():
        assert results[key] == pytest.approx(value, rel=tolerance), key


def test_vtu_reads_back(small_run):
    """Meshio and vtk read the grids: the same nodes, displacement, pressure."""
    vtk_io = pytest.importorskip("vtk")
    r = hdengine.load(small_run)
    path = sorted(small_run.glob("contact_*.vtu"))[-1]
    mesh = meshio.read(path)
    np.testing.assert_allclose(mesh.cell_data["pressure_pa"][0].ravel(), r.contact["pressure_pa"][-1])
    reader = vtk_io.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(sorted(small_run.glob("bodies_*.vtu"))[-1]))
    reader.Update()
    grid = reader.GetOutput()
    assert 3 * grid.GetNumberOfPoints() == summary(small_run)["model"]["dof"]
    displacement = grid.GetPointData().GetArray("displacement_m")
    assert displacement.GetNumberOfComponents() == 3
    assert 1.5e-4 < max(abs(x) for x in displacement.GetRange(0)) < 3e-4
    assert grid.GetFieldData().GetArray("torque_nm").GetValue(0) == r.torque_nm[-1]
    times = [float(t) for t in re.findall(r'timestep="([^"]*)"', (small_run / "bodies.pvd").read_text())]
    np.testing.assert_allclose(times, r.steps["load_factor"] - (r.steps["phase"] == "assembly"))


def test_grids_hold_stresses(small_run):
    """Principal stresses at the nodes and at a Gauss point of each cell fall from first to third and give the von Mises stress beside them."""
    grid = meshio.read(sorted(small_run.glob("bodies_*.vtu"))[-1])
    for value, parts in ((grid.point_data["von_mises_pa"], grid.point_data["principal_stresses_pa"]),
                         (grid.cell_data["von_mises_max_of_gauss_points_pa"][0], grid.cell_data["principal_stresses_of_that_point_pa"][0])):
        a, b, c = parts.T
        assert np.all(a >= b) and np.all(b >= c) and value.max() > 1e8
        np.testing.assert_allclose(np.ravel(value), np.sqrt(((a - b)**2 + (b - c)**2 + (c - a)**2) / 2), rtol=1e-6, atol=1)


@pytest.mark.parametrize("keys", [
    ["load.torque=5"],
    ["wave_generator.eccentricity=5e-6", "wave_generator.eccentricity_angle_deg=30"],
    ["load.support=bearing", "load.torque=3"],
    ["contact.mode=frictionless"],
    ["contact.mode=bonded"],
    ["mesh.divisions=25"],
    ["mesh.through_wall=2", "mesh.through_ring=2"],
    ["mesh.ring_divisions=20"],
    ["mesh.ring_divisions=26", "mesh.ring_facets=5"],
    ["mesh.element=hex20r", "mesh.divisions=16", "mesh.band_facets=2", "load.torque_steps=0"],
    ["mesh.ring_divisions=20", "mesh.ring_facets=3"],
], ids=lambda k: "-".join(k))
def test_condensation_changes_nothing(exe, tmp_path, keys):
    """Condensation to the face by harmonics and the sparse matrix agree to 1e-9 on every facet."""
    results = []
    for method in ("condensed", "newton"):
        order = [f"solver.method={method}", *keys] if method == "condensed" else [*keys, "solver.method=newton", "solver.factors=exact"]
        results.append(solve_small(exe, tmp_path / method, *order, "solver.tolerance=3e-11"))
    a, b = (r.contact for r in results)
    for name in ("pressure_pa", "traction_theta_pa", "traction_z_pa"):
        np.testing.assert_allclose(a[name], b[name], rtol=0, atol=1e-9 * b["pressure_pa"].max())
    assert results[0].steps["rotation_rad"][-1] == pytest.approx(results[1].steps["rotation_rad"][-1], rel=1e-7, abs=1e-15)
    assert "condensed" in results[0].summary["model"]["solver"]


def test_symmetry_changes_nothing(exe, tmp_path):
    """Quarter, half and whole face give the same tractions to 1e-9 of the peak, in assembly and torque steps."""
    results = {}
    for symmetry in ("full", "half", "quarter"):
        results[symmetry] = solve_small(exe, tmp_path / symmetry, f"solver.symmetry={symmetry}", "solver.tolerance=3e-11")
        assert results[symmetry].summary["model"]["symmetry_assembly"] == symmetry
    for symmetry in ("half", "quarter"):
        for name in ("pressure_pa", "traction_theta_pa", "traction_z_pa"):
            np.testing.assert_allclose(results[symmetry].contact[name], results["full"].contact[name], rtol=0,
                                       atol=1e-9 * results["full"].contact["pressure_pa"].max())


@pytest.mark.parametrize("keys, assembly, torque", [
    ([], "quarter", "half"),
    (["mesh.divisions=25"], "half", "full"),                      # half a turn does not map the mesh onto itself
    (["mesh.ring_divisions=25"], "half", "full"),
    (["wave_generator.eccentricity=1e-9"], "half", "full"),       # along the long axis: one mirror plane is left
    (["wave_generator.eccentricity=1e-9", "wave_generator.eccentricity_angle_deg=90"], "half", "full"),
    (["wave_generator.eccentricity=1e-9", "wave_generator.eccentricity_angle_deg=30"], "full", "full"),
    (["load.torque=1e-6"], "quarter", "half"),
    (["solver.symmetry=half"], "half", "half"),
    (["solver.symmetry=full"], "full", "full"),
], ids=lambda k: "-".join(k) if isinstance(k, list) else k)
def test_no_symmetry_is_used_that_the_scene_lacks(exe, tmp_path, keys, assembly, torque):
    """A perturbation of 1 nm or one cell more takes away exactly the symmetry that it breaks; torque takes the mirrors."""
    model = solve_small(exe, tmp_path / "s", *keys, "load.torque_steps=1").summary["model"]
    assert (model["symmetry_assembly"], model["symmetry_torque"]) == (assembly, torque)


def test_symmetry_that_is_not_there_is_refused(exe, tmp_path):
    """`solver.symmetry = quarter` in an eccentric scene: code 2 and what the scene has."""
    done = call(exe, CD14, *SMALL, "wave_generator.eccentricity=1e-9", "solver.symmetry=quarter", "--out", tmp_path / "c", "-q")
    assert done.returncode == 2 and "half" in done.stderr and "'auto'" in done.stderr


def test_summary_tells_what_was_used(small_run):
    """Solver, ordering asked and used, memory and versions are there, the status is complete."""
    s = summary(small_run)
    assert s["status"] == "complete" and s["code"] == 0
    assert s["model"]["ordering_used"] == s["model"]["ordering_asked"]
    assert s["peak_memory_mb"] > 10 and s["provenance"]["hdengine"] == hdengine.__version__
    assert s["scene"]["mesh.divisions"] == 24


def test_gross_slip_is_diagnosed(exe, tmp_path):
    """Support 'bearing', torque beyond friction: code 4, torque equal to mu int p r dA to 0.5 %, last state kept."""
    out = tmp_path / "slip.out"
    done = call(exe, CD14, *SMALL, "load.support=bearing", "load.torque=60", "--out", out, "-q")
    assert done.returncode == 4 and "gross slip at T = " in done.stderr
    s = summary(out)
    assert s["status"] == "failed" and s["code"] == 4
    r = s["results"]
    assert r["gross_slip_torque_nm"] == pytest.approx(r["friction_capacity_nm"], rel=5e-3)
    steps = hdengine.load(out).steps
    assert steps["torque_nm"][-1] == pytest.approx(r["gross_slip_torque_nm"], rel=5e-3)
    with pytest.raises(hdengine.NotConvergedError, match="gross slip"):
        hdengine.run(CD14, out=tmp_path / "py.out", mesh={"divisions": 24, "band_facets": 4},
                     load={"support": "bearing", "torque": 60, "torque_steps": 2, "assembly_steps": 1})
    assert summary(tmp_path / "py.out")["code"] == 4


def test_no_body_is_held(exe, tmp_path):
    """A clearance that the cam cannot close leaves the flexspline of a bearing support without contact: a clear message."""
    done = call(exe, CD14, *SMALL, "load.support=bearing", "wave_generator.w=0", "wave_generator.clearance=1e-4",
                "load.torque=1", "--out", tmp_path / "a.out", "-q")
    assert done.returncode == 4 and done.stderr.startswith("error: the flexspline is not held")


def test_shear_of_rounding_holds_nothing(exe, tmp_path):
    """A free flexspline without friction on an eccentric cam is not held; the load step is not cut to nothing for ever."""
    done = call(exe, CD14, "mesh.divisions=24", "mesh.band_facets=4", "contact.friction=0", "load.assembly_steps=2", "load.support=bearing",
                "wave_generator.shape=as_formed", "wave_generator.eccentricity=36e-6", "wave_generator.eccentricity_angle_deg=139",
                "geometry.ring_thickness=1.3e-4", "geometry.wall_thickness=7.2e-4", "geometry.rim_thickness=9e-4", "wave_generator.w=8.5e-5",
                "load.torque=-0.23", "output.vtu=none", "solver.time_limit_s=30", "--out", tmp_path / "b", "-q")
    assert done.returncode == 4 and "not held" in done.stderr, done.stderr


def test_python_steps_give_the_same_numbers(small_run):
    """hdengine.Run, driven step by step, repeats the run of hdengine.x."""
    table = hdengine.load(small_run)
    with hdengine.Run(CD14, mesh={"divisions": 24, "band_facets": 4}, load={"torque_steps": 2, "assembly_steps": 1}) as run:
        steps = list(run)
    assert len(steps) == len(table.steps)
    for i, step in enumerate(steps):
        np.testing.assert_allclose(step.facets["pressure_pa"], table.contact["pressure_pa"][i], rtol=1e-9, atol=1)
        assert step.k_ts_nm_per_rad == pytest.approx(table.torsional_stiffness()[0][i], rel=1e-9)


def test_a_run_has_one_handle_that_no_other_gets(tmp_path):
    """A run cannot be copied; closed, it answers with the package's error, and its handle in other hands is none of a later run's."""
    keys = {"mesh": {"divisions": 16, "band_facets": 4}, "load": {"torque_steps": 1, "assembly_steps": 1}}
    with hdengine.Run(**keys) as run:
        stale = run._handle
        for copied in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(hdengine.InputError, match="cannot be copied"):
                copied(run)
    never = hdengine.Run.__new__(hdengine.Run)   # as one whose input is wrong, in a debugger
    assert repr(never).endswith("closed") and run.done is False
    for use in (run.advance, run.step, lambda: next(iter(run)), lambda: next(iter(never))):
        with pytest.raises(hdengine.InputError, match="closed"):
            use()
    with hdengine.Run(**keys) as other:
        for name in ("run_sizes", "run_advance"):
            with pytest.raises(hdengine.InputError, match="closed"):
                _engine.call(name, stale)
        assert other._handle > stale


def test_runs_in_threads_do_not_disturb_each_other():
    """Four threads, four runs, one answer: the engine's lock holds."""
    from concurrent.futures import ThreadPoolExecutor

    def normal_force(_):
        with hdengine.Run(mesh={"divisions": 16, "band_facets": 3}, load={"torque_steps": 0, "assembly_steps": 1}) as run:
            return run.advance().sums["normal_force_n"]

    with ThreadPoolExecutor(4) as pool:
        forces = list(pool.map(normal_force, range(4)))
    assert np.ptp(forces) <= 1e-9 * forces[0]


def test_scale_of_the_iteration_does_not_matter(exe, small_run, tmp_path):
    """The rotation does not depend on numerical parameters: a hundred times stricter tolerance changes it by < 1e-6."""
    solve_small(exe, tmp_path / "s.out", "solver.tolerance=1e-10")
    a, b = (summary(f)["results"]["rotation_rad"] for f in (small_run, tmp_path / "s.out"))
    assert a == pytest.approx(b, rel=1e-6)


def test_rotation_counts_from_the_end_of_the_assembly(exe, tmp_path):
    """An assembly that turns the rim leaves nothing in the rotation, in however many steps: 1e-6 N m turn it by no more than the share of 5 N m."""
    keys = ["wave_generator.ring_tangent=follow", "wave_generator.eccentricity=10e-6", "wave_generator.eccentricity_angle_deg=30", "load.torque=1e-6"]
    done = call(exe, CD14, *SMALL, *keys, "load.assembly_steps=3", "load.torque_steps=1", "--out", tmp_path / "a", "-q")
    assert done.returncode == 0, done.stderr
    assert 0 < summary(tmp_path / "a")["results"]["rotation_rad"] < 1e-11


@pytest.mark.full
def test_quadratic_elements_agree_with_refined_linear_ones(exe, tmp_path):
    """Normal force by hex20r at 24 divisions and by hex8i at 72 agrees to 5 % (slip needs a finer face than 24)."""
    keys = {"hex20r": ["mesh.divisions=24", "mesh.band_facets=4"], "hex8i": ["mesh.divisions=72", "mesh.band_facets=12"]}
    results = []
    for element, mesh in keys.items():
        results.append(solve_small(exe, tmp_path / element, *mesh, f"mesh.element={element}").summary["results"])
    assert results[0]["normal_force_n"] == pytest.approx(results[1]["normal_force_n"], rel=0.05)


def test_meshes_that_do_not_match(exe, small_run, tmp_path):
    """A ring of 20 divisions in a cup of 24: converged, pressure integrates to the reaction to 0.1 %."""
    s = solve_small(exe, tmp_path / "n.out", "mesh.ring_divisions=20", "solver.method=newton", "solver.factors=exact").summary
    assert s["model"]["ordering_used"] == s["model"]["ordering_asked"] == "METIS (PERM_IN)"
    assert s["provenance"]["mumps"].startswith("5.")
    r = s["results"]
    assert r["facet_force_n"] == pytest.approx(r["reaction_force_n"], rel=1e-3)
    assert r["normal_force_n"] == pytest.approx(summary(small_run)["results"]["normal_force_n"], rel=0.1)


@pytest.mark.parametrize("option, word", [("--help", "usage:"), ("--version", "METIS"),
                                          ("--license", "GPL-3.0"), ("--citation", "Hu, Li, Wang, Li")])
def test_texts(exe, option, word):
    """The texts of the command line are there."""
    done = call(exe, option)
    assert done.returncode == 0 and word in done.stdout


def test_check_and_explain(exe, tmp_path):
    """--check writes nothing; --explain gives unit, default and meaning."""
    done = call(exe, "--check", CD14, cwd=tmp_path)
    assert done.returncode == 0 and "is valid" in done.stdout and not list(tmp_path.iterdir())
    done = call(exe, "--explain", "friction")
    assert done.stdout.startswith("&contact friction = 0.15")


def test_cycling_states_are_named(exe, tmp_path):
    """A pressed ring (w = 0) whose contact states run in a cycle: softened friction finds the solution and says so; without the iterations
    for it the run ends with code 4, its own message and the history."""
    keys = [*SMALL, "wave_generator.w=0", "load.torque_steps=0"]
    done = call(exe, CD14, *keys, "--out", tmp_path / "a", "-q")
    assert done.returncode == 0 and summary(tmp_path / "a")["results"]["cycles"] == 1   # of one load step
    done = call(exe, CD14, *keys, "solver.max_iterations=3", "--out", tmp_path / "b", "-q")
    assert done.returncode == 4 and "the contact states run in a cycle of 2 iterations" in done.stderr
    assert "after 3 iterations, with less friction too (raise solver.max_iterations)" in done.stderr and summary(tmp_path / "b")["code"] == 4 and (tmp_path / "b/history.csv").stat().st_size > 0


def test_softened_friction_stiffens_as_far_as_needed(exe, tmp_path):
    """Short cells at the edges (scene 26 of bench/promised.py) whose states run in a cycle: with no outer step stiffer than the
    law's own scale, as formerly, sixty iterations do not suffice, and halving the load step does not help."""
    keys = {"geometry.wall_thickness": 0.753016e-3, "geometry.rim_thickness": 0.910787e-3, "geometry.ring_thickness": 0.669676e-3,
            "geometry.band_length": 9.4901e-3, "wave_generator.w": 0.293256e-3, "wave_generator.interference": 4.69408e-6,
            "wave_generator.eccentricity": 19.6962e-6, "contact.friction": 0.222041, "mesh.divisions": 64, "mesh.band_facets": 12,
            "mesh.edge_length": 12.356901e-6, "load.assembly_steps": 1, "load.torque_steps": 0, "solver.max_cuts": 0,
            "wave_generator.ring_tangent": "follow"}
    done = call(exe, CD14, *(f"{key}={value}" for key, value in keys.items()), "--out", tmp_path / "a", "-q")
    assert done.returncode == 0 and summary(tmp_path / "a")["results"]["cycles"] > 0


@pytest.mark.parametrize("text", [
    "step,phase,x\n1,assembly,0\n2,torque,0.5\n3,torque,nan\n", "a,b\n1,2\n", "a,b\n1,1e300\n-2,1e17\n", "a,word\n1,x\n2," + 30 * "y" + "\n",
    "a,b\n1,\n2.5,3.5\n", "mesh,b\n40x8_linear,2\n", "checksum,b\n81EB,2\nA1,3\n"])
def test_tables_are_read_alike(text, tmp_path):
    """The fast reader gives the names, types and values of numpy's genfromtxt: whole numbers, words, gaps, a column that turns."""
    path = tmp_path / "t.csv"
    path.write_text(text)
    slow, fast = np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")), hdengine.table_file.read_csv(path)
    assert slow.dtype == fast.dtype
    for name in slow.dtype.names:
        np.testing.assert_array_equal(slow[name], fast[name])


@pytest.mark.parametrize("other", ["1", ""])
def test_a_whole_number_is_exact(tmp_path, other):
    """A column of whole numbers up to 2^53 - 1 is read as such; one beyond, which a double would round, leaves it a column of doubles."""
    for top, kind in ((2**53 - 1, "i"), (2**53 + 1, "f")):
        (tmp_path / "t.csv").write_text(f"a,b\n{top},{other}\n{-top},2\n")
        column = hdengine.table_file.read_csv(tmp_path / "t.csv")["a"]
        assert column.dtype.kind == kind and [*column] == pytest.approx([top, -top], rel=1e-15)


def test_a_word_among_numbers_is_refused(tmp_path):
    """A column of whole numbers that ends in a word is no table."""
    (tmp_path / "t.csv").write_text("a,b\n" + 25 * "1,2\n" + "word,3\n")
    with pytest.raises(hdengine.HdengineError, match="line 27: column a: 'word'; valid: a number"):
        hdengine.table_file.read_csv(tmp_path / "t.csv")


def test_one_step_is_read_alone(small_run, tmp_path):
    """Each step's facets found by bisection are those of the whole table, as of one that ends without a line's end."""
    run = hdengine.load(small_run)
    bare = tmp_path / "contact.csv"
    bare.write_bytes((small_run / "contact.csv").read_bytes().rstrip())
    for i, step in enumerate(run.steps["step"]):
        alone = hdengine.table_file.read_csv(bare, step=int(step))
        for facets in (run.contact_at(i), {name: alone[name] for name in alone.dtype.names}):
            assert facets.keys() == run.contact.keys() and all(np.array_equal(column[i], facets[name]) for name, column in run.contact.items())


def test_a_result_is_of_its_own_run(exe, tmp_path, monkeypatch):
    """A folder that another run was written into gives nothing of it to a result of the first; what a result has read stays, is not written into,
    and is read from where it was after the program has gone elsewhere."""
    monkeypatch.chdir(tmp_path)
    first = solve_small(exe, "a.out", "load.torque_steps=1")
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    with pytest.raises(ValueError, match="read-only"):
        first.contact_at(-1)["pressure_pa"] *= 2
    kept = first.contact_at(-1)["pressure_pa"].copy()
    solve_small(exe, tmp_path / "a.out", "load.torque_steps=1", "contact.friction=0.3", "--force")
    np.testing.assert_array_equal(first.contact_at(-1)["pressure_pa"], kept)
    for ask in (lambda: first.contact, first.gradient, first.report, lambda: first.frame("contact")):
        with pytest.raises(hdengine.FileError, match="holds another run by now"):
            ask()


def test_a_table_of_a_key_is_that_of_the_run(exe, tmp_path):
    """Joint and gradient of a run whose joint's table has changed since are refused; the summary has the table's checksum."""
    table = tmp_path / "kn.csv"
    table.write_text("pressure_pa,k_n_pa_per_m\n1e3,1e11\n1e6,1e13\n1e9,1e15\n")
    found = solve_small(exe, tmp_path / "a.out", "load.torque_steps=1", "joint.model=table", f"joint.table_file={table}")
    assert found.summary["input_files"] == {"joint.table_file": _engine.checksum(table)}
    k = found.joint.stiffness(5e6, 0.0, 1.0)[0]
    field = uncertainty.ContactField(found)
    assert field.k_ts() > 0 and k > 0
    table.write_text(table.read_text().replace("1e13", "3e13"))
    for ask in (lambda: found.joint, field.k_ts, found.gradient):
        with pytest.raises(hdengine.FileError, match="kn.csv.*is not as the run read it"):
            ask()
