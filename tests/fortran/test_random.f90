! SPDX-License-Identifier: GPL-3.0-or-later
!> Random numbers against the published vectors.
module test_random
  use hd_check, only: check
  use hd_kinds, only: dp, i8
  use hd_random, only: threefry, uniforms
  implicit none
  private
  public :: run_random

contains

  subroutine run_random()
    integer(i8), parameter :: ones = int(z'FFFFFFFF', i8), pi_1 = int(z'243F6A88', i8), pi_2 = int(z'85A308D3', i8)
    integer(i8) :: i(4000), j(4000)
    real(dp) :: u(4000), v(2)
    integer :: k
    call published([0_i8, 0_i8], [0_i8, 0_i8], [int(z'6B200159', i8), int(z'99BA4EFE', i8)], 'zeros')
    call published([ones, ones], [ones, ones], [int(z'1CB996FC', i8), int(z'BB002BE7', i8)], 'ones')
    call published([pi_1, pi_2], [int(z'13198A2E', i8), int(z'03707344', i8)], [int(z'C4923A9C', i8), int(z'483DF7A0', i8)], 'pi')
    i = [(k, k=1, size(i))]
    j = 3
    call uniforms(12345_i8, i, j, u)
    call check(all(u >= 0 .and. u < 1) .and. abs(sum(u) / size(u) - 0.5_dp) < 0.02_dp .and. &
      abs(sum((u - 0.5_dp)**2) / size(u) - 1 / 12._dp) < 0.005_dp, 'uniform numbers lie in [0, 1) with their mean and variance')
    call uniforms(12345_i8, [777_i8, -1_i8], [3_i8, 0_i8], v)
    call check(abs(v(1) - u(777)) <= 0, 'a number depends on its counter alone')
    call check(v(2) >= 0 .and. v(2) < 1, 'a negative counter is as good as any')
  end subroutine run_random

  !> Words of a counter under a key.
  subroutine published(counter, key, expected, name)
    integer(i8), intent(in) :: counter(2), key(2), expected(2)
    character(len=*), intent(in) :: name
    integer(i8) :: a(1), b(1)
    a = counter(1)
    b = counter(2)
    call threefry(1, a, b, key)
    call check(a(1) == expected(1) .and. b(1) == expected(2), 'Threefry-2x32-20 gives the published words of '//name)
  end subroutine published
end module test_random
