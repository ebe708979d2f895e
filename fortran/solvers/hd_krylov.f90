! SPDX-License-Identifier: GPL-3.0-or-later
!> GMRES with a right preconditioner (Saad and Schultz 1986), for operators that are applied, not stored.
module hd_krylov
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_lapack, only: add_image, ddot
  use hd_system, only: check_stop
  implicit none
  private
  public :: operator_t, solve_gmres

  type, abstract :: operator_t
  contains
    procedure(apply_operator), deferred :: multiply
    procedure(precondition_operator), deferred :: approximate
  end type operator_t

  abstract interface
    !> y = A x.
    subroutine apply_operator(self, x, y)
      import :: operator_t, dp
      class(operator_t), intent(inout) :: self  !< operator
      real(dp), intent(in) :: x(:)              !< vector
      real(dp), intent(out) :: y(:)             !< product
    end subroutine apply_operator

    !> y close to A^-1 x.
    subroutine precondition_operator(self, x, y, error)
      import :: operator_t, dp, error_t
      class(operator_t), intent(inout) :: self          !< operator
      real(dp), intent(in) :: x(:)                      !< vector
      real(dp), intent(out) :: y(:)                     !< approximation
      type(error_t), allocatable, intent(out) :: error  !< memory
    end subroutine precondition_operator
  end interface

  integer, parameter :: long_vector = 8000  !< from which two threads are worth waking

contains

  !> Solve A x = b from x = 0 without restart. A preconditioner that is not the same linear map every time needs `flexible`
  !> (Saad 1993): its results are kept, twice the memory.
  subroutine solve_gmres(op, b, tolerance, most, x, steps, residual, error, flexible)
    class(operator_t), intent(inout) :: op            !< operator
    real(dp), intent(in) :: b(:)                      !< right-hand side
    real(dp), intent(in) :: tolerance                 !< of the residual, relative to b
    integer, intent(in) :: most                       !< steps at most
    real(dp), intent(out) :: x(:)                     !< solution
    integer, intent(out) :: steps                     !< steps taken
    real(dp), intent(out) :: residual                 !< reached, relative
    type(error_t), allocatable, intent(out) :: error  !< memory, a stop asked for
    logical, intent(in), optional :: flexible         !< keep what the preconditioner made
    real(dp), allocatable :: v(:, :), z(:), kept(:, :)
    real(dp) :: h(most + 1, most), g(most + 1), cosine(most), sine(most), norm, t
    integer :: i, j, n
    allocate (v(size(b), most + 1), z(size(b)), kept(size(b), 0))
    if (present(flexible)) then
      if (flexible) then
        deallocate (kept)
        allocate (kept(size(b), most))
      end if
    end if
    x = 0
    steps = 0
    residual = 0
    n = size(b)
    norm = sqrt(ddot(n, b, 1, b, 1))
    if (.not. norm > 0) return
    v(:, 1) = b/norm
    g = 0
    g(1) = norm
    do j = 1, most
      call check_stop(error)
      if (.not. allocated(error)) call op%approximate(v(:, j), z, error)
      if (allocated(error)) return
      if (size(kept, 2) > 0) kept(:, j) = z
      call op%multiply(z, v(:, j + 1))
      call orthonormalise(v(:, :j + 1), h(:j + 1, j))
      do i = 1, j - 1
        t = cosine(i)*h(i, j) + sine(i)*h(i + 1, j)
        h(i + 1, j) = -sine(i)*h(i, j) + cosine(i)*h(i + 1, j)
        h(i, j) = t
      end do
      t = hypot(h(j, j), h(j + 1, j))
      cosine(j) = h(j, j)/t
      sine(j) = h(j + 1, j)/t
      h(j, j) = t
      g(j + 1) = -sine(j)*g(j)
      g(j) = cosine(j)*g(j)
      steps = j
      residual = abs(g(j + 1))/norm
      if (residual <= tolerance) exit
    end do
    do i = steps, 1, -1
      g(i) = (g(i) - dot_product(h(i, i + 1:steps), g(i + 1:steps)))/h(i, i)
    end do
    if (size(kept, 2) > 0) then
      call add_image(1._dp, kept(:, :steps), g(:steps), x)
    else
      z = 0
      call add_image(1._dp, v(:, :steps), g(:steps), z)
      call op%approximate(z, x, error)
    end if
  end subroutine solve_gmres

  !> Modified Gram-Schmidt of the last column against the others. Halves of the columns run beside each other: the sums are the same
  !> for any number of threads.
  subroutine orthonormalise(v, h)
    real(dp), intent(inout), contiguous :: v(:, :)   !< all but the last orthonormal (n, columns)
    real(dp), intent(out) :: h(:)                    !< parts of the last along the others, and the length that is left (columns)
    real(dp) :: part(2)
    integer :: first(3), half, i, last
    last = size(v, 2)
    first = [1, size(v, 1)/2 + 1, size(v, 1) + 1]
    !$omp parallel private(i) if(size(v, 1) > long_vector)
    do i = 1, last
      !$omp do schedule(static)
      do half = 1, 2
        associate (low => first(half), high => first(half + 1) - 1)
          part(half) = ddot(high - low + 1, v(low:high, i), 1, v(low:high, last), 1)
        end associate
      end do
      !$omp single
      h(i) = merge(sqrt(sum(part)), sum(part), i == last)
      !$omp end single
      !$omp do schedule(static)
      do half = 1, 2
        associate (low => first(half), high => first(half + 1) - 1)
          if (i < last) v(low:high, last) = v(low:high, last) - h(i)*v(low:high, i)
          if (i == last .and. h(i) > 0) v(low:high, last) = v(low:high, last)/h(i)
        end associate
      end do
    end do
    !$omp end parallel
  end subroutine orthonormalise
end module hd_krylov
