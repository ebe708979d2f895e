! SPDX-License-Identifier: GPL-3.0-or-later
!> How the traction of a contact point changes from where it stands: the rate form of a rough joint with Coulomb friction.
!>
!> With the joint's stiffness k_n = dP/d closure and k_t against shear, rates of gap g, slip s, pressure p and shear tau obey
!>   open:   dp = 0, dtau = 0
!>   closed: dg + dp/k_n = 0
!>   stick:  ds + dtau/k_t = 0, along tau with k_t under the present shear, across it with k_t without shear
!>   slip:   e . dtau = mu dp along e = tau/|tau|; across it as in stick
!> A point at the bound mu p sticks again where the slip would go against its shear.
module hd_rate_law
  use hd_kinds, only: dp
  implicit none
  private
  public :: rate_point_t, rate_rows, rate_drive, asked_state, missed_work, rate_open, rate_stick, rate_slip, rate_glued, rate_rigid

  integer, parameter :: rate_open = 0, rate_stick = 1, rate_slip = 2
  integer, parameter :: rate_glued = 3  !< neither gap nor slip
  integer, parameter :: rate_rigid = 4  !< no shear; no gap unless k_n is above 0

  !> A contact point.
  type :: rate_point_t
    integer :: state = rate_open     !< one of the constants
    logical :: at_bound = .false.    !< its shear is mu p
    real(dp) :: direction(2) = 0     !< of its shear; 0 where there is none
    real(dp) :: k_n = 0              !< dP / d closure; 0: rigid [Pa/m]
    real(dp) :: k_t = 0              !< under the present shear, for shear that grows [Pa/m]
    real(dp) :: k_0 = 0              !< without shear, for shear that shrinks [Pa/m]
    logical :: grows = .true.        !< the shear grows
  end type rate_point_t

contains

  !> Rows  dw (dg, ds) + dt (dp, dtau) = 0  of a point, in the scale of the contact law. Along and across the shear each component
  !> has a compliance of its own, a thousand times apart near slip: preconditioners take the diagonal of such rows.
  pure subroutine rate_rows(point, friction, scale, dw, dt)
    type(rate_point_t), intent(in) :: point  !< point
    real(dp), intent(in) :: friction         !< mu
    real(dp), intent(in) :: scale            !< c of the contact law [Pa/m]
    real(dp), intent(out) :: dw(3, 3)        !< [Pa/m]
    real(dp), intent(out) :: dt(3, 3)
    real(dp) :: e(2)
    integer :: i
    dw = 0
    dt = 0
    do i = 1, 3
      dt(i, i) = 1
    end do
    if (point%state == rate_open) return
    dw(1, 1) = scale
    dt(1, 1) = 0
    if (point%k_n > 0) dt(1, 1) = scale/point%k_n
    if (point%state == rate_rigid) return
    if (point%state == rate_glued) then
      dw(2, 2) = scale
      dw(3, 3) = scale
      dt = 0
      return
    end if
    e = point%direction
    if (.not. norm2(e) > 0) e = [1, 0]
    dw(3, 2:) = scale*[-e(2), e(1)]
    dt(3, 2:) = scale/point%k_0*[-e(2), e(1)]
    if (point%state == rate_slip) then
      dt(2, :) = [-friction, e(1), e(2)]
    else
      dw(2, 2:) = scale*e
      dt(2, 2:) = scale/merge(point%k_t, point%k_0, point%grows)*e
    end if
  end subroutine rate_rows

  !> Drive of a point: what its rates ask for is `asked_state` of it. Linear in the rates, and of one sign whatever the state was in
  !> which they were found: in stick the shear beyond the bound mu p, in slip the slip that goes along the shear, times a stiffness.
  pure real(dp) function rate_drive(point, friction, scale, slip, traction) result(z)
    type(rate_point_t), intent(in) :: point  !< point
    real(dp), intent(in) :: friction         !< mu
    real(dp), intent(in) :: scale            !< c of the contact law [Pa/m]
    real(dp), intent(in) :: slip(2)          !< ds
    real(dp), intent(in) :: traction(3)      !< dp, dtau
    real(dp) :: along
    z = 0
    if (point%state /= rate_stick .and. point%state /= rate_slip) return
    along = dot_product(point%direction, traction(2:))
    z = along - scale*(dot_product(point%direction, slip) + along/point%k_0)
    if (point%at_bound) z = z - friction*traction(1)
  end function rate_drive

  !> A point in the state that its drive asks for: a point at the bound slips or sticks, the shear of another one grows or shrinks.
  elemental function asked_state(point, drive) result(next)
    type(rate_point_t), intent(in) :: point  !< point
    real(dp), intent(in) :: drive            !< of `rate_drive`
    type(rate_point_t) :: next
    next = point
    if (point%state /= rate_stick .and. point%state /= rate_slip) return
    if (point%at_bound) then
      next%state = merge(rate_slip, rate_stick, drive > 0)
      next%grows = .false.
    else
      next%grows = .not. drive < 0
    end if
  end function asked_state

  !> Work per area by which rates miss the law of a point along its shear: to first order, what that changes of an answer.
  pure real(dp) function missed_work(point, friction, slip, traction) result(work)
    type(rate_point_t), intent(in) :: point  !< point in the state its rates ask for
    real(dp), intent(in) :: friction         !< mu
    real(dp), intent(in) :: slip(2)          !< ds
    real(dp), intent(in) :: traction(3)      !< dp, dtau
    real(dp) :: along, moved
    along = dot_product(point%direction, traction(2:))
    moved = dot_product(point%direction, slip)
    if (point%state == rate_slip) then
      work = abs((along - friction*traction(1))*moved)
    else
      work = abs(along*(moved + along/merge(point%k_t, point%k_0, point%grows)))
    end if
  end function missed_work
end module hd_rate_law
