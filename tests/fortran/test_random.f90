! SPDX-License-Identifier: GPL-3.0-or-later
!> Random numbers against the published vectors.
module test_random
  use hd_check, only: check
  use hd_kinds, only: dp, i8
  use hd_random, only: threefry, uniform
  implicit none
  private
  public :: run_random

contains

  subroutine run_random()
    integer(i8), parameter :: ones = int(z'FFFFFFFF', i8)
    real(dp) :: u(4000)
    integer :: i
    call check(all(threefry([0_i8, 0_i8], [0_i8, 0_i8]) == [int(z'6B200159', i8), int(z'99BA4EFE', i8)]), &
      'Threefry-2x32-20 gives the published words of zeros')
    call check(all(threefry([ones, ones], [ones, ones]) == [int(z'1CB996FC', i8), int(z'BB002BE7', i8)]), &
      'Threefry-2x32-20 gives the published words of ones')
    call check(all(threefry([int(z'243F6A88', i8), int(z'85A308D3', i8)], [int(z'13198A2E', i8), int(z'03707344', i8)]) == &
      [int(z'C4923A9C', i8), int(z'483DF7A0', i8)]), 'Threefry-2x32-20 gives the published words of pi')
    u = [(uniform(12345_i8, int(i, i8), 3_i8), i=1, size(u))]
    call check(all(u >= 0 .and. u < 1) .and. abs(sum(u) / size(u) - 0.5_dp) < 0.02_dp .and. &
      abs(sum((u - 0.5_dp)**2) / size(u) - 1 / 12._dp) < 0.005_dp, 'uniform numbers lie in [0, 1) with their mean and variance')
    call check(uniform(1_i8, -1_i8, 0_i8) >= 0 .and. uniform(1_i8, -1_i8, 0_i8) < 1, 'a negative counter is as good as any')
  end subroutine run_random
end module test_random
