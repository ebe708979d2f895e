! SPDX-License-Identifier: GPL-3.0-or-later
!> What a fit looks at: S over a window of short lags, rows and columns together, and where it comes from.
module hd_observation
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  use hd_structure_function, only: structure_line, check_map
  implicit none
  private
  public :: observation_t, observe, level_plane, add_observation

  !> S at lags of a window. Lag i is share(1, i) times the mean over rows plus share(2, i) times that over columns.
  type :: observation_t
    integer :: nx = 0, ny = 0                     !< points along a row, rows
    real(dp) :: dx = 0, dy = 0                    !< spacing [m]
    logical :: levelled = .false.                 !< a least-squares plane was taken off
    real(dp) :: filled = 1                        !< share of the pairs that are not lost to holes
    real(dp) :: parts = 1                         !< sum of squares over square of sum of S of independent maps added up
    integer, allocatable :: lag(:)                !< lag in points
    real(dp), allocatable :: share(:, :)          !< shares of rows and columns (2, n)
    real(dp), allocatable :: tau(:)               !< lag [m]
    real(dp), allocatable :: s(:)                 !< S [m^2]
    real(dp), allocatable :: s_x(:), s_y(:)       !< S along rows and along columns at the lags of the window [m^2]
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
    if (det > 1e-12_dp * xx * yy) then
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

  !> Measure S over lags first to last. Square pixels: rows and columns pooled; else one after the other.
  subroutine observe(z, dx, dy, first, last, levelled, o, error)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights (nx, ny) [m], levelled or not
    real(dp), intent(in) :: dx, dy                    !< spacing [m]
    integer, intent(in) :: first, last                !< window in points
    logical, intent(in) :: levelled                   !< a plane was taken off
    type(observation_t), intent(out) :: o             !< the observation
    type(error_t), allocatable, intent(out) :: error  !< map too small, bad window
    integer :: lags(max(1, last - first + 1)), i, n
    real(dp), dimension(size(lags)) :: sx, sy, cx, cy
    logical :: columns, pooled
    call check_map(z, dx, dy, error)
    if (allocated(error)) return
    if (first < 1 .or. last < first + 3 .or. last > (size(z, 1) - 1) / 2) then
      call raise(error, code_input, 'lags '//to_text(first)//' to '//to_text(last)//' on rows of '//to_text(size(z, 1))// &
        ' points: a fit needs at least 4 lags, from 1 to half the length of a row')
      return
    end if
    n = size(lags)
    lags = [(first + i - 1, i=1, n)]
    o%nx = size(z, 1)
    o%ny = size(z, 2)
    o%dx = dx
    o%dy = dy
    o%levelled = levelled
    columns = last <= (o%ny - 1) / 2
    call structure_line(z, [1, 0], lags, sx, cx, error)
    if (allocated(error)) return
    sy = sx
    cy = 0
    if (columns) call structure_line(z, [0, 1], lags, sy, cy, error)
    if (allocated(error)) return
    if (any(cx < 1) .or. (columns .and. any(cy < 1))) then
      call raise(error, code_input, 'some lags of the window '//to_text(first)//' to '//to_text(last)// &
        ' have no pair of points: the map has too many holes')
      return
    end if
    o%filled = (sum(cx) + sum(cy)) / (sum(real(o%nx - lags, dp)) * o%ny + &
      merge(sum(real(o%ny - lags, dp)) * o%nx, 0._dp, columns))
    o%s_x = sx
    o%s_y = sy
    pooled = columns .and. abs(dx - dy) <= 1e-3_dp * dx
    if (pooled .or. .not. columns) then
      o%lag = lags
      allocate (o%share(2, n))
      o%share(1, :) = cx / (cx + cy)
      o%share(2, :) = cy / (cx + cy)
      o%tau = lags * (o%share(1, :) * dx + o%share(2, :) * dy)
      o%s = o%share(1, :) * sx + o%share(2, :) * merge(sy, 0._dp, cy > 0)
    else
      o%lag = [lags, lags]
      allocate (o%share(2, 2 * n), source=0._dp)
      o%share(1, :n) = 1
      o%share(2, n + 1:) = 1
      o%tau = [lags * dx, lags * dy]
      o%s = [sx, sy]
    end if
  end subroutine observe

  !> Add the S of an independent map: S_eq = S_1 + S_2. The smaller map lends its size.
  subroutine add_observation(o, other, error)
    type(observation_t), intent(inout) :: o           !< first map, then the sum
    type(observation_t), intent(in) :: other          !< second map
    type(error_t), allocatable, intent(out) :: error  !< spacings differ
    real(dp) :: first(size(o%lag))
    logical :: fit
    fit = size(o%lag) == size(other%lag) .and. abs(o%dx - other%dx) <= 1e-3_dp * o%dx .and. abs(o%dy - other%dy) <= 1e-3_dp * o%dy
    if (.not. fit) then
      call raise(error, code_input, 'two maps are added lag by lag, so their spacings must agree to 0.1 %: '//to_text(o%dx)// &
        ' x '//to_text(o%dy)//' m and '//to_text(other%dx)//' x '//to_text(other%dy)//' m')
      return
    end if
    first = o%s
    if (other%nx * other%ny < o%nx * o%ny) o = other
    o%parts = sum((first**2 + other%s**2) / (first + other%s)**2) / size(first)
    o%filled = min(o%filled, other%filled)
    o%s = first + other%s
  end subroutine add_observation
end module hd_observation
