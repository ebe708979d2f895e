! SPDX-License-Identifier: GPL-3.0-or-later
!> Race of the balls in the outer ring: a groove of circular section round the middle of the ring's inner face.
module hd_race
  use hd_kinds, only: dp
  use hd_scene, only: scene_t
  implicit none
  private
  public :: race_radius, groove_width, deepest_groove, groove_depths

  real(dp), parameter :: deepest = 0.75_dp   !< depth of a groove over the ring's thickness, see deepest_groove

contains

  !> Radius of the circle at the ground of the groove, on which the balls run [m].
  pure real(dp) function race_radius(scene)
    type(scene_t), intent(in) :: scene  !< scene
    race_radius = scene%bore_radius - scene%ring_thickness + scene%groove_depth
  end function race_radius

  !> Radius of the groove's section [m].
  pure real(dp) function section_radius(scene)
    type(scene_t), intent(in) :: scene  !< scene
    section_radius = scene%outer_conformity*scene%ball_diameter
  end function section_radius

  !> Width of the groove where it leaves the ring's inner face [m].
  pure real(dp) function groove_width(scene)
    type(scene_t), intent(in) :: scene  !< scene whose groove is not deeper than its radius
    associate (d => scene%groove_depth)
      groove_width = 2*sqrt(d*(2*section_radius(scene) - d))
    end associate
  end function groove_width

  !> Depth that a groove stays below: three quarters of the ring's thickness, so that a line through coarse stations (a quarter
  !> deeper than the groove where one cell is as long as it is wide) leaves some; the groove's radius; and where it is as wide as
  !> the ring [m].
  pure real(dp) function deepest_groove(scene) result(depth)
    type(scene_t), intent(in) :: scene  !< scene
    associate (r => section_radius(scene))
      depth = min(r - sqrt(max(0._dp, r**2 - scene%band_length**2/4)), deepest*scene%ring_thickness)
    end associate
  end function deepest_groove

  !> Depth of the groove at stations along the ring, straight between them: of all such lines the nearest to the groove in the mean
  !> square. So the ring loses the groove's own area on any mesh, wherever the stations lie; beside the groove it may be a little
  !> thicker than without.
  pure function groove_depths(scene, z) result(depth)
    type(scene_t), intent(in) :: scene  !< scene with a valid groove
    real(dp), intent(in) :: z(:)        !< rising stations from edge to edge of the ring [m]
    real(dp) :: depth(size(z))          !< [m]
    real(dp), dimension(size(z)) :: x, area, moment, diagonal
    real(dp) :: rising, half, h, f
    integer :: i
    depth = 0
    if (.not. scene%groove_depth > 0) return
    half = groove_width(scene)/2
    x = z - scene%band_start - scene%band_length/2
    associate (r => section_radius(scene), y => min(max(x, -half), half))
      area = (y*sqrt(r**2 - y**2) + r**2*asin(y/r))/2 - (r - scene%groove_depth)*y
      moment = -sqrt(r**2 - y**2)**3/3 - (r - scene%groove_depth)*y**2/2
    end associate
    diagonal = 0
    do i = 2, size(z)
      h = x(i) - x(i - 1)
      rising = (moment(i) - moment(i - 1) - x(i - 1)*(area(i) - area(i - 1)))/h
      depth(i - 1:i) = depth(i - 1:i) + [area(i) - area(i - 1) - rising, rising]
      diagonal(i - 1:i) = diagonal(i - 1:i) + h/3
    end do
    do i = 2, size(z)  ! elimination, h/6 beside the diagonal
      f = (x(i) - x(i - 1))/6/diagonal(i - 1)
      diagonal(i) = diagonal(i) - f*(x(i) - x(i - 1))/6
      depth(i) = depth(i) - f*depth(i - 1)
    end do
    depth(size(z)) = depth(size(z))/diagonal(size(z))
    do i = size(z) - 1, 1, -1
      depth(i) = (depth(i) - (x(i + 1) - x(i))/6*depth(i + 1))/diagonal(i)
    end do
  end function groove_depths
end module hd_race
