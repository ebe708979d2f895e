#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""joint.model = 'auto' of CD-14-100 at work: which model six surfaces get at two loads, and how far that lies from boundary elements.

Each scene says the area that sticks, its mean pressure and its touching waves. The truth is k_N by boundary elements on periodic maps as large
as that area, 8 points to the shortest wave, three sets of phases, no wave longer than joint.sample_length; elastic. Beside the theory stands the table
that a user can have: boundary elements on a piece of a quarter of the side, measured on one map, for the contact of another.
Writes bench/results/joint_scenes.json and the table of docs/evidence/joint_scenes.md. Usage: bench/joint_scenes.py [--redraw]
"""
import argparse
import tempfile
from pathlib import Path

import numpy as np

import hdengine
from common import DATA, put, read_record, table, write_record
from hdengine.elastic import ElasticJoint, moduli
from hdengine.prediction.bodies import Bodies
from hdengine.prediction.choice import TRUST
from hdengine.prediction.half_space import HalfSpace, tamaas
from hdengine.prediction.law import predict

E_STAR, RATIO = moduli(209e9, 0.295, 219e9, 0.30)
POINTS, SHORTEST, H_RMS, SEEDS = {"light": 480, "heavy": 256}, 200e-6, 1e-6, (7001, 7002, 7003)
SURFACES = [(d, length) for d in (2.1, 2.5, 2.9) for length in (1.2e-3, 4e-3)]
LOADS = {"light": {"wave_generator.w": 0.05e-3, "load.torque": 1.0}, "heavy": {"wave_generator.w": 0.2e-3, "load.torque": 5.0}}
SOFT = Bodies(hardness=1e13)


def g_of(d, length):
    """G [m] of Eq. 1 in the continuum that has H_RMS between both wavelengths."""
    a = 2 * (3 - d)
    return (2 * a * H_RMS**2 / (length**a - SHORTEST**a)) ** (0.5 / (d - 2))


def rough(side, n, d, length, seed):
    """Periodic map of n x n points of that spectrum [m], random phases."""
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(n, side / n), np.fft.rfftfreq(n, side / n), indexing="ij"))
    inside = (f >= 1 / length) & (f <= 1 / SHORTEST)
    amplitude = np.where(inside, np.where(inside, f, 1.0) ** -(4.0 - d), 0.0)
    z = np.fft.irfft2(amplitude * np.exp(2j * np.pi * np.random.default_rng(seed).random(f.shape)), (n, n))
    return z * H_RMS / z.std()


def scene(d, length, load, folder):
    """What a run says of its joint, and k_N by theory at the mean pressure."""
    (folder / "be.csv").write_text("pressure_pa,k_n_pa_per_m\n1e4,1e11\n1e9,1e16\n")
    keys = {"joint.model": "auto", "joint.table_file": str(folder / "be.csv"), "joint.fractal_dimension": d, "joint.roughness": g_of(d, length),
            "joint.sample_length": length, "joint.shortest_wavelength": SHORTEST, "joint.hardness": SOFT.hardness, "output.vtu": "none",
            **LOADS[load]}
    chosen = hdengine.run(DATA / "cd14_ground.nml", folder / "auto", True, **keys).summary["joint"]
    named = hdengine.run(DATA / "cd14_ground.nml", folder / "spectrum", True, **{**keys, "joint.model": "spectrum"})
    error = named.summary["joint"]["theory_error"]
    law = ElasticJoint.of_scene(named.scene)
    return {"taken": chosen["model"], "reason": chosen["chosen_because"], **error, "k_n_theory": float(law.stiffness(error["mean_pressure_pa"])[0])}


def collect():
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for d, length in SURFACES:
            for load in LOADS:
                row = {"fractal_dimension": d, "sample_length_m": length, "load": load, **scene(d, length, load, Path(folder))}
                n, side, p = POINTS[load], row["area_m2"] ** 0.5, row["mean_pressure_pa"]
                dx = (side / n,) * 2
                truth, patch = [], []
                for seed in SEEDS:
                    z = rough(side, n, d, length, seed)
                    space = HalfSpace(z, dx, E_STAR, RATIO)
                    truth.append(space.normal_stiffness(space.press(p) > 0))
                    piece = z[:n // 4, :n // 4]
                    patch.append(float(predict((piece, dx), pressure=[p], model="boundary_elements", points=n // 4, bodies=SOFT,
                                               draws=10).table["k_n_pa_per_m"][0]))
                row["theory"] = [float(f"{np.log(row['k_n_theory'] / k):.3g}") for k in truth]
                row["table_of_a_piece"] = [float(f"{np.log(patch[i - 1] / truth[i]):.3g}") for i in range(len(SEEDS))]
                rows.append({k: float(f"{v:.5g}") if isinstance(v, float) else v for k, v in row.items()})
                print(rows[-1], flush=True)
    write_record("joint_scenes", rows, seed=SEEDS[0], peers=(tamaas(),))
    return rows


def rms(logs):
    return f"{100 * np.sqrt(np.mean(np.square(logs))):.0f} %"


def pages(rows):
    out = [[f"{r['fractal_dimension']}, {1e3 * r['sample_length_m']:g} mm", r["load"], f"{1e-6 * r['mean_pressure_pa']:.2g}",
            f"{r['contact_area_fraction'] * r['independent_waves']:.2g}", f"{100 * r['ln_k_n_half_width']:.0f} %", f"`{r['taken']}`",
            rms(r["theory"]), rms(r["table_of_a_piece"])] for r in rows]
    put("joint-scenes", table(["D, longest wave", "load", "pressure / MPa", "touching waves", "stated", "taken", "theory", "piece"], out),
        "evidence/joint_scenes")
    kept = [abs(e) <= r["ln_k_n_half_width"] for r in rows for e in r["theory"]]
    print(f"{sum(kept)} of {len(kept)} errors within what is stated; of those taken within {TRUST:g}:",
          [(abs(e) <= TRUST) for r in rows if r["taken"] == "spectrum" for e in r["theory"]])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--redraw", action="store_true", help="table from the record")
    pages(read_record("joint_scenes") if parser.parse_args().redraw else collect())


if __name__ == "__main__":
    main()
