! SPDX-License-Identifier: GPL-3.0-or-later
!> Errors of a fit: what the model itself is off by, and intervals of estimates beside one that cannot be negative.
module hd_uncertainty
  use hd_kinds, only: dp
  use hd_observation, only: observation_t
  implicit none
  private
  public :: identity, left_over, alike, unexplained, interval_95, error_of, in_95

  real(dp), parameter :: in_95 = 1.959964_dp    !< standard deviations each way that hold 95 % of a normal distribution
  real(dp), parameter :: ripple = 0.15_dp       !< of ln tau over which residuals are alike, see unexplained
  real(dp), parameter :: least_left = 0.02_dp   !< share of a residual that the fit leaves at least: the first lag is nearly met

contains

  !> 95 % interval of estimate i beside a variance (the third) that is not negative: all values that the likelihood ratio, at the
  !> most likely variance from 0 on, does not refuse. Its bounds are those of the free estimate where its variance is positive and
  !> those at variance 0 where not. For estimates far above 0, or without variance, 1.96 standard errors each way.
  pure function interval_95(u, c, i) result(x)
    real(dp), intent(in) :: u(3), c(3, 3)   !< free estimates, their covariance
    integer, intent(in) :: i                !< which, 1 or 2
    real(dp) :: x(2), q, away, reach
    integer :: k
    q = in_95**2
    away = 0                                ! of the free variance below 0, squared, in its standard errors
    if (c(3, 3) > 0 .and. u(3) < 0) away = u(3)**2 / c(3, 3)
    do k = 1, 2
      reach = (2 * k - 3) * sqrt(q + away)
      x(k) = u(i) + reach * sqrt(c(i, i))
      if (.not. c(3, 3) > 0) cycle
      if (u(3) + c(i, 3) / sqrt(c(i, i)) * reach >= 0) cycle
      reach = (2 * k - 3) * sqrt(max(0._dp, (q + away - u(3)**2 / c(3, 3)) * (c(i, i) - c(i, 3)**2 / c(3, 3))))
      x(k) = u(i) - c(i, 3) / c(3, 3) * u(3) + reach
    end do
  end function interval_95

  !> Standard error that a 95 % interval stands for.
  pure real(dp) function error_of(interval) result(error)
    real(dp), intent(in) :: interval(2)     !< low and high
    error = (interval(2) - interval(1)) / (2 * in_95)
  end function error_of

  !> Correlation of what a model is off by at two lags: over a range of ln tau.
  pure function alike(o, range) result(like)
    type(observation_t), intent(in) :: o    !< observation
    real(dp), intent(in) :: range           !< of ln tau
    real(dp) :: like(size(o%lag), size(o%lag))
    integer :: i
    do i = 1, size(o%lag)
      like(:, i) = exp(-0.5_dp * (log(o%tau / o%tau(i)) / range)**2)
    end do
  end function alike

  !> Covariance of ln S as the residuals show it, whatever the model is off by (sandwich form): products of residuals, each freed
  !> from the share that the fit took, correlated over 0.15 in ln tau - ripples of gamma = 1.5 change sign over 0.2 - and within a
  !> direction, for ripples of few ridges differ from one to the next.
  pure function unexplained(o, res, hat) result(cov)
    type(observation_t), intent(in) :: o              !< observation
    real(dp), intent(in) :: res(:), hat(:, :)         !< residuals of ln S, projection on residuals
    real(dp) :: cov(size(res), size(res)), seen(size(res))
    integer :: i, j
    seen = [(res(i) / sqrt(max(hat(i, i), least_left)), i=1, size(res))]
    cov = alike(o, ripple)
    do j = 1, size(res)
      do i = 1, size(res)
        cov(i, j) = cov(i, j) * seen(i) * seen(j) * merge(1, 0, any(o%share(:, i) * o%share(:, j) > 0))
      end do
    end do
  end function unexplained

  !> Unit matrix.
  pure function identity(n) result(a)
    integer, intent(in) :: n    !< size
    real(dp) :: a(n, n)
    integer :: i
    a = 0
    do i = 1, n
      a(i, i) = 1
    end do
  end function identity

  !> Mean weighted sum of squares of the residuals of data with a covariance.
  pure real(dp) function left_over(white, hat, cov)
    real(dp), intent(in) :: white(:, :), hat(:, :), cov(:, :)   !< whitening, projection on residuals, covariance
    real(dp) :: a(size(cov, 1), size(cov, 1))
    a = matmul(white, hat)
    left_over = sum(matmul(a, cov) * a)
  end function left_over
end module hd_uncertainty
