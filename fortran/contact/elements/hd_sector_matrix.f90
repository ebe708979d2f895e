! SPDX-License-Identifier: GPL-3.0-or-later
!> Stiffness of a revolved body, stored for one sector: all others are the same. A product runs over all sectors at once,
!> dof by dof, so its inner loops are contiguous.
module hd_sector_matrix
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use hd_kinds, only: dp
  use hd_body, only: body_t
  implicit none
  private
  public :: hd_sector_product, sector_matrix_t, new_sector_matrix, add_product

  integer, parameter :: long_loop = 100000  !< blocks from which two threads are worth waking

  !> Row a holds the blocks ptr(a):ptr(a+1)-1; the column is node col of the sector `shift` further on.
  type :: sector_matrix_t
    integer :: sectors = 0                  !< of the body
    integer, allocatable :: ptr(:)          !< row pointers (nodes per sector + 1)
    integer, allocatable :: col(:)          !< column nodes of a sector
    integer, allocatable :: shift(:)        !< -1, 0 or 1
    real(dp), allocatable :: val(:, :, :)   !< blocks (3, 3, size(col)) [N/m]
    real(dp) :: largest = 0                 !< entry [N/m]
  end type sector_matrix_t

  interface
    pure subroutine hd_sector_product(most, n, blocks, a, col, shift, v, s) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: most, n, blocks
      integer(c_int), intent(in) :: col(*), shift(*)
      real(c_double), intent(in) :: a(3, 3, *), v(-1:n, 3, *)
      real(c_double), intent(out) :: s(n, 3)
    end subroutine hd_sector_product
  end interface

contains

  !> Sum the cells of one sector.
  pure subroutine new_sector_matrix(body, ke, a)
    type(body_t), intent(in) :: body           !< revolved body
    real(dp), intent(in) :: ke(:, :, :)        !< stiffness of its cells (3 nodes, 3 nodes, cells) [N/m]
    type(sector_matrix_t), intent(out) :: a    !< matrix
    integer :: c, i, j, k, m, row, column, turn
    integer, allocatable :: room(:), used(:), col(:), shift(:)
    real(dp), allocatable :: val(:, :, :)
    m = body%nodes_per_sector
    a%sectors = body%sectors
    allocate (room(m + 1), used(m), source=0)
    do c = 1, size(body%cells, 2)
      do i = 1, size(body%cells, 1)
        row = modulo(body%cells(i, c) - 1, m) + 2
        room(row) = room(row) + size(body%cells, 1)
      end do
    end do
    do i = 1, m
      room(i + 1) = room(i + 1) + room(i)
    end do
    allocate (col(room(m + 1)), shift(room(m + 1)), val(3, 3, room(m + 1)))
    do c = 1, size(body%cells, 2)
      do i = 1, size(body%cells, 1)
        row = modulo(body%cells(i, c) - 1, m) + 1
        do j = 1, size(body%cells, 1)
          column = modulo(body%cells(j, c) - 1, m) + 1
          turn = (body%cells(j, c) - 1)/m - (body%cells(i, c) - 1)/m
          do k = room(row) + 1, room(row) + used(row)
            if (col(k) == column .and. shift(k) == turn) exit
          end do
          if (k > room(row) + used(row)) then
            used(row) = used(row) + 1
            col(k) = column
            shift(k) = turn
            val(:, :, k) = 0
          end if
          val(:, :, k) = val(:, :, k) + ke(3*i - 2:3*i, 3*j - 2:3*j, c)
        end do
      end do
    end do
    allocate (a%ptr(m + 1), a%col(sum(used)), a%shift(sum(used)), a%val(3, 3, sum(used)))
    a%ptr(1) = 1
    do i = 1, m
      a%ptr(i + 1) = a%ptr(i) + used(i)
      associate (from => room(i) + 1, to => room(i) + used(i))
        a%col(a%ptr(i):a%ptr(i + 1) - 1) = col(from:to)
        a%shift(a%ptr(i):a%ptr(i + 1) - 1) = shift(from:to)
        a%val(:, :, a%ptr(i):a%ptr(i + 1) - 1) = val(:, :, from:to)
      end associate
    end do
    a%largest = maxval(abs(a%val))
  end subroutine new_sector_matrix

  !> y = y + A u.
  subroutine add_product(a, u, y)
    type(sector_matrix_t), intent(in) :: a   !< matrix
    real(dp), intent(in) :: u(:, :)          !< nodal vectors of the body (3, nodes)
    real(dp), intent(inout) :: y(:, :)       !< nodal vectors of the body (3, nodes)
    real(dp), allocatable :: v(:, :, :), s(:, :)
    integer :: filled, from, i, j, m, n
    n = a%sectors
    filled = (n + 7)/8*8
    m = size(a%ptr) - 1
    allocate (v(-1:filled, 3, m))
    !$omp parallel private(s, from, i, j) if(size(a%col)*n > long_loop)
    allocate (s(filled, 3))
    !$omp do schedule(static)
    do i = 1, m
      do j = 0, n - 1
        v(j, :, i) = u(:, i + j*m)
      end do
      v(-1, :, i) = v(n - 1, :, i)
      v(n, :, i) = v(0, :, i)
      v(n + 1:, :, i) = 0
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 1, m
      from = a%ptr(i)
      call hd_sector_product(0, filled, a%ptr(i + 1) - from, a%val(:, :, from), a%col(from), a%shift(from), v, s)
      do j = 1, n
        y(:, i + (j - 1)*m) = y(:, i + (j - 1)*m) + s(j, :)
      end do
    end do
    !$omp end do
    !$omp end parallel
  end subroutine add_product
end module hd_sector_matrix
