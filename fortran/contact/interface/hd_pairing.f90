! SPDX-License-Identifier: GPL-3.0-or-later
!> Which points of two faces press on each other after large displacements, and in which frame. At rest both lie on one curve round
!> the axis, a circle or one near it.
!>
!> A point of the slave at the angle theta and its opposite at theta + beta, z + zeta of the master are apart by
!>   y = R(beta) [radius + u_r, u_theta, u_z]_master - [radius + u_r, u_theta, u_z]_slave + [0, 0, zeta],  radius that of curvature,
!> in the slave's directions at theta. The pair is where y has no part along the deformed slave's tangents; its normal gives the
!> gap. Both follow from the displacements alone, whatever was before. Within an equilibrium they stand still: hd_newton solves
!> it and pairs anew, until nothing moves.
module hd_pairing
  use hd_kinds, only: dp
  use hd_body, only: frame
  use hd_face, only: face_t
  use hd_mortar, only: mortar_t, new_mortar, add_rigid, relative_displacement, side_sums
  use hd_vector, only: cross
  implicit none
  private
  public :: pairing_t, pair_faces, pairing_error

  integer, parameter :: searches = 3   !< for the opposite; each leaves a strain's share of what was left

  type :: pairing_t
    type(face_t) :: slave, master             !< faces at rest; the master may reach further than where they touch
    type(mortar_t) :: rest                    !< their coupling at rest, displacements of the master against the slave
    type(face_t), allocatable :: inside       !< face that meets a rigid surface
    real(dp) :: radius = 0                    !< of the chart [m]
    real(dp), allocatable :: stretch(:)       !< length of the faces over that of the chart round the axis (multipliers)
    real(dp), allocatable :: bend(:)          !< turn of the normal at rest over length of the chart (multipliers) [rad/m]
    real(dp) :: sign = 1                      !< -1 if displacements of the slave against the master are asked for
    integer :: slave_nodes = 0                !< nodes of the slave's body, which come first
  end type pairing_t

