# SPDX-License-Identifier: GPL-3.0-or-later
"""
Stress cycle and Goodman's safety along the meridian
====================================================

As the cam turns, every point of the cup meets the stresses of the whole circumference. Their mean and amplitude give the safety against
fatigue by Goodman's line. Coarse mesh (24 x 4 facets): the peaks at the ring's edges grow on a finer one, and tooth roots are not in it.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import hdengine

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4, "run.band": False}

run = hdengine.run(data / "drive14.nml", out / "drive", True, **COARSE, loop__torques=[14], load__torque_steps=4)
points = run.fatigue
outside = np.array([points["z_m"] == z for z in np.unique(points["z_m"])])
worst = np.array([points[rows][np.argmin(points["safety"][rows])] for rows in outside], points.dtype)
print(f"least safety {points['safety'].min():.2f} at z = {1e3 * points['z_m'][np.argmin(points['safety'])]:.1f} mm")

figure, axes = plt.subplots(1, 2, figsize=(10, 4))
axes[0].plot(1e3 * worst["z_m"], worst["amplitude_pa"] / 1e6, "o-", label="amplitude")
axes[0].plot(1e3 * worst["z_m"], worst["mean_pa"] / 1e6, "^-", label="mean")
axes[0].set_ylabel("signed von Mises stress / MPa")
axes[0].legend()
axes[1].plot(1e3 * worst["z_m"], worst["safety"], "o-")
axes[1].axhline(1, color="k", lw=1)
axes[1].set_ylim(bottom=0)
axes[1].set_ylabel("safety (worst point through the thickness)")
for axis in axes:
    axis.set_xlabel("distance from the opening / mm")
figure.tight_layout()
