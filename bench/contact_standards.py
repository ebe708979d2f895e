#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact against closed solutions: Hertz, Cattaneo-Mindlin, a dragged rod, Persson, Lame, holding torque, patch tests.

Writes bench/results/contact_standards.json and docs/figures/contact_standards.png, prints Markdown. Takes some five minutes.
"""
import sys
import time

import matplotlib
import matplotlib.ticker
import numpy as np

import hdengine

matplotlib.use("Agg")
import contact_cases as cc  # noqa: E402
from matplotlib import pyplot as plt  # noqa: E402

from common import ROOT, write_record

FRICTION = 0.3
PATH = (0.5, 1.1, 0.5, 0.0, -0.5, -1.1)


def order(sizes, errors):
    """Slope of ln error over ln size."""
    return float(np.polyfit(np.log(sizes), np.log(np.abs(errors)), 1)[0])


def plain(result, *drop):
    """Scalars of a result, for JSON."""
    return {k: (v.item() if hasattr(v, "item") else v) for k, v in result.items()
            if np.ndim(v) == 0 and k not in ("solution", *drop)}


def hertz(record, ax):
    """Line contact on meshes of 5 to 40 cells in the half-width; sphere with 5, 7 and 10."""
    rows = []
    for element, meshes in (("hex8i", (5, 10, 20, 40)), ("hex20r", (5, 10))):
        for m in meshes:
            run = cc.cylinder(m, element)
            rows.append({"element": element, "cells": m} | plain(cc.hertz_line(run)))
            if (element, m) == ("hex8i", 10):
                a, p0 = rows[-1]["a"], rows[-1]["p0"]
                ax[0].plot(run["y"] / a, run["pressure"][0] / p0, "o", ms=4, label="line, 10 cells in a")
    mine = [r for r in rows if r["element"] == "hex8i"]
    record["hertz_line"] = {"rows": rows, "order_field_hex8i": order([1 / r["cells"] for r in mine], [r["field"] for r in mine])}
    rows = []
    for m in (5, 7, 10):
        run = cc.sphere(m)
        rows.append({"element": "hex8i", "cells": m} | plain(run))
    ax[0].plot(run["r"] / run["a"], run["pressure"] / run["p0"], "x", ms=4, label="sphere, 10 cells in a")
    s = np.linspace(0, 1, 200)
    ax[0].plot(s, np.sqrt(1 - s**2), "k-", lw=1, label="Hertz")
    ax[0].set(xlim=(0, 1.4), xlabel="distance from the centre / a", ylabel="pressure / peak", title="Hertz")
    record["hertz_sphere"] = {"rows": rows}


def cattaneo(record, ax):
    """Partial slip, unloading and reversal."""
    rows = []
    for element, m, matching in (("hex8i", 5, True), ("hex8i", 10, True), ("hex8i", 20, True), ("hex8i", 10, False), ("hex20r", 10, True)):
        run = cc.cylinder(m, element, FRICTION, PATH, matching)
        h = cc.hertz_line(run)
        a, p0, y = h["a"], h["p0"], run["y"]
        ratio = run["drag"] / (FRICTION * run["force"])
        full = np.sqrt(((FRICTION * p0) ** 2 * np.maximum(0, 1 - (y / a) ** 2)).sum())
        row = {"element": element, "cells": m, "matching": matching, "iterations": cc.iterations(run["solution"])}
        for s, name in ((1, "stick_low"), (2, "stick_high")):
            row[name] = float(cc.stick_width(y, run["shear"][s], a, p0, FRICTION) / a / np.sqrt(1 - ratio[s]) - 1)
        field = []
        for s in range(1, len(PATH) + 1):
            turns = [ratio[s]] if s < 3 else [ratio[2], ratio[s]]
            exact = cc.mindlin_shear(y, a, p0, FRICTION, turns)
            field.append(float(np.sqrt(((run["shear"][s] - exact) ** 2).sum()) / full))
            if (element, m) == ("hex8i", 20) and s in (2, 3, 4, 6):
                fine = np.linspace(-1.2, 1.2, 961)
                line = ax[1].plot(fine, cc.mindlin_shear(fine * a, a, p0, FRICTION, turns) / (FRICTION * p0), "-", lw=1)[0]
                ax[1].plot(y / a, run["shear"][s] / (FRICTION * p0), "o", ms=3, color=line.get_color(),
                           label=f"Q = {ratio[s]:+.2f} µP")
        rows.append(row | {"field": field, "ratio": ratio[1:].tolist()})
    mine = [r for r in rows if r["element"] == "hex8i" and r["matching"]]
    record["cattaneo"] = {"rows": rows, "order_field": order([1 / r["cells"] for r in mine], [r["field"][1] for r in mine])}
    ax[1].set(xlim=(-1.2, 1.2), ylim=(-1.6, 1.0), xlabel="y / a", ylabel="shear / (µ peak pressure)", title="Cattaneo-Mindlin, loading, unloading, reversal")


def rod(record, ax):
    """The dragged rod's loop."""
    rows = []
    for m in (50, 100, 200):
        run = cc.dragged_rod(m)
        d = run["force"] - run["exact"]
        slipping = [10, 11, 12, 23, 24, 25, 27]
        rows.append({"cells": m, "worst": float(np.nanmax(np.abs(d))), "gross_slip": float(np.abs(d[slipping]).max()),
                     "iterations_max": max(cc.iterations(run["solution"]))})
    ax[2].plot(run["travel"], run["exact"], "k-", lw=1, label="closed solution")
    ax[2].plot(run["travel"], run["force"], "o", ms=4, label="200 cells")
    ax[2].set(xlabel="travel of the end / travel at gross slip", ylabel="force / µ N", title="Dragged rod: back, half pressure, forth")
    record["dragged_rod"] = rows


