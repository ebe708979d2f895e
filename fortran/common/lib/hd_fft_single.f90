! SPDX-License-Identifier: GPL-3.0-or-later
!> The plans of hd_fft in single precision.
module hd_fft_single
  use, intrinsic :: iso_c_binding, only: c_associated, c_null_ptr
  use hd_kinds, only: rk => sp
  use hd_error, only: error_t, raise, code_memory
  use hd_fftw, only: fft_plan_t, rows_plan_t, kept_t, long_rows, rows_of_part, lock_planner, unlock_planner
  use hd_fftw, only: FFTW_BACKWARD, FFTW_ESTIMATE, &
    plan_many => fftwf_plan_many_dft, plan_many_r2c => fftwf_plan_many_dft_r2c, plan_many_c2r => fftwf_plan_many_dft_c2r, &
    run_dft => fftwf_execute_dft, run_r2c => fftwf_execute_dft_r2c, run_c2r => fftwf_execute_dft_c2r, &
    destroy_plan => fftwf_destroy_plan
  use hd_text, only: to_text
  implicit none
  private
  public :: fft_plan_t, plan_complex, plan_backward_real, execute_complex, execute_backward_real, free_plan
  public :: rows_plan_t, plan_rows, execute_rows, free_rows

  type(kept_t), save :: kept(64)
  integer, save :: kept_plans = 0

contains

  include 'hd_fft.inc'
end module hd_fft_single
