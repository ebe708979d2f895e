! SPDX-License-Identifier: GPL-3.0-or-later
!> The transposed of Newton's equations: what a result changes by per unit of every residual. The solver of the equations solves
!> them too, with another law at each multiplier. With tau = -R_w^T rho and w = R_t^T rho - g,
!>
!>   K lambda - B^T a tau = g_u,    (B lambda + g_t/a, tau) in the range of (R_t^T, -R_w^T)   or   W (B lambda + g_t/a) + T tau = 0,
!>
!> where the rows of (W, T) span what that range leaves. The result's change is  -lambda . dr_u - a rho . dr_c.
module hd_adjoint
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_linear_solver, only: linear_solver_t
  use hd_mortar, only: add_nodal_forces, relative_displacement
  use hd_problem, only: problem_t, state_t, load_t, apply_stiffness
  use hd_symmetry, only: symmetry_t, symmetrise
  implicit none
  private
  public :: adjoint_t, begin_adjoint

  type :: adjoint_t
    real(dp) :: scale = 1                              !< of the law [Pa/m]
    real(dp), allocatable :: w(:, :, :), t(:, :, :)    !< its rows (3, 3, multipliers), for a solver's update [Pa/m]
    real(dp), allocatable :: back(:, :, :)             !< rho from w and tau over the scale (3, 6, multipliers)
  contains
    procedure :: take => take_law
    procedure :: solve => solve_adjoint
  end type adjoint_t

