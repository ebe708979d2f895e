! SPDX-License-Identifier: GPL-3.0-or-later
!> Powers and their integrals without cancellation.
module hd_powers
  use, intrinsic :: iso_c_binding, only: c_double
  use hd_kinds, only: dp
  implicit none
  private
  public :: expm1, log1p, power_partial

  interface
    !> exp(x) - 1 of the C library.
    pure real(c_double) function expm1(x) bind(c, name='expm1')
      import :: c_double
      real(c_double), intent(in), value :: x
    end function expm1
    !> log(1 + x) of the C library.
    pure real(c_double) function log1p(x) bind(c, name='log1p')
      import :: c_double
      real(c_double), intent(in), value :: x
    end function log1p
  end interface

contains

  !> int_0^l exp(e t) dt.
  pure real(dp) function power_partial(l, e) result(f)
    real(dp), intent(in) :: l, e
    f = l
    if (abs(e*l) > tiny(e)) f = expm1(e*l)/e
  end function power_partial
end module hd_powers
