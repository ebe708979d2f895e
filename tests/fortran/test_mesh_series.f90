! SPDX-License-Identifier: GPL-3.0-or-later
module test_mesh_series
  use hd_check, only: check, check_close
  use hd_kinds, only: dp
  use hd_mesh_series, only: extrapolate, first_level, least_error, least_tolerance, levels
  implicit none
  private
  public :: run_mesh_series

contains

  subroutine run_mesh_series()
    real(dp), parameter :: rows(6) = [4._dp, 6._dp, 8._dp, 12._dp, 16._dp, 22._dp]
    real(dp), parameter :: x(3) = [0.1_dp, 0.03_dp, 0.01_dp]
    real(dp) :: q(3, 6), limit(3), estimate(3), least(3)
    integer :: i
    q(1, :) = 2 + 5/rows**2
    q(2, :) = 7 - 3/rows**2
    q(3, :) = 3 + [0._dp, 0._dp, 0.3_dp, 0._dp, 0._dp, 0._dp]
    call extrapolate(q, 6, limit, estimate)
    call check_close(limit(1), 2._dp, 1e-12_dp, 'what moves in proportion to h^2 has its limit at h = 0')
    call check_close(limit(2), 7._dp, 1e-12_dp, 'upwards, too')
    call check_close(estimate(1), 1.3_dp*5/22**2/2, 1e-12_dp, 'the way to the limit, with a margin, is its error')
    call check_close(limit(3), 3._dp, 1e-12_dp, 'a coarse mesh counts no more')
    call check(estimate(3) > 0.04_dp, 'what it changed of the limit is its error')
    q(1, :) = 2 + 5/rows
    call extrapolate(q, 6, limit, estimate)
    call check(abs(limit(1) - 2) < 2*estimate(1)*limit(1), 'the estimate covers half of a first order taken for a second')
    do i = 1, 3
      least = least_error(first_level(x(i)), x(i))
      call check(all(least < x(i)), 'the first level may keep the promise')
    end do
    call check(all(least_error(5, 0.1_dp) >= least_error(5, 0.049_dp)), 'less is known with one layer')
    call check(abs(maxval(least_error(levels, least_tolerance))/least_tolerance - 1) < 0.01_dp, &
      'the finest level may keep the least promise')
    call check(all([(first_level(x(i)), i=1, 3)] == [4, 5, 7]), 'refinement begins on 12, 16 and 32 rows for 10, 3 and 1 per cent')
  end subroutine run_mesh_series
end module test_mesh_series