def persson(record, ax):
    """Pin in a hole: clearance, interference with separation, interference with full contact; either side slave."""
    rows = []
    for n in (5, 10):
        for clearance, travel in ((1e-3, 1e-3), (1e-3, 4e-3), (-1e-3, 12e-3), (-1e-3, 6e-3), (-1e-3, 2e-3)):
            for swap in (False, True):
                run = cc.pin(n, "hex20r", clearance, travel, 1.3, swap)
                d = run["pressure"] - run["exact"]
                rows.append({"cells": 4 * n, "clearance": clearance, "slave": "hole" if swap else "pin"} | plain(run) | {
                    "field": float(np.sqrt((d**2).sum() / (run["exact"] ** 2).sum())),
                    "peak": float(run["pressure"].max() / run["exact"].max() - 1),
                    "bracketed": bool(run["closed_to"] - np.pi / (4 * n) <= run["exact_angle"] <= run["next"] + np.pi / (4 * n))})
                if n == 10 and not swap:
                    peak = run["exact"].max()
                    fine = np.linspace(0, np.pi, 721)
                    curve = cc.persson_pressure(fine, run["exact_angle"], run["force"], run["radius"], cc.E / (1 - cc.NU**2) * clearance)
                    line = ax[3].plot(np.degrees(fine), curve / peak, "-", lw=1)[0]
                    ax[3].plot(np.degrees(run["angle"]), run["pressure"] / peak, "o", ms=4, color=line.get_color(),
                               label=f"{'clearance' if clearance > 0 else 'interference'}, to {np.degrees(run['exact_angle']):.0f}°")
    record["persson"] = rows
    ax[3].set(xlabel="angle from the load / degrees", ylabel="pressure / peak", title="Pin in a hole (lines: Persson)")


def press_fit(record, ax):
    """Lame's rings on meshes that do not match; holding torque."""
    rows = []
    for element, layers in (("hex8i", 3), ("hex8i", 6), ("hex20r", 3)):
        for n in ((40, 40), (40, 32), (80, 64), (160, 128)):
            for swap in (False, True):
                rows.append({"element": element, "layers": layers, "divisions": n, "slave": "outer" if swap else "inner"}
                            | plain(cc.lame(*n, element, layers, swap)))
        mine = [r for r in rows if (r["element"], r["layers"], r["slave"]) == (element, layers, "inner")][1:]
        ax[4].plot([r["divisions"][0] for r in mine], [100 * r["pressure_worst"] for r in mine], "o-", label=f"{element}, {layers} layers")
    ax[4].axhline(0.5, color="0.7", lw=1)
    ax[4].set(xscale="log", yscale="log", xlabel="divisions of the inner ring (outer: 4/5 of it)", ylabel="pressure, worst point / %",
              title="Lamé press fit, not matching")
    ax[4].set_xticks([40, 80, 160], ["40", "80", "160"])
    ax[4].xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    record["lame"] = rows
    record["holding_torque"] = [{"element": e, "divisions": n} | plain(cc.holding_torque(*n, e))
                                for e in ("hex8i", "hex20r") for n in ((80, 64), (160, 128))]


