#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the whole drives from one table of stated inputs: drive11.nml to drive40.nml (ratio 100), drive20_30, _50, _160 (other ratios)
and drive14_hat.nml (silk hat in place of the cup). Other sizes and ratios: data/make_drives.py SIZE RATIO [hat].

A size is the pitch diameter of the circular spline in tenths of an inch. What is known of a size stands in `UNITS`; all other lengths
are those of size 14 times size/14. Sources and tolerances of every input: docs/evidence/drive.md. Nothing is fitted to a catalogue.
Clearances of the teeth are those of an involute rack of 20 degrees on the rim of the assembled drive, solved here for each file, with
the play of the closest pair; so the drive must be built first (./hd setup).
"""
import math
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import hdengine

HERE = Path(__file__).parent


@dataclass
class Unit:
    """A size: torques [N m] of the catalogue, outer diameter of the circular spline and clamped radius of the bottom [mm]."""

    t1: float
    t2: float
    rated: float          # ratio 100; above T2, so the loop reaches K3
    spline: float = 0     # 0: in proportion to size 20
    clamp: float = 0      # half the screws' circle and half a screw head; 0: likewise


UNITS = {11: Unit(0.8, 2.0, 5.0), 14: Unit(2, 6.9, 7.8, 50, 11.25), 17: Unit(3.9, 12, 24, 60, 13.25), 20: Unit(7, 25, 40, 70, 15.5),
         25: Unit(14, 48, 67, 85, 19.25), 32: Unit(29, 108, 137, 110, 25.5), 40: Unit(54, 196, 265, 135, 30.5), 45: Unit(76, 275, 353),
         50: Unit(108, 382, 470), 58: Unit(168, 598, 696), 65: Unit(235, 843, 951), 80: Unit(430, 1570, 1800), 90: Unit(618, 2260, 2590)}
PLAY = 1e-6         # of the closest pair of size 14, round the axis [m]
FILES = [(size, 100, "") for size in (11, 14, 17, 20, 25, 32, 40)] + [(20, 30, ""), (20, 50, ""), (20, 160, ""), (14, 100, "hat")]


def clearance(diameter):
    """Mean radial clearance of a normal bearing (ISO 492) in a bore to H7 (ISO 286) [m]."""
    for most, bore, bearing in ((50e-3, 25e-6, 11e-6), (80e-3, 30e-6, 13e-6), (120e-3, 35e-6, 15e-6), (180e-3, 40e-6, 18e-6),
                                (250e-3, 46e-6, 20e-6)):
        if diameter <= most:
            return (bore + bearing) / 4
    raise ValueError(diameter)


def pressure_angle(ratio):
    """Of the teeth, from a maker's formula of the axial force [deg]."""
    return 20 if ratio >= 80 else 30 if ratio >= 50 else 32


def thinning(ratio):
    """Factor on wall, rim and ring. Below ratio 50, where w is larger, they are thinner, so that the stress of bending them to the cam,
    E w t / r^2, stays at that of ratio 50."""
    return min(1, ratio / 50)



def scene(size, ratio=100, shape=""):
    """Keys of a drive, group by group."""
    unit, s, thin = UNITS[size], size / 14, thinning(ratio)
    bore = 17.5e-3 * s
    geometry = dict(bore_radius=bore, rim_length=9e-3 * s, ring_thickness=1e-3 * s * thin, band_start=1.5e-3 * s, band_length=6e-3 * s)
    cup = {}
    if shape == "hat":
        cup = dict(sections_r=[bore] * 4 + [27e-3 * s], sections_z=[x * s for x in (0, 9e-3, 10e-3, 20e-3, 20e-3)],
                   sections_thickness=[x * s for x in (0.427e-3 * thin, 0.427e-3 * thin, 0.36e-3 * thin, 0.36e-3 * thin, 0.5e-3)],
                   sections_fillet=[0, 0, 0, 1.5e-3 * s, 0])
    else:
        geometry |= dict(wall_thickness=0.36e-3 * s * thin, rim_thickness=0.427e-3 * s * thin, rim_taper=1e-3 * s, cup_length=20e-3 * s,
                         bottom_thickness=0.5e-3 * s, hub_radius=unit.clamp * 1e-3 or 15.5e-3 * size / 20)
    return {
        "run": dict(title=f"whole drive, size {size}, ratio {ratio}" + (", silk hat" if shape else "")),
        "geometry": geometry, "cup": cup, "mesh": dict(divisions=86, band_facets=10),
        "wave_generator": dict(w=0.2e-3 * s * 100 / ratio, cam="cosine", clearance=clearance(2 * bore)),
        "bearing": dict(balls=21, ball_diameter=3.2e-3 * s), "contact": dict(friction=0.1),
        "load": dict(support="drive", torque=unit.rated, torque_steps=10, teeth=2 * ratio, tooth_pairs=2 * round(0.2 * ratio),
                     pressure_angle_deg=pressure_angle(ratio), tooth_stiffness=1.25e8 * s,
                     spline_diameter=unit.spline * 1e-3 or 70e-3 * size / 20),
        "loop": dict(torque_1=unit.t1, torque_2=unit.t2, rated_torque=unit.rated)}


def text(groups):
    """A namelist."""
    def value(x):
        if isinstance(x, (list, tuple)):
            return ", ".join(f"{v:.6g}" for v in x)
        return f"'{x}'" if isinstance(x, str) else f"{x:.6g}"
    return "".join(f"&{group}\n" + "".join(f"  {key} = {value(x)}\n" for key, x in keys.items()) + "/\n"
                   for group, keys in groups.items() if keys)


def with_teeth(groups, size, ratio):
    """The same with the clearances of its teeth, on the rim of its own assembly."""
    module = 35.56e-3 * size / 14 / (2 * ratio)
    gap = PLAY * size / 14 * math.cos(math.radians(pressure_angle(ratio)))
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "rim.nml").write_text(text(groups))
        subprocess.run([Path(sys.executable).parent / "hdengine.x", "rim.nml", "loop.torques=0,0", "load.torque_steps=1", "output.vtu=last", "-q"],
                       cwd=folder, check=True)
        keys = hdengine.tooth_gaps(hdengine.Involute(module=module), f"{folder}/rim.out", least_gap=gap).keys()
    groups["load"] |= {key.split(".")[1]: keys[key] for key in ("load.tooth_gaps", "load.tooth_gaps_back")}
    return groups


def write(size, ratio=100, shape=""):
    """Write one file."""
    name = f"drive{size}" + (f"_{ratio}" if ratio != 100 else "") + (f"_{shape}" if shape else "")
    head = (f"! Whole drive of size {size}, ratio {ratio}{', silk hat' if shape else ''}, as it is built: fit, balls, ring, contact with friction, "
            "cup, teeth and\n! circular spline, over the loop that a bench measures (docs/explain/drive.md). Made by data/make_drives.py from one table of\n"
            "! stated inputs. Every key and its default: hdengine.x --explain all. All values in SI units.\n&hd_input\n  version = 1\n/\n")
    (HERE / f"{name}.nml").write_text(head + text(with_teeth(scene(size, ratio, shape), size, ratio)))


def main():
    """Write the shipped files, or one."""
    if len(sys.argv) > 1:
        write(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:])
        return
    for case in FILES:
        write(*case)


if __name__ == "__main__":
    main()
