! SPDX-License-Identifier: GPL-3.0-or-later
!> Contact laws at one multiplier, written as one nonsmooth equation R(w, t) = 0 with its generalised derivative.
!>
!> t = (p, tau_1, tau_2) is the traction on the master (p > 0 pushes apart), w = (gap, slip_1, slip_2) the gap and the slip
!> since the last converged step. With the trial pressure p^ = p - c gap and the trial shear tau^ = tau - c slip,
!>   unilateral:  p - max(0, p^) = 0,    Coulomb:  tau - proj(tau^; |.| <= mu max(0, p^)) = 0
!> (Alart and Curnier 1991). The constant c [Pa/m] only scales the iteration, never the solution.
!>
!> A rough joint takes the same form. Its pressure P(x) over the closure x = -gap gives  p - P(x*) = 0  with x* from
!> P(x*) + c x* = p^ (the resolvent; max(0, p^) is its limit for a stiff joint). Shear follows the slip with the stiffness
!> k_t(p) from the last step's tau_0 until Coulomb's bound:  tau - proj((k_t tau^ + c tau_0) / (k_t + c); mu P(x*)) = 0.
!> Where the table knows how k_t falls as shear grows, the projection shortens by that slip too (hd_micro_slip): a radial return. It
!> slips so as the shear comes nearer to its bound, not as it grows with that (Mindlin and Deresiewicz 1953, doi:10.1115/1.4010702).
!>
!> A point that slipped along e_0 = tau_0/|tau_0| when the step began and slips by s = -|s| d turns meanwhile: d is the direction in
!> the middle of the step, 2 d - e_0 that at its end (error of second order; d itself would be implicit Euler, of first order).
!> So s is replaced by s' = (1 + g) s + g |s| e_0, which is monotone in s, vanishes with it and is s where nothing turns.
!> g = 1 / (1 + (|s|/s_0)^2), s_0 = 10 |tau_0|/c, leaves Euler's rule to slips far beyond the elastic ones (gross slip), where d
!> is the direction of nearly the whole step; it alters the result by second order.
module hd_contact_law
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_tabulated_law, only: closure_table_t, resolve_pressure, stiffness_at_pressure
  use hd_micro_slip, only: return_shear
  implicit none
  private
  public :: contact_law_t, contact_mode, evaluate_law
  public :: open_state, stick_state, slip_state, bonded, frictionless, frictional

  integer, parameter :: open_state = 0   !< no contact
  integer, parameter :: stick_state = 1  !< contact without slip
  integer, parameter :: slip_state = 2   !< contact with slip
  integer, parameter :: bonded = 0       !< neither gap nor slip
  integer, parameter :: frictionless = 1 !< unilateral, no shear
  integer, parameter :: frictional = 2   !< unilateral with Coulomb friction

  real(dp), parameter :: reach = 10      !< s_0, times |tau_0|/c
  real(dp), parameter :: faintest = 1e-150_dp  !< s_0 in parts of a slip, whose square is still a number

  type :: contact_law_t
    integer :: mode = frictional      !< bonded, frictionless or frictional
    real(dp) :: friction = 0          !< Coulomb coefficient: a value of the load step, which hd_newton enters
    real(dp) :: scale = 0             !< c [Pa/m]
    type(closure_table_t), allocatable :: joint   !< compliance of a rough joint; absent: hard
    real(dp) :: softness = 0          !< elastic slip of the hard law from an outer iterate, see hd_newton [m/Pa]
  end type contact_law_t

