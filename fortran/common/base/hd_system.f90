! SPDX-License-Identifier: GPL-3.0-or-later
!> The operating system: stop signals, folders, renaming.
module hd_system
  use, intrinsic :: iso_fortran_env, only: int64
  use, intrinsic :: iso_c_binding, only: c_int, c_long_long, c_char, c_null_char, c_ptr, c_null_ptr, c_loc
  use hd_error, only: error_t, raise, code_file, code_stopped
  use hd_text, only: string_t
  implicit none
  private
  public :: set_libraries, renew_after_fork, catch_signals, watch_signals, unwatch_signals, keep_memory, &
    stop_requested, hold_stop, check_stop, stop_signal, fill_streams, leave_at_once, addresses_limited, make_directory, &
    rename_file, remove_file, remove_matching, remove_directory, settle_file, system_text, writable_kind, begin_error, file_bytes, &
    path_kind, become_program
  public :: path_absent, path_file, path_directory

  integer, parameter :: path_absent = 0     !< nothing there
  integer, parameter :: path_file = 1       !< a file
  integer, parameter :: path_directory = 2  !< a folder

  interface
    subroutine catch_signals() bind(c, name='hd_catch_signals')
    end subroutine catch_signals
    !> In a forked child: one thread, open locks.
    subroutine renew_after_fork() bind(c, name='hd_renew_after_fork')
    end subroutine renew_after_fork
    subroutine watch_signals() bind(c, name='hd_watch_signals')
    end subroutine watch_signals
    integer(c_int) function unwatch_signals() bind(c, name='hd_unwatch_signals')
      import :: c_int
    end function unwatch_signals
    !> From the program's start on threads of OpenMP that wait sleep; an environment that says otherwise is left alone.
    subroutine set_libraries() bind(c, name='hd_set_libraries')
    end subroutine set_libraries
    subroutine keep_memory() bind(c, name='hd_keep_memory')
    end subroutine keep_memory
    subroutine c_hold(on) bind(c, name='hd_hold_stop')
      import :: c_int
      integer(c_int), value, intent(in) :: on
    end subroutine c_hold
    integer(c_int) function c_stop() bind(c, name='hd_stop_requested')
      import :: c_int
    end function c_stop
    integer(c_int) function c_mkdir(path) bind(c, name='hd_make_directory')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
    end function c_mkdir
    integer(c_int) function c_rename(from, to) bind(c, name='hd_rename')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: from(*), to(*)
    end function c_rename
    !> Number of the i-th signal that ends a run in order, from 0; 0: there is none.
    integer(c_int) function stop_signal(i) bind(c, name='hd_stop_signal')
      import :: c_int
      integer(c_int), value :: i
    end function stop_signal
    !> Standard streams that are closed lead nowhere.
    subroutine fill_streams() bind(c, name='hd_fill_streams')
    end subroutine fill_streams
    integer(c_int) function c_limited() bind(c, name='hd_addresses_limited')
      import :: c_int
    end function c_limited
    integer(c_int) function c_begin_error(path) bind(c, name='hd_begin_error')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
    end function c_begin_error
    integer(c_int) function c_writable(path) bind(c, name='hd_writable_kind')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
    end function c_writable
    integer(c_long_long) function c_bytes(path) bind(c, name='hd_file_bytes')
      import :: c_char, c_long_long
      character(kind=c_char), intent(in) :: path(*)
    end function c_bytes
    integer(c_int) function c_settle(path, bytes) bind(c, name='hd_settle')
      import :: c_int, c_long_long, c_char
      character(kind=c_char), intent(in) :: path(*)
      integer(c_long_long), value :: bytes
    end function c_settle
    subroutine c_words(number, text, size) bind(c, name='hd_system_text')
      import :: c_int, c_char
      integer(c_int), value :: number, size
      character(kind=c_char), intent(out) :: text(*)
    end subroutine c_words
    integer(c_int) function c_remove(path) bind(c, name='hd_remove')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
    end function c_remove
    subroutine c_remove_matching(folder, pattern) bind(c, name='hd_remove_matching')
      import :: c_char
      character(kind=c_char), intent(in) :: folder(*), pattern(*)
    end subroutine c_remove_matching
    integer(c_int) function c_rmdir(path) bind(c, name='hd_remove_directory')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
    end function c_rmdir
    integer(c_int) function c_kind(path) bind(c, name='hd_path_kind')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
    end function c_kind
    subroutine c_become(words) bind(c, name='hd_become')
      import :: c_ptr
      type(c_ptr), intent(in) :: words(*)
    end subroutine c_become
  end interface

