! SPDX-License-Identifier: GPL-3.0-or-later
!> The circular spline as an elastic ring, the width over which its teeth push, and their clearances.
module test_spline_ring
  use hd_kinds, only: dp, pi
  use hd_body, only: axial_moment, body_t
  use hd_check, only: check, check_close
  use hd_face, only: face_t
  use hd_hexahedron, only: hex8i
  use hd_rim_load, only: force_tooth, rim_nodes
  use hd_scene, only: scene_t
  use hd_spline_ring, only: spline_ring_t, new_spline_ring, ring_compliance
  use hd_test_bodies, only: two_rings
  use hd_tooth_flanks, only: tooth_gaps
  implicit none
  private
  public :: run_spline_ring

contains

  subroutine run_spline_ring()
    call ring_under_forces()
    call teeth_over_the_width()
    call clearances_between_pairs()
  end subroutine run_spline_ring

  !> Clearances that are a cubic over the pairs, another at either end of the long axis, are that cubic after a part of a pitch; two
  !> pairs have a line; none is negative; beyond the outermost pair the last value stays.
  subroutine clearances_between_pairs()
    real(dp), parameter :: x(12) = [1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6], ends(12) = [spread(1, 1, 6), spread(2, 1, 6)]
    type(scene_t) :: scene
    scene%tooth_pairs = 12
    scene%tooth_phase = -0.3_dp
    scene%gap_count = 12
    scene%gaps(:12) = ends*cubic(x)
    call check_close(maxval(abs(tooth_gaps(scene) - ends*cubic(max(1._dp, x + scene%tooth_phase)))), 0._dp, 1e-18_dp, &
      'clearances between pairs are on the cubic of their neighbours')
    scene%tooth_pairs = 4
    scene%gap_count = 2
    scene%gaps(:2) = [1e-6_dp, 3e-6_dp]
    call check_close(maxval(abs(tooth_gaps(scene) - [1e-6_dp, 2.4e-6_dp, 1e-6_dp, 2.4e-6_dp])), 0._dp, 1e-18_dp, &
      'those of two pairs on their line')
    scene%tooth_pairs = 8
    scene%gap_count = 4
    scene%gaps(:4) = [1e-6_dp, 0._dp, 0._dp, 1e-6_dp]
    scene%tooth_phase = 0.5_dp
    call check_close(minval(tooth_gaps(scene)), 0._dp, 1e-18_dp, 'where the cubic dives below 0 the flanks touch')
  contains
    elemental real(dp) function cubic(place)
      real(dp), intent(in) :: place
      cubic = 1e-7_dp*(70 + (place - 2)**3 - place)
    end function cubic
  end subroutine clearances_between_pairs

  !> Two opposite radial forces P widen a ring by  P [R^3/(E I) (pi/4 - 2/pi) + R/(E A) pi/4 + R/(k G A) pi/4]  (Castigliano), thin
  !> or thick, but for the shear of the harmonics left out. What one point does to another, that does to it (Maxwell). Two
  !> opposite tangential forces, whose moment the housing takes, move the teeth along.
  subroutine ring_under_forces()
    real(dp), parameter :: young = 209e9_dp, poisson = 0.295_dp, radius = 18e-3_dp, width = 9e-3_dp
    real(dp), parameter :: thick(3) = [0.1e-3_dp, 1e-3_dp, 7e-3_dp]
    type(spline_ring_t) :: ring
    real(dp) :: c(2, 2), d(2, 2), r, area, widened
    integer :: i
    do i = 1, size(thick)
      ring = new_spline_ring([radius, radius + thick(i)], 0._dp, width, young, poisson)
      r = radius + thick(i)/2
      area = width*thick(i)
      widened = r/(young*area)*(r**2/(thick(i)**2/12)*(pi/4 - 2/pi) + pi/4 + 2*(1 + poisson)*6/5._dp*pi/4)
      c = ring_compliance(ring, 0._dp)
      d = ring_compliance(ring, pi)
      call check_close(2*(c(1, 1) + d(1, 1)), widened, 4e-3_dp*(thick(i)/radius)**2*widened, 'two opposite forces on a ring')
      c = ring_compliance(ring, 0.7_dp)
      d = ring_compliance(ring, -0.7_dp)
      call check(maxval(abs(c - transpose(d))) < 1e-14_dp*maxval(abs(c)), 'what one point does to another, that does to it')
    end do
    c = ring_compliance(ring, 0._dp) + ring_compliance(ring, pi)
    call check(c(2, 2) > 0 .and. abs(c(1, 2)) < 1e-12_dp*c(2, 2), 'tangential forces move the teeth along')
  end subroutine ring_under_forces

  !> A tooth pushes evenly over the width of the circular spline amid a rim of 4 mm, or over the rim, with the moment of its circle:
  !> rows of nodes at 0, 2 and 5 mm get the integrals of their linear shapes.
  subroutine teeth_over_the_width()
    type(body_t) :: cup, other
    type(face_t) :: rim, inside
    type(scene_t) :: scene
    real(dp), allocatable :: outwards(:, :), along(:, :)
    real(dp) :: width, ends(2), share(3), z(3)
    integer :: i, k
    call two_rings(hex8i, 12, 12, cup, other, rim, inside)
    scene%bore_radius = 19e-3_dp
    scene%rim_thickness = 1e-3_dp
    scene%rim_length = 4e-3_dp
    z = [0._dp, 2e-3_dp, 5e-3_dp]
    do k = 1, 2
      scene%spline_width = merge(2.4e-3_dp, 0._dp, k == 1)
      width = merge(2.4e-3_dp, 4e-3_dp, k == 1)
      ends = 2e-3_dp + [-width, width]/2
      share(1) = (z(2) - ends(1))**2/(2*z(2)*width)
      share(3) = (ends(2) - z(2))**2/(2*(z(3) - z(2))*width)
      share(2) = 1 - share(1) - share(3)
      allocate (outwards(3, cup%nodes()), along(3, cup%nodes()), source=0._dp)
      call force_tooth(scene, cup, rim, rim_nodes(cup, rim), 0.29_dp, outwards, along)
      do i = 1, 3
        call check_close(sum(outwards(1, :), abs(cup%x(3, :) - z(i)) < 1e-9_dp), share(i), 1e-12_dp, 'load of a row of the rim')
      end do
      call check_close(axial_moment(cup, along), scene%tooth_circle(), 1e-12_dp, 'moment of a tooth on its circle')
      deallocate (outwards, along)
    end do
  end subroutine teeth_over_the_width
end module test_spline_ring
