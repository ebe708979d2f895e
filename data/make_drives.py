#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes data/drive11.nml to drive25.nml: the whole drive of sizes 11 to 25, ratio 100, with all lengths in proportion to the size.

A size is the pitch diameter of the circular spline in tenths of an inch. Lengths of size 14 and their sources: docs/explain/scene.md.
T1 and T2 of sizes 14 to 25 are the catalogue's; those of size 11 and all rated torques are estimates.
"""
from pathlib import Path

TORQUES = {11: (0.8, 2.0, 5.0), 14: (2, 6.9, 7.8), 17: (3.9, 12, 24), 20: (7, 25, 40), 25: (14, 48, 67)}  # T1, T2, rated [N m]

TEXT = """! Whole drive of size {size}, ratio 100: balls, ring, cup, friction and teeth, over the loop that a bench measures (docs/explain/drive.md).
! Lengths are those of size 14 times {size}/14 (data/make_drives.py): estimates, as are number and diameter of the balls, interference
! and clearance of the teeth. Every key and its default: hdengine.x --explain all. All values in SI units.
&hd_input
  version = 1
/
&run
  title = 'whole drive, size {size}, ratio 100'
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
  tooth_pairs = 40
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


def main():
    """Write one file per size."""
    for size, (t1, t2, rated) in TORQUES.items():
        s = size / 14
        text = TEXT.format(size=size, bore=17.5e-3 * s, wall=0.36e-3 * s, rim=0.427e-3 * s, rim_length=9e-3 * s, taper=1e-3 * s,
                           cup=20e-3 * s, bottom=0.5e-3 * s, hub=8e-3 * s, ring=1e-3 * s, start=0.5e-3 * s, band=12e-3 * s,
                           w=0.2e-3 * s, interference=10e-6 * s, ball=3.2e-3 * s, torque=14 if size == 14 else 2 * t2,
                           stiffness=1.25e8 * s, clearance=10e-6 * s, t1=t1, t2=t2, rated=rated)
        (Path(__file__).parent / f"drive{size}.nml").write_text(text)


if __name__ == "__main__":
    main()
