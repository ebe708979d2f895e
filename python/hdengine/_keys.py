# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys of a scene by group, for editors and type checkers. Made by tools/typed_keys.py of the engine's table; do not edit."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict


class HdInputKeys(TypedDict, total=False):
    """Keys of &hd_input."""

    version: int


class RunKeys(TypedDict, total=False):
    """Keys of &run."""

    title: str
    tolerance: float
    wanted: str
    band: bool | str
    gradient: bool | str


class GeometryKeys(TypedDict, total=False):
    """Keys of &geometry."""

    bore_radius: float  # m
    wall_thickness: float  # m
    rim_thickness: float  # m
    rim_length: float  # m
    rim_taper: float  # m
    cup_length: float  # m
    bottom_thickness: float  # m
    hub_radius: float  # m
    ring_thickness: float  # m
    band_start: float  # m
    band_length: float  # m


class CupKeys(TypedDict, total=False):
    """Keys of &cup."""

    sections_r: Sequence[float] | float  # m
    sections_z: Sequence[float] | float  # m
    sections_thickness: Sequence[float] | float  # m
    sections_fillet: Sequence[float] | float  # m


class MaterialKeys(TypedDict, total=False):
    """Keys of &material."""

    flexspline_e: float  # Pa
    flexspline_nu: float
    ring_e: float  # Pa
    ring_nu: float
    yield_strength: float  # Pa
    ring_yield_strength: float  # Pa


class MeshKeys(TypedDict, total=False):
    """Keys of &mesh."""

    divisions: int
    band_facets: int
    ring_divisions: int
    ring_facets: int
    wall_elements: int
    bottom_elements: int
    through_wall: int
    through_ring: int
    edge_length: float  # m
    element: str
    memory_limit_mb: float  # MB


class WaveGeneratorKeys(TypedDict, total=False):
    """Keys of &wave_generator."""

    w: float  # m
    cam: str
    lobes: int
    arc_angle_deg: float  # deg
    cam_file: str
    perimeter: str
    perimeter_length: float  # m
    ring_tangent: str
    ring_contact: str
    ball_stiffness: float  # N/m
    shape: str
    cone_angle_deg: float  # deg
    eccentricity: float  # m
    eccentricity_angle_deg: float  # deg
    interference: float  # m
    clearance: float  # m


class ContactKeys(TypedDict, total=False):
    """Keys of &contact."""

    mode: str
    friction: float
    torque_friction: float
    law: str
    zero_pressure: float  # Pa
    slave: str


class LoadKeys(TypedDict, total=False):
    """Keys of &load."""

    support: str
    torque_load: str
    teeth: int
    tooth_pairs: int
    pressure_angle_deg: float  # deg
    tooth_stiffness: float  # N/m
    tooth_gaps: Sequence[float] | float  # m
    tooth_gaps_back: Sequence[float] | float  # m
    tooth_clearance: float  # m
    tooth_friction: float
    spline: str
    spline_diameter: float  # m
    tooth_phase: float
    torque: float  # N m
    support_stiffness: float  # N/m
    assembly_steps: int
    torque_steps: int
    tangent_steps: str


class BearingKeys(TypedDict, total=False):
    """Keys of &bearing."""

    balls: int
    model: str
    ball_diameter: float  # m
    inner_conformity: float
    outer_conformity: float
    groove_depth: float  # m
    clearance: float  # m
    cage_angle_deg: float  # deg
    ball_e: float  # Pa
    ball_nu: float
    ball_rate: float  # N/m^1.5
    patch_length: float  # m
    patch_width: float  # m


class LoopKeys(TypedDict, total=False):
    """Keys of &loop."""

    torques: Sequence[float] | float  # N m
    history: str
    torque_1: float  # N m
    torque_2: float  # N m
    rated_torque: float  # N m


class TurningKeys(TypedDict, total=False):
    """Keys of &turning."""

    positions: int
    range_deg: float  # deg
    torque: float  # N m


class FatigueKeys(TypedDict, total=False):
    """Keys of &fatigue."""

    tensile_strength: float  # Pa
    fatigue_limit: float  # Pa
    notch_factor: float


class SolverKeys(TypedDict, total=False):
    """Keys of &solver."""

    method: str
    factors: str
    kinematics: str
    start: str
    symmetry: str
    tolerance: float
    max_iterations: int
    max_cuts: int
    time_limit_s: float  # s


class JointKeys(TypedDict, total=False):
    """Keys of &joint."""

    model: str
    table_file: str
    spectrum_file: str
    from_fit: str
    fractal_dimension: float
    roughness: float  # m
    gamma: float
    sample_length: float  # m
    shortest_wavelength: float  # m
    asperity_radius: float  # m
    s_min: float  # m^2
    hardness: float  # Pa
    closure: str
    plastic_spots: str


class OutputKeys(TypedDict, total=False):
    """Keys of &output."""

    vtu: str
    contact: str
    positions: Sequence[float] | float  # m


class SurfaceKeys(TypedDict, total=False):
    """Keys of &surface."""

    nx: int
    ny: int
    dx: float  # m
    dy: float  # m
    fractal_dimension: float
    roughness: float  # m
    gamma: float
    sample_length: float  # m
    shortest_wavelength: float  # m
    ridges: int
    seed: int
    tolerance: float
    method: str
    precision: str


