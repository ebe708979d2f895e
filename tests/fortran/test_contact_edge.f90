! SPDX-License-Identifier: GPL-3.0-or-later
module test_contact_edge
  use hd_check, only: check, check_close
  use hd_contact_edge, only: softening
  use hd_kinds, only: dp
  implicit none
  private
  public :: run_contact_edge

contains

  !> Pressure that ends as the square root of the distance, given as means over cells: stiffness p^a against its integral where a is
  !> above 0. No mean exceeds the highest pressure of its cell, whatever a is.
  subroutine run_contact_edge()
    integer, parameter :: n = 12
    real(dp) :: z(n), p(n), f(n), a(n), end, soft
    real(dp), parameter :: powers(4) = [0.6_dp, 0.33_dp, -0.2_dp, -3e-3_dp]
    integer :: i, shift
    z = [(i*1._dp, i=1, n)]
    do shift = 1, 9
      end = 9.5_dp + 0.1_dp*shift
      a = powers(1 + modulo(shift, 4))
      p = cells(end - z)
      f = softening(z, p, a)
      call check(all(f > 0 .and. (f <= 1 .or. a < 0)) .and. all(abs(f(:8) - 1) < 1e-12_dp), &
        'only the last two nodes of contact change')
      soft = sum((f(9:10)*p(9:10))**a(1))
      if (a(1) > 0) call check_close(soft, (end - 8.5_dp)**(1 + a(1)/2)/(1 + a(1)/2), 1e-9_dp, 'stiffness of the last two cells')
      call check(all(f(9:10)*p(9:10) < (1 + 1e-9_dp)*sqrt(end - [8.5_dp, 9.5_dp])), &
        'no mean above the highest pressure of its cell')
      call check(a(1) < 0 .or. sum(p(9:10)**a(1)) > 1.004_dp*soft, 'mean pressures are too stiff')
      call check(all(abs(softening(-z(n:1:-1), p(n:1:-1), a) - f(n:1:-1)) < 1e-9_dp), 'both ends alike')
      call check(all(abs(softening(7*z - 2, 3*p, a) - f) < 1e-8_dp), 'in any units')
    end do
    call check(all(abs(softening(z, spread(1._dp, 1, n), a) - 1) < 1e-12_dp), 'no change where contact ends with the band')
    p = 0
    p(5) = 1
    call check(all(abs(softening(z, p, a) - 1) < 1e-12_dp), 'no change of a single node')
  end subroutine run_contact_edge

  !> Means of max(0, x)^(1/2) over cells of length 1 about nodes at a distance x before the end.
  pure function cells(x) result(p)
    real(dp), intent(in) :: x(:)  !< distances
    real(dp) :: p(size(x))
    p = (max(0._dp, x + 0.5_dp)**1.5_dp - max(0._dp, x - 0.5_dp)**1.5_dp)/1.5_dp
  end function cells
end module test_contact_edge
