#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the engine is right, refuses, is slow or is wrong: maps over its hardest parameters, past their breaking points.

Usage: bench/stability.py [--quick | --draw] [MAP ...]; writes bench/results/stability.json and docs/figures/stability.png. A map that is
named is measured anew, the others keep their record; --draw measures nothing.

A scene is right when it is complete, its forces balance, and a second solver (matrix of Newton's method with exact factors, no symmetry, no
first guesses) gives the same force, peak and rotation to 1e-5 (1e-2 where one halved a load step), of a whole drive K1, K3, hysteresis and
largest forces. Heights are right when they are those of the direct sum, the joint of Hu et al. when it has a stiffness under load, the theory of
the joint within 25 % of boundary elements (refused: the planner takes those), the fit when two of three intervals hold D (refused: not fractal).
"""
import argparse
import json
import re
import textwrap
import time
import warnings
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import joint_law as law
import numpy as np
from blind_generators import field
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from common import RESULTS, new_axes, save_figure, solve, write_record
from hdengine import HdengineError, Joint, surface
from hdengine.elastic import stiffness_from_spectrum
from hdengine.prediction.choice import TRUST, choose
from hdengine.prediction.half_space import HalfSpace
from hdengine.prediction.spectrum import of_map
from hdengine.surfaces import roughness

RIGHT, REFUSED, SLOW, WRONG = "right", "refused", "slow", "wrong"
PATIENCE = 20       # CPU seconds
SEEDS = 3           # maps of a cell of the fit
COLOURS = {RIGHT: "#2e7d32", REFUSED: "#f2c14e", SLOW: "#4a78b5", WRONG: "#c62828"}
SMALL = ("--allow-implausible", "mesh.divisions=32", "mesh.band_facets=5", "load.assembly_steps=2", "load.torque_steps=2")
SECOND = ("solver.method=newton", "solver.factors=exact", "solver.symmetry=full", "solver.start=rest")
LOOP = ("--allow-implausible", "mesh.divisions=24", "mesh.band_facets=4", "load.assembly_steps=2", "load.torque_steps=4")
JUDGED = ("normal_force_n", "pressure_max_pa", "rotation_rad")
JUDGED_OF_LOOP = ("normal_force_n", "k1_nm_per_rad", "k3_nm_per_rad", "hysteresis_rad", "ball_force_max_n", "tooth_force_max_n")


def drive(*keys):
    """Verdict and words on a loop of the whole drive of size 14."""
    return scene("load.spline_root_diameter=0", "load.spline_width=0", *keys, data="drive14.nml", small=LOOP, judged=JUDGED_OF_LOOP)


def scene(*keys, data="cd14.nml", small=SMALL, judged=JUDGED):
    """Verdict and words on one scene."""
    summary, command = solve(data, *small, *keys, limit=PATIENCE)
    if command.code != 0:
        if command.code in (None, 7) or command.cpu_s >= PATIENCE:   # 7: it was told to stop
            return SLOW, f"more than {PATIENCE:.0f} s"
        words = next((line for line in command.text.splitlines() if line.strip()), "")
        return (WRONG if command.code == 1 or not words else REFUSED), f"code {command.code}: {words.strip()[:160]}"
    results = summary["results"]
    scale = max(abs(results["normal_force_n"]), 1e-3)
    if abs(results["normal_force_n"] - results["reaction_force_n"]) > 1e-6 * scale:
        return WRONG, "forces do not balance"
    second, other = solve(data, *small, *keys, *SECOND, limit=PATIENCE)
    if other.code != 0:
        return RIGHT, "balanced; the second solver gave up"
    close = 1e-5 if results["cut_backs"] == second["results"]["cut_backs"] else 1e-2   # friction along halved steps takes another path
    for name in judged:
        a, b = (r.get(name) or 0 for r in (results, second["results"]))   # a reading that the loop does not have is null
        if abs(a - b) > close * max(abs(a), abs(b)) + 1e-12 + (play(summary) if name == "hysteresis_rad" else 0):
            return WRONG, f"{name}: {a:.6g}, second solver {b:.6g}"
    return RIGHT, ""


def play(summary):
    """Angle by which the bottom is free to turn at no torque [rad], of which a run with all teeth open warns."""
    told = [re.search(r"free to turn by ([\d.e-]+) rad", line) for line in summary["warnings"]]
    return max((float(m[1]) for m in told if m), default=0.0)


def pressed_by(d):
    """Keys of an interference d [m]; below 0 it is clearance."""
    return f"wave_generator.interference={max(d, 0):.6g}", f"wave_generator.clearance={max(-d, 0):.6g}"


def friction_interference(quick):
    """Friction and interference."""
    x = [0, 0.05, 0.15, 0.5, 1, 2][:: 2 if quick else 1]
    y = [-1, -0.1, -0.01, 0, 0.01, 0.1, 1][:: 2 if quick else 1]
    return "friction", x, "interference / wall", y, lambda mu, d: scene(
        f"contact.friction={mu}", *([] if mu else ["contact.mode=frictionless"]), *pressed_by(d * 0.36e-3))


def wave_wall(quick):
    """Deformation w and wall."""
    x = [0.02e-3, 0.1e-3, 0.36e-3, 1e-3, 5e-3][:: 2 if quick else 1]
    y = [0, 0.1, 0.5, 1, 3][:: 2 if quick else 1]
    return "wall and rim / m", x, "w / wall", y, lambda t, w, *more: scene(
        f"geometry.wall_thickness={t}", f"geometry.rim_thickness={1.2 * t:.6g}", f"geometry.bottom_thickness={max(t, 0.3e-3):.6g}",
        f"wave_generator.w={w * t:.6g}", *more)


def ring_wall(quick):
    """Ring and wall."""
    x = [0.02e-3, 0.1e-3, 0.5e-3, 1e-3, 5e-3][:: 2 if quick else 1]
    y = [0.02e-3, 0.1e-3, 0.36e-3, 1e-3, 5e-3][:: 2 if quick else 1]
    return "ring / m", x, "wall / m", y, lambda r, t: scene(
        f"geometry.ring_thickness={r}", f"geometry.wall_thickness={t}", f"geometry.rim_thickness={1.2 * t:.6g}")


def eccentric(quick):
    """Eccentricity and interference."""
    x = [0, 1e-6, 1e-5, 1e-4, 1e-3][:: 2 if quick else 1]
    y = [-1e-5, 0, 1e-5, 5e-5][:: 2 if quick else 1]
    return "eccentricity / m", x, "interference / m", y, lambda e, d: scene(
        f"wave_generator.eccentricity={e}", *pressed_by(d))


def torque_steps(quick):
    """Torque through gross slip, load steps."""
    x = [0.1, 1, 5, 10, 20, 100][:: 2 if quick else 1]
    y = [1, 2, 8]
    return "torque / N m", x, "load steps", y, lambda t, s: scene(
        "load.support=bearing", f"load.torque={t}", f"load.torque_steps={s}", f"load.assembly_steps={s}")


def shapes_of_cells(quick):
    """Edge cells and meshes that do not match."""
    x = [1, 10, 100, 1000][:: 2 if quick else 1]
    y = [0.1, 0.5, 1, 2, 10][:: 2 if quick else 1]
    return "facet / edge cell", x, "divisions of ring / cup", y, lambda a, ratio: scene(
        f"mesh.ring_divisions={max(8, round(32 * ratio))}", *([f"mesh.edge_length={2.4e-3 / a:.6g}"] if a > 1 else []))


def units(quick):
    """Units: moduli and lengths."""
    x = [1e-6, 1e-3, 1, 1e3, 1e6][:: 2 if quick else 1]
    y = [1e-3, 1, 1e3]
    lengths = {"bore_radius": 17.5e-3, "wall_thickness": 0.36e-3, "rim_thickness": 0.427e-3, "rim_length": 9e-3, "rim_taper": 1e-3,
               "cup_length": 20e-3, "bottom_thickness": 0.5e-3, "hub_radius": 8e-3, "ring_thickness": 1e-3, "band_start": 0.5e-3, "band_length": 12e-3}

    def one(stress, length):
        keys = [f"geometry.{k}={v * length:.9g}" for k, v in lengths.items()]
        keys += [f"wave_generator.w={0.2e-3 * length:.9g}", f"wave_generator.interference={1e-5 * length:.9g}",
                 f"material.flexspline_e={209e9 * stress:.9g}", f"material.ring_e={219e9 * stress:.9g}",
                 f"material.yield_strength={835e6 * stress:.9g}", f"load.torque={5 * stress * length**3:.9g}", f"load.support_stiffness={100 * stress * length:.9g}",
                 f"output.positions=0,{5e-3 * length:.6g},{10e-3 * length:.6g}"]
        verdict, words = scene(*keys)
        if verdict == RIGHT:
            base, _ = solve("cd14.nml", *SMALL)
            mine, _ = solve("cd14.nml", *SMALL, *keys)
            if abs(mine["results"]["rotation_rad"] / base["results"]["rotation_rad"] - 1) > 1e-6:
                return WRONG, f"rotation {mine['results']['rotation_rad']:.6g} for {base['results']['rotation_rad']:.6g} rad"
        return verdict, words
    return "moduli times", x, "lengths times", y, one


def supports(quick):
    """Supports nearly free: their stiffness, friction."""
    x = [1e-9, 1e-3, 1, 100, 1e6, 1e12][::3 if quick else 1]
    y = [0, 0.01, 0.15, 1][::3 if quick else 1]
    return "support stiffness / (N/m)", x, "friction", y, lambda k, mu: scene(
        "load.support=bearing", f"load.support_stiffness={k}", "load.torque=1", f"contact.friction={mu}", *([] if mu else ["contact.mode=frictionless"]))


def large_displacements(quick):
    """Large displacements: deformation w and wall."""
    _, x, _, y, one = wave_wall(quick)
    return "wall and rim / m", x[:-1] if quick else x, "w / wall", y[:-1] if quick else y, lambda t, w: one(t, w, "solver.kinematics=nonlinear")


def balls_open(quick):
    """Whole drive: balls open, torque."""
    x = [-2e-5, 0, 5e-6, 2e-5, 1e-4, 4e-4][::3 if quick else 1]
    y = [0.1, 2, 14, 60][::3 if quick else 1]
    return "bearing clearance / m", x, "torque / N m", y, lambda c, t: drive(f"bearing.clearance={c}", f"load.torque={t}")


def teeth_open(quick):
    """Whole drive: teeth open, torque."""
    x = [0, 1e-5, 1e-4, 4e-4, 2e-3][::3 if quick else 1]
    y = [0.1, 2, 14, 60][::3 if quick else 1]
    return "clearance of teeth / m", x, "torque / N m", y, lambda g, t: drive(
        f"load.tooth_gaps={','.join([f'{g:g}'] * 40)}" if g else "load.tooth_clearance=0", f"load.torque={t}")


def drive_friction(quick):
    """Whole drive: friction of contact and teeth."""
    x, y = [0, 0.05, 0.15, 0.5, 1, 2][::3 if quick else 1], [0, 0.05, 0.15, 0.3, 0.5, 1][::3 if quick else 1]
    return "friction of the contact", x, "friction of the teeth", y, lambda mu, teeth: drive(
        f"contact.friction={mu}", f"load.tooth_friction={teeth}", *([] if mu else ["contact.mode=frictionless"]))


# --- surfaces and joints

def heights(quick):
    """Heights: D and gamma."""
    x = [2.0001, 2.01, 2.1, 2.5, 2.9, 2.99, 2.9999][:: 2 if quick else 1]
    y = [1.001, 1.01, 1.1, 1.5, 3, 10][:: 2 if quick else 1]

    def one(d, gamma):
        given = dict(fractal_dimension=d, roughness=2.4248e-7, gamma=gamma, length=0.5e-3, shortest_wavelength=4e-6, ridges=6, seed=2)
        start = time.process_time()
        try:
            exact = surface.generate(32, 0.5e-3 / 32, **given, method="direct")
            error = max(np.abs(surface.generate(32, 0.5e-3 / 32, **given, tolerance=tol, method=m) - exact).max() / exact.std()
                        for m, tol in (("product", None), ("nufft", 1e-9)))
        except HdengineError as trouble:
            return REFUSED, str(trouble)[:160]
        if time.process_time() - start > PATIENCE:
            return SLOW, ""
        return (RIGHT, "") if error < 1e-7 else (WRONG, f"error {error:.1e}")
    return "D", x, "gamma", y, one


def joint(quick):
    """Joint of Hu et al.: D and pressure."""
    warnings.simplefilter("ignore")
    x = [2.0001, 2.01, 2.2, 2.5, 2.8, 2.99, 2.9999][:: 2 if quick else 1]
    y = [1e3, 1e5, 1e7, 1e9][:: 2 if quick else 1]

    def one(d, p):
        try:
            found = Joint(fractal_dimension=d)
            k = np.asarray(found.stiffness([p, p * 1.001], area=1e-6)[0], float)
        except HdengineError as trouble:
            return REFUSED, str(trouble)[:160]
        if not np.isfinite(k).all() or (k < 0).any():
            return WRONG, f"K_N {k[0]:.3g}"
        if not k[0] > 0:
            told = [line for line in found.warnings(p) if "K_N = K_T = 0" in line]
            return (REFUSED, f"JointWarning: {told[0]}") if told else (WRONG, "no stiffness under load, and no word of it")
        return RIGHT, f"K_N {k[0]:.3g}"
    return "D", x, "pressure / Pa", y, one


def theory(contact):
    """A map of the theory of the joint over D (the slope of the spectrum) and roll-off, at a share of true contact."""
    def make(quick):
        x, y = [2.01, 2.1, 2.3, 2.5, 2.7, 2.9, 2.99][::3 if quick else 1], [1, 2, 4, 8][::3 if quick else 1]

        def one(d, times):
            z = 1e-7 * law.rough(256, 3 - d, 256 / times, 6, int(1000 * d) + times)
            spectrum = law.scaled(law.lattice(z))
            p = law.pressures(spectrum.slope_rms, (contact,))
            k, area, _ = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, p, law.E_STAR, 1e15)
            seen, facts = of_map(z, law.DX)
            model, reason = choose(facts, p, area, seen.waves)
            if model != "spectrum":
                return REFUSED, f"boundary elements: {reason}"
            space = HalfSpace(z, law.DX, law.E_STAR, law.RATIO)
            off = abs(np.log(k[0] / space.normal_stiffness(space.press(p[0]) > 0)))
            return (RIGHT if off <= TRUST else WRONG), f"off by {100 * off:.1f} %"
        return "D", x, "map / longest wave", y, one
    make.__name__ = f"theory_{1000 * contact:g}"
    make.__doc__ = f"Theory of the joint at {100 * contact:g} % of contact: D and roll-off."
    return make


def fit(name, values, title):
    """A map of the fit of D, told nothing, over D and what spoils maps of 128 x 128 points."""
    def make(quick):
        x, y = [2.02, 2.1, 2.3, 2.5, 2.7, 2.9, 2.98][::3 if quick else 1], values[::3 if quick else 1]

        def one(d, amount):
            warnings.simplefilter("ignore")
            said, inside, start = [], 0, time.process_time()
            for seed in range(SEEDS):
                rng = np.random.default_rng([2911, int(1000 * d), seed])
                found = roughness.fit(*field(128, 1e-6, d, rng, finer=2, **{name: amount}))
                said += [] if found.verdict == "fractal" else [found.verdict]
                inside += found.interval[0][0] <= d <= found.interval[0][1]
            if time.process_time() - start > PATIENCE:
                return SLOW, ""
            if 2 * len(said) > SEEDS:
                return REFUSED, f"not fractal: {said[0]}"
            return (RIGHT if 2 * inside > SEEDS else WRONG), f"{inside} of {SEEDS} intervals hold D"
        return "D", x, title, y, one
    make.__name__, make.__doc__ = f"fit_{name}", f"Fit of D, told nothing: D and {name}."
    return make


METHODS = (heights, joint, theory(0.01), theory(0.1), fit("noise", [0, 0.05, 0.3, 1, 3], "noise / Sq"),
           fit("probe", [0, 0.5, 2, 5, 15], "probe / spacing"))
MAPS = (friction_interference, wave_wall, large_displacements, ring_wall, eccentric, torque_steps, supports, shapes_of_cells, units, balls_open,
        teeth_open, drive_friction, *METHODS)


def measure(make, quick):
    """Record of one map, two cells at a time where each is a process of its own: limits are CPU seconds."""
    xlabel, x, ylabel, y, judge = make(quick)
    with ThreadPoolExecutor(1 if make in METHODS else 2) as pool:
        found = list(pool.map(lambda c: judge(*c), [(a, b) for b in y for a in x]))
    said = Counter(words for verdict, words in found if verdict in (REFUSED, WRONG) and words).most_common(1)
    cells = [found[i:i + len(x)] for i in range(0, len(found), len(x))]
    return {"name": make.__name__, "title": make.__doc__.strip().rstrip("."), "xlabel": xlabel, "x": x, "ylabel": ylabel, "y": y,
            "verdict": [[c[0] for c in row] for row in cells], "said": said[0][0] if said else ""}


def draw(maps):
    """Maps in one figure, four colours."""
    order = list(COLOURS)
    columns = 3
    figure, axes = new_axes(-(-len(maps) // columns), columns, figsize=(11, 3.3 * -(-len(maps) // columns)))
    for ax, m in zip(axes.flat, maps):
        grid = [[order.index(v) for v in row] for row in m["verdict"]]
        ax.pcolormesh(np.arange(len(m["x"]) + 1), np.arange(len(m["y"]) + 1), grid, cmap=ListedColormap(list(COLOURS.values())), vmin=-0.5,
                      vmax=3.5, edgecolors="white", linewidth=1.5)
        ax.set(xlabel=m["xlabel"], ylabel=m["ylabel"], title=textwrap.fill(m["title"], 30))
        ax.title.set_fontsize(10)
        ax.xaxis.label.set_fontsize(11)
        ax.yaxis.label.set_fontsize(11)
        ax.set_xticks(np.arange(len(m["x"])) + 0.5, [f"{v:g}" for v in m["x"]], fontsize=10)
        ax.set_yticks(np.arange(len(m["y"])) + 0.5, [f"{v:g}" for v in m["y"]], fontsize=10)
        ax.tick_params(axis="x", labelrotation=30)
        ax.grid(False)
    for ax in axes.flat[len(maps):]:
        ax.remove()
    figure.legend([Patch(color=c) for c in COLOURS.values()], order, loc="outside lower center", ncols=4)
    save_figure(figure, "stability", dpi=90)


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("maps", nargs="*")
    parser.add_argument("--quick", action="store_true", help="every second or third value")
    parser.add_argument("--draw", action="store_true", help="the figure from the record")
    options = parser.parse_args()
    unknown = set(options.maps) - {m.__name__ for m in MAPS}
    if unknown:
        parser.error(f"no map {', '.join(sorted(unknown))}; valid: {', '.join(m.__name__ for m in MAPS)}")
    path = RESULTS / "stability.json"
    whole = json.loads(path.read_text()) if path.exists() else {"maps": []}
    old = {m["name"]: m for m in whole["maps"]}
    if options.draw:
        draw([*old.values()])
        return
    maps = []
    for make in MAPS:
        if options.maps and make.__name__ not in options.maps:
            if make.__name__ in old:
                maps.append(old[make.__name__])
            continue
        start = time.time()
        maps.append(measure(make, options.quick))
        print(make.__name__, dict(Counter(v for row in maps[-1]["verdict"] for v in row)), f"{time.time() - start:.0f} s", flush=True)
    kept = {"commit": whole["provenance"]["commit"]} if options.maps and old else {}  # of the maps that were not measured
    write_record("stability", {"maps": maps}, **kept)
    draw(maps)


if __name__ == "__main__":
    main()
