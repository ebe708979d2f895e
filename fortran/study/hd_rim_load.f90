! SPDX-License-Identifier: GPL-3.0-or-later
!> Loads on the outside of the toothed rim: even shear, or the forces of the tooth pairs near the long axis.
module hd_rim_load
  use hd_kinds, only: dp, pi
  use hd_body, only: body_t, axial_moment
  use hd_face, only: face_t, facet_weights, shape_facet
  use hd_scene, only: scene_t
  implicit none
  private
  public :: even_shear, tooth_forces

contains

  !> Even shear with a unit moment about the axis.
  pure function even_shear(body, face) result(force)
    type(body_t), intent(in) :: body  !< flexspline
    type(face_t), intent(in) :: face  !< outside of the rim, nodes numbered in the body
    real(dp) :: force(3, body%nodes()), area
    integer :: f
    force = 0
    do f = 1, size(face%nodes, 2)
      area = (face%chart(1, 2, f) - face%chart(1, 1, f))*(face%chart(2, 4, f) - face%chart(2, 1, f))
      associate (list => face%nodes(:, f))
        force(2, list) = force(2, list) + facet_weights(size(list))*area
      end associate
    end do
    force = force/axial_moment(body, force)
  end function even_shear

  !> Line forces of the tooth pairs in mesh, evenly shared, half of them around each end of the long axis.
  pure subroutine tooth_forces(scene, body, face, tangential, radial)
    type(scene_t), intent(in) :: scene              !< scene
    type(body_t), intent(in) :: body                !< flexspline
    type(face_t), intent(in) :: face                !< outside of the rim, axial facets first, then round the axis
    real(dp), intent(out) :: tangential(:, :)       !< forces along the rim with a unit moment (3, nodes) [1/m]
    real(dp), intent(out) :: radial(:, :)           !< inward forces that go with them (3, nodes) [1/m]
    real(dp), parameter :: eta(2) = [-1, 1]/sqrt(3._dp)
    real(dp) :: place, xi, n(size(face%nodes, 1))
    integer :: tooth, lobe, sector, rows, sectors, f, g, i, half
    tangential = 0
    radial = 0
    half = scene%tooth_pairs/2
    sectors = scene%divisions
    rows = size(face%nodes, 2)/sectors
    do lobe = 0, 1
      do tooth = 1, half
        place = sectors*(0.5_dp*lobe + (tooth - 0.5_dp*(half + 1))/scene%teeth)
        sector = floor(place + 1e-9_dp)
        xi = 2*(place - sector) - 1
        do i = 1, rows
          f = rows*modulo(sector, sectors) + i
          do g = 1, 2
            n = shape_facet(size(n), [xi, eta(g)])*(face%chart(2, 4, f) - face%chart(2, 1, f))/2
            tangential(2, face%nodes(:, f)) = tangential(2, face%nodes(:, f)) + n
          end do
        end do
      end do
    end do
    tangential = tangential/axial_moment(body, tangential)
    radial(1, :) = -tan(scene%pressure_angle_deg*pi/180)*tangential(2, :)
  end subroutine tooth_forces
end module hd_rim_load
