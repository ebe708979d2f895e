! SPDX-License-Identifier: GPL-3.0-or-later
!> Places in rising lists.
module hd_sorted
  use hd_kinds, only: dp
  implicit none
  private
  public :: count_up_to

contains

  !> How many entries of a rising list do not exceed x, by bisection.
  pure integer function count_up_to(list, x) result(n)
    real(dp), intent(in) :: list(:)  !< rising
    real(dp), intent(in) :: x        !< place
    integer :: high, middle
    n = 0
    high = size(list) + 1
    do while (high - n > 1)
      middle = (n + high)/2
      if (list(middle) <= x) then
        n = middle
      else
        high = middle
      end if
    end do
  end function count_up_to
end module hd_sorted
