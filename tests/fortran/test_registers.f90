! SPDX-License-Identifier: GPL-3.0-or-later
!> Kernels that are compiled for several widths of vector register.
module test_registers
  use hd_check, only: check
  use hd_harmonic_matrix, only: hd_symmetric_product, hd_symmetric_product_single
  use hd_kinds, only: dp, sp
  use hd_sector_matrix, only: hd_sector_product
  use hd_spread, only: window_rows, window_rows_single, spread_rows, spread_rows_single
  use hd_text, only: to_text
  use hd_total_lagrangian, only: hd_large_strain
  implicit none
  private
  public :: run_registers

  integer, parameter :: widths(3) = [64, 32, 16]

contains

  subroutine run_registers()
    integer :: n
    do n = 8, 40, 16
      call check_symmetric(n)
    end do
    call check_symmetric(520)
    call check_sectors(24, 5)
    call check_cells(8, 9)
    call check_cells(20, 0)
    do n = 4, 28, 4
      call check_spreading(n)
      call check_spreading_single(n)
    end do
  end subroutine run_registers

  !> All widths give the product, those with fused multiply-add the same bits, in double and in single precision, also where the
  !> heads of columns are left out.
  subroutine check_symmetric(n)
    integer, intent(in) :: n    !< order
    real(dp) :: full(n, n), x(n, 2), y(n, 2, 3)
    real(sp) :: short(n, 2, 3)
    real(dp), allocatable :: a(:)
    integer :: j, k, top(n/8)
    call random_number(full)
    call random_number(x)
    full = full + transpose(full)
    top = [(8*(j/3), j=1, n/8)]
    allocate (a(0))
    do j = 1, n
      associate (head => top((j + 7)/8))
        full(:head, j) = 0
        full(j, :head) = 0
        a = [a, full(head + 1:8*((j + 7)/8), j)]
      end associate
    end do
    do k = 1, 3
      call hd_symmetric_product(widths(k), n, top, a, x, y(:, :, k))
      call check(maxval(abs(y(:, :, k) - matmul(full, x))) < 1e-13_dp*n, 'symmetric product of order '//to_text(n)// &
        ' in registers of '//to_text(widths(k))//' bytes')
      call hd_symmetric_product_single(widths(k), n, top, real(a, sp), real(x, sp), short(:, :, k))
      call check(maxval(abs(short(:, :, k) - matmul(full, x))) < 1e-6_dp*n, 'the same in single precision')
    end do
    call check(all(y(:, :, 1) == y(:, :, 2)), 'a symmetric product has the same bits in registers of 64 and 32 bytes')
  end subroutine check_symmetric

  !> The same of a row of sectors.
  subroutine check_sectors(n, blocks)
    integer, intent(in) :: n, blocks    !< sectors, blocks
    real(dp) :: a(3, 3, blocks), v(-1:n, 3, blocks), s(n, 3, 3), expected(n, 3)
    integer :: i, j, k, shift(blocks)
    call random_number(a)
    call random_number(v)
    shift = [(modulo(k, 3) - 1, k=1, blocks)]
    expected = 0
    do k = 1, blocks
      do j = 1, 3
        do i = 1, 3
          expected(:, i) = expected(:, i) + a(i, j, k)*v(shift(k):n - 1 + shift(k), j, k)
        end do
      end do
    end do
    do k = 1, 3
      call hd_sector_product(widths(k), n, blocks, a, [(i, i=1, blocks)], shift, v, s(:, :, k))
      call check(maxval(abs(s(:, :, k) - expected)) < 1e-13_dp*blocks, 'product of sectors in registers of '// &
        to_text(widths(k))//' bytes')
    end do
    call check(all(s(:, :, 1) == s(:, :, 2)), 'a product of sectors has the same bits in registers of 64 and 32 bytes')
  end subroutine check_sectors

  !> Sectors of a cell under large displacements do not know each other: all widths give the same, and equal sectors the same bits.
  subroutine check_cells(nodes, modes)
    integer, intent(in) :: nodes, modes    !< of the cell
    real(dp) :: turn(2, nodes), g(nodes, 3, 8), weight(8), eased(48, modes), pushed(3, nodes, 8, modes), u(8, 3, nodes)
    real(dp) :: stress(8, 48, 3), energy(8, 3), f(8, 3*nodes, 3), k(8, 9*nodes**2, 3)
    integer :: a, i
    call random_number(turn)
    call random_number(g)
    call random_number(weight)
    call random_number(eased)
    call random_number(pushed)
    call random_number(u)
    u(8, :, :) = u(1, :, :)
    energy = 0
    f = 0
    do i = 1, 3
      call hd_large_strain(widths(i), nodes, modes, 1.2_dp, 0.8_dp, turn, g, weight + 1, eased, pushed, [(a, a=1, nodes)], u, &
        stress(:, :, i), energy(:, i), f(:, :, i), k(:, :, i))
      call check(maxval(abs(k(:, :, i) - k(:, :, 1))) < 1e-13_dp*maxval(abs(k)) .and. &
        maxval(abs(f(:, :, i) - f(:, :, 1))) < 1e-13_dp*maxval(abs(f)), 'cells under large displacements in registers of '// &
        to_text(widths(i))//' bytes')
      call check(all(k(8, :, i) == k(1, :, i)) .and. all(stress(8, :, i) == stress(1, :, i)) .and. &
        abs(energy(8, i) - energy(1, i)) < tiny(1._dp), 'equal sectors of a cell have the same bits')
    end do
  end subroutine check_cells

  !> The same of a window's weights and of spreading.
  subroutine check_spreading(width)
    integer, intent(in) :: width                           !< of the window
    integer, parameter :: waves = 5, degree = 6, height = 40, fine_y = 48
    real(dp) :: piece(width, 0:degree), s(waves), weight(width, waves, 3), expected(width, waves)
    complex(dp) :: c(waves), f(height, 0:fine_y - 1, 3), sums(height, 0:fine_y - 1)
    integer :: kx(waves), ky(waves), i, j, k
    call draw(piece, s, c, kx, ky)
    call expect(piece, s, c, kx, ky, expected, sums)
    f = 0
    do k = 1, 3
      call window_rows(widths(k), waves, width, degree, piece, s, weight(:, :, k))
      call check(maxval(abs(weight(:, :, k) - expected)) < 1e-14_dp, 'weights of a window '//to_text(width)//' wide '// &
        'in registers of '//to_text(widths(k))//' bytes')
      call spread_rows(widths(k), waves, width, width, width, fine_y, height, kx, ky, c, weight(:, :, k), &
        weight(:, :, k), f(:, :, k))
      call check(maxval(abs(f(:, :, k) - sums)) < 1e-12_dp, 'waves spread '//to_text(width)//' wide in registers of '// &
        to_text(widths(k))//' bytes')
    end do
    call check(all([((weight(j, i, 1) == weight(j, i, 2), j=1, width), i=1, waves)]) .and. all(f(:, :, 1) == f(:, :, 2)), &
      'spreading has the same bits in registers of 64 and 32 bytes')
  end subroutine check_spreading

  !> The same in single precision.
  subroutine check_spreading_single(width)
    integer, intent(in) :: width                           !< of the window
    integer, parameter :: waves = 5, degree = 6, height = 40, fine_y = 48
    real(dp) :: piece(width, 0:degree), s(waves), expected(width, waves)
    real(sp) :: weight(width, waves, 3)
    complex(dp) :: c(waves), sums(height, 0:fine_y - 1)
    complex(sp) :: f(height, 0:fine_y - 1, 3)
    integer :: kx(waves), ky(waves), k
    call draw(piece, s, c, kx, ky)
    call expect(piece, s, c, kx, ky, expected, sums)
    f = 0
    do k = 1, 3
      call window_rows_single(widths(k), waves, width, degree, real(piece, sp), s, weight(:, :, k))
      call spread_rows_single(widths(k), waves, width, width, width, fine_y, height, kx, ky, cmplx(c, kind=sp), weight(:, :, k), &
        weight(:, :, k), f(:, :, k))
      call check(maxval(abs(weight(:, :, k) - expected)) < 1e-5_dp .and. &
        maxval(abs(cmplx(f(:, :, k), kind=dp) - sums)) < 1e-5_dp*maxval(abs(sums)), &
        'single waves spread '//to_text(width)//' wide in registers of '//to_text(widths(k))//' bytes')
    end do
    call check(all(weight(:, :, 1) == weight(:, :, 2)) .and. all(f(:, :, 1) == f(:, :, 2)), &
      'single spreading has the same bits in registers of 64 and 32 bytes')
  end subroutine check_spreading_single

  !> Random pieces of a window, waves and places.
  subroutine draw(piece, s, c, kx, ky)
    real(dp), intent(out) :: piece(:, 0:), s(:)    !< pieces, places in [-1, 1]
    complex(dp), intent(out) :: c(:)               !< waves
    integer, intent(out) :: kx(:), ky(:)           !< first fine points
    real(dp) :: part(size(c), 2)
    call random_number(piece)
    call random_number(s)
    call random_number(part)
    s = 2*s - 1
    c = cmplx(part(:, 1), part(:, 2), dp)
    kx = int(10*part(:, 1))
    ky = int(47*part(:, 2))
  end subroutine draw

  !> Weights and fine points, term by term.
  subroutine expect(piece, s, c, kx, ky, weight, f)
    real(dp), intent(in) :: piece(:, 0:), s(:)     !< pieces, places
    complex(dp), intent(in) :: c(:)                !< waves
    integer, intent(in) :: kx(:), ky(:)            !< first fine points
    real(dp), intent(out) :: weight(:, :)          !< weights
    complex(dp), intent(out) :: f(:, 0:)           !< fine points
    integer :: i, j, k, q
    weight = 0
    f = 0
    do k = 1, size(c)
      do i = 0, ubound(piece, 2)
        weight(:, k) = weight(:, k) + piece(:, i)*s(k)**i
      end do
      do j = 1, size(weight, 1)
        q = modulo(ky(k) + j - 1, size(f, 2))
        do i = 1, size(weight, 1)
          f(kx(k) + i, q) = f(kx(k) + i, q) + c(k)*weight(i, k)*weight(j, k)
        end do
      end do
    end do
  end subroutine expect
end module test_registers
