! SPDX-License-Identifier: GPL-3.0-or-later
!> Life of the flexspline: as the wave generator turns, every point of a meridian meets the stresses of the whole circumference.
!> Those two of them whose difference has the largest von Mises stress make its cycle; half that stress is the amplitude, the signed
!> von Mises stress of their mean the mean. Goodman's line: 1/safety = notch amplitude/limit + max(0, mean)/strength.
module hd_fatigue
  use hd_kinds, only: dp
  use hd_body, only: body_t
  use hd_error, only: error_t
  use hd_output, only: fatigue_file
  use hd_scene, only: scene_t
  use hd_stress, only: many_nodes, signed_equivalent, square_of
  use hd_table, only: table_t
  implicit none
  private
  public :: fatigue_t, cycle_weights, judge_fatigue, safety_of, write_fatigue

  real(dp), parameter :: cycle_weights(2, 2) = reshape([0.5_dp, 0.5_dp, -0.5_dp, 0.5_dp], [2, 2])  !< mean, amplitude of two

  !> Nodes of the meridian at the load step with the least safety.
  type :: fatigue_t
    real(dp) :: torque = 0                      !< of that step [N m]
    real(dp), allocatable :: mean(:)            !< [Pa]
    real(dp), allocatable :: amplitude(:)       !< [Pa]
    real(dp), allocatable :: safety(:)          !< Goodman's
    integer :: least(2) = 0                     !< nodes of the body whose stresses are the cycle of the least
  end type fatigue_t

contains

  !> Judge the stresses of a step; the worst step stays.
  subroutine judge_fatigue(scene, body, stress, torque, fatigue)
    type(scene_t), intent(in) :: scene            !< limits
    type(body_t), intent(in) :: body              !< revolved flexspline
    real(dp), intent(in) :: stress(:, :)          !< at its nodes (6, nodes) [Pa]
    real(dp), intent(in) :: torque                !< of the step [N m]
    type(fatigue_t), intent(inout) :: fatigue     !< worst step so far
    real(dp), dimension(body%nodes_per_sector) :: mean, amplitude, safety
    real(dp) :: between(6, body%nodes_per_sector)
    integer :: pair(2, body%nodes_per_sector), i
    associate (m => body%nodes_per_sector)
      !$omp parallel do schedule(static) if(body%nodes() > many_nodes)
      do i = 1, m
        pair(:, i) = i + m*(furthest(stress(:, i::m)) - 1)
        between(:, i) = (stress(:, pair(1, i)) + stress(:, pair(2, i)))/2
        amplitude(i) = sqrt(square_of(stress(:, pair(2, i)) - stress(:, pair(1, i))))/2
      end do
      !$omp end parallel do
    end associate
    mean = signed_equivalent(between)
    safety = safety_of(scene, mean, amplitude)
    if (allocated(fatigue%safety)) then
      if (minval(safety) >= minval(fatigue%safety)) return
    end if
    fatigue%torque = torque
    fatigue%mean = mean
    fatigue%amplitude = amplitude
    fatigue%safety = safety
    fatigue%least = pair(:, minloc(safety, 1))
  end subroutine judge_fatigue

  !> Columns whose difference has the largest von Mises stress. Where one such difference is d and no column is further than R from
  !> the mean of all, both ends of a larger one are d - R or more from it (triangle inequality): only such columns are compared.
  pure function furthest(s) result(pair)
    real(dp), intent(in) :: s(:, :)  !< (6, n) [Pa]
    integer :: pair(2), i, j
    integer, allocatable :: outer(:)
    real(dp) :: centre(6), away(size(s, 2)), most, square
    centre = sum(s, 2)/size(s, 2)
    away = [(sqrt(square_of(s(:, i) - centre)), i=1, size(s, 2))]
    pair = maxloc(away, 1)
    pair(2) = maxloc([(square_of(s(:, i) - s(:, pair(1))), i=1, size(s, 2))], 1)
    most = square_of(s(:, pair(2)) - s(:, pair(1)))
    outer = pack([(i, i=1, size(s, 2))], away >= sqrt(most) - maxval(away))
    do j = 2, size(outer)
      do i = 1, j - 1
        square = square_of(s(:, outer(i)) - s(:, outer(j)))
        if (.not. square > most) cycle
        most = square
        pair = [outer(i), outer(j)]
      end do
    end do
  end function furthest

  !> Safety of a cycle.
  elemental real(dp) function safety_of(scene, mean, amplitude) result(safety)
    type(scene_t), intent(in) :: scene          !< limits
    real(dp), intent(in) :: mean, amplitude     !< of either sign [Pa]
    safety = 1/max(tiny(1._dp), scene%notch_factor*abs(amplitude)/scene%fatigue_limit + &
      max(0._dp, mean)/scene%tensile_strength)
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
