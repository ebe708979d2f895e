! SPDX-License-Identifier: GPL-3.0-or-later
!> Interface law of an elastic joint, whole from its normal stiffness per area k_N(P), whatever that comes from.
!>
!> Similar materials, full stick: k_T = kappa k_N, kappa = 4 G*/E* = (2 - 2 nu)/(2 - nu) for equal bodies (Mindlin 1949; Campana,
!> Persson and Mueser 2011 for rough ones). Partial slip under constant P is mu times the difference of two normal solutions
!> (Ciavarella 1998, Jaeger 1998), at P and at P - q/mu: k_T(P, q) = k_T(P - q/mu), u(q) = mu (delta_T(P) - delta_T(P - q/mu)) with
!> delta_T = int dP / k_T. Reversals by Masing's rule on u(q). A measured k_T takes the place of kappa k_N.
module hd_elastic_law
  use hd_kinds, only: dp
  use hd_stiffness_curve, only: compliance_curve_t, new_curve, stiffness_of, closure_of, pressure_of
  use hd_error, only: error_t
  implicit none
  private
  public :: elastic_law_t, new_elastic_law, elastic_stiffness, elastic_closure, elastic_pressure, elastic_shear, stick_ratio, &
    scaled_law

  type :: elastic_law_t
    type(compliance_curve_t) :: normal       !< k_N(P)
    type(compliance_curve_t) :: tangential   !< k_T(P) without shear
  end type elastic_law_t

contains

  !> kappa = k_T/k_N of full stick: 4 G*/E* with 1/E* = (1-nu1^2)/E1 + (1-nu2^2)/E2, 1/(4 G*) = (2-nu1)/(4 G1) + (2-nu2)/(4 G2).
  pure real(dp) function stick_ratio(e1, nu1, e2, nu2)
    real(dp), intent(in) :: e1, nu1, e2, nu2  !< Young's moduli [Pa] and Poisson's ratios
    stick_ratio = ((1 - nu1**2)/e1 + (1 - nu2**2)/e2)/((2 - nu1)*(1 + nu1)/(2*e1) + (2 - nu2)*(1 + nu2)/(2*e2))
  end function stick_ratio

  !> Law from samples of both stiffnesses.
  subroutine new_elastic_law(pressure, normal, tangential, law, error)
    real(dp), intent(in) :: pressure(:)               !< rising, > 0 [Pa]
    real(dp), intent(in) :: normal(:)                 !< k_N > 0 [Pa/m]
    real(dp), intent(in) :: tangential(:)             !< k_T of full stick > 0 [Pa/m]
    type(elastic_law_t), intent(out) :: law           !< law
    type(error_t), allocatable, intent(out) :: error  !< not rising, not positive
    call new_curve(pressure, normal, law%normal, error)
    if (.not. allocated(error)) call new_curve(pressure, tangential, law%tangential, error)
  end subroutine new_elastic_law

  !> The same law with both stiffnesses times a factor.
  pure type(elastic_law_t) function scaled_law(law, factor) result(scaled)
    type(elastic_law_t), intent(in) :: law  !< law
    real(dp), intent(in) :: factor          !< > 0
    scaled = law
    scaled%normal%log_k = law%normal%log_k + log(factor)
    scaled%normal%closure = law%normal%closure/factor
    scaled%tangential%log_k = law%tangential%log_k + log(factor)
    scaled%tangential%closure = law%tangential%closure/factor
  end function scaled_law

  !> Stiffness per area under pressure and shear, with derivatives; none where the shear reaches mu P.
  elemental subroutine elastic_stiffness(law, mu, pressure, shear, k_n, k_t, k_n_by_p, k_t_by_p, k_t_by_q)
    type(elastic_law_t), intent(in) :: law           !< law
    real(dp), intent(in) :: mu                       !< friction coefficient
    real(dp), intent(in) :: pressure, shear          !< P, q >= 0 [Pa]
    real(dp), intent(out) :: k_n, k_t                !< [Pa/m]
    real(dp), intent(out) :: k_n_by_p, k_t_by_p, k_t_by_q  !< dk_N/dP, dk_T/dP, dk_T/dq [1/m]
    k_t = 0
    k_t_by_p = 0
    k_t_by_q = 0
    call stiffness_of(law%normal, pressure, k_n, k_n_by_p)
    if (.not. shear < mu*pressure) return
    call stiffness_of(law%tangential, pressure - shear/mu, k_t, k_t_by_p)
    k_t_by_q = -k_t_by_p/mu
  end subroutine elastic_stiffness

  !> Closure at a pressure, counted from zero_pressure [m].
  elemental real(dp) function elastic_closure(law, zero_pressure, pressure) result(d)
    type(elastic_law_t), intent(in) :: law     !< law
    real(dp), intent(in) :: zero_pressure      !< > 0 [Pa]
    real(dp), intent(in) :: pressure           !< P [Pa]
    d = closure_of(law%normal, pressure) - closure_of(law%normal, zero_pressure)
  end function elastic_closure

  !> Pressure at a closure counted from zero_pressure [Pa].
  elemental real(dp) function elastic_pressure(law, zero_pressure, closure) result(p)
    type(elastic_law_t), intent(in) :: law     !< law
    real(dp), intent(in) :: zero_pressure      !< > 0 [Pa]
    real(dp), intent(in) :: closure            !< [m]
    p = pressure_of(law%normal, closure + closure_of(law%normal, zero_pressure))
  end function elastic_pressure

  !> Shear at a tangential displacement under constant pressure, loaded from zero.
  elemental subroutine elastic_shear(law, mu, pressure, displacement, shear, k, slipping)
    type(elastic_law_t), intent(in) :: law   !< law
    real(dp), intent(in) :: mu               !< friction coefficient
    real(dp), intent(in) :: pressure         !< P [Pa]
    real(dp), intent(in) :: displacement     !< u >= 0 [m]
    real(dp), intent(out) :: shear           !< q [Pa], at most mu P
    real(dp), intent(out) :: k               !< dq/du [Pa/m]
    logical, intent(out) :: slipping         !< the friction limit is reached
    real(dp) :: rest, by_p
    k = 0
    shear = 0
    slipping = .false.
    if (.not. (pressure > 0 .and. mu > 0)) return
    rest = closure_of(law%tangential, pressure) - displacement/mu
    slipping = rest <= closure_of(law%tangential, 0._dp)
    shear = mu*pressure
    if (slipping) return
    rest = min(pressure_of(law%tangential, rest), pressure)
    shear = mu*(pressure - rest)
    call stiffness_of(law%tangential, rest, k, by_p)
  end subroutine elastic_shear
end module hd_elastic_law
