# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensitivity of K_TS of the scene CD-14-100, as `hdengine sensitivity cd14.out --drive`: tornado charts, bands, Sobol indices.

Writes bench/results/sensitivity.json, the tables of docs/evidence/sensitivity.md and docs/figures/tornado_{joint,drive}.png.

Usage: python bench/sensitivity.py [--work DIR]
"""
import argparse
import shutil
import tempfile
from pathlib import Path

import hdengine
from common import ROOT, put, table, write_record
from hdengine import uncertainty


def main():
    """Run and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", help="folder for the runs (kept, and continued when called again)")
    out = Path(parser.parse_args().work or tempfile.mkdtemp()) / "base.out"
    if not (out / "summary.json").is_file():
        hdengine.run(str(ROOT / "data/cd14.nml"), out, True)
    found = uncertainty.analyse(out, drive=True)
    write_record("sensitivity", found)
    for name in ("tornado_joint.png", "tornado_drive.png"):
        shutil.copy(out / name, ROOT / "docs/figures")
    put("bands", table(("what varies", "95 % band of K_TS / (MN m/rad)", "median"), [
        (name, f"{low / 1e6:.2f} to {high / 1e6:.2f}", f"{median / 1e6:.2f}")
        for name, (low, median, high) in found["bands_95_nm_per_rad"].items()]), "evidence/sensitivity")
    put("indices", table(("input", "first order", "total"), [
        (f"`{key}`", f"{first:.2f} ± {a:.2f}", f"{total:.2f} ± {b:.2f}") for key, (first, a, total, b) in found["indices"].items()]),
        "evidence/sensitivity")


if __name__ == "__main__":
    main()
