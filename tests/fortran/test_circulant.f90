! SPDX-License-Identifier: GPL-3.0-or-later
module test_circulant
  use hd_check, only: check, check_close
  use hd_circulant, only: circulant_t
  use hd_circulant_side, only: circulant_side_t, plan_side, fill_kernel, add_response, add_side_column, release_side
  use hd_error, only: error_t
  use hd_harmonic_matrix, only: harmonic_matrix_t, new_harmonic_matrix
  use hd_kinds, only: dp, sp
  implicit none
  private
  public :: run_circulant

contains

  subroutine run_circulant()
    integer :: nodes
    do nodes = 1, 6
      call products(nodes)
    end do
    call short_products(.false., 1e-6_dp)
    call short_products(.true., 1e-3_dp)
    call mixed_products()
    call one_side(1)
    call one_side(2)
    call fringe(1)
    call fringe(2)
  end subroutine run_circulant

  !> Around one closed point of a face that repeats `stride` times stand two layers of open points. All take values, and a layer of
  !> constant values takes the same part of it at each of its points.
  subroutine fringe(stride)
    integer, intent(in) :: stride
    integer, parameter :: rows = 5, sectors = 16
    type(circulant_t) :: face
    integer, allocatable :: at(:), from(:)
    real(dp), allocatable :: weight(:)
    real(dp) :: value(rows*sectors), expected(rows*sectors)
    logical :: closed(rows*sectors)
    integer :: e, j, away
    allocate (face%sides(1))
    face%sides(1)%sectors = sectors
    face%stride = stride
    face%rows = rows
    face%row = [(modulo(j - 1, rows) + 1, j=1, rows*sectors)]
    face%sector = [((j - 1)/rows, j=1, rows*sectors)]
    allocate (face%beside(2, rows))
    face%beside(1, :) = [0, 1, 2, 3, 4]
    face%beside(2, :) = [2, 3, 4, 5, 0]
    closed = face%row == 3 .and. face%sector == 0
    call face%surround(closed, at, from, weight)
    value = merge(1._dp, 0._dp, closed)
    do e = 1, size(at)
      value(at(e)) = value(at(e)) + weight(e)*value(from(e))
    end do
    do j = 1, rows*sectors
      away = abs(face%row(j) - 3) + min(face%sector(j), modulo(-face%sector(j), sectors/stride))
      expected(j) = merge(1._dp, 0._dp, away == 0)
      if (away == 1) expected(j) = 0.7_dp
      if (away == 2) expected(j) = 0.35_dp
      if (face%sector(j) >= sectors/stride) expected(j) = 0
    end do
    call check_close(maxval(abs(value - expected)), 0._dp, 1e-15_dp, 'values fade out over two layers beyond the closed points')
  end subroutine fringe

  !> Symmetric positive matrix.
  function some_matrix(n, k) result(a)
    integer, intent(in) :: n, k
    real(dp) :: a(n, n)
    integer :: i, j
    do j = 1, n
      do i = 1, n
        a(i, j) = cos(1.3_dp*(i + j) + 0.7_dp*(k*i*j)) + merge(2*n, 0, i == j)
      end do
    end do
  end function some_matrix

  !> What is kept is the whole matrix, and multiplies as it does.
  subroutine products(nodes)
    integer, intent(in) :: nodes
    type(harmonic_matrix_t) :: matrix
    complex(dp) :: wave(3*nodes, 0:2), expected(3*nodes, 0:2)
    real(dp) :: angle(nodes)
    integer :: i, k
    angle = [(0.1_dp*i, i=1, nodes)]
    call new_harmonic_matrix(angle, 4, matrix, drop=0._dp)
    do k = 0, 4
      call matrix%set(k, some_matrix(3*nodes, k))
    end do
    call check_close(maxval(abs(matrix%full(3) - some_matrix(3*nodes, 3))), 0._dp, 0._dp, 'one triangle holds the whole matrix')
    do k = 0, 2
      wave(:, k) = [(cmplx(sin(i + 2._dp*k), cos(3._dp*i - k), dp), i=1, 3*nodes)]
      associate (factor => matrix%factor(:, 2*k))
        expected(:, k) = factor*matmul(some_matrix(3*nodes, 2*k), conjg(factor)*wave(:, k))
      end associate
    end do
    call matrix%multiply(2, wave, single=.false.)
    call check_close(maxval(abs(wave - expected)), 0._dp, 1e-12_dp, 'products by harmonics are those of the whole matrices')
  end subroutine products

  !> Of coefficients that fall with the distance those beyond a bound are left out, and the product is off by no more than the bound
  !> times the order; in single precision by its rounding.
  subroutine short_products(single, drop)
    logical, intent(in) :: single
    real(dp), intent(in) :: drop
    integer, parameter :: nodes = 24
    type(harmonic_matrix_t) :: matrix
    real(dp) :: a(3*nodes, 3*nodes), x(3*nodes), y(3*nodes)
    complex(sp) :: few(3*nodes, 0:0)
    complex(dp) :: wave(3*nodes, 0:0)
    integer :: i, j
    a = reshape([((exp(-abs(i - j)/2._dp)*sqrt(1._dp*i*j), i=1, 3*nodes), j=1, 3*nodes)], shape(a))
    x = [(cos(2._dp*i)/sqrt(1._dp*i), i=1, 3*nodes)]
    if (single) then
      call new_harmonic_matrix([(0._dp, i=1, nodes)], 0, matrix, short_drop=drop)
    else
      call new_harmonic_matrix([(0._dp, i=1, nodes)], 0, matrix, drop=drop)
    end if
    call matrix%set(0, a)
    wave(:, 0) = x*matrix%factor(:, 0)
    few = cmplx(wave, kind=sp)
    if (single) then
      call matrix%multiply_single(1, few)
      wave = cmplx(few, kind=dp)
    else
      call matrix%multiply(1, wave, single=.false.)
      call check(sum(matrix%part(0)%top) > 0, 'distant coefficients are left out')
    end if
    y = real(wave(:, 0)*conjg(matrix%factor(:, 0))) - matmul(a, x)
    y = y/sqrt([(1._dp*i, i=1, 3*nodes)])
    call check(norm2(y) <= (3*nodes*drop + merge(1e-5_dp, 1e-13_dp, single))*norm2(x*sqrt([(1._dp*i, i=1, 3*nodes)])), &
      'products without distant coefficients obey their bound')
    call check(norm2(y) > 0.01_dp*drop*norm2(x*sqrt([(1._dp*i, i=1, 3*nodes)])), 'and something was left out')
  end subroutine short_products

  !> Where single precision is enough, soft harmonics get the product of double precision and the others the rounded one.
  subroutine mixed_products()
    integer, parameter :: nodes = 4, last = 20
    type(harmonic_matrix_t) :: matrix
    complex(dp), dimension(3*nodes, 0:last) :: exact, mixed
    real(dp) :: off(0:last)
    integer :: i, k
    call new_harmonic_matrix([(0.1_dp*i, i=1, nodes)], last, matrix, drop=0._dp, short_drop=0._dp)
    do k = 0, last
      call matrix%set(k, some_matrix(3*nodes, k))
      exact(:, k) = [(cmplx(sin(i + 2._dp*k), cos(3._dp*i - k), dp), i=1, 3*nodes)]
    end do
    mixed = exact
    call matrix%multiply(1, exact, single=.false.)
    call matrix%multiply(1, mixed, single=.true.)
    off = [(maxval(abs(mixed(:, k) - exact(:, k)))/maxval(abs(exact(:, k))), k=0, last)]
    call check(.not. any(off(:15) > 0), 'harmonics below 16 keep double precision')
    call check(all(off(16:) > 0) .and. all(off(16:) < 1e-5_dp), 'the others are rounded to single precision')
  end subroutine mixed_products

  !> Response by FFT, columns and blocks of multipliers that meet nodes of two sectors are those of one matrix.
  subroutine one_side(stride)
    integer, intent(in) :: stride
    integer, parameter :: n = 8, m = 2   !< sectors, nodes of each
    type(circulant_side_t) :: side
    type(error_t), allocatable :: error
    real(dp) :: f(3, n), w(3, n), column(3, 3, n), expected(3, n)
    integer :: j, k
    side%sectors = n
    side%ptr = [(2*j - 1, j=1, n + 1)]
    side%row = [(1, 2, j=1, n)]
    side%sector = [(j - 1, modulo(j, n), j=1, n)]
    side%val = [(0.7_dp, 0.3_dp, j=1, n)]
    side%angle = [0._dp, 0.2_dp]
    call new_harmonic_matrix(side%angle, n/2, side%hat, drop=0._dp)
    do k = 0, n/2
      call side%hat%set(k, some_matrix(3*m, k))
    end do
    call plan_side(side, stride, [(j <= n/stride, j=1, n)], error)
    call fill_kernel(side, stride, error)
    expected = 0
    do j = 1, n
      f(:, j) = [sin(1._dp*modulo(j, n/stride)), 0.5_dp, cos(2._dp*modulo(j, n/stride))]
    end do
    do j = 1, n/stride
      column = 0
      call add_side_column(side, j, [1._dp, 1._dp, 1._dp], [(k, k=1, n)], column)
      do k = 1, n
        expected(:, k) = expected(:, k) + matmul(column(:, :, k), f(:, j))
      end do
      call check_close(maxval(abs(column(:, :, j) - side%own(:, :, j))), 0._dp, 1e-12_dp, &
        'the block of a multiplier is that of its column')
    end do
    call add_response(side, stride, .false., .false., f, w)
    call check_close(maxval(abs(w - expected)), 0._dp, 1e-12_dp, 'columns add up to the response')
    call add_response(side, stride, .false., .true., f, w)
    call check_close(maxval(abs(w - 2*expected)), 0._dp, 1e-12_dp, 'which adds to what is there')
    call release_side(side)
  end subroutine one_side
end module test_circulant
