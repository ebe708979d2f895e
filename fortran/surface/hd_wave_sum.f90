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

  !> Waves along lines of n points in w rows, per wave and lag.
  type :: line_t
    integer :: n = 0, w = 0
    real(dp), allocatable :: u(:), v(:)                   !< phases per point along and across
    integer, allocatable :: left(:)                       !< pairs in a line at each lag
    real(dp), allocatable :: half(:, :)                   !< sin(lag u/2)
    real(dp), allocatable :: sine(:, :), cosine(:, :)     !< of left u/2
    real(dp), allocatable :: mean(:, :), tilt(:, :)       !< mean increment and lag times slope; 0 if not levelled
  end type line_t

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
    type(line_t) :: rows, columns
    real(dp) :: scale
    integer :: i, n
    scale = sum(a2)
    rows = new_line(o%lag, o%nx, o%ny, qx * o%dx, qy * o%dy, o%levelled)
    columns = new_line(o%lag, o%ny, o%nx, qy * o%dy, qx * o%dx, o%levelled)
    allocate (part(size(o%lag), size(o%lag), size(a2)))
    !$omp parallel private(terms, n)
    allocate (terms(size(o%lag), 2 * size(a2)))
    !$omp do schedule(dynamic, 4)
    do i = 1, size(a2)
      call pair_terms(o, rows, columns, a2 / scale, i, terms)
      n = 2 * (size(a2) - i + 1)
      part(:, :, i) = matmul(terms(:, :n), transpose(terms(:, :n)))
    end do
    !$omp end parallel
    cov = 0.5_dp * sum(part, 3) * scale**2
  end subroutine wave_covariance

  !> Per wave and lag, along lines of n points in w rows.
  function new_line(lag, n, w, u, v, levelled) result(t)
    integer, intent(in) :: lag(:), n, w       !< lags; points along and across
    real(dp), intent(in) :: u(:), v(:)        !< phases per point along and across (waves)
    logical, intent(in) :: levelled           !< a plane was taken off
    type(line_t) :: t
    integer :: j
    t%n = n
    t%w = w
    t%u = u
    t%v = v
    t%left = n - lag
    allocate (t%half(size(lag), size(u)), t%sine(size(lag), size(u)), t%cosine(size(lag), size(u)))
    allocate (t%mean(size(lag), size(u)), t%tilt(size(lag), size(u)), source=0._dp)
    do j = 1, size(u)
      t%half(:, j) = sin(0.5_dp * lag * u(j))
      t%sine(:, j) = sin(0.5_dp * (n - lag) * u(j))
      t%cosine(:, j) = cos(0.5_dp * (n - lag) * u(j))
      if (.not. levelled) cycle
      t%mean(:, j) = 2 * t%half(:, j) * ratio(u(j), n - lag) * ratio(v(j), w)
      t%tilt(:, j) = lag * slope(u(j), n) * ratio(v(j), w)
    end do
  end function new_line

  !> Products of wave i with itself and all later ones: columns of P and R in turn, weighted.
  subroutine pair_terms(o, rows, columns, a2, i, terms)
    type(observation_t), intent(in) :: o            !< geometry and lags
    type(line_t), intent(in) :: rows, columns       !< waves along rows and along columns
    real(dp), intent(in) :: a2(:)                   !< squares of the amplitudes
    integer, intent(in) :: i                        !< first wave
    real(dp), intent(inout) :: terms(:, :)          !< (lags, 2 (waves - i + 1)) set
    real(dp) :: minus(size(o%lag)), plus(size(o%lag)), m(size(o%lag)), p(size(o%lag)), weight
    integer :: j
    do j = i, size(a2)
      minus = 0
      plus = 0
      if (any(o%share(1, :) > 0)) then
        call line_product(rows, i, j, m, p)
        minus = o%share(1, :) * m
        plus = o%share(1, :) * p
      end if
      if (any(o%share(2, :) > 0)) then
        call line_product(columns, i, j, m, p)
        minus = minus + o%share(2, :) * m
        plus = plus + o%share(2, :) * p
      end if
      weight = sqrt(a2(i) * a2(j))
      terms(:, 2 * (j - i) + 1) = merge(0._dp, weight, j == i) * minus
      terms(:, 2 * (j - i) + 2) = merge(0.5_dp, 1._dp, j == i) * weight * plus
    end do
  end subroutine pair_terms

  !> Mean products of the increments of two waves at each lag: by the difference and by the sum of their phases.
  pure subroutine line_product(t, i, j, minus, plus)
    type(line_t), intent(in) :: t               !< waves along a line
    integer, intent(in) :: i, j                 !< which two
    real(dp), intent(out) :: minus(:), plus(:)  !< means (lags)
    real(dp) :: s, across
    s = sin(0.5_dp * (t%u(i) - t%u(j)))
    across = 4 * ratio(t%v(i) - t%v(j), t%w)
    if (abs(s) > 1e-6_dp) then
      minus = (t%sine(:, i) * t%cosine(:, j) - t%cosine(:, i) * t%sine(:, j)) / (t%left * s)
    else
      minus = ratio(t%u(i) - t%u(j), t%left)
    end if
    minus = across * t%half(:, i) * t%half(:, j) * minus
    s = sin(0.5_dp * (t%u(i) + t%u(j)))
    across = 4 * ratio(t%v(i) + t%v(j), t%w)
    if (abs(s) > 1e-6_dp) then
      plus = (t%sine(:, i) * t%cosine(:, j) + t%cosine(:, i) * t%sine(:, j)) / (t%left * s)
    else
      plus = ratio(t%u(i) + t%u(j), t%left)
    end if
    plus = -across * t%half(:, i) * t%half(:, j) * plus
    minus = minus - t%tilt(:, j) * t%mean(:, i) - t%tilt(:, i) * t%mean(:, j) + t%tilt(:, i) * t%tilt(:, j)
    plus = plus + t%tilt(:, j) * t%mean(:, i) + t%tilt(:, i) * t%mean(:, j) - t%tilt(:, i) * t%tilt(:, j)
  end subroutine line_product
end module hd_wave_sum
