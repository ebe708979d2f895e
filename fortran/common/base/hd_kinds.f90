! SPDX-License-Identifier: GPL-3.0-or-later
!> Number kinds used everywhere.
module hd_kinds
  use, intrinsic :: iso_fortran_env, only: real32, real64, real128, int64
  implicit none
  private
  public :: sp, dp, qp, i8, pi, hair

  integer, parameter :: sp = real32
  integer, parameter :: dp = real64
  !> Quadruple precision, the widest there is where a compiler has none (flang on x86-64: 64 bits of mantissa)
  integer, parameter :: qp = merge(real128, selected_real_kind(18), real128 > 0)
  integer, parameter :: i8 = int64
  real(dp), parameter :: pi = 3.14159265358979323846264338327950288_dp
  !> relative difference of two lengths or angles that are one: far above what rounding leaves, far below what any part is
  !> made to
  real(dp), parameter :: hair = 1e-9_dp
end module hd_kinds
