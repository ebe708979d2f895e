! SPDX-License-Identifier: GPL-3.0-or-later
!> One asperity: elastic, elastoplastic (Kogut and Etsion 2002) and plastic contact of a cosine peak (Eq. 3-16, 36-40).
!>
!> In each regime i the load and the stiffnesses are powers of sigma = s / s_ec:
!>   f = f_ec load(i) sigma^load_power(i),   k = (f_ec / eps_ec) stiff(i) sigma^stiff_power(i).
!> The exponents are the exact quotients behind the printed, rounded ones. Regimes change at the areas edge(i) s_ec and
!> jump there (load +12.8 %, -1.5 %, +1.1 %): load is not monotone in area, so it is never inverted across regimes.
module hd_asperity
  use hd_kinds, only: dp, pi
  implicit none
  private
  public :: asperity_t, new_asperity, asperity_by_area, asperity_by_depth
  public :: fully_plastic
  public :: load, load_power, stiff, stiff_power, edge

  integer, parameter :: fully_plastic = 4   !< last regime of a spot: 1 is elastic, 2 and 3 are elastoplastic
  real(dp), parameter :: load_power(4) = [1.5_dp, 1.425_dp/1.136_dp, 1.263_dp/1.146_dp, 1._dp]
  real(dp), parameter :: stiff_power(4) = [0.5_dp, 0.425_dp/1.136_dp, 0.263_dp/1.146_dp, 0._dp]
  !> Upper edges of the first three regimes in units of s_ec (Eq. 13, 14).
  real(dp), parameter :: edge(3) = [1._dp, 0.93_dp*6._dp**1.136_dp, 0.94_dp*110._dp**1.146_dp]
  real(dp), parameter :: stiff(4) = [1.5_dp, 1.03_dp*1.425_dp/0.93_dp**stiff_power(2), &
    1.40_dp*1.263_dp/0.94_dp**stiff_power(3), 0._dp]
  !> The fourth factor depends on hardness: f = H s, so load(4) = H s_ec / f_ec = 3 / (2 k).
  real(dp), parameter :: load(3) = [1._dp, 1.03_dp/0.93_dp**load_power(2), 1.40_dp/0.94_dp**load_power(3)]

  !> The branches over depth: s = area_factor s_ec x^area_power, f = load_factor f_ec x^depth_power, x = eps / eps_ec.
  real(dp), parameter :: area_factor(3) = [1._dp, 0.93_dp, 0.94_dp], area_power(4) = [1._dp, 1.136_dp, 1.146_dp, 1._dp]
  real(dp), parameter :: load_factor(3) = [1._dp, 1.03_dp, 1.40_dp], depth_power(4) = [1.5_dp, 1.425_dp, 1.263_dp, 1._dp]

  type :: asperity_t
    real(dp) :: e_star = 0      !< reduced modulus E [Pa]
    real(dp) :: g_prime = 0     !< reduced shear modulus G' of Eq. 38, 1/G' = sum (2 - nu)/G [Pa]
    real(dp) :: hardness = 0    !< H [Pa]
    real(dp) :: hardness_factor = 0  !< k = 0.454 + 0.41 nu of the softer body
    real(dp) :: amplitude = 0   !< eta, amplitude of the cosine (Eq. 4) [m]
    real(dp) :: radius = 0      !< R of the peak (Eq. 5) [m]
    real(dp) :: eps_ec = 0      !< depth at first yield (Eq. 7) [m]
    real(dp) :: s_ec = 0        !< area at first yield (Eq. 8) [m^2]
    real(dp) :: f_ec = 0        !< load at first yield, (2/3) k H s_ec (Eq. 10) [N]
  end type asperity_t

