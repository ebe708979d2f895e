# SPDX-License-Identifier: GPL-3.0-or-later
"""
Share of every pair of teeth
============================

The cup turns against the teeth of the circular spline while its ring is bonded to it. Forty pairs are in mesh, twenty around each end
of the long axis. Coarse mesh: 24 x 4 facets.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import hdengine

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4}

run = hdengine.run(data / "teeth.nml", out / "teeth", True, **COARSE)
teeth = run.teeth[run.teeth["step"] == run.teeth["step"].max()]
teeth = teeth[abs(teeth["theta_rad"]) < np.pi / 2]
print(f"K_FTS {run.secant_stiffness()[-1]:.3g} N m/rad")

figure, axis = plt.subplots(figsize=(6, 4))
axis.bar(np.degrees(teeth["theta_rad"]), 100 * teeth["share"], width=1.3)
axis.set_xlabel("angle from the long axis / degree")
axis.set_ylabel("share of the force / %")
figure.tight_layout()
