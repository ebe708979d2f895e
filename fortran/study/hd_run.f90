! SPDX-License-Identifier: GPL-3.0-or-later
!> A run: its scene, model and state; set up or restored, each converged load step measured and booked, closed with a summary.
module hd_run
  use hd_kinds, only: dp
  use hd_checkpoint, only: mark_t, save_checkpoint, load_checkpoint, drop_checkpoint
  use hd_clock, only: wall_seconds, timestamp
  use hd_coarser, only: coarser_t
  use hd_drive, only: drive_t, drive_load
  use hd_error, only: error_t, raise, code_input, code_stopped
  use hd_facets, only: facets_t, sums_t, scene_joint, evaluate_facets, sum_up
  use hd_interface, only: scene_interface
  use hd_joint, only: joint_t
  use hd_joint_range, only: range_warnings
  use hd_linear_solver, only: linear_solver_t
  use hd_log, only: say
  use hd_kept, only: assembly_t, take_model, keep_model
  use hd_output, only: output_t, step_t, open_output, reopen_output, table_sizes, write_step, write_teeth, write_grids, &
    close_output
  use hd_problem, only: state_t, load_t, new_state, pair_bodies
  use hd_scene, only: scene_t
  use hd_summary, only: record_t, write_summary
  use hd_teeth, only: teeth_t, add_tooth_forces
  use hd_text, only: string_t, push, to_text
  implicit none
  private
  public :: run_t, new_run, restore_run, accept, place, final_position, finish, quantities

  type :: run_t
    type(scene_t) :: scene
    type(drive_t), allocatable :: drive
    type(joint_t) :: joint
    class(linear_solver_t), allocatable :: solver
    type(state_t) :: before, state          !< last two converged states
    real(dp) :: position = 0, position_before = 0   !< 0 to 1: assembly, 1 to 2: torque
    type(assembly_t) :: assembly            !< states of the assembly, also of an earlier run
    type(coarser_t), allocatable :: coarser !< the same run on a coarser mesh, for first guesses
    logical :: keeps_all = .false.          !< `assembly` gets the states under torque too
    logical :: easy = .true.                !< the last part took few iterations
    integer :: period = 0                   !< of the cycle in which the contact states ran last, 0: none
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
    call prepare(scene, input, run, error)
    if (allocated(error)) return
    if (len(folder) > 0) then
      call open_output(folder, scene, force, run%output, error)
      if (allocated(error)) return
      call drop_checkpoint(folder)
      run%writes = .true.
    end if
    call build(run, error)
    if (.not. allocated(error)) call say('step phase     load  torque/Nm its   residual   open stick slip   normal/N  pmax/MPa')
  end subroutine new_run

  !> Take up a stopped run from its checkpoint.
  subroutine restore_run(scene, input, folder, run, error)
    type(scene_t), intent(in) :: scene                !< scene it began with; limits and output may differ
    character(len=*), intent(in) :: input             !< name of the input, for the record
    character(len=*), intent(in) :: folder            !< output folder with a checkpoint
    type(run_t), intent(inout) :: run                 !< run where it stopped
    type(error_t), allocatable, intent(out) :: error  !< mesh, files, memory
    type(mark_t) :: mark
    call prepare(scene, input, run, error)
    if (.not. allocated(error)) call build(run, error)
    if (.not. allocated(error)) call load_checkpoint(folder, mark, run%before, run%state, error)
    if (.not. allocated(error)) call reopen_output(folder, scene, mark%sizes, mark%steps, run%output, error)
    if (allocated(error)) return
    run%writes = .true.
    run%position = mark%position
    run%position_before = mark%position_before
    run%stride = mark%stride
    run%easy = mark%easy
    run%rotation_assembled = mark%rotation_assembled
    run%record%resumed = .true.
    run%record%steps = mark%steps
    run%record%iterations = mark%iterations
    run%record%cuts = mark%cuts
    run%record%cycles = mark%cycles
    run%record%symmetry = mark%symmetry
    run%step%number = mark%steps
    call place(run, run%position, run%step)
    call pair_bodies(run%drive%problem, run%state%u)
    call measure(run)
    call say('resumed   after load step '//to_text(mark%steps)//', torque '//to_text(run%step%torque)//' N m')
  end subroutine restore_run

  !> Checks and record of a run, before any file is touched.
  subroutine prepare(scene, input, run, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    character(len=*), intent(in) :: input             !< name of the input
    type(run_t), intent(inout) :: run                 !< gets scene, record, joint
    type(error_t), allocatable, intent(out) :: error  !< no contact scene
    if (scene%map_only) then
      call raise(error, code_input, 'the input holds only &surface and &fit: hdengine.x runs it, as does '// &
        'hdengine.run_surface in Python; a contact run needs another group')
      return
    end if
    run%clock = wall_seconds()
    run%scene = scene
    run%keeps_all = scene%promise > 0
    run%record%started = timestamp()
    run%record%input = input
    allocate (run%record%warnings(0))
    call scene_joint(scene, run%joint, error)
  end subroutine prepare

  !> Mesh and factors of the scene, the run at rest.
  subroutine build(run, error)
    type(run_t), intent(inout) :: run                 !< prepared run
    type(error_t), allocatable, intent(out) :: error  !< mesh, memory
    call take_model(run%scene, run%drive, run%solver, run%assembly, run%record%kept, error)
    if (.not. allocated(error)) then
      if (allocated(run%drive%problem%law%joint)) deallocate (run%drive%problem%law%joint)
      if (run%scene%contact_law /= 'hard') then
        allocate (run%drive%problem%law%joint)
        call scene_interface(run%scene, run%joint, run%drive%problem%law%joint, error)
      end if
    end if
    if (allocated(error)) return
    call new_state(run%drive%problem, run%state)
    run%before = run%state
    run%record%timers%setup = wall_seconds() - run%clock
    call say('mesh      '//to_text(3*run%drive%problem%n)//' dof, '//to_text(size(run%drive%face%nodes, 2))// &
      ' contact facets, '//to_text(run%solver%unknowns)//' unknowns')
    call say('solver    '//trim(run%solver%name)//merge(', kept', '      ', run%record%kept))
  end subroutine build

  !> Position at the end of the run.
  pure real(dp) function final_position(run) result(p)
    type(run_t), intent(in) :: run  !< run
    p = merge(2._dp, 1._dp, run%scene%torque_steps > 0)
  end function final_position

  !> Phase, load factor and torque of a position.
  pure subroutine place(run, position, step)
    type(run_t), intent(in) :: run        !< run
    real(dp), intent(in) :: position      !< 0 to 2
    type(step_t), intent(inout) :: step   !< step
    step%phase = merge('torque  ', 'assembly', position > 1)
    step%load_factor = merge(position - 1, position, position > 1)
    step%torque = max(0._dp, position - 1)*run%scene%torque
  end subroutine place

  !> Book a finished load step.
  subroutine accept(run, error)
    type(run_t), intent(inout) :: run                 !< run
    type(error_t), allocatable, intent(out) :: error  !< files
    character(len=100) :: line
    real(dp) :: start
    start = wall_seconds()
    run%record%steps = run%record%steps + 1
    run%step%number = run%record%steps
    run%step%seconds = start - run%step%seconds
    call measure(run)
    if (run%position <= 1 + 1e-12_dp) then
      run%rotation_assembled = run%sums%rotation
      run%sums%rotation = 0
    end if
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
      if (.not. allocated(error) .and. .not. allocated(run%teeth)) call save(run, error)
    end if
    run%record%timers%output = run%record%timers%output + wall_seconds() - start
  end subroutine accept

  !> Facets, forces and rotation of the present state.
  subroutine measure(run)
    type(run_t), intent(inout) :: run  !< gets facets and sums
    type(load_t) :: load
    call drive_load(run%drive, min(run%position, 1._dp), merge(0._dp, run%step%torque, run%scene%support == 'teeth'), load)
    if (allocated(run%teeth)) call add_tooth_forces(run%teeth, load%force)
    call evaluate_facets(run%drive, run%joint, run%state, run%facets)
    call sum_up(run%drive, load, run%state, run%facets, run%sums)
    run%sums%rotation = run%sums%rotation - run%rotation_assembled
    if (allocated(run%teeth)) run%sums%rotation = run%teeth%rotation
  end subroutine measure

  !> Write the checkpoint of the present state.
  subroutine save(run, error)
    type(run_t), intent(in) :: run                    !< run after a load step
    type(error_t), allocatable, intent(out) :: error  !< disk full
    type(mark_t) :: mark
    mark%position = run%position
    mark%position_before = run%position_before
    mark%stride = run%stride
    mark%easy = run%easy
    mark%rotation_assembled = run%rotation_assembled
    mark%steps = run%record%steps
    mark%iterations = run%record%iterations
    mark%cuts = run%record%cuts
    mark%cycles = run%record%cycles
    mark%symmetry = run%record%symmetry
    mark%sizes = table_sizes(run%output)
    call save_checkpoint(run%output%folder, mark, run%before, run%state, error)
  end subroutine save

  !> Close the run: warnings, last grids of a run that ended early, summary.
  subroutine finish(run, error)
    type(run_t), intent(inout) :: run                 !< run
    type(error_t), allocatable, intent(out) :: error  !< files
    call judge_joint(run)
    if (run%record%steps > 0) run%record%limit = run%record%to_limit*quantities(run)
    if (.not. allocated(run%failure) .and. run%position < final_position(run) - 1e-12_dp) call raise(run%failure, &
      code_stopped, 'closed after '//to_text(run%record%steps)//' load steps; their results are kept, --resume goes on')
    run%record%timers%total = wall_seconds() - run%clock
    if (run%writes) then
      if (allocated(run%failure) .and. run%scene%vtu /= 'none' .and. run%record%steps > 0) &
        call write_grids(run%output, run%step, run%drive, run%facets, run%state, error)
      call close_output(run%output)
      if (.not. allocated(error)) call write_summary(run%output%folder, run%scene, run%drive, run%joint, run%solver, &
        run%sums, run%record, run%failure, error)
      if (.not. (allocated(error) .or. allocated(run%failure))) call drop_checkpoint(run%output%folder)
      run%writes = .false.
    end if
    call keep_model(run%scene, run%drive, run%solver, run%assembly)
  end subroutine finish

  !> K_TS (Eq. 45), normal force and mid-band pressure of the last step.
  pure function quantities(run) result(q)
    type(run_t), intent(in) :: run  !< finished run
    real(dp) :: q(3)
    real(dp), allocatable :: lever(:)
    associate (f => run%facets)
      allocate (lever, source=f%x(1, :)*f%normal(2, :) - f%x(2, :)*f%normal(1, :))
      q = [sum(f%k_n*lever**2 + f%k_t*(f%x(1, :)**2 + f%x(2, :)**2 - lever**2)), run%sums%normal_force, &
        run%sums%pressure_middle]
    end associate
  end function quantities

  !> Warn where the joint model leaves its range.
  subroutine judge_joint(run)
    type(run_t), intent(inout) :: run  !< run
    type(string_t), allocatable :: lines(:)
    integer :: i
    if (run%record%steps == 0 .or. run%scene%support == 'teeth') return  ! bonded there: no joint
    call range_warnings(run%joint, maxval(run%facets%corner(1, :, :)), lines)
    do i = 1, size(lines)
      call push(run%record%warnings, lines(i)%s)
      call say('warning: '//lines(i)%s)
    end do
  end subroutine judge_joint
end module hd_run
