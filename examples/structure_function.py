# SPDX-License-Identifier: GPL-3.0-or-later
"""
Structure function and fit of a generated surface
=================================================

A fractal surface with known D and G is generated, and both are read back from its heights. The fit states a 95 % interval: look whether it
holds the truth.
"""
import matplotlib.pyplot as plt
import numpy as np

from hdengine import roughness, surface

D, G, SPACING = 2.5, 1e-8, 1e-6
heights = surface.periodic(256, 256 * SPACING, D, G, 2 * SPACING, seed=3)
fit = roughness.fit(heights, SPACING)
(d_low, d_high), (g_low, g_high) = fit.interval
print(f"D {fit.fractal_dimension:.3f}, 95 % interval {d_low:.3f} to {d_high:.3f}; put in {D}")
print(f"G {fit.roughness_m:.2e} m, 95 % interval {g_low:.2e} to {g_high:.2e}; put in {G:.0e}")

lags = np.unique(np.geomspace(1, 100, 25).astype(int))
tau, s = roughness.structure_function(heights, SPACING, lags)[:2]
figure, axes = plt.subplots(1, 2, figsize=(10, 4))
shown = axes[0].imshow(1e6 * heights, extent=(0, 256, 0, 256))
axes[0].set_xlabel("x / µm")
figure.colorbar(shown, label="height / µm")
axes[1].loglog(1e6 * tau, 1e12 * s, "o")
axes[1].set_xlabel("lag / µm")
axes[1].set_ylabel("structure function / µm²")
figure.tight_layout()
