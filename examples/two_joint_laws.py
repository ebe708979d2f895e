# SPDX-License-Identifier: GPL-3.0-or-later
"""
Two laws of one joint: spectrum and hu2023
==========================================

The law ``spectrum`` follows from the power spectrum of the surface and has no free number. The law ``hu2023`` is the paper's; it needs a radius
of asperities, which nobody can measure. So its stiffness is a band of choices.
"""
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import hdengine
from hdengine.elastic import ElasticJoint

data = next(d for d in (Path("data"), Path("../data")) if d.is_dir())  # of a checkout of hdengine

pressure = np.geomspace(1e5, 2e8, 40)
scene = hdengine.read_scene(data / "paper.nml", joint__model="spectrum")
k_spectrum = ElasticJoint.of_scene(scene).stiffness(pressure)[0]

figure, axis = plt.subplots(figsize=(6, 4.2))
axis.loglog(pressure / 1e6, k_spectrum / 1e12, label="spectrum")
with warnings.catch_warnings():
    warnings.simplefilter("ignore", hdengine.JointWarning)  # spots larger than an asperity's base: the law is extrapolated
    for radius, style in ((5e-6, "--"), (50e-6, "-."), (250e-6, ":")):
        k = hdengine.Joint(asperity_radius=radius).closure(pressure)[1]
        axis.loglog(pressure / 1e6, k / 1e12, style, label=f"hu2023, r_m = {1e6 * radius:g} µm")
axis.set_xlabel("pressure / MPa")
axis.set_ylabel("k_N / (TPa/m)")
axis.legend()
figure.tight_layout()
