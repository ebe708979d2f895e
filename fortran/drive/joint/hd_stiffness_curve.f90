! SPDX-License-Identifier: GPL-3.0-or-later
!> Stiffness over pressure as a table, and its closure: ln k is a monotone cubic function of ln P (Fritsch and Butland 1984).
!>
!> Below the table k goes on as a power of P, with an exponent between 0 and 1; above it k stays. The closure int dP/k counts from
!> the first entry.
module hd_stiffness_curve
  use hd_gauss, only: gauss_4, weight_4
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_text, only: to_text
  implicit none
  private
  public :: compliance_curve_t, new_curve, stiffness_of, closure_of, pressure_of

  real(dp), parameter :: flat = 1e-6_dp   !< 1 - power below which P^e - 1 loses more to rounding than its logarithm to the power
  real(dp), parameter :: settled = 1e-14_dp   !< step of ln P that is rounding
  real(dp), parameter :: closed = 1e-15_dp    !< width of a bracket of ln P that holds hardly a further number
  real(dp), parameter :: x(4) = 0.5_dp + 0.5_dp*gauss_4, w(4) = 0.5_dp*weight_4   !< Gauss rule on [0, 1]
  integer, parameter :: panels = 4   !< of the closure between two entries

  type :: compliance_curve_t
    real(dp), allocatable :: log_p(:)     !< rising
    real(dp), allocatable :: log_k(:)     !< ln of the stiffness per area [Pa/m]
    real(dp), allocatable :: slope(:)     !< d ln k / d ln P
    real(dp), allocatable :: closure(:)   !< from the first entry [m]
    real(dp) :: power = 1                 !< exponent below the table
  end type compliance_curve_t

