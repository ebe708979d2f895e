# SPDX-License-Identifier: GPL-3.0-or-later
"""The charts of bench/pareto.py: for each family of methods one problem, and the error and time of each method on it."""
import json
import shutil
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

import numpy as np

from common import ROOT, solve, take_turns
from hdengine import Joint
from hdengine.surfaces import roughness

sys.path.append(str(ROOT / "court"))
STIFFNESS = 1e7   # of CalculiX's penalty [N/mm3]: fifty moduli over a millimetre
TURNED = 0.3      # angle by which the outer ring is turned: no mesh matches [rad]
PATIENCE = 60     # CPU seconds for one run of a peer
NOTHING = 1e3     # error drawn for a run that ended without a result


@dataclass
class Point:
    """One run of a method: relative error, CPU seconds."""

    method: str
    setting: str
    error: float
    seconds: float
    default: bool = False
    peer: bool = False


@dataclass
class Chart:
    """A family of methods on one problem."""

    name: str
    title: str
    decides: str
    points: list


def relative(value, truth):
    """Relative error, not below rounding."""
    return float(max(abs(value / truth - 1), 1e-16))


def heights(_):
    """Eq. 1 on 512 x 512 points, 160 waves."""
    from height_peers import LENGTH, candidates, fitting, spectrum

    from hdengine import surface
    n = 512
    s = spectrum(n, 160)
    h, step = LENGTH / n, n // 64
    exact = surface.generate(64, h * step, **s, method="direct")
    w = surface.waves(**s)

    def error(z):
        """Root mean square error over that of the heights, not below rounding."""
        return float(max(np.sqrt(np.mean((z[::step, ::step] - exact) ** 2)) / exact.std(), 1e-16))

    calls = {("direct sum", "rounding", ""): lambda: surface.generate(n, h, **s, method="direct"),
             ("matrix product", "rounding", ""): lambda: surface.generate(n, h, **s, method="product")}
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        for name, method in (("matrix product", "product"), ("NUFFT", "nufft")):
            for kind, told in (("float64", ""), ("float32", ", single")) if tolerance >= 1e-6 else (("float64", ""),):
                calls[name + told, f"{tolerance:g}", ""] = \
                    lambda t=tolerance, m=method, k=kind: surface.generate(n, h, **s, tolerance=t, method=m, dtype=k)
        try:
            for peer, makers in candidates(w, n, tolerance).items():
                call, _ = fitting(makers, lambda z: error(z + w["offset_m"]), tolerance)
                name = ("FINUFFT" if peer.startswith("finufft") else "numpy product") + (", single" if "single" in peer else "")
                if call:
                    calls[name, f"{tolerance:g}", peer] = lambda c=call: c() + w["offset_m"]
        except ImportError:
            pass
    seconds, found = take_turns(calls, turns=5, limit=20, clock=time.process_time)
    best = {}   # of the ways to use a peer
    for key in calls:
        other = best.setdefault(key[:2], key)
        best[key[:2]] = min(key, other, key=lambda k: median(seconds[k]))
    points = [Point(name, setting, error(found[key]), median(seconds[key]), default=key == ("matrix product", "rounding", ""), peer=bool(key[2]))
              for (name, setting), key in best.items()]
    return Chart("heights", f"Heights of Eq. 1, {n} x {n} points, 160 waves",
                 "Matrix product and NUFFT reach any tolerance; the engine takes the cheaper one, and each peer its fastest use.", points)


