#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed against accuracy: for each method the error it reaches over the CPU time it takes, peers beside it, on one page.

Usage: bench/pareto.py [--quick | --draw] [CHART ...]; writes bench/results/pareto.json, and from it a figure for each chart. A chart
that is named is measured anew, the others keep their record; --draw measures nothing.
FINUFFT (PyPI) and CalculiX (Debian package calculix-ccx) are drawn where they are installed.
"""
import argparse
import json
import re
import time
from dataclasses import asdict

import numpy as np
from matplotlib.ticker import NullFormatter
from pareto_charts import CHARTS

from common import RESULTS, new_axes, save_figure, write_record
from hdengine import _engine, read_scene


def charted():
    """Keys whose default a chart chose, with its heading."""
    found = {}
    for key in read_scene():
        told = re.search(r'chosen by the chart "(.*)" of', _engine.call_text("explain_text", key))
        if told:
            found[key] = told[1]
    return found


def draw(chart):
    """A chart as figure: error over CPU seconds, a star for the default, hollow marks for peers."""
    methods = list(dict.fromkeys(p["method"] for p in chart["points"]))
    columns = 1 if max(map(len, methods)) > 32 else 2
    figure, ax = new_axes(figsize=(5.0, 3.2 + 0.21 * -(-len(methods) // columns)))
    for method in methods:
        mine = [p for p in chart["points"] if p["method"] == method]
        peer = mine[0]["peer"]
        line, = ax.plot([p["seconds"] for p in mine], [p["error"] for p in mine], "o--" if peer else "o-", ms=6,
                        mfc="white" if peer else None, lw=1.2, label=method)
        for p in mine:
            if p["default"]:
                ax.plot(p["seconds"], p["error"], "*", ms=17, color=line.get_color(), mec="black", zorder=4)
    ax.set(xscale="log", yscale="log", xlabel="CPU time / s", ylabel="relative error")
    for axis, limit in ((ax.xaxis, ax.set_xlim), (ax.yaxis, ax.set_ylim)):
        low, high = axis.get_view_interval()
        limit(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))   # whole decades have labels enough
        axis.set_minor_formatter(NullFormatter())
    figure.legend(*ax.get_legend_handles_labels(), fontsize=9, loc="outside lower center", ncols=columns, columnspacing=1)
    save_figure(figure, f"speed/{chart['name']}", dpi=80)


def shown(error):
    """A relative error: per cent, or a power of ten below 0.01 %."""
    return f"{100 * error:.0f} %" if error >= 0.095 else f"{100 * error:.1g} %" if error >= 1e-4 else f"{error:.0e}".replace("e-0", "e-")


def default_of(points):
    """Error and CPU time of the default, as ranges where it has several points."""
    mine = [p for p in points if p["default"]]

    def span(values, form):
        ends = [form(v) for v in (min(values), max(values))]
        return ends[0] if ends[0] == ends[1] else " to ".join(ends)
    return span([p["error"] for p in mine], shown), span([p["seconds"] for p in mine], lambda s: f"{s:.2g}")


def section(chart):
    """A chart on its page: heading, what it decides, the figure."""
    error, seconds = default_of(chart["points"])
    return (f"## {chart['title']}\n\n{chart['decides']} The default errs by {error} in {seconds} s.\n\n"
            f"![Relative error over CPU time](../figures/speed/{chart['name']}.png)")


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("charts", nargs="*", choices=[c.__name__ for c in CHARTS] + [[]])
    parser.add_argument("--quick", action="store_true", help="smaller sizes")
    parser.add_argument("--draw", action="store_true", help="figures from the record")
    options = parser.parse_args()
    path = RESULTS / "pareto.json"
    whole = json.loads(path.read_text()) if path.exists() else {"charts": []}
    old = {c["name"]: c for c in whole["charts"]}
    if options.draw:
        for c in old.values():
            draw(c)
        return
    charts = []
    for make in CHARTS:
        name = make.__name__
        if options.charts and name not in options.charts:
            if name in old:
                charts.append(old[name])
            continue
        start = time.time()
        charts.append(asdict(make(options.quick)))
        print(f"{name}: {len(charts[-1]['points'])} points, {time.time() - start:.0f} s", flush=True)
    known = charted()
    scene = {key: value for key, value in read_scene().items() if key in known}
    kept = {"commit": whole["provenance"]["commit"]} if options.charts and old else {}  # of the charts that were not measured
    write_record("pareto", {"charts": charts, "defaults": scene}, **kept)
    for c in charts:
        draw(c)


if __name__ == "__main__":
    main()
