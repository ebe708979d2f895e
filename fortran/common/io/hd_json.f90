! SPDX-License-Identifier: GPL-3.0-or-later
!> JSON documents, built key by key and written in one atomic step.
module hd_json
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_checksum, only: checksum, file_checksum, whole, hexadecimal
  use hd_error, only: error_t
  use hd_new_file, only: write_text
  use hd_text, only: string_t, split, to_text, exact, is_utf8
  implicit none
  private
  public :: json_t

  type :: json_t
    private
    character(len=:), allocatable :: text
    integer :: depth = 0
    logical :: first = .true.
  contains
    procedure :: begin
    procedure :: finish
    procedure :: seal
    procedure :: write_atomic
    procedure :: content
    generic :: add => add_integer, add_long, add_real, add_text, add_logical, add_reals, add_texts
    procedure, private :: add_integer, add_long, add_real, add_text, add_logical, add_reals, add_texts
    procedure, private :: put
  end type json_t

contains

  !> Open an object; without a key: the document.
  subroutine begin(self, key)
    class(json_t), intent(inout) :: self              !< document
    character(len=*), intent(in), optional :: key     !< name of the object
    if (present(key)) then
      call self%put(key, '{')
    else
      self%text = '{'
    end if
    self%depth = self%depth + 1
    self%first = .true.
  end subroutine begin

  !> Close the innermost object.
  subroutine finish(self)
    class(json_t), intent(inout) :: self  !< document
    self%depth = self%depth - 1
    self%text = self%text//new_line('a')//repeat(' ', 2*self%depth)//'}'
    self%first = .false.
  end subroutine finish

  !> Add a key with its value as JSON text.
  subroutine put(self, key, value)
    class(json_t), intent(inout) :: self     !< document
    character(len=*), intent(in) :: key      !< name
    character(len=*), intent(in) :: value    !< JSON text
    if (.not. self%first) self%text = self%text//','
    self%text = self%text//new_line('a')//repeat(' ', 2*self%depth)//quoted(key)//': '//value
    self%first = .false.
  end subroutine put

  subroutine add_integer(self, key, value)
    class(json_t), intent(inout) :: self
    character(len=*), intent(in) :: key
    integer, intent(in) :: value
    call self%put(key, to_text(value))
  end subroutine add_integer

  subroutine add_long(self, key, value)
    class(json_t), intent(inout) :: self
    character(len=*), intent(in) :: key
    integer(int64), intent(in) :: value
    call self%put(key, to_text(value))
  end subroutine add_long

  subroutine add_real(self, key, value)
    class(json_t), intent(inout) :: self
    character(len=*), intent(in) :: key
    real(dp), intent(in) :: value
    call self%put(key, number(value))
  end subroutine add_real

  subroutine add_text(self, key, value)
    class(json_t), intent(inout) :: self
    character(len=*), intent(in) :: key
    character(len=*), intent(in) :: value
    call self%put(key, quoted(value))
  end subroutine add_text

  subroutine add_logical(self, key, value)
    class(json_t), intent(inout) :: self
    character(len=*), intent(in) :: key
    logical, intent(in) :: value
    call self%put(key, trim(merge('true ', 'false', value)))
  end subroutine add_logical

  subroutine add_reals(self, key, values)
    class(json_t), intent(inout) :: self
    character(len=*), intent(in) :: key
    real(dp), intent(in) :: values(:)
    character(len=:), allocatable :: s
    integer :: i
    s = '['
    do i = 1, size(values)
      if (i > 1) s = s//', '
      s = s//number(values(i))
    end do
    call self%put(key, s//']')
  end subroutine add_reals

  subroutine add_texts(self, key, values)
    class(json_t), intent(inout) :: self
    character(len=*), intent(in) :: key
    character(len=*), intent(in) :: values(:)
    character(len=:), allocatable :: s
    integer :: i
    s = '['
    do i = 1, size(values)
      if (i > 1) s = s//', '
      s = s//quoted(trim(values(i)))
    end do
    call self%put(key, s//']')
  end subroutine add_texts

  !> JSON number that reads back exactly; null for NaN and infinity.
  pure function number(x) result(s)
    real(dp), intent(in) :: x  !< value
    character(len=:), allocatable :: s
    if (x /= x .or. abs(x) > huge(x)) then
      s = 'null'
    else
      s = exact(x)
    end if
  end function number

  !> JSON string. Bytes that are no UTF-8, as a file's name may have, become its sign for an unknown letter.
  pure function quoted(value) result(s)
    character(len=*), intent(in) :: value  !< text
    character(len=:), allocatable :: s
    character(len=*), parameter :: unknown = char(239)//char(191)//char(189)  !< U+FFFD
    character(len=6) :: code
    integer :: i, n
    s = '"'
    i = 1
    do while (i <= len_trim(value))
      n = 1
      select case (value(i:i))
      case ('"', '\')
        s = s//'\'//value(i:i)
      case (achar(0):achar(31))
        write (code, '(a,z4.4)') '\u', ichar(value(i:i))
        if (value(i:i) == new_line('a')) code = '\n'
        if (value(i:i) == achar(9)) code = '\t'
        s = s//trim(code)
      case (achar(32):'!', '#':'[', ']':achar(127))
        s = s//value(i:i)
      case default
        do n = 2, min(4, len(value) - i + 1)  ! bytes of a letter
          if (is_utf8(value(i:i + n - 1))) exit
        end do
        if (n <= min(4, len(value) - i + 1)) then
          s = s//value(i:i + n - 1)
        else
          s = s//unknown
          n = 1
        end if
      end select
      i = i + n
    end do
    s = s//'"'
  end function quoted

  !> The document as text.
  pure function content(self) result(text)
    class(json_t), intent(in) :: self  !< closed document
    character(len=:), allocatable :: text
    text = self%text
  end function content

  !> Close the document with the checksums of files that it goes with, and of all that stands before its own.
  subroutine seal(self, folder, files)
    class(json_t), intent(inout) :: self     !< document, open
    character(len=*), intent(in) :: folder   !< of the files
    character(len=*), intent(in) :: files    !< names, parted by commas; those that are not there are left out
    type(string_t), allocatable :: name(:)
    integer(int64) :: sum
    integer :: i, status
    name = split(files)
    call self%begin('checksums')
    do i = 1, size(name)
      call file_checksum(folder//'/'//name(i)%s, whole, sum, status)
      if (status == 0) call self%add(name(i)%s, hexadecimal(sum))
    end do
    call self%finish()
    call self%add('checksum', hexadecimal(checksum(self%text)))
    call self%finish()
  end subroutine seal

  !> Write the document: it is there whole or not at all.
  subroutine write_atomic(self, path, error)
    class(json_t), intent(in) :: self                 !< closed document
    character(len=*), intent(in) :: path              !< file
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    call write_text(path, self%text//new_line('a'), error)
  end subroutine write_atomic
end module hd_json
