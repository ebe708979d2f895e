! SPDX-License-Identifier: GPL-3.0-or-later
!> A contact problem: bodies, supports, one mortar interface, and the fields that solve it.
module hd_problem
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_body, only: body_t, sector_stiffness, cell_nodes
  use hd_block_matrix, only: block_matrix_t, graph_from_cells, add_cell, multiply
  use hd_corotation, only: corotation_t, new_corotation, cell_response
  use hd_mortar, only: mortar_t, add_nodal_forces, relative_displacement
  use hd_contact_law, only: contact_law_t
  implicit none
  private
  public :: problem_t, state_t, load_t, new_problem, allow_rotations, update_tangent, add_springs, internal_residual, &
    gap_and_slip, new_state

  !> Nodes of the bodies are numbered one after the other: body b starts after first(b).
  type :: problem_t
    type(body_t), allocatable :: bodies(:)     !< bodies
    integer, allocatable :: first(:)           !< nodes before each body
    integer :: n = 0                           !< nodes
    type(block_matrix_t) :: stiffness          !< of all bodies and springs, nothing removed; with large rotations the tangent
    type(corotation_t), allocatable :: corotation(:)  !< of each body, if rotations may be large
    logical, allocatable :: fixed(:, :)        !< prescribed dofs (3, n)
    real(dp), allocatable :: spring(:, :)      !< springs to the ground, part of the stiffness (3, n) [N/m]
    type(mortar_t) :: mortar                   !< interface
    type(contact_law_t) :: law                 !< its law
  end type problem_t

  !> What a load step prescribes.
  type :: load_t
    real(dp), allocatable :: displacement(:, :)  !< values of the fixed dofs (3, n) [m]
    real(dp), allocatable :: force(:, :)         !< nodal forces (3, n) [N]
    real(dp), allocatable :: gap(:)              !< initial gap (multipliers), negative for interference [m]
  end type load_t

  !> Fields of a converged step (or an iterate).
  type :: state_t
    real(dp), allocatable :: u(:, :)         !< displacements (3, n) [m]
    real(dp), allocatable :: traction(:, :)  !< on the master, normal first (3, multipliers) [Pa]
    real(dp), allocatable :: slip(:, :)      !< relative tangential displacement (2, multipliers) [m]
    real(dp), allocatable :: gap(:)          !< gap (multipliers) [m]
    integer, allocatable :: contact(:)       !< open, stick or slip (multipliers)
  end type state_t

