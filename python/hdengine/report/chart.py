# SPDX-License-Identifier: GPL-3.0-or-later
"""Small charts as inline SVG: crisp at every size, in the colours of the page, drawn without matplotlib."""
from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence
from typing import TypeAlias, Union

import numpy as np

from ..views.palette import STEPS

__all__: list[str] = []
Values: TypeAlias = Union[Sequence[float], np.ndarray]  # noqa: UP007
WIDTH, HEIGHT, SIDE, TOP, FOOT = 480, 320, 56, 34, 48   # of a chart; margins of its axes
_FONT, _LETTER = 13, 7.0   # height, and mean width of a letter [px]


def _number(value):
    return f"{value:.4g}".replace("-", "\u2212")


def ticks(low: float, high: float, most: int = 6) -> list[float]:
    """Round numbers from low to high: multiples of 1, 2 or 5 times a power of ten."""
    rough = (high - low) / most
    if not rough > 0 or not math.isfinite(rough):
        return [low]
    power = 10 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1, 2, 5, 10) if m * power >= rough * (1 - 1e-9))
    return [step * i for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def _text(x, y, text, anchor="middle", **more):
    keys = "".join(f' {key}="{value}"' for key, value in more.items())
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{keys}>{html.escape(text)}</text>'


def _svg(title, width, height, parts, kind="chart"):
    """The picture; a reader of the screen hears its title."""
    return f'<svg class="{kind}" viewBox="0 0 {width:.0f} {height:.0f}" role="img" aria-label="{html.escape(title)}" ' \
        f'font-size="{_FONT}" font-family="system-ui,sans-serif" fill="currentColor">{"".join(parts)}</svg>'


def _legend(marks, width, y):
    """Marks and names in rows, from the left."""
    found, x = [], 8.0
    for colour, name in marks:
        wide = 24 + _LETTER * len(name)
        if x > 8 and x + wide > width:
            x, y = 8.0, y + 18
        found.append(f'<rect x="{x:.1f}" y="{y - 8:.1f}" width="14" height="8" rx="2" fill="{colour}"/>'
                     + _text(x + 19, y, name, "start", fill="currentColor"))
        x += wide + 10
    return found, y


class Chart:
    """Axes from data to pixels, and what is drawn in them.

    Parameters
    ----------
    title, across, up : str
        Above the axes, below them, beside them.
    x, y : sequence of float
        Values that the axes must show.
    x_ticks : sequence of float, optional
        Default: round numbers.
    height : float
        Of the axes and their margins [px].
    right : float
        Margin on the right [px].
    """

    def __init__(self, title: str, across: str, up: str, x: Values, y: Values,
                 x_ticks: Values | None = None, height: float = HEIGHT, right: float = 14) -> None:
        self.title, self.height, self.right, self.marks = title, height, right, {}  # type: str, float, float, dict[str, str]
        self.x0, self.x1 = float(np.min(x)), float(np.max(x))
        self.y0, self.y1 = float(np.min(y)), float(np.max(y))
        self.x1 += self.x1 == self.x0
        self.y1 += self.y1 == self.y0
        self.parts: list[str] = []
        frame = [f'<rect class="line" x="{SIDE}" y="{TOP}" width="{WIDTH - SIDE - right:.1f}" height="{height - TOP - FOOT:.1f}" '
                 'fill="none" stroke="#d5d9de"/>']
        for at in ticks(self.x0, self.x1) if x_ticks is None else x_ticks:
            place = self._x(at)
            frame.append(f'<path class="line" d="M{place:.1f} {TOP}V{height - FOOT:.1f}" stroke="#d5d9de"/>'
                         + _text(place, height - FOOT + 16, _number(at)))
        for at in ticks(self.y0, self.y1, 5):
            place = self._y(at)
            frame.append(f'<path class="line" d="M{SIDE} {place:.1f}H{WIDTH - right:.1f}" stroke="#d5d9de"/>'
                         + _text(SIDE - 6, place + 4, _number(at), "end"))
        middle = (TOP + height - FOOT) / 2
        frame += [_text(WIDTH / 2, 20, title), _text((SIDE + WIDTH - right) / 2, height - 14, across),
                  _text(13, middle, up, transform=f"rotate(-90 13 {middle:.1f})")]
        self.frame = frame

    def _x(self, value):
        return SIDE + (WIDTH - SIDE - self.right) * (value - self.x0) / (self.x1 - self.x0)

    def _y(self, value):
        return self.height - FOOT - (self.height - TOP - FOOT) * (value - self.y0) / (self.y1 - self.y0)

    def _path(self, x, y):
        return "M" + "L".join(f"{self._x(a):.1f} {self._y(b):.1f}" for a, b in zip(x, y))

    def line(self, x: Values, y: Values, colour: str, name: str = "", width: float = 2, dash: str = "",
             dots: float = 0) -> None:
        """A line through points; `dots` is their radius, `width` 0 leaves the line out."""
        if width:
            self.parts.append(f'<path d="{self._path(x, y)}" fill="none" stroke="{colour}" stroke-width="{width}"'
                              f'{f""" stroke-dasharray="{dash}" """ if dash else ""}/>')
        if dots:
            self.parts.append("".join(f'<circle cx="{self._x(a):.1f}" cy="{self._y(b):.1f}" r="{dots}" fill="{colour}"/>'
                                      for a, b in zip(x, y)))
        if name:
            self.marks[name] = colour

    def area(self, x: Values, y: Values, colour: str, opacity: float = 1) -> None:
        """A closed outline, filled."""
        self.parts.append(f'<path d="{self._path(x, y)}Z" fill="{colour}" fill-opacity="{opacity}"/>')

    def fits(self, x: float, text: str) -> bool:
        """Whether words beside a point of the data end inside of the axes."""
        return self._x(x) + 10 + _LETTER * len(text) < WIDTH - self.right

    def note(self, x: float, y: float, text: str, colour: str = "currentColor", anchor: str = "start",
             shift: tuple[float, float] = (8, 4)) -> None:
        """Words beside a point of the data, so many pixels to the right and lower."""
        self.parts.append(_text(self._x(x) + shift[0], self._y(y) + shift[1], text, anchor, fill=colour))

    def cells(self, x: Values, y: Values, values: np.ndarray, top: float, unit: str, power: float = 1) -> None:
        """Colours of cells between edges, values (y, x); NaN is left out. `power` below 1 gives small values more colours.

        One path holds all cells of a colour, equal neighbours as one.
        """
        known = np.isfinite(values)
        level = np.where(known, np.minimum(len(STEPS) - 1, len(STEPS) * (np.where(known, values, 0) / top).clip(0, 1) ** power), -1)
        outlines: list[list[str]] = [[] for _ in STEPS]
        columns = [f"{self._x(at):.1f}" for at in x]
        for j, row in enumerate(level.astype(int)):
            up, down = f"V{self._y(y[j + 1]):.1f}H", f"V{self._y(y[j]):.1f}Z"
            starts = np.flatnonzero(np.diff(row, prepend=-2)).tolist()
            for start, end in zip(starts, [*starts[1:], len(row)]):
                if row[start] >= 0:
                    outlines[row[start]].append(f"M{columns[start]} {self._y(y[j]):.1f}H{columns[end]}{up}{columns[start]}{down}")
        self.parts += [f'<path shape-rendering="crispEdges" d="{"".join(paths)}" fill="{colour}"/>'
                       for paths, colour in zip(outlines, STEPS) if paths]
        left, high = WIDTH - self.right + 12, (self.height - TOP - FOOT) / len(STEPS)
        self.parts += [f'<rect shape-rendering="crispEdges" x="{left:.1f}" y="{self.height - FOOT - i * high:.1f}" width="12" '
                       f'height="{high:.1f}" fill="{colour}"/>' for i, colour in enumerate(STEPS, 1)]
        for share in (0, 0.5, 1):
            at = self.height - FOOT - share * high * len(STEPS)
            self.parts.append(_text(left + 16, at + 4, f"{share ** (1 / power) * top:.3g}", "start"))
        self.parts.append(_text(left, TOP - 10, unit, "start"))

    def svg(self) -> str:
        """The picture, with its legend below."""
        marks, foot = _legend([(colour, name) for name, colour in self.marks.items()], WIDTH, self.height + 8)
        return _svg(self.title, WIDTH, foot + 8 if marks else self.height, [*self.frame, *self.parts, *marks])


def polar(title: str, rings: Iterable[tuple[str, str, np.ndarray, np.ndarray]], stems: bool = True) -> str:
    """Values round the axis, as stems or as a closed line.

    Parameters
    ----------
    title : str
    rings : iterable of tuple
        (name, colour, angles [rad], values); angle 0 to the right.
    stems : bool

    Returns
    -------
    str
    """
    size, radius, rings = 300, 105.0, list(rings)
    x0 = y0 = size / 2
    marks_at = ticks(0, max((float(np.max(values, initial=0)) for *_, values in rings), default=0.0) or 1.0, 3)
    top = max(marks_at[-1], max(float(np.max(values, initial=0)) for *_, values in rings)) or 1.0
    parts = [f'<circle class="line" cx="{x0}" cy="{y0}" r="{radius * at / top:.1f}" fill="none" stroke="#d5d9de"/>'
             for at in marks_at[1:]]
    for degrees in range(0, 360, 45):
        c, s = math.cos(math.radians(degrees)), -math.sin(math.radians(degrees))
        parts.append(f'<path class="line" d="M{x0} {y0}L{x0 + radius * c:.1f} {y0 + radius * s:.1f}" stroke="#d5d9de"/>'
                     + _text(x0 + (radius + 17) * c, y0 + (radius + 13) * s + 4, f"{degrees}°"))
    for _, colour, angle, values in rings:
        px, py = x0 + radius * np.cos(angle) * values / top, y0 - radius * np.sin(angle) * values / top
        if stems:
            parts.append(f'<path d="{"".join(f"M{x0} {y0}L{a:.1f} {b:.1f}" for a, b, v in zip(px, py, values) if v > 0)}" '
                         f'stroke="{colour}" stroke-width="1.5"/>')
            parts.append("".join(f'<circle cx="{a:.1f}" cy="{b:.1f}" r="2.6" fill="{colour}"/>' for a, b in zip(px, py)))
        else:
            parts.append(f'<path d="M{"L".join(f"{a:.1f} {b:.1f}" for a, b in zip(px, py))}Z" fill="{colour}" fill-opacity=".25" '
                         f'stroke="{colour}" stroke-width="2"/>')
    slant = math.radians(67)
    parts += [_text(x0 + radius * at / top * math.cos(slant), y0 - radius * at / top * math.sin(slant) + 4, f"{at:.3g}")
              for at in marks_at[1:]]
    marks, foot = _legend([(colour, name) for name, colour, *_ in rings], size, size + 8)
    return _svg(title, size, foot + 8, [_text(x0, 16, title), *parts, *marks], "chart polar")


def bars(title: str, rows: Sequence[tuple[str, str, float]], unit: str) -> str:
    """Bars from the left: (name, colour, value) each, the longest as wide as the chart."""
    longest, parts = max(value for *_, value in rows) or 1.0, []
    high = (HEIGHT - TOP - 14) / len(rows)
    for i, (name, colour, value) in enumerate(rows):
        y, wide = TOP + i * high, max(0.0, (WIDTH - 2 * SIDE - 30) * value / longest)
        parts += [_text(SIDE + 8, y + 0.6 * high, name, "end"),
                  f'<rect x="{SIDE + 16}" y="{y + 0.15 * high:.1f}" width="{wide:.1f}" height="{0.6 * high:.1f}" fill="{colour}"/>',
                  _text(SIDE + 22 + wide, y + 0.6 * high, f"{value:.2g} {unit}", "start")]
    return _svg(title, WIDTH, HEIGHT, [_text(WIDTH / 2, 20, title), *parts])
