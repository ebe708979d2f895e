! SPDX-License-Identifier: GPL-3.0-or-later
!> A contact problem: bodies, supports, one mortar interface, and the fields that solve it.
module hd_problem
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_body, only: body_t, sector_stiffness, cell_nodes
  use hd_hexahedron, only: points
  use hd_block_matrix, only: block_matrix_t, graph_from_cells, cell_places, add_cell, largest_diagonal, multiply
  use hd_total_lagrangian, only: total_lagrangian_t, strains_t, new_total_lagrangian, cell_response, lanes
  use hd_sector_matrix, only: sector_matrix_t, new_sector_matrix, add_product
  use hd_mortar, only: mortar_t, add_nodal_forces, relative_displacement
  use hd_contact_law, only: contact_law_t
  use hd_pairing, only: pairing_t, pair_faces
  use hd_flank_friction, only: rub_t, strut_laws, rubbed_answers, give_way_rubbing, memories
  use hd_groove, only: groove_t, groove_forces, groove_tangents, groove_answers
  use hd_hold, only: hold_t
  use hd_vector, only: add, many, set
  use hd_strut, only: strut_t, placing_t, closing_of, push, strut_force, strut_tangent, answers, give_way
  implicit none
  private
  public :: problem_t, state_t, load_t, new_problem, assemble_stiffness, use_lagrangian, update_tangent, strain_bodies, &
    stiffness_blocks, add_springs, loosen, apply_stiffness, largest_stiffness, internal_residual, gap_and_slip, new_state, &
    keep_state, move_state, pair_bodies, update_struts, elastic_forces, body_forces, linear_forces, strain_energy, strut_closings, &
    strut_forces, forces_at

  integer, parameter :: long_loop = 2000  !< cells from which two threads are worth waking

  !> Nodes of the bodies are numbered one after the other: body b starts after first(b).
  type :: problem_t
    type(body_t), allocatable :: bodies(:)     !< bodies
    integer, allocatable :: first(:)           !< nodes before each body
    integer :: n = 0                           !< nodes
    type(sector_matrix_t), allocatable :: sector(:)   !< stiffness of the bodies, if all are revolved
    type(block_matrix_t) :: stiffness          !< of all bodies and springs, nothing removed; with large displacements the tangent;
                                               !< for revolved bodies only where a solver asked for it, values where it needs them
    type(total_lagrangian_t), allocatable :: lagrangian(:)  !< of each body, if displacements may be large
    real(dp), allocatable :: tangent_at(:, :)  !< displacements of their tangent (3, n) [m]
    type(strains_t), allocatable :: strains(:) !< of each body there, where no matrix of the tangent is kept,
    real(dp), allocatable :: elastic(:, :)     !< and their forces (3, n) [N]
    real(dp) :: largest = 0                    !< largest entry of their stiffness at rest [N/m]
    logical, allocatable :: fixed(:, :)        !< prescribed dofs (3, n)
    real(dp), allocatable :: spring(:, :)      !< springs to the ground, part of the stiffness (3, n) [N/m]
    type(mortar_t) :: mortar                   !< interface
    type(pairing_t), allocatable :: pairing    !< faces of the interface, if they are paired anew as they move
    type(contact_law_t) :: law                 !< its law
    type(strut_t), allocatable :: struts(:)    !< unilateral springs to rigid surroundings; unallocated: none
    class(placing_t), allocatable :: placing   !< of those struts that are placed anew as the bodies move
    real(dp), allocatable :: strut_shift(:)    !< closings of the placed struts beside those by weights; unallocated: none [m]
    real(dp), allocatable :: strut_foot(:)     !< angles at rest of what they press on [rad]
    real(dp), allocatable :: strut_rate(:)     !< their tangents at the present iterate [N/m]
    real(dp), allocatable :: strut_give(:, :)  !< compliance of what they stand on; unallocated: rigid [m/N]
    type(groove_t), allocatable :: groove      !< of struts that are balls, which hold along the axis too; unallocated: none
    type(hold_t), allocatable :: holds(:)      !< of a ring, in Newton's matrix; unallocated: none
    type(rub_t), allocatable :: rub            !< friction of struts, the last ones being companions of others; unallocated: none
    integer, allocatable :: loose(:)           !< bodies that contact, struts or soft springs hold in some rigid motions:
    logical, allocatable :: loose_ways(:, :)   !< of x, y, the turn about the axis, z, turns about x and y (6, loose)
    integer, allocatable :: wheel(:)           !< nodes on one circle with one common turn about the axis, an unknown; their other
                                               !< dofs are fixed, and so is this one for whoever does not know of it
    logical :: wheel_turns = .false.           !< they may turn; else they are held
  end type problem_t

  !> What a load step prescribes.
  type :: load_t
    real(dp), allocatable :: displacement(:, :)  !< values of the fixed dofs (3, n) [m]
    real(dp), allocatable :: force(:, :)         !< nodal forces (3, n) [N]
    real(dp), allocatable :: gap(:)              !< initial gap (multipliers), negative for interference [m]
    real(dp) :: friction = 0                     !< Coulomb coefficient of the step
    real(dp), allocatable :: closing(:)          !< offsets of the struts [m]
    real(dp), allocatable :: past(:, :)          !< of companions of struts, at the beginning of the step (memories, companions)
  end type load_t

  !> Fields of a converged step (or an iterate).
  type :: state_t
    real(dp), allocatable :: u(:, :)         !< displacements (3, n) [m]
    real(dp), allocatable :: traction(:, :)  !< on the master, normal first (3, multipliers) [Pa]
    real(dp), allocatable :: slip(:, :)      !< relative tangential displacement (2, multipliers) [m]
    real(dp), allocatable :: gap(:)          !< gap (multipliers) [m]
    integer, allocatable :: contact(:)       !< open, stick or slip (multipliers)
    real(dp), allocatable :: touch(:)        !< offsets of struts that are there from a state on; none before it [m]
    real(dp), allocatable :: past(:, :)      !< what companions of these struts remember (memories, companions); none before it
  end type state_t

