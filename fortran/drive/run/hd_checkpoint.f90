! SPDX-License-Identifier: GPL-3.0-or-later
!> A checkpoint: what a stopped run needs to go on as if it had never stopped.
module hd_checkpoint
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_checksum, only: checksum, file_checksum
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_file, code_input
  use hd_facets, only: sums_t
  use hd_input, only: read_scene
  use hd_load_path, only: place_t
  use hd_loop, only: loop_t, store_loop, recall_loop
  use hd_new_file, only: new_file_t
  use hd_output, only: output_t, step_t
  use hd_parameters, only: parameter_table_t, new_table, value_text
  use hd_problem, only: state_t
  use hd_promises, only: most_steps
  use hd_flank_friction, only: memories
  use hd_scene, only: scene_t
  use hd_strength, only: strength_t
  use hd_summary, only: tally_t
  use hd_system, only: remove_file, path_kind, path_file
  use hd_text, only: string_t
  use hd_twist_shares, only: part_names
  use hd_version, only: version
  implicit none
  private
  public :: mark_t, reference_t, flexibility_t, save_checkpoint, load_checkpoint, drop_checkpoint, has_checkpoint, check_same_scene

  !> Flexibility of the drive with its joint, for the tangent and the secant K_TS.
  type :: flexibility_t
    logical :: known = .false.     !< there is one: the bodies are assembled, their contact has a joint
    real(dp) :: glued = 0          !< with the faces glued [rad/(N m)]
    real(dp) :: coupled = 0        !< at the last load step [rad/(N m)]
    real(dp) :: torque = 0         !< of that step [N m]
    real(dp) :: turned = 0         !< integral of the coupled one over the torque [rad]
    real(dp) :: contact = 0        !< stiffness of the contact alone at the last load step [N m/rad]
    real(dp) :: shares(size(part_names)) = 0   !< of the drive's further twist there
    real(dp) :: tangent(0:most_steps) = 0   !< tangent K_TS after the assembly and in each torque step, 0: none [N m/rad]
  end type flexibility_t

  !> The step of a loop that its results are of: where the torque was largest last, in the sense of its first rise.
  type :: reference_t
    logical :: known = .false.    !< there was one
    type(step_t) :: step
    type(sums_t) :: sums
    logical :: certain = .true.   !< its tangent is
  end type reference_t

  !> The part of a run that it goes on from, beside its states and its loop: written and read whole.
  type :: mark_t
    type(place_t) :: place, place_before    !< of the last two converged states
    real(dp) :: stride = 1                  !< longest share of a load step that is tried
    logical :: easy = .true.                !< the last part took few iterations
    type(step_t) :: step                    !< last converged step
    real(dp) :: rotation_assembled = 0      !< rotation at the end of the assembly [rad]
    type(flexibility_t) :: flexibility      !< for tangent and secant K_TS
    logical :: certain = .true.             !< the last step's tangent is
    type(tally_t) :: tally                  !< counts
    type(reference_t) :: reference          !< of a loop
    type(strength_t) :: strength            !< largest stresses so far
    integer(int64) :: table_sizes(6) = 0    !< of the tables that are written [bytes]
    integer(int64) :: table_sums(6) = 0     !< their checksums
  end type mark_t

  !> What a file begins with; at its end stands the checksum of all before.
  type :: head_t
    character(len=21) :: magic = 'hdengine checkpoint E'
    character(len=32) :: version = version
    integer(int64) :: bytes = 0           !< of the file
    integer(int64) :: scene = 0           !< checksum of the keys that may not change,
    integer(int64) :: files = 0           !< and of the tables that they name
    integer :: nodes = 0, points = 0      !< of the mesh
  end type head_t

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
  subroutine save_checkpoint(output, scene, mark, before, state, top, loop, error)
    type(output_t), intent(in) :: output              !< folder of the run, its grids so far
    type(scene_t), intent(in) :: scene                !< its scene
    type(mark_t), intent(in) :: mark                  !< where it stands
    type(state_t), intent(in) :: before, state        !< last two converged states
    type(state_t), intent(in) :: top                  !< that of the reference step, if there is one
    type(loop_t), intent(in) :: loop                  !< steps of a whole drive
    type(error_t), allocatable, intent(out) :: error  !< disk full
    type(new_file_t) :: file
    type(head_t) :: head
    integer(int64) :: sum
    head%scene = scene_checksum(scene)
    head%files = scene%files
    head%nodes = size(state%u, 2)
    head%points = size(state%traction, 2)
    call file%open(file_of(output%folder), error)
    if (allocated(error)) return
    associate (unit => file%unit, status => file%status)
      write (unit, iostat=status) head, mark, size(output%grids), output%grids, output%times
      if (status == 0) call write_state(unit, before, status)
      if (status == 0) call write_state(unit, state, status)
      if (status == 0 .and. mark%reference%known) call write_state(unit, top, status)
      if (status == 0 .and. scene%support%loop) call store_loop(loop, unit, status)
      if (status == 0) then
        inquire (unit=unit, pos=head%bytes)
        head%bytes = head%bytes - 1 + storage_size(sum)/8
        write (unit, pos=1, iostat=status) head
      end if
      if (status == 0) flush (unit, iostat=status)
      if (status == 0) call file_checksum(file%now, head%bytes - storage_size(sum)/8, sum, status)
      if (status == 0) write (unit, pos=head%bytes - storage_size(sum)/8 + 1, iostat=status) sum
    end associate
    call file%close(error)
  end subroutine save_checkpoint

  !> Read a checkpoint into states of the right size. What is not, to the last bit, what this version of the engine wrote for
  !> this scene is refused.
  subroutine load_checkpoint(folder, scene, mark, output, before, state, top, loop, error)
    character(len=*), intent(in) :: folder            !< of a run
    type(scene_t), intent(in) :: scene                !< its scene
    type(mark_t), intent(out) :: mark                 !< where it stood
    type(output_t), intent(out) :: output             !< its grids
    type(state_t), intent(inout) :: before, state     !< at rest, then the last two converged states
    type(state_t), intent(inout) :: top               !< gets that of the reference step
    type(loop_t), intent(inout) :: loop               !< gets the steps of a whole drive
    type(error_t), allocatable, intent(out) :: error  !< broken, of another version, scene or mesh
    type(head_t) :: head, right
    character(len=:), allocatable :: cause
    integer(int64) :: bytes, sum, found, place
    integer :: unit, status, grids
    cause = 'broken: its length or its checksum is wrong'
    open (newunit=unit, file=file_of(folder), access='stream', form='unformatted', action='read', status='old', iostat=status)
    if (status == 0) then
      inquire (unit=unit, size=bytes)
      read (unit, iostat=status) head
      inquire (unit=unit, pos=place)
      if (status == 0 .and. head%magic /= right%magic) cause = 'no checkpoint of this version of hdengine'
      if (status == 0 .and. (head%magic /= right%magic .or. head%bytes /= bytes)) status = 1
      if (status == 0) read (unit, pos=bytes - storage_size(sum)/8 + 1, iostat=status) sum
      if (status == 0) then
        call file_checksum(file_of(folder), bytes - storage_size(sum)/8, found, status)
        if (found /= sum) status = 1
      end if
      if (status == 0 .and. head%version /= right%version) then
        cause = 'of hdengine '//trim(head%version)//', this is '//trim(right%version)
        status = 1
      else if (status == 0 .and. head%files /= scene%files) then
        cause = 'of other tables: joint.table_file, joint.spectrum_file or wave_generator.cam_file have changed since'
        status = 1
      else if (status == 0 .and. head%scene /= scene_checksum(scene)) then
        cause = 'of another scene'
        status = 1
      else if (status == 0 .and. (head%nodes /= size(state%u, 2) .or. head%points /= size(state%traction, 2))) then
        cause = 'of another mesh'
        status = 1
      end if
      if (status == 0) read (unit, pos=place, iostat=status) mark, grids
      if (status == 0) allocate (output%grids(grids), output%times(grids))
      if (status == 0) read (unit, iostat=status) output%grids, output%times
      if (status == 0) call read_state(unit, before, status)
      if (status == 0) call read_state(unit, state, status)
      top = state
      if (status == 0 .and. mark%reference%known) call read_state(unit, top, status)
      if (status == 0 .and. scene%support%loop) call recall_loop(loop, unit, state, status)
      close (unit)
    end if
    if (status /= 0) call raise(error, code_file, "'"//file_of(folder)//"' is "//cause//new_line('a')// &
      '      begin anew with --force')
  end subroutine load_checkpoint

  !> Checksum of all keys that may not change while a run rests.
  integer(int64) function scene_checksum(scene) result(sum)
    type(scene_t), intent(in) :: scene  !< scene
    type(scene_t), target :: copy
    type(parameter_table_t) :: table
    integer :: i
    copy = scene
    call new_table(copy, table)
    sum = 0
    do i = 1, size(table%rows)
      associate (p => table%rows(i))
        if (.not. p%may_change()) sum = checksum(p%group//'.'//p%key//'='//value_text(p)//new_line('a'), sum)
      end associate
    end do
  end function scene_checksum

  subroutine write_state(unit, state, status)
    integer, intent(in) :: unit
    type(state_t), intent(in) :: state
    integer, intent(out) :: status
    write (unit, iostat=status) state%u, state%traction, state%slip, state%gap, state%contact, size(state%touch), &
      size(state%past, 2), state%touch, state%past
  end subroutine write_state

  subroutine read_state(unit, state, status)
    integer, intent(in) :: unit
    type(state_t), intent(inout) :: state
    integer, intent(out) :: status
    integer :: companions, flanks
    read (unit, iostat=status) state%u, state%traction, state%slip, state%gap, state%contact, flanks, companions
    if (status /= 0) return
    deallocate (state%touch, state%past)
    allocate (state%touch(flanks), state%past(memories, companions))
    read (unit, iostat=status) state%touch, state%past
  end subroutine read_state

  !> A run goes on only with the scene it began with; limits and output may change.
  subroutine check_same_scene(folder, file, scene, error)
    character(len=*), intent(in) :: folder            !< of a run
    character(len=*), intent(in) :: file              !< in it: the scene it began with
    type(scene_t), intent(in) :: scene                !< asked for now
    type(error_t), allocatable, intent(out) :: error  !< the first key that differs
    type(scene_t), target :: began, now
    type(parameter_table_t) :: one, two
    type(string_t) :: none(0)
    integer :: i
    call read_scene(folder//'/'//file, none, began, error)
    if (allocated(error)) return
    now = scene
    call new_table(began, one)
    call new_table(now, two)
    do i = 1, size(one%rows)
      associate (a => one%rows(i), b => two%rows(i))
        if (a%may_change() .or. value_text(a) == value_text(b)) cycle
        call raise(error, code_input, a%group//'.'//a%key//' = '//value_text(b)//', but the run in '''//folder// &
          ''' began with '//value_text(a)//new_line('a')// &
          '      valid: the same value; or begin anew in another folder (--out DIR) or with --force')
        return
      end associate
    end do
  end subroutine check_same_scene
end module hd_checkpoint
