#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shear of a joint with Coulomb friction by boundary elements, beside the law that follows from k_N alone (Ciavarella 1998, Jaeger 1998).

spot    a Hertz spot: curve and loop beside Cattaneo and Mindlin, on three grids
patch   rough patches, four surfaces, 1 to 20 % of contact: curve and loop beside the law; k_T/k_N in both directions beside
        (2 - 2 nu)/(2 - nu)
tamaas  the friction solvers of tamaas on the Hertz spot, nu = 0.5, where shear does not change the pressure
Writes bench/results/joint_shear.json and docs/figures/joint_shear.png. Usage: bench/joint_shear.py [--redraw]
"""
import argparse
import math
import time

import numpy as np
from joint_law import lattice, pressures, rough

from common import new_axes, read_record, save_figure, styled, write_record
from hdengine.elastic import ElasticJoint, moduli, stiffness_from_spectrum
from hdengine.prediction.half_space import HalfSpace, corrected_area, tamaas
from hdengine.prediction.shear import Slider
from hdengine.prediction.spectrum import Spectrum

E_STAR, RATIO = moduli(209e9, 0.295, 219e9, 0.30)
FRICTION = 0.15
LOADING = np.array([0.1, 0.25, 0.45, 0.7, 1.0, 1.4])           # displacements over that of full slip by k_T without slip
LOOP = np.array([0.8, 0.4, 0.0, -0.4, -0.8, -1.0, -0.6, -0.2, 0.2, 0.6, 1.0])   # over the one of the reversal
TURN = 0.5                                                      # the reversal over the end of the loading


def short(x):
    """Five digits."""
    return float(f"{x:.5g}")


def sphere(n, radius=2e-3, spot=14e-6, cell=96e-6):
    """Heights of a ball in a periodic cell, spacing, and the mean pressure that presses a spot of a radius."""
    x = (np.arange(n) + 0.5) * cell / n - cell / 2
    return -np.hypot(*np.meshgrid(x, x)) ** 2 / (2 * radius), cell / n, 4 * E_STAR * spot**3 / (3 * radius) / cell**2


def walk(space, pressure, load, path):
    """Shear over mu P along a path of displacements [m], and the slipping share at its points."""
    slider, found = Slider(space, pressure, FRICTION), []
    for u in path:
        found.append((slider.move(u) / (FRICTION * load), slider.slipping))
    return np.array(found).T


def masing(curve, turn, path):
    """Shear after a reversal at `turn` down to -turn and up again, by Masing's rule on the loading curve."""
    at_turn, down, found = curve(turn), True, []
    for i, u in enumerate(path):
        down = down and (i == 0 or u < path[i - 1])
        found.append(at_turn - 2 * curve((turn - u) / 2) if down else -at_turn + 2 * curve((u + turn) / 2))
    return np.array(found)


def spot():
    """Hertz spot beside Cattaneo and Mindlin: q/(mu P) over the displacement, less what the cell's other spots move it."""
    rows = []
    for n in (48, 96, 144):
        z, step, load = sphere(n)
        start = time.perf_counter()
        space = HalfSpace(z, (step, step), E_STAR, RATIO)
        pressure = space.press(load)
        area, k_t = (96e-6) ** 2, space.tangential_stiffness(pressure > 0)
        a = math.sqrt((pressure > 0).sum()) * step / math.sqrt(math.pi)
        alone = 2 * RATIO * 14e-6 * E_STAR / area
        cell = 1 / alone - 1 / k_t                  # the others' share of the compliance: they move the spot the other way
        slide = 1.5 * FRICTION * load / alone
        shares = np.array([0.2, 0.4, 0.6, 0.8, 0.95])
        u = slide * (1 - (1 - shares) ** (2 / 3)) - cell * shares * FRICTION * load
        q, slipping = walk(space, pressure, load, u)
        turned = 0.6 * np.array([0.5, 0.0, -0.5, -1.0])
        back = slide * ((1 - (1 - 0.6) ** (2 / 3)) - 2 * (1 - (1 - (0.6 - turned) / 2) ** (2 / 3))) - cell * turned * FRICTION * load
        loop = walk(space, pressure, load, [u[2], *back])[0][1:]
        rows.append({"points": n, "radius_over_hertz": short(a / 14e-6),
                     "curve_error": short(abs(q - shares).max()), "loop_error": short(abs(loop - turned).max()),
                     "slip_area_error": short(abs(slipping - (1 - (1 - shares) ** (2 / 3))).max()),
                     "seconds": short(time.perf_counter() - start)})
        print(rows[-1], flush=True)
    return rows


