! SPDX-License-Identifier: GPL-3.0-or-later
!> Points that meet after large displacements.
module test_pairing
  use hd_body, only: axial_moment, body_t
  use hd_check, only: check, check_close
  use hd_face, only: face_t
  use hd_hexahedron, only: hex8i
  use hd_kinds, only: dp, pi
  use hd_mortar, only: add_nodal_forces, coupling_block, mortar_t, new_mortar, relative_displacement
  use hd_pairing, only: pair_faces, pairing_error, pairing_t
  use hd_test_bodies, only: two_rings
  implicit none
  private
  public :: run_pairing

  real(dp), parameter :: radius = 20e-3_dp, w = 0.2e-3_dp   !< of the rings, and what makes them oval [m]

contains

  subroutine run_pairing()
    real(dp) :: coarse(2), fine(2)
    call turned_ring()
    call slid_along_oval(24, 34, 1._dp, coarse)
    call slid_along_oval(48, 68, 1._dp, fine)
    call check(fine(1) < 0.6e-6_dp .and. fine(1) < coarse(1)/3, 'rings that slide along an oval stay closed, to second order')
    call check(fine(2) < 2.5e-4_dp .and. fine(2) < coarse(2)/3, 'normals of an oval, to second order')
    call slid_along_oval(48, 68, -1._dp, fine)
    call check(fine(1) < 0.6e-6_dp, 'the same for the slave against the master')
  end subroutine run_pairing

  !> Two rings and their coupling at rest.
  subroutine new_rings(n_inner, n_outer, sign, bodies, pairing, mortar)
    integer, intent(in) :: n_inner, n_outer
    real(dp), intent(in) :: sign
    type(body_t), intent(out) :: bodies(2)
    type(pairing_t), intent(out) :: pairing
    type(mortar_t), intent(out) :: mortar
    type(face_t) :: slave, master
    call two_rings(hex8i, n_inner, n_outer, bodies(1), bodies(2), slave, master)
    call new_mortar(slave, master, mortar)
    pairing = pairing_t(slave, master, mortar, radius=radius, sign=sign, slave_nodes=bodies(1)%nodes())
    allocate (pairing%stretch(mortar%n), source=1._dp)
    allocate (pairing%bend(mortar%n), source=1/radius)
    mortar%val = sign*mortar%val
  end subroutine new_rings

  !> Displacements of a body whose points at the radius move to polar angle theta + angle of the oval and along the axis.
  function on_oval(body, oval, angle, along) result(u)
    type(body_t), intent(in) :: body
    real(dp), intent(in) :: oval, angle, along
    real(dp) :: u(3, body%nodes()), r
    integer :: i
    do i = 1, body%nodes()
      r = hypot(body%x(1, i), body%x(2, i)) + oval*cos(2*(body%angle(i) + angle))
      u(:, i) = [r*cos(angle) - hypot(body%x(1, i), body%x(2, i)), r*sin(angle), along]
    end do
  end function on_oval

  !> A ring turned by 0.02 rad and shifted by 0.1 mm inside another: no gap, where pairs at rest see 4 um; moments balance.
  subroutine turned_ring()
    type(body_t) :: bodies(2)
    type(pairing_t) :: pairing
    type(mortar_t) :: mortar
    real(dp), allocatable :: u(:, :), f(:, :), t(:, :), y(:, :), far(:, :)
    real(dp) :: apart, turned, block(3, 3)
    integer :: first, j, k
    call new_rings(24, 17, 1._dp, bodies, pairing, mortar)
    first = bodies(1)%nodes()
    u = reshape([on_oval(bodies(1), 0._dp, 0._dp, 0._dp), on_oval(bodies(2), 0._dp, 0.02_dp, 1e-4_dp)], &
      [3, first + bodies(2)%nodes()])
    far = relative_displacement(mortar, u)
    call check_close(minval(far(1, :))/(radius*(cos(0.02_dp) - 1)), 1._dp, 1e-9_dp, &
      'pairs at rest see a gap where a ring only turned')
    call pair_faces(pairing, u, mortar)
    y = relative_displacement(mortar, u) + mortar%offset
    call check_close(maxval(abs(y))/radius, 0._dp, 1e-14_dp, 'a ring turned and shifted in another leaves no gap and lies opposite')
    call pairing_error(pairing, mortar, u, spread(1e6_dp, 1, mortar%n), apart, turned)
    call check_close(apart/radius + turned, 0._dp, 1e-14_dp, 'pairs that are found stay')
    call check_close(sum(mortar%area)/(2*pi*radius*4.9e-3_dp), 1._dp, 1e-12_dp, 'what was shifted over the edge is no contact')
    allocate (t(3, mortar%n), f(3, size(u, 2)))
    t(1, :) = [(1 + sin(3._dp*j), j=1, mortar%n)]
    t(2, :) = [(cos(5._dp*j), j=1, mortar%n)]
    t(3, :) = [(sin(7._dp*j), j=1, mortar%n)]
    f = 0
    call add_nodal_forces(mortar, t, f)
    associate (on_slave => axial_moment(bodies(1), f(:, :first), u(:, :first)), &
        on_master => axial_moment(bodies(2), f(:, first + 1:), u(:, first + 1:)))
      call check_close((on_slave + on_master)/abs(on_master), 0._dp, 1e-12_dp, 'tractions between pairs have no moment')
    end associate
    y = relative_displacement(mortar, u)
    call check_close(sum(spread(mortar%area, 1, 3)*t*y)/sum(f*u), 1._dp, 1e-12_dp, 'nodal forces do the work of the tractions')
    do j = 1, mortar%n
      do k = mortar%ptr(j), mortar%ptr(j + 1) - 1
        block = coupling_block(mortar, j, k)
        y(:, j) = y(:, j) - matmul(block, u(:, mortar%col(k)))
      end do
    end do
    call check_close(maxval(abs(y))/radius, 0._dp, 1e-14_dp, 'blocks of the coupling add up to the relative displacement')
  end subroutine turned_ring

  !> Two rings on the same oval, the outer one further round it by 0.2 mm: gap and normals against those of the curve. Pairs at rest
  !> would see 4 um; what is left is the curve between the nodes, 4 w h^2 / 8.
  subroutine slid_along_oval(n_inner, n_outer, sign, errors)
    integer, intent(in) :: n_inner, n_outer
    real(dp), intent(in) :: sign
    real(dp), intent(out) :: errors(2)   !< of the gap [m] and of the normals
    type(body_t) :: bodies(2)
    type(pairing_t) :: pairing
    type(mortar_t) :: mortar
    real(dp), allocatable :: u(:, :), y(:, :)
    real(dp) :: slope
    integer :: j
    call new_rings(n_inner, n_outer, sign, bodies, pairing, mortar)
    u = reshape([on_oval(bodies(1), w, 0._dp, 0._dp), on_oval(bodies(2), w, 0.01_dp, 0._dp)], &
      [3, bodies(1)%nodes() + bodies(2)%nodes()])
    call pair_faces(pairing, u, mortar)
    y = relative_displacement(mortar, u) + mortar%offset
    errors(1) = maxval(abs(y(1, :)))
    errors(2) = 0
    do j = 1, mortar%n
      associate (theta => bodies(1)%angle(mortar%node(j)))
        slope = -2*w*sin(2*theta)/(radius + w*cos(2*theta))
        errors(2) = max(errors(2), norm2(mortar%turn(1, :, j) - [1._dp, -slope, 0._dp]/sqrt(1 + slope**2)))
      end associate
    end do
  end subroutine slid_along_oval
end module test_pairing
