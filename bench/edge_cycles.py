#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Does Newton's method settle where cells at the edges are short? Every second scene of promised_scenes.py on two meshes with edge cells
of a 768th of the band, one load step of assembly and torque, residual 1e-8, no halvings.

Usage: bench/edge_cycles.py [--count 200] [--first 0] [--every 2]; one row a run: iterations and softened load steps, or the message.
Writes bench/results/edge_cycles.json.
"""
import argparse
from tempfile import TemporaryDirectory

from promised_scenes import draw, solve

from common import write_record
from hdengine import HdengineError

MESHES = ((64, 12, 1), (96, 16, 4))  # divisions, rows, layers


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--every", type=int, default=2)
    args = parser.parse_args()
    rows = []
    print("| scene | divisions | iterations | load steps with cycles |\n|---|---|---|---|")
    with TemporaryDirectory() as folder:
        for i in range(args.first, args.count, args.every):
            for divisions, facets, layers in MESHES:
                data, keys = draw(i)
                keys |= {"mesh.divisions": divisions, "mesh.band_facets": facets, "mesh.edge_length": keys["geometry.band_length"] / 768,
                         "mesh.through_wall": layers, "mesh.through_ring": layers, "load.assembly_steps": 1, "load.torque_steps": 1,
                         "solver.tolerance": 1e-8, "solver.max_cuts": 0, "solver.kinematics": "linear"}
                row = {"scene": i, "divisions": divisions}
                try:
                    results = solve(data, keys, folder)[0].summary["results"]
                    row |= {"iterations": results["iterations"], "cycles": results["cycles"]}
                except HdengineError as e:
                    row["message"] = str(e)[:80]
                rows.append(row)
                print(f"| {' | '.join(map(str, row.values()))} |", flush=True)
    print(f"{sum('message' in row for row in rows)} of {len(rows)} did not converge")
    write_record("edge_cycles", rows)


if __name__ == "__main__":
    main()