def law_of(space, load):
    """The law from k_N by boundary elements alone."""
    p = load * np.geomspace(1e-3, 1, 25)
    k_n = np.array([space.normal_stiffness(space.press(x) > 0) for x in p])
    return ElasticJoint(p, k_n, RATIO * k_n, FRICTION, "boundary_elements")


def patch():
    """Rough patches beside the law."""
    rows = []
    for d, roll_off, seed in ((2.2, 21, 11), (2.5, 21, 12), (2.5, 128, 13), (2.8, 21, 14)):
        z = 1e-7 * rough(128, 3 - d, roll_off, 6, seed)
        s = lattice(z)
        spectrum = Spectrum(s.q * 1e6, s.height_variance, s.modes)
        for load in pressures(spectrum.slope_rms, (0.01, 0.05, 0.2)):
            space = HalfSpace(z, (1e-6, 1e-6), E_STAR, RATIO)
            law = law_of(space, load)
            p = load * np.geomspace(1e-3, 1, 25)
            k = stiffness_from_spectrum(spectrum.q, spectrum.height_variance, p, E_STAR)[0]
            theory = ElasticJoint(p, k, RATIO * k, FRICTION, "spectrum")
            pressure = space.press(load)
            touching = pressure > 0
            k_n, k_t = space.normal_stiffness(touching), space.tangential_stiffness(touching)
            across = HalfSpace(z.T, (1e-6, 1e-6), E_STAR, RATIO).tangential_stiffness(touching.T)
            path = LOADING * 2.2 * FRICTION * load / k_t
            turn = TURN * path[-1]
            back = turn * LOOP
            start = time.perf_counter()
            q = walk(space, pressure, load, path)[0]
            loop = walk(space, pressure, load, [turn, *back])[0]
            seconds = time.perf_counter() - start

            def by(joint, load=load):
                return lambda u: joint.shear(load, u)[0] / (FRICTION * load)

            row = {"surface": f"D {d}, {'roll-off' if roll_off < 128 else 'no roll-off'}", "seed": seed,
                   "contact": short(corrected_area(touching)), "pressure_pa": short(load), "k_t_over_k_n": short((k_t + across) / 2 / k_n),
                   "displacement_m": [short(u) for u in path], "shear": [short(x) for x in q],
                   "loop_m": [short(u) for u in (turn, *back)], "loop_shear": [short(x) for x in loop], "seconds": short(seconds)}
            for name, joint in (("law", law), ("theory", theory)):
                curve, circle = by(joint)(path), masing(by(joint), turn, back)
                row |= {f"{name}_shear": [short(x) for x in curve], f"{name}_loop": [short(x) for x in (by(joint)(turn), *circle)],
                        f"{name}_curve_error": short(abs(curve - q).max()), f"{name}_loop_error": short(abs(circle - loop[1:]).max())}
            rows.append(row)
            print({k: v for k, v in row.items() if not isinstance(v, list)}, flush=True)
    return rows


