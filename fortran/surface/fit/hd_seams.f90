! SPDX-License-Identifier: GPL-3.0-or-later
!> Straight steps of stitching and offsets of single rows or columns (jitter of a scanning instrument): found, taken off, counted.
module hd_seams
  use hd_kinds, only: dp
  use hd_outliers, only: median, robust
  implicit none
  private
  public :: seams_t, remove_seams, remove_offsets, add_seams

  real(dp), parameter :: settled = 1e-9_dp    !< change of an offset over the largest step
  integer, parameter :: fewest = 4            !< distances between seams, of a map that may have one: two edges and room to tell by
  integer, parameter :: quarters = 4          !< most parts of a direction that are looked at one by one
  real(dp), parameter :: far_out = 7          !< a seam's step beside its neighbours', in robust standard deviations of all
  real(dp), parameter :: sharp = 3            !< that over the largest of the four beside it
  integer, parameter :: most = 8              !< seams per direction; more are a texture
  integer, parameter :: apart = 8             !< least points between seams and to the edge of the map
  integer, parameter :: shortest = 48         !< least points along a seam
  integer, parameter :: around = 8            !< rows either way that say how high a row would be without jitter

  !> What was found.
  type :: seams_t
    integer :: count(2) = 0                   !< seams across x, across y
    integer, allocatable :: x(:), y(:)        !< last points before them, of the latest map
    real(dp) :: largest = 0                   !< step [m]
    real(dp) :: jitter(2) = 0                 !< rms offset of columns, of rows that was taken off [m]
  end type seams_t

