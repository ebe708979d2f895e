# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit measured surfaces and write the table of docs/evidence/verification.md.

python bench/measured_surfaces.py FOLDER    (a folder with the files named below; each reads or says why not)
"""
import sys
import warnings
from pathlib import Path

import hdengine
from common import write_record
from hdengine import specimen

UNITS = {"nanovea_test2.txt": {"unit": ("mm", "um")}, "npl_edm_x_um_z_um.csv": {"unit": "um"},
         "npl_sine.xml": {"unit": "um", "spacing": 0.5e-6}}
SKIP = ("LICENSE", "MANIFEST")


def main(folder):
    warnings.simplefilter("ignore")
    rows = []
    for path in sorted(p for p in Path(folder).iterdir() if not p.name.startswith(SKIP)):
        row = {"file": path.name}
        try:
            s = specimen.read(path, **UNITS.get(path.name, {}))
            row |= {"points": "x".join(map(str, s.heights.shape)), "spacing_m": s.spacing, "sq_m": s.parameters()["sq_m"],
                    "notes": list(s.notes), "windows": []}
            for lags in ((1, 20), (5, 50)):
                f = s.fit(lags=lags)
                row["windows"].append({
                    "lags": lags, "tau_max_m": f.tau_m.max(), "d": f.fractal_dimension, "d_error": f.fractal_dimension_error,
                    "g_m": f.roughness_m, "ln_g_error": f.ln_roughness_error, "anisotropy": f.anisotropy, "misfit": f.misfit,
                    "verdict": f.verdict, "kind": f.kind, "reason": f.reason})
        except hdengine.HdengineError as e:
            row["error"] = str(e)
        rows.append(row)
        print(f"{row['file']:25s}", row.get("error") or f"{row['points']} Sq {row['sq_m']:.3g} {row['notes']}")
        for w in row.get("windows", ()):
            print(f"    {w['lags']} D {w['d']:.3f} +- {1.96 * w['d_error']:.3f} G {w['g_m']:.3g} (x/ {1.96 * w['ln_g_error']:.2g} in ln)"
                  f" S_x/S_y {w['anisotropy']:.2f} {w['verdict']} ({w['kind']}): {w['reason']}")
    write_record("measured_surfaces", rows)
    table = ["| file | points | Sq / µm | lags | D ± 95 % | G / m | S_x/S_y | verdict |", "|---|---|---|---|---|---|---|---|"]
    for row in rows:
        for w in row.get("windows", ()):
            ratio = f"{w['anisotropy']:.2f}" if w["anisotropy"] == w["anisotropy"] else "-"
            verdict = w["verdict"] + (f" ({w['kind']})" if w["kind"] not in w["verdict"] else "")
            table.append(f"| {row['file']} | {row['points']} | {1e6 * row['sq_m']:.3g} | {w['lags'][0]}-{w['lags'][1]} | "
                         f"{w['d']:.2f} ± {1.96 * w['d_error']:.2f} | {w['g_m']:.2g} | {ratio} | {verdict} |")
    print("\n".join(table))


main(sys.argv[1])
