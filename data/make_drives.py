#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the whole drives: drive11.nml to drive40.nml, ratio 100, with all lengths in proportion to the size, and three other designs:
drive14_50.nml and drive14_160.nml (ratios 50 and 160) and drive14_short.nml (short cup).

A size is the pitch diameter of the circular spline in tenths of an inch. Lengths of size 14 and their sources: docs/explain/scene.md.
T1 and T2 of sizes 14 to 40 are the catalogue's (ratio 50: the same; 160: that above 50); those of size 11 and all rated torques are
estimates. Other ratios have the same pitch diameter: module, w and teeth follow, the tooth pairs keep their arc, the wall is kept.
The short cup is half as long as a long one, its hub the bolt circle of a short unit; rim and band are estimates.
"""
from pathlib import Path

TORQUES = {11: (0.8, 2.0, 5.0), 14: (2, 6.9, 7.8), 17: (3.9, 12, 24), 20: (7, 25, 40), 25: (14, 48, 67),
           32: (29, 108, 137), 40: (54, 196, 265)}  # T1, T2, rated [N m]

TEXT = """! Whole drive of size {size}, ratio {ratio}{design}: balls, ring, cup, friction and teeth, over the loop that a bench measures (docs/explain/drive.md).
! Lengths are {lengths} (data/make_drives.py): estimates, as are number and diameter of the balls, interference
! and clearance of the teeth. Every key and its default: hdengine.x --explain all. All values in SI units.
&hd_input
  version = 1
/
&run
  title = 'whole drive, size {size}, ratio {ratio}{design}'
/
&geometry
  bore_radius = {bore:.6g}
  wall_thickness = {wall:.6g}
  rim_thickness = {rim:.6g}   ! 1.67^(1/3) times the wall
  rim_length = {rim_length:.6g}
  rim_taper = {taper:.6g}
  cup_length = {cup:.6g}
  bottom_thickness = {bottom:.6g}
  hub_radius = {hub:.6g}
  ring_thickness = {ring:.6g}
  band_start = {start:.6g}
  band_length = {band:.6g}
/
&mesh
  divisions = 86
  band_facets = 15
/
&wave_generator
  w = {w:.6g}
  cam = 'cosine'
  interference = {interference:.6g}
/
&bearing
  balls = 21
  ball_diameter = {ball:.6g}
/
&contact
  friction = 0.15
/
&load
  support = 'drive'
  torque = {torque:.6g}    ! the loop goes up to it, back, to minus it and back: T2 twice
  torque_steps = 10  ! of each of its four legs
  teeth = {teeth}
  tooth_pairs = {pairs}
  tooth_stiffness = {stiffness:.6g}
  tooth_clearance = {clearance:.6g}   ! of the outermost pairs
/
&loop
  torque_1 = {t1}
  torque_2 = {t2}
  rated_torque = {rated}
/
&joint
  model = 'hu2023'
  asperity_radius = 5e-6
/
"""


def design(name, size, ratio=100, word="", lengths=None, **changes):
    """Write one file; `changes` are lengths [m] or torques [N m] of the design."""
    s, (t1, t2, rated) = size / 14, TORQUES[size]
    values = dict(bore=17.5e-3 * s, wall=0.36e-3 * s, rim=0.427e-3 * s, rim_length=9e-3 * s, taper=1e-3 * s, cup=20e-3 * s,
                  bottom=0.5e-3 * s, hub=8e-3 * s, ring=1e-3 * s, start=0.5e-3 * s, band=12e-3 * s, w=0.2e-3 * s * 100 / ratio,
                  interference=10e-6 * s, ball=3.2e-3 * s, torque=14 if size == 14 else 2 * t2, clearance=10e-6 * s, t1=t1, t2=t2,
                  rated=rated, teeth=2 * ratio, pairs=2 * round(0.2 * ratio), lengths=lengths or f"those of size 14 times {size}/14")
    values.update(changes)
    values["stiffness"] = 1.25e8 * values["rim_length"] / 9e-3
    (Path(__file__).parent / f"{name}.nml").write_text(TEXT.format(size=size, ratio=ratio, design=word, **values))


def main():
    """Write one file per size and design."""
    for size in TORQUES:
        design(f"drive{size}", size)
    for ratio in (50, 160):
        design(f"drive14_{ratio}", 14, ratio, lengths="those of ratio 100, but for w, which goes with the module")
    design("drive14_short", 14, word=", short cup", lengths="those of size 14 but for cup, rim, band and hub", cup=13.5e-3, rim_length=7e-3,
           band=8e-3, hub=8.5e-3, rated=5.4)


if __name__ == "__main__":
    main()
