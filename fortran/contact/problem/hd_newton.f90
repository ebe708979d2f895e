! SPDX-License-Identifier: GPL-3.0-or-later
!> Semi-smooth Newton iteration of one load step: equilibrium and contact law together (Hueeber, Stadler, Wohlmuth 2008).
!>
!> Where the contact states run in a cycle, or the residual stalls, friction is softened: shear follows the slip elastically
!> from an anchor, the outer iterate (proximal point method). Each outer step moves the anchor to the solution and stiffens, in the
!> end only while that is easy; where the anchor is the solution the softened law is Coulomb's. Once the residual is small,
!> Newton's method finishes.
module hd_newton
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_checked_solve, only: solve_checked
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_problem, only: problem_t, state_t, load_t, internal_residual, gap_and_slip, keep_state, new_state, update_tangent, &
    strain_bodies, apply_stiffness, largest_stiffness, pair_bodies, update_struts
  use hd_contact_law, only: contact_law_t, evaluate_law, frictionless, open_state, stick_state, slip_state
  use hd_hold, only: hold_less, hold_more
  use hd_mortar, only: add_nodal_forces
  use hd_pairing, only: pairing_error
  use hd_strut_step, only: ahead_t, count_ahead
  use hd_system, only: check_stop
  use hd_tabulated_law, only: stiffness_at_pressure
  use hd_vector, only: add, largest, length, many, part_lengths, weighted_length
  implicit none
  private
  public :: newton_options_t, iteration_t, iterate, respond, linear_equations, idle_components, prescribe

  integer, parameter :: full_steps = 12  !< undamped iterations before the line search sets in

  type :: newton_options_t
    real(dp) :: tolerance = 1e-8_dp    !< relative residual of forces and contact law
    integer :: max_iterations = 60     !< Newton iterations per load step
    real(dp) :: runaway = huge(1._dp)  !< displacement at which a body counts as sliding away [m]
    real(dp) :: torque = 0             !< amount of the torque [N m]
    logical :: rough = .false.         !< pairs will be moved, and equilibrium between them need not be near
    logical :: anew = .false.          !< the step goes another way than the last: its beginning is no solution, however near
  end type newton_options_t

  !> One row of the convergence history.
  type :: iteration_t
    integer :: iteration = 0           !< from 0 (before the first correction)
    real(dp) :: residual = 0           !< relative residual
    integer :: changes = 0             !< multipliers whose state changed
    integer :: open = 0, stick = 0, slip = 0  !< multipliers by state
    real(dp) :: damping = 1            !< length of the step that led here
    real(dp) :: linear = 0             !< backward error of the linear equations behind that step
    real(dp) :: seconds = 0            !< wall clock since the start of the step
    integer :: period = 0              !< iterations since the same contact states stood before without a better residual, 0: new
  end type iteration_t

  !> Residuals and derivatives of an iterate.
  type :: linearisation_t
    real(dp), allocatable :: r_u(:, :), r_c(:, :), dw(:, :, :), dt(:, :, :)
    integer, allocatable :: contact(:)
    logical, allocatable :: idle(:, :)   !< components whose dofs are all prescribed: their traction stays 0
    real(dp) :: merit = 0                !< relative residual
    real(dp) :: distance = 0             !< absolute one, which the line search lowers [N]
    logical :: forceless = .false.       !< all forces, those of supports too, are rounding
    logical :: far_ends = .false.        !< springs have far ends that move
    real(dp) :: stiffness = 0            !< largest of the bodies, for what rounding leaves of forces that cancel [N/m]
    type(contact_law_t) :: law           !< the law, softened or not
    real(dp), allocatable :: anchor(:, :) !< tractions it refers to (3, multipliers) [Pa]
    real(dp), allocatable :: lead(:, :)   !< shear where points slip when the step begins, else 0 (2, multipliers) [Pa]
  end type linearisation_t

  !> Memory of the globalisation.
  type :: globalisation_t
    integer, allocatable :: seen(:, :)     !< contact states of the series of iterates (multipliers, iterates)
    real(dp), allocatable :: merits(:)     !< their residuals
    type(state_t) :: saved                 !< iterate to which the softened iteration returns, if there is one
    real(dp) :: lowest = huge(1._dp)       !< lowest residual of the series
    real(dp) :: harden = 1e-2_dp           !< residual of the hard law at which Newton's method takes over again
    real(dp) :: softness = 0               !< of the outer step [m/Pa]
    integer :: best = 0                    !< its iteration
    integer :: since = 0                   !< iteration at which the series began
    integer :: outer = 0                   !< softened outer steps
    real(dp) :: hard = 1                   !< residual of the hard law after the last of them
    integer :: begun = 0                   !< iteration at which the outer step began
    logical :: damped = .false.            !< the line search is on from here on
  end type globalisation_t

  !> what an outer step stiffens by, gains and asks of the next; and Armijo's share of the fall that a Newton step promises
  real(dp), parameter :: tenth = 0.1_dp
  integer, parameter :: halvings = 7            !< of a step in a line search: down to a hundredth of it
  real(dp), parameter :: least_share = 0.1_dp   !< of the pairs' way that Aitken's rule may leave: less is no step
  real(dp), parameter :: clear = 1e-3_dp   !< residual at which what a body does is seen: where all is open, that it flies away,
  !> and where points touch, that they do not hold it; Newton's method passes through the former
  real(dp), parameter :: small = 1e-6_dp
  real(dp), parameter :: whole = 1e-5_dp        !< accuracy of a correction that is taken whole,
  real(dp), parameter :: searched = 1e-9_dp     !< and of one whose length is searched, for a line search fails on a rougher one
  real(dp), parameter :: unstrained = 1e-7_dp   !< share of stiffness times displacement that is a force at least
  real(dp), parameter :: rounding = 10*epsilon(1._dp)  !< of forces, over that product: none in the bodies is seen
  real(dp), parameter :: useless = 1._dp        !< backward error of a correction that is not taken
  integer, parameter :: patience = 8           !< iterations without a new lowest residual before the law is softened, by judgement
  real(dp), parameter :: softest = 100         !< compliance of the first outer step, times the scale of the law: two tenths from 1
  !> compliance times that scale below which outer steps stiffen only after easy ones: above the last of the tenths from
  !> `softest` on, 1, at which scenes with short edge cells crept
  real(dp), parameter :: stiff = 1.5_dp
  integer, parameter :: easy = 2                !< iterations of an easy outer step
  real(dp), parameter :: inner_tolerance = 1e-3_dp  !< of a softened problem
  integer, parameter :: few = 10                    !< iterations in which a step that begins within the tolerance finds its states
  integer, parameter :: most_pairings = 8           !< rounds of a load step in which pairs may still move
  !> share of its first residual, and residual, that a round before the last leaves: what is left moves pairs by a hundredth of it
  real(dp), parameter :: gain = 0.03_dp, loose = 1e-3_dp
  integer, parameter :: few_pairings = 3            !< rounds in which the turn of normals [rad] and way of pairs, over the radius,
  real(dp), parameter :: sought = 1e-8_dp           !< may be this, or so many tolerances,
  real(dp), parameter :: tolerances = 5             !< (K1 to K3 to 3e-7 at 1e-8)
  real(dp), parameter :: bearable = 1e-5_dp         !< and what may be left in more of them;
  real(dp), parameter :: moment_left = 1e-3_dp      !< moment of the pressure by that way, over the torque,
  real(dp), parameter :: rounding_left = 1e-8_dp    !< unless the way over the radius is as short as this

