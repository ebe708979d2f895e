! SPDX-License-Identifier: GPL-3.0-or-later
!> The circular spline as an elastic ring.
module test_spline_ring
  use hd_kinds, only: dp, pi
  use hd_check, only: check, check_close
  use hd_spline_ring, only: spline_ring_t, new_spline_ring, ring_compliance
  implicit none
  private
  public :: run_spline_ring

contains

  !> Two opposite radial forces P widen a ring by  P [R^3/(E I) (pi/4 - 2/pi) + R/(E A) pi/4 + R/(k G A) pi/4]  (Castigliano), thin
  !> or thick, but for the shear of the harmonics left out. What one point does to another, that does to it (Maxwell). Two
  !> opposite tangential forces, whose moment the housing takes, move the teeth along.
  subroutine run_spline_ring()
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
  end subroutine run_spline_ring
end module test_spline_ring
