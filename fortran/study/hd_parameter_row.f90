! SPDX-License-Identifier: GPL-3.0-or-later
!> Rows of the table of parameters: a key of the input file, tied to its place in the scene, with bounds, unit and meaning.
module hd_parameter_row
  use hd_kinds, only: dp
  use hd_text, only: string_t, push
  implicit none
  private
  public :: parameter_t, table_t, whole, number, numbers, text

  !> A key: exactly one of integer, real, text and reals points into the scene.
  type :: parameter_t
    character(len=:), allocatable :: group, key, unit, meaning
    integer, pointer :: integer => null()
    real(dp), pointer :: real => null(), reals(:) => null()
    character(len=:), pointer :: text => null()
    real(dp) :: low = -huge(1._dp), high = huge(1._dp)   !< valid range
    logical :: open_low = .false., open_high = .false.   !< the bound itself is not valid
    type(string_t), allocatable :: choices(:)            !< valid texts, empty: any
    character(len=:), allocatable :: default             !< as text
    logical :: given = .false.                           !< set by the user
  end type parameter_t

  type :: table_t
    type(parameter_t), allocatable :: rows(:)
  end type table_t

contains

  !> Add a row.
  subroutine append(table, group, key, unit, meaning, row)
    type(table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, unit, meaning
    type(parameter_t), intent(inout) :: row
    type(parameter_t), allocatable :: longer(:)
    integer :: i
    row%group = group
    row%key = key
    row%unit = unit
    row%meaning = meaning
    if (.not. allocated(row%choices)) allocate (row%choices(0))
    allocate (longer(size(table%rows) + 1))
    do i = 1, size(table%rows)
      longer(i) = table%rows(i)
    end do
    longer(size(longer)) = row
    call move_alloc(longer, table%rows)
  end subroutine append

  subroutine whole(table, group, key, value, low, high, meaning)
    type(table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, meaning
    integer, intent(in), target :: value
    integer, intent(in) :: low, high
    type(parameter_t) :: row
    row%integer => value
    row%low = low
    row%high = high
    call append(table, group, key, '', meaning, row)
  end subroutine whole

  subroutine number(table, group, key, value, unit, low, high, meaning, closed)
    type(table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, unit, meaning
    real(dp), intent(in), target :: value
    real(dp), intent(in) :: low, high
    logical, intent(in), optional :: closed   !< the bounds themselves are valid
    type(parameter_t) :: row
    row%real => value
    row%low = low
    row%high = high
    row%open_low = .not. present(closed)
    row%open_high = row%open_low
    call append(table, group, key, unit, meaning, row)
  end subroutine number

  subroutine numbers(table, group, key, value, unit, low, high, meaning)
    type(table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, unit, meaning
    real(dp), intent(in), target :: value(:)
    real(dp), intent(in) :: low, high
    type(parameter_t) :: row
    row%reals => value
    row%low = low
    row%high = high
    call append(table, group, key, unit, meaning, row)
  end subroutine numbers

  subroutine text(table, group, key, value, choices, meaning)
    type(table_t), intent(inout) :: table
    character(len=*), intent(in) :: group, key, choices, meaning
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
    call append(table, group, key, '', meaning, row)
  end subroutine text
end module hd_parameter_row