contains

  !> Couple the deformed faces.
  subroutine pair_faces(pairing, u, mortar, again)
    type(pairing_t), intent(in) :: pairing      !< faces
    real(dp), intent(in) :: u(:, :)             !< displacements (3, nodes) [m]
    type(mortar_t), intent(inout) :: mortar     !< coupling before, then anew
    logical, intent(in), optional :: again      !< in rounds, where one search does: not the first, it goes on from before
    type(mortar_t) :: new
    real(dp) :: shift(2, pairing%rest%n), frames(3, 3, pairing%rest%n), y(3), base(3)
    integer :: first, i, j, n
    n = pairing%rest%n
    frames = deformed_frames(pairing, u)
    new = pairing%rest
    shift = 0
    first = 1
    if (present(again)) then
      first = searches
      if (again) then
        new = mortar
        new%val = pairing%sign*new%val
        shift = mortar%shift
      end if
    end if
    do i = first, searches
      do j = 1, n
        if (.not. new%area(j) > 0) cycle
        y = matmul(frames(:, :, j), apart(pairing, new, u, shift(:, j), j))
        shift(:, j) = shift(:, j) - y(2:)/[pairing%stretch(j), 1._dp]
      end do
      call new_mortar(pairing%slave, pairing%master, new, shift)
    end do
    new%slave_nodes = pairing%slave_nodes
    new%val = pairing%sign*new%val
    if (allocated(pairing%inside)) call add_rigid(new, pairing%inside)
    allocate (new%turn(3, 3, new%n), new%carry(3, 3, new%n), new%offset(3, new%n))
    new%turn(:, :, :n) = frames
    new%turn(:, :, n + 1:) = spread(frame(0._dp), 3, new%rigid)
    new%carry = new%turn
    new%offset = 0
    new%shift = shift
    do j = 1, n
      base = [pairing%stretch(j)/pairing%bend(j), 0._dp, 0._dp]
      new%carry(:, :, j) = matmul(frames(:, :, j), frame(shift(1, j)*pairing%bend(j)))
      new%offset(:, j) = pairing%sign*(matmul(new%carry(:, :, j), base) + &
        matmul(frames(:, :, j), [0._dp, 0._dp, shift(2, j)] - base))
    end do
    new%serial = mortar%serial + 1
    new%pattern = merge(mortar%pattern, new%serial, same_pattern(new, mortar))
    mortar = new
  end subroutine pair_faces

  !> Both couplings have entries at the same places.
  pure logical function same_pattern(a, b)
    type(mortar_t), intent(in) :: a, b   !< couplings of the same faces
    same_pattern = size(a%col) == size(b%col) .and. (allocated(a%turn) .eqv. allocated(b%turn))
    if (same_pattern) same_pattern = all(a%ptr == b%ptr) .and. all(a%col == b%col)
  end function same_pattern

  !> What displacements have moved since the faces were paired, in the mean over the pressure: distance of the pairs along the face,
  !> and turn of their normals.
  subroutine pairing_error(pairing, mortar, u, pressure, apart_by, turned_by)
    type(pairing_t), intent(in) :: pairing     !< faces
    type(mortar_t), intent(in) :: mortar       !< their coupling
    real(dp), intent(in) :: u(:, :)            !< displacements (3, nodes) [m]
    real(dp), intent(in) :: pressure(:)        !< (multipliers) [Pa]
    real(dp), intent(out) :: apart_by          !< [m]
    real(dp), intent(out) :: turned_by         !< [rad]
    real(dp) :: frames(3, 3, pairing%rest%n), w(3, mortar%n), force(pairing%rest%n)
    integer :: n
    n = pairing%rest%n
    frames = deformed_frames(pairing, u)
    w = relative_displacement(mortar, u) + mortar%offset
    force = mortar%area(:n)*max(0._dp, pressure(:n))
    force = force/max(sum(force), tiny(1._dp))
    apart_by = sum(force*norm2(w(2:, :n), 1))
    turned_by = sum(force*norm2(frames(1, :, :) - mortar%turn(1, :, :n), 1))
  end subroutine pairing_error

  !> Position of the opposite on the master against a multiplier, in the slave's directions at rest [m].
  pure function apart(pairing, mortar, u, shift, j) result(y)
    type(pairing_t), intent(in) :: pairing   !< faces
    type(mortar_t), intent(in) :: mortar     !< coupling by that shift
    real(dp), intent(in) :: u(:, :)          !< displacements (3, nodes) [m]
    real(dp), intent(in) :: shift(2)         !< way to the opposite on the chart [m]
    integer, intent(in) :: j                 !< multiplier
    real(dp) :: y(3), base(3), sides(3, 2)
    base = [pairing%stretch(j)/pairing%bend(j), 0._dp, 0._dp]
    sides = side_sums(mortar, pairing%slave_nodes, u, j)
    y = matmul(frame(shift(1)*pairing%bend(j)), base + sides(:, 2)) - base + sides(:, 1)
    y(3) = y(3) + shift(2)
  end function apart

  !> Unit normal and tangents (round the axis, then along it) of the deformed slave at its multipliers, as rows.
  pure function deformed_frames(pairing, u) result(frames)
    type(pairing_t), intent(in) :: pairing                  !< faces
    real(dp), intent(in) :: u(:, :)                         !< displacements (3, nodes) [m]
    real(dp) :: frames(3, 3, pairing%rest%n)                !< in the dofs of the slave
    real(dp) :: slope(3, 2, pairing%rest%n), weight(2, pairing%rest%n), a(3), b(3), normal(3), length
    integer, parameter :: next(2, 4) = reshape([2, 4, 1, 3, 4, 2, 3, 1], [2, 4])  ! along the first, the second coordinate
    integer :: c, d, f, j
    slope = 0
    weight = 0
    associate (nodes => pairing%slave%nodes, chart => pairing%slave%chart)
      do f = 1, size(nodes, 2)
        do c = 1, 4
          j = pairing%rest%facet(c, f)
          do d = 1, 2
            length = chart(d, next(d, c), f) - chart(d, c, f)
            weight(d, j) = weight(d, j) + 1/abs(length)   ! the shorter side counts more: second order on uneven facets
            slope(:, d, j) = slope(:, d, j) + (u(:, nodes(next(d, c), f)) - u(:, nodes(c, f)))/(length*abs(length))
          end do
        end do
      end do
    end associate
    do j = 1, pairing%rest%n
      associate (v => u(:, pairing%rest%node(j)))
        a = slope(:, 1, j)/weight(1, j) + [-v(2)*pairing%bend(j), pairing%stretch(j) + v(1)*pairing%bend(j), 0._dp]
        b = slope(:, 2, j)/weight(2, j) + [0._dp, 0._dp, 1._dp]
      end associate
      normal = cross(a, b)
      frames(1, :, j) = normal/norm2(normal)
      frames(2, :, j) = a/norm2(a)
      frames(3, :, j) = cross(frames(1, :, j), frames(2, :, j))
    end do
  end function deformed_frames
end module hd_pairing
