# SPDX-License-Identifier: GPL-3.0-or-later
"""What a map can tell of D and G at best: Cramer-Rao bound of a Gaussian field, every Fourier mode of the map used.

python bench/fit_bound.py    501 x 501 points of 1 um, isotropic band of L = 0.5 mm, L_s = 1 um, gamma = 1.5, G = 2.4248e-7 m, aliases folded in.
No unbiased estimator scatters less, whatever it looks at; this one also knows the spectrum and its ends exactly (Whittle 1953).

python bench/fit_bound.py blind    the maps of blind_fit.py that are 128 points a side: parts told (which of probe, noise and finer detail are
there, not how large) and all of them free, with the taper of the fit: record fit_bound.json and its table in docs/evidence/fit_bound.md.
"""
import sys

import numpy as np
from blind_fit import MAPS

from common import put, read_record, table, write_record
from hdengine import roughness

G, N, DX = 2.4248e-7, 501, 1e-6
BAND = roughness.Ridges(0.5e-3, 1e-6).band
F = np.fft.fftfreq(N, DX)
POINTS, TAPER = 128, 1.81   # side of a blind map; modes of an independent mode under the fit's taper
BLIND = ("square to Nyquist", "circle to half of it", "4 times finer detail", "probe 0.25", "probe 0.5", "probe 1", "probe 2", "noise 5 %", "noise 30 %")


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


def blind_bound(d, finer=1, top=0.5, probe=0.0, noise=0.0):
    """Smallest standard error of D of a map of one spacing: parts told, and all free; density without dimension."""
    k = np.fft.fftfreq(POINTS)
    f = np.hypot(k[:, None], k)
    seen = (f >= 3.5 / POINTS) & (f <= 0.98 * top)

    def power(d, ln_a, square, detail, white):
        p, n = np.zeros_like(f), 2 * d - 8
        for i in range(-2, 3):
            for j in range(-2, 3):
                g = np.hypot(k[:, None] + i, k + j)
                share = 1.0 if i == j == 0 else detail
                p += share * np.maximum(g, 1e-9) ** n * np.exp(-square * (2 * np.pi * g) ** 2)
        return np.exp(ln_a) * p[seen] + white

    at = np.array([d, 0.0, probe**2, float(finer > 1), 0.0])
    low = np.arange(1, POINTS // 2) / POINTS     # the rms height is that of all modes
    at[4] = noise**2 * np.sum(2 * np.pi * low ** (2 * d - 7)) / POINTS
    p = power(*at)
    scale = np.array([1e-4, 1e-4, 1e-4, 1e-4, 1e-4 * p.min()])
    v = np.array([(power(*(at + e)) - power(*(at - e))) / (2 * s * p) for s, e in zip(scale, np.diag(scale))])
    there = [0, 1] + [i for i, part in ((2, probe), (3, finer > 1), (4, noise)) if part]

    def error(use):
        h = 0.5 * v[use] @ v[use].T / TAPER
        s = np.sqrt(np.diag(h))
        return float(np.sqrt(np.linalg.inv(h / np.outer(s, s))[0, 0]) / s[0])
    return error(there), error([0, 1, 2, 3, 4])


def put_table(rows):
    """Bounds beside what the blind fit scattered."""
    found = read_record("blind_fit")["maps"]
    put("bound", table(("kind of map", "parts told, D = 2.1 / 2.5 / 2.9", "all free", "std of the fit"), [
        (r["kind"], *(" / ".join(f"{b[key]:.3f}" for b in r["bounds"]) for key in ("told", "free")),
         " / ".join(f"{found[f'''{r['kind']}, D = {d}''']['std']:.3f}" for d in (2.1, 2.5, 2.9))) for r in rows]), "evidence/fit_bound")


if __name__ == "__main__":
    if "--tables" in sys.argv:
        put_table(read_record("fit_bound"))
    elif "blind" in sys.argv:
        rows = [{"kind": kind, "bounds": [dict(zip(("told", "free"), blind_bound(d, **MAPS[kind]))) for d in (2.1, 2.5, 2.9)]} for kind in BLIND]
        write_record("fit_bound", rows)
        put_table(rows)
    else:
        for d in (2.1, 2.3, 2.5304, 2.7, 2.9):
            print(f"D = {d}:", *(f"{name} {bound(d, noisy)[0]:.4f} in D, {bound(d, noisy)[1]:.3f} in ln G"
                                for name, noisy in (("clean", False), (" noise fitted", True))))
