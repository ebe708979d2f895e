! SPDX-License-Identifier: GPL-3.0-or-later
!> Newton's linear system condensed to the contact face: the bodies are solved by harmonics once, only tractions of closed
!> contact points remain, in a dense system solved by LU.
!>
!>   [ R_w F a + R_t ] dt = -r_c - R_w B v,   F = B K^-1 B^T,   v = -K^-1 r_u,   du = v + K^-1 B^T a dt
!> F is a circulant: its entries depend on the difference of the sectors. Where the scene repeats after half a turn, so do
!> all iterates, and half of the face is enough.
module hd_condensed
  use, intrinsic :: iso_fortran_env, only: int64
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_harmonics, only: harmonics_t, new_harmonics, solve_body, face_compliance
  use hd_lapack, only: solve_dense
  use hd_linear_solver, only: linear_solver_t
  use hd_mortar, only: add_nodal_forces, relative_displacement
  use hd_problem, only: problem_t
  implicit none
  private
  public :: condensed_t, new_condensed, can_condense

  type, extends(linear_solver_t) :: condensed_t
    type(harmonics_t), allocatable :: bodies(:)     !< factors of both bodies
    real(dp), allocatable :: kernel(:, :, :)        !< relative compliance (3 rows, 3 rows, sector difference) [m/N]
    integer, allocatable :: sector(:), row(:)       !< place of each multiplier: sector from 0, axial row
    integer, allocatable :: at(:, :)                !< multiplier at (row, sector)
    integer :: part = 0                             !< sectors that are solved: all, or half of them
    real(dp), allocatable :: dw(:, :, :), dt(:, :, :)
  contains
    procedure :: update => update_condensed
    procedure :: solve => solve_condensed
    procedure :: release => release_condensed
  end type condensed_t

