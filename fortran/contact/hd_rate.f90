! SPDX-License-Identifier: GPL-3.0-or-later
!> First change of a contact problem from a converged state under a small further load: linear but for points that turn from
!> slip to stick, which are found in a few solves.
module hd_rate
  use hd_kinds, only: dp
  use hd_checked_solve, only: solve_refined
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_mortar, only: relative_displacement
  use hd_newton, only: idle_components
  use hd_problem, only: problem_t
  use hd_rate_law, only: rate_point_t, rate_rows, next_state
  implicit none
  private
  public :: respond_by_rates

  integer, parameter :: most = 12             !< solves
  real(dp), parameter :: accuracy = 1e-6_dp   !< relative, of inner iterations
  real(dp), parameter :: of_work = 1e-5_dp    !< relative, of the work of the further load

contains

  !> Change of displacements per unit of load. The solver has begun this load and state.
  subroutine respond_by_rates(problem, solver, force, friction, points, du, settled, error)
    type(problem_t), intent(in) :: problem               !< problem, its tangent that of the state
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    real(dp), intent(in) :: force(:, :)                  !< nodal forces of the further load (3, n)
    real(dp), intent(in) :: friction                     !< mu
    type(rate_point_t), intent(inout) :: points(:)       !< points in their first states, then in the states found
    real(dp), intent(out) :: du(:, :)                    !< change (3, n)
    logical, intent(out) :: settled                      !< the states found are those assumed, the solution is accurate
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    type(rate_point_t) :: next
    real(dp), dimension(3, 3, size(points)) :: dw, dt
    real(dp), dimension(3, size(points)) :: traction, w
    logical :: idle(3, size(points)), accurate, same
    integer :: c, i, j, k, newtons
    idle = idle_components(problem)
    newtons = solver%inner   ! its inner steps are counted for Newton's method alone
    du = 0
    traction = 0
    solver%accuracy = accuracy
    do k = 1, most
      do j = 1, size(points)
        call rate_rows(points(j), friction, problem%law%scale, dw(:, :, j), dt(:, :, j))
        do c = 1, 3
          if (.not. idle(c, j)) cycle
          dw(c, :, j) = 0
          dt(c, :, j) = [(merge(1, 0, i == c), i=1, 3)]
        end do
      end do
      call solver%update(problem, dw, dt, error)
      if (.not. allocated(error)) call solve_refined(problem, solver, dw, dt, force, of_work, du, traction, accurate, error)
      solver%inner = newtons
      if (allocated(error)) return
      w = relative_displacement(problem%mortar, du)
      same = .true.
      do j = 1, size(points)
        next = next_state(points(j), friction, w(2:, j), traction(:, j))
        same = same .and. next%state == points(j)%state .and. (next%grows .eqv. points(j)%grows)
        points(j) = next
      end do
      settled = same .and. accurate
      if (same) return
    end do
  end subroutine respond_by_rates
end module hd_rate
