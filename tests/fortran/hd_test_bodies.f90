! SPDX-License-Identifier: GPL-3.0-or-later
!> Bodies and contact problems that several tests solve: blocks, rings, one load step.
module hd_test_bodies
  use hd_body, only: body_t
  use hd_check, only: check
  use hd_contact_law, only: contact_law_t, frictional
  use hd_error, only: error_t
  use hd_face, only: face_t
  use hd_hexahedron, only: hex8i
  use hd_kinds, only: dp
  use hd_mortar, only: new_mortar
  use hd_newton, only: iterate, iteration_t, newton_options_t
  use hd_newton_matrix, only: new_newton_matrix, newton_matrix_t
  use hd_problem, only: load_t, new_problem, new_state, problem_t, state_t
  use hd_revolution, only: revolve, strip_face, strip_t
  implicit none
  private
  public :: block, press_blocks, two_rings, new_problem_of, solve

contains

  !> A block of nx x ny x nz cells between two corners, Cartesian dofs; its nodes are numbered x fastest.
  function block(n, low, high) result(body)
    integer, intent(in) :: n(3)
    real(dp), intent(in) :: low(3), high(3)
    type(body_t) :: body
    integer :: i, j, k, c, a
    body%kind = hex8i
    body%young = 200e9_dp
    body%poisson = 0.3_dp
    body%nodes_per_sector = product(n + 1)
    allocate (body%x(3, body%nodes_per_sector), body%angle(body%nodes_per_sector), body%cells(8, product(n)))
    body%angle = 0
    c = 0
    do k = 0, n(3)
      do j = 0, n(2)
        do i = 0, n(1)
          a = node(i, j, k)
          body%x(:, a) = low + (high - low)*[i, j, k]/n
          if (i == n(1) .or. j == n(2) .or. k == n(3)) cycle
          c = c + 1
          body%cells(:, c) = [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k), &
            node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)]
        end do
      end do
    end do
  contains
    pure integer function node(i, j, k)
      integer, intent(in) :: i, j, k
      node = 1 + i + (n(1) + 1)*(j + (n(2) + 1)*k)
    end function node
  end function block

  !> Face of a block at constant x: chart (y, z). The contact normal is the first dof.
  function block_face(body, n, side) result(face)
    type(body_t), intent(in) :: body
    integer, intent(in) :: n(3), side
    type(face_t) :: face
    integer :: j, k, f, a
    allocate (face%nodes(4, n(2)*n(3)), face%chart(2, 4, n(2)*n(3)))
    f = 0
    do j = 0, n(2) - 1
      do k = 0, n(3) - 1
        f = f + 1
        a = 1 + side + (n(1) + 1)*(j + (n(2) + 1)*k)
        face%nodes(:, f) = [a, a + n(1) + 1, a + (n(1) + 1)*(n(2) + 2), a + (n(1) + 1)*(n(2) + 1)]
        face%chart(:, :, f) = body%x(2:, face%nodes(:, f))
      end do
    end do
  end function block_face

  !> Two blocks whose meshes do not match, one held, the other under an even pressure on its far side.
  subroutine press_blocks(pressure, swap, problem, load, x)
    real(dp), intent(in) :: pressure        !< [Pa]
    logical, intent(in) :: swap             !< the finer mesh is that of the block that is held
    type(problem_t), intent(out) :: problem
    type(load_t), intent(out) :: load
    real(dp), allocatable, intent(out) :: x(:, :)  !< places of the nodes [m]
    integer, parameter :: n1(3) = [2, 3, 4], n2(3) = [2, 5, 3]
    type(body_t) :: bodies(2)
    type(face_t) :: slave, master, pushed
    real(dp) :: area
    integer :: f
    bodies(1) = block(merge(n2, n1, swap), [0._dp, 0._dp, 0._dp], [1e-2_dp, 2e-2_dp, 2e-2_dp])
    bodies(2) = block(merge(n1, n2, swap), [1e-2_dp, 0._dp, 0._dp], [2e-2_dp, 2e-2_dp, 2e-2_dp])
    slave = block_face(bodies(1), merge(n2, n1, swap), 2)
    master = block_face(bodies(2), merge(n1, n2, swap), 0)
    pushed = block_face(bodies(2), merge(n1, n2, swap), 2)
    master%nodes = master%nodes + bodies(1)%nodes()
    pushed%nodes = pushed%nodes + bodies(1)%nodes()
    call new_problem_of(bodies, slave, master, frictional, problem)
    x = reshape([bodies(1)%x, bodies(2)%x], [3, problem%n])
    problem%fixed = x < 1e-12_dp
    allocate (load%force(3, problem%n), source=0._dp)
    do f = 1, size(pushed%nodes, 2)
      area = (pushed%chart(1, 2, f) - pushed%chart(1, 1, f))*(pushed%chart(2, 4, f) - pushed%chart(2, 1, f))
      load%force(1, pushed%nodes(:, f)) = load%force(1, pushed%nodes(:, f)) - pressure*area/4
    end do
  end subroutine press_blocks

  !> Two rings that touch at 20 mm, outer slave on inner master or the reverse numbering of the master.
  subroutine two_rings(kind, n_inner, n_outer, inner, outer, slave, master)
    integer, intent(in) :: kind, n_inner, n_outer
    type(body_t), intent(out) :: inner, outer
    type(face_t), intent(out) :: slave, master
    type(strip_t) :: strip
    real(dp), parameter :: z(3) = [0._dp, 2e-3_dp, 5e-3_dp]
    strip%layers = 3
    strip%inner = reshape([10e-3_dp, z(1), 10e-3_dp, z(2), 10e-3_dp, z(3)], [2, 3])
    strip%outer = reshape([20e-3_dp, z(1), 20e-3_dp, z(2), 20e-3_dp, z(3)], [2, 3])
    call revolve(strip, n_inner, kind, inner)
    call strip_face(strip, inner, 4, 1, 3, 20e-3_dp, slave)
    strip%inner = reshape([20e-3_dp, z(1), 20e-3_dp, z(1) + 1e-3_dp, 20e-3_dp, z(3)], [2, 3])
    strip%outer = reshape([30e-3_dp, z(1), 30e-3_dp, z(1) + 1e-3_dp, 30e-3_dp, z(3)], [2, 3])
    call revolve(strip, n_outer, kind, outer)
    call strip_face(strip, outer, 1, 1, 3, 20e-3_dp, master)
    inner%young = 210e9_dp
    inner%poisson = 0.3_dp
    outer%young = 110e9_dp
    outer%poisson = 0.25_dp
    master%nodes = master%nodes + inner%nodes()
  end subroutine two_rings

  !> A problem of bodies and two faces, friction 0.2.
  subroutine new_problem_of(bodies, slave, master, mode, problem)
    type(body_t), intent(in) :: bodies(:)
    type(face_t), intent(in) :: slave, master
    integer, intent(in) :: mode
    type(problem_t), intent(out) :: problem
    type(error_t), allocatable :: error
    call new_problem(bodies, problem, error)
    call check(.not. allocated(error), 'the bodies assemble')
    call new_mortar(slave, master, problem%mortar)
    problem%law = contact_law_t(mode, 0.2_dp, 1e13_dp)
  end subroutine new_problem_of

  !> One load step from rest, with exact factors.
  subroutine solve(problem, gap, load, state)
    type(problem_t), intent(inout) :: problem
    real(dp), intent(in) :: gap(:)
    type(load_t), intent(inout) :: load
    type(state_t), intent(out) :: state
    type(newton_matrix_t) :: matrix
    type(state_t) :: rest
    type(iteration_t), allocatable :: history(:)
    type(error_t), allocatable :: error
    type(newton_options_t) :: options
    logical :: converged, sliding
    if (.not. allocated(load%force)) allocate (load%force(3, problem%n), source=0._dp)
    if (.not. allocated(load%displacement)) allocate (load%displacement(3, problem%n), source=0._dp)
    load%gap = gap
    load%friction = problem%law%friction
    options%tolerance = 1e-12_dp
    call new_newton_matrix(problem, matrix, error)
    call new_state(problem, rest)
    state = rest
    if (.not. allocated(error)) call iterate(problem, matrix, options, load, rest, state, history, converged, sliding, error)
    call check(converged .and. .not. allocated(error), 'the contact problem converges')
    call matrix%release()
  end subroutine solve
end module hd_test_bodies
