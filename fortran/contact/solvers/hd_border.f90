! SPDX-License-Identifier: GPL-3.0-or-later
!> What stands beside the contact points in a condensed system: the forces x of the struts that push, and the motions a of bodies
!> that contact, struts or soft springs to the ground alone hold (those of a loose body, the turn of one with a wheel).
!>
!>   u = C (-r_u + B^T t + P x) + N a           C compliance, P unit forces of the struts, N = R - C S R, R rigid motions
!>   x / k + P^T u + G x = 0                    linearised strut, k its tangent, G compliance of what it stands on
!>   N^T (-r_u + B^T t + P x) = N^T S R a       balance of forces and moments, S the springs
!> A companion (hd_flank_friction) has  (x - lean x_partner)/k + P^T u + G x = 0,  or where it slides  x = lean x_partner  alone:
!> its row is no longer its column.
!> C holds a loose body by stiff springs of its own (hold_loose): under forces in balance with S they carry nothing, and the
!> equations are those of the body on S. In a C without them the soft springs of a body would hide what the contact gives way.
!> Motions are scaled to unknowns in newtons.
module hd_border
  use hd_kinds, only: dp
  use hd_circulant, only: circulant_t
  use hd_error, only: error_t
  use hd_lapack, only: invert_symmetric
  use hd_mortar, only: relative_displacement
  use hd_problem, only: problem_t
  use hd_flank_friction, only: lean_rows
  use hd_strut, only: closing_of, push
  use hd_symmetry, only: symmetry_t
  use hd_vector, only: largest, many, set
  implicit none
  private
  public :: border_t, new_border

  !> Part of the mean compliance of the struts that a loose body is given out of its plane where nothing else holds it: it changes
  !> the way of Newton's iteration, not where it ends.
  real(dp), parameter :: flat = 1e-7_dp
  real(dp), parameter :: alike = 1e-10_dp     !< makes struts at the same nodes no two unknowns of a least square
  real(dp), parameter :: rounding = 1e-12_dp  !< relative
  integer, parameter :: turns(3) = [3, 5, 6]  !< kinds of motions

  type :: border_t
    integer :: struts = 0                        !< all of them
    integer :: modes = 0                         !< motions
    real(dp) :: scale = 0                        !< of their unknowns [m/N]
    type(symmetry_t) :: symmetry                 !< that these motions have
    integer :: serial = 0                        !< of the pairs behind `side`
    integer, allocatable :: body(:), kind(:)     !< of each: body; 1 x, 2 y, 3 turn about the axis, 4 z, 5 and 6 turns about x, y
    real(dp), allocatable :: cosine(:), sine(:), radius(:), z(:)   !< of the nodes' places (n) [1, 1, m, m]
    integer, allocatable :: active(:)            !< struts that push, at the present iterate
    logical, allocatable :: blind(:)             !< of these: their force does not see displacements
    real(dp), allocatable :: side(:, :, :)       !< relative displacements at the multipliers (3, multipliers, struts + modes) [m/N]
    real(dp), allocatable :: own(:, :)           !< P^T C P and P^T N (struts, struts + modes) [m/N]
    real(dp), allocatable :: held(:)             !< N^T S R of each motion: what soft springs hold [m/N]
    real(dp), allocatable :: shares(:, :)        !< (P^T P)^-1 (struts, struts)
  contains
    procedure :: take => take_active
    procedure :: matrix => border_matrix
    procedure :: known => known_side
    procedure :: split => split_forces
    procedure :: respond => respond_struts
    procedure :: columns => active_columns
    procedure, private :: work => work_of_motions
    procedure :: add_solution
  end type border_t

