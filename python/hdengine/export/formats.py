# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint of a drive as text for other programs."""
from __future__ import annotations

import numpy as np

from .law import JointLaw

__all__: list[str] = []
FAR = 10.0  # rad: no joint of a drive twists so far


def head_of(law: JointLaw) -> list[str]:
    """What every format says before its numbers: title, readings, what the law is."""
    readings = ", ".join(f"{name} = {value:.6g}" for name, value in law.readings.items())
    loop = bool((law.falling_rad != law.rising_rad).any())
    curve = "middle of the loop" if loop else "first rise, for want of a loop"
    return [f"{law.title}: torque over the twist of the output, {curve}, by hdengine",
            "K1 to K3 are chords of the rise, not of this middle: " * loop + readings,
            f"friction beside it, half of the loop's width: {law.friction_nm:.4g} N m"]


def to_csv(law: JointLaw) -> str:
    """A table: torque, angle of the middle, both branches, slope; lines of the head begin with #."""
    rows = np.column_stack([law.torque_nm, law.angle_rad, law.falling_rad, law.rising_rad, law.stiffness_nm_per_rad])
    names = "torque_nm,angle_rad,angle_falling_rad,angle_rising_rad,stiffness_nm_per_rad"
    return "\n".join([*(f"# {line}" for line in head_of(law)), names, *(",".join(f"{v:.9g}" for v in row) for row in rows)]) + "\n"


def to_mujoco(law: JointLaw) -> str:
    """A MuJoCo model of one hinge: its stiffness, and a tendon for every change of slope, which pulls beyond its angle alone."""
    slope = np.diff(law.torque_nm) / np.diff(law.angle_rad)
    middle = len(law.angle_rad) // 2                       # the row of no torque: the slopes beside it are equal
    tendons = []
    for i in range(1, len(slope)):
        if i == middle:
            continue
        change = slope[i] - slope[i - 1] if i > middle else slope[i - 1] - slope[i]
        ends = f"{-FAR:g} {law.angle_rad[i]:.9g}" if i > middle else f"{law.angle_rad[i]:.9g} {FAR:g}"
        tendons.append(f'    <fixed stiffness="{change:.9g}" springlength="{ends}"><joint joint="drive" coef="1"/></fixed>')
    comment = "\n".join(f"  {line.replace('--', '- -')}" for line in head_of(law))
    return f"""<mujoco model="harmonic drive">
<!--
{comment}
  Copy joint and tendons into your model; frictionloss="{law.friction_nm:.4g}" on the joint gives a slow loop its width. By
  solreffriction and solimpfriction it holds at rest: those of MuJoCo let it creep to 0 within 0.5 s.
  The body is there so that the file loads: put your link in its place. Its damping is chosen, not computed.
-->
  <option timestep="1e-4" gravity="0 0 0"/>
  <worldbody>
    <body name="link">
      <joint name="drive" type="hinge" axis="0 0 1" stiffness="{slope[middle]:.9g}" damping="10"
             solreffriction="2e-4 1" solimpfriction="0.9999 0.9999 0.001"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.05 0.05 0.05"/>
    </body>
  </worldbody>
  <tendon>
""" + "\n".join(tendons) + "\n  </tendon>\n</mujoco>\n"


def to_modelica(law: JointLaw) -> str:
    """A Modelica model of the spring, by the Modelica Standard Library."""
    angle, torque = (", ".join(f"{v:.9g}" for v in values) for values in (law.angle_rad, law.torque_nm))
    title, *notes = (line.replace("\\", "/").replace('"', "'") for line in head_of(law))
    comment = "\n".join(f"  // {line}" for line in notes)
    return f"""model HarmonicDriveSpring "{title}"
{comment}
  extends Modelica.Mechanics.Rotational.Interfaces.PartialCompliant;
  constant Modelica.Units.SI.Angle angle[:] = {{{angle}}};
  constant Modelica.Units.SI.Torque torque[:] = {{{torque}}};
equation
  tau = Modelica.Math.Vectors.interpolate(angle, torque, phi_rel);
end HarmonicDriveSpring;
"""


def to_urdf_comment(law: JointLaw) -> str:
    """A comment for the joint of a URDF file, which knows no stiffness: readings and the table."""
    rows = "\n".join(f"  {t:12.6g} {a:14.6g}" for t, a in zip(law.torque_nm, law.angle_rad))
    head = "\n".join(f"  {line.replace('--', '- -')}" for line in head_of(law))
    return f"<!--\n{head}\n    torque_nm      angle_rad\n{rows}\n-->\n"


FORMATS = {"csv": (to_csv, ".csv"), "mujoco": (to_mujoco, ".xml"), "modelica": (to_modelica, ".mo"),
           "urdf-comment": (to_urdf_comment, ".urdf.xml")}
