! SPDX-License-Identifier: GPL-3.0-or-later
!> The integral behind Eq. 41-43: I(h) = int_lo^hi sigma^(e-1) (1 - x)^(1/3) dsigma, x = h sigma^-p, and dI/dh.
!>
!> It is an incomplete beta function, I = h^-a / p [B(x)] with a = -e/p. For x < 1/2 the binomial series without its first
!> term is added to a plain power integral, so nothing cancels as h -> 0 or D -> 2; for x > 1/2 the series runs in 1 - x and
!> vanishes at the slip edge. Both fall as 2^-n, their coefficients are computed once. Intervals too narrow for differences
!> use a Gauss rule, above x = 1/2 in v = (1 - x)^(1/3), where the cusp at the slip edge is smooth.
module hd_slip_integral
  use hd_gauss, only: gauss_rule
  use hd_kinds, only: dp
  use hd_powers, only: power_partial, expm1
  implicit none
  private
  public :: slip_series_t, new_slip_series, slip_integral

  real(dp), parameter :: fast = 0.1_dp, faster = 0.003_dp   !< x whose 17th, 7th power is below rounding: the first term left out
  integer, parameter :: terms = 50, terms_fast = 16, terms_faster = 6, points = 12
  real(dp), parameter :: third = 1/3._dp, narrow = 0.05_dp

  type :: slip_series_t
    real(dp) :: e = 0, p = 1, a = 0          !< exponents
    real(dp) :: low(0:terms) = 0             !< of (1 - x)^(1/3), term by term integrated, from x^1 on
    real(dp) :: high(0:terms) = 0            !< of (1 - u)^(a-1) u^(1/3), integrated, without u^(4/3)
    real(dp) :: x(points) = 0, w(points) = 0 !< Gauss rule on [0, 1]
  end type slip_series_t

