! SPDX-License-Identifier: GPL-3.0-or-later
!> Slip of a joint before it slides: the asperities give way one after the other as the shear q nears its bound B = mu p.
!>
!> While q grows at one p, dq/du = k_t(p, q), which falls from k_t(p, 0); while it does not, k_t(p, 0). What it grows along with its
!> bound it grows with k_t(p, 0) (Mindlin and Deresiewicz 1953). So the slip beyond the elastic one is
!>   B / k_t(p, 0) [g(p, q/B) - g(p, y_0)],   g(p, y) = int_0^y (k_t(p, 0) / k_t(p, y' B) - 1) dy',
!> along the shear; where the step began q was (1 - y_0) B below its bound of then. g is a cubic Hermite function of
!> z = 1 - (1 - y)^(1/3) (exact for one sphere, Mindlin's k_t ~ (1 - y)^(1/3): g = 3/2 z^2 - z^3) and linear in ln p, constant
!> outside its pressures.
module hd_micro_slip
  use hd_kinds, only: dp
  implicit none
  private
  public :: micro_slip_t, new_micro_slip, sampled_shares, return_shear

  real(dp), parameter :: rounding = 1e-15_dp   !< of a sum of a few terms of the order 1
  real(dp), parameter :: closed = 1e-16_dp     !< width of a bracket that holds no further number
  integer, parameter :: panels = 12            !< of z
  real(dp), parameter :: softest = 1e-3_dp     !< smallest k_t(p, q) / k_t(p, 0)

  type :: micro_slip_t
    real(dp), allocatable :: log_p(:)     !< rising
    real(dp), allocatable :: g(:, :)      !< at z = 0, 1/panels ... 1; second index as log_p
    real(dp), allocatable :: slope(:, :)  !< dg/dz there
  end type micro_slip_t

contains

  !> Shares q/B at which new_micro_slip wants k_t: ends and middles of the panels, without q = B.
  pure function sampled_shares() result(y)
    real(dp) :: y(2*panels)
    integer :: i
    y = [(1 - (1 - i/(2._dp*panels))**3, i=0, 2*panels - 1)]
  end function sampled_shares

  !> Table from k_t at the sampled shares of the bound.
  pure function new_micro_slip(log_p, tangential) result(table)
    real(dp), intent(in) :: log_p(:)          !< rising
    real(dp), intent(in) :: tangential(:, :)  !< k_t [Pa/m] at sampled_shares() and exp(log_p), the first above 0
    type(micro_slip_t) :: table
    real(dp) :: d(0:2*panels), z, limit
    integer :: i, j
    table%log_p = log_p
    allocate (table%g(0:panels, size(log_p)), table%slope(0:panels, size(log_p)), source=0._dp)
    do j = 1, size(log_p)
      d = 0
      do i = 1, 2*panels - 1
        z = i/(2._dp*panels)
        d(i) = 3*(1 - z)**2*(1/min(1._dp, max(softest, tangential(i + 1, j)/tangential(1, j))) - 1)
      end do
      table%slope(:, j) = d(::2)
      do i = 1, panels
        table%g(i, j) = table%g(i - 1, j) + (d(2*i - 2) + 4*d(2*i - 1) + d(2*i))/(6*panels)
        limit = 3*panels*(table%g(i, j) - table%g(i - 1, j))
        table%slope(i - 1:i, j) = min(table%slope(i - 1:i, j), limit)
      end do
    end do
  end function new_micro_slip

  !> g and its derivatives.
  pure subroutine evaluate(table, log_p, z, g, by_z, by_log_p)
    type(micro_slip_t), intent(in) :: table           !< table
    real(dp), intent(in) :: log_p, z                  !< place, 0 <= z <= 1
    real(dp), intent(out) :: g, by_z, by_log_p        !< value, dg/dz, dg/d ln p
    real(dp) :: part, s, base(4), slope(4), values(2), slopes(2), h
    integer :: i, j, k, n
    n = size(table%log_p)
    j = min(max(count(table%log_p <= log_p), 1), n - 1)
    h = table%log_p(j + 1) - table%log_p(j)
    part = min(max((log_p - table%log_p(j))/h, 0._dp), 1._dp)
    i = min(int(z*panels), panels - 1)
    s = z*panels - i
    base = [(1 + 2*s)*(1 - s)**2, s**2*(3 - 2*s), s*(1 - s)**2/panels, -s**2*(1 - s)/panels]
    slope = [-6*s*(1 - s)*panels, 6*s*(1 - s)*panels, (1 - s)*(1 - 3*s), s*(3*s - 2)]
    do k = 1, 2
      values(k) = dot_product(base, [table%g(i:i + 1, j + k - 1), table%slope(i:i + 1, j + k - 1)])
      slopes(k) = dot_product(slope, [table%g(i:i + 1, j + k - 1), table%slope(i:i + 1, j + k - 1)])
    end do
    g = values(1) + part*(values(2) - values(1))
    by_z = slopes(1) + part*(slopes(2) - slopes(1))
    by_log_p = merge((values(2) - values(1))/h, 0._dp, part > 0 .and. part < 1)
  end subroutine evaluate

  !> Shear q that comes nearer to its bound under the trial shear: q + h B [g(q/B) - g(y_0)] = trial, at most B.
  pure subroutine return_shear(table, p, bound, left, trial, h, by_h, q, by_trial, by_p)
    type(micro_slip_t), intent(in) :: table  !< table
    real(dp), intent(in) :: p                !< pressure, > 0 [Pa]
    real(dp), intent(in) :: bound            !< B = mu p, > 0 [Pa]
    real(dp), intent(in) :: left             !< to the bound when the step began, > 0 and more than from trial to bound [Pa]
    real(dp), intent(in) :: trial            !< trial shear, below what reaches the bound or not [Pa]
    real(dp), intent(in) :: h                !< share of the slip that the trial shear sees, c / (k_t + c)
    real(dp), intent(in) :: by_h             !< dh/dp [1/Pa]
    real(dp), intent(out) :: q               !< shear [Pa]
    real(dp), intent(out) :: by_trial, by_p  !< its derivatives; at the bound 0 and mu
    real(dp) :: z, z0, y0, g, g0, gz, gz0, gp, gp0, low, high, r, slope, by_y0
    integer :: k
    y0 = max(0._dp, 1 - left/bound)
    z0 = 1 - (1 - y0)**(1/3._dp)
    call evaluate(table, log(p), z0, g0, gz0, gp0)
    call evaluate(table, log(p), 1._dp, g, gz, gp)
    q = bound
    by_trial = 0
    by_p = bound/p
    if (trial >= bound*(1 + h*(g - g0))) return
    low = z0
    high = 1
    z = 0.5_dp*(low + high)
    do k = 1, 80
      call evaluate(table, log(p), z, g, gz, gp)
      r = 1 - (1 - z)**3 + h*(g - g0) - trial/bound
      slope = 3*(1 - z)**2 + h*gz
      if (r > 0) high = z
      if (r <= 0) low = z
      if (abs(r) <= rounding .or. high - low <= closed) exit
      z = z - r/slope
      if (.not. (z > low .and. z < high)) z = 0.5_dp*(low + high)
    end do
    q = bound*(1 - (1 - z)**3)
    by_trial = 3*(1 - z)**2/slope
    by_y0 = merge(gz0*(1 - z0)/3, 0._dp, y0 > 0)  ! times p dy_0/dp = 1 - y_0
    by_p = q/p - by_trial*(bound*(by_h*(g - g0) + h*(gp - gp0 - by_y0)/p) + trial/p)
  end subroutine return_shear
end module hd_micro_slip
