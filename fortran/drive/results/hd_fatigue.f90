! SPDX-License-Identifier: GPL-3.0-or-later
!> Life of the flexspline: as the wave generator turns, every point of a meridian meets the stresses of the whole circumference.
!> Their mean and amplitude go to Goodman's line: 1/safety = notch amplitude/limit + max(0, mean)/strength.
module hd_fatigue
  use hd_kinds, only: dp
  use hd_body, only: body_t
  use hd_error, only: error_t
  use hd_output, only: fatigue_file
  use hd_scene, only: scene_t
  use hd_stress, only: signed_equivalent
  use hd_table, only: table_t
  implicit none
  private
  public :: fatigue_t, judge_fatigue, safety_of, write_fatigue

  !> Nodes of the meridian at the load step with the least safety.
  type :: fatigue_t
    real(dp) :: torque = 0                      !< of that step [N m]
    real(dp), allocatable :: mean(:)            !< of the signed von Mises stress [Pa]
    real(dp), allocatable :: amplitude(:)       !< [Pa]
    real(dp), allocatable :: safety(:)          !< Goodman's
    integer :: least(2) = 0                     !< nodes of the body between whose stresses, low and high, it is least
  end type fatigue_t

contains

  !> Judge the stresses of a step; the worst step stays.
  subroutine judge_fatigue(scene, body, stress, torque, fatigue)
    type(scene_t), intent(in) :: scene            !< limits
    type(body_t), intent(in) :: body              !< revolved flexspline
    real(dp), intent(in) :: stress(:, :)          !< at its nodes (6, nodes) [Pa]
    real(dp), intent(in) :: torque                !< of the step [N m]
    type(fatigue_t), intent(inout) :: fatigue     !< worst step so far
    real(dp), dimension(body%nodes_per_sector) :: low, high, mean, amplitude, safety
    real(dp) :: s(body%nodes_per_sector, body%sectors)
    integer :: i
    s = reshape(signed_equivalent(stress), shape(s))
    low = s(:, 1)
    high = s(:, 1)
    do i = 2, size(s, 2)
      low = min(low, s(:, i))
      high = max(high, s(:, i))
    end do
    mean = (high + low)/2
    amplitude = (high - low)/2
    safety = safety_of(scene, low, high)
    if (allocated(fatigue%safety)) then
      if (minval(safety) >= minval(fatigue%safety)) return
    end if
    fatigue%torque = torque
    fatigue%mean = mean
    fatigue%amplitude = amplitude
    fatigue%safety = safety
    i = minloc(safety, 1)
    fatigue%least = i + body%nodes_per_sector*([minloc(s(i, :), 1), maxloc(s(i, :), 1)] - 1)
  end subroutine judge_fatigue

  !> Safety of a point between two signed stresses.
  elemental real(dp) function safety_of(scene, low, high) result(safety)
    type(scene_t), intent(in) :: scene      !< limits
    real(dp), intent(in) :: low, high       !< [Pa]
    safety = 1/max(tiny(1._dp), scene%notch_factor*(high - low)/(2*scene%fatigue_limit) + &
      max(0._dp, (high + low)/2)/scene%tensile_strength)
  end function safety_of

  !> The meridian's table.
  subroutine write_fatigue(folder, body, fatigue, error)
    character(len=*), intent(in) :: folder            !< of the run
    type(body_t), intent(in) :: body                  !< flexspline
    type(fatigue_t), intent(in) :: fatigue            !< judged
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    type(table_t) :: table
    integer :: a
    if (.not. allocated(fatigue%safety)) return
    call table%open(folder//'/'//fatigue_file, 'torque_nm,node,r_m,z_m,mean_pa,amplitude_pa,safety', error)
    do a = 1, body%nodes_per_sector
      if (allocated(error)) return
      call table%add(fatigue%torque)
      call table%add(a)
      call table%add(hypot(body%x(1, a), body%x(2, a)))
      call table%add(body%x(3, a))
      call table%add(fatigue%mean(a))
      call table%add(fatigue%amplitude(a))
      call table%add(fatigue%safety(a))
      call table%end_row(error)
    end do
    call table%close(error)
  end subroutine write_fatigue
end module hd_fatigue
