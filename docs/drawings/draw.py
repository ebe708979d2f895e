# SPDX-License-Identifier: GPL-3.0-or-later
"""Vector drawings of the pages: the drive, the cup with its band, one facet, the path of the torque."""
import sys
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle

STEEL, RING, CAM, BALL, FORCE, INK = "#9db4c8", "#e8b96a", "#d0d0d0", "#7a7a7a", "#b3261e", "#222222"


def canvas(width, height, xlim, ylim):
    """A figure without axes, one length scale both ways."""
    figure = Figure(figsize=(0.78 * width, 0.78 * height))  # letters are large beside the drawing: a phone shows it in full width
    ax = figure.add_axes([0, 0, 1, 1])
    ax.set(xlim=xlim, ylim=ylim, aspect="equal")
    ax.axis("off")
    return figure, ax


def save(figure, folder, name):
    """An SVG file as wide as drawing and words."""
    FigureCanvasSVG(figure).print_figure(str(Path(folder) / f"{name}.svg"), format="svg", metadata={"Date": None}, bbox_inches="tight", pad_inches=0.05)


def label(ax, text, at, point=None, ha="left"):
    """A word, with a thin line to what it names."""
    ax.annotate(text, xy=point or at, xytext=at, ha=ha, va="center", fontsize=11, color=INK,
                arrowprops=None if point is None else {"arrowstyle": "-", "lw": 0.8, "color": INK, "shrinkA": 2, "shrinkB": 0})


def arrow(ax, start, end, color=FORCE, text="", offset=(0, 0), **options):
    """A force or a length."""
    ax.add_patch(FancyArrowPatch(start, end, arrowstyle=options.pop("style", "-|>"), mutation_scale=14, color=color, lw=1.6, **options))
    if text:
        ax.text((start[0] + end[0]) / 2 + offset[0], (start[1] + end[1]) / 2 + offset[1], text, color=color, fontsize=11, ha="center")


def band(ax, inner, outer, color, edge=INK):
    """The area between two closed curves (n, 2)."""
    ax.add_patch(Polygon(np.vstack([outer, outer[:1], inner[::-1], inner[-1:]]), closed=True, fc=color, ec="none"))
    for curve in (inner, outer):
        ax.plot(*np.vstack([curve, curve[:1]]).T, color=edge, lw=0.8)


def drive():
    """Cross-section of a harmonic drive, deformation drawn ten times larger."""
    figure, ax = canvas(8, 4.9, (-1.3, 2.45), (-1.2, 1.1))
    th = np.linspace(0, 2 * np.pi, 721)[:-1]
    w = 0.11

    def oval(r, teeth=0, depth=0.0):
        radius = r + w * np.cos(2 * th) + depth * np.sign(np.sin(teeth * th)) * (teeth > 0)
        return np.c_[radius * np.cos(th), radius * np.sin(th)]

    circular = np.c_[np.cos(th), np.sin(th)]
    saw = np.abs((60 * th / (2 * np.pi)) % 1 - 0.5)
    band(ax, circular * (1.035 - 0.05 * saw)[:, None], circular * 1.09, "#e3e6ea")
    saw = np.abs((58 * th / (2 * np.pi)) % 1 - 0.5)
    teeth = oval(0.88) + circular * (0.05 * saw)[:, None]
    band(ax, oval(0.82), teeth, STEEL)
    band(ax, oval(0.755), oval(0.82), RING)
    ax.add_patch(Polygon(oval(0.6), closed=True, fc=CAM, ec=INK, lw=0.8))
    ax.add_patch(Circle((0, 0), 0.16, fc="white", ec=INK, lw=0.8))
    for t in np.linspace(0, 2 * np.pi, 22)[:-1]:
        r = 0.6775 + w * np.cos(2 * t)
        ax.add_patch(Circle((r * np.cos(t), r * np.sin(t)), 0.072, fc=BALL, ec=INK, lw=0.6))
    label(ax, "circular spline (fixed)", (1.25, 0.95), (0.8, 0.7))
    label(ax, "flexspline: thin toothed cup", (1.25, 0.72), (0.66, 0.56))
    label(ax, "outer ring of the bearing", (1.25, 0.42), (0.72, 0.33))
    label(ax, "ball", (1.25, 0.14), (0.80, 0.03))
    label(ax, "cam of the wave generator", (1.25, -0.16), (0.4, -0.12))
    label(ax, "the contact that\nhdengine computes", (1.25, -0.62), (0.735, -0.43))
    arrow(ax, (0, 0), (0.69, 0), INK, "long axis", (-0.02, 0.035), style="-")
    ax.text(-1.28, -1.17, "deformation drawn some ten times too large", fontsize=9, color="#555555")
    return figure


