! SPDX-License-Identifier: GPL-3.0-or-later
! Flat entries for Python: the process around the runs. Locks of folders, signals, the log, forks.

!> Names of the places of a list of numbers, parted by commas.
subroutine value_names(list, text, status, message)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t, raise, code_internal
  use hd_named_values, only: names_of
  use hd_status, only: tell, hand_over
  implicit none
  character(len=*), intent(in) :: list
  character(len=8192), intent(out) :: text
  integer(c_int), intent(out) :: status
  character(len=8192), intent(out) :: message
  type(error_t), allocatable :: error
  text = ''
  if (len(names_of(list)) == 0) call raise(error, code_internal, "no list of names '"//list//"'")
  if (.not. allocated(error)) call hand_over(names_of(list), text)
  call tell(error, status, message)
end subroutine value_names

!> Lock a folder for one writer.
subroutine folder_lock(folder, handle, status, message)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_error, only: error_t
  use hd_registry, only: put_lock
  use hd_status, only: tell
  implicit none
  character(len=*), intent(in) :: folder
  integer(c_int), intent(out) :: handle, status
  character(len=8192), intent(out) :: message
  type(error_t), allocatable :: error
  call put_lock(folder, handle, error)
  call tell(error, status, message)
end subroutine folder_lock

!> Give the lock of a folder back.
subroutine folder_unlock(handle)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_registry, only: drop_lock
  implicit none
  integer(c_int), intent(in) :: handle
  call drop_lock(handle)
end subroutine folder_unlock

!> Signals that Python has handlers for stop the engine too, from here on.
subroutine signals_watch()
  use hd_system, only: watch_signals
  implicit none
  call watch_signals()
end subroutine signals_watch

!> The end of that; `number` is the signal that came, 0 for none.
subroutine signals_unwatch(number)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_system, only: unwatch_signals
  implicit none
  integer(c_int), intent(out) :: number
  number = unwatch_signals()
end subroutine signals_unwatch

!> Numbers of the signals that end a run in order; 0 behind the last.
subroutine signals_list(numbers)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_system, only: stop_signal
  implicit none
  integer(c_int), intent(out) :: numbers(16)
  integer :: i
  numbers = [(stop_signal(int(i, c_int)), i=0, size(numbers) - 1)]
end subroutine signals_list

!> Begin with a log that is kept in memory instead of printed, and with the kernels of the processor.
subroutine engine_begin()
  use hd_lapack, only: choose_kernels
  use hd_log, only: keep_log, set_log_level, normal
  implicit none
  call keep_log()
  call set_log_level(normal)
  call choose_kernels()
end subroutine engine_begin

!> The oldest line of the log; found is 0 if there is none.
subroutine log_take(line, found)
  use, intrinsic :: iso_c_binding, only: c_int
  use hd_log, only: take_line
  implicit none
  character(len=2048), intent(out) :: line
  integer(c_int), intent(out) :: found
  logical :: there
  call take_line(line, there)
  found = merge(1, 0, there)
end subroutine log_take

!> A forked child has none of its parent's threads: it computes with one, and its locks are open.
subroutine fork_child()
  use hd_system, only: renew_after_fork
  use hd_lapack, only: blas_threads
  use hd_registry, only: leave_locks
  implicit none
  integer :: before
  call renew_after_fork()
  call leave_locks()
  before = blas_threads(1)
end subroutine fork_child
