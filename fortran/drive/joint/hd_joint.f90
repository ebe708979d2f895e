! SPDX-License-Identifier: GPL-3.0-or-later
!> The joint of two rough surfaces: size distribution of the contact spots and its integrals (Eq. 17-44).
!>
!> n(s) = (D-1)/2 psi^((3-D)/2) s_l^((D-1)/2) s^(-(D+1)/2) on (s_min, s_l]. Every integral over a regime runs between its
!> edges clipped to [s_min, s_l]; unclipped, the printed differences give negative loads. Eq. 30 diverges for s -> 0, so
!> s_min is an input. Areas are handled as sigma = s / s_ec, the largest one as excess = s_l / s_min - 1, which keeps its
!> digits where s_l is close to s_min. Integrals over whole regimes are computed once.
module hd_joint
  use hd_kinds, only: dp, hair
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  use hd_elastic_law, only: elastic_law_t, elastic_stiffness
  use hd_asperity, only: asperity_t, load, load_power, stiff, stiff_power, edge, fully_plastic
  use hd_slip_integral, only: slip_series_t, new_slip_series, slip_integral
  use hd_persson_error, only: theory_surface_t
  use hd_powers, only: expm1, log1p, power_partial
  implicit none
  private
  public :: joint_t, spots_t, response_t, new_joint, spots_at, joint_load, normal_stiffness, &
    tangential_stiffness, find_largest_spot, real_area, spot_shear, evaluate_joint, pressure_power, at_friction

  type :: joint_t
    type(asperity_t) :: asperity
    real(dp) :: d = 0            !< fractal dimension D
    real(dp) :: mu = 0           !< friction coefficient
    real(dp) :: s_min = 0        !< smallest spot [m^2]
    real(dp) :: reference_area = 0  !< A_0 = L^2 [m^2]
    real(dp) :: r_m = 0          !< half base length of the asperities [m]
    logical :: paper = .false.   !< closure of Eq. 28 as printed
    logical :: plastic = .false. !< plastic spots unload elastically; else they have no stiffness, as in the paper
    real(dp) :: stiff_power(4) = stiff_power  !< of sigma in each regime
    real(dp) :: psi = 0          !< domain extension factor (Eq. 17)
    real(dp) :: area_factor = 0  !< c_S = S_r / s_l (Eq. 22)
    real(dp) :: b = 0            !< (D-1)/2
    real(dp) :: unit = 0         !< (D-1)/2 psi^((3-D)/2)
    integer :: first = 1         !< regime of s_min
    real(dp) :: lo(4) = 0        !< where each regime starts, clipped to s_min, in units of s_ec
    real(dp) :: load_unit(4) = 0, stiff_unit(4) = 0    !< integrands at lo, times lo
    real(dp) :: load_whole(4) = 0, stiff_whole(4) = 0  !< integrals over whole regimes
    type(slip_series_t) :: slip(3)
    type(elastic_law_t), allocatable :: elastic  !< takes the place of the statistical model where it is there
    type(theory_surface_t), allocatable :: theory  !< what the law by theory knows of its surface
  end type joint_t

  !> Largest spot and what follows from it; forces in units of f_ec, stiffness in units of f_ec / eps_ec.
  type :: spots_t
    real(dp) :: excess = -1      !< s_l / s_min - 1; negative: no contact
    real(dp) :: sigma = 0        !< s_l / s_ec
    integer :: regime = 0        !< of the largest spot
    real(dp) :: length = 0       !< ln(sigma / lo(regime))
    real(dp) :: load = 0, load_slope = 0    !< F, dF / d ln sigma
    real(dp) :: stiff = 0, stiff_slope = 0  !< K_N, dK_N / d ln sigma
  end type spots_t

  !> Stiffness of a facet and its derivatives.
  type :: response_t
    real(dp) :: k_n = 0, k_t = 0                 !< normal and tangential stiffness [N/m]
    real(dp) :: s_l = 0                          !< largest spot [m^2]
    real(dp) :: dk_n_dp = 0, dk_t_dp = 0         !< by the pressure [N/(m Pa)]
    real(dp) :: dk_t_dtau = 0                    !< by the nominal shear [N/(m Pa)]
    integer :: iterations = 0                    !< of the inversion
  end type response_t

  !> pressure over the hardness up to which Eq. 28 as printed has a root that rounding leaves
  real(dp), parameter :: highest = 0.99_dp
  real(dp), parameter :: settled = 1e-8_dp     !< step of t after which Newton's next would be rounding, for it squares
  real(dp), parameter :: exact = 2e-15_dp      !< residual of a logarithm that is rounding
  real(dp), parameter :: rounding = 1e-16_dp   !< step of ln psi that changes nothing
  real(dp), parameter :: lowest = -745, largest = 700   !< t whose exp is the smallest number, and is not beyond the largest
  real(dp), parameter :: stride = 20           !< step of t where no bracket is known: 36 of them pass through all numbers

