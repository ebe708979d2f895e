! SPDX-License-Identifier: GPL-3.0-or-later
!> A run: its scene, model and state; set up or restored, each converged load step measured and booked, closed with a summary.
module hd_run
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use hd_kinds, only: dp
  use hd_attempts, only: attempts_t
  use hd_checkpoint, only: mark_t, reference_t, save_checkpoint, load_checkpoint, drop_checkpoint
  use hd_clock, only: wall_seconds, timestamp
  use hd_coupled_tangent, only: answer_t, coupled_response, glued_response, contact_alone
  use hd_drive, only: drive_load, step_friction
  use hd_error, only: error_t, raise, code_input, code_stopped
  use hd_folder_lock, only: folder_lock_t
  use hd_gradient, only: gradient_t
  use hd_facets, only: facets_t, sums_t, evaluate_facets, sum_up, sum_stiffness
  use hd_joint, only: joint_t, at_friction
  use hd_joint_range, only: check_stiffness
  use hd_plausible, only: implausible
  use hd_model_comparison, only: compare_models
  use hd_load_path, only: place_t, operator(<), assembled, assembly_at, load_factor_at, path_end, torque_at, under_torque, at_peak
  use hd_last_words, only: judge_results
  use hd_log, only: say
  use hd_fatigue, only: write_fatigue
  use hd_loop, only: loop_t, first_sense, book, engaged, write_loop, bottom_turn
  use hd_model, only: model_t, fit_model, hand_on, give_back
  use hd_output, only: output_t, step_t, open_output, reopen_output, find_table_sizes, table_sums, write_step, write_facets, &
    write_teeth, write_grids, close_output
  use hd_lapack, only: blas_threads
  use hd_problem, only: state_t, load_t, new_state, pair_bodies, update_struts, update_tangent
  use hd_promises, only: promised_values, most_steps
  use hd_pressure_patches, only: patch_pressures
  use hd_scene, only: scene_t
  use hd_scene_joint, only: scene_joint, tabulate_joint
  use hd_stress, only: stress_matrices_t
  use hd_strength, only: book_stress
  use hd_summary, only: derivatives_t, record_t, write_summary
  use hd_teeth, only: teeth_t, add_tooth_forces
  use hd_system, only: stop_requested
  use hd_text, only: string_t, push, to_text
  use hd_theory_error, only: theory_on, move_tangent
  use hd_timers, only: in_checkpoint, in_fields, in_gradient, in_newton, in_output, in_setup, &
    in_stiffness, in_stress, outside
  use hd_twist_shares, only: twist_shares
  implicit none
  private
  public :: run_t, new_run, restore_run, differentiate_run, fit_run, accept, keep_checkpoint, kept_text, place_step, &
    close_run, leave_model

  real(dp), parameter :: at_largest = 1 - 1e-9_dp !< share of the largest torque from which a step has it
  real(dp), parameter :: rest = 100          !< from a checkpoint to the next, over what writing it took: 1 % of a run

  type, extends(mark_t) :: run_t
    type(scene_t) :: scene
    type(model_t), allocatable :: model     !< before `new_run`: of an earlier run, or of that a scene and its joint alone
    type(joint_t) :: joint
    type(state_t) :: before, state          !< last two converged states
    type(state_t) :: top                    !< that of the reference step of a loop
    type(model_t), allocatable :: coarser   !< of the same run on a coarser mesh, with all its states, for first guesses
    logical :: keeps_all = .false.          !< `model` gets the states under torque too
    type(attempts_t) :: attempts            !< kept for the next run of this scene, or taken over from the last one
    logical :: asks_tangent = .true.        !< steps from the end of the assembly on get a tangent K_TS
    logical :: unsettled = .false.          !< an iteration was left in the middle: mesh and factors are of no more use
    integer :: first_step = 0               !< load steps before this process took the run up
    integer :: period = 0                   !< of the cycle in which the contact states ran last, 0: none
    real(dp) :: least = huge(1._dp)         !< residual of the last attempt at a load step
    integer :: loose_points = 0             !< that touched last, where none of them stuck, else 0
    logical :: far = .false.                !< the last iterate that failed has bodies far away
    type(facets_t) :: facets                !< of the last converged step
    type(sums_t) :: sums                    !< of that step
    type(teeth_t), allocatable :: teeth     !< of the circular spline, with support 'teeth'
    type(loop_t) :: loop                    !< of the whole drive, with support 'drive'
    type(stress_matrices_t) :: matrices(2)  !< of its bodies
    type(gradient_t), allocatable :: gradient   !< for derivatives of the results, if they were asked for
    type(output_t) :: output
    type(folder_lock_t) :: lock             !< of its folder, where it is stepped from outside
    logical :: writes = .false.             !< has an output folder
    type(record_t) :: record
    type(error_t), allocatable :: failure   !< what ended the run early
    real(dp) :: clock = 0, step_clock = 0   !< when the run and the present load step began [s]
    type(mark_t) :: owed                    !< mark of the last load step, while it has no checkpoint
    logical :: owes = .false.               !< it has none
    real(dp) :: due = 0                     !< clock from which the next checkpoint is written [s]
  end type run_t

