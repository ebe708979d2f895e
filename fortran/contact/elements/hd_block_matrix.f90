! SPDX-License-Identifier: GPL-3.0-or-later
!> Sparse symmetric matrix of 3 x 3 node blocks, both triangles stored row by row.
module hd_block_matrix
  use hd_kinds, only: dp
  implicit none
  private
  public :: block_matrix_t, graph_from_cells, cell_places, add_cell, largest_diagonal, multiply

  !> Row a holds the blocks of nodes col(ptr(a):ptr(a+1)-1), ascending.
  type :: block_matrix_t
    integer :: n = 0                        !< nodes
    integer, allocatable :: ptr(:)          !< row pointers (n + 1)
    integer, allocatable :: col(:)          !< column nodes
    integer, allocatable :: own(:)          !< place of each node's block on the diagonal (n)
    real(dp), allocatable :: val(:, :, :)   !< blocks (3, 3, size(col))
  end type block_matrix_t

contains

  !> Pattern of all node pairs that share a cell; values are zero.
  subroutine graph_from_cells(n, cells, a)
    integer, intent(in) :: n                   !< nodes
    integer, intent(in) :: cells(:, :)         !< (nodes per cell, cells)
    type(block_matrix_t), intent(out) :: a     !< matrix with its pattern
    integer, allocatable :: first(:), list(:), mark(:), row(:)
    integer :: c, i, j, k, m, pass
    allocate (first(n + 1), source=0)
    do c = 1, size(cells, 2)
      do i = 1, size(cells, 1)
        first(cells(i, c) + 1) = first(cells(i, c) + 1) + 1
      end do
    end do
    do i = 1, n
      first(i + 1) = first(i + 1) + first(i)
    end do
    allocate (list(first(n + 1)), mark(n))
    mark = first(:n)
    do c = 1, size(cells, 2)
      do i = 1, size(cells, 1)
        k = cells(i, c)
        mark(k) = mark(k) + 1
        list(mark(k)) = c
      end do
    end do
    allocate (a%ptr(n + 1), row(n))
    a%n = n
    do pass = 1, 2
      mark = 0
      a%ptr(1) = 1
      do i = 1, n
        m = 0
        do k = first(i) + 1, first(i + 1)
          do j = 1, size(cells, 1)
            c = cells(j, list(k))
            if (mark(c) == i) cycle
            mark(c) = i
            m = m + 1
            row(m) = c
          end do
        end do
        a%ptr(i + 1) = a%ptr(i) + m
        if (pass == 2) then
          call sort(row(:m))
          a%col(a%ptr(i):a%ptr(i) + m - 1) = row(:m)
        end if
      end do
      if (pass == 1) allocate (a%col(a%ptr(n + 1) - 1))
    end do
    a%own = [(find(a, i, i), i=1, n)]
    allocate (a%val(3, 3, size(a%col)), source=0._dp)
  end subroutine graph_from_cells

  !> Insertion sort of a short list.
  pure subroutine sort(list)
    integer, intent(inout) :: list(:)  !< sorted ascending on return
    integer :: i, j, key
    do i = 2, size(list)
      key = list(i)
      j = i - 1
      do while (j >= 1)
        if (list(j) <= key) exit
        list(j + 1) = list(j)
        j = j - 1
      end do
      list(j + 1) = key
    end do
  end subroutine sort

  !> Places of the blocks of one cell.
  pure function cell_places(a, nodes) result(place)
    type(block_matrix_t), intent(in) :: a  !< matrix
    integer, intent(in) :: nodes(:)        !< nodes of the cell
    integer :: place(size(nodes), size(nodes)), i, j
    do j = 1, size(nodes)
      do i = 1, size(nodes)
        place(i, j) = find(a, nodes(i), nodes(j))
      end do
    end do
  end function cell_places

  !> Add the stiffness of one cell.
  pure subroutine add_cell(a, place, ke)
    type(block_matrix_t), intent(inout) :: a  !< matrix
    integer, intent(in) :: place(:, :)        !< of its blocks
    real(dp), intent(in) :: ke(:, :)          !< stiffness (3 nodes, 3 nodes)
    integer :: i, j, k
    do i = 1, size(place, 1)
      do j = 1, size(place, 1)
        k = place(i, j)
        a%val(:, :, k) = a%val(:, :, k) + ke(3*i - 2:3*i, 3*j - 2:3*j)
      end do
    end do
  end subroutine add_cell

  !> Position of block (row, column), by bisection.
  pure integer function find(a, row, column) result(k)
    type(block_matrix_t), intent(in) :: a  !< matrix
    integer, intent(in) :: row             !< row node
    integer, intent(in) :: column          !< column node, present in the row
    integer :: hi
    k = a%ptr(row)
    hi = a%ptr(row + 1) - 1
    do while (k < hi)
      if (a%col((k + hi)/2) < column) then
        k = (k + hi)/2 + 1
      else
        hi = (k + hi)/2
      end if
    end do
  end function find

  !> Largest entry of the diagonal; that of a definite matrix is the largest of all.
  pure real(dp) function largest_diagonal(a) result(most)
    type(block_matrix_t), intent(in) :: a  !< matrix
    integer :: c, i
    most = 0
    do i = 1, a%n
      do c = 1, 3
        most = max(most, abs(a%val(c, c, a%own(i))))
      end do
    end do
  end function largest_diagonal

  !> y = A u.
  pure function multiply(a, u) result(y)
    type(block_matrix_t), intent(in) :: a  !< matrix
    real(dp), intent(in) :: u(:, :)        !< (3, n)
    real(dp) :: y(3, size(u, 2)), s(3)
    integer :: i, k
    do i = 1, a%n
      s = 0
      do k = a%ptr(i), a%ptr(i + 1) - 1
        s = s + a%val(:, 1, k)*u(1, a%col(k)) + a%val(:, 2, k)*u(2, a%col(k)) + a%val(:, 3, k)*u(3, a%col(k))
      end do
      y(:, i) = s
    end do
  end function multiply
end module hd_block_matrix
