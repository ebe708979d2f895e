# SPDX-License-Identifier: GPL-3.0-or-later
"""Vector drawings of ideas: angles, path of the torque, contact law, rough joint, readings of K_TS, planner, structure function."""
import sys
from pathlib import Path

import numpy as np
from draw import CAM, FORCE, INK, RING, STEEL, arrow, canvas, label, save
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, FancyBboxPatch, Polygon, Rectangle

BLUE, GREY = "#1f5fa8", "#666666"


def spring(ax, start, end, turns, height, color=INK):
    """A zigzag from start to end, along x."""
    x = np.linspace(start[0], end[0], 2 * turns + 1)
    y = start[1] + height * np.r_[0, np.tile([1, -1], turns)[: 2 * turns - 1], 0]
    ax.plot(x, y, color=color, lw=1.6)


def box(ax, at, text, color="#f3f5f8", size=(3.0, 1.0)):
    """A rounded box about a point, with words."""
    ax.add_patch(FancyBboxPatch((at[0] - size[0] / 2, at[1] - size[1] / 2), *size, boxstyle="round,pad=0.05", fc=color, ec=INK, lw=0.9))
    ax.text(*at, text, ha="center", va="center", fontsize=10, color=INK)


def axes(ax, origin, size, x, y):
    """Two plain axes with names."""
    arrow(ax, origin, (origin[0] + size[0], origin[1]), INK)
    arrow(ax, origin, (origin[0], origin[1] + size[1]), INK)
    ax.text(origin[0] + size[0], origin[1] - 0.32, x, ha="right", va="top", fontsize=10)
    ax.text(origin[0], origin[1] + size[1] + 0.15, y, ha="center", fontsize=10)


def angles():
    """The angle from the long axis, the axis from the opening, and the directions at a point."""
    figure, ax = canvas(9, 3.9, (-1.6, 5.9), (-1.65, 1.6))
    ax.add_patch(Ellipse((0, 0), 2.5, 1.9, fc="none", ec=INK, lw=1.4))
    ax.plot([-1.45, 1.5], [0, 0], "-.", color=GREY, lw=0.8)
    ax.plot([0, 0], [-1.15, 1.2], "-.", color=GREY, lw=0.8)
    ax.text(1.53, -0.02, "long axis\nθ = 0", fontsize=10, va="center")
    ax.text(0.05, 1.2, "short axis", fontsize=10)
    t = np.radians(42)
    p = np.array([1.25 * np.cos(t), 0.95 * np.sin(t)])
    n = np.array([0.95 * np.cos(t), 1.25 * np.sin(t)]) / np.hypot(0.95 * np.cos(t), 1.25 * np.sin(t))
    ax.plot([0, p[0]], [0, p[1]], color=GREY, lw=0.9)
    arc = np.linspace(0, np.arctan2(p[1], p[0]), 40)
    ax.plot(0.45 * np.cos(arc), 0.45 * np.sin(arc), color=BLUE, lw=1.4)
    ax.text(0.5, 0.13, "θ", color=BLUE, fontsize=13)
    arrow(ax, p, p + 0.42 * n, FORCE)
    ax.text(*(p + 0.5 * n + [0.02, 0]), "normal", color=FORCE, fontsize=10)
    arrow(ax, p, p + 0.42 * np.array([-n[1], n[0]]), BLUE)
    ax.text(p[0] - 0.42, p[1] + 0.38, "round", color=BLUE, fontsize=10, ha="center")
    ax.text(0, -1.5, "seen from the opening", fontsize=10, ha="center", color=GREY)
    ax.add_patch(Rectangle((2.75, 0.75), 2.4, 0.1, fc=STEEL, ec=INK, lw=0.8))
    ax.add_patch(Rectangle((2.75, -0.85), 2.4, 0.1, fc=STEEL, ec=INK, lw=0.8))
    ax.add_patch(Rectangle((5.07, -0.85), 0.08, 1.7, fc=STEEL, ec=INK, lw=0.8))
    for y in (0.57, -0.75):
        ax.add_patch(Rectangle((2.85, y), 1.3, 0.18, fc=RING, ec=INK, lw=0.8))
    ax.plot([2.6, 5.5], [0, 0], "-.", color=GREY, lw=0.8)
    arrow(ax, (2.75, 0.12), (3.7, 0.12), FORCE)
    ax.text(3.75, 0.12, "z", color=FORCE, fontsize=13, va="center")
    label(ax, "opening", (2.75, 1.25), (2.75, 0.85), "center")
    label(ax, "bottom", (5.35, 1.25), (5.11, 0.8), "center")
    label(ax, "ring", (3.5, -0.35), (3.5, -0.6), "center")
    ax.text(3.95, -1.5, "cut along the axis", fontsize=10, ha="center", color=GREY)
    return figure


