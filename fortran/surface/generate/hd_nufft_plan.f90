! SPDX-License-Identifier: GPL-3.0-or-later
!> Fine points, window widths and tiles of the non-uniform FFT, chosen for the lowest predicted time at a tolerance.
module hd_nufft_plan
  use hd_kinds, only: dp
  use hd_fft, only: smooth_size
  use hd_window, only: window_width, window_gain, widest
  implicit none
  private
  public :: nufft_plan_t, plan_nufft

  !> The choice.
  type :: nufft_plan_t
    integer :: fine_x = 0, fine_y = 0      !< fine points
    integer :: width_x = 0, width_y = 0    !< widths of the windows; 0: no window reaches the tolerance
    integer :: rows = 0                    !< rows of a tile
    real(dp) :: tolerance = 0              !< error wanted
    integer :: precision = 1               !< of the sum: 1 double, 2 single
    real(dp) :: seconds = huge(1._dp)      !< predicted time on the machine of docs/evidence/peers.md
  end type nufft_plan_t

  real(dp), parameter :: of_window = 0.6_dp, of_rounding = 0.4_dp  !< shares of the tolerance: error of the window, rounding
  integer, parameter :: most_windows = 4   !< that fine points hold at least: a window does not meet its own image
  integer, parameter :: line = 8           !< points that are written together, in the cache
  integer, parameter :: fewest_rows = 64   !< of a tile: of fewer the window's reach beyond either end is a large part
  real(dp), parameter :: ratios(*) = [1.25_dp, 1.4_dp, 1.6_dp, 1.8_dp, 2._dp, 2.5_dp]
  real(dp), parameter :: rounding(2) = [2e-16_dp, 1.2e-7_dp] !< of the transforms, before the division by those of the windows
  real(dp), parameter :: single_from = 3e-6_dp               !< tolerance from which single precision is tried
  ! Rates in double and in single precision, fitted to 561 sums of 256^2 to 2048^2 points on one thread (AMD EPYC with AVX-512):
  ! half of the predictions lie within 11 % of the time, nine tenths within 25 %.
  real(dp), parameter :: second_per_flop_row(2) = [0.048e-9_dp, 0.050e-9_dp]    !< FFT of a row
  real(dp), parameter :: second_per_row_point(2) = [2.5e-9_dp, 0.55e-9_dp]      !< fine point copied, corrected
  real(dp), parameter :: second_per_flop(2) = [0.056e-9_dp, 0.070e-9_dp]        !< FFT of a column
  real(dp), parameter :: second_per_weight(2) = [0.33e-9_dp, 0.096e-9_dp]       !< one fine point of a wave
  real(dp), parameter :: second_per_wave(2) = [10e-9_dp, 17e-9_dp]              !< phase and weights of a wave in a tile
  real(dp), parameter :: second_per_setup(2) = [16e-9_dp, 8.5e-9_dp]            !< turns and places of a wave
  real(dp), parameter :: second_per_far_point(2) = [2.3e-9_dp, 1.5e-9_dp]       !< fine point beyond the cache
  real(dp), parameter :: second_per_far_row(2) = [5.4e-9_dp, 17e-9_dp]          !< row of fine points of a wave beyond the cache
  real(dp), parameter :: cache_mb = 8, most_far = 4                             !< size of the cache; how far misses grow
  real(dp), parameter :: second_per_plan = 30e-6_dp                             !< this choice

