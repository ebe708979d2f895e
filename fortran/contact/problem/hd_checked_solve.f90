! SPDX-License-Identifier: GPL-3.0-or-later
!> Solutions whose residual is checked, whichever solver made them: a Newton correction is refined once where it is poor, the answer
!> to a further load until its work is right.
module hd_checked_solve
  use hd_error, only: error_t
  use hd_kinds, only: dp
  use hd_linear_solver, only: linear_solver_t
  use hd_mortar, only: add_nodal_forces, relative_displacement
  use hd_problem, only: problem_t, apply_stiffness, largest_stiffness
  implicit none
  private
  public :: solve_checked, solve_refined

  real(dp), parameter :: refine_above = 1e-4_dp  !< backward error from which a correction is refined

contains

  !> Correction for given residuals, and its backward error: what it leaves in the equations it should solve over the size of
  !> matrix times solution (a body that slides has large terms and small sums).
  subroutine solve_checked(problem, solver, dw, dt, r_u, r_c, du, dtraction, residual, error)
    type(problem_t), intent(in) :: problem               !< problem
    class(linear_solver_t), intent(inout) :: solver      !< factorised solver
    real(dp), intent(in) :: dw(:, :, :), dt(:, :, :)     !< derivatives of the law
    real(dp), intent(in) :: r_u(:, :)                    !< out-of-balance forces (3, n) [N]
    real(dp), intent(in) :: r_c(:, :)                    !< residuals of the law (3, multipliers) [Pa]
    real(dp), intent(out) :: du(:, :)                    !< correction (3, n) [m]
    real(dp), intent(out) :: dtraction(:, :)             !< correction (3, multipliers) [Pa]
    real(dp), intent(out) :: residual                    !< backward error
    type(error_t), allocatable, intent(out) :: error     !< solver failure
    real(dp) :: left_u(3, size(r_u, 2)), left_c(3, size(r_c, 2)), more_u(3, size(r_u, 2)), more_c(3, size(r_c, 2)), better
    call solver%solve(problem, r_u, r_c, du, dtraction, error)
    if (allocated(error)) return
    call find_remainder(problem, dw, dt, r_u, r_c, du, dtraction, left_u, left_c, residual)
    if (.not. residual > refine_above) return
    call solver%solve(problem, left_u, left_c, more_u, more_c, error)
    if (allocated(error)) return
    more_u = more_u + du
    more_c = more_c + dtraction
    call find_remainder(problem, dw, dt, r_u, r_c, more_u, more_c, left_u, left_c, better)
    if (.not. better < residual) return
    residual = better
    du = more_u
    dtraction = more_c
  end subroutine solve_checked

  !> Solution under nodal forces, refined until what it leaves in the equations would do little work beside these forces. A body on
  !> springs that are soft beside the contact turns far under the forces alone: a small part of that turn, which an iterative
  !> solver may leave, can exceed all that the contact gives way.
  subroutine solve_refined(problem, solver, dw, dt, force, accuracy, most, du, dtraction, accurate, error)
    type(problem_t), intent(in) :: problem               !< problem
    class(linear_solver_t), intent(inout) :: solver      !< factorised solver
    real(dp), intent(in) :: dw(:, :, :), dt(:, :, :)     !< derivatives of the law
    real(dp), intent(in) :: force(:, :)                  !< nodal forces (3, n) [N]
    real(dp), intent(in) :: accuracy                     !< of their work, relative
    integer, intent(in) :: most                          !< solves at most
    real(dp), intent(inout) :: du(:, :)                  !< first guess, then displacements (3, n) [m]
    real(dp), intent(inout) :: dtraction(:, :)           !< first guess, then tractions (3, multipliers) [Pa]
    logical, intent(out) :: accurate                     !< the accuracy is reached
    type(error_t), allocatable, intent(out) :: error     !< solver failure
    real(dp), dimension(3, size(du, 2)) :: left_u, more_u
    real(dp), dimension(3, size(dtraction, 2)) :: left_c, more_c, none
    real(dp) :: residual, work
    integer :: i
    none = 0
    left_u = -force  ! a wheel that turns is loaded there too
    left_c = 0
    if (any(abs(du) > 0)) call find_remainder(problem, dw, dt, -force, none, du, dtraction, left_u, left_c, residual)
    do i = 1, most
      call solver%solve(problem, left_u, left_c, more_u, more_c, error)
      if (allocated(error)) return
      du = du + more_u
      dtraction = dtraction + more_c
      call find_remainder(problem, dw, dt, -force, none, du, dtraction, left_u, left_c, residual)
      work = sum(abs(du*left_u)) + sum(spread(problem%mortar%area, 1, 3)*abs(dtraction*left_c))/problem%law%scale
      accurate = work <= accuracy*abs(sum(force*du))
      if (accurate) return
    end do
  end subroutine solve_refined

  !> What a solution leaves in the equations, and its backward error.
  subroutine find_remainder(problem, dw, dt, r_u, r_c, du, dtraction, left_u, left_c, relative)
    type(problem_t), intent(in) :: problem               !< problem
    real(dp), intent(in) :: dw(:, :, :), dt(:, :, :)     !< derivatives of the law
    real(dp), intent(in) :: r_u(:, :)                    !< out-of-balance forces (3, n) [N]
    real(dp), intent(in) :: r_c(:, :)                    !< residuals of the law (3, multipliers) [Pa]
    real(dp), intent(in) :: du(:, :)                     !< solution (3, n) [m]
    real(dp), intent(in) :: dtraction(:, :)              !< solution (3, multipliers) [Pa]
    real(dp), intent(out) :: left_u(:, :), left_c(:, :)  !< what remains of r_u and r_c
    real(dp), intent(out) :: relative                    !< backward error
    real(dp) :: w(3, size(r_c, 2)), f(3, size(r_u, 2))
    integer :: j
    f = 0
    call add_nodal_forces(problem%mortar, dtraction, f)
    left_u = r_u + apply_stiffness(problem, du) - f
    where (problem%fixed) left_u = 0
    w = relative_displacement(problem%mortar, du)
    do j = 1, size(r_c, 2)
      left_c(:, j) = r_c(:, j) + matmul(dw(:, :, j), w(:, j)) + matmul(dt(:, :, j), dtraction(:, j))
    end do
    relative = size_of(left_u, left_c)/max(size_of(merge(0._dp, r_u, problem%fixed), r_c) + &
      largest_stiffness(problem)*norm2(du), tiny(1._dp))
  contains
    pure real(dp) function size_of(u, c)
      real(dp), intent(in) :: u(:, :), c(:, :)
      size_of = sqrt(sum(u**2) + sum((spread(problem%mortar%area, 1, 3)*c)**2))
    end function size_of
  end subroutine find_remainder
end module hd_checked_solve
