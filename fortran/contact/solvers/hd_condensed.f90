! SPDX-License-Identifier: GPL-3.0-or-later
!> Newton's linear system condensed to the contact face: the bodies are solved once, only tractions of closed contact points
!> remain. They come from a dense LU of the part of the face that symmetry leaves, or from GMRES on the whole face,
!> whichever costs less.
!>
!>   [ R_w F a + R_t ] dt = -r_c - R_w B v,   F = B K^-1 B^T,   v = -K^-1 r_u,   du = v + K^-1 B^T a dt
module hd_condensed
  use hd_kinds, only: dp
  use hd_border, only: border_t, new_border
  use hd_circulant, only: circulant_t
  use hd_error, only: error_t
  use hd_face_system, only: face_system_t, new_face_system
  use hd_linear_solver, only: linear_solver_t
  use hd_log, only: detail
  use hd_mortar, only: add_nodal_forces, relative_displacement
  use hd_problem, only: problem_t, load_t, state_t
  use hd_symmetry, only: sharing_t, use_symmetry, share_law, symmetry_name, image_sector, node_images, mirror_sign
  use hd_text, only: to_text
  use hd_vector, only: add, length, many, part_lengths, set, weighted_length
  implicit none
  private
  public :: condensed_t, new_condensed

  real(dp), parameter :: useful = 1e-3_dp   !< residual of GMRES that makes a Newton step; above it a dense matrix takes over
  integer, parameter :: first_guess = 30             !< steps of GMRES expected before any are known
  integer, parameter :: most_steps = 250             !< of GMRES
  integer, parameter :: together = 4                 !< residuals that the bodies meet at once: eight columns of a harmonic
  integer, parameter :: largest_dense = 12000        !< unknowns a dense matrix may have
  !> Nodes from which it pays not to solve the bodies of a drive a second time. Smaller meshes keep the rounding of both
  !> solves, which decides whether a drive that cycles gets out.
  integer, parameter :: many_nodes = 6000
  real(dp), parameter :: balanced = 1e-6_dp          !< forces out of balance that do not move the contact
  real(dp), parameter :: dense_rate = 2e10_dp        !< operations per second of LU, measured; only the ratio matters
  real(dp), parameter :: pair_time = 15e-9_dp         !< seconds per entry to form the matrix
  real(dp), parameter :: apply_rate = 4e9_dp         !< operations per second of F

  type, extends(linear_solver_t) :: condensed_t
    type(circulant_t), pointer :: compliance => null()  !< of the bodies at the face
    integer :: sectors = 0                          !< of the ring
    integer, allocatable :: sector(:), row(:), at(:, :)  !< place of each multiplier, multiplier at (row, sector)
    type(sharing_t) :: sharing                      !< points whose law counts for others
    integer, allocatable :: image(:)                !< of every node behind the mirror plane
    integer :: steps = first_guess                  !< of GMRES, last time
    real(dp), allocatable :: dw(:, :, :), dt(:, :, :)
    real(dp), allocatable :: factors(:, :)          !< of the dense matrix, until the next update
    integer, allocatable :: pivot(:)                !< their rows
    type(border_t), allocatable :: border           !< struts and rigid motions, where the problem has any
  contains
    procedure :: begin => begin_condensed
    procedure :: update => update_condensed
    procedure :: solve => solve_condensed
    procedure :: solve_all => solve_condensed_all
    procedure :: release => release_condensed
  end type condensed_t

