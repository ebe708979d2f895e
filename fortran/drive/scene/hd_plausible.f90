! SPDX-License-Identifier: GPL-3.0-or-later
!> Values that are valid and hardly meant: usual ranges of keys, and the slip of units that would explain a value outside of them.
module hd_plausible
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t, raise, code_input
  use hd_idle_keys, only: idle_keys
  use hd_parameters, only: parameter_table_t, new_table, value_count
  use hd_scene, only: scene_t
  use hd_text, only: string_t, push, to_text, join
  implicit none
  private
  public :: implausible, slips_of, refuse_slips

  !> Usual range of a key; a value of exactly 0 that has a meaning of its own is never told.
  type :: usual_t
    character(len=32) :: name   !< group.key
    real(dp) :: low, high       !< in the unit of the key
  end type usual_t

  !> A unit that values are often given in by mistake.
  type :: slip_t
    character(len=8) :: meant, given
    real(dp) :: factor  !< value times factor is in the key's unit
  end type slip_t

  ! Sizes 8 to 100 of harmonic drives (bore radii from 10 to 125 mm) and what they are made of. Of a list the largest number counts.
  type(usual_t), parameter :: usual(*) = [ &
    usual_t('geometry.bore_radius', 5e-3_dp, 0.2_dp), usual_t('geometry.wall_thickness', 0.1e-3_dp, 5e-3_dp), &
    usual_t('geometry.rim_thickness', 0.1e-3_dp, 8e-3_dp), usual_t('geometry.rim_length', 1e-3_dp, 0.1_dp), &
    usual_t('geometry.cup_length', 5e-3_dp, 0.4_dp), usual_t('geometry.bottom_thickness', 0.1e-3_dp, 20e-3_dp), &
    usual_t('geometry.hub_radius', 2e-3_dp, 0.2_dp), usual_t('geometry.ring_thickness', 0.3e-3_dp, 10e-3_dp), &
    usual_t('geometry.rim_taper', 1e-5_dp, 0.1_dp), usual_t('geometry.band_start', 1e-7_dp, 0.1_dp), &
    usual_t('cup.sections_r', 5e-3_dp, 0.4_dp), usual_t('cup.sections_z', 5e-3_dp, 0.4_dp), &
    usual_t('cup.sections_thickness', 0.1e-3_dp, 20e-3_dp), usual_t('cup.sections_fillet', 1e-5_dp, 0.1_dp), &
    usual_t('geometry.band_length', 1e-3_dp, 0.1_dp), usual_t('mesh.edge_length', 1e-7_dp, 5e-3_dp), &
    usual_t('material.flexspline_e', 1e9_dp, 5e11_dp), &
    usual_t('material.ring_e', 1e9_dp, 5e11_dp), usual_t('material.flexspline_nu', 0.15_dp, 0.49_dp), &
    usual_t('material.ring_nu', 0.15_dp, 0.49_dp), usual_t('material.yield_strength', 2e7_dp, 4e9_dp), &
    usual_t('material.ring_yield_strength', 2e7_dp, 4e9_dp), &
    usual_t('wave_generator.w', 2e-5_dp, 5e-3_dp), usual_t('wave_generator.interference', 1e-8_dp, 1e-4_dp), &
    usual_t('wave_generator.clearance', 1e-8_dp, 1e-4_dp), usual_t('wave_generator.arc_angle_deg', 10._dp, 80._dp), &
    usual_t('wave_generator.perimeter_length', 0.03_dp, 1.3_dp), &
    usual_t('bearing.ball_diameter', 0.5e-3_dp, 50e-3_dp), usual_t('bearing.groove_depth', 1e-6_dp, 10e-3_dp), &
    usual_t('bearing.clearance', 1e-8_dp, 1e-4_dp), usual_t('bearing.ball_e', 1e9_dp, 5e11_dp), &
    usual_t('bearing.ball_rate', 1e8_dp, 1e12_dp), usual_t('bearing.patch_length', 1e-6_dp, 20e-3_dp), &
    usual_t('bearing.patch_width', 1e-6_dp, 20e-3_dp), usual_t('fatigue.tensile_strength', 2e7_dp, 4e9_dp), &
    usual_t('fatigue.fatigue_limit', 1e7_dp, 2e9_dp), usual_t('load.pressure_angle_deg', 5._dp, 50._dp), &
    usual_t('load.tooth_gaps', 1e-8_dp, 1e-3_dp), usual_t('load.tooth_gaps_back', 1e-8_dp, 1e-3_dp), &
    usual_t('wave_generator.eccentricity', 1e-7_dp, 2e-4_dp), usual_t('contact.friction', 5e-3_dp, 0.6_dp), &
    usual_t('load.tooth_stiffness', 1e6_dp, 3e10_dp), &
    usual_t('load.tooth_clearance', 1e-8_dp, 1e-4_dp), usual_t('load.spline_diameter', 0.02_dp, 0.5_dp), &
    usual_t('load.spline_root_diameter', 0.01_dp, 0.4_dp), usual_t('load.spline_width', 1e-3_dp, 0.1_dp), &
    usual_t('joint.roughness', 1e-16_dp, 1e-6_dp), &
    usual_t('joint.asperity_radius', 1e-7_dp, 1e-3_dp), usual_t('joint.hardness', 1e8_dp, 2e10_dp), &
    usual_t('joint.sample_length', 1e-5_dp, 2e-2_dp), usual_t('joint.shortest_wavelength', 1e-9_dp, 1e-4_dp), &
    usual_t('joint.s_min', 1e-18_dp, 1e-8_dp), usual_t('surface.roughness', 1e-16_dp, 1e-6_dp), &
    usual_t('surface.dx', 1e-10_dp, 1e-3_dp), usual_t('surface.dy', 1e-10_dp, 1e-3_dp), &
    usual_t('surface.sample_length', 1e-7_dp, 0.1_dp), usual_t('surface.shortest_wavelength', 1e-10_dp, 1e-2_dp), &
    usual_t('fit.dx', 1e-10_dp, 1e-3_dp), usual_t('fit.dy', 1e-10_dp, 1e-3_dp), &
    usual_t('fit.shortest_wavelength', 1e-10_dp, 1e-2_dp), usual_t('fit.longest_wavelength', 1e-7_dp, 0.1_dp)]
  type(slip_t), parameter :: slips(*) = [slip_t('Pa', 'GPa', 1e9_dp), slip_t('Pa', 'MPa', 1e6_dp), slip_t('Pa', 'kPa', 1e3_dp), &
    slip_t('deg', 'rad', 180/pi), slip_t('N/m^1.5', 'N/mm^1.5', 1e3_dp*sqrt(1e3_dp)), slip_t('m', 'mm', 1e-3_dp), &
    slip_t('m', 'um', 1e-6_dp), slip_t('m', 'nm', 1e-9_dp), slip_t('m^2', 'um^2', 1e-12_dp), &
    slip_t('m^2', 'mm^2', 1e-6_dp), slip_t('N/m', 'N/um', 1e6_dp), slip_t('N/m', 'N/mm', 1e3_dp)]

  real(dp), parameter :: least_given = 1e-3_dp  !< nobody gives a length as 2e-4 mm: smaller numbers are no slips
  real(dp), parameter :: absurd = 30            !< times beyond the usual range of a length or modulus of a body
  !> Lengths of bodies; a clearance may be as good as none, and a strength or stiffness without bound.
  character(len=22), parameter :: of_bodies(*) = [character(len=22) :: &
    'geometry.', 'cup.', 'wave_generator.w ', 'bearing.ball_diameter', 'load.spline_']

  ! What scenes of drives keep within, by the messages that are written beyond.
  real(dp), parameter :: least_w = 0.1_dp, most_w = 4                  !< deformation over the wall
  real(dp), parameter :: overload = 5   !< torque over the momentary peak of catalogues, which a slip of units exceeds by far
  real(dp), parameter :: shortest_cup = 0.3_dp, longest_cup = 6        !< length over the bore radius