contains

  !> Joint from its asperity and its surface; the table of parameters and hdengine.Joint hold the ranges.
  subroutine new_joint(asperity, d, mu, s_min, reference_area, r_m, paper, plastic, joint, error)
    type(asperity_t), intent(in) :: asperity          !< asperity
    real(dp), intent(in) :: d                         !< fractal dimension, 2 < D < 3
    real(dp), intent(in) :: mu                        !< friction coefficient
    real(dp), intent(in) :: s_min                     !< smallest spot, > 0 [m^2]
    real(dp), intent(in) :: reference_area            !< A_0 [m^2]
    real(dp), intent(in) :: r_m                       !< half base length [m]
    logical, intent(in) :: paper                      !< closure of Eq. 28
    logical, intent(in) :: plastic                    !< plastic spots unload elastically
    type(joint_t), intent(out) :: joint               !< joint
    type(error_t), allocatable, intent(out) :: error  !< no area at first yield
    if (.not. (asperity%s_ec > 0 .and. asperity%s_ec < huge(1._dp))) then
      call raise(error, code_input, 'the area at first yield is '//to_text(asperity%s_ec)// &
        ' m^2: check roughness, asperity_radius, gamma and hardness')
      return
    end if
    joint%asperity = asperity
    joint%d = d
    joint%mu = mu
    joint%s_min = s_min
    joint%reference_area = reference_area
    joint%r_m = r_m
    joint%paper = paper
    joint%plastic = plastic
    if (plastic) joint%stiff_power(4) = stiff_power(1)
    joint%psi = spot_ratio(d)
    joint%area_factor = (d - 1)/(3 - d)*joint%psi**((3 - d)/2)
    joint%b = (d - 1)/2
    joint%unit = joint%b*joint%psi**((3 - d)/2)
    call prepare_regimes(joint)
  end subroutine new_joint

  !> The same joint with another cap on its shear: that of a load step.
  pure type(joint_t) function at_friction(joint, friction) result(capped)
    type(joint_t), intent(in) :: joint    !< joint
    real(dp), intent(in) :: friction      !< Coulomb coefficient
    capped = joint
    capped%mu = friction
  end function at_friction

  !> Limits and whole integrals of the regimes; the plastic load factor is H s_ec / f_ec.
  pure subroutine prepare_regimes(joint)
    type(joint_t), intent(inout) :: joint  !< joint
    real(dp) :: sigma, factor(4), length
    integer :: i
    sigma = joint%s_min/joint%asperity%s_ec
    joint%first = 1 + count(sigma > edge)
    joint%lo = max([0._dp, edge], sigma)
    factor = [load, joint%asperity%hardness*joint%asperity%s_ec/joint%asperity%f_ec]
    joint%load_unit = factor*joint%lo**(load_power - joint%b)
    factor(:3) = stiff(:3)
    factor(4) = merge(stiff(1), 0._dp, joint%plastic)  ! k = 2 E a of a spot of radius a, whatever its load
    joint%stiff_unit = factor*joint%lo**(joint%stiff_power - joint%b)
    do i = joint%first, 3
      length = log(edge(i)/joint%lo(i))
      joint%load_whole(i) = joint%load_unit(i)*power_partial(length, load_power(i) - joint%b)
      joint%stiff_whole(i) = joint%stiff_unit(i)*power_partial(length, joint%stiff_power(i) - joint%b)
    end do
    do i = 1, 3
      joint%slip(i) = new_slip_series(1 - joint%d/2, load_power(i) - 1)
    end do
  end subroutine prepare_regimes

  !> psi of the size distribution [Eq. 17] from its transcendental equation (Wang and Komvopoulos 1994), regular at D = 3.
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
      r = (expm1(h/2*x) - expm1(-(h/ds)*log1p(exp(-ds/2*x))))*ds/h - 1
      if (r > 0) b = x
      if (r <= 0) a = x
      slope = ds/2*exp(h/2*x) - exp(-(h/ds)*log1p(exp(-ds/2*x)))*ds/2/(1 + exp(ds/2*x))
      step = -r/slope
      if (x + step <= a .or. x + step >= b) step = 0.5_dp*(a + b) - x
      x = x + step
      if (abs(step) < rounding) exit
    end do
    psi = exp(x)
  end function spot_ratio

  !> Real contact area c_S s_l, the sum over the regimes [Eq. 18-22], in m^2.
  elemental real(dp) function real_area(joint, s_l)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), intent(in) :: s_l         !< largest spot [m^2]
    real_area = joint%area_factor*s_l
  end function real_area

  !> Load and normal stiffness with their slopes for a largest spot s_min (1 + excess).
  elemental function spots_at(joint, excess) result(s)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), intent(in) :: excess      !< s_l / s_min - 1
    type(spots_t) :: s
    real(dp) :: share, whole
    integer :: i
    s%excess = excess
    if (.not. excess > 0) return
    s%sigma = joint%s_min/joint%asperity%s_ec*(1 + excess)
    i = max(joint%first, 1 + count(s%sigma > edge))
    s%regime = i
    s%length = log1p(excess)
    if (i > joint%first) s%length = log(s%sigma/joint%lo(i))
    share = joint%unit*s%sigma**joint%b
    whole = sum(joint%load_whole(joint%first:i - 1))
    s%load = share*(whole + joint%load_unit(i)*power_partial(s%length, load_power(i) - joint%b))
    s%load_slope = joint%b*s%load + share*joint%load_unit(i)*exp((load_power(i) - joint%b)*s%length)
    whole = sum(joint%stiff_whole(joint%first:i - 1))
    s%stiff = share*whole
    s%stiff = s%stiff + share*joint%stiff_unit(i)*power_partial(s%length, joint%stiff_power(i) - joint%b)
    s%stiff_slope = joint%b*s%stiff
    s%stiff_slope = s%stiff_slope + share*joint%stiff_unit(i)*exp((joint%stiff_power(i) - joint%b)*s%length)
  end function spots_at

  !> Load carried by the spots of each regime [Eq. 23-27], in N.
  pure function joint_load(joint, s_l) result(f)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), intent(in) :: s_l         !< largest spot [m^2]
    real(dp) :: f(4)
    f = by_regime(joint, s_l, joint%load_unit, joint%load_whole, load_power)*joint%asperity%f_ec
  end function joint_load

  !> Normal stiffness of each regime, limits clipped [Eq. 30, 33-35], in N/m.
  pure function normal_stiffness(joint, s_l) result(k)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), intent(in) :: s_l         !< largest spot [m^2]
    real(dp) :: k(4)
    k = by_regime(joint, s_l, joint%stiff_unit, joint%stiff_whole, joint%stiff_power)*joint%asperity%f_ec/joint%asperity%eps_ec
  end function normal_stiffness

  !> Integrals of one power law, regime by regime.
  pure function by_regime(joint, s_l, unit, whole, power) result(f)
    type(joint_t), intent(in) :: joint                     !< joint
    real(dp), intent(in) :: s_l                            !< largest spot [m^2]
    real(dp), intent(in) :: unit(4), whole(4), power(4)    !< integrand at lo, whole integrals, exponents
    real(dp) :: f(4)
    type(spots_t) :: s
    s = spots_at(joint, (s_l - joint%s_min)/joint%s_min)
    f = 0
    if (s%regime == 0) return
    f(:s%regime - 1) = whole(:s%regime - 1)
    f(s%regime) = unit(s%regime)*power_partial(s%length, power(s%regime) - joint%b)
    f = f*joint%unit*s%sigma**joint%b
  end function by_regime

  !> Tangential stiffness of each regime under the shear stress tau on the spots [Eq. 41-44], in N/m, and its
  !> derivatives.
  !>
  !> A spot carries t = tau s; with x = t / (mu f) = h sigma^-p its stiffness is 8 G' sqrt(s/pi) (1 - x)^(1/3), zero for
  !> x >= 1: the small spots of a regime slip first.
  pure subroutine tangential_stiffness(joint, s, tau, k, by_tau, by_spot)
    type(joint_t), intent(in) :: joint          !< joint
    type(spots_t), intent(in) :: s              !< spots
    real(dp), intent(in) :: tau                 !< shear stress on the spots, Q / S_r [Pa]
    real(dp), intent(out) :: k(4)               !< by regime [N/m]
    real(dp), intent(out) :: by_tau             !< d sum(k) / d tau at fixed s_l [N/(m Pa)]
    real(dp), intent(out) :: by_spot            !< d sum(k) / d ln s_l at fixed tau [N/m]
    real(dp) :: h_of_tau(3), length, df, x, factor
    integer :: i
    k = 0
    by_tau = 0
    by_spot = 0
    if (s%regime == 0 .or. .not. joint%mu > 0) return
    h_of_tau = joint%asperity%s_ec/(joint%mu*joint%asperity%f_ec*load)
    do i = joint%first, min(3, s%regime)
      length = s%length
      if (i < s%regime) length = log(edge(i)/joint%lo(i))
      call slip_integral(joint%slip(i), joint%lo(i), length, tau*h_of_tau(i), k(i), df)
      by_tau = by_tau + df*h_of_tau(i)
    end do
    if (s%regime == fully_plastic .and. joint%plastic) then  ! x is the same for every plastic spot, tau / (mu H)
      x = tau/(joint%mu*joint%asperity%hardness)
      if (x < 1) then
        df = joint%lo(4)**(1 - joint%d/2)*power_partial(s%length, 1 - joint%d/2)
        k(4) = df*(1 - x)**(1/3._dp)
        by_tau = by_tau - df*(1 - x)**(-2/3._dp)/(3*joint%mu*joint%asperity%hardness)
        by_spot = s%sigma**(1 - joint%d/2)*(1 - x)**(1/3._dp)
      end if
    else if (s%regime < fully_plastic) then
      x = tau*h_of_tau(s%regime)*s%sigma**(1 - load_power(s%regime))
      if (x < 1) by_spot = s%sigma**(1 - joint%d/2)*(1 - x)**(1/3._dp)
    end if
    by_spot = by_spot + joint%b*sum(k)
    factor = joint%unit*s%sigma**joint%b*8*joint%asperity%g_prime*sqrt(joint%asperity%s_ec/acos(-1._dp))
    k = k*factor
    by_tau = by_tau*factor
    by_spot = by_spot*factor
  end subroutine tangential_stiffness

  !> Largest spot under a pressure P [Eq. 28].
  !>
  !> Default: F_r(s_l) = P A_0. `paper` (Eq. 28 as printed): F_r(s_l) = P c_S s_l, which has no root unless P < 0.99 H. Newton's
  !> method on logarithms, ln F over t = ln(s_l / s_min - 1), which is nearly straight from the first spot on; inside a
  !> bracket, because the slope under `paper` tends to zero at H.
  pure subroutine find_largest_spot(joint, pressure, s, iterations)
    type(joint_t), intent(in) :: joint       !< joint
    real(dp), intent(in) :: pressure         !< P [Pa]
    type(spots_t), intent(out) :: s          !< spots; none without pressure or root
    integer, intent(out) :: iterations       !< Newton iterations
    real(dp) :: goal, t, low, high, r, slope, step, share, area
    integer :: i
    iterations = 0
    if (.not. (pressure > 0 .and. pressure <= huge(pressure))) return
    area = 0
    goal = pressure*joint%reference_area/joint%asperity%f_ec
    if (joint%paper) then
      if (pressure >= highest*joint%asperity%hardness) return
      area = 1
      goal = pressure*joint%area_factor*joint%s_min/joint%asperity%f_ec
    end if
    t = first_guess(joint, goal, area)
    low = lowest
    high = largest
    do i = 1, 200
      s = spots_at(joint, exp(t))
      share = s%excess/(1 + s%excess)
      r = log(s%load/goal) - area*log1p(s%excess)
      slope = share*(s%load_slope/s%load - area)
      if (r > 0) high = t
      if (r <= 0) low = t
      step = -r/slope
      iterations = i
      if (abs(step) < settled .or. abs(r) < exact) exit
      if (.not. (t + step > low .and. t + step < high)) step = merge(0.5_dp*(low + high) - t, sign(stride, -r), &
        low > lowest .and. high < largest)
      t = t + step
    end do
    if (abs(step) < settled) s = spots_at(joint, exp(t + step))
  end subroutine find_largest_spot

  !> Start of the inversion: a chord of ln F over t through the ends of the regime that holds the root.
  pure real(dp) function first_guess(joint, goal, area) result(t)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), intent(in) :: goal        !< load in units of f_ec
    real(dp), intent(in) :: area        !< 1: goal grows with s_l
    type(spots_t) :: s
    real(dp) :: t0, t1, r0, r1
    integer :: i
    t0 = -30
    s = spots_at(joint, exp(t0))
    r0 = log(s%load/goal) - area*log1p(s%excess)
    t1 = t0
    r1 = r0
    do i = joint%first, 3
      if (edge(i)*joint%asperity%s_ec <= joint%s_min*(1 + hair)) cycle
      t1 = log(edge(i)*joint%asperity%s_ec/joint%s_min - 1)
      s = spots_at(joint, exp(t1))
      r1 = log(s%load/goal) - area*log1p(s%excess)
      if (r1 > 0) exit
      t0 = t1
      r0 = r1
    end do
    t = t0 - r0
    if (r1 > 0 .and. r0 < 0) t = t0 - r0*(t1 - t0)/(r1 - r0)
  end function first_guess

  !> Shear stress on the spots from the nominal shear: Q / S_r; `paper`: the nominal shear itself [Pa].
  elemental real(dp) function spot_shear(joint, s, shear) result(tau)
    type(joint_t), intent(in) :: joint  !< joint
    type(spots_t), intent(in) :: s      !< spots
    real(dp), intent(in) :: shear       !< nominal shear [Pa]
    tau = shear
    if (.not. joint%paper) tau = shear*joint%reference_area/real_area(joint, s%sigma*joint%asperity%s_ec)
  end function spot_shear

  !> Stiffness of facets [N/m] under their nominal pressure and shear, with derivatives.
  !>
  !> Default closure: K_i = K(s_l) A_i / A_0, independent of the number of facets. `paper`: K_i = K(s_l) for every facet whatever
  !> its area, so the sum grows with their number.
  elemental subroutine evaluate_joint(joint, pressure, shear, area, r)
    type(joint_t), intent(in) :: joint          !< joint
    real(dp), intent(in) :: pressure, shear     !< nominal pressure and shear traction [Pa]
    real(dp), intent(in) :: area                !< area of the facet [m^2]
    type(response_t), intent(out) :: r          !< stiffness, largest spot, derivatives
    type(spots_t) :: s
    real(dp) :: tau, share, unit, by_tau, by_spot, k(4), spot_by_p
    if (allocated(joint%elastic)) then
      call elastic_stiffness(joint%elastic, joint%mu, pressure, shear, r%k_n, r%k_t, r%dk_n_dp, r%dk_t_dp, r%dk_t_dtau)
      r = response_t(area*r%k_n, area*r%k_t, 0._dp, area*r%dk_n_dp, area*r%dk_t_dp, area*r%dk_t_dtau)
      return
    end if
    call find_largest_spot(joint, pressure, s, r%iterations)
    if (.not. s%excess > 0) return
    r%s_l = s%sigma*joint%asperity%s_ec
    share = merge(1._dp, area/joint%reference_area, joint%paper)
    unit = share*joint%asperity%f_ec/joint%asperity%eps_ec
    ! d ln s_l / dP, from ln F = ln P + const (+ ln s_l under `paper`)
    spot_by_p = 1/(pressure*(s%load_slope/s%load - merge(1._dp, 0._dp, joint%paper)))
    r%k_n = unit*s%stiff
    r%dk_n_dp = unit*s%stiff_slope*spot_by_p
    if (.not. shear < joint%mu*pressure) return
    tau = spot_shear(joint, s, shear)
    call tangential_stiffness(joint, s, tau, k, by_tau, by_spot)
    r%k_t = share*sum(k)
    r%dk_t_dp = share*by_spot*spot_by_p
    r%dk_t_dtau = share*by_tau
    if (joint%paper) return
    r%dk_t_dp = r%dk_t_dp - share*by_tau*tau*spot_by_p
    r%dk_t_dtau = r%dk_t_dtau*joint%reference_area/real_area(joint, r%s_l)
  end subroutine evaluate_joint

  !> d ln K_T / d ln P at a constant share of the friction; 0 without stiffness.
  elemental real(dp) function pressure_power(r, pressure, shear) result(a)
    type(response_t), intent(in) :: r          !< answer of the joint to these
    real(dp), intent(in) :: pressure, shear    !< nominal [Pa]
    a = 0
    if (r%k_t > 0) a = (pressure*r%dk_t_dp + shear*r%dk_t_dtau)/r%k_t
  end function pressure_power
end module hd_joint
