! SPDX-License-Identifier: GPL-3.0-or-later
!> Struts in a load step: those that count before they push, and what companions remember when the step is over.
module hd_strut_step
  use hd_kinds, only: dp
  use hd_problem, only: problem_t, load_t, state_t, forces_at, linear_forces, strut_closings
  use hd_flank_friction, only: remembered
  use hd_strut, only: push
  implicit none
  private
  public :: ahead_t, count_ahead, remember, straight

  real(dp), parameter :: straight = 1.25_dp  !< between the powers of flanks, 1, and of balls, 3/2

  !> Struts of power 1 that count in Newton's matrix before they push.
  type :: ahead_t
    logical :: some = .false.    !< some do, in the present step
    logical :: held = .false.    !< none does in the rest of the load step
    real(dp) :: pull = huge(1._dp) !< of those that had parted, when they counted last [N]
    logical :: at_rest = .false. !< the state is in equilibrium: without a torque those that just touch push by rounding alone
  end type ahead_t

contains

  !> While no strut of power 1 pushes, those that the torque nears to it first count as if they did, with the pull that this means:
  !> a wheel that nothing holds would turn far in one step of Newton's method, and rub the contact into a state far from the
  !> solution. So do those that have only just come off without a torque: it leaves the wheel where it is, and the sign of rounding
  !> errors must not send it across the play. Where struts counted, are open now, and some points stick, the contact holds the
  !> wheel: counting them again would never end. A pull that a correction leaves is none of rounding: the contact draws the wheel
  !> off, and they are let go. Nor is there any to count where no torque and no residual moves the wheel.
  subroutine count_ahead(problem, load, u, sticks, ahead, r)
    type(problem_t), intent(inout) :: problem  !< with strut_rate, which gets these struts
    type(load_t), intent(in) :: load           !< load
    real(dp), intent(in) :: u(:, :)            !< displacements (3, n) [m]
    logical, intent(in) :: sticks              !< some contact points stick
    type(ahead_t), intent(inout) :: ahead      !< what was counted in this load step
    real(dp), intent(inout) :: r(:, :)         !< out-of-balance forces (3, n), get their pull [N]
    real(dp), parameter :: near = 1e-6_dp, just_off = 1e-9_dp  !< of struts that close together, of one that has just parted [m]
    real(dp), parameter :: rounded = 1e-12_dp  !< of one that rounding has parted in equilibrium [m]
    real(dp), parameter :: unfelt = 1e-15_dp   !< by which a strut's force is no torque [m]
    real(dp), parameter :: lasting = 0.5_dp    !< share of a pull that a correction leaves: it is none of rounding
    real(dp), allocatable :: closing(:)
    logical, allocatable :: linear(:), pushes(:)
    logical :: idle, parted
    real(dp) :: stiff, off
    integer :: i
    if (.not. (allocated(problem%struts) .and. problem%wheel_turns)) return
    closing = strut_closings(problem, load, u)
    linear = problem%struts%power < straight .and. .not. problem%struts%pulls .and. closing > -1
    if (allocated(problem%rub)) linear(size(linear) - size(problem%rub%partner) + 1:) = .false.
    if (.not. any(linear)) return
    ahead%held = ahead%held .or. (ahead%some .and. sticks .and. .not. any(linear .and. closing > -just_off))
    ahead%some = .false.
    off = merge(rounded, just_off, ahead%at_rest)
    stiff = maxval(problem%struts%rate, mask=linear)
    idle = .not. abs(sum(load%force(2, problem%wheel))) > unfelt*stiff
    parted = idle .and. any(linear .and. closing > -off)
    idle = idle .and. .not. (parted .or. abs(sum(r(2, problem%wheel))) > rounded*stiff)
    pushes = linear .and. problem%strut_rate > 0
    if (ahead%at_rest .and. parted) pushes = pushes .and. closing > off
    if (ahead%held .or. idle .or. any(pushes)) return
    do i = 1, size(closing)
      linear(i) = linear(i) .and. merge(closing(i) > -off, &
        sum(problem%struts(i)%weight(2, :))*sum(r(2, problem%wheel)) < 0, parted)
    end do
    linear = linear .and. closing >= maxval(closing, mask=linear) - near
    ahead%some = any(linear)
    where (linear) problem%strut_rate = problem%struts%rate
    closing = linear_forces(problem, merge(min(0._dp, closing), 0._dp, linear))
    ahead%held = parted .and. sum(abs(closing)) > max(lasting*ahead%pull, rounded*stiff)
    if (parted) ahead%pull = sum(abs(closing))
    if (ahead%held) then
      where (linear) problem%strut_rate = 0
      return
    end if
    do i = 1, size(closing)
      if (linear(i)) call push(problem%struts(i), closing(i), r)
    end do
  end subroutine count_ahead

  !> Keep what companions remember of a load step that is over.
  subroutine remember(problem, load, state)
    type(problem_t), intent(in) :: problem  !< problem
    type(load_t), intent(in) :: load        !< its load
    type(state_t), intent(inout) :: state   !< converged; gets past
    real(dp), allocatable :: c(:), f(:)
    integer :: i, n
    if (.not. allocated(problem%rub)) return
    c = strut_closings(problem, load, state%u)
    f = forces_at(problem, load, c)
    n = size(c) - size(problem%rub%partner)
    state%past = load%past
    do i = 1, size(problem%rub%partner)
      associate (strut => problem%rub%partner(i))
        state%past(:, i) = remembered(problem%rub%friction, problem%struts(strut)%rate, problem%struts(n + i)%rate, c(strut), &
          c(n + i), f(n + i), load%past(:, i))
      end associate
    end do
  end subroutine remember
end module hd_strut_step
