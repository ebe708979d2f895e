! SPDX-License-Identifier: GPL-3.0-or-later
!> Balls on the inner face of an elastic ring: each presses evenly on a patch that is fixed in space, normal to the face.
!>
!> A ball closes by the way of the cam less the mean over its patch of r - radius, with r the distance of the face from the axis at
!> a fixed angle. Small displacements: r - radius = u_r of the points that lie there at rest. Large ones: of the points that have
!> come there, and dr = g . du with g = normal/(normal . e_r), so that the ball pushes along the deformed face's normal and lets the
!> ring turn under it. The centre of its groove lies `lever` further in than the face: it moves along the axis by the mean of u_z
!> and by lever times the mean slope of r - radius along the axis.
module hd_ball_patch
  use hd_kinds, only: dp, pi
  use hd_face, only: face_t, shape_facet
  use hd_strut, only: placing_t, strut_t
  implicit none
  private
  public :: ball_patch_t

  integer, parameter :: samples = 12   !< of a patch along either side
  integer, parameter :: searches = 4   !< for a point; each leaves a strain's share of what was left,
  real(dp), parameter :: settled = 1e-10_dp   !< and no more are made after a change as small as this [rad]

  !> Patches of all balls, in the middle of the ring.
  type, extends(placing_t) :: ball_patch_t
    type(face_t) :: face                    !< inner face of the ring, axial facets first, then round the axis
    integer :: sectors = 0                  !< of the ring
    integer :: first = 0                    !< nodes before the ring's
    real(dp) :: radius = 0                  !< of the face [m]
    real(dp) :: z = 0                       !< of the middle [m]
    real(dp) :: angle = 0, width = 0        !< extent [rad], [m]
    real(dp), allocatable :: theta(:)       !< places of the balls [rad]
    real(dp) :: lever = 0                   !< radius of the groove's section [m]
  contains
    procedure :: place => place_ball
    procedure :: foot => material_angle
  end type ball_patch_t

