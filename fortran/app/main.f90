! SPDX-License-Identifier: GPL-3.0-or-later
!> hdengine.x: reads a scene, runs it, and ends with the exit code of its error.
program main
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use hd_command_line, only: command_t, read_command_line, obey
  use hd_error, only: error_t, code_memory
  use hd_lapack, only: choose_kernels
  use hd_log, only: check_log
  use hd_system, only: catch_signals, fill_streams, keep_memory, leave_at_once, set_libraries
  implicit none
  type(command_t) :: command
  type(error_t), allocatable :: error
  integer :: status
  call fill_streams()
  call set_libraries()
  call choose_kernels()
  call catch_signals()
  call keep_memory()
  call read_command_line(command, error)
  if (.not. allocated(error)) call obey(command, error)
  if (.not. allocated(error)) call check_log(error)
  if (.not. allocated(error)) stop 0, quiet=.true.
  if (index(error%message, 'error: ') /= 1) error%message = 'error: '//error%message
  write (error_unit, '(a)', iostat=status) error%message
  flush (output_unit)
  flush (error_unit)
  if (error%code == code_memory) call leave_at_once(error%code)
  stop error%code, quiet=.true.
end program main
