! SPDX-License-Identifier: GPL-3.0-or-later
!> Counter-based random numbers: Threefry-2x32, 20 rounds (Salmon et al. 2011, SC11, doi 10.1145/2063384.2063405).
!>
!> The number depends on (seed, i, j) alone, never on the order of calls or the thread, and is the same on every platform: words
!> are 32 bits in 64-bit integers, so nothing overflows.
module hd_random
  use hd_kinds, only: dp, i8
  implicit none
  private
  public :: uniforms, threefry

  integer(i8), parameter :: mask = 4294967295_i8
  integer, parameter :: turns(8) = [13, 15, 26, 6, 17, 29, 16, 24]

contains

  !> Uniform numbers in [0, 1), multiples of 2^-53.
  pure subroutine uniforms(seed, i, j, u)
    integer(i8), intent(in) :: seed           !< key
    integer(i8), intent(in) :: i(:), j(:)     !< counters; the lower 32 bits of each count
    real(dp), intent(out) :: u(:)             !< numbers, one for each counter
    integer(i8), dimension(128) :: a, b
    integer :: k, n
    do k = 1, size(u), size(a)
      n = min(size(a), size(u) - k + 1)
      a(:n) = iand(i(k:k + n - 1), mask)
      b(:n) = iand(j(k:k + n - 1), mask)
      call threefry(a(:n), b(:n), [iand(seed, mask), iand(ishft(seed, -32), mask)])
      u(k:k + n - 1) = (real(a(:n), dp) * 2097152._dp + real(ishft(b(:n), -11), dp)) * 2._dp**(-53)
    end do
  end subroutine uniforms

  !> Counters to random words under a key.
  pure subroutine threefry(a, b, key)
    integer(i8), intent(inout), contiguous :: a(:), b(:)    !< first and second words of 32 bits
    integer(i8), intent(in) :: key(2)                       !< words of 32 bits
    integer(i8) :: schedule(0:2)
    integer :: round, k
    schedule(0) = key(1)
    schedule(1) = key(2)
    schedule(2) = ieor(ieor(int(z'1BD11BDA', i8), key(1)), key(2))
    a = iand(a + key(1), mask)
    b = iand(b + key(2), mask)
    do round = 1, 20
      k = turns(mod(round - 1, 8) + 1)
      a = iand(a + b, mask)
      b = ieor(iand(ior(shiftl(b, k), shiftr(b, 32 - k)), mask), a)
      if (mod(round, 4) == 0) then
        k = round / 4
        a = iand(a + schedule(mod(k, 3)), mask)
        b = iand(b + schedule(mod(k + 1, 3)) + k, mask)
      end if
    end do
  end subroutine threefry
end module hd_random
