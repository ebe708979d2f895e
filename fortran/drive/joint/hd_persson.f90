! SPDX-License-Identifier: GPL-3.0-or-later
!> Contact of a rough half space by Persson's theory: true contact, pressures, stiffness and mean gap from the spectrum alone.
!>
!> Roughness up to wavenumber q spreads the pressure with a variance V_p(q) about P. In full contact dV = (pi E*^2/2) q^3 C dq;
!> where a share A touches, dV_p = S(A) dV, S = 5/9 - 2/9 A^2 + 6/9 A^4 (Wang and Mueser 2017). Then A(q) = erf(P/sqrt(2 V_p)), and
!> the density of the pressures is that of a Gauss curve about P less its image about -P (Persson 2001).
!> The elastic energy per area is U(P) = (pi E*/2) int q^2 C W(A(q)) dq, and k_N = P / (dU/dP). Here
!>   W(A) = A (a A^e + (1 - a) A^m),  a = a_0 + a_1 r^n,
!> where r = m_1^2/(m_0 m_2), of the moments m_k = int q^k (2 pi q C) dq, is 1 for a spectrum of one wavelength and falls with its
!> width. The constants were set once on generated surfaces and judged on others (bench/joint_law.py, docs/explain/joint.md).
!> Yield at the pressure H absorbs: what has yielded stores no energy (Persson 2001).
module hd_persson
  use hd_error, only: error_t
  use hd_kinds, only: dp, pi
  use hd_roughness_spectrum, only: power_spectrum_t
  use hd_stiffness_curve, only: compliance_curve_t, new_curve, closure_of
  implicit none
  private
  public :: contact_at, mean_gap_at

  real(dp), parameter :: rounding = 1e-18_dp !< what further terms of the series add is below rounding
  real(dp), parameter :: share_at_no_contact(2) = [0.35_dp, 0.15_dp]  !< a_0, a_1
  real(dp), parameter :: narrowness = 9      !< n
  real(dp), parameter :: share_power = 0.17_dp   !< e
  real(dp), parameter :: rise = 3.15_dp          !< m
  real(dp), parameter :: stiffest = 1e-6_dp !< full contact: k_N <= P / (stiffest h_rms)
  real(dp), parameter :: narrow = 0.04_dp   !< V/H^2 below which the two boundaries do not see each other
  real(dp), parameter :: clear = 6          !< standard deviations to the nearer boundary beyond which all touches elastically
  real(dp), parameter :: step = 0.2_dp      !< of ln V
  integer, parameter :: terms = 25          !< of the series: exp(-terms^2 pi^2 narrow/2) vanishes
  real(dp), parameter :: closed = 3         !< E* slopes of pressure under which no gap is left
  real(dp), parameter :: endless = 1e6_dp   !< E* that no pressure reaches: no yield
  real(dp), parameter :: fine = 0.05_dp     !< of ln P, of the table that the gap is summed on

