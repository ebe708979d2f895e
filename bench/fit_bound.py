# SPDX-License-Identifier: GPL-3.0-or-later
"""What a map can tell of D and G at best: Cramer-Rao bound of a Gaussian field, every Fourier mode of the map used.

python bench/fit_bound.py    501 x 501 points of 1 um, isotropic band of L = 0.5 mm, L_s = 1 um, gamma = 1.5, G = 2.4248e-7 m, aliases folded in.
No unbiased estimator scatters less, whatever it looks at; this one also knows the spectrum and its ends exactly (Whittle 1953).
"""
import numpy as np

from hdengine import roughness

G, N, DX = 2.4248e-7, 501, 1e-6
BAND = roughness.Ridges(0.5e-3, 1e-6).band
F = np.fft.fftfreq(N, DX)


def spectrum(d, ln_g):
    """Density of the sampled field per area of the frequency plane [m^4]."""
    p = np.zeros((N, N))
    for i in range(-2, 3):
        for j in range(-2, 3):
            f = np.hypot(F[:, None] + i / DX, F + j / DX)
            inside = (f >= 1 / BAND[1]) & (f <= 1 / BAND[0])
            p[inside] += np.exp(2 * (d - 2) * ln_g) * f[inside] ** (2 * d - 8) / (4 * np.pi)
    return p


def bound(d, noisy):
    """Smallest standard errors of D and ln G; with white noise of 5 % of sqrt(S(1)) of unknown size, or without."""
    ln_g, h = np.log(G), 1e-4
    white = 0.05**2 * roughness.expected_structure(DX, d, G, BAND) * DX**2 if noisy else 0.0
    p = spectrum(d, ln_g) + white
    seen = p > 0
    slopes = [(spectrum(d + h, ln_g) - spectrum(d - h, ln_g)) / (2 * h), (spectrum(d, ln_g + h) - spectrum(d, ln_g - h)) / (2 * h)]
    slopes += [np.full_like(p, white)] if noisy else []
    v = np.array([s[seen] / p[seen] for s in slopes])
    return np.sqrt(np.diag(np.linalg.inv(0.5 * v @ v.T)))[:2]


for d in (2.1, 2.3, 2.5304, 2.7, 2.9):
    print(f"D = {d}:", *(f"{name} {bound(d, noisy)[0]:.4f} in D, {bound(d, noisy)[1]:.3f} in ln G"
                        for name, noisy in (("clean", False), (" noise fitted", True))))