contains

  !> Choose; single precision if it keeps the tolerance.
  pure function plan_nufft(nx, ny, waves, tolerance) result(best)
    integer, intent(in) :: nx, ny              !< points
    integer, intent(in) :: waves               !< number of waves
    real(dp), intent(in) :: tolerance          !< root mean square error, relative to that of the heights
    type(nufft_plan_t) :: best                 !< choice
    if (tolerance >= single_from) best = plan_at(nx, ny, waves, tolerance, 2)
    if (best%width_x == 0) best = plan_at(nx, ny, waves, tolerance, 1)
  end function plan_nufft

  !> Choose at a precision. The error of each direction gets its share of the tolerance.
  pure function plan_at(nx, ny, waves, tolerance, precision) result(best)
    integer, intent(in) :: nx, ny              !< points
    integer, intent(in) :: waves               !< number of waves
    real(dp), intent(in) :: tolerance          !< root mean square error, relative to that of the heights
    integer, intent(in) :: precision           !< 1 double, 2 single
    type(nufft_plan_t) :: best                 !< choice
    type(nufft_plan_t) :: x(size(ratios)), y(size(ratios)), here
    real(dp) :: gain_x(size(ratios)), gain_y(size(ratios))
    integer :: i, j, tiles, rows
    do i = 1, size(ratios)
      x(i) = direction(nx, ratios(i), of_window * tolerance, precision)
      gain_x(i) = window_gain(nx, x(i)%fine_x, x(i)%width_x)
    end do
    tiles = 1
    do
      rows = (ny + tiles - 1) / tiles
      do j = 1, size(ratios)
        y(j) = direction(rows, ratios(j), of_window * tolerance, precision)
        gain_y(j) = window_gain(rows, y(j)%fine_x, y(j)%width_x)
      end do
      do j = 1, size(ratios)
        if (y(j)%width_x == 0) cycle
        if (j > 1) then
          if (y(j)%fine_x == y(j - 1)%fine_x) cycle
        end if
        do i = 1, size(ratios)
          if (x(i)%width_x == 0 .or. rounding(precision) * gain_x(i) * gain_y(j) > of_rounding * tolerance) cycle
          here = nufft_plan_t(x(i)%fine_x, y(j)%fine_x, x(i)%width_x, y(j)%width_x, rows, tolerance, precision)
          here%seconds = predicted(here, ny, tiles, waves)
          if (here%seconds < best%seconds) best = here
        end do
      end do
      if (rows <= fewest_rows) exit
      tiles = 2 * tiles
    end do
  end function plan_at

  !> Fine points and width of one direction.
  pure function direction(n, ratio, tolerance, precision) result(d)
    integer, intent(in) :: n                   !< points
    real(dp), intent(in) :: ratio              !< fine points per point, at least
    real(dp), intent(in) :: tolerance          !< error
    integer, intent(in) :: precision           !< 1 double, 2 single
    type(nufft_plan_t) :: d                    !< fine_x and width_x
    d%fine_x = smooth_size(max(ceiling(n * ratio), most_windows * widest), .true.)
    d%width_x = window_width(n, d%fine_x, tolerance, precision)
  end function direction

  !> Predicted time, the mean of that on one and on two threads: the choice is the same on any number of them [s].
  pure real(dp) function predicted(p, ny, tiles, waves) result(seconds)
    type(nufft_plan_t), intent(in) :: p        !< choice
    integer, intent(in) :: ny, tiles, waves    !< rows, tiles, waves
    real(dp) :: columns, points, row, tile, far
    integer :: k
    k = p%precision
    columns = min(0.5_dp * p%fine_x + p%width_x, real(waves, dp) * (p%width_x + line))
    points = columns * p%fine_y
    far = max(0._dp, min(most_far, (0.5_dp * p%fine_x + 2 * widest) * p%fine_y * (16 / k) / (cache_mb * 1e6_dp) - 1))
    row = p%fine_x * (2.5_dp * log(real(p%fine_x, dp)) / log(2._dp) * second_per_flop_row(k) + second_per_row_point(k))
    tile = points * (5 * log(real(p%fine_y, dp)) / log(2._dp) * second_per_flop(k) + far * second_per_far_point(k)) &
      + waves * (4 * ((p%width_x + 3) / 4) * p%width_y * second_per_weight(k) + second_per_wave(k) + &
      far * p%width_y * second_per_far_row(k))
    seconds = (ny * row + tiles * tile) * (1 + 1._dp / min(tiles, 2)) / 2 + waves * second_per_setup(k) + second_per_plan
  end function predicted
end module hd_nufft_plan
