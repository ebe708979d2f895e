! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs that Python holds by an integer handle; a stale handle is an error, not a crash.
module hd_registry
  use hd_error, only: error_t, raise, code_input
  use hd_run, only: run_t
  use hd_text, only: to_text
  implicit none
  private
  public :: put_run, find_run, drop_run

  integer, parameter :: capacity = 64   !< runs open at the same time
  type :: slot_t
    type(run_t), allocatable :: run
  end type slot_t
  type(slot_t), save, target :: slots(capacity)

contains

  !> Make room for a run.
  subroutine put_run(handle, run, error)
    integer, intent(out) :: handle                    !< its handle
    type(run_t), pointer, intent(out) :: run          !< an empty run
    type(error_t), allocatable, intent(out) :: error  !< too many
    nullify (run)
    do handle = 1, capacity
      if (allocated(slots(handle)%run)) cycle
      allocate (slots(handle)%run)
      run => slots(handle)%run
      return
    end do
    call raise(error, code_input, to_text(capacity)//' runs are open; close some with Run.close()')
  end subroutine put_run

  !> Run of a handle.
  subroutine find_run(handle, run, error)
    integer, intent(in) :: handle                     !< handle
    type(run_t), pointer, intent(out) :: run          !< its run
    type(error_t), allocatable, intent(out) :: error  !< no such run
    nullify (run)
    if (handle >= 1 .and. handle <= capacity) then
      if (allocated(slots(handle)%run)) run => slots(handle)%run
    end if
    if (.not. associated(run)) call raise(error, code_input, 'this run is closed (handle '//to_text(handle)//')')
  end subroutine find_run

  !> Forget a run.
  subroutine drop_run(handle)
    integer, intent(in) :: handle  !< handle
    if (handle < 1 .or. handle > capacity) return
    if (allocated(slots(handle)%run)) deallocate (slots(handle)%run)
  end subroutine drop_run
end module hd_registry
