# SPDX-License-Identifier: GPL-3.0-or-later
"""Structure function beside a numpy loop and SurfaceTopography's scale-dependent statistics: bench/results/structure_function.json.

python bench/structure_function.py    512 x 512 points, rows; one thread each, processor time, ratios of one run.
"""
import os
import time

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

import numpy as np  # noqa: E402
import SurfaceTopography  # noqa: E402

from common import write_record  # noqa: E402
from hdengine import roughness, surface  # noqa: E402

N = 512


def best(f, repeat=3):
    times = []
    for _ in range(repeat):
        start = time.process_time()
        result = f()
        times.append(time.process_time() - start)
    return min(times), result


def numpy_loop(z, lags):
    """One lag at a time, vectorised over the map."""
    return np.array([np.mean((z[:, k:] - z[:, :-k]) ** 2) for k in lags])


def double_loop(z, lags):
    """Lags and rows in Python, vectorised along the row."""
    return np.array([np.mean([np.mean((row[k:] - row[:-k]) ** 2) for row in z]) for k in lags])


def scale_dependent(t, lags):
    """S from SurfaceTopography: slopes over a distance, squared."""
    d = np.asarray(lags, dtype=float)
    mean = t.scale_dependent_statistical_property(lambda x, y: np.mean(x**2), n=1, distance=d)
    return np.asarray(mean)[-1] * d**2


def main():
    z = surface.generate(N, 1e-6, 2.5304, 2.4248e-7, 1.5, 0.5e-3, 1e-6, 10, 1)
    t = SurfaceTopography.Topography(np.ascontiguousarray(z.T), (float(N), float(N)))
    rows = []
    for name, lags in (("lags 1-20", np.arange(1, 21)), ("all lags to 255", np.arange(1, 256))):
        ours, s = best(lambda: roughness.structure_function(z, 1e-6, lags)[1])
        row = {"case": name, "hdengine_s": ours}
        for peer, f, repeat in (("numpy_double_loop", double_loop, 1), ("numpy_vectorised", numpy_loop, 1)):
            if name.startswith("all") and peer == "numpy_double_loop":
                some = lags[::16]
                seconds, other = best(lambda: f(z, some), repeat)
                seconds *= len(lags) / len(some)
                np.testing.assert_allclose(s[::16], other, rtol=1e-9)
            else:
                seconds, other = best(lambda: f(z, lags), repeat)
                np.testing.assert_allclose(s, other, rtol=1e-9)
            row |= {f"{peer}_ratio": seconds / ours}
        few = lags[::4] if name.startswith("lags") else lags[::64]
        seconds, other = best(lambda: scale_dependent(t, few), 1)
        seconds *= len(lags) / len(few)
        row |= {"surfacetopography_sds_ratio": seconds / ours, "surfacetopography_s_over_ours": float(np.median(other / s[few - 1]))}
        rows.append(row)
        print(row)
    write_record("structure_function", rows, peers=[SurfaceTopography])


main()
