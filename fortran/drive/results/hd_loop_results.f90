! SPDX-License-Identifier: GPL-3.0-or-later
!> Results of a whole drive's loop under their names, as summary.json, study tables and Python have them.
module hd_loop_results
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp
  use hd_ball_bearing, only: race_pressure
  use hd_facets, only: sums_t
  use hd_loop, only: loop_t, readings_t, read_loop
  use hd_scene, only: scene_t
  use hd_tolerance_band, only: tolerance_band_t, banded, banded_keys, banded_values, readings
  implicit none
  private
  public :: loop_names, loop_values

  character(len=*), parameter :: others = 'loop_work_j,loop_dissipated_j,loop_dissipated_teeth_j,loop_stored_j,'// &
    'ball_force_max_n,tooth_force_max_n,goodman_safety_min,ball_pressure_max_pa,turning_angle_error_rad,'// &
    'turning_stiffness_min_nm_per_rad,turning_stiffness_max_nm_per_rad'

contains

  !> What `loop_values` returns: readings, ends of the bands, the others.
  pure function loop_names() result(names)
    character(len=:), allocatable :: names  !< parted by commas
    integer :: i
    names = ''
    do i = 1, readings
      names = names//trim(banded_keys(i))//','
    end do
    do i = 1, banded
      names = names//trim(banded_keys(i))//'_low,'//trim(banded_keys(i))//'_high,'
    end do
    names = names//others
  end function loop_names

  !> Values in the order of `loop_names`; NaN for what the torques do not reach, or was not computed.
  pure function loop_values(loop, scene, sums, band) result(values)
    type(loop_t), intent(in) :: loop              !< booked steps
    type(scene_t), intent(in) :: scene            !< T1, T2, rated torque
    type(sums_t), intent(in) :: sums              !< of the reference step
    type(tolerance_band_t), intent(in) :: band    !< of the readings
    real(dp), allocatable :: values(:)
    type(readings_t) :: r
    real(dp) :: none, value(banded), ends(2, banded), safety, pressed, turning(3)
    none = ieee_value(1._dp, ieee_quiet_nan)
    r = read_loop(loop, scene)
    ends = none
    if (allocated(band%input)) then
      value = banded_values(r, sums)
      ends = merge(spread(value, 1, 2)*band%bounds(), none, spread(value > 0 .and. band%known, 1, 2))
    end if
    pressed = race_pressure(scene, loop%ball_force_max)
    if (.not. pressed > 0) pressed = none
    safety = none
    if (allocated(loop%fatigue%safety)) safety = minval(loop%fatigue%safety)
    turning = none
    if (allocated(loop%turned_angle)) turning = [maxval(loop%turned_angle) - minval(loop%turned_angle), &
      minval(loop%turned_stiffness), maxval(loop%turned_stiffness)]
    values = [merge(r%k, none, r%k > 0), merge(r%hysteresis, none, r%has_hysteresis), &
      merge(r%lost_motion, none, r%has_lost_motion), reshape(ends, [2*banded]), loop%work, loop%dissipated, &
      loop%dissipated_teeth, loop%stored - loop%stored_assembled, loop%ball_force_max, loop%tooth_force_max, safety, &
      pressed, turning]
  end function loop_values
end module hd_loop_results
