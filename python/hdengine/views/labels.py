# SPDX-License-Identifier: GPL-3.0-or-later
"""Names, units and factors of columns and keys, as figures and tables show them."""
from math import pi

from .. import _engine

__all__: list[str] = []
SHOWN = ("pressure_max_pa", "normal_force_n")   # beside K_TS, of a study whose figure asks for nothing else
LOOP = _engine.names("loop")  # results of a whole drive's loop, readings first: in the last row of a point
ENDS = {"": "", "_low": ", low", "_high": ", high"}  # of a 95 % band
LABELS = {  # column: (label, unit, factor)
    "torque_nm": ("torque", "N m", 1), "k_ts_nm_per_rad": ("$K_{TS}$ (Eq. 45)", "MN m/rad", 1e-6),
    "k_ts_normal_nm_per_rad": ("$K_{TS}$, normal part", "MN m/rad", 1e-6),
    "k_ts_bonded_nm_per_rad": ("$K_{TS}$, tangent", "MN m/rad", 1e-6),
    "k_ts_secant_nm_per_rad": ("$K_{TS}$, secant", "MN m/rad", 1e-6),
    "slip_share_k_ts": ("slipping share of Eq. 45", "%", 100), "edge_line_load_n_per_m": ("line load of the ends", "kN/m", 1e-3),
    "k_ts_paper_n": ("Eq. 45 as printed", "MN", 1e-6), "pressure_max_pa": ("peak pressure at a node", "MPa", 1e-6),
    "pressure_mid_mean_pa": ("mean pressure, mid band", "MPa", 1e-6), "normal_force_n": ("normal force", "N", 1),
    "contact_area_m2": ("contact area", "mm²", 1e6), "rotation_rad": ("rotation", "µrad", 1e6),
    "k_fe_secant_nm_per_rad": ("torque over rotation", "kN m/rad", 1e-3), "k_fts_nm_per_rad": ("$K_{FTS}$", "kN m/rad", 1e-3),
    "torque_balance_nm": ("torque out of balance", "N m", 1),
    **{f"k{i}_nm_per_rad{end}": (f"$K_{i}${words}", "kN m/rad", 1e-3) for i in (1, 2, 3) for end, words in ENDS.items()},
    **{f"{name}_rad{end}": (f"{name.replace('_', ' ')}{words}", "arcmin", 60 * 180 / pi)
       for name in ("hysteresis", "lost_motion") for end, words in ENDS.items()},
    "ball_force_max_n": ("largest force of a ball", "N", 1), "tooth_force_max_n": ("largest force of a flank", "N", 1),
    **{f"pressure_long_{i}_pa": (f"pressure at Position {'I' * i}, long axis", "MPa", 1e-6) for i in (1, 2, 3)},
    **{f"geometry.{name}": (name.replace("_", " "), "mm", 1e3) for name in (
        "bore_radius", "wall_thickness", "rim_thickness", "rim_length", "cup_length", "bottom_thickness", "hub_radius",
        "ring_thickness", "band_length")}, "load.tooth_clearance": ("clearance", "µm", 1e6),
    "wave_generator.w": ("radial deformation w", "mm", 1e3), "wave_generator.eccentricity": ("eccentricity", "µm", 1e6),
    "wave_generator.interference": ("interference", "µm", 1e6), "wave_generator.clearance": ("clearance", "µm", 1e6),
    "load.torque": ("final torque", "N m", 1),
    "contact.friction": ("friction", "", 1), "joint.asperity_radius": ("asperity radius $r_m$", "µm", 1e6),
    "joint.s_min": ("smallest spot $s_{min}$", "µm²", 1e12), "joint.fractal_dimension": ("fractal dimension D", "", 1),
    "joint.roughness": ("roughness G", "µm", 1e6), "joint.hardness": ("hardness", "GPa", 1e-9),
    "material.flexspline_e": ("E of the flexspline", "GPa", 1e-9), "material.ring_e": ("E of the ring", "GPa", 1e-9),
    "friction_capacity_nm": ("friction capacity", "N m", 1), "friction_torque_nm": ("torque through friction", "N m", 1),
}


def label(column: str) -> tuple[str, float]:
    """(axis label, factor) of a column."""
    name, unit, factor = LABELS.get(column, (column.replace("_", " "), "", 1))
    unit = f"({unit})" if "/" in unit else unit
    return f"{name} / {unit}" if unit else name, factor
