! SPDX-License-Identifier: GPL-3.0-or-later
module test_element
  use hd_body, only: body_t
  use hd_check, only: check, check_close
  use hd_error, only: error_t
  use hd_face, only: face_t
  use hd_hexahedron, only: elasticity_matrix, element_stiffness, hex20r, hex8, hex8i, natural_coordinates, nodes_per_element, &
    shape_hexahedron
  use hd_kinds, only: dp
  use hd_newton, only: iterate, iteration_t, newton_options_t
  use hd_newton_matrix, only: new_newton_matrix, newton_matrix_t
  use hd_problem, only: load_t, new_problem, new_state, problem_t, state_t
  use hd_revolution, only: revolve, strip_face, strip_t
  implicit none
  private
  public :: run_element

  real(dp), parameter :: young = 210e9_dp, poisson = 0.3_dp

contains

  subroutine run_element()
    integer, parameter :: kinds(3) = [hex8, hex8i, hex20r]
    character(len=6), parameter :: names(3) = ['hex8  ', 'hex8i ', 'hex20r']
    integer :: i
    do i = 1, 3
      call patch(kinds(i), names(i))
      call shapes(kinds(i), names(i))
    end do
    call inverted()
    call ring(hex8i, 40, 0.04_dp)
    call ring(hex8i, 80, 0.01_dp)
    call ring(hex20r, 40, 0.001_dp)
  end subroutine run_element

  !> Nodes of a distorted unit cube; mid-side nodes on straight edges.
  pure function distorted(kind) result(x)
    integer, intent(in) :: kind
    real(dp) :: x(3, nodes_per_element(kind))
    integer, parameter :: ends(2, 12) = reshape([1, 2, 2, 3, 3, 4, 4, 1, 5, 6, 6, 7, 7, 8, 8, 5, 1, 5, 2, 6, 3, 7, 4, 8], [2, 12])
    integer :: k
    x(:, :8) = reshape([0._dp, 0._dp, 0._dp, 1.1_dp, 0.1_dp, 0._dp, 1._dp, 0.9_dp, 0.2_dp, -0.1_dp, 1._dp, 0.1_dp, &
      0.1_dp, -0.1_dp, 1._dp, 0.9_dp, 0.2_dp, 1.2_dp, 1.2_dp, 1.1_dp, 0.9_dp, 0._dp, 0.8_dp, 1.1_dp], [3, 8])
    if (kind /= hex20r) return
    do k = 1, 12
      x(:, 8 + k) = 0.5_dp*(x(:, ends(1, k)) + x(:, ends(2, k)))
    end do
  end function distorted

  !> A shape function is one at its node, zero at the others; they sum to one, their derivatives are those of differences.
  subroutine shapes(kind, name)
    integer, intent(in) :: kind
    character(len=*), intent(in) :: name
    real(dp), parameter :: inside(3) = [0.3_dp, -0.2_dp, 0.6_dp], step = 1e-4_dp
    real(dp), dimension(nodes_per_element(kind)) :: n, low, high, unit
    real(dp) :: dn(3, nodes_per_element(kind)), other(3, nodes_per_element(kind)), move(3)
    integer :: a, d
    do a = 1, size(n)
      unit = 0
      unit(a) = 1
      call shape_hexahedron(kind, natural_coordinates(a), n, dn)
      call check_close(maxval(abs(n - unit)), 0._dp, 1e-15_dp, name//': a shape function is one at its node alone')
    end do
    call shape_hexahedron(kind, inside, n, dn)
    call check_close(sum(n), 1._dp, 1e-14_dp, name//': the shape functions sum to one')
    do d = 1, 3
      move = 0
      move(d) = step
      call shape_hexahedron(kind, inside - move, low, other)
      call shape_hexahedron(kind, inside + move, high, other)
      call check_close(maxval(abs(dn(d, :) - (high - low)/(2*step))), 0._dp, 1e-7_dp, name//': their derivatives are right')
    end do
  end subroutine shapes

  !> A linear displacement field gives nodal forces that no self-balanced virtual linear field notices, and exact energy.
  subroutine patch(kind, name)
    integer, intent(in) :: kind
    character(len=*), intent(in) :: name
    real(dp), allocatable :: x(:, :), ke(:, :), u(:), f(:)
    real(dp) :: c(6, 6), grad(3, 3), strain(6), volume, moment(3), scale
    type(error_t), allocatable :: error
    integer :: a, n, p
    n = nodes_per_element(kind)
    x = distorted(kind)
    allocate (ke(3*n, 3*n), u(3*n))
    c = elasticity_matrix(young, poisson)
    call element_stiffness(kind, x, c, ke, error)
    call check(.not. allocated(error), name//': a distorted element has a stiffness')
    grad = reshape([1._dp, 0.3_dp, -0.2_dp, 0.5_dp, -1._dp, 0.4_dp, 0.1_dp, 0.7_dp, 0.6_dp], [3, 3])*1e-3_dp
    do a = 1, n
      u(3*a - 2:3*a) = matmul(grad, x(:, a))
    end do
    strain = [grad(1, 1), grad(2, 2), grad(3, 3), grad(1, 2) + grad(2, 1), grad(2, 3) + grad(3, 2), grad(3, 1) + grad(1, 3)]
    volume = cube_volume(kind, x)
    f = matmul(ke, u)
    call check_close(dot_product(u, f)/(volume*dot_product(strain, matmul(c, strain))), 1._dp, 1e-12_dp, &
      name//': patch test, constant strain stores its exact energy in a distorted element')
    scale = maxval(abs(f))
    do p = 1, 3
      call check_close(sum(f(p::3))/scale, 0._dp, 1e-12_dp, name//': the nodal forces balance')
    end do
    moment = 0
    do a = 1, n
      moment = moment + [x(2, a)*f(3*a) - x(3, a)*f(3*a - 1), x(3, a)*f(3*a - 2) - x(1, a)*f(3*a), &
        x(1, a)*f(3*a - 1) - x(2, a)*f(3*a - 2)]
    end do
    call check_close(maxval(abs(moment))/scale, 0._dp, 1e-11_dp, name//': the moments of the nodal forces balance')
    do a = 1, n
      u(3*a - 2:3*a) = [-x(2, a), x(1, a), 0._dp]
    end do
    call check_close(maxval(abs(matmul(ke, u)))/maxval(abs(ke)), 0._dp, 1e-13_dp, name//': a small rotation costs no force')
  end subroutine patch

  !> Volume by the 2 x 2 x 2 rule, exact for straight edges.
  function cube_volume(kind, x) result(v)
    integer, intent(in) :: kind
    real(dp), intent(in) :: x(:, :)
    real(dp) :: v, n(20), dn(3, 20), j(3, 3)
    integer :: p
    v = 0
    do p = 0, 7
      call shape_hexahedron(kind, [merge(1, -1, btest(p, 0)), merge(1, -1, btest(p, 1)), merge(1, -1, btest(p, 2))]/ &
        sqrt(3._dp), n, dn)
      j = matmul(dn(:, :size(x, 2)), transpose(x))
      v = v + j(1, 1)*(j(2, 2)*j(3, 3) - j(2, 3)*j(3, 2)) - j(1, 2)*(j(2, 1)*j(3, 3) - j(2, 3)*j(3, 1)) &
        + j(1, 3)*(j(2, 1)*j(3, 2) - j(2, 2)*j(3, 1))
    end do
  end function cube_volume

  subroutine inverted()
    real(dp) :: x(3, 8), ke(24, 24)
    type(error_t), allocatable :: error
    x = distorted(hex8)
    x(1, :) = -x(1, :)
    call element_stiffness(hex8, x, elasticity_matrix(young, poisson), ke, error)
    call check(allocated(error), 'an inverted element is refused')
  end subroutine inverted

  !> A ring of 0.3 mm wall, one element through it, bent by p cos 2 theta: error against the exact Michell solution.
  subroutine ring(kind, divisions, limit)
    integer, intent(in) :: kind, divisions
    real(dp), intent(in) :: limit
    real(dp), parameter :: r1 = 17.8e-3_dp, t = 0.3e-3_dp, height = 1e-3_dp
    type(strip_t) :: strip
    type(body_t) :: bodies(1)
    type(problem_t) :: problem
    type(face_t) :: face
    type(error_t), allocatable :: error
    real(dp) :: exact, actual
    strip%inner = reshape([r1, 0._dp, r1, height], [2, 2])
    strip%outer = reshape([r1 + t, 0._dp, r1 + t, height], [2, 2])
    call revolve(strip, divisions, kind, bodies(1))
    bodies%young = young
    bodies%poisson = poisson
    call new_problem(bodies, problem, error)
    exact = michell(r1, r1 + t)
    call strip_face(strip, bodies(1), 1, 1, 2, r1, face)
    actual = opening(problem, face)
    call check_close(actual/exact, 1._dp, limit, 'a thin ring under cos 2 theta does not lock')
  end subroutine ring

  !> Radial displacement at theta = 0 under a pressure cos 2 theta of 1 Pa on the face; plane strain, symmetric about the axes.
  function opening(problem, face) result(u)
    type(problem_t), intent(inout) :: problem
    type(face_t), intent(in) :: face
    real(dp) :: u
    type(newton_matrix_t) :: matrix
    type(load_t) :: load
    type(state_t) :: state, rest
    type(iteration_t), allocatable :: history(:)
    type(error_t), allocatable :: error
    real(dp) :: area
    integer :: f, a
    logical :: converged, sliding
    allocate (problem%mortar%node(0), problem%mortar%area(0), problem%mortar%col(0), problem%mortar%val(0))
    problem%mortar%ptr = [1]
    associate (angle => problem%bodies(1)%angle)
      problem%fixed(3, :) = .true.
      problem%fixed(2, :) = abs(sin(2*angle)) < 1e-9_dp
      allocate (load%displacement(3, problem%n), load%force(3, problem%n), source=0._dp)
      allocate (load%gap(0))
      do f = 1, size(face%nodes, 2)
        area = (face%chart(1, 2, f) - face%chart(1, 1, f))*(face%chart(2, 4, f) - face%chart(2, 1, f))
        associate (list => face%nodes(:, f))
          load%force(1, list) = load%force(1, list) + area*facet_weights(size(list))*cos(2*angle(list))
        end associate
      end do
    end associate
    call new_newton_matrix(problem, matrix, error)
    call new_state(problem, state)
    rest = state
    call iterate(problem, matrix, newton_options_t(), load, rest, state, history, converged, sliding, error)
    call check(converged .and. .not. allocated(error), 'a linear problem converges')
    a = face%nodes(1, 1)
    u = state%u(1, a)
    call matrix%release()
  end function opening

  !> Radial displacement at theta = 0 of the inner face under a radial pressure cos 2 theta of 1 Pa there, plane strain.
  !> Airy function (a r^2 + b r^4 + c / r^2 + d) cos 2 theta; the four constants from sigma_r and tau on both faces.
  real(dp) function michell(r1, r2)
    real(dp), intent(in) :: r1, r2
    real(dp) :: m(4, 5), r, e, nu, f
    integer :: i, j, k
    do i = 1, 2
      r = merge(r1, r2, i == 1)
      m(2*i - 1, :) = [-2._dp, 0._dp, -6/r**4, -4/r**2, merge(-1._dp, 0._dp, i == 1)]
      m(2*i, :) = [2._dp, 6*r**2, -6/r**4, -2/r**2, 0._dp]
    end do
    do k = 1, 4
      j = k - 1 + maxloc(abs(m(k:, k)), 1)
      m([k, j], :) = m([j, k], :)
      m(k, :) = m(k, :)/m(k, k)
      do i = 1, 4
        if (i /= k) m(i, :) = m(i, :) - m(i, k)*m(k, :)
      end do
    end do
    nu = poisson/(1 - poisson)
    e = young/(1 - poisson**2)
    r = r1
    f = -2*(1 + nu)*m(1, 5)*r - 4*nu*m(2, 5)*r**3 + 2*(1 + nu)*m(3, 5)/r**3 + 4*m(4, 5)/r
    michell = f/e
  end function michell

  !> Shares of a uniform load that the nodes of a rectangular facet of 4 or 8 nodes take (sum 1).
  pure function facet_weights(nodes) result(w)
    integer, intent(in) :: nodes
    real(dp) :: w(nodes)
    w = 0.25_dp
    if (nodes == 8) w = [spread(-1/12._dp, 1, 4), spread(1/3._dp, 1, 4)]
  end function facet_weights
end module test_element
