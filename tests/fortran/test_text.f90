! SPDX-License-Identifier: GPL-3.0-or-later
module test_text
  use hd_check, only: check
  use hd_kinds, only: dp
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_text, only: exact, is_utf8, lower, nearest_name, percent, push, string_t, to_number, to_text
  implicit none
  private
  public :: run_text

contains

  subroutine run_text()
    type(string_t), allocatable :: names(:)
    character(len=*), parameter :: numbers(8) = [character(len=24) :: '5', '-.5', '+2.', '1e3', '1.5D-300', '0012', '1E+05', &
      '0.1000000000000000055511']
    character(len=*), parameter :: others(22) = [character(len=9) :: '', '/', ',', '2*5', '1;2', '1+13', '1-3', 'e5', '1e', '1e+', &
      '.', '+', 'nan', 'inf', '1e999', '1 2', '1,', '0x10', '1_0', '1d', '--1', '1.2.3']
    real(dp), parameter :: values(8) = [5._dp, -0.5_dp, 2._dp, 1e3_dp, 1.5e-300_dp, 12._dp, 1e5_dp, 0.1_dp]
    real(dp) :: x, y
    integer(int64) :: n
    logical :: ok
    character(len=:), allocatable :: text
    integer :: i
    call check(to_text(-42) == '-42', 'an integer becomes its decimal digits')
    call check(to_text(0.0175_dp) == '0.0175', 'a real becomes short text')
    call check(to_text(0.001_dp) == '0.001' .and. index(to_text(0.0001_dp), 'e') > 0, 'from a thousandth on without an exponent')
    call check(percent(0.1234_dp) == '12 %' .and. percent(0.0123_dp) == '1.2 %', 'a share becomes per cent of two digits')
    x = 1.2345678901234567e-7_dp
    do i = 1, 300
      x = -1.7_dp*x/(1 + 1e-3_dp*i)
      text = exact(x)
      read (text, *) y
      call check(abs(x - y) <= 0, 'exact() reads back as the same number: '//exact(x))
    end do
    do i = 1, size(numbers)
      call to_number(trim(numbers(i)), x, ok)
      call check(ok .and. abs(x - values(i)) <= 0, 'a number is read to the last bit: '//numbers(i))
    end do
    do i = 1, size(others)
      call to_number(trim(others(i)), x, ok)
      call check(.not. ok, "what list-directed reading bends into a number is none: '"//trim(others(i))//"'")
      call to_number(trim(others(i)), n, ok)
      call check(.not. ok, "nor a whole number: '"//trim(others(i))//"'")
    end do
    call to_number('-9000000000', n, ok)
    call check(ok .and. n == -9000000000_int64, 'a whole number may have 64 bits')
    call to_number('9999999999999999999', n, ok)
    call check(.not. ok, 'one beyond them is none')
    call check(lower('MuMPS') == 'mumps', 'lower() lowers letters')
    call check(is_utf8('T in N m, '//char(194)//char(181)//'m, '//char(226)//char(134)//char(146)//' '//char(240)//char(159)// &
      char(152)//char(128)), 'letters of one to four bytes are UTF-8')
    call check(.not. any([is_utf8(char(192)//char(175)), is_utf8(char(224)//char(128)//char(175)), &
      is_utf8(char(240)//char(128)//char(128)//char(175))]), 'a slash in two, three or four bytes is not')
    call check(.not. any([is_utf8(char(237)//char(160)//char(128)), is_utf8(char(244)//char(144)//char(128)//char(128)), &
      is_utf8(char(226)//char(134)), is_utf8(char(181))]), 'nor half of a pair, a letter beyond the last plane, or a part of one')
    call push(names, 'friction')
    call push(names, 'torque')
    call check(nearest_name('frction', names) == 'friction', 'a misspelt name finds its neighbour')
    call check(nearest_name('zzzzzz', names) == '', 'a name without neighbour finds none')
  end subroutine run_text
end module test_text
