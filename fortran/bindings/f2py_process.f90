! SPDX-License-Identifier: GPL-3.0-or-later
!> Flat entries for Python: the process around the runs. Locks of folders, signals, the log, forks.
module f2py_process
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_checksum, only: file_checksum, hexadecimal
  use hd_error, only: error_t, raise, code_internal
  use hd_named_values, only: names_of
  use hd_status, only: tell, hand_over
  use hd_registry, only: put_lock, drop_lock, leave_locks
  use hd_system, only: watch_signals, unwatch_signals, stop_signal, renew_after_fork
  use hd_lapack, only: choose_kernels, blas_threads
  use hd_log, only: keep_log, set_log_level, normal, take_line
  implicit none
  private
  public :: value_names, checksum_of, folder_lock, folder_unlock, signals_watch, signals_unwatch, signals_list, engine_begin, &
    log_take, fork_child

contains

  !> Names of the places of a list of numbers, parted by commas.
  subroutine value_names(list, status)
    character(len=*), intent(in) :: list
    integer(c_int), intent(out) :: status
    type(error_t), allocatable :: error
    if (len(names_of(list)) == 0) call raise(error, code_internal, "no list of names '"//list//"'")
    if (.not. allocated(error)) call hand_over(names_of(list))
    call tell(error, status)
  end subroutine value_names

  !> Checksum of the first bytes of a file, of all where `bytes` is -1; blank: it cannot be read.
  subroutine checksum_of(path, bytes, text)
    character(len=*), intent(in) :: path
    integer(c_int), intent(in) :: bytes
    character(len=16), intent(out) :: text
    !f2py threadsafe
    integer(int64) :: sum
    integer :: status
    call file_checksum(path, int(bytes, int64), sum, status)
    text = merge(hexadecimal(sum), repeat(' ', len(text)), status == 0)
  end subroutine checksum_of

  !> Lock a folder for one writer.
  subroutine folder_lock(folder, handle, status)
    character(len=*), intent(in) :: folder
    integer(c_int), intent(out) :: handle, status
    type(error_t), allocatable :: error
    call put_lock(folder, handle, error)
    call tell(error, status)
  end subroutine folder_lock

  !> Give the lock of a folder back.
  subroutine folder_unlock(handle)
    integer(c_int), intent(in) :: handle
    call drop_lock(handle)
  end subroutine folder_unlock

  !> Signals that Python has handlers for stop the engine too, from here on.
  subroutine signals_watch()
    call watch_signals()
  end subroutine signals_watch

  !> The end of that; `number` is the signal that came, 0 for none.
  subroutine signals_unwatch(number)
    integer(c_int), intent(out) :: number
    number = unwatch_signals()
  end subroutine signals_unwatch

  !> Numbers of the signals that end a run in order; 0 behind the last.
  subroutine signals_list(numbers)
    integer(c_int), intent(out) :: numbers(16)
    integer :: i
    numbers = [(stop_signal(int(i, c_int)), i=0, size(numbers) - 1)]
  end subroutine signals_list

  !> Begin with a log that is kept in memory instead of printed, and with the kernels of the processor.
  subroutine engine_begin()
    call keep_log()
    call set_log_level(normal)
    call choose_kernels()
  end subroutine engine_begin

  !> The oldest line of the log; found is 0 if there is none.
  subroutine log_take(line, found)
    character(len=2048), intent(out) :: line
    integer(c_int), intent(out) :: found
    logical :: there
    call take_line(line, there)
    found = merge(1, 0, there)
  end subroutine log_take

  !> A forked child has none of its parent's threads: it computes with one, and its locks are open.
  subroutine fork_child()
    integer :: before
    call renew_after_fork()
    call leave_locks()
    before = blas_threads(1)
  end subroutine fork_child
end module f2py_process
