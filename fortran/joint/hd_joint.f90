! SPDX-License-Identifier: GPL-3.0-or-later
!> The joint of two rough surfaces: size distribution of the contact spots and its integrals (Eq. 17-44).
!>
!> n(s) = (D-1)/2 psi^((3-D)/2) s_l^((D-1)/2) s^(-(D+1)/2) on (s_min, s_l]. Every integral over a regime runs between its
!> edges clipped to [s_min, s_l]; unclipped, the printed differences give negative loads. Eq. 30 diverges for s -> 0, so
!> s_min is an input. Areas are handled as sigma = s / s_ec.
module hd_joint
  use hd_kinds, only: dp, pi
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  use hd_asperity, only: asperity_t, new_asperity, load, load_power, stiff, stiff_power, edge
  implicit none
  private
  public :: joint_t, new_joint, spot_ratio, largest_spot, largest_spot_paper, joint_load, normal_stiffness, &
    tangential_stiffness, real_area, evaluate_joint

  integer, parameter :: points = 24   !< of the Gauss rule

  type :: joint_t
    type(asperity_t) :: asperity
    real(dp) :: d = 0            !< fractal dimension D
    real(dp) :: mu = 0           !< friction coefficient
    real(dp) :: s_min = 0        !< smallest spot [m^2]
    real(dp) :: reference_area = 0  !< A_0 = L^2 [m^2]
    real(dp) :: r_m = 0          !< half base length of the asperities [m]
    logical :: paper = .false.   !< closure of Eq. 28 as printed
    real(dp) :: psi = 0          !< domain extension factor (Eq. 17)
    real(dp) :: area_factor = 0  !< c_S = S_r / s_l (Eq. 22)
    real(dp) :: plastic_load = 0 !< load factor of the plastic regime, H s_ec / f_ec
    real(dp) :: x(points) = 0, w(points) = 0  !< Gauss-Legendre rule on [0, 1]
  end type joint_t

