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

    bore_radius: float | str  # m
    wall_thickness: float | str  # m
    rim_thickness: float | str  # m
    rim_length: float | str  # m
    rim_taper: float | str  # m
    cup_length: float | str  # m
    bottom_thickness: float | str  # m
    hub_radius: float | str  # m
    ring_thickness: float | str  # m
    band_start: float | str  # m
    band_length: float | str  # m


class CupKeys(TypedDict, total=False):
    """Keys of &cup."""

    sections_r: Sequence[float | str] | float | str  # m
    sections_z: Sequence[float | str] | float | str  # m
    sections_thickness: Sequence[float | str] | float | str  # m
    sections_fillet: Sequence[float | str] | float | str  # m


class MaterialKeys(TypedDict, total=False):
    """Keys of &material."""

    flexspline_e: float | str  # Pa
    flexspline_nu: float
    ring_e: float | str  # Pa
    ring_nu: float
    yield_strength: float | str  # Pa
    ring_yield_strength: float | str  # Pa


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
    edge_length: float | str  # m
    element: str
    memory_limit_mb: float | str  # MB


class WaveGeneratorKeys(TypedDict, total=False):
    """Keys of &wave_generator."""

    w: float | str  # m
    cam: str
    lobes: int
    arc_angle_deg: float | str  # deg
    cam_file: str
    perimeter: str
    perimeter_length: float | str  # m
    ring_tangent: str
    ring_contact: str
    ball_stiffness: float | str  # N/m
    shape: str
    cone_angle_deg: float | str  # deg
    eccentricity: float | str  # m
    eccentricity_angle_deg: float | str  # deg
    interference: float | str  # m
    clearance: float | str  # m


class ContactKeys(TypedDict, total=False):
    """Keys of &contact."""

    mode: str
    friction: float
    torque_friction: float
    law: str
    zero_pressure: float | str  # Pa
    slave: str


class LoadKeys(TypedDict, total=False):
    """Keys of &load."""

    support: str
    torque_load: str
    teeth: int
    tooth_pairs: int
    pressure_angle_deg: float | str  # deg
    tooth_stiffness: float | str  # N/m
    tooth_gaps: Sequence[float | str] | float | str  # m
    tooth_gaps_back: Sequence[float | str] | float | str  # m
    tooth_clearance: float | str  # m
    tooth_friction: float
    spline: str
    spline_diameter: float | str  # m
    tooth_phase: float
    torque: float | str  # N m
    support_stiffness: float | str  # N/m
    assembly_steps: int
    torque_steps: int
    tangent_steps: str


class BearingKeys(TypedDict, total=False):
    """Keys of &bearing."""

    balls: int
    model: str
    ball_diameter: float | str  # m
    inner_conformity: float
    outer_conformity: float
    groove_depth: float | str  # m
    clearance: float | str  # m
    cage_angle_deg: float | str  # deg
    ball_e: float | str  # Pa
    ball_nu: float
    ball_rate: float | str  # N/m^1.5
    patch_length: float | str  # m
    patch_width: float | str  # m


class LoopKeys(TypedDict, total=False):
    """Keys of &loop."""

    torques: Sequence[float | str] | float | str  # N m
    history: str
    torque_1: float | str  # N m
    torque_2: float | str  # N m
    rated_torque: float | str  # N m


class TurningKeys(TypedDict, total=False):
    """Keys of &turning."""

    positions: int
    range_deg: float | str  # deg
    torque: float | str  # N m


class FatigueKeys(TypedDict, total=False):
    """Keys of &fatigue."""

    tensile_strength: float | str  # Pa
    fatigue_limit: float | str  # Pa
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
    time_limit_s: float | str  # s


class JointKeys(TypedDict, total=False):
    """Keys of &joint."""

    model: str
    table_file: str
    spectrum_file: str
    from_fit: str
    fractal_dimension: float
    roughness: float | str  # m
    gamma: float
    sample_length: float | str  # m
    shortest_wavelength: float | str  # m
    asperity_radius: float | str  # m
    s_min: float | str  # m^2
    hardness: float | str  # Pa
    closure: str
    plastic_spots: str


class OutputKeys(TypedDict, total=False):
    """Keys of &output."""

    vtu: str
    contact: str
    positions: Sequence[float | str] | float | str  # m


class SurfaceKeys(TypedDict, total=False):
    """Keys of &surface."""

    nx: int
    ny: int
    dx: float | str  # m
    dy: float | str  # m
    fractal_dimension: float
    roughness: float | str  # m
    gamma: float
    sample_length: float | str  # m
    shortest_wavelength: float | str  # m
    ridges: int
    seed: int
    tolerance: float
    method: str
    precision: str


