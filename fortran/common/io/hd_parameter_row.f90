! SPDX-License-Identifier: GPL-3.0-or-later
!> Rows of the table of parameters: a key of the input file, tied to its place in the scene, with bounds, unit and meaning.
module hd_parameter_row
  use hd_kinds, only: dp
  use hd_text, only: string_t, push
  implicit none
  private
  public :: parameter_t, parameter_table_t, add_integer, add_real, add_reals, add_choice, tolerate, close_table
  public :: stage_model, stage_assembly, stage_load, stage_control, stage_output

  !> What a key affects first; everything after it in this order is affected too.
  enum, bind(c)
    enumerator :: stage_model = 1, stage_assembly, stage_load, stage_control, stage_output
  end enum
  character(len=8), parameter :: stages(5) = [character(len=8) :: 'model', 'assembly', 'load', 'control', 'output']

  integer, parameter :: some = 64  !< rows that a table begins with

  !> A key: exactly one of integer, real, text and reals points into the scene.
  type :: parameter_t
    character(len=:), allocatable :: group, key, unit, meaning
    !> What it affects: 'model' (mesh, supports, factors), 'assembly' (states before the torque), 'load' (states under torque,
    !> stiffness), 'control' (when a run ends) or 'output' (what is written); 'cam': the assembly, or the model where the bodies
    !> are formed to the cam; 'joint': the load, or the assembly under a joint law. With ' limit' behind it: also of the effort.
    character(len=:), allocatable :: affects
    integer, pointer :: integer => null()
    real(dp), pointer :: real => null(), reals(:) => null()
    integer, pointer :: count => null()                  !< of a list: how many of `reals` count
    character(len=:), pointer :: text => null()
    real(dp) :: low = -huge(1._dp), high = huge(1._dp)   !< valid range
    logical :: open_low = .false., open_high = .false.   !< the bound itself is not valid
    type(string_t), allocatable :: choices(:)            !< valid texts, empty: any
    character(len=:), allocatable :: default             !< as text
    logical :: given = .false.                           !< set by the user
    real(dp) :: tolerance = 0                            !< half width of a 95 % interval of the value; 0: none is stated
    character(len=5) :: tolerance_of = ''                !< what it is a share of: 'value', 'bore' (its radius), 'fit' (its mean
                                                         !< clearance), 'play' (that of the balls); '': in the unit
    character(len=:), allocatable :: tolerance_source    !< in a word or two
  contains
    procedure :: stage
    procedure :: may_change
  end type parameter_t

  type :: parameter_table_t
    type(parameter_t), allocatable :: rows(:)  !< keys; until `close_table` with room for more
    integer, private :: used = 0               !< rows that are keys
  contains
    procedure :: find
    procedure :: given
  end type parameter_table_t

