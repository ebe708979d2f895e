# SPDX-License-Identifier: GPL-3.0-or-later
"""Bias, spread and coverage of the fit of D and G over many seeds of Eq. 1: bench/results/fit_statistics.json.

python bench/fit_statistics.py [SEEDS[@FIRST] [ESTIMATOR[:NOISE[:RIDGES[:D]]] ...]]    501 x 501 points of 1 um, L = 0.5 mm, L_s = 1 um, gamma = 1.5, G = 2.4248e-7 m, lags 1-20.
`fitted`: a tilt of 5 % and white noise of 5 % of the expected sqrt(S(1)) are added, the plane is taken off and the noise is fitted; `known`: the
noise is given. 0 ridges: no sum of Eq. 1 but a Gaussian isotropic field, 20 000 waves of all directions and frequencies of the band.
Estimators: exact = two-step GLS on the sum of Eq. 1, told; blind = the default, told nothing but (of a field) the ends of its band;
isotropic = weighted least squares on the isotropic band with the errors of a Gaussian field and of misfit, what blind does where
it finds no lines; waves = the same told the sum, with the errors of random phases. Goes on where it stopped; several may run at
once, each on estimators of its own.
"""
import json
import sys
from pathlib import Path

import numpy as np

from hdengine import roughness, surface

G, L = 2.4248e-7, 0.5e-3
BAND = roughness.Ridges(L, 1e-6).band
OUT = Path(__file__).parent / "results/fit_statistics.json"
TILT = 0.05 * 1e-6 * np.arange(501) - 0.02 * 1e-6 * np.arange(501)[:, None]
KEYS = ("d", "ridges", "noise", "estimator", "seeds", "first_seed")


def field(d, seed, count=20000):
    """Isotropic field of the band; waves spread evenly in ln f, at random within their share."""
    rng = np.random.default_rng((1, seed))
    width = np.log(BAND[1] / BAND[0])
    f = np.exp(width * (np.arange(count) + rng.random(count)) / count) / BAND[1]
    angle = 2 * np.pi * rng.random(count)
    amplitude = np.sqrt(width / count) * f ** (d - 3) * G ** (d - 2)
    return surface.sum_waves(f * np.cos(angle), f * np.sin(angle), amplitude, rng.random(count), 501, 1e-6, tolerance=1e-9)


def sample(d, ridges, seed, noise, tilted=True):
    """A map and the rms noise in it."""
    z = surface.generate(501, 1e-6, d, G, 1.5, L, 1e-6, ridges, seed) if ridges else field(d, seed)
    if noise == "none":
        return z, 0.0
    size = 0.05 * np.sqrt(roughness.expected_structure(1e-6, d, G, BAND))
    return z + size * np.random.default_rng(seed).standard_normal(z.shape) + tilted * TILT, size


def fit(d, ridges, seed, noise, name, tilted=True):
    """One fit."""
    known = roughness.Ridges(L, 1e-6, ridges)
    keys = {"exact": {"surface": known}, "blind": {} if ridges else {"band": BAND},
            "isotropic": {"band": BAND, "model": "isotropic"}, "waves": {"surface": known, "model": "isotropic"}}[name]
    z, size = sample(d, ridges, seed, noise, tilted)
    return roughness.fit(z, 1e-6, noise="fit" if noise == "fitted" else size, **keys)


def study(d, ridges, noise, name, seeds, first):
    """Statistics of one estimator."""
    fits = [fit(d, ridges, seed, noise, name) for seed in range(first, first + seeds)]
    row = {"d": d, "ridges": ridges, "noise": noise, "estimator": name, "seeds": seeds, "first_seed": first}
    if noise == "fitted":
        row["change_by_tilt_d"] = abs(fit(d, ridges, first, noise, name, False).fractal_dimension - fits[0].fractal_dimension)
    for k, (key, found, true, error) in enumerate((
            ("d", [f.fractal_dimension for f in fits], d, [f.fractal_dimension_error for f in fits]),
            ("ln_g", np.log([f.roughness_m for f in fits]), np.log(G), [f.ln_roughness_error for f in fits]))):
        off = np.array(found) - true
        held = [[np.mean([i[k][0] < (d, G)[k] < i[k][1] for i in intervals])] for intervals in
                ([f.interval for f in fits], [f.sampling_interval for f in fits])]
        row |= {f"bias_{key}": off.mean(), f"std_{key}": off.std(ddof=1), f"error_{key}": np.sqrt(np.mean(np.square(error))),
                f"coverage_{key}": held[0][0], f"coverage_sampling_{key}": held[1][0]}
    return row | {"fractal": np.mean([f.verdict == "fractal" for f in fits]), "recognised": np.mean([f.model == "ridges" for f in fits])}


def percent(share):
    """A share as text; some rows of band without noise have no coverage by sampling, being older than it."""
    return "-" if share is None else f"{100 * share:.0f}"


def line(r):
    """A row as it stands in docs/evidence/verification.md."""
    return (f"| {r['d']} | {r['ridges']} | {r['noise']} | {r['estimator']} | {r['bias_d']:+.4f} | {r['std_d']:.4f} | "
            f"{r['error_d']:.4f} | {r['bias_ln_g']:+.3f} | {r['std_ln_g']:.3f} | "
            f"{percent(r['coverage_sampling_d'])} / {percent(r['coverage_sampling_ln_g'])} | "
            f"{percent(r['coverage_d'])} / {percent(r['coverage_ln_g'])} | {percent(r['fractal'])} |")


def rows_of(names):
    """All rows wanted, the important first."""
    for name, noise, several in (("blind", "fitted", (10, 40, 0)), ("exact", "fitted", (10, 40)), ("blind", "none", (10, 40, 0)),
                                 ("waves", "none", (10, 40)), ("exact", "none", (10, 40)), ("waves", "fitted", (10, 40)),
                                 ("isotropic", "none", (10, 40)), ("isotropic", "fitted", (10, 40))):
        for ridges in several:
            for d in (2.5304, 2.9, 2.1, 2.5, 2.7, 2.3):
                words = f"{name}:{noise}:{ridges}:{d}:"
                if not names or any(words.startswith(n + ":") for n in names):
                    yield d, ridges, noise, name


def main(seeds, first, names):
    """All rows not yet in the file; then the table."""
    for wanted in rows_of(names):
        rows = json.loads(OUT.read_text()) if OUT.exists() else []
        if (*wanted, seeds, first) in {tuple(r[k] for k in KEYS) for r in rows}:
            continue
        row = study(*wanted, seeds, first)
        print(line(row), flush=True)
        rows = json.loads(OUT.read_text()) if OUT.exists() else []
        OUT.write_text(json.dumps([*rows, row], indent=1) + "\n")
    print("\nall rows")
    rows = json.loads(OUT.read_text())
    print(*map(line, sorted(rows, key=lambda r: tuple(r[k] for k in ("estimator", "noise", "ridges", "d", "first_seed")))), sep="\n")


main(*map(int, (sys.argv[1] if len(sys.argv) > 1 else "200@2000").split("@")), sys.argv[2:])
