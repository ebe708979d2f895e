! SPDX-License-Identifier: GPL-3.0-or-later
!> Slices of the factors of a matrix product that BLAS sums without rounding, and so in any order to the same bits (Ozaki, Ogita,
!> Oishi and Rump 2012, Numer. Algorithms 59, 95-118).
!>
!> A factor is x = x_1 + x_2 + a rest, each slice of whole multiples of its quantum. In a sum over k of x(k) y(k) the quanta are
!> such that all x_1 y_1 are multiples of one number q, all x_1 y_2 and x_2 y_1 of one smaller number, and that the sums of their
!> sizes stay below 2^53 of it: every product and partial sum is a double. With |x(k)| <= 1 and |y(k)| <= b(k) quanta of 2^-p(k)
!> and q 2^p(k), 2^p(k) = sqrt(b(k) / q), lose least. They follow from the b(k) alone. Long sums are taken in blocks.
module hd_slices
  use hd_kinds, only: dp, i8
  implicit none
  private
  public :: slices_t, new_slices, split

  !> Blocks of the sum, and the quanta of both slices.
  type :: slices_t
    integer, allocatable :: first(:)     !< terms of block b: first(b) .. first(b + 1) - 1
    real(dp), allocatable :: x(:, :)     !< quanta of x_1, x_2 (2, terms)
    real(dp), allocatable :: y(:, :)     !< quanta of y_1, y_2 (2, terms)
  end type slices_t

  integer, parameter :: longest = 84                     !< terms of a block
  real(dp), parameter :: margin = 1 + 2._dp**(-10)       !< for what is rounded up
  real(dp), parameter :: least = 2._dp**(-300)           !< smaller sums have the quanta of this one

contains

  !> Quanta for bounds of the second factor.
  pure type(slices_t) function new_slices(bound) result(s)
    real(dp), intent(in) :: bound(:)     !< b
    integer :: b, blocks
    blocks = (size(bound) - 1) / longest + 1
    allocate (s%first(blocks + 1), s%x(2, size(bound)), s%y(2, size(bound)))
    s%first(1) = 1
    do b = 1, blocks
      s%first(b + 1) = 1 + int(b * int(size(bound), i8) / blocks)
      associate (i => s%first(b), j => s%first(b + 1) - 1)
        call block_quanta(bound(i:j), s%x(:, i:j), s%y(:, i:j))
      end associate
    end do
  end function new_slices

  !> Quanta of one block.
  pure subroutine block_quanta(bound, x, y)
    real(dp), intent(in) :: bound(:)     !< b
    real(dp), intent(out) :: x(:, :)     !< quanta of x_1, x_2
    real(dp), intent(out) :: y(:, :)     !< quanta of y_1, y_2
    real(dp) :: q, q_2, cross
    integer :: k
    q = quantum(sum(bound))
    cross = 0
    do k = 1, size(bound)
      y(1, k) = q * 2._dp**max(0, exponent(bound(k) / q) / 2)
      x(1, k) = q / y(1, k)
      cross = cross + y(1, k) / 2 + x(1, k) / 2 * (bound(k) + y(1, k) / 2)
    end do
    q_2 = quantum(cross)
    y(2, :) = q_2 / x(1, :)
    x(2, :) = q_2 / y(1, :)
  end subroutine block_quanta

  !> Power of two of which sums up to a size have less than 2^53.
  elemental real(dp) function quantum(size)
    real(dp), intent(in) :: size     !< bound of the sums
    quantum = scale(1._dp, exponent(margin * max(size, least)) - 53)
  end function quantum

  !> The slices of x: adding and taking off 1.5 2^52 quanta rounds to whole ones.
  pure subroutine split(x, quanta, x_1, x_2)
    real(dp), intent(in), contiguous :: x(:)                 !< numbers, below 2^51 quanta
    real(dp), intent(in) :: quanta(2)                        !< powers of two
    real(dp), intent(out), contiguous :: x_1(:), x_2(:)      !< slices
    real(dp) :: shift(2)
    integer :: i
    shift = 6755399441055744._dp * quanta
    do i = 1, size(x)
      x_1(i) = (x(i) + shift(1)) - shift(1)
      x_2(i) = ((x(i) - x_1(i)) + shift(2)) - shift(2)
    end do
  end subroutine split
end module hd_slices