def cup():
    """Meridian of the cup with ring, band and the places where pressure is read."""
    figure, ax = canvas(9, 4.2, (-3.5, 25), (-2.4, 10.9))
    ax.add_patch(Rectangle((0, 8.0), 20, 0.42, fc=STEEL, ec=INK, lw=0.8))          # wall
    ax.add_patch(Polygon([(0, 8.42), (0, 8.72), (9, 8.72), (10, 8.42)], closed=True, fc=STEEL, ec=INK, lw=0.8))
    ax.add_patch(Rectangle((19.5, 2.6), 0.5, 5.82, fc=STEEL, ec=INK, lw=0.8))      # bottom
    ax.add_patch(Rectangle((19.5, 0.4), 1.4, 2.2, fc=STEEL, ec=INK, lw=0.8))       # hub
    ax.add_patch(Rectangle((0.5, 6.9), 12, 1.1, fc=RING, ec=INK, lw=0.8))
    ax.plot([-3, 24], [0, 0], "-.", color=INK, lw=0.8)
    label(ax, "axis", (22.6, 0.55))
    label(ax, "toothed rim", (4.5, 10.0), (4.5, 8.6), "center")
    label(ax, "wall", (14.8, 10.0), (14.8, 8.25), "center")
    label(ax, "bottom", (22.2, 5.2), (19.8, 5.2))
    label(ax, "hub: held,\ntorque\nleaves here", (22.2, 2.2), (20.4, 1.6))
    label(ax, "outer ring", (3.0, 5.6), (3.0, 7.2), "center")
    for z, name in ((0.5, "I"), (5.5, "II"), (10.5, "III")):
        ax.plot([z, z], [6.1, 8.0], color=FORCE, lw=1.2)
        ax.text(z, 5.5, name, color=FORCE, ha="center", fontsize=12)
    ax.annotate("", (0.5, 4.3), (12.5, 4.3), arrowprops={"arrowstyle": "<->", "color": INK, "lw": 0.8})
    ax.text(6.5, 3.55, "contact band", ha="center", fontsize=11)
    ax.annotate("", (-0.6, 0), (-0.6, 8.0), arrowprops={"arrowstyle": "<->", "color": INK, "lw": 0.8})
    ax.text(-0.9, 3.9, "bore radius", rotation=90, ha="right", va="center", fontsize=11)
    arrow(ax, (0, -1.3), (5, -1.3), INK, "z, from the opening", (3.4, -0.75))
    return figure


def facet():
    """One facet of the contact with its normal, its lever and its two stiffnesses."""
    figure, ax = canvas(7, 5.0, (-0.28, 1.75), (-0.33, 1.12))
    th = np.linspace(0, np.pi / 2, 200)
    a, b = 1.15, 0.85
    ax.plot(a * np.cos(th), b * np.sin(th), color=INK, lw=1.4)
    ax.plot([0, 1.45], [0, 0], "-.", color=INK, lw=0.7)
    ax.plot([0, 0], [0, 1.08], "-.", color=INK, lw=0.7)
    t = np.radians(48)
    p = np.array([a * np.cos(t), b * np.sin(t)])
    n = np.array([b * np.cos(t), a * np.sin(t)])
    n /= np.linalg.norm(n)
    s = np.array([-n[1], n[0]])
    ax.plot(*np.c_[p - 0.13 * s, p + 0.13 * s], color=RING, lw=7, solid_capstyle="butt", zorder=3)
    ax.plot([0, p[0]], [0, p[1]], color="#666666", lw=0.9)
    ax.text(*(0.5 * p + [-0.05, 0.03]), r"$\rho$", fontsize=13)
    foot = (p @ s) * s
    ax.plot(*np.c_[foot, p + 0.02 * n], ":", color="#666666", lw=0.9)
    ax.plot(*np.c_[[0, 0], foot], color=FORCE, lw=1.6)
    ax.text(*(foot * 0.5 + [-0.1, -0.09]), "lever", color=FORCE, fontsize=11)
    arrow(ax, p, p + 0.33 * n, FORCE, r"$K_N$, along the normal", (0.35, 0.02))
    arrow(ax, p, p + 0.33 * s, "#1f5fa8", r"$K_T$, in the facet", (-0.02, 0.13))
    ax.text(p[0] + 0.17, p[1] - 0.05, "facet", fontsize=11)
    ax.text(1.3, 0.03, "long axis", fontsize=10)
    ax.text(-0.03, 0.03, "axis of\nthe drive", fontsize=10, ha="right")
    ax.text(0.98, 0.16, "cam's curve", fontsize=10, ha="right")
    return figure


def torque_path():
    """Where torque enters and leaves, for the supports of a scene."""
    figure, ax = canvas(9, 3.2, (0, 27), (0, 9))
    cases = (("support = 'hub'", "the cup's bottom is held", (6.2, 2.2)), ("support = 'bearing'", "the bottom is free: all torque\npasses the contact", (1.4, 2.4)),
             ("support = 'teeth'", "teeth hold the rim,\nthe bottom is turned", (2.6, 6.6)))
    for i, (name, words, _) in enumerate(cases):
        x = 9 * i + 0.6
        ax.add_patch(Rectangle((x, 5.2), 6.6, 0.3, fc=STEEL, ec=INK, lw=0.8))
        ax.add_patch(Rectangle((x + 6.3, 2.4), 0.3, 3.1, fc=STEEL, ec=INK, lw=0.8))
        ax.add_patch(Rectangle((x + 0.2, 4.5), 4.2, 0.7, fc=RING, ec=INK, lw=0.8))
        ax.text(x + 3.2, 8.2, name, ha="center", fontsize=11, family="monospace")
        ax.text(x + 3.2, 0.7, words, ha="center", fontsize=10)
        if i < 2:
            arrow(ax, (x + 2, 7.4), (x + 2, 5.6), FORCE, "T", (0.5, 0.1))
        if i == 0:
            arrow(ax, (x + 6.45, 2.3), (x + 8.0, 2.3), "#1f5fa8")
        if i == 1:
            arrow(ax, (x + 2, 4.4), (x + 2, 2.8), "#1f5fa8")
        if i == 2:
            arrow(ax, (x + 8.0, 2.6), (x + 6.7, 2.6), FORCE, "T", (0.3, 0.35))
            arrow(ax, (x + 2, 5.6), (x + 2, 7.4), "#1f5fa8")
    return figure


def draw_all(folder):
    """Write the drawings as SVG files into a folder."""
    for make in (drive, cup, facet, torque_path):
        figure = make()
        save(figure, folder, make.__name__)


if __name__ == "__main__":
    draw_all(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "figures")
