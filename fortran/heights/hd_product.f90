! SPDX-License-Identifier: GPL-3.0-or-later
!> The sum of waves as matrix products. cos(kx x + ky y + p) is cos(kx x) cos(ky y + p) - sin(kx x) sin(ky y + p): rank two.
!>
!> Two symmetries cut the work of the plain product (N x 2J x N) to a quarter. Waves of one |kx| (ridges m and M - m) share their
!> factors in x. And with x counted from the middle of the grid cos is even, sin odd: each half of a row is the sum or the
!> difference of two products of half the width.
!>
!> BLAS adds in an order of its own on each processor. It is given slices of the factors that it adds without rounding (hd_slices);
!> what it returns is added here: the heights are the same bits everywhere.
module hd_product
  use hd_exact, only: add_row
  use hd_kinds, only: dp
  use hd_lapack, only: multiply_transposed, blas_threads
  use hd_slices, only: slices_t, new_slices, split
  use hd_waves, only: waves_t, grid_t, turns_on_grid, split_turns
  implicit none
  private
  public :: product_t, new_product, product_sum

  integer, parameter :: tile_points = 32768     !< heights of a tile

  !> Factors in x, and what the factors in y are made of. Columns of a block of groups: all first slices, then all second ones.
  type :: product_t
    real(dp), allocatable :: even(:, :), odd(:, :)    !< cos and sin of kx x (half of nx, 2 groups)
    real(dp), allocatable :: high(:), low(:)          !< turns per half step in y (waves)
    real(dp), allocatable :: phase(:)                 !< phase at the middle of the grid [turns] (waves)
    real(dp), allocatable :: amplitude(:)             !< amplitude [unit], negative (waves)
    real(dp), allocatable :: mirror(:)                !< amplitude times the sign of kx (waves)
    integer, allocatable :: first(:), order(:)        !< waves of group k: order(first(k) .. first(k + 1) - 1)
    type(slices_t) :: slices                          !< blocks of groups, quanta
    integer :: ny = 0                                 !< rows of the whole grid
    real(dp) :: unit = 1                              !< power of two [m]
    real(dp) :: offset = 0                            !< constant height [m]
  end type product_t

