! SPDX-License-Identifier: GPL-3.0-or-later
!> FFTW adapter: scaling, signs and layouts against the defining sums.
module test_fft
  use hd_check, only: check, check_close
  use hd_error, only: error_t
  use hd_fft, only: execute_rows, forward_real, backward_real, forward_real_2d, backward_real_2d, free_rows, plan_rows, &
    rows_plan_t, smooth_size
  use hd_kinds, only: dp, pi
  implicit none
  private
  public :: run_fft

contains

  subroutine run_fft()
    integer, parameter :: nx = 9, ny = 6
    real(dp) :: a(nx, ny), b(nx, ny)
    complex(dp) :: s(nx / 2 + 1, ny)
    type(error_t), allocatable :: error
    integer :: i, j, k
    complex(dp) :: sum_1, sum_2
    do j = 1, ny
      do i = 1, nx
        a(i, j) = sin(1.7_dp * i + 0.3_dp * j * j) + 0.1_dp * i
      end do
    end do
    sum_1 = 0
    sum_2 = 0
    do i = 1, nx
      sum_1 = sum_1 + a(i, 4) * exp(cmplx(0, -2 * pi * 2 * (i - 1) / nx, dp))
      do k = 1, ny
        sum_2 = sum_2 + a(i, k) * exp(cmplx(0, -2 * pi * (2 * (i - 1) / real(nx, dp) + 3 * (k - 1) / real(ny, dp)), dp))
      end do
    end do
    call forward_real(a, s, error)
    call check_close(abs(s(3, 4) - sum_1), 0._dp, 1e-13_dp, 'forward_real transforms columns with exp(-i)')
    call backward_real(s, b, error)
    call check_close(maxval(abs(b / nx - a)), 0._dp, 1e-14_dp, 'backward_real inverts it up to the factor n')
    call forward_real_2d(a, s, error)
    call check_close(abs(s(3, 4) - sum_2), 0._dp, 1e-13_dp, 'forward_real_2d is the double sum')
    call backward_real_2d(s, b, error)
    call check_close(maxval(abs(b / (nx * ny) - a)), 0._dp, 1e-14_dp, 'backward_real_2d inverts it up to nx ny')
    call check(smooth_size(7, .false.) == 8 .and. smooth_size(31, .true.) == 32 .and. smooth_size(25, .true.) == 30, &
      'smooth sizes are products of 2, 3 and 5, even if asked')
    call check_rows(35)
    call check_rows(32)
  end subroutine run_fft

  !> Rows that threads share in parts, the last one shorter or not.
  subroutine check_rows(count)
    integer, intent(in) :: count
    integer, parameter :: n = 1000
    type(rows_plan_t) :: forward, backward
    type(error_t), allocatable :: error
    real(dp), allocatable :: a(:, :), b(:, :), turned(:, :)
    complex(dp), allocatable :: s(:, :), columns(:, :)
    integer :: i, j
    allocate (a(count, n), b(count, n), s(count, n/2 + 1), columns(n/2 + 1, count))
    a = reshape([((sin(0.7_dp*i*j), i=1, count), j=1, n)], [count, n])
    b = a
    call plan_rows(n, count, b, s, forward, backward, error)
    call execute_rows(forward, n, b, s, .true.)
    turned = transpose(a)
    call forward_real(turned, columns, error)
    call check_close(maxval(abs(transpose(columns) - s)), 0._dp, 1e-11_dp, 'transforms of rows are those of columns')
    call execute_rows(backward, n, b, s, .false.)
    call check_close(maxval(abs(b/n - a)), 0._dp, 1e-13_dp, 'and go back')
    call free_rows(forward)
    call free_rows(backward)
  end subroutine check_rows
end module test_fft
