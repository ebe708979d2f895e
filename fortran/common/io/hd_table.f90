! SPDX-License-Identifier: GPL-3.0-or-later
!> CSV tables, written row by row.
module hd_table
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_long_long
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_checksum, only: checksum, joined_checksum
  use hd_error, only: error_t, raise, code_file
  use hd_new_file, only: new_file_t
  use hd_system, only: file_bytes, system_text
  use hd_text, only: to_text
  implicit none
  private
  public :: table_t

  integer, parameter :: longest = 26            !< characters of a real and what follows it
  integer, parameter :: block = 512             !< rows that a thread makes at once
  integer, parameter :: batch = 16              !< blocks made before they are written

  type :: table_t
    private
    type(new_file_t) :: file
    character(len=:), allocatable :: line   !< the row so far, longer than that
    integer :: used = 0                     !< characters of it
    integer(int64), public :: sum = 0       !< checksum of what has been written
  contains
    procedure :: open => open_table
    procedure :: reopen
    procedure :: find_bytes
    generic :: add => add_integer, add_real, add_text
    procedure, private :: add_integer, add_real, add_text, begin_row
    procedure :: end_row, end_rows
    procedure :: close => close_table
  end type table_t

  interface
    integer(c_int) function c_decimal(x, text) bind(c, name='hd_decimal')
      import :: c_char, c_double, c_int
      real(c_double), value :: x
      character(kind=c_char), intent(out) :: text(*)
    end function c_decimal
    integer(c_long_long) function c_rows(first, n, numbers, columns, rows, text) bind(c, name='hd_rows')
      import :: c_char, c_double, c_int, c_long_long
      integer(c_int), value :: n, columns, rows
      character(kind=c_char), intent(in) :: first(*)
      real(c_double), intent(in) :: numbers(columns, *)
      character(kind=c_char), intent(out) :: text(*)
    end function c_rows
  end interface

contains

  !> Start a table with its header.
  subroutine open_table(self, path, columns, error)
    class(table_t), intent(inout) :: self             !< table
    character(len=*), intent(in) :: path              !< file
    character(len=*), intent(in) :: columns           !< names joined by commas
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    call self%begin_row()
    call self%file%open_in_place(path, error)
    if (allocated(error)) return
    call self%file%put(columns//new_line('a'))
    self%sum = checksum(columns//new_line('a'))
  end subroutine open_table

  !> Take up a table again behind its first bytes; what stands there is lost.
  subroutine reopen(self, path, bytes, sum, error)
    class(table_t), intent(inout) :: self             !< table
    character(len=*), intent(in) :: path              !< file
    integer(int64), intent(in) :: bytes               !< that stay
    integer(int64), intent(in) :: sum                 !< their checksum
    type(error_t), allocatable, intent(out) :: error  !< absent, shorter already, changed, cannot be written
    call self%begin_row()
    call self%file%reopen(path, bytes, sum, error)
    self%sum = sum
  end subroutine reopen

  !> Length of the file so far; 0 for a table that is not open.
  subroutine find_bytes(self, bytes, error)
    class(table_t), intent(inout) :: self             !< table
    integer(int64), intent(out) :: bytes              !< that stand in the file
    type(error_t), allocatable, intent(out) :: error  !< disk full
    integer(int64) :: next
    bytes = 0
    if (self%file%unit == -1) return
    if (self%file%status == 0) flush (self%file%unit, iostat=self%file%status)
    inquire (unit=self%file%unit, pos=next)
    bytes = file_bytes(self%file%now)
    if (bytes /= next - 1) self%file%status = -1   ! the compiler's library does not tell, and takes for written what it holds
    call tell(self, error)
  end subroutine find_bytes

  !> A writing that failed.
  subroutine tell(self, error)
    class(table_t), intent(in) :: self                !< table
    type(error_t), allocatable, intent(out) :: error  !< disk full
    if (self%file%status /= 0) call raise(error, code_file, "cannot write '"//self%file%path//"'"//system_text(self%file%status))
  end subroutine tell

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
    self%line(self%used:self%used) = new_line('a')
    call self%file%put(self%line(:self%used))
    self%sum = checksum(self%line(:self%used), self%sum)
    call self%begin_row()
    call tell(self, error)
  end subroutine end_row

  !> Write rows that share what the row so far holds; numbers follow it.
  subroutine end_rows(self, numbers, error)
    class(table_t), intent(inout) :: self             !< table
    real(dp), intent(in) :: numbers(:, :)             !< (columns, rows)
    type(error_t), allocatable, intent(out) :: error  !< disk full
    character(len=block*(self%used + longest*size(numbers, 1))), allocatable :: text(:)
    integer(int64) :: length(batch), sum(batch)
    integer :: b, first, from, last
    allocate (text(min(batch, (size(numbers, 2) + block - 1)/block)))
    do from = 0, size(numbers, 2) - 1, block*batch
      !$omp parallel do schedule(static) private(first, last) if(size(text) > 2)
      do b = 1, size(text)
        first = from + block*(b - 1) + 1
        last = min(size(numbers, 2), first + block - 1)
        length(b) = c_rows(self%line, self%used, numbers(:, first:last), size(numbers, 1), max(0, last + 1 - first), text(b))
        sum(b) = checksum(text(b)(:length(b)))
      end do
      !$omp end parallel do
      do b = 1, size(text)
        call self%file%put(text(b)(:length(b)))
        self%sum = joined_checksum(self%sum, sum(b), length(b))
      end do
    end do
    call self%begin_row()
    call tell(self, error)
  end subroutine end_rows

  !> Close the file; an error that is there already stays.
  subroutine close_table(self, error)
    class(table_t), intent(inout) :: self               !< table
    type(error_t), allocatable, intent(inout) :: error  !< disk full
    call self%file%close(error)
  end subroutine close_table
end module hd_table
