# SPDX-License-Identifier: GPL-3.0-or-later
"""
From two height maps to K_TS with a band
========================================

Two measured surfaces give the stiffness law of the joint between them. A run on that law gives K_TS, the torsional stiffness of the
contact. The mesh is coarse (24 x 4 facets): the figures show the way, not the last per cent.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import hdengine
from hdengine import specimen
from hdengine.prediction.law import predict

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4}

# %%
# The maps of ``data/`` are synthetic. ``specimen.read`` takes other formats too.

maps = [specimen.read(data / f"specimen_{name}.sdf") for name in ("flexspline", "bearing")]
law = predict(*maps, model="spectrum")
print(law)

# %%
# ``joint.csv`` is the law with its 95 % band. A run per column gives the band of K_TS; the contact itself is the same in all of them.

law.write(out / "joint")
table = np.genfromtxt(out / "joint/joint.csv", delimiter=",", names=True)
k_ts = {}
for name in ("k_n_pa_per_m_low", "k_n_pa_per_m", "k_n_pa_per_m_high"):
    share = table[name] / table["k_n_pa_per_m"]
    rows = np.column_stack([table["pressure_pa"], table["k_n_pa_per_m"] * share, table["k_t_pa_per_m"] * share])
    np.savetxt(out / f"{name}.csv", rows, delimiter=",", comments="", header="pressure_pa,k_n_pa_per_m,k_t_pa_per_m")
    run = hdengine.run(data / "cd14.nml", out / name, True, **COARSE,
                       joint={"model": "table", "table_file": str((out / f"{name}.csv").absolute())})
    k_ts[name] = run.steps["k_ts_bonded_nm_per_rad"][-1]
low, middle, high = k_ts.values()
print(f"tangent K_TS at 5 N m: {middle:.3g} N m/rad, 95 % band {low:.3g} to {high:.3g}")

# %%
# The band holds the surfaces and the theory of the joint. It does not hold the mesh or the unknown sizes of the drive.

figure, axes = plt.subplots(1, 2, figsize=(10, 4))
shown = axes[0].imshow(1e6 * maps[0].heights)
figure.colorbar(shown, label="height / µm")
axes[0].set_title("flexspline")
axes[1].loglog(table["pressure_pa"] / 1e6, table["k_n_pa_per_m"] / 1e12)
axes[1].fill_between(table["pressure_pa"] / 1e6, table["k_n_pa_per_m_low"] / 1e12, table["k_n_pa_per_m_high"] / 1e12, alpha=0.3)
axes[1].set_xlabel("pressure / MPa")
axes[1].set_ylabel("k_N / (TPa/m)")
axes[1].set_title("stiffness of the joint, 95 % band")
figure.tight_layout()