contains

  !> Nodes and weights of a ball's strut, and what its closing has beside the displacements so weighted. Behind the balls come their
  !> ways along the axis.
  pure subroutine place_ball(self, i, strut, shift, u)
    class(ball_patch_t), intent(in) :: self        !< patches
    integer, intent(in) :: i                       !< which ball
    type(strut_t), intent(inout) :: strut          !< gets node, weight
    real(dp), intent(out) :: shift                 !< [m]
    real(dp), intent(in), optional :: u(:, :)      !< displacements (3, nodes of all bodies), if they may be large [m]
    real(dp) :: theta, z, xi(2), g(2), v(2), n(8), turn, share
    integer :: j, k, l, a, f
    logical :: axial
    shift = 0
    turn = 0
    axial = i > size(self%theta)
    strut%node = [integer ::]
    strut%weight = reshape([real(dp) ::], [3, 0])
    do l = 1, samples
      theta = self%theta(merge(i - size(self%theta), i, axial)) + self%angle*((l - 0.5_dp)/samples - 0.5_dp)
      do j = 1, samples
        z = self%z + self%width*((j - 0.5_dp)/samples - 0.5_dp)
        share = -1._dp/samples**2
        if (axial) share = 12*self%lever*(z - self%z)/(self%width**2*(samples**2 - 1))  ! of a line through all samples
        g = [1, 0]
        if (present(u)) then
          call follow_face(self, u, theta, z, turn, v, g, f, xi)
          shift = shift + share*((hypot(self%radius + v(1), v(2)) - self%radius) - dot_product(g, v))
        else
          call find_facet(self, theta, z, f, xi)
        end if
        call shape_facet(size(self%face%nodes, 1), xi, n)
        do k = 1, size(self%face%nodes, 1)
          a = findloc(strut%node, self%first + self%face%nodes(k, f), 1)
          if (a == 0) then
            strut%node = [strut%node, self%first + self%face%nodes(k, f)]
            a = size(strut%node)
            strut%weight = reshape([strut%weight, 0._dp, 0._dp, 0._dp], [3, a])
          end if
          strut%weight(:2, a) = strut%weight(:2, a) + n(k)*share*g
          if (axial) strut%weight(3, a) = strut%weight(3, a) + n(k)/samples**2
        end do
      end do
    end do
  end subroutine place_ball

  !> Angle at rest of the point that has come to the middle of a ball's patch [rad].
  pure real(dp) function material_angle(self, i, u) result(theta)
    class(ball_patch_t), intent(in) :: self   !< patches
    integer, intent(in) :: i                  !< which ball
    real(dp), intent(in) :: u(:, :)           !< displacements (3, nodes of all bodies) [m]
    real(dp) :: turn, v(2), g(2), xi(2)
    integer :: f
    turn = 0
    associate (place => self%theta(modulo(i - 1, size(self%theta)) + 1))
      call follow_face(self, u, place, self%z, turn, v, g, f, xi)
      theta = place - turn
    end associate
  end function material_angle

  !> The point of the deformed face at an angle in space: its displacement, how its distance from the axis follows displacements,
  !> and its facet.
  pure subroutine follow_face(patch, u, theta, z, turn, v, g, facet, xi)
    type(ball_patch_t), intent(in) :: patch      !< patches
    real(dp), intent(in) :: u(:, :)              !< displacements (3, nodes of all bodies) [m]
    real(dp), intent(in) :: theta, z             !< angle in space [rad], place along the axis at rest [m]
    real(dp), intent(inout) :: turn              !< guess of how far it has come round the axis, then that [rad]
    real(dp), intent(out) :: v(2)                !< u_r, u_theta [m]
    real(dp), intent(out) :: g(2)                !< dr/du
    integer, intent(out) :: facet                !< facet
    real(dp), intent(out) :: xi(2)               !< place on it
    real(dp), parameter :: h = 0.5_dp
    real(dp) :: before, slope(2), normal(2)
    integer :: i
    do i = 1, searches
      call find_facet(patch, theta - turn, z, facet, xi)
      v = mean(xi)
      if (i == searches) exit
      before = turn
      turn = atan2(v(2), patch%radius + v(1))
      if (abs(turn - before) <= settled) exit
    end do
    slope = (mean([xi(1) + h, xi(2)]) - mean([xi(1) - h, xi(2)]))/(2*h)*patch%sectors/pi
    normal = [patch%radius + v(1) + slope(2), v(2) - slope(1)]
    g = normal/dot_product(normal, [cos(turn), sin(turn)])
  contains
    !> Displacement at a place of the facet.
    pure function mean(at) result(w)
      real(dp), intent(in) :: at(2)  !< place
      real(dp) :: w(2), n(8)
      integer :: k
      call shape_facet(size(patch%face%nodes, 1), at, n)
      w = 0
      do k = 1, size(patch%face%nodes, 1)
        w = w + n(k)*u(:2, patch%first + patch%face%nodes(k, facet))
      end do
    end function mean
  end subroutine follow_face

  !> The facet at a place, and the place on it.
  pure subroutine find_facet(patch, theta, z, facet, xi)
    type(ball_patch_t), intent(in) :: patch   !< patches
    real(dp), intent(in) :: theta, z          !< at rest [rad], [m]
    integer, intent(out) :: facet             !< facet
    real(dp), intent(out) :: xi(2)            !< place on it
    real(dp) :: place
    integer :: rows, sector
    rows = size(patch%face%nodes, 2)/patch%sectors
    place = modulo(theta/(2*pi), 1._dp)*patch%sectors
    sector = min(floor(place), patch%sectors - 1)
    xi(1) = 2*(place - sector) - 1
    facet = sector*rows + 1
    do while (facet < (sector + 1)*rows .and. z > patch%face%chart(2, 4, facet))
      facet = facet + 1
    end do
    xi(2) = 2*(z - patch%face%chart(2, 1, facet))/(patch%face%chart(2, 4, facet) - patch%face%chart(2, 1, facet)) - 1
  end subroutine find_facet
end module hd_ball_patch