def peers():
    """Friction solvers of tamaas, asked for q = mu P / 2 on a Hertz spot in units of the cell and of E, beside this package's."""
    tm, rows, n, load, friction = tamaas(), [], 64, 5e-4, 0.3
    x = (np.arange(n) + 0.5) / n - 0.5
    z, ratio = -np.hypot(*np.meshgrid(x, x)) ** 2 / 10, (2 - 2 * 0.5) / (2 - 0.5)
    for name in ("PolonskyKeerTan", "Kato", "Condat", "BeckTeboulle", "Slider"):
        start = time.perf_counter()
        if name == "Slider":
            space = HalfSpace(z, (1 / n, 1 / n), 1 / 0.75, ratio)
            normal = space.press(load)
            low, high = 0.0, 3 * friction * load / space.tangential_stiffness(normal > 0)
            for _ in range(25):   # the displacement that half the limit of friction takes
                middle = (low + high) / 2
                slider = Slider(space, normal, friction)
                low, high = (middle, high) if slider.move(middle) < 0.5 * friction * load else (low, middle)
            shear, size = slider.traction[..., 1], np.linalg.norm(slider.traction, axis=-1)
        else:
            model = tm.ModelFactory.createModel(tm.model_type.surface_2d, [1.0, 1.0], [n, n])
            model.E, model.nu = 1.0, 0.5
            getattr(tm, name)(model, z.copy(), 1e-8, friction).solve([0.5 * friction * load, 0.0, load])
            traction = np.array(model.traction)
            shear, size, normal = traction[..., 0], np.hypot(traction[..., 0], traction[..., 1]), traction[..., 2]
        slipping = ((size > 0.999 * friction * normal) & (normal > 0)).sum() / max((normal > 0).sum(), 1)
        rows.append({"solver": name, "mean_pressure_over_asked": short(normal.mean() / load),
                     "mean_shear_over_asked": short(shear.mean() / (0.5 * friction * load)), "slip_share_of_contact": short(slipping),
                     "exact_slip_share": short(1 - 0.5 ** (2 / 3)), "remembers_slip": name == "Slider",
                     "seconds": short(time.perf_counter() - start)})
        print(rows[-1], flush=True)
    return rows


@styled
def draw(rows):
    """Curve and loop of one patch, and the errors of all over the true contact."""
    figure, (left, right) = new_axes(1, 2, figsize=(13, 5.5))
    row = next(r for r in rows if r["surface"] == "D 2.5, roll-off" and 0.02 < r["contact"] < 0.1)
    nm = 1e9
    left.plot(np.array([0, *row["displacement_m"]]) * nm, [0, *row["shear"]], "ko", label="boundary elements, loading")
    left.plot(np.array(row["loop_m"]) * nm, row["loop_shear"], "C3s", label="boundary elements, loop", mfc="none")
    left.plot(np.array([0, *row["displacement_m"]]) * nm, [0, *row["law_shear"]], "k-", label="law from k_N alone")
    left.plot(np.array(row["loop_m"]) * nm, row["law_loop"], "C3-", label="the same, Masing's rule")
    left.set(xlabel="displacement / nm", ylabel="shear over µP", title=f"{row['surface']}, {100 * row['contact']:.2g} % of contact")
    left.legend(fontsize=10)
    area = [100 * r["contact"] for r in rows]
    for name, colour, label in (("law", "C0", "law from k_N of boundary elements"), ("theory", "C1", "law from the spectrum")):
        right.plot(area, [100 * r[f"{name}_curve_error"] for r in rows], "o", color=colour, label=f"{label}: loading")
        right.plot(area, [100 * r[f"{name}_loop_error"] for r in rows], "s", color=colour, mfc="none", label="the same: loop")
    right.axhline(3, color="k", ls=":", lw=1)
    right.set(xscale="log", yscale="log", xlabel="true contact / % of the area", ylabel="largest error / % of µP", xlim=(1, 40),
              ylim=(0.2, 200))
    right.set_xticks([1, 3, 10, 30], ["1", "3", "10", "30"])
    right.set_xticks([], minor=True)
    right.legend(fontsize=10)
    save_figure(figure, "joint_shear")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--redraw", action="store_true", help="figure from the record")
    if parser.parse_args().redraw:
        draw(read_record("joint_shear")["patches"])
        return
    rows = patch()
    write_record("joint_shear", {"e_star_pa": E_STAR, "k_t_over_k_n": RATIO, "friction": FRICTION, "spot": spot(), "tamaas": peers(),
                                 "patches": rows}, seed=11, peers=(tamaas(),))
    draw(rows)


if __name__ == "__main__":
    main()
