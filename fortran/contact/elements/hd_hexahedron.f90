! SPDX-License-Identifier: GPL-3.0-or-later
!> Hexahedral elements: shape functions and linear-elastic stiffness.
!>
!> Three elements: `hex8` (full integration, locks in bending: the reference for locking), `hex8i` (three incompatible
!> displacement modes per direction, Wilson 1973 with the correction of Taylor, Beresford and Wilson 1976, condensed) and
!> `hex20r` (serendipity, 2 x 2 x 2 points). Node order is that of VTK types 12 and 25.
module hd_hexahedron
  use hd_gauss, only: gauss_2
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_lapack, only: inverse_factor, multiply_dense, multiply_transposed
  use hd_text, only: to_text
  implicit none
  private
  public :: nodes_per_element, element_kind, shape_hexahedron, elasticity_matrix, strain_matrix
  public :: natural_coordinates, element_points, element_stiffness, points, hex8, hex8i, hex20r

  integer, parameter :: hex8 = 1    !< trilinear, full integration
  integer, parameter :: hex8i = 2   !< trilinear with incompatible modes
  integer, parameter :: hex20r = 3  !< serendipity quadratic, reduced integration
  integer, parameter :: points = 8  !< Gauss points

  !> Natural coordinates of the 20 nodes (the first 8 are the corners).
  real(dp), parameter :: corner(3, 20) = reshape([ &
    -1._dp, -1._dp, -1._dp, 1._dp, -1._dp, -1._dp, 1._dp, 1._dp, -1._dp, -1._dp, 1._dp, -1._dp, &
    -1._dp, -1._dp, 1._dp, 1._dp, -1._dp, 1._dp, 1._dp, 1._dp, 1._dp, -1._dp, 1._dp, 1._dp, &
    0._dp, -1._dp, -1._dp, 1._dp, 0._dp, -1._dp, 0._dp, 1._dp, -1._dp, -1._dp, 0._dp, -1._dp, &
    0._dp, -1._dp, 1._dp, 1._dp, 0._dp, 1._dp, 0._dp, 1._dp, 1._dp, -1._dp, 0._dp, 1._dp, &
    -1._dp, -1._dp, 0._dp, 1._dp, -1._dp, 0._dp, 1._dp, 1._dp, 0._dp, -1._dp, 1._dp, 0._dp], [3, 20])
  real(dp), parameter :: at_rest(3, 3) = reshape([1._dp, 0._dp, 0._dp, 0._dp, 1._dp, 0._dp, 0._dp, 0._dp, 1._dp], [3, 3])

