! SPDX-License-Identifier: GPL-3.0-or-later
!> Files that are written: each begins as a new file beside its place, so that links, pipes and devices are never followed, and is
!> moved there. Closed without an error it is on the disk to its last byte.
module hd_new_file
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_checksum, only: file_checksum
  use hd_error, only: error_t, raise, code_file
  use hd_system, only: rename_file, remove_file, settle_file, system_text, writable_kind, begin_error
  implicit none
  private
  public :: new_file_t, write_text

  !> A file that is being written, as an unformatted stream.
  type :: new_file_t
    integer :: unit = -1                                     !< of the open file, else -1
    integer :: status = 0                                    !< of the first writing that failed, 0: none did
    character(len=:), allocatable :: path                    !< its place
    character(len=:), allocatable :: now                     !< where it stands so far
  contains
    procedure :: open => open_new
    procedure :: open_in_place
    procedure :: reopen
    procedure :: put
    procedure :: close => close_written
  end type new_file_t

contains

  !> Begin a file beside its place.
  subroutine open_new(self, path, error)
    class(new_file_t), intent(inout) :: self          !< file
    character(len=*), intent(in) :: path              !< its place
    type(error_t), allocatable, intent(out) :: error  !< something else than a file stands there, cannot be written
    call start(self, path, error)
    if (allocated(error)) return
    call remove_file(self%now)
    open (newunit=self%unit, file=self%now, access='stream', form='unformatted', action='write', status='new', iostat=self%status)
    if (self%status /= 0) self%status = begin_error(self%now)
    call check_open(self, error)
  end subroutine open_new

  !> Begin a file in its place, for readers that follow its growth.
  subroutine open_in_place(self, path, error)
    class(new_file_t), intent(inout) :: self          !< file
    character(len=*), intent(in) :: path              !< its place
    type(error_t), allocatable, intent(out) :: error  !< something else than a file stands there, cannot be written
    call self%open(path, error)
    if (.not. allocated(error)) call place(self, error)
    if (allocated(error)) call self%close(error)
  end subroutine open_in_place

  !> Take up a file again behind its first bytes, in a copy of them: the file stays as it is where that fails.
  subroutine reopen(self, path, bytes, sum, error)
    class(new_file_t), intent(inout) :: self          !< file
    character(len=*), intent(in) :: path              !< its place
    integer(int64), intent(in) :: bytes               !< that stay
    integer(int64), intent(in) :: sum                 !< their checksum
    type(error_t), allocatable, intent(out) :: error  !< absent, shorter already, changed, cannot be written
    integer(int64) :: found
    call start(self, path, error)
    if (allocated(error)) return
    call file_checksum(path, bytes, found, self%status, copy=self%now)
    if (self%status == -1) then
      call raise(error, code_file, "'"//path//"' is missing or shorter than the run left it: begin anew with --force")
      return
    else if (self%status == 0 .and. found /= sum) then
      call raise(error, code_file, "'"//path//"' is not as the run left it (its checksum differs): begin anew with --force")
      call remove_file(self%now)
      return
    end if
    if (self%status == 0) open (newunit=self%unit, file=self%now, access='stream', form='unformatted', action='write', &
      status='old', position='append', iostat=self%status)
    call check_open(self, error)
    if (.not. allocated(error)) call place(self, error)
    if (allocated(error)) call self%close(error)
  end subroutine reopen

  !> A file that could not be opened.
  subroutine check_open(self, error)
    class(new_file_t), intent(inout) :: self          !< file
    type(error_t), allocatable, intent(out) :: error  !< says why
    if (self%status == 0) return
    self%unit = -1
    call remove_file(self%now)
    call raise(error, code_file, "cannot write '"//self%path//"'"//system_text(self%status))
  end subroutine check_open

  !> Names of a file that is begun; its place must be free, or a file's.
  subroutine start(self, path, error)
    class(new_file_t), intent(inout) :: self          !< file
    character(len=*), intent(in) :: path              !< its place
    type(error_t), allocatable, intent(out) :: error  !< something else than a file stands there
    self%path = path
    self%now = path//'.part'
    self%status = 0
    if (.not. writable_kind(path)) call raise(error, code_file, "cannot write '"//path//"': it is no regular file (a link, a "// &
      'folder, a pipe or a device): remove it, or choose another folder with --out DIR')
  end subroutine start

  !> Move a file to its place.
  subroutine place(self, error)
    class(new_file_t), intent(inout) :: self          !< file
    type(error_t), allocatable, intent(out) :: error  !< cannot be moved
    call rename_file(self%now, self%path, error)
    if (allocated(error)) then
      call remove_file(self%now)
    else
      self%now = self%path
    end if
  end subroutine place

  !> Write text as it stands; once a writing has failed nothing more is written.
  subroutine put(self, text)
    class(new_file_t), intent(inout) :: self  !< file
    character(len=*), intent(in) :: text      !< bytes
    if (self%status == 0) write (self%unit, iostat=self%status) text
  end subroutine put

  !> Close a file: its bytes are counted and on the disk, then it is moved to its place. The compiler's library does not tell where
  !> its last bytes found no room. An error that is there already stays, and the file is not moved.
  subroutine close_written(self, error)
    class(new_file_t), intent(inout) :: self            !< file; nothing happens where it is not open
    type(error_t), allocatable, intent(inout) :: error  !< disk full
    integer(int64) :: next
    integer :: status
    if (self%unit == -1) return
    if (self%status == 0) flush (self%unit, iostat=self%status)
    inquire (unit=self%unit, pos=next)
    close (self%unit, iostat=status)
    self%unit = -1
    if (self%status == 0) self%status = status
    if (self%status == 0) self%status = settle_file(self%now, next - 1)
    if (self%status /= 0 .and. .not. allocated(error)) call raise(error, code_file, "cannot write '"//self%path//"'"// &
      system_text(self%status))
    if (self%now == self%path) return
    if (allocated(error)) then
      call remove_file(self%now)
    else
      call place(self, error)
    end if
  end subroutine close_written

  !> Write a text as a file; a file of that name is replaced when the new one is whole.
  subroutine write_text(path, text, error)
    character(len=*), intent(in) :: path              !< file
    character(len=*), intent(in) :: text              !< lines, each with its end
    type(error_t), allocatable, intent(out) :: error  !< cannot be written
    type(new_file_t) :: file
    call file%open(path, error)
    if (allocated(error)) return
    call file%put(text)
    call file%close(error)
  end subroutine write_text
end module hd_new_file
