! SPDX-License-Identifier: GPL-3.0-or-later
!> LAPACK and BLAS: products and factorisations of dense matrices.
module hd_lapack
  use, intrinsic :: iso_c_binding, only: c_char, c_int
  use hd_kinds, only: dp, sp
  use hd_error, only: error_t, raise, code_linear_solver
  use hd_text, only: to_text
  implicit none
  private
  public :: dgemm, sgemm, dtrsm, blas_threads, blas_kernels, choose_kernels, multiply_dense, multiply_transposed, solve_dense
  public :: invert_symmetric, inverse_factor, solve_definite

  interface
    !> Let BLAS use n threads from now on; the number before.
    integer(c_int) function c_threads(n) bind(c, name='hd_blas_threads')
      import :: c_int
      integer(c_int), value :: n
    end function c_threads
    !> Let an OpenBLAS older than the processor take kernels with AVX2, unless the environment names some.
    subroutine choose_kernels() bind(c, name='hd_choose_kernels')
    end subroutine choose_kernels
    subroutine c_kernels(text, size) bind(c, name='hd_blas_kernels')
      import :: c_char, c_int
      character(kind=c_char), intent(out) :: text(*)
      integer(c_int), value :: size
    end subroutine c_kernels
    subroutine dgemm(ta, tb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      import :: dp
      character(len=1), intent(in) :: ta, tb
      integer, intent(in) :: m, n, k, lda, ldb, ldc
      real(dp), intent(in) :: alpha, a(lda, *), b(ldb, *), beta
      real(dp), intent(inout) :: c(ldc, *)
    end subroutine dgemm
    subroutine sgemm(ta, tb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      import :: sp
      character(len=1), intent(in) :: ta, tb
      integer, intent(in) :: m, n, k, lda, ldb, ldc
      real(sp), intent(in) :: alpha, a(lda, *), b(ldb, *), beta
      real(sp), intent(inout) :: c(ldc, *)
    end subroutine sgemm
    subroutine dgetrf(m, n, a, lda, pivot, info)
      import :: dp
      integer, intent(in) :: m, n, lda
      real(dp), intent(inout) :: a(lda, *)
      integer, intent(out) :: pivot(*), info
    end subroutine dgetrf
    subroutine dgetrs(trans, n, nrhs, a, lda, pivot, b, ldb, info)
      import :: dp
      character(len=1), intent(in) :: trans
      integer, intent(in) :: n, nrhs, lda, ldb, pivot(*)
      real(dp), intent(in) :: a(lda, *)
      real(dp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dgetrs
    subroutine dpotrf(uplo, n, a, lda, info)
      import :: dp
      character(len=1), intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(dp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotrf
    subroutine dtrtri(uplo, diag, n, a, lda, info)
      import :: dp
      character(len=1), intent(in) :: uplo, diag
      integer, intent(in) :: n, lda
      real(dp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dtrtri
    subroutine dlaswp(n, a, lda, first, last, rows, step)
      import :: dp
      integer, intent(in) :: n, lda, first, last, rows(*), step
      real(dp), intent(inout) :: a(lda, *)
    end subroutine dlaswp
    subroutine dtrsm(side, uplo, trans, diag, m, n, alpha, a, lda, b, ldb)
      import :: dp
      character(len=1), intent(in) :: side, uplo, trans, diag
      integer, intent(in) :: m, n, lda, ldb
      real(dp), intent(in) :: alpha, a(lda, *)
      real(dp), intent(inout) :: b(ldb, *)
    end subroutine dtrsm
    subroutine dposv(uplo, n, nrhs, a, lda, b, ldb, info)
      import :: dp
      character(len=1), intent(in) :: uplo
      integer, intent(in) :: n, nrhs, lda, ldb
      real(dp), intent(inout) :: a(lda, *), b(ldb, *)
      integer, intent(out) :: info
    end subroutine dposv
    subroutine dpotri(uplo, n, a, lda, info)
      import :: dp
      character(len=1), intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(dp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotri
  end interface

  integer, parameter :: large = 500   !< order from which threads share a factorisation
  integer, parameter :: block = 64    !< columns that one of them takes

contains

  !> Let BLAS use n threads from now on; the number before.
  integer function blas_threads(n) result(before)
    integer, intent(in) :: n  !< threads
    before = c_threads(int(n, c_int))
  end function blas_threads

  !> The processor whose kernels BLAS uses; '' where it does not say.
  function blas_kernels() result(name)
    character(len=:), allocatable :: name
    character(len=32) :: text
    call c_kernels(text, len(text, c_int))
    name = trim(text)
  end function blas_kernels

  !> C = A B.
  subroutine multiply_dense(a, b, c)
    real(dp), intent(in), contiguous :: a(:, :), b(:, :)  !< factors (m, k), (k, n)
    real(dp), intent(out), contiguous :: c(:, :)          !< product (m, n)
    call dgemm('N', 'N', size(a, 1), size(b, 2), size(a, 2), 1._dp, a, size(a, 1), b, size(b, 1), 0._dp, c, size(c, 1))
  end subroutine multiply_dense

  !> C = A B^T.
  subroutine multiply_transposed(a, b, c)
    real(dp), intent(in), contiguous :: a(:, :), b(:, :)  !< factors (m, k), (n, k)
    real(dp), intent(out), contiguous :: c(:, :)          !< product (m, n)
    call dgemm('N', 'T', size(a, 1), size(b, 1), size(a, 2), 1._dp, a, size(a, 1), b, size(b, 1), 0._dp, c, size(c, 1))
  end subroutine multiply_transposed

  !> Inverse of a symmetric positive definite matrix of which the upper triangle is given.
  subroutine invert_symmetric(a, error)
    real(dp), intent(inout), contiguous :: a(:, :)    !< matrix, then whole inverse (n, n)
    type(error_t), allocatable, intent(out) :: error  !< not positive definite
    integer :: i, j, info
    call dpotrf('U', size(a, 1), a, size(a, 1), info)
    if (info > 0) then
      call raise(error, code_linear_solver, &
        'the stiffness condensed to the contact is singular: a body is not held; check supports, contact and units '// &
        'of lengths')
      return
    end if
    call dpotri('U', size(a, 1), a, size(a, 1), info)
    do j = 1, size(a, 2)
      do i = j + 1, size(a, 1)
        a(i, j) = a(j, i)
      end do
    end do
  end subroutine invert_symmetric

  !> Inverse of the Cholesky factor of a symmetric matrix of which the lower triangle is given: W A W^T = 1.
  subroutine inverse_factor(a, definite)
    real(dp), intent(inout), contiguous :: a(:, :)    !< matrix, then W in its lower triangle (n, n)
    logical, intent(out) :: definite                  !< the matrix is positive definite, to rounding
    integer :: info
    call dpotrf('L', size(a, 1), a, size(a, 1), info)
    definite = info == 0
    if (definite) call dtrtri('L', 'N', size(a, 1), a, size(a, 1), info)
  end subroutine inverse_factor

  !> Solve A x = b for a symmetric positive definite matrix, which is overwritten.
  subroutine solve_definite(a, b, definite)
    real(dp), intent(inout), contiguous :: a(:, :)    !< matrix (n, n)
    real(dp), intent(inout), contiguous :: b(:)       !< right-hand side, then solution (n)
    logical, intent(out) :: definite                  !< it is positive definite, to rounding
    integer :: info
    call dposv('L', size(a, 1), 1, a, size(a, 1), b, size(b), info)
    definite = info == 0
  end subroutine solve_definite

  !> LU factors. Of a large matrix threads share blocks of columns, the same blocks for any number of them: while one of them
  !> factorises a block, others bring those behind up to date.
  subroutine factorise(n, a, rows, info)
    integer, intent(in) :: n              !< order
    real(dp), intent(inout) :: a(n, n)    !< matrix, then factors
    integer, intent(out) :: rows(n)       !< pivots
    integer, intent(out) :: info          !< unknown that is singular, or 0
    integer :: c, j, part, w
    info = 0
    if (n == 0) return
    if (n < large) then
      call dgetrf(n, n, a, n, rows, info)
      return
    end if
    !$omp parallel
    !$omp single
    do j = 1, n, block
      w = min(block, n + 1 - j)
      !$omp task depend(inout: a(1, j)) firstprivate(j, w) private(part) priority(1)
      call dgetrf(n + 1 - j, w, a(j, j), n, rows(j), part)
      if (part > 0 .and. info == 0) info = part + j - 1
      rows(j:j + w - 1) = rows(j:j + w - 1) + j - 1
      !$omp end task
      do c = 1, n, block
        if (c == j) cycle
        !$omp task depend(in: a(1, j)) depend(inout: a(1, c)) firstprivate(c, j, w)
        call dlaswp(min(block, n + 1 - c), a(1, c), n, j, j + w - 1, rows, 1)
        if (c > j) then
          call dtrsm('L', 'L', 'N', 'U', w, min(block, n + 1 - c), 1._dp, a(j, j), n, a(j, c), n)
          call dgemm('N', 'N', n + 1 - j - w, min(block, n + 1 - c), w, -1._dp, a(j + w, j), n, a(j, c), n, 1._dp, a(j + w, c), n)
        end if
        !$omp end task
      end do
    end do
    !$omp end single
    !$omp end parallel
  end subroutine factorise

  !> Solve A x = b by LU, whose factors overwrite A.
  subroutine solve_dense(a, b, error, pivot)
    real(dp), intent(inout), contiguous :: a(:, :)    !< matrix (n, n), or its factors
    real(dp), intent(inout), contiguous :: b(:, :)    !< right-hand sides, then solutions (n, count)
    type(error_t), allocatable, intent(out) :: error  !< singular
    integer, allocatable, intent(inout), optional :: pivot(:)  !< rows of the factors; unallocated: they are to be made
    integer, allocatable :: rows(:)
    integer :: info, n
    n = size(a, 1)
    info = 0
    if (present(pivot)) call move_alloc(pivot, rows)
    if (.not. allocated(rows)) then
      allocate (rows(n))
      call factorise(n, a, rows, info)
    end if
    if (info == 0 .and. n > 0) call dgetrs('N', n, size(b, 2), a, n, rows, b, n, info)
    if (present(pivot)) call move_alloc(rows, pivot)
    if (info > 0) call raise(error, code_linear_solver, 'the condensed contact matrix is singular at unknown '// &
      to_text(info)//': a body is not held; check supports, contact and units of lengths')
  end subroutine solve_dense
end module hd_lapack
