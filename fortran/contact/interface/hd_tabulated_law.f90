! SPDX-License-Identifier: GPL-3.0-or-later
!> Compliance of an interface as a table: pressure over closure, smooth and rising, and tangential stiffness over pressure.
!>
!> ln p is a cubic Hermite function of the closure with the slopes given (limited to stay monotone, Fritsch and Carlson 1980).
!> Above the last entry the tangent goes on; below the first the tangent runs down to p = 0, where the faces part.
module hd_tabulated_law
  use hd_kinds, only: dp
  use hd_error, only: error_t, raise, code_input
  use hd_micro_slip, only: micro_slip_t, new_micro_slip
  use hd_sorted, only: count_up_to
  use hd_text, only: to_text
  implicit none
  private
  public :: closure_table_t, new_closure_table, stiffness_at_pressure, resolve_pressure

  type :: closure_table_t
    real(dp), allocatable :: closure(:)   !< rising [m]
    real(dp), allocatable :: pressure(:)  !< rising [Pa]
    real(dp), allocatable :: log_p(:)     !< its logarithm
    real(dp), allocatable :: slope(:)     !< d ln p / d closure [1/m]
    real(dp), allocatable :: log_kt(:)    !< ln of the tangential stiffness without shear [Pa/m]
    type(micro_slip_t), allocatable :: micro   !< its fall under shear; absent: none before sliding
    real(dp) :: start = 0                 !< closure at which the pressure vanishes [m]
  end type closure_table_t

  real(dp), parameter :: rounding = 1e-15_dp   !< of a sum of a few terms, relative
  real(dp), parameter :: closed = 1e-16_dp     !< width of a bracket, relative, that holds no further number

contains

  !> Table from samples of a law.
  subroutine new_closure_table(closure, pressure, normal, tangential, table, error)
    real(dp), intent(in) :: closure(:)                !< rising [m]
    real(dp), intent(in) :: pressure(:)               !< rising, > 0 [Pa]
    real(dp), intent(in) :: normal(:)                 !< dp / dclosure, > 0 [Pa/m]
    real(dp), intent(in) :: tangential(:, :)          !< k_t under shear [Pa/m]: one row > 0, without shear, or hd_micro_slip's
    !< sampled_shares() of the bound; second index as pressure
    type(closure_table_t), intent(out) :: table       !< table
    type(error_t), allocatable, intent(out) :: error  !< not monotone
    real(dp) :: secant
    integer :: i, n
    n = size(closure)
    if (n < 2) then
      call raise(error, code_input, 'the table of the interface law has '//to_text(n)//' rows; valid: 2 or more')
    else if (.not. (all(closure(2:) > closure(:n - 1)) .and. all(pressure(2:) > pressure(:n - 1)) .and. pressure(1) > 0 .and. &
        all(normal > 0) .and. all(tangential(1, :) > 0))) then
      call raise(error, code_input, 'closure and pressure of the interface law must rise, its stiffness must be above 0')
    end if
    if (allocated(error)) return
    table%closure = closure
    table%pressure = pressure
    table%log_p = log(pressure)
    table%log_kt = log(tangential(1, :))
    if (size(tangential, 1) > 1) table%micro = new_micro_slip(table%log_p, tangential)
    table%slope = normal/pressure
    do i = 1, n - 1
      secant = (table%log_p(i + 1) - table%log_p(i))/(closure(i + 1) - closure(i))
      table%slope(i:i + 1) = min(table%slope(i:i + 1), 3*secant)
    end do
    table%start = closure(1) - 1/table%slope(1)
  end subroutine new_closure_table

  !> Pressure in a known interval.
  pure subroutine evaluate(table, i, closure, pressure, normal)
    type(closure_table_t), intent(in) :: table     !< table
    integer, intent(in) :: i                       !< interval
    real(dp), intent(in) :: closure                !< [m]
    real(dp), intent(out) :: pressure, normal      !< [Pa], [Pa/m]
    real(dp) :: h, s, l
    integer :: n
    n = size(table%closure)
    if (i == 0 .or. i == n) then
      l = merge(table%log_p(1), table%log_p(n), i == 0)
      s = merge(table%slope(1), table%slope(n), i == 0)
      h = closure - merge(table%closure(1), table%closure(n), i == 0)
      normal = exp(l)*s
      pressure = exp(l) + normal*h
      if (pressure <= 0) then
        pressure = 0
        normal = 0
      end if
      return
    end if
    h = table%closure(i + 1) - table%closure(i)
    s = (closure - table%closure(i))/h
    l = table%log_p(i) + (table%log_p(i + 1) - table%log_p(i))*s*s*(3 - 2*s) + &
      h*s*(1 - s)*(table%slope(i)*(1 - s) - table%slope(i + 1)*s)
    pressure = exp(l)
    normal = pressure*((table%log_p(i + 1) - table%log_p(i))/h*6*s*(1 - s) + &
      table%slope(i)*(1 - s)*(1 - 3*s) + table%slope(i + 1)*s*(3*s - 2))
  end subroutine evaluate

  !> Tangential stiffness and its derivative by the pressure; proportional to p below the table, constant above.
  pure subroutine stiffness_at_pressure(table, pressure, tangential, slope)
    type(closure_table_t), intent(in) :: table  !< table
    real(dp), intent(in) :: pressure            !< > 0 [Pa]
    real(dp), intent(out) :: tangential         !< [Pa/m]
    real(dp), intent(out) :: slope              !< d tangential / dp [1/m]
    real(dp) :: l, power
    integer :: i, n
    n = size(table%log_p)
    l = log(pressure)
    i = count_up_to(table%log_p, l)
    power = merge(1, 0, i == 0)
    if (i == 0 .or. i == n) then
      i = max(i, 1)
    else
      power = (table%log_kt(i + 1) - table%log_kt(i))/(table%log_p(i + 1) - table%log_p(i))
    end if
    tangential = exp(table%log_kt(i) + power*(l - table%log_p(i)))
    slope = power*tangential/pressure
  end subroutine stiffness_at_pressure

  !> Solve p(x) + c x = trial for the closure x: the projection of the trial pressure onto the law.
  pure subroutine resolve_pressure(table, c, trial, pressure, normal)
    type(closure_table_t), intent(in) :: table  !< table
    real(dp), intent(in) :: c                   !< > 0 [Pa/m]
    real(dp), intent(in) :: trial               !< [Pa]
    real(dp), intent(out) :: pressure           !< p at the solution [Pa]
    real(dp), intent(out) :: normal             !< dp / dx there [Pa/m]
    real(dp) :: x, low, high, r
    integer :: i, n, k
    n = size(table%closure)
    pressure = 0
    normal = 0
    if (trial <= c*table%start) return
    i = count_up_to(table%pressure + c*table%closure, trial)
    low = merge(table%start, table%closure(max(i, 1)), i == 0)
    if (i == n) then
      x = low + (trial - table%pressure(n) - c*low)/(table%pressure(n)*table%slope(n) + c)
      call evaluate(table, n, x, pressure, normal)
      return
    end if
    high = table%closure(i + 1)
    x = 0.5_dp*(low + high)
    do k = 1, 80
      call evaluate(table, i, x, pressure, normal)
      r = pressure + c*x - trial
      if (r > 0) high = x
      if (r <= 0) low = x
      if (abs(r) <= rounding*(pressure + abs(c*x) + abs(trial)) .or. high - low <= closed*abs(high)) exit
      x = x - r/(normal + c)
      if (x <= low .or. x >= high) x = 0.5_dp*(low + high)
    end do
  end subroutine resolve_pressure
end module hd_tabulated_law
