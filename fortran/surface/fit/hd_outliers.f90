! SPDX-License-Identifier: GPL-3.0-or-later
!> Single wrong points of a map found and taken for holes, and holes filled so that a spectrum can be taken.
module hd_outliers
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp, i8, pi
  use hd_error, only: error_t
  use hd_fft, only: backward_real_2d
  use hd_random, only: uniforms
  implicit none
  private
  public :: mask_spikes, fill_holes, synthetic, median, robust

  real(dp), parameter :: robust = 1.4826_dp   !< standard deviation over the median of the amount, of a Gaussian
  integer, parameter :: beside = 3            !< points each way that a clump lies in: the farthest of the rings
  integer, parameter :: fewest = 3            !< neighbours that say how far a point is off
  real(dp), parameter :: alone = 0.5_dp       !< distance from all around but one, over that from their middle
  real(dp), parameter :: relaxed = 1.6_dp     !< over-relaxation, 2/(1 + sin(pi/n)): the best for a hole of n = 13 points
  real(dp), parameter :: settled = 1e-6_dp    !< change of a filled height over the range of all that no spectrum sees
  real(dp), parameter :: texture = 0.005_dp   !< share of points beyond which spikes must stand alone or in clumps to be spikes
  real(dp), parameter :: jittery = 0.7_dp     !< change of the median step over that of steps from which on rows jitter
  real(dp), parameter :: slender = 1.5_dp     !< ratio of the spacings beyond which neighbours are those along the finer one
  integer, parameter :: clump = 6             !< most wrong points of a clump, in seven points each way
  real(dp), parameter :: far_out = 6          !< a spike's distance from its neighbours, in standard deviations of that distance

