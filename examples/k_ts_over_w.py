# SPDX-License-Identifier: GPL-3.0-or-later
"""
K_TS over the radial deformation w
==================================

The cam pushes the cup outward by w. The paper varies w from 0.195 to 0.215 mm. Coarse mesh: 24 x 4 facets.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import hdengine

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4}

study = hdengine.Study(data / "cd14.nml", grid={"wave_generator.w": [0.195e-3, 0.2e-3, 0.205e-3, 0.21e-3, 0.215e-3]},
                       fixed={**COARSE, "load.assembly_steps": 1, "load.torque_steps": 2})
result = study.run(out / "study", show=False)
rows = result.select(torque_nm=5.0)
x = [1e3 * row["wave_generator.w"] for row in rows]
tangent = [row["k_ts_bonded_nm_per_rad"] for row in rows]
eq45 = [row["k_ts_nm_per_rad"] for row in rows]

# %%
# Both readings relative to the first point.

figure, axis = plt.subplots(figsize=(6, 4))
axis.plot(x, [100 * (k / tangent[0] - 1) for k in tangent], "o-", label="tangent")
axis.plot(x, [100 * (k / eq45[0] - 1) for k in eq45], "^-", label="Eq. 45")
axis.set_xlabel("w / mm")
axis.set_ylabel("change of K_TS / %")
axis.legend()
figure.tight_layout()
