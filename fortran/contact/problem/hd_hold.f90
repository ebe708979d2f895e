! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds of a ring in Newton's matrix, not in the forces. A ring whose balls hardly push rocks in them almost freely, and one whose
!> contact slips as a whole turns so: a correction that moves it far leads nowhere, and is made again with struts that hold it,
!> until corrections are short.
module hd_hold
  use hd_kinds, only: dp
  use hd_groove, only: groove_t, stiffen_way
  use hd_strut, only: strut_t, closing_of
  implicit none
  private
  public :: hold_t, hold_more, hold_less

  real(dp), parameter :: stiffer = 30   !< factor between two stiffnesses of a hold
  integer, parameter :: most = 3        !< times it is made stiffer
  real(dp), parameter :: short = 0.1_dp !< of a long way: after a correction as short as this the hold is less

  type :: hold_t
    integer, allocatable :: struts(:)   !< that take part
    real(dp) :: long = 0                !< way of a correction along one of them that is too far [m]
    real(dp) :: least = 0               !< stiffness, if there is one [N/m]
    real(dp) :: rate = 0                !< that Newton's matrix adds to each of them [N/m]
  end type hold_t

contains

  !> Hold what a correction moves too far, stiffer at each call. Nothing is to do where it moves less.
  subroutine hold_more(holds, groove, struts, rate, u, more)
    type(hold_t), intent(inout) :: holds(:)              !< get rate
    type(groove_t), intent(inout), optional :: groove    !< gets cross
    type(strut_t), intent(in) :: struts(:)               !< all struts
    real(dp), intent(inout) :: rate(:)                   !< tangents (struts) [N/m]
    real(dp), intent(in) :: u(:, :)                      !< correction (3, n) [m]
    logical, intent(out) :: more                         !< held, by new tangents
    real(dp) :: before
    integer :: i
    more = .false.
    do i = 1, size(holds)
      before = holds(i)%rate
      if (.not. (before < stiffer**most*holds(i)%least .and. farthest(holds(i), struts, u) > holds(i)%long)) cycle
      more = .true.
      holds(i)%rate = max(stiffer*before, holds(i)%least)
      call add_hold(holds(i), holds(i)%rate - before, groove, rate)
    end do
  end subroutine hold_more

  !> Let go after a short correction, and hold in the tangents of the next iterate.
  subroutine hold_less(holds, groove, struts, rate, u)
    type(hold_t), intent(inout) :: holds(:)              !< get rate
    type(groove_t), intent(inout), optional :: groove    !< gets cross
    type(strut_t), intent(in) :: struts(:)               !< all struts
    real(dp), intent(inout) :: rate(:)                   !< tangents without a hold (struts) [N/m]
    real(dp), intent(in) :: u(:, :)                      !< correction before (3, n) [m]
    integer :: i
    do i = 1, size(holds)
      if (.not. holds(i)%rate > 0) cycle
      if (farthest(holds(i), struts, u) < short*holds(i)%long) holds(i)%rate = holds(i)%rate/stiffer
      if (holds(i)%rate < holds(i)%least) holds(i)%rate = 0
      if (holds(i)%rate > 0) call add_hold(holds(i), holds(i)%rate, groove, rate)
    end do
  end subroutine hold_less

  !> Longest way of its struts [m].
  pure real(dp) function farthest(hold, struts, u) result(way)
    type(hold_t), intent(in) :: hold        !< hold
    type(strut_t), intent(in) :: struts(:)  !< all struts
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    integer :: i
    way = 0
    do i = 1, size(hold%struts)
      way = max(way, abs(closing_of(struts(hold%struts(i)), u)))
    end do
  end function farthest

  !> Add a stiffness to the tangents of its struts.
  subroutine add_hold(hold, more, groove, rate)
    type(hold_t), intent(in) :: hold                     !< hold
    real(dp), intent(in) :: more                         !< [N/m]
    type(groove_t), intent(inout), optional :: groove    !< gets cross
    real(dp), intent(inout) :: rate(:)                   !< tangents (struts) [N/m]
    integer :: i
    do i = 1, size(hold%struts)
      if (present(groove)) call stiffen_way(groove, hold%struts(i), more, rate)
      rate(hold%struts(i)) = rate(hold%struts(i)) + more
    end do
  end subroutine add_hold
end module hd_hold
