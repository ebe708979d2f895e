! SPDX-License-Identifier: GPL-3.0-or-later
!> Rows of the plain product in C, in double and in single precision.
module hd_plain_rows
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_float
  implicit none
  private
  public :: factor_row, join_row

  !> even = a cos, odd = b sin of 2 pi (phase + step (high + low)).
  interface factor_row
    subroutine factor_row_double(n, phase, high, low, step, a, b, even, odd) bind(c, name='hd_factor_row')
      import :: c_int, c_double
      integer(c_int), value, intent(in) :: n                                      !< waves
      real(c_double), intent(in) :: phase(*), high(*), low(*), a(*), b(*)         !< turns, factors
      real(c_double), value, intent(in) :: step                                   !< steps
      real(c_double), intent(inout) :: even(*), odd(*)                            !< results
    end subroutine factor_row_double
    subroutine factor_row_single(n, phase, high, low, step, a, b, even, odd) bind(c, name='hd_factor_row_single')
      import :: c_int, c_double, c_float
      integer(c_int), value, intent(in) :: n                                      !< waves
      real(c_double), intent(in) :: phase(*), high(*), low(*), a(*), b(*)         !< turns, factors
      real(c_double), value, intent(in) :: step                                   !< steps
      real(c_float), intent(inout) :: even(*), odd(*)                             !< results
    end subroutine factor_row_single
  end interface factor_row

  !> z = offset + unit (even - odd) left, offset + unit (even + odd) right of the middle.
  interface join_row
    subroutine join_row_double(n, even, odd, offset, unit, z) bind(c, name='hd_join_row')
      import :: c_int, c_double
      integer(c_int), value, intent(in) :: n                                      !< points
      real(c_double), intent(in) :: even(*), odd(*)                               !< sums, from the middle on
      real(c_double), value, intent(in) :: offset, unit                           !< [m]
      real(c_double), intent(inout) :: z(*)                                       !< heights [m]
    end subroutine join_row_double
    subroutine join_row_single(n, even, odd, offset, unit, z) bind(c, name='hd_join_row_single')
      import :: c_int, c_double, c_float
      integer(c_int), value, intent(in) :: n                                      !< points
      real(c_float), intent(in) :: even(*), odd(*)                                !< sums, from the middle on
      real(c_double), value, intent(in) :: offset, unit                           !< [m]
      real(c_double), intent(inout) :: z(*)                                       !< heights [m]
    end subroutine join_row_single
    subroutine join_single_row_double(n, even, odd, offset, unit, z) bind(c, name='hd_join_single_row')
      import :: c_int, c_double, c_float
      integer(c_int), value, intent(in) :: n                                      !< points
      real(c_double), intent(in) :: even(*), odd(*)                               !< sums, from the middle on
      real(c_double), value, intent(in) :: offset, unit                           !< [m]
      real(c_float), intent(inout) :: z(*)                                        !< heights [m]
    end subroutine join_single_row_double
    subroutine join_single_row_single(n, even, odd, offset, unit, z) bind(c, name='hd_join_single_row_single')
      import :: c_int, c_double, c_float
      integer(c_int), value, intent(in) :: n                                      !< points
      real(c_float), intent(in) :: even(*), odd(*)                                !< sums, from the middle on
      real(c_double), value, intent(in) :: offset, unit                           !< [m]
      real(c_float), intent(inout) :: z(*)                                        !< heights [m]
    end subroutine join_single_row_single
  end interface join_row
end module hd_plain_rows
