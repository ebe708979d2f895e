! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs and locks that Python holds by an integer handle; a run's is never used again: a stale one is an error. The model of the run
!> that was closed last is kept for the next one.
module hd_registry
  use hd_error, only: error_t, raise, code_input
  use hd_folder_lock, only: folder_lock_t
  use hd_model, only: model_t, give_back
  use hd_run, only: run_t, leave_model
  use hd_text, only: to_text
  implicit none
  private
  public :: put_run, find_run, drop_run, put_lock, drop_lock, leave_locks, forget_model

  integer, parameter :: capacity = 64   !< runs open at the same time
  type :: run_slot_t
    integer :: handle = 0
    type(run_t), pointer :: run => null()  ! one that is allocatable takes seconds to compile: its copy and end are written out
  end type run_slot_t
  type(run_slot_t), save, target :: slots(capacity)
  integer, save :: latest = 0           !< handle given last
  type(model_t), allocatable, save :: last_model
  type(folder_lock_t), save :: locks(capacity)
  logical, save :: taken(capacity) = .false.

contains

  !> Make room for a run.
  subroutine put_run(handle, run, error)
    integer, intent(out) :: handle                    !< its handle
    type(run_t), pointer, intent(out) :: run          !< an empty run with the model of the last one
    type(error_t), allocatable, intent(out) :: error  !< too many
    integer :: i
    nullify (run)
    do i = 1, capacity
      if (associated(slots(i)%run)) cycle
      latest = latest + 1
      handle = latest
      slots(i)%handle = handle
      allocate (slots(i)%run)
      run => slots(i)%run
      call move_alloc(last_model, run%model)
      return
    end do
    handle = 0
    call raise(error, code_input, to_text(capacity)//' runs are open; close some with Run.close()')
  end subroutine put_run

  !> Run of a handle.
  subroutine find_run(handle, run, error)
    integer, intent(in) :: handle                     !< handle
    type(run_t), pointer, intent(out) :: run          !< its run
    type(error_t), allocatable, intent(out) :: error  !< no such run
    integer :: i
    nullify (run)
    i = findloc(slots%handle, handle, 1)
    if (i > 0) then
      if (associated(slots(i)%run)) run => slots(i)%run
    end if
    if (.not. associated(run)) call raise(error, code_input, 'this run is closed (handle '//to_text(handle)//')')
  end subroutine find_run

  !> Forget a run, but its model.
  subroutine drop_run(handle)
    integer, intent(in) :: handle  !< handle
    integer :: i
    i = findloc(slots%handle, handle, 1)
    if (i == 0) return
    if (.not. associated(slots(i)%run)) return
    call leave_model(slots(i)%run, last_model)
    deallocate (slots(i)%run)
  end subroutine drop_run

  !> Give back the memory of the last run's model.
  subroutine forget_model()
    call give_back(last_model)
  end subroutine forget_model

  !> Take the lock of a folder.
  subroutine put_lock(folder, handle, error)
    character(len=*), intent(in) :: folder            !< folder
    integer, intent(out) :: handle                    !< of the lock
    type(error_t), allocatable, intent(out) :: error  !< too many, held by another process
    handle = findloc(taken, .false., 1)
    if (handle == 0) then
      call raise(error, code_input, to_text(capacity)//' folders are locked')
    else
      call locks(handle)%take(folder, error)
      taken(handle) = .not. allocated(error)
    end if
  end subroutine put_lock

  !> In a forked child: let go of all locks, which stay the parent's.
  subroutine leave_locks()
    integer :: i
    do i = 1, capacity
      call drop_lock(i)
      if (associated(slots(i)%run)) call slots(i)%run%lock%give()
    end do
  end subroutine leave_locks

  !> Give a lock back.
  subroutine drop_lock(handle)
    integer, intent(in) :: handle  !< of the lock
    if (handle < 1 .or. handle > capacity) return
    if (taken(handle)) call locks(handle)%give()
    taken(handle) = .false.
  end subroutine drop_lock
end module hd_registry
