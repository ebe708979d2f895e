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
  real(dp), parameter :: far = 8            !< sqrt(2 V) to the upper boundary beyond which nothing yields, erfc(far) = 1e-29
  real(dp), parameter :: slope_of_erf = 2/sqrt(pi)  !< at 0
  integer, parameter :: share_of_thread = 8         !< pressures that it takes at a time
  real(dp), parameter :: clear = 6          !< standard deviations to the nearer boundary beyond which all touches elastically
  real(dp), parameter :: step = 0.2_dp      !< of ln V
  real(dp), parameter :: widest = exp(step) !< a band's upper end over its lower one that takes no more than one of them
  integer, parameter :: terms = 25          !< of the series: exp(-terms^2 pi^2 narrow/2) vanishes
  real(dp), parameter :: closed = 3         !< E* slopes of pressure under which no gap is left
  real(dp), parameter :: endless = 1e6_dp   !< E* that no pressure reaches: no yield
  real(dp), parameter :: fine = 0.05_dp     !< of ln P, of the table that the gap is summed on

contains

  !> Stiffness per area of full stick, share of the area that touches, elastic or yielding, and variance of the pressures.
  subroutine contact_at(spectrum, modulus, hardness, pressure, k, area, variance)
    type(power_spectrum_t), intent(in) :: spectrum   !< of the equivalent surface
    real(dp), intent(in) :: modulus            !< E* [Pa]
    real(dp), intent(in) :: hardness           !< H of the softer body [Pa]
    real(dp), intent(in) :: pressure(:)        !< 0 < P < H [Pa]
    real(dp), intent(out) :: k(:)              !< k_N [Pa/m]
    real(dp), intent(out) :: area(:)           !< share of the nominal area
    real(dp), intent(out) :: variance(:)       !< V_p [Pa^2]
    real(dp) :: full(size(spectrum%q)), energy(size(spectrum%q)), a, height, by_energy
    integer :: i
    height = sum(spectrum%height)
    a = share_at_no_contact(1) + share_at_no_contact(2)*(sum(spectrum%mean)**2/(height*sum(spectrum%slope)))**narrowness
    full = (modulus/2)**2*spectrum%slope
    energy = 0
    where (full > 0) energy = modulus/4*spectrum%mean/full
    !$omp parallel do schedule(dynamic, share_of_thread) private(by_energy)
    do i = 1, size(pressure)
      call spread(full, energy, a, hardness, pressure(i), by_energy, area(i), variance(i))
      k(i) = pressure(i)/max(by_energy, stiffest*sqrt(height))
    end do
    !$omp end parallel do
  end subroutine contact_at

  !> Energy, contact and variance under one pressure, band after band.
  pure subroutine spread(full, energy, a, hardness, pressure, by_energy, area, variance)
    real(dp), intent(in) :: full(:)            !< dV of full contact of each band [Pa^2]
    real(dp), intent(in) :: energy(:)          !< per dV [m/Pa^2]
    real(dp), intent(in) :: a                  !< share at no contact
    real(dp), intent(in) :: hardness, pressure !< H, 0 < P < H [Pa]
    real(dp), intent(out) :: by_energy         !< dU/dP [m]
    real(dp), intent(out) :: area              !< share of the nominal area that touches
    real(dp), intent(out) :: variance          !< V_p [Pa^2]
    real(dp) :: by_p, first, from, to, ratio, lower, middle, upper, half, half_by_p, share(2), share_by_p(2), power, power_by_p
    complex(dp) :: turn
    integer :: i, j, n
    turn = cmplx(cos(pi*pressure/hardness), sin(pi*pressure/hardness), dp)
    first = (min(pressure, hardness - pressure)/clear)**2
    variance = 0
    by_p = 0
    by_energy = 0
    to = 0
    do i = 1, size(full)
      from = to
      to = from + full(i)
      if (.not. to > first) variance = to
      if (.not. to > max(from, first)) cycle
      if (from < first) variance = first
      from = max(from, first)
      n = 1
      if (to > widest*from) n = ceiling(log(to/from)/step)
      ratio = sqrt(to/from)
      if (n > 1) ratio = ratio**(1/real(n, dp))
      upper = from
      do j = 1, n  ! midpoint rule in ln V
        lower = upper
        middle = lower*ratio
        upper = merge(to, middle*ratio, j == n)
        call touching(variance, by_p, hardness, pressure, turn, share, share_by_p)
        call spreading(share, share_by_p, power, power_by_p)
        half = variance + (middle - lower)*power
        half_by_p = by_p + (middle - lower)*power_by_p
        call touching(half, half_by_p, hardness, pressure, turn, share, share_by_p)
        call spreading(share, share_by_p, power, power_by_p)
        variance = variance + (upper - lower)*power
        by_p = by_p + (upper - lower)*power_by_p
        by_energy = by_energy + energy(i)*energy_slope(a, share(1))*max(share_by_p(1), 0._dp)*(upper - lower)
      end do
    end do
    call touching(variance, by_p, hardness, pressure, turn, share, share_by_p)
    area = min(sum(share), 1._dp)
  end subroutine spread

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
  pure subroutine touching(v, v_by_p, h, p, turn, share, share_by_p)
    real(dp), intent(in) :: v              !< V_p > 0 [Pa^2]
    real(dp), intent(in) :: v_by_p         !< dV_p/dP [Pa]
    real(dp), intent(in) :: h, p           !< hardness and nominal pressure [Pa]
    complex(dp), intent(in) :: turn        !< exp(i pi p/h)
    real(dp), intent(out) :: share(2)      !< between the boundaries, at the upper one
    real(dp), intent(out) :: share_by_p(2) !< with V_p [1/Pa]
    real(dp) :: s, below, above, image, density(2), fall, ratio, square, wave
    real(dp) :: sums(4)  ! of even and odd n, then their derivatives times h
    complex(dp) :: turned  ! cos + i sin of n times the phase of one wave
    integer :: i, n
    if (v < narrow*h**2) then
      s = 1/sqrt(2*max(v, tiny(v)))
      below = p*s
      above = (h - p)*s
      share = [erf(below), 0._dp]
      density = [slope_of_erf*s*exp(-below**2)*(1 - below*v_by_p*s), 0._dp]
      if (above < far) then
        image = (h + p)*s  ! what parts before it yields comes back from -p
        share(2) = erfc(above) - erfc(image)
        density(2) = slope_of_erf*s*(exp(-above**2)*(1 + above*v_by_p*s) + exp(-image**2)*(1 - image*v_by_p*s))
        share(1) = max(share(1) - share(2), 0._dp)
      end if
      share_by_p = [density(1) - density(2), density(2)]
      return
    end if
    wave = pi/h
    turned = 1
    ratio = exp(-wave**2*v/2)  ! of falls, exp(-(n pi/h)^2 v/2), from n = 0 to 1; then it falls by its square
    square = ratio**2
    fall = 1
    sums = 0
    do n = 1, terms
      fall = fall*ratio
      if (fall < rounding) exit
      ratio = ratio*square
      turned = turned*turn
      i = 1 + mod(n, 2)
      sums(i) = sums(i) + turned%im*fall/n
      sums(i + 2) = sums(i + 2) + (2*turned%re - n*wave*v_by_p*turned%im)*fall
    end do
    share = [max(4/pi*sums(2), 0._dp), p/h + 2/pi*(sums(1) - sums(2))]
    share_by_p = [2*sums(4), 1 + sums(3) - sums(4)]/h
  end subroutine touching
end module hd_persson
