! SPDX-License-Identifier: GPL-3.0-or-later
!> A block circulant in the space of harmonics: one symmetric real matrix of amplitudes for each, of which the upper triangle is
!> kept (in blocks of 8 x 8). What couples distant rows of nodes falls exponentially with the harmonic. Blocks at the head of
!> their columns whose entries all obey |a_ij| <= drop sqrt(a_ii a_jj) are left out: scaled by the diagonal, the matrix is off by
!> drop times its order at most.
module hd_harmonic_matrix
  use, intrinsic :: iso_c_binding, only: c_double, c_float, c_int
  use hd_harmonics, only: amplitude
  use hd_kinds, only: dp, pi, sp
  implicit none
  private
  public :: hd_symmetric_product, hd_symmetric_product_single, harmonic_matrix_t, new_harmonic_matrix

  integer, parameter :: block = 8            !< order of the blocks on the diagonal
  integer, parameter :: long_loop = 50000    !< entries from which two threads are worth waking
  !> Harmonics below it keep double precision: bodies bend so softly there that the rounding of a product in single precision
  !> exceeds what sums of all harmonics leave of it.
  integer, parameter :: soft_harmonics = 16

  !> Columns from row top + 1 down to the end of their diagonal block, one behind the other; in single precision from row
  !> short_top + 1.
  type :: skyline_t
    integer(c_int), allocatable :: top(:), short_top(:)   !< rows left out, by block of columns
    real(dp), allocatable :: entry(:)
    real(sp), allocatable :: short(:)
  end type skyline_t

  type :: harmonic_matrix_t
    integer :: n = 0                            !< dofs
    real(dp) :: drop = -1                       !< entries left out, relative; below 0: not kept in double precision
    real(dp) :: short_drop = -1                 !< the same in single precision
    complex(dp), allocatable :: factor(:, :)    !< between dofs of the first sector and amplitudes (dofs, 0:last)
    type(skyline_t), allocatable :: part(:)     !< (0:last)
  contains
    procedure :: set
    procedure :: full
    procedure :: kernel
    procedure :: multiply
    procedure :: multiply_single
  end type harmonic_matrix_t

  interface
    subroutine hd_symmetric_product(most, n, top, a, x, y) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: most, n
      integer(c_int), intent(in) :: top(*)
      real(c_double), intent(in) :: a(*), x(n, 2)
      real(c_double), intent(out) :: y(n, 2)
    end subroutine hd_symmetric_product
    subroutine hd_symmetric_product_single(most, n, top, a, x, y) bind(c)
      import :: c_float, c_int
      integer(c_int), value :: most, n
      integer(c_int), intent(in) :: top(*)
      real(c_float), intent(in) :: a(*), x(n, 2)
      real(c_float), intent(out) :: y(n, 2)
    end subroutine hd_symmetric_product_single
  end interface

