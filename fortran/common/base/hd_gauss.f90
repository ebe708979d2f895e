! SPDX-License-Identifier: GPL-3.0-or-later
!> Gauss-Legendre rules on (-1, 1), whose weights sum to 2: n points integrate polynomials of degree 2 n - 1.
module hd_gauss
  use hd_kinds, only: dp, pi
  implicit none
  private
  public :: gauss_2, gauss_3, weight_3, gauss_4, weight_4, gauss_8, weight_8, gauss_rule

  real(dp), parameter :: gauss_2(2) = 0.57735026918962576450914878050196_dp*[-1, 1]   !< both weights are 1
  real(dp), parameter :: gauss_3(3) = sqrt(0.6_dp)*[-1, 0, 1]
  real(dp), parameter :: weight_3(3) = [5, 8, 5]/9._dp
  real(dp), parameter :: gauss_4(4) = [-0.861136311594052575224_dp, -0.339981043584856264803_dp, 0.339981043584856264803_dp, &
    0.861136311594052575224_dp]
  real(dp), parameter :: weight_4(4) = [0.347854845137453857373_dp, 0.652145154862546142627_dp, 0.652145154862546142627_dp, &
    0.347854845137453857373_dp]
  real(dp), parameter :: gauss_8(8) = [-0.9602898564975363_dp, -0.7966664774136267_dp, -0.5255324099163290_dp, &
    -0.1834346424956498_dp, 0.1834346424956498_dp, 0.5255324099163290_dp, 0.7966664774136267_dp, 0.9602898564975363_dp]
  real(dp), parameter :: weight_8(8) = [0.1012285362903763_dp, 0.2223810344533745_dp, 0.3137066458778873_dp, &
    0.3626837833783620_dp, 0.3626837833783620_dp, 0.3137066458778873_dp, 0.2223810344533745_dp, 0.1012285362903763_dp]

contains

  !> Rule of any number of points on [0, 1], whose weights sum to 1, by Newton's method on the Legendre polynomial.
  pure subroutine gauss_rule(x, w)
    real(dp), intent(out) :: x(:), w(:)  !< points and weights
    real(dp) :: z, p0, p1, slope
    integer :: i, j, n
    n = size(x)
    do i = 1, n
      z = cos(pi*(i - 0.25_dp)/(n + 0.5_dp))
      do j = 1, 10
        call legendre(n, z, p1, p0)
        slope = n*(z*p1 - p0)/(z*z - 1)
        z = z - p1/slope
      end do
      x(i) = (1 - z)/2
      w(i) = 1/((1 - z*z)*slope**2)
    end do
  end subroutine gauss_rule

  !> Legendre polynomials of degree n and n - 1.
  pure subroutine legendre(n, z, p, previous)
    integer, intent(in) :: n
    real(dp), intent(in) :: z
    real(dp), intent(out) :: p, previous
    real(dp) :: next
    integer :: k
    p = 1
    previous = 0
    do k = 1, n
      next = ((2*k - 1)*z*p - (k - 1)*previous)/k
      previous = p
      p = next
    end do
  end subroutine legendre
end module hd_gauss
