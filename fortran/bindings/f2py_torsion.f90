! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat entries for Python: weights of K_N and K_T in Eq. 45 (hd_torsion), which cannot fail.
module f2py_torsion
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_torsion, only: facet_weights, printed_weights
  implicit none
  private
  public :: torsion_weights, torsion_weights_printed

contains

  !> Eq. 45 put right.
  subroutine torsion_weights(x, normal, n, w_n, w_t)
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: x(3, n), normal(3, n)
    real(c_double), intent(out) :: w_n(n), w_t(n)
    !f2py integer(c_int), intent(hide), depend(x) :: n = shape(x, 1)
    call facet_weights(x, normal, w_n, w_t)
  end subroutine torsion_weights

  !> Eq. 45 as printed.
  subroutine torsion_weights_printed(theta, r, w, slope, n, w_n, w_t)
    integer(c_int), intent(in) :: n
    real(c_double), intent(in) :: theta(n), r, w, slope
    real(c_double), intent(out) :: w_n(n), w_t(n)
    !f2py integer(c_int), intent(hide), depend(theta) :: n = len(theta)
    call printed_weights(theta, r, w, slope, w_n, w_t)
  end subroutine torsion_weights_printed
end module f2py_torsion
