! SPDX-License-Identifier: GPL-3.0-or-later
!> Flanks of the tooth pairs against the circular spline, as struts along their normals: of every pair first the flank that takes a
!> positive torque, then the other. With friction their companions along the tangents follow, in the same order.
module hd_tooth_flanks
  use hd_kinds, only: dp, pi
  use hd_body, only: body_t
  use hd_elastic_law, only: stick_ratio
  use hd_face, only: face_t
  use hd_rim_load, only: force_tooth, rim_nodes
  use hd_scene, only: scene_t
  use hd_strut, only: strut_t
  implicit none
  private
  public :: tooth_angles, tooth_gaps, turn_to_flank, flank_struts, flank_directions, flanks_of

contains

  !> Places of the pairs, half of them around each end of the long axis [rad].
  pure function tooth_angles(scene) result(theta)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp) :: theta(scene%tooth_pairs)
    integer :: i
    theta = (2*pi/scene%teeth)*places(scene) + [(merge(pi, 0._dp, i > scene%tooth_pairs/2), i=1, scene%tooth_pairs)]
  end function tooth_angles

  !> Distances of the pairs from the nearer end of the long axis [tooth pitches].
  pure function places(scene) result(x)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp) :: x(scene%tooth_pairs)
    integer :: i, half
    half = scene%tooth_pairs/2
    x = scene%tooth_phase + [(modulo(i - 1, half) + 1 - 0.5_dp*(half + 1), i=1, scene%tooth_pairs)]
  end function places

  !> Clearances along the normals when the assembly ends: those of the scene's lists, or 0 on the long axis, growing with the
  !> square of the distance [m].
  pure function tooth_gaps(scene, side) result(gap)
    type(scene_t), intent(in) :: scene       !< scene
    integer, intent(in), optional :: side    !< 1: flanks that a positive torque presses, 2: the others; default: their mean
    real(dp) :: gap(scene%tooth_pairs)
    if (scene%gap_count <= 1 .and. .not. scene%gaps(1) > 0) then
      gap = scene%tooth_clearance*(2*places(scene)/max(1, scene%tooth_pairs/2 - 1))**2
    else if (scene%gap_back_count <= 1 .and. .not. scene%gaps_back(1) > 0) then
      gap = listed(scene, scene%gaps)
    else if (present(side)) then
      gap = merge(listed(scene, scene%gaps), listed(scene, scene%gaps_back), side == 1)
    else
      gap = (listed(scene, scene%gaps) + listed(scene, scene%gaps_back))/2
    end if
  end function tooth_gaps

  !> Turn of the bottom to the nearest flank of a side [rad].
  pure real(dp) function turn_to_flank(scene, closing) result(turn)
    type(scene_t), intent(in) :: scene      !< scene
    real(dp), intent(in) :: closing(:)      !< of the flanks of this side [m]
    turn = -maxval(closing)/(cos(scene%pressure_angle_deg*pi/180)*scene%tooth_circle())
  end function turn_to_flank

  !> Clearances of a list, on the cubic of the four nearest pairs where the wave generator has turned on [m].
  pure function listed(scene, gaps) result(gap)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp), intent(in) :: gaps(:)     !< of the pairs at one end of the long axis, or at both [m]
    real(dp), dimension(scene%tooth_pairs) :: gap, share, x
    integer :: first(scene%tooth_pairs), from(scene%tooth_pairs), half, i, j, n
    half = scene%tooth_pairs/2
    n = min(4, half)
    x = min(max(places(scene) + 0.5_dp*(half + 1), 1._dp), real(half, dp))
    first = max(1, min(floor(x) + 1 - n/2, half + 1 - n))
    from = [(merge(half, 0, i > half .and. scene%gap_count > half), i=1, scene%tooth_pairs)] + first - 1
    gap = 0
    do i = 1, n
      share = 1
      do j = 1, n
        if (j /= i) share = share*(x - (first + j - 1))/(i - j)
      end do
      gap = gap + share*gaps(from + i)
    end do
    gap = max(0._dp, gap)
  end function listed

  !> Struts of the flanks, and of their companions where they rub.
  pure integer function flanks_of(scene) result(n)
    type(scene_t), intent(in) :: scene  !< scene
    n = 2*scene%tooth_pairs*merge(2, 1, scene%tooth_friction > 0)
  end function flanks_of

  !> Radial and tangential parts of the unit vectors of a pair: normals of both flanks, then their tangents.
  pure function flank_directions(scene) result(d)
    type(scene_t), intent(in) :: scene  !< scene
    real(dp) :: d(2, 4), angle
    angle = scene%pressure_angle_deg*pi/180
    d(:, 1) = [sin(angle), cos(angle)]
    d(:, 2) = [sin(angle), -cos(angle)]
    d(:, 3) = [cos(angle), -sin(angle)]
    d(:, 4) = [cos(angle), sin(angle)]
  end function flank_directions

  !> Stiffness of a flank that sticks, along its tangent, by Mindlin's ratio of bodies pressed together. A tenth or ten times as
  !> much changes no digit of K1 to K3 and the hysteresis by 0.05 % (drive14, mu = 0.1): flanks slip by far more than they give.
  pure real(dp) function tangent_stiffness(scene) result(k)
    type(scene_t), intent(in) :: scene  !< scene
    k = scene%tooth_stiffness*stick_ratio(scene%flexspline_e, scene%flexspline_nu, scene%flexspline_e, scene%flexspline_nu)
  end function tangent_stiffness

  !> Struts of the flanks: each amid the height of its tooth.
  function flank_struts(scene, body, rim, first) result(struts)
    type(scene_t), intent(in) :: scene  !< scene
    type(body_t), intent(in) :: body    !< flexspline
    type(face_t), intent(in) :: rim     !< outside of its rim, nodes numbered in the body
    integer, intent(in) :: first        !< nodes before the flexspline's
    type(strut_t) :: struts(flanks_of(scene))
    real(dp), dimension(3, body%nodes()) :: radial, tangential
    real(dp) :: theta(scene%tooth_pairs), along(2, 4)
    integer, allocatable :: outside(:), nodes(:)
    integer :: i, kind, n
    n = 2*scene%tooth_pairs
    along = flank_directions(scene)
    theta = tooth_angles(scene)
    outside = rim_nodes(body, rim)
    radial = 0
    tangential = 0
    do i = 1, scene%tooth_pairs
      call force_tooth(scene, body, rim, outside, theta(i)/(2*pi), radial, tangential)
      nodes = pack(outside, any(abs(tangential(:, outside)) > 0, 1))
      do kind = 1, merge(4, 2, size(struts) > n)
        associate (strut => struts(2*(i - 1) + kind + merge(n - 2, 0, kind > 2)))
          strut%rate = scene%tooth_stiffness
          if (kind > 2) strut%rate = tangent_stiffness(scene)
          strut%power = 1
          strut%pulls = .false.
          strut%node = nodes + first
          strut%weight = along(1, kind)*radial(:, nodes) + along(2, kind)*tangential(:, nodes)
        end associate
      end do
    end do
  end function flank_struts
end module hd_tooth_flanks
