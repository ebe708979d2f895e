# SPDX-License-Identifier: GPL-3.0-or-later
"""Height maps by numpy alone, for the fit told nothing: fractal ones of known D and G, jitter, lays, and fifteen kinds that are not fractal."""
import numpy as np

LN_G = np.log(1e-7)  # of every fractal map and line here [ln m]


def field(n, dx, d, rng, finer=1, longer=1, top=None, probe=0.0, noise=0.0, tilt=0.0, aspect=1.0):
    """Gaussian map (n, n) of density G^(2(D-2)) f^(2D-8) / (4 pi), and its spacing (dy, dx) [m].

    finer: points per spacing of the synthesis; longer: its period over the side of the map; top: circular end of the band [1/dx];
    probe: standard deviation of a Gaussian blur [dx]; noise: of the rms height; tilt: in rms heights, middle to edge; aspect: dy/dx.
    """
    dy = aspect * dx
    size, hx, hy = n * finer * longer, dx / finer, dy / finer
    f = np.hypot(np.fft.rfftfreq(size, hx)[None], np.fft.fftfreq(size, hy)[:, None])
    f[0, 0] = np.inf
    p = np.exp(2 * (d - 2) * LN_G) / (4 * np.pi) * f ** (2 * d - 8)
    if top:
        p[f > top / max(dx, dy)] = 0
    p *= np.exp(-((2 * np.pi * probe * dx * np.where(np.isfinite(f), f, 0)) ** 2))
    z = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((size, size))) * np.sqrt(p / (hx * hy)), s=(size, size))
    z = z[: n * finer : finer, : n * finer : finer]
    z = z + noise * z.std() * rng.standard_normal(z.shape) + tilt * z.std() * np.linspace(-1, 1, n)
    return z, (dy, dx)


def line(n, dx, d, rng, finer=1, probe=0.0, noise=0.0):
    """Gaussian profile of two-sided density G^(2(D-2)) f^(2D-7) / 4 (Eq. 2) [m]."""
    f = np.fft.rfftfreq(n * finer, dx / finer)
    f[0] = np.inf
    p = np.exp(2 * (d - 2) * LN_G) / 4 * f ** (2 * d - 7)
    p *= np.exp(-((2 * np.pi * probe * dx * np.where(np.isfinite(f), f, 0)) ** 2))
    z = np.fft.irfft(np.fft.rfft(rng.standard_normal(n * finer)) * np.sqrt(p * finer / dx), n=n * finer)[::finer]
    return z + noise * z.std() * rng.standard_normal(n)


def clumps(z, rng):
    """Raise twenty clumps of 2 x 2 points of a map by 3 Sq, in place; where they are."""
    wrong = np.zeros(z.shape, dtype=bool)
    for i, j in rng.integers(0, min(z.shape) - 2, (20, 2)):
        wrong[i:i + 2, j:j + 2] = True
    z[wrong] += 3 * z.std()
    return wrong


def jitter(n, dx, d, rng, size, way=0, drift=False, **options):
    """White offsets of rows (way 0) or columns of `size` rms heights; or offsets that drift from row to row."""
    z, _ = field(n, dx, d, rng, finer=2, **options)
    offset = rng.standard_normal((n, 1))
    if drift:
        offset = np.cumsum(offset, 0) / n**0.5
    return z + size * z.std() * (offset.T if way else offset)


def straight(n, dx, d, rng, of_line):
    """Grooves without end along y: a fractal profile of twice the height of the map beneath."""
    z, _ = field(n, dx, d, rng, finer=2)
    across = line(n, dx, of_line, rng, finer=2)
    return z + 2 * z.std() * across / across.std()


def stretched(n, dx, d, rng, times, angle=0.0, noise=0.0):
    """A fractal map stretched along y, turned by an angle."""
    f, g = np.fft.rfftfreq(2 * n)[None], np.fft.fftfreq(2 * n)[:, None]
    k = np.hypot(np.cos(angle) * f + np.sin(angle) * g, times * (np.cos(angle) * g - np.sin(angle) * f))
    k[0, 0] = np.inf
    z = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((2 * n, 2 * n))) * k ** (d - 4), s=(2 * n, 2 * n))[:n, :n]
    return 1e-6 * (z / z.std() + noise * rng.standard_normal(z.shape))


