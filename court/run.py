#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve every problem of the court, print its table, write bench/results/court.json.

Usage: court/run.py [PROBLEM ...]; with names, only the table of these is printed.
"""
import importlib
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "bench")]

from common import table, write_record  # noqa: E402

PROBLEMS = {
    "roller_on_plane": "NAFEMS 1, roller on a block",
    "rounded_punch": "NAFEMS 2, punch with a rounded edge",
    "block_on_slope": "NAFEMS CGS-4, block on a slope",
    "plate_with_friction": "GRECO's plate with friction",
    "two_spheres": "two spheres",
    "patch_tests": "contact patch tests",
    "oblique_load": "oblique load, then shear",
    "variable_load": "loop of shear under a load that varies",
    "punches": "rigid flat punch",
    "closed_solutions": "closed solutions",
}


def judged(names):
    """Records of problems."""
    records = []
    for name in names:
        problem = importlib.import_module(name)
        start = time.process_time()
        rows = problem.rows()
        seconds = time.process_time() - start
        records += [{"problem": name, "quantity": r.quantity, "unit": r.unit, "reference": r.reference, "ours": float(r.ours),
                     "tolerance": r.tolerance, "verdict": r.verdict, "remark": r.remark, "cpu_s": round(seconds, 2)} for r in rows]
    return records


def lines_of(records):
    """Markdown: the problem stands before its first quantity alone."""
    rows, last = [], None
    for r in records:
        away = abs(r["ours"] - r["reference"])
        share = f"{100 * (r['ours'] / r['reference'] - 1):+.1g} %" if r["reference"] else f"{away:.1g}"
        if away <= 1e-9 * abs(r["reference"]):
            share = "0"
        unit = "" if r["unit"] == "-" else f" {r['unit']}".replace(" um", " µm")
        rows.append((PROBLEMS[r["problem"]] if r["problem"] != last else "", r["quantity"].replace("mu", "µ"), f"{r['reference']:.4g}{unit}",
                     f"{r['ours']:.4g}", share, r["verdict"]))
        last = r["problem"]
    return table(("problem", "quantity", "published", "hdengine", "difference", "verdict"), rows)


def main():
    """Command line."""
    names = sys.argv[1:] or list(PROBLEMS)
    unknown = [n for n in names if n not in PROBLEMS]
    if unknown:
        sys.exit(f"error: no problem '{unknown[0]}'; valid: {', '.join(PROBLEMS)}")
    records = judged(names)
    print(lines_of(records))
    if not sys.argv[1:]:
        write_record("court", records)


if __name__ == "__main__":
    main()
