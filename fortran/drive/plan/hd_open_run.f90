! SPDX-License-Identifier: GPL-3.0-or-later
!> The one door to a run, for the command line and for Python: planned if the scene states a tolerance, resumed, or new.
module hd_open_run
  use hd_cost, only: check_memory
  use hd_error, only: error_t, raise, code_input
  use hd_folder_lock, only: folder_lock_t
  use hd_job, only: resume_run, run_scene
  use hd_joint_choice, only: choose_joint
  use hd_mesh_series, only: coarse, least_tolerance, meshed
  use hd_planner, only: new_planned_run, run_planned
  use hd_run, only: run_t, new_run
  use hd_scene, only: scene_t
  use hd_text, only: to_text
  implicit none
  private
  public :: check_run, open_run, run_to_end

  character(len=1), parameter :: nl = new_line('a')

contains

  !> Refuse what no mesh can promise, and a mesh that does not fit into memory, before either is tried. A plan chooses its own mesh.
  subroutine check_run(scene, error)
    type(scene_t), intent(in) :: scene                !< checked scene with a contact
    type(error_t), allocatable, intent(out) :: error  !< tolerance, memory
    if (scene%planned_tolerance > 0 .and. scene%planned_tolerance < least_tolerance) then
      call raise(error, code_input, 'error: run.tolerance = '//to_text(scene%planned_tolerance)//nl// &
        '      valid: 0, or '//to_text(least_tolerance)//' and more: what the finest mesh of a plan can promise')
    else if (scene%planned_tolerance > 0) then
      call check_memory(meshed(scene, coarse), .true., error)
    else
      call check_memory(scene, .false., error)
    end if
  end subroutine check_run

  !> Open a run that is solved step by step.
  subroutine open_run(scene, input, folder, force, resume, run, error)
    type(scene_t), intent(inout) :: scene             !< checked scene
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder; empty: nothing is written
    logical, intent(in) :: force                      !< replace earlier results
    logical, intent(in) :: resume                     !< go on with a stopped run of this scene
    type(run_t), intent(inout) :: run                 !< opened
    type(error_t), allocatable, intent(out) :: error  !< memory, files, another scene
    call check_run(scene, error)
    if (.not. allocated(error)) call run%lock%take(folder, error)
    if (allocated(error)) return
    call choose_joint(scene, error)
    if (allocated(error)) then
      call run%lock%give()
      return
    end if
    if (scene%planned_tolerance > 0) then
      call new_planned_run(scene, input, folder, force, resume, run, error)
    else if (resume) then
      call resume_run(scene, input, folder, run, error)
    else
      call new_run(scene, input, folder, force, run, error)
    end if
    if (allocated(error)) call run%lock%give()
  end subroutine open_run

  !> Solve a scene to its end.
  subroutine run_to_end(scene, input, folder, force, resume, error)
    type(scene_t), intent(inout) :: scene             !< checked scene
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder
    logical, intent(in) :: force                      !< replace earlier results
    logical, intent(in) :: resume                     !< go on with a stopped run of this scene
    type(error_t), allocatable, intent(out) :: error  !< whatever ended the run early
    type(folder_lock_t) :: lock
    call check_run(scene, error)
    if (.not. allocated(error)) call lock%take(folder, error)
    if (allocated(error)) return
    call choose_joint(scene, error)
    if (.not. allocated(error)) then
      if (scene%planned_tolerance > 0) then
        call run_planned(scene, input, folder, force, resume, error)
      else
        call run_scene(scene, input, folder, force, resume, error)
      end if
    end if
    call lock%give()
  end subroutine run_to_end
end module hd_open_run
