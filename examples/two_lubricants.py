# SPDX-License-Identifier: GPL-3.0-or-later
"""
Compare two lubricants by their friction
========================================

Two coefficients of friction, all else equal. Less friction means more slip, so the tangent K_TS falls. Coarse mesh:
24 x 4 facets.
"""
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import hdengine

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine
out = Path(mkdtemp())
COARSE = {"mesh.divisions": 24, "mesh.band_facets": 4}

figure, axes = plt.subplots(1, 2, figsize=(10, 4))
for friction in (0.05, 0.15):
    run = hdengine.run(data / "cd14.nml", out / f"mu{friction:g}", True, **COARSE, contact__friction=friction)
    steps = run.steps[run.steps["torque_nm"] > 0]
    axes[0].plot(steps["torque_nm"], steps["k_ts_bonded_nm_per_rad"] / 1e6, "o-", label=f"µ = {friction:g}")
    axes[1].plot(steps["torque_nm"], 100 * steps["slip_share_area"], "o-")
    print(f"µ = {friction:g}: tangent K_TS at 5 N m {steps['k_ts_bonded_nm_per_rad'][-1]:.3g} N m/rad, "
          f"friction could carry {steps['friction_capacity_nm'][-1]:.3g} N m")
axes[0].set_ylabel("tangent K_TS / (MN m/rad)")
axes[1].set_ylabel("share of the contact area that slips / %")
for axis in axes:
    axis.set_xlabel("torque / N m")
axes[0].legend()
figure.tight_layout()
