# SPDX-License-Identifier: GPL-3.0-or-later
"""Write data/torque_record.csv: a synthetic record of the test bench (Fig. 9), with the bench's stated errors.

The middle curve has K(T) = 2042 + 3761 (1 - exp(-|T| / 2.5 N m)) N m/rad, through the two measured values of the paper, 2724 at
0.5 and 5294 at 5 N m; hysteresis 0.8 arcmin; torque in steps of 0.02 N m; errors: a straight line within +-0.05 N m and +-2 arcsec
plus scatter of a tenth of both.

Usage: python data/make_torque_record.py [OUT.csv] [--seed N]
"""
import argparse
from pathlib import Path

import numpy as np

A, B, C, TOP, WIDTH = 5803.0, 3761.0, 2.5, 5.0, 0.4 / 60 * np.pi / 180
ARCSEC = np.pi / 180 / 3600


def stiffness(torque):
    """dT/dθ of the middle curve [N m/rad]."""
    return A - B * np.exp(-np.abs(torque) / C)


def angle(torque):
    """Middle curve [rad]."""
    t = np.abs(torque)
    return np.sign(torque) * C / A * np.log((A * np.exp(t / C) - B) / (A - B))


def record(seed=1):
    """Torque [N m] and angle [rad] as the bench would read them."""
    step = 0.02
    first, down, up = np.arange(0, TOP, step), np.arange(TOP, -TOP, -step), np.arange(-TOP, TOP + step / 2, step)
    torque = np.concatenate([first, down, up])
    x = torque / TOP
    sense = np.concatenate([1.5 * np.abs(first) / TOP, -np.ones(len(down)), np.ones(len(up))])
    true = angle(torque) - sense * WIDTH * (1 - x**2)
    generator = np.random.default_rng(seed)
    ends = generator.uniform(-1, 1, (2, 2))
    line = [e[0] * (1 - x) / 2 + e[1] * (1 + x) / 2 for e in ends]
    torque_read = torque + 0.05 * (line[0] + 0.1 * generator.uniform(-1, 1, len(x)))
    angle_read = true + 2 * ARCSEC * (line[1] + 0.1 * generator.uniform(-1, 1, len(x)))
    return np.round(torque_read, 3), angle_read


def main():
    """Write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", nargs="?", default=Path(__file__).resolve().parents[1] / "data/torque_record.csv")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    torque, turn = record(args.seed)
    np.savetxt(args.out, np.column_stack([torque, turn / ARCSEC]), delimiter=",", comments="", fmt=["%.3f", "%.2f"],
               header="torque_nm,angle_arcsec")


if __name__ == "__main__":
    main()
