! SPDX-License-Identifier: GPL-3.0-or-later
module test_element
  use hd_check, only: check, check_close
  use hd_error, only: error_t
  use hd_hexahedron, only: elasticity_matrix, element_stiffness, hex20r, hex8, hex8i, natural_coordinates, nodes_per_element, &
    shape_hexahedron
  use hd_kinds, only: dp
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
end module test_element
