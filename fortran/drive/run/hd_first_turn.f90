! SPDX-License-Identifier: GPL-3.0-or-later
!> One turn of the wave generator in the assembled drive, without torque: flexspline and ring move on by a facet at a time
!> (hd_rolling) and come to equilibrium again, with the friction of where they were. What the assembly left in the contact is so
!> worn off. Balls and cam keep their places; the cage, which lags behind, is left out.
module hd_first_turn
  use hd_drive, only: drive_t
  use hd_error, only: error_t, raise, code_not_converged, code_stopped
  use hd_linear_solver, only: linear_solver_t
  use hd_log, only: say, detail
  use hd_newton, only: newton_options_t, iteration_t, iterate
  use hd_problem, only: load_t, state_t
  use hd_rolling, only: roll_on
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
end module hd_first_turn
