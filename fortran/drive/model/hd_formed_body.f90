! SPDX-License-Identifier: GPL-3.0-or-later
!> Circles of many heights on the wave generator's curve: the ring's inner face as it is pressed on, bodies formed to the cam.
module hd_formed_body
  use hd_kinds, only: dp
  use hd_body, only: body_t, cell_nodes
  use hd_cam, only: cam_t, curve_t, new_curve
  use hd_scene, only: scene_t
  implicit none
  private
  public :: form_body, formed_curve, put_on_curve

contains

  !> Displacements that put points of the cam's circle on its curve, in their directions at rest.
  subroutine put_on_curve(cam, w, theta, part, u, v)
    type(cam_t), intent(in) :: cam          !< cam
    real(dp), intent(in) :: w(:)            !< deformation of the whole assembly at the points [m]
    real(dp), intent(in) :: theta(:)        !< their angles [rad]
    real(dp), intent(in) :: part            !< of the assembly, 0 to 1
    real(dp), intent(out) :: u(:), v(:)     !< radial and tangential displacement [m]
    type(curve_t) :: curve
    logical :: done(size(w))
    real(dp) :: x(2)
    integer :: i, k
    done = .false.
    do k = 1, size(w)
      if (done(k)) cycle
      call new_curve(cam, w(k), part, curve)
      do i = k, size(w)
        if (abs(w(i) - w(k)) > 0) cycle
        done(i) = .true.
        call curve%put(theta(i), x)
        u(i) = x(1)*cos(theta(i)) + x(2)*sin(theta(i)) - cam%radius
        v(i) = x(2)*cos(theta(i)) - x(1)*sin(theta(i))
      end do
    end do
  end subroutine put_on_curve

  !> Length of the formed curve over that of the circle of the contact radius, and turn of its normal over the circle's length.
  subroutine formed_curve(cam, theta, stretch, bend)
    type(cam_t), intent(in) :: cam           !< of the contact radius, without a cone
    real(dp), intent(in) :: theta(:)         !< angles of the circle [rad]
    real(dp), intent(out) :: stretch(:)      !< 1 on a circle
    real(dp), intent(out) :: bend(:)         !< [rad/m]
    type(curve_t) :: curve
    real(dp) :: x(2), normal(2)
    integer :: i
    call new_curve(cam, cam%w, 1._dp, curve)
    stretch = curve%length/(2*acos(-1._dp)*cam%radius)
    do i = 1, size(theta)
      call curve%put(theta(i), x, normal, bend(i))
    end do
    bend = bend*stretch
  end subroutine formed_curve

  !> Give a revolved body the cam's shape: every circle of the contact radius becomes the cam's curve, thicknesses stand on
  !> its normals, the first dof of a node follows the normal. Behind the band the shape fades out linearly to the bottom.
  subroutine form_body(scene, cam, body)
    type(scene_t), intent(in) :: scene   !< scene
    type(cam_t), intent(in) :: cam       !< of the contact radius
    type(body_t), intent(inout) :: body  !< revolved body, then one general sector
    type(curve_t) :: curve
    real(dp), dimension(size(body%x, 2)) :: fade, w
    logical :: done(size(body%x, 2))
    real(dp) :: band_end, corner, r, x(2), normal(2)
    integer, allocatable :: cells(:, :)
    integer :: i, k, c, s, m
    band_end = scene%band_start + scene%band_length
    corner = scene%cup_length - scene%bottom_thickness
    fade = min(max((corner - body%x(3, :))/(corner - band_end), 0._dp), 1._dp)
    w = cam%deformation(min(body%x(3, :), band_end))
    done = .false.
    do k = 1, size(w)
      if (done(k)) cycle
      call new_curve(cam, w(k), fade(k), curve)
      do i = k, size(w)
        if (done(i) .or. abs(w(i) - w(k)) > 0 .or. abs(fade(i) - fade(k)) > 0) cycle
        done(i) = .true.
        r = hypot(body%x(1, i), body%x(2, i))
        call curve%put(body%angle(i), x, normal)
        body%x(:2, i) = x + (r - scene%bore_radius)*normal
        body%angle(i) = body%angle(i) + turn(body%angle(i), normal)
      end do
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

  !> Angle of a normal against a direction [rad].
  pure real(dp) function turn(angle, normal)
    real(dp), intent(in) :: angle      !< of the direction [rad]
    real(dp), intent(in) :: normal(2)  !< unit vector
    turn = atan2(normal(2)*cos(angle) - normal(1)*sin(angle), normal(1)*cos(angle) + normal(2)*sin(angle))
  end function turn
end module hd_formed_body
