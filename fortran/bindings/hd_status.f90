! SPDX-License-Identifier: GPL-3.0-or-later
!> Error values as status and message, for procedures called from Python.
module hd_status
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_text, only: string_t, push
  use hd_error, only: error_t, code_done
  implicit none
  private
  public :: tell, lines_of

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

  !> Lines of a text that are not blank.
  function lines_of(text) result(lines)
    character(len=*), intent(in) :: text  !< lines with their ends
    type(string_t), allocatable :: lines(:)
    integer :: i, j
    allocate (lines(0))
    i = 1
    do while (i <= len(text))
      j = i + index(text(i:)//new_line('a'), new_line('a')) - 2
      if (len_trim(text(i:j)) > 0) call push(lines, text(i:j))
      i = j + 2
    end do
  end function lines_of
end module hd_status
