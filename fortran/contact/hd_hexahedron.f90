! SPDX-License-Identifier: GPL-3.0-or-later
!> Hexahedral elements: shape functions and linear-elastic stiffness.
!>
!> Three elements: `hex8` (full integration, locks in bending: the reference for locking), `hex8i` (three incompatible
!> displacement modes per direction, Wilson 1973 with the correction of Taylor, Beresford and Wilson 1976, condensed) and
!> `hex20r` (serendipity, 2 x 2 x 2 points). Node order is that of VTK types 12 and 25.
module hd_hexahedron
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  implicit none
  private
  public :: nodes_per_element, element_kind, shape_hexahedron, element_stiffness, elasticity_matrix, centre_gradient
  public :: hex8, hex8i, hex20r

  integer, parameter :: hex8 = 1    !< trilinear, full integration
  integer, parameter :: hex8i = 2   !< trilinear with incompatible modes
  integer, parameter :: hex20r = 3  !< serendipity quadratic, reduced integration

  !> Natural coordinates of the 20 nodes (the first 8 are the corners).
  real(dp), parameter :: corner(3, 20) = reshape([ &
    -1._dp, -1._dp, -1._dp, 1._dp, -1._dp, -1._dp, 1._dp, 1._dp, -1._dp, -1._dp, 1._dp, -1._dp, &
    -1._dp, -1._dp, 1._dp, 1._dp, -1._dp, 1._dp, 1._dp, 1._dp, 1._dp, -1._dp, 1._dp, 1._dp, &
    0._dp, -1._dp, -1._dp, 1._dp, 0._dp, -1._dp, 0._dp, 1._dp, -1._dp, -1._dp, 0._dp, -1._dp, &
    0._dp, -1._dp, 1._dp, 1._dp, 0._dp, 1._dp, 0._dp, 1._dp, 1._dp, -1._dp, 0._dp, 1._dp, &
    -1._dp, -1._dp, 0._dp, 1._dp, -1._dp, 0._dp, 1._dp, 1._dp, 0._dp, -1._dp, 1._dp, 0._dp], [3, 20])
  real(dp), parameter :: gauss = 0.57735026918962576450914878050196_dp

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
    real(dp) :: n(20), dn(3, 20), b(6, 60), cb(6, 60), m(6, 9), jac0(3, 3), inv0(3, 3), det0, jac(3, 3), inv(3, 3), det
    real(dp) :: kum(60, 9), kmm(9, 9), solved(9, 60), xi(3)
    integer :: nn, nd, p
    nn = nodes_per_element(kind)
    nd = 3*nn
    ke = 0
    kum = 0
    kmm = 0
    call shape_hexahedron(kind, [0._dp, 0._dp, 0._dp], n, dn)
    jac0 = matmul(dn(:, :nn), transpose(x(:, :nn)))
    call invert3(jac0, inv0, det0)
    do p = 0, 7
      xi = gauss*[merge(1, -1, btest(p, 0)), merge(1, -1, btest(p, 1)), merge(1, -1, btest(p, 2))]
      call shape_hexahedron(kind, xi, n, dn)
      jac = matmul(dn(:, :nn), transpose(x(:, :nn)))
      call invert3(jac, inv, det)
      if (.not. det > 0) then
        call raise(error, code_input, 'inverted element: Jacobian determinant '//to_text(det)//' m^3 (valid: > 0)')
        return
      end if
      call strain_matrix(matmul(inv, dn(:, :nn)), b(:, :nd))
      cb(:, :nd) = det*matmul(c, b(:, :nd))
      ke = ke + matmul(transpose(b(:, :nd)), cb(:, :nd))
      if (kind == hex8i) then
        call strain_matrix(incompatible_gradient(xi, inv0)*(det0/det), m)
        kum(:nd, :) = kum(:nd, :) + matmul(transpose(cb(:, :nd)), m)
        kmm = kmm + det*matmul(transpose(m), matmul(c, m))
      end if
    end do
    if (kind == hex8i) then
      solved = transpose(kum)
      call solve_spd(kmm, solved(:, :nd))
      ke = ke - matmul(kum(:nd, :), solved(:, :nd))
    end if
    ke = 0.5_dp*(ke + transpose(ke))
  end subroutine element_stiffness

  !> Gradients of the shape functions at the centre.
  pure function centre_gradient(kind, x) result(g)
    integer, intent(in) :: kind       !< element kind
    real(dp), intent(in) :: x(:, :)   !< node coordinates (3, nodes) [m]
    real(dp) :: g(3, size(x, 2)), n(20), dn(3, 20), inv(3, 3), det
    call shape_hexahedron(kind, [0._dp, 0._dp, 0._dp], n, dn)
    call invert3(matmul(dn(:, :size(x, 2)), transpose(x)), inv, det)
    g = matmul(inv, dn(:, :size(x, 2)))
  end function centre_gradient

  !> Gradients of the three incompatible modes 1 - xi_a^2, mapped by the Jacobian at the centre.
  pure function incompatible_gradient(xi, inv0) result(g)
    real(dp), intent(in) :: xi(3)       !< natural coordinates
    real(dp), intent(in) :: inv0(3, 3)  !< inverse Jacobian at the centre [1/m]
    real(dp) :: g(3, 3)
    integer :: a
    do a = 1, 3
      g(:, a) = inv0(:, a)*(-2*xi(a))
    end do
  end function incompatible_gradient

  !> Strain-displacement matrix from gradients.
  pure subroutine strain_matrix(g, b)
    real(dp), intent(in) :: g(:, :)   !< gradients (3, functions) [1/m]
    real(dp), intent(out) :: b(:, :)  !< (6, 3 functions)
    integer :: a, j
    b = 0
    do a = 1, size(g, 2)
      j = 3*(a - 1)
      b(1, j + 1) = g(1, a)
      b(2, j + 2) = g(2, a)
      b(3, j + 3) = g(3, a)
      b(4, j + 1:j + 2) = [g(2, a), g(1, a)]
      b(5, j + 2:j + 3) = [g(3, a), g(2, a)]
      b(6, j + 1) = g(3, a)
      b(6, j + 3) = g(1, a)
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

  !> Solve A X = B for a small symmetric positive definite A by Cholesky; B is overwritten.
  pure subroutine solve_spd(a, b)
    real(dp), intent(inout) :: a(:, :)  !< matrix, overwritten by its factor
    real(dp), intent(inout) :: b(:, :)  !< right-hand sides, then solutions
    integer :: i, j
    do j = 1, size(a, 1)
      a(j, j) = sqrt(a(j, j) - dot_product(a(j, :j - 1), a(j, :j - 1)))
      do i = j + 1, size(a, 1)
        a(i, j) = (a(i, j) - dot_product(a(i, :j - 1), a(j, :j - 1)))/a(j, j)
      end do
    end do
    do j = 1, size(a, 1)
      b(j, :) = (b(j, :) - matmul(a(j, :j - 1), b(:j - 1, :)))/a(j, j)
    end do
    do j = size(a, 1), 1, -1
      b(j, :) = (b(j, :) - matmul(a(j + 1:, j), b(j + 1:, :)))/a(j, j)
    end do
  end subroutine solve_spd
end module hd_hexahedron
