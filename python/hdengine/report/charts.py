# SPDX-License-Identifier: GPL-3.0-or-later
"""The charts of a run's report: of a drive at its reference step, else of its contact; `hdengine plot` draws them for slides."""
from __future__ import annotations

import html
from collections.abc import Iterator

import numpy as np

from ..results import Result
from ..summary_file import has_table
from ..views import run as views
from ..views.palette import COLOURS, PARTS, REFERENCE
from .chart import Chart, bars, polar

__all__: list[str] = []
_ROUND = range(0, 361, 45)


def figure(caption: str, *charts: str) -> str:
    """Charts side by side over their caption."""
    return f'<figure><div class="charts">{"".join(charts)}</div><figcaption>{html.escape(caption)}</figcaption></figure>'


def answer(result: Result) -> str:
    """Figure of a drive's answer: its loop and the parts of its twist."""
    return figure("Torque over the angle of the output, with its chords K1, K2, K3 and the catalogue's; what takes a twist.",
                  _loop_chart(result), *_twist_charts(result))


def _loop_chart(result):
    """Torque over the angle of the output with the chords, beside the catalogue's."""
    loop = views.loop_of(result)
    near = 1 + views.NEAR_CATALOGUE, 1 - views.NEAR_CATALOGUE
    chart = Chart(loop.title, "angle of the output / arc minute", "torque / N m",
                  [*loop.angle, *(loop.stated[0] / near[1])], [*(1.15 * loop.torque), *loop.stated[1]])  # room for the words at K3
    if loop.size:
        angle, torque = loop.stated
        chart.area([*(angle / near[0]), *(angle / near[1])[::-1]], [*torque, *torque[::-1]], REFERENCE, 0.2)
        chart.line(angle, torque, REFERENCE, f"catalogue, size {loop.size}; band: ± {100 * views.NEAR_CATALOGUE:.0f} %", dash="6 4")
    chart.line(loop.angle, loop.torque, COLOURS[0], "computed loop", dots=2)
    for angle, torque, text in loop.chords:
        chart.line(angle, torque, COLOURS[1], "chords", width=3)
        fits = chart.fits(angle.mean(), text)
        chart.note(angle.mean(), torque.mean(), text, COLOURS[1], *(("start", (10, 16)) if fits else ("end", (-24, 2))))
    return chart.svg()


def _twist_charts(result):
    """Shares of a further twist, stacked over the torque where they are known all the way, else those of the reference torque."""
    found = views.twist_of(result)
    if found is None:
        at_reference, title = views.reference_twist(result)
        if at_reference:
            yield bars(title, [(part, PARTS[part], share) for part, share in at_reference.items()], "%")
        return
    torque, shares, title = found
    chart = Chart(title, "torque / N m", "share / %", torque, [0, 100], right=100)
    base, lowest = np.zeros(len(torque)), -np.inf
    places = []
    for name, share in shares.items():
        chart.area([*torque, *torque[::-1]], [*(base + share), *base[::-1]], PARTS[name])
        lowest = max(base[-1] + share[-1] / 2, lowest + 6)
        places.append((name, share[-1], lowest))
        base = base + share
    over = max(0, places[-1][2] - 99)
    for name, share, place in places:
        chart.note(torque[-1], place - over, f"{name} {share:.2g} %")
    yield chart.svg()


def _band_charts(band, slip):
    """Pressure, on request also slip, on the unrolled band."""
    angles = np.linspace(0, 360, len(band.load) + 1)
    fields = [(f"contact pressure at {band.torque:.3g} N m; blank: {band.rest}", band.pressure, "MPa")]
    if slip and band.rest == "open":   # bonded faces do not slip
        fields.append((f"slip at {band.torque:.3g} N m", band.slip, "µm"))
    for title, values, unit in fields:
        chart = Chart(title, "angle from the long axis / degree", "from front edge / mm", angles, band.edges, _ROUND, 230, 64)
        known = values[np.isfinite(values)]
        chart.cells(angles, band.edges, values.T, (np.percentile(known, 99) if len(known) else 0) or 1.0, unit, 0.5)
        yield chart.svg()


def _force_charts(result, band):
    """Line load of the contact, forces of balls and of pairs of teeth, round the axis."""
    middle = (np.arange(len(band.load)) + 0.5) * 2 * np.pi / len(band.load)
    yield polar("line load of the contact / (N/mm)", [(f"{band.torque:.3g} N m", COLOURS[1], middle, band.load)], stems=False)
    for table, title in ((result.balls, "balls: force / N"), (result.teeth, "pairs of teeth: force / N")):
        if table is not None and len(table):
            forces = views.forces_of(result, table)
            colours = (REFERENCE, COLOURS[1])[-len(forces):]
            yield polar(title, [(f"{t:.3g} N m", colour, angle, force) for (t, angle, force), colour in zip(forces, colours)])