contains

  !> Answers of the bodies to unit forces of the struts, and motions.
  subroutine new_border(problem, compliance, symmetry, border, error)
    type(problem_t), intent(in) :: problem                !< problem with struts or loose bodies
    type(circulant_t), intent(inout) :: compliance        !< prepared
    type(symmetry_t), intent(in) :: symmetry              !< of the load step; with struts there is none
    type(border_t), intent(out) :: border                 !< complete but for what pushes
    type(error_t), allocatable, intent(out) :: error      !< memory
    real(dp), allocatable :: f(:, :), u(:, :), v(:, :)
    integer :: i, j, n
    if (allocated(problem%struts)) border%struts = size(problem%struts)
    n = border%struts
    border%symmetry = symmetry
    border%serial = problem%mortar%serial
    call list_modes(problem, border)
    allocate (border%cosine(problem%n), border%sine(problem%n), border%radius(problem%n), border%z(problem%n))
    do i = 1, size(problem%bodies)
      associate (body => problem%bodies(i), low => problem%first(i) + 1, high => problem%first(i) + problem%bodies(i)%nodes())
        border%cosine(low:high) = cos(body%angle)
        border%sine(low:high) = sin(body%angle)
        border%radius(low:high) = hypot(body%x(1, :), body%x(2, :))
        border%z(low:high) = body%x(3, :)
      end associate
    end do
    allocate (border%side(3, problem%mortar%n, n + border%modes), border%own(n, n + border%modes))
    allocate (f(3, problem%n), u(3, problem%n), v(3, problem%n), border%held(border%modes), border%shares(n, n))
    do i = 1, n
      f = 0
      call push(problem%struts(i), 1._dp, f)
      call compliance%solve(problem, 1, f, u, error)
      if (allocated(error)) return
      border%side(:, :, i) = relative_displacement(problem%mortar, u)
      do j = 1, n
        border%own(j, i) = closing_of(problem%struts(j), u)
        border%shares(j, i) = closing_of(problem%struts(j), f)
      end do
      border%shares(i, i) = (1 + alike)*border%shares(i, i)
    end do
    if (n > 0) call invert_symmetric(border%shares, error)
    if (allocated(error)) return
    border%own(:, :n) = (border%own(:, :n) + transpose(border%own(:, :n)))/2
    if (n > 0) then
      border%scale = sum([(border%own(i, i), i=1, n)])/n
    else
      ! of the order of a point's compliance, and the same whatever harmonics are known: a kept model repeats every bit
      border%scale = 1/(problem%bodies(1)%young*hypot(problem%bodies(1)%x(1, 1), problem%bodies(1)%x(2, 1)))
    end if
    do i = 1, border%modes
      u = 0
      call add_rigid_motions(border, problem, [(merge(border%scale, 0._dp, i == j), j=1, border%modes)], u)
      f = problem%spring*u
      call compliance%solve(problem, 1, f, v, error)
      if (allocated(error)) return
      u = u - v
      border%side(:, :, n + i) = relative_displacement(problem%mortar, u)
      border%own(:, n + i) = [(closing_of(problem%struts(j), u), j=1, n)]
      border%held(i) = sum(f*u)
    end do
    allocate (border%active(0), border%blind(0))
  end subroutine new_border

  !> Rigid motions that nothing but contact, struts and soft springs resists, as far as the symmetry of the step has them.
  subroutine list_modes(problem, border)
    type(problem_t), intent(in) :: problem   !< problem
    type(border_t), intent(inout) :: border  !< gets modes, body, kind
    logical :: there(6)
    integer :: b, k
    allocate (border%body(0), border%kind(0))
    there = .not. border%symmetry%half_turn .and. border%symmetry%mirror /= [2, 1, 0, 0, 1, 2]
    there(3) = border%symmetry%mirror == 0
    there(4) = .true.
    if (allocated(problem%loose)) then
      do b = 1, size(problem%loose)
        border%kind = [border%kind, pack([1, 2, 3, 4, 5, 6], there .and. problem%loose_ways(:, b))]
        border%body = [border%body, (problem%loose(b), k=size(border%body) + 1, size(border%kind))]
      end do
    end if
    if (allocated(problem%wheel)) then
      border%body = [border%body, count(problem%first < problem%wheel(1))]
      border%kind = [border%kind, 3]
    end if
    border%modes = size(border%body)
  end subroutine list_modes

  !> Add rigid motions of bodies: translations by amounts, turns that move points at a body's first node's radius by so much.
  subroutine add_rigid_motions(self, problem, amounts, u)
    class(border_t), intent(in) :: self       !< border
    type(problem_t), intent(in) :: problem    !< problem of revolved bodies
    real(dp), intent(in) :: amounts(:)        !< of the motions [m]
    real(dp), intent(inout) :: u(:, :)        !< displacements (3, n) [m]
    real(dp) :: a(6), x, y, z
    integer :: b, i
    do b = 1, size(problem%bodies)
      if (.not. any(self%body == b)) cycle
      a = 0
      do i = 1, self%modes
        if (self%body(i) == b) a(self%kind(i)) = a(self%kind(i)) + amounts(i)
      end do
      associate (first => problem%first(b) + 1, nodes => problem%bodies(b)%nodes(), c => self%cosine, s => self%sine, &
          r => self%radius)
        a(turns) = a(turns)/r(first)
        !$omp parallel do schedule(static) private(x, y, z) if(3*nodes > many)
        do i = first, first + nodes - 1
          z = self%z(i) - self%z(first)
          x = a(1) + a(6)*z
          y = a(2) - a(5)*z
          u(1, i) = u(1, i) + x*c(i) + y*s(i)
          u(2, i) = u(2, i) + y*c(i) - x*s(i) + a(3)*r(i)
          u(3, i) = u(3, i) + a(4) + r(i)*(a(5)*s(i) - a(6)*c(i))
        end do
        !$omp end parallel do
      end associate
    end do
  end subroutine add_rigid_motions

  !> Work of nodal forces on the unit of each motion [N m], summed in blocks of one length.
  function work_of_motions(self, problem, f) result(work)
    class(border_t), intent(in) :: self      !< border
    type(problem_t), intent(in) :: problem   !< problem
    real(dp), intent(in) :: f(:, :)          !< nodal forces (3, n) [N]
    real(dp) :: work(self%modes)
    integer, parameter :: block = 4000       !< nodes
    real(dp) :: part(6, size(f, 2)/block + 1), a(6), x, y, z
    integer :: b, i, k
    do b = 1, size(problem%bodies)
      if (.not. any(self%body == b)) cycle
      associate (first => problem%first(b) + 1, nodes => problem%bodies(b)%nodes(), c => self%cosine, s => self%sine, &
          r => self%radius)
        part = 0
        !$omp parallel do schedule(static) private(i, a, x, y, z) if(3*nodes > many)
        do k = 1, nodes/block + 1
          a = 0
          do i = first + block*(k - 1), first - 1 + min(block*k, nodes)
            z = self%z(i) - self%z(first)
            x = c(i)*f(1, i) - s(i)*f(2, i)
            y = s(i)*f(1, i) + c(i)*f(2, i)
            a = a + [x, y, r(i)*f(2, i), f(3, i), r(i)*s(i)*f(3, i) - z*y, z*x - r(i)*c(i)*f(3, i)]
          end do
          part(:, k) = a
        end do
        !$omp end parallel do
        a = self%scale*sum(part, 2)
        a(turns) = a(turns)/r(first)
      end associate
      do i = 1, self%modes
        if (self%body(i) == b) work(i) = a(self%kind(i))
      end do
    end do
  end function work_of_motions

  !> Struts that push at the present iterate.
  subroutine take_active(self, problem)
    class(border_t), intent(inout) :: self    !< gets active, blind
    type(problem_t), intent(in) :: problem    !< with strut_rate
    logical :: slides(self%struts)
    integer :: i
    if (self%struts == 0) return
    self%active = pack([(i, i=1, self%struts)], problem%strut_rate > 0)
    slides = .false.
    if (allocated(problem%rub)) slides(self%struts - size(problem%rub%partner) + 1:) = problem%rub%slides
    self%blind = slides(self%active)
  end subroutine take_active

  !> Numbers of the columns of `side` that count: struts that push, then motions.
  pure function active_columns(self) result(list)
    class(border_t), intent(in) :: self  !< border
    integer :: list(size(self%active) + self%modes), i
    list = [self%active, (self%struts + i, i=1, self%modes)]
  end function active_columns

  !> Matrix between them.
  pure function border_matrix(self, problem) result(d)
    class(border_t), intent(in) :: self     !< border
    type(problem_t), intent(in) :: problem  !< with strut_rate
    real(dp) :: d(size(self%active) + self%modes, size(self%active) + self%modes)
    integer :: i, j, n
    n = size(self%active)
    d = 0
    d(:n, :n) = self%own(self%active, self%active)
    d(:n, n + 1:) = self%own(self%active, self%struts + 1:)
    d(n + 1:, :n) = transpose(d(:n, n + 1:))
    if (allocated(problem%strut_give)) d(:n, :n) = d(:n, :n) + problem%strut_give(self%active, self%active)
    if (allocated(problem%groove)) then
      do i = 1, count(self%active <= problem%groove%balls)
        j = findloc(self%active, problem%groove%before + self%active(i), 1)
        d(i, j) = d(i, j) + problem%groove%cross(self%active(i))
        d(j, i) = d(j, i) + problem%groove%cross(self%active(i))
      end do
    end if
    do i = 1, n
      d(i, i) = d(i, i) + 1/problem%strut_rate(self%active(i))
    end do
    if (allocated(problem%rub)) call lean_rows(problem%rub, self%active, self%struts, problem%strut_rate, d)
    do i = 1, self%modes
      d(n + i, n + i) = -self%held(i)
      if (self%kind(i) > 2 .and. .not. self%held(i) > 0) d(n + i, n + i) = -flat*self%scale
    end do
  end function border_matrix

  !> Right-hand sides of the border for forces that are known and the displacements they make.
  function known_side(self, problem, f, v) result(b)
    class(border_t), intent(in) :: self      !< border
    type(problem_t), intent(in) :: problem   !< problem
    real(dp), intent(in) :: f(:, :)          !< nodal forces (3, n) [N]
    real(dp), intent(in) :: v(:, :)          !< C f (3, n) [m]
    real(dp) :: b(size(self%active) + self%modes)
    real(dp) :: left(3, problem%n)
    integer :: i, n
    n = size(self%active)
    !$omp parallel do schedule(static) if(size(v) > many)
    do i = 1, problem%n
      left(:, i) = f(:, i) - problem%spring(:, i)*v(:, i)
    end do
    !$omp end parallel do
    do i = 1, n
      b(i) = merge(0._dp, -closing_of(problem%struts(self%active(i)), v), self%blind(i))
    end do
    b(n + 1:) = -self%work(problem, left)
  end function known_side

  !> Forces of the struts, and what is left, of nodal forces.
  subroutine split_forces(self, problem, f, forces, left)
    class(border_t), intent(in) :: self     !< border
    type(problem_t), intent(in) :: problem  !< problem
    real(dp), intent(in) :: f(:, :)         !< nodal forces (3, n) [N]
    real(dp), intent(out) :: forces(:)      !< (struts) [N]
    real(dp), intent(out) :: left(:, :)     !< (3, n) [N]
    real(dp) :: small
    integer :: i
    forces = matmul(self%shares, [(closing_of(problem%struts(i), f), i=1, self%struts)])
    call set(size(f), 1._dp, f, left)
    do i = 1, self%struts
      call push(problem%struts(i), -forces(i), left)
    end do
    small = rounding*largest(size(f), f)
    !$omp parallel do schedule(static) if(size(f) > many)
    do i = 1, size(f, 2)
      where (abs(left(:, i)) <= small) left(:, i) = 0
    end do
    !$omp end parallel do
  end subroutine split_forces

  !> Right-hand sides of the border for forces of the struts, of the multipliers, and some at fixed dofs, without a solve of the
  !> bodies; and the relative displacements that the struts make.
  subroutine respond_struts(self, problem, forces, pressed, left, closed, w, known)
    class(border_t), intent(in) :: self      !< border
    type(problem_t), intent(in) :: problem   !< problem
    real(dp), intent(in) :: forces(:)        !< (struts) [N]
    real(dp), intent(in) :: pressed(:, :)    !< (3, multipliers) [N]
    real(dp), allocatable, intent(in) :: left(:, :)  !< of split_forces: the bodies do not answer to it (3, n) [N]
    integer, intent(in) :: closed(:)         !< multipliers that count
    real(dp), intent(inout) :: w(:, :)       !< gets the displacements there (3, multipliers) [m]
    real(dp), allocatable, intent(out) :: known(:)  !< as of known_side
    integer, parameter :: block = 500  !< points summed one behind the other
    integer, allocatable :: list(:), points(:), push_too(:)
    real(dp), allocatable :: part(:, :)
    integer :: i, j, k
    list = self%columns()
    points = pack([(i, i=1, size(pressed, 2))], any(abs(pressed) > 0, 1))  ! often few
    push_too = pack([(i, i=1, self%struts)], abs(forces) > 0)
    allocate (part(size(list), (size(points) + block - 1)/block))
    !$omp parallel private(i, k) if(3*(size(closed) + size(points))*size(list) > many/4)
    !$omp do schedule(static)
    do j = 1, size(part, 2)
      do i = 1, size(list)
        part(i, j) = 0
        do k = block*(j - 1) + 1, min(block*j, size(points))
          part(i, j) = part(i, j) + sum(self%side(:, points(k), list(i))*pressed(:, points(k)))
        end do
      end do
    end do
    !$omp end do
    !$omp do schedule(static)
    do j = 1, size(closed)
      do k = 1, size(push_too)
        w(:, closed(j)) = w(:, closed(j)) + forces(push_too(k))*self%side(:, closed(j), push_too(k))
      end do
    end do
    !$omp end do
    !$omp end parallel
    known = [(-dot_product(self%own(:, list(i)), forces) - sum(part(i, :)), i=1, size(list))]
    where (self%blind) known(:size(self%blind)) = 0
    if (.not. allocated(left)) return
    associate (entries => known(size(self%active) + 1:))
      entries = entries - self%work(problem, left)
    end associate
  end subroutine respond_struts

  !> Forces P x - S R a and rigid motions R a of a solution.
  subroutine add_solution(self, problem, x, f, u)
    class(border_t), intent(in) :: self      !< border
    type(problem_t), intent(in) :: problem   !< problem
    real(dp), intent(in) :: x(:)             !< unknowns of the border [N]
    real(dp), intent(inout) :: f(:, :)       !< nodal forces, to which C answers (3, n) [N]
    real(dp), intent(out) :: u(:, :)         !< rigid motions (3, n) [m]
    integer :: i
    do i = 1, size(self%active)
      call push(problem%struts(self%active(i)), x(i), f)
    end do
    !$omp parallel do schedule(static) if(size(u) > many)
    do i = 1, problem%n
      u(:, i) = 0
    end do
    !$omp end parallel do
    call add_rigid_motions(self, problem, self%scale*x(size(self%active) + 1:), u)
    !$omp parallel do schedule(static) if(size(u) > many)
    do i = 1, problem%n
      f(:, i) = f(:, i) - problem%spring(:, i)*u(:, i)
    end do
    !$omp end parallel do
  end subroutine add_solution
end module hd_border
