! SPDX-License-Identifier: GPL-3.0-or-later
!> Conditions between the keys of a scene.
module hd_conditions
  use hd_kinds, only: dp, pi, hair
  use hd_cup_sections, only: has_sections
  use hd_race, only: race_radius, groove_width, deepest_groove
  use hd_scene, only: scene_t
  use hd_text, only: string_t, push, to_text
  implicit none
  private
  public :: check_scene

  real(dp), parameter :: stretch = 0.02_dp  !< of the length of the circle on the cam: more is a wrong unit
  real(dp), parameter :: small = 0.1_dp     !< of the radius, that small displacements and fits stay below
  integer, parameter :: least_of_lobe = 4    !< facets along a wave of the cam: with half of them it is another wave
  real(dp), parameter :: least_hub = 1e-4_dp !< of the radius, down to which the twist of the bottom is that of a plate within 0.5 %
  real(dp), parameter :: most_cells = 1e5_dp !< along the cup: ten times what mesh.wall_elements takes
  integer, parameter :: fewest_balls = 4    !< that hold the ring
  character(len=1), parameter :: nl = new_line('a')

contains

  !> All conditions, every mistake.
  subroutine check_scene(s, faults)
    type(scene_t), intent(in) :: s                            !< scene whose keys are in range
    type(string_t), allocatable, intent(inout) :: faults(:)   !< gets mistakes
    call check_shape(s, faults)
    call check_methods(s, faults)
    if (s%support%struts) call check_drive(s, faults)
  end subroutine check_scene

  !> Conditions between the keys of geometry and wave generator.
  subroutine check_shape(s, faults)
    type(scene_t), intent(in) :: s                            !< scene whose keys are in range
    type(string_t), allocatable, intent(inout) :: faults(:)   !< gets mistakes
    real(dp) :: length   !< along the cup that has cells as long as the facets [m]
    call need(faults, s%wall_thickness < s%bore_radius, 'geometry.wall_thickness', s%wall_thickness, 'below bore_radius', &
      s%bore_radius)
    call need(faults, s%rim_thickness < s%bore_radius, 'geometry.rim_thickness', s%rim_thickness, 'below bore_radius', &
      s%bore_radius)
    call need(faults, s%ring_thickness < s%bore_radius, 'geometry.ring_thickness', s%ring_thickness, 'below bore_radius', &
      s%bore_radius)
    call need(faults, s%hub_radius < s%bore_radius .or. has_sections(s), 'geometry.hub_radius', s%hub_radius, &
      'below bore_radius', s%bore_radius)
    call need(faults, s%hub_radius >= (1 - hair)*least_hub*s%bore_radius, 'geometry.hub_radius', s%hub_radius, &
      'at least a ten-thousandth of bore_radius, for a bottom that is held at a point turns freely', least_hub*s%bore_radius)
    call need(faults, s%bottom_thickness < s%cup_length, 'geometry.bottom_thickness', s%bottom_thickness, 'below cup_length', &
      s%cup_length)
    call need(faults, s%band_start + s%band_length < s%cup_length - s%bottom_thickness, 'geometry.band_length', s%band_length, &
      'so that the band ends before the bottom: below cup_length - bottom_thickness - band_start', &
      s%cup_length - s%bottom_thickness - s%band_start)
    length = merge(max(s%rim_length, s%band_start), s%cup_length, s%wall_elements > 0) + &
      merge(0._dp, abs(s%bore_radius - s%hub_radius), s%bottom_elements > 0)
    call need(faults, length*s%band_facets < most_cells*s%band_length, 'geometry.band_length', s%band_length, &
      'so long that less than 100000 cells as long as its facets lie along the cup, or mesh.wall_elements and '// &
      'mesh.bottom_elements given; above', length*s%band_facets/most_cells)
    call need(faults, s%rim_length < s%cup_length - s%bottom_thickness, 'geometry.rim_length', s%rim_length, &
      'below cup_length - bottom_thickness', s%cup_length - s%bottom_thickness)
    call need(faults, abs(s%w) < s%bore_radius - s%ring_thickness, 'wave_generator.w', s%w, &
      'below the inner radius of the ring', s%bore_radius - s%ring_thickness)
    call need(faults, s%cam == 'cosine' .or. s%lobes == 2, 'wave_generator.lobes', real(s%lobes, dp), &
      "cam = 'cosine' or lobes", 2._dp)
    call need(faults, s%lobes*least_of_lobe <= s%divisions, 'mesh.divisions', real(s%divisions, dp), &
      'enough for the waves of the cam (wave_generator.lobes): at least', real(least_of_lobe*s%lobes, dp))
    call need(faults, s%lobes == 2 .or. .not. (s%support%struts .or. s%support%against_teeth .or. s%torque_load == 'teeth'), &
      'wave_generator.lobes', real(s%lobes, dp), '2 with teeth, which are in mesh at both ends of one long axis')
    call ask(faults, (s%cam == 'table') .eqv. len_trim(s%cam_file) > 0, 'wave_generator.cam', s%cam, &
      "'table' together with wave_generator.cam_file, the file of the table; other cams without that file")
    call need(faults, (s%perimeter == 'given') .eqv. s%perimeter_length > 0, 'wave_generator.perimeter_length', &
      s%perimeter_length, "a length together with perimeter = 'given', else", 0._dp)
    associate (circle => 2*pi*(s%bore_radius - merge(s%ring_thickness, 0._dp, .not. s%formed())))
      call need(faults, s%perimeter /= 'given' .or. abs(s%perimeter_length/circle - 1) < stretch, &
        'wave_generator.perimeter_length', s%perimeter_length, 'within 2 % of the length of the circle', circle)
    end associate
    call need(faults, s%eccentricity < small*s%bore_radius, 'wave_generator.eccentricity', s%eccentricity, &
      'below a tenth of bore_radius (small displacements)', small*s%bore_radius)
    call need(faults, abs(tan(s%cone_angle_deg*pi/180))*s%band_length < s%bore_radius - s%ring_thickness, &
      'wave_generator.cone_angle_deg', s%cone_angle_deg, 'so small that the ring stays open', 10._dp)
  end subroutine check_shape

  !> Conditions between the keys of load, contact, joint and solver.
  subroutine check_methods(s, faults)
    type(scene_t), intent(in) :: s                            !< scene whose keys are in range
    type(string_t), allocatable, intent(inout) :: faults(:)   !< gets mistakes
    call need(faults, modulo(s%tooth_pairs, 2) == 0, 'load.tooth_pairs', real(s%tooth_pairs, dp), &
      'an even number, half of them at each end of the long axis; below teeth', real(s%teeth, dp))
    call need(faults, s%gap_count == s%tooth_pairs/2 .or. s%gap_count == s%tooth_pairs .or. (s%gap_count == 1 .and. &
      .not. s%gaps(1) > 0), 'number of load.tooth_gaps', real(s%gap_count, dp), &
      'none, or as many values as pairs at one end of the long axis, or at both: half of tooth_pairs, or all', &
      real(s%tooth_pairs, dp))
    call need(faults, s%gap_back_count == s%gap_count .or. (s%gap_back_count == 1 .and. .not. s%gaps_back(1) > 0), &
      'number of load.tooth_gaps_back', real(s%gap_back_count, dp), 'none, or as many values as load.tooth_gaps', &
      real(s%gap_count, dp))
    call need(faults, s%support%struts .or. s%support%against_teeth .or. .not. abs(s%tooth_phase) > 0, 'load.tooth_phase', &
      s%tooth_phase, "0, but with load.support = 'drive' or 'teeth'")
    call need(faults, s%tooth_pairs <= s%teeth, 'load.tooth_pairs', real(s%tooth_pairs, dp), 'not above teeth', real(s%teeth, dp))
    call need(faults, s%clearance < small*s%bore_radius, 'wave_generator.clearance', s%clearance, &
      'smaller than a tenth of bore_radius', small*s%bore_radius)
    call need(faults, abs(s%interference) < small*s%bore_radius, 'wave_generator.interference', s%interference, &
      'smaller than a tenth of bore_radius', small*s%bore_radius)
    call need(faults, s%shortest_wavelength < s%sample_length, 'joint.shortest_wavelength', s%shortest_wavelength, &
      'below sample_length', s%sample_length)
    call ask(faults, s%support%contact .or. s%bonded(), 'contact.mode', s%contact_mode, &
      "'bonded' with load.support = 'teeth'; support 'drive' has teeth and friction")
    call need(faults, s%support%struts .or. .not. s%tooth_friction > 0, 'load.tooth_friction', s%tooth_friction, &
      "0: the flanks have no friction, but with load.support = 'drive'")
    call need(faults, (s%support%struts .and. s%balls > 0) .or. .not. s%groove_depth > 0, 'bearing.groove_depth', &
      s%groove_depth, "0, but with load.support = 'drive' and bearing.balls, that run in the groove")
    call ask(faults, .not. s%support%friction_alone .or. s%contact_mode /= 'frictionless', 'contact.mode', s%contact_mode, &
      "'frictional' with load.support = 'bearing', where all torque goes through friction")
    call ask(faults, .not. (s%ring_lifts() .and. (s%quadratic() .or. s%support%against_teeth)), &
      'wave_generator.ring_contact', s%ring_contact, "'tied' with mesh.element = 'hex20r' or load.support = 'teeth'")
    call need(faults, .not. (s%ball_stiffness > 0 .and. (s%quadratic() .or. s%ring_lifts())), &
      'wave_generator.ball_stiffness', s%ball_stiffness, "0, or ring_contact = 'tied' and element hex8 or hex8i")
    call ask(faults, &
      .not. s%support%friction_alone .or. s%ring_tangent /= 'free' .or. s%formed() .or. .not. abs(s%torque) > 0, &
      'wave_generator.ring_tangent', s%ring_tangent, "'follow' or 'auto' with load.support = 'bearing': nothing takes the " // &
      'torque where the ring slides on the cam')
    call ask(faults, .not. s%large() .or. (s%may_newton() .and. .not. s%support%against_teeth), &
      'solver.kinematics', s%kinematics, "'linear', or solver.method auto or newton with a load.support other than teeth")
    call ask(faults, .not. s%support%against_teeth .or. s%may_factorise(), 'solver.factors', s%factors, &
      "'auto' or 'exact' with load.support = 'teeth'")
    call ask(faults, s%with_band /= '.true.' .or. s%support%loop, 'run.band', s%with_band, &
      "'auto' or '.false.', but with load.support = 'drive'")
    call ask(faults, s%tangent_steps == 'needed' .or. s%tangent_steps == 'all' .or. .not. (s%with_band == '.true.' .or. &
      s%planned_tolerance > 0), 'load.tangent_steps', s%tangent_steps, "'needed' or 'all' with run.band = .true. or run.tolerance")
    call ask(faults, s%with_gradient == '.false.' .or. (s%differentiable() .and. .not. (s%large() .or. &
      s%planned_tolerance > 0)), 'run.gradient', s%with_gradient, &
      "'.false.' with solver.kinematics = 'nonlinear', load.support = 'teeth', load.tooth_friction, loop.history = 'turned' "// &
      "or run.tolerance")
    call need(faults, s%turning_positions == 0 .or. s%support%struts, 'turning.positions', real(s%turning_positions, dp), &
      "0, but with load.support = 'drive'")
    call ask(faults, s%hard() .or. .not. s%bonded(), 'contact.law', s%contact_law, &
      "'hard' with contact.mode = 'bonded': a joint does not pull")
    call ask(faults, s%hard() .or. s%closure == 'nominal', 'joint.closure', s%closure, &
      "'nominal' with a contact.law other than 'hard'")
  end subroutine check_methods

  !> Conditions between the keys of a whole drive.
  subroutine check_drive(s, faults)
    type(scene_t), intent(in) :: s                            !< scene with support 'drive'
    type(string_t), allocatable, intent(inout) :: faults(:)   !< gets mistakes
    real(dp) :: wall, spline(2)
    call check_groove(s, faults)
    call ask(faults, .not. s%formed(), 'wave_generator.shape', s%shape, "'pressed' with load.support = 'drive'")
    call ask(faults, .not. s%ring_lifts(), 'wave_generator.ring_contact', s%ring_contact, &
      "'tied' with load.support = 'drive', where the balls lift off by themselves")
    call ask(faults, s%may_factorise(), 'solver.factors', s%factors, "'auto' or 'exact' with load.support = 'drive'")
    call ask(faults, .not. (s%large() .and. s%slides_on_cam()), 'solver.kinematics', s%kinematics, "'linear', bearing.balls, "// &
      "or wave_generator.ring_tangent = 'follow': without balls the ring turns against the cam's radial ties")
    call need(faults, s%balls == 0 .or. s%balls >= fewest_balls, 'bearing.balls', real(s%balls, dp), &
      'none, or enough to hold the ring', real(fewest_balls, dp))
    call need(faults, s%ball_diameter*s%balls < 2*pi*(race_radius(s) - s%ball_diameter/2), 'bearing.ball_diameter', &
      s%ball_diameter, 'so small that all balls have room on their circle: below', &
      2*pi*(race_radius(s) - s%ball_diameter/2)/max(1, s%balls))
    call need(faults, s%balls == 0 .or. .not. s%ball_stiffness > 0, 'wave_generator.ball_stiffness', s%ball_stiffness, &
      '0 where bearing.balls stand for it')
    wall = 2*(s%bore_radius + s%wall_thickness + s%w)
    call need(faults, .not. s%spline_root_diameter > 0 .or. s%spline_root_diameter > wall, 'load.spline_root_diameter', &
      s%spline_root_diameter, '0, or above that of the wall on the long axis', wall)
    spline = 2*s%spline_radii()
    call need(faults, s%spline == 'rigid' .or. spline(2) > spline(1), 'load.spline_diameter', s%spline_diameter, &
      'above that of the roots of its teeth (load.spline_root_diameter)', spline(1))
    call ask(faults, .not. s%turned() .or. (.not. s%large() .and. (s%ring_divisions == 0 .or. s%ring_divisions == &
      s%divisions)), 'loop.history', s%history, &
      "'loop' or 'assembled' with solver.kinematics = 'nonlinear' or with mesh.ring_divisions")
    call need(faults, s%torque_2 > s%torque_1, 'loop.torque_2', s%torque_2, 'above torque_1', s%torque_1)
  end subroutine check_drive

  !> The groove of the balls lies in the ring, and a cell of the ring in the groove.
  subroutine check_groove(s, faults)
    type(scene_t), intent(in) :: s                            !< scene with support 'drive'
    type(string_t), allocatable, intent(inout) :: faults(:)   !< gets mistakes
    integer :: cells
    if (s%balls == 0 .or. .not. s%groove_depth > 0) return
    call need(faults, s%groove_depth < deepest_groove(s), 'bearing.groove_depth', s%groove_depth, &
      'below three quarters of geometry.ring_thickness and below its radius (outer_conformity times ball_diameter), and so '// &
      'small that the groove is narrower than the ring: below', deepest_groove(s))
    if (.not. s%groove_depth < deepest_groove(s)) return
    cells = merge(s%ring_facets, s%band_facets, s%ring_facets > 0)
    call need(faults, cells*groove_width(s) >= s%band_length, trim(merge('mesh.ring_facets', 'mesh.band_facets', &
      s%ring_facets > 0)), real(cells, dp), 'so many that the cells of the ring are not longer than the groove of '// &
      'bearing.groove_depth is wide ('//to_text(groove_width(s))//' m): at least', &
      real(ceiling(s%band_length/groove_width(s)), dp))
  end subroutine check_groove

  !> A mistake where a condition does not hold.
  subroutine need(faults, condition, name, value, rule, limit)
    type(string_t), allocatable, intent(inout) :: faults(:)   !< gets it
    logical, intent(in) :: condition                          !< that must hold
    character(len=*), intent(in) :: name, rule                !< key, and what is valid
    real(dp), intent(in) :: value                             !< as given
    real(dp), intent(in), optional :: limit                   !< of the rule
    character(len=:), allocatable :: bound
    if (condition) return
    bound = ''
    if (present(limit)) bound = ' ('//plain(limit)//')'
    call push(faults, 'error: '//name//' = '//plain(value)//nl//'      valid: '//rule//bound)
  end subroutine need

  !> A number as one writes it: counts without a point.
  pure function plain(x) result(text)
    real(dp), intent(in) :: x  !< number
    character(len=:), allocatable :: text
    text = to_text(x)
    if (index(text, '.0', back=.true.) == len(text) - 1) text = text(:len(text) - 2)
  end function plain

  !> A choice that does not go with another key.
  subroutine ask(faults, condition, name, choice, rule)
    type(string_t), allocatable, intent(inout) :: faults(:)   !< gets it
    logical, intent(in) :: condition                          !< that must hold
    character(len=*), intent(in) :: name, choice, rule        !< key, its value, and what is valid
    if (.not. condition) call push(faults, 'error: '//name//" = '"//trim(choice)//"'"//nl//'      valid: '//rule)
  end subroutine ask

end module hd_conditions
