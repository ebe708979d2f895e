#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve every problem of the court, print its table, write bench/results/court.json and the table of docs/evidence/court.md.

Usage: court/run.py [PROBLEM ...]; with names, only the table of these is printed.
"""
import importlib
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "bench")]

from common import put, write_record  # noqa: E402

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
}


def table(names):
    """Markdown rows and records of problems."""
    lines = ["| problem | quantity | published | hdengine | difference | verdict |", "|---|---|---|---|---|---|"]
    records = []
    for name in names:
        problem = importlib.import_module(name)
        start = time.process_time()
        rows = problem.rows()
        seconds = time.process_time() - start
        for r in rows:
            unit = "" if r.unit == "-" else f" {r.unit}"
            error = f"{100 * r.error:+.2g} %" if r.reference else f"{r.ours:.2g}"
            lines.append(f"| {PROBLEMS[name]} | {r.quantity} | {r.reference:.6g}{unit} | {r.ours:.6g}{unit} | {error} | {r.verdict} |")
            records.append({"problem": name, "quantity": r.quantity, "unit": r.unit, "reference": r.reference, "ours": float(r.ours),
                            "tolerance": r.tolerance, "verdict": r.verdict, "remark": r.remark, "cpu_s": round(seconds, 2)})
    return lines, records


def main():
    """Command line."""
    names = sys.argv[1:] or list(PROBLEMS)
    unknown = [n for n in names if n not in PROBLEMS]
    if unknown:
        sys.exit(f"error: no problem '{unknown[0]}'; valid: {', '.join(PROBLEMS)}")
    lines, records = table(names)
    print("\n".join(lines))
    if not sys.argv[1:]:
        write_record("court", records)
        put("table", "\n".join(lines), "evidence/court")


if __name__ == "__main__":
    main()