contains

  !> Condensation by harmonics needs two revolved bodies of linear elements with as many sectors and matching faces.
  pure logical function can_condense(problem) result(yes)
    type(problem_t), intent(in) :: problem  !< problem
    integer :: j
    yes = size(problem%bodies) == 2
    if (.not. yes) return
    yes = all(problem%bodies%revolved) .and. problem%bodies(1)%sectors == problem%bodies(2)%sectors .and. &
      all(problem%bodies%nodes_per_sector*problem%bodies%sectors > 0)
    if (.not. yes) return
    yes = all(problem%mortar%ptr(2:) - problem%mortar%ptr(:problem%mortar%n) == 2)
    do j = 1, problem%mortar%n
      if (.not. yes) return
      yes = all(abs(abs(problem%mortar%val(problem%mortar%ptr(j):problem%mortar%ptr(j) + 1)) - 1) < 1e-10_dp)
    end do
  end function can_condense

  !> Factorise both bodies and form the compliance of the face.
  subroutine new_condensed(problem, half_turn, condensed, error)
    type(problem_t), intent(in) :: problem            !< problem that can_condense
    logical, intent(in) :: half_turn                  !< the scene repeats after half a turn
    type(condensed_t), intent(out) :: condensed       !< solver
    type(error_t), allocatable, intent(out) :: error  !< cannot be condensed, body not held
    real(dp), allocatable :: kernel(:, :, :)
    integer, allocatable :: face(:)
    integer :: b, j, k, n, rows
    if (.not. can_condense(problem)) then
      call raise(error, code_input, "solver.method = 'condensed' needs round bodies with matching meshes; valid: auto, newton")
      return
    end if
    n = problem%bodies(1)%sectors
    condensed%name = 'condensed to the face by harmonics'
    condensed%part = merge(n/2, n, half_turn .and. modulo(n, 2) == 0)
    if (condensed%part < n) condensed%name = trim(condensed%name)//', half'
    call place_multipliers(problem, condensed, rows)
    allocate (condensed%bodies(2))
    do b = 1, 2
      call new_harmonics(problem%bodies(b), condensed%part, problem%fixed(:, problem%first(b) + 1:problem%first(b) + &
        problem%bodies(b)%nodes_per_sector), sector_springs(problem, b), condensed%bodies(b), error)
      if (allocated(error)) return
      allocate (face(rows))
      do k = 1, rows
        j = condensed%at(k, 0)
        face(k) = problem%mortar%node(j)
        if (b == 2) face(k) = partner(problem, j) - problem%first(2)
      end do
      call face_compliance(condensed%bodies(b), face, kernel)
      deallocate (face)
      if (b == 1) condensed%kernel = kernel
      if (b == 2) condensed%kernel = condensed%kernel + kernel
      condensed%factor_entries = condensed%factor_entries + size(condensed%bodies(b)%band, kind=int64)
    end do
    condensed%unknowns = 3*rows*condensed%part
  end subroutine new_condensed

  !> Master node opposite a multiplier.
  pure integer function partner(problem, j)
    type(problem_t), intent(in) :: problem  !< problem with matching faces
    integer, intent(in) :: j                !< multiplier
    associate (col => problem%mortar%col(problem%mortar%ptr(j):problem%mortar%ptr(j) + 1))
      partner = maxval(col)
    end associate
  end function partner

  !> Sector and axial row of every multiplier.
  subroutine place_multipliers(problem, condensed, rows)
    type(problem_t), intent(in) :: problem           !< problem
    type(condensed_t), intent(inout) :: condensed    !< gets sector, row, at
    integer, intent(out) :: rows                     !< multipliers along the axis
    integer, allocatable :: number(:)
    integer :: j, local, m
    m = problem%bodies(1)%nodes_per_sector
    allocate (number(m), source=0)
    condensed%sector = (problem%mortar%node - 1)/m
    rows = 0
    do local = 1, m
      if (.not. any(problem%mortar%node == local)) cycle
      rows = rows + 1
      number(local) = rows
    end do
    condensed%row = number(modulo(problem%mortar%node - 1, m) + 1)
    allocate (condensed%at(rows, 0:problem%bodies(1)%sectors - 1))
    do j = 1, problem%mortar%n
      condensed%at(condensed%row(j), condensed%sector(j)) = j
    end do
  end subroutine place_multipliers

  !> Springs to the ground in the first sector of a body.
  pure function sector_springs(problem, b) result(rate)
    type(problem_t), intent(in) :: problem  !< problem
    integer, intent(in) :: b                !< body
    real(dp) :: rate(3, problem%bodies(b)%nodes_per_sector)
    rate = problem%spring(:, problem%first(b) + 1:problem%first(b) + problem%bodies(b)%nodes_per_sector)
  end function sector_springs

  !> Keep the derivatives; the dense matrix is formed in solve.
  subroutine update_condensed(self, problem, dw, dt, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: dw(:, :, :)               !< dR/dw (3, 3, multipliers) [Pa/m]
    real(dp), intent(in) :: dt(:, :, :)               !< dR/dt (3, 3, multipliers)
    type(error_t), allocatable, intent(out) :: error  !< never set
    if (allocated(error) .or. problem%n == 0) return
    self%dw = dw
    self%dt = dt
  end subroutine update_condensed

  !> Newton correction: dense system over the closed points, then the bodies.
  subroutine solve_condensed(self, problem, r_u, r_c, du, dtraction, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: r_u(:, :)                 !< out-of-balance forces (3, n) [N]
    real(dp), intent(in) :: r_c(:, :)                 !< residuals of the law (3, multipliers) [Pa]
    real(dp), intent(out) :: du(:, :)                 !< correction of the displacements (3, n) [m]
    real(dp), intent(out) :: dtraction(:, :)          !< correction of the tractions (3, multipliers) [Pa]
    type(error_t), allocatable, intent(out) :: error  !< singular
    real(dp), allocatable :: f(:, :)
    allocate (f(3, problem%n))
    call open_corrections(self, r_c, dtraction)
    f = -r_u
    call add_nodal_forces(problem%mortar, dtraction, f)
    call solve_bodies(self, problem, f, du)
    call solve_closed(self, problem, r_c, relative_displacement(problem%mortar, du), dtraction, error)
    if (allocated(error)) return
    f = -r_u
    call add_nodal_forces(problem%mortar, dtraction, f)
    call solve_bodies(self, problem, f, du)
  end subroutine solve_condensed

  !> Where the law does not see the displacements (open points), the correction follows from the traction alone.
  subroutine open_corrections(self, r_c, dtraction)
    class(condensed_t), intent(in) :: self      !< solver with derivatives
    real(dp), intent(in) :: r_c(:, :)           !< residuals of the law
    real(dp), intent(out) :: dtraction(:, :)    !< corrections there, 0 elsewhere [Pa]
    integer :: j
    dtraction = 0
    do j = 1, size(r_c, 2)
      if (is_open(self, j)) dtraction(:, j) = -r_c(:, j)
    end do
  end subroutine open_corrections

  !> The law at j does not see the displacements.
  pure logical function is_open(self, j)
    class(condensed_t), intent(in) :: self  !< solver with derivatives
    integer, intent(in) :: j                !< multiplier
    is_open = .not. any(abs(self%dw(:, :, j)) > 0)
  end function is_open

  !> Dense system over the closed points of the part that is solved.
  subroutine solve_closed(self, problem, r_c, w, dtraction, error)
    class(condensed_t), intent(inout) :: self         !< solver with derivatives
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: r_c(:, :)                 !< residuals of the law (3, multipliers) [Pa]
    real(dp), intent(in) :: w(:, :)                   !< relative displacement without these tractions [m]
    real(dp), intent(inout) :: dtraction(:, :)        !< gets the closed points [Pa]
    type(error_t), allocatable, intent(out) :: error  !< singular
    real(dp), allocatable :: a(:, :), b(:, :)
    integer, allocatable :: list(:)
    integer :: i, j, k, p, q, d, n
    list = pack([(j, j=1, problem%mortar%n)], [(self%sector(j) < self%part .and. .not. is_open(self, j), &
      j=1, problem%mortar%n)])
    n = size(list)
    allocate (a(3*n, 3*n), b(3*n, 1))
    do q = 1, n
      j = list(q)
      do p = 1, n
        i = list(p)
        d = modulo(self%sector(i) - self%sector(j), self%part) + 1
        a(3*p - 2:3*p, 3*q - 2:3*q) = problem%mortar%area(j)*matmul(self%dw(:, :, i), &
          self%kernel(3*self%row(i) - 2:3*self%row(i), 3*self%row(j) - 2:3*self%row(j), d))
      end do
      a(3*q - 2:3*q, 3*q - 2:3*q) = a(3*q - 2:3*q, 3*q - 2:3*q) + self%dt(:, :, j)
      b(3*q - 2:3*q, 1) = -r_c(:, j) - matmul(self%dw(:, :, j), w(:, j))
    end do
    self%flops = 2*(3._dp*n)**3/3
    call solve_dense(a, b, error)
    if (allocated(error)) return
    do q = 1, n
      do k = 0, size(self%at, 2)/self%part - 1
        i = self%at(self%row(list(q)), self%sector(list(q)) + k*self%part)
        dtraction(:, i) = b(3*q - 2:3*q, 1)
      end do
    end do
  end subroutine solve_closed

  !> u = K^-1 f for both bodies.
  subroutine solve_bodies(self, problem, f, u)
    class(condensed_t), intent(in) :: self     !< factors
    type(problem_t), intent(in) :: problem     !< problem
    real(dp), intent(in) :: f(:, :)            !< nodal forces (3, n) [N]
    real(dp), intent(out) :: u(:, :)           !< displacements (3, n) [m]
    integer :: b
    do b = 1, 2
      associate (low => problem%first(b) + 1, high => problem%first(b) + problem%bodies(b)%nodes())
        call solve_body(self%bodies(b), f(:, low:high), u(:, low:high))
      end associate
    end do
  end subroutine solve_bodies

  !> Give back all memory.
  subroutine release_condensed(self)
    class(condensed_t), intent(inout) :: self  !< solver
    if (allocated(self%bodies)) deallocate (self%bodies, self%kernel)
  end subroutine release_condensed
end module hd_condensed
