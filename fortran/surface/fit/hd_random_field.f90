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
  public :: field_covariance, noise_covariance, radial_t, new_radial

  real(dp), parameter :: most_tabled = 4e6_dp !< displacements whose S is worth a table: 32 MB
  integer, parameter :: nodes = 1500
  integer, parameter :: near = 20, beyond = 10  !< places along a half side of the square that is visited, up to twice the reach
                                                !< and beyond

  !> S as a function of distance: values at equidistant ln r, cubic between.
  type :: radial_t
    real(dp) :: ln_first = 0, step = 0      !< first ln r and step
    real(dp), allocatable :: v(:)           !< S [m^2]
  end type radial_t

  !> Lag vectors.
  type :: lags_t
    integer, allocatable :: entry(:)            !< entry of the observation
    integer, allocatable :: x(:), y(:)          !< lag vector [points]
    real(dp), allocatable :: share(:)           !< share of the direction in the entry, per pair of points
  end type lags_t

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
  subroutine field_covariance(o, t, cov, diagonal)
    type(observation_t), intent(in) :: o    !< geometry and lags
    type(radial_t), intent(in) :: t         !< S over distance
    real(dp), intent(out) :: cov(:, :)      !< covariance [m^4]
    logical, intent(in), optional :: diagonal !< variances alone; the rest stays 0
    integer, allocatable :: rx(:), ry(:), cell(:)
    real(dp), allocatable :: part(:, :, :), grid(:, :)
    integer, parameter :: blocks = 64
    type(lags_t) :: g
    integer :: b, i, j, mx, my
    logical :: own
    own = .false.
    if (present(diagonal)) own = diagonal
    call places(o, rx, ry, cell)
    g = lags_of(o)
    mx = o%nx + 2 * maxval(o%lag)
    my = o%ny + 2 * maxval(o%lag)
    if (real(mx, dp) * my < most_tabled) then        ! S at every displacement; of larger maps only few are visited
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
        call add_place(o, t, g, grid, rx(i), ry(i), cell(i), own, part(:, :, b))
      end do
    end do
    cov = sum(part, 3)
    cov = cov + transpose(cov)
  end subroutine field_covariance

  !> Lag vectors of all entries along all their directions.
  pure type(lags_t) function lags_of(o) result(g)
    type(observation_t), intent(in) :: o    !< geometry and lags
    integer, allocatable :: way(:)
    integer :: i, d
    g%share = reshape(transpose(o%share), [4 * size(o%lag)])
    g%entry = pack([((i, i=1, size(o%lag)), d=1, 4)], g%share > 0)
    way = pack([((d, i=1, size(o%lag)), d=1, 4)], g%share > 0)
    g%share = pack(g%share, g%share > 0)
    g%x = o%lag(g%entry) * directions(1, way)
    g%y = o%lag(g%entry) * directions(2, way)
    g%share = g%share / ((o%nx - abs(g%x)) * real(o%ny - abs(g%y), dp))
  end function lags_of

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
            if (y < 0 .or. (y == 0 .and. x < 0)) cycle        ! the same at -r, with lags exchanged
            n = n + 1
            if (pass == 2) then
              rx(n) = x
              ry(n) = y
              cell(n) = step * min(step, o%ny) * merge(1, 2, x == 0 .and. y == 0)
            end if
          end do
        end do
        if (outer >= far) exit
        outer = 2 * outer
        step = max(2, outer / near, merge(outer / beyond, 0, outer > 2 * reach))
      end do
      if (pass == 1) allocate (rx(n), ry(n), cell(n))
    end do
  end subroutine places

  !> Add one displacement to all pairs of lag vectors.
  subroutine add_place(o, t, g, grid, rx, ry, cell, own, part)
    type(observation_t), intent(in) :: o        !< geometry
    type(radial_t), intent(in) :: t             !< S over distance
    type(lags_t), intent(in) :: g               !< lag vectors
    real(dp), allocatable, intent(in) :: grid(:, :) !< S at displacements (0:, 0:), if it was worth it
    integer, intent(in) :: rx, ry, cell         !< displacement, places it stands for
    logical, intent(in) :: own                  !< each entry with itself alone
    real(dp), intent(inout) :: part(:, :)       !< sum of c^2 [m^4]
    real(dp) :: s0, c, w, ahead(size(g%x)), behind(size(g%x))
    integer :: i, j
    s0 = value_at(rx, ry)
    do j = 1, size(g%x)
      ahead(j) = value_at(rx + g%x(j), ry + g%y(j))
      behind(j) = value_at(rx - g%x(j), ry - g%y(j))
    end do
    do j = 1, size(g%x)
      do i = 1, size(g%x)
        if (own .and. g%entry(i) /= g%entry(j)) cycle
        w = real(pairs(rx, g%x(i), g%x(j), o%nx), dp) * pairs(ry, g%y(i), g%y(j), o%ny)
        if (w <= 0) cycle
        c = 0.5_dp * (ahead(j) + behind(i) - s0 - value_at(rx + g%x(j) - g%x(i), ry + g%y(j) - g%y(i)))
        part(g%entry(i), g%entry(j)) = part(g%entry(i), g%entry(j)) &
          + (g%share(i) * g%share(j) * w) * cell * c**2
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

  !> Pairs of first points, r apart, of the lags k and l along a line of n points.
  elemental integer function pairs(r, k, l, n)
    integer, intent(in) :: r, k, l, n   !< displacement of the second from the first, lags, points
    pairs = max(0, min(n - max(0, k), n - max(0, l) - r) - max(max(0, -k), max(0, -l) - r))
  end function pairs

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
      w = real(pairs(r(1, i), k(1), l(1), o%nx), dp) * pairs(r(2, i), k(2), l(2), o%ny)
      total = total + w * (2 * cs * cn + cn**2)
    end do
    total = total / (real(o%nx - abs(k(1)), dp) * (o%ny - abs(k(2)))) / (real(o%nx - abs(l(1)), dp) * (o%ny - abs(l(2))))
  contains
    pure real(dp) function s_of(v)
      integer, intent(in) :: v(2)     !< displacement
      s_of = radial_value(t, (v(1) * o%dx)**2 + (v(2) * o%dy)**2)
    end function s_of
  end function noise_pair
end module hd_random_field
