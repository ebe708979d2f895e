! SPDX-License-Identifier: GPL-3.0-or-later
!> The scene: every parameter of a run, in SI units. Bounds, units and meanings stand in hd_parameters.
module hd_scene
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_surface_scene, only: surface_t, surface_fit_t
  use hd_support, only: support_t
  implicit none
  private
  public :: scene_t

  integer, parameter :: name_length = 32   !< longest choice
  integer, parameter :: title_length = 120 !< longest title
  integer, parameter :: path_length = 240  !< longest file name
  integer, parameter :: reason_length = 800

  integer, parameter, public :: most_torques = 100  !< in the list of a loop
  integer, parameter, public :: most_gaps = 400     !< in the list of clearances of tooth pairs
  integer, parameter, public :: most_sections = 60  !< of a cup

  type :: scene_t
    integer :: version = 1
    character(len=title_length) :: title = ''
    real(dp) :: planned_tolerance = 0
    character(len=path_length) :: wanted = '', tolerances = ''
    character(len=name_length) :: with_band = 'auto', with_gradient = '.false.'
    ! geometry
    real(dp) :: bore_radius = 17.5e-3_dp, wall_thickness = 0.36e-3_dp, rim_thickness = 0.427e-3_dp
    real(dp) :: rim_length = 9e-3_dp, rim_taper = 1e-3_dp, cup_length = 20e-3_dp, bottom_thickness = 0.5e-3_dp
    real(dp) :: hub_radius = 8e-3_dp, ring_thickness = 1e-3_dp, band_start = 0.5e-3_dp, band_length = 12e-3_dp
    ! cup: sections of its meridian, instead of the simple keys of geometry
    real(dp), dimension(most_sections) :: sections_r = 0, sections_z = 0, sections_thickness = 0, sections_fillet = 0
    integer :: sections_count(4) = 1
    ! material
    real(dp) :: flexspline_e = 209e9_dp, flexspline_nu = 0.295_dp, ring_e = 219e9_dp, ring_nu = 0.30_dp
    real(dp) :: yield_strength = 835e6_dp, ring_yield_strength = 1.7e9_dp
    ! mesh
    integer :: divisions = 86, band_facets = 15, ring_divisions = 0, ring_facets = 0, wall_elements = 0
    integer :: bottom_elements = 0, through_wall = 1, through_ring = 1
    real(dp) :: edge_length = 0
    character(len=name_length) :: element = 'hex8i'
    real(dp) :: memory_limit_mb = 0
    ! wave generator
    real(dp) :: w = 0.2e-3_dp
    character(len=name_length) :: cam = 'ellipse', ring_tangent = 'auto', ring_contact = 'tied', shape = 'pressed'
    real(dp) :: eccentricity = 0, eccentricity_angle_deg = 0, interference = 10e-6_dp, clearance = 0, cone_angle_deg = 0
    real(dp) :: ball_stiffness = 0, arc_angle_deg = 45, perimeter_length = 0
    integer :: lobes = 2
    character(len=name_length) :: perimeter = 'kept'
    character(len=path_length) :: cam_file = ''
    integer(int64) :: files = 0          !< checksum of the tables that keys name, as the scene was read
    ! contact
    character(len=name_length) :: contact_mode = 'frictional', contact_law = 'hard', slave = 'ring'
    real(dp) :: friction = 0.15_dp, torque_friction = 0, zero_pressure = 1e3_dp
    ! load
    type(support_t) :: support
    character(len=name_length) :: torque_load = 'uniform', spline = 'free'
    real(dp) :: torque = 5, support_stiffness = 100, pressure_angle_deg = 20
    integer :: teeth = 200, tooth_pairs = 40
    real(dp) :: tooth_stiffness = 1.25e8_dp, tooth_clearance = 0, tooth_friction = 0
    real(dp) :: spline_diameter = 0, spline_root_diameter = 0, spline_width = 0
    real(dp) :: gaps(most_gaps) = 0, gaps_back(most_gaps) = 0
    integer :: gap_count = 1, gap_back_count = 1
    integer :: assembly_steps = 3, torque_steps = 5
    character(len=name_length) :: tangent_steps = 'needed'
    ! bearing: balls of the whole drive
    integer :: balls = 21
    real(dp) :: ball_diameter = 3.2e-3_dp, inner_conformity = 0.52_dp, outer_conformity = 0.52_dp, ball_clearance = 0
    real(dp) :: groove_depth = 0, cage_angle_deg = 0, ball_e = 208e9_dp, ball_nu = 0.3_dp, patch_length = 0, patch_width = 0, &
      ball_rate = 0
    character(len=name_length) :: axial_hold = 'grooves'
    ! loop: torques of the whole drive
    real(dp) :: torques(most_torques) = 0, torque_1 = 2, torque_2 = 6.9_dp, rated_torque = 7.8_dp
    integer :: torque_count = 1
    logical :: straight = .false.         !< ramps before the last one take one load step each, and none stops there to be read
    logical :: half_loop = .false.        !< torques end at the opposite of the first: the rise from there is the fall, mirrored
    character(len=name_length) :: history = 'loop'
    ! turning: the wave generator of the whole drive
    integer :: turning_positions = 0
    real(dp) :: turning_range_deg = 0, turning_torque = 0, tooth_phase = 0
    ! fatigue
    real(dp) :: tensile_strength = 980e6_dp, fatigue_limit = 490e6_dp, notch_factor = 1
    ! solver
    character(len=name_length) :: method = 'auto', factors = 'auto', symmetry = 'auto', kinematics = 'auto', &
      start = 'auto', bearing_model = 'auto'
    real(dp) :: tolerance = 1e-8_dp
    integer :: max_iterations = 60, max_cuts = 8
    real(dp) :: time_limit_s = 0
    ! joint
    real(dp) :: fractal_dimension = 2.5304_dp, roughness = 2.4248e-7_dp, gamma = 1.5_dp, sample_length = 0.5e-3_dp
    real(dp) :: shortest_wavelength = 1e-6_dp, asperity_radius = 5e-6_dp, s_min = 0, hardness = 0
    character(len=name_length) :: closure = 'nominal', plastic_spots = 'none', joint_model = 'spectrum'
    character(len=path_length) :: joint_table = '', joint_spectrum = '', joint_from_fit = ''
    character(len=reason_length) :: joint_reason = '', joint_doubt = ''  !< why joint.model = 'auto' became what it is, and what
                                                                         !< speaks against it; no keys
    ! surface
    type(surface_t) :: surface
    type(surface_fit_t) :: fit
    logical :: surface_only = .false.     !< the input asks for a surface alone: no contact
    ! output
    character(len=name_length) :: vtu = 'last'
    character(len=name_length) :: contact_table = 'all'
    real(dp) :: positions(3) = [0._dp, 5e-3_dp, 10e-3_dp]
  contains
    procedure :: bonded
    procedure :: frictionless
    procedure :: hard
    procedure :: formed
    procedure :: large
    procedure :: cup_is_slave
    procedure :: ring_lifts
    procedure :: ring_follows
    procedure :: slides_on_cam
    procedure :: in_grooves
    procedure :: turned
    procedure :: differentiable
    procedure :: wants_band
    procedure :: quadratic
    procedure :: kinematics_open
    procedure :: may_condense
    procedure :: may_newton
    procedure :: may_factorise
    procedure :: spline_radii
    procedure :: tooth_circle
    procedure :: spline_breadth
    procedure :: tooth_ends
    procedure :: may_harmonics
    procedure :: most_images
  end type scene_t