contains

  !> One line for every value that is hardly meant; none for a usual scene.
  subroutine implausible(scene, lines)
    type(scene_t), intent(in) :: scene                    !< checked scene
    type(string_t), allocatable, intent(out) :: lines(:)  !< warnings
    type(string_t), allocatable :: idle(:)
    allocate (lines(0))
    if (len_trim(scene%joint_doubt) > 0) call push(lines, 'joint.model: '//trim(scene%joint_doubt))
    call look_at_keys(scene, .false., lines)
    if (scene%surface_only) return
    call compare(scene, .false., lines)
    idle = idle_keys(scene)
    if (size(idle) > 0) call push(lines, 'this scene does not use '//join(idle, ', ')// &
      ": take it out, or see 'hdengine.x --explain "//idle(1)%s//"'")
  end subroutine implausible

  !> Of these the ones that a slip of units explains, or that no body has: they are some thousand times off.
  subroutine slips_of(scene, lines)
    type(scene_t), intent(in) :: scene                    !< scene whose keys are in range
    type(string_t), allocatable, intent(out) :: lines(:)  !< one each
    allocate (lines(0))
    call look_at_keys(scene, .true., lines)
    if (.not. scene%surface_only) call compare(scene, .true., lines)
  end subroutine slips_of

  !> Error for a scene with such values.
  subroutine refuse_slips(scene, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    type(error_t), allocatable, intent(out) :: error  !< what is off
    type(string_t), allocatable :: lines(:)
    call slips_of(scene, lines)
    if (size(lines) == 0) return
    call raise(error, code_input, join(lines, new_line('a')//'       ')//new_line('a')// &
      '       To solve it all the same: --allow-implausible, in Python allow_implausible=True')
  end subroutine refuse_slips

  !> Lines for keys outside of their usual range.
  subroutine look_at_keys(scene, slips_alone, lines)
    type(scene_t), intent(in) :: scene                      !< scene
    logical, intent(in) :: slips_alone                      !< those that stop a run
    type(string_t), allocatable, intent(inout) :: lines(:)  !< gets the lines
    type(scene_t), target :: copy
    type(parameter_table_t) :: table
    integer :: i, j
    copy = scene
    call new_table(copy, table)
    do i = 1, size(table%rows)
      associate (row => table%rows(i))
        if (scene%surface_only .neqv. (row%group == 'surface' .or. row%group == 'fit')) cycle
        do j = 1, size(usual)
          if (usual(j)%name /= row%group//'.'//row%key) cycle
          if (associated(row%real)) call tell(usual(j), row%real, row%unit, slips_alone, lines)
          if (associated(row%reals)) call tell(usual(j), maxval(row%reals(:value_count(row))), row%unit, slips_alone, lines)
        end do
      end associate
    end do
  end subroutine look_at_keys

  !> Line for a value outside of its usual range, with the slip of units that would bring it back.
  subroutine tell(row, value, unit, slips_alone, lines)
    type(usual_t), intent(in) :: row                        !< key and range
    real(dp), intent(in) :: value                           !< as given
    character(len=*), intent(in) :: unit                    !< of the key
    logical, intent(in) :: slips_alone                      !< no line for others
    type(string_t), allocatable, intent(inout) :: lines(:)  !< gets the line
    character(len=:), allocatable :: hint
    logical :: off
    integer :: i
    if (.not. abs(value) > 0 .or. (abs(value) >= row%low .and. abs(value) <= row%high)) return
    hint = ''
    off = index(row%name, '_e ') > 0
    do i = 1, size(of_bodies)
      off = off .or. index(row%name, trim(of_bodies(i))) == 1
    end do
    off = off .and. (abs(value)*absurd < row%low .or. abs(value) > absurd*row%high)
    do i = 1, size(slips)
      if (abs(value) < least_given) exit
      if (slips(i)%meant /= unit .or. slips(i)%given == unit) cycle
      if (abs(value)*slips(i)%factor < row%low .or. abs(value)*slips(i)%factor > row%high) cycle
      hint = '; did you mean '//to_text(value*slips(i)%factor)//' '//unit//' ('//to_text(value)//' '//trim(slips(i)%given)//')?'
      off = .true.
      exit
    end do
    if (slips_alone .and. .not. off) return
    call push(lines, trim(row%name)//' = '//to_text(value)//trim(' '//unit)//' is unusual: usual are '//to_text(row%low)//' to '// &
      to_text(row%high)//trim(' '//unit)//hint)
  end subroutine tell

  !> Lines for values that do not go together.
  subroutine compare(s, slips_alone, lines)
    type(scene_t), intent(in) :: s                          !< scene
    logical, intent(in) :: slips_alone                      !< no line for others
    type(string_t), allocatable, intent(inout) :: lines(:)  !< gets the lines
    if (s%support%loop .and. any(abs(s%torques) > 0)) then
      call look_at_torque('loop.torques', s%torques(maxloc(abs(s%torques), 1)), s, slips_alone, lines)
    else
      call look_at_torque('load.torque', s%torque, s, slips_alone, lines)
    end if
    if (s%support%loop) then
      call look_at_torque('loop.torque_1', s%torque_1, s, slips_alone, lines)
      call look_at_torque('loop.torque_2', s%torque_2, s, slips_alone, lines)
      call look_at_torque('loop.rated_torque', s%rated_torque, s, slips_alone, lines)
      call look_at_torque('turning.torque', s%turning_torque, s, slips_alone, lines)
    end if
    if (slips_alone) return
    if (.not. abs(s%w) > 0 .and. s%cam /= 'table') call push(lines, 'wave_generator.w = 0: the cup stays round, '// &
      'no drive. Check it: usual are 0.1 to 4 times the wall')
    if (modulo(s%teeth, 2) == 1 .and. (s%support%struts .or. s%support%against_teeth)) call push(lines, &
      'load.teeth = '//to_text(s%teeth)//' is odd: with two lobes both ends of the long axis are in mesh alike only with an '// &
      'even number. Check it')
    if (s%rim_thickness < s%wall_thickness) call push(lines, 'geometry.rim_thickness = '//to_text(s%rim_thickness)// &
      ' m is thinner than the wall ('//to_text(s%wall_thickness)//' m): a toothed rim is stiffer, 1.67^(1/3) times the wall')
    if (abs(s%w) > most_w*s%wall_thickness .or. (abs(s%w) > 0 .and. abs(s%w) < least_w*s%wall_thickness)) call push(lines, &
      'wave_generator.w = '//to_text(s%w)//' m is '//to_text(s%w/s%wall_thickness)//' times the wall: usual are 0.1 to 4 times')
    if (s%cup_length < shortest_cup*s%bore_radius .or. s%cup_length > longest_cup*s%bore_radius) call push(lines, &
      'geometry.cup_length = '// &
      to_text(s%cup_length)//' m is '//to_text(s%cup_length/s%bore_radius)//' times the bore radius: usual are 0.3 to 6 times')
  end subroutine compare

  !> Line for a torque that no drive of this bore holds.
  subroutine look_at_torque(key, torque, s, slips_alone, lines)
    character(len=*), intent(in) :: key                     !< its name
    real(dp), intent(in) :: torque                          !< [N m]
    type(scene_t), intent(in) :: s                          !< scene
    logical, intent(in) :: slips_alone                      !< no line for others
    type(string_t), allocatable, intent(inout) :: lines(:)  !< gets the line
    real(dp) :: most   !< momentary peak torque of catalogues, sizes 14 to 100: 1e7 N m per cubic metre of the bore radius [N m]
    character(len=:), allocatable :: hint
    most = 1e7_dp*s%bore_radius**3
    if (abs(torque) <= overload*most) return
    hint = ''
    if (1e-3_dp*abs(torque) < overload*most) hint = '; did you mean '//to_text(1e-3_dp*torque)//' N m ('//to_text(torque)//' N mm)?'
    if (slips_alone .and. len(hint) == 0) return
    call push(lines, key//' = '//to_text(torque)//' N m: drives of this bore hold some '//to_text(anint(most))// &
      ' N m for a moment'//hint)
  end subroutine look_at_torque
end module hd_plausible