contains

  !> What the key affects first, 0 if the table does not say.
  pure integer function stage(self, formed, joint_law)
    class(parameter_t), intent(in) :: self  !< row
    logical, intent(in) :: formed           !< the bodies are formed to the cam
    logical, intent(in) :: joint_law        !< the joint is part of the contact law
    character(len=:), allocatable :: word
    word = self%affects
    if (index(word, ' limit') > 0) word = word(:index(word, ' limit') - 1)
    select case (word)
    case ('cam')
      stage = merge(stage_model, stage_assembly, formed)
    case ('joint')
      stage = merge(stage_assembly, stage_load, joint_law)
    case default
      do stage = size(stages), 1, -1
        if (stages(stage) == word) exit
      end do
    end select
  end function stage

  !> Row of a key, 0 if there is none.
  pure integer function find(self, group, key) result(row)
    class(parameter_table_t), intent(in) :: self  !< table
    character(len=*), intent(in) :: group, key    !< names
    do row = size(self%rows), 1, -1
      if (self%rows(row)%group == group .and. self%rows(row)%key == key) return
    end do
  end function find

  !> A key was set by the user; one that the table does not hold is an internal error.
  pure logical function given(self, group, key)
    class(parameter_table_t), intent(in) :: self  !< table
    character(len=*), intent(in) :: group, key    !< names
    integer :: row
    row = self%find(group, key)
    if (row == 0) error stop 'internal error: the program asks for a key that there is not'
    given = self%rows(row)%given
  end function given

  !> A stopped run may go on with another value: it changes nothing that was computed.
  pure logical function may_change(self)
    class(parameter_t), intent(in) :: self  !< row
    may_change = self%stage(.true., .true.) >= stage_control .or. index(self%affects, ' limit') > 0
  end function may_change

  !> Add a row.
  subroutine append(table, group, key, affects, unit, meaning, row)
    type(parameter_table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, affects, unit, meaning
    type(parameter_t), intent(inout) :: row
    row%group = group
    row%key = key
    row%affects = affects
    row%unit = unit
    row%meaning = meaning
    if (.not. allocated(row%choices)) allocate (row%choices(0))
    if (table%used == 0) allocate (table%rows(some))
    if (table%used == size(table%rows)) call resize(table, 2*table%used)
    table%used = table%used + 1
    table%rows(table%used) = row
  end subroutine append

  !> State the tolerance of the last row; of a choice: the other one is the other bound.
  subroutine tolerate(table, tolerance, of, source)
    type(parameter_table_t), intent(inout) :: table   !< table
    real(dp), intent(in) :: tolerance                 !< half width of a 95 % interval
    character(len=*), intent(in) :: of                !< 'value', 'bore', 'fit', 'play' or ''
    character(len=*), intent(in) :: source            !< where it comes from
    associate (row => table%rows(table%used))
      row%tolerance = tolerance
      row%tolerance_of = of
      row%tolerance_source = source
    end associate
  end subroutine tolerate

  !> The table is whole: its rows are its keys.
  subroutine close_table(table)
    type(parameter_table_t), intent(inout) :: table  !< table
    call resize(table, table%used)
  end subroutine close_table

  subroutine resize(table, n)
    type(parameter_table_t), intent(inout) :: table
    integer, intent(in) :: n
    type(parameter_t), allocatable :: rows(:)
    integer :: i
    allocate (rows(n))
    do i = 1, table%used
      rows(i) = table%rows(i)
    end do
    call move_alloc(rows, table%rows)
  end subroutine resize

  subroutine add_integer(table, group, key, affects, value, low, high, meaning)
    type(parameter_table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, affects, meaning
    integer, intent(in), target :: value
    integer, intent(in) :: low, high
    type(parameter_t) :: row
    row%integer => value
    row%low = low
    row%high = high
    call append(table, group, key, affects, '', meaning, row)
  end subroutine add_integer

  subroutine add_real(table, group, key, affects, value, unit, low, high, meaning, closed)
    type(parameter_table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, affects, unit, meaning
    real(dp), intent(in), target :: value
    real(dp), intent(in) :: low, high
    logical, intent(in), optional :: closed   !< the bounds themselves are valid
    type(parameter_t) :: row
    row%real => value
    row%low = low
    row%high = high
    row%open_low = .not. present(closed)
    row%open_high = row%open_low
    call append(table, group, key, affects, unit, meaning, row)
  end subroutine add_real

  !> A list of numbers.
  subroutine add_reals(table, group, key, affects, value, unit, low, high, meaning, count)
    type(parameter_table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, affects, unit, meaning
    real(dp), intent(in), target :: value(:)
    real(dp), intent(in) :: low, high
    integer, intent(in), target, optional :: count   !< how many count, one or more; left out: all
    type(parameter_t) :: row
    row%reals => value
    if (present(count)) row%count => count
    row%low = low
    row%high = high
    call append(table, group, key, affects, unit, meaning, row)
  end subroutine add_reals

  subroutine add_choice(table, group, key, affects, value, choices, meaning)
    type(parameter_table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, affects, choices, meaning
    character(len=*), intent(in), target :: value
    type(parameter_t) :: row
    integer :: i, j
    row%text => value
    allocate (row%choices(0))
    i = 1
    do while (i <= len(choices))
      j = i + index(choices(i:)//' ', ' ') - 2
      call push(row%choices, choices(i:j))
      i = j + 2
    end do
    call append(table, group, key, affects, '', meaning, row)
  end subroutine add_choice
end module hd_parameter_row
