! SPDX-License-Identifier: GPL-3.0-or-later
!> Balls of the flexible bearing: struts of Hertz contact between the cam's inner race and the inner face of the outer ring, each on
!> a patch of that face; in their grooves they hold the ring along the axis too, each by a second strut.
module hd_ball_bearing
  use hd_kinds, only: dp, pi
  use hd_ball_patch, only: ball_patch_t
  use hd_face, only: face_t
  use hd_groove, only: groove_t
  use hd_hold, only: hold_t
  use hd_hertz, only: point_contact_t, ball_on_race, contact_pressure, contact_rate, in_series
  use hd_race, only: race_radius
  use hd_scene, only: scene_t
  use hd_strut, only: strut_t
  implicit none
  private
  public :: ball_angles, ball_patches, ball_struts, axial_struts, ball_grooves, race_pressure, ring_holds

contains

  !> Contacts of a ball with the inner and the outer race.
  pure function race_contacts(scene) result(contact)
    type(scene_t), intent(in) :: scene    !< scene
    type(point_contact_t) :: contact(2)
    real(dp) :: outer
    outer = race_radius(scene)
    contact(1) = ball_on_race(scene%ball_diameter, outer - scene%ball_diameter, scene%inner_conformity, modulus(scene))
    contact(2) = ball_on_race(scene%ball_diameter, -outer, scene%outer_conformity, modulus(scene))
  end function race_contacts

  !> Modulus of contact of balls and races [Pa].
  pure real(dp) function modulus(scene)
    type(scene_t), intent(in) :: scene    !< scene
    modulus = 1/((1 - scene%ball_nu**2)/scene%ball_e + (1 - scene%ring_nu**2)/scene%ring_e)
  end function modulus

  !> F over approach^1.5 of both races in series [N/m^1.5].
  pure real(dp) function ball_rate(scene) result(k)
    type(scene_t), intent(in) :: scene  !< scene
    type(point_contact_t) :: contact(2)
    k = scene%ball_rate
    if (k > 0) return
    contact = race_contacts(scene)
    k = in_series(contact_rate(contact(1)), contact_rate(contact(2)))
  end function ball_rate

  !> Largest pressure of a ball on a race; 0 where no ball pushes, or its rate is not that of its races [Pa].
  pure real(dp) function race_pressure(scene, force) result(p)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), intent(in) :: force       !< of a ball [N]
    p = 0
    if (force > 0 .and. .not. scene%ball_rate > 0) p = maxval(contact_pressure(race_contacts(scene), force))
  end function race_pressure

  !> Places of the balls [rad].
  pure function ball_angles(scene) result(theta)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp) :: theta(scene%balls)
    integer :: i
    theta = modulo(scene%cage_angle_deg*pi/180 + [(2*pi*(i - 1)/scene%balls, i=1, scene%balls)], 2*pi)
  end function ball_angles

  !> Patches of the balls, in the middle of the ring: as large as the ring is thick, or as one facet where that is larger, or as the
  !> keys say. What a smaller patch would press in, Hertz's law has in it already.
  pure function ball_patches(scene, face, sectors, first) result(patch)
    type(scene_t), intent(in) :: scene    !< scene
    type(face_t), intent(in) :: face      !< inner face of the ring, axial facets first, then round the axis
    integer, intent(in) :: sectors        !< of the ring
    integer, intent(in) :: first          !< nodes before the ring's
    type(ball_patch_t) :: patch
    real(dp) :: outer, z(2)
    outer = race_radius(scene)
    z = [minval(face%chart(2, :, :)), maxval(face%chart(2, :, :))]
    patch%face = face
    patch%sectors = sectors
    patch%first = first
    patch%radius = scene%bore_radius - scene%ring_thickness
    patch%z = sum(z)/2
    patch%angle = max(scene%ring_thickness, 2*pi*outer/sectors)/outer
    if (scene%patch_length > 0) patch%angle = scene%patch_length/outer
    patch%width = max(scene%ring_thickness, (z(2) - z(1))/(size(face%nodes, 2)/sectors))
    if (scene%patch_width > 0) patch%width = scene%patch_width
    patch%width = min(z(2) - z(1), patch%width)
    patch%theta = ball_angles(scene)
    patch%lever = scene%outer_conformity*scene%ball_diameter
  end function ball_patches

  !> Struts of the balls on their patches.
  pure function ball_struts(scene, patch) result(struts)
    type(scene_t), intent(in) :: scene          !< scene
    type(ball_patch_t), intent(in) :: patch     !< patches
    type(strut_t) :: struts(scene%balls)
    real(dp) :: none
    integer :: i
    struts%rate = ball_rate(scene)
    struts%power = 1.5_dp
    struts%pulls = .false.
    do i = 1, scene%balls
      call patch%place(i, struts(i), none)
    end do
  end function ball_struts

  !> Struts of their ways along the axis; the law is that of their grooves.
  pure function axial_struts(scene, patch) result(struts)
    type(scene_t), intent(in) :: scene          !< scene
    type(ball_patch_t), intent(in) :: patch     !< patches
    type(strut_t) :: struts(scene%balls)
    real(dp) :: none
    integer :: i
    struts%rate = ball_rate(scene)*sqrt(reach(scene))  ! scales their equations alone
    struts%power = 1
    struts%pulls = .true.
    do i = 1, scene%balls
      call patch%place(scene%balls + i, struts(i), none)
    end do
  end function axial_struts

  !> Grooves of the balls, whose axial ways stand behind some struts.
  pure type(groove_t) function ball_grooves(scene, before) result(groove)
    type(scene_t), intent(in) :: scene   !< scene
    integer, intent(in) :: before        !< struts
    groove = groove_t(scene%balls, before, reach(scene), spread(0._dp, 1, scene%balls))
  end function ball_grooves

  !> Holds of a ring on balls: by all of them along the axis, by a strut that takes its turn.
  function ring_holds(scene, brake, groove) result(holds)
    type(scene_t), intent(in) :: scene               !< scene
    integer, intent(in) :: brake                     !< this strut, 0: none
    type(groove_t), intent(in), optional :: groove   !< grooves, if there are any
    type(hold_t), allocatable :: holds(:)
    real(dp), parameter :: long = 0.25_dp            !< way of a correction over the reach that is too far
    real(dp), parameter :: light = 0.01_dp           !< closing of a ball over it, whose force over the reach is the least hold
    real(dp) :: least
    integer :: i
    allocate (holds(0))
    least = ball_rate(scene)*light**1.5_dp*sqrt(reach(scene))
    if (present(groove)) holds = [holds, hold_t([(groove%before + i, i=1, groove%balls)], long*reach(scene), least)]
    if (brake > 0) holds = [holds, hold_t([brake], long*reach(scene), least)]
  end function ring_holds

  !> Distance of the centres of a ball's grooves where all just touch [m].
  pure real(dp) function reach(scene)
    type(scene_t), intent(in) :: scene   !< scene
    reach = (scene%inner_conformity + scene%outer_conformity - 1)*scene%ball_diameter
  end function reach
end module hd_ball_bearing
