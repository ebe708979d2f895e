! SPDX-License-Identifier: GPL-3.0-or-later
!> A hexahedral body made of equal sectors.
!>
!> A revolved body repeats one sector of cells `sectors` times round the z axis; its dofs are cylindrical (u_r, u_theta,
!> u_z) at every node, so every sector has the same stiffness. A general body is one sector with Cartesian dofs.
module hd_body
  use hd_kinds, only: dp
  use hd_error, only: error_t
  use hd_hexahedron, only: element_stiffness, elasticity_matrix, nodes_per_element
  implicit none
  private
  public :: body_t, sector_stiffness, cell_nodes, cartesian, axial_moment, frame

  !> Node numbers inside a cell run from 1 to 2 nodes_per_sector: the second half belongs to the next sector.
  type :: body_t
    integer :: kind = 0                      !< element kind of hd_hexahedron
    integer :: sectors = 1                   !< number of equal sectors round the axis
    integer :: nodes_per_sector = 0          !< nodes owned by a sector
    logical :: revolved = .false.            !< cylindrical dofs, sectors close to a full turn
    real(dp), allocatable :: x(:, :)         !< Cartesian node coordinates (3, sectors nodes_per_sector) [m]
    real(dp), allocatable :: angle(:)        !< direction of the first dof at each node [rad]
    integer, allocatable :: cells(:, :)      !< cells of the first sector (nodes, cells)
    real(dp) :: young = 0                    !< Young's modulus [Pa]
    real(dp) :: poisson = 0                  !< Poisson's ratio
  contains
    procedure :: nodes
  end type body_t

contains

  !> Number of nodes of the body.
  pure integer function nodes(self)
    class(body_t), intent(in) :: self  !< body
    nodes = self%sectors*self%nodes_per_sector
  end function nodes

  !> Global nodes of a cell of a sector.
  pure function cell_nodes(body, cell, sector) result(list)
    type(body_t), intent(in) :: body  !< body
    integer, intent(in) :: cell       !< cell of the sector, from 1
    integer, intent(in) :: sector     !< sector, from 0
    integer :: list(nodes_per_element(body%kind))
    list = modulo(body%cells(:, cell) - 1 + sector*body%nodes_per_sector, body%nodes()) + 1
  end function cell_nodes

  !> Stiffness matrices of the cells of the first sector, in the dofs of their nodes [N/m].
  subroutine sector_stiffness(body, ke, error)
    type(body_t), intent(in) :: body                      !< body
    real(dp), allocatable, intent(out) :: ke(:, :, :)     !< (3 nodes, 3 nodes, cells)
    type(error_t), allocatable, intent(out) :: error      !< inverted element
    real(dp) :: c(6, 6), q(3, 3)
    integer :: list(nodes_per_element(body%kind)), cell, a, i, n
    n = nodes_per_element(body%kind)
    allocate (ke(3*n, 3*n, size(body%cells, 2)))
    c = elasticity_matrix(body%young, body%poisson)
    do cell = 1, size(body%cells, 2)
      list = cell_nodes(body, cell, 0)
      call element_stiffness(body%kind, body%x(:, list), c, ke(:, :, cell), error)
      if (allocated(error)) return
      do a = 1, n
        q = frame(body%angle(list(a)))
        i = 3*(a - 1)
        ke(:, i + 1:i + 3, cell) = matmul(ke(:, i + 1:i + 3, cell), q)
        ke(i + 1:i + 3, :, cell) = matmul(transpose(q), ke(i + 1:i + 3, :, cell))
      end do
    end do
  end subroutine sector_stiffness

  !> Columns are the unit vectors of the node's dofs.
  pure function frame(angle) result(q)
    real(dp), intent(in) :: angle  !< direction of the first dof [rad]
    real(dp) :: q(3, 3)
    q = reshape([cos(angle), sin(angle), 0._dp, -sin(angle), cos(angle), 0._dp, 0._dp, 0._dp, 1._dp], [3, 3])
  end function frame

  !> Cartesian components of nodal vectors given in the nodes' own dofs.
  pure function cartesian(body, u) result(v)
    type(body_t), intent(in) :: body   !< body
    real(dp), intent(in) :: u(:, :)    !< nodal vectors (3, nodes)
    real(dp) :: v(3, size(u, 2))
    real(dp) :: c, s
    integer :: i
    c = 1
    s = 0
    do i = 1, size(u, 2)
      if (i == 1 .or. abs(body%angle(i) - body%angle(max(1, i - 1))) > 0) then  ! the nodes of a sector share it
        c = cos(body%angle(i))
        s = sin(body%angle(i))
      end if
      v(1, i) = c*u(1, i) - s*u(2, i)
      v(2, i) = s*u(1, i) + c*u(2, i)
      v(3, i) = u(3, i)
    end do
  end function cartesian

  !> Moment about the z axis of nodal forces given in the nodes' own dofs [N m].
  pure real(dp) function axial_moment(body, f, u) result(m)
    type(body_t), intent(in) :: body             !< body
    real(dp), intent(in) :: f(:, :)              !< nodal forces (3, nodes) [N]
    real(dp), intent(in), optional :: u(:, :)    !< displacements, if the deformed body counts (3, nodes) [m]
    real(dp) :: q(3, 3), v(3), x(3)
    integer :: i
    m = 0
    do i = 1, size(f, 2)
      if (.not. any(abs(f(:2, i)) > 0)) cycle  ! most, where a tooth pushes
      q = frame(body%angle(i))
      v = matmul(q, f(:, i))
      x = body%x(:, i)
      if (present(u)) x = x + matmul(q, u(:, i))
      m = m + x(1)*v(2) - x(2)*v(1)
    end do
  end function axial_moment
end module hd_body
