#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed against accuracy: for each method the error it reaches over the CPU time it takes, peers beside it, on one page.

Usage: bench/pareto.py [--quick] [CHART ...]; writes bench/results/pareto.json, docs/figures/pareto.png and the tables of
docs/evidence/speed_accuracy.md. A chart that is named is measured anew, the others keep their record.
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

from common import FIGURES, RESULTS, new_axes, put, table, write_record
from hdengine import _engine, read_scene


def charted():
    """Keys whose default a chart chose, with its heading."""
    found = {}
    for key in read_scene():
        told = re.search(r'chosen by the chart "(.*)" of', _engine.call_text("explain_text", key))
        if told:
            found[key] = told[1]
    return found


def draw(charts):
    """All charts in one style: error over CPU seconds, a star for the default, hollow marks for peers."""
    columns = 3
    figure, axes = new_axes(-(-len(charts) // columns), columns, figsize=(16, 4.6 * -(-len(charts) // columns)))
    for ax, chart in zip(axes.flat, charts):
        for method in dict.fromkeys(p["method"] for p in chart["points"]):
            mine = [p for p in chart["points"] if p["method"] == method]
            peer = mine[0]["peer"]
            line, = ax.plot([p["seconds"] for p in mine], [p["error"] for p in mine], "o--" if peer else "o-", ms=6,
                            mfc="white" if peer else None, lw=1.2, label=method)
            for p in mine:
                if p["default"]:
                    ax.plot(p["seconds"], p["error"], "*", ms=17, color=line.get_color(), mec="black", zorder=4)
        ax.set(xscale="log", yscale="log", xlabel="CPU time / s", ylabel="relative error", title=chart["title"])
        ax.title.set_fontsize(12)
        for axis in (ax.xaxis, ax.yaxis):
            low, high = axis.get_view_interval()
            if high > 10 * low:   # one decade has labels enough
                axis.set_minor_formatter(NullFormatter())
        ax.tick_params(axis="x", which="minor", labelsize=8, labelrotation=40)
        ax.legend(fontsize=8)
    for ax in axes.flat[len(charts):]:
        ax.remove()
    figure.savefig(FIGURES / "pareto.png", dpi=80)


def page(charts):
    """Sentences and tables of the page."""
    parts = []
    for c in charts:
        rows = [(p["method"], p["setting"] or "-", f"{p['error']:.1e}", f"{p['seconds']:.3g}",
                 "-" if np.isnan(p["memory_mb"] or np.nan) else f"{p['memory_mb']:.0f}", "default" if p["default"] else "peer" if p["peer"] else "")
                for p in c["points"]]
        parts.append(f"## {c['title']}\n\n{c['decides']}\n\n" + table(("method", "setting", "error", "CPU s", "MB", ""), rows))
    return "\n\n".join(parts)


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("charts", nargs="*", choices=[c.__name__ for c in CHARTS] + [[]])
    parser.add_argument("--quick", action="store_true", help="smaller sizes")
    options = parser.parse_args()
    path = RESULTS / "pareto.json"
    old = {c["name"]: c for c in json.loads(path.read_text())["charts"]} if path.exists() else {}
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
    for c in charts:
        for p in c["points"]:
            p["memory_mb"] = None if p["memory_mb"] is None or np.isnan(p["memory_mb"]) else p["memory_mb"]
    known = charted()
    scene = {key: value for key, value in read_scene().items() if key in known}
    write_record("pareto", {"charts": charts, "defaults": scene})
    for c in charts:
        for p in c["points"]:
            p["memory_mb"] = np.nan if p["memory_mb"] is None else p["memory_mb"]
    draw(charts)
    put("charts", page(charts), "evidence/speed_accuracy")


if __name__ == "__main__":
    main()
