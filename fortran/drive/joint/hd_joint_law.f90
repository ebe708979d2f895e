! SPDX-License-Identifier: GPL-3.0-or-later
!> The joint as a law of the interface: closure over pressure, and shear over tangential displacement.
!>
!> Normal: delta(P) = int dP / k_N(P), k_N = K_N / A_0. K_N vanishes with the load, so delta tends to minus infinity like ln P:
!> bodies never part for good, they are pressed exponentially less. delta is therefore counted from the pressure
!> `zero_pressure`. With t = ln(s_l / s_min - 1) the integrand ddelta/dt is smooth between the regime edges, which are ends of
!> panels; below the first panel the exponential tail goes on. Past the last (real area = nominal area) the tangent stays.
!> Tangential: u(q) = int dq / k_T(P, q) at constant P up to the friction limit mu P, then slip. Reversals follow Masing's rule,
!> u - u_r = 2 u((q - q_r) / 2).
module hd_joint_law
  use hd_gauss, only: gauss_rule
  use hd_kinds, only: dp
  use hd_asperity, only: fully_plastic
  use hd_error, only: error_t, raise, code_input
  use hd_joint, only: joint_t, spots_t, spots_at, find_largest_spot, tangential_stiffness, spot_shear
  use hd_text, only: to_text
  implicit none
  private
  public :: interface_law_t, new_interface_law, closure_at, pressure_at, shear_at

  real(dp), parameter :: settled = 1e-8_dp     !< step of t after which Newton's next would be rounding, for it squares
  real(dp), parameter :: close = 1e-12_dp      !< step of the shear over its limit that no reading sees
  integer, parameter :: halvings = 40          !< of the way to the friction limit: the rest, 1e-12 of it, counts as slip
  integer, parameter :: points = 10
  real(dp), parameter :: panel = 0.5_dp, first_t = -9  !< length of a panel in t, start of the first

  type :: interface_law_t
    type(joint_t) :: joint
    real(dp) :: zero_closure = 0               !< closure at zero_pressure from the first panel's start [m]
    real(dp), allocatable :: t(:)              !< ends of the panels
    real(dp), allocatable :: closure(:)        !< there, from the first panel's start [m]
    real(dp), allocatable :: pressure(:)       !< there [Pa]
    real(dp), allocatable :: stiffness(:)      !< k_N there [Pa/m]
    real(dp) :: x(points) = 0, w(points) = 0   !< Gauss rule on [0, 1]
  end type interface_law_t

