! SPDX-License-Identifier: GPL-3.0-or-later
!> Text: numbers as text, lower case, lists of names, the nearest valid name.
module hd_text
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  implicit none
  private
  public :: to_text, lower, nearest_name, suggestion, string_t, push, join, exact, percent, split, is_utf8, unquoted, rounded
  public :: to_number, next_word, printable

  !> One entry of a list of texts.
  type :: string_t
    character(len=:), allocatable :: s
  end type string_t

  !> Number as short text.
  interface to_text
    module procedure :: integer_text, long_text, real_text
  end interface to_text

  !> Text as number: the one reader of numbers that others wrote. List-directed reading would take `/`, `2*5`, `1;2`, `1+13` too.
  interface to_number
    module procedure :: real_number, whole_number
  end interface to_number

  real(dp), parameter :: nothing = 1e-4_dp            !< beside its neighbours' size: none of their four digits
  integer, parameter :: smallest = -3, largest = 5    !< powers of ten from and below which a number has no exponent
  character(len=*), parameter :: figures = '0123456789'
  integer, parameter :: longest = 100                 !< characters of a number
  integer, parameter :: most_shown = 800              !< characters of a foreign text that a message shows

contains

  !> Decimal text of an integer.
  pure function integer_text(i) result(s)
    integer, intent(in) :: i  !< number
    character(len=:), allocatable :: s
    s = long_text(int(i, int64))
  end function integer_text

  !> Decimal text of a long integer.
  pure function long_text(i) result(s)
    integer(int64), intent(in) :: i  !< number
    character(len=:), allocatable :: s
    character(len=24) :: buffer
    write (buffer, '(I0)') i
    s = trim(buffer)
  end function long_text

  !> Six digits, without superfluous zeros.
  pure function real_text(x) result(s)
    real(dp), intent(in) :: x  !< number
    character(len=:), allocatable :: s
    s = shorten(x, 6)
  end function real_text

  !> Four digits, for lines that are read and not computed with; what is nothing beside `scale` is 0.
  pure function rounded(x, scale) result(s)
    real(dp), intent(in) :: x                !< number
    real(dp), intent(in), optional :: scale  !< size of its neighbours
    character(len=:), allocatable :: s
    s = shorten(x, 4)
    if (.not. present(scale)) return
    if (abs(x) < nothing*abs(scale)) s = '0.0'
  end function rounded

  !> The shortest text that reads back as the same number.
  pure function exact(x) result(s)
    real(dp), intent(in) :: x  !< number
    character(len=:), allocatable :: s
    real(dp) :: y
    integer :: digits
    logical :: ok
    do digits = 6, 17
      s = shorten(x, digits)
      call to_number(s, y, ok)
      if (ok .and. abs(y - x) <= 0) return
    end do
  end function exact

  !> Finite number of a text that holds nothing else: digits, at most one point, an exponent behind e or d.
  pure subroutine real_number(s, x, ok)
    character(len=*), intent(in) :: s  !< text without blanks
    real(dp), intent(out) :: x         !< number, 0 if it is none
    logical, intent(out) :: ok         !< it is one
    character(len=:), allocatable :: t
    integer :: at, digits, more, status
    x = 0
    ok = .false.
    if (len(s) > longest) return
    t = s//' '
    at = 1 + scan(t(1:1), '+-')
    digits = verify(t(at:), figures) - 1
    at = at + digits
    if (t(at:at) == '.') then
      more = verify(t(at + 1:), figures) - 1
      digits = digits + more
      at = at + 1 + more
    end if
    if (digits == 0) return
    if (scan(t(at:at), 'eEdD') == 1) then
      at = at + 1
      at = at + scan(t(at:at), '+-')
      more = verify(t(at:), figures) - 1
      if (more == 0) return
      at = at + more
    end if
    if (at <= len(s)) return
    read (s, '(f100.0)', iostat=status) x
    ok = status == 0 .and. abs(x) <= huge(x)
    if (.not. ok) x = 0
  end subroutine real_number

  !> Whole number of a text that holds nothing else.
  pure subroutine whole_number(s, i, ok)
    character(len=*), intent(in) :: s  !< text without blanks
    integer(int64), intent(out) :: i   !< number, 0 if it is none
    logical, intent(out) :: ok         !< it is one
    integer :: first, status
    i = 0
    first = 1 + scan(s(:min(1, len(s))), '+-')
    ok = len(s) >= first .and. len(s) <= range(i) .and. verify(s(first:), figures) == 0
    if (.not. ok) return
    read (s, '(I20)', iostat=status) i
    ok = status == 0
  end subroutine whole_number

  !> Next word of a text, between blanks and control characters.
  pure subroutine next_word(text, at, word)
    character(len=*), intent(in) :: text                  !< text
    integer, intent(inout) :: at                          !< where to look, then behind the word
    character(len=:), allocatable, intent(out) :: word    !< '' at the end
    integer :: first
    do while (at <= len(text))
      if (text(at:at) > ' ') exit
      at = at + 1
    end do
    first = at
    do while (at <= len(text))
      if (text(at:at) <= ' ') exit
      at = at + 1
    end do
    word = text(first:at - 1)
  end subroutine next_word

  !> Text of a real with a number of significant digits.
  pure function shorten(x, digits) result(s)
    real(dp), intent(in) :: x       !< number
    integer, intent(in) :: digits   !< significant digits
    character(len=:), allocatable :: s
    character(len=40) :: buffer
    character(len=12) :: form
    integer :: e
    if (x /= x .or. abs(x) > huge(x)) then
      write (buffer, '(f0.0)') x
      s = trim(buffer)
      return
    end if
    write (form, '(a,I0,a)') '(es40.', digits - 1, 'e3)'
    write (buffer, form) x
    buffer = adjustl(buffer)
    e = index(buffer, 'E')
    s = buffer(:e - 1)
    do while (s(len(s):) == '0')
      s = s(:len(s) - 1)
    end do
    if (s(len(s):) == '.') s = s//'0'
    read (buffer(e + 1:), '(I10)') e
    if (e == 0) return
    if (e >= smallest .and. e < largest) then
      write (form, '(a,I0,a)') '(f0.', max(1, digits - 1 - e), ')'
      write (buffer, form) x
      s = trim(buffer)
      do while (s(len(s):) == '0' .and. s(len(s) - 1:len(s) - 1) /= '.')
        s = s(:len(s) - 1)
      end do
      if (s(1:1) == '.') s = '0'//s
      if (len(s) > 1) then
        if (s(1:2) == '-.') s = '-0'//s(2:)
      end if
    else
      s = s//'e'//integer_text(e)
    end if
  end function shorten

  !> Lower-case copy.
  pure function lower(s) result(t)
    character(len=*), intent(in) :: s  !< text
    character(len=len(s)) :: t
    integer :: i
    t = s
    do i = 1, len(s)
      if (s(i:i) >= 'A' .and. s(i:i) <= 'Z') t(i:i) = achar(iachar(s(i:i)) + 32)
    end do
  end function lower

  !> A text without its quotes; a doubled quote within stands for one.
  pure function unquoted(s) result(t)
    character(len=*), intent(in) :: s  !< as in a namelist, quoted or not
    character(len=:), allocatable :: t
    integer :: i, n
    t = s
    if (scan(s(:min(1, len(s))), '''"') == 0) return
    n = 0
    i = 2
    do while (i < len(s))
      n = n + 1
      t(n:n) = s(i:i)
      if (s(i:i + 1) == s(1:1)//s(1:1)) i = i + 1
      i = i + 1
    end do
    t = t(:n)
  end function unquoted

  !> Well-formed UTF-8 (RFC 3629; surrogates are let pass).
  pure logical function is_utf8(s)
    character(len=*), intent(in) :: s  !< bytes
    integer :: i, k, n, byte
    is_utf8 = .false.
    i = 1
    do while (i <= len(s))
      byte = iachar(s(i:i))
      select case (byte)
      case (0:127); n = 0
      case (194:223); n = 1
      case (224:239); n = 2
      case (240:244); n = 3
      case default; return
      end select
      if (i + n > len(s)) return
      if (n > 1) then  ! no letter in more bytes than it needs, no half of a pair, none beyond the last plane
        k = iachar(s(i + 1:i + 1))
        if ((byte == 224 .and. k < 160) .or. (byte == 237 .and. k > 159) .or. (byte == 240 .and. k < 144) .or. &
          (byte == 244 .and. k > 143)) return
      end if
      do k = i + 1, i + n
        if (iand(iachar(s(k:k)), 192) /= 128) return
      end do
      i = i + n + 1
    end do
    is_utf8 = .true.
  end function is_utf8

  !> Append a text to a list. (An array constructor of texts is miscompiled by gfortran 12.)
  pure subroutine push(list, s)
    type(string_t), allocatable, intent(inout) :: list(:)  !< grows by one; may be unallocated
    character(len=*), intent(in) :: s                      !< text
    type(string_t), allocatable :: longer(:)
    integer :: i, n
    n = 0
    if (allocated(list)) n = size(list)
    allocate (longer(n + 1))
    do i = 1, n
      call move_alloc(list(i)%s, longer(i)%s)
    end do
    longer(n + 1)%s = s
    call move_alloc(longer, list)
  end subroutine push

  !> Names joined by a separator.
  pure function join(names, separator) result(s)
    type(string_t), intent(in) :: names(:)      !< names
    character(len=*), intent(in) :: separator   !< between them
    character(len=:), allocatable :: s
    integer :: i
    s = ''
    do i = 1, size(names)
      if (i > 1) s = s//separator
      s = s//names(i)%s
    end do
  end function join

  !> The name nearest to a misspelt one, empty if none is close.
  pure function nearest_name(word, names) result(best)
    character(len=*), intent(in) :: word     !< as typed
    type(string_t), intent(in) :: names(:)   !< valid names
    character(len=:), allocatable :: best
    integer :: i, d, least
    best = ''
    least = max(2, len(word)/3) + 1
    do i = 1, size(names)
      d = distance(lower(word), names(i)%s)
      if (d >= least) cycle
      least = d
      best = names(i)%s
    end do
  end function nearest_name

  !> Nearest valid name and the list of all.
  pure function suggestion(word, names) result(hint)
    character(len=*), intent(in) :: word    !< as typed
    type(string_t), intent(in) :: names(:)  !< valid names
    character(len=:), allocatable :: hint
    hint = nearest_name(word, names)
    if (len(hint) > 0) hint = "did you mean '"//hint//"'?  "
    hint = hint//'valid: '//join(names, ', ')
  end function suggestion

  !> Edit distance (insertions, deletions, substitutions).
  pure integer function distance(a, b)
    character(len=*), intent(in) :: a, b  !< words
    integer :: row(0:len(b)), i, j, diagonal, above
    row = [(j, j=0, len(b))]
    do i = 1, len(a)
      diagonal = row(0)
      row(0) = i
      do j = 1, len(b)
        above = row(j)
        row(j) = min(above + 1, row(j - 1) + 1, diagonal + merge(0, 1, a(i:i) == b(j:j)))
        diagonal = above
      end do
    end do
    distance = row(len(b))
  end function distance

  !> A share in per cent: 0.123 as "12 %", 0.0123 as "1.2 %".
  pure function percent(x) result(text)
    real(dp), intent(in) :: x     !< share
    character(len=:), allocatable :: text
    real(dp), parameter :: tenth = 0.0995_dp  !< from here on it rounds to 10 %, which has two digits without a decimal
    if (x < tenth) then
      text = to_text(0.1_dp * nint(1000 * x))//' %'
    else
      text = to_text(nint(100 * x))//' %'
    end if
  end function percent

  !> Parts of a text between commas.
  pure function split(text) result(parts)
    character(len=*), intent(in) :: text  !< text
    type(string_t), allocatable :: parts(:)
    integer :: first, comma
    allocate (parts(0))
    first = 1
    do
      comma = index(text(first:), ',')
      if (comma == 0) exit
      call push(parts, text(first:first + comma - 2))
      first = first + comma
    end do
    call push(parts, text(first:))
  end function split

  !> A text without control characters, in UTF-8, and no longer than a message may be.
  pure function printable(s) result(t)
    character(len=*), intent(in) :: s  !< text
    character(len=:), allocatable :: t
    integer :: i, last
    t = s(:min(len(s), most_shown))
    if (len(t) < len(s)) t = t//' ...'
    last = merge(255, 126, is_utf8(t))
    do i = 1, len(t)
      if (iachar(t(i:i)) < 32 .or. iachar(t(i:i)) == 127 .or. iachar(t(i:i)) > last) t(i:i) = '?'
    end do
  end function printable
end module hd_text
