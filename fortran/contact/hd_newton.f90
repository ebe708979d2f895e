! SPDX-License-Identifier: GPL-3.0-or-later
!> Semi-smooth Newton iteration of one load step: equilibrium and contact law together (Hueeber, Stadler, Wohlmuth 2008).
module hd_newton
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_problem, only: problem_t, state_t, load_t, internal_residual, gap_and_slip, new_state
  use hd_contact_law, only: evaluate_law, open_state, stick_state, slip_state
  use hd_mortar, only: add_nodal_forces
  implicit none
  private
  public :: newton_options_t, iteration_t, iterate, respond

  type :: newton_options_t
    real(dp) :: tolerance = 1e-8_dp    !< relative residual of forces and contact law
    integer :: max_iterations = 60     !< Newton iterations per load step
    integer :: full_steps = 12         !< undamped iterations before the line search sets in
    real(dp) :: runaway = huge(1._dp)  !< displacement at which a body counts as sliding away [m]
  end type newton_options_t

  !> One row of the convergence history.
  type :: iteration_t
    integer :: iteration = 0           !< from 0 (before the first correction)
    real(dp) :: residual = 0           !< relative residual
    integer :: changes = 0             !< multipliers whose state changed
    integer :: open = 0, stick = 0, slip = 0  !< multipliers by state
    real(dp) :: damping = 1            !< length of the step that led here
    real(dp) :: seconds = 0            !< wall clock since the start of the step
  end type iteration_t

  !> Residuals and derivatives of an iterate.
  type :: linearisation_t
    real(dp), allocatable :: r_u(:, :), r_c(:, :), dw(:, :, :), dt(:, :, :)
    integer, allocatable :: contact(:)
    logical, allocatable :: idle(:, :)   !< components whose dofs are all prescribed: their traction stays 0
    real(dp) :: merit = 0
  end type linearisation_t