contains

  !> Stiffness of the bodies; supports and interface are set by the caller afterwards.
  subroutine new_problem(bodies, problem, error)
    type(body_t), intent(in) :: bodies(:)             !< bodies of one element kind
    type(problem_t), intent(out) :: problem           !< problem without supports
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    real(dp), allocatable :: ke(:, :, :)
    integer :: b
    problem%bodies = bodies
    allocate (problem%first(size(bodies)))
    do b = 1, size(bodies)
      problem%first(b) = problem%n
      problem%n = problem%n + bodies(b)%nodes()
    end do
    allocate (problem%fixed(3, problem%n))
    problem%fixed = .false.
    allocate (problem%spring(3, problem%n), source=0._dp)
    if (.not. all(bodies%revolved)) then
      call assemble_stiffness(problem, error)
      return
    end if
    allocate (problem%sector(size(bodies)))
    do b = 1, size(bodies)
      call sector_stiffness(bodies(b), ke, error)
      if (allocated(error)) return
      call new_sector_matrix(bodies(b), ke, problem%sector(b))
    end do
  end subroutine new_problem

  !> The sparse matrix of all bodies and springs, if it is not there yet.
  subroutine assemble_stiffness(problem, error)
    type(problem_t), intent(inout) :: problem         !< gets stiffness
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    real(dp), allocatable :: ke(:, :, :)
    integer, allocatable :: cells(:, :)
    integer :: b, s, c, m
    if (allocated(problem%stiffness%val)) return
    m = 0
    do b = 1, size(problem%bodies)
      m = m + problem%bodies(b)%sectors*size(problem%bodies(b)%cells, 2)
    end do
    allocate (cells(size(problem%bodies(1)%cells, 1), m))
    m = 0
    do b = 1, size(problem%bodies)
      do s = 0, problem%bodies(b)%sectors - 1
        do c = 1, size(problem%bodies(b)%cells, 2)
          m = m + 1
          cells(:, m) = problem%first(b) + cell_nodes(problem%bodies(b), c, s)
        end do
      end do
    end do
    call graph_from_cells(problem%n, cells, problem%stiffness)
    m = 0
    do b = 1, size(problem%bodies)
      call sector_stiffness(problem%bodies(b), ke, error)
      if (allocated(error)) return
      do s = 0, problem%bodies(b)%sectors - 1
        do c = 1, size(problem%bodies(b)%cells, 2)
          m = m + 1
          call add_cell(problem%stiffness, cell_places(problem%stiffness, cells(:, m)), ke(:, :, c))
        end do
      end do
    end do
    call enter_springs(problem%spring, problem%stiffness)
  end subroutine assemble_stiffness

  !> Springs at all dofs that have one, into a stiffness without them.
  pure subroutine enter_springs(spring, matrix)
    real(dp), intent(in) :: spring(:, :)           !< (3, n) [N/m]
    type(block_matrix_t), intent(inout) :: matrix  !< added to
    integer :: b, c
    do b = 1, size(spring, 2)
      do c = 1, 3
        if (spring(c, b) > 0) call add_to_diagonal(matrix, b, c, spring(c, b))
      end do
    end do
  end subroutine enter_springs

  !> Nothing but contact, struts and springs to the ground holds a body in some rigid motions.
  pure subroutine loosen(problem, body, ways)
    type(problem_t), intent(inout) :: problem  !< problem
    integer, intent(in) :: body                !< number of the body
    logical, intent(in) :: ways(6)             !< as of loose_ways
    if (.not. allocated(problem%loose)) allocate (problem%loose(0), problem%loose_ways(6, 0))
    problem%loose = [problem%loose, body]
    problem%loose_ways = reshape([problem%loose_ways, ways], [6, size(problem%loose)])
  end subroutine loosen

  !> Springs from single dofs to the ground.
  subroutine add_springs(problem, nodes, component, rate)
    type(problem_t), intent(inout) :: problem  !< problem
    integer, intent(in) :: nodes(:)            !< nodes
    integer, intent(in) :: component           !< dof 1 to 3
    real(dp), intent(in) :: rate               !< stiffness at each node [N/m]
    integer :: i
    do i = 1, size(nodes)
      problem%spring(component, nodes(i)) = problem%spring(component, nodes(i)) + rate
      if (allocated(problem%stiffness%val)) call add_to_diagonal(problem%stiffness, nodes(i), component, rate)
    end do
  end subroutine add_springs

  !> Add a stiffness to the diagonal entry of a dof.
  pure subroutine add_to_diagonal(matrix, node, component, rate)
    type(block_matrix_t), intent(inout) :: matrix  !< matrix
    integer, intent(in) :: node, component         !< dof
    real(dp), intent(in) :: rate                   !< [N/m]
    associate (k => matrix%own(node))
      matrix%val(component, component, k) = matrix%val(component, component, k) + rate
    end associate
  end subroutine add_to_diagonal

  !> State of rest.
  pure subroutine new_state(problem, state)
    type(problem_t), intent(in) :: problem  !< problem
    type(state_t), intent(out) :: state     !< zero everywhere
    allocate (state%u(3, problem%n), source=0._dp)
    allocate (state%traction(3, problem%mortar%n), source=0._dp)
    allocate (state%slip(2, problem%mortar%n), source=0._dp)
    allocate (state%gap(problem%mortar%n), source=0._dp)
    allocate (state%contact(problem%mortar%n), source=0)
    allocate (state%touch(0))
    allocate (state%past(memories, 0))
  end subroutine new_state

  !> Copy of a state.
  subroutine keep_state(state, kept)
    type(state_t), intent(in) :: state     !< state
    type(state_t), intent(inout) :: kept   !< gets it
    if (.not. allocated(kept%u)) allocate (kept%u, mold=state%u)
    call set(size(state%u), 1._dp, state%u, kept%u)
    kept%traction = state%traction
    kept%slip = state%slip
    kept%gap = state%gap
    kept%contact = state%contact
    kept%touch = state%touch
    kept%past = state%past
  end subroutine keep_state

  !> Let a state become another's without a copy.
  pure subroutine move_state(from, to)
    type(state_t), intent(inout) :: from, to   !< empty afterwards; gets it
    call move_alloc(from%u, to%u)
    call move_alloc(from%traction, to%traction)
    call move_alloc(from%slip, to%slip)
    call move_alloc(from%gap, to%gap)
    call move_alloc(from%contact, to%contact)
    call move_alloc(from%touch, to%touch)
    call move_alloc(from%past, to%past)
  end subroutine move_state

  !> K u: forces of bodies, springs and struts under small displacements [N]; with large displacements those of the present tangent.
  subroutine apply_stiffness(problem, u, f)
    type(problem_t), intent(in) :: problem  !< problem
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    real(dp), intent(out) :: f(:, :)        !< forces (3, n) [N]
    real(dp), allocatable :: forces(:)
    integer :: i
    call elastic_forces(problem, u, f)
    if (.not. allocated(problem%struts)) return
    forces = linear_forces(problem, [(closing_of(problem%struts(i), u), i=1, size(problem%struts))])
    do i = 1, size(problem%struts)
      if (problem%strut_rate(i) > 0) call push(problem%struts(i), forces(i), f)
    end do
  end subroutine apply_stiffness

  !> Forces of the struts by their present tangents [N].
  function linear_forces(problem, closing) result(f)
    type(problem_t), intent(in) :: problem  !< problem with struts
    real(dp), intent(in) :: closing(:)      !< (struts) [m]
    real(dp) :: f(size(closing))
    if (allocated(problem%rub)) then
      f = rubbed_answers(problem%strut_rate, problem%rub, closing, problem%strut_give)
    else if (allocated(problem%strut_give)) then
      f = answers(problem%strut_rate, problem%strut_give, closing)
    else
      f = problem%strut_rate*closing
    end if
    if (allocated(problem%groove)) call groove_answers(problem%groove, problem%strut_rate, closing, f)
  end function linear_forces

  !> The same without struts.
  subroutine elastic_forces(problem, u, f)
    type(problem_t), intent(in) :: problem  !< problem
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    real(dp), intent(out) :: f(:, :)        !< forces (3, n) [N]
    integer :: b
    if (allocated(problem%lagrangian) .and. .not. allocated(problem%stiffness%val)) then
      call sum_cells(problem%bodies, problem%first, problem%lagrangian, problem%tangent_at, f, along=u, strains=problem%strains)
      f = f + problem%spring*u
      return
    end if
    if (allocated(problem%lagrangian) .or. .not. allocated(problem%sector)) then
      f = multiply(problem%stiffness, u)
      return
    end if
    do b = 1, size(problem%bodies)
      call body_forces(problem, b, u, f)
    end do
  end subroutine elastic_forces

  !> Those of one of some bodies that are revolved, its springs included.
  subroutine body_forces(problem, b, u, f)
    type(problem_t), intent(in) :: problem  !< problem
    integer, intent(in) :: b                !< body
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    real(dp), intent(inout) :: f(:, :)      !< gets the forces on its nodes (3, n) [N]
    integer :: i
    associate (low => problem%first(b) + 1, high => problem%first(b) + problem%bodies(b)%nodes())
      !$omp parallel do schedule(static) if(3*(high - low) > many)
      do i = low, high
        f(:, i) = problem%spring(:, i)*u(:, i)
      end do
      !$omp end parallel do
      call add_product(problem%sector(b), u(:, low:high), f(:, low:high))
    end associate
  end subroutine body_forces

  !> Largest entry of the stiffness of the bodies [N/m].
  pure real(dp) function largest_stiffness(problem) result(k)
    type(problem_t), intent(in) :: problem  !< problem
    if (allocated(problem%lagrangian)) then
      k = problem%largest
    else if (.not. allocated(problem%sector)) then
      k = largest_diagonal(problem%stiffness)
    else
      k = maxval(problem%sector%largest)
    end if
  end function largest_stiffness

  !> Out-of-balance nodal forces K u - f - B^T t [N]; at fixed dofs these are the reactions.
  subroutine internal_residual(problem, load, state, r, pushed)
    type(problem_t), intent(in) :: problem  !< problem
    type(load_t), intent(in) :: load        !< load
    type(state_t), intent(in) :: state      !< iterate
    real(dp), intent(out) :: r(:, :)        !< (3, n) [N]
    real(dp), intent(out), optional :: pushed  !< length of the vector of the struts' forces [N]
    real(dp), allocatable :: forces(:)
    integer :: i
    if (strained_at(problem, state%u)) then
      r = problem%elastic + problem%spring*state%u
    else if (allocated(problem%lagrangian)) then
      call sum_cells(problem%bodies, problem%first, problem%lagrangian, state%u, r)
      r = r + problem%spring*state%u
    else
      call elastic_forces(problem, state%u, r)
    end if
    call add(size(r), -1._dp, load%force, r)
    call add_nodal_forces(problem%mortar, state%traction, r, factor=-1._dp)
    if (present(pushed)) pushed = 0
    if (.not. allocated(problem%struts)) return
    forces = strut_forces(problem, load, state%u)
    if (present(pushed)) pushed = norm2(forces)
    do i = 1, size(forces)
      if (abs(forces(i)) > 0) call push(problem%struts(i), forces(i), r)
    end do
  end subroutine internal_residual

  !> Closings of the struts, less what they stand on gives way [m].
  function strut_closings(problem, load, u) result(c)
    type(problem_t), intent(in) :: problem  !< problem with struts
    type(load_t), intent(in) :: load        !< load
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    real(dp) :: c(size(problem%struts))
    integer :: i
    c = load%closing
    do i = 1, size(c)
      if (c(i) > -1) c(i) = c(i) + closing_of(problem%struts(i), u)
    end do
    if (allocated(problem%strut_shift)) c(problem%placing%struts) = c(problem%placing%struts) + problem%strut_shift
    if (.not. allocated(problem%strut_give)) return
    if (allocated(problem%rub)) then
      call give_way_rubbing(problem%struts, problem%rub, load%past, problem%strut_give, c)
    else
      call give_way(problem%struts%rate, problem%strut_give, c)
    end if
  end function strut_closings

  !> Forces of the struts [N].
  function strut_forces(problem, load, u) result(f)
    type(problem_t), intent(in) :: problem  !< problem with struts
    type(load_t), intent(in) :: load        !< load
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    real(dp) :: f(size(problem%struts))
    f = forces_at(problem, load, strut_closings(problem, load, u))
  end function strut_forces

  !> The same at given closings [N].
  pure function forces_at(problem, load, closing) result(f)
    type(problem_t), intent(in) :: problem  !< problem with struts
    type(load_t), intent(in) :: load        !< load
    real(dp), intent(in) :: closing(:)      !< (struts) [m]
    real(dp) :: f(size(closing)), rate(size(closing)), lean(size(closing))
    logical :: slides(size(closing))
    if (allocated(problem%rub)) then
      associate (m => size(problem%rub%partner))
        call strut_laws(problem%struts, problem%rub, load%past, closing, f, rate, lean(:m), slides(:m))
      end associate
    else
      f = strut_force(problem%struts, closing)
    end if
    if (allocated(problem%groove)) call groove_forces(problem%groove, problem%struts, closing, f)
  end function forces_at

  !> Bring the tangents of the struts up to date.
  subroutine update_struts(problem, load, u)
    type(problem_t), intent(inout) :: problem  !< gets strut_rate
    type(load_t), intent(in) :: load           !< load
    real(dp), intent(in) :: u(:, :)            !< displacements (3, n) [m]
    real(dp), allocatable :: closing(:), force(:)
    type(rub_t) :: now
    if (.not. allocated(problem%struts)) return
    closing = strut_closings(problem, load, u)
    if (allocated(problem%rub)) then
      now = problem%rub
      allocate (force, mold=closing)
      call strut_laws(problem%struts, problem%rub, load%past, closing, force, problem%strut_rate, now%lean, now%slides)
      problem%rub = now
    else
      problem%strut_rate = strut_tangent(problem%struts, closing)
    end if
    if (allocated(problem%groove)) call groove_tangents(problem%groove, problem%struts, closing, problem%strut_rate)
  end subroutine update_struts

  !> Allow large displacements from here on.
  subroutine use_lagrangian(problem, error)
    type(problem_t), intent(inout) :: problem         !< problem
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    integer :: b, c, s
    call assemble_stiffness(problem, error)
    if (allocated(error)) return
    problem%largest = largest_diagonal(problem%stiffness)
    problem%tangent_at = 0*problem%spring
    allocate (problem%lagrangian(size(problem%bodies)))
    do b = 1, size(problem%bodies)
      associate (body => problem%bodies(b), lagrangian => problem%lagrangian(b))
        call new_total_lagrangian(body, lagrangian, error)
        if (allocated(error)) return
        allocate (lagrangian%place(size(body%cells, 1), size(body%cells, 1), size(body%cells, 2), 0:body%sectors - 1))
        do s = 0, body%sectors - 1
          do c = 1, size(body%cells, 2)
            lagrangian%place(:, :, c, s) = cell_places(problem%stiffness, problem%first(b) + cell_nodes(body, c, s))
          end do
        end do
      end associate
    end do
  end subroutine use_lagrangian

  !> Bring the stiffness up to date with the displacements; nothing to do for small displacements.
  subroutine update_tangent(problem, u)
    type(problem_t), intent(inout) :: problem  !< problem
    real(dp), intent(in) :: u(:, :)            !< displacements (3, n) [m]
    call strain_bodies(problem, u)
    if (.not. (allocated(problem%lagrangian) .and. allocated(problem%stiffness%val))) return
    problem%tangent_at = u
    call assemble_tangent(problem, problem%stiffness)
  end subroutine update_tangent

  !> Forces of the bodies under large displacements, and what products of the tangent need of all cells, unless they are there.
  subroutine strain_bodies(problem, u)
    type(problem_t), intent(inout) :: problem  !< gets tangent_at, elastic, strains, if no matrix is kept
    real(dp), intent(in) :: u(:, :)            !< displacements (3, n) [m]
    integer :: b
    if (.not. allocated(problem%lagrangian) .or. allocated(problem%stiffness%val)) return
    if (strained_at(problem, u)) return
    if (.not. allocated(problem%strains)) then
      allocate (problem%strains(size(problem%bodies)), problem%elastic(3, problem%n))
      do b = 1, size(problem%bodies)
        associate (body => problem%bodies(b))
          allocate (problem%strains(b)%kept(15*lanes*points, size(body%cells, 2), 0:(body%sectors - 1)/lanes))
        end associate
      end do
    end if
    problem%tangent_at = u
    call sum_cells(problem%bodies, problem%first, problem%lagrangian, u, problem%elastic, keep=problem%strains)
  end subroutine strain_bodies

  !> Forces and strains are those of given displacements.
  pure logical function strained_at(problem, u) result(yes)
    type(problem_t), intent(in) :: problem  !< problem
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    yes = allocated(problem%strains)
    if (yes) yes = all(abs(u - problem%tangent_at) <= 0)
  end function strained_at

  !> Energy of the bodies under large displacements [J].
  real(dp) function strain_energy(problem, u) result(e)
    type(problem_t), intent(in) :: problem  !< problem with large displacements
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    real(dp), allocatable :: v(:, :, :)
    real(dp) :: part(lanes)
    integer :: b, c, s
    e = 0
    do b = 1, size(problem%bodies)
      associate (body => problem%bodies(b))
        do s = 0, body%sectors - 1, lanes
          v = group_field(body, problem%first(b), s, u)
          part = 0
          do c = 1, size(body%cells, 2)
            call cell_response(problem%lagrangian(b)%cells(c), body%cells(:, c), v, energy=part)
          end do
          e = e + sum(part(:min(lanes, body%sectors - s)))
        end do
      end associate
    end do
  end function strain_energy

  !> Tangent of the present displacements, with springs.
  subroutine assemble_tangent(problem, matrix)
    type(problem_t), intent(in) :: problem         !< problem with large displacements
    type(block_matrix_t), intent(inout) :: matrix  !< has its pattern
    real(dp) :: f(3, problem%n)
    matrix%val = 0
    call sum_cells(problem%bodies, problem%first, problem%lagrangian, problem%tangent_at, f, matrix)
    call enter_springs(problem%spring, matrix)
  end subroutine assemble_tangent

  !> Blocks of the stiffness in the order of its pattern, also where they are not kept.
  function stiffness_blocks(problem) result(val)
    type(problem_t), intent(in) :: problem  !< problem
    real(dp), allocatable :: val(:, :, :)
    type(block_matrix_t) :: matrix
    if (allocated(problem%stiffness%val)) then
      val = problem%stiffness%val
    else
      matrix = problem%stiffness
      allocate (matrix%val(3, 3, size(matrix%col)))
      call assemble_tangent(problem, matrix)
      call move_alloc(matrix%val, val)
    end if
  end function stiffness_blocks

  !> Nodal forces and tangent of all cells under large displacements, or its product. Sectors go in groups. A group shares nodes
  !> with its neighbours only, so every other one may run beside the rest, with the same bits for any number of threads.
  subroutine sum_cells(bodies, first, lagrangian, u, f, tangent, along, strains, keep)
    type(body_t), intent(in) :: bodies(:)                      !< bodies of one element kind
    integer, intent(in) :: first(:)                            !< nodes before each
    type(total_lagrangian_t), intent(in) :: lagrangian(:)      !< their cells at rest
    real(dp), intent(in) :: u(:, :)                            !< displacements (3, n) [m]
    real(dp), intent(out) :: f(:, :)                           !< forces (3, n) [N]
    type(block_matrix_t), intent(inout), optional :: tangent   !< added to
    real(dp), intent(in), optional :: along(:, :)              !< f gets the tangent times this (3, n) [m],
    type(strains_t), intent(in), optional :: strains(:)        !< by what is kept of u
    type(strains_t), intent(inout), optional :: keep(:)        !< gets that
    integer :: b, even, groups, s, turn
    f = 0
    do b = 1, size(bodies)
      groups = (bodies(b)%sectors + lanes - 1)/lanes
      even = groups/2*2
      do turn = 0, 2
        !$omp parallel do schedule(static) if(bodies(b)%sectors*size(bodies(b)%cells, 2) > long_loop)
        do s = merge(even, turn, turn == 2), merge(groups, even, turn == 2) - 1, 2
          if (present(keep)) then
            call sum_group(bodies(b), first(b), lagrangian(b), lanes*s, u, f, keep=keep(b)%kept(:, :, s))
          else if (present(strains)) then
            call sum_group(bodies(b), first(b), lagrangian(b), lanes*s, u, f, along=along, kept=strains(b)%kept(:, :, s))
          else
            call sum_group(bodies(b), first(b), lagrangian(b), lanes*s, u, f, tangent)
          end if
        end do
        !$omp end parallel do
      end do
    end do
  end subroutine sum_cells

  !> Nodal forces and tangent of a group of sectors, or its product.
  subroutine sum_group(body, first, lagrangian, sector, u, f, tangent, along, kept, keep)
    type(body_t), intent(in) :: body                           !< body
    integer, intent(in) :: first                               !< nodes before it
    type(total_lagrangian_t), intent(in) :: lagrangian         !< its cells at rest
    integer, intent(in) :: sector                              !< first of the group, from 0
    real(dp), intent(in) :: u(:, :)                            !< displacements (3, n) [m]
    real(dp), intent(inout) :: f(:, :)                         !< forces (3, n), added to [N]
    type(block_matrix_t), intent(inout), optional :: tangent   !< added to
    real(dp), intent(in), optional :: along(:, :)              !< as of sum_cells, like the next two
    real(dp), intent(in), optional :: kept(:, :)               !< (15 lanes points, cells)
    real(dp), intent(inout), optional :: keep(:, :)            !< the same
    real(dp), allocatable :: v(:, :, :), part(:, :, :), way(:, :, :), ke(:, :, :)  ! absent arguments where they are not there
    integer :: a, b, c, l, many
    many = min(lanes, body%sectors - sector)
    if (present(tangent)) allocate (ke(lanes, 3*size(body%cells, 1), 3*size(body%cells, 1)))
    if (present(along)) way = group_field(body, first, sector, along)
    if (present(kept)) then
      allocate (v(lanes, 3, 0), part(lanes, 3, size(way, 3)))
    else
      v = group_field(body, first, sector, u)
      allocate (part, mold=v)
    end if
    part = 0
    do c = 1, size(body%cells, 2)
      if (present(kept)) then
        call cell_response(lagrangian%cells(c), body%cells(:, c), v, part, along=way, kept=kept(:, c))
      else if (present(keep)) then
        call cell_response(lagrangian%cells(c), body%cells(:, c), v, part, keep=keep(:, c))
      else
        call cell_response(lagrangian%cells(c), body%cells(:, c), v, part, ke, way)
      end if
      do l = 1, merge(many, 0, present(tangent))
        call add_cell(tangent, lagrangian%place(:, :, c, sector + l - 1), ke(l, :, :))
      end do
    end do
    do a = 1, size(part, 3)
      do l = 1, many
        b = first + group_node(body, sector + l - 1, a)
        f(:, b) = f(:, b) + part(l, :, a)
      end do
    end do
  end subroutine sum_group

  !> A nodal field at the nodes of all cells of a group of sectors, of one sector and the next in each lane.
  pure function group_field(body, first, sector, u) result(v)
    type(body_t), intent(in) :: body   !< body
    integer, intent(in) :: first       !< nodes before it
    integer, intent(in) :: sector      !< first of the group, from 0
    real(dp), intent(in) :: u(:, :)    !< field (3, n)
    real(dp), allocatable :: v(:, :, :)  !< (lanes, 3, places as in the cells)
    integer :: a, l
    allocate (v(lanes, 3, maxval(body%cells)))
    do a = 1, size(v, 3)
      do l = 1, lanes
        v(l, :, a) = u(:, first + group_node(body, min(sector + l, body%sectors) - 1, a))
      end do
    end do
  end function group_field

  !> Node of a sector at a place as in the cells, of which the second half belongs to the next sector.
  pure integer function group_node(body, sector, place) result(node)
    type(body_t), intent(in) :: body   !< body
    integer, intent(in) :: sector      !< from 0
    integer, intent(in) :: place       !< as in the cells
    node = sector*body%nodes_per_sector + place
    if (node > body%sectors*body%nodes_per_sector) node = node - body%sectors*body%nodes_per_sector
  end function group_node

  !> Couple the faces, and place struts, where they are; nothing to do for pairs that stay those at rest.
  subroutine pair_bodies(problem, u, again)
    type(problem_t), intent(inout) :: problem  !< gets its mortar and its struts anew
    real(dp), intent(in) :: u(:, :)            !< displacements (3, n) [m]
    logical, intent(in), optional :: again     !< as of pair_faces
    type(strut_t) :: new
    integer :: i, k, n
    logical :: same
    if (.not. allocated(problem%pairing)) return
    call pair_faces(problem%pairing, u, problem%mortar, again)
    if (.not. allocated(problem%placing)) return
    n = size(problem%placing%struts)
    if (.not. allocated(problem%strut_shift)) allocate (problem%strut_shift(n))
    problem%strut_foot = [(problem%placing%foot(i, u), i=1, n)]
    do i = 1, n
      k = problem%placing%struts(i)
      new = problem%struts(k)
      call problem%placing%place(i, new, problem%strut_shift(i), u)
      same = size(new%node) == size(problem%struts(k)%node)
      if (same) same = all(new%node == problem%struts(k)%node) .and. &
        all((abs(new%weight) > 0) .eqv. (abs(problem%struts(k)%weight) > 0))
      if (.not. same) problem%mortar%pattern = problem%mortar%serial
      problem%struts(k) = new
    end do
  end subroutine pair_bodies

  !> Gap and total tangential displacement of the master against the slave. Points that are paired anew add the way of the load
  !> step, in their present frame, to the way before.
  subroutine gap_and_slip(problem, load, previous, state)
    type(problem_t), intent(in) :: problem   !< problem
    type(load_t), intent(in) :: load         !< load
    type(state_t), intent(in) :: previous    !< state at the beginning of the load step
    type(state_t), intent(inout) :: state    !< gets gap and slip from its displacements
    real(dp) :: w(3, problem%mortar%n)
    w = relative_displacement(problem%mortar, state%u)
    state%gap = load%gap + w(1, :)
    state%slip = w(2:, :)
    if (.not. allocated(problem%mortar%turn)) return
    state%gap = state%gap + problem%mortar%offset(1, :)
    w = relative_displacement(problem%mortar, previous%u)
    state%slip = previous%slip + state%slip - w(2:, :)
  end subroutine gap_and_slip
end module hd_problem
