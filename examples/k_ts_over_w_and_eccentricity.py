# SPDX-License-Identifier: GPL-3.0-or-later
"""
K_TS over the radial deformation w and over the eccentricity
============================================================

The cam pushes the cup outward by w. The paper varies w from 0.195 to 0.215 mm, and mounts the cam off the cup's axis by 0 to 10 µm. A
study solves the scene at each value. By the eccentricity the changes stay below one per cent, which is less than this coarse mesh
(24 x 4 facets) can be trusted with.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import hdengine

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4, "load.assembly_steps": 1, "load.torque_steps": 2,
          "load.support": "hub", "wave_generator.ring_tangent": "auto"}   # cup held, ring sliding: the paper's joint on data/cd14.nml

# %%
# Both readings relative to the first point.

figure, axes = plt.subplots(1, 2, figsize=(10, 4))
for axis, key, values, unit, label in (
        (axes[0], "wave_generator.w", [0.195e-3, 0.2e-3, 0.205e-3, 0.21e-3, 0.215e-3], 1e-3, "w / mm"),
        (axes[1], "wave_generator.eccentricity", [0.0, 2.5e-6, 5e-6, 7.5e-6, 10e-6], 1e-6, "eccentricity / µm")):
    result = hdengine.Study(data / "paper.nml", grid={key: values}, fixed=COARSE).run(out / key, show=False)
    rows = result.select(torque_nm=5.0)
    for column, name, mark in (("k_ts_bonded_nm_per_rad", "tangent", "o-"), ("k_ts_nm_per_rad", "Eq. 45", "^-")):
        axis.plot([row[key] / unit for row in rows], [100 * (row[column] / rows[0][column] - 1) for row in rows], mark, label=name)
    axis.set_xlabel(label)
    axis.set_ylabel("change of K_TS / %")
axes[0].legend()
figure.tight_layout()
