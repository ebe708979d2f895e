# SPDX-License-Identifier: GPL-3.0-or-later
"""
K_TS over the torque
====================

K_TS can be read in three ways. The tangent is what a test would measure with a small further torque. The secant counts from the end of
the assembly. Eq. 45 of the paper takes every facet as stiff as just before it slips. Coarse mesh: 24 x 4 facets.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import hdengine

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4}

run = hdengine.run(data / "cd14.nml", out / "torque", True, **COARSE)
steps = run.steps[run.steps["torque_nm"] > 0]
figure, axis = plt.subplots(figsize=(6, 4))
for name, label in (("k_ts_bonded_nm_per_rad", "tangent"), ("k_ts_secant_nm_per_rad", "secant"), ("k_ts_nm_per_rad", "Eq. 45")):
    axis.plot(steps["torque_nm"], steps[name] / 1e6, "o-", label=label)
axis.set_yscale("log")
axis.set_xlabel("torque / N m")
axis.set_ylabel("K_TS / (MN m/rad)")
axis.legend()
figure.tight_layout()
