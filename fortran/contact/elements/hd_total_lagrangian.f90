! SPDX-License-Identifier: GPL-3.0-or-later
!> Large displacements: total Lagrangian description with a St. Venant-Kirchhoff material.
!>
!> E = (F^T F - 1)/2 is the Green-Lagrange strain at the Gauss points, S = C E the second Piola-Kirchhoff stress. The
!> incompatible modes M alpha of `hex8i` add to E what they add to the linear strain. So the energy is quadratic in alpha and the
!> modes are eliminated once for all: an element stores W = e.D e/2 with e the strains of its displacements at all points and
!> the D of hd_hexahedron, which no displacement changes. Forces and tangent are its exact derivatives,
!>   f = B^T s,   K = B^T D B + sum_p (g_a . S_p g_b) 1,   s = D e (weighted stresses S_p),   B = de/du,
!> rigid turns are free of force, and small displacements give back the linear element whatever its kind.
module hd_total_lagrangian
  use hd_kinds, only: dp
  use hd_body, only: body_t, cell_nodes, frame
  use hd_error, only: error_t
  use hd_hexahedron, only: element_points, elasticity_matrix, nodes_per_element, point_stiffness, points, strain_matrix
  use hd_lapack, only: multiply_dense, multiply_transposed
  implicit none
  private
  public :: total_lagrangian_t, new_total_lagrangian, cell_response, cell_stress, element_response

  !> Cells of the first sector of a body at rest, in Cartesian components.
  type :: total_lagrangian_t
    real(dp) :: c(6, 6) = 0                     !< elasticity matrix [Pa]
    real(dp), allocatable :: g(:, :, :, :)      !< gradients (nodes, 3, points, cells) [1/m]
    real(dp), allocatable :: weight(:, :)       !< volumes of the points (points, cells) [m^3]
    real(dp), allocatable :: condensed_modes(:, :, :)     !< A of element_points (6 points, modes, cells)
  end type total_lagrangian_t

