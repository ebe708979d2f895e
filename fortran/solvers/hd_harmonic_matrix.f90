! SPDX-License-Identifier: GPL-3.0-or-later
!> A block circulant in the space of harmonics: one symmetric real matrix of amplitudes for each, of which the upper triangle is
!> kept (in blocks of 8 x 8).
module hd_harmonic_matrix
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use hd_kinds, only: dp, pi
  use hd_harmonics, only: amplitude
  implicit none
  private
  public :: hd_symmetric_product, harmonic_matrix_t, new_harmonic_matrix

  integer, parameter :: block = 8            !< order of the blocks on the diagonal
  integer, parameter :: long_loop = 200000   !< entries from which two threads are worth waking

  type :: harmonic_matrix_t
    integer :: n = 0                            !< dofs
    complex(dp), allocatable :: factor(:, :)    !< between dofs of the first sector and amplitudes (dofs, 0:last)
    real(dp), allocatable :: entry(:, :)        !< columns down to the end of their diagonal block (entries, 0:last)
  contains
    procedure :: set
    procedure :: full
    procedure :: kernel
    procedure :: multiply
  end type harmonic_matrix_t

  interface
    subroutine hd_symmetric_product(most, n, a, x, y) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: most, n
      real(c_double), intent(in) :: a(*), x(n, 2)
      real(c_double), intent(out) :: y(n, 2)
    end subroutine hd_symmetric_product
  end interface

contains

  !> Room for matrices between nodes, three dofs each.
  subroutine new_harmonic_matrix(angle, last, matrix)
    real(dp), intent(in) :: angle(:)                !< of the nodes of the first sector [rad]
    integer, intent(in) :: last                     !< harmonic
    type(harmonic_matrix_t), intent(out) :: matrix  !< entries not set
    integer :: c, k
    matrix%n = 3*size(angle)
    allocate (matrix%factor(matrix%n, 0:last), matrix%entry(padded(matrix%n)*(padded(matrix%n) + block)/2, 0:last))
    do k = 0, last
      do c = 1, 3
        matrix%factor(c::3, k) = amplitude(k, angle, c)
      end do
    end do
  end subroutine new_harmonic_matrix

  !> Order with blocks filled up.
  elemental integer function padded(n)
    integer, intent(in) :: n  !< order
    padded = (n + block - 1)/block*block
  end function padded

  !> Take over the upper triangle of one harmonic.
  pure subroutine set(self, k, a)
    class(harmonic_matrix_t), intent(inout) :: self  !< matrix
    integer, intent(in) :: k                         !< harmonic
    real(dp), intent(in) :: a(:, :)                  !< symmetric (dofs, dofs)
    integer :: at, j, m
    self%entry(:, k) = 0
    at = 0
    do j = 1, self%n
      m = min(padded(j), self%n)
      self%entry(at + 1:at + m, k) = [a(:j, j), a(j, j + 1:m)]
      at = at + padded(j)
    end do
  end subroutine set

  !> One harmonic with both triangles.
  pure function full(self, k) result(a)
    class(harmonic_matrix_t), intent(in) :: self  !< matrix
    integer, intent(in) :: k                      !< harmonic
    real(dp) :: a(self%n, self%n)
    integer :: at, j
    at = 0
    do j = 1, self%n
      a(:j, j) = self%entry(at + 1:at + j, k)
      a(j, :j) = a(:j, j)
      at = at + padded(j)
    end do
  end function full

  !> Block between two sectors, for fields that repeat `stride` times round the axis.
  pure function kernel(self, stride, sectors, difference) result(a)
    class(harmonic_matrix_t), intent(in) :: self  !< matrix
    integer, intent(in) :: stride                 !< 1 or 2
    integer, intent(in) :: sectors                !< of one repetition
    integer, intent(in) :: difference             !< of the sectors
    real(dp) :: a(self%n, self%n), part(self%n, self%n)
    complex(dp) :: f(self%n), turn
    integer :: j, k
    a = 0
    do k = 0, sectors/2
      part = self%full(stride*k)
      f = self%factor(:, stride*k)
      turn = exp(cmplx(0, 2*pi*k*difference/sectors, dp))*merge(1, 2, k == 0 .or. 2*k == sectors)/sectors
      do j = 1, self%n
        a(:, j) = a(:, j) + part(:, j)*real(f*(conjg(f(j))*turn))
      end do
    end do
  end function kernel

  !> Product with a field given by its harmonics 0, stride, 2 stride, ...
  subroutine multiply(self, stride, wave)
    class(harmonic_matrix_t), intent(in) :: self  !< matrix
    integer, intent(in) :: stride                 !< 1 or 2
    complex(dp), intent(inout) :: wave(:, 0:)     !< transform of the field (dofs, harmonics)
    real(dp) :: x(padded(self%n), 2), y(padded(self%n), 2)
    integer :: k, n
    n = self%n
    !$omp parallel do private(x, y) if(size(wave)*n > long_loop)
    do k = 0, ubound(wave, 2)
      associate (factor => self%factor(:, stride*k))
        x(:n, 1) = real(conjg(factor)*wave(:, k))
        x(:n, 2) = aimag(conjg(factor)*wave(:, k))
        x(n + 1:, :) = 0
        call hd_symmetric_product(0, size(x, 1), self%entry(:, stride*k), x, y)
        wave(:, k) = factor*cmplx(y(:n, 1), y(:n, 2), dp)
      end associate
    end do
  end subroutine multiply
end module hd_harmonic_matrix
