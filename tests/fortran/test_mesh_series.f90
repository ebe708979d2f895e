! SPDX-License-Identifier: GPL-3.0-or-later
module test_mesh_series
  use hd_check, only: check, check_close
  use hd_kinds, only: dp
  use hd_mesh_series, only: extrapolate, first_level, least_error
  implicit none
  private
  public :: run_mesh_series

contains

  subroutine run_mesh_series()
    real(dp), parameter :: rows(6) = [4._dp, 6._dp, 8._dp, 12._dp, 16._dp, 22._dp]
    real(dp), parameter :: x(3) = [0.1_dp, 0.03_dp, 0.01_dp]
    real(dp) :: q(3, 6), limit(3), estimate(3)
    integer :: i
    q(1, :) = 2 + 5/rows
    q(2, :) = 7 - 3/rows
    q(3, :) = 3 + [0.2_dp, -0.1_dp, 0.05_dp, 0.04_dp, -0.03_dp, 0.02_dp]
    call extrapolate(q, 6, limit, estimate)
    call check_close(limit(1), 2._dp, 1e-12_dp, 'what moves in proportion to h has its limit at h = 0')
    call check_close(limit(2), 7._dp, 1e-12_dp, 'so have quantities that may jump, where they do not')
    call check_close(estimate(1), 1.3_dp*5/66/2, 1e-12_dp, 'a third of the way to the limit, with a margin, is its error at least')
    call check_close(limit(3), q(3, 6), 1e-15_dp, 'what jumps keeps the value of the finest mesh')
    call check_close(estimate(3), 1.3_dp*0.05_dp*16/6/3.02_dp, 1e-12_dp, &
      'its error is what the first order leaves of the last jump')
    q(1, :) = 2 + 5/rows**2
    call extrapolate(q, 6, limit, estimate)
    call check(abs(limit(1) - 2) < estimate(1)*limit(1), 'the estimate covers a second order taken for a first')
    call check(least_error(5, 0.1_dp) > least_error(5, 0.049_dp), 'less is known with cells at the edges refined twice only')
    call check(least_error(7, 0.01_dp) > 0.01_dp .and. least_error(8, 0.01_dp) < 0.01_dp, &
      'one per cent may be promised on 46 rows, not on 32')
    call check(all([(first_level(x(i)), i=1, 3)] == [5, 6, 7]), 'refinement begins on 16, 22 and 32 rows for 10, 3 and 1 per cent')
  end subroutine run_mesh_series
end module test_mesh_series
