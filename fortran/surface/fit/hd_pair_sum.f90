! SPDX-License-Identifier: GPL-3.0-or-later
!> Sums of squared differences of a map over pairs of points, by direct subtraction: exact to rounding at any lag, since
!> offset and tilt cancel before anything is squared. Points that are not finite are holes and take no part. Partial sums are
!> kept per row and added in a fixed order: the result is the same for any number of threads.
module hd_pair_sum
  use hd_kinds, only: dp, i8
  implicit none
  private
  public :: pair_sum, pair_sum_lines, second_sum, has_holes

contains

  !> True if a point is NaN or infinite.
  logical function has_holes(z)
    real(dp), intent(in), contiguous :: z(:, :)   !< heights (nx, ny) [m]
    integer :: j
    logical :: hole
    hole = .false.
    !$omp parallel do reduction(.or.: hole) if (size(z, kind=i8) > 100000)
    do j = 1, size(z, 2)
      hole = hole .or. .not. all(abs(z(:, j)) <= huge(1._dp))
    end do
    has_holes = hole
  end function has_holes

  !> Sum of (z(x + k) - z(x))^2 over all pairs at one lag vector, and their number.
  subroutine pair_sum(z, kx, ky, holes, total, count)
    real(dp), intent(in), contiguous :: z(:, :)   !< heights (nx, ny) [m]
    integer, intent(in) :: kx, ky                 !< lag in points; ky >= 0
    logical, intent(in) :: holes                  !< look for holes
    real(dp), intent(out) :: total, count         !< sum [m^2], number of pairs
    real(dp) :: t(size(z, 2)), c(size(z, 2))
    integer :: j, a, b
    a = max(1, 1 - kx)
    b = min(size(z, 1), size(z, 1) - kx)
    t = 0
    c = 0
    !$omp parallel do if (size(z, kind=i8) > 100000)
    do j = 1, size(z, 2) - ky
      if (b < a) cycle
      call add_pairs(z(a:b, j), z(a + kx:b + kx, j + ky), holes, t(j), c(j))
    end do
    total = sum(t)
    count = sum(c)
  end subroutine pair_sum

  !> Sums at several lags along the first index, each line of points read once.
  subroutine pair_sum_lines(z, lags, holes, total, count)
    real(dp), intent(in), contiguous :: z(:, :)   !< heights (nx, ny) [m]
    integer, intent(in) :: lags(:)                !< lags in points, >= 1
    logical, intent(in) :: holes                  !< look for holes
    real(dp), intent(out) :: total(:), count(:)   !< sums [m^2], numbers of pairs
    integer, parameter :: block = 32
    real(dp), allocatable :: t(:, :), c(:, :)
    real(dp) :: s, n
    integer :: b, i, j, k, blocks
    blocks = (size(z, 2) + block - 1) / block
    allocate (t(size(lags), blocks), c(size(lags), blocks), source=0._dp)
    !$omp parallel do private(i, j, k, s, n) schedule(dynamic) if (size(z, kind=i8) > 20000)
    do b = 1, blocks
      do j = 1 + (b - 1) * block, min(b * block, size(z, 2))
        do i = 1, size(lags)
          k = lags(i)
          if (k >= size(z, 1)) cycle
          call add_pairs(z(:size(z, 1) - k, j), z(1 + k:, j), holes, s, n)
          t(i, b) = t(i, b) + s
          c(i, b) = c(i, b) + n
        end do
      end do
    end do
    total = sum(t, 2)
    count = sum(c, 2)
  end subroutine pair_sum_lines

  !> One line of pairs.
  pure subroutine add_pairs(a, b, holes, total, count)
    real(dp), intent(in), contiguous :: a(:), b(:)  !< heights of first and second points [m]
    logical, intent(in) :: holes                    !< look for holes
    real(dp), intent(out) :: total, count           !< sum [m^2], number
    real(dp) :: d, s, n
    integer :: i
    logical :: good
    s = 0
    n = 0
    if (holes) then
      !$omp simd reduction(+: s, n) private(d, good)
      do i = 1, size(a)
        d = b(i) - a(i)
        good = abs(d) <= huge(1._dp)
        s = s + merge(d * d, 0._dp, good)
        n = n + merge(1._dp, 0._dp, good)
      end do
    else
      !$omp simd reduction(+: s) private(d)
      do i = 1, size(a)
        d = b(i) - a(i)
        s = s + d * d
      end do
      n = size(a)
    end if
    total = s
    count = n
  end subroutine add_pairs

  !> Sum of (z(x + k) - 2 z(x) + z(x - k))^2 over all triples at one lag vector: blind to tilt.
  subroutine second_sum(z, kx, ky, total, count)
    real(dp), intent(in), contiguous :: z(:, :)   !< heights (nx, ny) [m]
    integer, intent(in) :: kx, ky                 !< lag in points; ky >= 0
    real(dp), intent(out) :: total, count         !< sum [m^2], number of triples
    real(dp) :: t(size(z, 2)), c(size(z, 2)), d, s, n
    integer :: i, j
    logical :: good
    t = 0
    c = 0
    !$omp parallel do private(i, d, s, n, good) if (size(z, kind=i8) > 100000)
    do j = 1 + ky, size(z, 2) - ky
      s = 0
      n = 0
      !$omp simd reduction(+: s, n) private(d, good)
      do i = 1 + abs(kx), size(z, 1) - abs(kx)
        d = (z(i + kx, j + ky) - z(i, j)) - (z(i, j) - z(i - kx, j - ky))
        good = abs(d) <= huge(1._dp)
        s = s + merge(d * d, 0._dp, good)
        n = n + merge(1._dp, 0._dp, good)
      end do
      t(j) = s
      c(j) = n
    end do
    total = sum(t)
    count = sum(c)
  end subroutine second_sum
end module hd_pair_sum
