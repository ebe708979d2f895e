! SPDX-License-Identifier: GPL-3.0-or-later
!> The harness of the Fortran tests: each check carries the sentence it proves.
module hd_check
  use, intrinsic :: iso_fortran_env, only: output_unit
  use hd_kinds, only: dp
  implicit none
  private
  public :: check, check_close, report_checks

  integer, save :: passed = 0, failed = 0

contains

  !> The sentence is true.
  subroutine check(condition, sentence)
    logical, intent(in) :: condition
    character(len=*), intent(in) :: sentence
    if (condition) then
      passed = passed + 1
    else
      failed = failed + 1
      write (output_unit, '(a)') 'FAILED: '//sentence
    end if
  end subroutine check

  !> |actual - expected| <= tolerance.
  subroutine check_close(actual, expected, tolerance, sentence)
    real(dp), intent(in) :: actual, expected, tolerance
    character(len=*), intent(in) :: sentence
    character(len=100) :: seen
    write (seen, '(a,es23.15,a,es23.15,a)') ' (', actual, ' against', expected, ')'
    call check(abs(actual - expected) <= tolerance, sentence//trim(seen))
  end subroutine check_close

  !> Closing line; true if nothing failed.
  logical function report_checks() result(good)
    write (output_unit, '(i0,a,i0,a)') passed, ' passed, ', failed, ' failed'
    good = failed == 0
  end function report_checks
end module hd_check
