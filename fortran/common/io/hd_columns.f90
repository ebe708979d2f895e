! SPDX-License-Identifier: GPL-3.0-or-later
!> Columns of numbers from a CSV file, found by the names in its header. Lines that start with # are comments.
module hd_columns
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_input_file, only: read_text, next_line, line_count
  use hd_text, only: string_t, to_text, to_number, split, join, printable
  implicit none
  private
  public :: columns_t, read_columns

  type :: columns_t
    character(len=:), allocatable :: path
    type(string_t), allocatable :: names(:)     !< of the columns
    real(dp), allocatable :: values(:, :)       !< (columns, rows)
    integer, allocatable :: lines(:)            !< of the rows in the file
    integer :: header_line = 0
  contains
    procedure :: has
    procedure :: take
    procedure :: place
  end type columns_t

contains

  !> Read a file.
  subroutine read_columns(path, columns, error)
    character(len=*), intent(in) :: path              !< file
    type(columns_t), intent(out) :: columns           !< its columns
    type(error_t), allocatable, intent(out) :: error  !< missing, no header, a row that does not fit
    character(len=:), allocatable :: text, line
    type(string_t), allocatable :: cells(:)
    integer :: at, number, rows, i, k
    columns%path = path
    call read_text(path, text, error)
    if (allocated(error)) return
    rows = 0
    number = 0
    at = 1
    do while (at <= len(text))
      call next_line(text, at, line)
      number = number + 1
      if (len_trim(line) == 0 .or. index(adjustl(line), '#') == 1) cycle
      cells = split(line)
      if (.not. allocated(columns%names)) then
        allocate (columns%names(size(cells)))
        do i = 1, size(cells)
          columns%names(i)%s = trim(adjustl(cells(i)%s))
          if (count([(columns%names(k)%s == columns%names(i)%s, k=1, i)]) == 1) cycle
          call raise(error, code_input, columns%place(number)//"column '"//printable(columns%names(i)%s)// &
            "' stands twice; keep one")
          return
        end do
        columns%header_line = number
        rows = min(line_count(text(at:)), (len(text) - at)/(2*size(cells)) + 2)   ! a cell takes a digit and what parts it
        allocate (columns%values(size(cells), rows), columns%lines(rows))
        rows = 0
        cycle
      end if
      rows = rows + 1
      columns%lines(rows) = number
      call read_row(columns, cells, rows, error)
      if (allocated(error)) return
    end do
    if (rows == 0) then
      call raise(error, code_input, "'"//path//"' holds no rows; valid: a line of column names, then rows of numbers")
      return
    end if
    columns%values = columns%values(:, :rows)
    columns%lines = columns%lines(:rows)
  end subroutine read_columns

  !> Numbers of a row.
  subroutine read_row(columns, cells, row, error)
    type(columns_t), intent(inout) :: columns         !< get them
    type(string_t), intent(in) :: cells(:)            !< as they stand
    integer, intent(in) :: row                        !< place of the row
    type(error_t), allocatable, intent(out) :: error  !< cells that are no numbers, too many or few
    logical :: ok
    integer :: i
    if (size(cells) /= size(columns%names)) then
      call raise(error, code_input, columns%place(columns%lines(row))//to_text(size(cells))//' cells; valid: '// &
        to_text(size(columns%names))//', as the header')
      return
    end if
    do i = 1, size(cells)
      call to_number(trim(adjustl(cells(i)%s)), columns%values(i, row), ok)
      if (ok) cycle
      call raise(error, code_input, columns%place(columns%lines(row))//'column '//printable(columns%names(i)%s)//": '"// &
        printable(trim(adjustl(cells(i)%s)))//"'; valid: a number")
      return
    end do
  end subroutine read_row

  !> A line of the file, for messages.
  pure function place(self, line) result(text)
    class(columns_t), intent(in) :: self  !< columns
    integer, intent(in) :: line           !< number of the line
    character(len=:), allocatable :: text
    text = "'"//self%path//"', line "//to_text(line)//': '
  end function place

  !> Is there a column of a name?
  pure logical function has(self, name)
    class(columns_t), intent(in) :: self  !< columns
    character(len=*), intent(in) :: name  !< of the column
    integer :: i
    has = .false.
    do i = 1, size(self%names)
      if (self%names(i)%s == name) has = .true.
    end do
  end function has

  !> Values of a column.
  subroutine take(self, name, values, error)
    class(columns_t), intent(in) :: self               !< columns
    character(len=*), intent(in) :: name               !< of the column
    real(dp), allocatable, intent(out) :: values(:)    !< its numbers
    type(error_t), allocatable, intent(out) :: error   !< there is none
    integer :: i
    do i = 1, size(self%names)
      if (self%names(i)%s == name) then
        values = self%values(i, :)
        return
      end if
    end do
    call raise(error, code_input, "'"//self%path//"' has no column '"//name//"'; it has "//printable(join(self%names, ', ')))
  end subroutine take
end module hd_columns
