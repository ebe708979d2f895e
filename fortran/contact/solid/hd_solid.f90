! SPDX-License-Identifier: GPL-3.0-or-later
!> Contact problems on meshes of the caller's own: bodies, one interface, load steps, all as plain arrays.
module hd_solid
  use hd_kinds, only: dp
  use hd_body, only: body_t
  use hd_contact_law, only: contact_mode
  use hd_error, only: error_t, raise, code_not_converged
  use hd_face, only: face_t
  use hd_hexahedron, only: element_kind
  use hd_mortar, only: new_mortar
  use hd_newton, only: iterate, iteration_t, newton_options_t
  use hd_newton_matrix, only: new_newton_matrix, newton_matrix_t
  use hd_problem, only: internal_residual, load_t, new_problem, new_state, problem_t, state_t
  use hd_text, only: to_text
  implicit none
  private
  public :: new_solid, new_interface, solid_steps

contains

  !> Bodies with one element kind; body b owns the nodes and cells up to node_end(b) and cell_end(b).
  subroutine new_solid(element, node_end, cell_end, material, x, angle, cells, problem, error)
    character(len=*), intent(in) :: element           !< hex8, hex8i or hex20r
    integer, intent(in) :: node_end(:), cell_end(:)   !< last node and last cell of each body
    real(dp), intent(in) :: material(:, :)            !< Young's modulus [Pa], Poisson's ratio (2, bodies)
    real(dp), intent(in) :: x(:, :)                   !< node coordinates (3, n) [m]
    real(dp), intent(in) :: angle(:)                  !< direction of the first dof in the x-y plane (n) [rad]
    integer, intent(in) :: cells(:, :)                !< nodes of the cells (nodes per cell, cells)
    type(problem_t), intent(out) :: problem           !< problem without supports
    type(error_t), allocatable, intent(out) :: error  !< unknown element, inverted element
    type(body_t) :: bodies(size(node_end))
    integer :: b, first, first_cell, kind
    call element_kind(element, kind, error)
    if (allocated(error)) return
    first = 0
    first_cell = 0
    do b = 1, size(bodies)
      bodies(b)%kind = kind
      bodies(b)%nodes_per_sector = node_end(b) - first
      bodies(b)%x = x(:, first + 1:node_end(b))
      bodies(b)%angle = angle(first + 1:node_end(b))
      bodies(b)%cells = cells(:, first_cell + 1:cell_end(b)) - first
      bodies(b)%young = material(1, b)
      bodies(b)%poisson = material(2, b)
      first = node_end(b)
      first_cell = cell_end(b)
    end do
    call new_problem(bodies, problem, error)
  end subroutine new_solid

  !> Couple two faces by a contact law.
  subroutine new_interface(problem, slave, master, mode, constants, error)
    type(problem_t), intent(inout) :: problem         !< gets mortar and law
    type(face_t), intent(in) :: slave, master         !< faces on one chart, nodes in the common numbering
    character(len=*), intent(in) :: mode              !< bonded, frictionless or frictional
    real(dp), intent(in) :: constants(2)              !< Coulomb coefficient, scale of the iteration [Pa/m]
    type(error_t), allocatable, intent(out) :: error  !< unknown mode
    call contact_mode(mode, problem%law%mode, error)
    if (allocated(error)) return
    problem%law%friction = constants(1)
    problem%law%scale = constants(2)
    call new_mortar(slave, master, problem%mortar)
  end subroutine new_interface

  !> Load steps one after the other, each from the state before it.
  subroutine solid_steps(problem, displacement, force, gap, tolerance, limit, u, reaction, traction, slip, opening, contact, &
      history, used, error)
    type(problem_t), intent(inout) :: problem         !< problem
    real(dp), intent(in) :: displacement(:, :, :)     !< of the fixed dofs (3, n, steps) [m]
    real(dp), intent(in) :: force(:, :, :)            !< nodal forces (3, n, steps) [N]
    real(dp), intent(in) :: gap(:, :)                 !< initial gap at slave nodes (n, steps) [m]
    real(dp), intent(in) :: tolerance                 !< relative residual
    integer, intent(in) :: limit                      !< Newton iterations per step
    real(dp), intent(inout) :: u(:, :, :)             !< displacements (3, n, steps) [m]
    real(dp), intent(inout) :: reaction(:, :, :)      !< forces of the supports (3, n, steps) [N]
    real(dp), intent(inout) :: traction(:, :, :)      !< on the master, normal first (3, n, steps) [Pa]
    real(dp), intent(inout) :: slip(:, :, :)          !< tangential displacement master - slave (2, n, steps) [m]
    real(dp), intent(inout) :: opening(:, :)          !< gap (n, steps) [m]
    integer, intent(inout) :: contact(:, :)           !< 0 open, 1 stick, 2 slip (n, steps)
    real(dp), intent(inout) :: history(:, :)          !< one column per iterate
    integer, intent(out) :: used                      !< columns of it
    type(error_t), allocatable, intent(out) :: error  !< no convergence, body not held, memory
    type(newton_matrix_t) :: matrix
    type(newton_options_t) :: options
    type(iteration_t), allocatable :: rows(:)
    type(state_t) :: previous, state
    type(load_t) :: load
    logical :: converged, sliding
    integer :: i, s
    used = 0
    options%tolerance = tolerance
    options%max_iterations = limit
    call new_newton_matrix(problem, matrix, error)
    call new_state(problem, state)
    do s = 1, size(gap, 2)
      if (allocated(error)) exit
      previous = state
      load = load_t(displacement(:, :, s), force(:, :, s), gap(problem%mortar%node, s), problem%law%friction)
      call iterate(problem, matrix, options, load, previous, state, rows, converged, sliding, error)
      if (allocated(error)) exit
      do i = 1, min(size(rows), size(history, 2) - used)
        used = used + 1
        history(:, used) = [real(s, dp), real(rows(i)%iteration, dp), rows(i)%residual, real(rows(i)%changes, dp), &
          real(rows(i)%open, dp), real(rows(i)%stick, dp), real(rows(i)%slip, dp)]
      end do
      u(:, :, s) = state%u
      call internal_residual(problem, load, state, reaction(:, :, s))
      where (.not. problem%fixed) reaction(:, :, s) = 0
      traction(:, problem%mortar%node, s) = state%traction
      slip(:, problem%mortar%node, s) = state%slip
      opening(problem%mortar%node, s) = state%gap
      contact(problem%mortar%node, s) = state%contact
      if (maxval(abs(state%u)) > extent(problem) + maxval(abs(displacement(:, :, s)))) then
        call raise(error, code_not_converged, 'in load step '//to_text(s)//' a body moves by '//to_text(maxval(abs(state%u)))// &
          ' m, farther than all are long: neither its supports nor the contact hold it; fix more of its nodes')
      else if (.not. converged) then
        call raise(error, code_not_converged, 'load step '//to_text(s)//' did not converge in '//to_text(limit)// &
          ' iterations: residual '//to_text(rows(size(rows))%residual)//'; take smaller load steps or more iterations')
      end if
    end do
    call matrix%release()
  end subroutine solid_steps

  !> Largest length of all bodies together along an axis [m].
  pure real(dp) function extent(problem)
    type(problem_t), intent(in) :: problem  !< problem
    real(dp) :: low(3), high(3)
    integer :: b
    low = huge(low)
    high = -low
    do b = 1, size(problem%bodies)
      low = min(low, minval(problem%bodies(b)%x, 2))
      high = max(high, maxval(problem%bodies(b)%x, 2))
    end do
    extent = maxval(high - low)
  end function extent
end module hd_solid
