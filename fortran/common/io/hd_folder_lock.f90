! SPDX-License-Identifier: GPL-3.0-or-later
!> A folder is written by one run or study at a time.
module hd_folder_lock
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
  use hd_error, only: error_t, raise, code_file
  use hd_system, only: make_directory, remove_directory, path_kind, path_absent, path_directory
  implicit none
  private
  public :: folder_lock_t

  character(len=*), parameter :: lock_name = 'hdengine.lock'  !< file of the lock
  integer(c_int), parameter :: no_file = 2, elsewhere = 3, not_regular = 4  !< as in hd_folder_lock.c; 0 taken, 1 held

  !> A lock that is held, or none.
  type :: folder_lock_t
    private
    character(len=:), allocatable :: folder
    integer(c_int) :: handle = -1
    logical :: made = .false.           !< the folder was made for it
  contains
    procedure :: take
    procedure :: give
  end type folder_lock_t

  interface
    integer(c_int) function c_take(path, kernel, handle, holder, size) bind(c, name='hd_take_lock')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: kernel, size
      integer(c_int), intent(out) :: handle
      character(kind=c_char), intent(out) :: holder(*)
    end function c_take
    subroutine c_give(path, handle) bind(c, name='hd_give_lock')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: handle
    end subroutine c_give
  end interface

contains

  !> Lock a folder, which is made if need be. No folder, a file in its place, and one that may not be written: no lock; who
  !> writes there will say so.
  subroutine take(self, folder, error, by_name)
    class(folder_lock_t), intent(inout) :: self       !< lock
    character(len=*), intent(in) :: folder            !< folder, '' for none
    type(error_t), allocatable, intent(out) :: error  !< another process is at work in it
    logical, intent(in), optional :: by_name          !< without the kernel, as on file systems that cannot lock
    character(kind=c_char) :: text(400)
    character(len=:), allocatable :: holder
    integer(c_int) :: kernel, status
    integer :: i
    if (len_trim(folder) == 0) return
    self%folder = trim(folder)
    self%made = path_kind(folder) == path_absent
    if (self%made) call make_directory(folder, error)
    if (allocated(error) .or. path_kind(folder) /= path_directory) return
    kernel = 1
    if (present(by_name)) kernel = merge(0, 1, by_name)
    status = c_take(self%folder//'/'//lock_name//c_null_char, kernel, self%handle, text, size(text))
    if (status == 0 .or. status == no_file) return
    if (status == not_regular) then
      call raise(error, code_file, "'"//self%folder//'/'//lock_name//"' is no regular file: remove it, or choose another "// &
        'folder (--out DIR)')
      return
    end if
    holder = ''
    do i = 1, size(text)
      if (text(i) == c_null_char) exit
      holder = holder//text(i)
    end do
    if (len(holder) == 0) holder = 'another process'
    holder = "'"//self%folder//"' is in use: "//holder//', writes into it'//new_line('a')// &
      '      wait for its end, end it, or choose another folder (--out DIR)'
    if (status == elsewhere) holder = holder//"; if it has died, remove '"//self%folder//'/'//lock_name//"'"
    call raise(error, code_file, holder)
  end subroutine take

  !> Give the lock back; a folder that was made for it and stayed empty is removed.
  subroutine give(self)
    class(folder_lock_t), intent(inout) :: self  !< lock
    if (self%handle >= 0) call c_give(self%folder//'/'//lock_name//c_null_char, self%handle)
    self%handle = -1
    if (self%made) call remove_directory(self%folder)
    self%made = .false.
  end subroutine give
end module hd_folder_lock
