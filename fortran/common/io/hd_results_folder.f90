! SPDX-License-Identifier: GPL-3.0-or-later
!> The folder of a run, before its writers: free or not, and without what an earlier run left. A run is told by its echo.nml, and
!> has its summary.json as proof of its end.
module hd_results_folder
  use hd_error, only: error_t, raise, code_file
  use hd_system, only: make_directory, path_kind, path_absent, path_directory, remove_file, remove_matching
  use hd_text, only: string_t, split
  implicit none
  private
  public :: check_folder, clear_folder

contains

  !> A folder may be used: absent, without a run, or `force`.
  subroutine check_folder(folder, force, error)
    character(len=*), intent(in) :: folder            !< folder
    logical, intent(in) :: force                      !< replace earlier results
    type(error_t), allocatable, intent(out) :: error  !< exists already
    if (path_kind(folder) == path_absent) return
    if (path_kind(folder) /= path_directory) then
      call raise(error, code_file, "'"//folder//"' is a file, not a folder: choose another with --out DIR")
    else if (path_kind(folder//'/echo.nml') /= path_absent .and. .not. force) then
      call raise(error, code_file, "'"//folder//"' holds an earlier run: add --force to replace it (from Python "// &
        'force=True), or choose another folder with --out DIR (out=)')
    end if
  end subroutine check_folder

  !> Make the folder, or remove what an earlier run left in it: a table of that run is none of the next one. The summary goes first,
  !> and always.
  subroutine clear_folder(folder, names, error)
    character(len=*), intent(in) :: folder            !< folder
    character(len=*), intent(in) :: names             !< of files, or patterns, parted by commas
    type(error_t), allocatable, intent(out) :: error  !< cannot be made
    type(string_t), allocatable :: name(:)
    integer :: i
    call make_directory(folder, error)
    if (allocated(error)) return
    call remove_file(folder//'/summary.json')
    if (path_kind(folder//'/echo.nml') == path_absent) return
    name = split(names)
    do i = 1, size(name)
      call remove_matching(folder, name(i)%s)
    end do
  end subroutine clear_folder
end module hd_results_folder
