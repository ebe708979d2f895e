! SPDX-License-Identifier: GPL-3.0-or-later
!> Stiffness of a revolved body, stored for one sector: all others are the same. A product runs over all sectors at once,
!> dof by dof, so its inner loops are contiguous.
module hd_sector_matrix
  use hd_kinds, only: dp
  use hd_body, only: body_t
  implicit none
  private
  public :: sector_matrix_t, new_sector_matrix, add_product

  integer, parameter :: long_loop = 1000000  !< blocks from which two threads are worth waking

  !> Row a holds the blocks ptr(a):ptr(a+1)-1; the column is node col of the sector `shift` further on.
  type :: sector_matrix_t
    integer :: sectors = 0                  !< of the body
    integer, allocatable :: ptr(:)          !< row pointers (nodes per sector + 1)
    integer, allocatable :: col(:)          !< column nodes of a sector
    integer, allocatable :: shift(:)        !< -1, 0 or 1
    real(dp), allocatable :: val(:, :, :)   !< blocks (3, 3, size(col)) [N/m]
  end type sector_matrix_t

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
  end subroutine new_sector_matrix

  !> y = y + A u.
  subroutine add_product(a, u, y)
    type(sector_matrix_t), intent(in) :: a   !< matrix
    real(dp), intent(in) :: u(:, :)          !< nodal vectors of the body (3, nodes)
    real(dp), intent(inout) :: y(:, :)       !< nodal vectors of the body (3, nodes)
    real(dp), allocatable :: v(:, :, :), s(:, :)
    integer :: c, d, i, k, m, n, t
    n = a%sectors
    m = size(a%ptr) - 1
    allocate (v(0:n + 1, 3, m))
    !$omp parallel private(s, c, d, i, k, t) if(size(a%col)*n > long_loop)
    allocate (s(n, 3))
    !$omp do schedule(static)
    do i = 1, m
      do d = 1, 3
        v(1:n, d, i) = u(d, i::m)
        v(0, d, i) = v(n, d, i)
        v(n + 1, d, i) = v(1, d, i)
      end do
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 1, m
      s = 0
      do k = a%ptr(i), a%ptr(i + 1) - 1
        c = a%col(k)
        t = a%shift(k)
        call add_block(n, a%val(:, :, k), v(1 + t, 1, c), v(1 + t, 2, c), v(1 + t, 3, c), s(1, 1), s(1, 2), s(1, 3))
      end do
      do d = 1, 3
        y(d, i::m) = y(d, i::m) + s(:, d)
      end do
    end do
    !$omp end do
    !$omp end parallel
  end subroutine add_product

  !> Add a block times one field to another, three components at once.
  pure subroutine add_block(n, block, x, y, z, p, q, r)
    integer, intent(in) :: n                         !< sectors
    real(dp), intent(in) :: block(3, 3)              !< [N/m]
    real(dp), intent(in) :: x(n), y(n), z(n)         !< components
    real(dp), intent(inout) :: p(n), q(n), r(n)      !< those of the product
    integer :: i
    !$omp simd
    do i = 1, n
      p(i) = p(i) + block(1, 1)*x(i) + block(1, 2)*y(i) + block(1, 3)*z(i)
      q(i) = q(i) + block(2, 1)*x(i) + block(2, 2)*y(i) + block(2, 3)*z(i)
      r(i) = r(i) + block(3, 1)*x(i) + block(3, 2)*y(i) + block(3, 3)*z(i)
    end do
  end subroutine add_block
end module hd_sector_matrix
