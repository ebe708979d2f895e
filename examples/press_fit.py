# SPDX-License-Identifier: GPL-3.0-or-later
"""
A press fit against Lamé's closed solution
==========================================

Two rings with 10 µm of interference, plane strain, meshes that do not match. Lamé's formula gives the pressure between them. The
program knows nothing of it: it solves the contact of two meshes of your own.
"""
import matplotlib.pyplot as plt
import numpy as np

from hdengine import mesh, solid

A, B, C, LENGTH, INTERFERENCE = 10e-3, 20e-3, 30e-3, 2e-3, 10e-6  # radii, length, interference [m]
YOUNG, POISSON = (210e9, 110e9), (0.3, 0.25)


def ring(inside, outside, divisions, young, poisson):
    """A ring as a body whose nodes have radial, tangential and axial dofs."""
    flat = mesh.block(np.linspace(inside, outside, 5), np.linspace(0, 2 * np.pi, divisions + 1), [0, LENGTH])
    turned = flat.warp(lambda p: np.c_[p[:, 0] * np.cos(p[:, 1]), p[:, 0] * np.sin(p[:, 1]), p[:, 2]])
    joined = mesh.merge(turned)
    return solid.Body(joined, young, poisson, np.arctan2(joined.points[:, 1], joined.points[:, 0]))


bodies = [ring(A, B, 60, YOUNG[0], POISSON[0]), ring(B, C, 48, YOUNG[1], POISSON[1])]
points = np.vstack([body.mesh.points for body in bodies])
n = len(bodies[0].mesh.points)
radius, theta = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])

# %%
# A chart unrolls the common cylinder. Axial displacements are held (plane strain), and so is the turn of either ring.

chart, touching = np.c_[B * theta, points[:, 2]], abs(radius - B) < 1e-9
slave = solid.Face(bodies[0].mesh.facets(touching[:n]), chart)
master = solid.Face(n + bodies[1].mesh.facets(touching[n:]), chart)
fixed = np.zeros(points.shape, bool)
fixed[:, 2] = True
fixed[(radius < A + 1e-9) | (radius > C - 1e-9), 1] = True
solution = solid.contact(bodies, slave, master, fixed, gap=np.full(len(points), -INTERFERENCE), mode="frictionless", period=2 * np.pi * B)

# %%
# Lamé, in plane strain.

(e1, e2), (n1, n2) = [[e / (1 - v**2) for e, v in zip(YOUNG, POISSON)], [v / (1 - v) for v in POISSON]]
give = B / e1 * ((B**2 + A**2) / (B**2 - A**2) - n1) + B / e2 * ((C**2 + B**2) / (C**2 - B**2) + n2)
exact = INTERFERENCE / give
on = solution.area > 0
pressure = solution.traction[0, on, 0]
print(f"pressure {pressure.mean() / 1e6:.2f} MPa, by Lamé {exact / 1e6:.2f} MPa: {100 * (pressure.mean() / exact - 1):+.2f} %")

figure, axis = plt.subplots(figsize=(6, 4))
axis.plot(np.degrees(theta[:len(on)][on]), pressure / 1e6, ".", label="hdengine")
axis.axhline(exact / 1e6, color="k", lw=1, label="Lamé")
axis.set_ylim(0, 1.2 * exact / 1e6)
axis.set_xlabel("angle / degree")
axis.set_ylabel("pressure / MPa")
axis.legend(loc="lower right")
figure.tight_layout()
