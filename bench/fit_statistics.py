# SPDX-License-Identifier: GPL-3.0-or-later
"""Bias, spread and coverage of the fits of D and G over many seeds: table of docs/evidence/fit_told.md, record bench/results/fit_statistics.json.

501 x 501 points of 1 um, L = 0.5 mm, L_s = 1 um, gamma = 1.5, G = 2.4248e-7 m. A tilt of 5 % and white noise of 5 % of the expected sqrt(S(1))
are added; the noise is fitted. 0 ridges: no sum of Eq. 1 but a Gaussian isotropic field, 20 000 waves of all directions and frequencies of
the band. Estimators: default = told nothing; band = `model='isotropic'`, told the ends of the band; sum = told the sum of Eq. 1, all correlations.

Usage: python bench/fit_statistics.py [--seeds N] [--slow N] [--d D ...]    N seeds a row from 2000 on; --slow: of slow rows, 2 s a map
"""
import argparse

import numpy as np

from common import put, table, write_record
from hdengine import roughness, surface

G, L, FIRST = 2.4248e-7, 0.5e-3, 2000
BAND = roughness.Ridges(L, 1e-6).band
TILT = 0.05 * 1e-6 * np.arange(501) - 0.02 * 1e-6 * np.arange(501)[:, None]
SURFACES = {10: "Eq. 1, 10 ridges", 40: "Eq. 1, 40 ridges", 0: "continuous field"}


def field(d, seed, count=20000):
    """Isotropic field of the band; waves spread evenly in ln f, at random within their share."""
    rng = np.random.default_rng((1, seed))
    width = np.log(BAND[1] / BAND[0])
    f = np.exp(width * (np.arange(count) + rng.random(count)) / count) / BAND[1]
    angle = 2 * np.pi * rng.random(count)
    amplitude = np.sqrt(width / count) * f ** (d - 3) * G ** (d - 2)
    return surface.sum_waves(f * np.cos(angle), f * np.sin(angle), amplitude, rng.random(count), 501, 1e-6, tolerance=1e-9)


def sample(d, ridges, seed):
    """A map with noise and tilt."""
    z = surface.generate(501, 1e-6, d, G, 1.5, L, 1e-6, ridges, seed) if ridges else field(d, seed)
    size = 0.05 * np.sqrt(roughness.expected_structure(1e-6, d, G, BAND))
    return z + size * np.random.default_rng(seed).standard_normal(z.shape) + TILT


def fit(z, ridges, estimator):
    """One fit."""
    keys = {"default": {}, "band": {"band": BAND, "model": "isotropic", "noise": "fit"},
            "sum": {"surface": roughness.Ridges(L, 1e-6, ridges), "noise": "fit"}}[estimator]
    return roughness.fit(z, 1e-6, **keys)


def study(d, ridges, estimator, seeds):
    """Statistics of one estimator on one kind of map."""
    fits = [fit(sample(d, ridges, seed), ridges, estimator) for seed in range(FIRST, FIRST + seeds)]
    row = {"d": d, "ridges": ridges, "estimator": estimator, "seeds": seeds, "first_seed": FIRST}
    for k, (key, found, true, error) in enumerate((
            ("d", [f.fractal_dimension for f in fits], d, [f.fractal_dimension_error for f in fits]),
            ("ln_g", [np.log(f.roughness_m) if f.roughness_m > 0 else np.nan for f in fits], np.log(G), [f.ln_roughness_error for f in fits]))):
        off = np.array(found) - true   # no G where the interval of D reaches 2
        row |= {f"bias_{key}": np.nanmean(off), f"std_{key}": np.nanstd(off, ddof=1), f"error_{key}": np.sqrt(np.nanmean(np.square(error))),
                f"coverage_{key}": np.mean([f.interval[k][0] < (d, G)[k] < f.interval[k][1] for f in fits])}
    return row | {"fractal": np.mean([f.verdict == "fractal" for f in fits]), "models": sorted({f.model for f in fits})}


def line(r):
    """A row of the table."""
    return (SURFACES[r["ridges"]], r["estimator"], r["d"], f"{r['bias_d']:+.4f}", f"{r['std_d']:.4f}", f"{r['error_d']:.4f}",
            f"{r['bias_ln_g']:+.3f}", f"{r['std_ln_g']:.3f}", f"{100 * r['coverage_d']:.0f} / {100 * r['coverage_ln_g']:.0f}",
            f"{100 * r['fractal']:.0f}")


def main():
    """All rows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=60)
    parser.add_argument("--slow", type=int, default=20)
    parser.add_argument("--d", type=float, nargs="+", default=[2.1, 2.5304, 2.9])
    options = parser.parse_args()
    rows = []
    for estimator, ridges in (("sum", 10), ("sum", 40), ("band", 0), ("band", 10), ("band", 40), ("default", 10), ("default", 40), ("default", 0)):
        for d in options.d:
            rows.append(study(d, ridges, estimator, options.slow if estimator == "default" or not ridges else options.seeds))
            print(*line(rows[-1]), rows[-1]["models"], flush=True)
    write_record("fit_statistics", rows, seed=FIRST)
    put("statistics", table(("surface", "told", "D", "bias of D", "std of D", "stated", "bias of ln G", "std of ln G", "D / ln G inside, %",
                             "fractal, %"), map(line, rows)), "evidence/fit_told")


if __name__ == "__main__":
    main()