def grooves(n, dx, d, rng, length):
    """Forty grooves along y of unlike depth and width that end: `length` sides long, of twice the height of the map beneath."""
    z, _ = field(n, dx, d, rng, finer=2)
    y, x = np.mgrid[:n, :n]
    cut = np.zeros((n, n))
    places = rng.uniform(0, n, 40), rng.uniform(-0.3 * n, 1.3 * n, 40)
    for at, middle, width, depth in zip(*places, rng.uniform(0.7, 3, 40), rng.exponential(1, 40)):
        cut -= depth * np.exp(-((x - at) ** 2) / (2 * width**2)) / (1 + np.exp((abs(y - middle) - length * n / 2) / 2))
    return z + 2 * z.std() * cut / cut.std()


def _coloured(n, rng, power):
    """Gaussian map of a given spectrum over f [1/points], of rms height 1 um."""
    f = np.hypot(np.fft.rfftfreq(n)[None], np.fft.fftfreq(n)[:, None])
    z = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((n, n))) * np.sqrt(power(np.maximum(f, 1 / n))), s=(n, n))
    return 1e-6 * (z - z.mean()) / z.std()


def _plateaus(n, rng, sites=60):
    """Voronoi cells, each flat at its own height."""
    y, x = np.mgrid[:n, :n]
    at = rng.uniform(0, n, (sites, 2))
    near = np.argmin((x[..., None] - at[:, 0]) ** 2 + (y[..., None] - at[:, 1]) ** 2, axis=-1)
    return 1e-6 * rng.standard_normal(sites)[near]


def _bumps(n, rng, count, width):
    """Gaussian bumps at random places."""
    y, x = np.mgrid[:n, :n]
    z = np.zeros((n, n))
    for cx, cy, h in zip(rng.uniform(0, n, count), rng.uniform(0, n, count), rng.standard_normal(count)):
        z += h * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * width**2))
    return 1e-6 * z / z.std()


def _spikes(n, rng):
    z = 1e-9 * rng.standard_normal((n, n))
    z.flat[rng.choice(n * n, n * n // 30, replace=False)] += 1e-6
    return z


def _scratches(n, rng, count=25):
    y, x = np.mgrid[:n, :n]
    z = 0.02 * rng.standard_normal((n, n))
    for a, c, h in zip(rng.uniform(0, np.pi, count), rng.uniform(-0.5 * n, n, count), rng.exponential(1, count)):
        z -= h * (abs(x * np.cos(a) + y * np.sin(a) - c) < 1.2)
    return 1e-6 * z


def _wave(n, rng):
    return np.arange(n) / rng.uniform(12, 30) + rng.uniform()


NOT_FRACTAL = {
    "sine": lambda n, rng: 1e-6 * np.sin(2 * np.pi * _wave(n, rng))[None] * np.ones((n, 1)),
    "noisy sine": lambda n, rng: 1e-6 * (np.sin(2 * np.pi * _wave(n, rng))[None] + 0.1 * rng.standard_normal((n, n))),
    "square wave": lambda n, rng: 1e-6 * np.sign(np.sin(2 * np.pi * _wave(n, rng)))[None] * np.ones((n, 1)),
    "noisy square wave": lambda n, rng: 1e-6 * (np.sign(np.sin(2 * np.pi * _wave(n, rng))) + 0.1 * rng.standard_normal((n, n))),
    "turned lay": lambda n, rng: 1e-6 * (abs(_wave(n, rng) % 1 - 0.5) + 0.02 * rng.standard_normal((n, n))),
    "plateaus": _plateaus,
    "noisy plateaus": lambda n, rng: _plateaus(n, rng) + 1e-7 * rng.standard_normal((n, n)),
    "scratches": _scratches,
    "bumps": lambda n, rng: _bumps(n, rng, 60, n / 25),
    "spikes": _spikes,
    "white noise": lambda n, rng: 1e-6 * rng.standard_normal((n, n)),
    "smooth": lambda n, rng: _coloured(n, rng, lambda f: np.exp(-((40 * f) ** 2))),
    "crossover up": lambda n, rng: _coloured(n, rng, lambda f: f**-3.8 + (0.12**-1.8) * f**-2.0 * 1.0),
    "crossover down": lambda n, rng: _coloured(n, rng, lambda f: 1 / (f**2.2 * (1 + (f / 0.1) ** 1.8))),
    "one scale": lambda n, rng: _coloured(n, rng, lambda f: np.exp(-((np.log(f / 0.08)) ** 2) / 0.08)),
}