contains

  !> Coefficients for the exponents e <= 0 and p > 0.
  pure function new_slip_series(e, p) result(s)
    real(dp), intent(in) :: e, p  !< exponents
    type(slip_series_t) :: s
    real(dp) :: c, g
    integer :: n
    s%e = e
    s%p = p
    s%a = -e/p
    c = 1
    g = 1
    do n = 0, terms
      if (n > 0) g = g*(n - s%a)/n
      s%high(n) = g/(n + 4*third)
      c = c*(n - third)/(n + 1)
      s%low(n) = c/(s%a + n + 1)
    end do
    call gauss_rule(s%x, s%w)
  end function new_slip_series

  !> Integral from lo over the length l = ln(hi/lo) [Eq. 41-43], and its derivative.
  pure subroutine slip_integral(s, lo, l, h, f, df)
    type(slip_series_t), intent(in) :: s    !< series
    real(dp), intent(in) :: lo, l           !< lower limit, logarithmic length
    real(dp), intent(in) :: h               !< slip parameter, >= 0
    real(dp), intent(out) :: f, df          !< I, dI/dh
    real(dp) :: x_lo, x_hi, start, length, split
    f = 0
    df = 0
    if (.not. l > 0) return
    x_lo = h*lo**(-s%p)
    if (x_lo <= 0) then
      f = lo**s%e*power_partial(l, s%e)
      df = -third*lo**(s%e - s%p)*power_partial(l, s%e - s%p)
      return
    end if
    start = lo
    length = l
    if (x_lo > 1) then
      length = l - log(x_lo)/s%p
      if (.not. length > 0) return
      start = h**(1/s%p)
      x_lo = 1
    end if
    if (length < narrow) then
      call narrow_integral(s, start, length, x_lo, h, f, df)
      return
    end if
    x_hi = x_lo*exp(-s%p*length)
    if (x_lo <= 0.5_dp) then
      call low_integral(s, start, length, x_lo, x_hi, f, df)
    else if (x_hi >= 0.5_dp) then
      call high_integral(s, start, length, x_lo, x_hi, h, f, df)
    else
      split = log(2*x_lo)/s%p
      call high_integral(s, start, split, x_lo, 0.5_dp, h, f, df)
      call low_integral(s, start*exp(split), length - split, 0.5_dp, x_hi, f, df)
    end if
  end subroutine slip_integral

  !> Adds the part with x <= 1/2.
  pure subroutine low_integral(s, lo, l, x_lo, x_hi, f, df)
    type(slip_series_t), intent(in) :: s
    real(dp), intent(in) :: lo, l, x_lo, x_hi
    real(dp), intent(inout) :: f, df
    real(dp) :: p_lo, p_hi, q_lo, q_hi, unit, ratio
    call low_series(s, x_lo, p_lo, q_lo)
    call low_series(s, x_hi, p_hi, q_hi)
    unit = lo**s%e
    ratio = exp(s%e*l)
    f = f + unit*(power_partial(l, s%e) + (x_lo*p_lo - ratio*x_hi*p_hi)/s%p)
    df = df + unit*lo**(-s%p)*(q_lo - ratio*exp(-s%p*l)*q_hi)/s%p
  end subroutine low_integral

  !> sum low(n) x^n and its companion sum (n+1) low(n) x^n.
  pure subroutine low_series(s, x, f, g)
    type(slip_series_t), intent(in) :: s
    real(dp), intent(in) :: x
    real(dp), intent(out) :: f, g
    real(dp) :: slope
    integer :: n
    f = 0
    slope = 0
    do n = length_of(x), 0, -1
      slope = slope*x + f
      f = f*x + s%low(n)
    end do
    g = f + x*slope
  end subroutine low_series

  !> Terms that count at x <= 1/2.
  pure integer function length_of(x) result(n)
    real(dp), intent(in) :: x
    n = terms
    if (x < fast) n = terms_fast
    if (x < faster) n = terms_faster
  end function length_of

  !> Adds the part with x >= 1/2; h dI/dh = -a I + [sigma^e v] / p.
  pure subroutine high_integral(s, lo, l, x_lo, x_hi, h, f, df)
    type(slip_series_t), intent(in) :: s
    real(dp), intent(in) :: lo, l, x_lo, x_hi, h
    real(dp), intent(inout) :: f, df
    real(dp) :: part, v_lo, v_hi, unit
    unit = lo**s%e
    v_lo = (1 - x_lo)**third
    v_hi = (1 - x_hi)**third
    part = unit*x_lo**(-s%a)*(high_series(s, v_hi) - high_series(s, v_lo))/s%p
    f = f + part
    df = df + (-s%a*part + unit*(v_lo - exp(s%e*l)*v_hi)/s%p)/h
  end subroutine high_integral

  !> int_(1-u)^1 t^(a-1) (1-t)^(1/3) dt with u = v^3.
  pure real(dp) function high_series(s, v) result(f)
    type(slip_series_t), intent(in) :: s
    real(dp), intent(in) :: v
    real(dp) :: u
    integer :: n
    u = v**3
    f = 0
    do n = length_of(u), 0, -1
      f = f*u + s%high(n)
    end do
    f = f*v**4
  end function high_series

  !> Gauss rule over a narrow interval: in ln sigma where x < 1/2, in v above.
  pure subroutine narrow_integral(s, lo, l, x_lo, h, f, df)
    type(slip_series_t), intent(in) :: s
    real(dp), intent(in) :: lo, l, x_lo, h
    real(dp), intent(out) :: f, df
    real(dp) :: v_lo, v_hi, dv, v, x, g
    integer :: n
    f = 0
    df = 0
    if (x_lo < 0.5_dp) then
      do n = 1, points
        x = x_lo*exp(-s%p*l*s%x(n))
        v = (1 - x)**third
        g = l*s%w(n)*lo**s%e*exp(s%e*l*s%x(n))
        f = f + g*v
        df = df - third*g*x/(h*v**2)
      end do
      return
    end if
    v_lo = (1 - x_lo)**third
    v_hi = (1 - x_lo*exp(-s%p*l))**third
    dv = -x_lo*expm1(-s%p*l)/(v_hi**2 + v_hi*v_lo + v_lo**2)
    do n = 1, points
      v = v_lo + dv*s%x(n)
      x = 1 - v**3
      g = dv*s%w(n)*lo**s%e*(x_lo/x)**(s%e/s%p)*3*v**2/(s%p*x)
      f = f + g*v
      df = df - third*g*x/(h*v**2)
    end do
  end subroutine narrow_integral
end module hd_slip_integral
