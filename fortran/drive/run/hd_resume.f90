! SPDX-License-Identifier: GPL-3.0-or-later
!> A stopped run is taken up where its folder says that it stands.
module hd_resume
  use hd_checkpoint, only: check_same_scene, has_checkpoint
  use hd_error, only: error_t
  use hd_log, only: say
  use hd_run, only: run_t, new_run, restore_run
  use hd_scene, only: scene_t
  use hd_system, only: path_kind, path_absent
  implicit none
  private
  public :: resume_run, is_complete

contains

  !> Take up a stopped run; a folder without a converged step is begun anew.
  subroutine resume_run(scene, input, folder, run, complete, error)
    type(scene_t), intent(in) :: scene                !< checked scene
    character(len=*), intent(in) :: input             !< name of the input
    character(len=*), intent(in) :: folder            !< output folder
    type(run_t), intent(inout) :: run                 !< stands where it stopped, unless complete
    logical, intent(out) :: complete                  !< the run in the folder is: nothing is left to do
    type(error_t), allocatable, intent(out) :: error  !< another scene, files
    complete = .false.
    if (path_kind(folder//'/echo.nml') == path_absent) then
      call new_run(scene, input, folder, .false., run, error)
      if (.not. allocated(error)) call say("resumed   nothing in '"//folder//"' yet: begins with the first load step")
      return
    end if
    call check_same_scene(folder, 'echo.nml', scene, error)
    if (allocated(error)) return
    complete = is_complete(folder)
    if (complete) return
    if (has_checkpoint(folder)) then
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
end module hd_resume