class FitKeys(TypedDict, total=False):
    """Keys of &fit."""

    first_file: str
    second_file: str
    dx: float | str  # m
    dy: float | str  # m
    first_lag: int
    last_lag: int
    model: str
    shortest_wavelength: float | str  # m
    longest_wavelength: float | str  # m


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
    geometry__bore_radius: float | str
    geometry__wall_thickness: float | str
    geometry__rim_thickness: float | str
    geometry__rim_length: float | str
    geometry__rim_taper: float | str
    geometry__cup_length: float | str
    geometry__bottom_thickness: float | str
    geometry__hub_radius: float | str
    geometry__ring_thickness: float | str
    geometry__band_start: float | str
    geometry__band_length: float | str
    cup__sections_r: Sequence[float | str] | float | str
    cup__sections_z: Sequence[float | str] | float | str
    cup__sections_thickness: Sequence[float | str] | float | str
    cup__sections_fillet: Sequence[float | str] | float | str
    material__flexspline_e: float | str
    material__flexspline_nu: float
    material__ring_e: float | str
    material__ring_nu: float
    material__yield_strength: float | str
    material__ring_yield_strength: float | str
    mesh__divisions: int
    mesh__band_facets: int
    mesh__ring_divisions: int
    mesh__ring_facets: int
    mesh__wall_elements: int
    mesh__bottom_elements: int
    mesh__through_wall: int
    mesh__through_ring: int
    mesh__edge_length: float | str
    mesh__element: str
    mesh__memory_limit_mb: float | str
    wave_generator__w: float | str
    wave_generator__cam: str
    wave_generator__lobes: int
    wave_generator__arc_angle_deg: float | str
    wave_generator__cam_file: str
    wave_generator__perimeter: str
    wave_generator__perimeter_length: float | str
    wave_generator__ring_tangent: str
    wave_generator__ring_contact: str
    wave_generator__ball_stiffness: float | str
    wave_generator__shape: str
    wave_generator__cone_angle_deg: float | str
    wave_generator__eccentricity: float | str
    wave_generator__eccentricity_angle_deg: float | str
    wave_generator__interference: float | str
    wave_generator__clearance: float | str
    contact__mode: str
    contact__friction: float
    contact__torque_friction: float
    contact__law: str
    contact__zero_pressure: float | str
    contact__slave: str
    load__support: str
    load__torque_load: str
    load__teeth: int
    load__tooth_pairs: int
    load__pressure_angle_deg: float | str
    load__tooth_stiffness: float | str
    load__tooth_gaps: Sequence[float | str] | float | str
    load__tooth_gaps_back: Sequence[float | str] | float | str
    load__tooth_clearance: float | str
    load__tooth_friction: float
    load__spline: str
    load__spline_diameter: float | str
    load__tooth_phase: float
    load__torque: float | str
    load__support_stiffness: float | str
    load__assembly_steps: int
    load__torque_steps: int
    load__tangent_steps: str
    bearing__balls: int
    bearing__model: str
    bearing__ball_diameter: float | str
    bearing__inner_conformity: float
    bearing__outer_conformity: float
    bearing__groove_depth: float | str
    bearing__clearance: float | str
    bearing__cage_angle_deg: float | str
    bearing__ball_e: float | str
    bearing__ball_nu: float
    bearing__ball_rate: float | str
    bearing__patch_length: float | str
    bearing__patch_width: float | str
    loop__torques: Sequence[float | str] | float | str
    loop__history: str
    loop__torque_1: float | str
    loop__torque_2: float | str
    loop__rated_torque: float | str
    turning__positions: int
    turning__range_deg: float | str
    turning__torque: float | str
    fatigue__tensile_strength: float | str
    fatigue__fatigue_limit: float | str
    fatigue__notch_factor: float
    solver__method: str
    solver__factors: str
    solver__kinematics: str
    solver__start: str
    solver__symmetry: str
    solver__tolerance: float
    solver__max_iterations: int
    solver__max_cuts: int
    solver__time_limit_s: float | str
    joint__model: str
    joint__table_file: str
    joint__spectrum_file: str
    joint__from_fit: str
    joint__fractal_dimension: float
    joint__roughness: float | str
    joint__gamma: float
    joint__sample_length: float | str
    joint__shortest_wavelength: float | str
    joint__asperity_radius: float | str
    joint__s_min: float | str
    joint__hardness: float | str
    joint__closure: str
    joint__plastic_spots: str
    output__vtu: str
    output__contact: str
    output__positions: Sequence[float | str] | float | str
    surface__nx: int
    surface__ny: int
    surface__dx: float | str
    surface__dy: float | str
    surface__fractal_dimension: float
    surface__roughness: float | str
    surface__gamma: float
    surface__sample_length: float | str
    surface__shortest_wavelength: float | str
    surface__ridges: int
    surface__seed: int
    surface__tolerance: float
    surface__method: str
    surface__precision: str
    fit__first_file: str
    fit__second_file: str
    fit__dx: float | str
    fit__dy: float | str
    fit__first_lag: int
    fit__last_lag: int
    fit__model: str
    fit__shortest_wavelength: float | str
    fit__longest_wavelength: float | str
