! SPDX-License-Identifier: GPL-3.0-or-later
module test_table
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_check, only: check
  use hd_checksum, only: checksum
  use hd_error, only: error_t
  use hd_kinds, only: dp
  use hd_system, only: remove_file
  use hd_table, only: table_t
  implicit none
  private
  public :: run_table

  character(len=*), parameter :: path = 'test_table.csv'
  integer, parameter :: n = 200

contains

  subroutine run_table()
    type(table_t) :: table
    type(error_t), allocatable :: error
    real(dp) :: x(n), y(n)
    integer :: i, unit
    integer(int64) :: bytes, sum
    character(len=6000) :: line
    x = [(-1.7_dp**i/(1 + 1e-3_dp*i)*1e-30_dp, i=1, n)]
    x(:6) = [0._dp, 0.25_dp, -huge(x), -tiny(x), tiny(x)*epsilon(x), 1/3._dp]
    call table%open(path, 'a,b', error)
    do i = 1, n
      call table%add(x(i))
    end do
    call table%end_row(error)
    call table%find_bytes(bytes, error)
    sum = table%sum
    call table%add(-7)
    call table%add('open  ')
    call table%add(8)
    call table%end_row(error)
    call table%close(error)
    open (newunit=unit, file=path, action='read', status='old', recl=6000)
    read (unit, '(a)') line
    call check(line == 'a,b', 'a table begins with its header')
    read (unit, '(a)') line
    read (line, *) y
    call check(all(abs(x - y) <= 0), 'reals of a long row read back as the same numbers, the smallest and largest too')
    call check(index(line, '0,0.25,-1.7976931348623157e+308,-2.2250738585072014e-308,') == 1, 'zeros and short reals are short')
    read (unit, '(a)') line
    close (unit)
    call check(line == '-7,open,8', 'integers stand as they are, texts without trailing blanks')
    call table%reopen(path, bytes, sum, error)
    call table%add(8)
    call table%end_row(error)
    call table%close(error)
    open (newunit=unit, file=path, action='read', status='old', recl=6000)
    read (unit, '(/,/,a)') line
    close (unit)
    call check(line == '8', 'a table goes on behind the bytes that stay')
    open (newunit=unit, file=path, access='stream', form='unformatted', action='readwrite', status='old')
    write (unit, pos=8) 'x'
    close (unit)
    call table%reopen(path, bytes, sum, error)
    call check(allocated(error), 'a table that was changed does not go on')
    call remove_file(path)
    call check_digits()
    call check(checksum('123456789') == int(z'995DC9BBDF1939FA', int64), 'CRC-64 has the value that xz states for 123456789')
    call check(checksum('6789', checksum('12345')) == checksum('123456789'), 'a checksum goes on behind another')
  end subroutine run_table

  !> Numbers of any size and sign read back to the last bit.
  subroutine check_digits()
    integer, parameter :: rows = 20000, columns = 5
    type(table_t) :: table
    type(error_t), allocatable :: error
    real(dp) :: x(columns, rows), y(0:columns, rows)
    integer(int64) :: bits(columns, rows)
    integer :: i, unit
    bits(1, 1) = 88172645463325252_int64
    do i = 2, size(bits)  ! xorshift of Marsaglia
      associate (now => bits(mod(i - 1, columns) + 1, (i - 1)/columns + 1))
        now = bits(mod(i - 2, columns) + 1, (i - 2)/columns + 1)
        now = ieor(now, ishft(now, 13))
        now = ieor(now, ishft(now, -7))
        now = ieor(now, ishft(now, 17))
      end associate
    end do
    x = reshape(transfer(bits, x, size(x)), [columns, rows])
    where (abs(x) > huge(x) .or. x /= x) x = 0.1_dp
    x(:, :990) = reshape(spread([(10._dp**(i - 25), i=1, 50)], 2, 99)*spread([(real(i, dp), i=1, 99)], 1, 50), [columns, 990])
    call table%open(path, 'a', error)
    call table%add(-7)
    call table%end_rows(x, error)
    call table%close(error)
    open (newunit=unit, file=path, action='read', status='old', recl=6000)
    read (unit, *)
    read (unit, *) y
    close (unit)
    call check(all(abs(x - y(1:, :)) <= 0), 'a hundred thousand reals of all sizes read back as the same numbers')
    call check(all(nint(y(0, :)) == -7), 'rows written together begin alike')
    call remove_file(path)
  end subroutine check_digits
end module test_table