contains

  !> Room for matrices between nodes, three dofs each.
  subroutine new_harmonic_matrix(angle, last, matrix, drop, short_drop)
    real(dp), intent(in) :: angle(:)                !< of the nodes of the first sector [rad]
    integer, intent(in) :: last                     !< harmonic
    type(harmonic_matrix_t), intent(out) :: matrix  !< entries not set
    real(dp), intent(in), optional :: drop          !< kept in double precision; entries left out, relative (0: none)
    real(dp), intent(in), optional :: short_drop    !< kept in single precision, for multiply_single
    integer :: c, k
    matrix%n = 3*size(angle)
    if (present(drop)) matrix%drop = drop
    if (present(short_drop)) matrix%short_drop = short_drop
    allocate (matrix%factor(matrix%n, 0:last), matrix%part(0:last))
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
  subroutine set(self, k, a)
    class(harmonic_matrix_t), intent(inout) :: self  !< matrix
    integer, intent(in) :: k                         !< harmonic
    real(dp), intent(in) :: a(:, :)                  !< symmetric (dofs, dofs)
    associate (part => self%part(k))
      if (.not. self%drop < 0) then
        part%top = int(first_rows(a, self%drop), c_int)
        part%entry = packed(a, part%top)
      end if
      if (self%short_drop < 0) return
      part%short_top = int(first_rows(a, self%short_drop), c_int)
      part%short = real(packed(a, part%short_top), sp)
    end associate
  end subroutine set

  !> Columns of a matrix one behind the other.
  pure function packed(a, top) result(entry)
    real(dp), intent(in) :: a(:, :)       !< symmetric (dofs, dofs)
    integer(c_int), intent(in) :: top(:)  !< rows left out, by block of columns
    real(dp), allocatable :: entry(:)
    integer :: at, i, j
    allocate (entry(sum([(block*(block*i - top(i)), i=1, size(top))])), source=0._dp)
    at = 0
    do j = 1, size(a, 1)
      associate (head => top((j + block - 1)/block), m => min(padded(j), size(a, 1)))
        entry(at + 1:at + m - head) = [a(head + 1:j, j), a(j, j + 1:m)]
        at = at + padded(j) - head
      end associate
    end do
  end function packed

  !> Rows left out above every block of columns.
  pure function first_rows(a, drop) result(top)
    real(dp), intent(in) :: a(:, :)  !< symmetric
    real(dp), intent(in) :: drop     !< relative size of what is left out; 0: none
    integer :: top(padded(size(a, 1))/block), i, j
    real(dp) :: scale(size(a, 1))
    top = 0
    if (.not. drop > 0) return
    scale = [(drop*sqrt(a(i, i)), i=1, size(a, 1))]
    do j = 1, size(top)
      associate (columns => a(:, block*j - block + 1:min(block*j, size(a, 1))))
        do i = 1, block*(j - 1)
          if (any(abs(columns(i, :)) > scale(i)*scale(block*j - block + 1:min(block*j, size(a, 1)))/drop)) exit
        end do
      end associate
      top(j) = (i - 1)/block*block
    end do
  end function first_rows

  !> One harmonic with both triangles, without what is left out.
  pure function full(self, k) result(a)
    class(harmonic_matrix_t), intent(in) :: self  !< matrix in double precision
    integer, intent(in) :: k                      !< harmonic
    real(dp) :: a(self%n, self%n)
    integer :: at, head, j
    at = 0
    do j = 1, self%n
      head = self%part(k)%top((j + block - 1)/block)
      a(:head, j) = 0
      a(head + 1:j, j) = self%part(k)%entry(at + 1:at + j - head)
      a(j, :j) = a(:j, j)
      at = at + padded(j) - head
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
  subroutine multiply(self, stride, wave, single)
    class(harmonic_matrix_t), intent(in) :: self  !< matrix in double precision
    integer, intent(in) :: stride                 !< 1 or 2
    complex(dp), intent(inout) :: wave(:, 0:)     !< transform of the field (dofs, harmonics)
    logical, intent(in) :: single                 !< single precision is enough, and there
    real(dp) :: x(padded(self%n), 2), y(padded(self%n), 2)
    real(sp) :: short(padded(self%n), 2)
    integer :: k, n
    n = self%n
    !$omp parallel do schedule(static, 1) private(x, y, short) if(size(wave)*n > long_loop)
    do k = 0, ubound(wave, 2)
      associate (factor => self%factor(:, stride*k), part => self%part(stride*k))
        x(:n, 1) = real(conjg(factor)*wave(:, k))
        x(:n, 2) = aimag(conjg(factor)*wave(:, k))
        x(n + 1:, :) = 0
        if (single .and. stride*k >= soft_harmonics) then
          call hd_symmetric_product_single(0, size(x, 1), part%short_top, part%short, real(x, sp), short)
          y = short
        else
          call hd_symmetric_product(0, size(x, 1), part%top, part%entry, x, y)
        end if
        wave(:, k) = factor*cmplx(y(:n, 1), y(:n, 2), dp)
      end associate
    end do
  end subroutine multiply

  !> The same with a field in single precision too.
  subroutine multiply_single(self, stride, wave)
    class(harmonic_matrix_t), intent(in) :: self  !< matrix in single precision
    integer, intent(in) :: stride                 !< 1 or 2
    complex(sp), intent(inout) :: wave(:, 0:)     !< transform of the field (dofs, harmonics)
    real(sp) :: x(padded(self%n), 2), y(padded(self%n), 2)
    complex(sp) :: factor(self%n)
    integer :: k, n
    n = self%n
    !$omp parallel do schedule(static, 1) private(x, y, factor) if(size(wave)*n > long_loop)
    do k = 0, ubound(wave, 2)
      factor = cmplx(self%factor(:, stride*k), kind=sp)
      x(:n, 1) = real(conjg(factor)*wave(:, k))
      x(:n, 2) = aimag(conjg(factor)*wave(:, k))
      x(n + 1:, :) = 0
      call hd_symmetric_product_single(0, size(x, 1), self%part(stride*k)%short_top, self%part(stride*k)%short, x, y)
      wave(:, k) = factor*cmplx(y(:n, 1), y(:n, 2), sp)
    end do
  end subroutine multiply_single
end module hd_harmonic_matrix
