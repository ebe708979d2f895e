! SPDX-License-Identifier: GPL-3.0-or-later
!> Covariance of the structure function of a short profile against the sum over all pairs of places.
module test_random_field
  use hd_kinds, only: dp
  use hd_band_integral, only: band_integral, kind_profile
  use hd_check, only: check_close
  use hd_observation, only: observation_t
  use hd_random_field, only: field_covariance, new_radial, noise_covariance, radial_t
  implicit none
  private
  public :: run_random_field

  integer, parameter :: n = 12                                   !< points
  real(dp), parameter :: dx = 1e-6_dp, noise = 0.3_dp            !< spacing [m], variance of white noise [m^2]
  real(dp), parameter :: d = 2.4_dp, band(2) = [1e4_dp, 3e5_dp]  !< [1/m]

contains

  !> Without and with white noise.
  subroutine run_random_field()
    type(observation_t) :: o
    type(radial_t) :: t
    real(dp), dimension(3, 3) :: cov, exact
    real(dp) :: scale
    integer :: i, j
    scale = 1/band_integral(kind_profile, d, dx, band(1), band(2))
    o%nx = n
    o%ny = 1
    o%dx = dx
    o%dy = dx
    o%lag = [1, 2, 5]
    allocate (o%share(4, 3), source=0._dp)
    o%share(1, :) = 1
    t = new_radial(kind_profile, d, scale, band(1), band(2), dx, 3*n*dx)
    call field_covariance(o, t, cov)
    exact = reshape([((summed(o%lag(i), o%lag(j), 0._dp), i=1, 3), j=1, 3)], [3, 3])
    call check_close(maxval(abs(cov/exact - 1)), 0._dp, 1e-6_dp, 'sampling of S varies as the sum over all pairs of places says')
    call noise_covariance(o, t, noise, cov)
    exact = reshape([((summed(o%lag(i), o%lag(j), noise), i=1, 3), j=1, 3)], [3, 3])
    call check_close(maxval(abs(cov/exact - 1)), 0._dp, 1e-6_dp, 'white noise adds what that sum says')
  contains
    !> Covariance of S at two lags: twice the mean square of the covariance of two increments.
    real(dp) function summed(k, l, variance)
      integer, intent(in) :: k, l             !< lags
      real(dp), intent(in) :: variance        !< of the noise
      integer :: p, q
      real(dp) :: c
      summed = 0
      do p = 1, n - k
        do q = 1, n - l
          c = (s(q + l - p) + s(q - p - k) - s(q - p) - s(q + l - p - k))/2 + variance* &
            (count([q + l == p + k]) + count([q == p]) - count([q + l == p]) - count([q == p + k]))
          summed = summed + 2*c**2
        end do
      end do
      summed = summed/((n - k)*(n - l))
    end function summed

    !> Structure function at a distance.
    real(dp) function s(steps)
      integer, intent(in) :: steps            !< of either sign
      s = 0
      if (steps /= 0) s = scale*band_integral(kind_profile, d, abs(steps)*dx, band(1), band(2))
    end function s
  end subroutine run_random_field
end module test_random_field
