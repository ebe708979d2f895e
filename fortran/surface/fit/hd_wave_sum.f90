! SPDX-License-Identifier: GPL-3.0-or-later
!> Statistics of the structure function of a finite map of a sum of plane waves with random phases (Eq. 1): its expectation and
!> its covariance over the phases, exact, with the plane taken off or not. With the origin in the middle of the map every
!> product of two waves averages to real sine ratios, so no simulation is needed.
module hd_wave_sum
  use hd_kinds, only: dp, pi, hair
  use hd_lapack, only: multiply_transposed, blas_threads
  use hd_observation, only: observation_t, directions
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

  !> Waves over the pairs of one direction, per wave and entry that uses it.
  type :: pairs_t
    integer, allocatable :: pick(:)                       !< entries of the observation
    integer, allocatable :: nx(:), ny(:)                  !< places of the first point of a pair, along x and y
    real(dp), allocatable :: half(:, :)                   !< sin of half the phase over the lag
    real(dp), allocatable :: sx(:, :), cx(:, :), sy(:, :), cy(:, :)   !< sin and cos of nx u/2 and ny v/2
    real(dp), allocatable :: mean(:, :), tilt(:, :)       !< mean increment and that of the plane; 0 if not levelled
  end type pairs_t

  real(dp), parameter :: near_zero = 1e-2_dp  !< phase over a map up to which two terms of the series hold 1e-11
  real(dp), parameter :: divides = 1e-6_dp    !< sine that may be divided by: ten digits are left

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
    if (abs(s) > hair) then
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
    if (abs(n * q) < near_zero) then
      b = q * (1 - q**2 * (3 * real(n, dp)**2 - 7) / 120)
    else if (abs(s) > hair) then
      b = -(0.5_dp * n * cos(n * q / 2) * s - 0.5_dp * sin(n * q / 2) * cos(q / 2)) / s**2 / xx
    else
      b = 0
    end if
  end function slope

  !> Rise of the least-squares plane through a wave over a lag vector, times i.
  pure real(dp) function plane_rise(o, u, v, p, q) result(b)
    type(observation_t), intent(in) :: o    !< geometry
    real(dp), intent(in) :: u, v            !< phases per point
    integer, intent(in) :: p, q             !< lag vector
    b = 0
    if (.not. o%levelled) return
    if (p /= 0) b = p * slope(u, o%nx) * ratio(v, o%ny)
    if (q /= 0) b = b + q * slope(v, o%ny) * ratio(u, o%nx)
  end function plane_rise

  !> What one wave of unit amplitude adds to S at each lag, over its phase.
  pure subroutine wave_expectation(o, qx, qy, s)
    type(observation_t), intent(in) :: o    !< geometry and lags
    real(dp), intent(in) :: qx, qy          !< wave number [1/m]
    real(dp), intent(out) :: s(:)           !< expectation per amplitude squared, size of o%lag
    real(dp) :: u, v, b, m, half
    integer :: i, d, p, q
    u = qx * o%dx
    v = qy * o%dy
    do i = 1, size(s)
      s(i) = 0
      do d = 1, 4
        if (o%share(d, i) <= 0) cycle
        p = o%lag(i) * directions(1, d)
        q = o%lag(i) * directions(2, d)
        half = sin(0.5_dp * (p * u + q * v))
        b = plane_rise(o, u, v, p, q)
        m = 2 * half * ratio(u, o%nx - abs(p)) * ratio(v, o%ny - q)
        s(i) = s(i) + o%share(d, i) * (2 * half**2 - b * m + 0.5_dp * b**2)
      end do
    end do
  end subroutine wave_expectation

  !> Covariance of S over random phases.
  subroutine wave_covariance(o, qx, qy, a2, cov)
    type(observation_t), intent(in) :: o    !< geometry and lags
    real(dp), intent(in) :: qx(:), qy(:)    !< wave numbers (waves) [1/m]
    real(dp), intent(in) :: a2(:)           !< squares of the amplitudes (waves) [m^2]
    real(dp), intent(out) :: cov(:, :)      !< covariance (n, n) [m^4]
    real(dp), allocatable :: terms(:, :), part(:, :, :)
    type(pairs_t) :: t(4)
    real(dp) :: scale, u(size(qx)), v(size(qx))
    integer :: i, n, d, threads
    scale = sum(a2)
    u = qx * o%dx
    v = qy * o%dy
    do d = 1, 4
      t(d) = new_pairs(o, d, u, v)
    end do
    allocate (part(size(o%lag), size(o%lag), size(a2)))
    threads = blas_threads(1)
    !$omp parallel private(terms, n)
    allocate (terms(size(o%lag), 2 * size(a2)))
    !$omp do schedule(dynamic, 4)
    do i = 1, size(a2)
      call pair_terms(o, t, u, v, a2 / scale, i, terms)
      n = 2 * (size(a2) - i + 1)
      call multiply_transposed(terms(:, :n), terms(:, :n), part(:, :, i))
    end do
    !$omp end parallel
    threads = blas_threads(threads)
    cov = 0.5_dp * sum(part, 3) * scale**2
  end subroutine wave_covariance

  !> Per wave and entry, along direction d.
  function new_pairs(o, d, u, v) result(t)
    type(observation_t), intent(in) :: o      !< geometry and lags
    integer, intent(in) :: d                  !< direction
    real(dp), intent(in) :: u(:), v(:)        !< phases per point along x and y (waves)
    type(pairs_t) :: t
    integer :: i, j, p, q
    t%pick = pack([(i, i=1, size(o%lag))], o%share(d, :) > 0)
    t%nx = o%nx - o%lag(t%pick) * abs(directions(1, d))
    t%ny = o%ny - o%lag(t%pick) * directions(2, d)
    allocate (t%half(size(t%pick), size(u)), t%mean(size(t%pick), size(u)), t%tilt(size(t%pick), size(u)))
    do j = 1, size(u)
      do i = 1, size(t%pick)
        p = o%lag(t%pick(i)) * directions(1, d)
        q = o%lag(t%pick(i)) * directions(2, d)
        t%half(i, j) = sin(0.5_dp * (p * u(j) + q * v(j)))
        t%tilt(i, j) = plane_rise(o, u(j), v(j), p, q)
        t%mean(i, j) = 2 * t%half(i, j) * ratio(u(j), t%nx(i)) * ratio(v(j), t%ny(i))
      end do
    end do
    t%sx = sin(0.5_dp * spread(t%nx, 2, size(u)) * spread(u, 1, size(t%pick)))
    t%cx = cos(0.5_dp * spread(t%nx, 2, size(u)) * spread(u, 1, size(t%pick)))
    t%sy = sin(0.5_dp * spread(t%ny, 2, size(u)) * spread(v, 1, size(t%pick)))
    t%cy = cos(0.5_dp * spread(t%ny, 2, size(u)) * spread(v, 1, size(t%pick)))
  end function new_pairs

  !> Products of wave i with itself and all later ones: columns by the difference and by the sum of their phases in turn, weighted.
  subroutine pair_terms(o, t, u, v, a2, i, terms)
    type(observation_t), intent(in) :: o            !< geometry and lags
    type(pairs_t), intent(in) :: t(:)               !< waves along the directions
    real(dp), intent(in) :: u(:), v(:)              !< phases per point along x and y (waves)
    real(dp), intent(in) :: a2(:)                   !< squares of the amplitudes
    integer, intent(in) :: i                        !< first wave
    real(dp), intent(inout) :: terms(:, :)          !< (lags, 2 (waves - i + 1)) set
    real(dp), dimension(size(o%lag)) :: m, p, xm, xp, ym, yp
    real(dp) :: weight(2)
    integer :: j, d, k, l, e, n
    do j = i, size(a2)
      k = 2 * (j - i) + 1
      terms(:, k:k + 1) = 0
      weight = sqrt(a2(i) * a2(j))
      if (j == i) weight = [0._dp, 0.5_dp * weight(2)]
      do d = 1, size(t)
        n = size(t(d)%pick)
        if (n == 0) cycle
        call both(t(d)%sx(:, i), t(d)%cx(:, i), t(d)%sx(:, j), t(d)%cx(:, j), u(i), u(j), t(d)%nx, xm(:n), xp(:n))
        call both(t(d)%sy(:, i), t(d)%cy(:, i), t(d)%sy(:, j), t(d)%cy(:, j), v(i), v(j), t(d)%ny, ym(:n), yp(:n))
        call products(t(d)%half(:, i), t(d)%half(:, j), t(d)%tilt(:, i), t(d)%tilt(:, j), t(d)%mean(:, i), t(d)%mean(:, j), &
          xm(:n), xp(:n), ym(:n), yp(:n), m(:n), p(:n))
        do l = 1, n
          e = t(d)%pick(l)
          terms(e, k) = terms(e, k) + weight(1) * o%share(d, e) * m(l)
          terms(e, k + 1) = terms(e, k + 1) + weight(2) * o%share(d, e) * p(l)
        end do
      end do
    end do
  end subroutine pair_terms

  !> Mean products of the increments of two waves: by the difference and by the sum of their phases.
  pure subroutine products(half_1, half_2, tilt_1, tilt_2, mean_1, mean_2, xm, xp, ym, yp, minus, plus)
    real(dp), intent(in), contiguous, dimension(:) :: half_1, half_2, tilt_1, tilt_2, mean_1, mean_2  !< of the waves (entries)
    real(dp), intent(in), contiguous, dimension(:) :: xm, xp, ym, yp    !< ratios by difference and sum, along x and y
    real(dp), intent(out), contiguous :: minus(:), plus(:)              !< means (entries)
    real(dp) :: h, b
    integer :: k
    do k = 1, size(minus)
      h = 4 * half_1(k) * half_2(k)
      b = tilt_2(k) * mean_1(k) + tilt_1(k) * mean_2(k) - tilt_1(k) * tilt_2(k)
      minus(k) = h * xm(k) * ym(k) - b
      plus(k) = b - h * xp(k) * yp(k)
    end do
  end subroutine products

  !> ratio(q_1 - q_2, n) and ratio(q_1 + q_2, n) from sin and cos of n q/2.
  pure subroutine both(s_1, c_1, s_2, c_2, q_1, q_2, n, minus, plus)
    real(dp), intent(in), contiguous, dimension(:) :: s_1, c_1, s_2, c_2  !< sin and cos of n q_1/2, n q_2/2
    real(dp), intent(in) :: q_1, q_2                                      !< phases per point
    integer, intent(in), contiguous :: n(:)                               !< points
    real(dp), intent(out), contiguous :: minus(:), plus(:)                !< ratios
    real(dp) :: m, p
    integer :: k
    m = sin(0.5_dp * (q_1 - q_2))
    p = sin(0.5_dp * (q_1 + q_2))
    if (n(1) == n(size(n))) then                              ! the same along the whole direction
      minus = ratio(q_1 - q_2, n(1))
      plus = ratio(q_1 + q_2, n(1))
    else if (min(abs(m), abs(p)) > divides) then
      do k = 1, size(n)
        minus(k) = (s_1(k) * c_2(k) - c_1(k) * s_2(k)) / (n(k) * m)
        plus(k) = (s_1(k) * c_2(k) + c_1(k) * s_2(k)) / (n(k) * p)
      end do
    else
      minus = ratio(q_1 - q_2, n)
      plus = ratio(q_1 + q_2, n)
    end if
  end subroutine both
end module hd_wave_sum
