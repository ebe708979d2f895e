! SPDX-License-Identifier: GPL-3.0-or-later
!> Tests of the lists of numbers that cross to Python by name.
module test_named_values
  use hd_check, only: check
  use hd_error, only: error_t, code_internal
  use hd_kinds, only: dp
  use hd_named_values, only: named_list_t, names_of
  implicit none
  private
  public :: run_named_values

contains

  !> Every check.
  subroutine run_named_values()
    type(named_list_t) :: list
    type(error_t), allocatable :: error
    real(dp) :: values(15), taken
    values = 0
    list%list = 'joint'
    call list%put(values, 'plastic', 3._dp)
    call list%check(error)
    call check(.not. allocated(error) .and. values(15) == 3 .and. list%take(values, 'plastic') == 3, &
      'a number is found under its name')
    call list%put(values, 'palstic', 4._dp)
    taken = list%take(values, 'nu')
    call list%check(error)
    call check(allocated(error), 'a name that a list does not hold is an error')
    if (.not. allocated(error)) return
    call check(error%code == code_internal .and. index(error%message, "'palstic'") > 0, &
      'of hdengine itself, and tells the first such name')
    call check(taken /= taken .and. count(abs(values) > 0) == 1, 'it reads as NaN and changes nothing')
    call check(names_of('wrong') == '', 'there is no other list')
  end subroutine run_named_values
end module test_named_values
