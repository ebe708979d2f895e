! SPDX-License-Identifier: GPL-3.0-or-later
!> The run log: on standard output, flushed line by line, or kept for a program that calls the engine. A terminal gets lines of 80
!> columns at most, broken between words; a file keeps each message on its line. Silent unless the application switches it on.
module hd_log
  use, intrinsic :: iso_c_binding, only: c_char, c_int
  use hd_error, only: error_t, raise, code_file
  use hd_system, only: system_text
  implicit none
  private
  public :: set_log_level, keep_log, take_line, say, detail, print_text, check_log, quiet, normal, verbose

  integer, parameter :: quiet = 0    !< nothing
  integer, parameter :: normal = 1   !< load steps
  integer, parameter :: verbose = 2  !< Newton iterations too
  integer, save :: level = quiet
  logical, save :: keeps = .false.   !< lines are kept, not printed
  integer, save :: failure = 0       !< of the first line that could not be written, the system's number
  integer, parameter :: columns = 80, indent = 10  !< of a terminal; of the lines that a message goes on in

  interface
    subroutine c_keep_line(text, n) bind(c, name='hd_keep_line')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: text(*)
      integer(c_int), value :: n
    end subroutine c_keep_line
    integer(c_int) function c_print_line(text, n) bind(c, name='hd_print_line')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: text(*)
      integer(c_int), value :: n
    end function c_print_line
    integer(c_int) function c_take_line(text, size) bind(c, name='hd_take_line')
      import :: c_char, c_int
      character(kind=c_char), intent(out) :: text(*)
      integer(c_int), value :: size
    end function c_take_line
    integer(c_int) function c_isatty(unit) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: unit
    end function c_isatty
  end interface

contains

  !> Choose what is written.
  subroutine set_log_level(new, old)
    integer, intent(in) :: new              !< quiet, normal or verbose
    integer, intent(out), optional :: old   !< what it was
    if (present(old)) old = level
    level = new
  end subroutine set_log_level

  !> From here on lines are kept in memory, for take_line.
  subroutine keep_log()
    keeps = .true.
  end subroutine keep_log

  !> The oldest line that is kept; it is so no more.
  subroutine take_line(line, found)
    character(len=*), intent(out) :: line  !< text
    logical, intent(out) :: found          !< there was one
    found = c_take_line(line, len(line)) /= 0
  end subroutine take_line

  !> One line of the log. An output that is gone or full ends no run: `check_log` tells of it.
  subroutine say(line)
    character(len=*), intent(in) :: line  !< text
    if (level < normal) return
    if (keeps) then
      call c_keep_line(line, len(line))
    else if (len(line) > columns .and. c_isatty(1_c_int) == 1) then
      call write_broken(line)
    else
      call print_text(line)
    end if
  end subroutine say

  !> One line on standard output; nothing once that cannot be written.
  subroutine print_text(text)
    character(len=*), intent(in) :: text  !< line
    if (failure == 0) failure = c_print_line(text, len(text))
  end subroutine print_text

  !> The end of the log: an error where lines of it are lost.
  subroutine check_log(error)
    type(error_t), allocatable, intent(out) :: error  !< full disk, a reader that is gone
    if (failure /= 0) call raise(error, code_file, 'cannot write the standard output'//system_text(failure)// &
      '; files of results are not concerned')
  end subroutine check_log

  !> A long line in parts that end between words; all but the first begin after blanks.
  subroutine write_broken(line)
    character(len=*), intent(in) :: line  !< text
    integer :: first, last, before
    first = 1
    before = 0
    do
      last = len(line)
      if (last - first + 1 > columns - before) then
        last = first + index(line(first:first + columns - before), ' ', back=.true.) - 2
        if (last <= first + indent) last = first + columns - before - 1   ! a word longer than a line
      end if
      call print_text(repeat(' ', before)//line(first:last))
      first = last + 1
      if (first > len(line)) exit
      if (line(first:first) == ' ') first = first + 1
      before = indent
    end do
  end subroutine write_broken

  !> One line that only the verbose log shows.
  subroutine detail(line)
    character(len=*), intent(in) :: line  !< text
    if (level >= verbose) call say(line)
  end subroutine detail
end module hd_log
