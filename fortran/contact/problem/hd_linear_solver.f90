! SPDX-License-Identifier: GPL-3.0-or-later
!> What Newton's method needs of a linear solver; two kinds exist: the sparse Newton matrix, and condensation to the face.
module hd_linear_solver
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_problem, only: problem_t, load_t, state_t
  use hd_symmetry, only: symmetry_t
  implicit none
  private
  public :: linear_solver_t

  type, abstract :: linear_solver_t
    character(len=64) :: name = ''             !< for log and summary
    integer :: unknowns = 0                    !< size of the system that is factorised
    integer(int64) :: factor_entries = 0       !< entries of its factors
    real(dp) :: flops = 0                      !< operations of the last factorisation
    logical :: own_threads = .false.           !< runs its harmonics in parallel; BLAS gets one thread
    real(dp) :: accuracy = 1e-9_dp             !< relative residual of a correction that an inner iteration may leave
    real(dp) :: backward = -1                  !< backward error of the last correction, -1: not known
    integer :: inner = 0                       !< steps of an inner iteration so far
    logical :: goes_on = .false.               !< the load step that begins is the last one, between other pairs
    integer :: sides = 1                       !< right-hand sides that a matrix is expected to meet
    integer :: most_images = 4                 !< images of the part that is solved, at most: 1, 2 or 4
    type(symmetry_t) :: symmetry               !< used in this load step
    logical :: demanded = .false.              !< fewer in the next load step are an error
    character(len=8) :: symmetry_used = 'full' !< full, half or quarter, in the present load step
    character(len=40) :: ordering_asked = 'none', ordering_used = 'none'
    character(len=16) :: library = ''          !< version of the library behind it
  contains
    procedure :: begin => begin_linear
    procedure(update_linear), deferred :: update
    procedure(solve_linear), deferred :: solve
    procedure :: solve_all => solve_one_by_one
    procedure(release_linear), deferred :: release
  end type linear_solver_t

  abstract interface
    !> Enter the derivatives of the contact law and factorise.
    subroutine update_linear(self, problem, dw, dt, error)
      import :: linear_solver_t, problem_t, dp, error_t
      class(linear_solver_t), intent(inout) :: self     !< solver
      type(problem_t), intent(in) :: problem            !< problem
      real(dp), intent(in) :: dw(:, :, :)               !< dR/dw (3, 3, multipliers) [Pa/m]
      real(dp), intent(in) :: dt(:, :, :)               !< dR/dt (3, 3, multipliers)
      type(error_t), allocatable, intent(out) :: error  !< singular, out of memory
    end subroutine update_linear

    !> Newton correction: K du - B^T a dtraction = -r_u,  dR/dw B du + dR/dt dtraction = -r_c.
    subroutine solve_linear(self, problem, r_u, r_c, du, dtraction, error)
      import :: linear_solver_t, problem_t, dp, error_t
      class(linear_solver_t), intent(inout) :: self     !< factorised solver
      type(problem_t), intent(in) :: problem            !< problem
      real(dp), intent(in) :: r_u(:, :)                 !< out-of-balance forces (3, n) [N]
      real(dp), intent(in) :: r_c(:, :)                 !< residuals of the law (3, multipliers) [Pa]
      real(dp), intent(out) :: du(:, :)                 !< correction of the displacements (3, n) [m]
      real(dp), intent(out) :: dtraction(:, :)          !< correction of the tractions (3, multipliers) [Pa]
      type(error_t), allocatable, intent(out) :: error  !< solver failure
    end subroutine solve_linear

    !> Give back all memory.
    subroutine release_linear(self)
      import :: linear_solver_t
      class(linear_solver_t), intent(inout) :: self     !< solver
    end subroutine release_linear
  end interface

contains

  !> A load step begins; solvers that use its symmetry look at it.
  subroutine begin_linear(self, problem, load, state, error)
    class(linear_solver_t), intent(inout) :: self     !< solver
    type(problem_t), intent(in) :: problem            !< problem
    type(load_t), intent(in) :: load                  !< load at the end of the step
    type(state_t), intent(in) :: state                !< state at its beginning
    type(error_t), allocatable, intent(out) :: error  !< symmetry asked for is not there
    if (allocated(error) .or. problem%n + size(load%gap) + size(state%gap) == 0) return
    self%symmetry_used = 'full'
    if (self%demanded) call raise(error, code_input, "solver.symmetry asks for a part of the scene, which exact factors do "// &
      "not use; valid: 'auto'")
  end subroutine begin_linear

  !> Corrections for several residuals.
  subroutine solve_one_by_one(self, problem, r_u, r_c, du, dtraction, error)
    class(linear_solver_t), intent(inout) :: self     !< factorised solver
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: r_u(:, :, :)              !< out-of-balance forces (3, n, sides) [N]
    real(dp), intent(in) :: r_c(:, :, :)              !< residuals of the law (3, multipliers, sides) [Pa]
    real(dp), intent(out) :: du(:, :, :)              !< corrections of the displacements (3, n, sides) [m]
    real(dp), intent(out) :: dtraction(:, :, :)       !< corrections of the tractions (3, multipliers, sides) [Pa]
    type(error_t), allocatable, intent(out) :: error  !< solver failure
    integer :: k
    do k = 1, size(r_u, 3)
      call self%solve(problem, r_u(:, :, k), r_c(:, :, k), du(:, :, k), dtraction(:, :, k), error)
      if (allocated(error)) return
    end do
  end subroutine solve_one_by_one
end module hd_linear_solver