contains

  !> What does not depend on the displacements.
  subroutine new_total_lagrangian(body, lagrangian, error)
    type(body_t), intent(in) :: body                      !< body
    type(total_lagrangian_t), intent(out) :: lagrangian   !< its cells
    type(error_t), allocatable, intent(out) :: error      !< inverted element
    real(dp), allocatable :: condensed_modes(:, :)
    integer :: cell, cells
    cells = size(body%cells, 2)
    lagrangian%c = elasticity_matrix(body%young, body%poisson)
    allocate (lagrangian%g(nodes_per_element(body%kind), 3, points, cells), lagrangian%weight(points, cells))
    do cell = 1, cells
      call element_points(body%kind, body%x(:, cell_nodes(body, cell, 0)), lagrangian%c, lagrangian%g(:, :, :, cell), &
        lagrangian%weight(:, cell), condensed_modes, error)
      if (allocated(error)) return
      if (cell == 1) allocate (lagrangian%condensed_modes(size(condensed_modes, 1), size(condensed_modes, 2), cells))
      lagrangian%condensed_modes(:, :, cell) = condensed_modes
    end do
  end subroutine new_total_lagrangian

  !> Forces and tangent of a cell of any sector, in the dofs of its nodes.
  subroutine cell_response(body, lagrangian, cell, u, f, tangent)
    type(body_t), intent(in) :: body                        !< body
    type(total_lagrangian_t), intent(in) :: lagrangian      !< its cells
    integer, intent(in) :: cell                             !< cell of the first sector; the others see the same in their frame
    real(dp), intent(in) :: u(:, :)                         !< displacements of its nodes (3, nodes) [m]
    real(dp), intent(out) :: f(:, :)                        !< forces (3, nodes) [N]
    real(dp), intent(out), optional :: tangent(:, :)        !< (3 nodes, 3 nodes) [N/m]
    real(dp) :: q(3, 3, size(u, 2)), v(3, size(u, 2))
    integer :: list(size(u, 2)), a, i
    list = cell_nodes(body, cell, 0)
    do a = 1, size(list)
      q(:, :, a) = frame(body%angle(list(a)))
      v(:, a) = matmul(q(:, :, a), u(:, a))
    end do
    associate (g => lagrangian%g(:, :, :, cell), weight => lagrangian%weight(:, cell), &
      modes => lagrangian%condensed_modes(:, :, cell))
      if (present(tangent)) then  ! an absent array passed on has bounds that overflow (gfortran)
        call element_response(g, weight, modes, lagrangian%c, v, f, tangent)
      else
        call element_response(g, weight, modes, lagrangian%c, v, f)
      end if
    end associate
    do a = 1, size(list)
      f(:, a) = matmul(f(:, a), q(:, :, a))
      if (.not. present(tangent)) cycle
      i = 3*(a - 1)
      tangent(:, i + 1:i + 3) = matmul(tangent(:, i + 1:i + 3), q(:, :, a))
      tangent(i + 1:i + 3, :) = matmul(transpose(q(:, :, a)), tangent(i + 1:i + 3, :))
    end do
  end subroutine cell_response

  !> Second Piola-Kirchhoff stress at the Gauss points of a cell of any sector, in the Cartesian directions of the first sector at
  !> rest, and the energy that the cell stores.
  subroutine cell_stress(body, lagrangian, cell, u, stress, energy)
    type(body_t), intent(in) :: body                        !< body
    type(total_lagrangian_t), intent(in) :: lagrangian      !< its cells
    integer, intent(in) :: cell                             !< cell of the first sector
    real(dp), intent(in) :: u(:, :)                         !< displacements of its nodes (3, nodes) [m]
    real(dp), intent(out) :: stress(6, points)              !< xx, yy, zz, xy, yz, zx [Pa]
    real(dp), intent(out) :: energy                         !< [J]
    real(dp) :: v(3, size(u, 2)), h(3, 3*points), e(6*points), s(6*points)
    integer :: list(size(u, 2)), a
    list = cell_nodes(body, cell, 0)
    do a = 1, size(list)
      v(:, a) = matmul(frame(body%angle(list(a))), u(:, a))
    end do
    call strain_and_stress(lagrangian%g(:, :, :, cell), lagrangian%weight(:, cell), lagrangian%condensed_modes(:, :, cell), &
      lagrangian%c, v, h, e, s)
    energy = dot_product(s, e)/2
    stress = reshape(s, [6, points])/spread(lagrangian%weight(:, cell), 1, 6)
  end subroutine cell_stress

  !> Forces and tangent of one element in Cartesian components.
  subroutine element_response(g, weight, condensed_modes, c, u, f, tangent)
    real(dp), intent(in) :: u(:, :)                         !< displacements (3, nodes) [m]
    real(dp), intent(in) :: g(size(u, 2), 3*points)         !< gradients at the points (nodes, 3 points) [1/m]
    real(dp), intent(in) :: weight(points)                  !< volumes of the points [m^3]
    real(dp), intent(in) :: condensed_modes(:, :)                     !< A of element_points (6 points, modes)
    real(dp), intent(in) :: c(6, 6)                         !< elasticity matrix [Pa]
    real(dp), intent(out) :: f(:, :)                        !< forces (3, nodes) [N]
    real(dp), intent(out), optional :: tangent(:, :)        !< (3 nodes, 3 nodes) [N/m]
    real(dp) :: h(3, 3*points), e(6*points), s(6*points), stress(3, 3), first(3, 3*points), gs(size(u, 2), 3*points)
    real(dp) :: b(3*size(u, 2), 6, points), geometric(size(u, 2), size(u, 2))
    integer :: i, j, p
    call strain_and_stress(g, weight, condensed_modes, c, u, h, e, s)
    do p = 1, points
      associate (t => s(6*p - 5:6*p), gradient => h(:, 3*p - 2:3*p))
        stress(:, 1) = [t(1), t(4), t(6)]
        stress(:, 2) = [t(4), t(2), t(5)]
        stress(:, 3) = [t(6), t(5), t(3)]
        do i = 1, 3
          gradient(i, i) = gradient(i, i) + 1
        end do
        first(:, 3*p - 2:3*p) = matmul(gradient, stress)
        if (.not. present(tangent)) cycle
        gs(:, 3*p - 2:3*p) = matmul(g(:, 3*p - 2:3*p), stress)
        call strain_matrix(g(:, 3*p - 2:3*p), gradient, b(:, :, p))
      end associate
    end do
    call multiply_transposed(first, g, f)
    if (.not. present(tangent)) return
    call point_stiffness(b, c, weight, condensed_modes, tangent)
    call multiply_transposed(gs, g, geometric)
    do j = 1, size(tangent, 1)
      i = modulo(j - 1, 3) + 1
      tangent(i::3, j) = tangent(i::3, j) + geometric(:, (j + 2)/3)
    end do
  end subroutine element_response

  !> Displacement gradients, strains and stresses times volume at the points of an element.
  subroutine strain_and_stress(g, weight, condensed_modes, c, u, h, e, s)
    real(dp), intent(in) :: u(:, :)                      !< displacements (3, nodes) [m]
    real(dp), intent(in) :: g(size(u, 2), 3*points)      !< gradients at the points (nodes, 3 points) [1/m]
    real(dp), intent(in) :: weight(points)               !< volumes of the points [m^3]
    real(dp), intent(in) :: condensed_modes(:, :)        !< A of element_points (6 points, modes)
    real(dp), intent(in) :: c(6, 6)                      !< elasticity matrix [Pa]
    real(dp), intent(out) :: h(3, 3*points)              !< du_i/dX_j
    real(dp), intent(out) :: e(6*points), s(6*points)    !< E, and S times volume [N m]
    integer :: i, p
    call multiply_dense(u, g, h)
    do p = 1, points
      e(6*p - 5:6*p) = green_lagrange(h(:, 3*p - 2:3*p))
      s(6*p - 5:6*p) = weight(p)*matmul(c, e(6*p - 5:6*p))
    end do
    do i = 1, size(condensed_modes, 2)
      s = s - condensed_modes(:, i)*dot_product(condensed_modes(:, i), e)
    end do
  end subroutine strain_and_stress

  !> Green-Lagrange strain of a displacement gradient, shear strains doubled.
  pure function green_lagrange(h) result(e)
    real(dp), intent(in) :: h(3, 3)  !< du_i/dX_j
    real(dp) :: e(6)
    integer :: i, j
    do i = 1, 3
      j = modulo(i, 3) + 1
      e(i) = h(i, i) + 0.5_dp*dot_product(h(:, i), h(:, i))
      e(3 + i) = h(i, j) + h(j, i) + dot_product(h(:, i), h(:, j))
    end do
  end function green_lagrange
end module hd_total_lagrangian
