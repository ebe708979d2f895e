! SPDX-License-Identifier: GPL-3.0-or-later
!> Flanks of teeth: those that count while none of them pushes yet, and what they remember of a load step.
module hd_flanks
  use hd_kinds, only: dp
  use hd_problem, only: problem_t, load_t, state_t, forces_at, linear_forces, strut_closings
  use hd_rub, only: remembered
  use hd_strut, only: push
  implicit none
  private
  public :: flanks_t, count_flanks, remember

  !> Flanks that count in Newton's matrix before they push.
  type :: flanks_t
    logical :: ahead = .false.   !< some do, in the present step
    logical :: held = .false.    !< none does in the rest of the load step
  end type flanks_t

contains

  !> While no flank pushes, those that the torque nears to it first count as if they did, with the pull that this means: a bottom
  !> that nothing holds would turn far in one step of Newton's method, and rub the contact into a state far from the solution. So do
  !> those that have only just come off without a torque: it leaves the bottom where it is, and the sign of rounding errors must not
  !> send it across the play. Where flanks counted, are open now, and some points stick, the contact holds the bottom: counting
  !> them again would never end.
  subroutine count_flanks(problem, load, u, sticks, flanks, r)
    type(problem_t), intent(inout) :: problem  !< with strut_rate, which gets these flanks
    type(load_t), intent(in) :: load           !< load
    real(dp), intent(in) :: u(:, :)            !< displacements (3, n) [m]
    logical, intent(in) :: sticks              !< some contact points stick
    type(flanks_t), intent(inout) :: flanks    !< what was counted in this load step
    real(dp), intent(inout) :: r(:, :)         !< out-of-balance forces (3, n), get their pull [N]
    real(dp), parameter :: near = 1e-6_dp, just_off = 1e-9_dp  !< of flanks that close together, of one that has just parted [m]
    real(dp), parameter :: linear = 1.25_dp  !< between the powers of flanks, 1, and of balls, 3/2
    real(dp), parameter :: unfelt = 1e-6_dp  !< share of a flank's force at `just_off` that is no torque
    real(dp), allocatable :: closing(:)
    logical, allocatable :: flank(:)
    logical :: torque
    integer :: i
    if (.not. (allocated(problem%struts) .and. problem%turning)) return
    closing = strut_closings(problem, load, u)
    flank = problem%struts%power < linear .and. closing > -1
    if (allocated(problem%rub)) flank(size(flank) - size(problem%rub%flank) + 1:) = .false.
    if (.not. any(flank)) return
    flanks%held = flanks%held .or. (flanks%ahead .and. sticks .and. .not. any(flank .and. closing > -just_off))
    flanks%ahead = .false.
    if (flanks%held .or. any(flank .and. problem%strut_rate > 0)) return
    torque = abs(sum(load%force(2, problem%hub))) > unfelt*just_off*maxval(problem%struts%rate, mask=flank)
    do i = 1, size(closing)
      flank(i) = flank(i) .and. ((.not. torque .and. closing(i) > -just_off) .or. &
        sum(problem%struts(i)%weight(2, :))*sum(r(2, problem%hub)) < 0)
    end do
    flank = flank .and. closing >= maxval(closing, mask=flank) - near
    flanks%ahead = any(flank)
    where (flank) problem%strut_rate = problem%struts%rate
    closing = linear_forces(problem, merge(closing, 0._dp, flank))
    do i = 1, size(closing)
      if (flank(i)) call push(problem%struts(i), closing(i), r)
    end do
  end subroutine count_flanks

  !> Keep what companions of flanks remember of a load step that is over.
  subroutine remember(problem, load, state)
    type(problem_t), intent(in) :: problem  !< problem
    type(load_t), intent(in) :: load        !< its load
    type(state_t), intent(inout) :: state   !< converged; gets past
    real(dp), allocatable :: c(:), f(:)
    integer :: i, n
    if (.not. allocated(problem%rub)) return
    c = strut_closings(problem, load, state%u)
    f = forces_at(problem, load, c)
    n = size(c) - size(problem%rub%flank)
    state%past = load%past
    do i = 1, size(problem%rub%flank)
      associate (flank => problem%rub%flank(i))
        state%past(:, i) = remembered(problem%rub%friction, problem%struts(flank)%rate, problem%struts(n + i)%rate, c(flank), &
          c(n + i), f(n + i), load%past(:, i))
      end associate
    end do
  end subroutine remember
end module hd_flanks