contains

  !> Curve from samples.
  subroutine new_curve(pressure, stiffness, curve, error)
    real(dp), intent(in) :: pressure(:)               !< rising, > 0 [Pa]
    real(dp), intent(in) :: stiffness(:)              !< > 0 [Pa/m]
    type(compliance_curve_t), intent(out) :: curve    !< curve
    type(error_t), allocatable, intent(out) :: error  !< too few, not rising, not positive
    real(dp), allocatable :: h(:), s(:)
    integer :: i, n
    n = size(pressure)
    if (n < 2) then
      call raise(error, code_input, 'the joint has '//to_text(n)//' pressures; valid: 2 or more')
      return
    end if
    do i = 1, n
      if (.not. pressure(i) > pressure(max(i - 1, 1)) .and. i > 1) call raise(error, code_input, 'pressure '// &
        to_text(pressure(i))//' Pa of the joint follows '//to_text(pressure(max(i - 1, 1)))//' Pa; valid: rising pressures')
      if (.not. (pressure(i) > 0 .and. pressure(i) < huge(1._dp))) call raise(error, code_input, &
        'pressure '//to_text(pressure(i))//' Pa of the joint; valid: above 0')
      if (.not. (stiffness(i) > 0 .and. stiffness(i) < huge(1._dp))) call raise(error, code_input, &
        'stiffness '//to_text(stiffness(i))//' Pa/m of the joint at '//to_text(pressure(i))//' Pa; valid: above 0')
      if (allocated(error)) return
    end do
    curve%log_p = log(pressure)
    curve%log_k = log(stiffness)
    h = curve%log_p(2:) - curve%log_p(:n - 1)
    s = (curve%log_k(2:) - curve%log_k(:n - 1))/h
    allocate (curve%slope(n), curve%closure(n))
    curve%slope(1) = s(1)
    curve%slope(n) = s(n - 1)
    do i = 2, n - 1
      curve%slope(i) = 0
      if (s(i - 1)*s(i) > 0) curve%slope(i) = 3*(h(i - 1) + h(i))/((2*h(i) + h(i - 1))/s(i - 1) + (h(i) + 2*h(i - 1))/s(i))
    end do
    curve%power = min(max(s(1), 0._dp), 1._dp)
    curve%closure(1) = 0
    do i = 2, n
      curve%closure(i) = curve%closure(i - 1) + between(curve, i - 1, curve%log_p(i))
    end do
  end subroutine new_curve

  !> Interval of ln P, 1 to size - 1.
  pure integer function interval(curve, l) result(i)
    type(compliance_curve_t), intent(in) :: curve  !< curve
    real(dp), intent(in) :: l                      !< ln P
    i = min(max(count(curve%log_p <= l), 1), size(curve%log_p) - 1)
  end function interval

  !> ln k and its slope inside interval i.
  pure subroutine inside(curve, i, l, y, slope)
    type(compliance_curve_t), intent(in) :: curve  !< curve
    integer, intent(in) :: i                       !< interval
    real(dp), intent(in) :: l                      !< ln P in it
    real(dp), intent(out) :: y, slope              !< ln k, d ln k / d ln P
    real(dp) :: h, s
    h = curve%log_p(i + 1) - curve%log_p(i)
    s = (l - curve%log_p(i))/h
    y = curve%log_k(i) + (curve%log_k(i + 1) - curve%log_k(i))*s*s*(3 - 2*s) + &
      h*s*(1 - s)*(curve%slope(i)*(1 - s) - curve%slope(i + 1)*s)
    slope = (curve%log_k(i + 1) - curve%log_k(i))/h*6*s*(1 - s) + curve%slope(i)*(1 - s)*(1 - 3*s) + &
      curve%slope(i + 1)*s*(3*s - 2)
  end subroutine inside

  !> Stiffness per area and its derivative by the pressure.
  elemental subroutine stiffness_of(curve, pressure, k, by_p)
    type(compliance_curve_t), intent(in) :: curve  !< curve
    real(dp), intent(in) :: pressure               !< P [Pa]; not above 0: no stiffness
    real(dp), intent(out) :: k                     !< [Pa/m]
    real(dp), intent(out) :: by_p                  !< dk/dP [1/m]
    real(dp) :: l, y, slope
    integer :: n
    k = 0
    by_p = 0
    if (.not. pressure > 0) return
    n = size(curve%log_p)
    l = log(pressure)
    if (l < curve%log_p(1)) then
      slope = curve%power
      y = curve%log_k(1) + slope*(l - curve%log_p(1))
    else if (l >= curve%log_p(n)) then
      slope = 0
      y = curve%log_k(n)
    else
      call inside(curve, interval(curve, l), l, y, slope)
    end if
    k = exp(y)
    by_p = slope*k/pressure
  end subroutine stiffness_of

  !> Closure from the start of interval i to ln P = l in it.
  pure real(dp) function between(curve, i, l) result(d)
    type(compliance_curve_t), intent(in) :: curve  !< curve
    integer, intent(in) :: i                       !< interval
    real(dp), intent(in) :: l                      !< ln P
    real(dp) :: part, start, y, slope
    integer :: j, k
    d = 0
    part = (l - curve%log_p(i))/panels
    do j = 0, panels - 1
      start = curve%log_p(i) + j*part
      do k = 1, size(x)
        call inside(curve, i, start + part*x(k), y, slope)
        d = d + w(k)*exp(start + part*x(k) - y)
      end do
    end do
    d = d*part
  end function between

  !> Closure from the first entry to a pressure [m]; at no pressure that at which the faces part, or minus infinity.
  elemental real(dp) function closure_of(curve, pressure) result(d)
    type(compliance_curve_t), intent(in) :: curve  !< curve
    real(dp), intent(in) :: pressure               !< P >= 0 [Pa]
    real(dp) :: l, first, e
    integer :: n
    n = size(curve%log_p)
    first = exp(curve%log_p(1) - curve%log_k(1))
    e = 1 - curve%power
    if (.not. pressure > 0) then
      d = -huge(1._dp)
      if (e > flat) d = -first/e
      return
    end if
    l = log(pressure)
    if (l < curve%log_p(1)) then
      d = first*(l - curve%log_p(1))
      if (e > flat) d = first*(exp(e*(l - curve%log_p(1))) - 1)/e
    else if (l >= curve%log_p(n)) then
      d = curve%closure(n) + (pressure - exp(curve%log_p(n)))*exp(-curve%log_k(n))
    else
      n = interval(curve, l)
      d = curve%closure(n) + between(curve, n, l)
    end if
  end function closure_of

  !> Pressure at a closure: the inverse of closure_of [Pa].
  elemental real(dp) function pressure_of(curve, closure) result(p)
    type(compliance_curve_t), intent(in) :: curve  !< curve
    real(dp), intent(in) :: closure                !< from the first entry [m]
    real(dp) :: low, high, l, y, slope, step, r, first, e
    integer :: i, n
    n = size(curve%log_p)
    first = exp(curve%log_p(1) - curve%log_k(1))
    e = 1 - curve%power
    if (closure <= 0) then
      p = exp(curve%log_p(1) + closure/first)
      if (e > flat) p = exp(curve%log_p(1) + log(max(1 + e*closure/first, tiny(1._dp)))/e)
      return
    else if (closure >= curve%closure(n)) then
      p = exp(curve%log_p(n)) + (closure - curve%closure(n))*exp(curve%log_k(n))
      return
    end if
    i = count(curve%closure <= closure)
    low = curve%log_p(i)
    high = curve%log_p(i + 1)
    l = low + (high - low)*(closure - curve%closure(i))/(curve%closure(i + 1) - curve%closure(i))
    do n = 1, 60
      call inside(curve, i, l, y, slope)
      r = curve%closure(i) + between(curve, i, l) - closure
      if (r > 0) high = l
      if (r <= 0) low = l
      step = -r*exp(y - l)
      if (abs(step) < settled .or. high - low < closed) exit
      l = l + step
      if (.not. (l >= low .and. l <= high)) l = 0.5_dp*(low + high)
    end do
    p = exp(l)
  end function pressure_of
end module hd_stiffness_curve
