! SPDX-License-Identifier: GPL-3.0-or-later
!> The sum of waves as matrix products (hd_factors), the same bits everywhere.
!>
!> BLAS adds in an order of its own on each processor. It is given slices of the factors that it adds without rounding (hd_slices);
!> what it returns is added here.
module hd_product
  use hd_exact, only: add_row
  use hd_kinds, only: dp
  use hd_lapack, only: multiply_transposed, blas_threads
  use hd_factors, only: factors_t, new_factors
  use hd_slices, only: slices_t, new_slices, split
  use hd_waves, only: waves_t, grid_t
  implicit none
  private
  public :: product_t, new_product, product_sum

  integer, parameter :: tile_points = 32768     !< heights of a tile

  !> Factors in x, and what the factors in y are made of. Columns of a block of groups: all first slices, then all second ones.
  type :: product_t
    real(dp), allocatable :: even(:, :), odd(:, :)    !< cos and sin of kx x (half of nx, 2 groups)
    type(factors_t) :: f                              !< waves on the grid
    type(slices_t) :: slices                          !< blocks of groups, quanta
  end type product_t

contains

  !> Factors for a grid.
  subroutine new_product(w, g, p)
    type(waves_t), intent(in) :: w       !< waves
    type(grid_t), intent(in) :: g        !< grid
    type(product_t), intent(out) :: p    !< factors
    integer :: k
    call new_factors(w, g, p%f)
    p%slices = new_slices([(sum(abs(p%f%amplitude(p%f%first(k):p%f%first(k + 1) - 1))), k=1, w%groups)])
    call factors_in_x(p)
  end subroutine new_product

  !> Slices of cos and sin of kx x.
  subroutine factors_in_x(p)
    type(product_t), intent(inout) :: p            !< factors
    real(dp), allocatable :: even(:), odd(:)
    integer :: b, k, half
    half = (p%f%nx + 1) / 2
    allocate (p%even(half, 2 * size(p%f%x_high)), p%odd(half, 2 * size(p%f%x_high)))
    !$omp parallel do private(k, even, odd) schedule(dynamic) if (size(p%even) > 400000)
    do b = 1, size(p%slices%first) - 1
      do k = p%slices%first(b), p%slices%first(b + 1) - 1
        even = spread(0._dp, 1, half)
        odd = even
        call add_row(half, 0._dp, p%f%x_high(k), p%f%x_low(k), mod(p%f%nx + 1, 2), 1._dp, 1._dp, even, odd)
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
        z(i, j) = p%f%offset + p%f%unit * (e(half + 1 - i, j) - o(half + 1 - i, j))
      end do
      do i = 1, half
        z(nx - half + i, j) = p%f%offset + p%f%unit * (e(i, j) + o(i, j))
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
    integer :: groups, i, j, k
    groups = size(a, 2) / 2
    do i = 1, groups
      k = p%slices%first(block) + i - 1
      even = 0
      odd = 0
      do j = p%f%first(k), p%f%first(k + 1) - 1
        call add_row(size(a, 1), p%f%phase(j), p%f%high(j), p%f%low(j), 2 * (j_1 - 1) - (p%f%ny - 1), p%f%amplitude(j), &
          p%f%mirror(j), even, odd)
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