def elements(quick):
    """A thin ring under cos 2 theta, one cell through 0.3 mm (Michell's solution)."""
    import elements as cases
    kinds = (("hex8", False, "C3D8"), ("hex8i", False, "C3D8I"), ("hex20r", True, "C3D20R"))
    points = []
    for kind, quadratic, peer in kinds:
        for divisions in (40, 80, 160) if quick else (20, 40, 80, 160, 320):
            case = cases.ring_harmonic(quadratic, 0.3, divisions)
            best = min((cases.engine(case, kind) for _ in range(3)), key=lambda r: r[1])
            points.append(Point(kind, str(divisions), relative((case.probe * best[0]).sum(), case.exact), best[1],
                                default=kind == "hex8i" and divisions == 80))
            if shutil.which("ccx") and divisions <= 160:
                with tempfile.TemporaryDirectory() as folder:
                    u, seconds = cases.calculix(case, peer, Path(folder))
                points.append(Point(f"CalculiX {peer}", str(divisions), relative((case.probe * u).sum(), case.exact), seconds, peer=True))
    return Chart("elements", "Ring of 0.3 mm under cos 2θ, one cell through the wall",
                 "hex8i is the default: hex20r is more accurate for one body, but costs more in contact.", points)


def press_fit(quick):
    """Lame's press fit of two rings whose meshes do not match: root mean square of the radial displacement at the interface."""
    import closed_solutions
    import peer_contact
    points = []
    for element, solid_name in (("hex8i", "C3D8I"), ("hex20r", "C3D20R")):
        for n in (24, 48) if quick else (24, 48, 96):
            outer, setting = round(1.5 * n), f"{n} / {round(1.5 * n)}"
            start = time.process_time()
            found = closed_solutions.lame(n, outer, element, layers=n // 8, start=TURNED)
            points.append(Point(f"mortar, {element}", setting, float(found["displacement_rms"]), time.process_time() - start,
                                default=element == "hex8i" and n == 48))
            for method in ("n2s", "s2s", "mortar") if shutil.which("ccx") and n <= 48 else ():
                # n2s reads no *CLEARANCE; s2s takes whichever errs less, the interference told or as shape
                tried = [peer_contact.press_fit(method, told, n, outer, element, n // 8, TURNED, stiffness=STIFFNESS, limit=PATIENCE)
                         for told in {"n2s": (False,), "s2s": (True, False), "mortar": (True,)}[method]]
                answer, error = min(tried, key=lambda f: np.nan_to_num(f[1], nan=NOTHING))
                points.append(Point(f"CalculiX {method}, {solid_name}", setting, error if answer.done else NOTHING, answer.seconds, peer=True))
    return Chart("press_fit", "Press fit of two rings, meshes 1 : 1.5, displacement",
                 "Mortar contact keeps the order of the elements on meshes that do not match; node to surface (n2s) and surface to surface contact (s2s) "
                 "of CalculiX ride on the corners of the facets.", points)


def scene_runs(settings, truth_keys, quantities, base, method_of, default=None, scene="cd14.nml"):
    """Points of runs of a scene against a reference run: the largest relative error of some results."""
    def values(summary):
        return np.array([summary["results"][q] for q in quantities])

    reference, _ = solve(scene, *base, *truth_keys)
    if reference["status"] != "complete":
        raise RuntimeError(f"the reference run {truth_keys} ended as {reference['status']}")
    truth, points = values(reference), []
    for setting, keys in settings.items():
        summary, command = solve(scene, *base, *keys)
        if summary is None or summary["status"] != "complete":
            continue
        error = float(max(np.abs(values(summary) / truth - 1).max(), 1e-16))
        points.append(Point(method_of(setting), setting, error, command.cpu_s, default=setting == default))
    return points


def solvers(quick):
    """Every linear solver on one scene, against the default to a residual of 1e-12."""
    base = ["mesh.divisions=64", "mesh.band_facets=10", "load.assembly_steps=2", "load.torque_steps=2", "solver.tolerance=1e-10"]
    settings = {"condensed by harmonics": [], "Newton matrix, exact factors (MUMPS)": ["solver.method=newton", "solver.factors=exact"],
                "Newton matrix, harmonics and GMRES": ["solver.method=newton", "solver.factors=harmonic"]}
    points = scene_runs(settings, ["solver.tolerance=1e-12"], ["rotation_rad", "normal_force_n", "pressure_max_pa"], base[:-1],
                        lambda s: s, "condensed by harmonics")
    return Chart("solvers", "Linear solvers, 64 x 10 facets of CD-14-100, same residual",
                 "All solve one problem; the condensation is the fastest and the smallest.", points)


def meshes(quick):
    """Normal force and K_TS by the paper's law over the rows of facets, with and without short cells at the edges."""
    rows = (6, 10, 16, 24) if quick else (6, 10, 16, 24, 36)
    base = ["load.support=hub", "wave_generator.ring_tangent=auto", "load.assembly_steps=1", "load.torque_steps=1", "mesh.through_ring=2", "mesh.through_wall=2"]
    settings = {}
    for r in rows:
        settings[f"{r} equal rows"] = [f"mesh.band_facets={r}", f"mesh.divisions={4 * round(5.75 * r / 4)}"]
        settings[f"{r} rows, edge cells"] = [*settings[f"{r} equal rows"], f"mesh.edge_length={0.36e-3 / r:.3g}"]
    finest = ["mesh.band_facets=64", "mesh.divisions=368", "mesh.edge_length=4e-6"]
    points = scene_runs(settings, finest, ["normal_force_n", "k_ts_nm_per_rad"], base,
                        lambda s: "edge cells" if "edge" in s else "equal rows", "16 equal rows", "paper.nml")
    return Chart("meshes", "Mesh of the band: worst of force and K_TS (Eq. 45)",
                 "Equal rows err by some ten per cent in Eq. 45 at any affordable size, and cells shortened towards the edges by 2 %.", points)


def planner(quick):
    """Tolerance asked, error reached and time of planned runs, result by result: CD-14-100, K_FTS of a cup against its teeth."""
    import promised as promises
    points, beyond = [], []
    for data, tolerances in (("cd14.nml", (0.05, 0.02)),) if quick else (("cd14.nml", (0.05, 0.02, 0.01)), ("teeth.nml", (0.05,))):
        row = {"data": data, "keys": {} if data == "teeth.nml" else {"solver.kinematics": "linear"}}
        with tempfile.TemporaryDirectory() as folder:
            row["runs"] = [promises.planned(data, row["keys"], tolerance, Path(folder), promises.TEETH_MB) for tolerance in tolerances]
            promises.judge(row, Path(folder))
        for run in promises.judged(row):
            asked = f"{100 * run['tolerance']:g} % asked"
            errors = {n: e for n, e in run["true_error"].items() if data == "cd14.nml" or n == "k_fe_secant_nm_per_rad"}
            points += [Point(promises.NAMES[n], asked, max(e, 1e-6), run["seconds"], default=n == "k_ts_bonded_nm_per_rad") for n, e in errors.items()]
            beyond += [f"{promises.NAMES[n]} at {100 * run['tolerance']:g} %" for n, e in errors.items() if e > run["tolerance"]]
            if data == "cd14.nml":
                points.append(Point("tolerance asked", asked, run["tolerance"], run["seconds"], peer=True))
    return Chart("planner", "Planned runs: error of the promised limits",
                 f"The plan keeps the tolerance that is asked with the smallest mesh it can; broken here: {', '.join(beyond) or 'none'}.", points)


def fit(quick):
    """D of maps made by another generator, told nothing about them: root mean square error over seeds."""
    from blind_generators import field
    points, kinds = [], {"spectrum": None, "structure function, as in the paper": "paper"}
    for n in (64, 128) if quick else (64, 128, 256):
        maps = [(field(n, 1e-6, d, np.random.default_rng(50 + s), finer=2, probe=0.5), d) for d in (2.2, 2.5, 2.8) for s in range(4)]
        for name, model in kinds.items():
            errors, start = [], time.process_time()
            for given, d in maps:
                try:
                    found = roughness.fit(*given, model=model)
                    errors.append(found.fractal_dimension - d)
                except Exception:  # noqa: BLE001  (a method that refuses a map has no error on it)
                    errors.append(0.5)
            points.append(Point(name, f"{n} x {n}", float(np.sqrt(np.mean(np.square(errors)))), (time.process_time() - start) / len(maps),
                                default=model is None))
    return Chart("fit", "Fit of D, optics of half a spacing, generator not ours",
                 "Only the fit of the whole spectrum knows of the optics; that of the structure function reads them as a lower D.", points)


def statistical(z, dimension, band):
    """Joints of Hu et al. without yield for a map of 1 um spacing: D and band [m] as made, G of its structure function."""
    calibrated = json.loads((ROOT / "data/joint_calibration.json").read_text())["fitted"]
    lags = np.arange(1, 11)
    found = roughness.structure_function(z, 1e-6, lags)[1]
    unit = roughness.expected_structure(1e-6 * lags, dimension, 1.0, band)
    g = float(np.exp(np.log(found / unit).mean() / (2 * dimension - 4)))   # S grows with G^(2(D-2))
    joint = Joint(hardness=1e15, fractal_dimension=dimension, roughness=g)
    return {"r_m and s_min of the defaults": joint,
            "r_m and s_min fitted to other maps": replace(joint, asperity_radius=calibrated["asperity_radius_m"], s_min=calibrated["s_min_m2"])}


def joint(quick):
    """k_N of a rough joint at 3 % of contact: boundary elements over their grid, theory, and the model of Hu et al."""
    import joint_law as law

    from hdengine.elastic import stiffness_from_spectrum
    from hdengine.prediction.half_space import HalfSpace
    pixels, longest, dimension, points = 64, 64 / 6, 2.3, []   # of the coarsest grid; roll-off a sixth of the map
    z0 = 1e-7 * law.rough(pixels, 3 - dimension, longest, 4, 901)

    def finer(factor):
        """The same periodic map on a finer grid."""
        n = pixels * factor
        h, wide = np.fft.fftshift(np.fft.fft2(z0)), np.zeros((n, n), complex)
        lo = (n - pixels) // 2
        wide[lo:lo + pixels, lo:lo + pixels] = h
        return np.fft.ifft2(np.fft.ifftshift(wide)).real * factor**2

    spectrum = law.scaled(law.lattice(z0))
    pressure = law.pressures(spectrum.slope_rms, (0.03,))[0]

    def elements_of(factor):
        """k_N and seconds on a grid finer by a factor, or averaged over blocks of its inverse."""
        blocks = round(1 / factor)
        z = finer(factor) if factor >= 1 else z0.reshape(pixels // blocks, blocks, pixels // blocks, blocks).mean((1, 3))
        space = HalfSpace(z, (1e-6 / factor,) * 2, law.E_STAR, law.RATIO)
        start = time.process_time()
        k = space.normal_stiffness(space.press(pressure) > 0)
        return k, time.process_time() - start

    finest = 8 if quick else 16
    truth, _ = elements_of(finest)
    for factor in [f for f in (1, 2, 4, 8) if f < finest]:
        k, seconds = elements_of(factor)
        points.append(Point("boundary elements (tamaas)", f"{pixels * factor} x {pixels * factor}", relative(k, truth), seconds,
                            default=factor == 1))
    for factor in (1 / 2, 1 / 4):
        k, seconds = elements_of(factor)
        points.append(Point("the same, map averaged", f"{round(pixels * factor)} x {round(pixels * factor)}", relative(k, truth), seconds))
    start = time.process_time()
    for _ in range(100):
        k = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, [pressure], law.E_STAR)[0]
    points.append(Point("spectrum (theory)", "-", relative(float(k[0]), truth), (time.process_time() - start) / 100, default=True))
    for setting, joint in statistical(z0, dimension, (4e-6, longest * 1e-6)).items():
        start = time.process_time()
        for _ in range(100):
            k = joint.stiffness(np.array([pressure]))[0] / joint.reference_area
        points.append(Point("statistical (Hu et al.)", setting, relative(float(k[0]), truth), (time.process_time() - start) / 100))
    return Chart("joint", "Normal stiffness of a rough joint, 3 % of contact",
                 "The theory costs no time and errs by some per cent; the statistical model is far off for a surface to which it was not fitted.", points)


CHARTS = (elements, press_fit, meshes, solvers, planner, heights, fit, joint)