contains

  !> Begin with a state whose matrix meets many right-hand sides.
  subroutine begin_adjoint(solver, sides, problem, load, state, error)
    class(linear_solver_t), intent(inout) :: solver   !< of the run
    integer, intent(in) :: sides                      !< how many
    type(problem_t), intent(in) :: problem            !< of the run
    type(load_t), intent(in) :: load                  !< load
    type(state_t), intent(in) :: state                !< state
    type(error_t), allocatable, intent(out) :: error  !< linear solver
    real(dp), parameter :: accuracy = 1e-9_dp
    call solver%begin(problem, load, state, error)
    solver%sides = sides
    solver%accuracy = accuracy
  end subroutine begin_adjoint

  !> Transpose a law.
  pure subroutine take_law(self, scale, dw, dt)
    class(adjoint_t), intent(inout) :: self   !< gets the law
    real(dp), intent(in) :: scale             !< its scale [Pa/m]
    real(dp), intent(in) :: dw(:, :, :)       !< R_w (3, 3, multipliers) [Pa/m]
    real(dp), intent(in) :: dt(:, :, :)       !< R_t (3, 3, multipliers)
    real(dp) :: a(6, 3), q(6, 6), b(3, 2), p(3, 3), rows(3, 6)
    integer :: i, j
    self%scale = scale
    self%w = dw
    self%t = dt
    if (allocated(self%back)) deallocate (self%back)
    allocate (self%back(3, 6, size(dw, 3)), source=0._dp)
    do j = 1, size(dw, 3)
      if (.not. any(abs(dw(:, :, j)) > 0)) then  ! no traction but what is given: R_t is 1
        do i = 1, 3
          self%back(i, i, j) = 1
        end do
        cycle
      end if
      a(:3, :) = transpose(dt(:, :, j))
      a(4:, :) = -transpose(dw(:, :, j))/scale
      call reflect(a, q)
      do i = 3, 1, -1
        self%back(i, :, j) = (q(:, i) - matmul(transpose(self%back(i + 1:, :, j)), a(i, i + 1:)))/a(i, i)
      end do
      b = transpose(q(2:3, 4:))  ! the first row sees no slip, as that of every law
      call reflect(b, p)
      rows = transpose(matmul(q(:, 4:), p(:, [3, 1, 2])))
      self%w(:, :, j) = scale*rows(:, :3)
      self%t(:, :, j) = rows(:, 4:)
      self%w(1, 2:, j) = 0
    end do
  end subroutine take_law

  !> Householder's reflections: A = Q R.
  pure subroutine reflect(a, q)
    real(dp), intent(inout) :: a(:, :)   !< matrix of more rows than columns, then R above zeros
    real(dp), intent(out) :: q(:, :)     !< orthonormal
    real(dp) :: v(size(a, 1)), size_of
    integer :: i, k
    q = 0
    do i = 1, size(a, 1)
      q(i, i) = 1
    end do
    do k = 1, size(a, 2)
      v = 0
      v(k:) = a(k:, k)
      size_of = norm2(v)
      if (.not. size_of > 0) cycle
      v(k) = v(k) + sign(size_of, v(k))
      v = v/norm2(v)
      do i = 1, size(a, 2)
        a(:, i) = a(:, i) - 2*dot_product(v, a(:, i))*v
      end do
      do i = 1, size(a, 1)
        q(i, :) = q(i, :) - 2*dot_product(q(i, :), v)*v
      end do
    end do
  end subroutine reflect

  !> Solve for some results. The slip of a step ends what it was when the step began: `later` is the tau along the face that the
  !> next step asks of this one. Where the load step has a symmetry that all residuals share, the solver uses it, and of a result
  !> only the mean over its images counts: a derivative by what breaks the symmetry is that of both directions together.
  subroutine solve_adjoint(self, problem, solver, by_u, by_t, later, twice, lambda, rho, error)
    class(adjoint_t), intent(in) :: self              !< law, which the solver has
    type(problem_t), intent(in) :: problem            !< problem
    class(linear_solver_t), intent(inout) :: solver   !< factorised
    real(dp), intent(inout) :: by_u(:, :, :)          !< derivatives of the results by displacements (3, n, results); their means
    real(dp), intent(in) :: by_t(:, :, :)             !< and tractions (3, multipliers, results) [1/Pa]
    real(dp), intent(inout) :: later(:, :, :)         !< tau of the next step, then of this one (2, multipliers, results)
    logical, intent(in) :: twice(:)                   !< refined: a solver may let a wheel's balance be by a hair (results)
    real(dp), intent(out) :: lambda(:, :, :)          !< by out-of-balance forces (3, n, results)
    real(dp), intent(out) :: rho(:, :, :)             !< by residuals of the law, area included (3, multipliers, results)
    type(error_t), allocatable, intent(out) :: error  !< solver
    real(dp), dimension(3, size(by_t, 2), size(by_t, 3)) :: r, w, tau
    real(dp) :: more(3, size(by_t, 2))
    real(dp), allocatable :: left_u(:, :), more_u(:, :)
    integer :: j, k
    w = by_t
    do k = 1, size(w, 3)
      if (solver%symmetry%order() > 1) then
        call symmetrise(problem, solver%symmetry, by_u(:, :, k))
        more(1, :) = 0
        more(2:, :) = later(:, :, k)
        w(:, :, k) = mean_of(problem, solver%symmetry, w(:, :, k))
        more = mean_of(problem, solver%symmetry, more)
        later(:, :, k) = more(2:, :)
      end if
      do j = 1, size(r, 2)
        w(:, j, k) = w(:, j, k)/max(problem%mortar%area(j), tiny(1._dp))
        r(:, j, k) = matmul(self%w(:, :, j), w(:, j, k)) + matmul(self%t(:, 2:, j), later(:, j, k))
      end do
    end do
    call solver%solve_all(problem, -by_u, r, lambda, tau, error)
    if (allocated(error)) return
    allocate (left_u(3, size(by_u, 2)), more_u(3, size(by_u, 2)))
    do k = 1, size(w, 3)
      if (twice(k)) then
        call apply_stiffness(problem, lambda(:, :, k), left_u)
        left_u = left_u - by_u(:, :, k)
        call add_nodal_forces(problem%mortar, tau(:, :, k), left_u, factor=-1._dp)
        more = relative_displacement(problem%mortar, lambda(:, :, k))
        do j = 1, size(r, 2)
          r(:, j, k) = r(:, j, k) + matmul(self%w(:, :, j), more(:, j)) + matmul(self%t(:, :, j), tau(:, j, k))
        end do
        call solver%solve(problem, left_u, r(:, :, k), more_u, more, error)
        if (allocated(error)) return
        lambda(:, :, k) = lambda(:, :, k) + more_u
        tau(:, :, k) = tau(:, :, k) + more
      end if
      tau(2:, :, k) = tau(2:, :, k) + later(:, :, k)
      w(:, :, k) = w(:, :, k) + relative_displacement(problem%mortar, lambda(:, :, k))
      do j = 1, size(r, 2)
        rho(:, j, k) = problem%mortar%area(j)*(matmul(self%back(:, :3, j), w(:, j, k)) + &
          matmul(self%back(:, 4:, j), tau(:, j, k)/self%scale))
      end do
      call leave_free(problem, lambda(:, :, k))
    end do
    later = tau(2:, :, :)
  end subroutine solve_adjoint

  !> Nothing moves fixed dofs, but a wheel that turns.
  pure subroutine leave_free(problem, u)
    type(problem_t), intent(in) :: problem  !< problem
    real(dp), intent(inout) :: u(:, :)      !< (3, n)
    real(dp) :: turn
    turn = 0
    if (problem%wheel_turns) turn = u(2, problem%wheel(1))
    where (problem%fixed) u = 0
    if (problem%wheel_turns) u(2, problem%wheel) = turn
  end subroutine leave_free

  !> Mean of a field of the multipliers over its images.
  function mean_of(problem, symmetry, t) result(mean)
    type(problem_t), intent(in) :: problem    !< problem
    type(symmetry_t), intent(in) :: symmetry  !< of the load step
    real(dp), intent(in) :: t(:, :)           !< (3, multipliers)
    real(dp) :: mean(3, size(t, 2)), field(3, problem%n)
    field = 0
    field(:, problem%mortar%node) = t
    call symmetrise(problem, symmetry, field)
    mean = field(:, problem%mortar%node)
  end function mean_of
end module hd_adjoint
