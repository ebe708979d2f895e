! SPDX-License-Identifier: GPL-3.0-or-later
!> A run: load steps from rest through the assembly to the full torque, with cut-backs, slip detection and all output.
module hd_run
  use hd_kinds, only: dp
  use hd_clock, only: wall_seconds, timestamp
  use hd_drive, only: drive_t, drive_load
  use hd_error, only: error_t, raise, code_input, code_not_converged, code_stopped, code_memory
  use hd_facets, only: facets_t, sums_t, scene_joint, evaluate_facets, sum_up
  use hd_interface, only: scene_interface
  use hd_joint, only: joint_t
  use hd_joint_range, only: range_warnings
  use hd_linear_solver, only: linear_solver_t
  use hd_log, only: say, detail
  use hd_newton, only: newton_options_t, iteration_t, iterate
  use hd_kept, only: assembly_t, take_model, keep_model
  use hd_output, only: output_t, step_t, open_output, write_step, write_teeth, write_history, write_grids, close_output
  use hd_problem, only: state_t, load_t, new_state
  use hd_scene, only: scene_t
  use hd_summary, only: record_t, write_summary
  use hd_system, only: stop_requested
  use hd_teeth, only: teeth_t, new_teeth, turn_hub, add_tooth_forces
  use hd_text, only: string_t, push, to_text
  use hd_contact_law, only: slip_state
  implicit none
  private
  public :: run_t, new_run, advance, finish, run_scene

  integer, parameter :: few_iterations = 10  !< after so few the next part of a load step may be twice as long

  type :: run_t
    type(scene_t) :: scene
    type(drive_t), allocatable :: drive
    type(joint_t) :: joint
    class(linear_solver_t), allocatable :: solver
    type(state_t) :: before, state          !< last two converged states
    real(dp) :: position = 0, position_before = 0   !< 0 to 1: assembly, 1 to 2: torque
    type(assembly_t) :: assembly            !< states of the assembly, also of an earlier run
    logical :: easy = .true.                !< the last part took few iterations
    real(dp) :: stride = 2                  !< longest part of a load step that is tried
    type(step_t) :: step                    !< last converged step
    type(facets_t) :: facets                !< its facets
    type(sums_t) :: sums                    !< its sums
    type(teeth_t), allocatable :: teeth     !< of the circular spline, with support 'teeth'
    type(output_t) :: output
    logical :: writes = .false.             !< has an output folder
    type(record_t) :: record
    type(error_t), allocatable :: failure   !< what ended the run early
    real(dp) :: rotation_assembled = 0      !< rotation at the end of the assembly [rad]
    real(dp) :: clock = 0
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
    if (scene%map_only) then
      call raise(error, code_input, 'the input holds only &surface: hdengine.x generates it, as does '// &
        'hdengine.surface.generate in Python; a contact run needs another group')
      return
    end if
    run%clock = wall_seconds()
    run%scene = scene
    run%record%started = timestamp()
    run%record%input = input
    allocate (run%record%warnings(0))
    call scene_joint(scene, run%joint, error)
    if (allocated(error)) return
    if (len(folder) > 0) then
      call open_output(folder, scene, force, run%output, error)
      if (allocated(error)) return
      run%writes = .true.
    end if
    call take_model(scene, run%drive, run%solver, run%assembly, run%record%kept, error)
    if (.not. allocated(error)) then
      if (allocated(run%drive%problem%law%joint)) deallocate (run%drive%problem%law%joint)
      if (scene%contact_law == 'joint') then
        allocate (run%drive%problem%law%joint)
        call scene_interface(scene, run%joint, run%drive%problem%law%joint, error)
      end if
    end if
    if (allocated(error)) return
    call new_state(run%drive%problem, run%state)
    run%before = run%state
    run%record%timers%setup = wall_seconds() - run%clock
    call say('mesh      '//to_text(3*run%drive%problem%n)//' dof, '//to_text(size(run%drive%face%nodes, 2))// &
      ' contact facets, '//to_text(run%solver%unknowns)//' unknowns')
    call say('solver    '//trim(run%solver%name)//merge(', kept', '      ', run%record%kept))
    call say('step phase     load  torque/Nm its   residual   open stick slip   normal/N  pmax/MPa')
  end subroutine new_run

  !> Solve the next load step, in parts where it must be cut.
  subroutine advance(run, done, error)
    type(run_t), intent(inout) :: run                 !< run
    logical, intent(out) :: done                      !< the last step is solved
    type(error_t), allocatable, intent(out) :: error  !< not converged, gross slip, stopped, solver
    real(dp) :: target, part, slip_torque
    integer :: cuts, attempt
    logical :: solved, sliding
    target = next_position(run)
    if (abs(run%position - 1) < 1e-12_dp) run%stride = 2
    part = min(target, run%position + run%stride)
    cuts = 0
    attempt = 0
    slip_torque = 0
    run%step%iterations = 0
    run%step%seconds = wall_seconds()
    do while (run%position < target - 1e-12_dp)
      if (stop_requested() .or. out_of_time(run)) then
        call raise(error, code_stopped, 'stopped at a limit after '//to_text(run%record%steps)// &
          ' load steps; their results are kept')
      else
        call solve_part(run, part, attempt, solved, sliding, slip_torque, error)
      end if
      if (allocated(error)) exit
      attempt = attempt + 1
      if (solved) then
        cuts = 0
        if (run%easy) run%stride = 2*run%stride
        part = min(target, run%position + run%stride)
        if (slip_torque > 0) then
          part = min(target, cautious(run, slip_torque))
          if (slip_torque <= abs(run%step%torque)*1.003_dp) call slipped(run, slip_torque, error)
        end if
      else
        cuts = cuts + 1
        run%record%cuts = run%record%cuts + 1
        if (sliding .and. .not. slip_torque > 0) then
          call not_held(run, part, error)
        else if (sliding) then
          part = cautious(run, slip_torque)
          if (cuts > run%scene%max_cuts) call slipped(run, slip_torque, error)
        else
          run%stride = 0.5_dp*(part - run%position)
          part = run%position + run%stride
          if (cuts > run%scene%max_cuts) call not_converged(run, error)
        end if
      end if
      if (allocated(error)) exit
    end do
    if (.not. allocated(error)) call accept(run, error)
    done = run%position >= final_position(run) - 1e-12_dp
    if (allocated(error)) run%failure = error
  end subroutine advance

  !> The wall-clock limit of the scene has passed.
  logical function out_of_time(run)
    type(run_t), intent(in) :: run  !< run
    real(dp) :: elapsed
    elapsed = wall_seconds() - run%clock
    out_of_time = run%scene%time_limit_s > 0 .and. elapsed > run%scene%time_limit_s
  end function out_of_time

  !> Position of the next load step: assembly ends at 1, torque at 2.
  pure real(dp) function next_position(run) result(p)
    type(run_t), intent(in) :: run  !< run
    integer :: n
    if (run%position < 1 - 1e-12_dp) then
      n = run%scene%assembly_steps
      p = real(floor(run%position*n + 1e-9_dp) + 1, dp)/n
    else
      n = run%scene%torque_steps
      p = 1 + real(floor((run%position - 1)*n + 1e-9_dp) + 1, dp)/n
    end if
  end function next_position

  !> Position at the end of the run.
  pure real(dp) function final_position(run) result(p)
    type(run_t), intent(in) :: run  !< run
    p = merge(2._dp, 1._dp, run%scene%torque_steps > 0)
  end function final_position

  !> Position four fifths of the way to the torque at which the contact slips.
  pure real(dp) function cautious(run, slip_torque) result(p)
    type(run_t), intent(in) :: run            !< run
    real(dp), intent(in) :: slip_torque       !< estimate of the slip torque [N m]
    real(dp) :: now
    now = max(0._dp, run%position - 1)*abs(run%scene%torque)
    p = 1 + (now + 0.8_dp*max(0._dp, slip_torque - now))/abs(run%scene%torque)
  end function cautious

  !> Try to reach a position; the state changes only if that succeeds.
  subroutine solve_part(run, position, attempt, solved, sliding, slip_torque, error)
    type(run_t), intent(inout) :: run                 !< run
    real(dp), intent(in) :: position                  !< aim
    integer, intent(in) :: attempt                    !< attempts of this load step before
    logical, intent(out) :: solved                    !< reached
    logical, intent(out) :: sliding                   !< the contact slips as a whole
    real(dp), intent(inout) :: slip_torque            !< torque that friction carries then [N m]
    type(error_t), allocatable, intent(out) :: error  !< solver, files
    type(state_t) :: trial
    type(load_t) :: load
    type(sums_t) :: sums
    type(newton_options_t) :: options
    type(iteration_t), allocatable :: history(:)
    type(step_t) :: step
    real(dp) :: ratio, start
    options%tolerance = run%scene%tolerance
    options%max_iterations = run%scene%max_iterations
    options%runaway = 0.05_dp*run%drive%radius
    call drive_load(run%drive, min(position, 1._dp), max(0._dp, position - 1)*run%scene%torque, load)
    trial = run%state
    ratio = 0
    if (run%position > run%position_before) ratio = (position - run%position)/(run%position - run%position_before)
    if (run%position_before < 1 .and. position > 1) ratio = 0
    trial%u = trial%u + ratio*(run%state%u - run%before%u)
    trial%traction = trial%traction + ratio*(run%state%traction - run%before%traction)
    start = wall_seconds()
    call run%assembly%recall(position, trial)
    if (run%scene%support == 'teeth' .and. position > 1) then
      call turn_against_teeth(run, max(0._dp, position - 1)*run%scene%torque, trial, history, error)
      solved = .true.
      sliding = .false.
    else
      call iterate(run%drive%problem, run%solver, options, load, run%state, trial, history, solved, sliding, error)
    end if
    run%record%timers%newton = run%record%timers%newton + wall_seconds() - start
    if (allocated(error)) return
    run%record%iterations = run%record%iterations + size(history) - 1
    step = run%step
    step%number = run%record%steps + 1
    call place(run, position, step)
    if (run%writes) call write_history(run%output, step, attempt, history, error)
    if (allocated(error)) return
    call log_iterations(history)
    run%step%iterations = run%step%iterations + size(history) - 1
    run%easy = size(history) <= few_iterations
    if (solved) then
      run%before = run%state
      run%state = trial
      run%position_before = run%position
      run%position = position
      if (position < 1 + 1e-12_dp) call run%assembly%add(position, trial)
      run%record%symmetry(merge(2, 1, position > 1 + 1e-12_dp)) = run%solver%symmetry_used
      call place(run, position, run%step)
    else if (sliding) then
      sums%friction_torque = sum(run%drive%problem%mortar%area*trial%traction(2, :))*run%drive%radius
      slip_torque = abs(sums%friction_torque)
    end if
  end subroutine solve_part

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
      call new_teeth(run%scene, run%drive, run%solver, run%state, run%teeth, error)
      if (allocated(error)) return
    end if
    call turn_hub(run%teeth, run%drive, torque, trial, error)
    history = [(iteration_t(iteration=i, stick=size(trial%contact)), i=0, run%teeth%iterations)]
  end subroutine turn_against_teeth

  !> Phase, load factor and torque of a position.
  pure subroutine place(run, position, step)
    type(run_t), intent(in) :: run        !< run
    real(dp), intent(in) :: position      !< 0 to 2
    type(step_t), intent(inout) :: step   !< step
    step%phase = merge('torque  ', 'assembly', position > 1)
    step%load_factor = merge(position - 1, position, position > 1)
    step%torque = max(0._dp, position - 1)*run%scene%torque
  end subroutine place

  !> Newton iterations in the verbose log.
  subroutine log_iterations(history)
    type(iteration_t), intent(in) :: history(:)  !< iterates
    character(len=80) :: line
    integer :: i
    do i = 1, size(history)
      write (line, '(6x,i4,es12.3,4i7,f8.3)') history(i)%iteration, history(i)%residual, history(i)%changes, &
        history(i)%open, history(i)%stick, history(i)%slip, history(i)%damping
      call detail(trim(line))
    end do
  end subroutine log_iterations

  !> Book a finished load step.
  subroutine accept(run, error)
    type(run_t), intent(inout) :: run                 !< run
    type(error_t), allocatable, intent(out) :: error  !< files
    type(load_t) :: load
    character(len=100) :: line
    real(dp) :: start
    start = wall_seconds()
    run%record%steps = run%record%steps + 1
    run%step%number = run%record%steps
    run%step%seconds = start - run%step%seconds
    call drive_load(run%drive, min(run%position, 1._dp), merge(0._dp, run%step%torque, run%scene%support == 'teeth'), load)
    if (allocated(run%teeth)) call add_tooth_forces(run%teeth, load%force)
    call evaluate_facets(run%drive, run%joint, run%state, run%facets)
    call sum_up(run%drive, load, run%state, run%facets, run%sums)
    if (run%position <= 1 + 1e-12_dp) run%rotation_assembled = run%sums%rotation
    run%sums%rotation = run%sums%rotation - run%rotation_assembled
    if (allocated(run%teeth)) run%sums%rotation = run%teeth%rotation
    associate (c => run%state%contact)
      write (line, '(i4,1x,a8,f7.3,f10.4,i4,9x,3i6,f11.2,f10.3)') run%step%number, run%step%phase, run%step%load_factor, &
        run%step%torque, run%step%iterations, count(c == 0), count(c == 1), count(c == 2), run%sums%normal_force, &
        run%sums%pressure_max*1e-6_dp
    end associate
    call say(trim(line))
    if (run%writes) then
      call write_step(run%output, run%step, run%drive, run%facets, run%sums, error)
      if (allocated(run%teeth) .and. .not. allocated(error)) call write_teeth(run%output, run%step, run%teeth, error)
      if (.not. allocated(error) .and. (run%scene%vtu == 'all' .or. (run%scene%vtu == 'last' .and. &
        run%position >= final_position(run) - 1e-12_dp))) &
        call write_grids(run%output, run%step, run%drive, run%facets, run%state, error)
    end if
    run%record%timers%output = run%record%timers%output + wall_seconds() - start
  end subroutine accept

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
  subroutine not_held(run, position, error)
    type(run_t), intent(in) :: run                    !< run
    real(dp), intent(in) :: position                  !< where it was tried to go
    type(error_t), allocatable, intent(out) :: error  !< the message
    call raise(error, code_not_converged, 'the flexspline is not held: beyond torque '//to_text(abs(run%step%torque))// &
      ' N m (tried '//to_text(max(0._dp, position - 1)*run%scene%torque)//' N m) no contact point carries it and only the '// &
      "soft springs of the support are left. Raise interference, w or friction, or use support = 'hub'; the last "// &
      'converged state is kept')
  end subroutine not_held

  !> Newton's method failed on ever smaller steps.
  subroutine not_converged(run, error)
    type(run_t), intent(in) :: run                    !< run
    type(error_t), allocatable, intent(out) :: error  !< the message
    call raise(error, code_not_converged, 'no convergence in the '//trim(run%step%phase)//' step beyond load factor '// &
      to_text(run%step%load_factor)//' (torque '//to_text(run%step%torque)//' N m) after '// &
      to_text(run%scene%max_cuts)//' halvings; history.csv shows the residuals, the last converged state is kept')
  end subroutine not_converged

  !> Close the run: warnings, last grids of a run that ended early, summary.
  subroutine finish(run, error)
    type(run_t), intent(inout) :: run                 !< run
    type(error_t), allocatable, intent(out) :: error  !< files
    call judge_joint(run)
    run%record%timers%total = wall_seconds() - run%clock
    if (run%writes) then
      if (allocated(run%failure) .and. run%scene%vtu /= 'none' .and. run%record%steps > 0) &
        call write_grids(run%output, run%step, run%drive, run%facets, run%state, error)
      call close_output(run%output)
      if (.not. allocated(error)) call write_summary(run%output%folder, run%scene, run%drive, run%joint, run%solver, &
        run%sums, run%record, run%failure, error)
      run%writes = .false.
    end if
    call keep_model(run%scene, run%drive, run%solver, run%assembly)
  end subroutine finish

  !> Warn where the joint model leaves its range.
  subroutine judge_joint(run)
    type(run_t), intent(inout) :: run  !< run
    type(string_t), allocatable :: lines(:)
    integer :: i
    if (run%record%steps == 0) return
    call range_warnings(run%joint, maxval(run%facets%traction(1, :)), lines)
    do i = 1, size(lines)
      call push(run%record%warnings, lines(i)%s)
      call say('warning: '//lines(i)%s)
    end do
  end subroutine judge_joint

  !> A whole run, for the command line.
  subroutine run_scene(scene, input, folder, force, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder
    logical, intent(in) :: force                      !< replace earlier results
    type(error_t), allocatable, intent(out) :: error  !< whatever ended the run early
    type(error_t), allocatable :: trouble
    type(run_t), allocatable :: run
    logical :: done
    allocate (run)
    call new_run(scene, input, folder, force, run, error)
    if (allocated(error)) return
    done = .false.
    do while (.not. done .and. .not. allocated(error))
      call advance(run, done, error)
    end do
    call finish(run, trouble)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
    call say('done      '//to_text(run%record%iterations)//' Newton iterations, '//to_text(run%record%timers%total)// &
      ' s, results in '//folder)
  end subroutine run_scene
end module hd_run