contains

  !> Element kind from its name.
  subroutine element_kind(name, kind, error)
    character(len=*), intent(in) :: name  !< hex8, hex8i or hex20r
    integer, intent(out) :: kind          !< hex8, hex8i or hex20r
    type(error_t), allocatable, intent(out) :: error
    kind = 0
    select case (name)
    case ('hex8'); kind = hex8
    case ('hex8i'); kind = hex8i
    case ('hex20r'); kind = hex20r
    case default
      call raise(error, code_input, "element '"//name//"' is unknown; valid: hex8, hex8i, hex20r")
    end select
  end subroutine element_kind

  !> Natural coordinates of a node, from -1 to 1.
  pure function natural_coordinates(node) result(xi)
    integer, intent(in) :: node  !< 1 to 20
    real(dp) :: xi(3)
    xi = corner(:, node)
  end function natural_coordinates

  !> Number of nodes of an element kind.
  elemental integer function nodes_per_element(kind) result(n)
    integer, intent(in) :: kind  !< element kind
    n = merge(20, 8, kind == hex20r)
  end function nodes_per_element

  !> Isotropic elasticity matrix in the order xx, yy, zz, xy, yz, zx with engineering shear strains [Pa].
  pure function elasticity_matrix(young, poisson) result(c)
    real(dp), intent(in) :: young    !< Young's modulus [Pa]
    real(dp), intent(in) :: poisson  !< Poisson's ratio
    real(dp) :: c(6, 6), lambda, shear
    integer :: i
    lambda = young*poisson/((1 + poisson)*(1 - 2*poisson))
    shear = young/(2*(1 + poisson))
    c = 0
    c(1:3, 1:3) = lambda
    do i = 1, 3
      c(i, i) = lambda + 2*shear
      c(i + 3, i + 3) = shear
    end do
  end function elasticity_matrix

  !> Shape functions and their derivatives by the natural coordinates.
  pure subroutine shape_hexahedron(kind, xi, n, dn)
    integer, intent(in) :: kind        !< element kind
    real(dp), intent(in) :: xi(3)      !< natural coordinates in [-1, 1]
    real(dp), intent(out) :: n(:)      !< shape functions (nodes)
    real(dp), intent(out) :: dn(:, :)  !< derivatives (3, nodes)
    real(dp) :: f(3), g(3), s
    integer :: a, d, e, k
    do a = 1, nodes_per_element(kind)
      f = 1 + xi*corner(:, a)
      g = corner(:, a)
      if (kind /= hex20r) then
        n(a) = product(f)/8
        do d = 1, 3
          dn(d, a) = g(d)*product(f, mask=[(k /= d, k=1, 3)])/8
        end do
      else if (a <= 8) then
        s = sum(xi*g) - 2
        n(a) = product(f)*s/8
        do d = 1, 3
          dn(d, a) = g(d)*product(f, mask=[(k /= d, k=1, 3)])*(s + f(d))/8
        end do
      else
        e = minloc(abs(g), 1)
        f(e) = 1 - xi(e)**2
        g(e) = -2*xi(e)
        n(a) = product(f)/4
        do d = 1, 3
          dn(d, a) = g(d)*product(f, mask=[(k /= d, k=1, 3)])/4
        end do
      end if
    end do
  end subroutine shape_hexahedron

  !> Stiffness of one element, dofs ordered node by node (x, y, z) [N/m].
  subroutine element_stiffness(kind, x, c, ke, error)
    integer, intent(in) :: kind       !< element kind
    real(dp), intent(in) :: x(:, :)   !< node coordinates (3, nodes) [m]
    real(dp), intent(in) :: c(6, 6)   !< elasticity matrix [Pa]
    real(dp), intent(out) :: ke(:, :) !< stiffness (3 nodes, 3 nodes)
    type(error_t), allocatable, intent(out) :: error  !< inverted element
    real(dp) :: g(size(x, 2), 3, points), weight(points), b(3*size(x, 2), 6, points)
    real(dp), allocatable :: condensed_modes(:, :)
    integer :: p
    call element_points(kind, x, c, g, weight, condensed_modes, error)
    if (allocated(error)) return
    do p = 1, points
      call strain_matrix(g(:, :, p), at_rest, b(:, :, p))
    end do
    call point_stiffness(b, c, weight, condensed_modes, ke)
  end subroutine element_stiffness

  !> Gradients and weights at the Gauss points, and what the incompatible modes ease. With e the strains at all points an
  !> element stores W = e.D e/2, D = diag(weight C) - A A^T: the modes M follow at once, A = diag(weight C) M L^-T,
  !> L L^T = M^T diag(weight C) M.
  subroutine element_points(kind, x, c, g, weight, condensed_modes, error)
    integer, intent(in) :: kind                          !< element kind
    real(dp), intent(in) :: x(:, :)                      !< node coordinates (3, nodes) [m]
    real(dp), intent(in) :: c(6, 6)                      !< elasticity matrix [Pa]
    real(dp), intent(out) :: g(:, :, :)                  !< gradients of the shape functions (nodes, 3, points) [1/m]
    real(dp), intent(out) :: weight(points)              !< volume of each point [m^3]
    real(dp), allocatable, intent(out) :: condensed_modes(:, :)    !< A (6 points, modes); no modes but in hex8i
    type(error_t), allocatable, intent(out) :: error     !< inverted element
    real(dp) :: n(20), dn(3, 20), jac(3, 3), inv(3, 3), inv0(3, 3), det0, xi(3), m(9, 6), cm(9, 6, points), kmm(9, 9)
    integer :: nn, p, i
    logical :: definite
    nn = nodes_per_element(kind)
    call shape_hexahedron(kind, [0._dp, 0._dp, 0._dp], n, dn)
    jac = matmul(dn(:, :nn), transpose(x(:, :nn)))
    call invert3(jac, inv0, det0)
    kmm = 0
    do p = 1, points
      xi = [(merge(gauss_2(2), gauss_2(1), btest(p - 1, i)), i=0, 2)]
      call shape_hexahedron(kind, xi, n, dn)
      jac = matmul(dn(:, :nn), transpose(x(:, :nn)))
      call invert3(jac, inv, weight(p))
      if (.not. weight(p) > 0) then
        call raise(error, code_input, 'inverted element: Jacobian determinant '//to_text(weight(p))//' m^3 (valid: > 0)')
        return
      end if
      g(:, :, p) = matmul(transpose(dn(:, :nn)), transpose(inv))
      if (kind /= hex8i) cycle
      call strain_matrix(incompatible_gradient(xi, inv0)*(det0/weight(p)), at_rest, m)
      cm(:, :, p) = weight(p)*matmul(m, c)
      kmm = kmm + matmul(m, transpose(cm(:, :, p)))
    end do
    allocate (condensed_modes(6*points, merge(9, 0, kind == hex8i)))
    if (kind /= hex8i) return
    call inverse_factor(kmm, definite)
    if (.not. definite) then
      call raise(error, code_input, "the incompatible modes of an element have no stiffness: Young's modulus must be positive")
      return
    end if
    do i = 1, 9
      condensed_modes(:, i) = matmul(kmm(i, :i), reshape(cm(:i, :, :), [i, 6*points]))
    end do
  end subroutine element_points

  !> B^T D B: stiffness from the strains per displacement at the Gauss points.
  subroutine point_stiffness(b, c, weight, condensed_modes, ke)
    real(dp), intent(in) :: b(:, :, :)        !< strains (dofs, 6, points) [1/m]
    real(dp), intent(in) :: c(6, 6)           !< elasticity matrix [Pa]
    real(dp), intent(in) :: weight(points)    !< volume of each point [m^3]
    real(dp), intent(in) :: condensed_modes(:, :)       !< A of element_points (6 points, modes)
    real(dp), intent(out) :: ke(:, :)         !< (dofs, dofs) [N/m]
    real(dp), dimension(size(b, 1), 6*points + size(condensed_modes, 2)) :: left, right
    integer :: i, j, p
    do p = 1, points
      left(:, 6*p - 5:6*p) = b(:, :, p)
      do j = 1, 6
        right(:, 6*(p - 1) + j) = 0
        do i = 1, 6
          if (c(i, j) > 0) right(:, 6*(p - 1) + j) = right(:, 6*(p - 1) + j) + weight(p)*c(i, j)*b(:, i, p)
        end do
      end do
    end do
    call multiply_dense(left(:, :6*points), condensed_modes, right(:, 6*points + 1:))
    left(:, 6*points + 1:) = -right(:, 6*points + 1:)
    call multiply_transposed(left, right, ke)
    ke = 0.5_dp*(ke + transpose(ke))
  end subroutine point_stiffness

  !> Gradients of the three incompatible modes 1 - xi_a^2, mapped by the Jacobian at the centre (modes, 3).
  pure function incompatible_gradient(xi, inv0) result(g)
    real(dp), intent(in) :: xi(3)       !< natural coordinates
    real(dp), intent(in) :: inv0(3, 3)  !< inverse Jacobian at the centre [1/m]
    real(dp) :: g(3, 3)
    integer :: a
    do a = 1, 3
      g(a, :) = inv0(:, a)*(-2*xi(a))
    end do
  end function incompatible_gradient

  !> Change of the Green-Lagrange strain with the displacements, dE = sym(F^T grad du); the linear strain where F = 1.
  pure subroutine strain_matrix(g, f, b)
    real(dp), intent(in) :: g(:, :)   !< gradients (functions, 3) [1/m]
    real(dp), intent(in) :: f(3, 3)   !< deformation gradient
    real(dp), intent(out) :: b(:, :)  !< (3 functions, 6), shear strains doubled
    integer :: a, i, j, k
    do i = 1, 3
      j = modulo(i, 3) + 1
      do a = 1, size(g, 1)
        do k = 1, 3
          b(3*(a - 1) + k, i) = f(k, i)*g(a, i)
          b(3*(a - 1) + k, 3 + i) = f(k, i)*g(a, j) + f(k, j)*g(a, i)
        end do
      end do
    end do
  end subroutine strain_matrix

  !> Inverse and determinant of a 3 x 3 matrix.
  pure subroutine invert3(a, inv, det)
    real(dp), intent(in) :: a(3, 3)     !< matrix
    real(dp), intent(out) :: inv(3, 3)  !< inverse
    real(dp), intent(out) :: det        !< determinant
    inv(1, :) = [a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2), a(1, 3)*a(3, 2) - a(1, 2)*a(3, 3), a(1, 2)*a(2, 3) - a(1, 3)*a(2, 2)]
    inv(2, :) = [a(2, 3)*a(3, 1) - a(2, 1)*a(3, 3), a(1, 1)*a(3, 3) - a(1, 3)*a(3, 1), a(1, 3)*a(2, 1) - a(1, 1)*a(2, 3)]
    inv(3, :) = [a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1), a(1, 2)*a(3, 1) - a(1, 1)*a(3, 2), a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)]
    det = dot_product(a(1, :), inv(:, 1))
    inv = inv/det
  end subroutine invert3
end module hd_hexahedron
