! SPDX-License-Identifier: GPL-3.0-or-later
!> Files that are read: opened in one way, whole texts and their lines.
module hd_input_file
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_error, only: error_t, raise, code_file
  use hd_system, only: path_kind, path_directory, path_absent, path_file
  use hd_text, only: to_text
  implicit none
  private
  public :: open_input, read_text, next_line, line_count

  integer(int64), parameter, public :: most_bytes = 2_int64**30  !< of a text

contains

  !> Open a file as a stream of bytes. Pipes and devices, which may have no end, are refused before they are opened.
  subroutine open_input(path, unit, bytes, error)
    character(len=*), intent(in) :: path              !< file
    integer, intent(out) :: unit                      !< to read from
    integer(int64), intent(out) :: bytes              !< that it holds
    type(error_t), allocatable, intent(out) :: error  !< absent, no regular file, not readable
    integer :: status
    bytes = 0
    unit = 0
    select case (path_kind(path))
    case (path_absent)
      call raise(error, code_file, "input file '"//path//"' does not exist")
      return
    case (path_file)
    case (path_directory)
      call raise(error, code_file, "'"//path//"' is a folder, not an input file")
      return
    case default
      call raise(error, code_file, "'"//path//"' is no file that can be read twice, as an input must be: copy it into one")
      return
    end select
    open (newunit=unit, file=path, action='read', status='old', access='stream', form='unformatted', iostat=status)
    if (status == 0) inquire (unit=unit, size=bytes)
    if (status /= 0) call raise(error, code_file, "input file '"//path//"' cannot be read: check its permissions")
  end subroutine open_input

  !> A whole text file, without a byte-order mark.
  subroutine read_text(path, text, error)
    character(len=*), intent(in) :: path                 !< file
    character(len=:), allocatable, intent(out) :: text   !< its bytes
    type(error_t), allocatable, intent(out) :: error     !< cannot be read, too long
    integer :: unit, status
    integer(int64) :: bytes
    text = ''
    call open_input(path, unit, bytes, error)
    if (allocated(error)) return
    status = 0
    if (bytes > most_bytes) then
      call raise(error, code_file, "input file '"//path//"' holds "//to_text(bytes)//' bytes; valid: up to '//to_text(most_bytes))
    else if (bytes > 0) then
      deallocate (text)
      allocate (character(len=bytes) :: text)
      read (unit, iostat=status) text
    end if
    close (unit)
    if (status /= 0) call raise(error, code_file, "input file '"//path//"' cannot be read: check its permissions")
    if (len(text) < 3) return
    if (text(:3) == char(239)//char(187)//char(191)) text = text(4:)
  end subroutine read_text

  !> Next line of a text, without its end.
  pure subroutine next_line(text, at, line)
    character(len=*), intent(in) :: text                  !< text
    integer, intent(inout) :: at                          !< where it begins, then where the next begins; behind the text: none
    character(len=:), allocatable, intent(out) :: line    !< the line
    integer :: last
    last = index(text(at:), new_line('a')) + at - 2
    if (last < at - 1) last = len(text)
    line = text(at:last)
    at = last + 2
    if (len(line) == 0) return
    if (line(len(line):) == achar(13)) line = line(:len(line) - 1)
  end subroutine next_line

  !> Lines of a text, the one that its end cuts among them.
  pure integer function line_count(text) result(n)
    character(len=*), intent(in) :: text  !< text
    integer :: i
    n = 1
    do i = 1, len(text)
      if (text(i:i) == new_line('a')) n = n + 1
    end do
  end function line_count
end module hd_input_file
