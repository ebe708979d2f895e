! SPDX-License-Identifier: GPL-3.0-or-later
!> Error values as a status for procedures called from Python. Messages and other texts stand here until the next one: Python asks
!> for them.
module hd_status
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_text, only: string_t, push
  use hd_error, only: error_t, code_done
  implicit none
  private
  public :: tell, hand_over, part_of_text, lines_of

  character(len=:), allocatable, save :: last   !< text handed over last; Python's lock keeps calls apart

contains

  !> Status 0, or the code of an error, whose message Python then asks for.
  subroutine tell(error, status)
    type(error_t), allocatable, intent(in) :: error  !< what happened
    integer(c_int), intent(out) :: status            !< its code
    status = code_done
    if (.not. allocated(error)) return
    status = error%code
    call hand_over(error%message)
  end subroutine tell

  !> Keep a text that Python will ask for.
  subroutine hand_over(text)
    character(len=*), intent(in) :: text   !< of any length
    last = text
  end subroutine hand_over

  !> A part of the text that was handed over last.
  subroutine part_of_text(first, text)
    integer, intent(in) :: first            !< its first character
    character(len=*), intent(out) :: text   !< from there, blank behind the end
    text = ''
    if (allocated(last)) text = last(min(first, len(last) + 1):)
  end subroutine part_of_text

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
