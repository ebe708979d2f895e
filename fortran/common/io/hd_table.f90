! SPDX-License-Identifier: GPL-3.0-or-later
!> CSV tables, written row by row.
module hd_table
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_checksum, only: checksum, file_checksum
  use hd_error, only: error_t, raise, code_file
  use hd_system, only: truncate_file
  use hd_text, only: to_text
  implicit none
  private
  public :: table_t

  type :: table_t
    private
    integer :: unit = -1
    character(len=:), allocatable :: path
    character(len=:), allocatable :: line   !< the row so far, longer than that
    integer :: used = 0                     !< characters of it
    integer(int64), public :: sum = 0       !< checksum of what has been written
  contains
    procedure :: open => open_table
    procedure :: reopen
    procedure :: bytes
    generic :: add => add_integer, add_real, add_text
    procedure, private :: add_integer, add_real, add_text, begin_row
    procedure :: end_row
    procedure :: close => close_table
  end type table_t

  interface
    integer(c_int) function c_decimal(x, text) bind(c, name='hd_decimal')
      import :: c_char, c_double, c_int
      real(c_double), value :: x
      character(kind=c_char), intent(out) :: text(*)
    end function c_decimal
  end interface

contains

  !> Start a table with its header.
  subroutine open_table(self, path, columns, error)
    class(table_t), intent(inout) :: self             !< table
    character(len=*), intent(in) :: path              !< file
    character(len=*), intent(in) :: columns           !< names joined by commas
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    integer :: status
    self%path = path
    call self%begin_row()
    open (newunit=self%unit, file=path, access='stream', form='unformatted', action='write', status='replace', iostat=status)
    if (status == 0) write (self%unit, iostat=status) columns//new_line('a')
    self%sum = checksum(columns//new_line('a'))
    if (status /= 0) call raise(error, code_file, "cannot write '"//path//"'")
  end subroutine open_table

  !> Take up a table again behind its first bytes; what stands there is lost.
  subroutine reopen(self, path, bytes, sum, error)
    class(table_t), intent(inout) :: self             !< table
    character(len=*), intent(in) :: path              !< file
    integer(int64), intent(in) :: bytes               !< that stay
    integer(int64), intent(in) :: sum                 !< their checksum
    type(error_t), allocatable, intent(out) :: error  !< absent, shorter already, changed, cannot be written
    integer :: status
    logical :: good
    self%path = path
    call self%begin_row()
    call truncate_file(path, bytes, error)
    if (allocated(error)) return
    call file_checksum(path, bytes, self%sum, good)
    if (.not. good .or. self%sum /= sum) then
      call raise(error, code_file, "'"//path//"' is not as the run left it (its checksum differs): begin anew with --force")
      return
    end if
    open (newunit=self%unit, file=path, access='stream', form='unformatted', action='write', status='old', position='append', &
      iostat=status)
    if (status /= 0) call raise(error, code_file, "cannot write '"//path//"'")
  end subroutine reopen

  !> Length of the file so far; 0 for a table that is not open.
  integer(int64) function bytes(self)
    class(table_t), intent(in) :: self  !< table
    bytes = 0
    if (self%unit == -1) return
    flush (self%unit)
    inquire (unit=self%unit, size=bytes)
  end function bytes

  !> An empty row.
  subroutine begin_row(self)
    class(table_t), intent(inout) :: self  !< table
    if (.not. allocated(self%line)) self%line = repeat(' ', 1024)
    self%used = 0
  end subroutine begin_row

  subroutine add_integer(self, value)
    class(table_t), intent(inout) :: self
    integer, intent(in) :: value
    call self%add_text(to_text(value))
  end subroutine add_integer

  !> Reals keep all their digits.
  subroutine add_real(self, value)
    class(table_t), intent(inout) :: self
    real(dp), intent(in) :: value
    character(len=25) :: buffer
    integer :: n
    n = c_decimal(value, buffer)
    call self%add_text(buffer(:n))
  end subroutine add_real

  subroutine add_text(self, value)
    class(table_t), intent(inout) :: self
    character(len=*), intent(in) :: value
    integer :: last
    last = self%used + len_trim(value) + 1
    do while (last > len(self%line))
      self%line = self%line//repeat(' ', len(self%line))
    end do
    self%line(self%used + 1:last - 1) = value
    self%line(last:last) = ','
    self%used = last
  end subroutine add_text

  !> Write the row.
  subroutine end_row(self, error)
    class(table_t), intent(inout) :: self             !< table
    type(error_t), allocatable, intent(out) :: error  !< disk full
    integer :: status
    self%line(self%used:self%used) = new_line('a')
    write (self%unit, iostat=status) self%line(:self%used)
    self%sum = checksum(self%line(:self%used), self%sum)
    call self%begin_row()
    if (status /= 0) call raise(error, code_file, "cannot write '"//self%path//"': is the disk full?")
  end subroutine end_row

  !> Close the file.
  subroutine close_table(self)
    class(table_t), intent(inout) :: self  !< table
    if (self%unit /= -1) close (self%unit)
    self%unit = -1
  end subroutine close_table
end module hd_table
