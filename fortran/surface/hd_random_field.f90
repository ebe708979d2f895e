! SPDX-License-Identifier: GPL-3.0-or-later
!> Covariance of the structure function of a finite map of an isotropic Gaussian random field, and what white noise adds to it.
!> Increments over k and l at a distance r have covariance c = (S(r+l) + S(r-k) - S(r) - S(r+l-k))/2, hence
!> Cov[S(k), S(l)] = 2 mean c^2 over all pairs of places. Places are summed one by one near the origin and on coarser and coarser
!> rings outside, where c is smooth.
module hd_random_field
  use hd_kinds, only: dp
  use hd_observation, only: observation_t, directions
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

  !> Add one displacement to all pairs of entries.
  subroutine add_place(o, t, grid, rx, ry, cell, part)
    type(observation_t), intent(in) :: o        !< geometry and lags
    type(radial_t), intent(in) :: t             !< S over distance
    real(dp), allocatable, intent(in) :: grid(:, :) !< S at displacements (0:, 0:), if it was worth it
    integer, intent(in) :: rx, ry, cell         !< displacement, places it stands for
    real(dp), intent(inout) :: part(:, :)       !< sum of c^2 [m^4]
    real(dp) :: s0, w, c, ahead(4, size(o%lag)), behind(4, size(o%lag))
    integer :: i, j, a, b, k(2), l(2)
    s0 = value_at(rx, ry)
    do j = 1, size(o%lag)
      do b = 1, 4
        if (o%share(b, j) <= 0) cycle
        l = o%lag(j) * directions(:, b)
        ahead(b, j) = value_at(rx + l(1), ry + l(2))
        behind(b, j) = value_at(rx - l(1), ry - l(2))
      end do
    end do
    do j = 1, size(o%lag)
      do b = 1, 4
        if (o%share(b, j) <= 0) cycle
        l = o%lag(j) * directions(:, b)
        do i = 1, size(o%lag)
          do a = 1, b                                     ! b with a: the same at -r, with i and j exchanged
            if (o%share(a, i) <= 0) cycle
            k = o%lag(i) * directions(:, a)
            w = overlap(rx, k(1), l(1), o%nx) * overlap(ry, k(2), l(2), o%ny) * cell
            if (w <= 0) cycle
            c = 0.5_dp * (ahead(b, j) + behind(a, i) - s0 - value_at(rx + l(1) - k(1), ry + l(2) - k(2)))
            part(i, j) = part(i, j) + merge(1, 2, a == b) * o%share(a, i) * o%share(b, j) * w * c**2
          end do
        end do
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

  !> Share of the pairs of places, r apart, of the first points of lags k and l along a line of n points.
  elemental real(dp) function overlap(r, k, l, n) result(w)
    integer, intent(in) :: r, k, l, n   !< displacement of the second from the first, lags, points
    integer :: low, high
    low = max(max(0, -k), max(0, -l) - r)
    high = min(n - max(0, k), n - max(0, l) - r)
    w = max(0, high - low) / (real(n - abs(k), dp) * (n - abs(l)))
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
        do b = 1, 4
          do a = 1, 4
            if (o%share(a, i) * o%share(b, j) > 0) cov(i, j) = cov(i, j) + 2 * o%share(a, i) * o%share(b, j) &
              * noise_pair(o, t, variance, o%lag(i) * directions(:, a), o%lag(j) * directions(:, b))
          end do
        end do
      end do
    end do
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
      w = overlap(r(1, i), k(1), l(1), o%nx) * overlap(r(2, i), k(2), l(2), o%ny)
      total = total + w * (2 * cs * cn + cn**2)
    end do
  contains
    pure real(dp) function s_of(v)
      integer, intent(in) :: v(2)     !< displacement
      s_of = radial_value(t, (v(1) * o%dx)**2 + (v(2) * o%dy)**2)
    end function s_of
  end function noise_pair
end module hd_random_field
