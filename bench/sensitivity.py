#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sobol indices of the tangent K_TS with every input of `hdengine.uncertainty` at once, each point solved anew, by SALib.

The mesh is coarse: 24 divisions and 4 rows. The same indices by one-at-a-time factors (`drive_bands`) stand beside them.
Writes bench/results/sensitivity.json. Usage: bench/sensitivity.py [--base N] [--work DIR]
"""
import argparse
import tempfile
from importlib import metadata
from pathlib import Path

import numpy as np
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as sampling

import hdengine
from common import ROOT, write_record
from hdengine import uncertainty

SCENE = str(ROOT / "data/cd14.nml")
FIXED = {"mesh.divisions": 24, "mesh.band_facets": 4, "load.torque_steps": 2, "output.vtu": "none"}
JOINT = {key: uncertainty.JOINT[key] for key in ("joint.fractal_dimension", "joint.roughness", "joint.hardness")}  # what the model spectrum takes
RANGES = uncertainty.ranges_of(hdengine.read_scene(SCENE), JOINT | uncertainty.DRIVE)
COLUMN = "k_ts_bonded_nm_per_rad"


def tangent(keys, work):
    """Tangent of one point, kept in a file of the folder so that a stopped call goes on where it was."""
    kept = work / f"tangent_{hash(tuple(keys.values())):x}"
    if not kept.exists():
        kept.write_text(repr(hdengine.run(SCENE, work / "point.out", True, **FIXED, **keys).summary["results"][COLUMN]))
    return float(kept.read_text())


def by_factors(work):
    """Shares by factors, from one input at a time over the same ranges."""
    one = uncertainty.one_at_a_time(SCENE, RANGES, FIXED).run(Path(work) / "one.out", show=False)
    middle, _ = uncertainty.drive_tornado(one, RANGES, COLUMN)
    curves = uncertainty.drive_curves(one, RANGES, COLUMN)
    _, shares = uncertainty.drive_bands(uncertainty.drive_factors(curves, RANGES), middle)
    return {"share_by_factors": {key: round(share, 4) for key, share in shares.items()}}


def measure(base, work, seed=1):
    """Indices of every input, all drawn at once."""
    problem = {"num_vars": len(RANGES), "names": list(RANGES), "bounds": [list(r[:2]) for r in RANGES.values()]}
    points = sampling.sample(problem, base, calc_second_order=False, seed=seed)
    y = np.array([tangent(dict(zip(RANGES, map(float, point))), Path(work)) for point in points])
    s = analysis.analyze(problem, np.log(y), calc_second_order=False, seed=seed)
    rows = [{"input": key, **{name: round(float(s[name][i]), 4) for name in ("ST", "ST_conf")}} for i, key in enumerate(RANGES)]
    return {"fixed": FIXED, "base": base, "band_95_nm_per_rad": [float(f"{v:.5g}") for v in np.quantile(y, (0.025, 0.975))],
            "indices": sorted(rows, key=lambda r: -r["ST"])}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--base", type=int, default=64, help="power of 2")
    parser.add_argument("--work", help="folder of the runs (kept, and continued when called again)")
    args = parser.parse_args()
    work = Path(args.work or tempfile.mkdtemp())
    work.mkdir(exist_ok=True)
    write_record("sensitivity", measure(args.base, work) | by_factors(work), seed=1, salib=metadata.version("SALib"))


if __name__ == "__main__":
    main()
