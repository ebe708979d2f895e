! SPDX-License-Identifier: GPL-3.0-or-later
!> Load steps of a run: parts that grow and are cut, gross slip found and bracketed, and what to say where it ends.
module hd_load_step
  use hd_kinds, only: dp
  use hd_attempts, only: attempt_t
  use hd_clock, only: wall_seconds
  use hd_coarse_start, only: guess_from
  use hd_contact_law, only: open_state
  use hd_drive, only: drive_load, step_friction, touch_teeth
  use hd_error, only: error_t, raise, code_not_converged, code_stopped
  use hd_first_turn, only: turn_once
  use hd_friction_path, only: raise_friction
  use hd_load_path, only: place_t, operator(<), ahead, assembled, assembly_at, begins, largest_torque, place_at, step_end, &
    stretch, torque_at
  use hd_log, only: detail
  use hd_loop, only: no_force
  use hd_lapack, only: blas_threads
  use hd_newton, only: newton_options_t, iteration_t, iterate
  use hd_output, only: step_t, write_history
  use hd_problem, only: state_t, load_t, move_state, pair_bodies, strut_closings, strut_forces
  use hd_run, only: run_t, accept, keep_checkpoint, kept_text, place_step
  use hd_scene, only: scene_t
  use hd_strut_step, only: remember
  use hd_balance, only: contact_torque
  use hd_system, only: hold_stop, stop_requested
  use hd_teeth, only: new_teeth, turn_hub
  use hd_text, only: to_text, rounded
  use hd_tooth_flanks, only: turn_to_flank
  use hd_timers, only: in_newton, in_output, in_setup, in_turn
  use hd_vector, only: many
  implicit none
  private
  public :: solve_step

  !> Where a torque begins or turns back, shear at the bound is taken a little below it: these points stick first, all of them. At
  !> the bound rounding would say which.
  real(dp), parameter :: below_bound = 1e-6_dp
  real(dp), parameter :: some_friction = 1e-3_dp  !< capacity over the torque carried while sliding: below it there was none
  real(dp), parameter :: nearly = 0.95_dp    !< share of its capacity from which friction is said to be used up
  real(dp), parameter :: unbalanced = 1e-2_dp   !< share of the torque out of balance that is refused,
  real(dp), parameter :: of_pressure = 1e-6_dp  !< beyond rounding: this of normal force times radius
  real(dp), parameter :: used_up = 1.003_dp  !< capacity of friction over the torque at which no further part is worth a trial
  real(dp), parameter :: rounding = 1e-11_dp  !< residual, relative, that a failed iteration stood at for rounding alone
  integer, parameter :: few_iterations = 10  !< after so few the next part of a load step may be twice as long

