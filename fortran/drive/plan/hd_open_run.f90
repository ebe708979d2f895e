! SPDX-License-Identifier: GPL-3.0-or-later
!> The one door to a run, for the command line and for Python: planned if the scene states a tolerance, resumed, or new.
module hd_open_run
  use hd_checkpoint, only: check_same_scene, has_checkpoint
  use hd_cost, only: check_memory
  use hd_error, only: error_t, raise, code_input
  use hd_input_file, only: read_text
  use hd_joint_choice, only: choose_joint
  use hd_load_path, only: place_t, operator(<), path_end
  use hd_log, only: say
  use hd_march, only: march
  use hd_mesh_series, only: coarse, least_tolerance, meshed
  use hd_model, only: give_back
  use hd_output, only: result_files
  use hd_planner, only: plan_t, make_plan, enter_plan
  use hd_promises, only: promise_t, promises_of, promise_text, is_field
  use hd_results_folder, only: check_input, check_folder
  use hd_run, only: run_t, new_run, restore_run, close_run
  use hd_scene, only: scene_t
  use hd_summary, only: record_t
  use hd_system, only: path_kind, path_absent
  use hd_text, only: percent, rounded, to_text
  use hd_timers, only: in_band
  use hd_tolerance_runs, only: find_band
  implicit none
  private
  public :: check_run, open_run, advance_run, run_to_end

  character(len=1), parameter :: nl = new_line('a')