def show(record):
    """Markdown of the table."""
    pc = lambda v: f"{100 * v:+.3g} %"  # noqa: E731
    print("| standard | mesh | result |\n|---|---|---|")
    for r in record["hertz_line"]["rows"]:
        print(f"| Hertz line, {r['element']} | {r['elements']:.1f} cells in a | half-width {pc(r['half_width'])}, peak {pc(r['peak'])}, "
              f"field {pc(r['field'])}, force balance {r['balance']:.0e}, {r['iterations']} iterations |")
    print("order of the field (hex8i)", record["hertz_line"]["order_field_hex8i"])
    for r in record["hertz_sphere"]["rows"]:
        print(f"| Hertz sphere, {r['element']} | {r['elements']:.1f} cells in a, {r['dof']} dof | load {pc(r['load'])}, radius {pc(r['radius'])}, "
              f"peak {pc(r['peak'])}, field {pc(r['field'])}, {r['iterations']} iterations |")
    for r in record["cattaneo"]["rows"]:
        print(f"| Cattaneo-Mindlin, {r['element']}{'' if r['matching'] else ', not matching'} | {r['cells']} | stick width at Q/µP = "
              f"{r['ratio'][0]:.2f}: {pc(r['stick_low'])}, {r['ratio'][1]:.2f}: {pc(r['stick_high'])}; shear field "
              + ", ".join(pc(v) for v in r["field"]) + f"; iterations {r['iterations']} |")
    print("order", record["cattaneo"]["order_field"])
    for r in record["dragged_rod"]:
        print(f"| dragged rod | {r['cells']} | worst {pc(r['worst'])}, gross slip {r['gross_slip']:.0e}, {r['iterations_max']} its |")
    for r in record["persson"]:
        print(f"| pin {r['clearance']} slave {r['slave']} | {r['cells']} | angle {np.degrees(r['exact_angle']):.1f} in "
              f"{np.degrees(r['closed_to']):.1f}..{np.degrees(r['next']):.1f}, peak {pc(r['peak'])}, field {pc(r['field'])}, "
              f"balance {r['balance']:.0e}, its {r['iterations']} |")
    for r in record["lame"]:
        print(f"| Lame {r['element']} {r['layers']} layers slave {r['slave']} | {r['divisions']} | pressure mean {pc(r['pressure_mean'])} worst "
              f"{pc(r['pressure_worst'])} even {r['unevenness']:.0e}, displacement mean {pc(r['displacement_mean'])} worst {pc(r['displacement_worst'])} |")
    for r in record["holding_torque"]:
        print(f"| holding torque {r['element']} | {r['divisions']} | {pc(r['error'])}, against own pressure {r['own']:.0e}, slipping {r['slipping']} |")


def main():
    start = time.time()
    record = {"hdengine": hdengine.__version__}
    fig, axes = plt.subplots(3, 2, figsize=(9.6, 12.5), layout="constrained")
    ax = axes.flat
    for part in (hertz, cattaneo, rod, persson, press_fit):
        part(record, ax)
        print(f"{part.__name__}: {time.time() - start:.0f} s", file=sys.stderr)
    for i, a in enumerate(ax[:5]):
        a.legend(fontsize=9, loc="lower center" if i == 1 else "best", ncol=2 if i == 1 else 1)
    order_data = record["hertz_line"]["rows"]
    for e in ("hex8i", "hex20r"):
        mine = [r for r in order_data if r["element"] == e]
        ax[5].plot([r["elements"] for r in mine], [100 * r["field"] for r in mine], "o-", label=f"Hertz line, {e}")
    mine = record["hertz_sphere"]["rows"]
    ax[5].plot([r["elements"] for r in mine], [100 * r["field"] for r in mine], "s-", label="Hertz sphere, hex8i")
    mine = [r for r in record["cattaneo"]["rows"] if r["element"] == "hex8i" and r["matching"]]
    ax[5].plot([r["cells"] for r in mine], [100 * r["field"][1] for r in mine], "x-", label="Cattaneo-Mindlin, hex8i")
    ax[5].set(xscale="log", yscale="log", xlabel="cells in the half-width", ylabel="error of the field (L2) / %", title="Convergence")
    ax[5].set_xticks([5, 10, 20, 40], ["5", "10", "20", "40"])
    ax[5].xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    ax[5].legend(fontsize=9)
    fig.savefig(ROOT / "docs/figures/contact_standards.png", dpi=110)
    write_record("contact_standards", record)
    show(record)


if __name__ == "__main__":
    main()
