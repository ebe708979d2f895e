! SPDX-License-Identifier: GPL-3.0-or-later
!> Columns of numbers from a CSV file, found by the names in its header. Lines that start with # are comments.
module hd_columns
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_file, code_input
  use hd_text, only: string_t, to_text, join
  implicit none
  private
  public :: columns_t, read_columns

  type :: columns_t
    character(len=:), allocatable :: path
    type(string_t), allocatable :: names(:)     !< of the columns
    real(dp), allocatable :: values(:, :)       !< (columns, rows)
  contains
    procedure :: has
    procedure :: take
  end type columns_t

contains

  !> Read a file.
  subroutine read_columns(path, columns, error)
    character(len=*), intent(in) :: path              !< file
    type(columns_t), intent(out) :: columns           !< its columns
    type(error_t), allocatable, intent(out) :: error  !< missing, no header, a row that does not fit
    character(len=:), allocatable :: line
    real(dp), allocatable :: row(:), grown(:, :)
    integer :: unit, status, number, rows
    columns%path = path
    open (newunit=unit, file=path, action='read', status='old', iostat=status)
    if (status /= 0) then
      call raise(error, code_file, "cannot read '"//path//"'")
      return
    end if
    rows = 0
    number = 0
    do
      call next_line(unit, line, number, status)
      if (status /= 0) exit
      if (.not. allocated(columns%names)) then
        columns%names = cells(line)
        allocate (row(size(columns%names)), columns%values(size(columns%names), 64))
        cycle
      end if
      call read_row(path, line, number, columns%names, row, error)
      if (allocated(error)) exit
      if (rows == size(columns%values, 2)) then
        allocate (grown(size(row), 2*rows))
        grown(:, :rows) = columns%values
        call move_alloc(grown, columns%values)
      end if
      rows = rows + 1
      columns%values(:, rows) = row
    end do
    close (unit)
    if (allocated(error)) return
    if (rows == 0) then
      call raise(error, code_input, "'"//path//"' holds no rows; valid: a line of column names, then rows of numbers")
      return
    end if
    columns%values = columns%values(:, :rows)
  end subroutine read_columns

  !> Next line that is neither empty nor a comment.
  subroutine next_line(unit, line, number, status)
    integer, intent(in) :: unit                               !< open file
    character(len=:), allocatable, intent(out) :: line        !< text
    integer, intent(inout) :: number                          !< of the line in the file
    integer, intent(out) :: status                            !< not 0 at the end
    character(len=256) :: buffer
    integer :: length
    do
      line = ''
      do
        read (unit, '(a)', iostat=status, advance='no', size=length) buffer
        line = line//buffer(:length)
        if (status /= 0) exit
      end do
      number = number + 1
      if (is_iostat_eor(status)) status = 0
      if (status /= 0 .and. len_trim(line) > 0) status = 0   ! a last line without an end
      if (status /= 0) return
      if (len(line) > 0) then
        if (line(len(line):) == achar(13)) line = line(:len(line) - 1)
      end if
      if (len_trim(line) > 0 .and. index(adjustl(line), '#') /= 1) return
    end do
  end subroutine next_line

  !> Cells between commas.
  pure function cells(line) result(list)
    character(len=*), intent(in) :: line  !< text
    type(string_t), allocatable :: list(:)
    integer :: i, from, comma
    allocate (list(count([(line(i:i) == ',', i=1, len(line))]) + 1))
    from = 1
    do i = 1, size(list)
      comma = index(line(from:), ',')
      if (comma == 0) comma = len(line) - from + 2
      list(i)%s = trim(adjustl(line(from:from + comma - 2)))
      from = from + comma
    end do
  end function cells

  !> Numbers of a row.
  subroutine read_row(path, line, number, names, row, error)
    character(len=*), intent(in) :: path, line        !< file and text, for the message
    integer, intent(in) :: number                     !< of the line
    type(string_t), intent(in) :: names(:)            !< of the columns
    real(dp), intent(out) :: row(:)                   !< values
    type(error_t), allocatable, intent(out) :: error  !< cells that are no numbers, too many or few
    type(string_t), allocatable :: list(:)
    integer :: i, status
    list = cells(line)
    if (size(list) /= size(row)) then
      call raise(error, code_input, "'"//path//"', line "//to_text(number)//': '//to_text(size(list))//' cells; valid: '// &
        to_text(size(row))//', as the header')
      return
    end if
    do i = 1, size(row)
      status = 1
      if (verify(list(i)%s, '0123456789+-.eEdDnNaAiIfF') == 0 .and. len(list(i)%s) > 0) then
        read (list(i)%s, *, iostat=status) row(i)
      end if
      if (status == 0) cycle
      call raise(error, code_input, "'"//path//"', line "//to_text(number)//', column '//names(i)%s//": '"//list(i)%s// &
        "'; valid: a number")
      return
    end do
  end subroutine read_row

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
    call raise(error, code_input, "'"//self%path//"' has no column '"//name//"'; it has "//join(self%names, ', '))
  end subroutine take
end module hd_columns
