! SPDX-License-Identifier: GPL-3.0-or-later
!> The folder of a run, before its writers: free or not, and without what an earlier run left. A run is told by its echo.nml, and
!> has its summary.json as proof of its end; files of these names that are none of its are left alone too.
module hd_results_folder
  use hd_error, only: error_t, raise, code_file
  use hd_system, only: make_directory, path_kind, path_absent, path_directory, remove_file, remove_matching
  use hd_text, only: string_t, split
  implicit none
  private
  public :: check_input, check_folder, clear_folder

contains

  !> An input has no name of a file that runs write: its own run might overwrite it.
  subroutine check_input(input, names, error)
    character(len=*), intent(in) :: input             !< file
    character(len=*), intent(in) :: names             !< of tables, or patterns, parted by commas
    type(error_t), allocatable, intent(out) :: error  !< it has
    type(string_t), allocatable :: name(:)
    integer :: i
    name = split('summary.json,'//names)
    do i = 1, size(name)
      if (input(index(input, '/', back=.true.) + 1:) == name(i)%s) call raise(error, code_file, "'"//input//"' has the name of "// &
        'a file that runs write: give it another')
    end do
  end subroutine check_input

  !> A folder may be used: absent, without a study, and without a run and files of the names of its tables, or `force`.
  subroutine check_folder(folder, names, force, error)
    character(len=*), intent(in) :: folder            !< folder
    character(len=*), intent(in) :: names             !< of tables, or patterns, parted by commas
    logical, intent(in) :: force                      !< replace earlier results
    type(error_t), allocatable, intent(out) :: error  !< exists already
    character(len=:), allocatable :: what
    type(string_t), allocatable :: name(:)
    integer :: i
    if (path_kind(folder) == path_absent) return
    if (path_kind(folder) /= path_directory) then
      call raise(error, code_file, "'"//folder//"' is a file, not a folder: choose another with --out DIR")
    else if (path_kind(folder//'/study.json') /= path_absent) then
      call raise(error, code_file, "'"//folder//"' holds a study: choose another folder with --out DIR (out=)")
    else if (.not. force) then
      name = split('echo.nml,summary.json,checkpoint.bin,'//names)
      do i = 1, size(name)
        if (scan(name(i)%s, '*') > 0) cycle
        if (path_kind(folder//'/'//name(i)%s) == path_absent) cycle
        what = 'an earlier run'
        if (i > 1) what = name(i)%s//', a file that runs write'
        call raise(error, code_file, "'"//folder//"' holds "//what//': add --force to replace it (from Python force=True), or '// &
          'choose another folder with --out DIR (out=)')
        return
      end do
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
