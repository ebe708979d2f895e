! SPDX-License-Identifier: GPL-3.0-or-later
!> Large displacements: total Lagrangian description with a St. Venant-Kirchhoff material.
!>
!> E = (F^T F - 1)/2 is the Green-Lagrange strain at the Gauss points, S = C E the second Piola-Kirchhoff stress. The
!> incompatible modes M alpha of `hex8i` add to E what they add to the linear strain. So the energy is quadratic in alpha and the
!> modes are eliminated once for all: an element stores W = e.D e/2 with e the strains of its displacements at all points and
!> the D of hd_hexahedron, which no displacement changes. Forces and tangent are its exact derivatives,
!>   f = B^T s,   K = B^T D B + sum_p (g_a . S_p g_b) 1,   s = D e (weighted stresses S_p),   B = de/du,
!> rigid turns are free of force, and small displacements give back the linear element whatever its kind. Sectors are equal, so a
!> cell is evaluated for `lanes` of them at once. F and S of the tangent are kept for its products with many vectors.
module hd_total_lagrangian
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  use hd_kinds, only: dp
  use hd_body, only: body_t, cell_nodes
  use hd_error, only: error_t
  use hd_hexahedron, only: element_points, elasticity_matrix, nodes_per_element, points
  implicit none
  private
  public :: hd_large_strain, cell_t, total_lagrangian_t, strains_t, new_total_lagrangian, new_cell, cell_response, cell_stress, &
    nodal_turns, lanes, unity

  integer, parameter :: lanes = 8  !< sectors at once
  real(dp), parameter :: unity(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])

  !> A cell at rest, in Cartesian components.
  type :: cell_t
    real(dp) :: lame(2) = 0                     !< lambda and mu [Pa]
    real(dp) :: weight(points) = 0              !< volumes of the points [m^3]
    real(dp), allocatable :: turn(:, :)         !< cosine and sine of the first dof's direction (2, nodes)
    real(dp), allocatable :: g(:, :, :)         !< gradients (nodes, 3, points) [1/m]
    real(dp), allocatable :: condensed_modes(:, :)  !< A of element_points (6 points, modes)
    real(dp), allocatable :: pushed(:, :, :, :) !< the same, as stresses, times the gradients (3, nodes, points, modes)
  end type cell_t

  !> Cells of the first sector of a body; the others see the same in their frame.
  type :: total_lagrangian_t
    type(cell_t), allocatable :: cells(:)       !< (cells)
    integer, allocatable :: place(:, :, :, :)   !< of their blocks in the tangent (nodes, nodes, cells, sectors)
  end type total_lagrangian_t

  !> What products of a body's tangent need of its displacements.
  type :: strains_t
    real(dp), allocatable :: kept(:, :, :)      !< as of hd_large_strain (15 lanes points, cells, groups)
  end type strains_t

  interface
    subroutine hd_large_strain(most, nodes, modes, lambda, mu, turn, g, weight, eased, pushed, at, u, stress, energy, f, k, v, &
      keep, kept) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: most, nodes, modes
      real(c_double), value :: lambda, mu
      real(c_double), intent(in) :: turn(2, *), g(nodes, 3, *), weight(*), eased(48, *), pushed(3, nodes, 8, *), u(8, 3, *)
      integer(c_int), intent(in) :: at(*)
      real(c_double), intent(out), optional :: stress(8, 6, *)
      real(c_double), intent(inout), optional :: energy(8), f(8, 3, *)
      real(c_double), intent(out), optional :: k(8, 3*nodes, *), keep(8, 15, *)
      real(c_double), intent(in), optional :: v(8, 3, *), kept(8, 15, *)
    end subroutine hd_large_strain
  end interface

