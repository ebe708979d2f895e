! SPDX-License-Identifier: GPL-3.0-or-later
!> One turn of the wave generator in the assembled drive, without torque: flexspline and ring move on by a facet at a time and come
!> to equilibrium again, with the friction of where they were. What the assembly left in the contact is so worn off. Seen from the
!> wave generator the bodies turn backwards; balls and cam keep their places, and the cage, which lags behind, is left out.
module hd_first_turn
  use hd_drive, only: drive_t
  use hd_error, only: error_t, raise, code_not_converged, code_stopped
  use hd_linear_solver, only: linear_solver_t
  use hd_log, only: say, detail
  use hd_newton, only: newton_options_t, iteration_t, iterate
  use hd_problem, only: load_t, state_t
  use hd_system, only: stop_requested
  use hd_text, only: to_text
  implicit none
  private
  public :: turn_once

contains

  !> Turn on by as many facets as there are round the axis.
  subroutine turn_once(drive, solver, options, load, state, error)
    type(drive_t), intent(inout) :: drive              !< assembled drive
    class(linear_solver_t), intent(inout) :: solver    !< its linear solver
    type(newton_options_t), intent(in) :: options      !< tolerance and limits
    type(load_t), intent(in) :: load                   !< of the assembly
    type(state_t), intent(inout) :: state              !< assembled, then turned
    type(error_t), allocatable, intent(out) :: error   !< not converged, stopped, linear solver
    type(iteration_t), allocatable :: history(:)
    type(state_t) :: before
    logical :: solved, sliding
    integer :: k, n
    n = drive%problem%bodies(drive%b_cup)%sectors
    do k = 1, n
      if (stop_requested()) then
        call raise(error, code_stopped, 'interrupted while the wave generator turned for loop.history = ''turned''')
        return
      end if
      call roll_on(drive, state)
      before = state
      call iterate(drive%problem, solver, options, load, before, state, history, solved, sliding, error)
      if (allocated(error)) return
      if (.not. solved) then
        call raise(error, code_not_converged, 'no convergence where the wave generator has turned by '//to_text(k)//' of '// &
          to_text(n)//" facets for loop.history = 'turned': choose 'loop' or 'assembled', or change mesh.divisions")
        return
      end if
      call detail('      turned by '//to_text(k)//' of '//to_text(n)//' facets, '//to_text(size(history))//' iterations')
    end do
    call say('turned    once, in '//to_text(n)//' facets')
  end subroutine turn_once

  !> The state of all points, one facet on: every material point takes displacement, traction and slip along to where it stands
  !> then. It is no equilibrium yet.
  pure subroutine roll_on(drive, state)
    type(drive_t), intent(in) :: drive      !< drive, as many facets round the ring as round the flexspline
    type(state_t), intent(inout) :: state   !< converged, then turned
    integer :: from(drive%problem%n), at(drive%problem%n), b, i, m
    associate (problem => drive%problem)
      do b = 1, size(problem%bodies)
        associate (first => problem%first(b), body => problem%bodies(b))
          from(first + 1:first + body%nodes()) = first + modulo([(i, i=1, body%nodes())] + body%nodes_per_sector - 1, &
            body%nodes()) + 1
        end associate
      end do
      m = problem%mortar%n
      at = 0
      at(problem%mortar%node) = [(i, i=1, m)]
      state%u = state%u(:, from)
      associate (point => at(from(problem%mortar%node)))
        state%traction = state%traction(:, point)
        state%slip = state%slip(:, point)
        state%gap = state%gap(point)
        state%contact = state%contact(point)
      end associate
    end associate
  end subroutine roll_on
end module hd_first_turn
