! SPDX-License-Identifier: GPL-3.0-or-later
!> Contact of a rough half space by Persson's theory: true contact area and stiffness per area from the spectrum alone.
!>
!> Roughness up to wavenumber q alone would give the pressure a variance V(q) = (pi E*^2/2) int^q q^3 C dq, and contact on the share
!> A(q) = erf(P / sqrt(2 V)) of the area (Persson 2001). The elastic energy per area is U(P) = (pi E*/2) int q^2 C W(A(q)) dq, and
!> k_N = P / (dU/dP). W(A) = A in full contact and less below it. Persson (2008) and Wang and Mueser (2017) take W = A S(A) with
!> S(0) = 5/9, which leaves k_N a share of that of boundary elements, the smaller the less touches. Here
!>   W(A) = A (a A^e + (1 - a) A^2),
!> with a and e set once on generated surfaces and judged on others (bench/joint_law.py, docs/explain/joint.md).
!> Yield at the pressure H absorbs: A counts what is still elastic at q, so what has yielded stores no energy (Persson 2001).
module hd_persson
  use hd_gauss, only: gauss_3, weight_3
  use hd_kinds, only: dp, pi
  use hd_roughness_spectrum, only: power_spectrum_t
  implicit none
  private
  public :: contact_at

  real(dp), parameter :: rounding = 1e-18_dp !< what further terms of the series add is below rounding
  real(dp), parameter :: share_at_no_contact = 0.40_dp   !< a
  real(dp), parameter :: share_power = 0.12_dp           !< e
  real(dp), parameter :: stiffest = 1e-6_dp !< full contact: k_N <= P / (stiffest h_rms)
  real(dp), parameter :: narrow = 0.04_dp   !< V/H^2 below which the two boundaries do not see each other
  real(dp), parameter :: x(3) = 0.5_dp + 0.5_dp*gauss_3, weight(3) = weight_3/2   !< Gauss rule on [0, 1]
  integer, parameter :: most = 10           !< panels of the first band
  integer, parameter :: terms = 25          !< of the series above that: exp(-terms^2 pi^2 narrow/2) vanishes

contains

  !> W(A) and its derivative.
  elemental subroutine energy_share(area, w, slope)
    real(dp), intent(in) :: area    !< A, 0 to 1
    real(dp), intent(out) :: w      !< W
    real(dp), intent(out) :: slope  !< dW/dA
    associate (a => share_at_no_contact, e => share_power)
      w = a*area**(1 + e) + (1 - a)*area**3
      slope = a*(1 + e)*area**e + 3*(1 - a)*area**2
    end associate
  end subroutine energy_share

  !> Stiffness per area of full stick, and share of the area that touches, elastic or yielding.
  elemental subroutine contact_at(spectrum, modulus, hardness, pressure, k, area)
    type(power_spectrum_t), intent(in) :: spectrum   !< of the equivalent surface
    real(dp), intent(in) :: modulus            !< E* [Pa]
    real(dp), intent(in) :: hardness           !< H of the softer body [Pa]
    real(dp), intent(in) :: pressure           !< 0 < P < H [Pa]
    real(dp), intent(out) :: k                 !< k_N [Pa/m]
    real(dp), intent(out) :: area              !< share of the nominal area
    real(dp) :: variance, elastic, by_p, yielding, w, slope, by_energy, root(2), s
    integer :: i, j, panel, panels
    variance = 0
    by_energy = 0
    area = 1
    do i = 1, size(spectrum%q)
      root = sqrt([variance, variance + spectrum%slope(i)])
      variance = variance + spectrum%slope(i)
      if (.not. root(2) > root(1)) cycle
      panels = 1 + int(most*(1 - root(1)/root(2)))
      do panel = 0, panels*size(x) - 1  ! over sqrt(V), in which the integrand is smooth where V begins
        j = 1 + mod(panel, size(x))
        s = root(1) + (root(2) - root(1))*(panel/size(x) + x(j))/panels
        call touching((modulus*s/2)**2, hardness, pressure, elastic, by_p, yielding)
        call energy_share(elastic, w, slope)
        by_energy = by_energy + modulus/4*spectrum%mean(i)*slope*max(by_p, 0._dp)*weight(j)/panels*2*s/ &
          (root(1) + root(2))
      end do
    end do
    call touching(modulus**2/4*variance, hardness, pressure, elastic, by_p, yielding)
    area = min(elastic + yielding, 1._dp)
    k = pressure/max(by_energy, stiffest*sqrt(sum(spectrum%height)))
  end subroutine contact_at

  !> Shares of the area that touch: the pressure spreads by V from P, absorbed at 0 (parted) and at H (yielding).
  elemental subroutine touching(v, h, p, elastic, by_p, yielding)
    real(dp), intent(in) :: v         !< variance of the pressure [Pa^2]
    real(dp), intent(in) :: h, p      !< hardness and nominal pressure [Pa]
    real(dp), intent(out) :: elastic  !< share between the boundaries
    real(dp), intent(out) :: by_p     !< its derivative by the pressure [1/Pa]
    real(dp), intent(out) :: yielding !< share at the upper one
    real(dp) :: s, fall, sine
    integer :: n
    s = sqrt(2*max(v, tiny(v)))
    if (v < narrow*h**2) then
      yielding = erfc((h - p)/s)
      elastic = max(erf(p/s) - yielding, 0._dp)
      by_p = 2/(sqrt(pi)*s)*(exp(-(p/s)**2) - exp(-((h - p)/s)**2))
      return
    end if
    elastic = 0
    by_p = 0
    yielding = p/h
    do n = 1, terms
      fall = exp(-(n*pi/h)**2*v/2)
      if (fall < rounding) exit
      sine = 2/(n*pi)*sin(n*pi*p/h)*fall
      if (mod(n, 2) == 1) then
        elastic = elastic + 2*sine
        by_p = by_p + 4/h*cos(n*pi*p/h)*fall
        yielding = yielding - sine
      else
        yielding = yielding + sine
      end if
    end do
    elastic = max(elastic, 0._dp)
  end subroutine touching
end module hd_persson