contains

  !> Refuse what no mesh can promise, and a mesh that does not fit into memory, before either is tried. A plan chooses its own mesh.
  subroutine check_run(scene, error)
    type(scene_t), intent(in) :: scene                !< checked scene with a contact
    type(error_t), allocatable, intent(out) :: error  !< tolerance, memory
    call check_wanted(scene, error)
    if (allocated(error)) return
    if (scene%planned_tolerance > 0 .and. scene%planned_tolerance < least_tolerance) then
      call raise(error, code_input, 'error: run.tolerance = '//to_text(scene%planned_tolerance)//nl// &
        '      valid: 0, or '//to_text(least_tolerance)//' and more: what the finest mesh of a plan can promise')
    else if (scene%planned_tolerance > 0) then
      call check_memory(meshed(scene, coarse(scene)), .true., error)
    else
      call check_memory(scene, .false., error)
    end if
  end subroutine check_run

  !> Words of run.wanted must name promises of the scene.
  subroutine check_wanted(scene, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    type(error_t), allocatable, intent(out) :: error  !< a word that is none
    type(promise_t), allocatable :: promised(:)
    character(len=:), allocatable :: valid, word
    integer :: i, at, last
    if (len_trim(scene%wanted) == 0) return
    promised = promises_of(scene)
    valid = ''
    do i = 1, size(promised)
      if (promised(i)%last > 0) valid = valid//' '//trim(promised(i)%name)
    end do
    at = 1
    do while (at <= len_trim(scene%wanted))
      last = at + index(scene%wanted(at:)//' ', ' ') - 2
      word = scene%wanted(at:last)
      at = last + 2
      if (len(word) == 0 .or. index(valid//' ', ' '//word//' ') > 0) cycle
      call raise(error, code_input, "error: run.wanted names '"//word//"', which this scene does not promise"//nl// &
        '      valid: some of'//valid//', parted by blanks')
      return
    end do
  end subroutine check_wanted

  !> Open a run.
  subroutine open_run(scene, input, folder, force, resume, run, complete, error)
    type(scene_t), intent(inout) :: scene             !< checked scene; gets its joint.model
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder; empty: nothing is written
    logical, intent(in) :: force                      !< replace earlier results
    logical, intent(in) :: resume                     !< go on with a stopped run of this scene
    type(run_t), intent(inout) :: run                 !< opened; its model may be that of an earlier run
    logical, intent(out) :: complete                  !< there is nothing to resume: the run is not opened
    type(error_t), allocatable, intent(out) :: error  !< memory, files, another scene
    type(scene_t) :: chosen
    type(plan_t) :: plan
    logical :: planned, begun
    complete = .false.
    call check_run(scene, error)
    if (.not. allocated(error)) call check_input(input, result_files, error)
    if (.not. allocated(error)) call run%lock%take(folder, error)
    if (allocated(error)) return
    if (len(folder) > 0 .and. .not. resume) call check_folder(folder, result_files, force, error)  ! before the long work
    if (.not. allocated(error)) call choose_joint(scene, error)
    planned = scene%planned_tolerance > 0
    begun = resume .and. path_kind(folder//'/echo.nml') /= path_absent
    if (begun) complete = is_complete(folder)
    if (planned .and. .not. allocated(error)) call make_plan(scene, folder, resume, complete, run%model, plan, error)
    chosen = scene
    if (planned .and. .not. complete) chosen = plan%scene
    if (begun .and. .not. ((planned .and. complete) .or. allocated(error))) call check_same_scene(folder, 'echo.nml', chosen, error)
    if (.not. (complete .or. allocated(error))) then
      if (begun .and. has_checkpoint(folder)) then
        call restore_run(chosen, input, folder, run, error)
      else
        call new_run(chosen, input, folder, force .or. begun, run, error)
        if (chosen%with_gradient == '.true.' .and. run%writes) allocate (run%gradient)  ! it stands in the summary alone
      end if
      if (.not. allocated(error)) then
        if (resume .and. .not. run%record%resumed) call say("resumed   no checkpoint in '"//folder//"': begins with the first "// &
          'load step')
        if (planned) call enter_plan(plan, run)
      end if
    end if
    complete = complete .and. .not. allocated(error)
    if (complete .or. allocated(error)) call run%lock%give()
  end subroutine open_run

  !> The summary of a folder says that its run is complete.
  logical function is_complete(folder)
    character(len=*), intent(in) :: folder  !< of a run
    character(len=:), allocatable :: text
    type(error_t), allocatable :: error
    call read_text(folder//'/summary.json', text, error)
    is_complete = index(text, '"status": "complete"') > 0
  end function is_complete

  !> Solve load steps up to a place; at the end of the last one the band is found: for a summary, else if it was asked for.
  subroutine advance_run(run, to, error)
    type(run_t), intent(inout) :: run                 !< run
    type(place_t), intent(in) :: to                   !< end of a load step
    type(error_t), allocatable, intent(out) :: error  !< whatever ended the run early
    call march(run, to, error)
    if (allocated(error) .or. allocated(run%record%band%input)) return
    if (.not. (run%scene%wants_band() .and. (run%writes .or. run%scene%with_band == '.true.'))) return
    if (.not. run%place < path_end(run%scene)) call find_band(run, error)
    call run%record%timers%book(in_band)
  end subroutine advance_run

  !> Open a run, march to its end, close it.
  subroutine run_to_end(scene, input, folder, force, resume, error)
    type(scene_t), intent(inout) :: scene             !< checked scene
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder
    logical, intent(in) :: force                      !< replace earlier results
    logical, intent(in) :: resume                     !< go on with a stopped run of this scene
    type(error_t), allocatable, intent(out) :: error  !< whatever ended the run early
    type(error_t), allocatable :: trouble
    type(run_t), allocatable :: run
    logical :: complete
    allocate (run)
    call open_run(scene, input, folder, force, resume, run, complete, error)
    if (complete) call say("the run in '"//folder//"' is complete: nothing to do")
    if (complete .or. allocated(error)) return
    call advance_run(run, path_end(run%scene), error)
    call close_run(run, trouble)
    call give_back(run%model)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
    call say(merge('ended     ', 'done      ', allocated(error))//to_text(run%tally%iterations)//' Newton iterations, '// &
      rounded(sum(run%record%timers%seconds))//' s, results in '//folder)
    if (run%record%level > 0 .and. .not. allocated(error)) call say_limits(promises_of(scene), run%record)
  end subroutine run_to_end

  !> The limits that a plan promised.
  subroutine say_limits(promised, record)
    type(promise_t), intent(in) :: promised(:)  !< what is promised
    type(record_t), intent(in) :: record        !< limits and their errors
    character(len=:), allocatable :: text
    integer :: i
    do i = 1, size(promised)
      text = promise_text(promised(i), record%limit)
      if (len(text) > 0) call say(trim('limit     '//text//', known to '//percent(record%estimate(i))// &
        merge(' in the norm', '            ', is_field(promised(i)%first))))
    end do
  end subroutine say_limits
end module hd_open_run
