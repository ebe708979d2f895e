! SPDX-License-Identifier: GPL-3.0-or-later
!> The wave generator's curve: displacement of a circle pressed onto it, and bodies that are formed to it without stress.
module hd_cam
  use hd_kinds, only: dp, pi
  use hd_body, only: body_t, cell_nodes
  use hd_scene, only: scene_t
  implicit none
  private
  public :: cam_deformation, cam_displacement, form_body, formed_curve

contains

  !> Radial deformation at a height: w in the middle of the band; a cone's falls towards the bottom [m].
  elemental real(dp) function cam_deformation(scene, z) result(w)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), intent(in) :: z           !< distance from the opening [m]
    w = scene%w - tan(scene%cone_angle_deg*pi/180)*(z - scene%band_start - scene%band_length/2)
  end function cam_deformation

  !> Displacement of a circle pressed onto the cam, and its derivatives by theta.
  elemental subroutine cam_displacement(cam, r, w, theta, u, v, du, dv)
    character(len=*), intent(in) :: cam      !< ellipse or cosine
    real(dp), intent(in) :: r                !< radius of the circle [m]
    real(dp), intent(in) :: w                !< deformation [m]
    real(dp), intent(in) :: theta            !< angle from the long axis [rad]
    real(dp), intent(out) :: u, v            !< radial and (inextensible) tangential displacement [m]
    real(dp), intent(out) :: du, dv          !< their derivatives [m]
    real(dp) :: a, b, s
    v = -w/2*sin(2*theta)
    dv = -w*cos(2*theta)
    if (cam == 'ellipse') then
      a = r + w
      b = r - w
      s = sqrt((b*cos(theta))**2 + (a*sin(theta))**2)
      u = a*b/s - r
      du = -a*b*(a*a - b*b)*sin(theta)*cos(theta)/s**3
    else
      u = w*cos(2*theta)
      du = -2*w*sin(2*theta)
    end if
  end subroutine cam_displacement

  !> Length of the formed curve over that of the circle of the contact radius, and turn of its normal over that length.
  elemental subroutine formed_curve(scene, theta, stretch, bend)
    type(scene_t), intent(in) :: scene       !< scene without a cone
    real(dp), intent(in) :: theta            !< angle of the circle [rad]
    real(dp), intent(out) :: stretch         !< 1 on a circle
    real(dp), intent(out) :: bend            !< [rad/m]
    real(dp), parameter :: h = 1e-4_dp
    real(dp) :: u(3), v(3), du(3), dv(3), turn(3)
    call cam_displacement(scene%cam, scene%bore_radius, scene%w, theta + [-h, 0._dp, h], u, v, du, dv)
    stretch = hypot(scene%bore_radius + u(2) + dv(2), v(2) - du(2))/scene%bore_radius
    turn = atan2(v - du, scene%bore_radius + u + dv)
    bend = (1 + (turn(3) - turn(1))/(2*h))/scene%bore_radius
  end subroutine formed_curve

  !> Give a revolved body the cam's shape: every circle of the contact radius becomes the cam's curve, thicknesses stand on
  !> its normals, the first dof of a node follows the normal. Behind the band the shape fades out linearly to the bottom.
  subroutine form_body(scene, body)
    type(scene_t), intent(in) :: scene   !< scene
    type(body_t), intent(inout) :: body  !< revolved body, then one general sector
    real(dp) :: band_end, corner, fade, theta, u, v, du, dv, normal(2), r, w
    integer, allocatable :: cells(:, :)
    integer :: i, c, s, m
    band_end = scene%band_start + scene%band_length
    corner = scene%cup_length - scene%bottom_thickness
    do i = 1, body%nodes()
      fade = min(max((corner - body%x(3, i))/(corner - band_end), 0._dp), 1._dp)
      w = fade*cam_deformation(scene, min(body%x(3, i), band_end))
      theta = body%angle(i)
      r = hypot(body%x(1, i), body%x(2, i))
      call cam_displacement(scene%cam, scene%bore_radius, w, theta, u, v, du, dv)
      normal = [scene%bore_radius + u + dv, v - du]
      normal = normal/norm2(normal)
      body%angle(i) = theta + atan2(normal(2), normal(1))
      body%x(1, i) = (scene%bore_radius + u)*cos(theta) - v*sin(theta) + (r - scene%bore_radius)*cos(body%angle(i))
      body%x(2, i) = (scene%bore_radius + u)*sin(theta) + v*cos(theta) + (r - scene%bore_radius)*sin(body%angle(i))
    end do
    m = size(body%cells, 2)
    allocate (cells(size(body%cells, 1), m*body%sectors))
    do s = 0, body%sectors - 1
      do c = 1, m
        cells(:, s*m + c) = cell_nodes(body, c, s)
      end do
    end do
    call move_alloc(cells, body%cells)
    body%nodes_per_sector = body%nodes()
    body%sectors = 1
    body%revolved = .false.
  end subroutine form_body
end module hd_cam
