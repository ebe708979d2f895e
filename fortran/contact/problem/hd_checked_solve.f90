! SPDX-License-Identifier: GPL-3.0-or-later
!> Solutions whose residual is checked, whichever solver made them: a Newton correction is refined once where it is poor, but for
!> one of GMRES, which is as good as was asked; the answer to a further load until its work is right.
module hd_checked_solve
  use hd_error, only: error_t
  use hd_kinds, only: dp
  use hd_linear_solver, only: linear_solver_t
  use hd_mortar, only: add_nodal_forces, relative_displacement
  use hd_problem, only: problem_t, apply_stiffness, largest_stiffness
  use hd_vector, only: add, dot, length, many, set, weighted_length
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
    real(dp), allocatable :: left_u(:, :), left_c(:, :), more_u(:, :), more_c(:, :)
    real(dp) :: better
    call solver%solve(problem, r_u, r_c, du, dtraction, error)
    if (allocated(error)) return
    residual = solver%backward
    if (residual >= 0) return  ! solved as accurately as was asked
    allocate (left_u, mold=r_u)
    allocate (left_c, mold=r_c)
    call find_remainder(problem, dw, dt, r_u, r_c, du, dtraction, left_u, left_c, residual)
    if (.not. residual > refine_above) return
    allocate (more_u, mold=r_u)
    allocate (more_c, mold=r_c)
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
    real(dp), dimension(3, size(du, 2)) :: left_u, more_u, against
    real(dp), dimension(3, size(dtraction, 2)) :: left_c, more_c, none
    real(dp) :: residual
    integer :: i
    none = 0
    left_c = 0
    call set(size(force), -1._dp, force, against)  ! a wheel that turns is loaded there too
    call set(size(force), -1._dp, force, left_u)
    if (length(size(du), du) > 0) call find_remainder(problem, dw, dt, against, none, du, dtraction, left_u, left_c, residual)
    do i = 1, most
      call solver%solve(problem, left_u, left_c, more_u, more_c, error)
      if (allocated(error)) return
      call add(size(du), 1._dp, more_u, du)
      dtraction = dtraction + more_c
      call find_remainder(problem, dw, dt, against, none, du, dtraction, left_u, left_c, residual)
      accurate = dot(size(du), du, left_u, amounts=.true.) + &
        sum(problem%mortar%area*sum(abs(dtraction*left_c), 1))/problem%law%scale <= accuracy*abs(dot(size(du), force, du))
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
    real(dp) :: w(3, size(r_c, 2)), loaded(3, size(r_u, 2))
    real(dp) :: given
    integer :: i, j, n
    n = size(r_u)
    call apply_stiffness(problem, du, left_u)
    call add_nodal_forces(problem%mortar, dtraction, left_u, factor=-1._dp)
    w = relative_displacement(problem%mortar, du)
    !$omp parallel if(n > many)
    !$omp do schedule(static)
    do i = 1, size(r_u, 2)
      loaded(:, i) = merge(0._dp, r_u(:, i), problem%fixed(:, i))
      left_u(:, i) = merge(0._dp, r_u(:, i) + left_u(:, i), problem%fixed(:, i))
    end do
    !$omp end do
    !$omp do schedule(static)
    do j = 1, size(r_c, 2)
      left_c(:, j) = r_c(:, j) + matmul(dw(:, :, j), w(:, j)) + matmul(dt(:, :, j), dtraction(:, j))
    end do
    !$omp end do
    !$omp end parallel
    given = hypot(length(n, loaded), weighted_length(problem%mortar%area, r_c))
    relative = hypot(length(n, left_u), weighted_length(problem%mortar%area, left_c))/ &
      max(given + largest_stiffness(problem)*length(n, du), tiny(1._dp))
  end subroutine find_remainder
end module hd_checked_solve
