# SPDX-License-Identifier: GPL-3.0-or-later
"""
K_TS over the eccentricity
==========================

The cam is mounted off the cup's axis by 0 to 10 µm. A study solves the scene at each value. The changes stay below one
per cent, which is less than this coarse mesh (24 x 4 facets) can be trusted with.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import hdengine

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4}

study = hdengine.Study(data / "cd14.nml", grid={"wave_generator.eccentricity": [0.0, 2.5e-6, 5e-6, 7.5e-6, 10e-6]},
                       fixed={**COARSE, "load.assembly_steps": 1, "load.torque_steps": 2})
result = study.run(out / "study", show=False)
rows = result.select(torque_nm=5.0)
x = [1e6 * row["wave_generator.eccentricity"] for row in rows]
tangent = [row["k_ts_bonded_nm_per_rad"] for row in rows]
eq45 = [row["k_ts_nm_per_rad"] for row in rows]

# %%
# Both readings relative to the first point.

figure, axis = plt.subplots(figsize=(6, 4))
axis.plot(x, [100 * (k / tangent[0] - 1) for k in tangent], "o-", label="tangent")
axis.plot(x, [100 * (k / eq45[0] - 1) for k in eq45], "^-", label="Eq. 45")
axis.set_xlabel("eccentricity / µm")
axis.set_ylabel("change of K_TS / %")
axis.legend()
figure.tight_layout()
