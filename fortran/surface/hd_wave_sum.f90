! SPDX-License-Identifier: GPL-3.0-or-later
!> Statistics of the structure function of a finite map of a sum of plane waves with random phases (Eq. 1): its expectation and
!> its covariance over the phases, exact, with the plane taken off or not. With the origin in the middle of the map every
!> product of two waves averages to real sine ratios, so no simulation is needed.
module hd_wave_sum
  use hd_kinds, only: dp, pi
  use hd_observation, only: observation_t
  implicit none
  private
  public :: ridges_t, wave_numbers, levels_of, wave_expectation, wave_covariance

  !> The sum of Eq. 1: M ridges, frequencies gamma^n / L, n = 0..n_max.
  type :: ridges_t
    real(dp) :: gamma = 1.5_dp      !< frequency ratio
    integer :: count = 10           !< M
    integer :: n_max = 0            !< highest index
    real(dp) :: length = 0          !< L [m]
  end type ridges_t

contains

  !> Wave numbers of all waves, n running first [1/m].
  pure subroutine wave_numbers(r, qx, qy)
    type(ridges_t), intent(in) :: r                       !< the sum
    real(dp), allocatable, intent(out) :: qx(:), qy(:)    !< (M (n_max + 1))
    integer :: m, n, j
    real(dp) :: q, angle
    allocate (qx(r%count * (r%n_max + 1)), qy(r%count * (r%n_max + 1)))
    j = 0
    do m = 1, r%count
      angle = pi * m / r%count
      do n = 0, r%n_max
        j = j + 1
        q = 2 * pi * r%gamma**n / r%length
        qx(j) = q * cos(angle)
        qy(j) = q * sin(angle)
      end do
    end do
  end subroutine wave_numbers

  !> Squares of the amplitudes per G^(2(D-2)), one per n and ridge: ln gamma (L / gamma^n)^(2(3-D)) / M [m^a].
  pure function levels_of(r, d) result(a2)
    type(ridges_t), intent(in) :: r   !< the sum
    real(dp), intent(in) :: d         !< fractal dimension D
    real(dp) :: a2(r%n_max + 1)
    integer :: n
    a2 = [(log(r%gamma) / r%count * (r%length / r%gamma**n)**(6 - 2 * d), n=0, r%n_max)]
  end function levels_of

  !> sin(n q/2) / (n sin(q/2)), the mean of exp(i q x) over n points about 0.
  elemental real(dp) function ratio(q, n) result(r)
    real(dp), intent(in) :: q   !< phase per point
    integer, intent(in) :: n    !< points
    real(dp) :: s
    s = sin(q / 2)
    if (abs(s) > 1e-9_dp) then
      r = sin(n * q / 2) / (n * s)
    else
      r = cos(n * q / 2) / cos(q / 2)
    end if
  end function ratio

  !> Slope of the least-squares line through sin(q x), per point, times i.
  elemental real(dp) function slope(q, n) result(b)
    real(dp), intent(in) :: q   !< phase per point
    integer, intent(in) :: n    !< points
    real(dp) :: s, xx
    s = sin(q / 2)
    xx = real(n, dp) * (real(n, dp)**2 - 1) / 12
    if (abs(n * q) < 1e-2_dp) then
      b = q * (1 - q**2 * (3 * real(n, dp)**2 - 7) / 120)
    else if (abs(s) > 1e-9_dp) then
      b = -(0.5_dp * n * cos(n * q / 2) * s - 0.5_dp * sin(n * q / 2) * cos(q / 2)) / s**2 / xx
    else
      b = 0
    end if
  end function slope

  !> What one wave of unit amplitude adds to S at each lag, over its phase.
  subroutine wave_expectation(o, qx, qy, s)
    type(observation_t), intent(in) :: o    !< geometry and lags
    real(dp), intent(in) :: qx, qy          !< wave number [1/m]
    real(dp), intent(out) :: s(:)           !< expectation per amplitude squared, size of o%lag
    real(dp) :: u, v, b, m
    integer :: i, k
    u = qx * o%dx
    v = qy * o%dy
    do i = 1, size(s)
      k = o%lag(i)
      s(i) = 0
      if (o%share(1, i) > 0) then
        b = merge(slope(u, o%nx) * ratio(v, o%ny), 0._dp, o%levelled)
        m = 2 * sin(u * k / 2) * ratio(u, o%nx - k) * ratio(v, o%ny)
        s(i) = s(i) + o%share(1, i) * (2 * sin(u * k / 2)**2 - k * b * m + 0.5_dp * (k * b)**2)
      end if
      if (o%share(2, i) > 0) then
        b = merge(slope(v, o%ny) * ratio(u, o%nx), 0._dp, o%levelled)
        m = 2 * sin(v * k / 2) * ratio(v, o%ny - k) * ratio(u, o%nx)
        s(i) = s(i) + o%share(2, i) * (2 * sin(v * k / 2)**2 - k * b * m + 0.5_dp * (k * b)**2)
      end if
    end do
  end subroutine wave_expectation

  !> Covariance of S over random phases.
  subroutine wave_covariance(o, qx, qy, a2, cov)
    type(observation_t), intent(in) :: o    !< geometry and lags
    real(dp), intent(in) :: qx(:), qy(:)    !< wave numbers (waves) [1/m]
    real(dp), intent(in) :: a2(:)           !< squares of the amplitudes (waves) [m^2]
    real(dp), intent(out) :: cov(:, :)      !< covariance (n, n) [m^4]
    real(dp), allocatable :: terms(:, :), part(:, :, :)
    real(dp) :: scale
    integer :: i, n
    n = size(o%lag)
    scale = sum(a2)
    allocate (part(n, n, size(a2)))
    !$omp parallel private(terms)
    allocate (terms(n, 2 * size(a2)))
    !$omp do schedule(dynamic, 4)
    do i = 1, size(a2)
      call pair_terms(o, qx, qy, a2 / scale, i, terms)
      part(:, :, i) = matmul(terms, transpose(terms))
    end do
    !$omp end parallel
    cov = 0.5_dp * sum(part, 3) * scale**2
  end subroutine wave_covariance

  !> Products of wave i with itself and all later ones: columns of P and R, weighted.
  subroutine pair_terms(o, qx, qy, a2, i, terms)
    type(observation_t), intent(in) :: o          !< geometry and lags
    real(dp), intent(in) :: qx(:), qy(:), a2(:)   !< waves
    integer, intent(in) :: i                      !< first wave
    real(dp), intent(out) :: terms(:, :)          !< (n, 2 waves)
    real(dp) :: minus(size(o%lag)), plus(size(o%lag)), m(size(o%lag)), p(size(o%lag)), weight
    integer :: j
    terms = 0
    do j = i, size(a2)
      minus = 0
      plus = 0
      if (any(o%share(1, :) > 0)) then
        call line_product(o%lag, o%nx, o%ny, qx([i, j]) * o%dx, qy([i, j]) * o%dy, o%levelled, m, p)
        minus = o%share(1, :) * m
        plus = o%share(1, :) * p
      end if
      if (any(o%share(2, :) > 0)) then
        call line_product(o%lag, o%ny, o%nx, qy([i, j]) * o%dy, qx([i, j]) * o%dx, o%levelled, m, p)
        minus = minus + o%share(2, :) * m
        plus = plus + o%share(2, :) * p
      end if
      weight = sqrt(a2(i) * a2(j))
      if (j > i) then
        terms(:, j) = weight * minus
        terms(:, size(a2) + j) = weight * plus
      else
        terms(:, size(a2) + j) = 0.5_dp * weight * plus
      end if
    end do
  end subroutine pair_terms

  !> Mean products of the increments of two waves along lines of n points in w rows: difference and sum of their phases.
  pure subroutine line_product(lag, n, w, u, v, levelled, minus, plus)
    integer, intent(in) :: lag(:), n, w         !< lags; points along and across
    real(dp), intent(in) :: u(2), v(2)          !< phases per point along and across
    logical, intent(in) :: levelled             !< a plane was taken off
    real(dp), intent(out) :: minus(:), plus(:)  !< means at each lag
    real(dp) :: b(2), m(2), across(2), both, s, c, level
    integer :: i, k
    across(1) = ratio(v(1) - v(2), w)
    across(2) = ratio(v(1) + v(2), w)
    b = 0
    if (levelled) b = slope(u, n) * ratio(v, w)
    do i = 1, size(lag)
      k = lag(i)
      s = sin(u(1) * k / 2)
      c = sin(u(2) * k / 2)
      both = 4 * s * c
      level = 0
      if (levelled) then
        m = 2 * [s, c] * ratio(u, n - k) * ratio(v, w)
        level = -k * (b(2) * m(1) + b(1) * m(2)) + real(k, dp)**2 * b(1) * b(2)
      end if
      minus(i) = both * across(1) * ratio(u(1) - u(2), n - k) + level
      plus(i) = -(both * across(2) * ratio(u(1) + u(2), n - k) + level)
    end do
  end subroutine line_product
end module hd_wave_sum
