! SPDX-License-Identifier: GPL-3.0-or-later
!> The sum of waves as matrix products. cos(kx x + ky y + p) is cos(kx x) cos(ky y + p) - sin(kx x) sin(ky y + p): rank two.
!>
!> Two symmetries cut the work of the plain product (N x 2J x N) to a quarter. Waves of one |kx| (ridges m and M - m) share their
!> factors in x. And with x counted from the middle of the grid cos is even, sin odd: each half of a row is the sum or the
!> difference of two products of half the width.
module hd_product
  use hd_kinds, only: dp
  use hd_lapack, only: multiply_transposed, blas_threads
  use hd_spread, only: add_row
  use hd_waves, only: waves_t, grid_t, turns_on_grid, split_turns
  implicit none
  private
  public :: product_t, new_product, product_sum

  integer, parameter :: tile_points = 131072    !< heights of a tile

  !> Factors in x, and what the factors in y are made of.
  type :: product_t
    real(dp), allocatable :: even(:, :), odd(:, :)    !< cos and sin of kx x (half of nx, groups)
    real(dp), allocatable :: high(:), low(:)          !< turns per half step in y (waves)
    real(dp), allocatable :: phase(:)                 !< phase at the middle of the grid [turns] (waves)
    real(dp), allocatable :: amplitude(:)             !< amplitude [m], negative (waves)
    real(dp), allocatable :: mirror(:)                !< amplitude times the sign of kx (waves)
    integer, allocatable :: first(:), order(:)        !< waves of group k: order(first(k) .. first(k + 1) - 1)
    integer :: ny = 0                                 !< rows of the whole grid
    real(dp) :: offset = 0                            !< constant height [m]
  end type product_t

contains

  !> Factors for a grid.
  subroutine new_product(w, g, p)
    type(waves_t), intent(in) :: w       !< waves
    type(grid_t), intent(in) :: g        !< grid
    type(product_t), intent(out) :: p    !< factors
    real(dp), allocatable :: ux(:), ux_2(:), uy(:), uy_2(:), xh(:), xl(:)
    integer, allocatable :: next(:)
    integer :: n, j, k
    n = size(w%amplitude)
    allocate (ux(n), ux_2(n), uy(n), uy_2(n), p%phase(n), xh(w%groups), xl(w%groups), p%high(n), p%low(n), p%mirror(n))
    call turns_on_grid(w, g, 0.5_dp * (g%nx - 1), 0.5_dp * (g%ny - 1), ux, ux_2, uy, uy_2, p%phase)
    call split_turns(uy / 2, uy_2 / 2, p%high, p%low)
    p%amplitude = -w%amplitude
    allocate (p%first(w%groups + 1), source=0)
    do j = 1, n
      k = w%group(j)
      p%first(k + 1) = p%first(k + 1) + 1
      call split_turns(abs(ux(j)) / 2, sign(0.5_dp, ux(j)) * ux_2(j), xh(k), xl(k))
      p%mirror(j) = merge(p%amplitude(j), -p%amplitude(j), ux(j) < 0)
    end do
    p%first(1) = 1
    do k = 1, w%groups
      p%first(k + 1) = p%first(k) + p%first(k + 1)
    end do
    next = p%first
    allocate (p%order(n))
    do j = 1, n
      p%order(next(w%group(j))) = j
      next(w%group(j)) = next(w%group(j)) + 1
    end do
    p%ny = g%ny
    p%offset = w%offset
    allocate (p%even((g%nx + 1) / 2, w%groups), p%odd((g%nx + 1) / 2, w%groups))
    !$omp parallel do schedule(static) if (size(p%even) > 200000)
    do j = 1, w%groups
      p%even(:, j) = 0
      p%odd(:, j) = 0
      call add_row(size(p%even, 1), 0._dp, xh(j), xl(j), mod(g%nx + 1, 2), 1._dp, 1._dp, p%even(:, j), p%odd(:, j))
    end do
  end subroutine new_product

  !> Heights [m] of rows j_1 .. j_1 + size(z, 2) - 1, in tiles that stay in the cache. Tiles do not depend on the number of threads,
  !> and BLAS uses one for each, so heights do not either.
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
    integer :: rows, groups, half, nx, i, j, k, l
    rows = size(z, 2)
    nx = size(z, 1)
    half = size(p%even, 1)
    groups = size(p%even, 2)
    allocate (a(rows, groups), b(rows, groups), e(half, rows), o(half, rows))
    do k = 1, groups
      a(:, k) = 0
      b(:, k) = 0
      do l = p%first(k), p%first(k + 1) - 1
        j = p%order(l)
        call add_row(rows, p%phase(j), p%high(j), p%low(j), 2 * (j_1 - 1) - (p%ny - 1), p%amplitude(j), p%mirror(j), &
          a(:, k), b(:, k))
      end do
    end do
    call multiply_transposed(p%even, a, e)
    call multiply_transposed(p%odd, b, o)
    do j = 1, rows
      do i = 1, nx / 2
        z(i, j) = p%offset + e(half + 1 - i, j) - o(half + 1 - i, j)
      end do
      do i = 1, half
        z(nx - half + i, j) = p%offset + e(i, j) + o(i, j)
      end do
    end do
  end subroutine product_tile
end module hd_product
