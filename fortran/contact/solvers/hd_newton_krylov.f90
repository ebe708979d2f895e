! SPDX-License-Identifier: GPL-3.0-or-later
!> Newton's equations by GMRES around the round, undeformed bodies by harmonics. The matrix itself is only applied. Where GMRES
!> stalls, the exact factors of hd_newton_matrix take over for the rest of the run. Round bodies keep struts where they stood
!> at rest.
!>
!> A wall of thickness t that large displacements have turned by an angle a resists a wave of length l by its membrane too, by a
!> share of some (a l/t)^2 of its bending. So the preconditioner turns with it: the compliance C becomes T C T^T with the turns T of
!> the nodes, and the contact law refers to the turned faces.
module hd_newton_krylov
  use hd_kinds, only: dp
  use hd_error, only: error_t, code_linear_solver
  use hd_krylov, only: operator_t, solve_gmres
  use hd_linear_solver, only: linear_solver_t
  use hd_log, only: say, detail
  use hd_mortar, only: add_nodal_forces, moved_share, relative_displacement
  use hd_newton_matrix, only: newton_matrix_t, lay_out_newton_matrix
  use hd_problem, only: problem_t, load_t, state_t, apply_stiffness, largest_stiffness
  use hd_symmetry, only: sharing_t, share_law, symmetrise, same_shape
  use hd_text, only: to_text
  use hd_total_lagrangian, only: nodal_turns, unity
  use hd_vector, only: length
  implicit none
  private
  public :: newton_krylov_t, new_newton_krylov

  integer, parameter :: most_steps = 40          !< of GMRES, then it starts again from what it found,
  integer, parameter :: most_starts = 3          !< so often,
  real(dp), parameter :: falls = 0.3_dp          !< where each start leaves less than this share of the residual
  real(dp), parameter :: per_digit = 2           !< steps expected for a tenth of the residual: 1 to 3 in drives
  real(dp), parameter :: stalled = 1e-3_dp       !< relative residual after them from which exact factors take over

  !> Share of their weights by which pairs may have moved beside those of the preconditioner, about the way over a facet's length.
  real(dp), parameter :: beside = 0.25_dp

  type, extends(linear_solver_t) :: newton_krylov_t
    class(linear_solver_t), allocatable :: near        !< the preconditioner: condensed bodies
    type(problem_t), allocatable :: round              !< round bodies with the same nodes, where `near` needs them
    type(newton_matrix_t), allocatable :: exact        !< takes over where GMRES stalls
    real(dp), allocatable :: dw(:, :, :), dt(:, :, :)  !< derivatives of the law, as symmetric as the load step
    type(sharing_t) :: sharing                         !< points whose law counts for others
    real(dp), allocatable :: turn(:, :, :)             !< T, if displacements may be large (3, 3, n)
    real(dp), allocatable :: frame(:, :, :)            !< from the turned face to the frame of each multiplier (3, 3, multipliers)
  contains
    procedure :: begin => begin_newton_krylov
    procedure :: update => update_newton_krylov
    procedure :: solve => solve_newton_krylov
    procedure :: release => release_newton_krylov
  end type newton_krylov_t

  !> Newton's matrix between corrections and residuals, both as (3 n + 3 multipliers), forces in N.
  type, extends(operator_t) :: newton_operator_t
    type(problem_t), pointer :: problem => null(), round => null()
    class(newton_krylov_t), pointer :: solver => null()
  contains
    procedure :: multiply => multiply_newton
    procedure :: approximate => approximate_newton
  end type newton_operator_t

