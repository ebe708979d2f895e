# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit measured surfaces, told nothing: table of docs/evidence/surfaces.md, record bench/results/measured_surfaces.json.

python bench/measured_surfaces.py FOLDER    (a folder with the files named below; each reads or says why not)
"""
import sys
import warnings
from pathlib import Path

import hdengine
from common import put, table, write_record
from hdengine import specimen

UNITS = {"nanovea_test2.txt": {"unit": ("mm", "um")}, "npl_edm_x_um_z_um.csv": {"unit": "um"}}
SKIP = ("LICENSE", "MANIFEST")


def measure(path):
    """Facts of one file."""
    try:
        s = specimen.read(path, **UNITS.get(path.name, {}))
        f = s.fit()
    except hdengine.HdengineError as e:
        return {"file": path.name, "error": str(e)}
    return {"file": path.name, "points": "x".join(map(str, s.heights.shape)), "spacing_m": s.spacing, "sq_m": s.texture().numbers["sq_m"],
            "notes": list(s.notes), "model": f.model, "d": f.fractal_dimension, "d_interval": f.interval[0], "g_m": f.roughness_m,
            "g_interval_m": f.interval[1], "band_m": f.band_m, "probe_m": f.probe_m, "noise_m": f.noise_m, "misfit": f.misfit,
            "verdict": f.verdict, "kind": f.kind, "reason": f.reason}


def line(row):
    """A row of the table."""
    if "error" in row:
        return (row["file"], *["-"] * 6, row["error"])
    low, high = row["d_interval"]
    g = f"{row['g_m']:.1e}" if low > 2.005 and row["g_m"] > 0 else "-"     # the interval of D reaches 2
    verdict = row["verdict"] + (f" ({row['kind']})" if row["kind"] not in row["verdict"] else "")
    band = " to ".join(f"{1e6 * v:.3g}" for v in row["band_m"])
    return row["file"], row["points"], f"{1e6 * row['sq_m']:.2g}", f"{row['d']:.2f}", f"{low:.2f} to {high:.2f}", g, band, verdict


def main(folder):
    """All files."""
    warnings.simplefilter("ignore")
    rows = [measure(path) for path in sorted(p for p in Path(folder).iterdir() if not p.name.startswith(SKIP))]
    for row in rows:
        print(*line(row), row.get("reason", ""))
    write_record("measured_surfaces", rows)
    put("measured", table(("file", "points", "Sq / µm", "D", "95 %", "G / m", "wavelengths / µm", "verdict"), map(line, rows)), "evidence/surfaces")


if __name__ == "__main__":
    main(sys.argv[1])
