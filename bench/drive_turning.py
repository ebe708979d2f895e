# SPDX-License-Identifier: GPL-3.0-or-later
"""The turning wave generator of the whole drive of size 14: angle error and ripple of the stiffness over one ball, and what they owe
to balls, teeth and mesh. Table of docs/evidence/drive_trends.md, figure turning.png, raw figures in bench/results/drive_turning.json.

Usage: python bench/drive_turning.py
"""
import tempfile

import numpy as np

from common import DATA, put, save_figure, solve, table, write_record
from hdengine import load
from hdengine.figures.drive import plot_turning

ARCSEC = np.degrees(1) * 3600
BASE = {"turning.positions": 24, "loop.torques": 1, "load.torque_steps": 1}
PITCH = 360 / 21 * 29.8 / 16.5 / 1.01  # turn of the wave generator from one ball to the next [degree]
CASES = (("as it stands, 86 x 15 facets", {}), ("48 x 8 facets", {"mesh.divisions": 48, "mesh.band_facets": 8}),
         ("172 x 30 facets", {"mesh.divisions": 172, "mesh.band_facets": 30}),
         ("rigid cam, no balls", {"bearing.balls": 0, "turning.range_deg": PITCH}),
         ("20 balls", {"bearing.balls": 20}), ("ring 0.8 mm thick", {"geometry.ring_thickness": 0.8e-3}),
         ("clearance of the balls 5 µm", {"bearing.clearance": 5e-6}), ("pairs half as stiff", {"load.tooth_stiffness": 6.25e7}))


def run(name, keys):
    """Turns and stiffnesses of a case; the first one is drawn."""
    with tempfile.TemporaryDirectory() as folder:
        _, command = solve(DATA / "drive14.nml", *(f"{k}={v}" for k, v in {**BASE, **keys}.items()), out=f"{folder}/r")
        if command.code != 0:
            raise SystemExit(command.text)
        result = load(f"{folder}/r")
        rows = result.turning
        if not keys:
            save_figure(plot_turning(result), "turning")
        print(name, command.wall_s, flush=True)
        return {"case": name, "turn_rad": rows["turn_rad"].tolist(), "stiffness_nm_per_rad": rows["stiffness_nm_per_rad"].tolist(),
                "ball_force_max_n": float(rows["ball_force_max_n"].max()), "seconds": result.summary["timers_s"]["turning"]}


def main():
    """Solve, write, draw."""
    rows = [run(*case) for case in CASES]
    write_record("drive_turning", {"cases": rows}, threads=1)
    put("drive turning", table(("case", "turn of the bottom", "angle error", "stiffness in kN m/rad", "its ripple"), [
        (r["case"], f"{ARCSEC * np.mean(r['turn_rad']):.1f}''", f"{ARCSEC * np.ptp(r['turn_rad']):.2f}''",
         f"{min(r['stiffness_nm_per_rad']) / 1e3:.2f} to {max(r['stiffness_nm_per_rad']) / 1e3:.2f}",
         f"{100 * np.ptp(r['stiffness_nm_per_rad']) / np.mean(r['stiffness_nm_per_rad']):.1f} %") for r in rows]),
        page="evidence/drive_trends")


if __name__ == "__main__":
    main()