contains

  !> Law of a joint with the default closure.
  subroutine new_interface_law(joint, zero_pressure, law, error)
    type(joint_t), intent(in) :: joint                !< joint
    real(dp), intent(in) :: zero_pressure             !< pressure at which the closure counts as 0 [Pa]
    type(interface_law_t), intent(out) :: law         !< law
    type(error_t), allocatable, intent(out) :: error  !< no stiffness, closure of Eq. 28, pressure out of range
    real(dp) :: k, zero
    integer :: i
    if (joint%paper) then
      call raise(error, code_input, 'the interface law needs the nominal closure; Eq. 28 (paper) has no pressure per area')
    else if (joint%first == fully_plastic) then
      call raise(error, code_input, 's_min is plastic already: the joint has no stiffness')
    else if (.not. (zero_pressure > 0 .and. zero_pressure < joint%asperity%hardness)) then
      call raise(error, code_input, 'zero_pressure is '//to_text(zero_pressure)//' Pa; valid: > 0 and below the hardness')
    end if
    if (allocated(error)) return
    law%joint = joint
    call gauss_rule(law%x, law%w)
    law%t = panel_ends(joint)
    allocate (law%closure(size(law%t)), law%pressure(size(law%t)), law%stiffness(size(law%t)))
    law%closure(1) = 0
    do i = 1, size(law%t)
      if (i > 1) law%closure(i) = law%closure(i - 1) + panel_closure(law, law%t(i - 1), law%t(i))
      call per_area(law, spots_at(joint, exp(law%t(i))), law%pressure(i), law%stiffness(i))
    end do
    call closure_at(law, zero_pressure, zero, k)
    law%zero_closure = zero
  end subroutine new_interface_law

  !> Ends of the panels in t: even steps, and the regime edges.
  pure function panel_ends(joint) result(t)
    type(joint_t), intent(in) :: joint  !< joint
    real(dp), allocatable :: t(:)
    real(dp) :: last, reached, s_edge
    integer :: i, k, n
    last = log(max(2._dp, joint%reference_area/(joint%area_factor*joint%s_min)))
    t = [first_t]
    reached = first_t
    do i = joint%first, 4
      s_edge = huge(1._dp)
      if (i < fully_plastic) s_edge = edge_excess(joint, i)
      s_edge = min(last, log(max(s_edge, tiny(1._dp))))
      if (s_edge <= reached) cycle
      n = ceiling((s_edge - reached)/panel)
      t = [t, [(reached + (s_edge - reached)*k/n, k=1, n)]]
      reached = s_edge
    end do
  end function panel_ends

  !> Excess of the largest spot at the upper edge of a regime.
  pure real(dp) function edge_excess(joint, i)
    type(joint_t), intent(in) :: joint  !< joint
    integer, intent(in) :: i            !< regime, 1 to 3
    edge_excess = joint%lo(i + 1)*joint%asperity%s_ec/joint%s_min - 1
  end function edge_excess

  !> Pressure [Pa] and normal stiffness per area [Pa/m].
  pure subroutine per_area(law, s, pressure, k)
    type(interface_law_t), intent(in) :: law  !< law
    type(spots_t), intent(in) :: s            !< spots
    real(dp), intent(out) :: pressure, k
    associate (a => law%joint%asperity, area => law%joint%reference_area)
      pressure = s%load*a%f_ec/area
      k = s%stiff*a%f_ec/(a%eps_ec*area)
    end associate
  end subroutine per_area

  !> int ddelta between two places of a panel: ddelta/dt = (dF/dt) / K_N, f_ec / (f_ec / eps_ec) = eps_ec.
  pure real(dp) function panel_closure(law, t0, t1) result(d)
    type(interface_law_t), intent(in) :: law  !< law
    real(dp), intent(in) :: t0, t1            !< places
    type(spots_t) :: s
    integer :: n
    d = 0
    do n = 1, points
      s = spots_at(law%joint, exp(t0 + (t1 - t0)*law%x(n)))
      d = d + law%w(n)*s%load_slope*s%excess/(1 + s%excess)/s%stiff
    end do
    d = d*(t1 - t0)*law%joint%asperity%eps_ec
  end function panel_closure

  !> Closure [m] and stiffness [Pa/m] under a pressure.
  elemental subroutine closure_at(law, pressure, closure, k)
    type(interface_law_t), intent(in) :: law  !< law
    real(dp), intent(in) :: pressure          !< P [Pa]; not above 0: minus infinity
    real(dp), intent(out) :: closure          !< delta [m]
    real(dp), intent(out) :: k                !< k_N = dP/ddelta [Pa/m]
    type(spots_t) :: s
    real(dp) :: p, t
    integer :: n, i, skip
    n = size(law%t)
    k = 0
    closure = -huge(1._dp)
    if (.not. pressure > 0) return
    if (pressure <= law%pressure(1)) then
      k = law%stiffness(1)*pressure/law%pressure(1)
      closure = law%pressure(1)/law%stiffness(1)*log(pressure/law%pressure(1)) - law%zero_closure
    else if (pressure >= law%pressure(n)) then
      k = law%stiffness(n)
      closure = law%closure(n) + (pressure - law%pressure(n))/k - law%zero_closure
    else
      i = count(law%pressure <= pressure)
      call find_largest_spot(law%joint, pressure, s, skip)
      t = min(max(log(s%excess), law%t(i)), law%t(i + 1))
      call per_area(law, s, p, k)
      closure = law%closure(i) + panel_closure(law, law%t(i), t) - law%zero_closure
    end if
  end subroutine closure_at

  !> Pressure [Pa] and stiffness [Pa/m] at a closure: the inverse of closure_at, smooth and above 0 everywhere.
  elemental subroutine pressure_at(law, closure, pressure, k)
    type(interface_law_t), intent(in) :: law  !< law
    real(dp), intent(in) :: closure           !< delta [m]
    real(dp), intent(out) :: pressure         !< P [Pa]
    real(dp), intent(out) :: k                !< k_N = dP/ddelta [Pa/m]
    type(spots_t) :: s
    real(dp) :: d, t, low, high, r, slope, step
    integer :: n, i, j
    n = size(law%t)
    d = closure + law%zero_closure
    if (d <= 0) then
      pressure = law%pressure(1)*exp(d*law%stiffness(1)/law%pressure(1))
      k = law%stiffness(1)*pressure/law%pressure(1)
    else if (d >= law%closure(n)) then
      k = law%stiffness(n)
      pressure = law%pressure(n) + k*(d - law%closure(n))
    else
      i = count(law%closure <= d)
      low = law%t(i)
      high = law%t(i + 1)
      t = low + (high - low)*(d - law%closure(i))/(law%closure(i + 1) - law%closure(i))
      do j = 1, 30
        s = spots_at(law%joint, exp(t))
        r = law%closure(i) + panel_closure(law, law%t(i), t) - d
        slope = s%load_slope*s%excess/(1 + s%excess)/s%stiff*law%joint%asperity%eps_ec
        step = min(max(-r/slope, low - t), high - t)
        t = t + step
        if (abs(step) < settled) exit
      end do
      call per_area(law, spots_at(law%joint, exp(t)), pressure, k)
    end if
  end subroutine pressure_at

  !> Shear stress at a tangential displacement under constant pressure, loaded from zero.
  elemental subroutine shear_at(law, pressure, displacement, shear, k, slipping)
    type(interface_law_t), intent(in) :: law  !< law
    real(dp), intent(in) :: pressure          !< P [Pa]
    real(dp), intent(in) :: displacement      !< u >= 0 [m]
    real(dp), intent(out) :: shear            !< q [Pa]
    real(dp), intent(out) :: k                !< k_T = dq/du [Pa/m]
    logical, intent(out) :: slipping          !< the friction limit is reached
    type(spots_t) :: s
    real(dp) :: limit, u, q, low, high, du, step
    integer :: i, j
    shear = 0
    k = 0
    slipping = .false.
    call find_largest_spot(law%joint, pressure, s, i)
    limit = law%joint%mu*pressure
    if (.not. s%excess > 0 .or. .not. limit > 0) return
    u = 0
    q = 0
    do i = 1, halvings  ! panels that halve the distance to the limit
      low = q
      high = limit*(1 - 0.5_dp**i)
      du = displacement_of(law, s, low, high)
      if (u + du >= displacement) exit
      u = u + du
      q = high
    end do
    slipping = i > halvings
    shear = limit
    if (slipping) return
    do j = 1, 60
      k = stiffness_of(law, s, q)
      step = (displacement - u - displacement_of(law, s, low, q))*k
      q = min(max(q + step, low), high)
      if (abs(step) < close*limit) exit
    end do
    shear = q
    k = stiffness_of(law, s, q)
  end subroutine shear_at

  !> k_T at a nominal shear [Pa/m].
  pure real(dp) function stiffness_of(law, s, q) result(k)
    type(interface_law_t), intent(in) :: law  !< law
    type(spots_t), intent(in) :: s            !< spots
    real(dp), intent(in) :: q                 !< nominal shear [Pa]
    real(dp) :: parts(4), by_tau, by_spot
    call tangential_stiffness(law%joint, s, spot_shear(law%joint, s, q), parts, by_tau, by_spot)
    k = sum(parts)/law%joint%reference_area
  end function stiffness_of

  !> int dq / k_T between two shear stresses [m].
  pure real(dp) function displacement_of(law, s, low, high) result(u)
    type(interface_law_t), intent(in) :: law  !< law
    type(spots_t), intent(in) :: s            !< spots
    real(dp), intent(in) :: low, high         !< nominal shear [Pa]
    integer :: n
    u = 0
    do n = 1, points
      u = u + law%w(n)/max(stiffness_of(law, s, low + (high - low)*law%x(n)), tiny(1._dp))
    end do
    u = u*(high - low)
  end function displacement_of
end module hd_joint_law