contains

  !> A caught signal asks for an orderly stop.
  logical function stop_requested()
    stop_requested = c_stop() /= 0
  end function stop_requested

  !> From here on a stop waits, or no longer.
  subroutine hold_stop(on)
    logical, intent(in) :: on  !< it waits
    call c_hold(merge(1_c_int, 0_c_int, on))
  end subroutine hold_stop

  !> The process may not take all addresses (ulimit -v, ulimit -d): libraries that find none wait for ever.
  logical function addresses_limited()
    addresses_limited = c_limited() /= 0
  end function addresses_limited

  !> For loops that take long: an error where a stop has been asked for.
  subroutine check_stop(error)
    type(error_t), allocatable, intent(out) :: error  !< a signal was caught
    if (stop_requested()) call raise(error, code_stopped, 'interrupted')
  end subroutine check_stop

  !> Become another program: the one beside this, else one of the search path. Returns only if there is none.
  subroutine become_program(words)
    type(string_t), intent(in) :: words(:)  !< its name and arguments
    character(kind=c_char), allocatable, target :: text(:, :)
    type(c_ptr) :: pointers(size(words) + 1)
    integer :: i, k
    allocate (text(maxval([(len(words(i)%s), i=1, size(words))]) + 1, size(words)), source=c_null_char)
    do i = 1, size(words)
      do k = 1, len(words(i)%s)
        text(k, i) = words(i)%s(k:k)
      end do
      pointers(i) = c_loc(text(1, i))
    end do
    pointers(size(words) + 1) = c_null_ptr
    call c_become(pointers)
  end subroutine become_program

  !> What stands at a path.
  integer function path_kind(path)
    character(len=*), intent(in) :: path  !< path
    path_kind = c_kind(trim(path)//c_null_char)
  end function path_kind

  !> Make a folder; nothing happens if it is there.
  subroutine make_directory(path, error)
    character(len=*), intent(in) :: path              !< folder; its parent must exist
    type(error_t), allocatable, intent(out) :: error  !< cannot be made
    integer(c_int) :: status
    status = c_mkdir(trim(path)//c_null_char)
    if (path_kind(path) == path_directory) return
    call raise(error, code_file, "cannot make the folder '"//trim(path)//"'"//system_text(int(status))// &
      '; its parent must exist and be writable: make it, or choose another folder with --out DIR')
  end subroutine make_directory

  !> Rename a file, replacing the target.
  subroutine rename_file(from, to, error)
    character(len=*), intent(in) :: from, to          !< paths
    type(error_t), allocatable, intent(out) :: error  !< cannot be renamed
    integer(c_int) :: status
    status = c_rename(trim(from)//c_null_char, trim(to)//c_null_char)
    if (status /= 0) call raise(error, code_file, "cannot write '"//trim(to)//"'"//system_text(int(status)))
  end subroutine rename_file

  !> Remove a file if it is there.
  subroutine remove_file(path)
    character(len=*), intent(in) :: path  !< file
    integer(c_int) :: status
    status = c_remove(trim(path)//c_null_char)
  end subroutine remove_file

  !> Remove the files of a folder whose names match a pattern, as of a shell.
  subroutine remove_matching(folder, pattern)
    character(len=*), intent(in) :: folder   !< folder
    character(len=*), intent(in) :: pattern  !< pattern
    call c_remove_matching(trim(folder)//c_null_char, pattern//c_null_char)
  end subroutine remove_matching

  !> Remove a folder if it is empty.
  subroutine remove_directory(path)
    character(len=*), intent(in) :: path  !< folder
    integer(c_int) :: status
    status = c_rmdir(trim(path)//c_null_char)
  end subroutine remove_directory

  !> Nothing stands at a path, or a file that is no link: it may be written.
  logical function writable_kind(path)
    character(len=*), intent(in) :: path  !< path
    writable_kind = c_writable(trim(path)//c_null_char) /= 0
  end function writable_kind

  !> Why no file could be begun at a path, for `system_text`.
  integer function begin_error(path)
    character(len=*), intent(in) :: path  !< file
    begin_error = c_begin_error(trim(path)//c_null_char)
  end function begin_error

  !> Bytes of a file on the disk, -1: there is none.
  integer(int64) function file_bytes(path)
    character(len=*), intent(in) :: path  !< file
    file_bytes = c_bytes(trim(path)//c_null_char)
  end function file_bytes

  !> Bring a closed file to the disk; 0: done, and it has its length, else for `system_text`.
  integer function settle_file(path, bytes) result(status)
    character(len=*), intent(in) :: path   !< file
    integer(int64), intent(in) :: bytes    !< that were written
    status = c_settle(trim(path)//c_null_char, int(bytes, c_long_long))
  end function settle_file

  !> End without waiting for threads of libraries: those of OpenBLAS ask for memory for ever where ulimit -v leaves none.
  subroutine leave_at_once(code)
    integer, intent(in) :: code  !< exit code
    interface
      subroutine c_leave(code) bind(c, name='_exit')
        import :: c_int
        integer(c_int), value :: code
      end subroutine c_leave
    end interface
    call c_leave(int(code, c_int))
  end subroutine leave_at_once

  !> Why a writing failed, behind a colon.
  function system_text(status) result(text)
    integer, intent(in) :: status  !< of a writing: of the system, of the compiler's library, -1 for bytes that are missing
    character(len=:), allocatable :: text
    integer, parameter :: first_of_library = 5000  !< gfortran's own numbers; below are the system's
    character(len=200) :: words
    text = ': is the disk full, or the size of files limited (ulimit -f)?'
    if (status <= 0 .or. status >= first_of_library) return
    call c_words(int(status, c_int), words, len(words))
    text = ': '//trim(words)
  end function system_text
end module hd_system
