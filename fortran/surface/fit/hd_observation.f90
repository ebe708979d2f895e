! SPDX-License-Identifier: GPL-3.0-or-later
!> What a fit looks at: S over a window of short lags, rows and columns together, and where it comes from.
module hd_observation
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  use hd_structure_function, only: structure_line, check_map
  implicit none
  private
  public :: observation_t, observe, level_plane, add_observation, anisotropy, directions, fewest_lags

  integer, parameter :: fewest_lags = 4       !< of a window: three unknowns and one to judge them by
  real(dp), parameter :: one_line = 1e-12_dp  !< determinant over its largest value of points that lie on a line but for rounding
  real(dp), parameter :: equal = 1e-3_dp   !< relative difference of spacings that are one: an instrument's scales agree to no more
  !> Steps of the four directions, x and y: rows, columns, both diagonals.
  integer, parameter :: directions(2, 4) = reshape([1, 0, 0, 1, 1, 1, -1, 1], [2, 4])

  !> S at lags of a window. Entry i is the sum over the directions of share(d, i) times the mean at lag(i) steps along d.
  type :: observation_t
    integer :: nx = 0, ny = 0                     !< points along a row, rows
    real(dp) :: dx = 0, dy = 0                    !< spacing [m]
    logical :: levelled = .false.                 !< a least-squares plane was taken off
    real(dp) :: filled = 1                        !< share of the pairs that are not lost to holes
    real(dp) :: parts = 1                         !< sum of squares over square of sum of S of independent maps added up
    integer, allocatable :: lag(:)                !< lag in steps
    real(dp), allocatable :: share(:, :)          !< shares of the directions (4, n)
    real(dp), allocatable :: tau(:)               !< lag [m]
    real(dp), allocatable :: s(:)                 !< S [m^2]
    real(dp), allocatable :: s_x(:), s_y(:)       !< S along rows and along columns over equal distances [m^2]
  end type observation_t

