! SPDX-License-Identifier: GPL-3.0-or-later
!> Tests of the Gauss rules.
module test_gauss
  use hd_check, only: check_close
  use hd_gauss, only: gauss_2, gauss_3, weight_3, gauss_4, weight_4, gauss_8, weight_8, gauss_rule
  use hd_kinds, only: dp
  use hd_text, only: to_text
  implicit none
  private
  public :: run_gauss

contains

  !> Every check.
  subroutine run_gauss()
    real(dp) :: x(12), w(12)
    call exact(gauss_2, [1._dp, 1._dp])
    call exact(gauss_3, weight_3)
    call exact(gauss_4, weight_4)
    call exact(gauss_8, weight_8)
    call gauss_rule(x, w)
    call exact(2*x - 1, 2*w)
  end subroutine run_gauss

  !> Powers up to 2 n - 1.
  subroutine exact(x, w)
    real(dp), intent(in) :: x(:), w(:)  !< points, weights
    integer :: k
    do k = 0, 2*size(x) - 1
      call check_close(sum(w*x**k), merge(2._dp/(k + 1), 0._dp, mod(k, 2) == 0), 2e-15_dp, &
        'a Gauss rule of '//to_text(size(x))//' points integrates x^'//to_text(k))
    end do
  end subroutine exact
end module test_gauss