contains

  !> Find seams that cross the whole map, level the tiles between them by offsets that close the steps best, and take those off.
  subroutine remove_seams(z, s)
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, ny); NaN are holes [m]
    type(seams_t), intent(inout) :: s                 !< seams are added
    s%x = [integer ::]
    s%y = s%x
    call remove_more(z, s)
  end subroutine remove_seams

  !> Count those of another map too.
  pure subroutine add_seams(s, other)
    type(seams_t), intent(inout) :: s     !< seams of one map, then of both; places stay those of the first
    type(seams_t), intent(in) :: other    !< seams of the other
    s%count = s%count + other%count
    s%largest = max(s%largest, other%largest)
    s%jitter = max(s%jitter, other%jitter)
  end subroutine add_seams

  !> The same for a map whose seams are known in part.
  subroutine remove_more(z, s)
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, ny); NaN are holes [m]
    type(seams_t), intent(inout) :: s                 !< its seams; more are added
    integer, allocatable :: x(:), y(:)
    real(dp), allocatable :: offset(:, :)
    integer :: a, b, i, j
    if (size(z, 2) == 1) return
    s%count = s%count - [size(s%x), size(s%y)]
    s%x = both(s%x, seams_of(z))
    s%y = both(s%y, seams_of(transpose(z)))
    s%count = s%count + [size(s%x), size(s%y)]
    if (size(s%x) + size(s%y) == 0) return
    x = [0, s%x, size(z, 1)]
    y = [0, s%y, size(z, 2)]
    call level_tiles(z, x, y, offset, s%largest)
    do b = 1, size(y) - 1
      do a = 1, size(x) - 1
        do j = y(b) + 1, y(b + 1)
          do i = x(a) + 1, x(a + 1)
            z(i, j) = z(i, j) - offset(a, b)
          end do
        end do
      end do
    end do
  contains
    !> Places of two lists in order.
    pure function both(p, q) result(r)
      integer, intent(in) :: p(:), q(:)   !< places
      integer, allocatable :: r(:)
      integer :: k
      r = pack([(k, k=1, maxval(shape(z)))], [(any(p == k) .or. any(q == k), k=1, maxval(shape(z)))])
    end function both
  end subroutine remove_more

  !> Last points before the seams across x. Medians of the steps from point to point over all rows, and over halves and quarters of
  !> them (tiles of a grid step either way), less those of the neighbours: a seam stands alone.
  function seams_of(z) result(at)
    real(dp), intent(in) :: z(:, :)         !< heights [m]
    integer, allocatable :: at(:)
    real(dp), allocatable :: step(:, :), weight(:), rest(:), bend(:)
    integer :: parts, k, i, n, first, last
    n = size(z, 1) - 1
    allocate (at(0))
    if (n < fewest * apart .or. size(z, 2) < shortest) return
    allocate (weight(n), source=0._dp)
    parts = 1
    do while (parts <= quarters .and. size(z, 2) / parts >= shortest)
      allocate (step(n, parts))
      do k = 1, parts
        first = (k - 1) * size(z, 2) / parts + 1
        last = k * size(z, 2) / parts
        !$omp parallel do
        do i = 1, n
          step(i, k) = middle(z(i + 1, first:last) - z(i, first:last))
        end do
        step(:, k) = alone(step(:, k))
      end do
      rest = reshape(abs(step(apart:n + 1 - apart, :)), [parts * (n + 2 - 2 * apart)])
      do k = 1, parts                                       ! a smooth surface bends over several points, a seam between two
        bend = abs(step(:, k))
        where (bend < sharp * max(eoshift(bend, 1), eoshift(bend, -1), eoshift(bend, 2), eoshift(bend, -2))) step(:, k) = 0
      end do
      weight = max(weight, maxval(abs(step), 2) / max(robust * median(rest), tiny(1._dp)))
      deallocate (step)
      parts = 2 * parts
    end do
    weight(:apart - 1) = 0
    weight(n + 2 - apart:) = 0
    do while (any(weight > far_out))
      i = maxloc(weight, 1)
      at = [at, i]
      weight(max(1, i - apart):min(n, i + apart)) = 0
    end do
    if (size(at) > most) at = [integer ::]
    at = pack([(i, i=1, n)], [(any(at == i), i=1, n)])      ! in order
  end function seams_of

  !> Each number less the median of the two before and the two behind it.
  pure function alone(x) result(r)
    real(dp), intent(in) :: x(:)      !< numbers
    real(dp) :: r(size(x))
    integer :: i
    r = 0
    do i = 3, size(x) - 2
      r(i) = x(i) - median([x(i - 2:i - 1), x(i + 1:i + 2)])
    end do
  end function alone

  !> Offsets of tiles whose differences are the steps between them, by least squares: each tile in turn takes the mean of what its
  !> neighbours want, until nothing moves.
  subroutine level_tiles(z, x, y, offset, largest)
    real(dp), intent(in) :: z(:, :)                     !< heights [m]
    integer, intent(in) :: x(:), y(:)                   !< 0, last points before the seams, numbers of points
    real(dp), allocatable, intent(out) :: offset(:, :)  !< of the tiles [m]
    real(dp), intent(inout) :: largest                  !< step [m]
    real(dp) :: right(size(x) - 1, size(y) - 1), up(size(x) - 1, size(y) - 1), total, weight, new, moved
    integer :: a, b, i, pass
    allocate (offset(size(x) - 1, size(y) - 1), source=0._dp)
    right = 0
    up = 0
    do b = 1, size(y) - 1
      do a = 1, size(x) - 1
        if (a < size(x) - 1) right(a, b) = jump(z(:, y(b) + 1:y(b + 1)), x(a + 1))
        if (b < size(y) - 1) up(a, b) = jump(transpose(z(x(a) + 1:x(a + 1), :)), y(b + 1))
      end do
    end do
    largest = max(largest, maxval(abs(right)), maxval(abs(up)))
    do pass = 1, 10000
      moved = 0
      do b = 1, size(y) - 1
        do a = 1, size(x) - 1
          total = 0
          weight = 0
          i = y(b + 1) - y(b)                           ! edges count by their length
          if (a > 1) call add(offset(a - 1, b) + right(a - 1, b))
          if (a < size(x) - 1) call add(offset(a + 1, b) - right(a, b))
          i = x(a + 1) - x(a)
          if (b > 1) call add(offset(a, b - 1) + up(a, b - 1))
          if (b < size(y) - 1) call add(offset(a, b + 1) - up(a, b))
          new = total / weight
          moved = max(moved, abs(new - offset(a, b)))
          offset(a, b) = new
        end do
      end do
      if (moved <= settled * largest) exit
    end do
    offset = offset - sum(offset) / size(offset)
  contains
    !> One neighbour's wish.
    subroutine add(value)
      real(dp), intent(in) :: value   !< [m]
      total = total + i * value
      weight = weight + i
    end subroutine add
  end subroutine level_tiles

  !> Step at a seam: median over its points, less what the surface itself rises there.
  pure real(dp) function jump(z, at)
    real(dp), intent(in) :: z(:, :)   !< heights, the seam across the first index [m]
    integer, intent(in) :: at         !< last point before it
    jump = middle(z(at + 1, :) - z(at, :)) - 0.5_dp * (middle(z(at, :) - z(at - 1, :)) + middle(z(at + 2, :) - z(at + 1, :)))
  end function jump

  !> Median of what is finite.
  pure real(dp) function middle(d)
    real(dp), intent(in) :: d(:)      !< numbers
    middle = median(pack(d, abs(d) <= huge(middle)))
  end function middle

  !> Take offsets of columns (way = 1) or rows (way = 2) off. Between seams each tile has its own: what its means stand off their
  !> running median, so that its long waves stay. Steps that the offsets hid are levelled then. Last the means over the map.
  subroutine remove_offsets(z, way, s)
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights without holes [m]
    integer, intent(in) :: way                        !< 1: columns; 2: rows
    type(seams_t), intent(inout) :: s                 !< seams of this map; more are added, jitter is set
    integer, allocatable :: ends(:)
    real(dp), allocatable :: mean(:)
    integer :: a, i, n, first, last
    n = size(z, 3 - way)
    ends = [0, s%y, n]
    if (way == 2) ends = [0, s%x, n]
    do a = 1, size(ends) - 1
      first = ends(a) + 1
      last = ends(a + 1)
      if (way == 1) mean = sum(z(:, first:last), 2) / (last - first + 1)
      if (way == 2) mean = sum(z(first:last, :), 1) / (last - first + 1)
      s%jitter(way) = max(s%jitter(way), sqrt(0.5_dp * sum((mean(2:) - mean(:size(mean) - 1))**2) / (size(mean) - 1)))
      if (size(ends) == 2) exit
      mean = mean - [(median(mean(max(1, i - around):min(size(mean), i + around))), i=1, size(mean))]
      if (way == 1) z(:, first:last) = z(:, first:last) - spread(mean, 2, last - first + 1)
      if (way == 2) z(first:last, :) = z(first:last, :) - spread(mean, 1, last - first + 1)
    end do
    if (size(ends) > 2) call remove_more(z, s)
    if (way == 1) z = z - spread(sum(z, 2) / n, 2, n)
    if (way == 2) z = z - spread(sum(z, 1) / n, 1, n)
  end subroutine remove_offsets
end module hd_seams