contains

  !> Take over a compliance.
  subroutine new_condensed(problem, compliance, condensed)
    type(problem_t), intent(in) :: problem                !< problem
    type(circulant_t), pointer, intent(in) :: compliance  !< allocated; the solver frees it
    type(condensed_t), intent(out) :: condensed           !< solver
    integer :: j, m, rows
    integer, allocatable :: number(:)
    condensed%compliance => compliance
    condensed%name = 'condensed by harmonics'
    condensed%unknowns = 3*problem%mortar%n
    condensed%own_threads = .true.
    m = problem%bodies(1)%nodes_per_sector
    condensed%sectors = problem%bodies(1)%sectors
    allocate (number(m), source=0)
    number(modulo(problem%mortar%node - 1, m) + 1) = 1
    rows = 0
    do j = 1, m
      rows = rows + number(j)
      number(j) = rows
    end do
    condensed%sector = (problem%mortar%node - 1)/m
    condensed%row = number(modulo(problem%mortar%node - 1, m) + 1)
    allocate (condensed%at(rows, 0:condensed%sectors - 1), source=0)
    do j = 1, problem%mortar%n
      condensed%at(condensed%row(j), condensed%sector(j)) = j
    end do
  end subroutine new_condensed

  !> Find the symmetry of a load step and factorise for it.
  subroutine begin_condensed(self, problem, load, state, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(problem_t), intent(in) :: problem            !< problem
    type(load_t), intent(in) :: load                  !< load at the end of the step
    type(state_t), intent(in) :: state                !< state at its beginning
    type(error_t), allocatable, intent(out) :: error  !< symmetry asked for is not there, body not held
    call use_symmetry(problem, load, state, self%most_images, self%demanded, self%symmetry, error)
    if (allocated(error)) return
    self%steps = first_guess  ! no memory of earlier load steps: a resumed run repeats every bit
    if (self%symmetry%mirror > 0) self%image = node_images(problem, self%symmetry%mirror)
    call share_law(problem, self%symmetry, self%sharing)
    self%symmetry_used = symmetry_name(self%symmetry)
    call self%compliance%prepare(problem, self%symmetry, error)
    self%factor_entries = self%compliance%factor_entries
    if (allocated(error) .or. .not. (allocated(problem%struts) .or. allocated(problem%loose))) return
    if (allocated(self%border)) then
      if (self%border%symmetry == self%symmetry .and. self%border%serial == problem%mortar%serial) return
      deallocate (self%border)
    end if
    allocate (self%border)
    call new_border(problem, self%compliance, self%symmetry, self%border, error)
  end subroutine begin_condensed

  !> Keep the derivatives; the face system is formed in solve.
  subroutine update_condensed(self, problem, dw, dt, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: dw(:, :, :)               !< dR/dw (3, 3, multipliers) [Pa/m]
    real(dp), intent(in) :: dt(:, :, :)               !< dR/dt (3, 3, multipliers)
    type(error_t), allocatable, intent(out) :: error  !< body not held
    call self%compliance%prepare(problem, self%symmetry, error)
    if (allocated(error)) return
    if (.not. allocated(self%dw)) allocate (self%dw, self%dt, mold=dw)
    call set(size(dw), 1._dp, dw, self%dw)
    call set(size(dt), 1._dp, dt, self%dt)
    if (allocated(self%factors)) deallocate (self%factors)
    if (allocated(self%pivot)) deallocate (self%pivot)
    call self%sharing%take_law(self%dw, self%dt)
    if (allocated(self%border)) call self%border%take(problem)
  end subroutine update_condensed

  !> Newton correction: tractions on the face, then the bodies.
  subroutine solve_condensed(self, problem, r_u, r_c, du, dtraction, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: r_u(:, :)                 !< out-of-balance forces (3, n) [N]
    real(dp), intent(in) :: r_c(:, :)                 !< residuals of the law (3, multipliers) [Pa]
    real(dp), intent(out) :: du(:, :)                 !< correction of the displacements (3, n) [m]
    real(dp), intent(out) :: dtraction(:, :)          !< correction of the tractions (3, multipliers) [Pa]
    type(error_t), allocatable, intent(out) :: error  !< singular
    call solve_sides(self, problem, 1, r_u, r_c, du, dtraction, error)
  end subroutine solve_condensed

  !> Some of them, a few at a time.
  subroutine solve_condensed_all(self, problem, r_u, r_c, du, dtraction, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: r_u(:, :, :), r_c(:, :, :)           !< residuals (3, n, sides), (3, multipliers, sides)
    real(dp), intent(out) :: du(:, :, :), dtraction(:, :, :)     !< corrections
    type(error_t), allocatable, intent(out) :: error  !< singular
    integer :: first, last
    do first = 1, size(r_u, 3), together
      last = min(first + together - 1, size(r_u, 3))
      call solve_sides(self, problem, last - first + 1, r_u(:, :, first:last), r_c(:, :, first:last), du(:, :, first:last), &
        dtraction(:, :, first:last), error)
      if (allocated(error)) return
    end do
  end subroutine solve_condensed_all

  !> Those that the bodies meet together.
  subroutine solve_sides(self, problem, sides, r_u, r_c, du, dtraction, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(problem_t), intent(in) :: problem            !< problem
    integer, intent(in) :: sides                      !< how many
    real(dp), intent(in) :: r_u(3, problem%n, sides), r_c(3, problem%mortar%n, sides)           !< residuals
    real(dp), intent(out) :: du(3, problem%n, sides), dtraction(3, problem%mortar%n, sides)     !< corrections
    type(error_t), allocatable, intent(out) :: error  !< singular
    real(dp), allocatable :: f(:, :, :), motion(:, :, :)
    integer :: k
    allocate (f, mold=r_u)
    if (has_border(self)) allocate (motion, mold=r_u)
    call press(self, problem, r_u, r_c, dtraction, f, motion, error)
    if (allocated(error)) return
    call self%compliance%solve(problem, sides, f, du, error)
    if (allocated(error)) return
    if (has_border(self)) call add(size(du), 1._dp, motion, du)
    do k = 1, sides
      call balance(self, du(:, :, k))
    end do
  end subroutine solve_sides

  !> Struts push, or bodies may move.
  logical function has_border(self)
    class(condensed_t), intent(in) :: self            !< solver
    has_border = .false.
    if (allocated(self%border)) has_border = size(self%border%columns()) > 0
  end function has_border

  !> Tractions on the face, and the forces that the bodies have then.
  subroutine press(self, problem, r_u, r_c, dtraction, f, motion, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(problem_t), intent(in) :: problem            !< problem
    real(dp), intent(in) :: r_u(:, :, :)              !< out-of-balance forces (3, n, sides) [N]
    real(dp), intent(in) :: r_c(:, :, :)              !< residuals of the law (3, multipliers, sides) [Pa]
    real(dp), intent(out) :: dtraction(:, :, :)       !< correction of the tractions (3, multipliers, sides) [Pa]
    real(dp), intent(out) :: f(:, :, :)               !< forces (3, n, sides) [N]
    real(dp), allocatable, intent(inout) :: motion(:, :, :)  !< allocated where there is a border: gets rigid motions [m]
    type(error_t), allocatable, intent(out) :: error  !< singular
    type(face_system_t) :: system
    real(dp), allocatable :: left(:, :, :)
    real(dp) :: w(3, problem%mortar%n, size(r_c, 3))
    integer, allocatable :: list(:), mirrored(:)
    integer :: j, k
    left = r_c
    do k = 1, size(left, 3)
      if (allocated(self%sharing%representative)) left(:, :, k) = left(:, self%sharing%representative, k)*self%sharing%sign
      if (self%symmetry%mirror > 0) call hold_on_plane(self, left(:, :, k))
    end do
    call new_face_system(self%dw, self%dt, left, max(problem%mortar%area, tiny(1._dp)), system)
    system%compliance => self%compliance
    dtraction = system%q
    if (allocated(motion)) call add_border(self, problem, size(left, 3), system)
    do k = 1, size(left, 3)
      call find_known(self, problem, k, r_u(:, :, k), r_c(:, :, k), system, w(:, :, k), error)
      if (allocated(error)) return
    end do
    list = pack([(j, j=1, problem%mortar%n)], system%rank > 0)
    if (self%symmetry%half_turn) list = pack(list, self%sector(list) < self%sectors/2)
    mirrored = list
    if (self%symmetry%mirror > 0) mirrored = images(self, list, self%symmetry%mirror)
    call solve_face(self, system, list, mirrored, w, dtraction, error)
    if (allocated(error)) return
    call set(size(r_u), -1._dp, r_u, f)
    do k = 1, size(left, 3)
      call add_nodal_forces(problem%mortar, dtraction(:, :, k), f(:, :, k))
      if (allocated(motion)) call self%border%add_solution(problem, system%x(:, k), f(:, :, k), motion(:, :, k))
      call balance(self, f(:, :, k))
    end do
  end subroutine press

  !> Relative displacements without the tractions that are sought, and the right-hand sides of the border. Where the bodies are in
  !> balance but for struts, as they are after a step of Newton's method, they need not be solved for it.
  subroutine find_known(self, problem, side, r_u, r_c, system, w, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(problem_t), intent(in) :: problem            !< problem
    integer, intent(in) :: side                       !< number of the right-hand side
    real(dp), intent(in) :: r_u(:, :)                 !< out-of-balance forces (3, n) [N]
    real(dp), intent(in) :: r_c(:, :)                 !< residuals of the law (3, multipliers) [Pa]
    type(face_system_t), intent(inout) :: system      !< gets what is known of the border
    real(dp), intent(out) :: w(:, :)                  !< (3, multipliers) [m]
    type(error_t), allocatable, intent(out) :: error  !< memory
    real(dp), allocatable :: f(:, :), v(:, :), known(:), pressed(:, :), forces(:), pushed(:, :)
    real(dp) :: scale, held, left
    logical :: bordered, easy, loaded
    integer :: j
    bordered = system%more > 0
    loaded = length(size(r_u), r_u) > 0
    easy = .true.
    if (bordered) then
      easy = self%border%struts > 0 .and. problem%n >= many_nodes
      allocate (forces(self%border%struts), source=0._dp)
    end if
    if (loaded .or. .not. easy) then
      allocate (f, v, mold=r_u)
      call set(size(r_u), -1._dp, r_u, f)
      call balance(self, f)
    end if
    if (loaded .and. easy) then
      scale = weighted_length(problem%mortar%area, r_c)
      if (bordered) then
        call self%border%split(problem, f, forces, v)
        pushed = f
        call add(size(f), -1._dp, v, pushed)
        scale = max(scale, length(size(f), pushed))
      else
        call set(size(f), 1._dp, f, v)
      end if
      call part_lengths(v, problem%fixed, held, left)
      easy = left <= balanced*scale
    end if
    if (easy) then
      allocate (pressed, mold=r_c)
      !$omp parallel do schedule(static) if(size(pressed) > many/4)
      do j = 1, problem%mortar%n
        pressed(:, j) = problem%mortar%area(j)*system%q(:, j, side)
      end do
      !$omp end parallel do
      call self%compliance%apply(.false., pressed, w)
      if (bordered) call self%border%respond(problem, forces, pressed, v, pack([(j, j=1, size(w, 2))], system%rank > 0), w, known)
    else
      call add_nodal_forces(problem%mortar, system%q(:, :, side), f)
      call balance(self, f)
      call self%compliance%solve(problem, 1, f, v, error)
      call balance(self, v)
      if (allocated(error)) return
      w = relative_displacement(problem%mortar, v)
      if (bordered) known = self%border%known(problem, f, v)
    end if
    if (.not. bordered) return
    system%known(:, side) = known
    if (allocated(problem%wheel) .and. .not. problem%wheel_turns) system%known(system%more, side) = 0
  end subroutine find_known

  !> Enter the border into a face system.
  subroutine add_border(self, problem, sides, system)
    class(condensed_t), intent(in) :: self            !< solver with a border
    type(problem_t), intent(in) :: problem            !< problem
    integer, intent(in) :: sides                      !< how many
    type(face_system_t), intent(inout) :: system      !< gets more, side, corner, and room
    system%column = self%border%columns()
    system%more = size(system%column)
    system%struts = size(self%border%active)
    system%blind = self%border%blind
    system%corner = self%border%matrix(problem)
    allocate (system%known(system%more, sides), system%x(system%more, sides))
    if (self%symmetry%half_turn) system%fold = 2
    if (problem%wheel_turns .or. .not. allocated(problem%wheel)) return
    associate (last => system%more)  ! the turn of the wheel, which is held
      system%column(last) = 0
      system%corner(last, :) = 0
      system%corner(:, last) = 0
      system%corner(last, last) = self%border%scale
    end associate
  end subroutine add_border

  !> Forces or displacements without the rounding that breaks the mirror plane: a body that turns freely would turn far by it.
  subroutine balance(self, f)
    class(condensed_t), intent(in) :: self  !< solver
    real(dp), intent(inout) :: f(:, :)      !< nodal vectors (3, n)
    real(dp) :: other(3, size(f, 2))
    integer :: i
    if (self%symmetry%mirror == 0) return
    !$omp parallel if(size(f) > many)
    !$omp do schedule(static)
    do i = 1, size(f, 2)
      other(:, i) = mirror_sign*f(:, self%image(i))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 1, size(f, 2)
      f(:, i) = (f(:, i) + other(:, i))/2
    end do
    !$omp end do
    !$omp end parallel
  end subroutine balance

  !> Points on the mirror plane get no circumferential shear, for the same reason.
  subroutine hold_on_plane(self, r_c)
    class(condensed_t), intent(inout) :: self  !< gets the law of these points
    real(dp), intent(inout) :: r_c(:, :)       !< residuals of the law
    integer :: j
    do j = 1, size(r_c, 2)
      if (.not. self%sharing%on_plane(j)) cycle
      self%dw(2, :, j) = 0
      self%dw(:, 2, j) = 0
      self%dt(:, 2, j) = 0
      self%dt(2, :, j) = [0, 1, 0]
      r_c(2, j) = 0
    end do
  end subroutine hold_on_plane

  !> The cheaper of dense LU and GMRES, then the images.
  subroutine solve_face(self, system, list, mirrored, w, dtraction, error)
    class(condensed_t), intent(inout) :: self         !< solver
    type(face_system_t), intent(inout) :: system      !< face system
    integer, intent(in) :: list(:)                    !< closed points, one of each pair that half a turn joins
    integer, intent(in) :: mirrored(:)                !< their images behind the mirror plane
    real(dp), intent(in) :: w(:, :, :)                !< relative displacements without these tractions (3, multipliers, sides) [m]
    real(dp), intent(inout) :: dtraction(:, :, :)     !< gets the closed points [Pa]
    type(error_t), allocatable, intent(out) :: error  !< singular
    real(dp) :: n, residual
    integer, allocatable :: part(:)
    integer :: k, steps
    logical :: krylov
    part = pack(list, list <= mirrored)
    n = sum(system%rank(part))
    krylov = n > largest_dense
    if (.not. (krylov .or. allocated(self%factors))) krylov = self%sides*self%steps*2*self%compliance%apply_flops/apply_rate < &
      2*n**3/3/dense_rate + n**2*pair_time*self%compliance%products
    if (krylov) then
      call system%solve_krylov(list, w, self%border, self%accuracy, most_steps, dtraction, steps, residual, error)
      if (allocated(error)) return
      self%steps = steps/size(w, 3)
      self%flops = steps*2*self%compliance%apply_flops
      self%inner = self%inner + steps
      call detail('          GMRES '//to_text(steps)//' steps to '//to_text(residual)//' of '//to_text(self%accuracy))
      krylov = residual <= max(useful, self%accuracy) .or. n > largest_dense
      if (.not. krylov) call system%renew()
    end if
    if (.not. krylov) then
      call system%solve_direct(part, pack(mirrored, list <= mirrored), w, self%border, dtraction, self%flops, self%factors, &
        self%pivot, error)
      if (allocated(error)) return
    end if
    do k = 1, size(w, 3)
      if (self%symmetry%mirror > 0) call spread_mirror(pack(list, list <= mirrored), pack(mirrored, list <= mirrored), &
        dtraction(:, :, k))
      if (.not. self%symmetry%half_turn) cycle
      part = images(self, list, 0)
      dtraction(:, part, k) = dtraction(:, list, k)
    end do
  end subroutine solve_face

  !> Copy tractions behind the mirror plane.
  pure subroutine spread_mirror(list, mirrored, traction)
    integer, intent(in) :: list(:), mirrored(:)     !< points and their images
    real(dp), intent(inout) :: traction(:, :)       !< (3, multipliers) [Pa]
    integer :: i
    do i = 1, size(list)
      if (mirrored(i) /= list(i)) traction(:, mirrored(i)) = mirror_sign*traction(:, list(i))
    end do
  end subroutine spread_mirror

  !> Images of multipliers: behind a mirror plane within the part that half a turn leaves, or after half a turn (mirror 0).
  pure function images(self, list, mirror) result(image)
    class(condensed_t), intent(in) :: self  !< solver
    integer, intent(in) :: list(:)          !< multipliers
    integer, intent(in) :: mirror           !< 0 half a turn; else the plane
    integer :: image(size(list)), i, s
    image = list
    if (mirror == 0 .and. .not. self%symmetry%half_turn) return
    do i = 1, size(list)
      s = image_sector(self%sectors, self%sector(list(i)), 0, mirror)
      if (mirror > 0 .and. self%symmetry%half_turn) s = modulo(s, self%sectors/2)
      image(i) = self%at(self%row(list(i)), s)
    end do
  end function images

  !> Give back all memory.
  subroutine release_condensed(self)
    class(condensed_t), intent(inout) :: self  !< solver
    if (.not. associated(self%compliance)) return
    call self%compliance%release()
    deallocate (self%compliance)
  end subroutine release_condensed
end module hd_condensed
