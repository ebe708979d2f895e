! SPDX-License-Identifier: GPL-3.0-or-later
!> Hertz's point contact of ball and race.
module test_hertz
  use hd_kinds, only: dp, pi
  use hd_check, only: check
  use hd_hertz, only: point_contact_t, ball_on_race, contact_pressure, contact_rate, elliptic_integrals, in_series
  implicit none
  private
  public :: run_hertz

contains

  !> Elliptic integrals against Abramowitz and Stegun, table 17.1; a ball on a plane against Hertz's closed form; the steel constant
  !> 2.15e5 N/mm^1.5 of Harris (6.56); a groove that holds the ball closely is stiffer than an open one.
  subroutine run_hertz()
    real(dp) :: first, second, r, e, k
    type(point_contact_t) :: plane, groove
    call elliptic_integrals(0.5_dp, first, second)
    call check(abs(first - 1.854074677301372_dp) < 1e-14_dp, 'K(0.5)')
    call check(abs(second - 1.350643881047675_dp) < 1e-14_dp, 'E(0.5)')
    call elliptic_integrals(0._dp, first, second)
    call check(abs(first - pi/2) + abs(second - pi/2) < 1e-15_dp, 'K(0) = E(0) = pi/2')
    r = 1.6e-3_dp
    e = 113e9_dp
    plane = ball_on_race(2*r, 1e9_dp, 1e9_dp, e)
    call check(abs(contact_rate(plane)/(4*e*sqrt(r)/3) - 1) < 1e-6_dp, 'ball on a plane')
    call check(abs(contact_pressure(plane, 50._dp)/(6*50*e**2/(pi**3*r**2))**(1/3._dp) - 1) < 1e-6_dp, 'its pressure')
    groove = ball_on_race(2*r, 13.3e-3_dp, 0.52_dp, 206.8e9_dp/(2*(1 - 0.09_dp)))
    k = 2.15e5_dp*sqrt(1e9_dp)/sqrt(groove%curvature/1e3_dp)/groove%approach**1.5_dp
    call check(abs(contact_rate(groove)/k - 1) < 5e-3_dp, 'constant of Harris for steel')
    call check(contact_rate(groove) > contact_rate(ball_on_race(2*r, 13.3e-3_dp, 0.60_dp, groove%modulus)), &
      'a close groove is stiffer')
    call check(abs(in_series(k, k)/(k/2**1.5_dp) - 1) < 1e-12_dp, 'two equal ones in series')
  end subroutine run_hertz
end module test_hertz
