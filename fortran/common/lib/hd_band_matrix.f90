! SPDX-License-Identifier: GPL-3.0-or-later
!> Symmetric positive definite band matrices A = U^T U, upper storage of LAPACK: u(kd + 1 + i - j, j) = a(i, j). With a leading
!> dimension of kd, every rectangle inside the band is a matrix as BLAS knows it.
module hd_band_matrix
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_linear_solver
  use hd_lapack, only: dgemm, dtrsm
  implicit none
  private
  public :: factorise_band, solve_band, part_of_inverse

  integer, parameter :: most_columns = 32  !< of a block

  interface
    subroutine hd_solve_band(n, kd, u, x) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: n, kd
      real(c_double), intent(in) :: u(kd + 1, n)
      real(c_double), intent(inout) :: x(n, 2)
    end subroutine hd_solve_band
    subroutine hd_solve_band_octet(n, kd, u, x) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: n, kd
      real(c_double), intent(in) :: u(kd + 1, n)
      real(c_double), intent(inout) :: x(8, n)
    end subroutine hd_solve_band_octet
    subroutine dpbtrf(uplo, n, kd, ab, ldab, info)
      import :: dp
      character(len=1), intent(in) :: uplo
      integer, intent(in) :: n, kd, ldab
      real(dp), intent(inout) :: ab(ldab, *)
      integer, intent(out) :: info
    end subroutine dpbtrf
    subroutine dgemv(trans, m, n, alpha, a, lda, x, incx, beta, y, incy)
      import :: dp
      character(len=1), intent(in) :: trans
      integer, intent(in) :: m, n, lda, incx, incy
      real(dp), intent(in) :: alpha, a(lda, *), x(*), beta
      real(dp), intent(inout) :: y(*)
    end subroutine dgemv
  end interface

contains

  !> Cholesky factor in place.
  subroutine factorise_band(u, error)
    real(dp), intent(inout), contiguous :: u(:, :)      !< band, then factor (kd + 1, n)
    type(error_t), allocatable, intent(out) :: error    !< not positive definite
    integer :: info
    call dpbtrf('U', size(u, 2), size(u, 1) - 1, u, size(u, 1), info)
    if (info > 0) call raise(error, code_linear_solver, &
      'the stiffness matrix is singular: a body is not held; check supports, contact and units of lengths')
  end subroutine factorise_band

  !> Solve for two right-hand sides or more in place.
  subroutine solve_band(u, x)
    real(dp), intent(in), contiguous :: u(:, :)     !< factor (kd + 1, n)
    real(dp), intent(inout), contiguous :: x(:, :)  !< right-hand sides, then solutions (n, 2 or more)
    real(dp) :: octet(8, size(u, 2))
    integer :: first, last
    if (size(x, 2) == 2) then
      call hd_solve_band(int(size(u, 2), c_int), int(size(u, 1) - 1, c_int), u, x)
      return
    end if
    do first = 1, size(x, 2), 8
      last = min(first + 7, size(x, 2))
      octet(last - first + 2:, :) = 0
      octet(:last - first + 1, :) = transpose(x(:, first:last))
      call hd_solve_band_octet(int(size(u, 2), c_int), int(size(u, 1) - 1, c_int), u, octet)
      x(:, first:last) = transpose(octet(:last - first + 1, :))
    end do
  end subroutine solve_band

  !> Entries of A^-1 between some rows.
  subroutine part_of_inverse(u, rows, part)
    real(dp), intent(in), contiguous :: u(:, :)  !< factor (kd + 1, n), kd > 0
    integer, intent(in) :: rows(:)               !< ascending
    real(dp), intent(out) :: part(:, :)          !< (rows, rows)
    real(dp), allocatable :: x(:, :)
    integer :: i
    if (size(rows) == 0) return
    allocate (x(size(rows), rows(1):size(u, 2)))
    call follow(size(rows), rows(1), size(u, 2), size(u, 1) - 1, u, rows, x)
    do i = 1, size(rows)
      part(:i, i) = x(:i, rows(i))
      part(i, :i) = part(:i, i)
    end do
  end subroutine part_of_inverse

  !> Rows of A^-1 from their diagonal on. As rows, many of them go through BLAS at once, a block of columns after the other; those
  !> that begin further right are left out.
  subroutine follow(m, first, n, kd, u, rows, x)
    integer, intent(in) :: m, first, n, kd
    real(dp), intent(in) :: u(kd + 1, n)      !< factor
    integer, intent(in) :: rows(m)            !< ascending from first
    real(dp), intent(out) :: x(m, first:n)    !< rows of A^-1; entries left of the diagonal mean nothing
    integer :: c, far, i, j, last, near, width
    width = min(kd, most_columns)
    x = 0
    do i = 1, m
      x(i, rows(i)) = 1
    end do
    do j = first, n, width                               ! x U^-1
      last = min(n, j + width - 1)
      c = count(rows <= last)
      near = max(first, last - kd)                       ! columns near:j - 1 are in the band of the whole block
      if (near < j) call dgemm('N', 'N', c, last - j + 1, j - near, -1._dp, x(1, near), m, u(kd + 1 + near - j, j), kd, &
        1._dp, x(1, j), m)
      do i = j, last - 1
        far = max(first, i - kd)
        if (far < near) call dgemv('N', c, near - far, -1._dp, x(1, far), m, u(kd + 1 + far - i, i), 1, 1._dp, x(1, i), 1)
      end do
      call dtrsm('R', 'U', 'N', 'N', c, last - j + 1, 1._dp, u(kd + 1, j), kd, x(1, j), m)
    end do
    do j = first + (n - first)/width*width, first, -width  ! x U^-T
      last = min(n, j + width - 1)
      c = count(rows <= last)
      near = min(n, j + kd)
      if (near > last) call dgemm('N', 'T', c, last - j + 1, near - last, -1._dp, x(1, last + 1), m, u(kd + j - last, last + 1), &
        kd, 1._dp, x(1, j), m)
      do i = j + 1, last
        far = min(n, i + kd)
        if (far > near) call dgemv('N', c, far - near, -1._dp, x(1, near + 1), m, u(kd + i - near, near + 1), kd, &
          1._dp, x(1, i), 1)
      end do
      call dtrsm('R', 'U', 'T', 'N', c, last - j + 1, 1._dp, u(kd + 1, j), kd, x(1, j), m)
    end do
  end subroutine follow
end module hd_band_matrix