def drive_chain():
    """What carries the torque in the whole drive, and what holds the cup in mesh."""
    figure, ax = canvas(9, 3.0, (0, 18), (0, 6))
    for x, text, color in ((2, "torque T\non the bottom", "#f6dedd"), (7, "cup", STEEL), (12, "tooth pairs", "#e3e6ea"), (16.2, "circular spline\nfixed", "#e3e6ea")):
        box(ax, (x, 4.6), text, color)
    for a, b in ((3.6, 5.4), (8.6, 10.4), (13.6, 14.6)):
        arrow(ax, (a, 4.6), (b, 4.6), FORCE)
    for x, text, color in ((2, "cam\nlocked", CAM), (7, "balls", "#c9c9c9"), (12, "ring", RING)):
        box(ax, (x, 1.3), text, color)
    for a, b in ((3.6, 5.4), (8.6, 10.4)):
        arrow(ax, (a, 1.3), (b, 1.3), BLUE)
    arrow(ax, (11.2, 1.95), (8.0, 3.95), BLUE)
    ax.text(10.1, 2.95, "contact", color=BLUE, fontsize=11)
    ax.text(16.2, 2.2, "red: the torque", color=FORCE, fontsize=10, ha="center")
    ax.text(16.2, 1.5, "blue: the push\nthat keeps teeth in mesh", color=BLUE, fontsize=10, ha="center", va="top")
    return figure


def contact_law():
    """Pressure over the gap and shear over the slip, hard and rough."""
    figure, ax = canvas(9, 3.6, (0, 18), (0, 7.2))
    axes(ax, (1.2, 1.2), (6.3, 4.8), "gap", "pressure p")
    ax.plot([4, 4, 7], [5.7, 1.2, 1.2], color=INK, lw=2.2)
    x = np.linspace(2.75, 5.4, 60)
    ax.plot(x, 1.2 + 4.5 * np.exp(-(x - 2.75) / 0.75), "--", color=FORCE, lw=1.8)
    ax.text(4.15, 5.3, "hard: gap 0,\nany pressure", fontsize=10, va="top")
    ax.text(1.5, 1.75, "rough joint:\nclosure δ(P)", fontsize=10, color=FORCE, va="center")
    ax.text(6.1, 1.5, "open", fontsize=10)
    ax.text(4, 0.75, "0", ha="center", fontsize=10, va="center")
    axes(ax, (10.2, 1.2), (6.8, 4.8), "slip along the face", "shear q")
    ax.plot([10.2, 10.2, 16.6], [1.2, 5.0, 5.0], color=INK, lw=2.2)
    x = np.linspace(0, 3.4, 80)
    ax.plot(10.2 + x, 1.2 + 3.8 * (1 - (1 - x / 3.4) ** 3), "--", color=FORCE, lw=1.8)
    ax.text(10.0, 5.0, "µp", ha="right", va="center", fontsize=11)
    ax.text(15, 5.2, "slip", fontsize=10)
    ax.text(10.35, 5.5, "stick", fontsize=10)
    ax.text(12.1, 3.2, "rough joint: gives way by $k_T$,\nwhich falls to zero at µp", fontsize=10, color=FORCE)
    return figure


