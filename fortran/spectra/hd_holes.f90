! SPDX-License-Identifier: GPL-3.0-or-later
!> Single wrong points of a map found and taken for holes, and holes filled so that a spectrum can be taken.
module hd_holes
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp, i8, pi
  use hd_error, only: error_t
  use hd_fft, only: backward_real_2d
  use hd_random, only: uniforms
  implicit none
  private
  public :: mask_spikes, fill_holes, synthetic

  real(dp), parameter :: texture = 0.005_dp   !< share of points beyond which spikes must stand alone to be spikes
  real(dp), parameter :: far_out = 6          !< a spike's distance from its neighbours, in standard deviations of that distance

contains

  !> Points far from the median of their neighbours become holes: beyond six robust standard deviations, which a Gaussian map of a
  !> million points reaches twice in a thousand times.
  subroutine mask_spikes(z, found)
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, ny) [m]
    integer, intent(out) :: found                     !< points masked
    real(dp), allocatable :: away(:, :), near(:, :), old(:, :)
    logical, allocatable :: bad(:, :), all_bad(:, :)
    real(dp) :: scale
    integer :: pass, i, j, alone
    found = 0
    old = z
    allocate (all_bad(size(z, 1), size(z, 2)), source=.false.)
    allocate (away(size(z, 1), size(z, 2)), near(size(z, 1), size(z, 2)))
    do pass = 1, 3
      !$omp parallel do private(i)
      do j = 1, size(z, 2)
        do i = 1, size(z, 1)
          call distance(z, i, j, away(i, j), near(i, j))
        end do
      end do
      scale = 1.4826_dp * middle(pack(abs(away), abs(away) <= huge(scale)))
      bad = abs(away) > far_out * scale .and. abs(away) <= huge(scale) .and. near > 0.5_dp * abs(away)
      if (.not. any(bad) .or. .not. scale > 0) exit
      found = found + int(count(bad, kind=i8))
      where (bad) z = ieee_value(scale, ieee_quiet_nan)
      all_bad = all_bad .or. bad
    end do
    if (found <= texture * size(z, kind=i8)) return
    alone = 0
    do j = 1, size(z, 2)
      do i = 1, size(z, 1)
        if (.not. all_bad(i, j)) cycle
        if (count(all_bad(max(1, i - 1):min(size(z, 1), i + 1), max(1, j - 1):min(size(z, 2), j + 1))) == 1) alone = alone + 1
      end do
    end do
    if (2 * alone > found) return
    z = old                                   ! many, and side by side: edges and scratches, no wrong points
    found = 0
  end subroutine mask_spikes

  !> Height over the median of the neighbours: eight of a map, four of a line; NaN of holes. And how far off all but one of them
  !> it is at least: a point at an edge or a corner of a plateau has others at its height.
  pure subroutine distance(z, i, j, away, second)
    real(dp), intent(in) :: z(:, :)         !< heights [m]
    integer, intent(in) :: i, j             !< place
    real(dp), intent(out) :: away, second   !< over the median; second smallest difference [m]
    real(dp) :: near(8), off(8)
    integer :: n, k, l, wide
    wide = merge(2, 1, size(z, 2) == 1)
    n = 0
    do l = max(1, j - 1), min(size(z, 2), j + 1)
      do k = max(1, i - wide), min(size(z, 1), i + wide)
        if ((k == i .and. l == j) .or. .not. abs(z(k, l)) <= huge(away)) cycle
        n = n + 1
        near(n) = z(k, l)
      end do
    end do
    away = ieee_value(away, ieee_quiet_nan)
    second = 0
    if (n < 3 .or. .not. abs(z(i, j)) <= huge(away)) return
    away = z(i, j) - middle(near(:n))
    off(:n) = abs(z(i, j) - near(:n))
    off(minloc(off(:n), 1)) = huge(second)
    second = minval(off(:n))
  end subroutine distance

  !> Median, by partition.
  pure real(dp) function middle(values)
    real(dp), intent(in) :: values(:)   !< numbers
    real(dp) :: pivot, swap
    real(dp), allocatable :: a(:)
    integer :: low, high, want, i, j
    middle = 0
    if (size(values) == 0) return
    a = values
    want = (size(a) + 1) / 2
    low = 1
    high = size(a)
    do while (low < high)
      pivot = a((low + high) / 2)
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
    middle = a(want)
  end function middle

  !> Fill holes with what bends least: each the mean of its neighbours (Laplace), relaxed until settled.
  subroutine fill_holes(z, hole)
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, ny) [m]
    logical, intent(in) :: hole(:, :)                 !< points to fill
    integer, allocatable :: at(:, :)
    real(dp) :: total, new, change
    logical, allocatable :: known(:, :)
    integer :: i, j, k, n, pass
    if (.not. any(hole)) return
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
        call around(at(1, k), at(2, k), new, i)
        if (i == 0) cycle
        z(at(1, k), at(2, k)) = new / i
        known(at(1, k), at(2, k)) = .true.
        n = n + 1
      end do
      if (n == 0) exit
    end do
    known = .true.
    do pass = 1, 200
      change = 0
      do k = 1, size(at, 2)
        call around(at(1, k), at(2, k), total, n)
        new = z(at(1, k), at(2, k)) + 1.6_dp * (total / n - z(at(1, k), at(2, k)))
        change = max(change, abs(new - z(at(1, k), at(2, k))))
        z(at(1, k), at(2, k)) = new
      end do
      if (change < 1e-6_dp * (maxval(z) - minval(z))) exit
    end do
  contains
    !> Sum and number of known neighbours.
    subroutine around(i, j, total, n)
      integer, intent(in) :: i, j         !< place
      real(dp), intent(out) :: total      !< sum
      integer, intent(out) :: n           !< number
      integer, parameter :: side(2, 4) = reshape([1, 0, -1, 0, 0, 1, 0, -1], [2, 4])
      integer :: l
      total = 0
      n = 0
      do l = 1, 4
        if (i + side(1, l) < 1 .or. i + side(1, l) > size(z, 1) .or. j + side(2, l) < 1 .or. j + side(2, l) > size(z, 2)) cycle
        if (.not. known(i + side(1, l), j + side(2, l))) cycle
        total = total + z(i + side(1, l), j + side(2, l))
        n = n + 1
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
end module hd_holes
