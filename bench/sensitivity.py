# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensitivity of K_TS of the scene CD-14-100: tornado charts, band, Sobol indices.

Writes bench/results/sensitivity.json and docs/figures/tornado_{joint,drive}.png.

Usage: python bench/sensitivity.py [--work DIR]
"""
import argparse
import json
import tempfile
from pathlib import Path

import hdengine
from hdengine import uncertainty as u

ROOT = Path(__file__).resolve().parents[1]
SCENE = str(ROOT / "data/cd14.nml")


def main():
    """Run and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", help="folder for the runs (kept, and continued when called again)")
    work = Path(parser.parse_args().work or tempfile.mkdtemp())
    work.mkdir(parents=True, exist_ok=True)
    field = u.ContactField(hdengine.run(SCENE, work / "base.out", True))
    joint = u.joint_tornado(field)
    study = u.one_at_a_time(SCENE, fixed={"load.assembly_steps": 1}).run(work / "drive.out")
    base, drive = u.drive_tornado(study)
    results = {"torque_nm": field.torque_nm, "k_ts_nm_per_rad": field.k_ts(), "joint": joint,
               "joint_band_95": u.joint_band(field), "joint_sobol": u.joint_indices(field),
               "drive_base_nm_per_rad": base, "drive": drive, "drive_failed": len(study.failures)}
    (ROOT / "bench/results/sensitivity.json").write_text(json.dumps(results, indent=1) + "\n")
    u.plot_tornado(field.k_ts(), joint, u.JOINT, "Joint, contact field kept").savefig(
        ROOT / "docs/figures/tornado_joint.png")
    u.plot_tornado(base, drive, u.DRIVE, "Drive, contact solved anew").savefig(ROOT / "docs/figures/tornado_drive.png")
    print(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