contains

  !> Assemble the stiffness of the bodies; supports and interface are set by the caller afterwards.
  subroutine new_problem(bodies, problem, error)
    type(body_t), intent(in) :: bodies(:)             !< bodies of one element kind
    type(problem_t), intent(out) :: problem           !< problem without supports
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    real(dp), allocatable :: ke(:, :, :)
    integer, allocatable :: cells(:, :)
    integer :: b, s, c, m
    problem%bodies = bodies
    allocate (problem%first(size(bodies)))
    m = 0
    do b = 1, size(bodies)
      problem%first(b) = problem%n
      problem%n = problem%n + bodies(b)%nodes()
      m = m + bodies(b)%sectors*size(bodies(b)%cells, 2)
    end do
    allocate (cells(size(bodies(1)%cells, 1), m), problem%fixed(3, problem%n))
    problem%fixed = .false.
    allocate (problem%spring(3, problem%n), source=0._dp)
    m = 0
    do b = 1, size(bodies)
      do s = 0, bodies(b)%sectors - 1
        do c = 1, size(bodies(b)%cells, 2)
          m = m + 1
          cells(:, m) = problem%first(b) + cell_nodes(bodies(b), c, s)
        end do
      end do
    end do
    call graph_from_cells(problem%n, cells, problem%stiffness)
    m = 0
    do b = 1, size(bodies)
      call sector_stiffness(bodies(b), ke, error)
      if (allocated(error)) return
      do s = 0, bodies(b)%sectors - 1
        do c = 1, size(bodies(b)%cells, 2)
          m = m + 1
          call add_cell(problem%stiffness, cells(:, m), ke(:, :, c))
        end do
      end do
    end do
  end subroutine new_problem

  !> Springs from single dofs to the ground.
  subroutine add_springs(problem, nodes, component, rate)
    type(problem_t), intent(inout) :: problem  !< problem
    integer, intent(in) :: nodes(:)            !< nodes
    integer, intent(in) :: component           !< dof 1 to 3
    real(dp), intent(in) :: rate               !< stiffness at each node [N/m]
    integer :: i, k
    do i = 1, size(nodes)
      problem%spring(component, nodes(i)) = problem%spring(component, nodes(i)) + rate
      do k = problem%stiffness%ptr(nodes(i)), problem%stiffness%ptr(nodes(i) + 1) - 1
        if (problem%stiffness%col(k) /= nodes(i)) cycle
        problem%stiffness%val(component, component, k) = problem%stiffness%val(component, component, k) + rate
      end do
    end do
  end subroutine add_springs

  !> State of rest.
  pure subroutine new_state(problem, state)
    type(problem_t), intent(in) :: problem  !< problem
    type(state_t), intent(out) :: state     !< zero everywhere
    allocate (state%u(3, problem%n), source=0._dp)
    allocate (state%traction(3, problem%mortar%n), source=0._dp)
    allocate (state%slip(2, problem%mortar%n), source=0._dp)
    allocate (state%gap(problem%mortar%n), source=0._dp)
    allocate (state%contact(problem%mortar%n), source=0)
  end subroutine new_state

  !> Out-of-balance nodal forces K u - f - B^T t [N]; at fixed dofs these are the reactions.
  pure function internal_residual(problem, load, state) result(r)
    type(problem_t), intent(in) :: problem  !< problem
    type(load_t), intent(in) :: load        !< load
    type(state_t), intent(in) :: state      !< iterate
    real(dp) :: r(3, problem%n), f(3, problem%n)
    f = load%force
    call add_nodal_forces(problem%mortar, state%traction, f)
    if (allocated(problem%corotation)) then
      r = rotated_forces(problem, state%u) + problem%spring*state%u - f
    else
      r = multiply(problem%stiffness, state%u) - f
    end if
  end function internal_residual

  !> Allow large rotations of the elements from here on.
  subroutine allow_rotations(problem, error)
    type(problem_t), intent(inout) :: problem         !< problem
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    integer :: b
    allocate (problem%corotation(size(problem%bodies)))
    do b = 1, size(problem%bodies)
      call new_corotation(problem%bodies(b), problem%corotation(b), error)
      if (allocated(error)) return
    end do
  end subroutine allow_rotations

  !> Nodal forces of the deformed bodies under large rotations [N].
  pure function rotated_forces(problem, u) result(f)
    type(problem_t), intent(in) :: problem  !< problem
    real(dp), intent(in) :: u(:, :)         !< displacements (3, n) [m]
    real(dp) :: f(3, problem%n), part(3, size(problem%bodies(1)%cells, 1))
    integer :: b, c, s, list(size(problem%bodies(1)%cells, 1))
    f = 0
    do b = 1, size(problem%bodies)
      do s = 0, problem%bodies(b)%sectors - 1
        do c = 1, size(problem%bodies(b)%cells, 2)
          list = problem%first(b) + cell_nodes(problem%bodies(b), c, s)
          call cell_response(problem%bodies(b), problem%corotation(b), c, u(:, list), part)
          f(:, list) = f(:, list) + part
        end do
      end do
    end do
  end function rotated_forces

  !> Bring the stiffness up to date with the displacements; nothing to do for small displacements.
  subroutine update_tangent(problem, u)
    type(problem_t), intent(inout) :: problem  !< problem
    real(dp), intent(in) :: u(:, :)            !< displacements (3, n) [m]
    real(dp) :: part(3, size(problem%bodies(1)%cells, 1))
    real(dp) :: tangent(3*size(problem%bodies(1)%cells, 1), 3*size(problem%bodies(1)%cells, 1)), spring(3, problem%n)
    integer :: b, c, s, list(size(problem%bodies(1)%cells, 1))
    if (.not. allocated(problem%corotation)) return
    problem%stiffness%val = 0
    do b = 1, size(problem%bodies)
      do s = 0, problem%bodies(b)%sectors - 1
        do c = 1, size(problem%bodies(b)%cells, 2)
          list = problem%first(b) + cell_nodes(problem%bodies(b), c, s)
          call cell_response(problem%bodies(b), problem%corotation(b), c, u(:, list), part, tangent)
          call add_cell(problem%stiffness, list, tangent)
        end do
      end do
    end do
    spring = problem%spring
    problem%spring = 0
    do c = 1, 3
      do b = 1, problem%n
        if (spring(c, b) > 0) call add_springs(problem, [b], c, spring(c, b))
      end do
    end do
  end subroutine update_tangent

  !> Gap and total tangential displacement of the master against the slave.
  pure subroutine gap_and_slip(problem, load, state)
    type(problem_t), intent(in) :: problem   !< problem
    type(load_t), intent(in) :: load         !< load
    type(state_t), intent(inout) :: state    !< gets gap and slip from its displacements
    real(dp) :: w(3, problem%mortar%n)
    w = relative_displacement(problem%mortar, state%u)
    state%gap = load%gap + w(1, :)
    state%slip = w(2:, :)
  end subroutine gap_and_slip
end module hd_problem
