! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat entries for Python: elastic bodies of the caller's own meshes, alone or in contact, held by handle. Fields have names
!> (hd_solid_entry) and cross as plain lists of numbers, first index fastest.
module f2py_solid
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use hd_error, only: error_t
  use hd_solid_entry, only: put_solid, field_t, solid_t, find_solid, drop_solid
  use hd_status, only: tell
  implicit none
  private
  public :: solid_open, solid_put, solid_solve, solid_size, solid_get, solid_close

contains

  !> Open a problem; an empty mode: linear statics.
  subroutine solid_open(element, mode, handle, status)
    character(len=*), intent(in) :: element, mode
    integer(c_int), intent(out) :: handle, status
    type(error_t), allocatable :: error
    call put_solid(trim(element), trim(mode), handle, error)
    call tell(error, status)
  end subroutine solid_open

  !> Enter a field.
  subroutine solid_put(handle, name, values, n, status)
    integer(c_int), intent(in) :: handle, n
    character(len=*), intent(in) :: name
    real(c_double), intent(in) :: values(n)
    integer(c_int), intent(out) :: status
    !f2py integer(c_int), intent(hide), depend(values) :: n = len(values)
    type(solid_t), pointer :: solid
    type(field_t), pointer :: field
    type(error_t), allocatable :: error
    call find_solid(handle, solid, error)
    if (.not. allocated(error)) call solid%field(name, field, error)
    if (.not. allocated(error)) field%values = values
    call tell(error, status)
  end subroutine solid_put

  !> Solve.
  subroutine solid_solve(handle, status)
    integer(c_int), intent(in) :: handle
    integer(c_int), intent(out) :: status
    !f2py threadsafe
    type(solid_t), pointer :: solid
    type(error_t), allocatable :: error
    call find_solid(handle, solid, error)
    if (.not. allocated(error)) call solid%solve(error)
    call tell(error, status)
  end subroutine solid_solve

  !> How many numbers a field has, 0 before it is entered.
  subroutine solid_size(handle, name, n, status)
    integer(c_int), intent(in) :: handle
    character(len=*), intent(in) :: name
    integer(c_int), intent(out) :: n, status
    type(solid_t), pointer :: solid
    type(field_t), pointer :: field
    type(error_t), allocatable :: error
    call find_solid(handle, solid, error)
    if (.not. allocated(error)) call solid%field(name, field, error)
    if (.not. allocated(error)) n = field%count()
    call tell(error, status)
  end subroutine solid_size

  !> The numbers of a field; `n` is its size.
  subroutine solid_get(handle, name, n, values, status)
    integer(c_int), intent(in) :: handle, n
    character(len=*), intent(in) :: name
    real(c_double), intent(out) :: values(n)
    integer(c_int), intent(out) :: status
    type(solid_t), pointer :: solid
    type(field_t), pointer :: field
    type(error_t), allocatable :: error
    values = 0
    call find_solid(handle, solid, error)
    if (.not. allocated(error)) call solid%field(name, field, error)
    if (.not. allocated(error)) then
      if (allocated(field%values)) values = field%values(:n)
    end if
    call tell(error, status)
  end subroutine solid_get

  !> Forget a problem.
  subroutine solid_close(handle)
    integer(c_int), intent(in) :: handle
    call drop_solid(handle)
  end subroutine solid_close
end module f2py_solid
