! SPDX-License-Identifier: GPL-3.0-or-later
!> GMRES with a right preconditioner (Saad and Schultz 1986), for operators that are applied, not stored.
module hd_krylov
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_system, only: check_stop
  use hd_vector, only: add_columns, length, orthogonalise
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

contains

  !> Solve A x = b from x = 0 without restart. The preconditioner need not be the same linear map every time: its results are kept
  !> (Saad 1993).
  subroutine solve_gmres(op, b, tolerance, most, x, steps, residual, error)
    class(operator_t), intent(inout) :: op            !< operator
    real(dp), intent(in) :: b(:)                      !< right-hand side
    real(dp), intent(in) :: tolerance                 !< of the residual, relative to b
    integer, intent(in) :: most                       !< steps at most
    real(dp), intent(out) :: x(:)                     !< solution
    integer, intent(out) :: steps                     !< steps taken
    real(dp), intent(out) :: residual                 !< reached, relative
    type(error_t), allocatable, intent(out) :: error  !< memory, a stop asked for
    real(dp), allocatable :: v(:, :), kept(:, :)
    real(dp) :: h(most + 1, most), g(most + 1), cosine(most), sine(most), norm, t
    integer :: i, j
    allocate (v(size(b), most + 1), kept(size(b), most))
    x = 0
    steps = 0
    residual = 0
    norm = length(size(b), b)
    if (.not. norm > 0) return
    v(:, 1) = b/norm
    g = 0
    g(1) = norm
    do j = 1, most
      call check_stop(error)
      if (.not. allocated(error)) call op%approximate(v(:, j), kept(:, j), error)
      if (allocated(error)) return
      call op%multiply(kept(:, j), v(:, j + 1))
      call orthogonalise(v(:, :j), v(:, j + 1), h(:j, j), h(j + 1, j))
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
    call add_columns(kept(:, :steps), g(:steps), x)
  end subroutine solve_gmres
end module hd_krylov