contains

  !> Points far from those around them become holes: single ones by their neighbours, clumps by the rings at twice and three times
  !> the distance. Far: beyond six robust standard deviations, half of it from all around but one. Jitter of rows does not count.
  subroutine mask_spikes(z, spacing, found, seams, least)
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, ny) [m]
    real(dp), intent(in) :: spacing(2)                !< dx, dy [m]
    integer, intent(out) :: found                     !< points masked
    integer, intent(in) :: seams(:)                   !< last points before steps of stitching across x
    real(dp), intent(out) :: least(2)                 !< height from which on single points, clumps are far [m]
    integer, parameter :: reach(8) = [1, 1, 1, 2, 2, 3, 2, 1]
    real(dp), allocatable :: work(:, :)
    integer, allocatable :: cuts(:)
    logical, allocatable :: bad(:, :), all_bad(:, :)
    real(dp) :: limit
    integer :: pass, i, j, single
    least = 0
    work = z
    cuts = [0, seams, size(z, 1)]
    do i = 1, size(cuts) - 1
      call still_rows(work(cuts(i) + 1:cuts(i + 1), :))
    end do
    allocate (all_bad(size(z, 1), size(z, 2)), source=.false.)
    allocate (bad, mold=all_bad)
    do pass = 1, size(reach)
      if (any(reach(:pass - 1) == reach(pass))) then
        if (.not. any(bad)) cycle                       ! nothing has changed since
      end if
      call find_far_points(work, half_ring(reach(pass), line_of(shape(z), spacing)), bad, limit)
      if (reach(pass) == 1 .and. pass == 1) least(1) = limit
      if (reach(pass) == maxval(reach)) least(2) = limit
      where (bad) work = ieee_value(1._dp, ieee_quiet_nan)
      all_bad = all_bad .or. bad
    end do
    found = int(count(all_bad, kind=i8))
    single = 0
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        if (.not. all_bad(i, j)) cycle
        if (count(all_bad(max(1, i - beside):min(size(z, 1), i + beside), &
          max(1, j - beside):min(size(z, 2), j + beside))) <= clump) single = single + 1
      end do
    end do
    if (found > texture * size(z, kind=i8) .and. 2 * single <= found) found = 0  ! many, and side by side: edges and scratches
    if (found > 0) where (all_bad) z = ieee_value(1._dp, ieee_quiet_nan)
  end subroutine mask_spikes

  !> Take offsets of rows off where they jitter: where the medians of the steps from row to row change nearly as much as steps do.
  subroutine still_rows(z)
    real(dp), intent(inout) :: z(:, :)    !< heights [m]
    real(dp), allocatable :: d(:, :)
    real(dp) :: step(1, size(z, 2) - 1), offset
    integer :: j
    if (size(z, 2) < 3) return    ! steps have no change
    d = z(:, 2:) - z(:, :size(z, 2) - 1)
    step(1, :) = [(median(pack(d(:, j), abs(d(:, j)) <= huge(1._dp))), j=1, size(d, 2))]
    if (change(step) < jittery * change(d)) return
    offset = 0
    do j = 2, size(z, 2)
      offset = offset + step(1, j - 1)
      z(:, j) = z(:, j) - offset
    end do
  end subroutine still_rows

  !> Median size of the changes along y.
  pure real(dp) function change(d)
    real(dp), intent(in) :: d(:, :)     !< numbers
    real(dp), allocatable :: a(:, :)
    a = abs(d(:, 2:) - d(:, :size(d, 2) - 1))
    change = median(pack(a, a <= huge(change)))
  end function change

  !> Points beyond six robust standard deviations of those with as many pairs around them (at edges and holes pairs are missing).
  subroutine find_far_points(z, step, bad, limit)
    real(dp), intent(in), contiguous :: z(:, :)       !< heights [m]
    integer, intent(in) :: step(:, :)                 !< to one of each pair of neighbours
    logical, intent(out) :: bad(:, :)                 !< those
    real(dp), intent(out) :: limit                    !< how far they stand at least, of most points [m]
    integer, parameter :: enough = 200                !< points to tell a deviation by
    real(dp), parameter :: rounding = 100 * epsilon(1._dp)    !< of heights a plane was taken off, over the largest
    real(dp), allocatable :: away(:, :), near(:, :), wide(:, :)
    integer, allocatable :: pairs(:, :)
    real(dp) :: scale, least, whole
    integer :: i, j, k
    allocate (away(size(z, 1), size(z, 2)), near(size(z, 1), size(z, 2)), pairs(size(z, 1), size(z, 2)))
    i = maxval(abs(step(1, :)))
    j = maxval(step(2, :))
    allocate (wide(1 - i:size(z, 1) + i, 1 - j:size(z, 2) + j), source=ieee_value(scale, ieee_quiet_nan))
    wide(1:size(z, 1), 1:size(z, 2)) = z
    !$omp parallel do private(i)
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        call distance(wide, lbound(wide, 1), lbound(wide, 2), i, j, step, away(i, j), near(i, j), pairs(i, j))
      end do
    end do
    bad = .false.
    least = rounding * maxval(abs(z), abs(z) <= huge(least))  ! of flat plateaus only rounding is left: no scatter to tell by
    scale = 0
    whole = 0
    do k = maxval(pairs), 1, -1
      if (count(pairs == k, kind=i8) >= enough .or. .not. scale > 0) scale = robust * median(pack(abs(away), pairs == k))
      if (.not. whole > 0) whole = scale
      if (.not. scale > least) cycle
      bad = bad .or. (pairs == k .and. abs(away) > far_out * scale .and. near > alone * abs(away))
    end do
    limit = far_out * whole
  end subroutine find_far_points

  !> Direction along which the neighbours of a point lie, 1: x, 2: y; 0: they lie around it. Of unlike spacings those along the
  !> coarser one are too far to tell anything.
  pure integer function line_of(n, spacing) result(line)
    integer, intent(in) :: n(2)               !< points along x and y
    real(dp), intent(in) :: spacing(2)        !< dx, dy [m]
    line = merge(1, 0, n(2) == 1 .or. spacing(2) > slender * spacing(1))
    if (n(2) > 1 .and. spacing(1) > slender * spacing(2)) line = 2
  end function line_of

  !> Steps to one of each pair of opposite points: on the square ring at a distance, along a line the next two.
  pure function half_ring(reach, line) result(step)
    integer, intent(in) :: reach              !< 1: neighbours; 2, 3: rings around them
    integer, intent(in) :: line               !< direction, 0: ring
    integer, allocatable :: step(:, :)
    integer :: k, l
    allocate (step(2, 0))
    if (line > 0) then
      step = spread([2 * reach - 1, 2 * reach], 1, 2)
      step(3 - line, :) = 0
      return
    end if
    do l = 0, reach
      do k = merge(1, -reach, l == 0), reach
        if (max(abs(k), l) == reach) step = reshape([step, k, l], [2, size(step, 2) + 1])
      end do
    end do
  end function half_ring

  !> Height over those around: the median of the means of opposite pairs, which a slope does not move. And how far off all but one
  !> of them it is at least: a point at an edge or a corner of a plateau has others at its height.
  pure subroutine distance(z, x, y, i, j, step, away, second, pairs)
    integer, intent(in) :: x, y             !< first indices of z
    real(dp), intent(in) :: z(x:, y:)       !< heights with a margin of NaN [m]
    integer, intent(in) :: i, j             !< place
    integer, intent(in) :: step(:, :)       !< to one of each pair
    real(dp), intent(out) :: away, second   !< over the pairs; second smallest difference [m]
    integer, intent(out) :: pairs           !< number of pairs; 0 where there is nothing to tell by
    real(dp) :: mean(12), first, both(2), apart
    integer :: n, k, m, l
    n = 0
    pairs = 0
    away = 0
    first = huge(first)
    second = huge(second)
    if (.not. abs(z(i, j)) <= huge(away)) return
    do k = 1, size(step, 2)
      both = [z(i + step(1, k), j + step(2, k)), z(i - step(1, k), j - step(2, k))]
      m = 0
      do l = 1, 2
        apart = abs(z(i, j) - both(l))
        if (.not. apart <= huge(apart)) cycle
        m = m + 1
        if (apart < first) then
          second = first
          first = apart
        else if (apart < second) then
          second = apart
        end if
      end do
      n = n + m
      if (m < 2) cycle
      apart = 0.5_dp * (both(1) + both(2))
      do l = pairs, 1, -1                     ! in order
        if (mean(l) <= apart) exit
        mean(l + 1) = mean(l)
      end do
      mean(l + 1) = apart
      pairs = pairs + 1
    end do
    if (n < fewest) pairs = 0
    if (pairs > 0) away = z(i, j) - 0.5_dp * (mean((pairs + 1) / 2) + mean(pairs / 2 + 1))
    if (pairs == 0) second = 0
  end subroutine distance

  !> Median, by partition; 0 of nothing.
  pure real(dp) function median(values)
    real(dp), intent(in) :: values(:)   !< numbers
    real(dp) :: pivot, swap
    real(dp), allocatable :: a(:)
    integer :: low, high, want, i, j
    median = 0
    if (size(values) == 0) return
    a = values
    want = (size(a) + 1) / 2
    low = 1
    high = size(a)
    do while (low < high)
      pivot = a(low + (high - low) / 2)
      i = low
      j = high
      do while (i <= j)
        do while (a(i) < pivot)
          i = i + 1
        end do
        do while (a(j) > pivot)
          j = j - 1
        end do
        if (i > j) exit
        swap = a(i)
        a(i) = a(j)
        a(j) = swap
        i = i + 1
        j = j - 1
      end do
      if (want <= j) then
        high = j
      else if (want >= i) then
        low = i
      else
        exit
      end if
    end do
    median = a(want)
    if (modulo(size(a), 2) == 0) median = 0.5_dp * (median + minval(a(want + 1:)))     ! of an even number the middle of two
  end function median

  !> Fill holes with what bends least: each the mean of its neighbours (Laplace), relaxed until settled.
  subroutine fill_holes(z, spacing, hole)
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, ny) [m]
    real(dp), intent(in) :: spacing(2)                !< dx, dy [m]
    logical, intent(in) :: hole(:, :)                 !< points to fill
    integer, allocatable :: at(:, :)
    real(dp) :: total, new, change, all_of, weight(4)
    logical, allocatable :: known(:, :)
    integer :: i, j, k, n, pass
    if (.not. any(hole)) return
    weight = (minval(spacing) / [spacing, spacing])**2
    allocate (at(2, count(hole, kind=i8)))
    k = 0
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        if (.not. hole(i, j)) cycle
        k = k + 1
        at(:, k) = [i, j]
      end do
    end do
    known = .not. hole
    where (hole) z = sum(z, known) / max(1_i8, count(known, kind=i8))
    do while (.not. all(known))                       ! from the rims inwards
      n = 0
      do k = 1, size(at, 2)
        if (known(at(1, k), at(2, k))) cycle
        call around(at(1, k), at(2, k), new, all_of)
        if (.not. all_of > 0) cycle
        z(at(1, k), at(2, k)) = new / all_of
        known(at(1, k), at(2, k)) = .true.
        n = n + 1
      end do
      if (n == 0) exit
    end do
    known = .true.
    do pass = 1, 200
      change = 0
      do k = 1, size(at, 2)
        call around(at(1, k), at(2, k), total, all_of)
        new = z(at(1, k), at(2, k)) + relaxed * (total / all_of - z(at(1, k), at(2, k)))
        change = max(change, abs(new - z(at(1, k), at(2, k))))
        z(at(1, k), at(2, k)) = new
      end do
      if (change < settled * (maxval(z) - minval(z))) exit
    end do
  contains
    !> Sum of known neighbours, each by its weight, and of the weights.
    subroutine around(i, j, total, all_of)
      integer, intent(in) :: i, j               !< place
      real(dp), intent(out) :: total, all_of    !< sums
      integer, parameter :: side(2, 4) = reshape([1, 0, 0, 1, -1, 0, 0, -1], [2, 4])
      integer :: l
      total = 0
      all_of = 0
      do l = 1, 4
        if (i + side(1, l) < 1 .or. i + side(1, l) > size(z, 1) .or. j + side(2, l) < 1 .or. j + side(2, l) > size(z, 2)) cycle
        if (.not. known(i + side(1, l), j + side(2, l))) cycle
        total = total + weight(l) * z(i + side(1, l), j + side(2, l))
        all_of = all_of + weight(l)
      end do
    end subroutine around
  end subroutine fill_holes

  !> A map of random phases whose power falls as f^-n: what filling does to a spectrum is measured on it.
  subroutine synthetic(z, dx, dy, n, error)
    real(dp), intent(out), contiguous :: z(:, :)      !< heights (nx, ny)
    real(dp), intent(in) :: dx, dy, n                 !< spacing [m], slope
    type(error_t), allocatable, intent(out) :: error  !< no plan
    complex(dp), allocatable :: s(:, :)
    real(dp), allocatable :: u(:)
    integer(i8), allocatable :: ki(:), kj(:)
    real(dp) :: f
    integer :: i, j
    allocate (s(size(z, 1) / 2 + 1, size(z, 2)), u(size(z, 1) / 2 + 1))
    ki = [(int(i, i8), i=1, size(u))]
    do j = 1, size(s, 2)
      kj = [(int(j, i8), i=1, size(u))]
      call uniforms(1_i8, ki, kj, u)
      do i = 1, size(s, 1)
        f = (i - 1) / (size(z, 1) * dx)
        if (size(z, 2) > 1) f = hypot(f, min(j - 1, size(z, 2) - j + 1) / (size(z, 2) * dy))
        s(i, j) = 0
        if (f > 0) s(i, j) = f**(-0.5_dp * n) * exp(cmplx(0, 2 * pi * u(i), dp))
      end do
    end do
    call backward_real_2d(s, z, error)
  end subroutine synthetic
end module hd_outliers
