# SPDX-License-Identifier: GPL-3.0-or-later
"""
A sweep of two inputs as a scatter plot
=======================================

A study solves every combination of its grid. Each point here is one drive: interference and friction vary, and the normal force and the
tangent K_TS follow. Coarse mesh: 24 x 4 facets.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import hdengine

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4}

study = hdengine.Study(data / "cd14.nml", fixed={**COARSE, "load.assembly_steps": 1, "load.torque_steps": 2},
                       grid={"wave_generator.interference": [5e-6, 10e-6, 15e-6], "contact.friction": [0.05, 0.1, 0.15, 0.2]})
result = study.run(out / "sweep", show=False)
print(result)
rows = result.select(torque_nm=5.0)

figure, axis = plt.subplots(figsize=(6, 4.5))
shown = axis.scatter([row["normal_force_n"] / 1e3 for row in rows], [row["k_ts_bonded_nm_per_rad"] / 1e6 for row in rows],
                     c=[row["contact.friction"] for row in rows], s=60)
figure.colorbar(shown, label="friction")
axis.set_xlabel("normal force / kN")
axis.set_ylabel("tangent K_TS / (MN m/rad)")
figure.tight_layout()
