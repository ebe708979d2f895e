! SPDX-License-Identifier: GPL-3.0-or-later
!> The sum of waves as plain matrix products in single precision (hd_factors): fast, its last bits are those of the BLAS.
module hd_plain_product_single
  use hd_factors, only: factors_t, new_factors
  use hd_kinds, only: dp, sp, rk => sp
  use hd_lapack, only: gemm => sgemm, blas_threads
  use hd_plain_rows, only: factor_row, join_row
  use hd_system, only: stop_requested
  use hd_waves, only: waves_t, grid_t
  implicit none
  private
  public :: plain_t, new_plain, plain_sum

  include 'hd_plain_product.inc'
end module hd_plain_product_single
