! SPDX-License-Identifier: GPL-3.0-or-later
!> Path from little friction to that of a load step, taken where Newton's method fails at once.
!>
!> A step solved with less friction, from the same beginning, is the first guess for more of it. Two kinds of step need the path:
!> faces that touch without pressure, where each point decides alone between stick, slip and lift, and friction so strong
!> (mu > 0.7) that the solution next to the last one ends and another lies further off.
module hd_friction_path
  use hd_kinds, only: dp
  use hd_clock, only: wall_seconds
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_log, only: detail
  use hd_newton, only: newton_options_t, iteration_t, iterate
  use hd_problem, only: problem_t, state_t, load_t
  use hd_text, only: to_text
  implicit none
  private
  public :: raise_friction

  integer, parameter :: most_tries = 10           !< solutions tried for
  real(dp), parameter :: first_share = 0.5_dp     !< of the friction, tried first;
  real(dp), parameter :: fall = 0.25_dp           !< factor to the next while none is solved,
  real(dp), parameter :: least_share = 1e-3_dp    !< down to this
  real(dp), parameter :: near = 0.85_dp           !< share from which all of it is tried

contains

  !> Solve a load step with less friction and raise it from solution to solution.
  subroutine raise_friction(problem, solver, options, load, deadline, previous, state, history, solved, sliding, error)
    type(problem_t), intent(inout) :: problem                      !< problem
    class(linear_solver_t), intent(inout) :: solver                !< its linear solver
    type(newton_options_t), intent(in) :: options                  !< tolerance and limits
    type(load_t), intent(in) :: load                               !< load at the end of the step
    real(dp), intent(in) :: deadline                               !< clock from which nothing more is tried [s]
    type(state_t), intent(in) :: previous                          !< state at its beginning
    type(state_t), intent(inout) :: state                          !< solution
    type(iteration_t), allocatable, intent(inout) :: history(:)    !< iterates; gets the further ones
    logical, intent(out) :: solved, sliding                        !< as of `iterate`, with all of the friction
    type(error_t), allocatable, intent(out) :: error               !< linear solver
    type(iteration_t), allocatable :: more(:)
    type(load_t) :: less
    type(state_t) :: guess
    real(dp) :: share, reached
    integer :: k
    less = load
    guess = previous
    reached = 0
    share = first_share
    do k = 1, most_tries
      less%friction = share*load%friction
      state = guess
      call detail('      '//to_text(share)//' of the friction')
      call iterate(problem, solver, options, less, previous, state, more, solved, sliding, error)
      more%iteration = more%iteration + history(size(history))%iteration
      history = [history, more]
      if (allocated(error)) return
      if ((solved .or. sliding) .and. share >= 1) return
      if (solved) guess = state
      call next_share(solved, sliding, share, reached)
      if (share < least_share .or. wall_seconds() > deadline) exit
    end do
    solved = .false.
    sliding = .false.
  end subroutine raise_friction

  !> Share of the friction to try next.
  pure subroutine next_share(solved, sliding, share, reached)
    logical, intent(in) :: solved, sliding  !< what became of `share`
    real(dp), intent(inout) :: share        !< tried, then to be tried
    real(dp), intent(inout) :: reached      !< largest solved
    if (solved) reached = share
    if (solved .and. share > near) then
      share = 1
    else if (solved .or. sliding) then      ! what slides wants more
      share = 0.5_dp*(1 + share)
    else if (reached > 0) then
      share = 0.5_dp*(reached + share)
    else
      share = fall*share
    end if
  end subroutine next_share
end module hd_friction_path
