! SPDX-License-Identifier: GPL-3.0-or-later
!> First change of a contact problem from a converged state under a small further load: linear but for points that turn from
!> slip to stick or whose shear turns, which are found in a few solves.
!>
!> Neighbours that all turn at once overshoot and would turn back for ever. Where the number of points that turn does not fall,
!> their drives go only half the way, and further halves until a state changes. Points may go on turning in the end if the work by
!> which they miss their law is below the accuracy.
module hd_rate
  use hd_kinds, only: dp
  use hd_checked_solve, only: solve_refined
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_mortar, only: relative_displacement
  use hd_newton, only: idle_components
  use hd_problem, only: problem_t
  use hd_rate_law, only: rate_point_t, rate_rows, rate_drive, asked_state, missed_work, rate_stick, rate_slip
  use hd_vector, only: dot
  implicit none
  private
  public :: respond_by_rates, rate_matrices

  integer, parameter :: most = 24             !< sets of states
  integer, parameter :: halves = 10           !< of the way of the drives, at most
  integer, parameter :: long_loop = 3000      !< points from which two threads are worth waking
  integer, parameter :: refinements = 11      !< solves for the last of them
  real(dp), parameter :: coarse = 1e-3_dp     !< relative accuracy of inner iterations while states are sought,
  real(dp), parameter :: accuracy = 1e-6_dp   !< and of the solution
  real(dp), parameter :: of_work = 1e-7_dp    !< relative, of the work of the further load

contains

  !> Change of displacements per unit of load. The solver has begun this load and state.
  subroutine respond_by_rates(problem, solver, force, friction, points, du, traction, settled, error)
    type(problem_t), intent(in) :: problem               !< problem, its tangent that of the state
    class(linear_solver_t), intent(inout) :: solver      !< its linear solver
    real(dp), intent(in) :: force(:, :)                  !< nodal forces of the further load (3, n)
    real(dp), intent(in) :: friction                     !< mu
    type(rate_point_t), intent(inout) :: points(:)       !< points in their first states, then in the states found
    real(dp), intent(out) :: du(:, :)                    !< change (3, n)
    real(dp), intent(out) :: traction(:, :)              !< change (3, points) [Pa]
    logical, intent(out) :: settled                      !< the states found are those assumed, the solution is accurate
    type(error_t), allocatable, intent(out) :: error     !< linear solver
    type(rate_point_t) :: next(size(points))
    real(dp), dimension(3, 3, size(points)) :: dw, dt
    real(dp) :: w(3, size(points))
    real(dp), dimension(size(points)) :: drive, new
    real(dp) :: missed
    logical :: accurate, last, negligible, idle(3, size(points))
    integer :: before, i, j, k, newtons, turned
    idle = idle_components(problem)
    newtons = solver%inner   ! its inner steps are counted for Newton's method alone
    du = 0
    traction = 0
    last = all(points%state /= rate_stick .and. points%state /= rate_slip)
    do k = 1, most
      solver%accuracy = merge(accuracy, coarse, last .and. k == 1)
      call rate_matrices(problem, idle, friction, points, dw, dt)
      call solver%update(problem, dw, dt, error)
      if (.not. allocated(error)) call solve_refined(problem, solver, dw, dt, force, of_work, merge(refinements, 1, last), du, &
        traction, accurate, error)
      solver%inner = newtons
      if (allocated(error)) return
      w = relative_displacement(problem%mortar, du)
      !$omp parallel do schedule(static) if(size(points) > long_loop)
      do j = 1, size(points)
        new(j) = rate_drive(points(j), friction, problem%law%scale, w(2:, j), traction(:, j))
        next(j) = asked_state(points(j), new(j))
      end do
      !$omp end parallel do
      turned = count(.not. alike(next, points))
      missed = 0
      do j = 1, size(points)
        if (.not. alike(next(j), points(j))) missed = missed + &
          problem%mortar%area(j)*missed_work(next(j), friction, w(2:, j), traction(:, j))
      end do
      negligible = missed <= of_work*abs(dot(size(du), force, du))
      settled = accurate .and. negligible
      if (last .and. (turned == 0 .or. k >= most)) return
      last = last .or. negligible .or. k >= most - 1
      if (k == 1 .or. turned < before) then
        drive = new
      else
        do i = 1, halves
          drive = (drive + new)/2
          if (.not. all(alike(asked_state(points, drive), points))) exit
        end do
      end if
      before = turned
      points = asked_state(points, drive)
    end do
  end subroutine respond_by_rates

  !> Rows of the points in their states.
  subroutine rate_matrices(problem, idle, friction, points, dw, dt)
    type(problem_t), intent(in) :: problem                  !< problem
    logical, intent(in) :: idle(:, :)                       !< its idle components (3, points)
    real(dp), intent(in) :: friction                        !< mu
    type(rate_point_t), intent(in) :: points(:)             !< points
    real(dp), intent(out) :: dw(:, :, :), dt(:, :, :)       !< rows (3, 3, points)
    integer :: c, i, j
    !$omp parallel do schedule(static) private(c, i) if(size(points) > long_loop)
    do j = 1, size(points)
      call rate_rows(points(j), friction, problem%law%scale, dw(:, :, j), dt(:, :, j))
      do c = 1, 3
        if (.not. idle(c, j)) cycle
        dw(c, :, j) = 0
        dt(c, :, j) = [(merge(1, 0, i == c), i=1, 3)]
      end do
    end do
    !$omp end parallel do
  end subroutine rate_matrices

  !> Both states have the same rows.
  elemental logical function alike(a, b)
    type(rate_point_t), intent(in) :: a, b  !< a point in two states
    alike = a%state == b%state .and. (a%grows .eqv. b%grows)
  end function alike
end module hd_rate