contains

  !> Solve a load step from the first guess `state`: equilibrium between given pairs, pairs anew where that moved them, until
  !> they stay. Not converging is a result, not an error.
  subroutine iterate(problem, solver, options, load, previous, state, history, converged, sliding, error)
    type(problem_t), intent(inout) :: problem                    !< problem; tangent and pairs follow the iterates
    class(linear_solver_t), intent(inout) :: solver              !< its linear solver
    type(newton_options_t), intent(in) :: options                !< tolerance and limits
    type(load_t), intent(in) :: load                             !< load at the end of the step
    type(state_t), intent(in) :: previous                        !< state at its beginning (friction history)
    type(state_t), intent(inout) :: state                        !< first guess, then solution
    type(iteration_t), allocatable, intent(out) :: history(:)    !< one entry per iterate
    logical, intent(out) :: converged                            !< residual below the tolerance
    logical, intent(out) :: sliding                              !< in balance, but displaced beyond `runaway`, or pairs slide on
    type(error_t), allocatable, intent(out) :: error             !< linear solver
    type(iteration_t), allocatable :: more(:)
    type(newton_options_t) :: round
    real(dp), allocatable :: paired(:, :), moved(:, :), before(:, :)
    real(dp) :: share
    logical :: stay
    integer :: k
    allocate (history(0))
    round = options
    if (allocated(problem%pairing)) paired = state%u
    share = 1
    stay = .false.
    do k = 1, most_pairings
      if (allocated(paired) .and. .not. stay) call pair_bodies(problem, paired, again=k > 1)
      round%rough = allocated(paired) .and. .not. stay .and. k < few_pairings
      solver%goes_on = k > 2  ! in the first round the bodies may come from rest
      call settle(problem, solver, round, load, previous, state, more, converged, sliding, error)
      solver%goes_on = .false.
      if (size(history) > 0) more%iteration = more%iteration + history(size(history))%iteration
      history = [history, more(merge(2, 1, stay):)]
      if (allocated(error) .or. .not. (converged .and. allocated(problem%pairing))) return
      moved = state%u - paired
      if (allocated(before) .and. .not. stay) share = share*sum(before*(before - moved))/ &
        max(sum((before - moved)**2), tiny(1._dp))  ! Aitken's
      sliding = share > 2  ! pairs move on by more than half of their last way
      stay = pairs_stay(problem, options, state, merge(bearable, min(bearable, max(sought, tolerances*options%tolerance)), &
        sliding .or. k > few_pairings))
      sliding = sliding .and. .not. stay
      if (sliding .or. (stay .and. (more(size(more))%residual <= options%tolerance .or. .not. round%rough))) exit
      if (stay) cycle
      share = min(1._dp, max(least_share, share))
      paired = paired + share*moved
      before = moved
    end do
    converged = stay .and. k <= most_pairings
  end subroutine iterate

  !> Pairs are still those of the faces, as near as matters.
  logical function pairs_stay(problem, options, state, moved)
    type(problem_t), intent(in) :: problem         !< problem
    type(newton_options_t), intent(in) :: options  !< torque
    type(state_t), intent(in) :: state             !< equilibrium between its pairs
    real(dp), intent(in) :: moved                  !< turn of normals [rad] and way of pairs, over the radius, that may be left
    real(dp) :: apart, turned
    integer :: i
    call pairing_error(problem%pairing, problem%mortar, state%u, state%traction(1, :), apart, turned)
    pairs_stay = turned <= moved .and. apart <= moved*problem%pairing%radius
    if (allocated(problem%placing)) then
      do i = 1, size(problem%placing%struts)
        if (problem%strut_rate(problem%placing%struts(i)) > 0) pairs_stay = pairs_stay .and. &
          abs(problem%placing%foot(i, state%u) - problem%strut_foot(i)) <= moved
      end do
    end if
    if (pairs_stay .and. options%torque > 0) pairs_stay = apart <= rounding_left*problem%pairing%radius .or. &
      apart*sum(problem%mortar%area*state%traction(1, :)) <= moment_left*options%torque
  end function pairs_stay

  !> Iterate from `state` to equilibrium between the present pairs.
  subroutine settle(problem, solver, options, load, previous, state, history, converged, sliding, error)
    type(problem_t), intent(inout) :: problem                    !< problem; its tangent follows the iterates
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
    type(globalisation_t) :: global
    type(iteration_t) :: row
    type(state_t) :: guess
    real(dp), allocatable :: du(:, :), dt(:, :)
    real(dp) :: tolerance
    logical :: search
    type(ahead_t) :: ahead
    integer(int64) :: start, now, rate
    call system_clock(start, rate)
    allocate (history(0))
    converged = .false.
    sliding = .false.
    if (allocated(problem%holds)) problem%holds%rate = 0
    call solver%begin(problem, load, previous, error)
    if (allocated(error)) return
    if (allocated(problem%lagrangian)) guess = state
    call prescribe(problem, load, state%u)
    allocate (du, mold=state%u)
    allocate (dt, mold=state%traction)
    here%stiffness = largest_stiffness(problem)
    call linearise(problem, load, previous, state, here)
    ! prescribed displacements alone would strain the cells at the support beyond use: the first correction is linear in them
    if (allocated(problem%lagrangian)) then
      call update_tangent(problem, guess%u)
      if (any(abs(state%u - guess%u) > 0)) then
        call internal_residual(problem, load, guess, here%r_u)
        call apply_stiffness(problem, state%u - guess%u, du)
        here%r_u = here%r_u + du
      end if
    end if
    tolerance = options%tolerance
    if (options%rough) tolerance = max(tolerance, min(loose, gain*here%merit))
    do
      call system_clock(now)
      row%residual = here%merit
      row%changes = count(here%contact /= state%contact)
      row%open = count(here%contact == open_state)
      row%stick = count(here%contact == stick_state)
      row%slip = count(here%contact == slip_state)
      row%seconds = real(now - start, dp)/rate
      history = [history, row]
      call check_stop(error)
      if (allocated(error)) return
      state%contact = here%contact
      sliding = here%merit <= max(options%tolerance, merge(clear, small, row%open == problem%mortar%n))
      if (sliding) sliding = largest(size(state%u), state%u) > options%runaway
      if (sliding) return
      converged = (here%merit <= tolerance .or. here%forceless) .and. .not. here%law%softness > 0
      if (options%anew .and. history(1)%residual <= tolerance) converged = converged .and. &
        row%iteration > 0 .and. (row%changes == 0 .or. row%iteration >= few)
      if (converged) where (spread(here%contact == open_state, 1, 3)) state%traction = 0
      if (converged .or. row%iteration >= options%max_iterations .or. here%merit /= here%merit) return
      call globalise(problem, load, previous, row%iteration, state, here, global, history(size(history))%period)
      if (row%iteration > 0) call update_tangent(problem, state%u)
      call update_struts(problem, load, state%u)
      if (allocated(problem%holds) .and. row%iteration > 0) call hold_less(problem%holds, problem%groove, problem%struts, &
        problem%strut_rate, du)
      call count_ahead(problem, load, state%u, row%stick > 0, ahead, here%r_u)
      search = row%iteration + 1 - global%since > full_steps .or. here%law%softness > 0 .or. global%damped
      solver%accuracy = merge(searched, whole, search)
      ! a wheel on its way over the play needs a whole correction: one that stops short of the other flank has got nowhere
      if (allocated(problem%pairing)) solver%accuracy = merge(whole, of_use(options, here%merit), ahead%some)
      call find_correction(problem, solver, here, du, dt, row%linear, error)
      if (allocated(error) .or. .not. row%linear < useless) return
      row%iteration = row%iteration + 1
      call take_newton_step(problem, load, previous, du, dt, search, state, here, row%damping)
    end do
  end subroutine settle

  !> Accuracy of a correction that the next one can use, where pairs move: as the residual is small (Dembo, Eisenstat, Steihaug
  !> 1982), or little is left to do, or pairs move it up again.
  pure real(dp) function of_use(options, merit)
    type(newton_options_t), intent(in) :: options  !< tolerance, and whether pairs will be moved
    real(dp), intent(in) :: merit                  !< relative residual
    of_use = max(whole, min(tenth, max(merit, tenth*options%tolerance/merit, merge(tenth, 0._dp, options%rough))))
  end function of_use

  !> Newton's correction, made again with the holds of the ring (hd_hold) where it moves the ring too far.
  subroutine find_correction(problem, solver, here, du, dt, accuracy, error)
    type(problem_t), intent(inout) :: problem            !< problem with its tangents
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    type(linearisation_t), intent(in) :: here            !< at the iterate
    real(dp), intent(inout) :: du(:, :), dt(:, :)        !< correction
    real(dp), intent(out) :: accuracy                    !< its backward error
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    logical :: more
    do
      call solver%update(problem, here%dw, here%dt, error)
      if (allocated(error)) return
      call solve_checked(problem, solver, here%dw, here%dt, here%r_u, here%r_c, du, dt, accuracy, error)
      if (allocated(error) .or. .not. allocated(problem%holds)) return
      call hold_more(problem%holds, problem%groove, problem%struts, problem%strut_rate, du, more)
      if (.not. more) return
    end do
  end subroutine find_correction

  !> Enter the values of the fixed dofs; a wheel keeps its turn.
  subroutine prescribe(problem, load, u)
    type(problem_t), intent(in) :: problem   !< problem
    type(load_t), intent(in) :: load         !< load
    real(dp), intent(inout) :: u(:, :)       !< displacements (3, n) [m]
    real(dp) :: turn
    integer :: i
    turn = 0
    if (allocated(problem%wheel)) turn = u(2, problem%wheel(1))
    !$omp parallel do schedule(static) if(size(u) > many)
    do i = 1, problem%n
      where (problem%fixed(:, i)) u(:, i) = load%displacement(:, i)
    end do
    !$omp end parallel do
    if (allocated(problem%wheel)) u(2, problem%wheel) = turn
  end subroutine prescribe

  !> Answer of a linear problem (bonded contact) to a load: one Newton step from rest.
  subroutine respond(problem, solver, load, factorise, state, error)
    type(problem_t), intent(inout) :: problem            !< problem; its strains follow
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

  !> Residuals of the law in a state, and its derivatives there. A point that sticks has no slip to turn, and without it a law that
  !> is smooth there.
  subroutine linear_equations(problem, load, previous, state, r_c, dw, dt)
    type(problem_t), intent(in) :: problem                 !< problem
    type(load_t), intent(in) :: load                       !< load
    type(state_t), intent(in) :: previous                  !< beginning of the load step
    type(state_t), intent(inout) :: state                  !< gets gap and slip
    real(dp), allocatable, intent(out) :: r_c(:, :)        !< residuals of the law (3, multipliers) [Pa]
    real(dp), allocatable, intent(out) :: dw(:, :, :), dt(:, :, :)  !< its derivatives
    type(linearisation_t) :: here
    integer :: j
    call begin_linearisation(problem, load, previous, here)
    call gap_and_slip(problem, load, previous, state)
    do j = 1, size(state%contact)
      if (state%contact(j) == stick_state .and. .not. creeps(problem%law, previous%traction(:, j), state%traction(:, j), &
        state%slip(:, j) - previous%slip(:, j))) here%lead(:, j) = 0
    end do
    call apply_law(problem, previous, state, here)
    call move_alloc(here%r_c, r_c)
    call move_alloc(here%dw, dw)
    call move_alloc(here%dt, dt)
  end subroutine linear_equations

  !> A point that sticks slips a little all the same: asperities of a rough joint give way, beyond what they do elastically.
  pure logical function creeps(law, before, traction, slip)
    type(contact_law_t), intent(in) :: law              !< law
    real(dp), intent(in) :: before(3), traction(3)      !< at the beginning and end of the load step [Pa]
    real(dp), intent(in) :: slip(2)                     !< in it [m]
    real(dp), parameter :: least = 1e-4_dp              !< of the elastic slip: more than keys are changed by
    real(dp) :: k, slope
    creeps = .false.
    if (.not. allocated(law%joint) .or. .not. traction(1) > 0) return
    call stiffness_at_pressure(law%joint, traction(1), k, slope)
    creeps = norm2(k*slip + traction(2:) - before(2:)) > least*norm2(traction(2:))
  end function creeps

  !> Decide on the law of the next iteration: harden a softened one that is solved, soften where the iteration cycles or stalls.
  subroutine globalise(problem, load, previous, iteration, state, here, global, period)
    type(problem_t), intent(inout) :: problem         !< problem; its strains follow
    type(load_t), intent(in) :: load                  !< load
    type(state_t), intent(in) :: previous             !< beginning of the load step
    integer, intent(in) :: iteration                  !< iterations so far
    type(state_t), intent(inout) :: state             !< iterate
    type(linearisation_t), intent(inout) :: here      !< its linearisation
    type(globalisation_t), intent(inout) :: global    !< memory
    integer, intent(inout) :: period                  !< of a cycle of the contact states
    if (allocated(problem%law%joint)) then  ! it is soft by itself: back to the best iterate, and damped from there, once
      if (global%damped) return
      global%damped = cycles(here, state, iteration, global, period)
      if (.not. global%damped) return
      state = global%saved
      call linearise(problem, load, previous, state, here)
      return
    end if
    if (here%law%softness > 0) then
      if (here%merit > min(inner_tolerance, tenth*global%hard)) return
      global%outer = global%outer + 1
      if (global%softness*here%law%scale > stiff .or. iteration - global%begun <= easy) global%softness = tenth*global%softness
      global%begun = iteration
      here%anchor = state%traction
      here%law%softness = 0
      call linearise(problem, load, previous, state, here)
      global%hard = here%merit
      if (here%merit < global%harden) then
        global%harden = tenth*global%harden
        call keep_state(state, global%saved)
        call forget(iteration, global)
      else
        here%law%softness = global%softness
        call linearise(problem, load, previous, state, here)
      end if
      return
    end if
    if (.not. cycles(here, state, iteration, global, period)) return
    if (allocated(global%saved%u)) state = global%saved
    here%anchor = state%traction
    if (global%outer == 0) global%softness = softest/here%law%scale
    here%law%softness = global%softness
    call linearise(problem, load, previous, state, here)
  end subroutine globalise

  !> The contact states repeat an earlier iterate's without a lower residual, or no lower residual comes for long.
  logical function cycles(here, state, iteration, global, period)
    type(linearisation_t), intent(in) :: here         !< linearisation
    type(state_t), intent(in) :: state                !< iterate
    integer, intent(in) :: iteration                  !< iterations so far
    type(globalisation_t), intent(inout) :: global    !< memory, gets this iterate
    integer, intent(inout) :: period                  !< iterations since the same states, if they repeat
    integer :: k
    cycles = .false.
    if (.not. allocated(global%seen)) allocate (global%seen(size(here%contact), 0), global%merits(0))
    do k = 1, size(global%seen, 2) - 1
      if (.not. all(global%seen(:, k) == here%contact)) cycle
      if (here%merit > 0.5_dp*global%merits(k)) period = size(global%merits) + 1 - k
    end do
    if (here%merit < global%lowest) then
      global%lowest = here%merit
      global%best = iteration
      if (global%outer == 0) call keep_state(state, global%saved)
    end if
    cycles = period > 0 .or. iteration - global%best >= patience
    global%merits = [global%merits, here%merit]
    global%seen = reshape([global%seen, here%contact], [size(here%contact), size(global%merits)])
  end function cycles

  !> Start a new series of iterates.
  subroutine forget(iteration, global)
    integer, intent(in) :: iteration                  !< iterations so far
    type(globalisation_t), intent(inout) :: global    !< memory
    global%lowest = huge(1._dp)
    global%best = iteration
    global%since = iteration
    if (allocated(global%seen)) deallocate (global%seen, global%merits)
  end subroutine forget

  !> Take the Newton step, shortened where that lowers the residual if `search` is set.
  subroutine take_newton_step(problem, load, previous, du, dt, search, state, here, damping)
    type(problem_t), intent(inout) :: problem         !< problem; its strains follow
    type(load_t), intent(in) :: load                  !< load
    type(state_t), intent(in) :: previous             !< beginning of the load step
    real(dp), intent(in) :: du(:, :), dt(:, :)        !< Newton correction
    logical, intent(in) :: search                     !< damp
    type(state_t), intent(inout) :: state             !< iterate
    type(linearisation_t), intent(inout) :: here      !< its linearisation
    real(dp), intent(out) :: damping                  !< length taken
    type(state_t) :: old
    real(dp) :: merit, begun, best, best_damping
    integer :: k
    damping = 1
    if (.not. search) then
      call add(size(du), 1._dp, du, state%u)
      call add(size(dt), 1._dp, dt, state%traction)
      call linearise(problem, load, previous, state, here)
      return
    end if
    old = state
    merit = here%distance
    begun = here%merit
    best = huge(best)
    best_damping = 1
    do k = 0, halvings
      damping = 0.5_dp**k
      state%u = old%u + damping*du
      state%traction = old%traction + damping*dt
      call linearise(problem, load, previous, state, here)
      if (here%distance < best) then
        best = here%distance
        best_damping = damping
      end if
      if (here%distance < (1 - tenth*damping)*merit) return
    end do
    ! struts that come and go lie behind a ridge; where little is left, a step that long leads back to where the iteration came from
    if (allocated(problem%struts) .and. begun > clear .and. .not. best < merit) best_damping = 1
    if (damping == best_damping) return
    damping = best_damping
    state%u = old%u + damping*du
    state%traction = old%traction + damping*dt
    call linearise(problem, load, previous, state, here)
  end subroutine take_newton_step

  !> Residuals, derivatives of the law and the relative residual of an iterate.
  subroutine linearise(problem, load, previous, state, here)
    type(problem_t), intent(inout) :: problem       !< problem; its strains follow
    type(load_t), intent(in) :: load                !< load
    type(state_t), intent(in) :: previous           !< beginning of the load step
    type(state_t), intent(inout) :: state           !< iterate; gets its gap and slip
    type(linearisation_t), intent(inout) :: here    !< linearisation
    real(dp), allocatable :: force(:, :)
    real(dp) :: scale, law, moved, pushed, held, left
    integer :: j
    if (.not. allocated(here%contact)) then
      call begin_linearisation(problem, load, previous, here)
      here%far_ends = any(problem%spring > 0 .and. abs(load%force) > 0)
    end if
    call gap_and_slip(problem, load, previous, state)
    call apply_law(problem, previous, state, here)
    call strain_bodies(problem, state%u)
    call internal_residual(problem, load, state, here%r_u, pushed)
    allocate (force(3, problem%n))
    !$omp parallel do schedule(static) if(size(force) > many)
    do j = 1, problem%n
      force(:, j) = 0
    end do
    !$omp end parallel do
    call add_nodal_forces(problem%mortar, state%traction, force)
    law = weighted_length(problem%mortar%area, here%r_c)
    moved = length(size(state%u), state%u)
    scale = length(size(force), force) + loaded_with(problem, load, here%far_ends, state%u) + law + pushed + tiny(scale)
    call part_lengths(here%r_u, problem%fixed, held, left)
    scale = scale + held
    here%forceless = scale <= rounding*here%stiffness*moved
    scale = scale + unstrained*here%stiffness*moved  ! bodies moved as a whole have no forces but rounding
    here%distance = hypot(left, law)
    if (problem%wheel_turns) here%distance = hypot(here%distance, sum(here%r_u(2, problem%wheel)))
    here%merit = here%distance/scale
  end subroutine linearise

  !> Size of the loads; where a spring's far end is moved, that of its force, not of its stiffness times the way [N].
  real(dp) function loaded_with(problem, load, far_ends, u) result(size_of)
    type(problem_t), intent(in) :: problem          !< problem
    type(load_t), intent(in) :: load                !< load
    logical, intent(in) :: far_ends                 !< such springs are there
    real(dp), intent(in) :: u(:, :)                 !< displacements (3, n) [m]
    if (far_ends) then
      size_of = length(size(u), load%force - merge(problem%spring*u, 0._dp, abs(load%force) > 0))
    else
      size_of = length(size(u), load%force)
    end if
  end function loaded_with

  !> Room for a linearisation, and the law of its load step.
  subroutine begin_linearisation(problem, load, previous, here)
    type(problem_t), intent(in) :: problem          !< problem
    type(load_t), intent(in) :: load                !< load
    type(state_t), intent(in) :: previous           !< beginning of the load step
    type(linearisation_t), intent(inout) :: here    !< linearisation
    allocate (here%r_c(3, problem%mortar%n), here%dw(3, 3, problem%mortar%n), here%dt(3, 3, problem%mortar%n), &
      here%contact(problem%mortar%n), here%r_u(3, problem%n))
    here%idle = idle_components(problem)
    here%law = problem%law
    here%law%friction = load%friction
    here%anchor = previous%traction
    here%lead = leads(previous)
  end subroutine begin_linearisation

  !> The law of all points at their gap and slip.
  subroutine apply_law(problem, previous, state, here)
    type(problem_t), intent(in) :: problem          !< problem
    type(state_t), intent(in) :: previous           !< beginning of the load step
    type(state_t), intent(in) :: state              !< iterate
    type(linearisation_t), intent(inout) :: here    !< gets r_c, dw, dt, contact
    integer :: c, i, j
    !$omp parallel do schedule(static) private(c, i) if(9*problem%mortar%n > many/4)
    do j = 1, problem%mortar%n
      if (j > problem%mortar%n - problem%mortar%rigid) then
        call evaluate_law(contact_law_t(mode=frictionless, scale=here%law%scale), state%traction(:, j), &
          [state%gap(j), 0._dp, 0._dp], here%anchor(:, j), here%lead(:, j), here%r_c(:, j), &
          here%dw(:, :, j), here%dt(:, :, j), here%contact(j))
      else
        call evaluate_law(here%law, state%traction(:, j), [state%gap(j), state%slip(:, j) - previous%slip(:, j)], &
          here%anchor(:, j), here%lead(:, j), here%r_c(:, j), here%dw(:, :, j), here%dt(:, :, j), here%contact(j))
      end if
      do c = 1, 3
        if (.not. here%idle(c, j)) cycle
        here%r_c(c, j) = state%traction(c, j)
        here%dw(c, :, j) = 0
        here%dt(c, :, j) = [(merge(1, 0, i == c), i=1, 3)]
      end do
    end do
    !$omp end parallel do
  end subroutine apply_law

  !> Shear of points that slip.
  pure function leads(state) result(lead)
    type(state_t), intent(in) :: state  !< beginning of a load step
    real(dp) :: lead(2, size(state%contact))
    lead = merge(state%traction(2:, :), 0._dp, spread(state%contact == slip_state, 1, 2))
  end function leads

  !> Traction components that act on prescribed dofs only, or on no facet opposite.
  function idle_components(problem) result(idle)
    type(problem_t), intent(in) :: problem  !< problem
    logical :: idle(3, problem%mortar%n)
    integer :: j, k
    !$omp parallel do schedule(static) private(k) if(problem%mortar%n > many/8)
    do j = 1, problem%mortar%n
      idle(:, j) = .true.
      if (.not. problem%mortar%area(j) > 0) cycle
      do k = problem%mortar%ptr(j), problem%mortar%ptr(j + 1) - 1
        idle(:, j) = idle(:, j) .and. problem%fixed(:, problem%mortar%col(k))
      end do
    end do
    !$omp end parallel do
  end function idle_components
end module hd_newton
