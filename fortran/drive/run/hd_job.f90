! SPDX-License-Identifier: GPL-3.0-or-later
!> A whole run, from rest or from the checkpoint of one that was stopped.
module hd_job
  use hd_checkpoint, only: check_same_scene, has_checkpoint
  use hd_error, only: error_t, raise, code_input
  use hd_log, only: say
  use hd_run, only: run_t, new_run, restore_run, close_run
  use hd_scene, only: scene_t
  use hd_system, only: path_kind, path_absent
  use hd_text, only: rounded, to_text
  use hd_turning, only: advance
  implicit none
  private
  public :: run_scene, resume_run, is_complete

contains

  !> Solve a scene to its end and write its summary.
  subroutine run_scene(scene, input, folder, force, resume, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder
    logical, intent(in) :: force                      !< replace earlier results
    logical, intent(in) :: resume                     !< go on with a stopped run of this scene
    type(error_t), allocatable, intent(out) :: error  !< whatever ended the run early
    type(error_t), allocatable :: trouble
    type(run_t), allocatable :: run
    logical :: done
    if (resume .and. is_complete(folder)) then
      call check_same_scene(folder, 'echo.nml', scene, error)
      if (.not. allocated(error)) call say("the run in '"//folder//"' is complete: nothing to do")
      return
    end if
    allocate (run)
    if (resume) then
      call resume_run(scene, input, folder, run, error)
    else
      call new_run(scene, input, folder, force, run, error)
    end if
    if (allocated(error)) return
    done = .false.
    do while (.not. done .and. .not. allocated(error))
      call advance(run, done, error)
    end do
    call close_run(run, trouble)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
    call say('done      '//to_text(run%record%iterations)//' Newton iterations, '//rounded(run%record%timers%total)// &
      ' s, results in '//folder)
  end subroutine run_scene

  !> Take up a stopped run; a folder without a converged step is begun anew.
  subroutine resume_run(scene, input, folder, run, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder
    type(run_t), intent(inout) :: run                 !< stands where it stopped
    type(error_t), allocatable, intent(out) :: error  !< complete already, another scene, files
    if (path_kind(folder//'/echo.nml') == path_absent) then
      call new_run(scene, input, folder, .false., run, error)
      if (.not. allocated(error)) call say("resumed   nothing in '"//folder//"' yet: begins with the first load step")
      return
    end if
    call check_same_scene(folder, 'echo.nml', scene, error)
    if (allocated(error)) return
    if (is_complete(folder)) then
      call raise(error, code_input, "the run in '"//folder//"' is complete: nothing to resume")
    else if (has_checkpoint(folder)) then
      call restore_run(scene, input, folder, run, error)
    else
      call new_run(scene, input, folder, .true., run, error)
    end if
  end subroutine resume_run

  !> The summary of a folder says that its run is complete.
  logical function is_complete(folder)
    character(len=*), intent(in) :: folder  !< of a run
    character(len=200) :: line
    integer :: unit, status
    is_complete = .false.
    open (newunit=unit, file=folder//'/summary.json', action='read', status='old', iostat=status)
    if (status /= 0) return
    do while (status == 0 .and. .not. is_complete)
      read (unit, '(a)', iostat=status) line
      if (status == 0) is_complete = index(line, '"status": "complete"') > 0
    end do
    close (unit)
  end function is_complete
end module hd_job