def _fatigue_chart(result):
    """Mean stress and amplitude of the cup's points beside Goodman's limit."""
    table, scene = result.fatigue, result.scene
    strength, limit = scene["fatigue.tensile_strength"] / 1e6, scene["fatigue.fatigue_limit"] / 1e6
    mean, amplitude = views.stresses_of(table, scene)
    chart = Chart(f"stress cycle of one turn at {table['torque_nm'][0]:.3g} N m", "mean stress / MPa", "amplitude / MPa",
                  [min(0, mean.min()), strength], [0, max(limit, amplitude.max())])
    chart.line([0, strength], [limit, 0], COLOURS[1], "limit (Goodman)")
    chart.line(mean, amplitude, COLOURS[0], "points of the cup", width=0, dots=2)
    worst = int(np.argmin(table["safety"]))
    chart.line(mean[[worst]], amplitude[[worst]], COLOURS[2], f"least safety {table['safety'][worst]:.2f}", width=0, dots=5)
    return chart.svg()


def _over(title, x, y, across, up) -> Chart:
    """A chart of one line; changes below 5 % are not blown up to its height."""
    middle, y = np.mean(y), np.asarray(y)
    near = [0.95 * middle, 1.05 * middle] if np.ptp(y) < 0.05 * abs(middle) else []
    chart = Chart(title, across, up, x, [*y, *near])
    chart.line(x, y, COLOURS[0], dots=3)
    return chart


def _turning_charts(result):
    """Turn of the bottom and stiffness while the wave generator turns; dotted: one ball on."""
    table = result.turning
    angle, turn = table["wave_generator_deg"], 60 * views.ARCMIN * (table["turn_rad"] - table["turn_rad"].mean())
    for title, values, up in (("turn of the bottom about its mean", turn, "arc second"),
                              ("stiffness, half to all of the torque", table["stiffness_nm_per_rad"] / 1e3, "kN m/rad")):
        chart = _over(title, angle, values, "turn of the wave generator / degree", up)
        for at in views.ball_steps(result, angle[-1]):
            chart.line([at, at], [chart.y0, chart.y1], REFERENCE, width=1, dash="2 4")
        yield chart.svg()


def _torsion_charts(result):
    """Stiffness and rotation over the torque; against the teeth the pairs' shares too."""
    after = np.flatnonzero(result.steps["load_factor"] >= 1 - 1e-9)[0]
    steps, torque = result.steps[after:], result.torque_nm[after:]
    if result.against_teeth:
        loaded = torque != 0
        steps, torque = steps[loaded], torque[loaded]
        yield _over("K_FTS, torque over rotation", torque, result.secant_stiffness()[after:][loaded] / 1e3, "torque / N m",
                    "kN m/rad").svg()
        ends = [(COLOURS[i], t, *views.pair_shares(result, t)) for i, t in enumerate(dict.fromkeys((torque[-1], torque[0])))]
        chart = Chart("share of each pair of teeth", "angle from the long axis / degree", "%",
                      np.concatenate([end[2] for end in ends]), [0, *np.concatenate([end[3] for end in ends])])
        for colour, t, angle, share in ends:
            chart.line(angle, share, colour, f"{t:g} N m", dots=3)
        yield chart.svg()
    else:
        k = steps["k_ts_bonded_nm_per_rad"] / 1e6
        known = np.isfinite(k)
        if known.any():
            chart = Chart("K_TS, tangent", "torque / N m", "MN m/rad", torque, [0, *k[known]])
            chart.line(torque[known], k[known], COLOURS[0], dots=3)
            yield chart.svg()
    yield _over("rotation", torque, 1e6 * steps["rotation_rad"], "torque / N m", "µrad").svg()


def _position_charts(result):
    """Pressure and shear over the angle next to Positions I, II, III."""
    rows = views.positions_of(result)
    angles = (np.arange(result.shape[0]) + 0.5) * 360 / result.shape[0]
    for which, up in ((1, "pressure / MPa"), (2, "shear along θ / MPa")):
        chart = Chart(f"rows of facets at {result.torque_nm[-1]:.3g} N m", "angle from the long axis / degree", up, [0, 360],
                      np.concatenate([row[which] for row in rows]), _ROUND)
        for row, colour in zip(rows, COLOURS):
            chart.line(angles, row[which], colour, row[0], width=1.5)
        yield chart.svg()


def pictures(result: Result) -> Iterator[str]:
    """Figures of a run, those of a drive without its loop, which stands in the answer."""
    if views.is_drive(result):
        band = views.band_of(result)
        yield figure("Contact pressure and slip at the largest torque, on the unrolled band.", *_band_charts(band, True))
        yield figure("Loads round the axis; the long axis lies at 0° and 180°.", *_force_charts(result, band))
        if has_table(result.summary, "fatigue"):
            yield figure("Stress cycle of one turn beside its limit.", _fatigue_chart(result))
        if result.turning is not None and len(result.turning) > 1:
            yield figure("Turn and stiffness while the wave generator turns; dotted: one ball on.", *_turning_charts(result))
        return
    yield figure("Contact pressure on the unrolled band, last step.", *_band_charts(views.band_of(result), False))
    if np.any(result.torque_nm != 0) if result.against_teeth else views.is_assembled(result):
        yield figure("Stiffness and rotation over the torque.", *_torsion_charts(result))
    yield figure("Contact stress over the angle in the rows next to Positions I, II, III.", *_position_charts(result))