contains

  !> What does not depend on the displacements; without the places in the tangent.
  subroutine new_total_lagrangian(body, lagrangian, error)
    type(body_t), intent(in) :: body                      !< body
    type(total_lagrangian_t), intent(out) :: lagrangian   !< its cells
    type(error_t), allocatable, intent(out) :: error      !< inverted element
    real(dp) :: c(6, 6)
    integer :: cell, list(nodes_per_element(body%kind))
    c = elasticity_matrix(body%young, body%poisson)
    allocate (lagrangian%cells(size(body%cells, 2)))
    do cell = 1, size(body%cells, 2)
      list = cell_nodes(body, cell, 0)
      call new_cell(body%kind, body%x(:, list), body%angle(list), c, lagrangian%cells(cell), error)
      if (allocated(error)) return
    end do
  end subroutine new_total_lagrangian

  !> One cell.
  subroutine new_cell(kind, x, angle, c, cell, error)
    integer, intent(in) :: kind                        !< element kind
    real(dp), intent(in) :: x(:, :)                    !< places of its nodes (3, nodes) [m]
    real(dp), intent(in) :: angle(:)                   !< directions of their first dofs (nodes) [rad]
    real(dp), intent(in) :: c(6, 6)                    !< isotropic elasticity matrix [Pa]
    type(cell_t), intent(out) :: cell                  !< cell
    type(error_t), allocatable, intent(out) :: error   !< inverted element
    integer :: m, p
    cell%lame = [c(1, 2), c(4, 4)]
    allocate (cell%g(size(x, 2), 3, points))
    call element_points(kind, x, c, cell%g, cell%weight, cell%condensed_modes, error)
    if (allocated(error)) return
    cell%turn = reshape([cos(angle), sin(angle)], [2, size(angle)], order=[2, 1])
    allocate (cell%pushed(3, size(x, 2), points, size(cell%condensed_modes, 2)))
    do m = 1, size(cell%condensed_modes, 2)
      do p = 1, points
        associate (s => cell%condensed_modes(6*p - 5:6*p, m))
          cell%pushed(:, :, p, m) = matmul(reshape(s([1, 4, 6, 4, 2, 5, 6, 5, 3]), [3, 3]), transpose(cell%g(:, :, p)))
        end associate
      end do
    end do
  end subroutine new_cell

  !> Add the forces of a cell in some sectors, in the dofs of its nodes; with `along` the tangent times that in their place.
  subroutine cell_response(cell, at, u, f, tangent, along, keep, kept, energy)
    type(cell_t), intent(in) :: cell                           !< cell
    integer, intent(in), contiguous :: at(:)                   !< places of its nodes in fields
    real(dp), intent(in) :: u(lanes, 3, *)                     !< displacements (lanes, 3, places) [m]
    real(dp), intent(inout), optional :: f(lanes, 3, *)        !< forces (lanes, 3, places) [N]
    real(dp), intent(out), optional :: tangent(lanes, 3*size(at), *)  !< (lanes, 3 nodes, 3 nodes) [N/m]
    real(dp), intent(in), optional :: along(lanes, 3, *)       !< (lanes, 3, places) [m]
    real(dp), intent(out), optional :: keep(*)                 !< as of hd_large_strain, like the next
    real(dp), intent(in), optional :: kept(*)                  !< (15 lanes points)
    real(dp), intent(inout), optional :: energy(lanes)         !< added to [J]
    associate (modes => cell%condensed_modes)
      call hd_large_strain(0, size(at), size(modes, 2), cell%lame(1), cell%lame(2), cell%turn, cell%g, cell%weight, modes, &
        cell%pushed, at, u, energy=energy, f=f, k=tangent, v=along, keep=keep, kept=kept)
    end associate
  end subroutine cell_response

  !> Second Piola-Kirchhoff stress at the Gauss points of a cell of the first sector and of those like it in all others, in the
  !> Cartesian directions of the first sector at rest.
  subroutine cell_stress(cell, u, stress)
    type(cell_t), intent(in) :: cell             !< cell of the first sector
    real(dp), intent(in) :: u(:, :, :)           !< displacements of the nodes (3, nodes, sectors) [m]
    real(dp), intent(out) :: stress(:, :, :)     !< xx, yy, zz, xy, yz, zx (6, points, sectors) [Pa]
    real(dp) :: v(lanes, 3, size(u, 2)), s(lanes, 6, points)
    integer :: a, l, sector
    do sector = 0, size(u, 3) - 1, lanes
      do l = 1, lanes
        v(l, :, :) = u(:, :, min(sector + l, size(u, 3)))
      end do
      call hd_large_strain(0, size(u, 2), size(cell%condensed_modes, 2), cell%lame(1), cell%lame(2), cell%turn, cell%g, &
        cell%weight, cell%condensed_modes, cell%pushed, [(a, a=1, size(u, 2))], v, s)
      do l = 1, min(lanes, size(u, 3) - sector)
        stress(:, :, sector + l) = s(l, :, :)
      end do
    end do
  end subroutine cell_stress

  !> Rotations of a body at its nodes, in their dofs: means of the gradients of the cells around, without the strain to its square.
  function nodal_turns(body, lagrangian, u) result(turn)
    type(body_t), intent(in) :: body                      !< body
    type(total_lagrangian_t), intent(in) :: lagrangian    !< its cells
    real(dp), intent(in) :: u(:, :)                       !< displacements (3, nodes) [m]
    real(dp) :: turn(3, 3, size(u, 2))
    real(dp), dimension(nodes_per_element(body%kind), 3) :: mean
    real(dp) :: weight(size(u, 2)), h(3, 3), f(3, 3), v(3), whole
    integer :: a, c, i, s, list(size(body%cells, 1))
    turn = 0
    weight = 0
    do c = 1, size(body%cells, 2)
      associate (cell => lagrangian%cells(c))
        whole = sum(cell%weight)
        do i = 1, 3
          mean(:, i) = matmul(cell%g(:, i, :), cell%weight)
        end do
        do s = 0, body%sectors - 1
          list = cell_nodes(body, c, s)
          h = 0
          do a = 1, size(list)
            v = about_z(cell%turn(:, a), u(:, list(a)))
            do i = 1, 3
              h(:, i) = h(:, i) + v*mean(a, i)
            end do
          end do
          do a = 1, size(list)
            associate (back => cell%turn(:, a)*[1, -1])
              do i = 1, 3
                f(i, :) = about_z(back, h(i, :))
              end do
              do i = 1, 3
                turn(:, i, list(a)) = turn(:, i, list(a)) + about_z(back, f(:, i))
              end do
            end associate
            weight(list(a)) = weight(list(a)) + whole
          end do
        end do
      end associate
    end do
    do a = 1, size(u, 2)
      f = unity + turn(:, :, a)/weight(a)
      turn(:, :, a) = matmul(f, 1.5_dp*unity - matmul(transpose(f), f)/2)
    end do
  end function nodal_turns

  !> A vector turned about z.
  pure function about_z(turn, v) result(w)
    real(dp), intent(in) :: turn(2), v(3)  !< cosine and sine, vector
    real(dp) :: w(3)
    w = [turn(1)*v(1) - turn(2)*v(2), turn(2)*v(1) + turn(1)*v(2), v(3)]
  end function about_z
end module hd_total_lagrangian