contains

  !> Radii of the circular spline's ring: the roots of its teeth, and its outside [m]. Unless given, the roots clear the tips of
  !> teeth of 2.25 modules, whose wall stands on the long axis, by a quarter of a module.
  pure function spline_radii(self) result(r)
    class(scene_t), intent(in) :: self  !< scene with teeth
    real(dp) :: r(2)
    real(dp), parameter :: modules = 2.5_dp
    real(dp), parameter :: usual = 1.4_dp  !< outer diameter over that of the bore: 1.35 to 1.43 in catalogues
    r(1) = (self%bore_radius + self%wall_thickness)*(1 + 2*modules/self%teeth) + self%w
    if (self%spline_root_diameter > 0) r(1) = self%spline_root_diameter/2
    r(2) = merge(self%spline_diameter/2, usual*self%bore_radius, self%spline_diameter > 0)
  end function spline_radii

  !> Radius amid the flexspline's teeth at rest, whose tips reach to the circular spline's roots on the long axis [m].
  pure real(dp) function tooth_circle(self) result(r)
    class(scene_t), intent(in) :: self  !< scene with teeth
    real(dp) :: spline(2)
    spline = self%spline_radii()
    r = (self%bore_radius + self%wall_thickness + spline(1) - self%w)/2
  end function tooth_circle

  !> Width of the circular spline: that of the rim unless given [m].
  pure real(dp) function spline_breadth(self) result(width)
    class(scene_t), intent(in) :: self  !< scene
    width = merge(self%spline_width, self%rim_length, self%spline_width > 0)
  end function spline_breadth

  !> Places along the axis between which teeth touch: the width of the circular spline, amid the rim [m].
  pure function tooth_ends(self) result(z)
    class(scene_t), intent(in) :: self  !< scene
    real(dp) :: z(2)
    z = (self%rim_length + [-1, 1]*min(self%spline_breadth(), self%rim_length))/2
  end function tooth_ends

  !> The faces do not part and do not slip.
  pure logical function bonded(self)
    class(scene_t), intent(in) :: self  !< scene
    bonded = self%contact_mode == 'bonded'
  end function bonded

  !> The contact takes no shear.
  pure logical function frictionless(self)
    class(scene_t), intent(in) :: self  !< scene
    frictionless = self%contact_mode == 'frictionless' .or. .not. (self%bonded() .or. max(self%friction, self%torque_friction) > 0)
  end function frictionless

  !> The faces meet without a joint that gives way.
  pure logical function hard(self)
    class(scene_t), intent(in) :: self  !< scene
    hard = self%contact_law == 'hard'
  end function hard

  !> Cup and ring have the shape of the wave generator without stress; else the round ones are pressed onto it.
  pure logical function formed(self)
    class(scene_t), intent(in) :: self  !< scene
    formed = self%shape == 'as_formed'
  end function formed

  !> Displacements are large: the elements turn with them and the faces are paired anew.
  pure logical function large(self)
    class(scene_t), intent(in) :: self  !< scene
    large = self%kinematics == 'nonlinear'
  end function large

  !> The contact points are the cup's, the ring's face is the one they meet.
  pure logical function cup_is_slave(self)
    class(scene_t), intent(in) :: self  !< scene
    cup_is_slave = self%slave == 'cup'
  end function cup_is_slave

  !> The ring lies on the wave generator, from which it may lift; else it is tied to it.
  pure logical function ring_lifts(self)
    class(scene_t), intent(in) :: self  !< scene
    ring_lifts = self%ring_contact == 'unilateral'
  end function ring_lifts

  !> The ring's inner face follows the cam tangentially: by choice, or where nothing else holds the ring, which is with support
  !> 'bearing', and without friction under large displacements.
  pure logical function ring_follows(self)
    class(scene_t), intent(in) :: self  !< scene
    ring_follows = self%ring_tangent == 'follow' .or. (self%ring_tangent == 'auto' .and. (self%support%friction_alone .or. &
      (self%frictionless() .and. self%large())))
  end function ring_follows

  !> The ring of a drive without balls turns against its cam, whose radial ties stay with the points of the ring: their way is that
  !> of the cam only to first order.
  pure logical function slides_on_cam(self)
    class(scene_t), intent(in) :: self  !< scene
    slides_on_cam = self%support%struts .and. self%balls == 0 .and. .not. self%ring_follows()
  end function slides_on_cam

  !> The grooves of its balls hold the ring along the axis.
  pure logical function in_grooves(self)
    class(scene_t), intent(in) :: self  !< scene
    in_grooves = self%support%struts .and. self%balls > 0 .and. self%axial_hold == 'grooves'
  end function in_grooves

  !> The answer is that of a drive whose wave generator has turned.
  pure logical function turned(self)
    class(scene_t), intent(in) :: self  !< scene
    turned = self%history == 'turned'
  end function turned

  !> The load steps have derivatives by the keys, under small displacements.
  pure logical function differentiable(self)
    class(scene_t), intent(in) :: self  !< scene
    differentiable = .not. (self%support%against_teeth .or. self%turned() .or. self%tooth_friction > 0)
  end function differentiable

  !> A band is to be found: it was asked for, or left open for a loop that has derivatives.
  pure logical function wants_band(self)
    class(scene_t), intent(in) :: self  !< scene
    wants_band = self%with_band == '.true.' .or. (self%with_band == 'auto' .and. self%support%loop .and. self%differentiable())
  end function wants_band

  !> Cells have nodes on their edges, too.
  pure logical function quadratic(self)
    class(scene_t), intent(in) :: self  !< scene
    quadratic = self%element == 'hex20r'
  end function quadratic

  !> Small or large displacements: the plan is to say.
  pure logical function kinematics_open(self)
    class(scene_t), intent(in) :: self  !< scene
    kinematics_open = self%kinematics == 'auto'
  end function kinematics_open

  !> The bodies may be condensed to the face.
  pure logical function may_condense(self)
    class(scene_t), intent(in) :: self  !< scene
    may_condense = self%method /= 'newton'
  end function may_condense

  !> Systems may be solved with Newton's matrix.
  pure logical function may_newton(self)
    class(scene_t), intent(in) :: self  !< scene
    may_newton = self%method /= 'condensed'
  end function may_newton

  !> Newton's matrix may be factorised.
  pure logical function may_factorise(self)
    class(scene_t), intent(in) :: self  !< scene
    may_factorise = self%factors /= 'harmonic'
  end function may_factorise

  !> Newton's matrix may be solved around condensation by harmonics.
  pure logical function may_harmonics(self)
    class(scene_t), intent(in) :: self  !< scene
    may_harmonics = self%factors /= 'exact'
  end function may_harmonics

  !> Images of the part that is solved, at most: 1, 2 or 4.
  pure integer function most_images(self)
    class(scene_t), intent(in) :: self  !< scene
    most_images = 4
    if (self%symmetry == 'half') most_images = 2
    if (self%symmetry == 'full') most_images = 1
  end function most_images
end module hd_scene
