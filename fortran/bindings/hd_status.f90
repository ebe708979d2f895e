! SPDX-License-Identifier: GPL-3.0-or-later
!> Error values as status and message, for procedures called from Python.
module hd_status
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t, code_done
  implicit none
  private
  public :: tell

contains

  !> Status 0 and no message, or the code and message of an error.
  subroutine tell(error, status, message)
    type(error_t), allocatable, intent(in) :: error  !< what happened
    integer(c_int), intent(out) :: status            !< its code
    character(len=*), intent(out) :: message         !< its message
    status = code_done
    message = ''
    if (.not. allocated(error)) return
    status = error%code
    message = error%message
  end subroutine tell
end module hd_status