contains

  !> Iterate from `state` to the solution of a load step. Not converging is a result, not an error.
  subroutine iterate(problem, solver, options, load, previous, state, history, converged, sliding, error)
    type(problem_t), intent(in) :: problem                       !< problem
    class(linear_solver_t), intent(inout) :: solver              !< its linear solver
    type(newton_options_t), intent(in) :: options                !< tolerance and limits
    type(load_t), intent(in) :: load                             !< load at the end of the step
    type(state_t), intent(in) :: previous                        !< state at its beginning (friction history)
    type(state_t), intent(inout) :: state                        !< first guess, then solution
    type(iteration_t), allocatable, intent(out) :: history(:)    !< one entry per iterate
    logical, intent(out) :: converged                            !< residual below the tolerance
    logical, intent(out) :: sliding                              !< in balance, but displaced beyond `runaway`
    type(error_t), allocatable, intent(out) :: error             !< linear solver
    type(linearisation_t) :: here
    type(iteration_t) :: row
    real(dp), allocatable :: du(:, :), dt(:, :)
    integer(int64) :: start, now, rate
    call system_clock(start, rate)
    allocate (history(0))
    converged = .false.
    sliding = .false.
    where (problem%fixed) state%u = load%displacement
    du = state%u
    dt = state%traction
    call linearise(problem, load, previous, state, here)
    do
      call system_clock(now)
      row%residual = here%merit
      row%changes = count(here%contact /= state%contact)
      row%open = count(here%contact == open_state)
      row%stick = count(here%contact == stick_state)
      row%slip = count(here%contact == slip_state)
      row%seconds = real(now - start, dp)/rate
      history = [history, row]
      state%contact = here%contact
      sliding = here%merit < 1e-6_dp .and. maxval(abs(state%u)) > options%runaway
      if (sliding) return
      converged = here%merit <= options%tolerance
      if (converged) where (spread(here%contact == open_state, 1, 3)) state%traction = 0
      if (converged .or. row%iteration >= options%max_iterations .or. here%merit /= here%merit) return
      call solver%update(problem, here%dw, here%dt, error)
      if (allocated(error)) return
      call solver%solve(problem, here%r_u, here%r_c, du, dt, error)
      if (allocated(error)) return
      row%iteration = row%iteration + 1
      call advance(problem, load, previous, du, dt, row%iteration > options%full_steps, state, here, row%damping)
    end do
  end subroutine iterate

  !> Answer of a linear problem (bonded contact) to a load: one Newton step from rest.
  subroutine respond(problem, solver, load, factorise, state, error)
    type(problem_t), intent(in) :: problem               !< problem
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    type(load_t), intent(in) :: load                     !< load
    logical, intent(in) :: factorise                     !< the solver has not met this problem's law yet
    type(state_t), intent(out) :: state                  !< answer
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    type(linearisation_t) :: here
    type(state_t) :: rest
    real(dp), allocatable :: du(:, :), dt(:, :)
    call new_state(problem, rest)
    state = rest
    where (problem%fixed) state%u = load%displacement
    du = state%u
    dt = state%traction
    call linearise(problem, load, rest, state, here)
    if (factorise) call solver%update(problem, here%dw, here%dt, error)
    if (allocated(error)) return
    call solver%solve(problem, here%r_u, here%r_c, du, dt, error)
    if (allocated(error)) return
    state%u = state%u + du
    state%traction = state%traction + dt
    state%contact = here%contact
  end subroutine respond

  !> Take the Newton step, shortened where that lowers the residual if `search` is set.
  subroutine advance(problem, load, previous, du, dt, search, state, here, damping)
    type(problem_t), intent(in) :: problem            !< problem
    type(load_t), intent(in) :: load                  !< load
    type(state_t), intent(in) :: previous             !< beginning of the load step
    real(dp), intent(in) :: du(:, :), dt(:, :)        !< Newton correction
    logical, intent(in) :: search                     !< damp
    type(state_t), intent(inout) :: state             !< iterate
    type(linearisation_t), intent(inout) :: here      !< its linearisation
    real(dp), intent(out) :: damping                  !< length taken
    type(state_t) :: old
    real(dp) :: merit, best, best_damping
    integer :: k
    old = state
    merit = here%merit
    best = huge(best)
    best_damping = 1
    damping = 1
    do k = 0, merge(7, 0, search)
      damping = 0.5_dp**k
      state%u = old%u + damping*du
      state%traction = old%traction + damping*dt
      call linearise(problem, load, previous, state, here)
      if (here%merit < best) then
        best = here%merit
        best_damping = damping
      end if
      if (here%merit < (1 - 0.1_dp*damping)*merit) return
    end do
    if (damping == best_damping) return
    damping = best_damping
    state%u = old%u + damping*du
    state%traction = old%traction + damping*dt
    call linearise(problem, load, previous, state, here)
  end subroutine advance

  !> Residuals, derivatives of the law and the relative residual of an iterate.
  subroutine linearise(problem, load, previous, state, here)
    type(problem_t), intent(in) :: problem          !< problem
    type(load_t), intent(in) :: load                !< load
    type(state_t), intent(in) :: previous           !< beginning of the load step
    type(state_t), intent(inout) :: state           !< iterate; gets its gap and slip
    type(linearisation_t), intent(inout) :: here    !< linearisation
    real(dp), allocatable :: force(:, :)
    real(dp) :: scale, law
    integer :: c, i, j
    if (.not. allocated(here%contact)) then
      allocate (here%r_c(3, problem%mortar%n), here%dw(3, 3, problem%mortar%n), here%dt(3, 3, problem%mortar%n), &
        here%contact(problem%mortar%n))
      here%idle = idle_components(problem)
    end if
    call gap_and_slip(problem, load, state)
    do j = 1, problem%mortar%n
      call evaluate_law(problem%law, state%traction(:, j), [state%gap(j), state%slip(:, j) - previous%slip(:, j)], &
        previous%traction(2:, j), here%r_c(:, j), here%dw(:, :, j), here%dt(:, :, j), here%contact(j))
      do c = 1, 3
        if (.not. here%idle(c, j)) cycle
        here%r_c(c, j) = state%traction(c, j)
        here%dw(c, :, j) = 0
        here%dt(c, :, j) = [(merge(1, 0, i == c), i=1, 3)]
      end do
    end do
    here%r_u = internal_residual(problem, load, state)
    allocate (force(3, problem%n), source=0._dp)
    call add_nodal_forces(problem%mortar, state%traction, force)
    law = sqrt(sum((spread(problem%mortar%area, 1, 3)*here%r_c)**2))
    scale = norm2(force) + norm2(load%force) + norm2(pack(here%r_u, problem%fixed)) + law + tiny(scale)
    here%merit = sqrt(sum(here%r_u**2, mask=.not. problem%fixed) + law**2)/scale
  end subroutine linearise

  !> Traction components that act on prescribed dofs only, or on no facet opposite.
  pure function idle_components(problem) result(idle)
    type(problem_t), intent(in) :: problem  !< problem
    logical :: idle(3, problem%mortar%n)
    integer :: j
    do j = 1, problem%mortar%n
      idle(:, j) = all(problem%fixed(:, problem%mortar%col(problem%mortar%ptr(j):problem%mortar%ptr(j + 1) - 1)), 2)
      if (.not. problem%mortar%area(j) > 0) idle(:, j) = .true.
    end do
  end function idle_components
end module hd_newton
