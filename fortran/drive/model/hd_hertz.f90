! SPDX-License-Identifier: GPL-3.0-or-later
!> Hertz's contact of a ball with a grooved race, by complete elliptic integrals (Harris, Rolling Bearing Analysis, 6.21-6.42):
!>   approach = d* S/2 (3 F / (2 S E'))^(2/3),   d* = 2 K / (pi a*),   a* = (2 kappa^2 E / pi)^(1/3)
!>   a = a* (3 F / (2 S E'))^(1/3),   b* = a*/kappa,   largest pressure 3 F / (2 pi a b)
!> S sum of the principal curvatures, E' reduced modulus, kappa ratio of the semi-axes from the difference of the curvatures.
module hd_hertz
  use hd_kinds, only: dp, pi, hair
  implicit none
  private
  public :: point_contact_t, ball_on_race, contact_rate, contact_pressure, in_series, elliptic_integrals

  type :: point_contact_t
    real(dp) :: curvature = 0                  !< S [1/m]
    real(dp) :: approach = 1                   !< d*
    real(dp) :: axes = 1                       !< a* b*
    real(dp) :: modulus = 0                    !< E' [Pa]
  end type point_contact_t

contains

  !> Complete elliptic integrals of the first and second kind by the arithmetic-geometric mean.
  pure subroutine elliptic_integrals(m, first, second)
    real(dp), intent(in) :: m               !< parameter, modulus squared, 0 <= m < 1
    real(dp), intent(out) :: first, second  !< K(m), E(m)
    real(dp) :: a, b, c, sum, power
    integer :: i
    a = 1
    b = sqrt(1 - m)
    sum = m/2
    power = 1
    do i = 1, 40
      c = (a - b)/2
      if (.not. abs(c) > epsilon(c)*a) exit
      sum = sum + power*c**2
      power = 2*power
      c = (a + b)/2
      b = sqrt(a*b)
      a = c
    end do
    first = pi/(a + b)
    second = first*(1 - sum)
  end subroutine elliptic_integrals

  !> Contact of a ball with a race. A race that the ball runs on from outside (the inner one) has a positive radius.
  pure type(point_contact_t) function ball_on_race(diameter, race, conformity, modulus) result(contact)
    real(dp), intent(in) :: diameter    !< of the ball [m]
    real(dp), intent(in) :: race        !< radius of the race along the way of the ball, negative for the outer one [m]
    real(dp), intent(in) :: conformity  !< radius of the groove over the diameter of the ball, above 0.5; huge: no groove
    real(dp), intent(in) :: modulus     !< E' [Pa]
    real(dp) :: along, across, difference, low, high, ratio, first, second
    integer :: i
    along = 2/diameter + 1/race
    across = 2/diameter - 1/(conformity*diameter)
    contact%curvature = along + across
    contact%modulus = modulus
    difference = abs(along - across)/contact%curvature
    low = 0
    high = log(1e8_dp)
    do i = 1, 200  ! kappa by bisection of its logarithm
      ratio = exp((low + high)/2)
      if (curvature_difference(ratio) < difference) then
        low = log(ratio)
      else
        high = log(ratio)
      end if
    end do
    call elliptic_integrals(1 - 1/ratio**2, first, second)
    contact%axes = (2*ratio**2*second/pi)**(2/3._dp)/ratio
    contact%approach = 2*first/pi/(2*ratio**2*second/pi)**(1/3._dp)
  end function ball_on_race

  !> Difference of the curvatures over their sum that belongs to a ratio of the semi-axes.
  pure real(dp) function curvature_difference(ratio) result(f)
    real(dp), intent(in) :: ratio  !< kappa
    real(dp) :: first, second
    call elliptic_integrals(1 - 1/ratio**2, first, second)
    f = 0
    if (ratio**2 - 1 > hair) f = ((ratio**2 + 1)*second - 2*first)/((ratio**2 - 1)*second)
  end function curvature_difference

  !> Force over approach to the power 3/2 [N/m^1.5].
  elemental real(dp) function contact_rate(contact) result(k)
    type(point_contact_t), intent(in) :: contact  !< contact
    k = 2*contact%curvature*contact%modulus/3*(2/(contact%approach*contact%curvature))**1.5_dp
  end function contact_rate

  !> Largest pressure under a force [Pa].
  elemental real(dp) function contact_pressure(contact, force) result(p)
    type(point_contact_t), intent(in) :: contact  !< contact
    real(dp), intent(in) :: force                 !< > 0 [N]
    p = 3*force/(2*pi*contact%axes)*(2*contact%curvature*contact%modulus/(3*force))**(2/3._dp)
  end function contact_pressure

  !> Rate of two contacts that carry the same force.
  elemental real(dp) function in_series(k_1, k_2) result(k)
    real(dp), intent(in) :: k_1, k_2  !< rates [N/m^1.5]
    k = (k_1**(-2/3._dp) + k_2**(-2/3._dp))**(-1.5_dp)
  end function in_series
end module hd_hertz