contains

  !> Factors for a grid.
  subroutine new_product(w, g, p)
    type(waves_t), intent(in) :: w       !< waves
    type(grid_t), intent(in) :: g        !< grid
    type(product_t), intent(out) :: p    !< factors
    real(dp), allocatable :: ux(:), ux_2(:), uy(:), uy_2(:), xh(:), xl(:)
    integer :: n, j
    n = size(w%amplitude)
    allocate (ux(n), ux_2(n), uy(n), uy_2(n), p%phase(n), xh(w%groups), xl(w%groups), p%high(n), p%low(n), p%mirror(n))
    call turns_on_grid(w, g, 0.5_dp * (g%nx - 1), 0.5_dp * (g%ny - 1), ux, ux_2, uy, uy_2, p%phase)
    call split_turns(uy / 2, uy_2 / 2, p%high, p%low)
    p%unit = scale(1._dp, max(-1000, min(1000, exponent(maxval(abs(w%amplitude))))))
    p%amplitude = -w%amplitude / p%unit
    do j = 1, n
      call split_turns(abs(ux(j)) / 2, sign(0.5_dp, ux(j)) * ux_2(j), xh(w%group(j)), xl(w%group(j)))
      p%mirror(j) = merge(p%amplitude(j), -p%amplitude(j), ux(j) < 0)
    end do
    p%ny = g%ny
    p%offset = w%offset
    call order_waves(w, p)
    call factors_in_x(g%nx, xh, xl, p)
  end subroutine new_product

  !> Waves by group, and the slices for the sums of their amplitudes.
  subroutine order_waves(w, p)
    type(waves_t), intent(in) :: w         !< waves
    type(product_t), intent(inout) :: p    !< factors
    real(dp) :: bound(w%groups)
    integer :: next(w%groups), j, k
    allocate (p%first(w%groups + 1), source=0)
    allocate (p%order(size(w%group)))
    bound = 0
    do j = 1, size(w%group)
      k = w%group(j)
      p%first(k + 1) = p%first(k + 1) + 1
      bound(k) = bound(k) + abs(p%amplitude(j))
    end do
    p%first(1) = 1
    do k = 1, w%groups
      p%first(k + 1) = p%first(k) + p%first(k + 1)
    end do
    next = p%first(:w%groups)
    do j = 1, size(w%group)
      k = w%group(j)
      p%order(next(k)) = j
      next(k) = next(k) + 1
    end do
    p%slices = new_slices(bound)
  end subroutine order_waves

  !> Slices of cos and sin of kx x.
  subroutine factors_in_x(nx, high, low, p)
    integer, intent(in) :: nx                      !< points
    real(dp), intent(in) :: high(:), low(:)        !< turns per half step (groups)
    type(product_t), intent(inout) :: p            !< factors
    real(dp), allocatable :: even(:), odd(:)
    integer :: b, k, half
    half = (nx + 1) / 2
    allocate (p%even(half, 2 * size(high)), p%odd(half, 2 * size(high)))
    !$omp parallel do private(k, even, odd) schedule(dynamic) if (size(p%even) > 400000)
    do b = 1, size(p%slices%first) - 1
      do k = p%slices%first(b), p%slices%first(b + 1) - 1
        even = spread(0._dp, 1, half)
        odd = even
        call add_row(half, 0._dp, high(k), low(k), mod(nx + 1, 2), 1._dp, 1._dp, even, odd)
        associate (i => k + p%slices%first(b) - 1, j => k + p%slices%first(b + 1) - 1)
          call split(even, p%slices%x(:, k), p%even(:, i), p%even(:, j))
          call split(odd, p%slices%x(:, k), p%odd(:, i), p%odd(:, j))
        end associate
      end do
    end do
  end subroutine factors_in_x

  !> Heights [m] of rows j_1 .. j_1 + size(z, 2) - 1, in tiles that stay in the cache, BLAS with one thread for each.
  subroutine product_sum(p, j_1, z)
    type(product_t), intent(in) :: p                  !< factors
    integer, intent(in) :: j_1                        !< first row
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, rows) [m]
    integer :: j, rows, threads
    rows = max(64, tile_points / size(z, 1))
    threads = blas_threads(1)
    !$omp parallel do schedule(dynamic) if (size(z, 2) > rows)
    do j = 1, size(z, 2), rows
      call product_tile(p, j_1 + j - 1, z(:, j:min(j + rows - 1, size(z, 2))))
    end do
    threads = blas_threads(threads)
  end subroutine product_sum

  !> Heights of a tile.
  subroutine product_tile(p, j_1, z)
    type(product_t), intent(in) :: p                  !< factors
    integer, intent(in) :: j_1                        !< first row
    real(dp), intent(inout), contiguous :: z(:, :)    !< heights (nx, rows) [m]
    real(dp), allocatable :: a(:, :), b(:, :), e(:, :), o(:, :)
    integer :: rows, half, nx, i, j, block, groups, last
    rows = size(z, 2)
    nx = size(z, 1)
    half = size(p%even, 1)
    allocate (e(half, rows), o(half, rows), source=0._dp)
    last = 0
    do block = 1, size(p%slices%first) - 1
      groups = p%slices%first(block + 1) - p%slices%first(block)
      allocate (a(rows, 2 * groups), b(rows, 2 * groups))
      call factors_in_y(p, block, j_1, a, b)
      call add_product(p%even(:, last + 1:last + 2 * groups), a, e)
      call add_product(p%odd(:, last + 1:last + 2 * groups), b, o)
      deallocate (a, b)
      last = last + 2 * groups
    end do
    do j = 1, rows
      do i = 1, nx / 2
        z(i, j) = p%offset + p%unit * (e(half + 1 - i, j) - o(half + 1 - i, j))
      end do
      do i = 1, half
        z(nx - half + i, j) = p%offset + p%unit * (e(i, j) + o(i, j))
      end do
    end do
  end subroutine product_tile

  !> Factors in y of a block's groups: all second slices, then all first ones.
  subroutine factors_in_y(p, block, j_1, a, b)
    type(product_t), intent(in) :: p                  !< factors
    integer, intent(in) :: block                      !< block
    integer, intent(in) :: j_1                        !< first row
    real(dp), intent(out), contiguous :: a(:, :), b(:, :)   !< factors of cos and sin of kx x (rows, 2 groups) [unit]
    real(dp) :: even(size(a, 1)), odd(size(a, 1))
    integer :: groups, i, j, k, l
    groups = size(a, 2) / 2
    do i = 1, groups
      k = p%slices%first(block) + i - 1
      even = 0
      odd = 0
      do l = p%first(k), p%first(k + 1) - 1
        j = p%order(l)
        call add_row(size(a, 1), p%phase(j), p%high(j), p%low(j), 2 * (j_1 - 1) - (p%ny - 1), p%amplitude(j), p%mirror(j), &
          even, odd)
      end do
      call split(even, p%slices%y(:, k), a(:, groups + i), a(:, i))
      call split(odd, p%slices%y(:, k), b(:, groups + i), b(:, i))
    end do
  end subroutine factors_in_y

  !> total + x y^T, the product of two second slices left out.
  subroutine add_product(x, y, total)
    real(dp), intent(in), contiguous :: x(:, :)          !< first slices, second slices (half of nx, 2 groups)
    real(dp), intent(in), contiguous :: y(:, :)          !< second slices, first slices (rows, 2 groups)
    real(dp), intent(inout), contiguous :: total(:, :)   !< sum (half of nx, rows)
    real(dp), allocatable :: first(:, :), cross(:, :)
    integer :: n
    n = size(x, 2) / 2
    allocate (first, cross, mold=total)
    call multiply_transposed(x(:, :n), y(:, n + 1:), first)
    call multiply_transposed(x, y, cross)
    total = total + (first + cross)
  end subroutine add_product
end module hd_product