contains

  !> Set up a run. An empty folder name: nothing is written.
  subroutine new_run(scene, input, folder, force, run, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    character(len=*), intent(in) :: input             !< name of the input, for the record
    character(len=*), intent(in) :: folder            !< output folder or ''
    logical, intent(in) :: force                      !< replace earlier results
    type(run_t), intent(inout) :: run                 !< run at rest
    type(error_t), allocatable, intent(out) :: error  !< mesh, files, memory
    call prepare(scene, input, run, error)
    if (allocated(error)) return
    if (len(folder) > 0) then
      call open_output(folder, scene, force, run%output, error)
      if (allocated(error)) return
      call drop_checkpoint(folder)
      run%writes = .true.
    end if
    call build(run, error)
    if (allocated(error) .and. run%writes) call close_output(run%output, error)
    if (.not. allocated(error)) call say('step phase     load    T/(N m) iter         open stick  slip   force/N  peak/MPa')
  end subroutine new_run

  !> Take up a stopped run from its checkpoint.
  subroutine restore_run(scene, input, folder, run, error)
    type(scene_t), intent(in) :: scene                !< scene it began with; limits and output may differ
    character(len=*), intent(in) :: input             !< name of the input, for the record
    character(len=*), intent(in) :: folder            !< output folder with a checkpoint
    type(run_t), intent(inout) :: run                 !< run where it stopped
    type(error_t), allocatable, intent(out) :: error  !< mesh, files, memory
    call prepare(scene, input, run, error)
    if (.not. allocated(error)) call build(run, error)
    if (.not. allocated(error)) call load_checkpoint(folder, scene, run%mark_t, run%output, run%before, run%state, run%top, &
      run%loop, error)
    if (.not. allocated(error)) call reopen_output(folder, scene, run%table_sizes, run%table_sums, run%step%number, run%output, &
      error)
    if (allocated(error)) return
    run%writes = .true.
    run%record%resumed = .true.
    if (scene%with_gradient == '.true.') call push(run%record%warnings, 'no gradient: it is found along all load '// &
      'steps of a run that is not resumed. Use hdengine.load(folder).gradient()')
    run%first_step = run%step%number
    call pair_bodies(run%model%drive%problem, run%state%u)
    call measure(run, again=.true.)
    call enter_stiffness(run)
    call run%record%timers%book(in_setup)
    call say('resumed   after load step '//to_text(run%step%number)//', torque '//to_text(run%step%torque)//' N m')
  end subroutine restore_run

  !> Checks and record of a run, before any file is touched.
  subroutine prepare(scene, input, run, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    character(len=*), intent(in) :: input             !< name of the input
    type(run_t), intent(inout) :: run                 !< gets scene, record, joint
    type(error_t), allocatable, intent(out) :: error  !< no contact scene
    if (scene%surface_only) then
      call raise(error, code_input, 'the input holds only &surface and &fit: hdengine.x runs it, as does '// &
        'hdengine.run_surface in Python; a contact run needs another group')
      return
    end if
    run%clock = wall_seconds()
    call run%record%timers%begin(run%clock)
    run%scene = scene
    run%record%started = timestamp()
    run%record%input = input
    call implausible(scene, run%record%warnings)
    if (allocated(run%model)) then
      call scene_joint(scene, run%joint, error, run%model%scene, run%model%joint)
    else
      call scene_joint(scene, run%joint, error)
    end if
    if (.not. allocated(error) .and. scene%support%contact) call check_stiffness(run%joint, error)
  end subroutine prepare

  !> Mesh and factors of the scene, the run at rest.
  subroutine build(run, error)
    type(run_t), intent(inout) :: run                 !< prepared run
    type(error_t), allocatable, intent(out) :: error  !< mesh, memory
    integer :: threads
    threads = blas_threads(1)  ! it wakes its threads for the smallest matrix, and waits for them long where others compute
    call fit_run(run, error)
    threads = blas_threads(threads)
    if (allocated(error)) return
    run%record%kept = run%model%kept
    run%record%choice = run%model%choice
    call new_state(run%model%drive%problem, run%state)
    run%before = run%state
    call run%record%timers%book(in_setup)
    call say('mesh      '//to_text(3*run%model%drive%problem%n)//' dof, '//to_text(size(run%model%drive%face%nodes, 2))// &
      ' contact facets, '//to_text(run%model%solver%unknowns)//' unknowns')
    call say(trim('solver    '//trim(run%model%solver%name)//merge(', taken over from the last run', repeat(' ', 30), &
      run%record%kept)))
  end subroutine build

  !> Fit the model that the run has to its scene and joint, or make one.
  subroutine fit_run(run, error)
    type(run_t), intent(inout) :: run                 !< gets model
    type(error_t), allocatable, intent(out) :: error  !< mesh, memory
    call fit_model(run%scene, run%model, error)
    if (allocated(error)) return
    run%model%joint = run%joint
    associate (law => run%model%drive%problem%law)
      if (allocated(law%joint)) deallocate (law%joint)
      if (run%scene%hard()) return
      allocate (law%joint)
      call tabulate_joint(run%scene, run%joint, law%joint, error)
    end associate
  end subroutine fit_run

  !> Leave the model to the next run; after an iteration that was left in the middle mesh and factors are of no more use.
  subroutine leave_model(run, to)
    type(run_t), intent(inout) :: run                     !< run that is over
    type(model_t), allocatable, intent(inout) :: to       !< place of the next run's
    if (run%unsettled) call give_back(run%model)
    call hand_on(run%model, to)
  end subroutine leave_model

  !> Phase, load factor and torque of a place.
  pure subroutine place_step(scene, place, step)
    type(scene_t), intent(in) :: scene    !< scene
    type(place_t), intent(in) :: place    !< place
    type(step_t), intent(inout) :: step   !< step
    step%loaded = under_torque(scene, place)
    step%load_factor = load_factor_at(scene, place)
    step%torque = torque_at(scene, place)
  end subroutine place_step

  !> Book a finished load step.
  subroutine accept(run, error)
    type(run_t), intent(inout) :: run                 !< run
    type(error_t), allocatable, intent(out) :: error  !< files
    character(len=100) :: line
    real(dp) :: stress
    logical :: known
    call run%record%timers%book(in_newton)
    run%step%number = run%step%number + 1
    run%step%seconds = wall_seconds() - run%step_clock
    call measure(run, again=.false.)
    if (.not. run%step%loaded) then
      run%rotation_assembled = run%rotation_assembled + run%sums%rotation  ! which counts from there
      run%sums%rotation = 0
    end if
    call run%record%timers%book(in_fields)
    run%flexibility%known = run%flexibility%known .and. wants_tangent(run)
    if (wants_tangent(run)) then
      call run%attempts%take_tangent(run%step%number, run%flexibility, run%certain, known)
      if (.not. known) call find_flexibility(run, error)
      if (allocated(error)) return
      call run%attempts%add_tangent(run%step%number, run%flexibility, run%certain)
    end if
    call enter_stiffness(run)
    call run%record%timers%book(in_stiffness)
    associate (c => run%state%contact)
      write (line, '(I4,1x,a8,f7.3,f10.4,I4,8x,3I6,f10.2,f10.3)') run%step%number, &
        merge('torque  ', 'assembly', run%step%loaded), run%step%load_factor, &
        run%step%torque, run%step%iterations, count(c == 0), count(c == 1), count(c == 2), run%sums%normal_force, &
        run%sums%pressure_max*1e-6_dp
    end associate
    call say(trim(line))
    if (run%scene%support%loop) call note_reference(run)
    stress = max(run%strength%flexspline, run%strength%ring)
    if (run%writes) call write_tables(run, error)
    call run%record%timers%book(in_output)
    if (.not. allocated(run%gradient) .or. allocated(error)) return
    call run%gradient%book(run%step%loaded, .not. run%scene%support%loop .or. &
      (run%reference%known .and. run%reference%step%number == run%step%number), &
      max(run%strength%flexspline, run%strength%ring) > stress, run%loop%fatigue)
    call run%record%timers%book(in_gradient)
  end subroutine accept

  !> Enter a booked load step in all tables, with its stresses, and its state in a checkpoint when one is due.
  subroutine write_tables(run, error)
    type(run_t), intent(inout) :: run                 !< run
    type(error_t), allocatable, intent(out) :: error  !< files
    call write_step(run%output, run%step, run%sums, error)
    if (run%scene%contact_table == 'all' .and. .not. allocated(error)) call write_facets(run%output, run%step, &
      run%model%drive, run%facets, error)
    if (allocated(run%teeth) .and. .not. allocated(error)) call write_teeth(run%output, run%step, run%teeth, error)
    call run%record%timers%book(in_output)
    if (.not. allocated(error)) call book_stress(run%strength, run%loop%fatigue, run%matrices, run%scene, &
      run%model%drive, run%state, run%step%torque, error)
    call run%record%timers%book(in_stress)
    if (run%scene%support%loop .and. .not. allocated(error)) call write_loop(run%output, run%step, run%scene, &
      run%model%drive, run%loop, run%sums%k_ts, run%sums%shares, error)
    if (.not. allocated(error) .and. (run%scene%vtu == 'all' .or. (run%scene%vtu == 'last' .and. &
      .not. (run%place < path_end(run%scene) .or. run%reference%known)))) then
      call write_grids(run%output, run%step, run%model%drive, run%facets, run%state, error)
    end if
    if (.not. (allocated(error) .or. allocated(run%teeth))) then
      call find_table_sizes(run%output, run%table_sizes, error)
      run%table_sums = table_sums(run%output)
      run%owed = run%mark_t
      run%owes = .not. allocated(error)
      call run%record%timers%book(in_output)
      if (run%owes .and. (wall_seconds() >= run%due .or. .not. run%place < path_end(run%scene))) call keep_checkpoint(run, error)
    end if
  end subroutine write_tables

  !> Derivatives of the results of a run that is over.
  subroutine find_gradient(run, stopped)
    type(run_t), intent(inout) :: run  !< its record gets them
    type(error_t), allocatable, intent(out) :: stopped  !< by a signal
    type(error_t), allocatable :: error
    character(len=:), allocatable :: lost
    if (.not. allocated(run%gradient) .or. allocated(run%failure)) return
    call differentiate_run(run, run%record%gradient, lost, error)
    if (allocated(error) .and. stop_requested()) then
      run%record%interrupted = .true.
      call raise(stopped, code_stopped, 'interrupted before the gradient was found: all else is whole, and '// &
        'hdengine.load(folder).gradient() finds it')
      run%failure = stopped
    else if (allocated(error)) then
      call push(run%record%warnings, 'no gradient: '//error%message//'. Compare runs with the key changed')
    else if (len(lost) > 0) then
      call push(run%record%warnings, 'no gradient: not of '//lost//', which would not be in proportion to all forces and '// &
        'stiffnesses: lost at a change of state. Take more load steps or another mesh, or compare runs with the key changed')
    end if
    call run%record%timers%book(in_gradient)
  end subroutine find_gradient

  !> Derivatives of its results, or of the readings of its loop alone.
  subroutine differentiate_run(run, found, lost, error, only)
    type(run_t), intent(inout) :: run                 !< run that is over, with a gradient
    type(derivatives_t), intent(out) :: found         !< as of its gradient
    character(len=:), allocatable, intent(out) :: lost  !< likewise
    type(error_t), allocatable, intent(out) :: error  !< likewise
    type(string_t), intent(in), optional :: only(:)   !< likewise
    integer :: threads, newtons
    threads = 0
    newtons = run%model%solver%inner   ! its inner steps are counted for Newton's method alone
    if (run%model%solver%own_threads) threads = blas_threads(1)
    call run%gradient%differentiate(run%model%solver, run%scene, run%joint, run%model%drive, run%sums%k_tangent, found, lost, &
      error, only)
    if (run%model%solver%own_threads) threads = blas_threads(threads)
    run%model%solver%inner = newtons
  end subroutine differentiate_run

  !> Write the checkpoint of the last whole load step, if it has none: seldom enough to cost little, before its state is left, and
  !> where the run ends.
  subroutine keep_checkpoint(run, error)
    type(run_t), intent(inout) :: run                 !< in the state of that step
    type(error_t), allocatable, intent(out) :: error  !< disk full
    real(dp) :: begun
    if (.not. run%owes .or. run%owed%place < run%place) return  ! a step that could not be booked is no place to go on from
    begun = wall_seconds()
    call save_checkpoint(run%output, run%scene, run%owed, run%before, run%state, run%top, run%loop, error)
    run%owes = .false.
    run%due = wall_seconds() + rest*(wall_seconds() - begun)
    call run%record%timers%book(in_checkpoint)
  end subroutine keep_checkpoint

  !> The last load step gets a tangent K_TS: none before the assembly's end, else by choice those that a result needs. In a loop
  !> that is the step its results are of; elsewhere secant and K_TS over the torque need all of them.
  pure logical function wants_tangent(run) result(wants)
    type(run_t), intent(in) :: run  !< run
    wants = run%asks_tangent .and. .not. run%place < assembled(run%scene)
    select case (run%scene%tangent_steps)
    case ('none')
      wants = .false.
    case ('last', 'needed')
      if (run%scene%support%loop) then
        wants = wants .and. at_peak(run%scene, run%place)
      else if (run%scene%tangent_steps == 'last') then
        wants = wants .and. .not. run%place < path_end(run%scene)
      end if
    end select
  end function wants_tangent

  !> Facets, forces and rotation of the present state.
  subroutine measure(run, again)
    type(run_t), intent(inout) :: run  !< gets facets and sums
    logical, intent(in) :: again       !< its step is booked already
    type(load_t) :: load
    call drive_load(run%model%drive, assembly_at(run%scene, run%place), &
      merge(0._dp, run%step%torque, run%scene%support%against_teeth), &
      step_friction(run%scene, run%step%loaded), load, run%state, run%before)
    if (allocated(run%teeth)) call add_tooth_forces(run%teeth, load%force)
    call evaluate_facets(run%model%drive, at_friction(run%joint, load%friction), run%state, run%facets)
    call sum_up(run%model%drive, load, run%state, run%facets, run%sums)
    run%sums%theory = theory_on(run%joint, run%model%drive, run%state)
    run%sums%rotation = run%sums%rotation - run%rotation_assembled
    if (allocated(run%teeth)) run%sums%rotation = run%teeth%rotation
    if (run%scene%support%loop) then
      if (.not. again) call book(run%loop, run%scene, run%model%drive, load, run%state, run%step)
      run%sums%rotation = bottom_turn(run%model%drive, run%state)
      run%sums%torque%wave_generator = run%loop%wave_generator_torque
    end if
    call sum_stiffness(run%scene, run%model%drive, run%step%torque, run%state, run%facets, run%sums)
  end subroutine measure

  !> Flexibility of the drive with its joint for a further torque, from the end of the assembly on. None where the faces are bonded
  !> or the joint gives no stiffness per area (Eq. 28 as printed).
  subroutine find_flexibility(run, error)
    type(run_t), intent(inout) :: run                 !< gets flexibility
    type(error_t), allocatable, intent(out) :: error  !< linear solver
    type(load_t) :: load
    type(answer_t) :: now, bonded
    real(dp) :: sense, friction
    integer :: threads
    if (run%joint%paper .or. .not. run%scene%support%contact .or. run%scene%bonded()) return
    sense = sign(1._dp, run%scene%torque)
    call drive_load(run%model%drive, 1._dp, run%step%torque, step_friction(run%scene, run%step%loaded), load, run%state, run%before)
    call update_tangent(run%model%drive%problem, run%state%u)
    if (run%scene%support%struts) then  ! balls and teeth that push change from step to step, and with them the glued drive
      run%flexibility%known = .false.
      if (.not. (run%step%loaded .and. engaged(run%loop, run%model%drive))) return
      sense = sign(1._dp, run%step%torque)
      load%displacement(2, run%model%drive%hub) = run%state%u(2, run%model%drive%hub)
      call update_struts(run%model%drive%problem, load, run%state%u)
    end if
    threads = 0
    if (run%model%solver%own_threads) threads = blas_threads(1)
    bonded%settled = .true.
    if (.not. run%flexibility%known) then
      call glued_response(run%model%drive, run%model%solver, load, sense, run%state, bonded, error)
      run%flexibility%glued = bonded%flexibility
    end if
    friction = step_friction(run%scene, .true.)
    if (friction <= run%scene%tolerance) friction = 0  ! less than forces are solved to
    if (.not. allocated(error)) call coupled_response(run%model%drive, run%model%solver, at_friction(run%joint, friction), load, &
      sense, run%state, now, error)
    if (run%model%solver%own_threads) threads = blas_threads(threads)
    if (allocated(error)) return
    run%certain = now%settled .and. bonded%settled
    run%flexibility%contact = contact_alone(run%model%drive, now)
    if (run%scene%support%loop) run%flexibility%shares = twist_shares(run%model%drive, now, bonded)
    associate (f => run%flexibility)
      if (f%known) f%turned = f%turned + 0.5_dp*(f%coupled + now%flexibility)*(run%step%torque - f%torque)
      f%known = .true.
      f%coupled = now%flexibility
      f%torque = run%step%torque
    end associate
  end subroutine find_flexibility

  !> Tangent and secant of what the contact adds to the drive with glued faces. With the joint as contact law the secant is
  !> that of the run's own rotation; with hard contact that of the tangents between its load steps.
  subroutine enter_stiffness(run)
    type(run_t), intent(inout) :: run  !< sums get k_tangent, k_secant
    real(dp) :: turn
    integer :: station
    run%sums%k_tangent = ieee_value(1._dp, ieee_quiet_nan)
    run%sums%k_secant = run%sums%k_tangent
    run%sums%k_contact = run%sums%k_tangent
    run%sums%shares = run%sums%k_tangent
    associate (f => run%flexibility)
      if (.not. f%known) return
      if (f%contact > 0) run%sums%k_contact = f%contact  ! else no point of it takes torque
      if (run%scene%support%loop) run%sums%shares = f%shares
      if (f%coupled > f%glued) run%sums%k_tangent = 1/(f%coupled - f%glued)
      if (run%scene%support%loop) return  ! a loop has no secant
      station = run%place%step - run%scene%assembly_steps + nint(run%place%share)
      if (run%scene%torque_steps <= most_steps) f%tangent(station) = run%sums%k_tangent
      run%sums%k_secant = run%sums%k_tangent
      if (.not. abs(f%torque) > 0) return
      turn = merge(f%turned, run%sums%rotation, run%scene%hard())/f%torque
      if (turn > f%glued) run%sums%k_secant = 1/(turn - f%glued)
      if (run%scene%tangent_steps == 'last' .and. run%scene%hard()) run%sums%k_secant = ieee_value(1._dp, ieee_quiet_nan)
    end associate
  end subroutine enter_stiffness

  !> Keep a step of a loop whose torque is the largest so far, in the sense of its first rise; of equals the last.
  subroutine note_reference(run)
    type(run_t), intent(inout) :: run  !< after a load step
    real(dp) :: sense
    if (.not. run%step%loaded) return
    sense = first_sense(run%loop%torque)
    if (.not. sense*run%step%torque > 0) return
    if (run%reference%known .and. sense*run%step%torque < at_largest*sense*run%reference%step%torque) return
    run%reference = reference_t(.true., run%step, run%sums, run%certain)
    run%top = run%state
  end subroutine note_reference

  !> The results of a loop are those of its reference step: state, sums and facets of the run become those.
  subroutine take_reference(run)
    type(run_t), intent(inout) :: run  !< run at its end
    type(error_t), allocatable :: error
    if (.not. run%reference%known) return
    run%state = run%top
    run%sums = run%reference%sums
    run%certain = run%reference%certain
    run%step = run%reference%step
    call evaluate_facets(run%model%drive, at_friction(run%joint, step_friction(run%scene, .true.)), run%state, run%facets)
    if (run%sums%k_tangent == run%sums%k_tangent .or. run%unsettled .or. run%scene%tangent_steps /= 'needed') return
    run%before = run%top  ! it ended before its torque came to a peak
    call pair_bodies(run%model%drive%problem, run%state%u)
    call find_flexibility(run, error)
    if (.not. allocated(error)) call enter_stiffness(run)
  end subroutine take_reference

  !> Close the run: warnings, last grids of a run that ended early, summary.
  subroutine close_run(run, error, interrupted)
    type(run_t), intent(inout) :: run                 !< run
    type(error_t), allocatable, intent(out) :: error  !< files
    logical, intent(in), optional :: interrupted      !< by a signal, between two load steps
    type(error_t), allocatable :: trouble, stopped
    call run%record%timers%book(outside)
    if (present(interrupted)) run%record%interrupted = run%record%interrupted .or. interrupted
    if (run%step%number > 0) run%record%limit = run%record%shift + run%record%to_limit*promised_values(run%scene, run%sums, &
      run%flexibility%tangent, patch_pressures(run%model%drive, run%facets), run%loop)
    if (run%writes .and. .not. allocated(run%failure)) call move_tangent(run%scene, run%model%drive, run%model%solver, run%joint, &
      run%flexibility, run%before, run%state, run%sums%theory, trouble)
    if (allocated(trouble) .and. stop_requested()) then
      run%record%interrupted = .true.
      call raise(run%failure, code_stopped, 'interrupted before the change of K_TS by the error of its joint was found; all '// &
        'load steps are kept, --resume finds it')
    end if
    call run%record%timers%book(in_stiffness)
    run%record%steps = run%step%number
    if (.not. allocated(run%failure) .and. run%place < path_end(run%scene)) call raise(run%failure, &
      code_stopped, kept_text(trim(merge('interrupted', 'closed     ', run%record%interrupted)), run%step%number))
    if (allocated(run%failure)) call keep_checkpoint(run, error)
    call take_reference(run)
    call run%record%timers%book(in_fields)
    call find_gradient(run, stopped)
    call judge_results(run%scene, run%joint, run%mark_t, run%facets, run%sums, run%loop, run%record)
    call run%record%timers%book(in_fields)
    if (run%writes) then
      if ((run%scene%vtu == 'last' .and. run%reference%known) .or. (allocated(run%failure) .and. run%scene%vtu /= 'none' .and. &
        run%step%number > 0)) then
        if (.not. allocated(error)) call write_grids(run%output, run%step, run%model%drive, run%facets, run%state, error)
      end if
      if (run%scene%contact_table == 'last' .and. run%step%number > 0 .and. .not. allocated(error)) call write_facets(run%output, &
        run%step, run%model%drive, run%facets, error)
      call close_output(run%output, trouble)
      if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
      call run%record%timers%book(in_output)
      if (run%step%number > 0) run%record%k_ts_by_model = compare_models(run%scene, run%model%drive, run%state, &
        run%step%torque, run%sums)
      call run%record%timers%book(in_fields)
      if (.not. allocated(error)) call write_fatigue(run%output%folder, run%model%drive%problem%bodies(run%model%drive%b_cup), &
        run%loop%fatigue, error)
      call run%record%timers%book(in_output)
      if (allocated(error) .and. .not. allocated(run%failure)) run%failure = error
      call write_summary(run%output%folder, run%scene, run%model%drive, run%joint, run%model%solver, &
        run%step, run%sums, run%strength, run%tally, run%record, run%loop, run%failure, trouble)
      if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
      if (.not. (allocated(error) .or. allocated(run%failure))) call drop_checkpoint(run%output%folder)
      run%writes = .false.
    end if
    if (allocated(stopped) .and. .not. allocated(error)) call move_alloc(stopped, error)
    call run%lock%give()
  end subroutine close_run

  !> What a run that was ended early leaves.
  pure function kept_text(why, steps) result(text)
    character(len=*), intent(in) :: why  !< 'interrupted', 'closed'
    integer, intent(in) :: steps         !< done
    character(len=:), allocatable :: text
    text = why//' after '//to_text(steps)//' load steps; '//trim(merge('their results are kept, --resume goes on', &
      '--resume begins with the first one      ', steps > 0))
  end function kept_text
end module hd_run
