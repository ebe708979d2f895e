! SPDX-License-Identifier: GPL-3.0-or-later
!> The one error value. Its code is the exit code of hdengine.x and selects the Python exception.
module hd_error
  implicit none
  private
  public :: error_t, raise
  public :: code_done, code_internal, code_input, code_file, code_not_converged, code_linear_solver, &
    code_memory, code_stopped

  integer, parameter :: code_done = 0          !< success
  integer, parameter :: code_internal = 1      !< a bug in hdengine
  integer, parameter :: code_input = 2         !< usage or input
  integer, parameter :: code_file = 3          !< a file cannot be read or written
  integer, parameter :: code_not_converged = 4 !< Newton or contact iteration, gross slip
  integer, parameter :: code_linear_solver = 5 !< factorisation failed, a body is not held
  integer, parameter :: code_memory = 6        !< out of memory
  integer, parameter :: code_stopped = 7       !< stopped at a limit, checkpoint written

  !> What went wrong: says what, where, the value seen and what to do.
  type :: error_t
    integer :: code = code_internal
    character(len=:), allocatable :: message
  end type error_t

contains

  !> Set an error; the library never stops, it returns this to its caller.
  pure subroutine raise(error, code, message)
    type(error_t), allocatable, intent(out) :: error  !< the error to set
    integer, intent(in) :: code                       !< one of the code_* constants
    character(len=*), intent(in) :: message           !< what, where, value seen, what is valid
    allocate (error)
    error%code = code
    error%message = message
  end subroutine raise
end module hd_error
