! SPDX-License-Identifier: GPL-3.0-or-later
!> What the user of a whole drive is warned of when its loop has ended.
module hd_loop_warnings
  use hd_kinds, only: dp
  use hd_loop, only: loop_t, read_loop, readings_t
  use hd_scene, only: scene_t
  use hd_text, only: string_t, push, rounded, to_text
  implicit none
  private
  public :: drive_warnings

  real(dp), parameter :: much_on_cam = 2      !< times the torque over the ratio above which it is warned of
  real(dp), parameter :: usual_play = 2.9089e-4_dp  !< an arc minute: catalogues' bound of lost motion [rad]
  real(dp), parameter :: large_jump = 0.2_dp  !< share of the largest force of a ball above which it is warned of

contains

  !> Where the drive leaves what its scene can say.
  subroutine drive_warnings(loop, scene, lines)
    type(loop_t), intent(in) :: loop                      !< booked steps
    type(scene_t), intent(in) :: scene                    !< scene
    type(string_t), allocatable, intent(out) :: lines(:)  !< one each
    character(len=:), allocatable :: cause
    type(readings_t) :: found
    real(dp) :: lossless, fitting
    integer :: i
    allocate (lines(0))
    lossless = maxval(abs(loop%torque))*2/scene%teeth
    fitting = 2*(scene%bore_radius + scene%rim_thickness)/scene%teeth
    if (lossless > 0 .and. loop%wave_generator_torque_max > much_on_cam*lossless) then
      cause = 'balls that stand unevenly about the long axis press on its slopes (wave_generator.eccentricity, '// &
        'bearing.cage_angle_deg)'
      if (abs(scene%w/fitting - 1) > 0.5_dp) cause = 'wave_generator.w = '//to_text(scene%w)//' m does not go with '// &
        'load.teeth = '//to_text(scene%teeth)//', which ask for about 2 (bore_radius + rim_thickness)/teeth = '// &
        to_text(fitting)//' m'
      if (scene%balls == 0 .and. scene%ring_follows()) cause = 'wave_generator.ring_tangent holds the ring'
      call push(lines, trim(merge('the ring puts', 'the balls put', scene%balls == 0))//' up to '// &
        to_text(loop%wave_generator_torque_max)//' N m on the cam; without losses '// &
        'the largest torque over half the teeth, '//to_text(lossless)//' N m, would drive it. Check this: '//cause)
    end if
    if (loop%unloaded) call push(lines, 'at a load step no ball carries the ring: bearing.clearance is larger than the '// &
      'way of the cam, or the torque has lifted the ring off. Lower bearing.clearance or the torque')
    if (loop%play > usual_play) call push(lines, 'no pair of teeth pushes at a load step: the bottom is free to turn by '// &
      to_text(loop%play)//' rad there, above the arc minute of catalogues; K1, hysteresis and lost motion contain it. Lower '// &
      'load.tooth_clearance or load.tooth_gaps, or raise load.tooth_pairs')
    if (loop%jump%force > large_jump*loop%ball_force_max) call push(lines, 'ball '//to_text(loop%jump%ball)// &
      ' comes or goes with '//to_text(loop%jump%force)//' N between '//to_text(loop%jump%before)//' and '// &
      to_text(loop%jump%after)//' N m: raise load.torque_steps to see where, or move bearing.cage_angle_deg')
    if (loop%lift > scene%w .and. scene%w > 0) call push(lines, 'loaded pairs of teeth move '//to_text(loop%lift)// &
      ' m out of mesh, more than w = '//to_text(scene%w)//' m: a real drive would ratchet; teeth have no tips '// &
      'here. Lower the torque')
    found = read_loop(loop, scene)
    associate (ends => [scene%torque_1, scene%torque_2])
      i = count(ends <= found%top) + 1  ! the chord in which it ends
      if (i <= 2) then
        if (found%k(i) > 0) call push(lines, 'the rise ends at '//to_text(found%top)//' N m, below loop.torque_'//to_text(i)// &
          ' = '//to_text(ends(i))//' N m: K'//to_text(i)//' is the chord to there, a catalogue''s is not. Raise the torque')
      end if
    end associate
    if (allocated(loop%fatigue%safety)) then
      if (minval(loop%fatigue%safety) < 1) call push(lines, "the cup's least safety by Goodman is "// &
        rounded(minval(loop%fatigue%safety))//', below 1: fatigue.csv holds the place. A sharp step of the wall lowers it on '// &
        'finer meshes; cup.sections_fillet rounds it')
    end if
  end subroutine drive_warnings
end module hd_loop_warnings
