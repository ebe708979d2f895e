! SPDX-License-Identifier: GPL-3.0-or-later
!> Namelist files, scanned by our own reader: every assignment keeps its line and column, every mistake is reported.
!>
!> (A compiler's own reader answers "End of file" to most mistakes, and names the wrong line for others.)
module hd_namelist
  use hd_error, only: error_t, raise, code_file
  use hd_system, only: path_kind, path_directory, path_absent
  use hd_text, only: string_t, push, to_text, lower
  implicit none
  private
  public :: assignment_t, namelist_t, read_namelist, report

  !> One `key = values` of the file.
  type :: assignment_t
    character(len=:), allocatable :: group, key
    type(string_t), allocatable :: values(:)      !< words; texts keep their quotes
    integer :: line = 0, column = 0               !< of the key
    integer :: value_line = 0, value_column = 0   !< of the first value
  end type assignment_t

  !> A scanned file.
  type :: namelist_t
    character(len=:), allocatable :: path
    type(string_t), allocatable :: lines(:)
    type(assignment_t), allocatable :: assignments(:)
    type(assignment_t), allocatable :: groups(:)   !< group headers
    type(string_t), allocatable :: faults(:)       !< rendered mistakes
  end type namelist_t

  type :: token_t
    character(len=:), allocatable :: s
    character(len=1) :: kind = ' '   !< & group, w word, = equals, / end
    integer :: line = 0, column = 0
  end type token_t

contains

  !> Scan a file. Mistakes of form are collected in faults; only a file that cannot be read is an error.
  subroutine read_namelist(path, list, error)
    character(len=*), intent(in) :: path              !< file
    type(namelist_t), intent(out) :: list             !< assignments and faults
    type(error_t), allocatable, intent(out) :: error  !< file cannot be read
    type(token_t), allocatable :: tokens(:)
    list%path = path
    allocate (list%lines(0), list%assignments(0), list%groups(0), list%faults(0))
    call read_lines(path, list%lines, error)
    if (allocated(error)) return
    call tokenize(list, tokens)
    call parse(list, tokens)
  end subroutine read_namelist

  !> Lines of a text file; carriage returns, tabs and a byte-order mark are removed.
  subroutine read_lines(path, lines, error)
    character(len=*), intent(in) :: path                       !< file
    type(string_t), allocatable, intent(inout) :: lines(:)     !< lines
    type(error_t), allocatable, intent(out) :: error           !< cannot be read
    character(len=4096) :: buffer
    integer :: unit, status, i
    if (path_kind(path) == path_absent) then
      call raise(error, code_file, "input file '"//path//"' does not exist")
      return
    else if (path_kind(path) == path_directory) then
      call raise(error, code_file, "'"//path//"' is a folder, not an input file")
      return
    end if
    open (newunit=unit, file=path, action='read', status='old', iostat=status)
    if (status /= 0) then
      call raise(error, code_file, "input file '"//path//"' cannot be read")
      return
    end if
    do
      read (unit, '(a)', iostat=status) buffer
      if (status /= 0) exit
      do i = 1, len_trim(buffer)
        if (buffer(i:i) == achar(9) .or. buffer(i:i) == achar(13)) buffer(i:i) = ' '
      end do
      if (size(lines) == 0 .and. buffer(1:3) == char(239)//char(187)//char(191)) buffer = buffer(4:)
      call push(lines, trim(buffer))
    end do
    close (unit)
  end subroutine read_lines

  !> Cut the lines into tokens.
  subroutine tokenize(list, tokens)
    type(namelist_t), intent(inout) :: list               !< file
    type(token_t), allocatable, intent(out) :: tokens(:)  !< its tokens
    integer :: l, i, j, n
    allocate (tokens(0))
    do l = 1, size(list%lines)
      associate (s => list%lines(l)%s)
        n = len(s)
        i = 1
        do while (i <= n)
          select case (s(i:i))
          case (' ', ',')
            i = i + 1
          case ('!')
            exit
          case ('=', '/')
            call add_token(tokens, s(i:i), s(i:i), l, i)
            i = i + 1
          case ('&')
            j = i + scan(s(i + 1:)//' ', ' !/,=') - 1
            call add_token(tokens, lower(s(i + 1:j)), '&', l, i)
            i = j + 1
          case ("'", '"')
            j = closing_quote(s, i)
            if (j == 0) then
              call report(list, l, i, n - i + 1, 'unterminated text', 'the closing '//s(i:i)//' is missing')
              j = n
            end if
            call add_token(tokens, s(i:j), 'w', l, i)
            i = j + 1
          case default
            j = i + scan(s(i:)//' ', ' ,=/!&''"') - 2
            call add_token(tokens, s(i:j), 'w', l, i)
            i = j + 1
          end select
        end do
      end associate
    end do
  end subroutine tokenize

  !> Append a token.
  subroutine add_token(tokens, s, kind, line, column)
    type(token_t), allocatable, intent(inout) :: tokens(:)  !< grows
    character(len=*), intent(in) :: s                       !< text
    character(len=1), intent(in) :: kind                    !< kind
    integer, intent(in) :: line, column                     !< place
    type(token_t), allocatable :: longer(:)
    type(token_t) :: new
    integer :: i
    new%s = s
    new%kind = kind
    new%line = line
    new%column = column
    allocate (longer(size(tokens) + 1))
    do i = 1, size(tokens)
      longer(i) = tokens(i)
    end do
    longer(size(longer)) = new
    call move_alloc(longer, tokens)
  end subroutine add_token

  !> Column of the quote that closes the one at i, 0 if there is none; a doubled quote stands for itself.
  pure integer function closing_quote(s, i) result(j)
    character(len=*), intent(in) :: s  !< line
    integer, intent(in) :: i           !< opening quote
    j = i + 1
    do while (j <= len(s))
      if (s(j:j) == s(i:i)) then
        if (j == len(s)) return
        if (s(j + 1:j + 1) /= s(i:i)) return
        j = j + 1
      end if
      j = j + 1
    end do
    j = 0
  end function closing_quote

  !> Group the tokens into assignments.
  subroutine parse(list, tokens)
    type(namelist_t), intent(inout) :: list  !< gets assignments
    type(token_t), intent(in) :: tokens(:)   !< tokens
    character(len=:), allocatable :: group
    type(assignment_t) :: new
    integer :: i, opened
    group = ''
    opened = 0
    i = 1
    do while (i <= size(tokens))
      associate (t => tokens(i))
        select case (t%kind)
        case ('&')
          if (opened > 0) then
            call report(list, tokens(opened)%line, tokens(opened)%column, len(group) + 1, &
              'group &'//group//' is not closed', "end it with '/' before the next group")
            opened = 0
          end if
          if (t%s /= 'end') then
            group = t%s
            opened = i
            call add_group(list, t)
          end if
          i = i + 1
        case ('/')
          if (opened == 0) call report(list, t%line, t%column, 1, "'/' outside a group", "groups start with '&name'")
          opened = 0
          i = i + 1
        case default
          if (opened == 0) then
            call report(list, t%line, t%column, len(t%s), 'text outside a group', "groups start with '&name'")
            i = end_of_junk(tokens, i)
          else
            call take_assignment(list, tokens, group, i, new)
          end if
        end select
      end associate
    end do
    if (opened > 0) call report(list, tokens(opened)%line, tokens(opened)%column, len(group) + 1, &
      'group &'//group//' is not closed', "its '/' is missing at the end")
    if (size(list%groups) == 0 .and. size(list%faults) == 0) &
      call report(list, 1, 1, 1, 'the file holds no group', 'an empty scene is written as "&hd_input version = 1 /"')
  end subroutine parse

  !> Remember where a group starts.
  subroutine add_group(list, t)
    type(namelist_t), intent(inout) :: list  !< gets the header
    type(token_t), intent(in) :: t           !< its token
    type(assignment_t) :: header
    header%group = t%s
    header%line = t%line
    header%column = t%column
    header%key = ''
    allocate (header%values(0))
    call append(list%groups, header)
  end subroutine add_group

  !> Append an assignment.
  subroutine append(list, new)
    type(assignment_t), allocatable, intent(inout) :: list(:)  !< grows
    type(assignment_t), intent(in) :: new                      !< its last entry
    type(assignment_t), allocatable :: longer(:)
    integer :: i
    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = new
    call move_alloc(longer, list)
  end subroutine append

  !> First token after stray text: the next group.
  pure integer function end_of_junk(tokens, start) result(i)
    type(token_t), intent(in) :: tokens(:)  !< tokens
    integer, intent(in) :: start            !< first stray one
    i = start
    do while (i <= size(tokens))
      if (tokens(i)%kind == '&' .or. tokens(i)%kind == '/') exit
      i = i + 1
    end do
    if (i > size(tokens)) return
    if (tokens(i)%kind == '/') i = i + 1
  end function end_of_junk

  !> Read `key = values` from token i on.
  subroutine take_assignment(list, tokens, group, i, new)
    type(namelist_t), intent(inout) :: list        !< gets the assignment
    type(token_t), intent(in) :: tokens(:)         !< tokens
    character(len=*), intent(in) :: group          !< group we are in
    integer, intent(inout) :: i                    !< next token
    type(assignment_t), intent(out) :: new         !< assignment
    new%group = group
    new%key = lower(tokens(i)%s)
    allocate (new%values(0))
    new%line = tokens(i)%line
    new%column = tokens(i)%column
    if (.not. kind_is(i + 1, '=')) then
      call report(list, tokens(i)%line, tokens(i)%column, len(tokens(i)%s), &
        "'"//tokens(i)%s//"' stands alone in &"//group, "write 'key = value'")
      i = i + 1
      do while (kind_is(i, '='))
        i = i + 1
      end do
      return
    end if
    i = i + 2
    new%value_line = tokens(i - 1)%line
    new%value_column = tokens(i - 1)%column
    do while (kind_is(i, 'w') .and. .not. kind_is(i + 1, '='))
      if (size(new%values) == 0) then
        new%value_line = tokens(i)%line
        new%value_column = tokens(i)%column
      end if
      call push(new%values, tokens(i)%s)
      i = i + 1
    end do
    if (size(new%values) == 0) then
      call report(list, new%line, new%column, len(new%key), "'"//new%key//"' has no value", "write 'key = value'")
    else
      call append(list%assignments, new)
    end if
    do while (kind_is(i, '='))
      call report(list, tokens(i)%line, tokens(i)%column, 1, "stray '='", "write 'key = value'")
      i = i + 1
    end do
  contains
    pure logical function kind_is(at, kind)
      integer, intent(in) :: at
      character(len=1), intent(in) :: kind
      kind_is = .false.
      if (at <= size(tokens)) kind_is = tokens(at)%kind == kind
    end function kind_is
  end subroutine take_assignment

  !> Add a mistake with its place in the file and a caret under it.
  subroutine report(list, line, column, length, what, hint)
    type(namelist_t), intent(inout) :: list  !< gets the fault
    integer, intent(in) :: line, column      !< place
    integer, intent(in) :: length            !< characters to underline
    character(len=*), intent(in) :: what     !< the mistake
    character(len=*), intent(in) :: hint     !< what would be right
    character(len=:), allocatable :: number, text
    character(len=1), parameter :: nl = new_line('a')
    number = to_text(line)
    text = ''
    if (line <= size(list%lines)) text = list%lines(line)%s
    call push(list%faults, 'error: '//what//nl//'  --> '//list%path//':'//number//':'//to_text(column)//nl// &
      ' '//number//' | '//text//nl//repeat(' ', len(number) + 1)//' | '//repeat(' ', column - 1)// &
      repeat('^', max(1, length))//' '//hint)
  end subroutine report
end module hd_namelist