contains

  !> Mode from its name.
  subroutine contact_mode(name, mode, error)
    character(len=*), intent(in) :: name  !< bonded, frictionless or frictional
    integer, intent(out) :: mode          !< one of the constants
    type(error_t), allocatable, intent(out) :: error
    mode = -1
    select case (name)
    case ('bonded'); mode = bonded
    case ('frictionless'); mode = frictionless
    case ('frictional'); mode = frictional
    case default
      call raise(error, code_input, "contact mode '"//name//"' is unknown; valid: bonded, frictionless, frictional")
    end select
  end subroutine contact_mode

  !> Residual, derivatives and state of one multiplier.
  pure subroutine evaluate_law(law, t, w, anchor, slip_shear, r, dw, dt, state)
    type(contact_law_t), intent(in) :: law  !< law
    real(dp), intent(in) :: t(3)            !< traction [Pa]
    real(dp), intent(in) :: w(3)            !< gap and slip [m]
    real(dp), intent(in) :: anchor(3)       !< traction of the last step (rough joint), or of the outer iterate (softened) [Pa]
    real(dp), intent(in) :: slip_shear(2)         !< shear tau_0 of a point that slipped when the step began, else 0 [Pa]
    real(dp), intent(out) :: r(3)           !< residual [Pa]
    real(dp), intent(out) :: dw(3, 3)       !< dR/dw [Pa/m]
    real(dp), intent(out) :: dt(3, 3)       !< dR/dt
    integer, intent(out) :: state           !< open, stick or slip
    real(dp) :: p, k, pressure_slope, flexibility, flexibility_slope
    integer :: i
    dw = 0
    dt = 0
    do i = 1, 3
      dt(i, i) = 1
    end do
    if (law%mode == bonded) then
      r = law%scale*w
      dw = law%scale*dt
      dt = 0
      state = stick_state
      return
    end if
    r = t
    state = open_state
    flexibility = law%softness
    flexibility_slope = 0
    if (allocated(law%joint)) then
      call resolve_pressure(law%joint, law%scale, t(1) - law%scale*w(1), p, k)
      pressure_slope = k/(k + law%scale)
      r(1) = t(1) - p
      if (.not. p > 0) return
      if (law%mode == frictional) then
        call stiffness_at_pressure(law%joint, p, k, flexibility_slope)
        flexibility = 1/k
        flexibility_slope = -flexibility_slope/k**2
      end if
    else
      p = t(1) - law%scale*w(1)
      if (p < 0) return
      pressure_slope = 1
      r(1) = law%scale*w(1)
    end if
    dw(1, 1) = law%scale*pressure_slope
    dt(1, 1) = 1 - pressure_slope
    state = slip_state
    if (law%mode == frictional) call add_friction(law, t, w, anchor, slip_shear, p, pressure_slope, flexibility, &
      flexibility_slope, r, dw, dt, state)
  end subroutine evaluate_law

  !> Coulomb friction of a closed point, elastic by `flexibility` before it slips; arguments as in evaluate_law.
  pure subroutine add_friction(law, t, w, anchor, slip_shear, p, pressure_slope, flexibility, flexibility_slope, r, dw, dt, state)
    type(contact_law_t), intent(in) :: law
    real(dp), intent(in) :: t(3), w(3), anchor(3), slip_shear(2)
    real(dp), intent(in) :: p                  !< pressure by the law [Pa]
    real(dp), intent(in) :: pressure_slope               !< its derivative by the trial pressure
    real(dp), intent(in) :: flexibility, flexibility_slope   !< tangential flexibility [m/Pa] and its derivative by p [m/Pa^2]
    real(dp), intent(inout) :: r(3), dw(3, 3), dt(3, 3)
    integer, intent(inout) :: state
    real(dp) :: share, trial(2), by_p(2), tangent(2, 2), e(2), size, turned(2), turn(2, 2), shear, by_size, shear_by_p
    real(dp), parameter :: one(2, 2) = reshape([1._dp, 0._dp, 0._dp, 1._dp], [2, 2])
    share = law%scale/(1 + law%scale*flexibility)
    call turn_slip(w(2:) + flexibility*(t(2:) - anchor(2:)), slip_shear, law%scale, turned, turn)
    trial = t(2:) - share*turned
    by_p = share*flexibility_slope*(share*turned - matmul(turn, t(2:) - anchor(2:)))
    size = norm2(trial)
    call limit_shear(law, p, size, anchor, share*flexibility, share**2*flexibility_slope/law%scale, shear, by_size, shear_by_p, &
      state)
    tangent = one
    if (shear >= size) then
      r(2:) = share*turned
    else
      e = trial/size
      r(2:) = t(2:) - shear*e
      tangent = shear/size*one + (by_size - shear/size)*spread(e, 2, 2)*spread(e, 1, 2)
      by_p = matmul(tangent, by_p) + shear_by_p*e
    end if
    dt(2:, 2:) = one - matmul(tangent, one - share*flexibility*turn)
    dw(2:, 2:) = share*matmul(tangent, turn)
    dt(2:, 1) = -by_p*pressure_slope
    dw(2:, 1) = by_p*pressure_slope*law%scale
  end subroutine add_friction

  !> Shear under a trial shear: itself while it comes no nearer to its bound, shortened by micro-slip, or the bound.
  pure subroutine limit_shear(law, p, trial, anchor, rigid, by_rigid, shear, by_trial, by_p, state)
    type(contact_law_t), intent(in) :: law      !< law
    real(dp), intent(in) :: p                   !< pressure [Pa]
    real(dp), intent(in) :: trial               !< trial shear [Pa]
    real(dp), intent(in) :: anchor(3)           !< traction when the step began [Pa]
    real(dp), intent(in) :: rigid, by_rigid     !< c / (k_t + c), 1 for the hard law, and its derivative by p [1/Pa]
    real(dp), intent(out) :: shear              !< shear [Pa]
    real(dp), intent(out) :: by_trial, by_p     !< its derivatives
    integer, intent(out) :: state               !< stick or slip
    real(dp) :: bound, left
    bound = law%friction*p
    shear = min(trial, bound)
    by_trial = merge(1, 0, trial <= bound)
    by_p = merge(0._dp, law%friction, trial <= bound)
    if (allocated(law%joint)) then
      left = max(0._dp, law%friction*anchor(1) - norm2(anchor(2:)))
      if (allocated(law%joint%micro) .and. left > 0 .and. bound - left < trial) call return_shear(law%joint%micro, p, bound, left, &
        trial, rigid, by_rigid, shear, by_trial, by_p)
    end if
    state = merge(slip_state, stick_state, shear >= bound .and. shear < trial)
  end subroutine limit_shear

  !> s' (see above), or s where nothing led, and its derivative.
  pure subroutine turn_slip(slip, slip_shear, scale, turned, turn)
    real(dp), intent(in) :: slip(2), slip_shear(2), scale
    real(dp), intent(out) :: turned(2), turn(2, 2)
    real(dp) :: size, led, share, slope, e(2), d(2)
    integer :: i
    turned = slip
    turn = reshape([1._dp, 0._dp, 0._dp, 1._dp], [2, 2])
    size = norm2(slip)
    led = reach*norm2(slip_shear)
    if (.not. led > faintest*(scale*size)) return   ! nothing led, or so little that its square is lost
    e = slip_shear/norm2(slip_shear)
    d = slip/max(size, tiny(size))
    share = 1/(1 + (scale*size/led)**2)
    slope = 2*share*(share - 1)       ! |s| dg/d|s|
    turned = (1 + share)*slip + share*size*e
    turn = (1 + share)*turn
    do i = 1, 2
      turn(:, i) = turn(:, i) + (slope*d + (share + slope)*e)*d(i)
    end do
  end subroutine turn_slip
end module hd_contact_law
