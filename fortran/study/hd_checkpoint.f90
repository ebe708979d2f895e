! SPDX-License-Identifier: GPL-3.0-or-later
!> A checkpoint: what a stopped run needs to go on as if it had never stopped.
module hd_checkpoint
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_file, code_input
  use hd_input, only: read_scene
  use hd_parameters, only: table_t, new_table, value_text
  use hd_problem, only: state_t
  use hd_scene, only: scene_t
  use hd_system, only: rename_file, remove_file, path_kind, path_file
  use hd_text, only: string_t
  implicit none
  private
  public :: mark_t, save_checkpoint, load_checkpoint, drop_checkpoint, has_checkpoint, check_same_scene

  !> Where a run stands after its last converged load step.
  type :: mark_t
    real(dp) :: position = 0, position_before = 0  !< of the last two converged states
    real(dp) :: stride = 0                         !< longest part of a load step that is tried
    real(dp) :: rotation_assembled = 0             !< [rad]
    logical :: easy = .true.                       !< the last part took few iterations
    integer :: steps = 0, iterations = 0, cuts = 0, cycles = 0 !< so far
    character(len=8) :: symmetry(2) = ''           !< used in assembly and torque
    integer(int64) :: sizes(4) = 0                 !< of the tables [bytes]
  end type mark_t

  character(len=*), parameter :: magic = 'hdengine checkpoint 3'

contains

  !> File of a folder's checkpoint.
  pure function file_of(folder) result(path)
    character(len=*), intent(in) :: folder  !< of a run
    character(len=:), allocatable :: path
    path = folder//'/checkpoint.bin'
  end function file_of

  !> The folder holds a checkpoint.
  logical function has_checkpoint(folder)
    character(len=*), intent(in) :: folder  !< of a run
    has_checkpoint = path_kind(file_of(folder)) == path_file
  end function has_checkpoint

  !> Remove the checkpoint of a run that is over.
  subroutine drop_checkpoint(folder)
    character(len=*), intent(in) :: folder  !< of a run
    call remove_file(file_of(folder))
  end subroutine drop_checkpoint

  !> Write a checkpoint; the one before is replaced only when this one is whole.
  subroutine save_checkpoint(folder, mark, before, state, error)
    character(len=*), intent(in) :: folder            !< of a run
    type(mark_t), intent(in) :: mark                  !< where it stands
    type(state_t), intent(in) :: before, state        !< last two converged states
    type(error_t), allocatable, intent(out) :: error  !< disk full
    integer :: unit, status
    open (newunit=unit, file=file_of(folder)//'.part', access='stream', form='unformatted', action='write', &
      status='replace', iostat=status)
    if (status == 0) write (unit, iostat=status) magic, size(state%u, 2), size(state%traction, 2), mark
    if (status == 0) call write_state(unit, before, status)
    if (status == 0) call write_state(unit, state, status)
    if (status == 0) then
      close (unit, iostat=status)
    end if
    if (status == 0) then
      call rename_file(file_of(folder)//'.part', file_of(folder), error)
    else
      call raise(error, code_file, "cannot write '"//file_of(folder)//"': is the disk full?")
    end if
  end subroutine save_checkpoint

  !> Read a checkpoint into states of the right size.
  subroutine load_checkpoint(folder, mark, before, state, error)
    character(len=*), intent(in) :: folder            !< of a run
    type(mark_t), intent(out) :: mark                 !< where it stood
    type(state_t), intent(inout) :: before, state     !< at rest, then the last two converged states
    type(error_t), allocatable, intent(out) :: error  !< broken, or of another mesh
    character(len=len(magic)) :: word
    integer :: unit, status, nodes, points
    word = ''
    nodes = 0
    points = 0
    open (newunit=unit, file=file_of(folder), access='stream', form='unformatted', action='read', status='old', iostat=status)
    if (status == 0) read (unit, iostat=status) word, nodes, points
    if (status == 0 .and. word == magic .and. nodes == size(state%u, 2) .and. points == size(state%traction, 2)) then
      read (unit, iostat=status) mark
      if (status == 0) call read_state(unit, before, status)
      if (status == 0) call read_state(unit, state, status)
      close (unit)
    else
      status = 1
    end if
    if (status /= 0) call raise(error, code_file, &
      "'"//file_of(folder)//"' is broken or of another version: begin anew with --force")
  end subroutine load_checkpoint

  subroutine write_state(unit, state, status)
    integer, intent(in) :: unit
    type(state_t), intent(in) :: state
    integer, intent(out) :: status
    write (unit, iostat=status) state%u, state%traction, state%slip, state%gap, state%contact
  end subroutine write_state

  subroutine read_state(unit, state, status)
    integer, intent(in) :: unit
    type(state_t), intent(inout) :: state
    integer, intent(out) :: status
    read (unit, iostat=status) state%u, state%traction, state%slip, state%gap, state%contact
  end subroutine read_state

  !> A run goes on only with the scene it began with; limits and output may change.
  subroutine check_same_scene(folder, file, scene, error)
    character(len=*), intent(in) :: folder            !< of a run
    character(len=*), intent(in) :: file              !< in it: the scene it began with
    type(scene_t), intent(in) :: scene                !< asked for now
    type(error_t), allocatable, intent(out) :: error  !< the first key that differs
    type(scene_t), target :: began, now
    type(table_t) :: one, two
    type(string_t) :: none(0)
    integer :: i
    call read_scene(folder//'/'//file, none, began, error)
    if (allocated(error)) return
    now = scene
    call new_table(began, one)
    call new_table(now, two)
    do i = 1, size(one%rows)
      associate (a => one%rows(i), b => two%rows(i))
        if (may_change(a%group//'.'//a%key) .or. value_text(a) == value_text(b)) cycle
        call raise(error, code_input, a%group//'.'//a%key//' = '//value_text(b)//', but the run in '''//folder// &
          ''' began with '//value_text(a)//new_line('a')// &
          '      valid: the same value; or begin anew in another folder (--out DIR) or with --force')
        return
      end associate
    end do
  end subroutine check_same_scene

  !> Keys that may change while a run rests.
  pure logical function may_change(name)
    character(len=*), intent(in) :: name  !< group.key
    may_change = index(name, 'output.') == 1 .or. index(name, 'run.') == 1 .or. name == 'solver.time_limit_s' .or. &
      name == 'solver.max_iterations' .or. name == 'solver.max_cuts' .or. name == 'mesh.memory_limit_mb'
  end function may_change
end module hd_checkpoint
