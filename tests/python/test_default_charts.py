# SPDX-License-Identifier: GPL-3.0-or-later
"""Defaults that a measurement chose: each names its chart, and none changes without the record that shows it."""
import json
import re

import hdengine
from conftest import ROOT
from hdengine import _engine

RECORD = json.loads((ROOT / "bench/results/pareto.json").read_text())
PAGE = (ROOT / "docs/evidence/speed_accuracy.md").read_text()


def charts():
    """Heading of the chart by key."""
    told = {key: re.search(r'chosen by the chart "(.*)" of (\S+)', _engine.call_text("explain_text", key)) for key in hdengine.read_scene()}
    return {key: t[1] for key, t in told.items() if t}


def test_every_method_names_its_chart():
    """Keys that choose a method or a fineness say in --explain which chart chose their default; the page shows that chart, eight at most."""
    named = charts()
    assert {"mesh.element", "solver.method", "solver.factors", "surface.method", "fit.model", "joint.model", "run.tolerance"} <= set(named)
    assert all(f"\n## {heading}\n" in PAGE for heading in named.values()) and len(RECORD["charts"]) <= 8


def test_no_default_changes_without_its_record():
    """The record of the charts was made with the defaults of today: after a change `./hd bench pareto` is due."""
    today = hdengine.read_scene()
    assert RECORD["defaults"] == {key: today[key] for key in charts()}


def test_charts_have_a_default():
    """Every chart marks the default among its points."""
    assert [c["name"] for c in RECORD["charts"] if not any(p["default"] for p in c["points"])] == []