contains

  !> Solve the next load step, in parts where it must be cut: down to 2^-max_cuts of it, for smaller ones are no progress. Where the
  !> torque is known at which the contact slips, parts are shares of the way there, and their failures are counted together.
  subroutine solve_step(run, error)
    type(run_t), intent(inout) :: run                 !< run, not at its end
    type(error_t), allocatable, intent(out) :: error  !< not converged, gross slip, stopped, solver
    type(place_t) :: target, part
    real(dp) :: slip_torque
    integer :: cuts, attempt
    logical :: solved, sliding, spent
    target = step_end(run%place)
    if (begins(run%scene, run%place)) run%stride = 1
    part = ahead(run%place, run%stride)
    cuts = 0
    attempt = 0
    slip_torque = 0
    run%step%iterations = 0
    run%step_clock = wall_seconds()
    do while (run%place < target)
      if (stop_requested()) then
        call interrupt(run, error)
      else if (out_of_time(run)) then
        call raise(error, code_stopped, stopped_text(run))
      else
        call solve_part(run, part, attempt, solved, sliding, slip_torque, error)
        run%unsettled = run%unsettled .or. allocated(error)
        if (run%unsettled .and. stop_requested()) call interrupt(run, error)
      end if
      if (allocated(error)) exit
      attempt = attempt + 1
      if (solved) then
        if (.not. slip_torque > 0) cuts = 0
        if (run%easy) run%stride = min(1._dp, 2*run%stride)
        part = ahead(run%place, run%stride)
        if (slip_torque > 0) then
          part = cautious(run, slip_torque)
          if (target < part) part = target
          if (slip_torque <= abs(run%step%torque)*used_up) call let_go(run, part, slip_torque, error)
        end if
      else if (.not. out_of_time(run)) then
        cuts = cuts + 1
        run%tally%cuts = run%tally%cuts + 1
        if (sliding .and. slip_torque > 0 .and. .not. cautious(run, slip_torque) < part) then
          sliding = .false.  ! friction carried more than was asked: no gross slip
          slip_torque = 0
        end if
        if (sliding .and. .not. slip_torque > 0) then
          call not_held(run, part, error)
        else if (sliding) then
          part = cautious(run, slip_torque)
          if (cuts > run%scene%max_cuts) call let_go(run, part, slip_torque, error)
        else
          run%stride = 0.5_dp*(part%step - run%place%step + part%share - run%place%share)
          spent = cuts > run%scene%max_cuts .or. (run%stride < 0.5_dp**run%scene%max_cuts .and. .not. slip_torque > 0)
          if (spent .and. all_friction(run)) then
            call slipped(run, abs(run%step%torque), error)
          else if (spent .or. proportional(run)) then
            call not_converged(run, error)
          end if
          part = ahead(run%place, run%stride)
        end if
      end if
      if (allocated(error)) exit
    end do
    if (allocated(error)) return
    call hold_stop(.true.)  ! a solved step is booked whole, with its tangent
    call accept(run, error)
    call hold_stop(.false.)
    if (.not. allocated(error)) call check_slip(run, error)
  end subroutine solve_step

  !> Next comes the first step from rest of a problem whose solution is in proportion to the load: half of it is no easier, so it
  !> is not halved. The torque begins at rest where the assembly left all points touching
  !> without pressure, as two shapes that fit.
  pure logical function proportional(run)
    type(run_t), intent(in) :: run  !< run
    proportional = begins(run%scene, run%place)
    if (.not. run%place < assembled(run%scene)) proportional = proportional .and. all(run%state%contact /= open_state) .and. &
      .not. any(abs(run%state%traction) > 0)
    proportional = proportional .and. .not. run%scene%large() .and. run%scene%hard()
  end function proportional

  !> The contact slides: gross slip, or nothing holds where the torque itself pressed the faces and there is no friction worth the
  !> name.
  subroutine let_go(run, place, slip_torque, error)
    type(run_t), intent(inout) :: run                 !< run
    type(place_t), intent(in) :: place                !< where it was tried to go
    real(dp), intent(in) :: slip_torque               !< carried while they slid [N m]
    type(error_t), allocatable, intent(out) :: error  !< the message
    if (run%sums%friction_capacity < some_friction*slip_torque) then
      call not_held(run, place, error)
    else
      call slipped(run, slip_torque, error)
    end if
  end subroutine let_go

  !> Friction alone holds the torque, and is used up: under large displacements pairs then move on without end.
  pure logical function all_friction(run)
    type(run_t), intent(in) :: run  !< run
    all_friction = run%scene%support%friction_alone .and. run%scene%large() .and. &
      run%sums%friction_capacity > 0 .and. abs(run%step%torque) >= nearly*run%sums%friction_capacity
  end function all_friction

  !> A signal ends the run in order; what the present load step had reached is lost.
  subroutine interrupt(run, error)
    type(run_t), intent(inout) :: run                 !< run
    type(error_t), allocatable, intent(out) :: error  !< says so
    run%record%interrupted = .true.
    call raise(error, code_stopped, kept_text('interrupted', run%step%number))
  end subroutine interrupt

  !> What a time limit leaves; one that is too short for a load step would stop every resumed run too.
  function stopped_text(run) result(text)
    type(run_t), intent(in) :: run  !< run
    character(len=:), allocatable :: text
    text = 'stopped at a limit after '//to_text(run%step%number)//' load steps; their results are kept, --resume goes on'
    if (run%step%number == run%first_step) text = 'stopped at the time limit of '//to_text(run%scene%time_limit_s)// &
      ' s before a load step was done ('//to_text(run%step%number)//' before; setting up took '// &
      rounded(run%record%timers%seconds(in_setup))//' s): --resume gets on only with a longer solver.time_limit_s'
  end function stopped_text

  !> The wall-clock limit of the scene has passed.
  logical function out_of_time(run)
    type(run_t), intent(in) :: run  !< run
    out_of_time = wall_seconds() > deadline(run)
  end function out_of_time

  !> Clock at which that limit is reached [s].
  pure real(dp) function deadline(run)
    type(run_t), intent(in) :: run  !< run
    deadline = huge(deadline)
    if (run%scene%time_limit_s > 0) deadline = run%clock + run%scene%time_limit_s
  end function deadline

  !> Four fifths of the way to the torque at which the contact slips.
  pure type(place_t) function cautious(run, slip_torque) result(place)
    type(run_t), intent(in) :: run            !< run
    real(dp), intent(in) :: slip_torque       !< estimate of the slip torque [N m]
    real(dp), parameter :: four_fifths = 0.8_dp  !< the torque of slip is an estimate
    real(dp) :: now
    now = abs(run%step%torque)
    place = place_at(run%scene, now + four_fifths*max(0._dp, slip_torque - now))
  end function cautious

  !> Try to reach a place; the state changes only if that succeeds.
  subroutine solve_part(run, place, attempt, solved, sliding, slip_torque, error)
    type(run_t), intent(inout) :: run                 !< run
    type(place_t), intent(in) :: place                !< aim
    integer, intent(in) :: attempt                    !< attempts of this load step before
    logical, intent(out) :: solved                    !< reached
    logical, intent(out) :: sliding                   !< the contact slips as a whole
    real(dp), intent(inout) :: slip_torque            !< torque that friction carries then [N m]
    type(error_t), allocatable, intent(out) :: error  !< solver, files
    type(attempt_t) :: found
    type(load_t) :: load
    type(newton_options_t) :: options
    type(step_t) :: step
    integer :: taken, inner
    logical :: known
    solved = .false.
    sliding = .false.
    inner = run%model%solver%inner
    step = run%step
    step%number = run%step%number + 1
    call place_step(run%scene, place, step)
    run%model%drive%problem%wheel_turns = run%scene%support%turns_bottom .and. step%loaded
    call run%attempts%take(run%place, place, found, known)
    if (.not. known) call try_part(run, place, step, options, load, found, error)
    call run%record%timers%book(in_newton)
    if (allocated(error)) return
    solved = found%solved
    sliding = found%sliding
    run%far = found%far
    run%model%solver%inner = run%model%solver%inner + merge(found%inner, 0, known)
    taken = found%history(size(found%history))%iteration
    run%tally%iterations = run%tally%iterations + taken
    if (run%writes) call write_history(run%output, step, attempt, found%history, error)
    call run%record%timers%book(in_output)
    if (allocated(error)) return
    call note_iterations(run, found%history)
    run%step%iterations = run%step%iterations + taken
    run%easy = taken < few_iterations
    if (solved) then
      if (.not. known) call finish_part(run, place, step, options, load, found%state, error)
      if (allocated(error)) return
      if (place%share > 0) call keep_checkpoint(run, error)  ! the state of the last whole step is left
      if (allocated(error)) return
    end if
    found%inner = run%model%solver%inner - inner
    call run%attempts%add(found)
    if (solved) then
      call move_state(run%state, run%before)
      call move_state(found%state, run%state)
      run%place_before = run%place
      run%place = place
      run%tally%symmetry(merge(2, 1, step%loaded)) = found%symmetry
      call place_step(run%scene, place, run%step)
      if (allocated(run%gradient)) call run%gradient%follow(place, run%before, run%state)
    else if (sliding) then
      slip_torque = found%slip_torque
    end if
    if (.not. solved) call pair_bodies(run%model%drive%problem, run%state%u)
  end subroutine solve_part

  !> Iterate towards a place.
  subroutine try_part(run, place, step, options, load, found, error)
    type(run_t), intent(inout) :: run                 !< run
    type(place_t), intent(in) :: place                !< aim
    type(step_t), intent(in) :: step                  !< and what stands there
    type(newton_options_t), intent(out) :: options    !< of the iteration
    type(load_t), intent(out) :: load                 !< there
    type(attempt_t), intent(out) :: found             !< what it came to
    type(error_t), allocatable, intent(out) :: error  !< solver
    integer :: threads
    logical :: known
    found%from = run%place
    found%to = place
    options%tolerance = run%scene%tolerance
    options%max_iterations = run%scene%max_iterations
    options%runaway = farthest(run%scene, run%model%drive%radius)
    if (step%loaded) options%torque = largest_torque(run%scene)
    call drive_load(run%model%drive, assembly_at(run%scene, place), step%torque, step_friction(run%scene, step%loaded), load, &
      run%state)
    associate (trial => found%state, solved => found%solved, sliding => found%sliding)
      call first_guess(run, place, step, trial, known)
      if (run%scene%support%loop .and. step%loaded .and. .not. known) call turn_to_side(run, load, step%torque, trial%u)
      options%anew = step%loaded .and. .not. (known .or. stretch(run%scene, run%place_before, run%place, place) > 0)
      if (run%model%solver%own_threads) threads = blas_threads(1)
      if (run%scene%support%against_teeth .and. step%loaded) then
        call turn_against_teeth(run, step%torque, trial, found%history, error)
        solved = .true.
      else
        call iterate(run%model%drive%problem, run%model%solver, options, load, run%state, trial, found%history, solved, sliding, &
          error)
        found%far = .not. (solved .or. run%scene%support%friction_alone .or. proportional(run))
        if (found%far) found%far = maxval(abs(trial%u)) > options%runaway
        if (.not. (solved .or. sliding .or. found%far .or. allocated(error)) .and. bears_less_friction(run, load, step)) then
          call raise_friction(run%model%drive%problem, run%model%solver, options, load, deadline(run), run%state, trial, &
            found%history, solved, sliding, error)
        end if
        sliding = sliding .and. run%scene%support%friction_alone  ! elsewhere a part of the step is easier
        if (solved .and. run%scene%support%loop .and. step%loaded .and. .not. abs(step%torque) > 0) then
          call stay_at_flank(run, options, load, trial, found%history, error)
        end if
      end if
      if (run%model%solver%own_threads) threads = blas_threads(threads)
      if (allocated(error)) return
      found%symmetry = run%model%solver%symmetry_used
      if (known .and. solved .and. found%history(size(found%history))%iteration == 0) then
        call run%model%assembly%recall(assembly_at(run%scene, place), step%torque, trial, known)  ! with the states it was found in
      else if (sliding .and. .not. solved) then
        found%slip_torque = abs(contact_torque(run%model%drive, trial))  ! below the tolerance rounding: friction holds nothing
        if (.not. load%friction > 0 .or. found%slip_torque < run%scene%tolerance*abs(run%scene%torque)) found%slip_torque = 0
      end if
    end associate
  end subroutine try_part

  !> Without a torque the play of the teeth leaves the bottom free, and Newton's method anywhere in it. The bottom stays where the
  !> torque let go of it, at the flank that it came from.
  subroutine stay_at_flank(run, options, load, state, history, error)
    type(run_t), intent(inout) :: run                 !< run
    type(newton_options_t), intent(in) :: options     !< of the iteration
    type(load_t), intent(in) :: load                  !< no torque
    type(state_t), intent(inout) :: state             !< solution
    type(iteration_t), allocatable, intent(inout) :: history(:)  !< grows
    type(error_t), allocatable, intent(out) :: error  !< solver
    type(state_t) :: turned
    type(iteration_t), allocatable :: more(:)
    logical :: solved, sliding
    turned = state
    call turn_to_side(run, load, torque_at(run%scene, run%place), turned%u)
    if (.not. any(abs(turned%u - state%u) > 0)) return
    call iterate(run%model%drive%problem, run%model%solver, options, load, run%state, turned, more, solved, sliding, error)
    if (allocated(error)) return
    if (.not. solved .or. sliding) then  ! the solution stays, and its pairs
      call pair_bodies(run%model%drive%problem, state%u)
      return
    end if
    more%iteration = more%iteration + history(size(history))%iteration
    history = [history, more(2:)]
    call move_state(turned, state)
  end subroutine stay_at_flank

  !> Where no flank pushes, turn ring and cup, which balls do not hold, to the flank that a torque presses.
  subroutine turn_to_side(run, load, torque, u)
    type(run_t), intent(in) :: run           !< run of a whole drive
    type(load_t), intent(in) :: load         !< of the step
    real(dp), intent(in) :: torque           !< its sense counts; 0: none [N m]
    real(dp), intent(inout) :: u(:, :)       !< displacements (3, n) [m]
    real(dp), allocatable :: force(:), closing(:)
    real(dp) :: turn
    integer :: i
    if (.not. abs(torque) > 0) return
    associate (drive => run%model%drive)
      force = strut_forces(drive%problem, load, u)
      if (any(force(drive%balls + 1:drive%balls + drive%flanks) > no_force*run%loop%tooth_force_max)) return
      closing = strut_closings(drive%problem, load, u)
      turn = sign(turn_to_flank(run%scene, closing(drive%balls + merge(1, 2, torque > 0):drive%balls + drive%flanks:2)), torque)
      do i = 1, drive%problem%n
        u(2, i) = u(2, i) + turn*drive%reference(1, i)
      end do
    end associate
  end subroutine turn_to_side

  !> What follows where a place was reached: the assembled drive may turn once, teeth and rubbing struts begin from there.
  subroutine finish_part(run, place, step, options, load, trial, error)
    type(run_t), intent(inout) :: run                 !< run
    type(place_t), intent(in) :: place                !< reached
    type(step_t), intent(in) :: step                  !< what stands there
    type(newton_options_t), intent(in) :: options     !< of the iteration
    type(load_t), intent(in) :: load                  !< there
    type(state_t), intent(inout) :: trial             !< solution
    type(error_t), allocatable, intent(out) :: error  !< solver
    ! a guess is of the drive before it has turned
    if (run%keeps_all .or. .not. step%loaded) call run%model%assembly%add(assembly_at(run%scene, place), step%torque, trial)
    if (run%scene%support%struts .and. .not. (step%loaded .or. place < assembled(run%scene))) then
      if (run%scene%turned()) then
        call turn_once(run%model%drive, run%model%solver, options, load, trial, error)
        call run%record%timers%book(in_turn)
      end if
      if (allocated(error)) return
      call touch_teeth(run%scene, run%model%drive, trial%u, trial)
    else
      call remember(run%model%drive%problem, load, trial)
    end if
  end subroutine finish_part

  !> Displacement at which a body counts as sliding away [m].
  pure real(dp) function farthest(scene, radius)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), intent(in) :: radius      !< of the contact [m]
    real(dp), parameter :: much = 0.05_dp, many = 10  ! a twentieth of the radius is no torsion, ten times the lift no assembly
    farthest = much*radius + many*(abs(scene%w) + abs(scene%eccentricity) + abs(scene%interference))
  end function farthest

  !> First guess of a part: extrapolated from the last two, from a coarser mesh, or an assembly solved before.
  subroutine first_guess(run, place, step, trial, known)
    type(run_t), intent(inout) :: run          !< run
    type(place_t), intent(in) :: place         !< aim
    type(step_t), intent(in) :: step           !< and what stands there
    type(state_t), intent(out) :: trial        !< guess
    logical, intent(out) :: known              !< it is a solution
    real(dp) :: ratio, part
    integer :: i
    part = assembly_at(run%scene, place)
    ratio = stretch(run%scene, run%place_before, run%place, place)
    associate (now => run%state, before => run%before)
      trial = state_t(null(), now%traction, now%slip, now%gap, now%contact, now%touch, now%past)
      allocate (trial%u, mold=now%u)
      !$omp parallel do schedule(static) if(size(now%u) > many)
      do i = 1, size(now%u, 2)
        trial%u(:, i) = now%u(:, i) + ratio*(now%u(:, i) - before%u(:, i))
      end do
      !$omp end parallel do
      trial%traction = trial%traction + ratio*(now%traction - before%traction)
    end associate
    if (run%model%drive%problem%wheel_turns .and. .not. ratio > 0) trial%traction(2:, :) = (1 - below_bound)*trial%traction(2:, :)
    if (allocated(run%coarser) .and. .not. ratio > 0) call guess_from(run%coarser, run%model%drive, run%state, &
      [assembly_at(run%scene, run%place), part], [torque_at(run%scene, run%place), step%torque], trial)
    known = .false.
    if (.not. run%scene%support%struts .or. .not. step%loaded) call run%model%assembly%recall(part, step%torque, trial, known)
  end subroutine first_guess

  !> There is friction to take away, and something else than friction holds the torque.
  logical function bears_less_friction(run, load, step)
    type(run_t), intent(in) :: run        !< run
    type(load_t), intent(in) :: load      !< load of the step
    type(step_t), intent(in) :: step      !< its end
    bears_less_friction = load%friction > 0 .and. .not. (step%loaded .and. run%scene%support%friction_alone) .and. &
      .not. out_of_time(run)
  end function bears_less_friction

  !> A torque at the cup's bottom against the teeth of the circular spline.
  subroutine turn_against_teeth(run, torque, trial, history, error)
    type(run_t), intent(inout) :: run                          !< run
    real(dp), intent(in) :: torque                             !< [N m]
    type(state_t), intent(inout) :: trial                      !< solution
    type(iteration_t), allocatable, intent(out) :: history(:)  !< one entry per set of teeth
    type(error_t), allocatable, intent(out) :: error           !< linear solver
    integer :: i
    if (.not. allocated(run%teeth)) then
      allocate (run%teeth)
      call new_teeth(run%scene, run%model%drive, run%model%solver, run%state, run%teeth, error)
      if (allocated(error)) return
    end if
    call turn_hub(run%teeth, run%model%drive, torque, trial, error)
    history = [(iteration_t(iteration=i, stick=size(trial%contact)), i=0, run%teeth%iterations)]
  end subroutine turn_against_teeth

  !> What Newton's iterations tell, for the verbose log and for a message where they fail.
  subroutine note_iterations(run, history)
    type(run_t), intent(inout) :: run            !< gets period, least, loose_points
    type(iteration_t), intent(in) :: history(:)  !< iterates
    character(len=80) :: line
    integer :: i
    do i = 1, size(history)
      write (line, '(6x,I4,es12.3,4I7,f8.3)') history(i)%iteration, history(i)%residual, history(i)%changes, &
        history(i)%open, history(i)%stick, history(i)%slip, history(i)%damping
      call detail(trim(line))
    end do
    run%period = maxval(history%period)
    run%least = minval(history%residual, history%residual > 0)
    if (run%period > 0) run%tally%cycles = run%tally%cycles + 1
    associate (last => history(size(history)))
      run%loose_points = merge(last%slip, 0, last%stick == 0)
    end associate
  end subroutine note_iterations

  !> The contact slips as a whole: there is no equilibrium beyond this torque.
  subroutine slipped(run, slip_torque, error)
    type(run_t), intent(inout) :: run                 !< run
    real(dp), intent(in) :: slip_torque               !< torque that friction carries [N m]
    type(error_t), allocatable, intent(out) :: error  !< the message
    type(error_t), allocatable :: trouble
    call accept(run, trouble)
    run%record%slip_torque = slip_torque
    call raise(error, code_not_converged, 'gross slip at T = '//to_text(slip_torque)//' N m: friction carries mu int p r dA = '// &
      to_text(run%sums%friction_capacity)//' N m and the support holds no torque. The state at '//to_text(run%step%torque)// &
      ' N m is kept. Raise interference or friction, lower torque, or use support = ''hub''')
  end subroutine slipped

  !> The flexspline slides away though no friction was overcome.
  subroutine not_held(run, place, error)
    type(run_t), intent(in) :: run                    !< run
    type(place_t), intent(in) :: place                !< where it was tried to go
    type(error_t), allocatable, intent(out) :: error  !< the message
    call raise(error, code_not_converged, 'the flexspline is not held: beyond torque '//to_text(abs(run%step%torque))// &
      ' N m (tried '//to_text(torque_at(run%scene, place))//' N m) no contact point carries it and only the '// &
      "soft springs of the support are left. Raise interference, w or friction, or use support = 'hub'; the last "// &
      'converged state is kept')
  end subroutine not_held

  !> Slip that is no longer small puts the torque out of balance under large displacements: points press where they were paired.
  subroutine check_slip(run, error)
    type(run_t), intent(in) :: run                    !< run after a load step
    type(error_t), allocatable, intent(out) :: error  !< the message
    if (.not. allocated(run%model%drive%problem%lagrangian) .or. .not. run%step%loaded) return
    if (abs(run%sums%torque%balance) <= &
      unbalanced*abs(run%scene%torque) + of_pressure*run%sums%normal_force*run%model%drive%radius) return
    call raise(error, code_not_converged, "the slip is too large for kinematics = 'nonlinear': at T = "// &
      to_text(run%step%torque)//' N m '//to_text(run%sums%torque%balance)//' N m are out of balance (friction carries '// &
      'mu int p r dA = '//to_text(run%sums%friction_capacity)//' N m). Lower the torque or use solver.kinematics = '// &
      "'linear'")
  end subroutine check_slip

  !> Newton's method failed on ever smaller steps.
  subroutine not_converged(run, error)
    type(run_t), intent(in) :: run                    !< run
    type(error_t), allocatable, intent(out) :: error  !< the message
    character(len=:), allocatable :: cause, tries, advice
    advice = ''
    cause = 'no convergence'
    tries = to_text(run%scene%max_cuts)//' halvings'
    if (proportional(run)) tries = to_text(run%scene%max_iterations)//' iterations, with less friction too'
    if (run%period > 0) cause = 'the contact states run in a cycle of '//to_text(run%period)//' iterations'
    if (run%scene%support%struts .and. run%loose_points > 0 .and. allocated(run%model%drive%problem%loose)) advice = &
      '. Friction alone keeps the ring from turning, and all of its contact ('//to_text(run%loose_points)// &
      ' multipliers) slips. Lower wave_generator.clearance or raise contact.friction; or change '// &
      trim(merge('bearing.cage_angle_deg  ', 'wave_generator.cam      ', run%scene%balls > 0))// &
      ', wave_generator.eccentricity or mesh.divisions a little'
    if (run%far) then
      cause = 'bodies move by more than '//rounded(farthest(run%scene, run%model%drive%radius))//' m'
      advice = '. No drive turns that far: lower load.torque'
    end if
    if (run%least < rounding .and. run%least > run%scene%tolerance) then  ! else it was reached with less friction
      cause = 'the residual stands at '//rounded(run%least)//', which is rounding,'
      advice = '. Raise solver.tolerance above it'
    end if
    if (proportional(run) .and. len(advice) == 0) tries = tries//' (raise solver.max_iterations)'
    call raise(error, code_not_converged, cause//' in the '// &
      trim(merge('assembly', 'torque  ', run%place < assembled(run%scene)))//' step beyond load factor '// &
      to_text(run%step%load_factor)//' (torque '//to_text(run%step%torque)//' N m) after '// &
      tries//'; history.csv shows the residuals, the last converged state is kept'//advice)
  end subroutine not_converged
end module hd_load_step
