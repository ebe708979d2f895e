! SPDX-License-Identifier: GPL-3.0-or-later
!> Arrays in numpy's format .npy, version 1.
module hd_npy
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp, sp
  use hd_error, only: error_t, raise, code_file
  use hd_new_file, only: new_file_t
  use hd_input_file, only: open_input
  use hd_text, only: to_text, to_number, split, string_t, printable
  implicit none
  private
  public :: write_npy, read_npy

  interface write_npy
    procedure :: write_double, write_single
  end interface write_npy

  character(len=*), parameter :: magic = char(147)//'NUMPY'//char(1)//char(0)
  character(len=*), parameter :: valid = '.npy with 4 or 8 byte reals, rows x points'

contains

  !> Array a(nx, ny) as shape (ny, nx) in C order.
  subroutine write_double(path, a, error)
    character(len=*), intent(in) :: path              !< file
    real(dp), intent(in), contiguous :: a(:, :)       !< array
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    type(new_file_t) :: file
    call file%open(path, error)
    if (allocated(error)) return
    write (file%unit, iostat=file%status) header('<f8', shape(a)), a
    call file%close(error)
  end subroutine write_double

  !> The same in single precision.
  subroutine write_single(path, a, error)
    character(len=*), intent(in) :: path              !< file
    real(sp), intent(in), contiguous :: a(:, :)       !< array
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    type(new_file_t) :: file
    call file%open(path, error)
    if (allocated(error)) return
    write (file%unit, iostat=file%status) header('<f4', shape(a)), a
    call file%close(error)
  end subroutine write_single

  !> Magic string, version, length and a dictionary, filled up to a multiple of 64 bytes.
  pure function header(kind_name, extent) result(text)
    character(len=*), intent(in) :: kind_name         !< '<f8' or '<f4'
    integer, intent(in) :: extent(2)                  !< nx, ny
    character(len=:), allocatable :: text, words
    integer :: n
    words = "{'descr': '"//kind_name//"', 'fortran_order': False, 'shape': ("//to_text(extent(2))//', '//to_text(extent(1))//'), }'
    n = 64 * ((10 + len(words) + 1 + 63) / 64) - 10
    text = magic//char(mod(n, 256))//char(n / 256)//words// &
      repeat(' ', n - len(words) - 1)//new_line('a')
  end function header

  !> Map of 4 or 8 byte reals, shape (rows, points) or (points).
  subroutine read_npy(path, a, error)
    character(len=*), intent(in) :: path                !< file
    real(dp), allocatable, intent(out) :: a(:, :)       !< array (points, rows)
    type(error_t), allocatable, intent(out) :: error    !< missing, not this format
    character(len=10) :: head
    character(len=:), allocatable :: words
    real(sp), allocatable :: a_4(:, :)
    integer :: unit, status, n, extent(2)
    integer(int64) :: bytes
    logical :: swapped
    call open_input(path, unit, bytes, error)
    if (allocated(error)) return
    head = ''
    read (unit, iostat=status) head
    n = ichar(head(9:9)) + 256 * ichar(head(10:10))
    if (head(:8) /= magic .or. bytes < len(head) + n) status = 1
    allocate (character(len=merge(n, 0, status == 0)) :: words)
    if (status == 0) read (unit, iostat=status) words
    if (status == 0) words = without_blanks(words)
    if (status /= 0) call raise(error, code_file, "'"//path//"' is no array of heights: "//valid)
    if (.not. allocated(error)) call read_shape(path, words, bytes - len(head) - n, extent, error)
    if (.not. allocated(error)) then
      swapped = index(words, "'fortran_order':True") > 0 .and. minval(extent) > 1
      if (swapped) extent = extent([2, 1])
      allocate (a(extent(2), extent(1)), stat=status)
      if (status == 0 .and. index(words, "'<f8'") > 0) then
        read (unit, iostat=status) a
      else if (status == 0) then
        allocate (a_4(extent(2), extent(1)), stat=status)
        if (status == 0) read (unit, iostat=status) a_4
        if (status == 0) a = a_4
      end if
      if (status == 0 .and. swapped) a = transpose(a)
      if (status /= 0) call raise(error, code_file, "'"//path//"' cannot be read, or its "//to_text(extent(1))//' x '// &
        to_text(extent(2))//' heights find no memory')
    end if
    close (unit)
  end subroutine read_npy

  !> A text without its blanks: a header may be spaced in any way.
  pure function without_blanks(text) result(short)
    character(len=*), intent(in) :: text  !< text
    character(len=:), allocatable :: short
    integer :: i
    short = ''
    do i = 1, len(text)
      if (text(i:i) /= ' ') short = short//text(i:i)
    end do
  end function without_blanks

  !> A word stands in a text once.
  pure logical function once(text, word)
    character(len=*), intent(in) :: text, word  !< text, word
    integer :: at
    at = index(text, word)
    once = at > 0 .and. at == index(text, word, back=.true.)
  end function once

  !> Rows and points that a header without blanks states; the bytes behind it must be theirs.
  subroutine read_shape(path, words, bytes, extent, error)
    character(len=*), intent(in) :: path, words       !< file and its header
    integer(int64), intent(in) :: bytes               !< behind the header
    integer, intent(out) :: extent(2)                 !< rows, points
    type(error_t), allocatable, intent(out) :: error  !< another kind of number, shape or size
    type(string_t), allocatable :: parts(:)
    character(len=:), allocatable :: list
    integer(int64) :: size_of, number
    integer :: at, first, last, i
    logical :: ok
    extent = 1
    at = index(words, "'shape':")
    first = index(words(max(at, 1):), '(') + max(at, 1)
    last = index(words(first:), ')') + first - 2
    size_of = merge(8, 4, index(words, "'<f8'") > 0)
    ok = once(words, "'shape':") .and. once(words, "'descr':") .and. once(words, "'fortran_order':") .and. &
      (once(words, "'fortran_order':True") .or. once(words, "'fortran_order':False"))
    if (.not. ok .or. first == max(at, 1) .or. last < first - 1 .or. (size_of == 4 .and. index(words, "'<f4'") == 0)) then
      call raise(error, code_file, "'"//path//"' is no array of heights: "//valid)
      return
    end if
    list = trim(adjustl(words(first:last)))
    parts = split(list)
    if (len_trim(parts(size(parts))%s) == 0) parts = parts(:size(parts) - 1)
    ok = size(parts) == 1 .or. size(parts) == 2
    do i = 1, size(parts)
      if (.not. ok) exit
      call to_number(trim(adjustl(parts(i)%s)), number, ok)
      ok = ok .and. number > 0 .and. number < huge(1)
      if (ok) extent(2 - size(parts) + i) = int(number)
    end do
    if (.not. ok) then
      call raise(error, code_file, "'"//path//"' has shape ("//printable(list)// &
        '): heights are rows x points, or one row of points')
    else if (extent(2) > bytes/size_of/extent(1) .or. extent(1)*size_of*extent(2) /= bytes) then
      call raise(error, code_file, "'"//path//"' states "//to_text(extent(1))//' x '//to_text(extent(2))//' heights of '// &
        to_text(size_of)//' bytes and holds '//to_text(bytes)//' bytes of them: damaged or cut')
    end if
  end subroutine read_shape
end module hd_npy
