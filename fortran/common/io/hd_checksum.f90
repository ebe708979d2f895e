! SPDX-License-Identifier: GPL-3.0-or-later
!> Checksums (CRC-64 of xz) that tell a file as it was written from a damaged one.
module hd_checksum
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long_long, c_null_char
  use, intrinsic :: iso_fortran_env, only: int64
  implicit none
  private
  public :: checksum, joined_checksum, file_checksum, hexadecimal

  integer(int64), parameter, public :: whole = -1  !< in the place of a number of bytes, all that a file has

  interface
    pure integer(c_long_long) function c_checksum(before, bytes, n) bind(c, name='hd_bytes_checksum')
      import :: c_char, c_long_long
      integer(c_long_long), intent(in), value :: before, n
      character(kind=c_char), intent(in) :: bytes(*)
    end function c_checksum
    !> Checksum of what follows texts whose checksum is known, from its own checksum and its length.
    pure integer(c_long_long) function joined_checksum(before, sum, n) bind(c, name='hd_joined_checksum')
      import :: c_long_long
      integer(c_long_long), intent(in), value :: before, sum, n
    end function joined_checksum
    integer(c_int) function c_file_checksum(path, copy, n, sum) bind(c, name='hd_file_checksum')
      import :: c_char, c_int, c_long_long
      character(kind=c_char), intent(in) :: path(*), copy(*)
      integer(c_long_long), value :: n
      integer(c_long_long), intent(out) :: sum
    end function c_file_checksum
  end interface

contains

  !> Checksum of a text, or of one that follows texts whose checksum is known.
  pure integer(int64) function checksum(text, before)
    character(len=*), intent(in) :: text                !< bytes
    integer(int64), intent(in), optional :: before      !< checksum of what stands before them
    checksum = 0
    if (present(before)) checksum = before
    checksum = c_checksum(checksum, text, int(len(text), c_long_long))
  end function checksum

  !> Checksum of the first bytes of a file.
  subroutine file_checksum(path, bytes, sum, status, copy)
    character(len=*), intent(in) :: path            !< file
    integer(int64), intent(in) :: bytes             !< from its beginning, or `whole`
    integer(int64), intent(out) :: sum              !< their checksum
    integer, intent(out) :: status                  !< 0: done, -1: it does not hold so many, else the system's error of writing
    character(len=*), intent(in), optional :: copy  !< new file that gets them too
    character(len=:), allocatable :: to
    to = ''
    if (present(copy)) to = copy
    status = c_file_checksum(path//c_null_char, to//c_null_char, bytes, sum)
  end subroutine file_checksum

  !> A checksum as 16 digits.
  pure function hexadecimal(sum) result(text)
    integer(int64), intent(in) :: sum  !< checksum
    character(len=16) :: text
    write (text, '(z16.16)') sum
  end function hexadecimal
end module hd_checksum
