! SPDX-License-Identifier: GPL-3.0-or-later
!> A Newton correction whose residual is checked, whichever solver made it, and refined once where it is poor.
module hd_checked_solve
  use hd_error, only: error_t
  use hd_kinds, only: dp
  use hd_linear_solver, only: linear_solver_t
  use hd_mortar, only: add_nodal_forces, relative_displacement
  use hd_problem, only: problem_t, apply_stiffness, largest_stiffness
  implicit none
  private
  public :: solve_checked

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
    call remainder(du, dtraction, residual)
    if (.not. residual > refine_above) return
    call solver%solve(problem, left_u, left_c, more_u, more_c, error)
    if (allocated(error)) return
    more_u = more_u + du
    more_c = more_c + dtraction
    call remainder(more_u, more_c, better)
    if (.not. better < residual) return
    residual = better
    du = more_u
    dtraction = more_c
  contains
    subroutine remainder(v, t, relative)
      real(dp), intent(in) :: v(:, :), t(:, :)
      real(dp), intent(out) :: relative
      real(dp) :: w(3, size(r_c, 2)), f(3, size(r_u, 2))
      integer :: j
      f = 0
      call add_nodal_forces(problem%mortar, t, f)
      left_u = r_u + apply_stiffness(problem, v) - f
      where (problem%fixed) left_u = 0
      w = relative_displacement(problem%mortar, v)
      do j = 1, size(r_c, 2)
        left_c(:, j) = r_c(:, j) + matmul(dw(:, :, j), w(:, j)) + matmul(dt(:, :, j), t(:, j))
      end do
      relative = size_of(left_u, left_c)/max(size_of(merge(0._dp, r_u, problem%fixed), r_c) + &
        largest_stiffness(problem)*norm2(v), tiny(1._dp))
    end subroutine remainder

    pure real(dp) function size_of(u, c)
      real(dp), intent(in) :: u(:, :), c(:, :)
      size_of = sqrt(sum(u**2) + sum((spread(problem%mortar%area, 1, 3)*c)**2))
    end function size_of
  end subroutine solve_checked
end module hd_checked_solve
