! SPDX-License-Identifier: GPL-3.0-or-later
!> Pressure where contact ends, as a joint whose stiffness is not in proportion to it must take it.
!>
!> A node's pressure is the mean over its cell. Where contact ends, the last cell is pressed in part only and the pressure falls
!> steeply: with K ~ p^a, a < 1, the stiffness of the mean is larger than the mean of the stiffness, and K_TS too high by what
!> falls as slowly as h. There p ~ (e - z)^(1/2) is taken (a crowned contact's end); the means of the last two cells tell e, and
!> both get the power mean  (1/l int p^a dz)^(1/a). The exponent a is the joint's own at the pressure of each node: 0.6 for the
!> default joint about to slip, 0.33 where spots are elastic, below 0 where K_T falls as the pressure grows. What is open has no
!> stiffness, which no pressure can tell where a is near 0: the mean is at most the highest pressure of the cell.
module hd_contact_edge
  use hd_kinds, only: dp
  implicit none
  private
  public :: softening

  real(dp), parameter :: least = -1.5_dp, most = 1._dp  !< exponents: the mean exists above -2
  real(dp), parameter :: smallest = 1e-3_dp             !< in amount: the power mean of 0 is the geometric one

contains

  !> Power mean over mean pressure of the nodes of a line along or round the axis; 1 except for the last two before an open node.
  pure function softening(z, p, a) result(f)
    real(dp), intent(in) :: z(:)  !< nodes, ascending, in any unit
    real(dp), intent(in) :: p(:)  !< their pressures, 0 where open [Pa]
    real(dp), intent(in) :: a(:)  !< d ln K_T / d ln p there
    real(dp) :: f(size(z))
    integer :: i
    f = 1
    do i = 3, size(z) - 1
      if (all(p(i - 2:i) > 0) .and. .not. p(i + 1) > 0) f(i - 1:i) = f(i - 1:i)*at_end(z(i - 2:i + 1), p(i - 1:i), a(i - 1:i))
    end do
    do i = 2, size(z) - 2
      if (all(p(i:i + 2) > 0) .and. .not. p(i - 1) > 0) then
        f(i:i + 1) = f(i:i + 1)*reverse(at_end(-z(i + 2:i - 1:-1), p(i + 1:i:-1), a(i + 1:i:-1)))
      end if
    end do
  end function softening

  !> Two in reverse order.
  pure function reverse(x) result(y)
    real(dp), intent(in) :: x(2)  !< two
    real(dp) :: y(2)
    y = x([2, 1])
  end function reverse

  !> Power mean over mean pressure of the last two nodes where contact ends upwards.
  pure function at_end(z, p, a) result(f)
    real(dp), intent(in) :: z(4)  !< a node, these two, and the open one
    real(dp), intent(in) :: p(2)  !< mean pressures of the two cells [Pa]
    real(dp), intent(in) :: a(2)  !< their exponents
    real(dp) :: f(2), bound(3), low, high, e, power(2)
    integer :: i
    bound = 0.5_dp*(z(:3) + z(2:))
    low = bound(2)
    high = bound(3)
    do i = 1, 40  ! the farther contact goes, the more of it on the last node: at most to the end of its cell
      e = 0.5_dp*(low + high)
      if (mean(e, bound(2), bound(3), 1._dp)*p(1) < mean(e, bound(1), bound(2), 1._dp)*p(2)) then
        low = e
      else
        high = e
      end if
    end do
    power = max(least, min(most, a))
    where (abs(power) < smallest) power = smallest
    f = [(mean(e, bound(i), bound(i + 1), power(i))/mean(e, bound(i), bound(i + 1), 1._dp), i=1, 2)]
  end function at_end

  !> Power mean of (e - z)^(1/2) over a cell, 0 beyond e: at most its highest value, which powers just below 0 pass by any amount.
  pure real(dp) function mean(e, from, to, power)
    real(dp), intent(in) :: e         !< end of contact, in the cell or beyond
    real(dp), intent(in) :: from, to  !< the cell
    real(dp), intent(in) :: power     !< of the mean
    real(dp) :: n, x
    n = 1 + 0.5_dp*power
    x = ((e - from)**n - max(0._dp, e - to)**n)/(n*(to - from))
    mean = sqrt(e - from)
    if (log(x)/power < log(mean)) mean = x**(1/power)
  end function mean
end module hd_contact_edge
