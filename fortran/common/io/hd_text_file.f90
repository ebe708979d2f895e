! SPDX-License-Identifier: GPL-3.0-or-later
!> A text written as a file.
module hd_text_file
  use hd_error, only: error_t, raise, code_file
  implicit none
  private
  public :: write_text

contains

  !> Write a text as it stands; a file of that name is replaced.
  subroutine write_text(path, text, error)
    character(len=*), intent(in) :: path              !< file
    character(len=*), intent(in) :: text              !< lines, each with its end
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    integer :: unit, status
    open (newunit=unit, file=path, access='stream', form='unformatted', action='write', status='replace', iostat=status)
    if (status == 0) write (unit, iostat=status) text
    if (status == 0) close (unit, iostat=status)
    if (status /= 0) call raise(error, code_file, "cannot write '"//path//"'")
  end subroutine write_text
end module hd_text_file