contains

  !> Take off the least-squares plane (of a single row: the line); holes stay holes.
  subroutine level_plane(z, tilt)
    real(dp), intent(inout), contiguous :: z(:, :)  !< heights (nx, ny) [m]
    real(dp), intent(out) :: tilt(2)                !< height per point along x and y [m]
    real(dp) :: n, mx, my, mz, xx, yy, xy, xz, yz, x, y, det, z0, w
    integer :: i, j, at(2)
    tilt = 0
    at = findloc(abs(z) <= huge(z), .true.)
    if (any(at == 0)) return
    z0 = z(at(1), at(2))
    z = z - z0
    n = 0; mx = 0; my = 0; mz = 0
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        if (.not. abs(z(i, j)) <= huge(z)) cycle
        n = n + 1
        mx = mx + i
        my = my + j
        mz = mz + z(i, j)
      end do
    end do
    mx = mx / n
    my = my / n
    mz = mz / n
    xx = 0; yy = 0; xy = 0; xz = 0; yz = 0
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        if (.not. abs(z(i, j)) <= huge(z)) cycle
        x = i - mx
        y = j - my
        w = z(i, j) - mz
        xx = xx + x * x
        yy = yy + y * y
        xy = xy + x * y
        xz = xz + x * w
        yz = yz + y * w
      end do
    end do
    det = xx * yy - xy * xy
    if (det > one_line * xx * yy) then
      tilt = [yy * xz - xy * yz, xx * yz - xy * xz] / det
    else if (xx > 0) then
      tilt(1) = xz / xx
    end if
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        z(i, j) = z(i, j) - mz - tilt(1) * (i - mx) - tilt(2) * (j - my)
      end do
    end do
  end subroutine level_plane

  !> Measure S over lags first to last. Square pixels: rows and columns pooled, then the diagonals over the same distances if
  !> wanted; else rows and columns one after the other.
  subroutine observe(z, dx, dy, first, last, levelled, diagonals, o, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m], levelled or not
    real(dp), intent(in) :: dx, dy                    !< spacing [m]
    integer, intent(in) :: first, last                !< window in points
    logical, intent(in) :: levelled                   !< a plane was taken off
    logical, intent(in) :: diagonals                  !< diagonals too
    type(observation_t), intent(out) :: o             !< the observation
    type(error_t), allocatable, intent(out) :: error  !< map too small, bad window
    integer :: i
    logical :: square
    call check_map(z, dx, dy, error)
    if (allocated(error)) return
    if (first < 1 .or. last < first + fewest_lags - 1 .or. last > (size(z, 1) - 1) / 2) then
      call raise(error, code_input, 'lags '//to_text(first)//' to '//to_text(last)//' on rows of '//to_text(size(z, 1))// &
        ' points: a fit needs at least '//to_text(fewest_lags)//' lags, from 1 to half the length of a row')
      return
    end if
    o%nx = size(z, 1)
    o%ny = size(z, 2)
    o%dx = dx
    o%dy = dy
    o%levelled = levelled
    allocate (o%lag(0), o%tau(0), o%s(0), o%share(4, 0))
    square = abs(dx - dy) <= equal * dx
    if (last > (o%ny - 1) / 2) then
      call add_lags(z, [1], [(i, i=first, last)], o, error)
    else if (.not. square) then
      call add_lags(z, [1], [(i, i=first, last)], o, error)
      if (.not. allocated(error)) call add_lags(z, [2], [(i, i=first, last)], o, error)
    else
      call add_lags(z, [1, 2], [(i, i=first, last)], o, error)
      if (diagonals .and. .not. allocated(error)) then
        call add_lags(z, [3, 4], [(i, i=ceiling(first / sqrt(2._dp)), floor(last / sqrt(2._dp)))], o, error)
      end if
    end if
    if (.not. allocated(error)) o%filled = o%filled / size(o%lag)
    if (allocated(error) .or. o%ny == 1 .or. (square .and. last <= (o%ny - 1) / 2)) return
    call compare_directions(z, first, last, o, error)
  end subroutine observe

  !> S along rows and along columns over lags of the coarser spacing; along the finer one between two lags by a power law.
  subroutine compare_directions(z, first, last, o, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    integer, intent(in) :: first, last                !< window in points
    type(observation_t), intent(inout) :: o           !< s_x and s_y are set
    type(error_t), allocatable, intent(out) :: error  !< memory
    real(dp), allocatable :: place(:), s(:, :), high(:), pairs(:)
    real(dp) :: ratio(2)
    integer :: i, n
    ratio = max(o%dx, o%dy) / [o%dx, o%dy]
    where (abs(ratio - 1) <= equal) ratio = 1
    n = count([(all(ceiling(i * ratio) <= max(1, (shape(z) - 1) / 2)), i=first, last)])
    allocate (s(n, 2), high(n), pairs(n))
    do i = 1, 2
      place = ratio(i) * [(n, n=first, first + size(high) - 1)]
      call structure_line(z, directions(:, i), floor(place), s(:, i), pairs, error)
      if (.not. allocated(error)) call structure_line(z, directions(:, i), ceiling(place), high, pairs, error)
      if (allocated(error)) return
      where (ceiling(place) > floor(place)) s(:, i) = s(:, i) * &
        (high / s(:, i))**(log(place / floor(place)) / log(real(ceiling(place), dp) / floor(place)))
    end do
    o%s_x = s(:, 1)
    o%s_y = s(:, 2)
  end subroutine compare_directions

  !> Append entries pooled over directions. `filled` counts shares of pairs and is divided by the entries at the end.
  subroutine add_lags(z, which, lags, o, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m]
    integer, intent(in) :: which(:)                   !< directions
    integer, intent(in) :: lags(:)                    !< lags in steps
    type(observation_t), intent(inout) :: o           !< the observation
    type(error_t), allocatable, intent(out) :: error  !< no pairs
    real(dp) :: s(size(lags), size(which)), pairs(size(lags), size(which)), share(4, size(lags)), whole(size(lags))
    integer :: d, step(2)
    share = 0
    whole = 0
    do d = 1, size(which)
      step = directions(:, which(d))
      call structure_line(z, step, lags, s(:, d), pairs(:, d), error)
      if (allocated(error)) return
      if (any(pairs(:, d) < 1)) then
        call raise(error, code_input, 'some lags of the window '//to_text(lags(1))//' to '//to_text(lags(size(lags)))// &
          ' have no pair of points: the map has too many holes')
        return
      end if
      share(which(d), :) = pairs(:, d)
      whole = whole + real(o%nx - lags * abs(step(1)), dp) * (o%ny - lags * step(2))
      if (which(d) == 1) o%s_x = s(:, d)
      if (which(d) == 2) o%s_y = s(:, d)
    end do
    if (size(o%lag) == 0) o%filled = 0
    o%filled = o%filled + sum(sum(pairs, 2) / whole)
    do d = 1, 4
      share(d, :) = share(d, :) / sum(pairs, 2)
    end do
    o%lag = [o%lag, lags]
    o%share = reshape([o%share, share], [4, size(o%lag)])
    o%s = [o%s, sum(s * pairs, 2) / sum(pairs, 2)]
    o%tau = [o%tau, lags * matmul(transpose(share), hypot(o%dx * directions(1, :), o%dy * directions(2, :)))]
  end subroutine add_lags

  !> Add the S of an independent map: S_eq = S_1 + S_2. The smaller map lends its size.
  subroutine add_observation(o, other, error)
    type(observation_t), intent(inout) :: o           !< first map, then the sum
    type(observation_t), intent(in) :: other          !< second map
    type(error_t), allocatable, intent(out) :: error  !< spacings differ
    real(dp) :: first(size(o%lag))
    real(dp), allocatable :: first_x(:), first_y(:)
    integer :: n
    logical :: fit
    fit = size(o%lag) == size(other%lag) .and. abs(o%dx - other%dx) <= equal * o%dx .and. abs(o%dy - other%dy) <= equal * o%dy
    if (.not. fit) then
      call raise(error, code_input, 'two maps are added lag by lag, so their spacings must agree to 0.1 %: '//to_text(o%dx)// &
        ' x '//to_text(o%dy)//' m and '//to_text(other%dx)//' x '//to_text(other%dy)//' m')
      return
    end if
    first = o%s
    if (allocated(o%s_y)) then
      first_x = o%s_x
      first_y = o%s_y
    end if
    if (real(other%nx, dp) * other%ny < real(o%nx, dp) * o%ny) o = other
    o%parts = sum((first**2 + other%s**2) / (first + other%s)**2) / size(first)
    o%filled = min(o%filled, other%filled)
    o%s = first + other%s
    if (.not. (allocated(first_y) .and. allocated(other%s_y))) return
    n = min(size(first_y), size(other%s_y))
    o%s_x = first_x(:n) + other%s_x(:n)
    o%s_y = first_y(:n) + other%s_y(:n)
  end subroutine add_observation

  !> Mean ratio of S along rows and along columns over equal distances; NaN of a single line.
  pure real(dp) function anisotropy(o)
    type(observation_t), intent(in) :: o  !< the observation
    anisotropy = ieee_value(anisotropy, ieee_quiet_nan)
    if (.not. allocated(o%s_y)) return
    associate (both => o%s_x <= huge(anisotropy) .and. o%s_y > 0)
      if (any(both)) anisotropy = sum(o%s_x / o%s_y, both) / count(both)
    end associate
  end function anisotropy
end module hd_observation
