#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the pages that the package draws by itself: joint of the paper, two specimens, a record.

The README's picture of the drive comes from docs/drawings/pressure_cup.py, where PyVista is installed. Usage: bench/page_figures.py
"""
import importlib.util
import subprocess
import sys

import numpy as np

from common import DATA, FIGURES, ROOT, save_figure, write_record
from hdengine import Joint, roughness, specimen
from hdengine.figures.joint import plot_joint
from hdengine.record import Record


def main():
    """Draw all."""
    save_figure(plot_joint(Joint(asperity_radius=250e-6, s_min=1e-15), np.logspace(-3, 3.2, 200) * 1e6).figure, "joint_stiffness")
    parts = [specimen.read(DATA / f"specimen_{name}.sdf") for name in ("flexspline", "bearing")]
    waves = roughness.Ridges(length=0.5e-3, shortest_wavelength=1e-6, ridges=10, gamma=1.5)
    specimen.equivalent(*parts, surface=waves).plot().savefig(FIGURES / "joint_surface.png", dpi=80)
    save_figure(Record.read(DATA / "torque_record.csv").plot(), "record")
    drawn = ["joint_stiffness", "joint_surface", "record"]
    if importlib.util.find_spec("pyvista"):
        drawn.append("pressure_cup")
        subprocess.run([sys.executable, ROOT / "docs/drawings/pressure_cup.py"], check=True)
    else:
        print("pressure_cup.png is kept: it needs PyVista (pip install 'hdengine[report]')")
    write_record("page_figures", {"figures": drawn})


if __name__ == "__main__":
    main()
