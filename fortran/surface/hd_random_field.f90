! SPDX-License-Identifier: GPL-3.0-or-later
!> Covariance of the structure function of a finite map of an isotropic Gaussian random field, and what white noise adds to it.
!> Increments over k and l at a distance r have covariance c = (S(r+l) + S(r-k) - S(r) - S(r+l-k))/2, hence
!> Cov[S(k), S(l)] = 2 mean c^2 over all pairs of places. Places are summed one by one near the origin and on coarser and coarser
!> rings outside, where c is smooth.
module hd_random_field
  use hd_kinds, only: dp
  use hd_observation, only: observation_t
  use hd_band_integral, only: band_integral
  implicit none
  private
  public :: field_covariance, noise_covariance, radial_t, new_radial, radial_value

  integer, parameter :: nodes = 1500

  !> S as a function of distance: values at equidistant ln r, cubic between.
  type :: radial_t
    real(dp) :: ln_first = 0, step = 0      !< first ln r and step
    real(dp), allocatable :: v(:)           !< S [m^2]
  end type radial_t

contains

  !> Tabulate S of a band between two distances.
  function new_radial(kind, d, scale, f_lo, f_hi, near, far) result(t)
    integer, intent(in) :: kind               !< kind of band_integral
    real(dp), intent(in) :: d, scale          !< D and factor G^(2(D-2)) [m^2 per m^a]
    real(dp), intent(in) :: f_lo, f_hi        !< band [1/m]
    real(dp), intent(in) :: near, far         !< distances [m]
    type(radial_t) :: t
    integer :: i
    t%ln_first = log(near) - 2e-2_dp
    t%step = (log(far) + 2e-2_dp - t%ln_first) / (nodes - 1)
    allocate (t%v(nodes))
    !$omp parallel do
    do i = 1, nodes
      t%v(i) = scale * band_integral(kind, d, exp(t%ln_first + (i - 1) * t%step), f_lo, f_hi)
    end do
  end function new_radial

  !> S at the square of a distance, 0 at 0.
  elemental real(dp) function radial_value(t, r2) result(s)
    type(radial_t), intent(in) :: t   !< table
    real(dp), intent(in) :: r2        !< square of the distance [m^2]
    real(dp) :: x
    integer :: i
    s = 0
    if (r2 <= 0) return
    x = (0.5_dp * log(r2) - t%ln_first) / t%step
    i = min(max(int(x), 1), nodes - 3)
    x = x - i
    s = t%v(i) * (-x * (x - 1) * (x - 2) / 6) + t%v(i + 1) * ((x + 1) * (x - 1) * (x - 2) / 2) &
      + t%v(i + 2) * (-(x + 1) * x * (x - 2) / 2) + t%v(i + 3) * ((x + 1) * x * (x - 1) / 6)
  end function radial_value

  !> Covariance of the observed S (n, n) [m^4].
  subroutine field_covariance(o, t, cov)
    type(observation_t), intent(in) :: o    !< geometry and lags
    type(radial_t), intent(in) :: t         !< S over distance
    real(dp), intent(out) :: cov(:, :)      !< covariance [m^4]
    integer, allocatable :: rx(:), ry(:), cell(:)
    real(dp), allocatable :: part(:, :, :), grid(:, :)
    integer, parameter :: blocks = 64
    integer :: b, i, j, mx, my
    call places(o, rx, ry, cell)
    mx = o%nx + maxval(o%lag)
    my = o%ny + maxval(o%lag)
    if (real(mx, dp) * my < 4e6_dp) then        ! S at every displacement; of larger maps only few are visited
      allocate (grid(0:mx, 0:my))
      !$omp parallel do
      do j = 0, my
        grid(:, j) = radial_value(t, [((i * o%dx)**2 + (j * o%dy)**2, i=0, mx)])
      end do
    end if
    allocate (part(size(cov, 1), size(cov, 1), blocks), source=0._dp)
    !$omp parallel do private(i) schedule(dynamic)
    do b = 1, blocks
      do i = b, size(rx), blocks
        call add_place(o, t, grid, rx(i), ry(i), cell(i), part(:, :, b))
      end do
    end do
    cov = 2 * sum(part, 3)
    cov = 0.5_dp * (cov + transpose(cov))
  end subroutine field_covariance

  !> Displacements to visit and the number of places each stands for.
  subroutine places(o, rx, ry, cell)
    type(observation_t), intent(in) :: o                      !< geometry and lags
    integer, allocatable, intent(out) :: rx(:), ry(:), cell(:)!< displacements in points, places
    integer :: reach, step, far, outer, x, y, n, pass
    reach = maxval(o%lag)
    if (o%ny == 1) reach = o%nx
    far = max(o%nx, o%ny)
    do pass = 1, 2
      n = 0
      step = 1
      outer = reach
      do
        do y = -(min(outer, o%ny - 1) / step) * step, min(outer, o%ny - 1), step
          do x = -(min(outer, o%nx - 1) / step) * step, min(outer, o%nx - 1), step
            if (step > 1 .and. max(abs(x), abs(y)) <= outer / 2) cycle
            n = n + 1
            if (pass == 2) then
              rx(n) = x
              ry(n) = y
              cell(n) = step * min(step, o%ny)
            end if
          end do
        end do
        if (outer >= far) exit
        outer = 2 * outer
        step = max(2, outer / 20, merge(outer / 10, 0, outer > 2 * reach))
      end do
      if (pass == 1) allocate (rx(n), ry(n), cell(n))
    end do
  end subroutine places

  !> Add one displacement to all pairs of lags.
  subroutine add_place(o, t, grid, rx, ry, cell, part)
    type(observation_t), intent(in) :: o        !< geometry and lags
    type(radial_t), intent(in) :: t             !< S over distance
    real(dp), allocatable, intent(in) :: grid(:, :) !< S at displacements (0:, 0:), if it was worth it
    integer, intent(in) :: rx, ry, cell         !< displacement, places it stands for
    real(dp), intent(inout) :: part(:, :)       !< sum of c^2 [m^4]
    real(dp) :: s0, w, c, sx(-maxval(o%lag):maxval(o%lag)), sy(-maxval(o%lag):maxval(o%lag))
    integer :: i, j, k, l, top
    top = maxval(o%lag)
    s0 = value_at(rx, ry)
    do i = -top, top
      sx(i) = value_at(rx + i, ry)
      sy(i) = value_at(rx, ry + i)
    end do
    do j = 1, size(o%lag)
      l = o%lag(j)
      do i = 1, size(o%lag)
        k = o%lag(i)
        if (o%share(1, i) * o%share(1, j) > 0) then
          w = overlap(rx, o%nx - k, o%nx - l) * overlap(ry, o%ny, o%ny) * cell
          c = 0.5_dp * (sx(l) + sx(-k) - s0 - sx(l - k))
          part(i, j) = part(i, j) + o%share(1, i) * o%share(1, j) * w * c**2
        end if
        if (o%share(2, i) * o%share(2, j) > 0) then
          w = overlap(rx, o%nx, o%nx) * overlap(ry, o%ny - k, o%ny - l) * cell
          c = 0.5_dp * (sy(l) + sy(-k) - s0 - sy(l - k))
          part(i, j) = part(i, j) + o%share(2, i) * o%share(2, j) * w * c**2
        end if
        if (o%share(1, i) * o%share(2, j) > 0) then      ! columns with rows: the same at -r, with i and j exchanged
          w = 2 * overlap(rx, o%nx - k, o%nx) * overlap(ry, o%ny, o%ny - l) * cell
          c = 0.5_dp * (sy(l) + sx(-k) - s0 - value_at(rx - k, ry + l))
          part(i, j) = part(i, j) + o%share(1, i) * o%share(2, j) * w * c**2
        end if
      end do
    end do
  contains
    real(dp) function value_at(x, y)
      integer, intent(in) :: x, y   !< displacement
      if (allocated(grid)) then
        value_at = grid(abs(x), abs(y))
      else
        value_at = radial_value(t, (x * o%dx)**2 + (y * o%dy)**2)
      end if
    end function value_at
  end subroutine add_place

  !> Share of the pairs of places of two windows of a and b points that lie r apart.
  elemental real(dp) function overlap(r, a, b) result(w)
    integer, intent(in) :: r, a, b    !< displacement, window lengths
    w = max(0, min(a, b - r) - max(0, -r)) / (real(a, dp) * b)
  end function overlap

  !> What white noise of a variance adds to the covariance of S, on top of a surface: 2 (2 c_s c_n + c_n^2) where c_n is not 0.
  subroutine noise_covariance(o, t, variance, cov)
    type(observation_t), intent(in) :: o    !< geometry and lags
    type(radial_t), intent(in) :: t         !< S over distance, without noise
    real(dp), intent(in) :: variance        !< noise [m^2]
    real(dp), intent(inout) :: cov(:, :)    !< covariance [m^4], added to
    integer :: i, j, a, b
    if (variance <= 0) return
    do j = 1, size(o%lag)
      do i = 1, size(o%lag)
        do b = 1, 2
          do a = 1, 2
            if (o%share(a, i) * o%share(b, j) > 0) cov(i, j) = cov(i, j) + 2 * o%share(a, i) * o%share(b, j) &
              * noise_pair(o, t, variance, vector(o%lag(i), a), vector(o%lag(j), b))
          end do
        end do
      end do
    end do
  contains
    pure function vector(lag, axis) result(v)
      integer, intent(in) :: lag, axis    !< lag along an axis
      integer :: v(2)
      v = 0
      v(axis) = lag
    end function vector
  end subroutine noise_covariance

  !> Sum of 2 c_s c_n + c_n^2 over displacements, for increments over k and l.
  pure real(dp) function noise_pair(o, t, variance, k, l) result(total)
    type(observation_t), intent(in) :: o      !< geometry
    type(radial_t), intent(in) :: t           !< S over distance
    real(dp), intent(in) :: variance          !< noise [m^2]
    integer, intent(in) :: k(2), l(2)         !< lag vectors
    integer :: r(2, 4), i, j
    real(dp) :: cn, cs, w, weight(4)
    r(:, 1) = 0
    r(:, 2) = k - l
    r(:, 3) = -l
    r(:, 4) = k
    weight = [1, 1, -1, -1]
    total = 0
    do i = 1, 4
      if (any([(all(r(:, j) == r(:, i)), j=1, i - 1)])) cycle
      cn = variance * sum(weight, mask=[(all(r(:, j) == r(:, i)), j=1, 4)])
      cs = 0.5_dp * (s_of(r(:, i) + l) + s_of(r(:, i) - k) - s_of(r(:, i)) - s_of(r(:, i) + l - k))
      w = overlap(r(1, i), o%nx - k(1), o%nx - l(1)) * overlap(r(2, i), o%ny - k(2), o%ny - l(2))
      total = total + w * (2 * cs * cn + cn**2)
    end do
  contains
    pure real(dp) function s_of(v)
      integer, intent(in) :: v(2)     !< displacement
      s_of = radial_value(t, (v(1) * o%dx)**2 + (v(2) * o%dy)**2)
    end function s_of
  end function noise_pair
end module hd_random_field
