! SPDX-License-Identifier: GPL-3.0-or-later
!> Loads on the outside of the toothed rim: even shear, or the forces of the tooth pairs near the long axis.
module hd_rim_load
  use hd_kinds, only: dp, pi
  use hd_body, only: body_t, axial_moment
  use hd_face, only: face_t, shape_facet
  use hd_scene, only: scene_t
  implicit none
  private
  public :: even_shear, tooth_forces, force_tooth, rim_nodes

  !> gauss_2 of hd_gauss but for its last bit, which is correctly rounded there and on which every torque's result hangs: equal bits
  !> of earlier runs count for more than one line.
  real(dp), parameter :: gauss(2) = [-1, 1]/sqrt(3._dp)

contains

  !> Even shear with a unit moment about the axis.
  pure function even_shear(scene, body, face) result(force)
    type(scene_t), intent(in) :: scene  !< where the rim ends
    type(body_t), intent(in) :: body    !< flexspline
    type(face_t), intent(in) :: face    !< outside of the rim, nodes numbered in the body
    real(dp) :: force(3, body%nodes())
    integer :: s, g
    force = 0
    do s = 0, scene%divisions - 1
      do g = 1, 2
        call add_rim_line(body, face, s + (1 + gauss(g))/2, 1._dp, [0._dp, scene%rim_length], force(2, :))
      end do
    end do
    force = force/axial_moment(body, force)
  end function even_shear

  !> Forces of the tooth pairs in mesh, evenly shared, half of them around each end of the long axis.
  pure subroutine tooth_forces(scene, body, face, tangential, radial)
    type(scene_t), intent(in) :: scene              !< scene
    type(body_t), intent(in) :: body                !< flexspline
    type(face_t), intent(in) :: face                !< outside of the rim, nodes numbered in the body
    real(dp), intent(out) :: tangential(:, :)       !< forces along the rim with a unit moment (3, nodes) [1/m]
    real(dp), intent(out) :: radial(:, :)           !< inward forces that go with them (3, nodes) [1/m]
    integer :: tooth, lobe, half
    tangential = 0
    radial = 0
    half = scene%tooth_pairs/2
    do lobe = 0, 1
      do tooth = 1, half
        call add_tooth(scene, body, face, 0.5_dp*lobe + (tooth - 0.5_dp*(half + 1))/scene%teeth, tangential(2, :))
      end do
    end do
    tangential = tangential/axial_moment(body, tangential)
    radial(1, :) = -tan(scene%pressure_angle_deg*pi/180)*tangential(2, :)
  end subroutine tooth_forces

  !> Nodes of the rim's outside, each once.
  pure function rim_nodes(body, face) result(nodes)
    type(body_t), intent(in) :: body     !< flexspline
    type(face_t), intent(in) :: face     !< outside of the rim, nodes numbered in the body
    integer, allocatable :: nodes(:)
    logical :: outside(body%nodes())
    integer :: i
    outside = .false.
    outside([face%nodes]) = .true.
    nodes = pack([(i, i=1, size(outside))], outside)
  end function rim_nodes

  !> Nodal forces of unit forces amid the height of a tooth: outwards, and along the rim, whose arm over the rim's outside tilts it.
  pure subroutine force_tooth(scene, body, face, nodes, turn, outwards, along)
    type(scene_t), intent(in) :: scene           !< where the rim ends, teeth
    type(body_t), intent(in) :: body             !< flexspline
    type(face_t), intent(in) :: face             !< outside of the rim, nodes numbered in the body
    integer, intent(in) :: nodes(:)              !< as rim_nodes
    real(dp), intent(in) :: turn                 !< place of the tooth [turns]
    real(dp), intent(inout) :: outwards(:, :), along(:, :)  !< forces (3, nodes), set on the rim alone
    real(dp) :: rim, arm, apart, ends(2)
    rim = scene%bore_radius + scene%rim_thickness
    arm = scene%tooth_circle() - rim
    apart = 1._dp/min(body%sectors, scene%teeth)
    ends = scene%tooth_ends()
    outwards(:, nodes) = 0
    along(:, nodes) = 0
    call add_tooth(scene, body, face, turn, along(2, :))
    along(2, nodes) = along(2, nodes)*rim/axial_moment(body, along)
    outwards(1, nodes) = along(2, nodes)
    call add_tooth(scene, body, face, turn - apart/2, along(1, :))
    along(1, nodes) = -along(1, nodes)
    call add_tooth(scene, body, face, turn + apart/2, along(1, :))
    along(1, nodes) = -along(1, nodes)*(sum(outwards(1, nodes))/(ends(2) - ends(1))*arm/rim/(2*pi*apart))
    along(2, nodes) = along(2, nodes)*(1 + arm/rim)
  end subroutine force_tooth

  !> Add the nodal weights of a tooth: an even load along what of the rim it touches, over one pitch of the teeth round the axis, or
  !> one facet if that is longer. So no pair is stiffer for standing on a meridian of the mesh.
  pure subroutine add_tooth(scene, body, face, turn, weight)
    type(scene_t), intent(in) :: scene  !< where the rim ends, teeth
    type(body_t), intent(in) :: body    !< flexspline
    type(face_t), intent(in) :: face    !< outside of the rim, axial facets first, then round the axis
    real(dp), intent(in) :: turn         !< place of its middle [turns]
    real(dp), intent(inout) :: weight(:) !< of the body's nodes; their sum grows by the length that is loaded [m]
    real(dp) :: from, to, low, high, width
    integer :: sector, g
    width = max(1._dp, real(body%sectors, dp)/scene%teeth)
    from = body%sectors*turn - width/2
    to = from + width
    do sector = floor(from), floor(to)
      low = max(from, real(sector, dp))
      high = min(to, real(sector + 1, dp))
      if (.not. high > low) cycle
      do g = 1, 2
        call add_rim_line(body, face, low + (high - low)*(1 + gauss(g))/2, (high - low)/(2*width), scene%tooth_ends(), weight)
      end do
    end do
  end subroutine add_tooth

  !> Add the nodal weights of an even load along one meridian of the rim.
  pure subroutine add_rim_line(body, face, place, amount, ends, weight)
    type(body_t), intent(in) :: body    !< flexspline
    type(face_t), intent(in) :: face    !< outside of the rim, axial facets first, then round the axis
    real(dp), intent(in) :: place        !< meridian, in sectors from theta = 0
    real(dp), intent(in) :: amount       !< factor
    real(dp), intent(in) :: ends(2)      !< where the load begins and ends, from the opening [m]
    real(dp), intent(inout) :: weight(:) !< of the body's nodes; their sum grows by amount times the length that is loaded [m]
    real(dp), parameter :: rounding = 1e-9_dp  !< of a place that stands on the border of two sectors
    real(dp) :: z(2), part(2), xi(2), n(8)
    integer :: sector, rows, f, g
    rows = size(face%nodes, 2)/body%sectors
    sector = floor(place + rounding)
    xi(1) = 2*(place - sector) - 1
    do f = rows*modulo(sector, body%sectors) + 1, rows*modulo(sector, body%sectors) + rows
      z = face%chart(2, [1, 4], f)
      part = min(max((ends - z(1))/(z(2) - z(1)), 0._dp), 1._dp)
      if (.not. part(2) > part(1)) cycle
      do g = 1, 2
        xi(2) = 2*part(1) + (part(2) - part(1))*(1 + gauss(g)) - 1
        associate (list => face%nodes(:, f))
          call shape_facet(size(list), xi, n)
          weight(list) = weight(list) + amount*n(:size(list))*(part(2) - part(1))*(z(2) - z(1))/2
        end associate
      end do
    end do
  end subroutine add_rim_line
end module hd_rim_load
