! SPDX-License-Identifier: GPL-3.0-or-later
!> METIS: fill-reducing ordering of a graph by nested dissection (Karypis and Kumar 1998).
module hd_metis
  use, intrinsic :: iso_c_binding, only: c_int32_t, c_ptr, c_null_ptr, c_loc
  use hd_error, only: error_t, raise, code_memory
  implicit none
  private
  public :: nested_dissection

  interface
    integer(c_int32_t) function metis_nodend(n, xadj, adjncy, weight, options, perm, iperm) bind(c, name='METIS_NodeND')
      import :: c_int32_t, c_ptr
      integer(c_int32_t), intent(in) :: n, xadj(*), adjncy(*)
      type(c_ptr), value :: weight, options
      integer(c_int32_t), intent(out) :: perm(*), iperm(*)
    end function metis_nodend
  end interface

contains

  !> Position of each vertex in the elimination order.
  subroutine nested_dissection(ptr, col, weight, position, error)
    integer, intent(in) :: ptr(:)                !< row pointers from 1 (n + 1)
    integer, intent(in) :: col(:)                !< neighbours from 1, loops allowed
    integer, intent(in), target :: weight(:)     !< unknowns per vertex (n)
    integer, intent(out) :: position(:)          !< place of each vertex in the order, from 1 (n)
    type(error_t), allocatable, intent(out) :: error
    integer(c_int32_t), allocatable :: xadj(:), adjncy(:), perm(:)
    integer(c_int32_t) :: status
    integer :: i, k, n, m
    n = size(ptr) - 1
    allocate (xadj(n + 1), adjncy(max(1, size(col))), perm(n))
    m = 0
    xadj(1) = 0
    do i = 1, n
      do k = ptr(i), ptr(i + 1) - 1
        if (col(k) == i) cycle
        m = m + 1
        adjncy(m) = col(k) - 1
      end do
      xadj(i + 1) = m
    end do
    status = metis_nodend(n, xadj, adjncy, c_loc(weight), c_null_ptr, perm, position)
    if (status /= 1) call raise(error, code_memory, 'METIS could not order the matrix (out of memory?): use a coarser mesh')
    position = position + 1
  end subroutine nested_dissection
end module hd_metis
