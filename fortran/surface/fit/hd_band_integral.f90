! SPDX-License-Identifier: GPL-3.0-or-later
!> Structure function of a band of the spectrum of Eq. 1, per G^(2(D-2)):
!> s(tau) = int_{f_lo}^{f_hi} f^(-a-1) (1 - c(2 pi f tau)) df, a = 6 - 2D, c = J0 on an isotropic surface, cos along a profile
!> (Eq. 2). With u = 2 pi f tau it is (2 pi tau)^a [F(u_hi) - F(u_lo)]; F comes from its series, from Gauss-Legendre panels, or
!> from its asymptotic tail, each where it holds 1e-12. Regular at D_s = D - 1 = 1.5, where the literature's constant is inf*0.
module hd_band_integral
  use hd_gauss, only: gauss_8, weight_8
  use hd_kinds, only: dp, pi
  implicit none
  private
  public :: band_integral, paper_constant, kind_isotropic, kind_profile

  integer, parameter :: kind_isotropic = 1   !< 1 - J0: mean over all directions of a surface (Eq. 1)
  integer, parameter :: kind_profile = 2     !< 1 - cos: one profile (Eq. 2)
  real(dp), parameter :: near = 8, far = 40   !< where the series still and the tail already holds 1e-12
  real(dp), parameter :: panel = 1.5_dp       !< longest panel of eight points in between: a quarter of a wave
  real(dp), parameter :: nothing = 1e-18_dp   !< term of the series over its sum that is below rounding

contains

  !> s(tau) per G^(2(D-2)) [m^a].
  elemental real(dp) function band_integral(kind, d, tau, f_lo, f_hi) result(s)
    integer, intent(in) :: kind           !< kind_isotropic or kind_profile
    real(dp), intent(in) :: d             !< fractal dimension D, 2 < D < 3
    real(dp), intent(in) :: tau           !< lag [m], > 0
    real(dp), intent(in) :: f_lo, f_hi    !< band [1/m]; f_hi may be infinite
    real(dp) :: a
    a = 6 - 2 * d
    s = (2 * pi * tau)**a * (partial(kind, a, 2 * pi * f_hi * tau) - partial(kind, a, 2 * pi * f_lo * tau))
  end function band_integral

  !> The literature's (Majumdar-Bhushan) constant in S = C G^(2(D-2)) tau^a, per its 1/ln gamma: Gamma(2 D_s - 3)
  !> sin((2 D_s - 3) pi / 2)/(4 - 2 D_s), written as pi/(2 Gamma(1 + a) sin(pi a/2)), which is regular at D_s = 1.5.
  elemental real(dp) function paper_constant(d, gamma_ratio) result(c)
    real(dp), intent(in) :: d             !< fractal dimension D
    real(dp), intent(in) :: gamma_ratio   !< frequency ratio
    real(dp) :: a
    a = 6 - 2 * d
    c = pi / (2 * gamma(1 + a) * sin(pi * a / 2)) / log(gamma_ratio)
  end function paper_constant

  !> F(x) = int_0^x u^(-a-1) (1 - c(u)) du.
  pure recursive real(dp) function partial(kind, a, x) result(f)
    integer, intent(in) :: kind     !< which c
    real(dp), intent(in) :: a, x    !< exponent, upper limit
    real(dp) :: h, b, whole
    integer :: i, j, panels
    if (x <= near) then
      f = series(kind, a, x)
    else if (x <= far) then
      panels = ceiling((x - near) / panel)
      h = (x - near) / panels
      f = series(kind, a, near)
      do i = 1, panels
        b = near + (i - 0.5_dp) * h
        do j = 1, 8
          f = f + 0.5_dp * h * weight_8(j) * integrand(kind, a, b + 0.5_dp * h * gauss_8(j))
        end do
      end do
    else
      if (kind == kind_isotropic) then
        whole = 2**(-a) * gamma(1 - a / 2) / (a * gamma(1 + a / 2))
      else
        whole = pi / (2 * gamma(1 + a) * sin(pi * a / 2))
      end if
      f = whole
      if (x <= huge(x)) f = whole - x**(-a) / a + tail(kind, a + 1, x)
    end if
  end function partial

  !> u^(-a-1) (1 - c(u)).
  pure real(dp) function integrand(kind, a, u) result(f)
    integer, intent(in) :: kind     !< which c
    real(dp), intent(in) :: a, u    !< exponent, argument
    if (kind == kind_isotropic) then
      f = u**(-a - 1) * (1 - bessel_j0(u))
    else
      f = u**(-a - 1) * (1 - cos(u))
    end if
  end function integrand

  !> Power series, term by term.
  pure real(dp) function series(kind, a, x) result(f)
    integer, intent(in) :: kind     !< which c
    real(dp), intent(in) :: a, x    !< exponent, upper limit
    real(dp) :: term
    integer :: k
    f = 0
    if (x <= 0) return
    term = -1
    do k = 1, 60
      if (kind == kind_isotropic) then
        term = -term * x * x / (4._dp * k * k)
      else
        term = -term * x * x / (2._dp * k * (2 * k - 1))
      end if
      f = f + term / (2 * k - a)
      if (abs(term) < nothing * abs(f)) exit
    end do
    f = f * x**(-a)
  end function series

  !> int_x^inf u^-p c(u) du by repeated integration by parts.
  pure real(dp) function tail(kind, p, x) result(t)
    integer, intent(in) :: kind     !< which c
    real(dp), intent(in) :: p, x    !< exponent, lower limit
    real(dp) :: factor, q, first, second
    integer :: i
    t = 0
    q = p
    factor = 1
    do i = 1, 12
      if (kind == kind_isotropic) then
        first = -x**(-q) * bessel_j1(x)
        second = (q + 1) * x**(-q - 1) * bessel_j0(x)
        t = t + factor * (first + second)
        factor = -factor * (q + 1)**2
      else
        first = -x**(-q) * sin(x)
        second = q * x**(-q - 1) * cos(x)
        t = t + factor * (first + second)
        factor = -factor * q * (q + 1)
      end if
      q = q + 2
    end do
  end function tail
end module hd_band_integral
