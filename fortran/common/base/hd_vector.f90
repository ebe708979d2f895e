! SPDX-License-Identifier: GPL-3.0-or-later
!> Products of vectors in space.
module hd_vector
  use hd_kinds, only: dp
  implicit none
  private
  public :: cross

contains

  !> Vector product.
  pure function cross(a, b) result(c)
    real(dp), intent(in) :: a(3), b(3)  !< factors
    real(dp) :: c(3)
    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross
end module hd_vector
