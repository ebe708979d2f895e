! SPDX-License-Identifier: GPL-3.0-or-later
module test_tolerance_band
  use hd_check, only: check, check_close
  use hd_kinds, only: dp
  use hd_text, only: string_t
  use hd_tolerance_band, only: tolerance_band_t, banded
  implicit none
  private
  public :: run_tolerance_band

contains

  subroutine run_tolerance_band()
    type(tolerance_band_t) :: band, still
    real(dp) :: base(banded), ends(banded, 2), factor(2, banded)
    type(string_t), allocatable :: keys(:)
    real(dp), allocatable :: shares(:)
    base = 2
    base(banded) = 0
    ends = 2
    call still%add('a', base, ends)
    factor = still%bounds()
    call check(all(abs(factor - 1) < 1e-15_dp), 'inputs that change nothing leave a band without width')
    call still%ranked(keys, shares)
    call check(all(abs(shares) <= 0), 'and no input makes it')
    ends(:, 1) = 2*exp(-0.3_dp)
    ends(:, 2) = 2*exp(0.1_dp)
    call band%add('a', base, ends)
    ends(:, 1) = 2*exp(0.4_dp)  ! both ends on one side
    ends(:, 2) = 2*exp(0.2_dp)
    ends(1, :) = [0._dp, 2*exp(0.2_dp)]
    call band%add('b', base, ends)
    factor = band%bounds()
    call check_close(log(factor(1, 2)), -0.3_dp, 1e-12_dp, 'an input that moves a result upwards does not widen it downwards')
    call check_close(log(factor(2, 2)), hypot(0.1_dp, 0.4_dp), 1e-12_dp, 'changes add up by the root of their squares')
    call check_close(log(factor(2, 1)), hypot(0.1_dp, 0.2_dp), 1e-12_dp, 'an end without a result does not count')
    call check(band%known(1) .and. .not. band%known(banded), 'a result that the drive does not have has no band')
    call band%ranked(keys, shares)
    call check(keys(1)%s == 'b' .and. keys(2)%s == 'a', 'the input that makes most of the band comes first')
    call check_close(shares(1), 0.16_dp/(0.16_dp + 0.09_dp + 0.01_dp), 1e-12_dp, 'shares are those of the variance of ln K2')
    call check_close(sum(shares), 1._dp, 1e-12_dp, 'shares add up to 1')
  end subroutine run_tolerance_band
end module test_tolerance_band