contains

  !> Joint from its asperity and its surface.
  subroutine new_joint(asperity, d, mu, s_min, reference_area, r_m, paper, joint, error)
    type(asperity_t), intent(in) :: asperity          !< asperity
    real(dp), intent(in) :: d                         !< fractal dimension, 2 < D < 3
    real(dp), intent(in) :: mu                        !< friction coefficient
    real(dp), intent(in) :: s_min                     !< smallest spot, > 0 [m^2]
    real(dp), intent(in) :: reference_area            !< A_0 [m^2]
    real(dp), intent(in) :: r_m                       !< half base length [m]
    logical, intent(in) :: paper                      !< closure of Eq. 28
    type(joint_t), intent(out) :: joint               !< joint
    type(error_t), allocatable, intent(out) :: error  !< input out of range
    if (.not. (d > 2 .and. d < 3)) then
      call raise(error, code_input, 'fractal_dimension is '//to_text(d)//'; valid: 2 < D < 3')
    else if (.not. s_min > 0) then
      call raise(error, code_input, 's_min is '//to_text(s_min)//' m^2; valid: > 0 (Eq. 30 diverges at 0)')
    else if (.not. (asperity%s_ec > 0 .and. asperity%s_ec < huge(1._dp))) then
      call raise(error, code_input, 'the area at first yield is '//to_text(asperity%s_ec)// &
        ' m^2: check roughness, asperity_radius, gamma and hardness')
    else if (.not. mu >= 0) then
      call raise(error, code_input, 'friction is '//to_text(mu)//'; valid: >= 0')
    end if
    if (allocated(error)) return
    joint%asperity = asperity
    joint%d = d
    joint%mu = mu
    joint%s_min = s_min
    joint%reference_area = reference_area
    joint%r_m = r_m
    joint%paper = paper
    joint%psi = spot_ratio(d)
    joint%area_factor = (d - 1)/(3 - d)*joint%psi**((3 - d)/2)
    joint%plastic_load = asperity%hardness*asperity%s_ec/asperity%f_ec
    call gauss_rule(joint%x, joint%w)
  end subroutine new_joint

  !> psi of Eq. 17 from its transcendental equation (Wang and Komvopoulos 1994), regular at D = 3.
  elemental real(dp) function spot_ratio(d) result(psi)
    real(dp), intent(in) :: d  !< fractal dimension
    real(dp) :: ds, h, a, b, x, r, slope, step
    integer :: i
    ds = d - 1
    h = 2 - ds
    x = log(2._dp)
    a = log(1.7_dp)
    b = log(2.7_dp)
    do i = 1, 60
      r = expm1_over(h/2*x, h/ds) - expm1_over(-(h/ds)*log1p_exp(-ds/2*x), h/ds) - 1
      if (r > 0) b = x
      if (r <= 0) a = x
      slope = ds/2*exp(h/2*x) - exp(-(h/ds)*log1p_exp(-ds/2*x))*ds/2/(1 + exp(ds/2*x))
      step = -r/slope
      if (x + step <= a .or. x + step >= b) step = 0.5_dp*(a + b) - x
      x = x + step
      if (abs(step) < 1e-16_dp) exit
    end do
    psi = exp(x)
  end function spot_ratio

  !> (exp(x) - 1) / y, accurate for small x.
  elemental real(dp) function expm1_over(x, y) result(f)
    real(dp), intent(in) :: x, y
    f = expm1(x)/y
  end function expm1_over

  !> exp(x) - 1 without cancellation (Kahan).
  elemental real(dp) function expm1(x)
    real(dp), intent(in) :: x
    real(dp) :: u
    u = exp(x)
    if (abs(u - 1) <= 0) then
      expm1 = x
    else if (u - 1 <= -1) then
      expm1 = -1
    else if (abs(x) < 1) then
      expm1 = (u - 1)*x/log(u)
    else
      expm1 = u - 1
    end if
  end function expm1

  !> log(1 + exp(x)).
  elemental real(dp) function log1p_exp(x)
    real(dp), intent(in) :: x
    log1p_exp = log(1 + exp(x))
  end function log1p_exp

  !> int_lo^hi sigma^(e-1) dsigma, regular at e = 0; empty intervals give 0.
  elemental real(dp) function power_integral(lo, hi, e) result(f)
    real(dp), intent(in) :: lo, hi, e
    real(dp) :: l
    f = 0
    if (hi <= lo) return
    l = log(hi/lo)
    f = l
    if (abs(e*l) > 1e-300_dp) f = expm1(e*l)/e
    f = f*lo**e
  end function power_integral

  !> Clipped limits of regime i in units of s_ec.
  elemental subroutine limits(joint, sigma_l, i, lo, hi)
    type(joint_t), intent(in) :: joint
    real(dp), intent(in) :: sigma_l
    integer, intent(in) :: i
    real(dp), intent(out) :: lo, hi
    lo = joint%s_min/joint%asperity%s_ec
    if (i > 1) lo = max(lo, edge(i - 1))
    hi = sigma_l
    if (i < 4) hi = min(hi, edge(i))
  end subroutine limits

  !> Common factor of the integrals: (D-1)/2 psi^((3-D)/2) sigma_l^((D-1)/2).
  elemental real(dp) function prefactor(joint, sigma_l) result(f)
    type(joint_t), intent(in) :: joint
    real(dp), intent(in) :: sigma_l
    f = (joint%d - 1)/2*joint%psi**((3 - joint%d)/2)*sigma_l**((joint%d - 1)/2)
  end function prefactor

  !> Real contact area c_S s_l (Eq. 22) [m^2].
  elemental real(dp) function real_area(joint, s_l)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), intent(in) :: s_l         !< largest spot [m^2]
    real_area = joint%area_factor*s_l
  end function real_area

  !> Load carried by the spots of each regime (Eq. 23-27) [N].
  pure function joint_load(joint, s_l) result(f)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), intent(in) :: s_l         !< largest spot [m^2]
    real(dp) :: f(4), sigma_l, lo, hi
    integer :: i
    sigma_l = s_l/joint%asperity%s_ec
    do i = 1, 4
      call limits(joint, sigma_l, i, lo, hi)
      f(i) = power_integral(lo, hi, load_power(i) - (joint%d - 1)/2)
    end do
    f = f*[load, joint%plastic_load]
    f = f*prefactor(joint, sigma_l)*joint%asperity%f_ec
  end function joint_load

  !> Normal stiffness of each regime (Eq. 29-35, clipped) [N/m].
  pure function normal_stiffness(joint, s_l) result(k)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), intent(in) :: s_l         !< largest spot [m^2]
    real(dp) :: k(4), sigma_l, lo, hi
    integer :: i
    sigma_l = s_l/joint%asperity%s_ec
    k = 0
    do i = 1, 3
      call limits(joint, sigma_l, i, lo, hi)
      k(i) = stiff(i)*power_integral(lo, hi, stiff_power(i) - (joint%d - 1)/2)
    end do
    k = k*prefactor(joint, sigma_l)*joint%asperity%f_ec/joint%asperity%eps_ec
  end function normal_stiffness

  !> Tangential stiffness of each regime under the shear stress tau on the spots (Eq. 36-44) [N/m].
  !>
  !> A spot carries t = tau s; with x = t / (mu f) = h sigma^-p its stiffness is 8 G' sqrt(s/pi) (1 - x)^(1/3), zero for
  !> x >= 1: the small spots of a regime slip first.
  pure function tangential_stiffness(joint, s_l, tau) result(k)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), intent(in) :: s_l         !< largest spot [m^2]
    real(dp), intent(in) :: tau         !< shear stress on the spots, Q / S_r [Pa]
    real(dp) :: k(4), sigma_l, lo, hi, h, p
    integer :: i
    sigma_l = s_l/joint%asperity%s_ec
    k = 0
    do i = 1, 3
      call limits(joint, sigma_l, i, lo, hi)
      if (hi <= lo) cycle
      p = load_power(i) - 1
      h = 0
      if (tau > 0) h = tau*joint%asperity%s_ec/(joint%mu*joint%asperity%f_ec*load(i))
      if (h > 0) lo = max(lo, h**(1/p))
      k(i) = slip_integral(joint, lo, hi, h, p)
    end do
    k = k*prefactor(joint, sigma_l)*8*joint%asperity%g_prime*sqrt(joint%asperity%s_ec/pi)
  end function tangential_stiffness

  !> int_lo^hi sigma^(-D/2) (1 - h sigma^-p)^(1/3) dsigma.
  !>
  !> Where x = h sigma^-p < 1/2: the binomial series, integrated term by term (2^-n fast, no special case at D = 2).
  !> Above: v = (1 - x)^(1/3) removes the cusp at the slip edge and a Gauss rule is exact to rounding.
  pure real(dp) function slip_integral(joint, lo, hi, h, p) result(f)
    type(joint_t), intent(in) :: joint
    real(dp), intent(in) :: lo, hi, h, p
    real(dp) :: middle, c, e, v1, v2, v, x, sigma
    integer :: n
    f = 0
    if (hi <= lo) return
    e = 1 - joint%d/2
    middle = lo
    if (h > 0) middle = max(lo, min(hi, (2*h)**(1/p)))
    if (hi > middle) then
      c = 1
      do n = 0, 60
        f = f + c*power_integral(middle, hi, e - p*n)
        if (h <= 0) exit
        c = c*(n - 1/3._dp)/(n + 1)*h
        if (abs(c)*middle**(-p*(n + 1)) < 1e-17_dp) exit
      end do
    end if
    if (middle <= lo) return
    v1 = max(0._dp, 1 - h*lo**(-p))**(1/3._dp)
    v2 = max(0._dp, 1 - h*middle**(-p))**(1/3._dp)
    do n = 1, points
      v = v1 + (v2 - v1)*joint%x(n)
      x = 1 - v**3
      sigma = (h/x)**(1/p)
      f = f + (v2 - v1)*joint%w(n)*sigma**e*3*v**3/(p*x)
    end do
  end function slip_integral

  !> Largest spot under the nominal pressure P: F_r(s_l) = P A_0, by Newton's method in logarithms inside a bracket.
  elemental real(dp) function largest_spot(joint, pressure) result(s_l)
    type(joint_t), intent(in) :: joint     !< joint
    real(dp), intent(in) :: pressure       !< P [Pa]
    real(dp) :: target, x, a, b, f, slope, step, s
    integer :: i
    s_l = 0
    if (.not. pressure > 0) return
    target = pressure*joint%reference_area
    a = log(joint%s_min)
    x = max(log(target/(joint%asperity%hardness*joint%area_factor)), a + 0.5_dp)
    b = huge(b)
    do i = 1, 200
      s = exp(x)
      f = sum(joint_load(joint, s))
      if (f > target) b = x
      if (f <= target) a = x
      slope = (joint%d - 1)/2 + end_load(joint, s)/f
      step = log(target/f)/slope
      if (x + step <= a) step = 0.5_dp*(a - x)
      if (x + step >= b) step = 0.5_dp*(b - x)
      x = x + step
      if (abs(step) < 4e-16_dp*max(1._dp, abs(x))) exit
    end do
    s_l = exp(x)
  end function largest_spot

  !> f(s_l) n(s_l) s_l, the end term of d ln F_r / d ln s_l times F_r [N].
  elemental real(dp) function end_load(joint, s_l) result(f)
    type(joint_t), intent(in) :: joint
    real(dp), intent(in) :: s_l
    real(dp) :: sigma
    integer :: i
    sigma = s_l/joint%asperity%s_ec
    i = 1 + count(sigma > edge)
    f = joint%plastic_load*sigma
    if (i < 4) f = load(i)*sigma**load_power(i)
    f = f*joint%asperity%f_ec*prefactor(joint, sigma)*sigma**(-(joint%d - 1)/2)
  end function end_load

  !> Largest spot by Eq. 28 as printed, P = F_r / S_r, by bisection; 0 if P is not below 0.99 H.
  elemental real(dp) function largest_spot_paper(joint, pressure) result(s_l)
    type(joint_t), intent(in) :: joint     !< joint
    real(dp), intent(in) :: pressure       !< mean pressure of the real contact [Pa]
    real(dp) :: a, b, x
    integer :: i
    s_l = 0
    if (.not. pressure > 0 .or. pressure >= 0.99_dp*joint%asperity%hardness) return
    a = log(joint%s_min)
    b = log(joint%asperity%s_ec) + 200
    do i = 1, 200
      x = 0.5_dp*(a + b)
      s_l = exp(x)
      if (sum(joint_load(joint, s_l)) > pressure*real_area(joint, s_l)) then
        b = x
      else
        a = x
      end if
      if (b - a < 1e-15_dp*abs(x)) exit
    end do
  end function largest_spot_paper

  !> Stiffness of facets [N/m] under their nominal pressure and shear.
  !>
  !> Default closure: F_r(s_l) = P A_0, K_i = K(s_l) A_i / A_0, independent of the number of facets. `paper`: P = F_r / S_r
  !> and K_i = K(s_l) for every facet whatever its area, so the sum grows with their number.
  elemental subroutine evaluate_joint(joint, pressure, shear, area, k_n, k_t, s_l)
    type(joint_t), intent(in) :: joint          !< joint
    real(dp), intent(in) :: pressure, shear     !< nominal pressure and shear traction [Pa]
    real(dp), intent(in) :: area                !< area of the facet [m^2]
    real(dp), intent(out) :: k_n, k_t           !< normal and tangential stiffness [N/m]
    real(dp), intent(out) :: s_l                !< largest spot [m^2]
    real(dp) :: tau, share
    k_n = 0
    k_t = 0
    s_l = 0
    if (.not. pressure > 0) return
    if (joint%paper) then
      s_l = largest_spot_paper(joint, pressure)
      share = 1
      tau = shear
    else
      s_l = largest_spot(joint, pressure)
      share = area/joint%reference_area
      tau = shear*joint%reference_area/max(real_area(joint, s_l), tiny(1._dp))
    end if
    if (.not. s_l > joint%s_min) return
    k_n = share*sum(normal_stiffness(joint, s_l))
    if (shear < joint%mu*pressure) k_t = share*sum(tangential_stiffness(joint, s_l, tau))
  end subroutine evaluate_joint

  !> Gauss-Legendre rule on [0, 1].
  pure subroutine gauss_rule(x, w)
    real(dp), intent(out) :: x(:), w(:)  !< points and weights
    real(dp) :: z, p0, p1, slope
    integer :: i, j, n
    n = size(x)
    do i = 1, n
      z = cos(pi*(i - 0.25_dp)/(n + 0.5_dp))
      do j = 1, 10
        call legendre(n, z, p1, p0)
        slope = n*(z*p1 - p0)/(z*z - 1)
        z = z - p1/slope
      end do
      x(i) = (1 - z)/2
      w(i) = 1/((1 - z*z)*slope**2)
    end do
  end subroutine gauss_rule

  !> Legendre polynomials of degree n and n - 1.
  pure subroutine legendre(n, z, p, previous)
    integer, intent(in) :: n
    real(dp), intent(in) :: z
    real(dp), intent(out) :: p, previous
    real(dp) :: next
    integer :: k
    p = 1
    previous = 0
    do k = 1, n
      next = ((2*k - 1)*z*p - (k - 1)*previous)/k
      previous = p
      p = next
    end do
  end subroutine legendre
end module hd_joint
