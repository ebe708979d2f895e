! SPDX-License-Identifier: GPL-3.0-or-later
!> Counter-based random numbers: Threefry-2x32, 20 rounds (Salmon et al. 2011, SC11, doi 10.1145/2063384.2063405).
!>
!> The number depends on (seed, i, j) alone, never on the order of calls or the thread, and is the same on every platform: words
!> are 32 bits, kept in 64-bit integers.
module hd_random
  use, intrinsic :: iso_c_binding, only: c_int, c_int64_t
  use hd_kinds, only: dp, i8
  implicit none
  private
  public :: uniforms, threefry

  integer(i8), parameter :: mask = 4294967295_i8

  interface
    !> Counters to random words of 32 bits under a key.
    pure subroutine threefry(n, a, b, key) bind(c, name='hd_threefry')
      import :: c_int, c_int64_t
      integer(c_int), value, intent(in) :: n              !< counters
      integer(c_int64_t), intent(inout) :: a(*), b(*)     !< first and second words
      integer(c_int64_t), intent(in) :: key(2)            !< words
    end subroutine threefry
  end interface

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
      call threefry(n, a, b, [iand(seed, mask), iand(ishft(seed, -32), mask)])
      u(k:k + n - 1) = (real(a(:n), dp) * 2097152._dp + real(ishft(b(:n), -11), dp)) * 2._dp**(-53)
    end do
  end subroutine uniforms
end module hd_random