contains

  !> Put GMRES around a solver.
  subroutine new_newton_krylov(near, solver)
    class(linear_solver_t), allocatable, intent(inout) :: near  !< moved away
    type(newton_krylov_t), intent(inout) :: solver              !< new; `round` may be set
    call move_alloc(near, solver%near)
    solver%name = 'GMRES, '//trim(solver%near%name)
    solver%unknowns = solver%near%unknowns
    solver%own_threads = solver%near%own_threads
  end subroutine new_newton_krylov

  !> A load step begins.
  subroutine begin_newton_krylov(self, problem, load, state, error)
    class(newton_krylov_t), intent(inout) :: self     !< solver
    type(problem_t), intent(in) :: problem            !< problem
    type(load_t), intent(in) :: load                  !< load at the end of the step
    type(state_t), intent(in) :: state                !< state at its beginning
    type(error_t), allocatable, intent(out) :: error  !< symmetry asked for is not there, memory
    if (allocated(self%exact)) return
    if (allocated(self%turn) .and. .not. self%goes_on) deallocate (self%turn)
    self%near%most_images = self%most_images
    self%near%demanded = self%demanded
    if (allocated(self%round)) then
      call follow_pairs(self%round, problem)
      call self%near%begin(self%round, load, state, error)
    else
      call self%near%begin(problem, load, state, error)
    end if
    self%demanded = self%near%demanded
    self%symmetry_used = self%near%symmetry_used
    if (allocated(self%round)) then
      call share_law(self%round, self%near%symmetry, self%sharing)
      if (same_shape(self%round, problem, self%near%symmetry)) return
      self%sharing = sharing_t()
      self%near%most_images = 1
      call self%near%begin(self%round, load, state, error)
      self%symmetry_used = self%near%symmetry_used
    else
      call share_law(problem, self%near%symmetry, self%sharing)
    end if
  end subroutine begin_newton_krylov

  !> Keep the derivatives, factorise the preconditioner.
  subroutine update_newton_krylov(self, problem, dw, dt, error)
    class(newton_krylov_t), intent(inout) :: self     !< solver
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: dw(:, :, :)               !< dR/dw (3, 3, multipliers) [Pa/m]
    real(dp), intent(in) :: dt(:, :, :)               !< dR/dt (3, 3, multipliers)
    type(error_t), allocatable, intent(out) :: error  !< singular, out of memory
    self%dw = dw
    self%dt = dt
    call self%sharing%take_law(self%dw, self%dt)
    if (.not. allocated(self%exact)) then
      if (allocated(problem%lagrangian)) call turn_along(self, problem)
      if (allocated(self%round)) then
        call follow_pairs(self%round, problem)
        call self%near%update(self%round, in_frames(self%frame, self%dw), in_frames(self%frame, self%dt), error)
      else
        call self%near%update(problem, in_frames(self%frame, self%dw), in_frames(self%frame, self%dt), error)
      end if
      self%factor_entries = self%near%factor_entries
      self%flops = self%near%flops
      if (.not. allocated(error)) return
      if (error%code /= code_linear_solver) return
      deallocate (error)
      call take_exact(self, problem, 'its factors are singular', error)
    else
      call self%exact%update(problem, dw, dt, error)
    end if
  end subroutine update_newton_krylov

  !> Couple the bodies at rest as they are coupled now, if pairs have moved far, and let those struts push that do.
  subroutine follow_pairs(round, problem)
    type(problem_t), intent(inout) :: round  !< bodies at rest
    type(problem_t), intent(in) :: problem   !< the same, deformed
    if (allocated(round%struts)) round%strut_rate = problem%strut_rate
    if (allocated(round%rub)) round%rub = problem%rub
    if (allocated(round%groove)) round%groove = problem%groove
    round%wheel_turns = problem%wheel_turns
    if (round%mortar%serial == problem%mortar%serial) return
    if (moved_share(round%mortar, problem%mortar) <= beside) return
    round%mortar = problem%mortar
    deallocate (round%mortar%turn, round%mortar%carry, round%mortar%offset)
  end subroutine follow_pairs

  !> Rotations of the nodes, once or twice in a load step, and what they leave between faces and multipliers. Nodes that are held
  !> stay, those that are held along the axis turn about it.
  subroutine turn_along(self, problem)
    class(newton_krylov_t), intent(inout) :: self     !< gets turn, frame
    type(problem_t), intent(in) :: problem            !< problem with large displacements
    integer :: b, j
    if (.not. allocated(self%turn)) then
      allocate (self%turn(3, 3, problem%n))
      do b = 1, size(problem%bodies)
        associate (low => problem%first(b) + 1, high => problem%first(b) + problem%bodies(b)%nodes())
          self%turn(:, :, low:high) = nodal_turns(problem%bodies(b), problem%lagrangian(b), problem%tangent_at(:, low:high))
        end associate
      end do
      do j = 1, problem%n
        if (any(problem%fixed(:2, j))) then
          self%turn(:, :, j) = unity
        else if (problem%fixed(3, j)) then
          self%turn(:, :, j) = about_axis(self%turn(:, :, j))
        end if
      end do
    end if
    self%frame = self%turn(:, :, problem%mortar%node)
    if (.not. allocated(problem%mortar%turn)) return
    do j = 1, problem%mortar%n
      self%frame(:, :, j) = matmul(problem%mortar%turn(:, :, j), self%frame(:, :, j))
    end do
  end subroutine turn_along

  !> What a rotation turns about the axis.
  pure function about_axis(turn) result(t)
    real(dp), intent(in) :: turn(3, 3)  !< rotation in the dofs of a node
    real(dp) :: t(3, 3), c(2)
    c = [turn(1, 1) + turn(2, 2), turn(2, 1) - turn(1, 2)]
    c = c/norm2(c)
    t = unity
    t(:2, :2) = reshape([c(1), c(2), -c(2), c(1)], [2, 2])
  end function about_axis

  !> Derivatives by displacements and tractions in the frames of the turned bodies.
  pure function in_frames(frame, d) result(e)
    real(dp), allocatable, intent(in) :: frame(:, :, :)  !< from these frames to the multipliers'; unallocated: the same
    real(dp), intent(in) :: d(:, :, :)                   !< in those of the multipliers (3, 3, multipliers)
    real(dp) :: e(3, 3, size(d, 3))
    integer :: j
    e = d
    if (.not. allocated(frame)) return
    do j = 1, size(d, 3)
      e(:, :, j) = matmul(d(:, :, j), frame(:, :, j))
    end do
  end function in_frames

  !> Factorise the matrix as it is, from here on.
  subroutine take_exact(self, problem, reason, error)
    class(newton_krylov_t), intent(inout) :: self     !< gets exact
    type(problem_t), intent(in) :: problem            !< problem
    character(len=*), intent(in) :: reason            !< for the log
    type(error_t), allocatable, intent(out) :: error  !< singular, out of memory
    call say('solver    '//trim(self%name)//': '//reason//'; exact factors in double precision from here on')
    call self%near%release()
    self%sharing = sharing_t()
    if (allocated(self%round)) deallocate (self%round)
    allocate (self%exact)
    call lay_out_newton_matrix(problem, self%exact, error)
    if (.not. allocated(error)) call self%exact%update(problem, self%dw, self%dt, error)
    self%name = self%exact%name
    self%backward = -1
    self%factor_entries = self%exact%factor_entries
    self%flops = self%exact%flops
    self%symmetry_used = 'full'
  end subroutine take_exact

  !> Newton correction.
  subroutine solve_newton_krylov(self, problem, r_u, r_c, du, dtraction, error)
    class(newton_krylov_t), intent(inout) :: self     !< updated solver
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: r_u(:, :)                 !< out-of-balance forces (3, n) [N]
    real(dp), intent(in) :: r_c(:, :)                 !< residuals of the law (3, multipliers) [Pa]
    real(dp), intent(out) :: du(:, :)                 !< correction of the displacements (3, n) [m]
    real(dp), intent(out) :: dtraction(:, :)          !< correction of the tractions (3, multipliers) [Pa]
    type(error_t), allocatable, intent(out) :: error  !< solver failure
    real(dp) :: residual
    if (.not. allocated(self%exact)) then
      call run_gmres(self, problem, r_u, r_c, du, dtraction, residual, error)
      if (allocated(error) .or. residual <= max(stalled, self%accuracy)) return
      call take_exact(self, problem, 'GMRES stalls at '//to_text(residual), error)
      if (allocated(error)) return
    end if
    call self%exact%solve(problem, r_u, r_c, du, dtraction, error)
  end subroutine solve_newton_krylov

  !> GMRES to the accuracy asked for.
  subroutine run_gmres(self, problem, r_u, r_c, du, dtraction, residual, error)
    class(newton_krylov_t), intent(inout), target :: self     !< updated solver
    type(problem_t), intent(in), target :: problem            !< problem
    real(dp), intent(in) :: r_u(:, :), r_c(:, :)              !< residuals
    real(dp), intent(out) :: du(:, :), dtraction(:, :)        !< correction
    real(dp), intent(out) :: residual                         !< left, relative
    type(error_t), allocatable, intent(out) :: error          !< solver failure
    type(newton_operator_t) :: op
    real(dp), allocatable :: b(:), x(:), dx(:), left(:)
    real(dp) :: norm, share
    integer :: k, steps
    op%problem => problem
    op%round => problem
    if (allocated(self%round)) op%round => self%round
    op%solver => self
    allocate (b(size(r_u) + size(r_c)), x(size(r_u) + size(r_c)))
    du = -r_u
    dtraction = -r_c
    if (allocated(self%sharing%representative)) then
      call symmetrise(op%round, self%near%symmetry, du)
      dtraction = dtraction(:, self%sharing%representative)*self%sharing%sign
    end if
    call pack_residual(problem, du, dtraction, b)
    self%near%sides = nint(max(1._dp, -per_digit*log10(self%accuracy)))
    self%near%accuracy = 1e-3_dp  ! 1e-2 takes twice the steps, 1e-4 no fewer
    allocate (dx(size(b)), left(size(b)))
    x = 0
    left = b
    residual = 1
    do k = 1, most_starts
      call solve_gmres(op, left, self%accuracy/residual, most_steps, dx, steps, share, error)
      if (allocated(error)) return
      x = x + dx
      residual = share*residual
      self%inner = self%inner + steps
      call detail('          GMRES '//to_text(steps)//' steps to '//to_text(residual)//' of '//to_text(self%accuracy))
      if (residual <= max(stalled, self%accuracy) .or. share > falls) exit
      call op%multiply(x, left)
      left = b - left
    end do
    call unpack_correction(x, du, dtraction)
    norm = length(size(b), b)
    self%backward = residual*norm/max(norm + largest_stiffness(problem)*length(size(du), du), tiny(1._dp))
  end subroutine run_gmres

  !> One vector of residuals: forces, and the law times area; nothing at prescribed dofs.
  pure subroutine pack_residual(problem, r_u, r_c, x)
    type(problem_t), intent(in) :: problem         !< problem
    real(dp), intent(in) :: r_u(:, :), r_c(:, :)   !< [N], [Pa]
    real(dp), intent(out) :: x(:)                  !< [N]
    real(dp) :: f(size(r_u, 1), size(r_u, 2))
    integer :: i, j
    f = merge(0._dp, r_u, problem%fixed)
    if (problem%wheel_turns) f(2, problem%wheel) = sum(r_u(2, problem%wheel))/size(problem%wheel)  ! one unknown of its nodes
    x(:size(r_u)) = reshape(f, [size(f)])
    do j = 1, size(r_c, 2)
      i = size(r_u) + 3*j
      x(i - 2:i) = max(problem%mortar%area(j), tiny(1._dp))*r_c(:, j)
    end do
  end subroutine pack_residual

  !> Displacements and tractions of a vector.
  pure subroutine unpack_correction(x, u, t)
    real(dp), intent(in) :: x(:)                       !< vector
    real(dp), intent(out) :: u(:, :), t(:, :)          !< [m], [Pa]
    u = reshape(x(:size(u)), shape(u))
    t = reshape(x(size(u) + 1:), shape(t))
  end subroutine unpack_correction

  !> y = Newton's matrix times x.
  subroutine multiply_newton(self, x, y)
    class(newton_operator_t), intent(inout) :: self  !< operator
    real(dp), intent(in), contiguous :: x(:)         !< correction
    real(dp), intent(out), contiguous :: y(:)        !< residual
    real(dp), allocatable :: u(:, :), t(:, :), f(:, :), w(:, :)
    integer :: j
    associate (p => self%problem, s => self%solver)
      allocate (u(3, p%n), t(3, p%mortar%n), f(3, p%n))
      call unpack_correction(x, u, t)
      call apply_stiffness(p, u, f)
      call add_nodal_forces(p%mortar, t, f, factor=-1._dp)
      w = relative_displacement(p%mortar, u)
      do j = 1, p%mortar%n
        w(:, j) = matmul(s%dw(:, :, j), w(:, j)) + matmul(s%dt(:, :, j), t(:, j))
      end do
      call pack_residual(p, f, w, y)
    end associate
  end subroutine multiply_newton

  !> y near the correction that leaves x.
  subroutine approximate_newton(self, x, y, error)
    class(newton_operator_t), intent(inout) :: self   !< operator
    real(dp), intent(in), contiguous :: x(:)          !< residual
    real(dp), intent(out), contiguous :: y(:)         !< correction
    type(error_t), allocatable, intent(out) :: error  !< solver failure
    real(dp), allocatable :: r_u(:, :), r_c(:, :), u(:, :), t(:, :)
    integer :: i, j
    associate (p => self%problem, s => self%solver)
      allocate (r_u(3, p%n), r_c(3, p%mortar%n), u(3, p%n), t(3, p%mortar%n))
      do j = 1, p%n
        r_u(:, j) = -x(3*j - 2:3*j)
        if (allocated(s%turn)) r_u(:, j) = r_u(1, j)*s%turn(1, :, j) + r_u(2, j)*s%turn(2, :, j) + r_u(3, j)*s%turn(3, :, j)
      end do
      do j = 1, p%mortar%n
        i = 3*(p%n + j)
        r_c(:, j) = -x(i - 2:i)/max(p%mortar%area(j), tiny(1._dp))
      end do
      call s%near%solve(self%round, r_u, r_c, u, t, error)
      do j = 1, p%n
        if (allocated(s%turn)) u(:, j) = s%turn(:, 1, j)*u(1, j) + s%turn(:, 2, j)*u(2, j) + s%turn(:, 3, j)*u(3, j)
        y(3*j - 2:3*j) = u(:, j)
      end do
      do j = 1, p%mortar%n
        i = 3*(p%n + j)
        if (allocated(s%turn)) t(:, j) = matmul(s%frame(:, :, j), t(:, j))
        y(i - 2:i) = t(:, j)
      end do
    end associate
  end subroutine approximate_newton

  !> Give back all memory.
  subroutine release_newton_krylov(self)
    class(newton_krylov_t), intent(inout) :: self  !< solver
    if (allocated(self%near)) call self%near%release()
    if (allocated(self%exact)) call self%exact%release()
  end subroutine release_newton_krylov
end module hd_newton_krylov
