# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the two synthetic specimens of this folder: Eq. 1, M = 10, gamma = 1.5, L = 0.5 mm, L_s = 1 um, 501 x 501 points.

Both have D_s = 1.5304; their S add up to that of G = 2.4248e-7 m (Hu et al. 2023, Fig. 5), 65 % from the flexspline and 35 %
from the bearing: G_i = G share_i^(1/(2(D-2))). Seeds 1 and 2. Run: python data/make_specimens.py
"""
from pathlib import Path

from hdengine import specimen, surface

D, G, L = 2.5304, 2.4248e-7, 0.5e-3

for name, share, seed in (("flexspline", 0.65, 1), ("bearing", 0.35, 2)):
    g = G * share ** (1 / (2 * (D - 2)))
    z = surface.generate(501, 1e-6, D, g, 1.5, L, 1e-6, 10, seed, method="direct")
    specimen.save(Path(__file__).parent / f"specimen_{name}.sdf", specimen.Specimen(z, (1e-6, 1e-6)))
