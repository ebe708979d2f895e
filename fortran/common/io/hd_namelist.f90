! SPDX-License-Identifier: GPL-3.0-or-later
!> Namelist files, scanned by our own reader: every assignment keeps its line and column, every mistake is reported.
!>
!> (A compiler's own reader answers "End of file" to most mistakes, and names the wrong line for others.)
module hd_namelist
  use hd_error, only: error_t, raise, code_input
  use hd_input_file, only: read_text
  use hd_text, only: string_t, push, join, to_text, lower, is_utf8, printable
  implicit none
  private
  public :: assignment_t, namelist_t, read_namelist, report, faults_text

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
    character(len=:), allocatable :: text          !< the whole file, blanks for tabs and carriage returns
    integer, allocatable :: first(:)               !< place of each line in it, and of the line behind the last
    type(assignment_t), allocatable :: assignments(:)
    type(assignment_t), allocatable :: groups(:)   !< group headers
    type(string_t), allocatable :: faults(:)       !< rendered mistakes, the first of them
    integer :: more = 0                            !< mistakes beyond those
  end type namelist_t

  type :: token_t
    character(len=1) :: kind = ' '   !< & group, w word, = equals, comma, / end
    integer :: first = 1, last = 0   !< place in the text
    integer :: line = 0, column = 0
  end type token_t

  integer, parameter :: most_faults = 400                !< that are told one by one
  integer, parameter :: widest = 200                     !< characters of a line that a fault shows

contains

  !> Scan a file. Mistakes of form are collected in faults; only a file that cannot be read is an error.
  subroutine read_namelist(path, list, error)
    character(len=*), intent(in) :: path              !< file
    type(namelist_t), intent(out) :: list             !< assignments and faults
    type(error_t), allocatable, intent(out) :: error  !< file cannot be read
    type(token_t), allocatable :: tokens(:)
    integer :: n
    list%path = path
    allocate (list%assignments(0), list%groups(0), list%faults(0), list%first(1))
    list%text = ''
    list%first = 1
    call read_text(path, list%text, error)
    if (.not. allocated(error) .and. index(list%text, achar(0)) > 0) call raise(error, code_input, "'"//path// &
      "' holds bytes of 0, as UTF-16 does: save it as UTF-8")
    if (allocated(error)) return
    call find_lines(list)
    call tokenize(list, tokens, n)
    call parse(list, tokens(:n))
  end subroutine read_namelist

  !> Where the lines begin; carriage returns and tabs become blanks.
  subroutine find_lines(list)
    type(namelist_t), intent(inout) :: list  !< file
    integer :: i, n
    n = 1
    do i = 1, len(list%text)
      select case (list%text(i:i))
      case (achar(10)); n = n + 1
      case (achar(9), achar(13)); list%text(i:i) = ' '
      end select
    end do
    deallocate (list%first)
    allocate (list%first(n + 1))
    list%first(1) = 1
    n = 1
    do i = 1, len(list%text)
      if (list%text(i:i) /= achar(10)) cycle
      n = n + 1
      list%first(n) = i + 1
    end do
    list%first(n + 1) = len(list%text) + 2
  end subroutine find_lines

  !> Cut the lines into tokens.
  subroutine tokenize(list, tokens, count)
    type(namelist_t), intent(inout) :: list               !< file
    type(token_t), allocatable, intent(out) :: tokens(:)  !< its tokens, and room behind them
    integer, intent(out) :: count                         !< of the tokens
    integer :: l, i, j, n
    allocate (tokens(256))
    count = 0
    do l = 1, size(list%first) - 1
      n = list%first(l + 1) - 2
      i = list%first(l)
      do while (i <= n)
        select case (list%text(i:i))
        case (' ')
          i = i + 1
        case ('!')
          exit
        case ('=', '/', ',')
          call add(list%text(i:i), i, i)
          i = i + 1
        case ('&')
          j = end_of_word(list%text, i + 1, n, ' !/,=')
          call add('&', i + 1, j)
          i = j + 1
        case ("'", '"')
          j = closing_quote(list%text, i, n)
          if (j == 0) then
            j = n
            do while (list%text(j:j) == ' ')
              j = j - 1
            end do
            call report(list, l, i - list%first(l) + 1, j - i + 1, 'unterminated text', &
              'the closing '//list%text(i:i)//' is missing')
          end if
          if (.not. is_utf8(list%text(i:j))) call report(list, l, i - list%first(l) + 1, j - i + 1, &
            'a text that is not UTF-8', 'save the file in that encoding')
          call add('w', i, j)
          i = j + 1
        case default
          j = end_of_word(list%text, i + 1, n, ' ,=/!&''"')
          call add('w', i, j)
          i = j + 1
        end select
      end do
    end do
  contains
    subroutine add(kind, first, last)
      character(len=1), intent(in) :: kind
      integer, intent(in) :: first, last
      type(token_t), allocatable :: longer(:)
      if (count == size(tokens)) then
        allocate (longer(2*count))
        longer(:count) = tokens
        call move_alloc(longer, tokens)
      end if
      count = count + 1
      tokens(count) = token_t(kind, first, last, l, i - list%first(l) + 1)
    end subroutine add
  end subroutine tokenize

  !> Last place of a word that began before i.
  pure integer function end_of_word(s, i, n, stops) result(j)
    character(len=*), intent(in) :: s      !< text
    integer, intent(in) :: i, n            !< next place, end of the line
    character(len=*), intent(in) :: stops  !< what ends a word
    do j = i, n
      if (index(stops, s(j:j)) > 0) exit
    end do
    j = j - 1
  end function end_of_word

  !> Column of the quote that closes the one at i, 0 if there is none; a doubled quote stands for itself.
  pure integer function closing_quote(s, i, n) result(j)
    character(len=*), intent(in) :: s  !< text
    integer, intent(in) :: i, n        !< opening quote, end of the line
    j = i + 1
    do while (j <= n)
      if (s(j:j) == s(i:i)) then
        if (j == n) return
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
    type(assignment_t), allocatable :: assignments(:), groups(:)
    character(len=:), allocatable :: group
    integer :: i, opened, n_assignments, n_groups
    allocate (assignments(count(tokens%kind == '=')), groups(count(tokens%kind == '&')))
    n_assignments = 0
    n_groups = 0
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
          if (lower(word(t)) /= 'end') then
            group = lower(word(t))
            opened = i
            n_groups = n_groups + 1
            groups(n_groups) = assignment_t(group=group, key='', line=t%line, column=t%column)
          end if
          i = i + 1
        case ('/')
          if (opened == 0) call report(list, t%line, t%column, 1, "'/' outside a group", "groups start with '&name'")
          opened = 0
          i = i + 1
        case default
          if (opened == 0) then
            call report(list, t%line, t%column, t%last - t%first + 1, 'text outside a group', "groups start with '&name'")
            i = end_of_junk(tokens, i)
          else
            call take_assignment(list, tokens, group, i, assignments, n_assignments)
          end if
        end select
      end associate
    end do
    if (opened > 0) call report(list, tokens(opened)%line, tokens(opened)%column, len(group) + 1, &
      'group &'//group//' is not closed', "its '/' is missing at the end")
    if (n_groups == 0 .and. size(list%faults) == 0) then
      call report(list, 1, 1, 1, 'the file holds no group', 'an empty scene is written as "&hd_input version = 1 /"')
    end if
    call cut(assignments, n_assignments, list%assignments)
    call cut(groups, n_groups, list%groups)
  contains
    pure function word(t) result(s)
      type(token_t), intent(in) :: t
      character(len=t%last - t%first + 1) :: s
      s = list%text(t%first:t%last)
    end function word
  end subroutine parse

  !> The first entries of a list; their texts are moved.
  subroutine cut(list, n, short)
    type(assignment_t), intent(inout) :: list(:)                 !< list
    integer, intent(in) :: n                                     !< entries that count
    type(assignment_t), allocatable, intent(inout) :: short(:)   !< they alone
    integer :: i
    if (allocated(short)) deallocate (short)
    allocate (short(n))
    do i = 1, n
      short(i)%line = list(i)%line
      short(i)%column = list(i)%column
      short(i)%value_line = list(i)%value_line
      short(i)%value_column = list(i)%value_column
      call move_alloc(list(i)%group, short(i)%group)
      call move_alloc(list(i)%key, short(i)%key)
      call move_alloc(list(i)%values, short(i)%values)
    end do
  end subroutine cut

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
  subroutine take_assignment(list, tokens, group, i, assignments, n)
    type(namelist_t), intent(inout) :: list                  !< gets mistakes
    type(token_t), intent(in) :: tokens(:)                   !< tokens
    character(len=*), intent(in) :: group                    !< group we are in
    integer, intent(inout) :: i                              !< next token
    type(assignment_t), intent(inout) :: assignments(:)      !< gets the assignment
    integer, intent(inout) :: n                              !< assignments in it
    integer :: first, k, values
    associate (t => tokens(i))
      first = i + 2
      if (.not. kind_is(i + 1, '=')) then
        call report(list, t%line, t%column, t%last - t%first + 1, &
          "'"//list%text(t%first:t%last)//"' stands alone in &"//group, "write 'key = value'")
        i = i + 1
      else
        i = first
        values = 0
        do while ((kind_is(i, 'w') .and. .not. kind_is(i + 1, '=')) .or. kind_is(i, ','))
          if (kind_is(i, 'w')) then
            values = values + 1
          else if (i == first .or. kind_is(i - 1, ',')) then
            call report(list, tokens(i)%line, tokens(i)%column, 1, "an empty place in '"//lower(list%text(t%first:t%last))//"'", &
              'a value stands before each comma')
          end if
          i = i + 1
        end do
        if (i == first) then
          call report(list, t%line, t%column, t%last - t%first + 1, &
            "'"//lower(list%text(t%first:t%last))//"' has no value", "write 'key = value'")
        else if (values > 0) then
          n = n + 1
          assignments(n)%group = group
          assignments(n)%key = lower(list%text(t%first:t%last))
          assignments(n)%line = t%line
          assignments(n)%column = t%column
          assignments(n)%value_line = tokens(first)%line
          assignments(n)%value_column = tokens(first)%column
          allocate (assignments(n)%values(values))
          values = 0
          do k = first, i - 1
            if (tokens(k)%kind /= 'w') cycle
            values = values + 1
            assignments(n)%values(values)%s = list%text(tokens(k)%first:tokens(k)%last)
          end do
          if (.not. kind_is(i, '=')) return
        end if
      end if
    end associate
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
    integer :: from
    if (size(list%faults) >= most_faults) then
      list%more = list%more + 1
      return
    end if
    number = to_text(line)
    text = ''
    from = 0
    if (line < size(list%first)) then
      text = list%text(list%first(line):list%first(line + 1) - 2)
      if (len(text) > widest) then
        from = max(0, column - widest/2)
        text = text(from + 1:min(len(text), from + widest))
      end if
    end if
    call push(list%faults, 'error: '//printable(what)//nl//'  --> '//list%path//':'//number//':'//to_text(column)//nl// &
      ' '//number//' | '//trim(printable(text))//nl//repeat(' ', len(number) + 1)//' | '//repeat(' ', column - from - 1)// &
      repeat('^', min(max(1, length), widest))//' '//hint)
  end subroutine report

  !> All mistakes in one text.
  function faults_text(list) result(text)
    type(namelist_t), intent(in) :: list  !< scanned file
    character(len=:), allocatable :: text
    character(len=1), parameter :: nl = new_line('a')
    text = join(list%faults, nl)
    if (list%more > 0) text = text//nl//'and '//to_text(list%more)//' more mistakes in '//list%path
  end function faults_text
end module hd_namelist
