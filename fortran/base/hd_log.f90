! SPDX-License-Identifier: GPL-3.0-or-later
!> The run log on standard output: 80 columns, flushed line by line; silent unless the application switches it on.
module hd_log
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  private
  public :: set_log_level, say, detail, quiet, normal, verbose

  integer, parameter :: quiet = 0    !< nothing
  integer, parameter :: normal = 1   !< load steps
  integer, parameter :: verbose = 2  !< Newton iterations too
  integer, save :: level = quiet

contains

  !> Choose what is written.
  subroutine set_log_level(new, old)
    integer, intent(in) :: new              !< quiet, normal or verbose
    integer, intent(out), optional :: old   !< what it was
    if (present(old)) old = level
    level = new
  end subroutine set_log_level

  !> One line of the log.
  subroutine say(line)
    character(len=*), intent(in) :: line  !< text
    if (level < normal) return
    write (output_unit, '(a)') line
    flush (output_unit)
  end subroutine say

  !> One line that only the verbose log shows.
  subroutine detail(line)
    character(len=*), intent(in) :: line  !< text
    if (level >= verbose) call say(line)
  end subroutine detail
end module hd_log
