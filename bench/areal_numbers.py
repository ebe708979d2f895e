# SPDX-License-Identifier: GPL-3.0-or-later
"""Areal numbers, form removal and Gaussian filter beside Gwyddion, surfalize and SurfaceTopography, on measured and synthetic maps.

python bench/areal_numbers.py FOLDER: the folder holds measured maps, any that SurfaceTopography reads. Needs cc, Debian's
libgwyddion20-dev and libglib2.0-dev, and pip install surfalize SurfaceTopography. Writes results/areal_numbers.json and the tables of
docs/evidence/areal_numbers.md; --tables only writes the tables again.
"""
import subprocess
import sys
import tempfile
import warnings
from importlib.metadata import version
from pathlib import Path

import numpy as np
from blind_generators import field

from common import put, read_record, table, write_record
from hdengine import InputError, specimen
from hdengine.surfaces import form, gaussian, texture

UNITS = {"nanovea_test2.txt": {"unit": ("mm", "um")}}
NAMES = {"sa_m": "Sa", "sq_m": "Sq", "ssk": "Ssk", "sku": "Sku", "sp_m": "Sp", "sv_m": "Sv", "sz_m": "Sz", "sdq": "Sdq", "sdr": "Sdr",
         "sal_m": "Sal", "str": "Str", "std_rad": "Std", "sk_m": "Sk", "spk_m": "Spk", "svk_m": "Svk", "smrk1": "Smr1", "smrk2": "Smr2",
         "sxp_m": "Sxp"}
MOST_POINTS = 450       # of a side: Gwyddion's fit of a cylinder takes all of them at once


def build(folder):
    """Gwyddion's side of the comparison."""
    def flags(*words):
        return subprocess.run(["pkg-config", *words], capture_output=True, text=True, check=True).stdout.split()
    places = [p for p in ("/usr/include/gwyddion", "/usr/lib/x86_64-linux-gnu/gwyddion/include") if Path(p).exists()]
    program = Path(folder) / "areal_gwyddion"
    subprocess.run(["cc", "-O2", Path(__file__).with_suffix("").with_name("areal_gwyddion.c"), "-o", program, *(f"-I{p}" for p in places),
                    *flags("--cflags", "glib-2.0", "gobject-2.0"), "-l:libgwyprocess2.so.0", "-l:libgwyddion2.so.0",
                    *flags("--libs", "glib-2.0", "gobject-2.0"), "-lm"], check=True, stderr=subprocess.DEVNULL)
    return program


