! SPDX-License-Identifier: GPL-3.0-or-later
!> A contact face: facets with their nodes and their place on a chart (a plane, or an unrolled cylinder).
module hd_face
  use hd_kinds, only: dp
  implicit none
  private
  public :: face_t, shape_facet

  !> Facets are quadrilaterals of 4 or 8 nodes; geometry on the chart is bilinear in the corners.
  type :: face_t
    integer, allocatable :: nodes(:, :)       !< nodes of each facet (4 or 8, facets)
    real(dp), allocatable :: chart(:, :, :)   !< chart coordinates of the corners (2, 4, facets) [m]
    real(dp) :: period = 0                    !< length after which the first chart coordinate repeats, 0: never [m]
  end type face_t

  real(dp), parameter :: corner(2, 4) = reshape([-1._dp, -1._dp, 1._dp, -1._dp, 1._dp, 1._dp, -1._dp, 1._dp], [2, 4])

contains

  !> Bilinear shape functions of the four corners.
  pure function shape_corner(xi) result(n)
    real(dp), intent(in) :: xi(2)  !< natural coordinates
    real(dp) :: n(4)
    n = (1 + xi(1)*corner(1, :))*(1 + xi(2)*corner(2, :))/4
  end function shape_corner

  !> Shape functions of a facet of 4 (bilinear) or 8 (serendipity) nodes.
  pure subroutine shape_facet(nodes, xi, n)
    integer, intent(in) :: nodes       !< 4 or 8
    real(dp), intent(in) :: xi(2)      !< natural coordinates
    real(dp), intent(out) :: n(nodes)  !< shape functions
    n(:4) = shape_corner(xi)
    if (nodes == 4) return
    n(:4) = n(:4)*(xi(1)*corner(1, :) + xi(2)*corner(2, :) - 1)
    n(5:7:2) = (1 - xi(1)**2)*(1 + xi(2)*[-1, 1])/2
    n(6:8:2) = (1 - xi(2)**2)*(1 + xi(1)*[1, -1])/2
  end subroutine shape_facet
end module hd_face
