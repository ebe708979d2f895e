# SPDX-License-Identifier: GPL-3.0-or-later
"""
Load of every ball as a polar plot
==================================

The balls of the flexible bearing carry the cup where the cam pushes it outward: around the two ends of the long axis (0 and 180
degrees). Coarse mesh: 24 x 4 facets.
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
balls = run.balls
assembled = balls["step"][balls["phase"] == "assembly"].max()
figure, axis = plt.subplots(figsize=(5.5, 5.5), subplot_kw={"projection": "polar"})
for step in (assembled, balls["step"].max()):
    rows = balls[balls["step"] == step]
    rows = rows[np.argsort(rows["theta_rad"] % (2 * np.pi))]
    theta = rows["theta_rad"] % (2 * np.pi)
    axis.plot(np.append(theta, theta[0]), np.append(rows["force_n"], rows["force_n"][0]), "o-", label=f"{rows['torque_nm'][0]:g} N m")
axis.set_rlabel_position(90)
axis.set_title("force of a ball / N")
axis.legend(loc="lower center", bbox_to_anchor=(0.5, -0.2), ncols=2)
figure.tight_layout()
