! SPDX-License-Identifier: GPL-3.0-or-later
!> Counter-based random numbers: Threefry-2x32, 20 rounds (Salmon et al. 2011, SC11, doi 10.1145/2063384.2063405).
!>
!> The number depends on (seed, i, j) alone, never on the order of calls or the thread, and is the same on every platform: words
!> are 32 bits in 64-bit integers, so nothing overflows.
module hd_random
  use hd_kinds, only: dp, i8
  implicit none
  private
  public :: uniform, threefry

  integer(i8), parameter :: mask = 4294967295_i8
  integer, parameter :: turns(8) = [13, 15, 26, 6, 17, 29, 16, 24]

contains

  !> Uniform number in [0, 1), a multiple of 2^-53.
  pure real(dp) function uniform(seed, i, j) result(u)
    integer(i8), intent(in) :: seed    !< key
    integer(i8), intent(in) :: i, j    !< counter; the lower 32 bits of each count
    integer(i8) :: word(2)
    word = threefry([iand(i, mask), iand(j, mask)], [iand(seed, mask), iand(ishft(seed, -32), mask)])
    u = (real(word(1), dp) * 2097152._dp + real(ishft(word(2), -11), dp)) * 2._dp**(-53)
  end function uniform

  !> The two random words of a counter under a key.
  pure function threefry(counter, key) result(x)
    integer(i8), intent(in) :: counter(2), key(2)    !< words of 32 bits
    integer(i8) :: x(2)
    integer(i8) :: schedule(0:2)
    integer :: round, k
    schedule(0) = key(1)
    schedule(1) = key(2)
    schedule(2) = ieor(ieor(int(z'1BD11BDA', i8), key(1)), key(2))
    x = iand(counter + key, mask)
    do round = 1, 20
      x(1) = iand(x(1) + x(2), mask)
      k = turns(mod(round - 1, 8) + 1)
      x(2) = ieor(iand(ior(ishft(x(2), k), ishft(x(2), k - 32)), mask), x(1))
      if (mod(round, 4) == 0) then
        k = round / 4
        x(1) = iand(x(1) + schedule(mod(k, 3)), mask)
        x(2) = iand(x(2) + schedule(mod(k + 1, 3)) + k, mask)
      end if
    end do
  end function threefry
end module hd_random
