! SPDX-License-Identifier: GPL-3.0-or-later
!> Balls of the flexible bearing: struts of Hertz contact between the cam's inner race and the inner face of the outer ring, each on
!> a patch of that face.
module hd_ball_bearing
  use hd_kinds, only: dp, pi
  use hd_face, only: face_t, shape_facet
  use hd_hertz, only: point_contact_t, ball_on_race, contact_rate, in_series, semi_axes
  use hd_race, only: race_radius
  use hd_scene, only: scene_t
  use hd_strut, only: strut_t
  implicit none
  private
  public :: ball_rate, ball_angles, ball_struts

  integer, parameter :: samples = 12            !< of a patch along either side
  real(dp), parameter :: usual_force = 100      !< that the ellipse of contact is taken at [N]

contains

  !> Contacts of a ball with the inner and the outer race.
  pure function race_contacts(scene) result(contact)
    type(scene_t), intent(in) :: scene    !< scene
    type(point_contact_t) :: contact(2)
    real(dp) :: modulus, outer
    modulus = 1/((1 - scene%ball_nu**2)/scene%ball_e + (1 - scene%ring_nu**2)/scene%ring_e)
    outer = race_radius(scene)
    contact(1) = ball_on_race(scene%ball_diameter, outer - scene%ball_diameter, scene%inner_conformity, modulus)
    contact(2) = ball_on_race(scene%ball_diameter, -outer, scene%outer_conformity, modulus)
  end function race_contacts

  !> F over approach^1.5 of both races in series [N/m^1.5].
  pure real(dp) function ball_rate(scene) result(k)
    type(scene_t), intent(in) :: scene  !< scene
    type(point_contact_t) :: contact(2)
    k = scene%ball_rate
    if (k > 0) return
    contact = race_contacts(scene)
    k = in_series(contact_rate(contact(1)), contact_rate(contact(2)))
  end function ball_rate

  !> Places of the balls [rad].
  pure function ball_angles(scene) result(theta)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp) :: theta(scene%balls)
    integer :: i
    theta = modulo(scene%cage_angle_deg*pi/180 + [(2*pi*(i - 1)/scene%balls, i=1, scene%balls)], 2*pi)
  end function ball_angles

  !> Struts of the balls. A patch is as large as the ellipse of contact, as one facet, or as the keys say, and lies in the middle of
  !> the ring.
  pure function ball_struts(scene, face, sectors, first) result(struts)
    type(scene_t), intent(in) :: scene    !< scene
    type(face_t), intent(in) :: face      !< inner face of the ring, axial facets first, then round the axis
    integer, intent(in) :: sectors        !< of the ring
    integer, intent(in) :: first          !< nodes before the ring's
    type(strut_t) :: struts(scene%balls)
    type(point_contact_t) :: contact(2)
    real(dp) :: theta(scene%balls), rate, length, width, axes(2), outer, z(2)
    integer :: i, rows
    rows = size(face%nodes, 2)/sectors
    outer = race_radius(scene)
    z = [minval(face%chart(2, :, :)), maxval(face%chart(2, :, :))]
    contact = race_contacts(scene)
    axes = 2*semi_axes(contact(2), usual_force)
    length = merge(scene%patch_length, max(axes(2), 2*pi*outer/sectors), scene%patch_length > 0)
    width = merge(scene%patch_width, max(axes(1), (z(2) - z(1))/rows), scene%patch_width > 0)
    theta = ball_angles(scene)
    rate = ball_rate(scene)
    do i = 1, scene%balls
      struts(i)%rate = rate
      struts(i)%power = 1.5_dp
      call spread_patch(face, sectors, theta(i), sum(z)/2, length/outer, min(width, z(2) - z(1)), struts(i))
      struts(i)%node = struts(i)%node + first
    end do
  end function ball_struts

  !> Weights of an even pressure on a patch: minus the mean radial displacement there.
  pure subroutine spread_patch(face, sectors, theta, z, angle, width, strut)
    type(face_t), intent(in) :: face             !< face
    integer, intent(in) :: sectors               !< of its body
    real(dp), intent(in) :: theta, z             !< centre [rad], [m]
    real(dp), intent(in) :: angle, width         !< extent [rad], [m]
    type(strut_t), intent(inout) :: strut        !< gets node, weight
    real(dp) :: place, at, xi(2), n(size(face%nodes, 1))
    integer :: i, j, k, a, f, rows, sector
    rows = size(face%nodes, 2)/sectors
    allocate (strut%node(0), strut%weight(3, 0))
    do i = 1, samples
      place = modulo((theta + angle*((i - 0.5_dp)/samples - 0.5_dp))/(2*pi), 1._dp)*sectors
      sector = min(floor(place), sectors - 1)
      xi(1) = 2*(place - sector) - 1
      do j = 1, samples
        at = z + width*((j - 0.5_dp)/samples - 0.5_dp)
        f = sector*rows + 1
        do while (f < (sector + 1)*rows .and. at > face%chart(2, 4, f))
          f = f + 1
        end do
        xi(2) = 2*(at - face%chart(2, 1, f))/(face%chart(2, 4, f) - face%chart(2, 1, f)) - 1
        n = shape_facet(size(n), xi)/samples**2
        do k = 1, size(n)
          a = findloc(strut%node, face%nodes(k, f), 1)
          if (a == 0) then
            strut%node = [strut%node, face%nodes(k, f)]
            a = size(strut%node)
            strut%weight = reshape([strut%weight, 0._dp, 0._dp, 0._dp], [3, a])
          end if
          strut%weight(1, a) = strut%weight(1, a) - n(k)
        end do
      end do
    end do
  end subroutine spread_patch
end module hd_ball_bearing
