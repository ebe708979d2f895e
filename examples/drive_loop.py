# SPDX-License-Identifier: GPL-3.0-or-later
"""
From a catalogue size to K1, K2, K3 with its loop
=================================================

A whole drive of size 14 turns up to 7.8 N m, to -7.8 N m and up again. K1, K2 and K3, as catalogues have them, are chords of the last
rise. The mesh is coarse (24 x 4 facets, 4 steps per leg): K1 comes out a
quarter higher than on that of ``data/drive14.nml``, K2 and K3 by 6 and 8 %.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import hdengine
from hdengine.catalogue import UNITS

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4}

run = hdengine.run(data / "drive14.nml", out / "drive", True, **COARSE, load__torque_steps=4)
results = run.summary["results"]
for k in (1, 2, 3):
    print(f"K{k} {results[f'k{k}_nm_per_rad'] / 1e3:.1f} kN m/rad")

# %%
# The dashed line is the catalogue's: 4.7, 6.1 and 7.1 kN m/rad. On its own mesh the drive has 4.4, 5.8 and 9.4.

loop = run.loop[run.loop["phase"] != "assembly"]
arcmin = np.degrees(loop["angle_rad"]) * 60
torque = np.linspace(0, run.scene["load.torque"], 50)
figure, axis = plt.subplots(figsize=(6, 4.5))
axis.plot(arcmin, loop["torque_nm"], "o-", label="hdengine")
axis.plot(np.degrees(UNITS[14].angle(torque)) * 60, torque, "k--", label="catalogue")
axis.set_xlabel("angle of the bottom / arc minute")
axis.set_ylabel("torque / N m")
axis.legend()
figure.tight_layout()