def rough_joint():
    """Two rough faces that touch at spots, and the layer of springs that stands for them."""
    figure, ax = canvas(9, 3.7, (0, 18), (0, 7.4))
    rng = np.random.default_rng(4)
    x = np.linspace(0.4, 9.4, 700)

    def rough():
        return sum(0.32 / n**0.9 * np.cos(2 * np.pi * n * x / 9 + rng.uniform(0, 2 * np.pi)) for n in range(3, 60))

    low, high = 2.9 + rough(), 3.4 + rough()
    shift = np.sort(high - low)[30]
    touch = high - low < shift
    high = np.where(touch, low, high - shift)
    ax.add_patch(Polygon(np.r_[np.c_[x, low], [(9.4, 1.0), (0.4, 1.0)]], fc=RING, ec=INK, lw=0.8))
    ax.add_patch(Polygon(np.r_[np.c_[x, high], [(9.4, 5.6), (0.4, 5.6)]], fc=STEEL, ec=INK, lw=0.8))
    ax.plot(np.where(touch, x, np.nan), np.where(touch, low, np.nan), color=FORCE, lw=4.5)
    ax.text(1, 5.05, "flexspline", fontsize=11)
    ax.text(1, 1.3, "ring", fontsize=11)
    place = x[touch][len(x[touch]) // 2]
    ax.annotate("spot that touches", (place, low[touch][len(x[touch]) // 2]), (5.2, 1.35), fontsize=11, color=FORCE,
                arrowprops={"arrowstyle": "-", "color": FORCE, "lw": 0.9})
    arrow(ax, (4.9, 7.1), (4.9, 5.65), FORCE, "P", (0.35, -0.1))
    arrow(ax, (6.0, 6.1), (7.7, 6.1), BLUE, "q", (0, 0.25))
    for y, color in ((1.0, RING), (4.6, STEEL)):
        ax.add_patch(Rectangle((10.8, y), 6.8, 1.0, fc=color, ec=INK, lw=0.8))
    for i, c in enumerate((11.5, 13.3, 15.1, 16.9)):
        y = np.linspace(2, 4.6, 13)
        ax.plot(c + 0.22 * np.r_[0, np.tile([1, -1], 6)[:11], 0], y, color=FORCE, lw=1.4)
        if i < 3:
            ax.plot([c + 0.4, c + 0.4], [2, 3.0], color=BLUE, lw=1.2)
            ax.plot([c + 1.4, c + 1.4], [3.0, 4.6], color=BLUE, lw=1.2)
            spring(ax, (c + 0.4, 3.0), (c + 1.4, 3.0), 5, 0.17, BLUE)
    ax.text(11.0, 6.9, r"$k_N$: along the normal", color=FORCE, fontsize=11)
    ax.text(11.0, 6.05, r"$k_T$: along the face", color=BLUE, fontsize=11)
    return figure


def readings():
    """Rotation over the torque with slip and with glued faces, and how tangent and secant read the difference."""
    figure, ax = canvas(7.5, 4.2, (0, 15), (0, 8.4))
    axes(ax, (1.4, 1.3), (11.6, 6.2), "torque", "turn θ of the rim")
    t = np.linspace(0, 1, 80)
    glued, slips = 1.3 + 1.6 * t, 1.3 + 1.6 * t + 1.0 * t + 2.0 * t**2.4
    ax.plot(1.4 + 10 * t, glued, color=GREY, lw=2)
    ax.plot(1.4 + 10 * t, slips, color=INK, lw=2)
    ax.plot([11.4, 11.4], [1.3, slips[-1]], ":", color=GREY, lw=1)
    ax.text(11.4, 0.85, "T", ha="center", fontsize=11)
    ax.annotate("", (11.4, glued[-1]), (11.4, slips[-1]), arrowprops={"arrowstyle": "<->", "color": FORCE, "lw": 1.6})
    ax.text(11.6, (glued[-1] + slips[-1]) / 2, "the contact's part:\nsecant", color=FORCE, fontsize=10, va="center")
    slope = 1.6 + 1.0 + 2 * 2.4
    ax.plot([8.6, 12.2], [slips[-1] - 0.28 * slope, slips[-1] + 0.08 * slope], "--", color=BLUE, lw=1.6)
    ax.text(8.3, 5.7, "slope of the difference:\ntangent", color=BLUE, fontsize=10, ha="right")
    ax.text(6.0, 1.65, "faces glued", color=GREY, fontsize=10)
    ax.text(4.0, 3.1, "faces slip", fontsize=10, ha="center")
    return figure


def planner():
    """Decisions of a run with a tolerance, as a flow."""
    figure, ax = canvas(7.5, 7.6, (0, 12), (0, 12.2))
    size = (6.4, 1.1)
    for y, text, color in ((11.4, "your scene and a tolerance", "#f6dedd"), (9.6, "coarse mesh: try kinematics\nand load steps", "#f3f5f8"),
                           (7.8, "choose the cheapest of each that keeps\nits share of the tolerance", "#f3f5f8"), (6.0, "solve the next mesh of the series", "#f3f5f8"),
                           (4.2, "extrapolate to h = 0,\nestimate the error", "#f3f5f8"), (0.8, "final run, limits with their errors", "#dcebdc")):
        box(ax, (4.2, y), text, color, size)
    ax.add_patch(Polygon([(4.2, 3.15), (6.4, 2.45), (4.2, 1.75), (2.0, 2.45)], fc="#fff3d6", ec=INK, lw=0.9))
    ax.text(4.2, 2.45, "error within\nthe tolerance?", ha="center", va="center", fontsize=9)
    for a, b in ((10.8, 10.22), (9.0, 8.42), (7.2, 6.62), (5.4, 4.82), (3.6, 3.17), (1.75, 1.42)):
        arrow(ax, (4.2, a), (4.2, b), INK)
    ax.text(4.4, 1.55, "yes", fontsize=10)
    ax.plot([6.4, 8.6, 8.6], [2.45, 2.45, 6.0], color=INK, lw=1.4)
    arrow(ax, (8.6, 6.0), (7.5, 6.0), INK)
    ax.text(6.5, 2.6, "no: finer\nmesh", fontsize=10)
    ax.plot([8.6, 10.4, 10.4], [4.2, 4.2, 0.8], "--", color=FORCE, lw=1.2)
    arrow(ax, (10.4, 0.8), (7.5, 0.8), FORCE)
    ax.text(10.5, 2.9, "no memory,\nor no\nconvergence:\nrun warns", fontsize=9, color=FORCE, ha="left", va="center")
    return figure


def structure_function():
    """Two profiles of the sum of Eq. 2, of one height, and their expected structure functions."""
    figure = Figure(figsize=(9, 3.6))
    left, right = figure.subplots(1, 2)
    rng = np.random.default_rng(3)
    wave = 1.0 / 1.3 ** np.arange(0, 27)
    x, lag = np.linspace(0, 1, 3000), np.logspace(-3.4, 0, 300)
    for shift, dimension, color in ((0.5, 2.2, BLUE), (-0.5, 2.6, FORCE)):
        size = wave ** (3 - dimension)
        size = size / np.sqrt((size**2).sum() / 2)
        z = (size * np.cos(2 * np.pi * x[:, None] / wave + rng.uniform(0, 2 * np.pi, wave.size))).sum(1)
        left.plot(x, 0.12 * (z - z.mean()) + shift, color=color, lw=0.8)
        left.text(0.01, shift + 0.34, f"D = {dimension}", color=color, fontsize=11)
        right.loglog(lag, (size**2 * (1 - np.cos(2 * np.pi * lag[:, None] / wave))).sum(1), color=color, lw=1.8)
    left.set(xlabel="x / L", ylabel="height", yticks=[], ylim=(-1, 1))
    right.set(xlabel="lag τ / L", ylabel="S(τ)")
    right.text(1.2e-2, 1.1, r"D = 2.6: $S \sim \tau^{0.8}$", color=FORCE, fontsize=11, ha="right")
    right.text(2e-2, 5e-4, r"D = 2.2: $S \sim \tau^{1.6}$", color=BLUE, fontsize=11)
    for ax in (left, right):
        ax.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    return figure


def draw_all(folder):
    """Write the drawings as SVG files into a folder."""
    for make in (angles, drive_chain, contact_law, rough_joint, readings, planner, structure_function):
        figure = make()
        save(figure, folder, make.__name__)


if __name__ == "__main__":
    draw_all(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "figures")
