! SPDX-License-Identifier: GPL-3.0-or-later
module test_text
  use hd_check, only: check
  use hd_kinds, only: dp
  use hd_text, only: exact, lower, nearest_name, percent, push, string_t, to_text
  implicit none
  private
  public :: run_text

contains

  subroutine run_text()
    type(string_t), allocatable :: names(:)
    real(dp) :: x, y
    character(len=:), allocatable :: text
    integer :: i
    call check(to_text(-42) == '-42', 'an integer becomes its decimal digits')
    call check(to_text(0.0175_dp) == '0.0175', 'a real becomes short text')
    call check(percent(0.1234_dp) == '12 %' .and. percent(0.0123_dp) == '1.2 %', 'a share becomes per cent of two digits')
    x = 1.2345678901234567e-7_dp
    do i = 1, 300
      x = -1.7_dp*x/(1 + 1e-3_dp*i)
      text = exact(x)
      read (text, *) y
      call check(abs(x - y) <= 0, 'exact() reads back as the same number: '//exact(x))
    end do
    call check(lower('MuMPS') == 'mumps', 'lower() lowers letters')
    call push(names, 'friction')
    call push(names, 'torque')
    call check(nearest_name('frction', names) == 'friction', 'a misspelt name finds its neighbour')
    call check(nearest_name('zzzzzz', names) == '', 'a name without neighbour finds none')
  end subroutine run_text
end module test_text