contains

  !> Asperity of half base length r_m on a surface of dimension d and roughness g [Eq. 3-5, 7, 8, 10, 38].
  pure function new_asperity(e1, nu1, e2, nu2, nu_soft, hardness, d, g, gamma, r_m) result(a)
    real(dp), intent(in) :: e1, nu1, e2, nu2  !< moduli [Pa] and Poisson's ratios of both bodies
    real(dp), intent(in) :: nu_soft           !< Poisson's ratio of the softer body
    real(dp), intent(in) :: hardness          !< H [Pa]
    real(dp), intent(in) :: d, g, gamma       !< fractal dimension, roughness [m], frequency ratio
    real(dp), intent(in) :: r_m               !< half base length [m]
    type(asperity_t) :: a
    a%e_star = 1/((1 - nu1**2)/e1 + (1 - nu2**2)/e2)
    a%g_prime = 1/((2 - nu1)*2*(1 + nu1)/e1 + (2 - nu2)*2*(1 + nu2)/e2)
    a%hardness = hardness
    a%hardness_factor = 0.454_dp + 0.41_dp*nu_soft
    a%amplitude = 2**(3 - d)*g**(d - 2)*sqrt(log(gamma))*r_m**(3 - d)
    a%radius = r_m**2/(pi**2*a%amplitude)
    a%eps_ec = (pi*a%hardness_factor*hardness/(2*a%e_star))**2*a%radius
    a%s_ec = pi*a%radius*a%eps_ec
    a%f_ec = 2*a%hardness_factor*hardness*a%s_ec/3
  end function new_asperity

  !> Regime of a spot: 1 elastic, 2 and 3 elastoplastic, 4 plastic.
  elemental integer function regime_of_area(a, s) result(i)
    type(asperity_t), intent(in) :: a  !< asperity
    real(dp), intent(in) :: s          !< area of the spot [m^2]
    i = 1 + count(s > edge*a%s_ec)
  end function regime_of_area

  !> Load and stiffnesses of a spot of area s under the shear stress tau [Eq. 9, 13-16, 29, 31, 32, 36, 37, 39, 40].
  elemental subroutine asperity_by_area(a, s, tau, mu, f, k, kt)
    type(asperity_t), intent(in) :: a      !< asperity
    real(dp), intent(in) :: s              !< area [m^2]
    real(dp), intent(in) :: tau            !< shear stress [Pa]
    real(dp), intent(in) :: mu             !< friction coefficient
    real(dp), intent(out) :: f, k, kt      !< load [N], normal and tangential stiffness [N/m]
    integer :: i
    real(dp) :: stuck
    i = regime_of_area(a, s)
    f = a%hardness*s
    if (i < fully_plastic) f = a%f_ec*load(i)*(s/a%s_ec)**load_power(i)
    k = a%f_ec/a%eps_ec*stiff(i)*(s/a%s_ec)**stiff_power(i)
    stuck = mu*f - tau*s
    kt = 0
    if (i < fully_plastic .and. stuck > 0) kt = 8*a%g_prime*sqrt(s/pi)*(stuck/(mu*f))**(1/3._dp)
  end subroutine asperity_by_area

  !> Area, load and stiffness at a depth eps [Eq. 6, 11, 12, 15]; branches are closed on the left at eps / eps_ec = 1, 6, 110, and
  !> jump there.
  elemental subroutine asperity_by_depth(a, eps, s, f, k)
    type(asperity_t), intent(in) :: a   !< asperity
    real(dp), intent(in) :: eps         !< depth [m]
    real(dp), intent(out) :: s, f, k    !< area [m^2], load [N], stiffness [N/m]
    real(dp), parameter :: jump(3) = [1._dp, 6._dp, 110._dp]
    real(dp) :: x
    integer :: i
    x = eps/a%eps_ec
    i = 1 + count(x >= jump)
    k = 0
    if (i < fully_plastic) then
      s = area_factor(i)*a%s_ec*x**area_power(i)
      f = load_factor(i)*a%f_ec*x**depth_power(i)
      if (eps > 0) k = f/eps*depth_power(i)
    else
      s = 2*a%s_ec*x
      f = a%hardness*s
    end if
  end subroutine asperity_by_depth
end module hd_asperity