class FitKeys(TypedDict, total=False):
    """Keys of &fit."""

    first_file: str
    second_file: str
    dx: float  # m
    dy: float  # m
    first_lag: int
    last_lag: int
    model: str
    shortest_wavelength: float  # m
    longest_wavelength: float  # m


class SceneKeys(TypedDict, total=False):
    """Groups of a scene, and every key as group__key."""

    hd_input: HdInputKeys
    run: RunKeys
    geometry: GeometryKeys
    cup: CupKeys
    material: MaterialKeys
    mesh: MeshKeys
    wave_generator: WaveGeneratorKeys
    contact: ContactKeys
    load: LoadKeys
    bearing: BearingKeys
    loop: LoopKeys
    turning: TurningKeys
    fatigue: FatigueKeys
    solver: SolverKeys
    joint: JointKeys
    output: OutputKeys
    surface: SurfaceKeys
    fit: FitKeys
    hd_input__version: int
    run__title: str
    run__tolerance: float
    run__wanted: str
    run__band: bool | str
    run__gradient: bool | str
    geometry__bore_radius: float
    geometry__wall_thickness: float
    geometry__rim_thickness: float
    geometry__rim_length: float
    geometry__rim_taper: float
    geometry__cup_length: float
    geometry__bottom_thickness: float
    geometry__hub_radius: float
    geometry__ring_thickness: float
    geometry__band_start: float
    geometry__band_length: float
    cup__sections_r: Sequence[float] | float
    cup__sections_z: Sequence[float] | float
    cup__sections_thickness: Sequence[float] | float
    cup__sections_fillet: Sequence[float] | float
    material__flexspline_e: float
    material__flexspline_nu: float
    material__ring_e: float
    material__ring_nu: float
    material__yield_strength: float
    material__ring_yield_strength: float
    mesh__divisions: int
    mesh__band_facets: int
    mesh__ring_divisions: int
    mesh__ring_facets: int
    mesh__wall_elements: int
    mesh__bottom_elements: int
    mesh__through_wall: int
    mesh__through_ring: int
    mesh__edge_length: float
    mesh__element: str
    mesh__memory_limit_mb: float
    wave_generator__w: float
    wave_generator__cam: str
    wave_generator__lobes: int
    wave_generator__arc_angle_deg: float
    wave_generator__cam_file: str
    wave_generator__perimeter: str
    wave_generator__perimeter_length: float
    wave_generator__ring_tangent: str
    wave_generator__ring_contact: str
    wave_generator__ball_stiffness: float
    wave_generator__shape: str
    wave_generator__cone_angle_deg: float
    wave_generator__eccentricity: float
    wave_generator__eccentricity_angle_deg: float
    wave_generator__interference: float
    wave_generator__clearance: float
    contact__mode: str
    contact__friction: float
    contact__torque_friction: float
    contact__law: str
    contact__zero_pressure: float
    contact__slave: str
    load__support: str
    load__torque_load: str
    load__teeth: int
    load__tooth_pairs: int
    load__pressure_angle_deg: float
    load__tooth_stiffness: float
    load__tooth_gaps: Sequence[float] | float
    load__tooth_gaps_back: Sequence[float] | float
    load__tooth_clearance: float
    load__tooth_friction: float
    load__spline: str
    load__spline_diameter: float
    load__tooth_phase: float
    load__torque: float
    load__support_stiffness: float
    load__assembly_steps: int
    load__torque_steps: int
    load__tangent_steps: str
    bearing__balls: int
    bearing__model: str
    bearing__ball_diameter: float
    bearing__inner_conformity: float
    bearing__outer_conformity: float
    bearing__groove_depth: float
    bearing__clearance: float
    bearing__cage_angle_deg: float
    bearing__ball_e: float
    bearing__ball_nu: float
    bearing__ball_rate: float
    bearing__patch_length: float
    bearing__patch_width: float
    loop__torques: Sequence[float] | float
    loop__history: str
    loop__torque_1: float
    loop__torque_2: float
    loop__rated_torque: float
    turning__positions: int
    turning__range_deg: float
    turning__torque: float
    fatigue__tensile_strength: float
    fatigue__fatigue_limit: float
    fatigue__notch_factor: float
    solver__method: str
    solver__factors: str
    solver__kinematics: str
    solver__start: str
    solver__symmetry: str
    solver__tolerance: float
    solver__max_iterations: int
    solver__max_cuts: int
    solver__time_limit_s: float
    joint__model: str
    joint__table_file: str
    joint__spectrum_file: str
    joint__from_fit: str
    joint__fractal_dimension: float
    joint__roughness: float
    joint__gamma: float
    joint__sample_length: float
    joint__shortest_wavelength: float
    joint__asperity_radius: float
    joint__s_min: float
    joint__hardness: float
    joint__closure: str
    joint__plastic_spots: str
    output__vtu: str
    output__contact: str
    output__positions: Sequence[float] | float
    surface__nx: int
    surface__ny: int
    surface__dx: float
    surface__dy: float
    surface__fractal_dimension: float
    surface__roughness: float
    surface__gamma: float
    surface__sample_length: float
    surface__shortest_wavelength: float
    surface__ridges: int
    surface__seed: int
    surface__tolerance: float
    surface__method: str
    surface__precision: str
    fit__first_file: str
    fit__second_file: str
    fit__dx: float
    fit__dy: float
    fit__first_lag: int
    fit__last_lag: int
    fit__model: str
    fit__shortest_wavelength: float
    fit__longest_wavelength: float
