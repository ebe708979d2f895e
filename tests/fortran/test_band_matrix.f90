! SPDX-License-Identifier: GPL-3.0-or-later
module test_band_matrix
  !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
  use hd_band_matrix, only: factorise_band, part_of_inverse, solve_band
  use hd_check, only: check
  use hd_error, only: error_t
  use hd_kinds, only: dp
  use hd_lapack, only: invert_symmetric, solve_dense
  use hd_text, only: to_text
  implicit none
  private
  public :: run_band_matrix

contains

  subroutine run_band_matrix()
    type(error_t), allocatable :: error
    real(dp) :: singular(3, 5)
    call check_size(1, 1)
    call check_size(40, 1)
    call check_size(97, 5)
    call check_size(150, 31)
    call check_size(150, 32)
    call check_size(200, 77)
    call check_size(30, 40)
    call part_of_inverse(singular, [integer ::], singular(:0, :0))
    singular = 1
    call factorise_band(singular, error)
    call check(allocated(error), 'a singular band is refused')
    call check_large(600)
  end subroutine run_band_matrix

  !> A full matrix whose factorisation threads share: the solution, the same bits for any number of them, what is singular.
  subroutine check_large(n)
    integer, intent(in) :: n
    real(dp), allocatable :: a(:, :), b(:, :), factors(:, :), x(:, :), first(:, :)
    type(error_t), allocatable :: error
    integer :: i, j, most, threads
    most = 1
    !$ most = omp_get_max_threads()
    allocate (a(n, n))
    a = reshape([((sin(0.37_dp*i*j + j), i=1, n), j=1, n)], [n, n])
    b = reshape([(cos(1._dp*i), i=1, n)], [n, 1])
    do threads = 1, 3, 2
      !$ call omp_set_num_threads(threads)
      factors = a
      x = b
      call solve_dense(factors, x, error)
      if (threads == 1) first = x
    end do
    !$ call omp_set_num_threads(most)
    call check(all(abs(first - x) <= 0), 'three threads give the bits of one')
    call check(norm2(matmul(a, x) - b) < 1e-9_dp*norm2(a)*norm2(x), 'a large system is solved')
    a(:, n) = 0
    call solve_dense(a, x, error)
    call check(allocated(error), 'a large singular matrix is refused')
  end subroutine check_large

  !> Against the inverse of the full matrix.
  subroutine check_size(n, kd)
    integer, intent(in) :: n, kd
    real(dp) :: u(kd + 1, n), full(n, n), b(n, 10), x(n, 10)
    real(dp), allocatable :: part(:, :)
    integer, allocatable :: rows(:)
    type(error_t), allocatable :: error
    integer :: i, j
    character(len=:), allocatable :: name
    name = to_text(n)//', half width '//to_text(kd)
    call random_number(u)
    u(kd + 1, :) = 2*kd + u(kd + 1, :)
    full = 0
    do j = 1, n
      do i = max(1, j - kd), j
        full(i, j) = u(kd + 1 + i - j, j)
      end do
    end do
    call factorise_band(u, error)
    call check(.not. allocated(error), 'factor of a band of order '//name)
    call invert_symmetric(full, error)
    call random_number(b)
    x = b
    call solve_band(u, x)
    call check(maxval(abs(x - matmul(full, b))) < 1e-12_dp*maxval(abs(x)), 'ten right-hand sides of order '//name)
    x(:, :2) = b(:, :2)
    call solve_band(u, x(:, :2))
    call check(maxval(abs(x - matmul(full, b))) < 1e-12_dp*maxval(abs(x)), 'two right-hand sides of order '//name)
    rows = pack([(i, i=1, n)], [(i == n .or. (2*i > n .and. modulo(i, 3) > 0), i=1, n)])
    allocate (part(size(rows), size(rows)))
    call part_of_inverse(u, rows, part)
    call check(maxval(abs(part - full(rows, rows))) < 1e-12_dp*maxval(abs(full)), 'part of the inverse of order '//name)
  end subroutine check_size
end module test_band_matrix
