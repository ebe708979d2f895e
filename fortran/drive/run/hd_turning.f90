! SPDX-License-Identifier: GPL-3.0-or-later
!> The turning wave generator of the whole drive: at places of a turn, balls and teeth stand where rolling and mesh have brought
!> them; there the drive is pressed on and loaded anew (hd_march), and stiffness and angle over the turn follow.
!>
!> Everything is seen from the wave generator, whose long axis stays. If it turns by phi against the circular spline, the
!> flexspline, with z teeth against z + 2, and the ring that it carries turn by -phi (z + 2)/z. Balls that roll without slip between
!> an inner race that stands and an outer one of radius R take the cage along by R/(2 R - d) of that, d their diameter.
!> The bodies are round: only their points of support move, and the compliance by harmonics stays.
module hd_turning
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t
  use hd_log, only: say
  use hd_output, only: turning_file
  use hd_race, only: race_radius
  use hd_run, only: run_t
  use hd_scene, only: scene_t
  use hd_table, only: table_t
  use hd_text, only: to_text
  implicit none
  private
  public :: angle_of, turned_scene, open_places, book_place

contains

  !> Turn of the wave generator at a place [rad].
  pure real(dp) function angle_of(scene, place) result(angle)
    type(scene_t), intent(in) :: scene  !< scene
    integer, intent(in) :: place        !< from 1
    angle = scene%turning_range_deg*pi/180
    if (.not. angle > 0) angle = merge(2*pi/max(1, scene%balls)/cage_share(scene), 2*pi/scene%teeth, scene%balls > 0)/ &
      flexspline_share(scene)
    angle = angle*(place - 1)/scene%turning_positions
  end function angle_of

  !> Turn of the flexspline over that of the wave generator against the circular spline, seen from the wave generator, backwards.
  pure real(dp) function flexspline_share(scene)
    type(scene_t), intent(in) :: scene  !< scene
    flexspline_share = real(scene%teeth + 2, dp)/scene%teeth
  end function flexspline_share

  !> Turn of the cage over that of the outer race, where balls roll and the inner race stands.
  pure real(dp) function cage_share(scene)
    type(scene_t), intent(in) :: scene  !< scene
    associate (outer => race_radius(scene))
      cage_share = outer/(2*outer - scene%ball_diameter)
    end associate
  end function cage_share

  !> The drive where the wave generator has turned; the torque comes in two steps.
  pure type(scene_t) function turned_scene(scene, place) result(s)
    type(scene_t), intent(in) :: scene   !< scene
    integer, intent(in) :: place         !< from 1
    real(dp) :: turned
    s = scene
    turned = -angle_of(scene, place)*flexspline_share(scene)
    s%cage_angle_deg = modulo(s%cage_angle_deg + turned*cage_share(scene)*180/pi, 360._dp)
    s%tooth_phase = s%tooth_phase + turned*scene%teeth/(2*pi)
    s%tooth_phase = s%tooth_phase - anint(s%tooth_phase)
    s%torque_count = 1
    s%torques(1) = merge(scene%turning_torque, scene%rated_torque, abs(scene%turning_torque) > 0)
    s%torque = s%torques(1)
    s%torque_steps = 2
    s%torque_1 = 2*abs(s%torque)  ! they stop nowhere else
    s%torque_2 = 3*abs(s%torque)
    s%start = 'rest'
    s%turning_positions = 0
  end function turned_scene

  !> Open turning.csv, in the folder of a run that has one.
  subroutine open_places(run, rows, error)
    type(run_t), intent(inout) :: run                 !< its loop is to get the places
    type(table_t), intent(inout) :: rows              !< turning.csv
    type(error_t), allocatable, intent(out) :: error  !< files
    allocate (run%loop%turned_angle(0), run%loop%turned_stiffness(0))
    if (run%writes) call rows%open(run%output%folder//'/'//turning_file, 'position,wave_generator_deg,cage_angle_deg,'// &
      'tooth_phase,turn_rad,stiffness_nm_per_rad,wave_generator_torque_nm,ball_force_max_n,tooth_force_max_n,'// &
      'balls_loaded,pairs_loaded', error)
  end subroutine open_places

  !> Row of a place, and what the record keeps of it.
  subroutine book_place(run, place, i, rows, error)
    type(run_t), intent(inout) :: run                 !< gets angle and stiffness in its loop
    type(run_t), intent(in) :: place                  !< loaded place
    integer, intent(in) :: i                          !< its number
    type(table_t), intent(inout) :: rows              !< turning.csv
    type(error_t), allocatable, intent(out) :: error  !< disk full
    real(dp) :: stiffness
    associate (loop => place%loop, scene => place%scene)
      stiffness = (loop%torque(3) - loop%torque(2))/(loop%angle(3) - loop%angle(2))
      run%loop%turned_angle = [run%loop%turned_angle, loop%angle(3)]
      run%loop%turned_stiffness = [run%loop%turned_stiffness, stiffness]
      call say('turned    '//to_text(angle_of(run%scene, i)*180/pi)//' degrees: '//to_text(loop%angle(3))//' rad, '// &
        to_text(stiffness)//' N m/rad at '//to_text(scene%torque)//' N m')
      if (.not. run%writes) return
      call rows%add(i)
      call rows%add(angle_of(run%scene, i)*180/pi)
      call rows%add(scene%cage_angle_deg)
      call rows%add(scene%tooth_phase)
      call rows%add(loop%angle(3))
      call rows%add(stiffness)
      call rows%add(loop%wave_generator_torque)
      call rows%add(maxval([0._dp, loop%force(:scene%balls)]))
      call rows%add(maxval(loop%force(scene%balls + 1:scene%balls + 2*scene%tooth_pairs)))
      call rows%add(count(loop%force(:scene%balls) > 0))
      call rows%add(count(loop%force(scene%balls + 1:scene%balls + 2*scene%tooth_pairs) > 0))
      call rows%end_row(error)
    end associate
  end subroutine book_place
end module hd_turning