contains

  !> Stiffness per area of full stick, share of the area that touches, elastic or yielding, and variance of the pressures.
  elemental subroutine contact_at(spectrum, modulus, hardness, pressure, k, area, variance)
    type(power_spectrum_t), intent(in) :: spectrum   !< of the equivalent surface
    real(dp), intent(in) :: modulus            !< E* [Pa]
    real(dp), intent(in) :: hardness           !< H of the softer body [Pa]
    real(dp), intent(in) :: pressure           !< 0 < P < H [Pa]
    real(dp), intent(out) :: k                 !< k_N [Pa/m]
    real(dp), intent(out) :: area              !< share of the nominal area
    real(dp), intent(out) :: variance          !< V_p [Pa^2]
    real(dp) :: a, by_energy, by_p, from, to, middle, half, half_by_p, share(2), share_by_p(2), power, power_by_p
    integer :: i, j, n
    associate (m => [sum(spectrum%height), sum(spectrum%mean), sum(spectrum%slope)])
      a = share_at_no_contact(1) + share_at_no_contact(2)*(m(2)**2/(m(1)*m(3)))**narrowness
    end associate
    variance = 0
    by_p = 0
    by_energy = 0
    to = 0
    associate (full => (modulus/2)**2*spectrum%slope, first => (min(pressure, hardness - pressure)/clear)**2)
      do i = 1, size(spectrum%q)
        from = to
        to = from + full(i)
        if (.not. to > first) variance = to
        if (.not. to > max(from, first)) cycle
        if (from < first) variance = first
        from = max(from, first)
        n = ceiling(log(to/from)/step)
        do j = 1, n  ! midpoint rule in ln V
          middle = from*(to/from)**((j - 0.5_dp)/n)
          associate (lower => from*(to/from)**(real(j - 1, dp)/n), upper => from*(to/from)**(real(j, dp)/n))
            call touching(variance, by_p, hardness, pressure, share, share_by_p)
            call spreading(share, share_by_p, power, power_by_p)
            half = variance + (middle - lower)*power
            half_by_p = by_p + (middle - lower)*power_by_p
            call touching(half, half_by_p, hardness, pressure, share, share_by_p)
            call spreading(share, share_by_p, power, power_by_p)
            variance = variance + (upper - lower)*power
            by_p = by_p + (upper - lower)*power_by_p
            by_energy = by_energy + modulus/4*spectrum%mean(i)*energy_slope(a, share(1))*max(share_by_p(1), 0._dp)* &
              (upper - lower)/full(i)
          end associate
        end do
      end do
    end associate
    call touching(variance, by_p, hardness, pressure, share, share_by_p)
    area = min(sum(share), 1._dp)
    k = pressure/max(by_energy, stiffest*sqrt(sum(spectrum%height)))
  end subroutine contact_at

  !> Mean gap of the elastic contact, int dP/k_N from each pressure to full contact [m].
  subroutine mean_gap_at(spectrum, modulus, pressure, gap, error)
    type(power_spectrum_t), intent(in) :: spectrum    !< of the equivalent surface
    real(dp), intent(in) :: modulus                   !< E* [Pa]
    real(dp), intent(in) :: pressure(:)               !< > 0 [Pa]
    real(dp), intent(out) :: gap(:)                   !< [m]
    type(error_t), allocatable, intent(out) :: error  !< of the table
    type(compliance_curve_t) :: curve
    real(dp), allocatable :: p(:), k(:), area(:), variance(:)
    real(dp) :: low, last
    integer :: i, n
    last = closed*modulus*sqrt(sum(spectrum%slope))
    low = min(minval(pressure), last/closed)
    n = ceiling(log(last/low)/fine)
    p = [(low*(last/low)**(real(i, dp)/n), i=0, n)]
    allocate (k(n + 1), area(n + 1), variance(n + 1))
    call contact_at(spectrum, modulus, endless*modulus, p, k, area, variance)
    call new_curve(p, k, curve, error)
    if (.not. allocated(error)) gap = max(closure_of(curve, last) - closure_of(curve, pressure), 0._dp)
  end subroutine mean_gap_at

  !> dW/dA.
  elemental real(dp) function energy_slope(a, area) result(slope)
    real(dp), intent(in) :: a     !< share at no contact
    real(dp), intent(in) :: area  !< A, 0 to 1
    slope = a*(1 + share_power)*area**share_power + (1 - a)*(1 + rise)*area**rise
  end function energy_slope

  !> S of the area that touches, elastic or yielding, and its derivative by the pressure.
  pure subroutine spreading(share, share_by_p, power, power_by_p)
    real(dp), intent(in) :: share(2), share_by_p(2)     !< elastic and yielding, dA/dP [1/Pa]
    real(dp), intent(out) :: power, power_by_p          !< S, dS/dP [1/Pa]
    real(dp) :: area
    area = min(sum(share), 1._dp)
    power = (5 - 2*area**2 + 6*area**4)/9
    power_by_p = (24*area**3 - 4*area)/9*sum(share_by_p)
  end subroutine spreading

  !> Shares of the area that touch, elastic and yielding: the pressure spreads by V_p from P, absorbed at 0 (parted) and at H.
  pure subroutine touching(v, v_by_p, h, p, share, share_by_p)
    real(dp), intent(in) :: v              !< V_p > 0 [Pa^2]
    real(dp), intent(in) :: v_by_p         !< dV_p/dP [Pa]
    real(dp), intent(in) :: h, p           !< hardness and nominal pressure [Pa]
    real(dp), intent(out) :: share(2)      !< between the boundaries, at the upper one
    real(dp), intent(out) :: share_by_p(2) !< with V_p [1/Pa]
    real(dp) :: s, density(2), wave, term, term_by_p, fall, ratio
    complex(dp) :: turn, turned  ! cos + i sin of one wave's phase, and of n
    integer :: n
    if (v < narrow*h**2) then
      s = sqrt(2*max(v, tiny(v)))
      density = 2/(sqrt(pi)*s)*exp(-([p, h - p]/s)**2)*[1 - p*v_by_p/s**2, 1 + (h - p)*v_by_p/s**2]
      share(2) = erfc((h - p)/s)
      share(1) = max(erf(p/s) - share(2), 0._dp)
      share_by_p = [density(1) - density(2), density(2)]
      return
    end if
    share = [0._dp, p/h]
    share_by_p = [0._dp, 1/h]
    turn = cmplx(cos(pi*p/h), sin(pi*p/h), dp)
    turned = 1
    ratio = exp(-(pi/h)**2*v/2)  ! of falls, exp(-(n pi/h)^2 v/2), from 0 to 1; then it falls by its square
    fall = 1
    do n = 1, terms
      fall = fall*ratio**(2*n - 1)
      if (fall < rounding) exit
      turned = turned*turn
      wave = n*pi/h
      term = 2/(n*pi)*turned%im*fall
      term_by_p = 2/h*turned%re*fall - term*wave**2*v_by_p/2
      if (mod(n, 2) == 1) then
        share = share + [2*term, -term]
        share_by_p = share_by_p + [2*term_by_p, -term_by_p]
      else
        share(2) = share(2) + term
        share_by_p(2) = share_by_p(2) + term_by_p
      end if
    end do
    share(1) = max(share(1), 0._dp)
  end subroutine touching
end module hd_persson
