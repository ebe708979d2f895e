! SPDX-License-Identifier: GPL-3.0-or-later
!> Tiles of the non-uniform FFT in double precision.
module hd_nufft_tiles
  use hd_kinds, only: dp, sp, rk => dp
  use hd_error, only: error_t
  use hd_fft, only: fft_plan_t, free_plan, plan_complex, plan_backward_real, execute_complex, execute_backward_real
  use hd_nufft_waves, only: nufft_t, panel
  use hd_spread, only: wave_phases, window_rows, spread_rows
  use hd_window, only: widest
  implicit none
  private
  public :: sum_tiles

  include 'hd_nufft_tiles.inc'
end module hd_nufft_tiles