def gwyddion(program, s, cutoff):
    """Numbers by name, and the map less its Gaussian mean surface."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map"
        with open(path, "wb") as file:
            np.array(s.heights.shape[::-1], dtype=np.int64).tofile(file)
            np.array(s.spacing[::-1]).tofile(file)
            np.ascontiguousarray(s.heights).tofile(file)
        lines = subprocess.run([program, path, str(cutoff)], capture_output=True, text=True, check=True).stdout.splitlines()
        found = {k: float(v) for k, v in (line.rsplit(" ", 1) for line in lines)}
        return found, np.fromfile(f"{path}.filtered").reshape(s.heights.shape)


def by_surfalize(s):
    """The same by surfalize, in metres and shares."""
    import surfalize

    surface = surfalize.Surface(form.remove(s, "plane").specimen.heights * 1e6, s.spacing[1] * 1e6, s.spacing[0] * 1e6)
    factor = {"ssk": 1, "sku": 1, "sdq": 1, "sdr": 0.01, "str": 1, "smrk1": 0.01, "smrk2": 0.01, "std_rad": np.pi / 180}
    factor["std_rad"] *= -1
    return {key: float(getattr(surface, name)()) * factor.get(key, 1e-6) for key, name in NAMES.items()}


def by_surface_topography(s):
    """Sq of the map less its plane, the map less a paraboloid and the material ratio half of Sq above the mean."""
    from SurfaceTopography import Topography

    bent = Topography(s.heights.T, s.size).detrend("curvature").heights().T
    flat = Topography(form.remove(s, "plane").specimen.heights.T, s.size)
    sq = float(flat.rms_height_from_area())
    return {"sq_m": sq, "smr": float(flat.bearing_area(0.5 * sq)), "poly2": bent - bent.mean()}


def maps(folder):
    """Measured maps without holes, and synthetic ones: lay, cylinder, fractal."""
    for path in sorted(Path(folder).iterdir()):
        if path.name.startswith(("LICENSE", "MANIFEST")) or path.suffix in (".xml", ".csv", ".opdx"):
            continue
        s = specimen.read(path, **UNITS.get(path.name, {}))
        if s.heights.ndim == 2:
            middle = tuple(slice((n - min(n, MOST_POINTS)) // 2, (n + min(n, MOST_POINTS)) // 2) for n in s.heights.shape)
            part = specimen.Specimen(np.ascontiguousarray(s.heights[middle]), s.spacing, path.name)
            yield specimen.clean(part, outliers=False, fill=True)[0]
    y, x = np.mgrid[:300, :360] * 1e-6
    rng = np.random.default_rng(7)
    rough = 1e-8 * rng.standard_normal(x.shape)
    u = x * np.cos(0.5) + y * np.sin(0.5)
    yield specimen.Specimen(1e-6 * np.sin(2 * np.pi * u / 23e-6) + rough, (1e-6, 1e-6), "lay at 0.5 rad")
    yield specimen.Specimen(np.sqrt(17.7e-3**2 - (u - 2e-4) ** 2) - 17.7e-3 + 0.003 * (y * np.cos(0.5) - x * np.sin(0.5)) + 20 * rough,
                            (1e-6, 1e-6), "cylinder, R = 17.7 mm")
    z, spacing = field(256, 1e-6, 2.4, rng, finer=2)
    yield specimen.Specimen(z, spacing, "fractal, D = 2.4")


def compare(program, s):
    """Numbers of one map by all, the cylinder, the polynomial and the filter."""
    cutoff = max(8 * max(s.spacing), 0.1 * min(s.size))
    ours = texture.numbers(form.remove(s, "plane").specimen.heights, s.spacing)
    theirs, filtered = gwyddion(program, s, cutoff)
    theirs["std_rad"] *= -1                             # theirs turns the other way, as surfalize's does
    st = by_surface_topography(s)
    row = {"map": s.name, "points": s.heights.shape, "spacing_m": s.spacing, "ours": ours, "surfalize": by_surfalize(s),
           "gwyddion": {k: v for k, v in theirs.items() if not k.startswith("cylinder")}}
    z = form.remove(s, "plane").specimen.heights
    inner = tuple(slice(int(np.ceil(cutoff / d)), -int(np.ceil(cutoff / d))) for d in s.spacing)
    if abs(s.spacing[0] / s.spacing[1] - 1) < 1e-3:     # Gwyddion's filter takes points, not lengths
        row["filter"] = float(np.max(abs(gaussian.highpass(z, s.spacing, cutoff) - filtered)[inner]) / np.std(z))
    row["smr"] = [float(texture.smr(z, 0.5 * np.std(z))), st["smr"]]
    row["sq_surface_topography"] = st["sq_m"]
    row["poly2"] = float(np.max(abs(form.remove(s, "poly2").specimen.heights - st["poly2"])) / np.std(z))
    try:
        c = form.remove(s, "cylinder")
        row["cylinder"] = [c.radius_m, float(np.std(c.specimen.heights))]
    except InputError as e:
        row["cylinder_error"] = str(e)
    if "cylinder_R" in theirs:
        row["cylinder_gwyddion"] = [-theirs["cylinder_R"], theirs["cylinder_rms"]]
    return row


def put_tables(rows):
    """Largest and median difference of each number; forms and filters."""
    lines = []
    for key, name in NAMES.items():
        if key == "std_rad":            # without a lay any direction will do: see the map with one
            continue
        cells = [name]
        for peer in ("gwyddion", "surfalize"):
            d = [abs(r["ours"][key] / r[peer][key] - 1) for r in rows
                 if r[peer].get(key) and np.isfinite(r[peer][key]) and np.isfinite(r["ours"][key] or np.nan)]
            cells.append(f"{np.median(d):.0e} / {max(d):.0e} ({len(d)})" if d else "-")
        lines.append(cells)
    put("areal", table(("number", "Gwyddion: median / largest (maps)", "surfalize: median / largest (maps)"), lines), "evidence/areal_numbers")
    forms = []
    for r in rows:
        ours, theirs = r.get("cylinder"), r.get("cylinder_gwyddion")
        forms.append((r["map"], "x".join(map(str, r["points"])), f"{1e3 * ours[0]:.6g}" if ours else "-", f"{1e3 * theirs[0]:.6g}" if theirs else "-",
                      f"{ours[1] / theirs[1] - 1:+.1e}" if ours and theirs else "-", f"{r['poly2']:.1e}", f"{r['filter']:.1e}" if "filter" in r else "-",
                      f"{abs(r['smr'][0] - r['smr'][1]):.1e}"))
    put("forms", table(("map", "points", "R / mm", "R of Gwyddion / mm", "rms left", "poly2", "L-filter", "Smr"), forms), "evidence/areal_numbers")


def main(folder):
    """All maps."""
    import SurfaceTopography

    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as place:
        program = build(place)
        rows = [compare(program, s) for s in maps(folder)]
    write_record("areal_numbers", rows, peers=(SurfaceTopography,), surfalize=version("surfalize"),
                 gwyddion=subprocess.run(["pkg-config", "--modversion", "gwyddion"], capture_output=True, text=True).stdout.strip())
    put_tables(rows)


if __name__ == "__main__":
    if "--tables" in sys.argv:
        put_tables(read_record("areal_numbers"))
    else:
        main(sys.argv[1])
