# SPDX-License-Identifier: GPL-3.0-or-later
"""Bias, spread and coverage of the fit of D and G over many seeds of Eq. 1: bench/results/fit_statistics.json.

python bench/fit_statistics.py [SEEDS [ESTIMATOR ...]]    501 x 501 points of 1 um, L = 0.5 mm, L_s = 1 um, gamma = 1.5, G = 2.4248e-7 m, lags 1-20.
`noisy`: a tilt of 5 % and white noise of 5 % of sqrt(S(1)) are added, the plane is taken off and the noise is fitted.
Estimators: exact = two-step GLS on the sum of Eq. 1; band = the default for unknown surfaces, weighted least squares on the
isotropic band with the errors of a Gaussian field and of misfit; waves = the same with the errors of random phases. Goes on
where it stopped.
"""
import json
import sys
from pathlib import Path

import numpy as np

from hdengine import roughness, surface

G, L = 2.4248e-7, 0.5e-3


def sample(d, ridges, seed, noisy):
    z = surface.generate(501, 1e-6, d, G, 1.5, L, 1e-6, ridges, seed)
    if noisy:
        rng = np.random.default_rng(seed)
        z += 0.05 * 1e-6 * np.arange(501) - 0.02 * 1e-6 * np.arange(501)[:, None]
        z += 0.05 * np.sqrt(np.mean(np.diff(z) ** 2)) * rng.standard_normal(z.shape)
    return z


def line(r):
    """A row as it stands in docs/verification.md."""
    return (f"| {r['d']} | {r['ridges']} | {'noise, tilt' if r['noisy'] else 'clean'} | {r['estimator']} | {r['bias_d']:+.4f} | "
            f"{r['std_d']:.4f} | {r['error_d']:.4f} | {r['bias_ln_g']:+.3f} | {r['std_ln_g']:.3f} | {100 * r['coverage_d']:.0f} / "
            f"{100 * r['coverage_ln_g']:.0f} | {100 * r['fractal']:.0f} |")


def study(d, ridges, noisy, name, seeds):
    """Statistics of one estimator."""
    known = roughness.Ridges(L, 1e-6, ridges)
    keys = {"exact": {"surface": known}, "band": {"band": known.band}, "waves": {"surface": known, "model": "isotropic"}}[name]
    found = []
    for seed in range(seeds):
        f = roughness.fit(sample(d, ridges, seed, noisy), 1e-6, noise="fit" if noisy else 0.0, **keys)
        found.append((f.fractal_dimension - d, np.log(f.roughness_m / G), f.fractal_dimension_error, f.ln_roughness_error,
                      f.verdict == "fractal"))
    v = np.array(found, dtype=float)
    return {
        "d": d, "ridges": ridges, "noisy": noisy, "estimator": name, "seeds": seeds,
        "bias_d": v[:, 0].mean(), "std_d": v[:, 0].std(ddof=1), "error_d": np.sqrt(np.mean(v[:, 2] ** 2)),
        "bias_ln_g": v[:, 1].mean(), "std_ln_g": v[:, 1].std(ddof=1), "error_ln_g": np.sqrt(np.mean(v[:, 3] ** 2)),
        "coverage_d": np.mean(abs(v[:, 0]) < 1.959964 * v[:, 2]),
        "coverage_ln_g": np.mean(abs(v[:, 1]) < 1.959964 * v[:, 3]), "fractal": v[:, 4].mean()}


def main(seeds, names):
    """All rows not yet in the file."""
    out = Path(__file__).parent / "results/fit_statistics.json"
    rows = json.loads(out.read_text()) if out.exists() else []
    done = {(r["d"], r["ridges"], r["noisy"], r["estimator"], r["seeds"]) for r in rows}
    for name, noisy in (("exact", False), ("band", False), ("exact", True), ("waves", False), ("band", True)):
        if names and name not in names:
            continue
        for ridges in (10, 40):
            for d in (2.5304,) if name == "waves" else (2.5304, 2.9, 2.1, 2.5, 2.7, 2.3):
                if (d, ridges, noisy, name, seeds) in done:
                    continue
                rows.append(study(d, ridges, noisy, name, seeds))
                print(line(rows[-1]), flush=True)
                out.write_text(json.dumps(rows, indent=1) + "\n")


main(int(sys.argv[1]) if len(sys.argv) > 1 else 100, sys.argv[2:])
